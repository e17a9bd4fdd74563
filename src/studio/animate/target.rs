//! Outputs of films: file formats, or a folder of pictures.

use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow, bail};
use strum::{IntoStaticStr, VariantArray};

use crate::picture::animation::Format;
use crate::studio::output;
use crate::studio::video::{self, Codec};

/// Allowed frame rates.
pub const RATES: [f64; 2] = [1.0 / 60.0, 240.0];
/// Viewers show a GIF's and a PNG's frames for no less than 20 ms.
const MOST_OF_PICTURES: f64 = 50.0;

/// Film file formats.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, IntoStaticStr, VariantArray)]
#[strum(const_into_str)]
pub enum Kind {
    #[default]
    #[strum(serialize = "GIF")]
    Gif,
    #[strum(serialize = "Animated PNG")]
    Apng,
    #[strum(serialize = "MP4 (H.264)")]
    Mp4,
    #[strum(serialize = "WebM (VP9)")]
    Webm,
}

impl Kind {
    /// The kinds that can be written here.
    pub fn writable() -> impl Iterator<Item = Self> {
        Self::VARIANTS
            .iter()
            .copied()
            .filter(|kind| video::IS_WRITTEN || matches!(kind, Self::Gif | Self::Apng))
    }

    /// Endings of a file's name, the usual one first.
    pub fn endings(self) -> &'static [&'static str] {
        match self {
            Self::Gif => &["gif"],
            Self::Apng => &["png", "apng"],
            Self::Mp4 => &["mp4"],
            Self::Webm => &["webm"],
        }
    }

    fn of(path: &Path) -> Option<Self> {
        let ending = path.extension()?.to_str()?.to_ascii_lowercase();
        Self::VARIANTS.iter().copied().find(|kind| kind.endings().contains(&ending.as_str()))
    }

    pub(super) fn encoding(self) -> Encoding {
        match self {
            Self::Gif => Encoding::Pictures(Format::Gif),
            Self::Apng => Encoding::Pictures(Format::Png),
            Self::Mp4 => Encoding::Video(Codec::H264),
            Self::Webm => Encoding::Video(Codec::Vp9),
        }
    }

    /// The size (pixels) that this kind has instead: sides of videos are even.
    pub fn pixels(self, (width, height): (usize, usize)) -> (usize, usize) {
        match self.encoding() {
            Encoding::Pictures(_) => (width, height),
            Encoding::Video(_) => (width.next_multiple_of(2), height.next_multiple_of(2)),
        }
    }

    /// Frames per second, at most.
    pub fn most_rate(self) -> f64 {
        match self.encoding() {
            Encoding::Pictures(_) => MOST_OF_PICTURES,
            Encoding::Video(_) => RATES[1],
        }
    }
}

/// The encoder.
#[derive(Clone, Copy, Debug)]
pub(super) enum Encoding {
    Pictures(Format),
    Video(Codec),
}

/// The output of a film.
#[derive(Clone, Debug, PartialEq)]
pub enum Target {
    File(PathBuf, Kind),
    /// A PNG per frame.
    Folder(PathBuf),
}

impl Target {
    pub fn of(output: &Path) -> anyhow::Result<Self> {
        let named_as_folder = output.as_os_str().to_string_lossy().ends_with(std::path::is_separator);
        if output.is_dir() || named_as_folder {
            return Ok(Self::Folder(output.to_owned()));
        }
        match Kind::of(output) {
            Some(kind) => Ok(Self::File(output.to_owned(), kind)),
            None => bail!(
                "{}: an animation is written as FILE.gif, FILE.png or FILE.apng, a video as FILE.mp4 or FILE.webm, and a PNG per \
                 frame into FOLDER/",
                output.display()
            ),
        }
    }

    /// The pixels of [`Kind::pixels`].
    pub fn pixels(&self, size: (usize, usize)) -> (usize, usize) {
        match self {
            Self::File(_, kind) => kind.pixels(size),
            Self::Folder(_) => size,
        }
    }

    /// Fails early if writing would fail after the work.
    pub fn check(&self, (width, height): (usize, usize), rate: Option<f64>) -> anyhow::Result<()> {
        let Self::File(path, kind) = self else { return Ok(()) };
        let most = match kind.encoding() {
            Encoding::Pictures(format) => format.largest_side(),
            Encoding::Video(_) => video::LARGEST_SIDE,
        };
        if width.max(height) > most {
            bail!("{}: {width} x {height} pixels: this format has room for {most} a side", path.display());
        }
        if let Some(rate) = rate.filter(|rate| *rate > kind.most_rate()) {
            bail!(
                "{}: {rate} frames a second: viewers show at most {} of this format",
                path.display(),
                kind.most_rate()
            );
        }
        output::check_writable(path)?;
        match kind.encoding() {
            Encoding::Pictures(_) => Ok(()),
            Encoding::Video(codec) => {
                codec.check((width, height)).map_err(|error| anyhow!("{}: {error:#}", path.display()))
            }
        }
    }

    /// The names of a folder's pictures; empty for a file.
    pub fn pictures<'a>(&'a self, name: &'a str, count: usize) -> impl Iterator<Item = PathBuf> + 'a {
        let folder = match self {
            Self::File(..) => None,
            Self::Folder(folder) => Some(folder),
        };
        let digits = count.to_string().len();
        let picture =
            move |folder: &PathBuf, index| folder.join(format!("{name}-{:0digits$}.png", index + 1));
        folder.into_iter().flat_map(move |folder| (0..count).map(move |index| picture(folder, index)))
    }

    pub fn make_folder(&self) -> anyhow::Result<()> {
        let Self::Folder(path) = self else { return Ok(()) };
        std::fs::create_dir_all(path).with_context(|| format!("{}: cannot make the folder", path.display()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_tell_kinds() {
        let of = |name: &str| Kind::of(Path::new(name));
        assert_eq!(of("a.gif"), Some(Kind::Gif));
        assert_eq!((of("a.PNG"), of("b/a.apng")), (Some(Kind::Apng), Some(Kind::Apng)));
        assert_eq!((of("a.mp4"), of("a.WebM")), (Some(Kind::Mp4), Some(Kind::Webm)));
        assert_eq!((of("a.avi"), of("gif"), of("")), (None, None, None));
        assert_eq!(Kind::Mp4.pixels((101, 64)), (102, 64));
        assert_eq!(Kind::Gif.pixels((101, 64)), (101, 64));
    }
}
