//! One map: the field on a plane by the chosen evaluator, and its colours.

use std::f64::consts::SQRT_2;
use std::time::Instant;

use crate::acoustics::Aperture;
use crate::cli::note;
use crate::drive::Drive;
use crate::field::stages::PROBES;
use crate::field::{By, Colouring, Evaluator, FieldError, Quantity, Stages, Wanted};
use crate::picture::{ColourMap, Picture};
use crate::scene::Scene;
use crate::simd::Isa;

/// How a map is wanted.
#[derive(Clone, Copy)]
pub struct Look {
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

/// Like [`draw`]; a GPU that fails is replaced by the CPU, once and with a word, if it was not asked for by name.
pub fn draw_anyhow(
    scene: &Scene,
    drive: &Drive,
    stages: &mut Stages,
    look: &Look,
    gpu_is_asked_for: bool,
) -> Result<DrawnMap, FieldError> {
    match draw(scene, drive, stages, look) {
        Err(FieldError::Gpu(error)) if !gpu_is_asked_for => {
            note(&format!("{error}; the CPU computes the field"));
            *stages = Stages::new(Evaluator::Cpu);
            draw(scene, drive, stages, look)
        }
        drawn => drawn,
    }
}

/// Evaluates and colours the field that a drive makes on the scene's plane.
fn draw(scene: &Scene, drive: &Drive, stages: &mut Stages, look: &Look) -> Result<DrawnMap, FieldError> {
    let start = Instant::now();
    let aperture = Aperture::new(scene);
    let wanted =
        Wanted { aperture: &aperture, plane: &scene.plane, drive, width: look.width, height: look.height };
    let map = stages.map(&wanted)?.clone();
    let colours = if look.quantity == Quantity::Phase { ColourMap::Cyclic } else { look.colours };
    let colouring = Colouring { quantity: look.quantity, table: colours.table(), full: None };
    let colours = stages.colours(&wanted, &colouring)?;
    let picture = Picture::from_field_order(look.width, look.height, colours.as_flattened());
    // Only numbers that somebody wants leave the GPU.
    let numbers = match look.numbers {
        true => Some(stages.read(&wanted)?.iter().map(|&p| look.quantity.of(p)).collect()),
        false => None,
    };
    let cpu = || format!("the CPU evaluator ({})", Isa::best().name());
    let who = match map.by {
        By::Reference => "the f64 reference".to_owned(),
        By::Cpu => cpu(),
        By::CpuInF64 => format!(
            "{}, in f64 since f32 does not keep the tolerance or has no room for such elements,",
            cpu()
        ),
        By::Gpu => stages.gpu().map_or_else(cpu, |gpu| gpu.info().to_string()),
    };
    Ok(DrawnMap {
        picture,
        peak_rms: f64::from(map.peak) / SQRT_2,
        numbers,
        error: map.error,
        how: format!(
            "{who} took {:.1} ms for the field and its colours\n  {}\n  measured error {:.1e} of the peak at {PROBES} \
             pixels",
            start.elapsed().as_secs_f64() * 1e3,
            map.how,
            map.error,
        ),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::gpu::adapter;
    use crate::scene::Plane;
    use crate::solver;

    #[test]
    fn a_lost_gpu_is_replaced_by_the_cpu_unless_it_was_asked_for() {
        let Ok(gpu) = adapter::open_best(true) else {
            let required = std::env::var("SONOGLYPH_REQUIRE").unwrap_or_default();
            assert!(!required.split(',').any(|what| what == "gpu"), "a GPU is required");
            eprintln!("NOT TESTED WITH A GPU");
            return;
        };
        let mut scene = crate::scene::file::parse(crate::cli::EXAMPLE, "hit.toml".as_ref()).unwrap();
        let drive = solver::solve(&scene).unwrap().drive;
        let look = Look {
            width: 300,
            height: 200,
            quantity: Quantity::Rms,
            colours: ColourMap::Grey,
            numbers: true,
        };
        let by_cpu = draw(&scene, &drive, &mut Stages::new(Evaluator::Cpu), &look).unwrap();
        let mut stages = Stages::new(Evaluator::Gpu(Box::new(gpu)));
        draw_anyhow(&scene, &drive, &mut stages, &look, true).unwrap();
        stages.gpu().unwrap().lose();
        // Something new must be made: what is kept needs no GPU.
        scene.plane = Plane { tolerance: 2e-3, ..scene.plane };
        let lost = draw_anyhow(&scene, &drive, &mut stages, &look, true).err();
        assert!(matches!(lost, Some(FieldError::Gpu(crate::field::GpuError::Lost(_)))), "{lost:?}");
        let drawn = draw_anyhow(&scene, &drive, &mut stages, &look, false).unwrap();
        assert!(drawn.how.contains("CPU evaluator"), "{}", drawn.how);
        assert!((drawn.peak_rms - by_cpu.peak_rms).abs() < 2e-3 * by_cpu.peak_rms);
        assert_eq!(drawn.numbers.unwrap().len(), 300 * 200);
    }
}
