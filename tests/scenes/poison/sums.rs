//! Invalid numbers in the mathematics: air, elements, transfer, drives, solver and surfaces.

use std::f64::consts::TAU;

use glam::DVec3;
use num_complex::Complex64;
use sonoglyph::acoustics::{Air, Aperture, Transfer, absorption, directivity, piston_nodes};
use sonoglyph::drive::{Drive, delay_level};
use sonoglyph::scene::{ElementModel, Focus, Liquid, Medium, Method, Scene};
use sonoglyph::solver::{self, Limits, Problem, levels};
use sonoglyph::surface::{Rest, Stretch, Tank, Waves, largest_drive};
use strum::VariantArray;

use crate::poison::{POISON, numbers, panics};

fn scene(model: ElementModel) -> Scene {
    let mut scene = Scene::default();
    (scene.array.rows, scene.array.columns, scene.array.element) = (3, 4, model);
    scene
}

#[test]
fn transfers_are_finite_within_a_thousand_kilometres() {
    for &model in ElementModel::VARIANTS {
        let aperture = Aperture::new(&scene(model));
        let places = [0.0, -0.0, 5e-324, -1e-310, 1e-300, 1e-5, -1e-5, 1e6, -1e6];
        for (x, z) in places.iter().flat_map(|x| places.map(|z| (*x, z))) {
            let at = DVec3::new(x, -x, z);
            assert!(aperture.element.transfer(at).is_finite(), "{model:?} {at}");
            assert!(aperture.transfer(&[at]).row(0).all(|h| h.is_finite()), "{model:?} {at}");
            assert!(aperture.resolution()(at).is_finite(), "{at}");
        }
        for poison in POISON {
            // Farther away: no panic, and integrals terminate.
            aperture.element.transfer(DVec3::splat(poison));
            aperture.element.transfer(DVec3::new(poison, 0.0, 0.1));
            aperture.transfer(&[DVec3::new(0.0, 0.0, poison)]);
            aperture.element.directivity(poison);
        }
        assert!(aperture.transfer(&[]).points == 0);
    }
    for a in POISON {
        for b in POISON {
            assert!(piston_nodes(a, b, a, b) >= 2);
            assert!(piston_nodes(3.7, a, b, 1e-9) >= 2);
        }
        directivity(a);
        assert!(directivity(a).abs() <= 1.0 || !a.is_finite(), "{a}");
    }
}

#[test]
fn air_of_any_weather_does_not_panic() {
    for poison in POISON {
        absorption(poison, 20.0, 50.0, 101_325.0);
        absorption(40e3, poison, 50.0, 101_325.0);
        absorption(40e3, 20.0, poison, poison);
        Air::new(&Medium { temperature: poison, pressure: poison, ..Medium::default() }, poison);
    }
}

#[test]
fn matrices_of_mismatched_sizes_panic() {
    let aperture = Aperture::new(&scene(ElementModel::Piston));
    let transfer = aperture.transfer(&[DVec3::Z, DVec3::X]);
    for count in [0, 1, 11, 13, 1000] {
        assert!(panics(|| transfer.pressure(&vec![Complex64::ONE; count])), "{count} of 12 values");
        assert!(panics(|| transfer.gram(Some(&vec![1.0; count]))), "{count} of 12 weights");
    }
    assert!(panics(|| transfer.back(&[Complex64::ONE])));
    let nothing = Transfer::zeros(0, 0);
    assert!(
        nothing.pressure(&[]).is_empty() && nothing.back(&[]).is_empty() && nothing.gram(None).is_empty()
    );
    // NaN affects only its own row.
    let mut broken = transfer.clone();
    broken.set(0, 3, Complex64::new(f64::NAN, 0.0));
    let heard = broken.pressure(&[Complex64::ONE; 12]);
    assert!(heard[0].is_nan() && heard[1].is_finite());
}

#[test]
fn drives_of_any_numbers_are_in_range() {
    for a in POISON {
        for b in POISON {
            let values = [Complex64::new(a, b), Complex64::ONE];
            for drive in [
                Drive::uniform(2, &[0, 1], &values),
                Drive::of(2, &[0, 1], &values),
                Drive::free(2, &[0, 1], &values),
            ] {
                let is_in_range = |(amplitude, phase): (&f64, &f64)| {
                    amplitude.is_nan()
                        || phase.is_nan()
                        || ((0.0..=1.0).contains(amplitude) && phase.abs() <= TAU / 2.0)
                };
                let known = [a, b].iter().all(|x| x.is_finite() && x.abs() <= 0.7);
                assert!(
                    !known || drive.amplitudes.iter().zip(&drive.phases).all(is_in_range),
                    "{a} {b}: {drive:?}"
                );
                for phase in drive.at_levels(7).phases {
                    assert!(phase.abs() <= TAU / 2.0, "{phase}");
                }
            }
        }
        for levels in [1, 2, 256, u32::MAX] {
            assert!(delay_level(a, levels) < levels, "{a} of {levels}");
        }
    }
    assert!(panics(|| delay_level(1.0, 0)) && panics(|| Drive::uniform(1, &[1], &[Complex64::ONE])));
    assert_eq!(Drive::free(0, &[], &[]), Drive::default());
}

fn focus(position: DVec3, target: f64) -> Focus {
    Focus::new(position, target)
}

#[test]
fn invalid_foci_and_targets_panic() {
    let aperture = Aperture::new(&scene(ElementModel::Piston));
    let problem = |foci: Vec<Focus>| Problem::new(&aperture, foci);
    assert!(panics(|| problem(Vec::new())));
    for poison in POISON {
        let is_place = poison.abs() <= 1e6;
        assert_eq!(panics(|| problem(vec![focus(DVec3::new(poison, 0.0, 0.1), 1.0)])), !is_place, "{poison}");
        let is_target = poison.is_finite() && poison > 0.0;
        assert_eq!(panics(|| problem(vec![focus(DVec3::Z, poison)])), !is_target, "{poison}");
    }
    // As unequal as scenes allow, coincident, on an element, and more than elements.
    let hard = [
        vec![focus(DVec3::Z, 1e-6), focus(DVec3::Z * 2.0, 1e9)],
        vec![focus(DVec3::Z * 0.1, 1.0); 3],
        vec![focus(aperture.positions[0] + DVec3::Z * 1e-9, 1.0), focus(DVec3::Z, 1.0)],
        (0..30).map(|i| focus(DVec3::new(0.001 * f64::from(i), 0.0, 0.1), 1.0)).collect(),
    ];
    for foci in hard {
        let problem = problem(foci);
        let limits = Limits::new(&problem);
        assert!(limits.bound.is_finite() && limits.condition.is_finite(), "{limits:?}");
        for &method in Method::VARIANTS.iter().filter(|method| **method != Method::Focus) {
            for iterations in [0, 1] {
                let excitation = solver::excite(&problem, method, iterations).unwrap();
                assert!(excitation.values.iter().all(|u| u.is_finite()), "{method:?}: {:?}", problem.foci);
                let drive = Drive::uniform(12, &aperture.driven, &excitation.values);
                assert!(panics(|| levels::refined(&problem, &drive, 0)));
                let refined = levels::refined(&problem, &drive, 1);
                assert!(refined.phases.iter().all(|&phase| phase == 0.0), "with one level");
                assert!((0.0..1.0).contains(&levels::expected_part(u32::MAX).mul_add(1.0, -1e-9)));
            }
        }
    }
}

#[test]
fn surfaces_are_finite_if_pressures_are() {
    for counts in [[0, 4], [4, 0], [0, 0]] {
        assert!(panics(|| Tank::new(counts, [0.001; 2])));
    }
    for step in POISON.into_iter().filter(|step| !step.is_normal() || *step <= 0.0) {
        assert!(panics(|| Tank::new([2, 2], [0.001, step])), "{step}");
    }
    let (tank, liquid) = (Tank::new([4, 3], [0.001; 2]), Liquid::default());
    for count in [0, 11, 13, 100] {
        assert!(panics(|| tank.dent(&liquid, &vec![1.0; count])), "{count} of 12 cells");
        assert!(panics(|| tank.surface(vec![1.0; count])) && panics(|| Rest::new(&tank, &vec![1.0; count])));
    }
    for pressure in numbers().filter(|pressure| pressure.abs() <= 1e300) {
        let dent = tank.dent(&liquid, &[pressure; 12]);
        let expected = pressure / (liquid.density() * liquid.gravity);
        assert!(
            dent.depth.iter().all(|depth| (depth - expected).abs() <= 1e-9 * expected.abs() + 1e-307),
            "{pressure}"
        );
    }
    assert!(tank.dent(&liquid, &[f64::NAN; 12]).volume.is_nan(), "NaN stays visible");
    for step in POISON {
        let is_time = (0.0..=1e6).contains(&step);
        let stretch = |step: f64| Stretch { rest: 0, until: step, part: 1.0, rise: 0.5 };
        let (level, rest) = (Waves::new(&tank, &liquid, Vec::new()), [Rest::new(&tank, &[0.001; 12])]);
        assert_eq!(panics(|| level.clone().advance(&rest, &[stretch(step)])), !is_time, "{step} s");
        if is_time {
            let mut waves = level;
            (1..=3).for_each(|i| waves.advance(&rest, &[stretch(f64::from(i) * step)]));
            assert!(waves.surface(&tank).iter().all(|depth| depth.is_finite()), "{step} s");
        }
        assert!(largest_drive(step) >= 0.0, "{step}");
    }
}
