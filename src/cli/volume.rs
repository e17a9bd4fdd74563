//! `sonoglyph render --volume`: the field on a lattice of points in a box, as VTI or NPY.

use std::time::Instant;

use anyhow::bail;
use clap::Args;
use glam::{DVec3, UVec3};

use crate::cli::arguments::numbers;
use crate::cli::{RenderArgs, View, read_scene, render};
use crate::field::Stages;
use crate::field::volume::{Block, MOST_POINTS_ALONG};
use crate::rounding::milliseconds;
use crate::studio::evaluator;
use crate::studio::output::{Files, say, warn};
use crate::studio::space::SIDES;
use crate::studio::still::{Diagram, Solved};
use crate::studio::volume::{self, Wish};

/// m; centres beyond are in a wrong unit.
const FARTHEST: f64 = 100.0;

#[derive(Debug, Args)]
#[command(next_help_heading = "Volumes")]
pub struct VolumeArgs {
    /// Write the quantity at NX x NY x NZ points: FILE.vti (VTK ImageData) or FILE.npy, shape (NZ, NY, NX)
    ///
    /// Values are float32, in the units of --data, at the centres of cells that fill the box.
    #[arg(long, value_name = "NX,NY,NZ", value_parser = parse_counts, conflicts_with_all = ["size", "motion", "waves", "figure", "data"])]
    pub volume: Option<UVec3>,
    /// Box of --volume and --view 3d: size, then centre (m) [default: plane, targets, most of the way to the boards]
    #[arg(long = "box", value_name = "SX,SY,SZ,CX,CY,CZ", allow_hyphen_values = true, value_parser = parse_block)]
    pub block: Option<Block>,
}

fn parse_counts(text: &str) -> Result<UVec3, String> {
    numbers(text)
        .filter(|counts: &[u32; 3]| counts.iter().all(|count| (1..=MOST_POINTS_ALONG).contains(count)))
        .map(UVec3::from_array)
        .ok_or_else(|| format!("give three numbers of points, each from 1 to {MOST_POINTS_ALONG}: NX,NY,NZ"))
}

fn parse_block(text: &str) -> Result<Block, String> {
    let Some([sx, sy, sz, x, y, z]) = numbers(text) else {
        return Err("give six numbers in metres, size and centre: SX,SY,SZ,CX,CY,CZ".to_owned());
    };
    let [least, most] = SIDES;
    let (size, centre) = (DVec3::new(sx, sy, sz), DVec3::new(x, y, z));
    if !size.to_array().iter().all(|side| (least..=most).contains(side)) {
        return Err(format!("give sides from {least} to {most} m"));
    }
    if !centre.to_array().iter().all(|place| place.abs() <= FARTHEST) {
        return Err(format!("give a centre with coordinates from -{FARTHEST} to {FARTHEST} m"));
    }
    Ok(Block { centre, size })
}

pub(in crate::cli) fn run(args: &RenderArgs, counts: UVec3) -> anyhow::Result<()> {
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
    let mut scene = read_scene(path, args.method, &mut files)?;
    scene.plane.tolerance = args.tolerance.unwrap_or(scene.plane.tolerance);
    files.writes(&args.output)?;
    let solved = Solved::new(scene, path)?;
    let mut stages = Stages::new(evaluator::for_maps(args.backend.backend, args.verbose)?);
    let start = Instant::now();
    let written = volume::write(&solved, &mut stages, &render::look(args), &wish)?;
    written.missed.iter().for_each(|missed| warn(&format!("{}: {missed}", solved.name)));
    say!("{}", written.line)?;
    if args.verbose {
        say!("  {} for the volume", milliseconds(start.elapsed().as_secs_f64(), 0))?;
    }
    Ok(())
}
