//! Animations, encoded frame by frame as they come: GIF and animated PNG. Their palette is the colour map itself, so that every
//! pixel has exactly its colour.

use std::fmt;
use std::io::Write;
use std::path::Path;

/// A file format for frames of 256 colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    Gif,
    /// An ordinary PNG where there is one frame.
    Png,
}

impl Format {
    /// The format of a file with this name.
    pub fn of(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "gif" => Some(Self::Gif),
            "png" | "apng" => Some(Self::Png),
            _ => None,
        }
    }

    /// Pixels per side that it has numbers for.
    pub fn largest_side(self) -> usize {
        match self {
            Self::Gif => usize::from(u16::MAX),
            Self::Png => i32::MAX as usize,
        }
    }

    /// What the time that a frame is shown is counted in.
    fn ticks_per_second(self) -> u16 {
        match self {
            Self::Gif => 100,
            Self::Png => 1000,
        }
    }
}

/// How long each frame is shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    /// s
    pub per_frame: f64,
    /// How many times slower than it really is.
    pub slowed: f64,
}

impl Pace {
    /// As fast as it really is, if that is neither too fast for viewers, which show frames for a tenth of a second when told less
    /// than a fiftieth, nor too slow for the formats. What is no rate is shown as slowly as can be.
    pub fn new(frames_per_second: f64) -> Self {
        const SHORTEST: f64 = 0.02;
        const LONGEST: f64 = 60.0;
        let is_rate = frames_per_second.is_finite() && frames_per_second > 0.0;
        let real = if is_rate { 1.0 / frames_per_second } else { LONGEST };
        let per_frame = real.clamp(SHORTEST, LONGEST);
        Self { per_frame, slowed: per_frame / real }
    }

    /// Ticks that a frame is shown for; rounding in one is made up for in the next.
    fn ticks(self, frame: u32, ticks_per_second: u16) -> u16 {
        let until = |frame: f64| (frame * self.per_frame * f64::from(ticks_per_second)).round();
        (until(f64::from(frame) + 1.0) - until(f64::from(frame))) as u16
    }
}

/// Why an animation could not be encoded.
#[derive(Debug, thiserror::Error)]
pub enum AnimationError {
    #[error(
        "cannot encode {frames} frames of {width} x {height} pixels: a side is 1 to {largest}, and there is a frame at least"
    )]
    Size { width: usize, height: usize, largest: usize, frames: u32 },
    #[error("cannot encode: {0}")]
    Gif(gif::EncodingError),
    #[error("cannot encode: {0}")]
    Png(png::EncodingError),
    #[error("cannot write: {0}")]
    File(#[from] std::io::Error),
}

impl From<gif::EncodingError> for AnimationError {
    fn from(error: gif::EncodingError) -> Self {
        match error {
            gif::EncodingError::Io(error) => Self::File(error),
            error => Self::Gif(error),
        }
    }
}

impl From<png::EncodingError> for AnimationError {
    fn from(error: png::EncodingError) -> Self {
        match error {
            png::EncodingError::IoError(error) => Self::File(error),
            error => Self::Png(error),
        }
    }
}

/// An animation that repeats for ever, on its way into a file.
pub struct Animation<W: Write> {
    encoder: Encoder<W>,
    width: usize,
    height: usize,
    pace: Pace,
    /// Frames promised and added.
    frames: u32,
    added: u32,
}

impl<W: Write> fmt::Debug for Animation<W> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Animation of {} x {}, {} of {} frames", self.width, self.height, self.added, self.frames)
    }
}

enum Encoder<W: Write> {
    Gif(gif::Encoder<W>),
    Png(png::Writer<W>),
}

impl<W: Write> Animation<W> {
    /// Begins an animation of as many frames in these colours.
    ///
    /// # Errors
    /// A side longer than [`Format::largest_side`], no frames, or a file that cannot be written.
    pub fn new(
        writer: W,
        format: Format,
        (width, height): (usize, usize),
        colours: &[[u8; 4]; 256],
        frames: u32,
        pace: Pace,
    ) -> Result<Self, AnimationError> {
        let largest = format.largest_side();
        if frames == 0 || [width, height].iter().any(|side| !(1..=largest).contains(side)) {
            return Err(AnimationError::Size { width, height, largest, frames });
        }
        let palette: Vec<u8> = colours.iter().flat_map(|[r, g, b, _]| [*r, *g, *b]).collect();
        let encoder = match format {
            Format::Gif => {
                let mut encoder = gif::Encoder::new(writer, width as u16, height as u16, &palette)?;
                encoder.set_repeat(gif::Repeat::Infinite)?;
                Encoder::Gif(encoder)
            }
            Format::Png => {
                let mut encoder = png::Encoder::new(writer, width as u32, height as u32);
                encoder.set_color(png::ColorType::Indexed);
                encoder.set_depth(png::BitDepth::Eight);
                encoder.set_palette(palette);
                if frames != 1 {
                    encoder.set_animated(frames, 0)?;
                }
                encoder.validate_sequence(true);
                Encoder::Png(encoder.write_header()?)
            }
        };
        Ok(Self { encoder, width, height, pace, frames, added: 0 })
    }

    /// Adds a frame: the place of every pixel in the table of colours, row 0 at the bottom.
    ///
    /// # Errors
    /// A file that cannot be written, or more frames than were promised.
    ///
    /// # Panics
    /// Another number of places than pixels.
    pub fn add(&mut self, places: &[u8]) -> Result<(), AnimationError> {
        assert_eq!(places.len(), self.width * self.height, "a byte per pixel");
        let from_top: Vec<u8> = places.chunks_exact(self.width).rev().flatten().copied().collect();
        match &mut self.encoder {
            Encoder::Gif(encoder) => encoder.write_frame(&gif::Frame {
                width: self.width as u16,
                height: self.height as u16,
                delay: self.pace.ticks(self.added, Format::Gif.ticks_per_second()),
                buffer: from_top.into(),
                ..gif::Frame::default()
            })?,
            Encoder::Png(writer) => {
                if self.frames != 1 {
                    let per_second = Format::Png.ticks_per_second();
                    writer.set_frame_delay(self.pace.ticks(self.added, per_second), per_second)?;
                }
                writer.write_image_data(&from_top)?;
            }
        }
        self.added += 1;
        Ok(())
    }

    /// Ends the file.
    ///
    /// # Errors
    /// A file that cannot be written, or fewer frames than were promised.
    pub fn finish(self) -> Result<(), AnimationError> {
        match self.encoder {
            Encoder::Gif(encoder) => drop(encoder.into_inner()?),
            Encoder::Png(writer) => writer.finish()?,
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;
    use crate::picture::ColourMap;

    const SIZE: (usize, usize) = (5, 4);

    /// Every frame has other places, and all 256 appear.
    fn places(frame: u32) -> Vec<u8> {
        (0..20).map(|pixel| (frame * 20 + pixel) as u8).collect()
    }

    fn encoded(format: Format, frames: u32, pace: Pace) -> Vec<u8> {
        let mut bytes = Vec::new();
        let colours = ColourMap::Inferno.table();
        let mut animation = Animation::new(&mut bytes, format, SIZE, &colours, frames, pace).unwrap();
        for frame in 0..frames {
            animation.add(&places(frame)).unwrap();
        }
        animation.finish().unwrap();
        bytes
    }

    /// r, g, b from the top left, as the colour map says.
    fn expected(frame: u32) -> Vec<u8> {
        let table = ColourMap::Inferno.table();
        let rows = places(frame);
        rows.chunks(SIZE.0)
            .rev()
            .flatten()
            .flat_map(|&place| table[usize::from(place)][..3].to_vec())
            .collect()
    }

    #[test]
    fn a_gif_has_every_frame_in_exactly_its_colours() {
        let bytes = encoded(Format::Gif, 13, Pace::new(30.0));
        let mut options = gif::DecodeOptions::new();
        options.set_color_output(gif::ColorOutput::RGBA);
        let mut decoder = options.read_info(Cursor::new(bytes)).unwrap();
        assert_eq!(decoder.repeat(), gif::Repeat::Infinite);
        let (mut frames, mut delay) = (0, 0);
        while let Some(frame) = decoder.read_next_frame().unwrap() {
            let rgb: Vec<u8> = frame.buffer.chunks(4).flat_map(|pixel| pixel[..3].to_vec()).collect();
            assert_eq!(rgb, expected(frames));
            delay += frame.delay;
            frames += 1;
        }
        assert_eq!(frames, 13);
        assert_eq!(delay, 43, "13 frames at 30 a second are 0.433 s, though one alone would be 0.03 s");
    }

    #[test]
    fn an_animated_png_has_every_frame_in_exactly_its_colours() {
        let bytes = encoded(Format::Png, 13, Pace::new(30.0));
        let decoder = image::codecs::png::PngDecoder::new(Cursor::new(bytes)).unwrap();
        assert!(decoder.is_apng().unwrap());
        let frames: Vec<_> =
            image::AnimationDecoder::into_frames(decoder.apng().unwrap()).map(Result::unwrap).collect();
        assert_eq!(frames.len(), 13);
        let mut milliseconds = 0;
        for (number, frame) in frames.iter().enumerate() {
            let rgb: Vec<u8> =
                frame.buffer().pixels().flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
            assert_eq!(rgb, expected(number as u32));
            milliseconds += frame.delay().numer_denom_ms().0;
        }
        assert_eq!(milliseconds, 433);
    }

    #[test]
    fn one_frame_is_an_ordinary_png() {
        let bytes = encoded(Format::Png, 1, Pace::new(5.0));
        assert!(!bytes.windows(4).any(|chunk| chunk == b"acTL"));
        assert_eq!(image::load_from_memory(&bytes).unwrap().to_rgb8().into_raw(), expected(0));
    }

    #[test]
    fn promised_frames_must_come() {
        let pace = Pace::new(5.0);
        let table = ColourMap::Grey.table();
        let mut animation = Animation::new(Vec::new(), Format::Png, SIZE, &table, 2, pace).unwrap();
        animation.add(&places(0)).unwrap();
        assert!(matches!(animation.finish(), Err(AnimationError::Png(_))));
    }

    #[test]
    fn what_is_too_fast_is_slowed_down() {
        let close = |pace: Pace, per_frame: f64, slowed: f64| {
            (pace.per_frame - per_frame).abs() < 1e-12 && (pace.slowed / slowed - 1.0).abs() < 1e-12
        };
        assert!(close(Pace::new(10.0), 0.1, 1.0));
        assert!(close(Pace::new(320.0), 0.02, 6.4));
        assert!(close(Pace::new(1e-6), 60.0, 6e-5));
        for frame in [0, 1, 7, u32::MAX] {
            assert_eq!(Pace::new(1e6).ticks(frame, 100), 2);
        }
    }

    #[test]
    fn names_tell_formats() {
        let of = |name: &str| Format::of(Path::new(name));
        assert_eq!(of("a.gif"), Some(Format::Gif));
        assert_eq!((of("a.PNG"), of("b/a.apng")), (Some(Format::Png), Some(Format::Png)));
        assert_eq!((of("a.mp4"), of("gif"), of("")), (None, None, None));
    }
}
