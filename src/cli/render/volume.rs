//! `sonoglyph render --volume`: the field on a lattice of points in a box, as VTI or NPY.

use std::time::Instant;

use anyhow::bail;
use glam::UVec3;

use crate::cli::render::args::{RenderArgs, View, look};
use crate::cli::scene::read_scene;
use crate::field::Stages;
use crate::rounding::milliseconds;
use crate::studio::evaluator;
use crate::studio::output::{Files, say, warn};
use crate::studio::still::{Diagram, Solved};
use crate::studio::volume::{self, Wish};

pub fn run(args: &RenderArgs, counts: UVec3) -> anyhow::Result<()> {
    let [path] = &args.scenes[..] else {
        bail!("--volume takes one scene, and {} are given", args.scenes.len());
    };
    let Diagram::Map(quantity) = args.quantity else {
        bail!("--volume takes a quantity of the field: `drive` and `sheet` are pages");
    };
    if args.view != View::Flat {
        bail!("--volume writes numbers: leave out --view");
    }
    let wish = Wish { quantity, counts, block: args.volume.block, output: &args.output };
    wish.check()?;
    let mut files = Files::new();
    let mut scene = read_scene(path, args.source(), &mut files)?;
    scene.plane.tolerance = args.tolerance.unwrap_or(scene.plane.tolerance);
    files.writes(&args.output)?;
    let solved = Solved::new(scene, path)?;
    let mut stages = Stages::new(evaluator::for_maps(args.backend.backend, args.verbose)?);
    let start = Instant::now();
    let written = volume::write(&solved, &mut stages, &look(args), &wish)?;
    written.missed.iter().for_each(|missed| warn(&format!("{}: {missed}", solved.name)));
    say!("{}", written.line)?;
    if args.verbose {
        say!("  {} for the volume", milliseconds(start.elapsed().as_secs_f64(), 0))?;
    }
    Ok(())
}
