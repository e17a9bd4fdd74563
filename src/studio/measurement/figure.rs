//! Measured, model and difference side by side: maps of planes, profiles of lines and arcs, and the elements.

use std::collections::{BTreeMap, BTreeSet};

use glam::{DVec2, DVec3};

use crate::acoustics::Aperture;
use crate::field::Quantity;
use crate::measure::{Parameter, State};
use crate::picture::ColourMap;
use crate::picture::figure::Axis;
use crate::picture::figure::curve::Curve;
use crate::picture::figure::elements::Elements;
use crate::picture::figure::page::Plot;
use crate::picture::figure::table::Table;
use crate::scene::Plane;
use crate::studio::figure::{Panel, Subject};
use crate::studio::measurement::{Measured, numbers, stated, words};
use crate::studio::scattered::Scattered;

/// Planes that are drawn, at most.
const MOST_PLANES: usize = 2;
/// m: readings that are nearer in a direction are on one plane, or one line.
const THIN: f64 = 2e-3;
/// Elements from which on a picture of them says something.
const MANY: usize = 4;
const RMS: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// Readings of a drive on a plane.
#[derive(Clone, Debug)]
pub struct Sheet {
    pub drive: usize,
    pub plane: Plane,
    /// Their numbers in the scan.
    pub readings: Vec<usize>,
    /// m from the plane's centre, along its axes.
    pub places: Vec<DVec2>,
}

/// The panels of a figure, three columns if there are maps.
pub fn panels(measured: &Measured) -> Vec<Panel> {
    let mut panels = Vec::new();
    let sheets = sheets(measured);
    let (read, model) = (measured.scan.readings.moduli(), measured.fit.model.moduli());
    for sheet in sheets.iter().take(MOST_PLANES) {
        let place = format!(", z {:.0} mm, drive {}", sheet.plane.centre.z * 1e3, sheet.drive);
        let place = if sheets.len() > 1 { place.as_str() } else { "" };
        panels.extend(maps(sheet, (Quantity::Rms, RMS), &read, &model, (measured.fit.residual, place)));
    }
    panels.extend(profile(measured, sheets.first()));
    if measured.fit.vague.is_none() && measured.fit.gains.len() >= MANY {
        panels.extend(elements(measured));
    }
    panels.push(plot("Bench", Plot::Table(table(measured))));
    panels
}

fn plot(name: &str, plot: Plot) -> Panel {
    Panel { name: name.to_owned(), subject: Subject::Plot(Box::new(plot)) }
}

/// Planes of readings along two axes of space, each with many places.
fn sheets(measured: &Measured) -> Vec<Sheet> {
    /// Places below which a plane is a line.
    const LEAST: usize = 25;
    let scan = &measured.scan;
    let index = |value: f64| (value / THIN).round() as i64;
    for normal in [2, 1, 0] {
        let mut of_plane: BTreeMap<(usize, i64), Vec<usize>> = BTreeMap::new();
        for (reading, (point, &drive)) in scan.points.iter().zip(&scan.drives).enumerate() {
            of_plane.entry((drive, index(point[normal]))).or_default().push(reading);
        }
        let sheets: Vec<_> = of_plane
            .into_iter()
            .filter(|(_, readings)| readings.len() >= LEAST)
            .filter_map(|((drive, _), readings)| sheet(measured, normal, drive, readings))
            .collect();
        if sheets.iter().map(|sheet| sheet.readings.len()).sum::<usize>() * 2 > scan.points.len() {
            return sheets;
        }
    }
    Vec::new()
}

fn sheet(measured: &Measured, normal: usize, drive: usize, readings: Vec<usize>) -> Option<Sheet> {
    let (x_axis, y_axis) = [(DVec3::Y, DVec3::Z), (DVec3::X, DVec3::Z), (DVec3::X, DVec3::Y)][normal];
    let points = &measured.scan.points;
    let place = |reading: usize| DVec2::new(points[reading].dot(x_axis), points[reading].dot(y_axis));
    let places: Vec<_> = readings.iter().map(|&reading| place(reading)).collect();
    let low = places.iter().fold(DVec2::MAX, |low, at| low.min(*at));
    let high = places.iter().fold(DVec2::MIN, |high, at| high.max(*at));
    if (high - low).min_element() < THIN {
        return None;
    }
    // Half a spacing beyond the outermost places.
    let spacing = ((high - low).element_product() / readings.len() as f64).sqrt();
    let middle = (low + high) / 2.0;
    let height = readings.iter().map(|&reading| points[reading][normal]).sum::<f64>() / readings.len() as f64;
    let centre = x_axis * middle.x + y_axis * middle.y + DVec3::AXES[normal] * height;
    let plane = Plane { centre, x_axis, y_axis, size: high - low + spacing, ..Plane::default() };
    let places: Vec<_> = places.iter().map(|at| at - middle).collect();
    let is_covered = is_covered(&places, high - low, spacing);
    is_covered.then_some(Sheet { drive, plane, readings, places })
}

/// Whether places (m from the middle) spread over a rectangle rather than along a line or an arc in it.
fn is_covered(places: &[DVec2], size: DVec2, spacing: f64) -> bool {
    /// Part of the cells with a place in them.
    const COVERED: f64 = 0.6;
    let cells = (size / (1.5 * spacing)).ceil().max(DVec2::ONE);
    let cell = |at: &DVec2| ((at / size + 0.5) * cells).floor().min(cells - 1.0).as_ivec2().to_array();
    let met: BTreeSet<_> = places.iter().map(cell).collect();
    met.len() as f64 > COVERED * cells.element_product()
}

/// Measured, model and difference of a plane: `read` and `model` have a value per reading of the scan, in units of which
/// one is so many of the quantity's; the residual is named, and so is the plane if there are several.
pub fn maps(
    sheet: &Sheet,
    (quantity, factor): (Quantity, f64),
    read: &[f64],
    model: &[f64],
    (residual, place): (f64, &str),
) -> [Panel; 3] {
    let panel = |name: String, is_difference: bool, value: &dyn Fn(usize) -> f64| Panel {
        name: format!("{name}{place}"),
        subject: Subject::Scattered(Box::new(Scattered {
            quantity,
            plane: sheet.plane.clone(),
            places: sheet.places.clone(),
            values: sheet.readings.iter().map(|&reading| (factor * value(reading)) as f32).collect(),
            is_difference,
        })),
    };
    let difference = format!("Measured − model, {:.1} %", 100.0 * residual);
    [
        panel("Measured".to_owned(), false, &|reading| read[reading]),
        panel("Model".to_owned(), false, &|reading| model[reading]),
        panel(difference, true, &|reading| read[reading] - model[reading]),
    ]
}

/// Readings and model along the row of a plane with the loudest reading.
pub fn row_of_loudest(sheet: &Sheet, of: (f64, &str), read: &[f64], model: &[f64]) -> Option<Panel> {
    let loudest = (0..sheet.readings.len())
        .max_by(|&a, &b| read[sheet.readings[a]].total_cmp(&read[sheet.readings[b]]))?;
    let row = sheet.places[loudest].y;
    let own = (0..sheet.readings.len()).filter(|&i| (sheet.places[i].y - row).abs() < THIN / 2.0);
    let middle = sheet.plane.centre.dot(sheet.plane.x_axis);
    let along = own.map(|i| ((sheet.places[i].x + middle) * 1e3, sheet.readings[i])).collect();
    let axis = if sheet.plane.x_axis == DVec3::Y { "y / mm" } else { "x / mm" };
    curve(Line { along, axis, name: "Row of the loudest reading" }, of, (read, model))
}

/// Places of readings along an axis, with the readings' numbers in the scan.
struct Line {
    along: Vec<(f64, usize)>,
    axis: &'static str,
    name: &'static str,
}

/// Readings as dots beside the model's curve.
fn curve(
    Line { mut along, axis, name }: Line,
    (factor, label): (f64, &str),
    (read, model): (&[f64], &[f64]),
) -> Option<Panel> {
    along.sort_by(|a, b| a.0.total_cmp(&b.0));
    let value = |of: &[f64], &(at, reading): &(f64, usize)| [at, factor * of[reading]];
    let points: Vec<_> = along.iter().map(|it| value(model, it)).collect();
    let dots: Vec<_> = along.iter().map(|it| value(read, it)).collect();
    let (low, high) = points
        .iter()
        .chain(&dots)
        .fold((0.0f64, 0.0f64), |(low, high), [_, value]| (low.min(*value), high.max(*value)));
    let (&(first, _), &(last, _)) = (along.first()?, along.last()?);
    (last > first && high > low).then(|| {
        let axes = [
            Axis { ends: [first, last], label: axis.to_owned() },
            Axis { ends: [1.05 * low, 1.05 * high], label: label.to_owned() },
        ];
        plot(
            &format!("{name}: readings (dots), model"),
            Plot::Curve(Curve { axes, points, dots, ..Curve::default() }),
        )
    })
}

/// Readings and model along a line: a row of the first plane, or else the scan's own line or arc.
fn profile(measured: &Measured, sheet: Option<&Sheet>) -> Option<Panel> {
    const PRESSURE: (f64, &str) = (RMS, "RMS pressure / Pa");
    let (read, model) = (measured.scan.readings.moduli(), measured.fit.model.moduli());
    if let Some(sheet) = sheet {
        return row_of_loudest(sheet, PRESSURE, &read, &model);
    }
    curve(of_line(measured)?, PRESSURE, (&read, &model))
}

/// Readings of a scan without planes against the angle or the distance from the only driven element, or against the axis
/// along which they spread.
fn of_line(measured: &Measured) -> Option<Line> {
    let points = &measured.scan.points;
    let readings = 0..points.len();
    let driven: Vec<_> =
        (0..measured.fit.states.len()).filter(|&n| measured.fit.states[n] != State::Undriven).collect();
    if let [element] = driven[..] {
        let aperture = Aperture::new(&measured.scene);
        let (at, normal) = (aperture.positions[element], aperture.normals[element]);
        let distance = |reading: usize| (points[reading] - at).length();
        let (near, far) = readings
            .clone()
            .map(distance)
            .fold((f64::MAX, 0.0), |(a, b): (f64, f64), d| (a.min(d), b.max(d)));
        // To either side of the array's x axis, as it is turned.
        let angle = |reading: usize| {
            let offset = points[reading] - at;
            let side = if offset.x + 1e-9 * offset.y < 0.0 { -1.0 } else { 1.0 };
            side * (offset.dot(normal) / offset.length()).clamp(-1.0, 1.0).acos().to_degrees()
        };
        let line = |place: &dyn Fn(usize) -> f64, axis, name| Line {
            along: readings.clone().map(|reading| (place(reading), reading)).collect(),
            axis,
            name,
        };
        return Some(match far < 1.1 * near {
            true => line(&angle, "angle / °", "Angles of one element"),
            false => line(&|reading| distance(reading) * 1e3, "distance / mm", "Distances of one element"),
        });
    }
    let low = points.iter().fold(DVec3::MAX, |low, at| low.min(*at));
    let high = points.iter().fold(DVec3::MIN, |high, at| high.max(*at));
    let spread = high - low;
    let axis = (0..3).max_by(|&a, &b| spread[a].total_cmp(&spread[b]))?;
    let along = readings.map(|i| (points[i][axis] * 1e3, i)).collect();
    (spread[axis] > THIN).then(|| Line { along, axis: ["x / mm", "y / mm", "z / mm"][axis], name: "Line" })
}

/// Phases and gains of the elements.
fn elements(measured: &Measured) -> [Panel; 2] {
    let fit = &measured.fit;
    let of = |value: &dyn Fn(usize) -> f64, leaves_out: &dyn Fn(State) -> bool| -> Vec<f64> {
        (0..fit.gains.len()).map(|n| if leaves_out(fit.states[n]) { f64::NAN } else { value(n) }).collect()
    };
    let is_silent = |state| matches!(state, State::Dead | State::Undriven);
    let phases = of(&|n| fit.gains[n].arg().to_degrees(), &is_silent);
    let gains = of(&|n| fit.gains[n].norm(), &|state| state == State::Undriven);
    let most = gains.iter().copied().filter(|gain| !gain.is_nan()).fold(1.0, f64::max);
    let scene = &measured.scene;
    [
        plot(
            "Phase error per element",
            Plot::Elements(Elements::values(
                scene,
                &phases,
                [-180.0, 180.0],
                "phase error / °",
                ColourMap::Cyclic,
            )),
        ),
        plot(
            "Gain per element",
            Plot::Elements(Elements::values(scene, &gains, [0.0, most], "gain", ColourMap::Viridis)),
        ),
    ]
}

/// Strength and bench with their errors.
fn table(measured: &Measured) -> Table {
    let row = |name: &str, value: f64, error: f64, unit: &str, is_free: bool| {
        let [value, error] = numbers(value, error);
        let state = if is_free { "fitted" } else { "held" };
        vec![name.to_owned(), value, error, unit.to_owned(), state.to_owned()]
    };
    let strength = measured.strength();
    let mut rows = vec![row("strength", strength.value, strength.error, "Pa·m", true)];
    for parameter in Parameter::ALL {
        let estimate = measured.parameter(parameter);
        let (value, error) = stated(parameter, estimate.value, estimate.error);
        let (name, unit) = words(parameter);
        rows.push(row(name, value, error, unit, estimate.is_free));
    }
    let head = ["", "value", "±", "unit", ""].map(str::to_owned).to_vec();
    Table { head, rows }
}
