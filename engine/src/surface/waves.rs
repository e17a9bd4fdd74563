//! Gravity-capillary waves: the response of a liquid's surface to a changing pressure, mode by mode and exact in
//! time.

use std::collections::HashMap;
use std::f64::consts::TAU;
use std::ops::Range;

use num_complex::Complex64;
use rayon::prelude::*;

use crate::scene::{Liquid, SpectralLine};
use crate::surface::Tank;
use crate::surface::dispersion::Mode;

/// Modes advanced together: their steps stay in the nearest cache.
const TOGETHER: usize = 256;
/// Durations that differ by less are the same, s.
const INSTANT: f64 = 1e-12;
/// Limit of memory for the steps of recurring durations, in bytes.
const MOST_BYTES: usize = 1 << 26;
/// Limit of a stretch of time, s.
const LONGEST: f64 = 1e6;
/// Durations remembered as having occurred.
const MOST_DURATIONS: usize = 1 << 12;

/// A surface in motion, as amplitudes of its modes ([`Tank::modes`]).
///
/// A mode obeys h'' + 2γ h' + Ω² (h - rest) = 0, with the two roots of Lamb's exact equation for viscous waves
/// ([`Mode`]). The diffusion of vorticity after a change of the pressure is neglected.
#[derive(Clone, Debug)]
pub struct Waves {
    modes: Vec<Mode>,
    /// Depth of each mode, m.
    depth: Vec<f64>,
    /// m/s
    speed: Vec<f64>,
    /// s, since the level surface.
    time: f64,
    /// The part of the steady pressure that swings, for all time.
    lines: Vec<SpectralLine>,
    steps: Steps,
}

/// Static depth (m) of each mode under a steady pressure.
#[derive(Clone, Debug)]
pub struct Rest(Vec<f64>);

impl Rest {
    /// The modes of the static depression (m) of every cell of the tank.
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

/// A stretch of time in which the pressure does not jump: a straight part of a steady pressure, and all lines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// The steady pressure, by the number of its rest.
    pub rest: usize,
    /// End of the stretch, s.
    pub until: f64,
    /// Mean of the straight part.
    pub part: f64,
    /// Change of the straight part from the beginning to the end.
    pub rise: f64,
}

impl Waves {
    /// A level surface at the time 0, to be moved by parts of steady pressures; `lines` are added to all parts.
    pub fn new(tank: &Tank, liquid: &Liquid, lines: Vec<SpectralLine>) -> Self {
        let mode = |square: f64| Mode::new(liquid, square.sqrt()).with_losses();
        let modes: Vec<_> = tank.squares().map(mode).collect();
        let (depth, speed) = (vec![0.0; modes.len()], vec![0.0; modes.len()]);
        Self { modes, depth, speed, time: 0.0, lines, steps: Steps::default() }
    }

    /// A level surface again, at the time 0.
    pub fn restart(&mut self) {
        self.depth.fill(0.0);
        self.speed.fill(0.0);
        self.time = 0.0;
    }

    /// Advances through stretches of time, one after the other.
    ///
    /// # Panics
    /// A stretch that ends before it begins or more than 1e6 s later, or without a rest.
    pub fn advance(&mut self, rests: &[Rest], stretches: &[Stretch]) {
        let passages: Vec<_> = stretches.iter().map(|stretch| self.passage(*stretch)).collect();
        let Self { modes, depth, speed, lines, steps, .. } = self;
        let chunks = depth.par_chunks_mut(TOGETHER).zip(speed.par_chunks_mut(TOGETHER));
        chunks.zip(modes.par_chunks(TOGETHER)).enumerate().for_each(|(chunk, ((depth, speed), modes))| {
            let range = chunk * TOGETHER..chunk * TOGETHER + modes.len();
            let mut chunk = Chunk { modes, depth, speed, steps: Vec::new(), ends: Vec::new() };
            for passage in &passages {
                chunk.pass(passage, &rests[passage.stretch.rest].0[range.clone()], lines, steps, &range);
            }
        });
    }

    /// Goes on to the end of a stretch.
    fn passage(&mut self, stretch: Stretch) -> Passage {
        let [from, to] = [self.time, stretch.until];
        assert!((0.0..=LONGEST).contains(&(to - from)), "no time: from {from} to {to} s");
        self.time = to;
        let duration = Duration::new(to - from);
        self.steps.meet(duration, &self.modes);
        let turning = |time: f64| -> Vec<_> {
            let turned = |line: &SpectralLine| {
                Complex64::from_polar(line.amplitude, TAU * (line.frequency * time).fract() + line.phase)
            };
            self.lines.iter().map(turned).collect()
        };
        Passage { stretch, duration, turned: [from, to].map(turning) }
    }

    /// m, positive down, for every cell of the tank.
    pub fn surface(&self, tank: &Tank) -> Vec<f64> {
        tank.surface(self.depth.clone())
    }
}

/// A stretch of time on its way: amplitude · e^{j(ωt + phase)} of all lines at its ends.
struct Passage {
    stretch: Stretch,
    duration: Duration,
    turned: [Vec<Complex64>; 2],
}

/// Some modes on their way.
struct Chunk<'a> {
    modes: &'a [Mode],
    depth: &'a mut [f64],
    speed: &'a mut [f64],
    /// Room for the steps of a duration that does not recur, and for the lines' courses.
    steps: Vec<Step>,
    ends: Vec<[[f64; 2]; 2]>,
}

impl Chunk<'_> {
    fn pass(
        &mut self,
        passage: &Passage,
        rest: &[f64],
        lines: &[SpectralLine],
        known: &Steps,
        range: &Range<usize>,
    ) {
        let Passage { stretch, duration, turned } = passage;
        let steps = match known.of(*duration) {
            Some(steps) => &steps[range.clone()],
            None => {
                self.steps.clear();
                self.steps.extend(self.modes.iter().map(|mode| Step::new(mode, duration.seconds())));
                &self.steps[..]
            }
        };
        let motion = self.depth.iter_mut().zip(&mut *self.speed).zip(rest.iter().zip(steps));
        if lines.is_empty() {
            for ((depth, speed), (rest, step)) in motion {
                let (part, rise) = (stretch.part * rest, stretch.rise * rest);
                (*depth, *speed) = step.after([part, 0.0], [*depth, *speed], [part, 0.0], rise);
            }
            return;
        }
        self.ends.clear();
        self.ends.resize(self.modes.len(), [[stretch.part, 0.0]; 2]);
        for (index, line) in lines.iter().enumerate() {
            let angular = TAU * line.frequency;
            for (mode, ends) in self.modes.iter().zip(&mut self.ends) {
                let response = mode.response(angular);
                for (end, turned) in ends.iter_mut().zip(turned) {
                    let swing = response * turned[index];
                    end[0] += swing.re;
                    end[1] -= angular * swing.im;
                }
            }
        }
        for (((depth, speed), (rest, step)), ends) in motion.zip(&self.ends) {
            let [from, to] = ends.map(|end| end.map(|part| part * rest));
            (*depth, *speed) = step.after(from, [*depth, *speed], to, stretch.rise * rest);
        }
    }
}

impl Mode {
    /// In an inviscid liquid a mode in resonance would have no steady swing.
    fn with_losses(self) -> Self {
        /// Damping relative to the natural frequency.
        const LEAST: f64 = 1e-9;
        let damping = self.damping.max(LEAST * self.square.sqrt());
        if damping == self.damping {
            self
        } else {
            Self { damping, swing: self.square - damping * damping, ..self }
        }
    }

    /// The steady swing of a mode under a pressure e^{jωt} that would press it down by 1.
    fn response(&self, angular: f64) -> Complex64 {
        let below = Complex64::new(self.square - angular * angular, 2.0 * self.damping * angular);
        self.square * below.conj() / below.norm_sqr()
    }
}

/// A duration, to the nearest [`INSTANT`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Duration(u64);

impl Duration {
    fn new(seconds: f64) -> Self {
        Self((seconds / INSTANT).round() as u64)
    }

    fn seconds(self) -> f64 {
        self.0 as f64 * INSTANT
    }
}

/// The steps of recurring durations of all modes, as far as memory allows.
#[derive(Clone, Debug, Default)]
struct Steps {
    /// Durations that occurred, with the number of their steps if they have recurred.
    met: HashMap<Duration, Option<usize>>,
    kept: Vec<Vec<Step>>,
}

impl Steps {
    fn meet(&mut self, duration: Duration, modes: &[Mode]) {
        let room = (MOST_BYTES / (modes.len() * size_of::<Step>())).max(1);
        match self.met.get_mut(&duration) {
            Some(Some(_)) => {}
            Some(number) if self.kept.len() < room => {
                *number = Some(self.kept.len());
                let step = |mode: &Mode| Step::new(mode, duration.seconds());
                self.kept.push(modes.par_iter().map(step).collect());
            }
            Some(None) => {}
            None => {
                if self.met.len() >= MOST_DURATIONS {
                    self.met.retain(|_, number| number.is_some());
                }
                self.met.insert(duration, None);
            }
        }
    }

    fn of(&self, duration: Duration) -> Option<&[Step]> {
        let number = self.met.get(&duration).copied().flatten()?;
        self.kept.get(number).map(Vec::as_slice)
    }
}

/// A time step of a mode's deviation y from rest and its speed v: y ← a y + b v, v ← c y + d v.
#[derive(Clone, Copy, Debug)]
struct Step {
    a: f64,
    b: f64,
    c: f64,
    d: f64,
    /// Depth and speed after a rise of the rest from -1/2 to 1/2.
    rise: [f64; 2],
}

impl Step {
    fn new(&Mode { damping, square, swing }: &Mode, time: f64) -> Self {
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
        let (a, b, c, d) = (cosine + damping * sine, sine, -square * sine, cosine - damping * sine);
        Self { a, b, c, d, rise: rise(damping, square, time, [1.0 - a, b]) }
    }

    /// Depth and speed after the step, from those before and from the rest and its speed at both ends, besides a rise of the
    /// rest about its mean.
    fn after(&self, rest: [f64; 2], [depth, speed]: [f64; 2], rest_then: [f64; 2], rise: f64) -> (f64, f64) {
        let (y, v) = (depth - rest[0], speed - rest[1]);
        (
            rest_then[0] + self.a * y + self.b * v + self.rise[0] * rise,
            rest_then[1] + self.c * y + self.d * v + self.rise[1] * rise,
        )
    }
}

/// Depth and speed of a level mode after a rise of its rest from -1/2 to 1/2 in a time. `stepped` is its depth after a jump
/// of its rest by 1 at the beginning, b as in [`Step`].
fn rise(damping: f64, square: f64, time: f64, [stepped, b]: [f64; 2]) -> [f64; 2] {
    /// A mode that lags behind by more times does not follow.
    const MOST: f64 = 1e6;
    let lag = 2.0 * damping / (square * time);
    // A mode without a restoring force has no lag at all, but a NaN.
    if !(0.0..MOST).contains(&lag) {
        return [0.0; 2];
    }
    [1.0 - lag * stepped - b / time - stepped / 2.0, stepped / time - square * b / 2.0]
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};
    use std::slice;

    use num_complex::Complex64;
    use strum::VariantArray;

    use super::*;
    use crate::scene::LiquidName;

    fn rest(tank: &Tank, liquid: &Liquid, pressure: &[f64]) -> Rest {
        Rest::new(tank, &tank.dent(liquid, pressure).depth)
    }

    /// Goes on for a time (s) under a part of a pressure.
    fn press(waves: &mut Waves, rest: &Rest, time: f64, part: f64) {
        let stretch = Stretch { rest: 0, until: waves.time + time, part, rise: 0.0 };
        waves.advance(slice::from_ref(rest), &[stretch]);
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
    fn critical_damping_is_met_from_both_sides() {
        let (damping, time) = (3.0f64, 0.2f64);
        let left = (-damping * time).exp();
        for swing in [-1e-9, -1e-15, 0.0, 1e-15, 1e-9] {
            let step = Step::new(&Mode { damping, square: damping * damping + swing, swing }, time);
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
                let mut waves = Waves::new(&tank, &liquid, Vec::new());
                (0..40).for_each(|_| press(&mut waves, &pressed, time, 1.0));
                let settled = waves.depth[1];
                (0..2).for_each(|_| press(&mut waves, &pressed, time, 0.0));
                let before = waves.depth[1];
                press(&mut waves, &pressed, time, 0.0);
                let measured = (before / waves.depth[1]).ln() / time;
                assert!((settled / pressed.0[1] - 1.0).abs() < 1e-6, "{settled} {}", pressed.0[1]);
                assert!((measured / rate - 1.0).abs() < 5e-4, "{measured} {rate}");
            }
        }
    }

    /// A pressure that rises, swings and jumps, by the time: from the beginning until each end, the part and its rise.
    const JUMPS: [(f64, f64, f64); 3] = [(0.021, 0.6, 0.8), (0.034, 0.1, -0.2), (0.05, 0.0, 0.0)];

    /// Liquids whose modes swing, creep, stand still, and have no losses.
    fn liquids() -> [Liquid; 5] {
        let named = |name| Liquid { name: Some(name), ..Liquid::default() };
        let inviscid = Liquid { viscosity: Some(0.0), ..Liquid::default() };
        let tar = Liquid { viscosity: Some(1e4), depth: 1e-5, ..Liquid::default() };
        [named(LiquidName::Water), named(LiquidName::Glycerol), thick_oil(), tar, inviscid]
    }

    fn lines() -> Vec<SpectralLine> {
        let line = |frequency, amplitude, phase| SpectralLine { frequency, amplitude, phase };
        vec![line(31.0, 0.4, 0.7), line(170.0, 0.3, -1.0)]
    }

    #[test]
    fn a_stretch_ends_as_its_parts_one_by_one() {
        let tank = Tank::new([12, 10], [0.0015, 0.0015]);
        let pressure: Vec<_> = (0..tank.count()).map(|i| f64::from(u8::from(i == 37))).collect();
        for liquid in liquids() {
            let pressed = rest(&tank, &liquid, &pressure);
            let surface = |parts: u32| {
                let mut waves = Waves::new(&tank, &liquid, lines());
                let mut from = 0.0;
                for (end, part, rise) in JUMPS {
                    let each = |i: u32| {
                        let share = (f64::from(i) + 0.5) / f64::from(parts) - 0.5;
                        let until = from + (end - from) * f64::from(i + 1) / f64::from(parts);
                        Stretch { rest: 0, until, part: part + rise * share, rise: rise / f64::from(parts) }
                    };
                    waves.advance(slice::from_ref(&pressed), &(0..parts).map(each).collect::<Vec<_>>());
                    from = end;
                }
                waves.surface(&tank)
            };
            let whole = surface(1);
            let largest = pressed.0.iter().map(|h| h.abs()).sum::<f64>();
            for parts in [3, 40] {
                let apart = surface(parts).iter().zip(&whole).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(apart < 1e-6 * largest, "{liquid:?}: {apart} of {largest}, {parts}");
            }
        }
    }

    #[test]
    fn waves_are_the_integral_of_their_pressure() {
        const STEPS: u32 = 20_000;
        let tank = Tank::new([20, 1], [0.0015, 0.0015]);
        let pressure: Vec<_> = (0..tank.count()).map(|i| f64::from(u8::from(i == 5))).collect();
        let end = JUMPS[2].0;
        let part = |time: f64| {
            let before = |&(until, ..): &(f64, f64, f64)| until <= time;
            let piece = JUMPS.iter().position(|jump| !before(jump)).unwrap_or(2);
            let (from, (until, part, rise)) =
                (if piece == 0 { 0.0 } else { JUMPS[piece - 1].0 }, JUMPS[piece]);
            let swing =
                |line: &SpectralLine| line.amplitude * (TAU * line.frequency * time + line.phase).cos();
            part + rise * ((time - from) / (until - from) - 0.5) + lines().iter().map(swing).sum::<f64>()
        };
        for liquid in liquids() {
            let pressed = rest(&tank, &liquid, &pressure);
            let mut waves = Waves::new(&tank, &liquid, lines());
            let stretches = JUMPS.map(|(until, part, rise)| Stretch { rest: 0, until, part, rise });
            waves.advance(slice::from_ref(&pressed), &stretches);
            let largest = pressed.0.iter().fold(0.0f64, |most, h| most.max(h.abs()));
            for (index, depth) in waves.depth.iter().enumerate().skip(1) {
                let Mode { damping, square, .. } = Mode::new(&liquid, wavenumber(&tank, index));
                // Midpoints of the pressure times the response to a blow: Ω² times the difference of two exponentials.
                let apart = Complex64::from(damping * damping - square).sqrt();
                let step = end / f64::from(STEPS);
                let moved = |i: u32| {
                    let time = (f64::from(i) + 0.5) * step;
                    let [slow, fast] =
                        [square / (damping + apart), damping + apart].map(|s| (-s * (end - time)).exp());
                    part(time) * (square * (slow - fast) / (2.0 * apart)).re * step
                };
                let expected = pressed.0[index] * (0..STEPS).map(moved).sum::<f64>();
                // A jump within a midpoint's step, and fast roots of a creep, cost little.
                assert!((depth - expected).abs() < 2e-4 * largest, "{liquid:?} {index}: {depth} {expected}");
            }
        }
    }

    #[test]
    fn nothing_blows_up_and_what_is_left_alone_comes_to_rest() {
        let tank = Tank::new([30, 24], [0.0015, 0.0015]);
        for &name in LiquidName::VARIANTS {
            let liquid = Liquid { name: Some(name), ..Liquid::default() };
            let pressure: Vec<_> = (0..tank.count()).map(|i| f64::from(u8::from(i == 370))).collect();
            let pressed = rest(&tank, &liquid, &pressure);
            let mut waves = Waves::new(&tank, &liquid, Vec::new());
            press(&mut waves, &pressed, 0.004, 1.0);
            let pushed = waves.surface(&tank).iter().fold(0.0f64, |most, h| most.max(h.abs()));
            (0..30_000).for_each(|_| press(&mut waves, &pressed, 0.004, 0.0));
            let left = waves.surface(&tank).iter().fold(0.0f64, |most, h| most.max(h.abs()));
            assert!(pushed > 0.0 && left < 1e-3 * pushed, "{name:?}: {pushed} {left}");
        }
    }
}
