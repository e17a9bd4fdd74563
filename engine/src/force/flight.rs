//! The motion of a bead under radiation force, weight and drag, with the added mass of the air.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use crate::force::{Levitation, Sphere, modes};
use crate::gauge::Gauge;

/// Steps in the shortest period of the bead: Runge and Kutta's are off by 5e-6 of it.
const STEPS: f64 = 40.0;
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
    /// In air of this viscosity (Pa·s) and density (kg/m³).
    pub fn new(sphere: &Sphere, viscosity: f64, density: f64) -> Self {
        let radius = (0.75 * sphere.volume / PI).cbrt();
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
    pub moments: Vec<Moment>,
    /// Largest distance from the trap, m.
    pub farthest: f64,
    /// It was more than a wavelength away; its later motion is unknown.
    pub is_lost: bool,
}

impl Carriage<'_> {
    /// Releases a bead at rest at a point (m), and follows it for some seconds, or until it is lost.
    ///
    /// # Panics
    /// No field, or different numbers of fields and positions.
    pub fn fly(&self, from: DVec3, seconds: f64, progress: &Gauge) -> Flight {
        assert!(!self.fields.is_empty() && self.fields.len() == self.wanted.len(), "a place for every field");
        let mut flight = Flight::default();
        let longest = self.step(from);
        let (mut at, mut velocity, mut time) = (from, DVec3::ZERO, 0.0);
        let mut turn = 0;
        flight.moments.push(Moment { time, at, velocity, wanted: self.wanted[0] });
        while time < seconds && !flight.is_lost {
            let index = turn % self.fields.len();
            let (field, wanted) = (&self.fields[index], self.wanted[index]);
            let end = (self.span * (turn + 1) as f64).min(seconds);
            let steps = ((end - time) / longest).ceil().max(1.0);
            let (start, step) = (time, (end - time) / steps);
            for done in 1..=steps as usize {
                (at, velocity) = self.advance(field, at, velocity, step);
                time = start + (end - start) * (done as f64 / steps);
                flight.moments.push(Moment { time, at, velocity, wanted });
                let away = at.distance(wanted);
                flight.farthest = flight.farthest.max(away);
                // A NaN position counts as lost.
                if away.is_nan() || away > LOST * field.wavelength {
                    flight.is_lost = true;
                    break;
                }
                progress.tell((1e3 * time / seconds) as usize, 1000);
            }
            turn += 1;
        }
        flight
    }

    /// kg
    fn inertia(&self) -> f64 {
        self.fields[0].sphere.inertia()
    }

    /// Time step (s): a fraction of the shortest period and of the drag's relaxation time.
    fn step(&self, from: DVec3) -> f64 {
        let places = self.wanted.iter().copied().zip(self.fields).chain([(from, &self.fields[0])]);
        let stiffest = places.fold(0.0f64, |most, (place, field)| {
            let modes = modes(&field.forces(place).symmetric());
            modes.iter().fold(most, |most, mode| most.max(mode.stiffness.abs()))
        });
        let period = TAU * (self.inertia() / stiffest.max(f64::MIN_POSITIVE)).sqrt();
        (period / STEPS).min(self.inertia() / self.drag.slow).min(self.span)
    }

    /// A step of Runge and Kutta's classical method.
    fn advance(&self, field: &Levitation, at: DVec3, velocity: DVec3, step: f64) -> (DVec3, DVec3) {
        let acceleration =
            |at: DVec3, velocity: DVec3| (field.net(at) + self.drag.force(velocity)) / self.inertia();
        let half = step / 2.0;
        let (v1, a1) = (velocity, acceleration(at, velocity));
        let (v2, a2) = (velocity + a1 * half, acceleration(at + v1 * half, velocity + a1 * half));
        let (v3, a3) = (velocity + a2 * half, acceleration(at + v2 * half, velocity + a2 * half));
        let (v4, a4) = (velocity + a3 * step, acceleration(at + v3 * step, velocity + a3 * step));
        let mean = |a: DVec3, b: DVec3, c: DVec3, d: DVec3| (a + 2.0 * (b + c) + d) / 6.0;
        (at + mean(v1, v2, v3, v4) * step, velocity + mean(a1, a2, a3, a4) * step)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_step_is_longer_than_the_bead_and_the_drag_allow() {
        let (levitation, node) = crate::force::tests::standing_wave();
        let drag = Drag::new(&levitation.sphere, 1.8e-5, 1.2);
        let (fields, wanted) = ([levitation], [node]);
        let from = node + DVec3::new(1e-4, 0.0, 2e-4);
        let carriage = Carriage { fields: &fields, wanted: &wanted, span: 1.0, drag };
        let longest = carriage.step(from);
        for part in [0.6, 1.0, 1.7, 2.5] {
            let carriage = Carriage { span: part * longest, ..carriage };
            let flight = carriage.fly(from, 10.0 * longest, &Gauge::default());
            let end = flight.moments[flight.moments.len() - 1].time;
            assert!(!flight.is_lost && (end / (10.0 * longest) - 1.0).abs() < 1e-9, "{part}: {end} s");
            let most = flight.moments.windows(2).map(|pair| pair[1].time - pair[0].time).fold(0.0, f64::max);
            assert!(most < longest * (1.0 + 1e-9), "{part}: {most} s, not {longest} s");
        }
    }
}
