//! Scenes as they are opened: the file, and the pictures and the waveform that it names.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use crate::picture::grey;
use crate::scene::check::{Key, KeyError};
use crate::scene::file::{self, FileError};
use crate::scene::{Grey, Modulation, Pixels, Scene, Shape, Target};
use crate::source;
use crate::studio::waveform;

/// Bytes of a picture's file, at most.
const MOST_BYTES: u64 = 64 << 20;

/// The scene of a file, with its pictures and its waveform.
///
/// # Errors
/// Those of [`file::read`], and a picture or a waveform that cannot be read.
pub fn open(path: &Path) -> Result<Scene, FileError> {
    parse(&file::read_text(path)?, path)
}

/// Like [`open`], from text; what it names is looked for beside `path`.
///
/// # Errors
/// As [`open`].
pub fn parse(text: &str, path: &Path) -> Result<Scene, FileError> {
    let mut scene = file::parse(text, path)?;
    load(&mut scene, path.parent().unwrap_or(Path::new("")))
        .map_err(|error| file::located(&error, text, path))?;
    Ok(scene)
}

/// Loads the pictures and the waveform that a scene names, relative to a folder, and checks the scene again if there are pictures.
///
/// # Errors
/// A picture that is not there, unreadable or black, a waveform that [`waveform::read`] refuses, and what
/// [`file::targets_in_motion`] refuses.
pub fn load(scene: &mut Scene, folder: &Path) -> Result<(), KeyError> {
    load_wave(&mut scene.modulation, folder)?;
    if !scene.targets.iter().any(Target::lacks_pixels) {
        return Ok(());
    }
    load_targets(&mut scene.targets, folder)?;
    file::targets_in_motion(scene)
}

/// Loads the waveform of a modulation, if it names one that is not loaded.
///
/// # Errors
/// Those of [`waveform::read`].
pub fn load_wave(modulation: &mut Modulation, folder: &Path) -> Result<(), KeyError> {
    if modulation.lacks_wave() {
        let read = waveform::read(&folder.join(&modulation.file));
        let key = [Key::from("modulation"), Key::from("file")];
        modulation.wave = read.map_err(|message| KeyError::new(key, message))?;
    }
    Ok(())
}

/// Loads the pictures among targets.
///
/// # Errors
/// A picture that is not there, unreadable or black.
pub fn load_targets(targets: &mut [Target], folder: &Path) -> Result<(), KeyError> {
    let mut loaded: HashMap<PathBuf, Pixels> = HashMap::new();
    for (index, target) in targets.iter_mut().enumerate().filter(|(_, target)| target.lacks_pixels()) {
        let Shape::Picture { file, pixels, .. } = &mut target.shape else { continue };
        let path = folder.join(&*file);
        *pixels = match loaded.get(&path) {
            Some(pixels) => pixels.clone(),
            None => {
                let key = [Key::from("target"), Key::from(index), Key::from("file")];
                let read = read(&path).map_err(|message| KeyError::new(key, message))?;
                loaded.insert(path, read.clone());
                read
            }
        };
    }
    Ok(())
}

fn read(path: &Path) -> Result<Pixels, String> {
    let bytes = source::read(path, MOST_BYTES).map_err(|error| format!("{}: {error}", path.display()))?;
    let grey = grey::read(&bytes).map_err(|error| error.to_string())?;
    Ok(Pixels::new(Grey { file: Some(path.to_owned()), ..grey }))
}
