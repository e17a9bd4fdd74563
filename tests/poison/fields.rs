//! Poison in maps, averages, samples, colours and contours.

use glam::{DVec2, DVec3};
use num_complex::Complex32;
use sonoglyph::acoustics::Aperture;
use sonoglyph::drive::Drive;
use sonoglyph::field::cells::Cells;
use sonoglyph::field::interpolation::Resampling;
use sonoglyph::field::plan::Costs;
use sonoglyph::field::{
    self, Average, Colouring, Evaluator, FieldError, Mean, NoGhost, Plan, Quantity, Samples, Scale, Stages,
    Wanted, colouring, contour, ghost, polynomial,
};
use sonoglyph::scene::{Plane, Scene};
use sonoglyph::studio::probe;

use crate::{POISON, SIZES, numbers, panics};

fn aperture() -> Aperture {
    let mut scene = Scene::default();
    (scene.array.rows, scene.array.columns) = (3, 4);
    Aperture::new(&scene)
}

fn drive() -> Drive {
    Drive { amplitudes: vec![1.0; 12], phases: vec![0.5; 12] }
}

fn plane() -> Plane {
    Plane { size: DVec2::splat(0.04), ..Plane::default() }
}

/// Drives that are none: too short, too long, or with a value that is no number.
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
fn maps_have_pixels_and_a_drive_that_is_one() {
    let (aperture, plane, drive) = (aperture(), plane(), drive());
    let mut stages = Stages::new(Evaluator::Cpu);
    let wanted = Wanted { aperture: &aperture, plane: &plane, drive: &drive, width: 8, height: 6 };
    for size in SIZES {
        for (width, height) in [(size, 6), (8, size), (size, size)] {
            let none = Wanted { width, height, ..wanted };
            assert_eq!(stages.map(&none), Err(FieldError::NoPixels(width, height)));
            assert_eq!(stages.read(&none), Err(FieldError::NoPixels(width, height)));
        }
    }
    for drive in broken_drives() {
        assert_eq!(stages.map(&Wanted { drive: &drive, ..wanted }), Err(FieldError::NoDrive), "{drive:?}");
    }
    assert!(stages.read(&wanted).unwrap().iter().all(|p| p.is_finite()), "and goes on after that");
}

#[test]
fn averages_have_drives_and_a_part_of_them() {
    let (aperture, plane, drive) = (aperture(), plane(), drive());
    let mut stages = Stages::new(Evaluator::Cpu);
    let pairs: Vec<_> = broken_drives().into_iter().map(|broken| [drive.clone(), broken]).collect();
    let wanted = |part, width, drives| Average {
        aperture: &aperture,
        plane: &plane,
        drives,
        mean: Mean::Square,
        part,
        width,
        height: 6,
    };
    let error = |stages: &mut Stages, wanted: Average<'_>| stages.average(&wanted).err();
    let one = std::slice::from_ref(&drive);
    assert_eq!(error(&mut stages, wanted(1.0, 8, &[])), Some(FieldError::NoMean));
    for part in POISON {
        let expected = (!(0.0..=1.0).contains(&part)).then_some(FieldError::NoMean);
        assert_eq!(error(&mut stages, wanted(part, 8, one)), expected, "{part}");
    }
    for size in SIZES {
        assert_eq!(error(&mut stages, wanted(1.0, size, one)), Some(FieldError::NoPixels(size, 6)));
    }
    for pair in &pairs {
        assert_eq!(error(&mut stages, wanted(1.0, 8, pair)), Some(FieldError::NoDrive));
    }
}

#[test]
fn planes_that_are_none_have_no_plan_no_samples_and_no_cells() {
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
            let drive = drive();
            let wanted = Wanted { aperture: &aperture, plane: &plane, drive: &drive, width: 5, height: 4 };
            match stages.read(&wanted) {
                Err(error) => assert_eq!(error, FieldError::NoPlane),
                Ok(field) => {
                    assert!(poison.is_finite(), "{index}: {poison}");
                    assert!(field.iter().all(|p| p.is_finite()), "{index}: {poison}");
                }
            }
            Cells::new(&aperture, &plane, 0.01, 1e-3);
            let (foci, drive) = (vec![DVec3::Z * 0.1], self::drive());
            let ghost = ghost::loudest(&mut stages, &aperture, &plane, &drive, &foci);
            assert!(
                ghost.is_err() || ghost.is_ok_and(|ghost| ghost.pressure.is_finite()),
                "{index}: {poison}"
            );
        }
    }
    for poison in POISON {
        let cells =
            [Cells::new(&aperture, &plane(), poison, 1e-3), Cells::new(&aperture, &plane(), 0.01, poison)];
        for cells in cells.into_iter().flatten() {
            assert!(cells.len() <= 1 << 23, "{poison}");
        }
    }
    // As wide, and as many wavelengths wide, as a scene may be.
    let mut scene = Scene::default();
    (scene.array.frequency, scene.medium.sound_speed) = (1e6, Some(1.0));
    scene.plane = Plane { size: DVec2::splat(100.0), tolerance: 1e-3, ..scene.plane };
    let plan = Plan::new(&Aperture::new(&scene), &scene.plane, Costs::CPU).unwrap();
    assert!(plan.grid.is_none(), "{}", plan.reason);
    let none = ghost::loudest(&mut Stages::new(Evaluator::Cpu), &aperture, &plane(), &drive(), &[]);
    assert_eq!(none, Err(NoGhost::NoFocus));
}

#[test]
fn a_broken_sample_spoils_no_other() {
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
        probe::reading(&aperture, &drive, DVec3::new(poison, 0.0, 0.1));
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
fn colours_are_of_the_table_and_lines_on_the_map_whatever_the_numbers() {
    let poison = POISON.map(|x| x as f32);
    let field: Vec<_> = poison.iter().flat_map(|&re| poison.map(|im| Complex32::new(re, im))).collect();
    let table = std::array::from_fn(|i| [i as u8, 1, 2, 255]);
    for quantity in Quantity::ALL {
        for scale in [Scale::Linear, Scale::Logarithmic] {
            for full in poison.map(Some).into_iter().chain([None]) {
                for phase in [0.3, f32::NAN, f32::INFINITY, 1e30] {
                    let colouring = Colouring { scale, full, phase, ..Colouring::new(quantity, table) };
                    let mut colours = Vec::new();
                    colouring.colours(&field, full.unwrap_or(1.0), &mut colours);
                    assert!(
                        colours.len() == field.len()
                            && colours.iter().all(|colour| colour[1..] == [1, 2, 255])
                    );
                    colouring.colours(&[], f32::NAN, &mut colours);
                    assert!(colours.is_empty());
                }
            }
        }
    }
    for number in POISON {
        assert!(colouring::phase_index(number) < 256);
        for width in [0, 1, 12, 1000, usize::MAX] {
            let lines = contour::lines(&poison, width, number as f32, |&x| x);
            assert!(lines.iter().flatten().flatten().all(|place| place.is_finite() || number.is_finite()));
        }
    }
}

#[test]
fn windows_have_taps_and_polynomials_end() {
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
