//! One map: the field on a plane by the chosen evaluator, and its colours.

use std::f64::consts::SQRT_2;
use std::time::Instant;

use anyhow::Context;
use num_complex::Complex32;

use crate::acoustics::Aperture;
use crate::drive::Drive;
use crate::field::gpu::Colouring;
use crate::field::{Evaluator, Samples, Sources, cpu};
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
    /// Who computed it and how long it took, for people.
    pub how: String,
}

/// Evaluates and colours the field that a drive makes on the scene's plane.
pub fn draw(scene: &Scene, drive: &Drive, evaluator: &Evaluator, wanted: &Wanted) -> anyhow::Result<Map> {
    let start = Instant::now();
    let aperture = Aperture::new(scene);
    let samples = Samples::on_plane(&scene.plane, wanted.width, wanted.height)
        .context("the plane's axes span no plane")?;
    let sources = Sources::new(&aperture, drive, &samples);
    let phase = wanted.quantity == Quantity::Phase;
    let table = if phase { ColourMap::Cyclic } else { wanted.colours }.table();
    let numbers = |field: &[Complex32]| field.iter().map(|&p| wanted.quantity.of(p)).collect();

    let (colours, peak, numbers, who) = match (evaluator, sources) {
        (Evaluator::Gpu(gpu), Some(sources)) => {
            let field = gpu.pressure(&sources, &samples)?;
            let colours = field.colours(&Colouring { table: &table, phase, full: None })?;
            // Only numbers that somebody wants leave the GPU.
            let numbers = if wanted.numbers { Some(numbers(&field.read()?)) } else { None };
            (colours, field.peak()?, numbers, gpu.info().to_string())
        }
        (evaluator, sources) => {
            let field = evaluator.pressure(&aperture, drive, &samples)?;
            let peak = colour::peak(&field);
            let colours = colour::colours(&field, wanted.quantity, &table, peak);
            let who = match (evaluator, sources) {
                (Evaluator::Cpu, Some(_)) => format!("the CPU evaluator ({})", cpu::Isa::best().name()),
                (Evaluator::Reference, _) => "the f64 reference".to_owned(),
                (_, None) => {
                    "the f64 reference (f32 has no room for such elements or such absorption)".to_owned()
                }
                (Evaluator::Gpu(_), Some(_)) => unreachable!("taken above"),
            };
            (colours, peak, wanted.numbers.then(|| numbers(&field)), who)
        }
    };
    Ok(Map {
        picture: Picture::from_field_order(wanted.width, wanted.height, &colours),
        peak_rms: f64::from(peak) / SQRT_2,
        numbers,
        how: format!(
            "{who} took {:.1} ms for the field and its colours",
            start.elapsed().as_secs_f64() * 1e3
        ),
    })
}
