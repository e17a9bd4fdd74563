//! `sonoglyph probe`: the complex pressure at points from a CSV file.

use std::fs::File;
use std::path::Path;

use anyhow::{Context, anyhow};
use num_complex::Complex64;

use crate::acoustics::Aperture;
use crate::cli::{ProbeArgs, read_scene};
use crate::drive::Drive;
use crate::field::{Evaluator, Samples, reference};
use crate::solver;
use crate::studio::evaluator;
use crate::studio::output::{self, warn};
use crate::studio::probe::Reading;
use crate::table::TableError;

pub fn run(args: &ProbeArgs) -> anyhow::Result<()> {
    let scene = read_scene(&args.scene, None)?;
    let samples = read_table(&args.points, Samples::read)?;
    if let Some(path) = &args.output {
        output::check_writable(path)?;
    }
    let drive = match &args.drive {
        Some(path) => read_table(path, |csv| Drive::read(csv, scene.array.elements()))?,
        None => {
            let solution = solver::solve(&scene).with_context(|| args.scene.display().to_string())?;
            solution.warnings.iter().for_each(|warning| warn(warning));
            solution.drive
        }
    };
    let evaluator = evaluator::for_points(args.backend.backend)?;
    let aperture = Aperture::new(&scene);
    let pressures: Vec<Complex64> = match evaluator {
        Evaluator::Reference => reference::pressure(&aperture, &drive, &samples),
        fast => {
            let wide = |p: num_complex::Complex32| Complex64::new(p.re.into(), p.im.into());
            fast.pressure(&aperture, &drive, &samples)?.into_iter().map(wide).collect()
        }
    };
    let mut text = String::from("x,y,z,re,im,rms\n");
    for (&point, &p) in samples.columns.iter().zip(&pressures) {
        let rms = Reading { position: point, pressure: p }.rms();
        text.push_str(&format!("{:?},{:?},{:?},{:?},{:?},{rms:?}\n", point.x, point.y, point.z, p.re, p.im));
    }
    match &args.output {
        Some(path) => output::write(path, text.as_bytes()),
        None => output::print(format_args!("{text}")),
    }
}

/// What `read` makes of a file; its errors name the file in front of the line.
fn read_table<T>(path: &Path, read: impl FnOnce(File) -> Result<T, TableError>) -> anyhow::Result<T> {
    let file = File::open(path).with_context(|| path.display().to_string())?;
    read(file).map_err(|error| anyhow!("{}:{error}", path.display()))
}
