//! Gravity-capillary waves: how a liquid's surface answers a pressure that changes, mode by mode and without error in time.

use crate::scene::Liquid;
use crate::surface::Tank;

/// A surface in motion, as amplitudes of its modes ([`Tank::modes`]).
///
/// A mode with wavenumber q obeys h'' + 4νq² h' + ω² h = (q tanh(q d)/ρ) p, ω² = (g q + σ q³/ρ) tanh(q d), for small damping.
#[derive(Clone, Debug)]
pub struct Waves {
    /// Depth of each mode, m.
    depth: Vec<f64>,
    /// m/s
    speed: Vec<f64>,
    steps: Vec<Step>,
}

/// Depth (m) at which each mode would rest under a steady pressure.
#[derive(Clone, Debug)]
pub struct Rest(Vec<f64>);

impl Rest {
    /// From the dent that the pressure makes, m for every cell of the tank.
    ///
    /// The liquid as a whole stays where it is: unlike a dent in an endless bath, waves displace nothing.
    pub fn new(tank: &Tank, depth: &[f64]) -> Self {
        let mut modes = tank.modes(depth);
        if let Some(level) = modes.first_mut() {
            *level = 0.0;
        }
        Self(modes)
    }
}

/// What a time step does to a mode's distance y from rest and its speed v: y ← a y + b v, v ← c y + d v.
#[derive(Clone, Copy, Debug)]
struct Step {
    a: f64,
    b: f64,
    c: f64,
    d: f64,
}

impl Waves {
    /// A level surface, to go on in steps of `step` (s).
    ///
    /// # Panics
    /// A step that is no time: negative, or longer than 1e9 s.
    pub fn new(tank: &Tank, liquid: &Liquid, step: f64) -> Self {
        assert!((0.0..=1e9).contains(&step), "no time: {step} s");
        let steps = tank.squares().map(|square| Step::new(liquid, square.sqrt(), step)).collect();
        Self { depth: vec![0.0; tank.len()], speed: vec![0.0; tank.len()], steps }
    }

    /// Goes on by one step, in which `part` of a pressure acts.
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
    fn new(liquid: &Liquid, q: f64, time: f64) -> Self {
        let density = liquid.density();
        let square =
            (liquid.gravity * q + liquid.surface_tension() * q.powi(3) / density) * (q * liquid.depth).tanh();
        let damping = 2.0 * liquid.viscosity() / density * q * q;
        // e^{-γt} cos and e^{-γt} sin/ω of the damped mode, or their hyperbolic likes of one that creeps.
        let (cosine, sine) = if square > damping * damping {
            let angular = (square - damping * damping).sqrt();
            let left = (-damping * time).exp();
            (left * (angular * time).cos(), left * (angular * time).sin() / angular)
        } else {
            let apart = (damping * damping - square).sqrt();
            let fast = damping + apart;
            let slow = if fast > 0.0 { square / fast } else { 0.0 };
            let (slowly, quickly) = ((-slow * time).exp(), (-fast * time).exp());
            let sine = if apart * time > 1e-6 { (slowly - quickly) / (2.0 * apart) } else { time * slowly };
            ((slowly + quickly) / 2.0, sine)
        };
        Self { a: cosine + damping * sine, b: sine, c: -square * sine, d: cosine - damping * sine }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use super::*;
    use crate::scene::LiquidName;

    fn rest(tank: &Tank, liquid: &Liquid, pressure: &[f64]) -> Rest {
        Rest::new(tank, &tank.dent(liquid, pressure).depth)
    }

    /// One cosine along a row of cells.
    fn single(tank: &Tank, mode: usize) -> Vec<f64> {
        let mut modes = vec![0.0; tank.len()];
        modes[mode] = 1.0;
        tank.surface(modes)
    }

    fn properties(liquid: &Liquid, tank: &Tank, mode: usize) -> (f64, f64, f64) {
        let q = PI * mode as f64 / (tank.step[0] * tank.counts[0] as f64);
        let square = (liquid.gravity * q + liquid.surface_tension() * q.powi(3) / liquid.density())
            * (q * liquid.depth).tanh();
        (q, square, 2.0 * liquid.viscosity() / liquid.density() * q * q)
    }

    #[test]
    fn a_mode_that_is_pressed_at_once_swings_about_its_rest() {
        let tank = Tank::new([40, 1], [0.001, 0.001]);
        for name in [LiquidName::Water, LiquidName::Glycerol] {
            let liquid = Liquid { name, ..Liquid::default() };
            let (q, square, damping) = properties(&liquid, &tank, 6);
            let rest = 3.0 / (liquid.density() * liquid.gravity + liquid.surface_tension() * q * q);
            for steps in [7, 100] {
                let time = 0.083;
                let pressure: Vec<_> = single(&tank, 6).iter().map(|p| 3.0 * p).collect();
                let pressed = self::rest(&tank, &liquid, &pressure);
                let mut waves = Waves::new(&tank, &liquid, time / f64::from(steps));
                (0..steps).for_each(|_| waves.advance(&pressed, 1.0));
                let swing = num_complex::Complex64::from(square - damping * damping).sqrt();
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

    #[test]
    fn a_mode_under_a_swinging_pressure_ends_in_its_resonance_curve() {
        const STEPS: u32 = 400;
        let tank = Tank::new([40, 1], [0.001, 0.001]);
        let liquid = Liquid { viscosity: Some(0.02), ..Liquid::default() };
        let (q, square, damping) = properties(&liquid, &tank, 8);
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
        for name in LiquidName::ALL {
            let liquid = Liquid { name, ..Liquid::default() };
            let pressure: Vec<_> = (0..tank.len()).map(|i| f64::from(u8::from(i == 370))).collect();
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
