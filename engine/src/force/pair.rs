//! The force between beads: each is in the sound that the others scatter (secondary Bjerknes force).
//!
//! Scattered waves go back and forth between the beads; few rounds suffice, since each is fainter by s_n h_n(kd).

use glam::DVec3;
use num_complex::Complex64;

use crate::acoustics::PartialWaves;
use crate::force::Levitation;

/// Rounds of scattering.
const ROUNDS: usize = 4;

impl Levitation {
    /// The forces (N) of all other beads on each of equal beads at these places (m); `None` if two of them overlap.
    pub fn between(&self, places: &[DVec3]) -> Option<Vec<DVec3>> {
        let diameter = 2.0 * self.sphere.radius;
        let overlap = |i: usize| places[..i].iter().any(|other| other.distance(places[i]) < diameter);
        if (0..places.len()).any(overlap) {
            return None;
        }
        let mut forces = vec![DVec3::ZERO; places.len()];
        for drive in 0..self.drives.len() {
            let alone: Vec<_> =
                places.iter().map(|&at| self.waves_of(drive, self.sphere.order(), at)).collect();
            let mut together = alone.clone();
            for _ in 0..ROUNDS {
                together = (0..places.len()).map(|i| self.beside(&alone[i], places, &together, i)).collect();
            }
            for (force, (alone, together)) in forces.iter_mut().zip(alone.iter().zip(&together)) {
                *force += (self.sphere.force(together) - self.sphere.force(alone)) / self.drives.len() as f64;
            }
        }
        Some(forces)
    }

    /// The partial waves about one bead, of the incident sound and of what the others scatter.
    fn beside(
        &self,
        alone: &PartialWaves,
        places: &[DVec3],
        all: &[PartialWaves],
        own: usize,
    ) -> PartialWaves {
        let others = || places.iter().zip(all).enumerate().filter(|(i, _)| *i != own).map(|(_, other)| other);
        let pressure = |at: &DVec3| -> Complex64 {
            others().map(|(place, waves)| waves.outgoing(self.sphere.scattered(), *at - *place)).sum()
        };
        let shell = (places[own], self.sphere.shell());
        let mut waves = PartialWaves::new(alone.order(), alone.wavenumber(), shell, |points| {
            points.iter().map(pressure).collect()
        });
        waves.add(alone, 1.0);
        waves
    }
}
