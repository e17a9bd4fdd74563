//! Element tables: our own and those of other programs, by the reader of all tables.

use std::collections::HashMap;

use glam::DVec3;

use crate::acoustics::Aperture;
use crate::device::pat;
use crate::scene::check::MOST_ELEMENTS;
use crate::scene::{Elements, Placed, Scene, Size, Wires};
use crate::table::{Order, Table, TableError};

/// m; larger positions indicate a wrong unit.
const FARTHEST: f64 = 100.0;
/// m; wider arrays, and elements farther apart, are slips of the unit if the table names none.
const WIDEST: f64 = 10.0;
const SPARSEST: f64 = 1.0;
/// Columns of tables without names; those with 9 and 14 are Ultraino's, whose strength, frequency, aperture, type, size and
/// phase are left out.
const ORDERS: [Order; 7] = [
    &["x", "y", "z"],
    &["x", "y"],
    &["x", "y", "z", "nx", "ny", "nz"],
    &["x", "y", "z", "nx", "ny", "nz", "", "", ""],
    &["x", "y", "z", "nx", "ny", "nz", "", "", "", "", "", "", "", ""],
    &["#", "x", "y", "z"],
    &["#", "x", "y", "z", "nx", "ny", "nz"],
];
/// Columns of the elements' numbers.
const NUMBERS: [&str; 3] = ["element", "id", "index"];

/// The elements of a table:
///
/// - columns `x`, `y`, `z` (m, unless the headings name a unit; 0 without `z`), `nx`, `ny` and `nz` (the direction of
///   radiation, of any length; along z without these), by name, in any text layout, JSON, or XML of acoular or Ultraino; if
///   `element`, `id` or `index` numbers them from 0 or 1, in the order of the numbers, otherwise in that of the file;
/// - the same without names, by their number: 2, 3, 6, or Ultraino's 9 and 14; a further first column counts;
/// - `.pat` of OpenMPD and AcousTools: places (m) of elements that radiate along z, and what the file says about driving
///   them.
///
/// # Errors
/// A file of another format, no elements or too many, an invalid row, a position out of range, positions that are
/// millimetres by their size, a missing direction, or two elements at one position.
pub fn read(bytes: &[u8]) -> Result<Elements, TableError> {
    let text = String::from_utf8_lossy(bytes);
    let text = text.trim_start_matches('\u{feff}');
    if pat::is_board(text) {
        return of_board(text);
    }
    let mut table = Table::in_order(bytes, ["x", "y"], ["z", "nx", "ny", "nz"], &ORDERS)?;
    let directions = ["nx", "ny", "nz"];
    if let Some(missing) = directions.into_iter().find(|name| !table.has(name))
        && directions.into_iter().any(|name| table.has(name))
    {
        return Err(table.refusal(format!("the column `{missing}` is missing")));
    }
    let numbers = table.place(&NUMBERS);
    let (mut found, mut order) = (Vec::new(), Vec::new());
    while let Some(row) = table.next_row()? {
        let ([x, y], [z, nx, ny, nz]) = (row.required, row.optional);
        let normal = match (nx, ny, nz) {
            (Some(nx), Some(ny), Some(nz)) => DVec3::new(nx, ny, nz),
            (_, _, _) => DVec3::Z,
        };
        order.push(numbers.and_then(|place| table.text(place).parse::<usize>().ok()));
        found.push((table.line(), Placed { at: DVec3::new(x, y, z.unwrap_or(0.0)), normal }));
        if found.len() as u64 > MOST_ELEMENTS {
            return Err(table.refusal(format!("more than {MOST_ELEMENTS} elements")));
        }
    }
    let unit = if table.has_unit() { Unit::Named } else { Unit::Missing };
    checked(in_order(found, &order), unit).map(|placed| Elements::new(placed, None))
}

/// Where a table says that it is in metres.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Unit {
    Named,
    Missing,
    /// By its format.
    Metres,
}

/// The rows by their numbers, if these are all from 0 or 1.
fn in_order(found: Vec<(u64, Placed)>, numbers: &[Option<usize>]) -> Vec<(u64, Placed)> {
    let Some(first) = numbers.iter().map(|number| number.unwrap_or(usize::MAX)).min().filter(|&it| it <= 1)
    else {
        return found;
    };
    let mut of_number = vec![None; found.len()];
    for (row, number) in numbers.iter().enumerate() {
        let place = number.and_then(|number| of_number.get_mut(number - first));
        match place {
            Some(place @ None) => *place = Some(row),
            Some(Some(_)) | None => return found,
        }
    }
    of_number.into_iter().flatten().map(|row| found[row]).collect()
}

fn of_board(text: &str) -> Result<Elements, TableError> {
    let file = pat::read(text)?;
    let placed =
        file.places.iter().map(|&at| (file.line, Placed { at: at.into(), normal: DVec3::Z })).collect();
    let elements = Elements::new(checked(placed, Unit::Metres)?, None);
    if file.wires.is_empty() {
        return Ok(elements);
    }
    let wires = file.wires.into_iter().map(Some).collect();
    Ok(elements.driven_by(Wires::new(wires, true, None), file.corrections))
}

/// # Errors
/// Positions or directions that no element has, or positions in millimetres by their size.
fn checked(found: Vec<(u64, Placed)>, unit: Unit) -> Result<Vec<Placed>, TableError> {
    if unit != Unit::Named {
        let places: Vec<_> = found.iter().map(|(_, placed)| *placed).collect();
        if let Some(slip) = slip(&places) {
            let hint = match unit {
                Unit::Named | Unit::Metres => "must be metres",
                Unit::Missing => {
                    "if they are millimetres, name the unit in the first line, as in `x [mm],y [mm],z [mm]`; if metres, `x [m]`"
                }
            };
            return Err(refusal(1, format!("{slip}: {hint}")));
        }
    }
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

/// What speaks against metres.
fn slip(places: &[Placed]) -> Option<String> {
    let Size { extent, spacing } = Size::of(places);
    if extent > WIDEST {
        return Some(format!("in metres, the elements span {extent:.1} m"));
    }
    (spacing > SPARSEST).then(|| format!("in metres, the elements are {spacing:.1} m apart"))
}

fn refusal(line: u64, reason: impl Into<String>) -> TableError {
    TableError { line, reason: reason.into() }
}

/// The elements of a scene, board after board, as CSV that [`read`] reads: the columns `x`, `y`, `z` (m), `nx`, `ny` and `nz`.
pub fn of_scene(scene: &Scene) -> String {
    let Aperture { positions, normals, .. } = Aperture::new(scene);
    let places = positions.iter().zip(&normals).map(|(&at, &normal)| Placed { at, normal });
    // Only the unit tells a wide array from a slip.
    let is_wide = slip(&places.collect::<Vec<_>>()).is_some();
    let mut text = String::from(if is_wide { "x [m],y [m],z [m],nx,ny,nz\n" } else { "x,y,z,nx,ny,nz\n" });
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

    /// Three elements in every layout of the next test.
    const PLACES: [[f64; 3]; 3] = [[-0.01, 0.0, 0.0], [0.0, 0.0055, 0.0], [0.01, 0.0, 0.002]];

    /// A table in UTF-16, little-endian, with its mark.
    fn utf_16(text: &str) -> Vec<u8> {
        ["\u{feff}", text].concat().encode_utf16().flat_map(u16::to_le_bytes).collect()
    }

    fn gzip(text: &str) -> Vec<u8> {
        let body = miniz_oxide::deflate::compress_to_vec(text.as_bytes(), 6);
        let sum = text.bytes().fold(!0u32, |sum, byte| {
            (0..8).fold(sum ^ u32::from(byte), |sum, _| (sum >> 1) ^ (0xedb8_8320 * (sum & 1)))
        });
        let head = [0x1f, 0x8b, 8, 0, 0, 0, 0, 0, 0, 255];
        [&head[..], &body, &(!sum).to_le_bytes(), &(text.len() as u32).to_le_bytes()].concat()
    }

    #[test]
    fn layouts_of_many_programs_are_the_same_elements() {
        let xyz = "x,y,z\n-0.01,0,0\n0,0.0055,0\n0.01,0,0.002\n";
        let rows = "-0.01 0 0\n0 0.0055 0\n0.01 0 0.002\n";
        let layouts: [(&str, Vec<u8>); 46] = [
            ("comma", xyz.into()),
            ("capitals", xyz.to_uppercase().into()),
            ("returns", xyz.replace('\n', "\r\n").into()),
            ("only returns", xyz.replace('\n', "\r").into()),
            ("mark of UTF-8", format!("\u{feff}{xyz}").into()),
            ("UTF-16", utf_16(xyz)),
            ("packed", gzip(xyz)),
            ("no line end", xyz.trim_end().into()),
            ("empty last column", xyz.replace('\n', ",\n").into()),
            ("rows end with commas", xyz.replace("0\n", "0,\n").replace("2\n", "2,\n").into()),
            ("quoted names", xyz.replace("x,y,z", "\"x\",\"y\",\"z\"").into()),
            ("semicolons", xyz.replace(',', ";").into()),
            ("decimal commas", xyz.replace(',', ";").replace('.', ",").into()),
            ("tabs", xyz.replace(',', "\t").into()),
            ("tabs and decimal commas", xyz.replace(',', "\t").replace('.', ",").into()),
            ("blanks", xyz.replace(',', "  ").into()),
            ("blanks after commas", xyz.replace(',', ", ").into()),
            ("blanks and decimal commas", xyz.replace(',', " ").replace('.', ",").into()),
            ("no names", rows.into()),
            ("no names, commas", rows.replace(' ', ",").into()),
            ("no names, semicolons, decimal commas", rows.replace(' ', ";").replace('.', ",").into()),
            ("no names, decimal commas", rows.replace('.', ",").into()),
            ("no names, tabs and blanks", rows.replace(' ', " \t").into()),
            ("numpy.savetxt with names", format!("# x y z\n{rows}").into()),
            ("MATLAB's comment", format!("% x, y, z\n{rows}").into()),
            ("C's comments", format!("// three\n\n{rows}// end\n").into()),
            ("comments at lines' ends", rows.replace(" 0\n", " 0 # it\n").into()),
            ("exponents", "-1e-2 0.000e+00 0\n0 5.5E-3 0\n+1.0e-2 0 2e-03\n".into()),
            ("minus signs", xyz.replace('-', "\u{2212}").into()),
            ("millimetres", "x [mm],y [mm],z [mm]\n-10,0,0\n0,5.5,0\n10,0,2\n".into()),
            ("AUTD3", "dev_idx,tr_idx,x[mm],y[mm],z[mm]\n0,0,-10,0,0\n0,1,0,5.5,0\n0,2,10,0,2\n".into()),
            ("underscores", "x_mm;y_mm;z_mm\n-10;0;0\n0;5,5;0\n10;0;2\n".into()),
            ("centimetres", "X (cm)\tY (cm)\tZ (cm)\n-1\t0\t0\n0\t0.55\t0\n1\t0\t0.2\n".into()),
            ("units between blanks", "x [mm] y [mm] z [mm]\n-10 0 0\n0 5.5 0\n10 0 2\n".into()),
            ("a unit after all names", "% x y z in mm\n-10 0 0\n0 5.5 0\n10 0 2\n".into()),
            ("Excel's separator", format!("sep=;\n{}", xyz.replace(',', ";")).into()),
            ("long names", xyz.replace("x,y,z", "Position X,Position Y,Position Z").into()),
            ("units in a comment", "# x/mm y/mm z/mm\n-10 0 0\n0 5.5 0\n10 0 2\n".into()),
            ("other order, directions", "nz,ny,nx,z,y,x\n2,0,0,0,0,-0.01\n2,0,0,0,.0055,0\n2,0,0,.002,0,.01\n".into()),
            ("named and numbered", "name,id,pos_x,pos_y,pos_z\nb,1,0,.0055,0\na,0,-.01,0,0\nc,2,.01,0,.002\n".into()),
            ("counted from 1", "1 -0.01 0 0\n2 0 0.0055 0\n3 0.01 0 0.002\n".into()),
            ("Ultraino", "-.01,0,0,0,0,1,2.4,40000,.009\n0,.0055,0,0,0,1,2.4,40000,.009\n.01,0,.002,0,0,1,2.4,40000,.009\n".into()),
            ("acoular", "<?xml version=\"1.0\"?>\n<MicArray name=\"a\"><pos Name=\"1\" x=\"-0.01\" y=\"0\" z=\"0\"/>\
                <pos x=\"0\" y=\"0.0055\" z=\"0\"/><pos x=\"0.01\" y=\"0\" z=\"0.002\"/></MicArray>".into()),
            ("JSON", "[[-0.01, 0, 0], [0, 0.0055, 0], [0.01, 0, 0.002]]".into()),
            ("JSON of objects", "{\"elements\": [{\"x\": -0.01, \"y\": 0, \"z\": 0, \"name\": \"a\"}, \
                {\"x\": 0, \"y\": 0.0055, \"z\": 0}, {\"x\": 0.01, \"y\": 0, \"z\": 0.002}]}".into()),
            ("JSON of columns", "{\"x\": [-0.01, 0, 0.01], \"y\": [0, 0.0055, 0], \"z\": [0, 0, 0.002]}".into()),
        ];
        for (name, bytes) in layouts {
            let elements = read(&bytes).unwrap_or_else(|error| panic!("{name}: {error}"));
            let placed = elements.get().unwrap();
            assert_eq!(placed.len(), PLACES.len(), "{name}");
            for (placed, place) in placed.iter().zip(PLACES) {
                assert!(placed.at.distance(place.into()) < 1e-15, "{name}: {placed:?}");
                assert_eq!(placed.normal, DVec3::Z, "{name}");
            }
        }
        // Coordinates in lines, as k-Wave has them.
        let line =
            |of: fn(f64) -> f64| (0..20).map(|n| of(f64::from(n)).to_string()).collect::<Vec<_>>().join(" ");
        let lines = [line(|n| n / 100.0), line(|n| n / 200.0), line(|_| 0.0)].join("\n");
        let elements = read(lines.as_bytes()).unwrap();
        let last = elements.get().unwrap()[19].at;
        assert!(elements.get().unwrap().len() == 20 && last.distance(DVec3::new(0.19, 0.095, 0.0)) < 1e-15);
    }

    #[test]
    fn what_is_no_table_of_elements_is_named() {
        let millimetres = "x,y,z\n-10,0,0\n0,5.5,0\n10,0,2\n";
        for (text, error) in [
            (millimetres, "in metres, the elements span 20.0 m: if they are millimetres, name the unit"),
            ("-1 0 0\n0 5 0\n1 0 2\n", "in metres, the elements are 2.8 m apart: if they are millimetres"),
            ("x [mm],y,z\n1,2,3\n", "only some of the columns x, y and z have a unit"),
            ("x,y,z,unit\n1,2,3,mm\n", "2: unit = `mm`: must be in the headings, as `x [mm]`"),
            ("x [kg],y [kg]\n1,2\n", "the column `x` is in `kg`: must be m, cm, mm"),
            ("0,01,0,005,0,0\n0,02,0,005,0,0\n", "part of a number with a decimal comma?"),
            ("x,y,z\n-0,01,0,0\n", "the row has 4 values, and the columns are 3"),
            (
                "0 -0.01 0\n1 0 0\n2 0.01 0\n",
                "the first of 3 columns counts, and they have no names: a line `x,y`",
            ),
            ("1 2 3 4\n5 6 7 8\n", "4 columns without names"),
            ("x;y;z\n1.234,5;0;0\n", "not a finite number"),
            (
                "PK\x03\x04\x14\0\x06\0[Content_Types].xml",
                "this is an Excel workbook (.xlsx): save it as CSV",
            ),
            ("PK\x03\x04\x14\0arr_0.npy", "this is a NumPy archive (.npz)"),
            ("PK\x03\x04\x14\0mimetypeapplication/vnd.oasis.opendocument.spreadsheet", "OpenDocument"),
            ("MATLAB 5.0 MAT-file, Platform", "this is a MATLAB file (.mat)"),
            ("%PDF-1.4\n1 0 obj", "this is a PDF file"),
            ("<!DOCTYPE html><html></html>", "this is an HTML page"),
            ("<svg xmlns=\"http://www.w3.org/2000/svg\"/>", "this is an SVG drawing"),
            ("<Project><x/></Project>", "this is XML of `Project`"),
            (
                "<java><object class=\"acousticfield3d.simulation.Simulation\"/></java>",
                "Ultraino simulation has no",
            ),
            ("{\"devices\": [{\"pos\": [0, 0, 0], \"rot\": [1, 0, 0, 0]}]}", "geometry of AUTD3"),
            ("[{\"pos\": [0, 0, 0], \"rot\": [1, 0, 0, 0]}]", "geometry of AUTD3"),
            ("{\"type\": \"Feature\"}", "this is JSON with `type`"),
            ("solid cap\nfacet normal 0 0 1\n", "this is an STL model"),
            ("format = 1\n[array]\nrows = 2\n", "this is a scene (TOML)"),
            ("import numpy as np\nx = 1\n", "this is a Python program"),
            ("some\0bytes\n", "this is a binary file"),
        ] {
            let refused = read(text.as_bytes()).unwrap_err().to_string();
            assert!(refused.contains(error), "{text:?}: {refused}");
        }
        assert!(read(b"\x1f\x8b\x08broken").unwrap_err().to_string().contains("gzip"));
        assert!(read(b"\x89HDF\r\n\x1a\n").unwrap_err().to_string().contains("HDF5 file (of MATLAB, k-Wave"));
        // A unit settles what the size leaves open.
        assert!(read(millimetres.replace("x,y,z", "x [m],y [m],z [m]").as_bytes()).is_ok());
    }

    #[test]
    fn tables_of_others_are_read() {
        let read = |text: &[u8]| read(text).unwrap().get().unwrap().to_vec();
        let own = read(b"# a note\nnx,ny,nz,x,y,z\n0,0,-2,0.01,0,0.1\n");
        assert_eq!(own, [Placed { at: DVec3::new(0.01, 0.0, 0.1), normal: DVec3::NEG_Z }]);
        let ultraino = read(b"0,0,0,0,0,1\n0.01,0,0,1,0,0\n0.02,0,0,0,3,0\n");
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
            ("0,0,0\n1,2\n", "2: the row has 2 values, and the columns are 3"),
            ("0,0,0\n1,2,x\n", "2: z = `x`: not a finite number"),
            ("TOP\n3\n128\n(0,0,0),(1,0,0),\n", "4: 2 places for 3 elements"),
        ] {
            let refused = read(text.as_bytes()).unwrap_err().to_string();
            assert!(refused.starts_with(error), "{text:?}: {refused}");
        }
    }
}
