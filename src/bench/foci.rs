//! Sets of foci for measurements of solvers: helices, random sets, and a disc.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::scene::Focus;

/// Radius of helices, m.
pub const RADIUS: f64 = 0.03;

/// One turn of a helix of height `rise` (m) about z = 0.15 m; a ring if that is 0.
pub fn helix(count: usize, rise: f64) -> Vec<Focus> {
    let focus = |i: usize| {
        let part = i as f64 / count as f64;
        let (sin, cos) = (TAU * part).sin_cos();
        let z = 0.15 + rise * (part - 0.5);
        Focus::new(DVec3::new(RADIUS * cos, RADIUS * sin, z), 1.0)
    };
    (0..count).map(focus).collect()
}

/// Random foci in a square of 10 cm, from z = 0.1 m to `depth` (m) above, at least a wavelength apart.
pub fn random(count: usize, depth: f64, seed: u64) -> Vec<Focus> {
    // SplitMix64 (Steele, Lea and Flood, 2014).
    let mut state = seed.wrapping_mul(0x1234_5678_9abc_def1);
    let mut unit = || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut foci: Vec<Focus> = Vec::new();
    while foci.len() < count {
        let position = DVec3::new(0.1 * unit() - 0.05, 0.1 * unit() - 0.05, 0.1 + depth * unit());
        if foci.iter().all(|other| other.position.distance(position) > 0.0085) {
            foci.push(Focus::new(position, 1.0));
        }
    }
    foci
}

/// Foci spread evenly over a disc of radius 5 cm at z = 0.1 m, along a sunflower spiral.
pub fn disc(count: usize) -> Vec<Focus> {
    let focus = |i: usize| {
        let (sin, cos) = (2.4 * i as f64).sin_cos();
        let radius = 0.05 * (i as f64 / count as f64).sqrt();
        Focus::new(DVec3::new(radius * cos, radius * sin, 0.1), 1.0)
    };
    (0..count).map(focus).collect()
}
