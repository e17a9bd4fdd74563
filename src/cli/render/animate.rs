//! `sonoglyph render --motion` and `--waves`: animations of a scene.

use std::time::Instant;

use anyhow::bail;

use crate::cli::render::args::{RenderArgs, View, look};
use crate::cli::{progress, scene::read_scene};
use crate::field::{Colouring, Quantity, Request, Stages, missed};
use crate::rounding::milliseconds;
use crate::solver::frames;
use crate::studio::animate::{self, Film, Target, times_of};
use crate::studio::evaluator::{self, Backend};
use crate::studio::motion::SOLVING;
use crate::studio::opening::stem;
use crate::studio::output::{Files, note, say, warn};
use crate::studio::still::{Diagram, Size};
use crate::studio::swell::Schedule;
use crate::studio::{liquid, map, motion};

/// Default width in pixels of a shaded surface.
const SHADED_WIDTH: usize = 800;

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
            bail!("--waves needs a liquid's surface: --quantity depression or caustic")
        }
        Diagram::Map(quantity) if quantity.declaration().is_level() => {
            bail!("{} is that of the whole cycle: --quantity skin is animated", quantity.declaration().words)
        }
        Diagram::Map(quantity) => quantity,
        Diagram::Drive | Diagram::Sheet => {
            let names = Quantity::ALL.map(|quantity| quantity.declaration().name);
            bail!("maps are animated: --quantity {}", names.join(", "))
        }
    };
    let is_shaded = args.view == View::Shaded;
    if is_shaded && !quantity.declaration().is_surface() {
        bail!("--view shaded draws a liquid's surface: add --quantity depression")
    }
    let mut files = Files::new();
    let mut scene = read_scene(path, args.source(), &mut files)?;
    scene.plane.tolerance = args.tolerance.unwrap_or(scene.plane.tolerance);
    let mut look = look(args);
    if is_shaded && look.size.is_none() {
        look.size = Some(Size { width: SHADED_WIDTH, height: None });
    }
    let size = target.pixels(look.pixels(&scene)?);
    if let Target::File(path, _) = &target {
        files.keeps(path)?;
    }
    if let Some(data) = &args.data {
        files.writes(data)?;
        files.writes(&times_of(data))?;
    }
    target.check(size, args.fps)?;
    let schedule = args.waves.then(|| Schedule::new(&scene, args.seconds)).transpose()?;
    let sequence = match args.waves {
        true => frames::follow_with(&scene, &progress::begin(SOLVING))?,
        false => motion::follow(&scene, &path.display().to_string(), &progress::begin(SOLVING))?,
    };
    let pictures = schedule.map_or(sequence.frames.len(), |schedule| schedule.pictures);
    target.pictures(&stem(path), pictures).try_for_each(|path| files.keeps(&path))?;
    target.make_folder()?;
    let stages = Stages::new(evaluator::for_maps(args.backend.backend, args.verbose)?);
    let seconds = sequence.seconds;
    let drives: Vec<_> = sequence.frames.into_iter().map(|frame| frame.drive).collect();
    let (points, look) = if is_shaded {
        (liquid::points(&scene.plane), animate::Look::Shaded { name: stem(path), page: size })
    } else {
        let colouring = Colouring::new(quantity, map::colours(quantity, args.colours).table());
        (size, animate::Look::Flat(Box::new(colouring)))
    };
    let request = Request::new(&scene, drives, quantity, points);
    let mut film = Film::new(&scene, request, stages, look);
    film.rate = args.fps;
    film.gpu_is_asked_for = args.backend.backend == Backend::Gpu;
    film.schedule = schedule;
    film.data.clone_from(&args.data);
    let start = Instant::now();
    film.begin = progress::begin;
    if quantity.declaration().of_liquid && !args.waves {
        note("every frame shows the surface at equilibrium under its sound; --waves shows the transient");
    }
    let shot = film.shoot(&target, &stem(path), &|_| Ok(()))?;
    if let Some(missed) = missed(film.error, quantity.declaration().tolerance(&scene)) {
        warn(&missed);
    }
    if let Some(beyond) = liquid::beyond_linear_theory(film.slope) {
        warn(&beyond);
    }
    say!("{}", shot.line(&args.output, size))?;
    if args.verbose {
        let (solving, drawing) = (seconds, start.elapsed().as_secs_f64());
        let frames = shot.frames();
        let each = drawing / frames as f64;
        say!(
            "  {} for all drives; {} for {frames} frames, {} each",
            milliseconds(solving, 1),
            milliseconds(drawing, 1),
            milliseconds(each, 2)
        )?;
    }
    Ok(())
}
