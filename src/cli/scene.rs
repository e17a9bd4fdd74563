//! Reading of scenes and writing of answers, shared by the commands.

use std::path::Path;

use anyhow::anyhow;

use crate::acoustics::Aperture;
use crate::cli::arguments::DriveArgs;
use crate::scene::{Method, Scene, file};
use crate::studio::output::Files;
use crate::studio::{opening, output, reach};

/// Width of the name column of printed answers.
pub const COLUMN: usize = 24;

/// The source of a scene's drive on the command line, instead of the scene's own.
#[derive(Clone, Copy, Debug, Default)]
pub struct Source<'a> {
    pub method: Option<Method>,
    /// The file of the drive, which excludes a method.
    pub drive: Option<&'a Path>,
}

impl DriveArgs {
    /// The file's drive, or the scene's.
    pub fn source(&self) -> Source<'_> {
        Source { method: None, drive: self.drive.as_deref() }
    }
}

/// Reads a scene. It and its named files are then refused as outputs.
pub fn read_scene(path: &Path, source: Source<'_>, files: &mut Files) -> anyhow::Result<Scene> {
    files.reads(path)?;
    let mut scene = opening::open(path)?;
    if let Some(method) = source.method {
        scene.solve_by(method);
    }
    if let Some(drive) = source.drive {
        let read = opening::read_drive(drive, drive.display().to_string(), &scene);
        scene.drive = read.map_err(anyhow::Error::msg)?;
        file::targets_in_motion(&scene).map_err(|error| anyhow!("{}: {error}", path.display()))?;
    }
    files.reads_files_of(&scene)?;
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
