//! Beads 100 mm above 16 x 16 elements, against sums over partial waves in numpy, and the stability of traps.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, dvec3};
use sonoglyph::acoustics::Aperture;
use sonoglyph::force::{Levitation, Outcome, WAYS};
use sonoglyph::scene::{Board, ElementModel, Scene};

use crate::force::{focused, still_air};

const AT: DVec3 = dvec3(0.0, 0.0, 0.1);

/// A trap: its signature, and the force upwards (µN) and the stiffnesses along x, y and z (mN/m).
type Known<'a> = (&'a str, &'a dyn Fn(DVec3) -> f64, [f64; 4]);

fn bottle(scene: &Scene) -> impl Fn(DVec3) -> f64 {
    let radius = scene.array.pitch * (scene.elements() as f64 / TAU).sqrt();
    move |place| if place.length() > radius { PI } else { 0.0 }
}

fn twin(place: DVec3) -> f64 {
    if place.x < 0.0 { PI } else { 0.0 }
}

#[test]
fn four_traps_have_the_values_of_partial_waves() {
    let scene = still_air();
    let aperture = Aperture::new(&scene);
    let bottle = bottle(&scene);
    // From samples of the far fields at 0.3/k, and differences of the force.
    let traps: [Known<'_>; 4] = [
        ("focus", &|_| 0.0, [0.879_618, -0.292_833, -0.292_833, 0.009_350]),
        ("twin", &twin, [-0.010_481, 0.397_259, 0.263_641, 0.015_060]),
        ("vortex", &|place| place.y.atan2(place.x), [-0.012_955, 0.387_768, 0.387_768, 0.017_567]),
        ("bottle", &bottle, [0.085_612, 0.010_645, 0.010_645, 0.000_884]),
    ];
    for (name, signature, [force, kx, ky, kz]) in traps {
        let drive = focused(&aperture, AT, signature);
        let levitation = Levitation::new(&scene, &aperture, &[drive]);
        let forces = levitation.forces(AT);
        assert!((forces.force.z * 1e6 - force).abs() < 1e-4, "{name}: {} µN", forces.force.z * 1e6);
        let own = [0, 1, 2].map(|i| forces.stiffness.col(i)[i] * 1e3);
        for (own, said) in own.into_iter().zip([kx, ky, kz]) {
            assert!((own - said).abs() < 2e-4, "{name}: {own} mN/m, not {said}");
        }
    }
    let weight = Levitation::new(&scene, &aperture, &[]).sphere.mass * 9.80665;
    assert!((weight * 1e6 - 0.149).abs() < 5e-4, "{weight}");
}

/// An element, a bead's radius (mm), and Fx and Fz (µN) at (1, 0, 100) mm of a focus at (0, 0, 100) mm.
const FOCUS: [(ElementModel, f64, [f64; 2]); 8] = [
    (ElementModel::Point, 0.5, [1.319_335, 2.125_116]),
    (ElementModel::Point, 1.0, [7.449_010, 87.068_25]),
    (ElementModel::ExactPiston, 0.1, [0.002_754, 0.000_383]),
    (ElementModel::ExactPiston, 0.25, [0.040_416, 0.018_521]),
    (ElementModel::ExactPiston, 0.5, [0.261_132, 0.821_560]),
    (ElementModel::ExactPiston, 0.75, [0.640_608, 7.733_819]),
    (ElementModel::ExactPiston, 1.0, [1.053_483, 34.597_853]),
    (ElementModel::ExactPiston, 1.5, [2.259_382, 207.748_697]),
];

#[test]
fn beads_beside_a_focus_have_the_force_of_sums() {
    for (element, radius, expected) in FOCUS {
        let mut scene = still_air();
        (scene.array.element, scene.bead.radius) = (element, radius * 1e-3);
        let aperture = Aperture::new(&scene);
        let levitation = Levitation::new(&scene, &aperture, &[focused(&aperture, AT, |_| 0.0)]);
        let force = levitation.force(AT + DVec3::X * 1e-3) * 1e6;
        for (own, expected) in [force.x, force.z].into_iter().zip(expected) {
            assert!((own - expected).abs() < 1e-4 * expected + 1e-6, "{element:?}, {radius}: {force}");
        }
    }
}

#[test]
fn a_bead_between_two_boards_has_the_force_of_sums() {
    let mut scene = Scene { medium: Scene::default().medium, ..levitator() };
    let aperture = Aperture::new(&scene);
    let drive = focused(&aperture, AT, |place| if place.z > 0.1 { PI / 2.0 } else { 0.0 });
    for (radius, expected) in [(0.25, 11.672), (0.5, 88.848), (0.75, 275.60), (1.0, 576.36), (1.5, 1281.87)] {
        scene.bead.radius = radius * 1e-3;
        let levitation = Levitation::new(&scene, &aperture, std::slice::from_ref(&drive));
        let force = levitation.force(AT).z * 1e6;
        assert!((force / expected - 1.0).abs() < 1e-3, "{radius}: {force}, not {expected}");
    }
}

#[test]
fn a_trap_from_below_is_judged_by_its_force_curve() {
    let scene = still_air();
    let aperture = Aperture::new(&scene);
    let hold = |signature: &dyn Fn(DVec3) -> f64| {
        let levitation = Levitation::new(&scene, &aperture, &[focused(&aperture, AT, signature)]);
        let hold = levitation.hold(AT);
        (levitation, hold)
    };
    // All stiffnesses of the twin trap are positive, but its lift is below the weight.
    let (_, twin) = hold(&twin);
    assert_eq!(twin.outcome, Outcome::TooHeavy);
    assert!(twin.lift < 1.0, "{twin:?}");
    let (_, focus) = hold(&|_| 0.0);
    assert_eq!(focus.outcome, Outcome::Unstable);
    assert!(focus.modes[0].direction.z.abs() < 1e-6, "{focus:?}");
}

#[test]
fn a_weightless_bead_in_silence_is_unstable_where_it_is() {
    let scene = still_air();
    let mut levitation = Levitation::new(&scene, &Aperture::new(&scene), &[]);
    levitation.load = 0.0;
    let hold = levitation.hold(AT);
    assert_eq!((hold.outcome, hold.rest, hold.lift), (Outcome::Unstable, AT, f64::INFINITY));
}

/// Two facing boards, 200 mm apart.
fn levitator() -> Scene {
    let above = Board { at: DVec3::Z * 0.2, normal: DVec3::NEG_Z, ..Board::default() };
    Scene { boards: vec![Board::default(), above], ..still_air() }
}

#[test]
fn a_standing_trap_holds_up_to_its_escapes() {
    let mut scene = levitator();
    // ka = 0.15.
    scene.bead.radius = 0.0002;
    let aperture = Aperture::new(&scene);
    let drive = focused(&aperture, AT, |place| if place.z > 0.1 { PI } else { 0.0 });
    let levitation = Levitation::new(&scene, &aperture, std::slice::from_ref(&drive));
    let hold = levitation.hold(AT);
    assert!(hold.holds() && hold.lift > 10.0, "{hold:?}");
    // The bead sags by weight/stiffness, to zero net force.
    assert!(levitation.net(hold.rest).length() < 1e-6 * levitation.load, "{hold:?}");
    let linear = levitation.load / hold.modes[2].stiffness;
    assert!(hold.modes[2].direction.z.abs() > 0.999 && (hold.sag() / linear - 1.0).abs() < 0.01, "{hold:?}");
    // The crest is λ/4 away; the weight moves the escape in its direction closer.
    let [down, up] = [hold.escapes[4].distance, hold.escapes[5].distance];
    let quarter = aperture.wavelength() / 4.0;
    assert!(
        (down / quarter - 1.0).abs() < 0.15 && (up / quarter - 1.0).abs() < 0.15 && down < up,
        "{hold:?}"
    );
    for (way, escape) in WAYS.into_iter().zip(hold.escapes) {
        let at = |part: f64| levitation.net(hold.rest + way * escape.distance * part).dot(way);
        assert!(at(0.9999) < 0.0 && at(1.0003) > 0.0, "{way}: {escape:?}");
        let crest = (1..1000).map(|i| -at(f64::from(i) * 1e-3)).fold(0.0, f64::max);
        assert!((escape.force / crest - 1.0).abs() < 2e-3, "{way}: {escape:?}, {crest} N");
    }
    // Half the strength gives a quarter of the force.
    let mut quiet = scene.clone();
    quiet.array.strength /= 2.0;
    let half = Levitation::new(&quiet, &Aperture::new(&quiet), &[drive]);
    let beside = AT + dvec3(0.001, 0.0005, 0.0007);
    assert!(
        (half.force(beside) * 4.0 - levitation.force(beside)).length()
            < 1e-12 * levitation.force(beside).length()
    );
}
