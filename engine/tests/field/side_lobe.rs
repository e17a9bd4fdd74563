//! The peak side lobe of a drive, against an exhaustive search in f64.

use glam::{DVec2, DVec3, dvec3};
use sonoglyph::acoustics::Aperture;
use sonoglyph::field::{Evaluator, NoSideLobe, Samples, SideLobe, Stages, reference, side_lobe};
use sonoglyph::scene::{Board, Method, Plane, Scene, Shape, Target};
use sonoglyph::solver::{self, Solution};

fn solved(points: &[DVec3], method: Method) -> (Scene, Solution) {
    let target = |&at: &DVec3| Target::new(Shape::Point { at });
    let mut scene = Scene { targets: points.iter().map(target).collect(), ..Scene::default() };
    scene.solver.method = method;
    let solution = solver::solve(&scene).unwrap();
    (scene, solution)
}

fn side_lobe_of(scene: &Scene, solution: &Solution) -> Result<SideLobe, NoSideLobe> {
    let aperture = Aperture::new(scene);
    let (mut stages, foci) = (Stages::new(Evaluator::Cpu), &solution.foci);
    side_lobe(&mut stages, &aperture, &scene.plane, &solution.drives(), foci)
}

/// All local maxima of |p| (Pa) on the plane, on a grid of λ/20, in f64; the loudest first.
fn maxima(scene: &Scene, solution: &Solution) -> Vec<(DVec3, f64)> {
    let aperture = Aperture::new(scene);
    let [width, height] =
        (scene.plane.size / aperture.wavelength() * 20.0).to_array().map(|samples| samples as usize | 1);
    let samples = Samples::on_plane(&scene.plane, width, height).unwrap();
    let field: Vec<_> =
        reference::pressure(&aperture, &solution.drive, &samples).iter().map(|p| p.norm()).collect();
    let inside = (1..height - 1).flat_map(|row| (1..width - 1).map(move |column| row * width + column));
    let is_maximum = |&at: &usize| {
        let around = [at - width, at - 1, at + 1, at + width];
        around.iter().all(|&other| field[other] < field[at])
    };
    let mut maxima: Vec<_> = inside.filter(is_maximum).map(|at| (samples.point(at), field[at])).collect();
    maxima.sort_by(|a, b| b.1.total_cmp(&a.1));
    maxima
}

#[test]
fn the_peak_side_lobe_of_one_focus_is_its_first() {
    for (focus, size) in [
        (dvec3(0.0, 0.0, 0.1), 0.05),
        (dvec3(0.03, -0.01, 0.12), 0.05),
        (dvec3(0.0, 0.0, 0.4), 0.08),
        (dvec3(0.01, 0.0, 0.04), 0.04),
    ] {
        let (mut scene, solution) = solved(&[focus], Method::Focus);
        scene.plane.centre = focus;
        scene.plane.size = DVec2::splat(size);
        // For a single focus, the loudest maximum is the focus, and the next one the peak side lobe.
        let maxima = maxima(&scene, &solution);
        assert!(maxima[0].0.distance(focus) < 1e-3, "{focus}: {:?}", maxima[0]);
        let (place, pressure) = maxima[1];
        let found = side_lobe_of(&scene, &solution).unwrap();
        assert!(
            (found.pressure / pressure - 1.0).abs() < 5e-3,
            "{focus}: {found:?}, not {pressure} at {place}"
        );
        let part = found.pressure / solution.quality.mean_pressure;
        assert!((found.part - part).abs() < 1e-12 && (0.1..0.25).contains(&part), "{focus}: {found:?}");
        // Side lobes lie on the array's axes through the focus; two of them may be equally loud.
        let null = Aperture::new(&scene).wavelength() * focus.length().hypot(0.084) / 0.168;
        let nulls = found.position.distance(focus) / null;
        assert!((1.4..1.75).contains(&nulls), "{focus}: {nulls} first nulls away");
    }
}

#[test]
fn the_peak_side_lobe_of_several_foci_is_the_loudest_maximum_outside_all() {
    let points = [dvec3(-0.03, 0.0, 0.1), dvec3(0.02, 0.02, 0.1), dvec3(0.01, -0.03, 0.1)];
    let mut parts = Vec::new();
    for method in [Method::Naive, Method::Best, Method::Pinv] {
        let (mut scene, solution) = solved(&points, method);
        scene.plane.size = DVec2::splat(0.1);
        let found = side_lobe_of(&scene, &solution).unwrap();
        let beside = |point: DVec3| points.iter().all(|focus| focus.distance(point) > 0.0085);
        let (place, pressure) = *maxima(&scene, &solution).iter().find(|(place, _)| beside(*place)).unwrap();
        assert!(found.position.distance(place) < 5e-4, "{method:?}: {found:?}, not {place}");
        assert!((found.pressure / pressure - 1.0).abs() < 5e-3, "{method:?}: {found:?}, not {pressure}");
        parts.push(found.part);
    }
    assert!(parts[0] != parts[1] && parts[1] != parts[2], "{parts:?}");
}

#[test]
fn the_main_lobe_along_the_beam_is_no_side_lobe() {
    // In a plane along the beam, the focus is 5 cm long.
    let focus = dvec3(0.0, 0.0, 0.15);
    let (mut scene, solution) = solved(&[focus], Method::Focus);
    scene.plane = Plane { centre: focus, y_axis: DVec3::Z, size: DVec2::splat(0.1), ..Plane::default() };
    let found = side_lobe_of(&scene, &solution).unwrap();
    assert!(found.part < 0.3, "{found:?}");
    let loudest = maxima(&scene, &solution);
    let louder = loudest.iter().filter(|(_, pressure)| *pressure > 1.01 * found.pressure);
    assert!(
        louder.clone().count() == 1,
        "louder than the side lobe is only the focus: {:?}",
        louder.collect::<Vec<_>>()
    );
}

#[test]
fn the_side_lobe_is_that_of_the_driven_elements_wherever_the_array_has_others() {
    let focus = dvec3(-0.05, 0.01, 0.1);
    let (mut half, _) = solved(&[focus], Method::Focus);
    half.array.off = (0..256).filter(|n| n % 16 >= 8).collect();
    let mut alone = half.clone();
    (alone.array.columns, alone.array.off) = (8, Vec::new());
    alone.boards = vec![Board { at: dvec3(-0.042, 0.0, 0.0), ..Board::default() }];
    let [half, alone] = [half, alone].map(|mut scene| {
        scene.plane = Plane { centre: focus, size: DVec2::splat(0.1), ..Plane::default() };
        side_lobe_of(&scene, &solver::solve(&scene).unwrap()).unwrap()
    });
    assert!((half.part / alone.part - 1.0).abs() < 1e-9, "{half:?}, {alone:?}");
    assert!(half.position.distance(alone.position) < 1e-9, "{half:?}, {alone:?}");
}

/// Boards below and beside the focus: a side lobe of one is in the long main lobe of the other.
#[test]
fn the_main_lobe_of_several_boards_is_common_to_all() {
    let focus = dvec3(0.0, 0.0, 0.12);
    let (mut scene, _) = solved(&[focus], Method::Focus);
    scene.boards =
        vec![Board::default(), Board { at: dvec3(-0.12, 0.0, 0.12), normal: DVec3::X, x_axis: DVec3::Y }];
    scene.plane = Plane { centre: focus, y_axis: DVec3::Z, size: DVec2::splat(0.08), ..Plane::default() };
    let solution = solver::solve(&scene).unwrap();
    let found = side_lobe_of(&scene, &solution).unwrap();
    let loudest = maxima(&scene, &solution);
    let (place, pressure) = loudest.iter().find(|(place, _)| place.distance(focus) > 0.0055).unwrap();
    assert!((found.pressure / pressure - 1.0).abs() < 5e-3, "{found:?}, not {pressure} at {place}");
}

#[test]
fn planes_without_a_focus_and_planes_too_large_have_no_side_lobe() {
    let focus = dvec3(0.0, 0.0, 0.1);
    let (mut scene, solution) = solved(&[focus], Method::Focus);
    let usual = scene.plane.clone();
    for plane in [
        Plane { centre: dvec3(0.0, 0.0, 0.3), ..usual.clone() },
        Plane { centre: dvec3(0.3, 0.0, 0.1), ..usual.clone() },
        Plane { centre: dvec3(0.0, -0.3, 0.1), ..usual.clone() },
        Plane { centre: dvec3(0.0, 0.05, 0.1), y_axis: DVec3::Z, ..usual.clone() },
    ] {
        scene.plane = plane;
        assert_eq!(side_lobe_of(&scene, &solution), Err(NoSideLobe::NoFocus), "{:?}", scene.plane);
    }
    scene.plane = Plane { size: DVec2::splat(20.0), ..usual };
    assert_eq!(side_lobe_of(&scene, &solution), Err(NoSideLobe::TooLarge));
}

#[test]
fn the_sound_next_to_an_element_is_no_side_lobe() {
    // The plane along the beam goes through a row of elements.
    let element = dvec3(0.00525, 0.00525, 0.0);
    let focus = dvec3(0.0, element.y, 0.15);
    let (mut scene, solution) = solved(&[focus], Method::Focus);
    let centre = dvec3(0.0, element.y, 0.1);
    scene.plane = Plane { centre, y_axis: DVec3::Z, size: DVec2::new(0.1, 0.2), ..Plane::default() };
    let found = side_lobe_of(&scene, &solution).unwrap();
    let aperture = Aperture::new(&scene);
    assert!(found.position.z > aperture.wavelength(), "{found:?}");
    let above = Samples::at(vec![element + DVec3::Z * 0.001]);
    let louder = reference::pressure(&aperture, &solution.drive, &above)[0].norm();
    assert!(louder > 2.0 * found.pressure, "{louder} Pa, {found:?}");
}
