//! Replaces videos in a browser, which has no `ffmpeg`.

use std::io::Write;

use anyhow::bail;

use crate::picture::Picture;

pub const IS_WRITTEN: bool = false;
/// Pixels per side that levels of H.264 have room for.
pub const LARGEST_SIDE: usize = 8192;

/// The codec of a video.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Codec {
    H264,
    Vp9,
}

impl Codec {
    /// # Errors
    /// Always.
    pub fn check(self, _: (usize, usize)) -> anyhow::Result<()> {
        bail!("a page writes no videos, but GIF and PNG: the program for the desktop does, with ffmpeg")
    }
}

/// An uninhabited type.
#[derive(Debug)]
pub enum Video {}

impl Video {
    /// # Errors
    /// Always.
    pub fn new(codec: Codec, size: (usize, usize), _: f64) -> anyhow::Result<Self> {
        codec.check(size)?;
        bail!("there are no videos here")
    }

    /// # Errors
    /// None.
    pub fn add(&mut self, _: &Picture) -> anyhow::Result<()> {
        match *self {}
    }

    /// # Errors
    /// None.
    pub fn finish(self, _: &mut dyn Write, _: &dyn Fn() -> anyhow::Result<()>) -> anyhow::Result<()> {
        match self {}
    }
}
