//! `sonoglyph probe`: the complex pressure, or the force on a bead, at points from a CSV file.

use std::fs::File;
use std::path::Path;

use anyhow::{Context, anyhow, bail};
use glam::DVec3;
use num_complex::Complex64;
use rayon::prelude::*;

use crate::acoustics::Aperture;
use crate::cli::{ProbeArgs, Probed, read_scene, time_course};
use crate::drive::Drive;
use crate::field::{Evaluator, Samples, reference};
use crate::force::Levitation;
use crate::solver;
use crate::source;
use crate::studio::evaluator::{self, Backend};
use crate::studio::output::{self, Files, note, warn};
use crate::studio::probe::Reading;
use crate::table::TableError;

pub fn run(args: &ProbeArgs) -> anyhow::Result<()> {
    let mut files = Files::new();
    let scene = read_scene(&args.scene, None, &mut files)?;
    for path in [&args.points].into_iter().chain(&args.drive) {
        files.reads(path)?;
    }
    for path in args.output.iter().chain(&args.time.spectrum) {
        files.writes(path)?;
    }
    let samples = read_table(&args.points, Samples::read)?;
    let drives = match &args.drive {
        Some(path) => vec![read_table(path, |csv| Drive::read(csv, scene.elements()))?],
        None if args.time.time => time_course::drives(&scene, &args.scene.display().to_string())?,
        None => {
            let solution = solver::solve(&scene).with_context(|| args.scene.display().to_string())?;
            solution.warnings.iter().for_each(|warning| warn(&warning.to_string()));
            solution.drives()
        }
    };
    let aperture = Aperture::new(&scene);
    if args.quantity == Probed::Force {
        return forces(args, &Levitation::new(&scene, &aperture, &drives), &samples.columns);
    }
    let evaluator = evaluator::for_points(args.backend.backend)?;
    let pressure = |drive: &Drive| -> anyhow::Result<Vec<Complex64>> {
        Ok(match evaluator {
            Evaluator::Reference => reference::pressure(&aperture, drive, &samples),
            Evaluator::Cpu | Evaluator::Gpu(_) => {
                let wide = |p: num_complex::Complex32| Complex64::new(p.re.into(), p.im.into());
                evaluator.pressure(&aperture, drive, &samples)?.into_iter().map(wide).collect()
            }
        })
    };
    if args.time.time {
        return time_course::write(
            &args.time,
            &scene,
            &samples.columns,
            &drives,
            pressure,
            args.output.as_deref(),
        );
    }
    let pressures = mean(&drives.iter().map(pressure).collect::<Result<Vec<_>, _>>()?);
    if drives.len() > 1 {
        note(
            "`re` and `im` have the modulus of the mean of all drives that take turns, and the phase of the first",
        );
    }
    let mut text = String::from("x,y,z,re,im,rms\n");
    for (&point, &p) in samples.columns.iter().zip(&pressures) {
        let rms = Reading { position: point, pressure: p }.rms();
        text.push_str(&format!("{:?},{:?},{:?},{:?},{:?},{rms:?}\n", point.x, point.y, point.z, p.re, p.im));
    }
    write(args, &text)
}

/// A row per point: where it is, the potential (J), the force (N) and the symmetric part of the stiffness (N/m).
fn forces(args: &ProbeArgs, levitation: &Levitation, points: &[DVec3]) -> anyhow::Result<()> {
    match args.backend.backend {
        Backend::Auto | Backend::Reference => {}
        Backend::Cpu | Backend::Gpu => bail!("forces are computed in f64: leave --backend out"),
    }
    levitation.sphere.warning().iter().for_each(|warning| warn(warning));
    let mut text = String::from("x,y,z,gorkov,fx,fy,fz,kxx,kxy,kxz,kyy,kyz,kzz\n");
    let all: Vec<_> = points.par_iter().map(|&point| levitation.forces(point)).collect();
    for (point, forces) in points.iter().zip(all) {
        let (force, k) = (forces.force, forces.symmetric());
        let stiffness = [k.x_axis.x, k.x_axis.y, k.x_axis.z, k.y_axis.y, k.y_axis.z, k.z_axis.z];
        let row = [point.x, point.y, point.z, forces.gorkov, force.x, force.y, force.z];
        let row: Vec<_> = row.into_iter().chain(stiffness).map(|value| format!("{value:?}")).collect();
        text.push_str(&row.join(","));
        text.push('\n');
    }
    write(args, &text)
}

fn write(args: &ProbeArgs, text: &str) -> anyhow::Result<()> {
    match &args.output {
        Some(path) => output::write(path, text.as_bytes()),
        None => output::print(format_args!("{text}")),
    }
}

/// As loud as the mean square of all, with the phase of the first.
fn mean(drives: &[Vec<Complex64>]) -> Vec<Complex64> {
    if let [one] = drives {
        return one.clone();
    }
    let modulus = |index: usize| {
        let squares = drives.iter().map(|pressures| pressures[index].norm_sqr()).sum::<f64>();
        (squares / drives.len() as f64).sqrt()
    };
    let first = drives.iter().take(1).flatten().enumerate();
    first.map(|(index, p)| Complex64::from_polar(modulus(index), p.arg())).collect()
}

/// What `read` makes of a file; its errors name the file in front of the line.
fn read_table<T>(path: &Path, read: impl FnOnce(File) -> Result<T, TableError>) -> anyhow::Result<T> {
    let file = source::open(path).with_context(|| path.display().to_string())?;
    read(file).map_err(|error| anyhow!("{}:{error}", path.display()))
}
