//! One map: the field on a plane by the chosen evaluator, and its colours.

use std::f64::consts::SQRT_2;
use std::time::Instant;

use anyhow::Context;
use num_complex::Complex32;

use crate::acoustics::Aperture;
use crate::drive::Drive;
use crate::field::gpu::Colouring;
use crate::field::{Evaluator, Plan, cpu, map};
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

pub struct Map {
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
pub fn draw(scene: &Scene, drive: &Drive, evaluator: &Evaluator, wanted: &Wanted) -> anyhow::Result<Map> {
    let start = Instant::now();
    let (width, height) = (wanted.width, wanted.height);
    let aperture = Aperture::new(scene);
    let plan = Plan::new(&aperture, &scene.plane, (width, height), scene.plane.tolerance)
        .context("the plane's axes span no plane")?;
    let probes = map::probes(&plan);
    let phase = wanted.quantity == Quantity::Phase;
    let table = if phase { ColourMap::Cyclic } else { wanted.colours }.table();
    let numbers = |field: &[Complex32]| field.iter().map(|&p| wanted.quantity.of(p)).collect();

    let on_gpu = match evaluator {
        Evaluator::Gpu(gpu) => map::on_gpu(gpu, &plan, &aperture, drive)?.map(|field| (gpu, field)),
        Evaluator::Cpu | Evaluator::Reference => None,
    };
    let (colours, peak, numbers, probed, who) = if let Some((gpu, field)) = on_gpu {
        let colours = field.colours(&Colouring { table: &table, phase, full: None })?;
        // Only numbers that somebody wants leave the GPU.
        let numbers = if wanted.numbers { Some(numbers(&field.read()?)) } else { None };
        (colours, field.peak()?, numbers, field.at(&probes)?, gpu.info().to_string())
    } else {
        let (field, who) = match evaluator {
            Evaluator::Reference => {
                (map::by_reference(&plan, &aperture, drive), "the f64 reference".to_owned())
            }
            Evaluator::Cpu | Evaluator::Gpu(_) => (
                map::on_cpu(&plan, &aperture, drive),
                format!("the CPU evaluator ({})", cpu::Isa::best().name()),
            ),
        };
        let peak = colour::peak(&field);
        let colours = colour::colours(&field, wanted.quantity, &table, peak);
        let probed = probes.iter().map(|&pixel| field[pixel]).collect();
        (colours, peak, wanted.numbers.then(|| numbers(&field)), probed, who)
    };
    let milliseconds = start.elapsed().as_secs_f64() * 1e3;
    let error = map::measured_error(&plan, &aperture, drive, &probes, &probed, peak);
    let reason =
        if matches!(evaluator, Evaluator::Reference) { "every pixel is evaluated" } else { &plan.reason };
    Ok(Map {
        picture: Picture::from_field_order(width, height, &colours),
        peak_rms: f64::from(peak) / SQRT_2,
        numbers,
        error,
        how: format!(
            "{who} took {milliseconds:.1} ms for the field and its colours\n  {reason}\n  measured error {error:.1e} of \
             the peak at {} pixels",
            probes.len()
        ),
    })
}
