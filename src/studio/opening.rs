//! Opens scenes: the file, and the pictures, waveforms, thresholds, paths, directivity, drives, elements, wires and
//! surfaces of bodies that it names.
//!
//! A scene file names a picture; opening loads the pixels, which the scene then shares and the file never contains.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use crate::acoustics::Aperture;
use crate::device::{pat, wiring};
use crate::drive;
use crate::picture::grey;
use crate::scene::check::check;
use crate::scene::file::{self, FileError};
use crate::scene::{
    Array, Body, DriveFile, Elements, Grey, Key, KeyError, Motion, Pixels, Scene, Skin, Surface, Target,
    Wires,
};
use crate::source;
use crate::studio::{arrays, directivity, elements, routes, surfaces, thresholds, waveform};

/// Bytes of a picture's or a table's file, at most.
const MOST_BYTES: u64 = 64 << 20;
/// The same of a file of drives.
const MOST_BYTES_OF_DRIVES: u64 = 512 << 20;

/// Extensions of scene files, the default first. Desktops recognise the other, and `.sonoglyph.toml`, as scenes.
pub const ENDINGS: &[&str] = &["toml", "sonoglyph"];

/// The name of a file without folder and extension; of a scene without `.sonoglyph.toml`.
pub fn stem(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or(path.as_os_str()).to_string_lossy();
    stem.strip_suffix(".sonoglyph").filter(|name| !name.is_empty()).unwrap_or(&stem).to_owned()
}

/// The scene of a file, with its pictures, waveforms, thresholds, paths, directivity, drives, surfaces of bodies, and
/// tables of elements and wires.
///
/// # Errors
/// The errors of [`file::read`], and a picture, a waveform, thresholds, a path, drives, a mesh or a table that cannot be read.
pub fn open(path: &Path) -> Result<Scene, FileError> {
    parse(&file::read_text(path)?, path)
}

/// Like [`open`], from text; named files are relative to `path`.
///
/// # Errors
/// The errors of [`open`].
pub fn parse(text: &str, path: &Path) -> Result<Scene, FileError> {
    let mut scene = file::parse(text, path)?;
    load(&mut scene, path.parent().unwrap_or(Path::new("")))
        .map_err(|error| file::located(&error, text, path))?;
    Ok(scene)
}

/// Loads the pictures, waveforms, thresholds, paths, directivity, drives, elements, wires and surfaces named by a scene,
/// relative to a folder, and checks the scene again if there are pictures, paths, drives, meshes or a table.
///
/// # Errors
/// A missing, unreadable or black picture, errors of [`waveform::read`], [`thresholds::read`], [`routes::read`] and
/// [`surfaces::read`], a missing or invalid table, and errors of [`check()`] and [`file::targets_in_motion`].
pub fn load(scene: &mut Scene, folder: &Path) -> Result<(), KeyError> {
    load_waves(scene, folder)?;
    load_thresholds(scene.skin.as_mut(), folder)?;
    load_directivity(&mut scene.array, folder)?;
    let has_routes = load_routes(scene, folder)?;
    let has_bodies = load_bodies(&mut scene.bodies, folder)?;
    let lacks_table = scene.array.lacks_elements() || scene.array.lacks_wires() || scene.drive.is_missing();
    if !scene.targets.iter().any(Target::lacks_pixels) && !lacks_table {
        if has_bodies {
            check(scene)?;
        }
        let is_whole = has_routes && !scene.lacks_pixels();
        return if is_whole { file::targets_in_motion(scene) } else { Ok(()) };
    }
    load_targets(&mut scene.targets, folder)?;
    load_elements(&mut scene.array, folder)?;
    load_wires(scene, folder)?;
    check(scene)?;
    if scene.drive.is_missing() {
        let name = scene.drive.name.clone();
        let read = read_drive(&folder.join(&name), name, scene);
        scene.drive = read.map_err(|message| KeyError::new([Key::from("drive")], message))?;
    }
    if scene.lacks_pixels() { Ok(()) } else { file::targets_in_motion(scene) }
}

/// Loads the table of elements that an array names, if it names one.
///
/// # Errors
/// A missing or invalid table.
pub fn load_elements(array: &mut Array, folder: &Path) -> Result<(), KeyError> {
    if let Some(name) = array.file.as_ref().filter(|_| array.lacks_elements()) {
        array.placed = placed(name, folder)
            .map_err(|message| KeyError::new([Key::from("array"), Key::from("elements")], message))?;
    }
    Ok(())
}

/// Loads the table of wires that a scene's array names, if it names one, after its elements.
///
/// # Errors
/// A missing or invalid table.
pub(crate) fn load_wires(scene: &mut Scene, folder: &Path) -> Result<(), KeyError> {
    if let Some(name) = scene.array.wiring.as_ref().filter(|_| scene.array.lacks_wires()) {
        scene.array.wires = wires(name, folder, scene)
            .map_err(|message| KeyError::new([Key::from("array"), Key::from("wiring")], message))?;
    }
    Ok(())
}

/// The wires of a table: a file in a folder, or a preset.
fn wires(name: &str, folder: &Path, scene: &Scene) -> Result<Wires, String> {
    if let Some(preset) = name.strip_prefix(arrays::PRESET) {
        return wiring::preset(preset, scene.array.elements());
    }
    let path = folder.join(name);
    let bytes = source::read(&path, MOST_BYTES).map_err(|error| format!("{}: {error}", path.display()))?;
    let text = String::from_utf8_lossy(&bytes);
    let read = if pat::is_board(&text) {
        let places: Vec<_> = scene.array.places().iter().map(|it| it.at.to_array()).collect();
        let of_places = |file: pat::BoardFile| {
            let transducers = file.transducers_at(&places)?;
            Ok(transducers.into_iter().map(|n| file.wires.get(n).copied()).collect())
        };
        pat::read(&text).and_then(of_places).map(|wires| (wires, true))
    } else {
        wiring::read(&bytes, scene.elements()).map(|wires| (wires, false))
    };
    let (wires, repeats) = read.map_err(|error| format!("{}:{error}", path.display()))?;
    Ok(Wires::new(wires, repeats, Some(path)))
}

/// The elements of a table: a file in a folder, or one of [`arrays`].
fn placed(name: &str, folder: &Path) -> Result<Elements, String> {
    if let Some(preset) = name.strip_prefix(arrays::PRESET) {
        let table = arrays::table(preset)?;
        return elements::read(table.as_bytes()).map_err(|error| error.to_string());
    }
    let path = folder.join(name);
    let bytes = source::read(&path, MOST_BYTES).map_err(|error| format!("{}: {error}", path.display()))?;
    let mut elements = elements::read(&bytes).map_err(|error| format!("{}:{error}", path.display()))?;
    (elements.wires.from, elements.from) = (Some(path.clone()), Some(path));
    Ok(elements)
}

/// The drives of a file for a scene's array, named as in the scene.
///
/// # Errors
/// A missing file, or errors of [`drive::read`]; the message names file and line.
pub fn read_drive(path: &Path, name: String, scene: &Scene) -> Result<DriveFile, String> {
    let bytes =
        source::read(path, MOST_BYTES_OF_DRIVES).map_err(|error| format!("{}: {error}", path.display()))?;
    let table = drive::read(&bytes[..], &Aperture::new(scene));
    let table = table.map_err(|error| format!("{}:{error}", path.display()))?;
    Ok(DriveFile::new(name, table, Some(path.to_owned())))
}

/// Loads the waveforms of the modulations of a scene and its targets that are named and not loaded.
///
/// # Errors
/// The errors of [`waveform::read`].
pub fn load_waves(scene: &mut Scene, folder: &Path) -> Result<(), KeyError> {
    for (target, modulation) in scene.modulations_mut().filter(|(_, modulation)| modulation.lacks_wave()) {
        let read = waveform::read(&folder.join(&modulation.file));
        modulation.wave = read.map_err(|message| {
            let error = KeyError::new([Key::from("modulation"), Key::from("file")], message);
            match target {
                None => error,
                Some(index) => error.under(&["target".into(), index.into()]),
            }
        })?;
    }
    Ok(())
}

/// Loads the paths of motions that are named and not loaded; returns whether there were any.
///
/// # Errors
/// The errors of [`routes::read`].
pub fn load_routes(scene: &mut Scene, folder: &Path) -> Result<bool, KeyError> {
    let mut has_loaded = false;
    let mut load = |motion: &mut Motion, key: Vec<Key>| {
        if motion.lacks_routes() {
            let read = routes::read(&folder.join(&motion.file));
            motion.routes = read.map_err(|message| KeyError::new(key, message))?;
            has_loaded = true;
        }
        Ok(())
    };
    load(&mut scene.motion, vec![Key::from("motion"), Key::from("file")])?;
    for (index, target) in scene.targets.iter_mut().enumerate() {
        let key = vec![Key::from("target"), Key::from(index), Key::from("motion"), Key::from("file")];
        target.motion.as_mut().map_or(Ok(()), |motion| load(motion, key))?;
    }
    Ok(has_loaded)
}

/// Loads the thresholds of a skin, if a file has them and they are not loaded.
///
/// # Errors
/// The errors of [`thresholds::read`].
pub fn load_thresholds(skin: Option<&mut Skin>, folder: &Path) -> Result<(), KeyError> {
    if let Some(skin) = skin.filter(|skin| skin.lacks_curve()) {
        let read = thresholds::read(&folder.join(&skin.threshold));
        let key = [Key::from("skin"), Key::from("threshold")];
        skin.curve = read.map_err(|message| KeyError::new(key, message))?;
    }
    Ok(())
}

/// Loads the directivity of an array's elements, if a file has it and it is not loaded.
///
/// # Errors
/// The errors of [`directivity::read`].
pub fn load_directivity(array: &mut Array, folder: &Path) -> Result<(), KeyError> {
    if let Some(name) = array.directivity.as_ref().filter(|_| array.lacks_directivity()) {
        let key = [Key::from("array"), Key::from("directivity")];
        array.measured =
            directivity::read(&folder.join(name)).map_err(|message| KeyError::new(key, message))?;
    }
    Ok(())
}

/// Loads the surfaces of bodies that are named and not loaded; returns whether there were any.
///
/// # Errors
/// The errors of [`surfaces::read`].
pub fn load_bodies(bodies: &mut [Body], folder: &Path) -> Result<bool, KeyError> {
    let mut loaded: HashMap<PathBuf, Surface> = HashMap::new();
    for (index, body) in bodies.iter_mut().enumerate().filter(|(_, body)| body.lacks_surface()) {
        let path = folder.join(body.file.as_deref().unwrap_or_default());
        body.surface = match loaded.get(&path) {
            Some(surface) => surface.clone(),
            None => {
                let key = [Key::from("body"), Key::from(index), Key::from("file")];
                let read = surfaces::read(&path).map_err(|message| KeyError::new(key, message))?;
                loaded.entry(path).insert_entry(read).get().clone()
            }
        };
    }
    Ok(!loaded.is_empty())
}

/// Loads the pictures among targets.
///
/// # Errors
/// A missing, unreadable or black picture.
pub fn load_targets(targets: &mut [Target], folder: &Path) -> Result<(), KeyError> {
    let mut loaded: HashMap<PathBuf, Pixels> = HashMap::new();
    for (index, target) in targets.iter_mut().enumerate().filter(|(_, target)| target.lacks_pixels()) {
        let Some((file, pixels)) = target.shape.picture_mut() else { continue };
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scene_is_called_what_stands_before_its_ending() {
        let stems = ["a/hit.toml", "hit.sonoglyph", "hit.sonoglyph.toml", "v1.2.toml", ".sonoglyph", "hit"];
        let stems = stems.map(|path| stem(Path::new(path)));
        assert_eq!(stems, ["hit", "hit", "hit", "v1.2", ".sonoglyph", "hit"]);
    }
}
