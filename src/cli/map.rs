//! One map: the field on a plane by the chosen evaluator, and its colours.

use std::f64::consts::SQRT_2;
use std::time::Instant;

use anyhow::Context;
use num_complex::Complex32;

use crate::acoustics::Aperture;
use crate::drive::Drive;
use crate::field::gpu::Colouring;
use crate::field::map::{self, Map};
use crate::field::{Evaluator, Plan, cpu};
use crate::picture::Picture;
use crate::picture::colour::{self, ColourMap, Quantity};
use crate::scene::Scene;

/// How a map is wanted.
#[derive(Clone, Copy)]
pub struct Wanted {
    pub width: usize,
    pub height: usize,
    pub quantity: Quantity,
    /// Colours of magnitudes; phases have their own.
    pub colours: ColourMap,
    /// The numbers too, not only their picture.
    pub numbers: bool,
}

/// A map as drawn.
pub struct DrawnMap {
    pub picture: Picture,
    /// The largest RMS pressure, Pa.
    pub peak_rms: f64,
    /// Pa (RMS) or rad, row 0 at the smallest y; there if wanted.
    pub numbers: Option<Vec<f32>>,
    /// The largest deviation from the f64 reference at some pixels, relative to the peak.
    pub error: f64,
    /// Who computed it, how, and how long it took, for people.
    pub how: String,
}

/// Evaluates and colours the field that a drive makes on the scene's plane.
pub fn draw(
    scene: &Scene,
    drive: &Drive,
    evaluator: &Evaluator,
    wanted: &Wanted,
) -> anyhow::Result<DrawnMap> {
    let start = Instant::now();
    let aperture = Aperture::new(scene);
    let plan = Plan::new(&aperture, &scene.plane, (wanted.width, wanted.height), scene.plane.tolerance)
        .context("the plane's axes span no plane")?;
    let tolerance = scene.plane.tolerance;
    let phase = wanted.quantity == Quantity::Phase;
    let table = if phase { ColourMap::Cyclic } else { wanted.colours }.table();
    let numbers = |field: &[Complex32]| field.iter().map(|&p| wanted.quantity.of(p)).collect();

    let on_gpu = match evaluator {
        Evaluator::Gpu(gpu) => map::by_gpu(gpu, &plan, &aperture, drive, tolerance)?.map(|map| (gpu, map)),
        Evaluator::Cpu | Evaluator::Reference => None,
    };
    if let Some((gpu, map)) = on_gpu {
        let colours = map.field.colours(&Colouring { table: &table, phase, full: Some(map.peak) })?;
        // Only numbers that somebody wants leave the GPU.
        let numbers = if wanted.numbers { Some(numbers(&map.field.read()?)) } else { None };
        return Ok(finish(&map, &gpu.info().to_string(), &colours, numbers, start));
    }
    let (map, who) = match evaluator {
        Evaluator::Reference => (map::by_reference(plan, &aperture, drive), "the f64 reference".to_owned()),
        Evaluator::Cpu | Evaluator::Gpu(_) => (
            map::by_cpu(plan, &aperture, drive, tolerance),
            format!("the CPU evaluator ({})", cpu::Isa::best().name()),
        ),
    };
    let colours = colour::colours(&map.field, wanted.quantity, &table, map.peak);
    let numbers = wanted.numbers.then(|| numbers(&map.field));
    Ok(finish(&map, &who, &colours, numbers, start))
}

fn finish<F>(map: &Map<F>, who: &str, colours: &[u8], numbers: Option<Vec<f32>>, start: Instant) -> DrawnMap {
    let plan = &map.plan;
    DrawnMap {
        picture: Picture::from_field_order(plan.width, plan.height, colours),
        peak_rms: f64::from(map.peak) / SQRT_2,
        numbers,
        error: map.error,
        how: format!(
            "{who} took {:.1} ms for the field and its colours\n  {}{}\n  measured error {:.1e} of the peak at {} pixels",
            start.elapsed().as_secs_f64() * 1e3,
            plan.reason,
            if plan.double {
                "; in f64, since f32 does not keep the tolerance or has no room for such elements"
            } else {
                ""
            },
            map.error,
            map::PROBES
        ),
    }
}
