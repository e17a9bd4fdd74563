//! Invalid numbers in maps, formulae, samples, colours and contours.

use glam::{DVec2, DVec3};
use num_complex::Complex32;
use sonoglyph::acoustics::{Air, Aperture};
use sonoglyph::drive::Drive;
use sonoglyph::field::cells::Cells;
use sonoglyph::field::harmonic::NoHarmonic;
use sonoglyph::field::interpolation::Resampling;
use sonoglyph::field::plan::Costs;
use sonoglyph::field::sound::{Constants, Part, Sound};
use sonoglyph::field::{
    self, Colouring, Evaluator, FieldError, NoSideLobe, Plan, Quantity, Request, Samples, Scale, Stages,
    contour, phase_index, polynomial, side_lobe,
};
use sonoglyph::scene::{Focus, Plane, Scene};
use sonoglyph::studio::probe;
use strum::VariantArray;

use crate::poison::{POISON, SIZES, numbers, panics};

fn scene() -> Scene {
    let mut scene = Scene { plane: plane(), ..Scene::default() };
    (scene.array.rows, scene.array.columns) = (3, 4);
    scene
}

fn aperture() -> Aperture {
    Aperture::new(&scene())
}

fn drive() -> Drive {
    Drive { amplitudes: vec![1.0; 12], phases: vec![0.5; 12] }
}

fn plane() -> Plane {
    Plane { size: DVec2::splat(0.04), ..Plane::default() }
}

/// Invalid drives: too short, too long, or with a value that is not a number.
fn broken_drives() -> Vec<Drive> {
    let mut drives = vec![Drive::default()];
    for count in [11, 13] {
        drives.push(Drive { amplitudes: vec![1.0; count], ..drive() });
        drives.push(Drive { phases: vec![1.0; count], ..drive() });
    }
    for poison in POISON.into_iter().filter(|poison| !poison.is_finite()) {
        let (mut amplitude, mut phase) = (drive(), drive());
        (amplitude.amplitudes[5], phase.phases[11]) = (poison, poison);
        drives.extend([amplitude, phase]);
    }
    drives
}

#[test]
fn maps_without_pixels_or_valid_drives_panic() {
    let mut stages = Stages::new(Evaluator::Cpu);
    for quantity in Quantity::ALL {
        let request = Request::new(&scene(), vec![drive()], quantity, (8, 6));
        let mut refused = |broken: Request| {
            let error = stages.map(&broken).err();
            assert_eq!(stages.poll(&broken).err(), error);
            assert_eq!(stages.pressed(&broken).err(), error);
            if error.is_some() {
                assert_eq!(stages.surface(&broken).err(), error);
            }
            error
        };
        for size in SIZES {
            for (width, height) in [(size, 6), (8, size), (size, size)] {
                let none = Request { size: (width, height), ..request.clone() };
                assert_eq!(refused(none), Some(FieldError::NoPixels(width, height)), "{quantity:?}");
            }
        }
        for broken in broken_drives() {
            for drives in [vec![broken.clone()], vec![drive(), broken]] {
                let none = Request { drives: drives.into(), ..request.clone() };
                assert_eq!(refused(none.clone()), Some(FieldError::NoDrive), "{quantity:?} {none:?}");
            }
        }
        assert_eq!(
            refused(Request { drives: Vec::new().into(), ..request.clone() }),
            Some(FieldError::NoMean)
        );
        for poison in POISON {
            let expected = (!(0.0..=1.0).contains(&poison)).then_some(FieldError::NoMean);
            assert_eq!(refused(Request { part: poison, ..request.clone() }), expected, "{poison}");
            let expected = (!poison.is_finite()).then_some(FieldError::NoMean);
            assert_eq!(refused(Request { moment: poison, ..request.clone() }), expected, "{poison}");
        }
        let values = &stages.map(&request).unwrap().values;
        assert!(
            values.iter().all(|value| value.is_finite()),
            "{quantity:?}: the stages still work afterwards"
        );
    }
}

#[test]
fn formulae_accept_any_number() {
    let air = Air::new(&Scene::default().medium, 40e3);
    for quantity in Quantity::ALL {
        for poison in POISON {
            for &part in Part::VARIANTS {
                let mut sound =
                    Sound { p: Complex32::ONE, x: Complex32::I, y: Complex32::I, n: Complex32::ONE };
                *sound.part_mut(part) = Complex32::new(poison as f32, poison as f32);
                let is_read = quantity.declaration().parts & 1 << part as u8 != 0;
                let value = quantity.of(sound, &Constants::new(&air, 733.0, 0.0).narrow());
                assert!(
                    value.is_finite() || (is_read && (poison.is_nan() || poison.abs() >= 1e10)),
                    "{quantity:?} of {sound:?}"
                );
            }
            quantity.of(Sound::default(), &Constants::new(&air, poison, poison).narrow());
            assert!(!quantity.with_unit(poison).is_empty() && !quantity.decibels(poison).is_nan());
        }
    }
}

#[test]
fn invalid_planes_have_no_plan_samples_or_cells() {
    let aperture = aperture();
    let put: [fn(&mut Plane, f64); 5] = [
        |plane, x| plane.centre.x = x,
        |plane, x| plane.centre.z = x,
        |plane, x| plane.size.y = x,
        |plane, x| plane.tolerance = x,
        |plane, x| plane.x_axis = DVec3::new(x, x, 0.0),
    ];
    for (index, put) in put.iter().enumerate() {
        for poison in POISON {
            let mut plane = plane();
            put(&mut plane, poison);
            let mut stages = Stages::new(Evaluator::Cpu);
            for quantity in Quantity::ALL {
                let request = Request {
                    plane: plane.clone(),
                    ..Request::new(&scene(), vec![drive()], quantity, (5, 4))
                };
                match stages.map(&request) {
                    Err(FieldError::TooNear | FieldError::TooManyCells)
                        if quantity.declaration().is_pressed() => {}
                    Err(FieldError::Harmonic(NoHarmonic::TooLarge)) => {}
                    Err(error) => assert_eq!(error, FieldError::NoPlane, "{index}: {poison} {quantity:?}"),
                    Ok(map) => {
                        assert!(poison.is_finite(), "{index}: {poison}");
                        let values = &map.values;
                        assert!(
                            values.iter().all(|value| value.is_finite()),
                            "{index}: {poison} {quantity:?}"
                        );
                    }
                }
            }
            Cells::new(&aperture, &plane, 0.01, 1e-3);
            let (foci, drive) = (vec![Focus::new(DVec3::Z * 0.1, 1.0)], drive());
            let found = side_lobe(&mut stages, &aperture, &plane, std::slice::from_ref(&drive), &foci);
            assert!(
                found.is_err() || found.is_ok_and(|found| found.pressure.is_finite()),
                "{index}: {poison}"
            );
        }
    }
    for poison in POISON {
        let cells =
            [Cells::new(&aperture, &plane(), poison, 1e-3), Cells::new(&aperture, &plane(), 0.01, poison)];
        for cells in cells.into_iter().flatten() {
            assert!(cells.count() <= 1 << 23, "{poison}");
        }
    }
    // The widest plane of a scene, in metres and in wavelengths.
    let mut scene = Scene::default();
    (scene.array.frequency, scene.medium.sound_speed) = (1e6, Some(1.0));
    scene.plane = Plane { size: DVec2::splat(100.0), tolerance: 1e-3, ..scene.plane };
    let plan = Plan::new(&Aperture::new(&scene), &scene.plane, Costs::CPU).unwrap();
    assert!(plan.grid.is_none(), "{}", plan.reason);
    let none = side_lobe(&mut Stages::new(Evaluator::Cpu), &aperture, &plane(), &[drive()], &[]);
    assert_eq!(none, Err(NoSideLobe::NoFocus));
}

#[test]
fn an_invalid_sample_does_not_affect_others() {
    let (aperture, drive) = (aperture(), drive());
    let here = DVec3::new(0.0, 0.01, 0.1);
    let right = Evaluator::Reference.pressure(&aperture, &drive, &Samples::at(vec![here])).unwrap()[0];
    for poison in POISON {
        let samples = Samples::at(vec![here, DVec3::new(poison, 0.0, 0.1), DVec3::new(0.0, 0.0, poison)]);
        for evaluator in [Evaluator::Reference, Evaluator::Cpu] {
            let field = evaluator.pressure(&aperture, &drive, &samples).unwrap();
            assert!(
                (field[0] - right).norm() <= 1e-4 * right.norm(),
                "{evaluator:?} beside {poison}: {}",
                field[0]
            );
        }
        probe::reading(&aperture, std::slice::from_ref(&drive), DVec3::new(poison, 0.0, 0.1));
    }
    let nothing = Samples::on_plane(&plane(), 0, 5).unwrap();
    assert!(nothing.is_empty() && panics(|| nothing.point(0)));
    for evaluator in [Evaluator::Reference, Evaluator::Cpu] {
        assert_eq!(evaluator.pressure(&aperture, &drive, &nothing), Ok(Vec::new()));
        assert_eq!(evaluator.pressure(&aperture, &drive, &Samples::at(Vec::new())), Ok(Vec::new()));
    }
    assert_eq!(field::peak(&[]), 0.0);
}

#[test]
fn colours_and_contours_of_any_numbers_are_in_range() {
    let poison = POISON.map(|x| x as f32);
    let table = std::array::from_fn(|i| [i as u8, 1, 2, 255]);
    for quantity in Quantity::ALL {
        for scale in [Scale::Linear, Scale::Logarithmic] {
            for full in poison.map(Some).into_iter().chain([None]) {
                for peak in poison {
                    let colouring = Colouring { scale, full, ..Colouring::new(quantity, table) };
                    let mut colours = Vec::new();
                    colouring.colours(&poison, peak, &mut colours);
                    assert!(
                        colours.len() == poison.len()
                            && colours.iter().all(|colour| colour[1..] == [1, 2, 255])
                    );
                    colouring.colours(&[], f32::NAN, &mut colours);
                    assert!(colours.is_empty());
                }
            }
        }
    }
    for number in POISON {
        assert!(phase_index(number) < 256);
        for width in [0, 1, 12, 1000, usize::MAX] {
            let lines = contour::lines(&poison, width, number as f32, |&x| x);
            assert!(lines.iter().flatten().flatten().all(|place| place.is_finite() || number.is_finite()));
        }
    }
}

#[test]
fn interpolation_windows_and_polynomials_are_bounded() {
    assert!(panics(|| Resampling::new([1.0].into_iter(), 0, 8.0)));
    for beta in POISON {
        let weights = Resampling::new([3.5, 4.0].into_iter(), 3, beta);
        assert_eq!((weights.len(), weights.weights.len()), (2, 12));
        polynomial::fit(|_| beta, 5);
    }
    assert!(Resampling::new(std::iter::empty(), 3, 8.0).is_empty());
    for position in numbers() {
        assert_eq!(Resampling::new([position].into_iter(), 2, 8.0).weights.len(), 4);
    }
}
