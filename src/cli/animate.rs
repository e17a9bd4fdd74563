//! `sonoglyph render --motion` and `--waves`: a scene in, an animation out.

use std::time::Instant;

use anyhow::bail;
use indicatif::{ProgressBar, ProgressStyle};

use crate::cli::{RenderArgs, View, read_scene, render};
use crate::field::{Colouring, Quantity, Request, Stages};
use crate::solver::frames;
use crate::studio::animate::{Film, Target};
use crate::studio::evaluator::{self, Backend};
use crate::studio::output::{self, note, say, warn};
use crate::studio::still::{Diagram, stem};
use crate::studio::swell::Schedule;
use crate::studio::{liquid, map, motion};

/// In which progress is counted.
const STEPS: f64 = 10_000.0;

pub fn run(args: &RenderArgs) -> anyhow::Result<()> {
    let target = Target::of(&args.output)?;
    let [path] = &args.scenes[..] else {
        bail!("one scene is animated at a time, and {} are given", args.scenes.len());
    };
    if args.data.is_some() && !args.waves {
        bail!("--data takes the numbers of a still map or of --waves; leave out --motion");
    }
    let quantity = match args.quantity {
        Diagram::Map(quantity) if args.waves && !quantity.declaration().of_liquid => {
            bail!("--waves are of a liquid's surface: --quantity depression")
        }
        Diagram::Map(quantity) => quantity,
        Diagram::Drive | Diagram::Sheet => {
            let names = Quantity::ALL.map(|quantity| quantity.declaration().name);
            bail!("maps are animated: --quantity {}", names.join(", "))
        }
    };
    if args.view == View::Shaded {
        bail!("animations are maps: leave out --view shaded");
    }
    let mut scene = read_scene(path, args.method)?;
    scene.plane.tolerance = args.tolerance.unwrap_or(scene.plane.tolerance);
    let look = render::look(args);
    let size = look.pixels(&scene)?;
    target.check(size)?;
    let schedule = args.waves.then(|| Schedule::new(&scene, args.seconds)).transpose()?;
    let sequence = match args.waves {
        true => frames::follow(&scene)?,
        false => motion::follow(&scene, &path.display().to_string())?,
    };
    if let Some(data) = &args.data {
        output::check_writable(data)?;
    }
    target.make_folder()?;
    let stages = Stages::new(evaluator::for_maps(args.backend.backend)?);
    let drives: Vec<_> = sequence.frames.iter().map(|frame| frame.drive.clone()).collect();
    let request = Request::new(&scene, drives, quantity, size);
    let colouring = Colouring::new(quantity, map::colours(quantity, args.colours).table());
    let mut film = Film::new(&scene, request, stages, colouring);
    film.gpu_is_asked_for = args.backend.backend == Backend::Gpu;
    film.schedule = schedule;
    film.data.clone_from(&args.data);
    let start = Instant::now();
    let bar = progress();
    let tell = |part: f64| {
        bar.set_position((part * STEPS) as u64);
        Ok(())
    };
    if quantity.declaration().of_liquid && !args.waves {
        note(
            "every frame shows the depression that its sound would press in the end; --waves shows how the surface follows",
        );
    }
    let shot = film.shoot(&target, &stem(path), &tell)?;
    bar.finish_and_clear();
    let tolerance = scene.plane.tolerance;
    if tolerance > 0.0 && film.error > tolerance {
        warn(&format!("a map's error is {:.1e} of its peak, more than the {tolerance:e} wanted", film.error));
    }
    if let Some(beyond) = liquid::beyond_linear_theory(film.slope) {
        warn(&beyond);
    }
    say!("{}", shot.line(&args.output, size))?;
    if args.verbose {
        let (solving, drawing) = (sequence.seconds, start.elapsed().as_secs_f64());
        let frames = shot.frames();
        let each = drawing / frames as f64;
        say!(
            "  {:.1} ms for all drives; {:.1} ms for {frames} frames, {:.2} ms for each",
            solving * 1e3,
            drawing * 1e3,
            each * 1e3
        )?;
    }
    Ok(())
}

fn progress() -> ProgressBar {
    let style = ProgressStyle::with_template("{bar:30} {percent} %, {eta} left");
    ProgressBar::new(STEPS as u64).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}
