//! Stability of a bead in a trap: equilibrium, stiffness and capture range.

use glam::DVec3;

use crate::force::{Levitation, Mode, modes};

/// Directions of escape: along the scene's axes.
pub const WAYS: [DVec3; 6] = [DVec3::NEG_X, DVec3::X, DVec3::NEG_Y, DVec3::Y, DVec3::NEG_Z, DVec3::Z];
/// Search range for the equilibrium, in wavelengths from the trap.
const REACH: f64 = 1.0;
/// Steps in a wavelength along a way.
const STEPS: usize = 24;
/// Bisection steps for the end of the capture range.
const HALVINGS: usize = 10;
/// Newton's steps, at most, and the wavelengths that one goes at most and at least.
const ROUNDS: usize = 60;
const LONGEST: f64 = 1.0 / 12.0;
const SHORTEST: f64 = 1e-9;

/// The behaviour of a bead released at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hold {
    /// m, where it is put.
    pub at: DVec3,
    /// Equilibrium position, or the release point without one; m.
    pub rest: DVec3,
    /// Principal stiffnesses at `rest`, smallest first.
    pub modes: [Mode; 3],
    /// The largest force upwards on the vertical through `at`, within a wavelength, over the weight less buoyancy.
    pub lift: f64,
    /// Escapes from `rest` along [`WAYS`]; zero without an equilibrium.
    pub escapes: [Escape; 6],
    pub outcome: Outcome,
}

/// The restoring force on a bead displaced along a direction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Escape {
    /// Distance (m) at which force and weight together stop restoring the bead; infinite beyond a wavelength.
    pub distance: f64,
    /// Largest restoring force (N) on the way there.
    pub force: f64,
}

/// The outcome for a bead: it holds, or the reason why not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outcome {
    Holds,
    /// The force nowhere carries the weight.
    TooHeavy,
    /// The bead is driven away along the mode of smallest stiffness.
    Unstable,
    /// The forces lead the bead more than a wavelength away.
    Leaves,
}

impl Hold {
    pub fn holds(&self) -> bool {
        self.outcome == Outcome::Holds
    }

    /// Sag of the equilibrium below the trap, m.
    pub fn sag(&self) -> f64 {
        self.at.z - self.rest.z
    }

    /// The least of the ways out.
    pub fn nearest_escape(&self) -> (DVec3, Escape) {
        let ways = WAYS.into_iter().zip(self.escapes);
        ways.min_by(|(_, a), (_, b)| a.distance.total_cmp(&b.distance)).unwrap_or_default()
    }
}

impl Levitation {
    /// The behaviour of a bead released at a point, m.
    pub fn hold(&self, at: DVec3) -> Hold {
        let rest = self.rest(at);
        let place = rest.unwrap_or(at);
        let modes = modes(&self.forces(place).symmetric());
        let lift = self.lift(at);
        let outcome = match rest {
            Some(_) if modes[0].stiffness > 0.0 => Outcome::Holds,
            _ if lift < 1.0 => Outcome::TooHeavy,
            _ if modes[0].stiffness <= 0.0 => Outcome::Unstable,
            _ => Outcome::Leaves,
        };
        let escapes = match outcome {
            Outcome::Holds => WAYS.map(|way| self.escape(place, way)),
            Outcome::TooHeavy | Outcome::Unstable | Outcome::Leaves => [Escape::default(); 6],
        };
        Hold { at, rest: place, modes, lift, escapes, outcome }
    }

    /// The equilibrium of force and weight near a point, by Newton's steps; where the bead is pushed away, in the direction of
    /// the force, with absolute stiffnesses.
    fn rest(&self, at: DVec3) -> Option<DVec3> {
        let mut place = at;
        for _ in 0..ROUNDS {
            let forces = self.forces(place);
            let net = forces.force - DVec3::Z * self.load;
            let modes = modes(&forces.symmetric());
            let stiffest = modes.iter().map(|mode| mode.stiffness.abs()).fold(f64::MIN_POSITIVE, f64::max);
            let along = |mode: &Mode| {
                mode.direction * (mode.direction.dot(net) / mode.stiffness.abs().max(1e-6 * stiffest))
            };
            // Where the bead is held, also against the part of the stiffness that drives it around.
            let step: DVec3 = match modes[0].stiffness > 0.0 {
                true => forces.stiffness.inverse() * net,
                false => modes.iter().map(along).sum(),
            };
            if !step.is_finite() {
                return None;
            }
            if step.length() < SHORTEST * self.wavelength {
                return Some(place);
            }
            place += step.clamp_length_max(LONGEST * self.wavelength);
            if place.distance(at) > REACH * self.wavelength {
                return None;
            }
        }
        None
    }

    fn lift(&self, at: DVec3) -> f64 {
        let step = 2.0 * REACH * self.wavelength / STEPS as f64;
        let up = |i: usize| self.force(at + DVec3::Z * (step * (i as f64 - STEPS as f64 / 2.0))).z;
        let most = (0..=STEPS).map(up).fold(f64::NEG_INFINITY, f64::max);
        if self.load > 0.0 { most / self.load } else { f64::INFINITY }
    }

    fn escape(&self, rest: DVec3, way: DVec3) -> Escape {
        let back = |distance: f64| -self.net(rest + way * distance).dot(way);
        let step = REACH * self.wavelength / STEPS as f64;
        let (mut force, mut before): (f64, _) = (0.0, [0.0; 2]);
        for i in 1..=STEPS {
            let here = back(step * i as f64);
            if here.is_nan() {
                // A body stops it.
                break;
            }
            if here <= 0.0 {
                force = force.max(crest(before[0], before[1], here));
                let (mut near, mut far) = (step * (i - 1) as f64, step * i as f64);
                for _ in 0..HALVINGS {
                    let middle = f64::midpoint(near, far);
                    let here = back(middle);
                    if here > 0.0 { near = middle } else { far = middle }
                }
                return Escape { distance: near, force };
            }
            force = force.max(crest(before[0], before[1], here));
            before = [before[1], here];
        }
        Escape { distance: f64::INFINITY, force }
    }
}

/// The maximum of the parabola through three equidistant values.
fn crest(before: f64, middle: f64, after: f64) -> f64 {
    let (rise, bend) = (0.5 * (after - before), before - 2.0 * middle + after);
    if middle >= before && middle >= after && bend < 0.0 {
        middle - rise * rise / (2.0 * bend)
    } else {
        middle.max(after)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lift_is_the_largest_force_upwards_within_a_wavelength_over_the_weight() {
        let (levitation, node) = crate::force::tests::standing_wave();
        let wavelength = levitation.wavelength;
        // At a node, where the force downwards is largest, and with the upper board almost a wavelength above.
        let places = [node.z, node.z + wavelength / 8.0, 0.08 - 1.05 * wavelength];
        for at in places.map(|z| node.with_z(z)) {
            let up = |i: i32| levitation.force(at + DVec3::Z * (wavelength * f64::from(i) / 500.0)).z;
            let most = (-500..=500).map(up).fold(f64::NEG_INFINITY, f64::max) / levitation.load;
            let lift = levitation.lift(at);
            assert!(lift > 0.75 * most && lift < 1.01 * most, "{at}: {lift}, not {most}");
        }
    }

    #[test]
    fn force_and_weight_balance_at_rest() {
        let (levitation, node) = crate::force::tests::standing_wave();
        for part in [0.0, 0.03, -0.05, 0.08] {
            let at = node + DVec3::new(part, 0.5 * part, 0.3 * part) * levitation.wavelength;
            let hold = levitation.hold(at);
            assert!(hold.holds() && hold.sag() > -0.1 * levitation.wavelength, "{hold:?}");
            let stiffest = hold.modes[2].stiffness;
            let net = levitation.net(hold.rest).length();
            let off = net / (stiffest * levitation.wavelength);
            assert!(off < SHORTEST, "{part}: {off:e} wavelengths at the stiffest mode");
        }
    }
}
