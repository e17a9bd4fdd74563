//! The requirements of a drawing beside its foci: areas, and the quiet region around them.

use std::collections::BTreeMap;

use glam::{DMat3, DVec3};

use crate::scene::{self, Amplitudes, Board, Cover, Focus, Liquid, Part, Plane, Scene, outline};

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
    /// Whether amplitudes are found beside phases.
    pub amplitudes: Amplitudes,
}

impl Surroundings {
    /// The surroundings of a drawing without zones and areas.
    pub fn of_plane(plane: Plane, quiet: f64) -> Self {
        let amplitudes = Amplitudes::Uniform;
        Self { plane, quiet, zones: Vec::new(), areas: Vec::new(), liquid: None, amplitudes }
    }

    /// The surroundings of a scene: its plane if these foci lie on it and, for strokes, it is across the beam; otherwise
    /// the plane through them parallel to the first board, since a plane along a beam cannot be quiet.
    pub fn new(scene: &Scene, foci: &[Focus]) -> Self {
        /// Wavelengths from one sample of a zone to the next.
        const SPACING: f64 = 0.4;
        /// Tolerated distance of foci from a plane, in wavelengths.
        const NEAR: f64 = 0.5;
        /// Cosine of the steepest plane that counts as across the beam, 40° from the board.
        const STEEPEST: f64 = 0.766;
        let board = scene.boards.first().and_then(Board::axes).unwrap_or(DMat3::IDENTITY);
        let normal = scene.plane.axes().map_or(DVec3::Z, |(x, y)| x.cross(y));
        let is_across = normal.dot(board.z_axis).abs() >= STEEPEST || foci.iter().any(Focus::is_of_area);
        let height = |focus: &Focus| (focus.position - scene.plane.centre).dot(normal).abs();
        let is_drawn_on = foci.iter().map(height).fold(0.0, f64::max) <= NEAR * scene.wavelength();
        let plane = if is_across && is_drawn_on {
            scene.plane.clone()
        } else {
            let centre = foci.iter().map(|focus| focus.position).sum::<DVec3>() / foci.len() as f64;
            Plane { centre, x_axis: board.x_axis, y_axis: board.y_axis, ..scene.plane.clone() }
        };
        let points = |zone: &scene::Zone| zone.points(SPACING * scene.wavelength());
        let zones = scene.quiet.iter().map(|zone| Zone { points: points(zone), weight: zone.weight });
        Self {
            plane,
            quiet: scene.solver.quiet,
            zones: zones.collect(),
            areas: areas(scene, foci),
            liquid: scene.aims_at_depression().then(|| scene.liquid.clone()),
            amplitudes: scene.solver.amplitudes,
        }
    }
}

/// The plane of a scene on which the side lobe of these foci is looked for: that of a drawing's [`Surroundings`], and the
/// scene's plane for separate foci.
pub fn judged_plane(scene: &Scene, foci: &[Focus]) -> Plane {
    if foci.iter().all(Focus::is_separate) {
        scene.plane.clone()
    } else {
        Surroundings::new(scene, foci).plane
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
    /// Factor on |p| there; 0 excludes the zone.
    pub weight: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scenes_plane_is_quiet_if_all_foci_are_within_half_a_wavelength() {
        let mut scene = Scene::default();
        scene.plane.centre = DVec3::new(0.02, 0.01, 0.15);
        scene.plane.x_axis = DVec3::new(1.0, 0.0, 0.3);
        let (x, y) = scene.plane.axes().unwrap();
        for (away, is_near) in [(0.0, true), (0.45, true), (-0.45, true), (0.55, false), (-3.0, false)] {
            let at = |along: f64, away: f64| {
                scene.plane.centre + x * along + x.cross(y) * (away * scene.wavelength())
            };
            let foci = [at(-0.03, 0.0), at(0.05, away)].map(|position| Focus::new(position, 1.0));
            let plane = Surroundings::new(&scene, &foci).plane;
            if is_near {
                assert_eq!(plane, scene.plane, "{away} wavelengths");
            } else {
                let middle = foci[0].position.midpoint(foci[1].position);
                assert!(plane.centre.distance(middle) < 1e-12, "{away} wavelengths: {plane:?}");
                assert_eq!([plane.x_axis, plane.y_axis], [DVec3::X, DVec3::Y], "{away} wavelengths");
            }
        }
    }

    #[test]
    fn strokes_along_the_beam_are_judged_across_it() {
        let place = DVec3::new(0.01, 0.0, 0.13);
        let plane_of = |steep: f64, part: Part| {
            let mut scene = Scene::default();
            let (sin, cos) = steep.to_radians().sin_cos();
            (scene.plane.centre, scene.plane.y_axis) = (place, DVec3::new(0.0, cos, sin));
            let foci = [-0.02, 0.02].map(|x| Focus { part, ..Focus::new(place + DVec3::X * x, 1.0) });
            (Surroundings::new(&scene, &foci).plane, scene.plane)
        };
        for steep in [30.0, 60.0, 90.0] {
            let (plane, own) = plane_of(steep, Part::Stroke);
            let flat = Plane { centre: place, x_axis: DVec3::X, y_axis: DVec3::Y, ..own.clone() };
            assert!(plane.centre.distance(place) < 1e-12, "{steep}: {plane:?}");
            let expected = if steep < 40.0 { own } else { flat };
            assert_eq!([plane.x_axis, plane.y_axis], [expected.x_axis, expected.y_axis], "{steep}");
        }
        let (plane, own) = plane_of(90.0, Part::Area(0));
        assert_eq!(plane, own);
    }
}
