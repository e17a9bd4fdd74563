//! The quiet region: samples of the scene's plane as far as the array radiates, and of zones, except the targets.

use glam::{DVec2, DVec3};

use crate::acoustics::{Aperture, Clearance};
use crate::scene::{Focus, Plane};
use crate::solver::problem::Problem;
use crate::solver::shape::Zone;
use crate::solver::shape::grid::{Grid, Layout};
use crate::solver::shape::objective::Quiet;
use crate::solver::shape::real::Real;
use crate::solver::shape::samples::Samples;
use crate::solver::shape::table::{BLOCK, Table};

/// Distances from the drawing, in wavelengths, within which the mask is 0, and beyond which it is 1.
const DRAWN: f64 = 0.58;
const ELSEWHERE: f64 = 0.82;
/// Values of a table at most, and samples of a plane in one.
const MOST_VALUES: usize = 16 << 20;
const MOST_SAMPLES: usize = 10_000;
/// Points with transfers computed at once.
const CHUNK: usize = 256;

/// Samples of a plane.
#[derive(Debug)]
pub enum Area {
    Grid(Layout),
    Points(Vec<DVec3>),
}

impl Area {
    /// `None` if the array's field is zero there. Finer samples are for the last steps.
    pub fn new(problem: &Problem<'_>, plane: &Plane, finer: bool) -> Option<Self> {
        let (x, y) = plane.axes()?;
        let aperture = problem.aperture;
        let is_parallel = is_parallel(plane, aperture);
        if is_parallel && plane.centre.z <= 0.0 {
            return None;
        }
        if is_parallel {
            let height = plane.centre.z;
            let reach = reach(problem, height);
            let grids = grids(aperture, height) + usize::from(finer);
            if reach.max_element() < 1e4 * aperture.pitch {
                let layout = Layout::new(aperture, height, reach, grids);
                if layout.area() <= 64 * aperture.positions.len() + (1 << 16) {
                    return Some(Self::Grid(layout));
                }
            }
        }
        let middle =
            problem.foci.iter().map(|focus| focus.position).sum::<DVec3>() / problem.foci.len() as f64;
        let normal = x.cross(y);
        let on_plane = middle - normal * normal.dot(middle - plane.centre);
        let drawn = problem.foci.iter().map(|focus| focus.position.distance(middle)).fold(0.0, f64::max);
        let away = aperture.boards().map(|board| board.pose.local(on_plane).length());
        let distance = away.fold(f64::INFINITY, f64::min).max(aperture.reach().length());
        let half = slope(aperture) * distance + 0.6 * drawn;
        let most = (MOST_VALUES / aperture.driven.len().max(1)).clamp(64, MOST_SAMPLES) as f64;
        let along = (2.0 * half / spacing(aperture, distance)).min(most.sqrt() - 1.0).ceil().max(1.0);
        let step = 2.0 * half / along;
        // The field next to an element is dominated by it.
        let clearance = Clearance::new(aperture);
        let heights = problem.foci.iter().map(|focus| clearance.at(focus.position));
        let nearest = heights.fold(f64::INFINITY, f64::min);
        let lowest = (2.0 * aperture.wavelength()).min(0.5 * nearest).max(0.0);
        let along = along as i64;
        let point = |i: i64, j: i64| on_plane + x * (i as f64 * step - half) + y * (j as f64 * step - half);
        let points = (0..=along).flat_map(|j| (0..=along).map(move |i| point(i, j)));
        let points: Vec<_> = points.filter(|&point| clearance.at(point) > lowest).collect();
        (!points.is_empty()).then_some(Self::Points(points))
    }
}

/// Whether samples of a plane can be a grid.
pub fn is_parallel(plane: &Plane, aperture: &Aperture) -> bool {
    let is_level = plane.axes().is_some_and(|(x, y)| x.cross(y).truncate().length() < 1e-9);
    is_level && aperture.lattice().is_some()
}

/// Distance (m) from the axis to which the array radiates on a parallel plane.
pub fn reach(problem: &Problem<'_>, height: f64) -> DVec2 {
    let far = |far: DVec2, focus: &Focus| far.max(focus.position.truncate().abs());
    let farthest = problem.foci.iter().fold(DVec2::ZERO, far);
    // For a drawing far from the axis, side lobes extend farther on its side and less on the opposite side.
    (slope(problem.aperture) * height + 0.6 * farthest).max(problem.aperture.reach())
}

/// Samples of a parallel plane in a pitch: the coarsest that miss no side lobe.
pub fn grids(aperture: &Aperture, height: f64) -> usize {
    (aperture.pitch / spacing(aperture, height)).ceil().clamp(1.0, 16.0) as usize
}

/// The lateral extent of radiation at a height of 1: to the first grating lobe, if that is at 37 to 58°.
fn slope(aperture: &Aperture) -> f64 {
    let sin = (aperture.wavelength() / aperture.pitch).clamp(0.6, 0.85);
    sin / (1.0 - sin * sin).sqrt()
}

/// Spacing (m) of samples that misses no side lobe at a distance (m): half a fringe of the outermost elements.
fn spacing(aperture: &Aperture, distance: f64) -> f64 {
    let (corner, wavelength) = (aperture.reach().max_element(), aperture.wavelength());
    let sines = 2.0 * corner / corner.hypot(distance);
    (0.51 * wavelength / sines.max(1e-6)).max(0.31 * wavelength)
}

/// Samples of a plane; `None` if no part of it is to be quiet.
pub fn on_plane<T: Real>(problem: &Problem<'_>, plane: &Plane, finer: bool, scale: f64) -> Option<Quiet<T>> {
    match Area::new(problem, plane, finer)? {
        Area::Grid(layout) => {
            let aperture = problem.aperture;
            let mask = mask(&layout, aperture, &problem.foci);
            let is_somewhere = mask.iter().any(|&part| part > T::default());
            let grid = || Samples::Grid(Box::new(Grid::new(aperture, layout, scale)));
            is_somewhere.then(|| Quiet::new(grid(), mask))
        }
        Area::Points(points) => scattered(problem, points.into_iter().map(|point| (point, scale))),
    }
}

/// Samples of zones, times their weights; `None` if no part of them is to be quiet.
pub fn in_zones<T: Real>(problem: &Problem<'_>, zones: &[Zone], scale: f64) -> Option<Quiet<T>> {
    let heard = zones.iter().filter(|zone| zone.weight > 0.0 && zone.weight.is_finite());
    let points = heard.flat_map(|zone| zone.points.iter().map(|&point| (point, zone.weight * scale)));
    let clearance = Clearance::new(problem.aperture);
    scattered(problem, points.filter(|(point, _)| clearance.at(*point) > 0.0))
}

/// A table of points with the scale of each, without drawn points and points with zero field.
fn scattered<T: Real>(problem: &Problem<'_>, points: impl Iterator<Item = (DVec3, f64)>) -> Option<Quiet<T>> {
    let aperture = problem.aperture;
    let points: Vec<_> = points.collect();
    let most = (MOST_VALUES / aperture.driven.len().next_multiple_of(BLOCK)).max(64);
    let every = points.len().div_ceil(most).max(1);
    let kept = |(point, scale): (DVec3, f64)| {
        let part = part(distance(point, &problem.foci), aperture.wavelength());
        (part > 0.0).then_some((point, scale, part))
    };
    let kept: Vec<_> = points.into_iter().step_by(every).filter_map(kept).collect();
    let mut table = Table::new(aperture.driven.len());
    let mut mask = Vec::new();
    for chunk in kept.chunks(CHUNK) {
        let transfer = aperture.transfer(&chunk.iter().map(|(point, ..)| *point).collect::<Vec<_>>());
        for (row, (_, scale, part)) in transfer.rows().zip(chunk) {
            if row.clone().any(|h| h.norm_sqr() > 0.0) {
                table.push(row, *scale);
                mask.push(T::of(*part));
            }
        }
    }
    (!mask.is_empty()).then(|| Quiet::new(Samples::Table(table), mask))
}

/// m, from a point to the nearest focus.
pub fn distance(point: DVec3, foci: &[Focus]) -> f64 {
    foci.iter().map(|focus| focus.position.distance_squared(point)).fold(f64::INFINITY, f64::min).sqrt()
}

/// The weight, 0 to 1, of a sample at a distance (m) from the drawing.
fn part(distance: f64, wavelength: f64) -> f64 {
    let t = ((distance / wavelength - DRAWN) / (ELSEWHERE - DRAWN)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// The weight of every sample of a plane, in the layout of a field.
pub fn mask<T: Real>(layout: &Layout, aperture: &Aperture, foci: &[Focus]) -> Vec<T> {
    let wavelength = aperture.wavelength();
    let mut mask = vec![T::default(); layout.len()];
    let distances = distances(layout, aperture.pitch, foci, ELSEWHERE * wavelength);
    for (index, _) in layout.places(aperture.pitch) {
        mask[index] = T::of(part(distances[index], wavelength));
    }
    mask
}

/// Distance (m) from every sample to the nearest focus, infinite beyond `farthest`; in the layout of a field.
pub fn distances(layout: &Layout, pitch: f64, foci: &[Focus], farthest: f64) -> Vec<f64> {
    let mut distances = vec![f64::INFINITY; layout.len()];
    for Focus { position, .. } in foci {
        if (position.z - layout.height).abs() < farthest {
            for (index, place) in layout.places_near(pitch, position.truncate(), farthest) {
                let distance = place.extend(layout.height).distance(*position);
                distances[index] = distances[index].min(distance);
            }
        }
    }
    distances
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Board, Scene};

    #[test]
    fn samples_of_tilted_planes_keep_away_from_elements_but_not_from_low_foci() {
        let aperture = Aperture::new(&Scene::default());
        for height in [0.012, 0.02, 0.03, 0.05] {
            let at = DVec3::new(0.0, 0.0, height);
            let problem = Problem::new(&aperture, vec![Focus::new(at, 1.0)]);
            let plane = Plane { centre: at, x_axis: DVec3::new(1.0, 0.0, 0.5), ..Plane::default() };
            let area = Area::new(&problem, &plane, false);
            let Some(Area::Points(points)) = area else { panic!("{height}: {area:?}") };
            let least =
                points.iter().map(|&point| Clearance::new(&aperture).at(point)).fold(f64::INFINITY, f64::min);
            let lowest = f64::min(2.0 * aperture.wavelength(), 0.5 * height);
            assert!(least > lowest && least < lowest + 4e-3, "{height}: {least}");
        }
    }

    #[test]
    fn where_the_drawing_covers_every_sample_nothing_is_to_be_quiet() {
        let is_heard = |pitch: f64| {
            let mut scene = Scene::default();
            (scene.array.rows, scene.array.columns, scene.array.pitch) = (1, 1, pitch);
            let aperture = Aperture::new(&scene);
            let at = DVec3::Z * 1e-3;
            let problem = Problem::new(&aperture, vec![Focus::new(at, 1.0)]);
            on_plane::<f32>(&problem, &Plane { centre: at, ..Plane::default() }, false, 1.0).is_some()
        };
        assert!(is_heard(5e-3) && !is_heard(0.3e-3));
    }

    #[test]
    fn points_in_front_of_one_board_and_behind_another_count() {
        let beside = Board { at: DVec3::X * 0.1, normal: -DVec3::Z, ..Board::default() };
        let mut scene = Scene { boards: vec![Board::default(), beside], ..Scene::default() };
        (scene.array.rows, scene.array.columns) = (2, 2);
        let aperture = Aperture::new(&scene);
        let problem = Problem::new(&aperture, vec![Focus::new(DVec3::Z * 0.1, 1.0)]);
        let points = vec![DVec3::new(0.05, 0.0, 0.1)];
        let silent = aperture.transfer(&points).row(0).filter(|h| h.norm() == 0.0).count();
        assert_eq!(silent, 4, "of 8 elements");
        assert!(in_zones::<f32>(&problem, &[Zone { points, weight: 1.0 }], 1.0).is_some());
    }
}
