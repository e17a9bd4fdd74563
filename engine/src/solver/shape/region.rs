//! The quiet region: samples of the scene's plane as far as the array radiates, and of zones, except the targets.

use glam::{DVec2, DVec3};

use crate::acoustics::{Aperture, Clearance};
use crate::scene::{Focus, Plane};
use crate::solver::Problem;
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

/// How far from the axis a parallel plane is heard, m.
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
    fn the_mask_rises_between_the_drawing_and_elsewhere() {
        let at = |wavelengths: f64| part(wavelengths * 8e-3, 8e-3);
        let middle = f64::midpoint(DRAWN, ELSEWHERE);
        for (wavelengths, expected) in [(0.0, 0.0), (DRAWN, 0.0), (middle, 0.5), (ELSEWHERE, 1.0), (3.0, 1.0)]
        {
            let part = at(wavelengths);
            assert!((part - expected).abs() < 1e-12, "{wavelengths} wavelengths: {part}, not {expected}");
        }
        let rising: Vec<_> =
            (0..=20).map(|i| at(DRAWN + (ELSEWHERE - DRAWN) * f64::from(i) / 20.0)).collect();
        assert!(rising.is_sorted(), "{rising:?}");
    }

    #[test]
    fn the_grid_of_a_parallel_plane_extends_as_far_as_the_array_steers() {
        let aperture = Aperture::new(&Scene::default());
        for height in [0.05, 0.1, 0.2] {
            let at = DVec3::new(0.0, 0.0, height);
            let problem = Problem::new(&aperture, vec![Focus::new(at, 1.0)]);
            let area = Area::new(&problem, &Plane { centre: at, ..Plane::default() }, false);
            let Some(Area::Grid(layout)) = area else { panic!("{height}: {area:?}") };
            let reach = (slope(&aperture) * height).max(aperture.reach().max_element());
            let farthest = layout.places(aperture.pitch).map(|(_, place)| place.abs().max_element());
            let farthest = farthest.fold(0.0, f64::max);
            assert!(
                (reach..reach + 3.0 * aperture.pitch).contains(&farthest),
                "{height}: {farthest}, {reach}"
            );
        }
    }

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

    fn square(side: u32) -> Aperture {
        let mut scene = Scene::default();
        (scene.array.rows, scene.array.columns) = (side, side);
        Aperture::new(&scene)
    }

    #[test]
    fn planes_are_grids_up_to_a_size_that_grows_with_the_array() {
        // Small arrays get more than 64 values per element, and large ones more than 65536.
        for (side, usual) in [(2, 64 * 4), (17, 1 << 16)] {
            let aperture = square(side);
            let most = 64 * aperture.positions.len() + 65536;
            let (mut largest, mut smallest_beyond) = (0, usize::MAX);
            for height in (4..=22).map(|step| 0.05 * f64::from(step)) {
                let at = DVec3::Z * height;
                let problem = Problem::new(&aperture, vec![Focus::new(at, 1.0)]);
                let plane = Plane { centre: at, ..Plane::default() };
                match Area::new(&problem, &plane, false) {
                    Some(Area::Grid(layout)) => largest = largest.max(layout.area()),
                    Some(Area::Points(_)) => {
                        let reach = DVec2::splat(slope(&aperture) * height).max(aperture.reach());
                        let grids = (aperture.pitch / spacing(&aperture, height)).ceil() as usize;
                        let area = Layout::new(&aperture, height, reach, grids).area();
                        smallest_beyond = smallest_beyond.min(area);
                    }
                    None => panic!("{side}, {height}: no samples"),
                }
            }
            assert!(largest > usual && largest <= most, "{side}: {largest}");
            assert!(smallest_beyond > most && smallest_beyond < usize::MAX, "{side}: {smallest_beyond}");
        }
    }

    #[test]
    fn samples_of_tilted_planes_are_near_enough_for_every_side_lobe() {
        for (side, height) in [(2, 0.06), (4, 0.1), (8, 0.07), (16, 0.1)] {
            let aperture = square(side);
            let at = DVec3::Z * height;
            let problem = Problem::new(&aperture, vec![Focus::new(at, 1.0)]);
            let plane = Plane { centre: at, x_axis: DVec3::new(1.0, 0.0, 0.5), ..Plane::default() };
            let area = Area::new(&problem, &plane, false);
            let Some(Area::Points(points)) = area else { panic!("{side}: {area:?}") };
            let apart = points[0].distance(points[1]);
            let needed = spacing(&aperture, height.max(aperture.reach().length()));
            assert!(apart <= needed && apart > 0.9 * needed, "{side}, {height}: {apart} of {needed} m");
        }
    }

    #[test]
    fn zones_are_heard_beside_the_drawing_and_thinned_if_they_are_large() {
        let aperture = Aperture::new(&Scene::default());
        let (drawn, beside) = (DVec3::Z * 0.1, DVec3::new(0.05, 0.0, 0.1));
        let problem = Problem::new(&aperture, vec![Focus::new(drawn, 1.0)]);
        let is_heard =
            |points: Vec<DVec3>| in_zones::<f32>(&problem, &[Zone { points, weight: 1.0 }], 1.0).is_some();
        assert!(is_heard(vec![beside]) && is_heard(vec![drawn, beside]));
        assert!(!is_heard(vec![drawn; 2]) && !is_heard(Vec::new()));
        // Of more points than have room, every second counts.
        let most = MOST_VALUES / aperture.driven.len();
        let with = |count: usize, place: usize| {
            let mut points = vec![drawn; count];
            points[place] = beside;
            is_heard(points)
        };
        assert!(with(most, 1) && with(most, 2), "all of {most}");
        assert!(!with(most + 1, 1) && with(most + 1, 2), "every second of {most} and one");
    }

    #[test]
    fn grids_resolve_side_lobes_and_reach_farther_for_drawings_beside_the_axis() {
        for (side, height, x) in
            [(8, 0.1, 0.0), (8, 0.1, 0.2), (16, 0.1, 0.15), (16, 0.05, 0.0), (5, 0.07, 0.1)]
        {
            let aperture = square(side);
            let problem = Problem::new(&aperture, vec![Focus::new(DVec3::new(x, 0.0, height), 1.0)]);
            let plane = Plane { centre: DVec3::Z * height, ..Plane::default() };
            let area = Area::new(&problem, &plane, false);
            let Some(Area::Grid(layout)) = area else { panic!("{side}, {height}, {x}: {area:?}") };
            let (apart, most) = (layout.spacing(aperture.pitch), spacing(&aperture, height));
            assert!(apart <= most, "{side}, {height}: {apart} of {most} m");
            let farthest = layout.places(aperture.pitch).map(|(_, place)| place.x).fold(0.0, f64::max);
            let needed = slope(&aperture) * height + 0.6 * x;
            assert!(farthest >= needed, "{side}, {height}, {x}: {farthest} of {needed} m");
        }
    }

    #[test]
    fn samples_of_a_tilted_plane_are_a_square_around_the_foot_of_the_drawing() {
        let aperture = square(8);
        let foci = [(-0.02, 0.0), (0.04, 0.01)].map(|(x, y)| Focus::new(DVec3::new(x, y, 0.2), 1.0));
        let (middle, centre) = (DVec3::new(0.01, 0.005, 0.2), DVec3::new(0.05, 0.03, 0.15));
        let problem = Problem::new(&aperture, foci.to_vec());
        let plane = Plane { centre, x_axis: DVec3::new(1.0, 0.0, 0.2), ..Plane::default() };
        let area = Area::new(&problem, &plane, false);
        let Some(Area::Points(points)) = area else { panic!("{area:?}") };
        let spacing = points[0].distance(points[1]);
        let (x, y) = plane.axes().unwrap();
        let normal = x.cross(y);
        let foot = middle - normal * (middle - centre).dot(normal);
        let half = slope(&aperture) * foot.length() + 0.6 * foci[0].position.distance(middle);
        let along = (2.0 * half / spacing).round();
        assert_eq!(points.len(), (along as usize + 1).pow(2));
        for point in points {
            let away = point - foot;
            assert!(away.dot(normal).abs() < 1e-12, "{point} is beside the plane");
            for steps in [x, y].map(|axis| (away.dot(axis) + half) / spacing) {
                let is_on_grid = (steps - steps.round()).abs() < 1e-6 && (-0.5..along + 0.5).contains(&steps);
                assert!(is_on_grid, "{point} is at {steps} of {along}");
            }
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

    #[test]
    fn samples_of_a_wide_plane_are_as_many_as_have_room() {
        // 16 Mi values, or 10 000 samples.
        for (side, most) in [(4, 10_000), (64, 4096)] {
            let aperture = square(side);
            let foci = [-5.0, 5.0].map(|x| Focus::new(DVec3::new(x, x, 0.2), 1.0)).to_vec();
            let problem = Problem::new(&aperture, foci);
            let plane = Plane { centre: DVec3::Z * 0.2, ..Plane::default() };
            let area = Area::new(&problem, &plane, false);
            let Some(Area::Points(points)) = area else { panic!("{side}: a grid") };
            assert_eq!(points.len(), most, "{side}");
        }
    }
}
