//! Surfaces of bodies from files: STL and OBJ.

use std::path::Path;

use crate::mesh::{self, Fault, FormatError};
use crate::scene::Surface;
use crate::source;

/// Bytes of a file, at most.
const MOST_BYTES: u64 = 512 << 20;
/// Endings of files that can be read.
pub const ENDINGS: [&str; 2] = ["stl", "obj"];

/// The surface of an STL or OBJ file, by its ending.
///
/// # Errors
/// A file that cannot be read, of another format, or without a closed surface.
pub fn read(path: &Path) -> Result<Surface, String> {
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    let parse = match &*ending {
        "stl" => mesh::stl,
        "obj" => mesh::obj,
        _ => {
            let name = path.display();
            return Err(format!(
                "{name}: its name ends neither in .stl nor in .obj: save the mesh as one of them"
            ));
        }
    };
    let bytes = source::read(path, MOST_BYTES).map_err(|error| format!("{}: {error}", path.display()))?;
    match parse(&bytes) {
        Ok(mesh) => Ok(Surface::new(mesh, Some(path.to_owned()))),
        Err(error) => Err(message(path, &error)),
    }
}

fn message(path: &Path, error: &FormatError) -> String {
    let path = path.display();
    match error {
        // It begins with the line.
        FormatError::Line { .. } => format!("{path}:{error}"),
        FormatError::Body(Fault::Open { .. } | Fault::Branched { .. } | Fault::Flat) => {
            format!("{path}: {error}; a body needs a closed surface: repair the mesh where it was made")
        }
        FormatError::Body(Fault::Empty | Fault::NotFinite | Fault::NoSuchVertex { .. })
        | FormatError::NotStl { .. }
        | FormatError::Short(_)
        | FormatError::NotText
        | FormatError::TooMany => format!("{path}: {error}"),
    }
}
