//! One map: the field on a plane by the chosen evaluator, and its colours.

use std::f64::consts::SQRT_2;
use std::time::Instant;

use crate::acoustics::{Air, Aperture};
use crate::drive::Drive;
use crate::field::stages::PROBES;
use crate::field::{Average, By, Colouring, Evaluator, FieldError, Mean, Quantity, Stages, Wanted};
use crate::picture::{ColourMap, Picture};
use crate::scene::Scene;
use crate::simd::Isa;
use crate::studio::output::note;
use crate::surface::{Dent, Reflector};

/// How a map is wanted.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    pub width: usize,
    pub height: usize,
    pub quantity: Quantity,
    /// Colours of magnitudes; phases have their own.
    pub colours: ColourMap,
    /// The numbers too, not only their picture.
    pub numbers: bool,
}

/// What is seen on a map.
#[derive(Clone, Copy, Debug)]
pub struct Sound<'a> {
    pub scene: &'a Scene,
    /// Played one after the other, each for the same time. A field is that of the first, an average that of all.
    pub drives: &'a [Drive],
}

/// A map as drawn.
#[derive(Debug)]
pub struct DrawnMap {
    pub picture: Picture,
    /// The largest value: Pa (RMS), Pa, or m.
    pub largest: f64,
    /// In these units, or rad; row 0 at the smallest y; there if wanted.
    pub numbers: Option<Vec<f32>>,
    /// The largest deviation from the f64 reference at some pixels, relative to the peak.
    pub error: f64,
    /// What an average presses.
    pub pressed: Option<Pressed>,
    /// Who computed it, how, and how long it took, for people.
    pub how: String,
}

/// The effect of radiation pressure.
#[derive(Debug)]
pub struct Pressed {
    /// N on the plane.
    pub force: f64,
    pub dent: Option<Dent>,
}

/// Evaluates and colours what the drives make on the scene's plane. A GPU that fails is replaced by the CPU, once and with a word, if it was not asked for by name.
///
/// # Errors
/// A plane that cannot be sampled, or a GPU that was asked for and fails.
pub fn draw_anyhow(
    sound: Sound<'_>,
    stages: &mut Stages,
    look: &Look,
    gpu_is_asked_for: bool,
) -> Result<DrawnMap, FieldError> {
    match draw(sound, stages, look) {
        Err(FieldError::Gpu(error)) if !gpu_is_asked_for => {
            note(&format!("{error}; the CPU computes the field"));
            *stages = Stages::new(Evaluator::Cpu);
            draw(sound, stages, look)
        }
        drawn => drawn,
    }
}

/// Evaluates and colours what the drives make on the scene's plane.
fn draw(sound: Sound<'_>, stages: &mut Stages, look: &Look) -> Result<DrawnMap, FieldError> {
    match mean(sound.scene, look.quantity) {
        None => field(sound, stages, look),
        Some(mean) => average(sound, stages, look, mean),
    }
}

/// What a quantity is the average of; `None` for a field.
pub fn mean(scene: &Scene, quantity: Quantity) -> Option<Mean> {
    let reflector = || Reflector::new(&Air::new(&scene.medium, scene.array.frequency), scene.array.frequency);
    match quantity {
        Quantity::Rms | Quantity::Phase | Quantity::Instantaneous => None,
        Quantity::MeanRms => Some(Mean::Square),
        Quantity::Radiation => Some(Mean::Radiation(reflector())),
        Quantity::Dent => Some(Mean::Dent(reflector(), scene.liquid.clone())),
    }
}

fn field(sound: Sound<'_>, stages: &mut Stages, look: &Look) -> Result<DrawnMap, FieldError> {
    let start = Instant::now();
    let Sound { scene, drives } = sound;
    let aperture = Aperture::new(scene);
    let wanted = Wanted {
        aperture: &aperture,
        plane: &scene.plane,
        drive: &drives[0],
        width: look.width,
        height: look.height,
    };
    let map = stages.map(&wanted)?.clone();
    let colours = if look.quantity == Quantity::Phase { ColourMap::Cyclic } else { look.colours };
    let colouring = Colouring::new(look.quantity, colours.table());
    let colours = stages.colours(&wanted, &colouring)?;
    let picture = Picture::from_field_order(look.width, look.height, colours.as_flattened());
    // Only numbers that somebody wants leave the GPU.
    let numbers = match look.numbers {
        true => Some(stages.read(&wanted)?.iter().map(|&p| look.quantity.of(p)).collect()),
        false => None,
    };
    let how = how(
        stages,
        map.by,
        start,
        &format!("{}\n  measured error {:.1e} of the peak at {PROBES} pixels", map.how, map.error),
    );
    Ok(DrawnMap {
        picture,
        largest: f64::from(map.peak) / SQRT_2,
        numbers,
        error: map.error,
        pressed: None,
        how,
    })
}

fn average(sound: Sound<'_>, stages: &mut Stages, look: &Look, mean: Mean) -> Result<DrawnMap, FieldError> {
    let start = Instant::now();
    let Sound { scene, drives } = sound;
    let wanted = Average {
        aperture: &Aperture::new(scene),
        plane: &scene.plane,
        drives,
        mean,
        part: scene.modulation.mean_square(),
        width: look.width,
        height: look.height,
    };
    let map = stages.average(&wanted)?.clone();
    let colouring = Colouring::new(look.quantity, look.colours.table());
    let colours = stages.average_colours(&wanted, &colouring)?;
    let picture = Picture::from_field_order(look.width, look.height, colours.as_flattened());
    let numbers = if look.numbers { Some(stages.read_average(&wanted)?) } else { None };
    let how = how(
        stages,
        map.by,
        start,
        &format!("{}\n  measured error {:.1e} of the largest at {PROBES} pixels", map.how, map.error),
    );
    Ok(DrawnMap {
        picture,
        largest: f64::from(map.largest),
        numbers,
        error: map.error,
        pressed: (look.quantity != Quantity::MeanRms).then_some(Pressed { force: map.force, dent: map.dent }),
        how,
    })
}

/// Who took how long for what, for people.
fn how(stages: &Stages, by: By, start: Instant, what: &str) -> String {
    let cpu = || format!("the CPU evaluator ({})", Isa::best().name());
    let who = match by {
        By::Reference => "the f64 reference".to_owned(),
        By::Cpu => cpu(),
        By::CpuInF64 => format!(
            "{}, in f64 since f32 does not keep the tolerance or has no room for such elements,",
            cpu()
        ),
        By::Gpu => stages.gpu().map_or_else(cpu, |gpu| gpu.info().to_string()),
    };
    let milliseconds = start.elapsed().as_secs_f64() * 1e3;
    format!("{who} took {milliseconds:.1} ms for the field and its colours\n  {what}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::gpu::adapter;
    use crate::requirement::found;
    use crate::scene::Plane;
    use crate::solver;

    #[test]
    fn a_lost_gpu_is_replaced_by_the_cpu_unless_it_was_asked_for() {
        let Some(gpu) = found("gpu", adapter::open_best(true)) else { return };
        let mut scene = crate::scene::file::parse(crate::studio::EXAMPLE, "hit.toml".as_ref()).unwrap();
        let drives = [solver::solve(&scene).unwrap().drive];
        let look = Look {
            width: 300,
            height: 200,
            quantity: Quantity::Rms,
            colours: ColourMap::Grey,
            numbers: true,
        };
        let by_cpu =
            draw(Sound { scene: &scene, drives: &drives }, &mut Stages::new(Evaluator::Cpu), &look).unwrap();
        let mut stages = Stages::new(Evaluator::Gpu(Box::new(gpu)));
        draw_anyhow(Sound { scene: &scene, drives: &drives }, &mut stages, &look, true).unwrap();
        stages.gpu().unwrap().lose();
        // Something new must be made: what is kept needs no GPU.
        scene.plane = Plane { tolerance: 2e-3, ..scene.plane };
        let lost = draw_anyhow(Sound { scene: &scene, drives: &drives }, &mut stages, &look, true).err();
        assert!(matches!(lost, Some(FieldError::Gpu(crate::field::GpuError::Lost(_)))), "{lost:?}");
        let drawn = draw_anyhow(Sound { scene: &scene, drives: &drives }, &mut stages, &look, false).unwrap();
        assert!(drawn.how.contains("CPU evaluator"), "{}", drawn.how);
        assert!((drawn.largest - by_cpu.largest).abs() < 2e-3 * by_cpu.largest);
        assert_eq!(drawn.numbers.unwrap().len(), 300 * 200);
    }
}
