//! The elements of all boards with their images in reflectors.

use std::f64::consts::TAU;
use std::sync::Arc;

use glam::{DVec2, DVec3};

use crate::acoustics::air::Air;
use crate::acoustics::element::Element;
use crate::acoustics::face;
use crate::acoustics::face::{Face, Layout, Pose};
use crate::acoustics::scattering::Scattering;
use crate::scene::{Reflector, Scene};

/// The array as a radiator: boards of equal elements at known positions, the driven ones, and their images in
/// reflectors.
#[derive(Clone, Debug, PartialEq)]
pub struct Aperture {
    pub element: Element,
    /// m, of every element, board after board.
    pub positions: Vec<DVec3>,
    /// Unit vectors: the directions in which they radiate.
    pub normals: Vec<DVec3>,
    /// m, between neighbours.
    pub pitch: f64,
    /// Indices into `positions` of the driven elements, in ascending order.
    pub driven: Vec<usize>,
    /// The boards, and after them their images, the loudest first.
    pub faces: Vec<Face>,
    /// A bound on the sound of the reflections that a series leaves out, relative to the board's own sound.
    pub remainder: f64,
    /// The reflectors, behind which there is no sound.
    pub mirrors: Vec<Reflector>,
    /// The bodies that scatter its sound.
    #[doc(hidden)]
    pub bodies: Scattering,
}

impl Aperture {
    pub fn new(scene: &Scene) -> Self {
        let array = &scene.array;
        let air = Air::new(&scene.medium, array.frequency);
        let element = Element {
            model: array.element,
            wavenumber: TAU * array.frequency / air.sound_speed,
            radius: array.element_radius,
            size: array.element_size,
            exponent: array.element_exponent,
            measured: array.measured.series(),
            strength: array.strength,
            attenuation: air.attenuation,
        };
        let placed = array.places();
        let places = || placed.iter().map(|it| it.at).collect();
        let (layout, columns) = match array.file {
            Some(_) => (
                Layout {
                    normals: placed.iter().map(|it| it.normal).collect(),
                    asides: placed.iter().map(|it| face::aside(it.normal)).collect(),
                    ..flat(places())
                },
                None,
            ),
            None => (flat(places()), Some(array.columns as usize)),
        };
        let (layout, own) = Layout { columns, ..layout }.level();
        let (layout, standing) = (Arc::new(layout), scene.standing());
        let poses: Vec<_> = standing.iter().map(Pose::of).collect();
        let board = |(number, pose): (usize, &Pose)| {
            Face::board(pose.after(&own), Arc::clone(&layout), number * placed.len())
        };
        let mut faces: Vec<_> = poses.iter().enumerate().map(board).collect();
        let mirrors = scene.mirrors();
        let (images, remainder) = face::images(&faces, &mirrors, &standing, array.reflectivity);
        faces.extend(images);
        let all = || poses.iter().flat_map(|pose| placed.iter().map(move |it| (pose, it)));
        let bodies = Scattering::new(&scene.bodies, element, &faces, &mirrors);
        Self {
            element,
            positions: all().map(|(pose, it)| pose.world(it.at)).collect(),
            normals: all().map(|(pose, it)| pose.world_direction(it.normal)).collect(),
            pitch: array.pitch,
            driven: scene.driven(),
            faces,
            remainder,
            mirrors,
            bodies,
        }
    }

    /// The same elements at other positions in z = 0 (m), all driven, without reflectors.
    pub(crate) fn with_elements(&self, positions: Vec<DVec3>) -> Self {
        let layout = flat(positions.clone());
        Self {
            normals: vec![DVec3::Z; positions.len()],
            driven: (0..positions.len()).collect(),
            faces: vec![Face::board(Pose::HOME, Arc::new(layout), 0)],
            positions,
            remainder: 0.0,
            mirrors: Vec::new(),
            bodies: Scattering::default(),
            ..*self
        }
    }

    /// m
    pub fn wavelength(&self) -> f64 {
        TAU / self.element.wavenumber
    }

    /// The boards without their images.
    pub fn boards(&self) -> impl Iterator<Item = &Face> {
        self.faces.iter().take_while(|face| face.is_direct())
    }

    /// Columns and rows of the array, if it is a single flat board centred in z = 0 without reflections and bodies.
    pub fn lattice(&self) -> Option<[usize; 2]> {
        match &self.faces[..] {
            [face] if face.pose == Pose::HOME && self.bodies.is_empty() => {
                face.layout.columns.map(|columns| [columns, self.positions.len() / columns])
            }
            _ => None,
        }
    }

    /// The incident sound on a reflector, half of the total pressure there: sources on its sound side, without its
    /// own images, scaled by (1 + coefficient)/2.
    pub(crate) fn incident_on(&self, mirror: &Reflector) -> Self {
        let heard = self.faces.iter().filter(|face| mirror.height(face.pose.world(DVec3::ZERO)) > 0.0);
        let gain = f64::midpoint(1.0, mirror.coefficient);
        let faces: Vec<_> = heard.map(|face| Face { gain: gain * face.gain, ..face.clone() }).collect();
        let bodies = Scattering::new(self.bodies.of(), self.element, &faces, &self.mirrors);
        Self { faces, bodies, ..self.clone() }
    }

    /// m: the farthest element from the middle of its board, along x and along y of the board.
    pub fn reach(&self) -> DVec2 {
        let of_board = |board: &Face| {
            let (low, high) = board.corners();
            low.abs().max(high.abs())
        };
        self.boards().map(of_board).fold(DVec2::ZERO, DVec2::max)
    }

    /// The planes behind which some elements are silent: a point and the direction of radiation of each.
    pub(crate) fn walls(&self) -> Vec<(DVec3, DVec3)> {
        let of_face = |face: &Face| {
            let elements = if face.layout.is_flat() { 0..1 } else { 0..face.layout.positions.len() };
            let wall = |n: usize| {
                let at = if face.layout.is_flat() { DVec3::ZERO } else { face.layout.positions[n] };
                (face.pose.world(at), face.pose.world_direction(face.layout.normal(n)))
            };
            elements.map(wall).collect::<Vec<_>>()
        };
        self.faces.iter().flat_map(of_face).collect()
    }

    /// The box around the centres of a board's driven elements, in its own coordinates: its smallest and its largest
    /// corner, m. `None` without driven elements.
    pub fn extent(&self, board: &Face) -> Option<(DVec3, DVec3)> {
        let driven = &self.driven[board.among(&self.driven)];
        let places = driven.iter().map(|&n| board.layout.positions[n - board.first]);
        let grow = |(low, high): (DVec3, DVec3), at: DVec3| (low.min(at), high.max(at));
        (!driven.is_empty()).then(|| places.fold((DVec3::MAX, DVec3::MIN), grow))
    }

    /// The resolution (m) near a point: λ/(2 NA), NA the sine of half the angle subtended by the wider side of the
    /// widest board.
    pub fn resolution(&self) -> impl Fn(DVec3) -> f64 {
        let boards: Vec<_> =
            self.boards().filter_map(|board| Some((board.pose, self.extent(board)?))).collect();
        let wavelength = self.wavelength();
        move |point| {
            let widest = |(pose, (low, high)): &(Pose, (DVec3, DVec3))| {
                let point = pose.local(point);
                let half_angle = |low: f64, high: f64, x: f64| {
                    (((high - x) / point.z).atan() - ((low - x) / point.z).atan()) / 2.0
                };
                half_angle(low.x, high.x, point.x).max(half_angle(low.y, high.y, point.y)).sin()
            };
            let widest = boards.iter().map(widest).fold(1e-6, f64::max);
            wavelength / (2.0 * widest)
        }
    }
}

/// Elements of a board that all radiate along z.
fn flat(positions: Vec<DVec3>) -> Layout {
    Layout { positions, normals: Vec::new(), asides: Vec::new(), columns: None }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::acoustics::{clearance::Clearance, element};
    use crate::scene::{Array, Board, ElementModel, Elements, Placed};
    use num_complex::Complex64;

    #[test]
    fn elements_are_numbered_row_by_row_and_centred() {
        let array = Array { rows: 3, columns: 4, pitch: 0.01, ..Array::default() };
        let Aperture { positions, .. } = Aperture::new(&Scene { array, ..Scene::default() });
        assert_eq!(positions.len(), 12);
        assert!(positions[0].distance(DVec3::new(-0.015, -0.01, 0.0)) < 1e-15);
        assert!(positions[1].distance(DVec3::new(-0.005, -0.01, 0.0)) < 1e-15, "x runs fastest");
        assert!(positions[11].distance(DVec3::new(0.015, 0.01, 0.0)) < 1e-15);
    }

    #[test]
    fn elements_that_are_off_have_no_column() {
        let mut scene = Scene::default();
        scene.array.off = vec![3, 3, 255];
        let aperture = Aperture::new(&scene);
        assert_eq!(aperture.driven.len(), 254);
        assert!(!aperture.driven.contains(&3));
        let point = DVec3::new(0.0, 0.0, 0.1);
        assert_eq!(
            aperture.transfer(&[point]).at(0, 3),
            Aperture::new(&Scene::default()).transfer(&[point]).at(0, 4)
        );
    }

    #[test]
    fn a_point_in_the_plane_of_a_board_hears_it_as_one_just_above() {
        let mut scene =
            Scene { array: Array { rows: 4, columns: 4, ..Array::default() }, ..Scene::default() };
        for model in [ElementModel::Point, ElementModel::Piston] {
            scene.array.element = model;
            let aperture = Aperture::new(&scene);
            let at = |height: f64| {
                let point = DVec3::new(0.013, -0.022, height * element::NEAREST);
                aperture.pressures(&[point], &[Complex64::ONE; 16])[0]
            };
            let expected = at(1.0);
            for height in [0.5, 0.0, -0.5] {
                let off = (at(height) - expected).norm();
                assert!(off <= 1e-9 * expected.norm(), "{model:?} {height}: {}, not {expected}", at(height));
            }
        }
    }

    #[test]
    fn walls_touch_the_elements() {
        let placed = |at: DVec3| Placed { at, normal: (DVec3::Z * 0.1 - at).normalize_or_zero() };
        let bowl = [(-0.05, 0.02), (0.0, 0.0), (0.04, 0.015)].map(|(x, z)| placed(DVec3::new(x, 0.0, z)));
        let placed = Elements::new(bowl.to_vec(), None);
        let array = Array { placed, file: Some("bowl.csv".to_owned()), ..Array::default() };
        let curved = Aperture::new(&Scene { array, ..Scene::default() });
        let walls = curved.walls();
        assert_eq!(walls.len(), 3);
        for ((at, direction), (position, normal)) in
            walls.iter().zip(curved.positions.iter().zip(&curved.normals))
        {
            assert!(at.distance(*position) < 1e-12 && direction.distance(*normal) < 1e-12, "{at} {position}");
        }
        let flat = Aperture::new(&Scene::default());
        let [(at, direction)] = flat.walls()[..] else { panic!("{:?}", flat.walls()) };
        assert!(flat.positions.iter().all(|position| (position - at).dot(direction).abs() < 1e-12));
    }

    #[test]
    fn a_series_of_reflections_leaves_out_what_comes_after_the_last() {
        for (reflectivity, coefficient) in
            [(0.0, 1.0), (0.5, 1.0), (0.98, 1.0), (0.999, -0.999), (1.0, 0.9999)]
        {
            let array = Array { rows: 2, columns: 2, reflectivity, ..Array::default() };
            let reflectors = vec![Reflector { coefficient, ..Reflector::default() }];
            let aperture = Aperture::new(&Scene { array, reflectors, ..Scene::default() });
            let both: f64 = reflectivity * coefficient;
            let last = (aperture.faces.len() - 2) / 2;
            // A geometric series of sources, each farther away than the one before.
            let rest = both.abs().powi(last as i32 + 1) / (1.0 - both.abs()) / (2 * last + 3) as f64;
            let least = if last < 2000 { 0.0 } else { rest * (1.0 - 1e-9) };
            assert!(
                (least..=rest * (1.0 + 1e-9)).contains(&aperture.remainder),
                "{both}: {}",
                aperture.remainder
            );
            assert!(last == 2000 || rest < 1e-13, "{both}: {last}");
        }
    }

    #[test]
    fn elements_of_bowls_and_domes_are_silent_behind_themselves() {
        let at = |n: i32| DVec3::new(0.01 * f64::from(n % 3 - 1), 0.012 * f64::from(n / 3 - 1), 0.0);
        let points: Vec<_> = (0..48)
            .map(|i| DVec3::new(0.01 * f64::from(i % 4) - 0.015, 0.01 * f64::from(i / 4 % 4) - 0.015, 0.0))
            .zip([-0.002, 0.001, 0.004].into_iter().cycle())
            .map(|(point, z)| point.with_z(z))
            .collect();
        for bend in [10.0, -10.0] {
            let placed = |at: DVec3| Placed {
                at: at.with_z(bend * at.length_squared()),
                normal: (DVec3::Z - at * (4.0 * bend)).normalize_or_zero(),
            };
            let placed = Elements::new((0..9).map(|n| placed(at(n))).collect(), None);
            let array = Array { placed, file: Some("bowl.csv".to_owned()), ..Array::default() };
            let aperture = Aperture::new(&Scene { array, ..Scene::default() });
            let transfer = aperture.transfer(&points);
            let mut silent = 0;
            for (row, point) in points.iter().enumerate() {
                let elements = aperture.positions.iter().zip(&aperture.normals).zip(transfer.row(row));
                for ((position, normal), own) in elements {
                    let expected =
                        aperture.element.towards(*point - *position, *normal, face::aside(*normal));
                    let off = (own - expected).norm();
                    assert!(off <= 1e-9 * expected.norm(), "{point} of {position}: {own}, not {expected}");
                    silent += usize::from(expected == Complex64::ZERO);
                }
            }
            assert!((20..9 * points.len() - 20).contains(&silent), "{bend}: {silent}");
        }
    }

    #[test]
    fn images_are_no_boards() {
        let board = |z: f64| Board { at: DVec3::Z * z, ..Board::default() };
        let array = Array { rows: 2, columns: 2, ..Array::default() };
        let boards = vec![board(0.0), board(-0.1)];
        let reflectors =
            vec![Reflector { point: DVec3::Z * 0.2, normal: DVec3::NEG_Z, ..Reflector::default() }];
        let aperture = Aperture::new(&Scene { array, boards, reflectors, ..Scene::default() });
        assert_eq!((aperture.boards().count(), aperture.faces.len()), (2, 4));
        // Between the image of a board, at 0.4 m, and the boards.
        assert!((Clearance::new(&aperture).at(DVec3::Z * 0.15) - 0.15).abs() < 1e-12);
    }
}
