//! The files of one run: inputs are never overwritten, and all outputs are distinct files, whatever their names.

use std::fs::{self, Metadata};
use std::path::{Path, PathBuf};

use anyhow::bail;

use crate::echo;
use crate::scene::Scene;
use crate::studio::output::check_writable;
use crate::studio::output::disk::{folder_of, followed};

/// The inputs, and the outputs so far.
#[derive(Debug, Default)]
pub struct Files {
    inputs: Vec<(PathBuf, Identity)>,
    outputs: Vec<(PathBuf, Identity)>,
}

/// Identity of a file behind different names: links, including hard links.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Identity {
    /// Device and inode of an existing file.
    #[cfg(unix)]
    There(u64, u64),
    /// Path of a future file, in a folder without links.
    Named(PathBuf),
    /// A pipe or a device is written directly, and a folder is never overwritten.
    Stream,
}

impl Identity {
    fn of(path: &Path) -> Self {
        match fs::metadata(path) {
            Ok(there) if there.is_file() => Self::of_file(&there, path),
            Ok(_) => Self::Stream,
            Err(_) => Self::named(path),
        }
    }

    #[cfg(unix)]
    fn of_file(there: &Metadata, _: &Path) -> Self {
        use std::os::unix::fs::MetadataExt;
        Self::There(there.dev(), there.ino())
    }

    #[cfg(not(unix))]
    fn of_file(_: &Metadata, path: &Path) -> Self {
        // In the system's spelling, which may ignore case.
        fs::canonicalize(path).map_or_else(|_| Self::named(path), Self::Named)
    }

    fn named(path: &Path) -> Self {
        let path = followed(path).unwrap_or_else(|_| path.to_owned());
        let folder = fs::canonicalize(folder_of(&path)).unwrap_or_else(|_| folder_of(&path).to_owned());
        Self::Named(path.file_name().map_or(folder.clone(), |name| folder.join(name)))
    }

    fn is_stream(&self) -> bool {
        *self == Self::Stream
    }
}

impl Files {
    /// The files of a command: initially standard input and output, if they are files.
    pub fn new() -> Self {
        let standard = |name: &str| {
            let own = (PathBuf::from(name), Identity::of(Path::new(name)));
            [own].into_iter().filter(|(_, own)| is_there(own)).collect()
        };
        Self { inputs: standard("/dev/stdin"), outputs: standard("/dev/stdout") }
    }

    /// Notes a file that is read.
    ///
    /// # Errors
    /// It is also an output.
    pub fn reads(&mut self, path: &Path) -> anyhow::Result<()> {
        let own = Identity::of(path);
        if let Some((output, _)) = self.outputs.iter().find(|(_, other)| *other == own && !own.is_stream()) {
            return refuse(output, path);
        }
        if self.inputs.iter().all(|(_, other)| *other != own) {
            self.inputs.push((path.to_owned(), own));
        }
        Ok(())
    }

    /// Notes the pictures, the waveform, the thresholds, the paths and the tables that a scene has been read with.
    ///
    /// # Errors
    /// The errors of [`Self::reads`].
    pub fn reads_files_of(&mut self, scene: &Scene) -> anyhow::Result<()> {
        for samples in scene.modulations().filter_map(|(_, modulation)| modulation.wave.get()) {
            self.reads(&samples.file)?;
        }
        let own = scene.targets.iter().filter_map(|target| target.motion.as_ref());
        for path in own.chain([&scene.motion]).filter_map(|motion| motion.routes.file()) {
            self.reads(path)?;
        }
        if let Some(path) = scene.skin.as_ref().and_then(|skin| skin.curve.from.as_ref()) {
            self.reads(path)?;
        }
        if let Some(path) = &scene.drive.from {
            self.reads(path)?;
        }
        for target in &scene.targets {
            if let Some((_, _, pixels)) = target.shape.picture()
                && let Some(path) = pixels.get().and_then(|grey| grey.file.as_deref())
            {
                self.reads(path)?;
            }
        }
        let tables = [&scene.array.placed.from, &scene.array.wires.from];
        tables.into_iter().flatten().try_for_each(|path| self.reads(path))
    }

    /// Registers an output file.
    ///
    /// # Errors
    /// It is an input, or already another output.
    pub fn keeps(&mut self, path: &Path) -> anyhow::Result<()> {
        let own = self.output(path)?;
        let is_own = |(_, other): &&(PathBuf, Identity)| *other == own && !own.is_stream();
        if let Some((output, _)) = self.outputs.iter().find(is_own) {
            bail!("{}: this would be written twice, as {} too", path.display(), output.display());
        }
        self.outputs.push((path.to_owned(), own));
        Ok(())
    }

    /// Checks whether a file may be written without registering it, for large numbers of files.
    ///
    /// # Errors
    /// It is read.
    pub fn spares(&self, path: &Path) -> anyhow::Result<()> {
        self.output(path).map(drop)
    }

    fn output(&self, path: &Path) -> anyhow::Result<Identity> {
        let own = Identity::of(path);
        match self.inputs.iter().find(|(_, other)| *other == own && !own.is_stream()) {
            Some((input, _)) => refuse(path, input),
            None => Ok(own),
        }
    }

    /// Does the same as [`Self::keeps`], and fails early if writing would fail after the work.
    ///
    /// # Errors
    /// Errors of [`Self::keeps`] and [`check_writable`].
    pub fn writes(&mut self, path: &Path) -> anyhow::Result<()> {
        self.keeps(path)?;
        check_writable(path)
    }
}

#[cfg(unix)]
fn is_there(own: &Identity) -> bool {
    matches!(own, Identity::There(..))
}

/// Standard input and output have no names there.
#[cfg(not(unix))]
fn is_there(_: &Identity) -> bool {
    false
}

fn refuse<T>(output: &Path, input: &Path) -> anyhow::Result<T> {
    if output == input {
        bail!("{}: this is an input, and writing it would destroy it", output.display());
    }
    bail!("{}: this is the input {}, and writing it would destroy it", output.display(), echo::path(input))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_one_file_are_known_whatever_leads_there() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("a"), "a").unwrap();
        fs::create_dir(at("b")).unwrap();
        let mut files = Files::default();
        files.reads(&at("a")).unwrap();
        files.keeps(&at("new")).unwrap();
        for path in ["a", "b/../a", "new", "b/../new"] {
            assert!(files.keeps(&at(path)).is_err(), "{path}");
        }
        assert!(files.reads(&at("b/../new")).is_err());
        #[cfg(unix)]
        {
            use std::os::unix::fs::symlink;
            fs::hard_link(at("a"), at("hard")).unwrap();
            symlink("a", at("soft")).unwrap();
            symlink("new", at("dangling")).unwrap();
            symlink(folder.path(), at("b/back")).unwrap();
            symlink("circle", at("circle")).unwrap();
            files.reads(&at("circle")).unwrap();
            for path in ["hard", "soft", "dangling", "b/back/a", "b/back/new", "circle"] {
                assert!(files.keeps(&at(path)).is_err(), "{path}");
            }
            files.keeps(Path::new("/dev/null")).unwrap();
            files.keeps(Path::new("/dev/null")).unwrap();
        }
        files.keeps(&at("other")).unwrap();
    }
}
