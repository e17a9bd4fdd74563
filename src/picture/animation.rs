//! Encoders of animations, frame by frame: GIF and animated PNG. The palette of a map's frames is the colour map
//! itself, so every pixel has exactly its colour.

use std::collections::HashMap;
use std::fmt;
use std::io::Write;

use color_quant::NeuQuant;

use crate::picture::Picture;

/// Subsampling of pixels for the choice of colours.
const SAMPLING: i32 = 3;

/// A file format of animated pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    Gif,
    /// An ordinary PNG for a single frame.
    Png,
}

impl Format {
    /// Pixels per side that it has numbers for.
    pub fn largest_side(self) -> usize {
        match self {
            Self::Gif => usize::from(u16::MAX),
            Self::Png => i32::MAX as usize,
        }
    }

    /// The clock of frame durations.
    fn ticks_per_second(self) -> u16 {
        match self {
            Self::Gif => 100,
            Self::Png => 1000,
        }
    }
}

/// The colours of all frames.
#[derive(Clone, Debug)]
pub enum Colours {
    /// Colours of a colour map, and no others.
    Map(Box<[[u8; 4]; 256]>),
    /// Any colours. A GIF is limited to 256, chosen from this picture.
    Like(Picture),
}

/// A palette of at most 256 colours, with a lookup of the nearest.
struct Palette {
    /// r, g, b in sequence.
    rgb: Vec<u8>,
    nearest: HashMap<[u8; 3], u8>,
}

impl Palette {
    fn new(colours: &Colours) -> Self {
        let rgb = match colours {
            Colours::Map(table) => table.iter().flat_map(|[r, g, b, _]| [*r, *g, *b]).collect(),
            Colours::Like(picture) => NeuQuant::new(SAMPLING, 256, &picture.rgba).color_map_rgb(),
        };
        Self { rgb, nearest: HashMap::new() }
    }

    fn place(&mut self, colour: [u8; 3]) -> u8 {
        let Self { rgb, nearest } = self;
        let far = |own: &[u8; 3]| -> u32 {
            own.iter().zip(colour).map(|(own, wanted)| u32::from(own.abs_diff(wanted)).pow(2)).sum()
        };
        let search =
            || (0..=255).zip(rgb.as_chunks().0).min_by_key(|(_, own)| far(own)).map_or(0, |(at, _)| at);
        *nearest.entry(colour).or_insert_with(search)
    }

    fn places(&mut self, picture: &Picture) -> Vec<u8> {
        picture.rgba.as_chunks().0.iter().map(|&[r, g, b, _]| self.place([r, g, b])).collect()
    }
}

/// The duration of each frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    /// s
    pub per_frame: f64,
    /// Slowdown relative to real time.
    pub slowed: f64,
}

impl Pace {
    /// Real time, within the limits of viewers (which show frames declared shorter than a fiftieth of a second for a
    /// tenth) and formats. An invalid rate becomes the slowest.
    pub fn new(frames_per_second: f64) -> Self {
        const SHORTEST: f64 = 0.02;
        const LONGEST: f64 = 60.0;
        let is_rate = frames_per_second.is_finite() && frames_per_second > 0.0;
        let real = if is_rate { 1.0 / frames_per_second } else { LONGEST };
        let per_frame = real.clamp(SHORTEST, LONGEST);
        Self { per_frame, slowed: per_frame / real }
    }

    /// This number of frames per second (more than 0), for an actual rate of `frames_per_second`.
    pub fn chosen(shown_per_second: f64, frames_per_second: f64) -> Self {
        let per_frame = 1.0 / shown_per_second;
        Self { per_frame, slowed: per_frame * frames_per_second }
    }

    /// Duration of a frame in ticks; rounding errors are compensated in the next frame.
    fn ticks(self, frame: u32, ticks_per_second: u16) -> u16 {
        let until = |frame: f64| (frame * self.per_frame * f64::from(ticks_per_second)).round();
        (until(f64::from(frame) + 1.0) - until(f64::from(frame))) as u16
    }
}

/// Why an animation could not be encoded.
#[derive(Debug, thiserror::Error)]
pub enum AnimationError {
    #[error(
        "cannot encode {frames} frames of {width} x {height} pixels: needs at least 1 frame, and sides of 1 to {largest} pixels"
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

/// An endlessly repeating animation, being written into a file.
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
    Gif(gif::Encoder<W>, Palette),
    /// Without a palette, pixels have their own colours.
    Png(png::Writer<W>, Option<Palette>),
}

impl<W: Write> Animation<W> {
    /// Begins an animation of `frames` frames in these colours.
    ///
    /// # Errors
    /// A side longer than [`Format::largest_side`], no frames, or a file that cannot be written.
    pub fn new(
        writer: W,
        format: Format,
        (width, height): (usize, usize),
        colours: &Colours,
        frames: u32,
        pace: Pace,
    ) -> Result<Self, AnimationError> {
        let largest = format.largest_side();
        if frames == 0 || [width, height].iter().any(|side| !(1..=largest).contains(side)) {
            return Err(AnimationError::Size { width, height, largest, frames });
        }
        let encoder = match format {
            Format::Gif => {
                let palette = Palette::new(colours);
                let mut encoder = gif::Encoder::new(writer, width as u16, height as u16, &palette.rgb)?;
                encoder.set_repeat(gif::Repeat::Infinite)?;
                Encoder::Gif(encoder, palette)
            }
            Format::Png => {
                let mut encoder = png::Encoder::new(writer, width as u32, height as u32);
                let palette = match colours {
                    Colours::Map(_) => Some(Palette::new(colours)),
                    Colours::Like(_) => None,
                };
                if let Some(palette) = &palette {
                    encoder.set_color(png::ColorType::Indexed);
                    encoder.set_palette(palette.rgb.clone());
                } else {
                    encoder.set_color(png::ColorType::Rgb);
                }
                encoder.set_depth(png::BitDepth::Eight);
                if frames != 1 {
                    encoder.set_animated(frames, 0)?;
                }
                encoder.validate_sequence(true);
                Encoder::Png(encoder.write_header()?, palette)
            }
        };
        Ok(Self { encoder, width, height, pace, frames, added: 0 })
    }

    /// Adds a frame.
    ///
    /// # Errors
    /// A file that cannot be written, or more frames than were promised.
    ///
    /// # Panics
    /// A frame of another size.
    pub fn add(&mut self, frame: &Picture) -> Result<(), AnimationError> {
        assert_eq!((frame.width, frame.height), (self.width, self.height), "frames of one size");
        match &mut self.encoder {
            Encoder::Gif(encoder, palette) => encoder.write_frame(&gif::Frame {
                width: self.width as u16,
                height: self.height as u16,
                delay: self.pace.ticks(self.added, Format::Gif.ticks_per_second()),
                buffer: palette.places(frame).into(),
                ..gif::Frame::default()
            })?,
            Encoder::Png(writer, palette) => {
                if self.frames != 1 {
                    let per_second = Format::Png.ticks_per_second();
                    writer.set_frame_delay(self.pace.ticks(self.added, per_second), per_second)?;
                }
                let bytes = match palette {
                    Some(palette) => palette.places(frame),
                    None => frame.rgba.as_chunks().0.iter().flat_map(|&[r, g, b, _]| [r, g, b]).collect(),
                };
                writer.write_image_data(&bytes)?;
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
            Encoder::Gif(encoder, _) => drop(encoder.into_inner()?),
            Encoder::Png(writer, _) => writer.finish()?,
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

    /// Every frame has other colours, and all 256 appear.
    fn frame(number: u32) -> Picture {
        let table = ColourMap::Inferno.table();
        let rgba = (0..20).flat_map(|pixel| table[(number as usize * 20 + pixel) % 256]).collect();
        Picture { width: SIZE.0, height: SIZE.1, rgba }
    }

    fn encoded(format: Format, frames: u32, pace: Pace) -> Vec<u8> {
        let mut bytes = Vec::new();
        let colours = Colours::Map(Box::new(ColourMap::Inferno.table()));
        let mut animation = Animation::new(&mut bytes, format, SIZE, &colours, frames, pace).unwrap();
        for number in 0..frames {
            animation.add(&frame(number)).unwrap();
        }
        animation.finish().unwrap();
        bytes
    }

    /// r, g, b from the top left.
    fn expected(number: u32) -> Vec<u8> {
        frame(number).rgba.chunks(4).flat_map(|pixel| pixel[..3].to_vec()).collect()
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
        let colours = Colours::Map(Box::new(ColourMap::Inferno.table()));
        let mut animation = Animation::new(Vec::new(), Format::Png, SIZE, &colours, 2, pace).unwrap();
        animation.add(&frame(0)).unwrap();
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
    fn pictures_of_any_colours_stay_as_they_are_in_a_png_and_nearly_so_in_a_gif() {
        let (width, height) = (40, 30);
        let at = |i: usize| [(i % 40 * 6) as u8, (i / 40 * 8) as u8, 128, 255];
        let picture = Picture { width, height, rgba: (0..width * height).flat_map(at).collect() };
        let encoded = |format| {
            let (mut bytes, colours) = (Vec::new(), Colours::Like(picture.clone()));
            let pace = Pace::new(5.0);
            let mut animation =
                Animation::new(&mut bytes, format, (width, height), &colours, 1, pace).unwrap();
            animation.add(&picture).unwrap();
            animation.finish().unwrap();
            bytes
        };
        let png = image::load_from_memory(&encoded(Format::Png)).unwrap().to_rgba8().into_raw();
        assert_eq!(png, picture.rgba);
        let mut options = gif::DecodeOptions::new();
        options.set_color_output(gif::ColorOutput::RGBA);
        let mut decoder = options.read_info(Cursor::new(encoded(Format::Gif))).unwrap();
        let gif = decoder.read_next_frame().unwrap().unwrap().buffer.to_vec();
        let off: u32 = gif.iter().zip(&picture.rgba).map(|(a, b)| u32::from(a.abs_diff(*b))).sum();
        // 1200 colours, 256 of which are kept: cells of 15 x 15, a quarter of which they are off in two channels of four.
        assert!(off < 6 * gif.len() as u32, "{off}");
    }
}
