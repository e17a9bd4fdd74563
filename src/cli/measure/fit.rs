//! `sonoglyph measure --scan`: gains, phases and bench from the readings of a microphone.

use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow, bail};

use crate::cli::measure::MeasureArgs;
use crate::cli::progress;
use crate::cli::scene::{Source, read_scene};
use crate::drive::Drive;
use crate::measure::{Parameter, Scan, Search, fit};
use crate::scene::Scene;
use crate::solver;
use crate::source;
use crate::studio::measurement::Measured;
use crate::studio::opening;
use crate::studio::output::{self, Files, note, say, warn};

/// The file of a plan's drives.
pub const DRIVE: &str = "drive.csv";

pub fn run(args: &MeasureArgs, scan_path: &Path) -> anyhow::Result<()> {
    let mut files = Files::new();
    let scene = read_scene(&args.scene, Source::default(), &mut files)?;
    files.reads(scan_path)?;
    let drive = args.drive.clone().or_else(|| beside(scan_path));
    drive.iter().try_for_each(|path| files.reads(path))?;
    for path in args.output.iter().chain(&args.fit.figure).chain(&args.fit.report) {
        files.writes(path)?;
    }
    let file = source::open(scan_path).with_context(|| scan_path.display().to_string())?;
    let mut scan = Scan::read(file).map_err(|error| anyhow!("{}:{error}", scan_path.display()))?;
    let drives = drives(&scene, drive.as_deref(), args.drive.is_none())?;
    count_from_one(&mut scan, drives.len());
    let search = Search { free: free(args.fit.free.as_deref())?, width: args.fit.width };
    let name = scan_path.display().to_string();
    let found = fit(&scene, &drives, &scan, &search, &progress::begin("Fitting")).context(name)?;
    let noise = args.snr.map(|snr| 10f64.powf(-snr / 20.0));
    let measured = Measured::new(scene, scan, found, noise);
    measured.warnings().iter().for_each(|warning| warn(warning));
    if let Some(path) = &args.output {
        if let Some(vague) = &measured.fit.vague {
            bail!("no calibration was written: {vague}");
        }
        let elements = measured.scene.elements();
        output::write(path, measured.calibration(args.fit.gains).to_csv(elements).as_bytes())?;
    }
    if args.fit.json {
        return say!("{:#}", measured.json());
    }
    measured.lines().iter().try_for_each(|line| say!("{line}"))
}

/// The drives of a plan in the scan's folder.
fn beside(scan: &Path) -> Option<PathBuf> {
    let path = scan.with_file_name(DRIVE);
    path.is_file().then_some(path)
}

fn drives(scene: &Scene, path: Option<&Path>, is_found: bool) -> anyhow::Result<Vec<Drive>> {
    let Some(path) = path else {
        note("the drive is the scene's own: give the one that was played with --drive if it was another");
        return Ok(solver::solve(scene)?.drives());
    };
    if is_found {
        note(&format!("the drive is that of {}", path.display()));
    }
    let read = opening::read_drive(path, path.display().to_string(), scene).map_err(anyhow::Error::msg)?;
    Ok(read.table().map(|table| table.drives.clone()).unwrap_or_default())
}

/// Drives counted from 1 in the scan.
fn count_from_one(scan: &mut Scan, drives: usize) {
    let (least, most) = scan.drives.iter().fold((usize::MAX, 0), |(a, b), &d| (a.min(d), b.max(d)));
    if least >= 1 && most == drives {
        note("the scan counts its drives from 1");
        scan.drives.iter_mut().for_each(|drive| *drive -= 1);
    }
}

/// The parameters of these names.
fn free(names: Option<&[String]>) -> anyhow::Result<Option<Vec<Parameter>>> {
    let Some(names) = names else { return Ok(None) };
    let mut free = Vec::new();
    for name in names.iter().map(|name| name.trim()) {
        let named = |parameter: &Parameter| parameter.name() == name;
        match Parameter::ALL.into_iter().find(named) {
            Some(parameter) if free.contains(&parameter) => bail!("--free: {name} is listed twice"),
            Some(parameter) => free.push(parameter),
            None if name == "none" => {}
            None => {
                let names: Vec<_> = Parameter::ALL.iter().map(|it| it.name()).collect();
                bail!("--free: {name:?} must be one of {}, or none", names.join(", "))
            }
        }
    }
    Ok(Some(free))
}
