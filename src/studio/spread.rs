//! Arrays whose elements differ, in words: 5, 50 and 95 % of every figure, what a calibration would win, and faults.

use crate::rounding::percent;
use crate::scene::{Scene, Spread};
use crate::solver::{Ranges, left_by_faults};

/// The spread of a scene.
pub fn title(Spread { gain, phase }: Spread) -> String {
    format!("elements that differ by {} in gain and {:.1}° in phase, rms", percent(gain), phase.to_degrees())
}

/// A row per figure: its name, and 5, 50 and 95 % of it.
pub fn rows(ranges: &Ranges, pressure: impl Fn(f64) -> String) -> Vec<(&'static str, String)> {
    let listed = |range: [f64; 3], tell: &dyn Fn(f64) -> String| range.map(tell).join(", ");
    let Ranges { mean_pressure, min_pressure, spread, evenness, relative_to_single, .. } = *ranges;
    let mut rows = vec![
        ("mean pressure", listed(mean_pressure, &pressure)),
        ("weakest focus", listed(min_pressure, &pressure)),
        ("uniformity (std/mean)", listed(spread, &percent)),
        ("evenness", listed(evenness, &percent)),
    ];
    rows.extend(ranges.strength.map(|strength| ("strength", listed(strength, &percent))));
    rows.push(("relative to single", listed(relative_to_single, &|value| format!("{value:.4}"))));
    rows.extend(ranges.side_lobe.map(|lobe| ("peak side lobe", listed(lobe, &percent))));
    rows
}

/// What elements that are measured and corrected would win over the median.
pub fn won(ranges: &Ranges) -> String {
    let [mean, weakest] = ranges.won.map(|won| percent(won - 1.0));
    format!("{mean} of the mean pressure, {weakest} of the weakest focus")
}

/// What dead and reversed elements cost.
pub fn faults(scene: &Scene) -> String {
    let elements = scene.elements();
    let lost = |dead: usize, reversed: usize| percent(1.0 - left_by_faults(elements, dead, reversed));
    let off = match elements - scene.driven().len() {
        0 => String::new(),
        off => format!(", the {off} that are off {}", lost(off, 0)),
    };
    format!("a dead element costs {} of the pressure, a reversed one {}{off}", lost(1, 0), lost(0, 1))
}
