//! `sonoglyph probe`: complex pressure, or the force on a bead, at points from a CSV file.

use std::fs::File;
use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow, bail};
use clap::{Args, ValueEnum};
use glam::{DVec2, DVec3};
use num_complex::Complex64;

use crate::acoustics::{Aperture, response::responding};
use crate::cli::arguments::{BackendArgs, DriveArgs};
use crate::cli::scene::{read_scene, write_or_print};
use crate::cli::time_course::TimeArgs;
use crate::cli::{progress, time_course};
use crate::drive::Drive;
use crate::field::{Evaluator, Quantity, Request, Samples, Stages, reference};
use crate::force::Levitation;
use crate::scene::{Scene, SpectralLine};
use crate::solver;
use crate::source;
use crate::studio::evaluator::{self, Backend};
use crate::studio::output::{Files, note, warn};
use crate::studio::performance::Performance;
use crate::studio::probe;
use crate::table::TableError;

#[derive(Debug, Args)]
pub struct ProbeArgs {
    /// Scene file
    pub scene: PathBuf,
    /// Table with the columns x, y, z (m, or as `x [mm]`)
    #[arg(long, value_name = "FILE.csv")]
    pub points: PathBuf,
    #[command(flatten)]
    pub backend: BackendArgs,
    #[command(flatten)]
    pub drive: DriveArgs,
    /// Computed quantity
    ///
    /// `force`: Gor'kov potential, radiation force on the scene's `[bead]` without its weight, and the symmetric part
    /// of the stiffness -dF/dx, in f64 from analytic derivatives; the mean over several drives.
    #[arg(long, value_enum, default_value_t = Probed::Pressure, conflicts_with = "time")]
    pub quantity: Probed,
    #[command(flatten)]
    pub time: TimeArgs,
    /// Output file [default: standard output]
    #[arg(short, long, value_name = "FILE.csv")]
    pub output: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Probed {
    /// Complex peak pressure, and RMS
    Pressure,
    /// Radiation force on the scene's bead
    Force,
}

pub fn run(args: &ProbeArgs) -> anyhow::Result<()> {
    let mut files = Files::new();
    let scene = read_scene(&args.scene, args.drive.source(), &mut files)?;
    files.reads(&args.points)?;
    for path in args.output.iter().chain(&args.time.spectrum) {
        files.writes(path)?;
    }
    let (samples, has_unit) = read_table(&args.points, Samples::read_with_unit)?;
    if !has_unit {
        probe::slip(&scene, &samples.columns).iter().for_each(|warning| warn(warning));
    }
    let name = args.scene.display().to_string();
    let drives = if args.time.time {
        Performance::of(&scene, &name, progress::begin)?.drives()
    } else {
        let solution = solver::solve(&scene).with_context(|| name)?;
        solution.warnings.iter().for_each(|warning| warn(&warning.to_string()));
        responding(&scene, solution.drives(), false)
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
        let skin = scene.skin.is_some().then(|| of_skin(&scene, &drives, &samples.columns, &evaluator));
        return time_course::write(
            &args.time,
            &scene,
            &samples.columns,
            &drives,
            pressure,
            skin.transpose()?.as_deref(),
            args.output.as_deref(),
        );
    }
    let pressures = probe::mean(&drives.iter().map(pressure).collect::<Result<Vec<_>, _>>()?);
    if drives.len() > 1 {
        note("`re` and `im` have the RMS modulus of all drives in turn, and the phase of the first");
    }
    write_or_print(args.output.as_deref(), &probe::pressures_csv(&samples.columns, &pressures))
}

/// The lines of the skin's displacement at points, which must be on it.
fn of_skin(
    scene: &Scene,
    drives: &[Drive],
    points: &[DVec3],
    evaluator: &Evaluator,
) -> anyhow::Result<Vec<Vec<SpectralLine>>> {
    /// m
    const BESIDE: f64 = 1e-3;
    let plane = &scene.plane;
    let (x, y) = plane.axes().context("the scene's plane has no axes")?;
    let (half, normal) = (plane.size / 2.0, x.cross(y));
    let place = |(index, point): (usize, &DVec3)| {
        let from = *point - plane.centre;
        let (place, height) = (DVec2::new(from.dot(x), from.dot(y)), from.dot(normal));
        if height.abs() > BESIDE || place.abs().cmpgt(half + BESIDE).any() {
            bail!("point {} at {point} m is not on the skin, which is the scene's [plane]", index + 1);
        }
        Ok(place.clamp(-half, half))
    };
    let places = points.iter().enumerate().map(place).collect::<anyhow::Result<Vec<_>>>()?;
    let own = match evaluator {
        Evaluator::Reference => Evaluator::Reference,
        Evaluator::Cpu | Evaluator::Gpu(_) => Evaluator::Cpu,
    };
    let request = Request::new(scene, drives.to_vec(), Quantity::Skin, (1, 1));
    Ok(Stages::new(own).skin(&request)?.at(&places))
}

fn forces(args: &ProbeArgs, levitation: &Levitation, points: &[DVec3]) -> anyhow::Result<()> {
    match args.backend.backend {
        Backend::Auto | Backend::Reference => {}
        Backend::Cpu | Backend::Gpu => bail!("forces are computed in f64: leave --backend out"),
    }
    levitation.sphere.warning().iter().for_each(|warning| warn(warning));
    write_or_print(args.output.as_deref(), &probe::forces_csv(levitation, points))
}

/// Reads a file. Errors name it before the line.
fn read_table<T>(path: &Path, read: impl FnOnce(File) -> Result<T, TableError>) -> anyhow::Result<T> {
    let file = source::open(path).with_context(|| path.display().to_string())?;
    read(file).map_err(|error| anyhow!("{}:{error}", path.display()))
}
