//! The requirements of a drawing beside its foci: areas, and the quiet region around them.

use std::collections::BTreeMap;

use glam::DVec3;

use crate::scene::{self, Cover, Focus, Liquid, Part, Plane, Scene, outline};

/// Requirements outside the targets.
#[derive(Clone, Debug, PartialEq)]
pub struct Surroundings {
    /// The quiet plane: its centre and axes; its extent is the radiated region, independently of the displayed part.
    pub plane: Plane,
    /// 0, the strongest drive, to 1, the quietest.
    pub quiet: f64,
    pub zones: Vec<Zone>,
    /// Areas of the drawing; their samples are among the foci.
    pub areas: Vec<Cover>,
    /// The liquid with the prescribed depression, instead of |p|.
    pub liquid: Option<Liquid>,
}

impl Surroundings {
    /// Of a drawing without zones and areas.
    pub fn of_plane(plane: Plane, quiet: f64) -> Self {
        Self { plane, quiet, zones: Vec::new(), areas: Vec::new(), liquid: None }
    }

    /// The surroundings of a scene: its plane if these foci lie on it, otherwise a horizontal plane through them,
    /// since a plane across a drawing cannot be quiet.
    pub fn new(scene: &Scene, foci: &[Focus]) -> Self {
        /// Wavelengths from one sample of a zone to the next.
        const SPACING: f64 = 0.4;
        /// Tolerated distance of foci from a plane, in wavelengths.
        const NEAR: f64 = 0.5;
        let normal = scene.plane.axes().map_or(DVec3::Z, |(x, y)| x.cross(y));
        let height = |focus: &Focus| (focus.position - scene.plane.centre).dot(normal).abs();
        let is_drawn_on = foci.iter().map(height).fold(0.0, f64::max) <= NEAR * scene.wavelength();
        let plane = if is_drawn_on {
            scene.plane.clone()
        } else {
            let centre = foci.iter().map(|focus| focus.position).sum::<DVec3>() / foci.len() as f64;
            Plane { centre, x_axis: DVec3::X, y_axis: DVec3::Y, ..scene.plane.clone() }
        };
        let points = |zone: &scene::Zone| zone.points(SPACING * scene.wavelength());
        let zones = scene.quiet.iter().map(|zone| Zone { points: points(zone), weight: zone.weight });
        Self {
            plane,
            quiet: scene.solver.quiet,
            zones: zones.collect(),
            areas: areas(scene, foci),
            liquid: scene.aims_at_depression().then(|| scene.liquid.clone()),
        }
    }
}

/// The areas of a scene with samples among the foci, at their current position.
fn areas(scene: &Scene, foci: &[Focus]) -> Vec<Cover> {
    let is_first = |(place, focus): &(usize, &Focus)| {
        focus.is_of_area() && (*place == 0 || foci[place - 1].part != focus.part)
    };
    // Of every step, before anything moved.
    let mut still: BTreeMap<u32, Vec<Focus>> = BTreeMap::new();
    let moved = |(_, focus): (usize, &Focus)| {
        let Part::Area(index) = focus.part else { return None };
        let target = scene.targets.get(index)?;
        let mut cover = Cover::new(target, scene.wavelength()).ok()??;
        let step = target.step.unwrap_or(0);
        let still =
            still.entry(step).or_insert_with(|| outline::foci_of_step(scene, step).unwrap_or_default());
        let first = still.iter().find(|still| still.part == focus.part)?;
        cover.centre += focus.position - first.position;
        Some(cover)
    };
    foci.iter().enumerate().filter(is_first).filter_map(moved).collect()
}

/// Quiet points anywhere.
#[derive(Clone, Debug, PartialEq)]
pub struct Zone {
    /// m
    pub points: Vec<DVec3>,
    /// |p| there counts as so many times as loud; 0 for nothing.
    pub weight: f64,
}
