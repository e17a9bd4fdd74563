//! Traps as targets: in balance at their places, and stiff, alone, together and beside foci.

use glam::{DVec3, dvec3};
use sonoglyph::acoustics::Aperture;
use sonoglyph::force::{Levitation, Outcome};
use sonoglyph::scene::{Board, Scene, Shape, Target, Trap, outline};
use sonoglyph::solver::{self, Problem, trap};
use strum::VariantArray;

use crate::dice::Dice;
use crate::force::{focused, still_air};

fn target(at: DVec3, trap: Trap) -> Target {
    Target::new(Shape::Trap { at, trap, charge: 1 })
}

fn facing(scene: Scene) -> Scene {
    let above = Board { at: DVec3::Z * 0.2, normal: DVec3::NEG_Z, ..Board::default() };
    Scene { boards: vec![Board::default(), above], ..scene }
}

/// The smallest stiffness of all traps before and after the search.
fn weakest(scene: &Scene) -> [f64; 2] {
    let aperture = Aperture::new(scene);
    let problem = Problem::of_scene(scene, &aperture, outline::foci(scene).unwrap());
    let traps = problem.traps.as_ref().unwrap();
    let least = |u: &[_]| traps.weakest(&aperture, u).into_iter().fold(f64::INFINITY, f64::min);
    let solution = solver::solve(scene).unwrap();
    [least(&trap::signature(&problem, traps)), least(&solution.drive.excitation(&aperture.driven))]
}

#[test]
fn one_board_holds_a_bead_at_its_place() {
    let (mut scenes, mut stiffness) = (0, Vec::new());
    for (size, pitch, element_radius, strength) in
        [(16, 0.0105, 0.005, 3.4), (9, 0.01, 0.003, 6.0), (8, 0.0105, 0.005, 3.4), (12, 0.009, 0.004, 4.0)]
    {
        for (radius, z) in [(5e-4, 0.04), (1e-3, 0.05), (1e-3, 0.08), (1.5e-3, 0.06), (1.5e-3, 0.1)] {
            let mut scene = Scene::default();
            (scene.array.rows, scene.array.columns, scene.array.pitch) = (size, size, pitch);
            (scene.array.element_radius, scene.array.strength) = (element_radius, strength);
            // The smaller boards are too weak for places far away.
            if size < 16 && z > 0.06 {
                continue;
            }
            scene.bead.radius = radius;
            scenes += 1;
            let at = dvec3(if scenes % 2 == 0 { 0.004 } else { 0.0 }, 0.0, z);
            scene.targets = vec![target(at, Trap::default())];
            let solution = solver::solve(&scene).unwrap();
            let levitation = Levitation::new(&scene, &Aperture::new(&scene), &solution.drives());
            let hold = levitation.hold(at);
            assert!(hold.holds(), "{size} x {size}, {radius} m at {at}: {hold:?}");
            assert!(hold.rest.distance(at) < 1e-5, "{size} x {size}, {radius} m at {at}: {hold:?}");
            stiffness.push(hold.modes[0].stiffness);
        }
    }
    let mean = stiffness.iter().sum::<f64>() / stiffness.len() as f64;
    println!("{scenes} scenes of one board hold their bead, with {:.3} mN/m on average", 1e3 * mean);
    assert_eq!(scenes, 14);
}

#[test]
fn several_traps_are_stiffer_than_at_the_start() {
    let (mut grown, mut stable) = (Vec::new(), 0);
    for number in 0..50 {
        let mut dice = Dice::new(0x7EAB, number);
        let mut scene = still_air();
        scene.bead.radius = 3e-4;
        let faces = dice.of(0.5);
        if faces {
            scene = facing(scene);
        }
        let kinds = if faces {
            [Trap::Standing, Trap::Twin, Trap::Vortex]
        } else {
            [Trap::Twin, Trap::Vortex, Trap::Bottle]
        };
        let count = dice.whole(2, 8) as usize;
        let mut places: Vec<DVec3> = Vec::new();
        while places.len() < count {
            let at = dvec3(dice.between(-0.05, 0.05), dice.between(-0.05, 0.05), dice.between(0.08, 0.12));
            if places.iter().all(|other| other.distance(at) > 0.02) {
                places.push(at);
            }
        }
        for at in places {
            let angle = dice.between(0.0, 3.0);
            scene.targets.push(Target { angle, ..target(at, dice.one_of(&kinds)) });
        }
        let [before, after] = weakest(&scene);
        assert!(after >= before, "{number}: {before} N/m, then {after}");
        stable += usize::from(after > 0.0);
        // A ratio has a meaning only if the start was stable.
        if before > 0.0 {
            grown.push(after / before);
        }
    }
    let mean = grown.iter().sum::<f64>() / grown.len() as f64;
    println!(
        "{} of 50 are stable at first, and then {mean:.2} times as stiff; in the end {stable} are",
        grown.len()
    );
    // A single board has no stable drive for some sets of traps.
    assert!(stable >= 45, "{stable}");
    assert!(grown.len() > 10 && mean > 1.3, "{mean} of {}", grown.len());
}

#[test]
fn one_trap_starts_from_its_signature() {
    let at = dvec3(0.01, -0.005, 0.09);
    let mut scene = still_air();
    scene.targets = vec![target(at, Trap::Vortex)];
    let aperture = Aperture::new(&scene);
    let problem = Problem::of_scene(&scene, &aperture, outline::foci(&scene).unwrap());
    let own = trap::signature(&problem, problem.traps.as_ref().unwrap());
    let known = focused(&aperture, at, |place| (place.y - at.y).atan2(place.x - at.x));
    for (u, phase) in own.iter().zip(known.phases) {
        assert!((u - num_complex::Complex64::cis(phase)).norm() < 1e-12);
    }
    // Half of the elements around the axis of a bottle, rounded up, are opposed by the others.
    for columns in [4, 5] {
        let mut row = Scene { targets: vec![target(at, Trap::Bottle)], ..still_air() };
        (row.array.rows, row.array.columns) = (1, columns);
        let aperture = Aperture::new(&row);
        let problem = Problem::of_scene(&row, &aperture, outline::foci(&row).unwrap());
        let own = trap::signature(&problem, problem.traps.as_ref().unwrap());
        let mut places: Vec<_> = aperture.positions.iter().zip(own).collect();
        places.sort_by(|(one, _), (other, _)| (one.x - at.x).abs().total_cmp(&(other.x - at.x).abs()));
        let known = focused(&aperture, at, |_| 0.0);
        let phase = |place: &DVec3| known.phases[aperture.positions.iter().position(|p| p == place).unwrap()];
        for (n, (place, u)) in places.iter().enumerate() {
            let sign = if n < places.len().div_ceil(2) { 1.0 } else { -1.0 };
            let expected = sign * num_complex::Complex64::cis(phase(place));
            assert!((u - expected).norm() < 1e-12, "{n} of {columns}");
        }
    }
    for &kind in Trap::VARIANTS {
        scene.targets = vec![target(at, kind)];
        let [before, after] = weakest(&scene);
        assert!(after >= before && after > 0.0, "{kind:?}: {before} {after}");
    }
}

#[test]
fn traps_between_boards_hold_and_keep_the_pressure_of_foci() {
    let mut scene = facing(still_air());
    scene.bead.radius = 3e-4;
    let places = [dvec3(-0.02, 0.0, 0.1), dvec3(0.025, 0.01, 0.095)];
    scene.targets = places.map(|at| target(at, Trap::Standing)).to_vec();
    let focus = dvec3(0.0, -0.03, 0.12);
    scene.targets.push(Target::new(Shape::Point { at: focus }));
    let aperture = Aperture::new(&scene);
    let solution = solver::solve(&scene).unwrap();
    let levitation = Levitation::new(&scene, &aperture, &solution.drives());
    for at in places {
        let hold = levitation.hold(at);
        assert!(hold.outcome == Outcome::Holds && hold.lift > 5.0, "{hold:?}");
        assert!(hold.rest.distance(at) < 1e-3 && hold.nearest_escape().1.distance > 1e-3, "{hold:?}");
    }
    let problem = Problem::of_scene(&scene, &aperture, solution.foci.clone());
    let start = trap::signature(&problem, problem.traps.as_ref().unwrap());
    let moduli: Vec<_> = problem.transfer.pressure(&start).iter().map(|p| p.norm()).collect();
    let [least, most] = [f64::min, f64::max].map(|of| moduli.iter().copied().reduce(of).unwrap());
    assert!(least > 0.5 * most, "the start drives traps and focus alike: {moduli:?}");
    let before = aperture.transfer(&[focus]).pressure(&start)[0].norm();
    let pressure = solution.pressures.last().unwrap().norm();
    assert!(pressure > 0.89 * before, "{pressure} Pa of {before}");
}
