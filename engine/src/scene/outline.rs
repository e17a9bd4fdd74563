//! From shapes and letters to focal points, evenly spaced along the outline including its corners.
//!
//! An outline is a set of strokes. Strokes are cut at their corners (ends, sharp turns, and junctions of strokes)
//! into [`run::Run`]s; every corner becomes one focal point, and the inside of a run is divided evenly by arc length.
//! A continuous stroke gets its samples the same way, as many as the wavelength requires, and an area those of its
//! [`Cover`].

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use crate::scene::check::MOST_FOCI;
use crate::scene::cover::Patch;
use crate::scene::focus::{Focus, Part};
use crate::scene::range::{Key, KeyError};
use crate::scene::run::{self, Run, Vertex};
use crate::scene::target::facing;
use crate::scene::target::{Sampling, Target};
use crate::scene::{content::Scene, cover::Cover, shape::Shape, stroke};

pub use crate::scene::stroke::strokes;

/// Samples of a continuous stroke in a wavelength, at least: |p|² has up to two cycles in one.
const PER_WAVELENGTH: f64 = 4.0;
/// Samples of an area in a wavelength.
const PER_WAVELENGTH_OF_AREA: f64 = 2.0;
/// Bisection steps for the spacing of continuous strokes beyond the limit.
const HALVINGS: u32 = 48;

/// Whether a visible target, in any step of the motion, is a continuous stroke or an area.
pub fn is_continuous(scene: &Scene) -> bool {
    let is_continuous = |target: &Target| target.sampling == Sampling::Continuous || target.is_area();
    scene.targets.iter().any(|target| target.visible && is_continuous(target))
}

/// The focal points of the scene at rest and the samples of its continuous strokes and areas, target by target in the order of
/// the file; of its first step, if it has several.
///
/// Samples are at most λ/4 apart along their stroke and λ/2 in an area, or coarser if needed for [`MOST_FOCI`] in
/// total.
///
/// # Errors
/// No visible targets, a missing glyph, more focal points than [`MOST_FOCI`], fewer points than corners, a focal
/// point on or behind the array, or an error of [`Cover::new`].
pub fn foci(scene: &Scene) -> Result<Vec<Focus>, KeyError> {
    foci_of_step(scene, 0)
}

/// The focal points of one step of the motion.
///
/// # Errors
/// The errors of [`foci`].
pub fn foci_of_step(scene: &Scene, step: u32) -> Result<Vec<Focus>, KeyError> {
    if scene.targets.is_empty() {
        return Err(KeyError::new([Key::from("target")], "the scene has no target: nothing to focus on"));
    }
    if scene.targets.iter().all(|target| !target.visible) {
        let message = "every target is hidden: nothing to focus on";
        return Err(KeyError::new([Key::from("target"), Key::from(0), Key::from("visible")], message));
    }
    let shown: Vec<_> = scene.targets.iter().enumerate().filter(|(_, target)| target.is_in(step)).collect();
    let foci = foci_of_targets(scene, &shown)?.concat();
    if foci.is_empty() {
        let message = format!("no target is shown in step {step}: nothing to focus on");
        return Err(KeyError::new([Key::from("target")], message));
    }
    on_surface(scene, &foci)?;
    on_skin(scene, &foci)?;
    Ok(foci)
}

/// The focal points of each of these targets, given with their indices in the scene, independently of the others.
pub(crate) fn foci_of_targets(
    scene: &Scene,
    shown: &[(usize, &Target)],
) -> Result<Vec<Vec<Focus>>, KeyError> {
    let wavelength = scene.wavelength();
    let mut divisions = divisions(shown)?;
    let covers = covers(shown, wavelength)?;
    let outlines: usize = divisions.iter().map(Division::count).sum();
    let has_strokes = divisions.iter().any(|it| it.target.sampling == Sampling::Continuous);
    let left = MOST_FOCI - outlines;
    let areas = patches(&covers, wavelength, if has_strokes { left.div_ceil(2) } else { left });
    let most = MOST_FOCI - areas.iter().map(|(_, patches)| patches.len()).sum::<usize>();
    spread(&mut divisions, wavelength / PER_WAVELENGTH, most);
    let (mut divisions, mut areas) = (divisions.into_iter(), areas.into_iter().peekable());
    let mut all = Vec::new();
    let front = scene.front();
    for &(index, target) in shown {
        let mut foci = Vec::new();
        if let Some((_, patches)) = areas.next_if(|(area, _)| *area == index) {
            foci.extend(patches.into_iter().map(|patch| Focus {
                position: patch.at,
                target: target.pressure * patch.brightness.sqrt(),
                part: Part::Area(index),
            }));
        } else if let Some((trap, charge)) = target.shape.trap() {
            divisions.next();
            let (at, turn) = (target.shape.centre(), target.turn());
            foci.extend(trap.lobes(charge, wavelength).into_iter().map(|lobe| Focus {
                position: at + turn * lobe.at,
                target: target.pressure,
                part: Part::Trap(index),
            }));
        } else if let Some(direction) = target.shape.direction() {
            divisions.next();
            if !scene.hears(direction) {
                let message = format!("no sound is radiated towards this direction: {}", front.ahead());
                return Err(KeyError::new(
                    [Key::from("target"), Key::from(index), Key::from("direction")],
                    message,
                ));
            }
            all.push(vec![Focus { position: direction, target: target.pressure, part: Part::Direction }]);
            continue;
        } else if let Some(division) = divisions.next() {
            let is_stroke = target.sampling == Sampling::Continuous;
            foci.extend(division.points().into_iter().map(|point| Focus {
                position: point.at,
                target: target.pressure * point.pressure,
                part: if is_stroke { Part::Stroke } else { Part::Point },
            }));
        }
        if let Some(behind) = foci.iter().find(|focus| !front.contains(focus.position)) {
            let [x, y, z] = behind.position.to_array();
            let message = format!("the focal point ({x}, {y}, {z}) lies {}", front.behind());
            return Err(KeyError::new([Key::from("target"), Key::from(index)], message));
        }
        all.push(foci);
    }
    directions_beside_points(scene, shown, &all)?;
    traps_beside_points(scene, &all)?;
    Ok(all)
}

/// Directions can only be combined with points and other separate foci.
fn directions_beside_points(
    scene: &Scene,
    shown: &[(usize, &Target)],
    foci: &[Vec<Focus>],
) -> Result<(), KeyError> {
    let Some((index, _)) = shown.iter().find(|(_, target)| target.shape.is_direction()) else {
        return Ok(());
    };
    let is_beside = |focus: &Focus| matches!(focus.part, Part::Point | Part::Direction);
    let is_plain = scene.quiet.is_empty()
        && !scene.solver.frames.are_several()
        && !scene.aims_at_depression()
        && !scene.aims_at_felt();
    if is_plain && foci.iter().flatten().all(is_beside) {
        return Ok(());
    }
    let message = "directions combine only with points and separate focal points: give strokes `points` or `spacing`, and \
                   remove areas, traps, `[[quiet]]`, `solver.frames` and `solver.target`";
    Err(KeyError::new([Key::from("target"), Key::from(*index), Key::from("kind")], message))
}

/// Traps can only be combined with separate foci.
fn traps_beside_points(scene: &Scene, foci: &[Vec<Focus>]) -> Result<(), KeyError> {
    let of_trap = |focus: &Focus| match focus.part {
        Part::Trap(index) => Some(index),
        Part::Point | Part::Stroke | Part::Area(_) | Part::Direction => None,
    };
    let Some(index) = foci.iter().flatten().find_map(of_trap) else { return Ok(()) };
    let is_alone = foci.iter().flatten().all(Focus::is_separate)
        && scene.quiet.is_empty()
        && !scene.solver.frames.are_several()
        && !scene.aims_at_depression();
    if is_alone {
        return Ok(());
    }
    let message = "traps combine only with points and separate focal points: give strokes `points` or `spacing`, and remove areas, \
                   `[[quiet]]`, `solver.frames` and `solver.target`";
    Err(KeyError::new([Key::from("target"), Key::from(index), Key::from("trap")], message))
}

/// A depression must be drawn on the liquid's surface.
fn on_surface(scene: &Scene, foci: &[Focus]) -> Result<(), KeyError> {
    /// Wavelengths.
    const NEAR: f64 = 0.1;
    let height = scene.plane.centre.z;
    let away = foci.iter().find(|focus| (focus.position.z - height).abs() > NEAR * scene.wavelength());
    let Some(away) = away.filter(|_| scene.aims_at_depression()) else { return Ok(()) };
    let message = format!(
        "a depression is drawn on the scene's plane, z = {height} m, and a target reaches z = {} m",
        away.position.z
    );
    Err(KeyError::new([Key::from("solver"), Key::from("target")], message))
}

/// What is to be felt must be drawn on the skin.
fn on_skin(scene: &Scene, foci: &[Focus]) -> Result<(), KeyError> {
    if !scene.aims_at_felt() || scene.drive.is_named() {
        return Ok(());
    }
    let Some((x, y)) = scene.plane.axes() else { return Ok(()) };
    let away = |focus: &Focus| (focus.position - scene.plane.centre).dot(x.cross(y)).abs();
    let Some(focus) = foci.iter().find(|focus| away(focus) > scene.wavelength()) else { return Ok(()) };
    let message = format!(
        "what is felt is drawn on the skin, which lies on the scene's plane, and a target is {} mm off: move `plane.centre`",
        (away(focus) * 1e4).round() / 10.0
    );
    Err(KeyError::new([Key::from("solver"), Key::from("target")], message))
}

/// The centre of rotation of a shape.
pub fn centre(shape: &Shape) -> DVec3 {
    shape.centre()
}

/// The strokes of a target, as drawn, with their target pressures.
pub(crate) fn drawn(target: &Target) -> Result<Vec<Vec<Vertex>>, KeyError> {
    if target.shape.is_path() {
        return Ok(vec![stroke::path(target)]);
    }
    if target.shape.is_direction() {
        return Ok(vec![vec![Vertex { at: target.shape.centre(), pressure: 1.0 }]]);
    }
    let even = |stroke: Vec<DVec3>| stroke.into_iter().map(|at| Vertex { at, pressure: 1.0 }).collect();
    Ok(strokes(target)?.into_iter().map(even).collect())
}

/// The number of focal points of all targets, without computing them; continuous strokes count with their corners,
/// areas as one.
///
/// # Errors
/// More than [`MOST_FOCI`], a glyph that the font lacks, or fewer points than corners.
pub fn count(targets: &[Target]) -> Result<usize, KeyError> {
    let shown: Vec<_> = targets.iter().enumerate().filter(|(_, target)| target.visible).collect();
    let areas = shown.iter().filter(|(_, target)| target.is_area()).count();
    Ok(areas + divisions(&shown)?.iter().map(Division::count).sum::<usize>())
}

/// An outline in pieces.
struct Division<'a> {
    target: &'a Target,
    runs: Vec<Run>,
    /// Pieces of each run.
    pieces: Vec<usize>,
}

impl<'a> Division<'a> {
    /// A continuous stroke gets as few pieces as possible.
    fn new(target: &'a Target, most: usize) -> Result<Self, KeyError> {
        let mut runs = run::runs(&drawn(target)?);
        let pieces = match target.sampling {
            Sampling::Whole | Sampling::Continuous | Sampling::Fill | Sampling::Stroke(_) => {
                vec![1; runs.len()]
            }
            Sampling::Spacing(spacing) => run::pieces_by_spacing(&runs, spacing),
            // Excessive numbers are refused before division.
            Sampling::Points(points) if points > most => return Err(too_many(target, points)),
            Sampling::Points(points) => run::pieces_by_count(&runs, points)?,
        };
        if let (Sampling::Continuous, Some(radius), [ring]) =
            (target.sampling, target.shape.circle(), &mut runs[..])
        {
            // A circle is longer than the polygon that represents it.
            ring.length = TAU * radius;
        }
        let division = Self { target, runs, pieces };
        if division.count() > most { Err(too_many(target, division.count())) } else { Ok(division) }
    }

    fn count(&self) -> usize {
        run::points_of(&self.runs, &self.pieces)
    }

    fn points(&self) -> Vec<Vertex> {
        // Points of a circle are computed exactly, not taken from its polygon.
        let (Some(radius), [pieces]) = (self.target.shape.circle(), &self.pieces[..]) else {
            return run::divide(&self.runs, &self.pieces);
        };
        let Target { shape, normal, angle, .. } = self.target;
        let at = shape.centre();
        let facing = facing(*normal);
        let place = |i| {
            let turn = DVec2::from_angle(angle + TAU * i as f64 / *pieces as f64);
            Vertex { at: at + facing * (turn * radius).extend(0.0), pressure: 1.0 }
        };
        (0..*pieces).map(place).collect()
    }
}

/// The divisions of targets that are not areas, leaving one sample for each area.
fn divisions<'a>(shown: &[(usize, &'a Target)]) -> Result<Vec<Division<'a>>, KeyError> {
    let areas = shown.iter().filter(|(_, target)| target.is_area()).count();
    let mut left = MOST_FOCI.saturating_sub(areas);
    if let Some((index, target)) = shown.iter().filter(|(_, target)| target.is_area()).nth(MOST_FOCI) {
        return Err(too_many(target, MOST_FOCI + 1).under(&["target".into(), (*index).into()]));
    }
    let divide = |&(index, target): &(usize, &'a Target)| {
        let division = Division::new(target, left).map_err(|e| e.under(&["target".into(), index.into()]))?;
        left -= division.count();
        Ok(division)
    };
    shown.iter().filter(|(_, target)| !target.is_area()).map(divide).collect()
}

/// The areas among targets, with their indices in the scene.
///
/// # Errors
/// The errors of [`Cover::new`].
pub fn covers(shown: &[(usize, &Target)], wavelength: f64) -> Result<Vec<(usize, Cover)>, KeyError> {
    let cover = |&(index, target): &(usize, &Target)| {
        let cover = Cover::new(target, wavelength).map_err(|e| e.under(&["target".into(), index.into()]));
        cover.transpose().map(|cover| cover.map(|cover| (index, cover)))
    };
    shown.iter().filter_map(cover).collect()
}

/// Samples of areas, spaced to give at most `most`; each area has at least one.
fn patches(covers: &[(usize, Cover)], wavelength: f64, most: usize) -> Vec<(usize, Vec<Patch>)> {
    const COARSER: f64 = 1.1;
    let mut spacing = wavelength / PER_WAVELENGTH_OF_AREA;
    loop {
        let patches: Vec<_> = covers.iter().map(|(index, cover)| (*index, cover.patches(spacing))).collect();
        let count: usize = patches.iter().map(|(_, patches)| patches.len()).sum();
        if count <= most.max(covers.len()) {
            return patches;
        }
        spacing *= COARSER.max((count as f64 / most.max(1) as f64).sqrt() * 0.99);
    }
}

/// Divides continuous strokes into pieces of at most `spacing` (m), or longer ones to keep at most `most` points in
/// total.
fn spread(divisions: &mut [Division<'_>], spacing: f64, most: usize) {
    let is_continuous = |division: &&Division<'_>| division.target.sampling == Sampling::Continuous;
    let separate: usize =
        divisions.iter().filter(|division| !is_continuous(division)).map(Division::count).sum();
    let most = most - separate;
    let strokes: Vec<_> = divisions.iter().filter(is_continuous).map(|division| &division.runs).collect();
    let fits = |spacing: f64| {
        let counts = strokes.iter().map(|runs| run::points_of(runs, &run::pieces_within(runs, spacing)));
        counts.fold(0, usize::saturating_add) <= most
    };
    // Whole runs fit.
    let longest = strokes.iter().copied().flatten().map(|run| run.length).fold(0.0, f64::max);
    let mut spacing = spacing;
    if !fits(spacing) {
        let (mut dense, mut sparse) = (spacing, longest);
        for _ in 0..HALVINGS {
            let middle = (dense * sparse).sqrt();
            if fits(middle) { sparse = middle } else { dense = middle }
        }
        spacing = sparse;
    }
    for division in divisions.iter_mut().filter(|division| is_continuous(&&**division)) {
        division.pieces = run::pieces_within(&division.runs, spacing);
    }
}

fn too_many(target: &Target, wanted: usize) -> KeyError {
    let most = format!("and a scene may have {MOST_FOCI}");
    let asked = format!("{wanted} focal points are asked for, {most}");
    match target.sampling {
        Sampling::Spacing(_) => refusal("spacing", asked),
        Sampling::Points(_) => refusal("points", asked),
        Sampling::Whole | Sampling::Fill | Sampling::Stroke(_) => KeyError::new([], asked),
        Sampling::Continuous => KeyError::new(
            [],
            format!(
                "its corners alone need {wanted} focal points in addition to those of other targets, {most}"
            ),
        ),
    }
}

fn refusal(key: &'static str, message: impl Into<String>) -> KeyError {
    KeyError::new([Key::from(key)], message)
}

#[cfg(test)]
mod tests {
    use glam::dvec2;

    use super::*;
    use crate::scene::motion::{self, Motion, MotionPath};

    fn sampled(shape: Shape, sampling: Sampling) -> Vec<DVec3> {
        points(&Target { sampling, ..Target::new(shape) }).unwrap()
    }

    fn points(target: &Target) -> Result<Vec<DVec3>, KeyError> {
        let foci = foci(&Scene { targets: vec![target.clone()], ..Scene::default() })?;
        Ok(foci.into_iter().map(|focus| focus.position).collect())
    }

    const AT: DVec3 = DVec3::new(0.01, 0.02, 0.1);

    #[test]
    fn a_rectangle_has_its_corners_and_even_sides() {
        let points = sampled(Shape::Rectangle { at: AT, width: 0.04, height: 0.02 }, Sampling::Spacing(0.01));
        assert_eq!(points.len(), 12);
        for corner in [(-0.02, -0.01), (0.02, -0.01), (0.02, 0.01), (-0.02, 0.01)] {
            let corner = AT + dvec2(corner.0, corner.1).extend(0.0);
            assert!(points.iter().any(|p| p.distance(corner) < 1e-12), "{corner}");
        }
        for pair in points.windows(2) {
            assert!((pair[0].distance(pair[1]) - 0.01).abs() < 1e-12);
        }
    }

    #[test]
    fn a_count_is_met_exactly() {
        for shape in [
            Shape::Circle { at: AT, radius: 0.02 },
            Shape::Rectangle { at: AT, width: 0.04, height: 0.025 },
            Shape::Triangle { at: AT, size: 0.04 },
            Shape::Polygon { at: AT, radius: 0.03, sides: 7 },
            Shape::Line { from: AT, to: AT + DVec3::X },
            Shape::Path { vertices: vec![AT, AT + DVec3::X, AT + DVec3::Y], closed: true },
            Shape::Text { text: "HIT".to_owned(), at: AT, height: 0.04 },
            Shape::Text { text: "Océ α8".to_owned(), at: AT, height: 0.04 },
        ] {
            for count in [80, 97, 211] {
                assert_eq!(sampled(shape.clone(), Sampling::Points(count)).len(), count, "{shape:?}");
            }
        }
    }

    #[test]
    fn circle_points_lie_on_the_circle_from_its_angle_on() {
        let target = Target {
            angle: 0.3,
            sampling: Sampling::Points(11),
            ..Target::new(Shape::Circle { at: AT, radius: 0.02 })
        };
        let points = points(&target).unwrap();
        for (i, point) in points.iter().enumerate() {
            let (sin, cos) = (0.3 + TAU * i as f64 / 11.0).sin_cos();
            assert!(point.distance(AT + 0.02 * DVec3::new(cos, sin, 0.0)) < 1e-12);
        }
    }

    #[test]
    fn letters_share_the_points_where_strokes_meet() {
        let points =
            sampled(Shape::Text { text: "H".to_owned(), at: AT, height: 0.04 }, Sampling::Spacing(0.02));
        assert_eq!(points.len(), 6, "four ends and two joints: {points:?}");
        for (i, a) in points.iter().enumerate() {
            for b in &points[..i] {
                assert!(a.distance(*b) > 1e-3);
            }
        }
    }

    #[test]
    fn a_normal_turns_the_shape_out_of_the_plane() {
        let mut target = Target::new(Shape::Circle { at: AT, radius: 0.02 });
        target.normal = DVec3::new(0.0, 3.0, 3.0);
        for point in points(&target).unwrap() {
            assert!((point - AT).dot(target.normal).abs() < 1e-12);
            assert!((point.distance(AT) - 0.02).abs() < 1e-12);
        }
    }

    #[test]
    fn an_angle_turns_lines_and_text_about_their_centre() {
        let mut target = Target::new(Shape::Line { from: AT, to: AT + 0.02 * DVec3::X });
        target.angle = TAU / 4.0;
        let points = points(&target).unwrap();
        assert!(points.iter().all(|p| (p.x - AT.x - 0.01).abs() < 1e-12), "{points:?}");
    }

    #[test]
    fn too_many_points_are_refused_before_they_are_made() {
        let target = Target {
            sampling: Sampling::Spacing(1e-9),
            ..Target::new(Shape::Line { from: AT, to: AT + DVec3::X })
        };
        assert!(points(&target).unwrap_err().message.contains("1000000001 focal points"));
        // More than can be counted.
        let target = Target { sampling: Sampling::Spacing(1e-300), ..target };
        assert!(points(&target).unwrap_err().message.contains("focal points are asked for"));
        assert!(count(&[target]).is_err());
    }

    #[test]
    fn hidden_targets_ask_for_nothing() {
        let mut scene = Scene { targets: vec![Target::new(Shape::Point { at: AT }); 2], ..Scene::default() };
        scene.targets[1].visible = false;
        assert_eq!(foci(&scene).unwrap().len(), 1);
        assert_eq!(count(&scene.targets).unwrap(), 1);
        scene.targets[0].visible = false;
        assert!(foci(&scene).unwrap_err().message.contains("every target is hidden"));
    }

    #[test]
    fn fewer_points_than_corners_are_refused() {
        let target = Target {
            sampling: Sampling::Points(3),
            ..Target::new(Shape::Rectangle { at: AT, width: 0.04, height: 0.02 })
        };
        assert!(points(&target).unwrap_err().message.contains("need 4"));
    }

    #[test]
    fn directions_are_unit_vectors_beside_separate_foci() {
        let way = |x: f64, z: f64| Target::new(Shape::Direction { direction: DVec3::new(x, 0.0, z) });
        let point = Target::new(Shape::Point { at: AT });
        let ring = Target::new(Shape::Circle { at: AT, radius: 0.02 });
        let of = |targets: &[&Target]| {
            foci(&Scene { targets: targets.iter().map(|it| (*it).clone()).collect(), ..Scene::default() })
        };
        let found = of(&[&way(3.0, 4.0), &point]).unwrap();
        assert!(found[0].position.distance(DVec3::new(0.6, 0.0, 0.8)) < 1e-15);
        assert_eq!((found[0].part, found[1].part), (Part::Direction, Part::Point));
        for (targets, why) in [
            (vec![&way(0.3, -1.0)], "no sound is radiated towards this direction"),
            (vec![&way(1.0, 0.0)], "no sound is radiated towards this direction"),
            (vec![&ring, &way(0.0, 1.0)], "directions combine only with points"),
        ] {
            let error = of(&targets).unwrap_err();
            assert!(error.message.contains(why), "{}", error.message);
        }
        let moving = Scene {
            targets: vec![way(0.0, 1.0)],
            motion: Motion { path: MotionPath::Circle, ..Motion::default() },
            ..Scene::default()
        };
        let error = motion::check(&moving).unwrap_err();
        assert!(
            error.message.contains("a direction has no place that a path could move"),
            "{}",
            error.message
        );
    }
}
