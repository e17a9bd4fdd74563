//! `sonoglyph probe --time`: pressure at points over time, and the spectral lines of |p|².

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use anyhow::bail;
use clap::Args;
use glam::DVec3;
use num_complex::Complex64;

use crate::acoustics::course::Course;
use crate::cli::arguments::{above_zero, seconds};
use crate::cli::scene::write_or_print;
use crate::drive::Drive;
use crate::scene::{Scene, SpectralLine};
use crate::studio::output::{self, note};

/// Limits of a table's rows, and of pressures (frames times points) in memory.
const MOST_ROWS: f64 = 2e6;
const MOST_PRESSURES: usize = 1 << 26;
/// Hz, of the same line in two spectra.
const SAME_LINE: f64 = 1e-3;

#[derive(Debug, Args)]
pub struct TimeArgs {
    /// Pressure over time, under modulation and the frames of a motion: columns x, y, z (m), time (s), re, im (Pa,
    /// peak), square (|p|², Pa²); in scenes with `[skin]` also skin (m,
    /// positive into it), at points on the scene's plane
    #[arg(long)]
    pub time: bool,
    /// Duration of --time (s) [default: the common period of modulation and motion]
    #[arg(long, value_name = "S", requires = "time", allow_negative_numbers = true, value_parser = seconds(3600.0))]
    span: Option<f64>,
    /// Sampling rate of --time (Hz) [default: at least 32 per period of the fastest tone, 4 per frame, and the rate of a file]
    #[arg(long, value_name = "HZ", requires = "time", allow_negative_numbers = true, value_parser = above_zero(1e6, "a frequency in Hz"))]
    rate: Option<f64>,
    /// Also write the spectral lines of |p|²: columns x, y, z (m), frequency (Hz), square (Pa²; amplitude of the
    /// cosine, at 0 Hz the mean), phase (rad); in scenes with `[skin]` also skin (m) and
    /// skin_phase (rad)
    #[arg(long, value_name = "FILE.csv", requires = "time")]
    pub spectrum: Option<PathBuf>,
    /// Highest frequency of --spectrum (Hz)
    #[arg(long, value_name = "HZ", default_value_t = 1000.0, requires = "spectrum", allow_negative_numbers = true, value_parser = above_zero(1e6, "a frequency in Hz"))]
    band: f64,
}

/// Writes the time course at points, and its spectrum if requested, from the `pressure` of every frame's drive; with the
/// lines of the skin's displacement at the points, if there is skin.
pub fn write(
    args: &TimeArgs,
    scene: &Scene,
    points: &[DVec3],
    drives: &[Drive],
    pressure: impl Fn(&Drive) -> anyhow::Result<Vec<Complex64>>,
    skin: Option<&[Vec<SpectralLine>]>,
    to: Option<&Path>,
) -> anyhow::Result<()> {
    let course = Course::new(scene, drives.len());
    let (span, rate) = (args.span.unwrap_or(course.usual_span()), args.rate.unwrap_or(course.usual_rate()));
    // A steady sound has one instant.
    let instants = (span * rate).round().max(1.0);
    if instants * points.len() as f64 > MOST_ROWS {
        bail!(
            "{instants} instants ({span} s at {rate} Hz) at {} points are more than the {MOST_ROWS} rows of a table: \
             take fewer points, or a smaller --span or --rate",
            points.len()
        );
    }
    if drives.len().saturating_mul(points.len()) > MOST_PRESSURES {
        bail!(
            "{} frames at {} points exceed the memory limit: take fewer points",
            drives.len(),
            points.len()
        );
    }
    note_rates(&course, args, span);
    let frames: Vec<Vec<Complex64>> = drives.iter().map(pressure).collect::<Result<_, _>>()?;
    let band = args.spectrum.as_ref().map(|_| args.band);
    let [table, spectrum] = tables(&course, points, &frames, (instants as usize, rate), band, skin)?;
    if let Some(path) = &args.spectrum {
        output::write(path, spectrum.as_bytes())?;
    }
    write_or_print(to, &table)
}

/// CSV of so many instants, so many per second, at points, and of the lines of |p|² up to a frequency (Hz) if they are wanted.
/// `frames`: of every frame the pressures at these points.
///
/// # Errors
/// More lines than can be told apart.
fn tables(
    course: &Course,
    points: &[DVec3],
    frames: &[Vec<Complex64>],
    (instants, rate): (usize, f64),
    band: Option<f64>,
    skin: Option<&[Vec<SpectralLine>]>,
) -> anyhow::Result<[String; 2]> {
    let (of_table, of_spectrum) = if skin.is_some() { (",skin", ",skin,skin_phase") } else { ("", "") };
    let (mut table, mut spectrum) = (
        format!("x,y,z,time,re,im,square{of_table}\n"),
        format!("x,y,z,frequency,square,phase{of_spectrum}\n"),
    );
    for (index, point) in points.iter().enumerate() {
        let of_frames: Vec<_> = frames.iter().map(|frame| frame[index]).collect();
        let [x, y, z] = point.to_array();
        for (instant, p) in course.pressures(&of_frames, instants, rate).into_iter().enumerate() {
            let time = instant as f64 / rate;
            let _ = write!(table, "{x:?},{y:?},{z:?},{time:?},{:?},{:?},{:?}", p.re, p.im, p.norm_sqr());
            if let Some(skin) = skin {
                let _ = write!(table, ",{:?}", skin[index].iter().map(|line| line.at(time)).sum::<f64>());
            }
            table.push('\n');
        }
        let lines = band.map_or(Ok(Vec::new()), |band| course.spectrum(&of_frames, band));
        for SpectralLine { frequency, amplitude, phase } in lines.map_err(anyhow::Error::msg)? {
            let _ = write!(spectrum, "{x:?},{y:?},{z:?},{frequency:?},{amplitude:?},{phase:?}");
            if let Some(skin) = skin {
                let is_same = |line: &&SpectralLine| (line.frequency - frequency).abs() < SAME_LINE;
                let found = skin[index].iter().find(is_same);
                let [amplitude, phase] = found.map_or([0.0; 2], |line| [line.amplitude, line.phase]);
                let _ = write!(spectrum, ",{amplitude:?},{phase:?}");
            }
            spectrum.push('\n');
        }
    }
    Ok([table, spectrum])
}

/// Notes frame and cycle rates, and the choice of the span.
fn note_rates(course: &Course, args: &TimeArgs, span: f64) {
    let rate = course.frames_per_second();
    if rate > 0.0 {
        note(&format!("{rate:.3} frames/s, {:.3} cycles/s", course.cycles_per_second()));
    }
    match course.period() {
        _ if span == 0.0 => note("the sound is steady: a single instant is written"),
        None if args.span.is_none() && rate > 0.0 => {
            note(
                "modulation and motion have no common period: the table covers the longer one, and does not repeat",
            );
        }
        Some(_) | None => {}
    }
}
