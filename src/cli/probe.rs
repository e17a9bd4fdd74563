//! `sonoglyph probe`: the complex pressure at points from a CSV file.

use std::f64::consts::FRAC_1_SQRT_2;
use std::path::Path;

use anyhow::{Context, bail};
use glam::DVec3;
use num_complex::Complex64;

use crate::acoustics::Aperture;
use crate::cli::{ProbeArgs, evaluator, output, read_scene, warn};
use crate::drive::Drive;
use crate::field::{Evaluator, Samples, reference};
use crate::solver;

/// Points beyond are a slip: their answer would fill gigabytes.
const MOST_POINTS: usize = 10_000_000;

pub fn run(args: &ProbeArgs) -> anyhow::Result<()> {
    let scene = read_scene(&args.scene, None)?;
    let points = read_points(&args.points)?;
    if let Some(path) = &args.output {
        output::check_writable(path)?;
    }
    let drive = match &args.drive {
        Some(path) => read_drive(path, scene.array.elements())?,
        None => {
            let solution = solver::solve(&scene).with_context(|| args.scene.display().to_string())?;
            solution.warnings.iter().for_each(|warning| warn(warning));
            solution.drive
        }
    };
    let evaluator = evaluator::for_points(args.backend.backend)?;
    let aperture = Aperture::new(&scene);
    let samples = Samples::at(points);
    let pressures: Vec<Complex64> = match evaluator {
        Evaluator::Reference => reference::pressure(&aperture, &drive, &samples),
        fast => {
            let wide = |p: num_complex::Complex32| Complex64::new(p.re.into(), p.im.into());
            fast.pressure(&aperture, &drive, &samples)?.into_iter().map(wide).collect()
        }
    };
    let mut text = String::from("x,y,z,re,im,rms\n");
    for (point, p) in samples.columns.iter().zip(&pressures) {
        let rms = p.norm() * FRAC_1_SQRT_2;
        text.push_str(&format!("{:?},{:?},{:?},{:?},{:?},{rms:?}\n", point.x, point.y, point.z, p.re, p.im));
    }
    match &args.output {
        Some(path) => output::write(path, text.as_bytes()),
        None => output::print(format_args!("{text}")),
    }
}

fn read_points(path: &Path) -> anyhow::Result<Vec<DVec3>> {
    let mut table = Columns::open(path, &["x", "y", "z"], &[])?;
    let mut points = Vec::new();
    while let Some((line, values)) = table.next_row()? {
        let [Some(x), Some(y), Some(z)] = values[..] else {
            bail!("{}:{line}: a value is missing", path.display())
        };
        points.push(DVec3::new(x, y, z));
        if points.len() > MOST_POINTS {
            bail!("{}:{line}: more than {MOST_POINTS} points", path.display());
        }
    }
    if points.is_empty() {
        bail!("{}: there are no points", path.display());
    }
    Ok(points)
}

/// Phase and amplitude per element; the columns `element` and `amplitude` may be left out.
fn read_drive(path: &Path, elements: usize) -> anyhow::Result<Drive> {
    let mut table = Columns::open(path, &["phase"], &["amplitude", "element"])?;
    let mut drive = Drive { amplitudes: vec![0.0; elements], phases: vec![0.0; elements] };
    let mut given = vec![false; elements];
    let mut next = 0;
    while let Some((line, values)) = table.next_row()? {
        let place = format!("{}:{line}", path.display());
        let [Some(phase), amplitude, element] = values[..] else { bail!("{place}: a phase is missing") };
        let element = element.unwrap_or(next as f64);
        if element.fract() != 0.0 || element < 0.0 || element >= elements as f64 {
            bail!("{place}: element = {element}: the scene's elements are numbered 0 to {}", elements - 1);
        }
        let element = element as usize;
        let amplitude = amplitude.unwrap_or(1.0);
        if !(0.0..=1.0).contains(&amplitude) {
            bail!("{place}: amplitude = {amplitude}: must be from 0 to 1");
        }
        if std::mem::replace(&mut given[element], true) {
            bail!("{place}: element {element} is given twice");
        }
        drive.phases[element] = phase;
        drive.amplitudes[element] = amplitude;
        next = element + 1;
    }
    match given.iter().position(|given| !given) {
        Some(missing) => bail!("{}: element {missing} of {elements} is missing", path.display()),
        None => Ok(drive),
    }
}

/// Named columns of numbers in a CSV file.
struct Columns<'a> {
    path: &'a Path,
    reader: csv::Reader<std::fs::File>,
    /// Name, and place in a row where the file has it.
    wanted: Vec<(&'static str, Option<usize>)>,
}

impl<'a> Columns<'a> {
    fn open(path: &'a Path, required: &[&'static str], optional: &[&'static str]) -> anyhow::Result<Self> {
        let file = std::fs::File::open(path).with_context(|| path.display().to_string())?;
        let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).from_reader(file);
        let headers = reader.headers().with_context(|| path.display().to_string())?.clone();
        let place =
            |name: &str| headers.iter().position(|header| header.trim_start_matches('\u{feff}') == name);
        let missing: Vec<_> =
            required.iter().filter(|name| place(name).is_none()).map(|name| format!("`{name}`")).collect();
        if !missing.is_empty() {
            bail!("{}:1: the column {} is missing", path.display(), missing.join(", "));
        }
        let wanted = required.iter().chain(optional).map(|&name| (name, place(name))).collect();
        Ok(Self { path, reader, wanted })
    }

    /// The line number of the next row and its wanted values in order.
    fn next_row(&mut self) -> anyhow::Result<Option<(u64, Vec<Option<f64>>)>> {
        let mut record = csv::StringRecord::new();
        if !self.reader.read_record(&mut record).with_context(|| self.path.display().to_string())? {
            return Ok(None);
        }
        let line = record.position().map_or(0, csv::Position::line);
        let mut values = Vec::with_capacity(self.wanted.len());
        for (name, place) in &self.wanted {
            let text = place.and_then(|place| record.get(place));
            let number = match text {
                Some(text) => match text.parse::<f64>() {
                    Ok(number) if number.is_finite() => Some(number),
                    _ => bail!("{}:{line}: {name} = `{text}`: not a finite number", self.path.display()),
                },
                None => None,
            };
            values.push(number);
        }
        Ok(Some((line, values)))
    }
}
