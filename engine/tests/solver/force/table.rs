//! Four traps 100 mm above 16 x 16 elements, against values from numpy (eighth-order differences), and their stability.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, dvec3};
use sonoglyph::acoustics::Aperture;
use sonoglyph::force::{Levitation, Outcome, WAYS};
use sonoglyph::scene::{Board, Scene};

use crate::force::{focused, still_air};

const AT: DVec3 = dvec3(0.0, 0.0, 0.1);

/// A trap: its signature, and |p| (Pa), the force upwards (µN) and the stiffnesses along x, y and z (mN/m).
type Known<'a> = (&'a str, &'a dyn Fn(DVec3) -> f64, [f64; 5]);

fn bottle(scene: &Scene) -> impl Fn(DVec3) -> f64 {
    let radius = scene.array.pitch * (scene.elements() as f64 / TAU).sqrt();
    move |place| if place.length() > radius { PI } else { 0.0 }
}

fn twin(place: DVec3) -> f64 {
    if place.x < 0.0 { PI } else { 0.0 }
}

#[test]
fn the_four_traps_have_the_values_of_converged_differences() {
    let scene = still_air();
    let aperture = Aperture::new(&scene);
    let bottle = bottle(&scene);
    let traps: [Known<'_>; 4] = [
        ("focus", &|_| 0.0, [4493.3114, 0.997_631_42, -0.386_480_67, -0.386_480_67, 0.004_503_56]),
        ("twin", &twin, [0.0, -0.008_555_28, 0.467_933_25, 0.266_864_72, 0.015_135_25]),
        (
            "vortex",
            &|place| place.y.atan2(place.x),
            [0.0, -0.010_649_48, 0.431_553_26, 0.431_553_26, 0.017_653_31],
        ),
        ("bottle", &bottle, [1290.1402, 0.100_419_90, 0.013_847_41, 0.013_847_41, 0.004_366_96]),
    ];
    for (name, signature, [pressure, force, kx, ky, kz]) in traps {
        let drive = focused(&aperture, AT, signature);
        let levitation = Levitation::new(&scene, &aperture, &[drive]);
        let p = levitation.sounds(AT).next().unwrap().pressure().norm();
        assert!((p - pressure).abs() < 1e-4, "{name}: {p} Pa");
        let forces = levitation.forces(AT);
        assert!((forces.force.z * 1e6 - force).abs() < 1e-7, "{name}: {} µN", forces.force.z * 1e6);
        let own = [0, 1, 2].map(|i| forces.stiffness.col(i)[i] * 1e3);
        for (own, said) in own.into_iter().zip([kx, ky, kz]) {
            assert!((own - said).abs() < 2e-7, "{name}: {own} mN/m, not {said}");
        }
    }
    let weight = Levitation::new(&scene, &aperture, &[]).sphere.mass * 9.80665;
    assert!((weight * 1e6 - 0.149).abs() < 5e-4, "{weight}");
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
