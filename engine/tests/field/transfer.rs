//! Tables of the transfer in every layout, and several drives as one product.

use glam::{DVec2, DVec3};
use num_complex::{Complex32, Complex64};
use sonoglyph::acoustics::Aperture;
use sonoglyph::drive::Drive;
use sonoglyph::field::plan::Costs;
use sonoglyph::field::slope::shifted;
use sonoglyph::field::transfer::{Layout, Transfer};
use sonoglyph::field::{Plan, Wave, reference};
use sonoglyph::scene::{Plane, Scene};

use crate::scattered;

#[test]
fn a_table_of_any_layout_gives_the_field_of_every_drive() {
    let d = DVec3::new;
    let plane = Plane { size: DVec2::new(0.15, 0.1), ..Plane::default() };
    let planes = [
        ("parallel", plane.clone(), 2),
        ("backwards", Plane { x_axis: -DVec3::X, ..plane.clone() }, 2),
        ("crossed", Plane { x_axis: DVec3::Y, y_axis: DVec3::X, ..plane.clone() }, 2),
        ("vertical", Plane { y_axis: DVec3::Z, ..plane.clone() }, 1),
        ("standing", Plane { x_axis: DVec3::Z, y_axis: -DVec3::Y, ..plane.clone() }, 1),
        ("turned", Plane { x_axis: d(1.0, 0.2, 0.0), ..plane.clone() }, 0),
    ];
    let mut scene = Scene::default();
    (scene.array.rows, scene.array.columns) = (5, 7);
    let aperture = Aperture::new(&scene);
    // Four that are summed together, and one alone.
    let mut drives = [0.754_877_666, 0.569_840_29, 0.618_033_988, 0.819_172_513, 0.671_043_607]
        .map(|step| scattered(35, step));
    drives[1].amplitudes[4] = 0.0;
    for (name, plane, shared) in planes {
        let plan = Plan::new(&aperture, &plane, Costs::CPU).unwrap();
        let grid = plan.grid.unwrap();
        // With and without shared columns, whichever the plan preferred.
        let ([board], [(0, repeats)]) = (&aperture.faces[..], &grid.heard[..]) else { panic!("{name}") };
        let layout = Layout::new(board, &grid.samples, *repeats);
        let wave = Wave::new(&aperture.element, &board.layout, &grid.samples).unwrap();
        assert!(repeats.iter().flatten().count() <= shared, "{name}");
        let transfer = Transfer::new(board, &wave, layout, None);
        let excitation = |drive: &Drive| drive.excitation(&aperture.driven);
        let excitations: Vec<_> = drives.iter().map(excitation).collect();
        let terms = transfer.layout.terms(board, [&excitations[1][..]]);
        assert_eq!(terms.len(), 34, "silent elements are left out");
        let mut fields = vec![vec![Complex32::ZERO; grid.samples.len()]; drives.len()];
        transfer.superpose(board, &excitations, &mut fields);
        for (drive, field) in drives.iter().zip(&fields) {
            let expected = reference::pressure(&aperture, drive, &grid.samples);
            let peak = expected.iter().map(|p| p.norm()).fold(0.0, f64::max);
            assert_eq!(field.len(), expected.len());
            for (p, expected) in field.iter().zip(&expected) {
                let wide = |p: &Complex32| Complex64::new(p.re.into(), p.im.into());
                assert!((wide(p) - expected).norm() < 3e-6 * peak, "{name}: {p} is not {expected}");
            }
        }
    }
}

#[test]
fn a_table_of_slopes_gives_the_slopes_of_the_field() {
    /// m
    const HALF: f64 = 1e-7;
    let plane = Plane { size: DVec2::new(0.03, 0.02), ..Plane::default() };
    let mut scene = Scene { plane: plane.clone(), ..Scene::default() };
    (scene.array.rows, scene.array.columns) = (3, 4);
    let aperture = Aperture::new(&scene);
    let grid = Plan::new(&aperture, &plane, Costs::CPU).unwrap().grid.unwrap();
    let ([board], [(0, repeats)]) = (&aperture.faces[..], &grid.heard[..]) else { panic!("one board") };
    let drive = scattered(12, 0.754_877_666);
    let excitations = [drive.excitation(&aperture.driven)];
    for direction in [DVec3::Z, DVec3::new(0.6, 0.0, 0.8)] {
        let element = &aperture.element;
        let table = Transfer::of_part((element, board), &grid.samples, *repeats, Some(direction), None);
        let mut fields = vec![vec![Complex32::ZERO; grid.samples.len()]];
        table.unwrap().superpose(board, &excitations, &mut fields);
        let [before, behind] = [HALF, -HALF]
            .map(|by| reference::pressure(&aperture, &drive, &shifted(&grid.samples, direction * by)));
        let expected: Vec<_> = before.iter().zip(&behind).map(|(a, b)| (a - b) / (2.0 * HALF)).collect();
        let peak = expected.iter().map(|slope| slope.norm()).fold(0.0, f64::max);
        for (slope, expected) in fields[0].iter().zip(&expected) {
            let off = Complex64::new(slope.re.into(), slope.im.into()) - expected;
            assert!(off.norm() < 2e-4 * peak, "{direction}: {slope} is not {expected}");
        }
    }
}
