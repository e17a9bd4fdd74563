//! One map: a quantity on a plane by the chosen evaluator, with its colours.

use web_time::Instant;

use crate::field::quantity::Norm;
use crate::field::{By, Colouring, FieldError, Map, Pressed, Quantity, Request, Stages};
use crate::picture::{ColourMap, Picture};
use crate::rounding::milliseconds;
use crate::simd::Isa;
use crate::studio::evaluator::or_by_cpu;

/// Text for a silent map, in place of zeros.
pub const SILENT: &str = "no sound reaches the plane";

/// A map as drawn.
#[derive(Debug)]
pub struct DrawnMap {
    pub picture: Picture,
    pub map: Map,
    /// For radiation pressure or its effects.
    pub pressed: Option<Pressed>,
    /// Evaluator, method and time, as text.
    pub how: String,
}

/// The colours of a quantity: the chosen ones for amounts, others have their own.
pub fn colours(quantity: Quantity, of_amounts: ColourMap) -> ColourMap {
    of_amounts.suited_to(quantity.declaration().range)
}

/// The range of a map's values, as text; `peak` as in the map.
pub fn extent(quantity: Quantity, peak: f64) -> String {
    let declaration = quantity.declaration();
    if peak == 0.0 {
        return SILENT.to_owned();
    }
    match declaration.norm {
        // It describes the sound behind the phases.
        Norm::Pressure => format!("pressure up to {} peak", Quantity::Rms.at_most(peak)),
        Norm::Value | Norm::Difference | Norm::Energy => {
            format!("{} up to {}", declaration.words, quantity.at_most(peak))
        }
    }
}

/// Evaluates and colours the request. A failing GPU is replaced by the CPU, once and with a warning, unless requested
/// by name.
///
/// # Errors
/// As [`Stages::map`].
pub fn draw(
    request: &Request,
    of_amounts: ColourMap,
    stages: &mut Stages,
    gpu_is_asked_for: bool,
) -> Result<DrawnMap, FieldError> {
    let start = Instant::now();
    let quantity = request.quantity;
    let colouring = Colouring::new(quantity, colours(quantity, of_amounts).table());
    let (map, picture, pressed) = or_by_cpu(stages, gpu_is_asked_for, |stages| {
        let (width, height) = request.size;
        let picture = stages.colours(request, &colouring)?;
        let picture = Picture::from_field_order(width, height, picture.as_flattened());
        let is_slow = quantity.declaration().is_slow;
        let pressed = is_slow.then(|| stages.pressed(request)).transpose()?;
        Ok((stages.map(request)?.clone(), picture, pressed))
    })?;
    let how = how(stages, quantity, &map, start);
    Ok(DrawnMap { picture, map, pressed, how })
}

/// Evaluator and time, as text.
fn how(stages: &Stages, quantity: Quantity, map: &Map, start: Instant) -> String {
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
    let time = milliseconds(start.elapsed().as_secs_f64(), 1);
    let whose = if quantity.declaration().of_light { "the radiation pressure's peak" } else { "the peak" };
    let error = match map.peak {
        0.0 => "silent: every pressure underflows when squared in f32".to_owned(),
        _ => format!(
            "error up to {:.1e} of {whose}, estimated from places that were compared with f64",
            map.error
        ),
    };
    format!("{who} took {time} for the map and its colours\n  {}\n  {error}", map.how)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::gpu::adapter;
    use crate::field::{Evaluator, GpuError};
    use crate::requirement::found;
    use crate::solver;
    use crate::studio::EXAMPLE;

    #[test]
    fn a_lost_gpu_is_replaced_by_the_cpu_unless_it_was_asked_for() {
        let Some(gpu) = found("gpu", adapter::open_best(true)) else { return };
        let scene = crate::scene::file::parse(EXAMPLE, "hit.toml".as_ref()).unwrap();
        let drives = vec![solver::solve(&scene).unwrap().drive];
        let mut request = Request::new(&scene, drives, Quantity::Rms, (300, 200));
        let by_cpu = draw(&request, ColourMap::Grey, &mut Stages::new(Evaluator::Cpu), true).unwrap();
        let mut stages = Stages::new(Evaluator::Gpu(Box::new(gpu)));
        assert_eq!(draw(&request, ColourMap::Grey, &mut stages, true).unwrap().map.by, By::Gpu);
        stages.gpu().unwrap().lose();
        // A new computation is needed: cached results need no GPU.
        request.plane.tolerance = 2e-3;
        let lost = draw(&request, ColourMap::Grey, &mut stages, true).err();
        assert!(matches!(lost, Some(FieldError::Gpu(GpuError::Lost(_)))), "{lost:?}");
        let drawn = draw(&request, ColourMap::Grey, &mut stages, false).unwrap();
        assert!(drawn.how.contains("CPU evaluator"), "{}", drawn.how);
        assert!((drawn.map.peak - by_cpu.map.peak).abs() < 2e-3 * by_cpu.map.peak);
        assert_eq!(drawn.map.values.len(), 300 * 200);
    }
}
