//! The played drive and its pressures.

use std::collections::BTreeSet;
use std::f64::consts::FRAC_1_SQRT_2;
use std::sync::Arc;

use glam::DVec3;

use crate::acoustics::{Air, Aperture, Ensemble};
use crate::drive::Drive;
use crate::field::Quantity;
use crate::scene::{Bead, Focus, Scene, Spread, outline};
use crate::solver::frames::Sequence;
use crate::studio::probe::{self, Reading};
use crate::ui::map::Map;
use crate::ui::playback::{Moment, Playback};

/// The played drive and its pressures.
#[derive(Clone, Debug)]
pub struct Sound {
    pub aperture: Aperture,
    pub air: Air,
    pub bead: Bead,
    /// Differences between elements.
    pub spread: Spread,
    /// Drives in turn, at least one.
    pub drives: Vec<Drive>,
    /// The same behind the response of the elements.
    pub heard: Vec<Drive>,
    pub foci: Vec<Focus>,
    /// The readings at the foci.
    pub readings: Vec<Reading>,
}

impl Sound {
    /// The first drive in turn.
    pub fn drive(&self) -> &Drive {
        &self.drives[0]
    }

    /// The drives for the request of a map, which adds the response of drives in turn by itself.
    pub fn of_map(&self) -> &[Drive] {
        if self.heard.len() == 1 { &self.heard } else { &self.drives }
    }

    /// Whether its pressures are known within a frame: the answers of bodies are there.
    pub fn is_at_hand(&self) -> bool {
        let driven = &self.aperture.driven;
        let excitations = || self.heard.iter().flat_map(|drive| drive.excitation(driven)).collect::<Vec<_>>();
        self.aperture.bodies.is_empty() || self.aperture.knows(&excitations())
    }

    /// The values of a map at points of its plane, in f64; empty for quantities that depend on more than the points.
    pub fn values(&self, map: &Map, points: &[DVec3]) -> Vec<f64> {
        let axes = [map.axes.x, map.axes.y, map.axes.x.cross(map.axes.y)];
        probe::values(
            (&self.aperture, &self.air, &self.bead, self.spread),
            &self.heard,
            (map.quantity, map.phase),
            axes,
            points,
        )
    }

    /// 5 and 95 % of the RMS pressure (Pa) at points, of arrays with these differences between elements; `None` without
    /// any.
    pub fn band(&self, points: &[DVec3]) -> Option<Vec<[f64; 2]>> {
        // With bodies, every point takes the answers to all elements.
        if self.spread.is_none() || !self.aperture.bodies.is_empty() {
            return None;
        }
        let played: Vec<_> =
            self.drives.iter().flat_map(|drive| drive.excitation(&self.aperture.driven)).collect();
        let ensemble = Ensemble::new(&self.aperture.transfer(points), &played, self.spread);
        Some(ensemble.quantiles().map(|[low, _, high]| [low, high].map(|p| p * FRAC_1_SQRT_2)).collect())
    }

    pub fn value(&self, map: &Map, point: DVec3) -> Option<f64> {
        self.values(map, &[point]).first().copied()
    }
}

/// Whether a map of this quantity is of all frames of a motion.
pub fn is_of_all_frames(quantity: Quantity, playback: Playback) -> bool {
    match playback.moment.of(quantity) {
        Moment::Mean | Moment::Wave(_) => true,
        Moment::Rest | Moment::Frame(_) => false,
    }
}

/// The drives of a map of this quantity: the played ones, or all frames of the motion if they count together.
pub fn drives(
    cycle: Option<&Arc<Sequence>>,
    sound: Option<&Sound>,
    playback: Playback,
    quantity: Quantity,
) -> Vec<Drive> {
    match cycle {
        Some(cycle) if quantity.declaration().is_slow && is_of_all_frames(quantity, playback) => {
            cycle.frames.iter().map(|frame| frame.drive.clone()).collect()
        }
        // Requests of the skin add the response of elements by themselves.
        _ if quantity.declaration().of_skin => {
            sound.iter().flat_map(|sound| &sound.drives).cloned().collect()
        }
        _ => sound.iter().flat_map(|sound| sound.of_map()).cloned().collect(),
    }
}

/// The position of the relevant focus (m): of the selected target, or of the first focus.
pub fn focus(scene: &Scene, selection: &BTreeSet<usize>, sound: Option<&Sound>) -> Option<DVec3> {
    let of_selection = selection.first().and_then(|&index| scene.targets.get(index));
    of_selection
        .map(|target| outline::centre(&target.shape))
        .or_else(|| sound?.foci.iter().find(|focus| !focus.is_direction()).map(|focus| focus.position))
}
