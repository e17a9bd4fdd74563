//! The motion of a bead under radiation force, weight and drag, with the added mass of the air.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use crate::force::{Levitation, Sphere, modes};
use crate::gauge::Gauge;

/// Moments in the shortest period of the bead, in any flight at least, and at most.
const A_PERIOD: f64 = 40.0;
const LEAST: f64 = 1000.0;
const MOST: f64 = 2e6;
/// Limit of a step's estimated error, in wavelengths and in wavelengths per time scale of the bead.
const TOLERANCE: f64 = 1e-8;
/// The shortest step, as a part of the time between moments.
const SHORTEST: f64 = 1e-9;
/// Halvings of a step in which a bead is lost.
const HALVINGS: usize = 50;
/// Distance from the trap, in wavelengths, at which a bead is lost.
const LOST: f64 = 1.0;

/// Drag of a sphere: Stokes', with Schiller and Naumann's factor for Reynolds numbers up to 1000.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drag {
    /// 6πμa, N·s/m
    pub slow: f64,
    /// Reynolds number of 1 m/s.
    pub reynolds: f64,
}

impl Drag {
    /// Drag in air of this viscosity (Pa·s) and density (kg/m³).
    pub fn new(sphere: &Sphere, viscosity: f64, density: f64) -> Self {
        let radius = sphere.radius;
        Self { slow: 6.0 * PI * viscosity * radius, reynolds: 2.0 * radius * density / viscosity }
    }

    /// N
    pub fn force(&self, velocity: DVec3) -> DVec3 {
        let reynolds = self.reynolds * velocity.length();
        velocity * (-self.slow * (1.0 + 0.15 * reynolds.powf(0.687)))
    }
}

/// Fields played cyclically, each with the trap's position (m).
#[derive(Clone, Copy, Debug)]
pub struct Carriage<'a> {
    pub fields: &'a [Levitation],
    pub wanted: &'a [DVec3],
    /// s that each is played.
    pub span: f64,
    pub drag: Drag,
}

/// A moment of a flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// s from the release.
    pub time: f64,
    /// m
    pub at: DVec3,
    /// m/s
    pub velocity: DVec3,
    /// m
    pub wanted: DVec3,
}

/// The flight of a bead.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Flight {
    /// Moments at an even rate, and the end.
    pub moments: Vec<Moment>,
    /// Largest distance from the trap, m.
    pub farthest: f64,
    /// The bead was a wavelength away at the last moment; its later motion is unknown.
    pub is_lost: bool,
}

impl Carriage<'_> {
    /// Releases a bead at rest at a point (m), and follows it for some seconds, or until it is lost.
    ///
    /// # Panics
    /// No field, or different numbers of fields and positions.
    pub fn fly(&self, from: DVec3, seconds: f64, progress: &Gauge) -> Flight {
        assert!(!self.fields.is_empty() && self.fields.len() == self.wanted.len(), "a place for every field");
        let every = self.every(from, seconds);
        let tolerances =
            [TOLERANCE * self.fields[0].wavelength, TOLERANCE * self.fields[0].wavelength / self.scale(from)];
        let mut flight = Flight::default();
        let mut state = State { at: from, velocity: DVec3::ZERO, acceleration: DVec3::ZERO };
        let (mut time, mut length) = (0.0, every);
        let mut turn = 0;
        flight.push(Moment { time, at: from, velocity: DVec3::ZERO, wanted: self.wanted[0] });
        while time < seconds && !flight.is_lost {
            let index = turn % self.fields.len();
            let (field, wanted) = (&self.fields[index], self.wanted[index]);
            let end = (self.span * (turn + 1) as f64).min(seconds);
            state.acceleration = self.acceleration(field, state.at, state.velocity);
            while time < end && !flight.is_lost {
                // Equal parts leave no short remainder.
                let parts = ((end - time) / length).ceil().max(1.0);
                let step = (end - time) / parts;
                let (to, errors) = self.advance(field, &state, step);
                let error = (errors[0] / tolerances[0]).max(errors[1] / tolerances[1]);
                length = step * (0.9 * error.powf(-0.2)).clamp(0.2, 5.0);
                if error.is_nan() {
                    length = 0.2 * step;
                }
                let is_accepted = error <= 1.0 || step <= SHORTEST * every;
                if !is_accepted {
                    continue;
                }
                let after = if parts > 1.0 { time + step } else { end };
                let piece = Piece { from: state, to, start: time, step };
                flight.follow(&piece, after, every, (wanted, LOST * field.wavelength));
                (state, time) = (to, after);
                progress.tell((1e3 * time / seconds) as usize, 1000);
            }
            turn += 1;
        }
        if !flight.is_lost && flight.moments[flight.moments.len() - 1].time < time {
            let wanted = self.wanted[(turn + self.fields.len() - 1) % self.fields.len()];
            flight.push(Moment { time, at: state.at, velocity: state.velocity, wanted });
        }
        flight
    }

    /// kg
    fn inertia(&self) -> f64 {
        self.fields[0].sphere.inertia()
    }

    /// The shortest time scale of the bead (s) where it is wanted and released: the inverse angular frequency or the
    /// drag's relaxation time.
    fn scale(&self, from: DVec3) -> f64 {
        let places = self.wanted.iter().copied().zip(self.fields).chain([(from, &self.fields[0])]);
        let stiffest = places.fold(0.0f64, |most, (place, field)| {
            let modes = modes(&field.forces(place).symmetric());
            modes.iter().fold(most, |most, mode| most.max(mode.stiffness.abs()))
        });
        let own = (self.inertia() / stiffest.max(f64::MIN_POSITIVE)).sqrt();
        own.min(self.inertia() / self.drag.slow)
    }

    /// Time between moments (s), a whole part of a field's span or else of the flight.
    fn every(&self, from: DVec3, seconds: f64) -> f64 {
        let longest = (TAU * self.scale(from) / A_PERIOD).min(seconds / LEAST).max(seconds / MOST);
        let whole = if self.span.is_finite() { self.span } else { seconds };
        whole / (whole / longest).ceil().max(1.0)
    }

    fn acceleration(&self, field: &Levitation, at: DVec3, velocity: DVec3) -> DVec3 {
        (field.net(at) + self.drag.force(velocity)) / self.inertia()
    }

    /// A step of Dormand and Prince's method (J. Comput. Appl. Math. 6:19, 1980), of the fifth order, with its
    /// estimated error in place (m) and velocity (m/s).
    fn advance(&self, field: &Levitation, from: &State, step: f64) -> (State, [f64; 2]) {
        let mut slopes = [[DVec3::ZERO; 2]; 7];
        slopes[0] = [from.velocity, from.acceleration];
        let sum = |weights: &[f64], slopes: &[[DVec3; 2]], part: usize| {
            weights.iter().zip(slopes).map(|(weight, slope)| *weight * slope[part]).sum::<DVec3>()
        };
        let (mut at, mut velocity) = (from.at, from.velocity);
        for (stage, weights) in STAGES.iter().enumerate() {
            let weights = &weights[..=stage];
            at = from.at + sum(weights, &slopes, 0) * step;
            velocity = from.velocity + sum(weights, &slopes, 1) * step;
            slopes[stage + 1] = [velocity, self.acceleration(field, at, velocity)];
        }
        let error = |part| (sum(&ERROR, &slopes, part) * step).length();
        (State { at, velocity, acceleration: slopes[6][1] }, [error(0), error(1)])
    }
}

/// The weights of the slopes before each stage; the last stage is the step's end.
const STAGES: [[f64; 6]; 6] = [
    [1.0 / 5.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
    [19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0, 0.0, 0.0],
    [9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0, 0.0],
    [35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
];
/// The weights of the end, less those of the embedded method of the fourth order.
const ERROR: [f64; 7] =
    [71.0 / 57600.0, 0.0, -71.0 / 16695.0, 71.0 / 1920.0, -17253.0 / 339_200.0, 22.0 / 525.0, -1.0 / 40.0];

/// The motion of a bead at one moment.
#[derive(Clone, Copy, Debug)]
struct State {
    at: DVec3,
    velocity: DVec3,
    acceleration: DVec3,
}

/// The motion during a step.
struct Piece {
    from: State,
    to: State,
    /// s
    start: f64,
    step: f64,
}

impl Piece {
    /// Place and velocity, by the polynomial of the fifth degree with both ends' places, velocities and accelerations.
    fn at(&self, time: f64) -> [DVec3; 2] {
        let (t, h) = (((time - self.start) / self.step).clamp(0.0, 1.0), self.step);
        let (from, to) = (&self.from, &self.to);
        // In powers of t: x + v h t + a h²/2 t² + c₃ t³ + c₄ t⁴ + c₅ t⁵.
        let (v, a) = (from.velocity * h, from.acceleration * (h * h / 2.0));
        let x = to.at - from.at - v - a;
        let slope = to.velocity * h - v - 2.0 * a;
        let bend = to.acceleration * (h * h) - 2.0 * a;
        let c3 = 10.0 * x - 4.0 * slope + 0.5 * bend;
        let c4 = -15.0 * x + 7.0 * slope - bend;
        let c5 = 6.0 * x - 3.0 * slope + 0.5 * bend;
        let place = from.at + t * (v + t * (a + t * (c3 + t * (c4 + t * c5))));
        let velocity = v + t * (2.0 * a + t * (3.0 * c3 + t * (4.0 * c4 + t * 5.0 * c5)));
        [place, velocity / h]
    }
}

impl Flight {
    fn push(&mut self, moment: Moment) {
        // A NaN is lost, and no distance.
        self.farthest = self.farthest.max(moment.at.distance(moment.wanted));
        self.moments.push(moment);
    }

    /// Adds the moments of a step up to a time (s), and ends the flight where the bead leaves the trap's surroundings.
    fn follow(&mut self, piece: &Piece, after: f64, every: f64, (wanted, reach): (DVec3, f64)) {
        let moment = |time: f64| {
            let [at, velocity] = piece.at(time);
            Moment { time, at, velocity, wanted }
        };
        let is_in = |time: f64| moment(time).at.distance(wanted) <= reach;
        let mut last = piece.start;
        loop {
            // The end of a turn belongs to it.
            let next = every * self.moments.len() as f64;
            let is_row = next <= after + SHORTEST * every;
            let time = if next >= after - SHORTEST * every { after } else { next };
            if !is_in(time) {
                let (mut near, mut far) = (last, time);
                for _ in 0..HALVINGS {
                    let middle = f64::midpoint(near, far);
                    *(if is_in(middle) { &mut near } else { &mut far }) = middle;
                }
                self.push(moment(far));
                self.is_lost = true;
                return;
            }
            if !is_row {
                return;
            }
            self.push(moment(time));
            last = time;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_have_an_even_rate_in_fields_of_any_span() {
        let (levitation, node) = crate::force::tests::standing_wave();
        let drag = Drag::new(&levitation.sphere, 1.8e-5, 1.2);
        let (fields, wanted) = ([levitation.clone(), levitation], [node; 2]);
        let from = node + DVec3::new(1e-4, 0.0, 2e-4);
        let carriage = Carriage { fields: &fields, wanted: &wanted, span: f64::INFINITY, drag };
        let period = TAU * carriage.scale(from);
        for span in [0.01, 0.6, 1.7].map(|part| part * period).into_iter().chain([f64::INFINITY]) {
            let carriage = Carriage { span, ..carriage };
            let seconds = 5.3 * period;
            let flight = carriage.fly(from, seconds, &Gauge::default());
            let times: Vec<_> = flight.moments.iter().map(|moment| moment.time).collect();
            let every = times[1];
            assert!(!flight.is_lost && every <= period / A_PERIOD * (1.0 + 1e-9), "{span}: {every} s");
            let (last, rows) = times.split_last().unwrap();
            assert_eq!(*last, seconds);
            let is_even = |(row, time): (usize, &f64)| (time - every * row as f64).abs() < 1e-9 * every;
            assert!(rows.iter().enumerate().all(is_even), "{span}: {rows:?}");
        }
    }
}
