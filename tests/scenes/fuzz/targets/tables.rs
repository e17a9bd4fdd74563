//! CSV files of points, drives, calibrations and elements: numbers are within their limits, errors name a line.

use std::f64::consts::PI;
use std::fmt::Write;
use std::sync::LazyLock;

use glam::DVec3;

use sonoglyph::acoustics::Aperture;
use sonoglyph::device::calibration::{Calibration, CalibrationError};
use sonoglyph::drive::{self, Drive};
use sonoglyph::field::{Evaluator, Samples};
use sonoglyph::scene::check::MOST_ELEMENTS;
use sonoglyph::scene::{Array, Elements, Scene};
use sonoglyph::studio::elements;
use sonoglyph::table::TableError;

use super::{has_line, is_one_line};

const ELEMENTS: usize = 4;
/// Limit of points with a computed field.
const MOST_POINTS: usize = 64;

static APERTURE: LazyLock<Aperture> = LazyLock::new(|| {
    Aperture::new(&Scene { array: Array { rows: 2, columns: 2, ..Array::default() }, ..Scene::default() })
});

fn names_a_line(bytes: &[u8], error: &TableError) {
    let message = error.to_string();
    is_one_line(&message);
    assert!(message.len() < 400, "{message}");
    has_line(bytes, error.line as usize);
}

pub fn points(bytes: &[u8]) {
    let samples = match Samples::read(bytes) {
        Ok(samples) => samples,
        Err(error) => return names_a_line(bytes, &error),
    };
    let mut text = String::from("x,y,z\n");
    for point in &samples.columns {
        writeln!(text, "{:?},{:?},{:?}", point.x, point.y, point.z).expect("writing to a String");
    }
    assert_eq!(Samples::read(text.as_bytes()), Ok(samples.clone()));
    if samples.len() > MOST_POINTS {
        return;
    }
    let drive = Drive { amplitudes: vec![1.0; ELEMENTS], phases: vec![0.5, -3.0, PI, 0.0] };
    for evaluator in [Evaluator::Reference, Evaluator::Cpu] {
        let pressures =
            evaluator.pressure(&APERTURE, &drive, &samples).expect("the CPU evaluators do not fail");
        for (point, p) in samples.columns.iter().zip(pressures) {
            assert!(p.is_finite(), "{p} at {point} by {evaluator:?}");
        }
    }
}

pub fn drive(bytes: &[u8]) {
    let table = match drive::read(bytes, &APERTURE) {
        Ok(table) => table,
        Err(error) => return names_a_line(bytes, &error),
    };
    for drive in &table.drives {
        assert_eq!((drive.amplitudes.len(), drive.phases.len()), (ELEMENTS, ELEMENTS));
        assert!(drive.amplitudes.iter().all(|amplitude| (0.0..=1.0).contains(amplitude)), "{drive:?}");
        assert!(drive.phases.iter().all(|&phase| (-PI..=PI).contains(&phase)), "{drive:?}");
    }
    assert!(table.rate.is_none_or(|rate| rate.is_finite() && rate > 0.0), "{table:?}");
    let written = Drive::write_in_turn(&table.drives, &APERTURE);
    let again = drive::read(written.as_bytes(), &APERTURE).expect("the written table can be read");
    assert_eq!(again.drives, table.drives);
}

pub fn calibration(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    match Calibration::parse(text, ELEMENTS) {
        Err(CalibrationError::Row(error)) => names_a_line(bytes, &error),
        Err(error) => is_one_line(&error.to_string()),
        Ok(calibration) => {
            let rows = (0..ELEMENTS).map(|element| calibration.corrected(element, 1.0, 0.0));
            for (amplitude, phase) in rows {
                assert!((0.0..=1.0).contains(&amplitude) && phase.abs() <= 2.0 * PI, "{amplitude} {phase}");
            }
            assert_eq!(
                calibration.corrected(ELEMENTS, 0.5, 0.5),
                (0.5, 0.5),
                "elements beyond the table are unchanged"
            );
        }
    }
}

pub fn elements(bytes: &[u8]) {
    let read = match elements::read(bytes) {
        Ok(read) => read,
        Err(error) => return names_a_line(bytes, &error),
    };
    let placed = read.get().unwrap_or_default().to_vec();
    for one in read.corrections().unwrap_or_default() {
        assert!(one.offset.abs() <= 360.0 && (0.0..=1.0).contains(&one.gain), "{one:?}");
    }
    let wires = read.wires.get().unwrap_or_default();
    assert!([0, placed.len()].contains(&wires.len()) && wires.iter().all(Option::is_some), "{wires:?}");
    assert!((1..=MOST_ELEMENTS as usize).contains(&placed.len()), "{} elements", placed.len());
    for it in &placed {
        assert!(it.at.abs().max_element() <= 100.0 && (it.normal.length() - 1.0).abs() < 1e-12, "{it:?}");
    }
    if placed.len() > MOST_POINTS {
        return;
    }
    let array = Array { placed: Elements::new(placed.clone(), None), ..Array::default() };
    let scene = Scene { array, ..Scene::default() };
    let written =
        elements::read(elements::of_scene(&scene).as_bytes()).expect("the written table can be read");
    let written = written.get().unwrap_or_default();
    let apart =
        written.iter().zip(&placed).map(|(a, b)| a.at.distance(b.at).max(a.normal.distance(b.normal)));
    assert!(written.len() == placed.len() && apart.fold(0.0, f64::max) < 1e-9, "{placed:?}");
    let transfer = Aperture::new(&scene).transfer(&[DVec3::new(0.01, -0.02, 0.1)]);
    assert!(transfer.row(0).all(|pressure| pressure.is_finite()));
}
