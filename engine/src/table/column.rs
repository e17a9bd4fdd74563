//! Headings of columns: names, their usual variants, and units.
//!
//! A unit follows the name in brackets (`x [mm]`, `x (mm)`), after a stroke (`x/mm`), a blank or an underscore
//! (`x_mm`).

use crate::echo;

/// Units by the quantity, the own one first: name and factor.
type Units = &'static [(&'static str, f64)];

const LENGTHS: Units = &[
    ("m", 1.0),
    ("cm", 1e-2),
    ("mm", 1e-3),
    ("µm", 1e-6),
    ("μm", 1e-6),
    ("um", 1e-6),
    ("nm", 1e-9),
    ("meter", 1.0),
    ("meters", 1.0),
    ("metre", 1.0),
    ("metres", 1.0),
    ("millimeter", 1e-3),
    ("millimeters", 1e-3),
    ("millimetre", 1e-3),
    ("millimetres", 1e-3),
];
const RADIANS: Units = &[
    ("rad", 1.0),
    ("radian", 1.0),
    ("radians", 1.0),
    ("deg", std::f64::consts::PI / 180.0),
    ("degree", std::f64::consts::PI / 180.0),
    ("degrees", std::f64::consts::PI / 180.0),
    ("°", std::f64::consts::PI / 180.0),
    ("turn", std::f64::consts::TAU),
    ("turns", std::f64::consts::TAU),
];
const DEGREES: Units = &[
    ("deg", 1.0),
    ("degree", 1.0),
    ("degrees", 1.0),
    ("°", 1.0),
    ("rad", 180.0 / std::f64::consts::PI),
    ("radians", 180.0 / std::f64::consts::PI),
];
const TIMES: Units = &[("s", 1.0), ("ms", 1e-3), ("µs", 1e-6), ("μs", 1e-6), ("us", 1e-6)];
const FREQUENCIES: Units = &[("hz", 1.0), ("khz", 1e3)];
/// Readings are pressures, and excitations relative.
const STRENGTHS: Units = &[("pa", 1.0), ("kpa", 1e3), ("1", 1.0), ("-", 1.0), ("", 1.0)];
const PARTS: Units = &[("1", 1.0), ("-", 1.0), ("", 1.0), ("%", 1e-2)];
const LEVELS: Units = &[("db", 1.0), ("db spl", 1.0), ("db re 20 µpa", 1.0)];

/// Variants of the names of coordinates, which stand for `?`; blanks, hyphens and points are underscores.
const PLACES: [&str; 10] = [
    "pos_?",
    "?_pos",
    "pos?",
    "?pos",
    "position_?",
    "?_position",
    "p?",
    "?_coordinate",
    "coordinate_?",
    "?_coord",
];
const NORMALS: [&str; 7] = ["n_?", "?_n", "normal_?", "?_normal", "normal?", "dir_?", "direction_?"];

/// The units that a column may have; none for numbers of things.
fn units(name: &str) -> Option<Units> {
    Some(match name {
        "x" | "y" | "z" | "displacement" | "depression" | "height" => LENGTHS,
        "phase" => RADIANS,
        "offset" => DEGREES,
        "time" => TIMES,
        "frequency" => FREQUENCIES,
        "amplitude" | "re" | "im" | "rms" => STRENGTHS,
        "nx" | "ny" | "nz" | "gain" => PARTS,
        "level" => LEVELS,
        _ if name.starts_with("phase_") => RADIANS,
        _ if is_numbered_place(name) => LENGTHS,
        _ => return None,
    })
}

/// Whether a column has one coordinate of one of several things, as `x2`.
fn is_numbered_place(name: &str) -> bool {
    let number = name.strip_prefix(['x', 'y', 'z']).filter(|number| !number.is_empty());
    number.is_some_and(|number| number.bytes().all(|digit| digit.is_ascii_digit()))
}

/// Whether the numbers of a column measure something, rather than count.
pub(crate) fn is_measure(name: &str) -> bool {
    units(name).is_some()
}

/// A column's factor to its own unit, which is that without one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Column {
    pub factor: f64,
    /// The heading names a unit.
    pub has_unit: bool,
}

/// Whether a heading is that of a column. `None`: of another one.
///
/// # Errors
/// A unit that the column cannot have, as a message.
pub(crate) fn of_heading(heading: &str, name: &str) -> Option<Result<Column, String>> {
    let heading = heading.trim();
    if is_name(heading, name) {
        return Some(Ok(Column { factor: 1.0, has_unit: false }));
    }
    if let Some((base, unit)) = bracketed(heading) {
        return is_name(base, name).then(|| in_unit(name, unit));
    }
    let (base, unit) = heading.rsplit_once(['/', ' ', '_'])?;
    let base = base.trim_end_matches([' ', '/']);
    let base = base.strip_suffix(" in").unwrap_or(base);
    let column = in_unit(name, unit).ok().filter(|column| column.has_unit)?;
    is_name(base, name).then_some(Ok(column))
}

/// The name and the unit of `name [unit]` or `name (unit)`.
fn bracketed(heading: &str) -> Option<(&str, &str)> {
    let inner = heading.strip_suffix([']', ')'])?;
    let (base, unit) = inner.rsplit_once(['[', '('])?;
    Some((base.trim_end_matches(['_', ' ']), unit.trim()))
}

fn is_name(heading: &str, name: &str) -> bool {
    if heading.eq_ignore_ascii_case(name) {
        return true;
    }
    let variants: &[&str] = match name {
        "x" | "y" | "z" => &PLACES,
        "nx" | "ny" | "nz" => &NORMALS,
        "time" => &["t", "seconds"],
        "target" => &["id", "trap", "point", "particle"],
        _ if is_numbered_place(name) => return heading.replace('_', "").eq_ignore_ascii_case(name),
        _ => return false,
    };
    let (letter, heading) = (&name[name.len() - 1..], heading.replace([' ', '-', '.'], "_"));
    variants.iter().any(|variant| variant.replace('?', letter).eq_ignore_ascii_case(&heading))
}

fn in_unit(name: &str, unit: &str) -> Result<Column, String> {
    let Some(units) = units(name) else { return Ok(Column { factor: 1.0, has_unit: false }) };
    let lower = unit.trim().to_lowercase();
    match units.iter().find(|(known, _)| *known == lower) {
        Some((known, factor)) => Ok(Column { factor: *factor, has_unit: !["", "-", "1"].contains(known) }),
        None => {
            // Their signs; words are accepted, too.
            let is_sign = |it: &&str| (1..=3).contains(&it.len()) && it.is_ascii();
            let known: Vec<_> = units.iter().map(|(known, _)| *known).filter(is_sign).collect();
            let unit = echo::value(unit);
            Err(format!("the column `{name}` is in `{unit}`: must be {}", known.join(", ")))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headings_name_columns_and_units() {
        for (heading, name, factor) in [
            ("X", "x", Some(1.0)),
            (" x [mm] ", "x", Some(1e-3)),
            ("x[mm]", "x", Some(1e-3)),
            ("Y (cm)", "y", Some(1e-2)),
            ("z/mm", "z", Some(1e-3)),
            ("x / µm", "x", Some(1e-6)),
            ("x_mm", "x", Some(1e-3)),
            ("pos_x", "x", Some(1.0)),
            ("Pos_X_mm", "x", Some(1e-3)),
            ("x in mm", "x", Some(1e-3)),
            ("phase [deg]", "phase", Some(std::f64::consts::PI / 180.0)),
            ("phase_0", "phase_0", Some(1.0)),
            ("offset [rad]", "offset", Some(180.0 / std::f64::consts::PI)),
            ("normal_z", "nz", Some(1.0)),
            ("T (ms)", "time", Some(1e-3)),
            ("y_2 [mm]", "y2", Some(1e-3)),
            ("Position X (mm)", "x", Some(1e-3)),
            ("x", "y", None),
            ("phase_0", "phase", None),
            ("x_left", "x", None),
            ("max", "x", None),
        ] {
            let found = of_heading(heading, name).map(|column| column.unwrap().factor);
            assert_eq!(found, factor, "{heading:?} as {name}");
        }
        assert!(of_heading("x [kg]", "x").unwrap().unwrap_err().contains("must be m, cm, mm"));
    }
}
