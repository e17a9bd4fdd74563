//! `sonoglyph measure --plan`: the drives and places of a scan, and playing the drives while it runs.

use std::fs;
use std::path::PathBuf;

use anyhow::{Context, bail};
use glam::DVec2;

use crate::cli::boards::send;
use crate::cli::measure::args::MeasureArgs;
use crate::cli::scene::{Source, read_scene};
use crate::device::profile::Profile;
use crate::measure::plan::{LEVELS, Raster};
use crate::studio::measurement::DRIVE;
use crate::studio::measurement::plan::{Course, Plan, PlanWish};
use crate::studio::opening;
use crate::studio::output::{self, Files, note, say, warn};

/// Signal-to-noise of a microphone on a bench, dB.
const USUAL: f64 = 30.0;

pub fn run(args: &MeasureArgs) -> anyhow::Result<()> {
    let own = &args.plan_args;
    let mut files = Files::new();
    let scene = read_scene(&args.scene, Source::default(), &mut files)?;
    args.drive.iter().try_for_each(|path| files.reads(path))?;
    let folder = args.output.as_ref().context("--plan needs -o FOLDER")?;
    let drives = match &args.drive {
        Some(path) => {
            let read = opening::read_drive(path, path.display().to_string(), &scene);
            read.map_err(anyhow::Error::msg)?.table().map(|table| table.drives.clone())
        }
        None => None,
    };
    let raster = || {
        let mut raster = Raster::over(&scene);
        if !own.heights.is_empty() {
            raster.heights.clone_from(&own.heights);
        }
        match own.size[..] {
            [width, height] => raster.size = DVec2::new(width, height),
            [side] => raster.size = DVec2::splat(side),
            _ => {}
        }
        raster.step = own.step.unwrap_or(raster.step);
        raster
    };
    let course = match own.at {
        Some(at) => Course::Still { at, is_single: own.single },
        None => Course::Planes(raster()),
    };
    let wish = PlanWish {
        course,
        drives,
        count: own.drives.map(usize::from),
        seed: own.seed,
        levels: own.profile.map_or(LEVELS, Profile::levels),
        has_phases: own.phases,
        dwell: own.dwell,
        signal_to_noise: args.snr.unwrap_or(USUAL),
    };
    let plan = Plan::new(&scene, &wish).with_context(|| args.scene.display().to_string())?;
    if let Some(refusal) = plan.refusal() {
        bail!("{}: {refusal}", args.scene.display());
    }
    if folder.exists() && !folder.is_dir() {
        bail!("{}: this is a file; -o names the folder of the plan", folder.display());
    }
    let texts = [
        (DRIVE, plan.drive_csv()),
        ("positions.csv", plan.positions_csv()),
        ("path.gcode", plan.gcode()),
        ("scan.csv", plan.scan_csv()),
        ("expected.csv", plan.expected_csv()),
    ];
    fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    for (name, _) in &texts {
        files.writes(&folder.join(name))?;
    }
    for (name, text) in &texts {
        let path = folder.join(name);
        // A table that somebody has begun to fill in is worth more than an empty one.
        if *name == "scan.csv" && is_filled(&path, text) {
            warn(&format!("{} has readings and stays as it is", path.display()));
            continue;
        }
        output::write(&path, text.as_bytes())?;
    }
    plan.lines().iter().try_for_each(|line| say!("{line}"))?;
    play(args, &plan, folder.join(DRIVE))
}

/// Whether a file is there and is not an empty table.
fn is_filled(path: &std::path::Path, empty: &str) -> bool {
    fs::read_to_string(path).is_ok_and(|text| {
        let readings =
            |text: &str| text.lines().any(|line| line.ends_with(|last: char| last.is_ascii_digit()));
        readings(&text) && text != empty
    })
}

/// Plays the drives one after the other, if a board is named.
fn play(args: &MeasureArgs, plan: &Plan, drives: PathBuf) -> anyhow::Result<()> {
    let own = &args.plan_args;
    let (Some(port), Some(profile)) = (&own.port, own.profile) else { return Ok(()) };
    let send = |drive: PathBuf, seconds: Option<f64>| {
        send::run(&send::SendArgs::of_drive(
            (args.scene.clone(), drive),
            port.clone(),
            profile,
            own.baud,
            seconds,
        ))
    };
    if plan.drives.len() == 1 {
        return send(drives, own.seconds);
    }
    let folder = tempfile::tempdir()?;
    for (number, drive) in plan.drives.iter().enumerate() {
        let path = folder.path().join(format!("drive-{number}.csv"));
        let one = Plan { drives: vec![drive.clone()], ..plan.clone() };
        output::write(&path, one.drive_csv().as_bytes())?;
        note(&format!("drive {number} of {}", plan.drives.len()));
        send(path, Some(own.seconds.unwrap_or(plan.seconds())))?;
    }
    Ok(())
}
