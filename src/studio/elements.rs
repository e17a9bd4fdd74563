//! Element tables: our own format, Ultraino's, and those of OpenMPD and AcousTools.

use std::collections::HashMap;

use glam::DVec3;

use crate::acoustics::Aperture;
use crate::device::pat;
use crate::echo;
use crate::scene::check::MOST_ELEMENTS;
use crate::scene::{Elements, Placed, Scene, Wires};
use crate::table::{Table, TableError};

/// m; larger positions indicate a wrong unit.
const FARTHEST: f64 = 100.0;

/// The elements of a table, in its order:
///
/// - CSV with the columns `x`, `y`, `z` (m), `nx`, `ny` and `nz` (the direction of radiation, of any length), by name;
/// - Ultraino's CSV, which has no names: 3, 6, 9 or 14 columns, of which the first three are the place (m, z upwards) and the next three the
///   direction, upwards where they are missing; strength, frequency, aperture and phase are left out;
/// - `.pat` of OpenMPD and AcousTools: places (m) of elements that radiate along z, and what the file says about driving
///   them.
///
/// # Errors
/// No elements or too many, an invalid row, a position out of range, a missing direction, or two elements at one
/// position.
pub fn read(bytes: &[u8]) -> Result<Elements, TableError> {
    let text = String::from_utf8_lossy(bytes);
    let text = text.trim_start_matches('\u{feff}');
    if pat::is_board(text) {
        return of_board(text);
    }
    let lines = || text.lines().enumerate().map(|(index, line)| (index as u64 + 1, line.trim()));
    let mut filled = lines().filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
    let first = filled.next().map_or("", |(_, line)| line);
    let found = if first.split(',').all(|field| field.trim().parse::<f64>().is_ok()) {
        of_ultraino(lines())?
    } else {
        own(text)?
    };
    checked(found).map(|placed| Elements::new(placed, None))
}

fn own(text: &str) -> Result<Vec<(u64, Placed)>, TableError> {
    let mut table = Table::open(text.as_bytes(), ["x", "y", "z", "nx", "ny", "nz"], [])?;
    let mut found = Vec::new();
    while let Some(row) = table.next_row()? {
        let ([x, y, z, nx, ny, nz], []) = (row.required, row.optional);
        let it = Placed { at: DVec3::new(x, y, z), normal: DVec3::new(nx, ny, nz) };
        found.push((table.line(), it));
    }
    Ok(found)
}

fn of_ultraino<'a>(lines: impl Iterator<Item = (u64, &'a str)>) -> Result<Vec<(u64, Placed)>, TableError> {
    let mut found = Vec::new();
    for (line, text) in lines.filter(|(_, text)| !text.is_empty() && !text.starts_with('#')) {
        let fields: Vec<_> = text.split(',').map(str::trim).collect();
        let [x, y, z, rest @ ..] = &fields[..] else {
            return Err(refusal(line, format!("{} columns: a place has three", fields.len())));
        };
        let number = |column: usize, field: &str| match field.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(number),
            _ => {
                Err(refusal(line, format!("column {column} = `{}`: not a finite number", echo::value(field))))
            }
        };
        let at = DVec3::new(number(1, x)?, number(2, y)?, number(3, z)?);
        let normal = match rest {
            [x, y, z, ..] => DVec3::new(number(4, x)?, number(5, y)?, number(6, z)?),
            _ => DVec3::Z,
        };
        found.push((line, Placed { at, normal }));
    }
    Ok(found)
}

fn of_board(text: &str) -> Result<Elements, TableError> {
    let file = pat::read(text)?;
    let placed =
        file.places.iter().map(|&at| (file.line, Placed { at: at.into(), normal: DVec3::Z })).collect();
    let elements = Elements::new(checked(placed)?, None);
    if file.wires.is_empty() {
        return Ok(elements);
    }
    let wires = file.wires.into_iter().map(Some).collect();
    Ok(elements.driven_by(Wires::new(wires, true, None), file.corrections))
}

fn checked(found: Vec<(u64, Placed)>) -> Result<Vec<Placed>, TableError> {
    let (mut placed, mut seen) = (Vec::new(), HashMap::new());
    for (line, Placed { at, normal }) in found {
        let [x, y, z] = at.to_array();
        let is_near = at.abs().max_element() <= FARTHEST;
        if !is_near {
            let reason = format!("x, y, z = {x}, {y}, {z}: must be metres, from -{FARTHEST} to {FARTHEST}");
            return Err(refusal(line, reason));
        }
        let Some(normal) = normal.try_normalize() else {
            let [x, y, z] = normal.to_array();
            return Err(refusal(line, format!("nx, ny, nz = {x}, {y}, {z}: must be a direction")));
        };
        if placed.len() as u64 == MOST_ELEMENTS {
            return Err(refusal(line, format!("more than {MOST_ELEMENTS} elements")));
        }
        // As files have it, -0 is 0.
        if let Some(first) = seen.insert((at + 0.0).to_array().map(f64::to_bits), placed.len()) {
            return Err(refusal(line, format!("the element coincides with element {first}")));
        }
        placed.push(Placed { at, normal });
    }
    if placed.is_empty() { Err(refusal(1, "there are no elements")) } else { Ok(placed) }
}

fn refusal(line: u64, reason: impl Into<String>) -> TableError {
    TableError { line, reason: reason.into() }
}

/// The elements of a scene, board after board, as CSV that [`read`] reads: the columns `x`, `y`, `z` (m), `nx`, `ny` and `nz`.
pub fn of_scene(scene: &Scene) -> String {
    let Aperture { positions, normals, .. } = Aperture::new(scene);
    let mut text = String::from("x,y,z,nx,ny,nz\n");
    for (at, normal) in positions.iter().zip(&normals) {
        let numbers = at.to_array().into_iter().chain(normal.to_array());
        let fields: Vec<_> = numbers.map(|number| format!("{number:?}")).collect();
        text.push_str(&fields.join(","));
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_of_others_are_read() {
        let read = |text: &[u8]| read(text).unwrap().get().unwrap().to_vec();
        let own = read(b"# a note\nnx,ny,nz,x,y,z\n0,0,-2,0.01,0,0.1\n");
        assert_eq!(own, [Placed { at: DVec3::new(0.01, 0.0, 0.1), normal: DVec3::NEG_Z }]);
        let ultraino = read(b"0,0,0\n0.01,0,0,1,0,0\n0.02,0,0,0,3,0,2.4,40000,0.009\n");
        assert_eq!(ultraino.iter().map(|it| it.normal).collect::<Vec<_>>(), [DVec3::Z, DVec3::X, DVec3::Y]);
        let board = read(b"TOP\n2\n128\n(-0.01, 0, 0),(0.01, 0.0, 0),\n0,1,\n0,0,\n1,1,\n");
        assert_eq!(board[1], Placed { at: DVec3::X * 0.01, normal: DVec3::Z });
    }

    #[test]
    fn rows_that_make_no_sense_are_named_by_line_and_column() {
        for (text, error) in [
            ("x,y,z,nx,ny\n", "1: the column `nz` is missing"),
            ("x,y,z,nx,ny,nz\n", "1: there are no elements"),
            ("x,y,z,nx,ny,nz\n0,0,0,0,0,1\n0,0,1,0,0,0\n", "3: nx, ny, nz = 0, 0, 0: must be a direction"),
            ("x,y,z,nx,ny,nz\n0,0,0,0,0,1\n0,-0,0,0,1,0\n", "3: the element coincides with element 0"),
            ("x,y,z,nx,ny,nz\n0,0,1000,0,0,1\n", "2: x, y, z = 0, 0, 1000: must be metres"),
            ("x,y,z,nx,ny,nz\n0,0,one,0,0,1\n", "2: z = `one`: not a finite number"),
            ("0,0,0\n1,2\n", "2: 2 columns: a place has three"),
            ("0,0,0\n1,2,x\n", "2: column 3 = `x`: not a finite number"),
            ("TOP\n3\n128\n(0,0,0),(1,0,0),\n", "4: 2 places for 3 elements"),
        ] {
            let refused = read(text.as_bytes()).unwrap_err().to_string();
            assert!(refused.starts_with(error), "{text:?}: {refused}");
        }
    }
}
