//! Files of triangles: STL, as text and binary, and OBJ.

use glam::DVec3;
use thiserror::Error;

use crate::mesh::closed::{Fault, Mesh};

/// Most triangles that are read.
const MOST: usize = 2_000_000;

/// A file that holds no body.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum FormatError {
    #[error("{line}: {text}: expected {expected}")]
    Line { line: usize, text: String, expected: &'static str },
    #[error(
        "not an STL file: neither text that begins with `solid` nor {count} binary triangles in {bytes} bytes"
    )]
    NotStl { count: u32, bytes: usize },
    #[error("not an STL file: it has {0} bytes")]
    Short(usize),
    #[error("not a text file (UTF-8)")]
    NotText,
    #[error("more than {MOST} triangles")]
    TooMany,
    #[error(transparent)]
    Body(#[from] Fault),
}

/// The body of an STL file, in the file's unit.
///
/// # Errors
/// Bytes that are no STL file, and surfaces that bound no body.
pub fn stl(bytes: &[u8]) -> Result<Mesh, FormatError> {
    if let Some(count) = bytes.get(80..84).and_then(|count| count.first_chunk())
        && let count = u32::from_le_bytes(*count)
        && bytes.len() as u64 == 84 + 50 * u64::from(count)
    {
        return binary(&bytes[84..]);
    }
    let start = bytes.trim_ascii_start();
    if start.starts_with(b"solid") {
        return text(std::str::from_utf8(bytes).map_err(|_| FormatError::NotText)?);
    }
    match bytes.get(80..84).and_then(|count| count.first_chunk()) {
        Some(count) => Err(FormatError::NotStl { count: u32::from_le_bytes(*count), bytes: bytes.len() }),
        None => Err(FormatError::Short(bytes.len())),
    }
}

fn binary(bytes: &[u8]) -> Result<Mesh, FormatError> {
    let (triangles, _) = bytes.as_chunks::<50>();
    if triangles.len() > MOST {
        return Err(FormatError::TooMany);
    }
    let mut mesh = Mesh::default();
    for triangle in triangles {
        // A normal, three corners and two bytes of attributes; corners alone count.
        let (numbers, _) = triangle[12..48].as_chunks::<4>();
        let first = mesh.vertices.len() as u32;
        for corner in numbers.chunks(3) {
            let [x, y, z] = [0, 1, 2].map(|axis| f64::from(f32::from_le_bytes(corner[axis])));
            mesh.vertices.push(DVec3::new(x, y, z));
        }
        mesh.triangles.push([first, first + 1, first + 2]);
    }
    Ok(mesh.closed()?)
}

fn text(text: &str) -> Result<Mesh, FormatError> {
    let mut mesh = Mesh::default();
    let mut corners = Vec::new();
    for (number, line) in text.lines().enumerate() {
        let mut words = line.split_ascii_whitespace();
        match words.next() {
            Some("vertex") => corners.push(point(words, (number, line))?),
            Some("endloop") => {
                if corners.len() != 3 {
                    return Err(wrong((number, line), "three lines `vertex x y z` before it"));
                }
                let first = mesh.vertices.len() as u32;
                mesh.vertices.append(&mut corners);
                mesh.triangles.push([first, first + 1, first + 2]);
            }
            Some("solid" | "facet" | "outer" | "endfacet" | "endsolid") | None => {}
            Some(_) => return Err(wrong((number, line), "a line of an STL file, such as `vertex x y z`")),
        }
        if mesh.triangles.len() > MOST {
            return Err(FormatError::TooMany);
        }
    }
    Ok(mesh.closed()?)
}

/// The body of an OBJ file, in the file's unit: vertices and faces, polygons as fans of triangles.
///
/// # Errors
/// The line that is wrong, and surfaces that bound no body.
pub fn obj(bytes: &[u8]) -> Result<Mesh, FormatError> {
    let text = std::str::from_utf8(bytes).map_err(|_| FormatError::NotText)?;
    let mut mesh = Mesh::default();
    for (number, line) in text.lines().enumerate() {
        let mut words = line.split('#').next().unwrap_or_default().split_ascii_whitespace();
        match words.next() {
            Some("v") => {
                let at = point(words, (number, line))?;
                mesh.vertices.push(at);
            }
            Some("f") => {
                let count = mesh.vertices.len();
                let corner = |word: &str| -> Option<u32> {
                    // vertex/texture/normal; negative ones count from the newest.
                    let index: i64 = word.split('/').next()?.parse().ok()?;
                    let index = if index < 0 { count as i64 + index } else { index - 1 };
                    (0..count as i64).contains(&index).then_some(index as u32)
                };
                let corners: Option<Vec<_>> = words.map(corner).collect();
                let corners = corners.filter(|corners| corners.len() >= 3).ok_or_else(|| {
                    wrong((number, line), "`f a b c ...` with numbers of three or more vertices above it")
                })?;
                mesh.triangles.extend(corners[1..].windows(2).map(|pair| [corners[0], pair[0], pair[1]]));
            }
            // Textures, normals, groups, materials and lines bound no body.
            Some(_) | None => {}
        }
        if mesh.triangles.len() > MOST {
            return Err(FormatError::TooMany);
        }
    }
    Ok(mesh.closed()?)
}

fn point<'a>(words: impl Iterator<Item = &'a str>, place: (usize, &str)) -> Result<DVec3, FormatError> {
    let numbers: Vec<f64> =
        words.map_while(|word| word.parse().ok()).filter(|x: &f64| x.is_finite()).collect();
    match numbers[..] {
        [x, y, z, ..] => Ok(DVec3::new(x, y, z)),
        _ => Err(wrong(place, "three numbers")),
    }
}

fn wrong((number, line): (usize, &str), expected: &'static str) -> FormatError {
    let text = line.trim().chars().take(60).collect();
    FormatError::Line { line: number + 1, text, expected }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    fn body() -> Mesh {
        shapes::geodesic(1.0, 2)
    }

    fn as_text(mesh: &Mesh) -> String {
        let mut text = "solid ball\n".to_owned();
        for triangle in 0..mesh.triangles.len() {
            text += "facet normal 0 0 0\n outer loop\n";
            for corner in mesh.corners(triangle) {
                text += &format!("  vertex {} {} {}\n", corner.x, corner.y, corner.z);
            }
            text += " endloop\nendfacet\n";
        }
        text + "endsolid ball\n"
    }

    fn as_binary(mesh: &Mesh) -> Vec<u8> {
        // A header that begins like text.
        let mut bytes = b"solid by a program that writes binary files".to_vec();
        bytes.resize(80, b' ');
        bytes.extend((mesh.triangles.len() as u32).to_le_bytes());
        for triangle in 0..mesh.triangles.len() {
            bytes.extend([0; 12]);
            for corner in mesh.corners(triangle) {
                corner.to_array().into_iter().for_each(|x| bytes.extend((x as f32).to_le_bytes()));
            }
            bytes.extend([0; 2]);
        }
        bytes
    }

    #[test]
    fn one_body_in_every_format_is_one_body() {
        let mesh = body();
        let mut text = "# ball\n".to_owned();
        mesh.vertices.iter().for_each(|at| text += &format!("v {} {} {}\n", at.x, at.y, at.z));
        for [a, b, c] in &mesh.triangles {
            text += &format!("f {}/1/1 {}//2 -{}\n", a + 1, b + 1, mesh.vertices.len() as u32 - c);
        }
        let read = [stl(as_text(&mesh).as_bytes()), stl(&as_binary(&mesh)), obj(text.as_bytes())];
        for read in read {
            let read = read.unwrap();
            assert_eq!((read.vertices.len(), read.triangles.len()), (42, 80));
            assert!((read.volume() / mesh.volume() - 1.0).abs() < 1e-6, "{}", read.volume());
        }
    }

    #[test]
    fn errors_name_the_line_and_what_would_be_right() {
        let text = as_text(&body());
        let message = |result: Result<Mesh, FormatError>| result.unwrap_err().to_string();
        let bad = text.replacen("  vertex", "  vertex up", 1);
        assert!(message(stl(bad.as_bytes())).starts_with("4: vertex up"), "{}", message(stl(bad.as_bytes())));
        assert!(message(stl(bad.as_bytes())).ends_with("expected three numbers"));
        let cut = &text[..text.len() / 2];
        let error = message(stl(&cut.as_bytes()[..cut.rfind("facet normal").unwrap()]));
        assert!(error.starts_with("the surface is not closed"), "{error}");
        assert_eq!(message(stl(b"PNG")), "not an STL file: it has 3 bytes");
        let mut binary = as_binary(&body());
        binary[0] = b'x';
        binary.pop();
        assert!(message(stl(&binary)).contains("80 binary triangles in 4083 bytes"));
        let error = message(obj(b"v 0 0 0\nv 1 0 0\nf 1 2 3\n"));
        assert!(error.starts_with("3: f 1 2 3: expected"), "{error}");
        assert_eq!(message(obj(b"")), "the surface has no triangles");
    }
}
