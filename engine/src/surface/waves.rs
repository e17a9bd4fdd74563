//! Gravity-capillary waves: the response of a liquid's surface to a changing pressure, mode by mode and exact in
//! time.

use crate::scene::Liquid;
use crate::surface::Tank;
use crate::surface::dispersion::Mode;

/// A surface in motion, as amplitudes of its modes ([`Tank::modes`]).
///
/// A mode obeys h'' + 2γ h' + Ω² (h - rest) = 0, with the two roots of Lamb's exact equation for viscous waves
/// ([`Mode`]). The diffusion of vorticity after a change of the pressure is neglected.
#[derive(Clone, Debug)]
pub struct Waves {
    /// Depth of each mode, m.
    depth: Vec<f64>,
    /// m/s
    speed: Vec<f64>,
    steps: Vec<Step>,
}

/// Static depth (m) of each mode under a steady pressure.
#[derive(Clone, Debug)]
pub struct Rest(Vec<f64>);

impl Rest {
    /// From the static depression of every cell of the tank, m.
    ///
    /// Volume is conserved: unlike a depression in an endless bath, waves displace none.
    pub fn new(tank: &Tank, depth: &[f64]) -> Self {
        let mut modes = tank.modes(depth);
        if let Some(level) = modes.first_mut() {
            *level = 0.0;
        }
        Self(modes)
    }
}

/// A time step of a mode's deviation y from rest and its speed v: y ← a y + b v, v ← c y + d v.
#[derive(Clone, Copy, Debug)]
struct Step {
    a: f64,
    b: f64,
    c: f64,
    d: f64,
}

impl Waves {
    /// A level surface, to be advanced in steps of `step` (s).
    ///
    /// # Panics
    /// An invalid step: negative, or longer than 1e9 s.
    pub fn new(tank: &Tank, liquid: &Liquid, step: f64) -> Self {
        assert!((0.0..=1e9).contains(&step), "no time: {step} s");
        let steps = tank.squares().map(|square| Step::new(Mode::new(liquid, square.sqrt()), step)).collect();
        Self { depth: vec![0.0; tank.count()], speed: vec![0.0; tank.count()], steps }
    }

    /// Advances by one step under `part` of a pressure.
    pub fn advance(&mut self, Rest(rest): &Rest, part: f64) {
        let motion = self.depth.iter_mut().zip(&mut self.speed);
        for ((depth, speed), (rest, step)) in motion.zip(rest.iter().zip(&self.steps)) {
            let (y, v) = (*depth - part * rest, *speed);
            *depth = part * rest + step.a * y + step.b * v;
            *speed = step.c * y + step.d * v;
        }
    }

    /// m, positive down, for every cell of the tank.
    pub fn surface(&self, tank: &Tank) -> Vec<f64> {
        tank.surface(self.depth.clone())
    }
}

impl Step {
    fn new(Mode { damping, square, swing }: Mode, time: f64) -> Self {
        // e^{-γt} cos and e^{-γt} sin/ω of the damped mode, or their hyperbolic counterparts of a creeping mode.
        let (cosine, sine) = if swing > 0.0 {
            let angular = swing.sqrt();
            let left = (-damping * time).exp();
            (left * (angular * time).cos(), left * (angular * time).sin() / angular)
        } else {
            let apart = (-swing).sqrt();
            let fast = damping + apart;
            let slow = if fast > 0.0 { square / fast } else { 0.0 };
            let slowly = (-slow * time).exp();
            // e^{-slow t} - e^{-fast t}, also for nearly equal roots.
            let between = -slowly * (-2.0 * apart * time).exp_m1();
            (slowly - between / 2.0, if apart > 0.0 { between / (2.0 * apart) } else { time * slowly })
        };
        Self { a: cosine + damping * sine, b: sine, c: -square * sine, d: cosine - damping * sine }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use num_complex::Complex64;
    use strum::VariantArray;

    use super::*;
    use crate::scene::LiquidName;

    fn rest(tank: &Tank, liquid: &Liquid, pressure: &[f64]) -> Rest {
        Rest::new(tank, &tank.dent(liquid, pressure).depth)
    }

    /// One cosine along a row of cells.
    fn single(tank: &Tank, mode: usize) -> Vec<f64> {
        let mut modes = vec![0.0; tank.count()];
        modes[mode] = 1.0;
        tank.surface(modes)
    }

    /// Wavenumber of a mode along the rows, 1/m.
    fn wavenumber(tank: &Tank, mode: usize) -> f64 {
        PI * mode as f64 / (tank.step[0] * tank.counts[0] as f64)
    }

    /// Silicone oil of 10 000 cSt.
    fn thick_oil() -> Liquid {
        let (density, tension) = (Some(975.0), Some(0.0205));
        Liquid { density, surface_tension: tension, viscosity: Some(9.75), ..Liquid::default() }
    }

    #[test]
    fn a_mode_that_is_pressed_at_once_swings_about_its_rest() {
        let tank = Tank::new([40, 1], [0.001, 0.001]);
        for name in [LiquidName::Water, LiquidName::Glycerol] {
            let liquid = Liquid { name: Some(name), ..Liquid::default() };
            let q = wavenumber(&tank, 6);
            let Mode { damping, square, .. } = Mode::new(&liquid, q);
            let rest = 3.0 / (liquid.density() * liquid.gravity + liquid.surface_tension() * q * q);
            for steps in [7, 100] {
                let time = 0.083;
                let pressure: Vec<_> = single(&tank, 6).iter().map(|p| 3.0 * p).collect();
                let pressed = self::rest(&tank, &liquid, &pressure);
                let mut waves = Waves::new(&tank, &liquid, time / f64::from(steps));
                (0..steps).for_each(|_| waves.advance(&pressed, 1.0));
                let swing = Complex64::from(square - damping * damping).sqrt();
                let answer = (swing * time).cos() + damping * (swing * time).sin() / swing;
                let expected = rest * (1.0 - (-damping * time).exp() * answer.re);
                assert!(
                    (waves.depth[6] / expected - 1.0).abs() < 1e-9,
                    "{name:?}: {} {expected}",
                    waves.depth[6]
                );
            }
        }
    }

    /// The root of a mode that a step of `time` (s) leaves over, 1/s; of two that creep, the slower.
    fn root(step: Step, time: f64) -> Complex64 {
        let half = (step.a + step.d) / 2.0;
        let between = Complex64::from(half * half - (step.a * step.d - step.b * step.c)).sqrt();
        (half + between).ln() / time
    }

    #[test]
    fn every_mode_dies_away_as_lambs_equation_says() {
        let named = |name| Liquid { name: Some(name), ..Liquid::default() };
        let liquids = [LiquidName::Water, LiquidName::SiliconeOil, LiquidName::Glycerol].map(named);
        for liquid in liquids.into_iter().chain([thick_oil()]) {
            let liquid = Liquid { depth: 1.0, ..liquid };
            for q in (4..=100).map(|twentieths| f64::from(twentieths) / 20.0 / liquid.capillary_length()) {
                let square = liquid.gravity * q + liquid.surface_tension() * q.powi(3) / liquid.density();
                let n = liquid.viscosity() / liquid.density() * q * q;
                let time = 0.5 / (square.sqrt() + square / n).min(10.0 * square.sqrt());
                let s = root(Step::new(Mode::new(&liquid, q), time), time);
                // How far s is from a root, by Newton's step.
                let sheet = (s / n + 1.0).sqrt();
                let (value, slope) = (
                    (s + 2.0 * n).powi(2) + square - 4.0 * n * n * sheet,
                    2.0 * (s + 2.0 * n) - 2.0 * n / sheet,
                );
                assert!(
                    s.re < 0.0 && (value / slope / s).norm() < 1e-6,
                    "{liquid:?} {q}: {s} {}",
                    value / slope
                );
            }
        }
    }

    #[test]
    fn critical_damping_is_met_from_both_sides() {
        let (damping, time) = (3.0f64, 0.2f64);
        let left = (-damping * time).exp();
        for swing in [-1e-9, -1e-15, 0.0, 1e-15, 1e-9] {
            let step = Step::new(Mode { damping, square: damping * damping + swing, swing }, time);
            let expected = [
                left * (1.0 + damping * time),
                left * time,
                -left * time * damping * damping,
                left * (1.0 - damping * time),
            ];
            for (met, expected) in [step.a, step.b, step.c, step.d].into_iter().zip(expected) {
                assert!((met - expected).abs() < 1e-8, "{swing}: {step:?} {expected}");
            }
        }
    }

    #[test]
    fn thick_liquids_creep_at_the_known_rates() {
        let glycerol = Liquid { name: Some(LiquidName::Glycerol), ..Liquid::default() };
        // 1/s at q of one and two radians per capillary length, from Lamb's equation.
        for (liquid, rates) in [(glycerol, [21.48, 25.38]), (thick_oil(), [1.436, 1.795])] {
            for (rate, radians) in rates.into_iter().zip([1.0, 2.0]) {
                let side = PI * liquid.capillary_length() / radians;
                let tank = Tank::new([8, 1], [side / 8.0, side / 8.0]);
                let pressed = rest(&tank, &liquid, &single(&tank, 1));
                let time = 0.5 / rate;
                let mut waves = Waves::new(&tank, &liquid, time);
                (0..40).for_each(|_| waves.advance(&pressed, 1.0));
                let settled = waves.depth[1];
                (0..2).for_each(|_| waves.advance(&pressed, 0.0));
                let before = waves.depth[1];
                waves.advance(&pressed, 0.0);
                let measured = (before / waves.depth[1]).ln() / time;
                assert!((settled / pressed.0[1] - 1.0).abs() < 1e-6, "{settled} {}", pressed.0[1]);
                assert!((measured / rate - 1.0).abs() < 5e-4, "{measured} {rate}");
            }
        }
    }

    #[test]
    fn a_mode_under_a_swinging_pressure_ends_in_its_resonance_curve() {
        const STEPS: u32 = 400;
        let tank = Tank::new([40, 1], [0.001, 0.001]);
        let liquid = Liquid { viscosity: Some(0.02), ..Liquid::default() };
        let q = wavenumber(&tank, 8);
        let Mode { damping, square, .. } = Mode::new(&liquid, q);
        let rest = 1.0 / (liquid.density() * liquid.gravity + liquid.surface_tension() * q * q);
        for frequency in [10.0, 35.0, 80.0] {
            let pressed = self::rest(&tank, &liquid, &single(&tank, 8));
            let mut waves = Waves::new(&tank, &liquid, 1.0 / (frequency * f64::from(STEPS)));
            let mut largest = 0.0f64;
            for period in 0..200 {
                for i in 0..STEPS {
                    waves.advance(&pressed, (TAU * (f64::from(i) + 0.5) / f64::from(STEPS)).sin());
                    largest = if period < 199 { 0.0 } else { largest.max(waves.depth[8].abs()) };
                }
            }
            let angular = TAU * frequency;
            let expected = rest * square / (square - angular * angular).hypot(2.0 * damping * angular);
            assert!((largest / expected - 1.0).abs() < 1e-3, "{frequency} Hz: {largest} {expected}");
        }
    }

    #[test]
    fn nothing_blows_up_and_what_is_left_alone_comes_to_rest() {
        let tank = Tank::new([30, 24], [0.0015, 0.0015]);
        for &name in LiquidName::VARIANTS {
            let liquid = Liquid { name: Some(name), ..Liquid::default() };
            let pressure: Vec<_> = (0..tank.count()).map(|i| f64::from(u8::from(i == 370))).collect();
            let pressed = rest(&tank, &liquid, &pressure);
            let mut waves = Waves::new(&tank, &liquid, 0.004);
            waves.advance(&pressed, 1.0);
            let pushed = waves.surface(&tank).iter().fold(0.0f64, |most, h| most.max(h.abs()));
            (0..30_000).for_each(|_| waves.advance(&pressed, 0.0));
            let left = waves.surface(&tank).iter().fold(0.0f64, |most, h| most.max(h.abs()));
            assert!(pushed > 0.0 && left < 1e-3 * pushed, "{name:?}: {pushed} {left}");
        }
    }
}
