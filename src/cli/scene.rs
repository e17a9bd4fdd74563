//! Reading of scenes and writing of answers, shared by the commands.

use std::path::Path;

use crate::acoustics::Aperture;
use crate::scene::{Method, Scene};
use crate::studio::output::Files;
use crate::studio::{opening, output, reach};

/// Width of the name column of printed answers.
pub const COLUMN: usize = 24;

/// Reads a scene, with `method` instead of its own. It and its named files are then refused as outputs.
pub fn read_scene(path: &Path, method: Option<Method>, files: &mut Files) -> anyhow::Result<Scene> {
    files.reads(path)?;
    let mut scene = opening::open(path)?;
    files.reads_files_of(&scene)?;
    if let Some(method) = method {
        scene.solver.method = method;
    }
    reach::cut_short(&Aperture::new(&scene)).iter().for_each(|warning| output::warn(&warning.to_string()));
    Ok(scene)
}

/// Writes to the file, by default to standard output.
pub fn write_or_print(path: Option<&Path>, text: &str) -> anyhow::Result<()> {
    match path {
        Some(path) => output::write(path, text.as_bytes()),
        None => output::print(format_args!("{text}")),
    }
}
