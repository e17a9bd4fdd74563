//! One map: a quantity on a plane by the chosen evaluator, with its colours.

use std::f32::consts::{PI, TAU};

use web_time::Instant;

use crate::field::{By, Colouring, FieldError, Map, Norm, Pressed, Quantity, Range, Request, Stages};
use crate::picture::{ColourMap, Picture};
use crate::rounding::milliseconds;
use crate::scene::{Envelope, Scene};
use crate::simd::Isa;
use crate::studio::evaluator::or_by_cpu;

/// Text for a silent map, in place of zeros.
pub const SILENT: &str = "no sound reaches the plane";
/// Text for skin that only steady sound presses.
pub const UNMOVED: &str = "the skin does not move: steady sound is hardly felt; add [modulation] or [motion]";
/// Level (dB) of what no hand feels: that of a map without motion is lower.
const UNFELT: f64 = -99.0;
/// Remark on values that exceed the range.
pub const LARGER: &str = "larger within a wavelength of elements";

/// Remark on the pixels within bodies.
pub const HATCHED: &str = "hatched: bodies";

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

/// Whether a map with this largest value is of skin that only steady sound presses.
pub fn is_unmoved(quantity: Quantity, peak: f64) -> bool {
    let declaration = quantity.declaration();
    declaration.of_skin && peak <= if declaration.is_level() { UNFELT } else { 0.0 }
}

/// The range of a map's values, as text; `peak` as in the map.
pub fn extent(quantity: Quantity, peak: f64) -> String {
    let declaration = quantity.declaration();
    if is_unmoved(quantity, peak) {
        return UNMOVED.to_owned();
    }
    if peak == 0.0 {
        return SILENT.to_owned();
    }
    match declaration.norm {
        // It describes the sound behind the phases.
        Norm::Pressure => format!("pressure up to {} peak", Quantity::Rms.at_most(peak)),
        Norm::Value | Norm::Difference => {
            format!("{} up to {}", declaration.words, quantity.at_most(peak))
        }
    }
}

/// Levels of contour lines of a level over the threshold, dB.
pub const OVER_THRESHOLD: [f64; 3] = [0.0, 10.0, 20.0];

/// The value of a contour line on a map with this largest value: of a level in dB itself, of others so many dB from the largest.
pub fn contour(quantity: Quantity, level: f64, largest: f64) -> f64 {
    let declaration = quantity.declaration();
    if declaration.is_level() { level } else { largest * 10f64.powf(level / declaration.decibels) }
}

/// The remark beside a picture whose colours need one: on a silent map, or on places beyond its range.
pub fn remark(quantity: Quantity, map: &Map) -> Option<String> {
    let declaration = quantity.declaration();
    if map.rounding > 0.0 && map.peak == 0.0 {
        // What is summed: phases and depressions follow from it.
        let summed = match (declaration.norm, declaration.of_liquid) {
            (Norm::Pressure, _) => Quantity::Rms.declaration(),
            (Norm::Value | Norm::Difference, true) => Quantity::Radiation.declaration(),
            (Norm::Value | Norm::Difference, false) => declaration,
        };
        let (words, unit) = (summed.words, summed.unit.symbol());
        return Some(format!("silent: {words} below its rounding, {:.0e} {unit}", map.rounding));
    }
    let larger = map.has_larger().then_some(LARGER);
    let remarks: Vec<_> = larger.into_iter().chain((map.within > 0).then_some(HATCHED)).collect();
    (!remarks.is_empty()).then(|| remarks.join("; "))
}

/// Whether a map of this quantity leaves out the scene's modulation: pressures are those at full amplitude.
pub fn omits_modulation(scene: &Scene, quantity: Quantity) -> bool {
    let is_of_sound = quantity.declaration().is_root || quantity == Quantity::Instantaneous;
    let envelope = scene.envelope();
    is_of_sound && envelope.shape != Envelope::Off && envelope.mean_square() < 1.0
}

/// Values minus values; phases differ by at most half a turn.
pub fn difference(quantity: Quantity, left: &[f32], right: &[f32]) -> Vec<f32> {
    let is_cyclic = quantity.declaration().range == Range::Cyclic;
    let minus = |(a, b): (&f32, &f32)| {
        let difference = a - b;
        if is_cyclic { (difference + PI).rem_euclid(TAU) - PI } else { difference }
    };
    left.iter().zip(right).map(minus).collect()
}

/// The range of a map's values, as text, with its remark.
pub fn summary(quantity: Quantity, map: &Map) -> String {
    match remark(quantity, map) {
        Some(silent) if map.peak == 0.0 && map.rounding > 0.0 => silent,
        Some(remark) => format!("{}, {remark}", extent(quantity, map.peak.into())),
        None => extent(quantity, map.peak.into()),
    }
}

/// Evaluates and colours the request. A failing GPU is replaced by the CPU, once and with a warning, unless requested
/// by name.
///
/// # Errors
/// The errors of [`Stages::map`].
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
        let declaration = quantity.declaration();
        let pressed =
            (declaration.is_slow && !declaration.of_skin).then(|| stages.pressed(request)).transpose()?;
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
    let declaration = quantity.declaration();
    let whose = match declaration.of_light || declaration.of_skin {
        true => "the radiation pressure's peak",
        false => "the peak",
    };
    let error = match map.peak {
        0.0 if map.rounding > 0.0 => "silent: no value exceeds the rounding of its sum in f64".to_owned(),
        0.0 => "silent: every pressure underflows when squared in f32".to_owned(),
        _ => {
            let from = match quantity.declaration().of_volume {
                true => "a map with longer steps",
                false => "places that were compared with f64",
            };
            format!("error up to {:.1e} of {whose}, estimated from {from}", map.error)
        }
    };
    let mut how = format!("{who} took {time} for the map and its colours\n  {}\n  {error}", map.how);
    if map.has_larger() {
        let values = match quantity.declaration().norm {
            Norm::Pressure => format!("{} peak", Quantity::Rms.at_most(map.loudest.into())),
            Norm::Value | Norm::Difference => quantity.at_most(map.loudest.into()),
        };
        how.push_str(&format!(
            "\n  the range leaves out {} pixels within a wavelength of elements, with values up to {values}",
            map.near
        ));
    }
    how
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
