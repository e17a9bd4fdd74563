//! Videos, encoded by the program `ffmpeg` on PATH.

use std::fs::File;
use std::io::{self, ErrorKind, Read, Seek, SeekFrom, Write};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::thread;
use std::time::Duration;

use anyhow::{Context, anyhow, bail};

use crate::echo;
use crate::picture::Picture;

/// The program, searched on PATH.
const PROGRAM: &str = "ffmpeg";
/// Whether videos are supported: not in a page, which has no other programs.
pub const IS_WRITTEN: bool = true;
/// Pixels per side that levels of H.264 have room for.
pub const LARGEST_SIDE: usize = 8192;
/// Last output of ffmpeg in an error: number of lines, and limit in bytes.
const LAST_LINES: usize = 3;
const LAST_BYTES: u64 = 1500;
/// Interval of checks for ffmpeg's end.
const LOOK: Duration = Duration::from_millis(5);

/// Codec and container of a video.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Codec {
    /// H.264 in MP4.
    H264,
    /// VP9 in WebM.
    Vp9,
}

impl Codec {
    fn arguments(self) -> &'static [&'static str] {
        match self {
            Self::H264 => &["-c:v", "libx264", "-crf", "16", "-movflags", "+faststart", "-f", "mp4"],
            Self::Vp9 => &[
                "-c:v",
                "libvpx-vp9",
                "-crf",
                "20",
                "-b:v",
                "0",
                "-row-mt",
                "1",
                "-cpu-used",
                "4",
                "-f",
                "webm",
            ],
        }
    }

    /// Fails early if a video of this size cannot be encoded, by encoding a blank frame.
    ///
    /// # Errors
    /// No ffmpeg, or one without this codec.
    pub fn check(self, (width, height): (usize, usize)) -> anyhow::Result<()> {
        let mut video = Video::new(self, (width, height), 25.0)?;
        video.add(&Picture { width, height, rgba: vec![255; width * height * 4] })?;
        video.finish(&mut io::sink(), &|| Ok(()))
    }
}

/// A video being encoded; dropped before its end, it leaves nothing behind.
#[derive(Debug)]
pub struct Video {
    program: Child,
    frames: Option<ChildStdin>,
    output: Output,
    complaints: File,
}

impl Video {
    /// Begins a video with this frame rate; sides are even.
    ///
    /// # Errors
    /// No ffmpeg, or no room for temporary files.
    pub fn new(codec: Codec, (width, height): (usize, usize), rate: f64) -> anyhow::Result<Self> {
        let no_file = "no temporary file can be made";
        let (output, stdout) = Output::new().context(no_file)?;
        let complaints = tempfile::tempfile().context(no_file)?;
        let mut command = Command::new(PROGRAM);
        command.args(["-hide_banner", "-loglevel", "error", "-nostdin", "-y"]);
        command.args(["-f", "rawvideo", "-pixel_format", "rgba"]);
        command.args(["-video_size", &format!("{width}x{height}"), "-framerate", &format!("{rate:.6}")]);
        // Without explicit tags, players assume BT.709 for large videos and BT.601 for small ones.
        command.args(["-i", "pipe:0", "-vf", "scale=out_color_matrix=bt709:out_range=tv"]);
        command.args(["-pix_fmt", "yuv420p", "-color_range", "tv", "-colorspace", "bt709"]);
        command.args(["-color_primaries", "bt709", "-color_trc", "bt709"]);
        command.args(codec.arguments()).arg(output.path());
        command.stdin(Stdio::piped()).stdout(stdout).stderr(complaints.try_clone().context(no_file)?);
        let mut program = command.spawn().map_err(|error| match error.kind() {
            ErrorKind::NotFound => anyhow!(
                "videos need the program `{PROGRAM}`, which is not on PATH; GIF, animated PNG and a PNG per frame work without it"
            ),
            _ => anyhow!("{PROGRAM} cannot be started: {error}"),
        })?;
        let frames = program.stdin.take();
        Ok(Self { program, frames, output, complaints })
    }

    /// # Errors
    /// ffmpeg's message if it ends early.
    pub fn add(&mut self, frame: &Picture) -> anyhow::Result<()> {
        match self.frames.as_mut().map(|frames| frames.write_all(&frame.rgba)) {
            Some(Ok(())) => Ok(()),
            Some(Err(_)) | None => {
                self.end(&|| Ok(()))?;
                bail!("{PROGRAM} ended before the last frame")
            }
        }
    }

    /// Finishes the video; `goes_on` is polled and cancels with an error.
    ///
    /// # Errors
    /// ffmpeg's message, or a file that cannot be written.
    pub fn finish(
        mut self,
        file: &mut dyn Write,
        goes_on: &dyn Fn() -> anyhow::Result<()>,
    ) -> anyhow::Result<()> {
        self.end(goes_on)?;
        let video = self.output.read()?;
        io::copy(&mut &*video, file)?;
        Ok(())
    }

    /// Waits for ffmpeg after its last frame.
    fn end(&mut self, goes_on: &dyn Fn() -> anyhow::Result<()>) -> anyhow::Result<()> {
        self.frames = None;
        let status = loop {
            match self.program.try_wait().with_context(|| format!("{PROGRAM} is lost"))? {
                Some(status) => break status,
                None => goes_on()?,
            }
            thread::sleep(LOOK);
        };
        if status.success() {
            return Ok(());
        }
        match last_lines(&mut self.complaints) {
            Ok(said) if !said.is_empty() => bail!("{PROGRAM} says: {}", echo::message(&said)),
            Ok(_) | Err(_) => bail!("{PROGRAM} failed without a word ({status})"),
        }
    }
}

impl Drop for Video {
    fn drop(&mut self) {
        // Both fail harmlessly after its end.
        let _ = self.program.kill();
        let _ = self.program.wait();
    }
}

fn last_lines(file: &mut File) -> io::Result<String> {
    let length = file.seek(SeekFrom::End(0))?;
    file.seek(SeekFrom::Start(length.saturating_sub(LAST_BYTES)))?;
    let mut said = Vec::new();
    file.take(LAST_BYTES).read_to_end(&mut said)?;
    let said = String::from_utf8_lossy(&said);
    let lines: Vec<_> = said.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
    Ok(lines[lines.len().saturating_sub(LAST_LINES)..].join("; "))
}

/// The output file of ffmpeg, which must be seekable, unlike a pipe. It has no name, so a killed program leaves
/// nothing behind.
#[cfg(unix)]
#[derive(Debug)]
struct Output(File);

#[cfg(unix)]
impl Output {
    fn new() -> io::Result<(Self, Stdio)> {
        let file = tempfile::tempfile()?;
        let own = file.try_clone()?;
        Ok((Self(own), file.into()))
    }

    fn path(&self) -> &'static str {
        "/dev/stdout"
    }

    fn read(&mut self) -> io::Result<&File> {
        self.0.rewind()?;
        Ok(&self.0)
    }
}

/// The output file of ffmpeg, removed on drop.
#[cfg(not(unix))]
#[derive(Debug)]
struct Output(tempfile::NamedTempFile);

#[cfg(not(unix))]
impl Output {
    fn new() -> io::Result<(Self, Stdio)> {
        Ok((Self(tempfile::NamedTempFile::new()?), Stdio::null()))
    }

    fn path(&self) -> &std::path::Path {
        self.0.path()
    }

    fn read(&mut self) -> io::Result<&File> {
        self.0.as_file_mut().rewind()?;
        Ok(self.0.as_file())
    }
}
