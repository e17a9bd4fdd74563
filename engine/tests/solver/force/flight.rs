//! Flights of beads, against closed forms.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use sonoglyph::acoustics::{Air, Aperture, viscosity};
use sonoglyph::drive::Drive;
use sonoglyph::force::{Carriage, Drag, Flight, Levitation};
use sonoglyph::gauge::Gauge;
use sonoglyph::scene::{Bead, Board, Scene};

use crate::force::focused;

/// Two facing boards in antiphase: a standing wave with a pressure node in the middle.
fn facing() -> Scene {
    let above = Board { at: DVec3::Z * 0.2, normal: DVec3::NEG_Z, ..Board::default() };
    Scene { boards: vec![Board::default(), above], ..Scene::default() }
}

/// A bead's scene and field between the boards, and the node in the middle.
fn standing() -> (Scene, Levitation, DVec3) {
    let mut scene = facing();
    scene.bead = Bead { radius: 0.0004, ..Bead::default() };
    let aperture = Aperture::new(&scene);
    let at = DVec3::new(0.0, 0.0, 0.1);
    let drive = focused(&aperture, at, |place| if place.z > 0.1 { TAU / 2.0 } else { 0.0 });
    let levitation = Levitation::new(&scene, &aperture, &[drive]);
    (scene, levitation, at)
}

fn drag(scene: &Scene, levitation: &Levitation) -> Drag {
    let air = Air::new(&scene.medium, scene.array.frequency);
    Drag::new(&levitation.sphere, viscosity(&scene.medium), air.density)
}

/// The flight of a bead in a constant field: time, displacement from the wanted place, and velocity.
fn fly(
    scene: &Scene,
    levitation: &Levitation,
    wanted: DVec3,
    from: DVec3,
    seconds: f64,
) -> Vec<(f64, DVec3, DVec3)> {
    let carriage = Carriage {
        fields: std::slice::from_ref(levitation),
        wanted: &[wanted],
        span: f64::INFINITY,
        drag: drag(scene, levitation),
    };
    let flight = carriage.fly(from, seconds, &Gauge::default());
    assert!(!flight.is_lost);
    flight.moments.iter().map(|moment| (moment.time, moment.at - wanted, moment.velocity)).collect()
}

#[test]
fn a_bead_oscillates_in_a_standing_wave_with_the_period_of_its_stiffness() {
    let (scene, levitation, at) = standing();
    let hold = levitation.hold(at);
    assert!(hold.holds(), "{hold:?}");
    let inertia = levitation.sphere.inertia();
    let decay = drag(&scene, &levitation).slow / (2.0 * inertia);
    for mode in [hold.modes[0], hold.modes[2]] {
        let period = TAU / (mode.stiffness / inertia - decay * decay).sqrt();
        let way = mode.direction * 2e-6;
        let flight = fly(&scene, &levitation, hold.rest, hold.rest + way, 6.1 * period);
        // Zero crossings, by linear interpolation between two moments.
        let passes: Vec<_> = flight
            .windows(2)
            .filter_map(|pair| {
                let [a, b] = [pair[0].1.dot(way), pair[1].1.dot(way)];
                (a > 0.0 && b <= 0.0).then(|| pair[0].0 + (pair[1].0 - pair[0].0) * a / (a - b))
            })
            .collect();
        assert_eq!(passes.len(), 6);
        let found = (passes[5] - passes[0]) / 5.0;
        assert!((found / period - 1.0).abs() < 1e-3, "{found} s, and {period} s");
    }
}

/// The scene's bead without sound.
fn silence(scene: &Scene) -> Levitation {
    let aperture = Aperture::new(scene);
    let count = aperture.positions.len();
    Levitation::new(scene, &aperture, &[Drive { amplitudes: vec![0.0; count], phases: vec![0.0; count] }])
}

/// Place and velocity after some seconds by steps of Runge and Kutta's classical method, 6000 of them.
fn by_fine_steps(scene: &Scene, levitation: &Levitation, from: DVec3, seconds: f64) -> [DVec3; 2] {
    const STEPS: u32 = 6_000;
    let (inertia, drag) = (levitation.sphere.inertia(), drag(scene, levitation));
    let rates =
        |[at, velocity]: [DVec3; 2]| [velocity, (levitation.net(at) + drag.force(velocity)) / inertia];
    let along = |state: [DVec3; 2], rate: [DVec3; 2], time: f64| [0, 1].map(|i| state[i] + rate[i] * time);
    let step = seconds / f64::from(STEPS);
    (0..STEPS).fold([from, DVec3::ZERO], |state, _| {
        let a = rates(state);
        let b = rates(along(state, a, step / 2.0));
        let c = rates(along(state, b, step / 2.0));
        let d = rates(along(state, c, step));
        [0, 1].map(|i| state[i] + (a[i] + 2.0 * (b[i] + c[i]) + d[i]) * (step / 6.0))
    })
}

#[test]
fn free_held_and_lost_beads_fly_as_by_fine_steps() {
    let (scene, levitation, at) = standing();
    let wavelength = levitation.wavelength;
    // Held, and lost from beside an antinode, which drives it away.
    let held = levitation.hold(at).rest + DVec3::new(1e-4, 0.0, 4e-4);
    let lost = at + DVec3::new(0.1, 0.05, 0.26) * wavelength;
    // A bead of 1 mm in silence, where a field sets no step.
    let heavy = Scene { bead: Bead { radius: 0.001, ..Bead::default() }, ..scene.clone() };
    let silence = silence(&heavy);
    let cases = [(&scene, &levitation, held), (&scene, &levitation, lost), (&heavy, &silence, at)];
    for (number, (scene, levitation, from)) in cases.into_iter().enumerate() {
        let carriage = Carriage {
            fields: std::slice::from_ref(levitation),
            wanted: &[at],
            span: f64::INFINITY,
            drag: drag(scene, levitation),
        };
        let flight = carriage.fly(from, 0.03, &Gauge::default());
        let last = flight.moments.last().unwrap();
        let [place, velocity] = by_fine_steps(scene, levitation, from, last.time);
        let off = last.at.distance(place) / place.distance(from).max(1e-4);
        assert!(off < 1e-5, "{number}: {off:e} of the way, {last:?}");
        let off = last.velocity.distance(velocity) / velocity.length().max(0.01);
        assert!(off < 2e-4, "{number}: {off:e} of the speed, {last:?}");
    }
}

#[test]
fn a_lost_bead_ends_its_flight_a_wavelength_away() {
    let (scene, levitation, at) = standing();
    let silence = silence(&scene);
    let carriage = Carriage {
        fields: std::slice::from_ref(&silence),
        wanted: &[at],
        span: f64::INFINITY,
        drag: drag(&scene, &silence),
    };
    let flight = carriage.fly(at, 1.0, &Gauge::default());
    assert!(flight.is_lost);
    let away = flight.moments.last().unwrap().at.distance(at);
    assert!((away / levitation.wavelength - 1.0).abs() < 1e-9 && flight.farthest == away, "{away} m");
}

#[test]
fn a_bead_in_silence_falls_at_terminal_speed() {
    let scene = Scene { bead: Bead { radius: 2e-5, ..Bead::default() }, ..Scene::default() };
    let aperture = Aperture::new(&scene);
    let count = aperture.positions.len();
    let silent = Drive { amplitudes: vec![0.0; count], phases: vec![0.0; count] };
    let levitation = Levitation::new(&scene, &aperture, &[silent]);
    let at = DVec3::new(0.0, 0.0, 0.1);
    let drag = drag(&scene, &levitation);
    let flight = fly(&scene, &levitation, at, at, 0.02);
    // At this speed the Reynolds correction adds 1 % to Stokes' drag.
    let speed = -flight.last().unwrap().2.z;
    let balanced = drag.slow * speed * (1.0 + 0.15 * (drag.reynolds * speed).powf(0.687));
    assert!((balanced / levitation.load - 1.0).abs() < 5e-5, "{balanced} {}", levitation.load);
    // After its relaxation time, nearly as with Stokes' drag alone.
    let relaxation = levitation.sphere.inertia() / drag.slow;
    let (time, _, velocity) = flight[flight.iter().position(|(time, ..)| *time > relaxation).unwrap()];
    let expected = levitation.load / drag.slow * (1.0 - (-time / relaxation).exp());
    assert!((-velocity.z / expected - 1.0).abs() < 0.02, "{velocity} {expected}");
}

#[test]
fn the_drag_of_a_sphere_is_that_of_the_published_coefficients() {
    let levitation = Levitation::new(&Scene::default(), &Aperture::new(&Scene::default()), &[]);
    let radius = (0.75 * levitation.sphere.volume / PI).cbrt();
    let (viscosity, density) = (1.8e-5, 1.2);
    let drag = Drag::new(&levitation.sphere, viscosity, density);
    assert!((drag.slow / (6.0 * PI * viscosity * radius) - 1.0).abs() < 1e-12);
    // Clift, Grace and Weber's standard curve.
    for (reynolds, coefficient) in [(0.1, 244.0), (1.0, 27.2), (10.0, 4.26), (100.0, 1.09), (500.0, 0.555)] {
        let speed = reynolds * viscosity / (2.0 * radius * density);
        let force = drag.force(DVec3::new(0.0, -speed, 0.0));
        let expected = coefficient * 0.5 * density * speed * speed * PI * radius * radius;
        assert!(
            (force.y / expected - 1.0).abs() < 0.03 && force.x == 0.0 && force.z == 0.0,
            "{reynolds}: {force}"
        );
    }
}

/// A bead of 20 µm in two silent fields in turn, 3 ms each, with these traps.
fn fall(wanted: &[DVec3; 2], from: DVec3, seconds: f64) -> Flight {
    let scene = Scene { bead: Bead { radius: 2e-5, ..Bead::default() }, ..Scene::default() };
    let aperture = Aperture::new(&scene);
    let silent = Drive {
        amplitudes: vec![0.0; aperture.positions.len()],
        phases: vec![0.0; aperture.positions.len()],
    };
    let fields = [0, 1].map(|_| Levitation::new(&scene, &aperture, std::slice::from_ref(&silent)));
    let drag = drag(&scene, &fields[0]);
    Carriage { fields: &fields, wanted, span: 0.003, drag }.fly(from, seconds, &Gauge::default())
}

#[test]
fn fields_take_turns_of_their_span_until_the_end() {
    let at = DVec3::new(0.0, 0.0, 0.1);
    let wanted = [at, at + DVec3::X * 1e-3];
    let flight = fall(&wanted, at, 0.01);
    assert!(!flight.is_lost);
    assert!((flight.moments.last().unwrap().time - 0.01).abs() < 1e-15);
    assert!(flight.moments.windows(2).all(|pair| pair[0].time < pair[1].time));
    for moment in &flight.moments[1..] {
        // The end of a turn belongs to it.
        let turn = ((moment.time - 1e-9) / 0.003) as usize;
        assert_eq!(moment.wanted, wanted[turn % 2], "{moment:?}");
    }
    let farthest = flight.moments.iter().map(|moment| moment.at.distance(moment.wanted)).fold(0.0, f64::max);
    assert_eq!(flight.farthest, farthest);
    // Accuracy does not depend on the turns: the last velocity is the terminal one.
    let fields = fall(&[at; 2], at, 0.02);
    assert!(
        (fields.moments.last().unwrap().velocity.z / flight.moments.last().unwrap().velocity.z - 1.0).abs()
            < 0.1
    );
}

#[test]
fn a_bead_is_lost_a_wavelength_away_from_its_trap() {
    let at = DVec3::new(0.0, 0.0, 0.1);
    let scene = Scene::default();
    let wavelength = Aperture::new(&scene).wavelength();
    // In this time it falls by less than a hundredth of a wavelength.
    for (distance, is_lost) in [(0.98, false), (1.02, true)] {
        let flight = fall(&[at + DVec3::X * (distance * wavelength); 2], at, 0.001);
        assert_eq!(flight.is_lost, is_lost, "{distance}");
        assert_eq!(flight.moments.len() == 2, is_lost, "{distance}: the flight ends there");
    }
}
