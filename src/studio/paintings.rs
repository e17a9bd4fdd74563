//! Saves pictures with a scene: paintings as files beside the scene's, other pictures by relative names.
//!
//! [`Paintings`] records which pixels were written to which file, so that undone strokes are rewritten and other
//! programs' files are never overwritten.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use crate::picture::grey;
use crate::scene::{Grey, Pixels, Scene, Target};
use crate::source;

/// Suffix of painting names: `<scene>-painting.png`, `<scene>-painting-2.png` and so on.
const SUFFIX: &str = "-painting";

/// Records the pixels written to each file, since undone strokes can return and files are overwritten.
#[derive(Clone, Debug, Default)]
pub struct Paintings(Vec<(PathBuf, Pixels)>);

/// A scene as for its file, and the pictures to be written first.
#[derive(Clone, Debug)]
pub struct Placed {
    pub scene: Scene,
    pub files: Vec<(PathBuf, Pixels)>,
}

impl Paintings {
    /// Names the pictures, waveform, drives, tables and meshes of a scene for `path`. Unsaved pictures get a file beside it
    /// that does not exist or `may_replace`; files in other folders get absolute paths.
    pub fn place(&self, scene: &Scene, path: &Path, may_replace: impl Fn(&Path) -> bool) -> Placed {
        let mut placed = Placed { scene: scene.clone(), files: Vec::new() };
        let path = absolute(path);
        let mut taken: Vec<(PathBuf, Pixels)> = Vec::new();
        // Files with matching pixels come first: new files must not replace them.
        for is_held in [true, false] {
            for target in &mut placed.scene.targets {
                let Some((file, pixels)) = target.shape.picture_mut() else { continue };
                let holder = self.holder(pixels, &path);
                let is_missing = pixels.get().is_none();
                if is_missing && is_held {
                    taken.push((absolute(&path.with_file_name(&*file)), pixels.clone()));
                }
                if is_missing || holder.is_some() != is_held {
                    continue;
                }
                let same = taken.iter().find(|(_, other)| other == pixels).map(|(place, _)| place.clone());
                let place = holder.or(same).unwrap_or_else(|| {
                    let is_free = |place: &PathBuf| {
                        !taken.iter().any(|(other, _)| other == place)
                            && (!source::exists(place) || may_replace(place))
                    };
                    let place = numbered(&path).find(is_free).unwrap_or_default();
                    placed.files.push((place.clone(), pixels.clone()));
                    place
                });
                *file = name_from(&path, &place, file);
                taken.push((place, pixels.clone()));
            }
        }
        let array = &mut placed.scene.array;
        if let (Some(name), Some(place)) = (&mut array.file, &array.placed.from) {
            *name = name_from(&path, &absolute(place), name);
        }
        if let (Some(name), Some(place)) = (&mut array.wiring, &array.wires.from) {
            *name = name_from(&path, &absolute(place), name);
        }
        if let (Some(name), Some(place)) = (&mut array.directivity, &array.measured.from) {
            *name = name_from(&path, &absolute(place), name);
        }
        for body in &mut placed.scene.bodies {
            if let (Some(name), Some(place)) = (&mut body.file, &body.surface.from) {
                *name = name_from(&path, &absolute(place), name);
            }
        }
        let drive = &mut placed.scene.drive;
        if let Some(place) = &drive.from {
            let before = if Path::new(&drive.name).is_absolute() { "" } else { &*drive.name };
            drive.name = name_from(&path, &absolute(place), before);
        }
        for (_, modulation) in placed.scene.modulations_mut() {
            if let Some(samples) = modulation.wave.get() {
                let file = &modulation.file;
                let before = if Path::new(file).is_absolute() { "" } else { file };
                modulation.file = name_from(&path, &absolute(&samples.file), before);
            }
        }
        let Scene { motion, targets, .. } = &mut placed.scene;
        let own = targets.iter_mut().filter_map(|target| target.motion.as_mut());
        for motion in own.chain([motion]) {
            if let Some(place) = motion.routes.file() {
                let before = if Path::new(&motion.file).is_absolute() { "" } else { &*motion.file };
                motion.file = name_from(&path, &absolute(place), before);
            }
        }
        if let Some(skin) = placed.scene.skin.as_mut().filter(|skin| skin.known().is_none())
            && let Some(place) = &skin.curve.from
        {
            let before = if Path::new(&skin.threshold).is_absolute() { "" } else { &*skin.threshold };
            skin.threshold = name_from(&path, &absolute(place), before);
        }
        placed
    }

    /// The file with these pixels, if it needs no writing for a scene at `path`.
    fn holder(&self, pixels: &Pixels, path: &Path) -> Option<PathBuf> {
        let own = pixels.get()?.file.as_deref().map(absolute);
        let is_as_loaded = |own: &PathBuf| self.at(own).is_none_or(|there| there == pixels);
        let written = |(place, there): &&(PathBuf, Pixels)| {
            there == pixels && is_painting_of(path, place) && source::exists(place)
        };
        own.filter(is_as_loaded).or_else(|| self.0.iter().find(written).map(|(place, _)| place.clone()))
    }

    fn at(&self, place: &Path) -> Option<&Pixels> {
        self.0.iter().find(|(other, _)| other == place).map(|(_, pixels)| pixels)
    }

    /// Whether this record has written a file.
    pub fn has_written(&self, place: &Path) -> bool {
        self.at(place).is_some()
    }

    /// Writes pictures by `write` and records them.
    ///
    /// # Errors
    /// Errors of `write`; earlier pictures have been written.
    pub fn write(
        &mut self,
        files: Vec<(PathBuf, Pixels)>,
        write: impl Fn(&Path, &[u8]) -> anyhow::Result<()>,
    ) -> anyhow::Result<()> {
        for (place, pixels) in files {
            let Some(grey) = pixels.get() else { continue };
            write(&place, &grey::png(grey)?)?;
            self.0.retain(|(other, _)| *other != place);
            self.0.push((place, pixels));
        }
        Ok(())
    }

    /// Adopts a scene read from `path`: its paintings become painted pixels, recorded as written.
    pub fn adopt(&mut self, scene: &mut Scene, path: &Path) {
        for target in &mut scene.targets {
            let Some((_, pixels)) = target.shape.picture_mut() else { continue };
            let Some(grey) = pixels.get() else { continue };
            let Some(file) = grey.file.clone().filter(|file| is_painting_of(path, file)) else { continue };
            *pixels = Pixels::new(Grey { file: None, ..grey.clone() });
            self.0.retain(|(other, _)| *other != absolute(&file));
            self.0.push((absolute(&file), pixels.clone()));
        }
    }

    /// Removes all written files, as far as permitted.
    pub fn remove(&mut self) {
        for (place, _) in self.0.drain(..) {
            source::remove(&place);
        }
    }
}

/// Whether a file has the name and folder of a painting of the scene at a path.
pub fn is_painting_of(path: &Path, place: &Path) -> bool {
    let (path, place) = (absolute(path), absolute(place));
    let stem = |path: &Path| path.file_stem().map(OsStr::to_os_string).unwrap_or_default();
    let (Some(scene), Some(painting)) =
        (stem(&path).to_str().map(str::to_owned), stem(&place).to_str().map(str::to_owned))
    else {
        return false;
    };
    let rest = painting.strip_prefix(&scene).and_then(|rest| rest.strip_prefix(SUFFIX));
    let is_number =
        |rest: &str| rest.is_empty() || rest.strip_prefix('-').is_some_and(|it| it.parse::<u32>().is_ok());
    path.parent() == place.parent() && rest.is_some_and(is_number)
}

/// Whether a scene has a picture loaded from this file.
pub fn names(scene: &Scene, place: &Path) -> bool {
    let is_from = |target: &Target| {
        let pixels = target.shape.picture().and_then(|(_, _, pixels)| pixels.get());
        let file = pixels.and_then(|grey| grey.file.as_deref());
        file.is_some_and(|file| absolute(file) == absolute(place))
    };
    scene.targets.iter().any(is_from)
}

/// The names that paintings of the scene at a path may have.
fn numbered(path: &Path) -> impl Iterator<Item = PathBuf> {
    let stem = path.file_stem().unwrap_or_default().to_os_string();
    (1..).map(move |number: usize| {
        let mut name = stem.clone();
        name.push(SUFFIX);
        if number > 1 {
            name.push(format!("-{number}"));
        }
        name.push(".png");
        path.with_file_name(name)
    })
}

/// The name of a file in the scene at a path: the existing name if valid.
fn name_from(path: &Path, place: &Path, before: &str) -> String {
    let folder = path.parent().unwrap_or(Path::new(""));
    if absolute(&folder.join(before)) == place {
        return before.to_owned();
    }
    let beside = if place.parent() == Some(folder) { place.file_name() } else { None };
    beside.unwrap_or(place.as_os_str()).to_string_lossy().into_owned()
}

fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned())
}
