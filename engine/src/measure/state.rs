//! The state of an element: good, dead or reversed.

use std::f64::consts::{FRAC_PI_2, PI};

use num_complex::Complex64;
use strum::IntoStaticStr;

#[derive(Clone, Copy, Debug, PartialEq, Eq, IntoStaticStr)]
#[strum(serialize_all = "lowercase", const_into_str)]
pub enum State {
    Good,
    Dead,
    Reversed,
    /// Driven by no drive of the scan: unknown.
    Undriven,
}

/// Gain below which an element is dead, relative to the others.
const DEAD: f64 = 0.2;
/// Part of the elements that is reversed, before anything is known.
const USUALLY_REVERSED: f64 = 0.01;

impl State {
    pub fn name(self) -> &'static str {
        self.into_str()
    }
}

/// The states of some gains; the gains relative to the good ones' mean modulus and mean phase; and that modulus.
pub(super) fn states(gains: &[Complex64]) -> (Vec<State>, Vec<Complex64>, f64) {
    let middle = |mut values: Vec<f64>| {
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or(1.0).max(f64::MIN_POSITIVE)
    };
    let median = middle(gains.iter().map(|g| g.norm()).collect());
    let lives = |g: &&Complex64| g.norm() > DEAD * median;
    // The axis of the phases, whatever their sign; then the sign of most.
    let axis: Complex64 = gains.iter().filter(lives).map(|g| (g / g.norm()).powu(2)).sum();
    let mut common = Complex64::from_polar(1.0, axis.arg() / 2.0);
    if gains.iter().filter(lives).map(|g| (g * common.conj()).re.signum()).sum::<f64>() < 0.0 {
        common = -common;
    }
    let phase = |g: &Complex64, common: Complex64| (g * common.conj()).arg();
    for _ in 0..2 {
        let forward = gains.iter().filter(lives).filter(|g| phase(g, common).abs() < FRAC_PI_2);
        let sum: Complex64 = forward.map(|g| g / g.norm()).sum();
        common = Complex64::from_polar(1.0, sum.arg());
    }
    // With a rare reversal and normal phases, the likelier of the two explanations.
    let folded =
        gains.iter().filter(lives).map(|g| phase(g, common).abs()).map(|angle| angle.min(PI - angle));
    let deviation = 1.4826 * middle(folded.collect());
    let limit = (FRAC_PI_2 - deviation * deviation * USUALLY_REVERSED.ln() / PI).min(0.75 * PI);
    let state = |g: &Complex64| match () {
        () if !lives(&g) => State::Dead,
        () if phase(g, common).abs() > limit => State::Reversed,
        () => State::Good,
    };
    let states: Vec<_> = gains.iter().map(state).collect();
    let good: Vec<_> = gains
        .iter()
        .zip(&states)
        .filter(|(_, state)| **state == State::Good)
        .map(|(g, _)| g.norm())
        .collect();
    let scale = match good.len() {
        0 => median,
        count => good.iter().sum::<f64>() / count as f64,
    };
    (states, gains.iter().map(|g| g * common.conj() / scale).collect(), scale)
}
