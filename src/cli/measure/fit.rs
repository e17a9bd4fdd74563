//! `sonoglyph measure --scan`: gains, phases and bench from the readings of a microphone.

use std::path::Path;

use anyhow::{Context, anyhow, bail};

use crate::cli::measure::args::MeasureArgs;
use crate::cli::progress;
use crate::cli::scene::{Source, read_scene};
use crate::measure::{Parameter, Search, fit};
use crate::picture::figure::Format;
use crate::scene::Scene;
use crate::studio::measurement::liquid::{self, MeasuredLiquid, is_heights};
use crate::studio::measurement::{self, Measured, Reading, report};
use crate::studio::output::{self, Files, note, say, warn};
use crate::studio::{figure, opening};

pub fn run(args: &MeasureArgs, scan_path: &Path) -> anyhow::Result<()> {
    let mut files = Files::new();
    let scene = read_scene(&args.scene, Source::default(), &mut files)?;
    files.reads(scan_path)?;
    args.drive.iter().try_for_each(|path| files.reads(path))?;
    args.fit.figure.iter().try_for_each(|path| figure::format(path).map(drop))?;
    args.fit.report.iter().try_for_each(|path| is_html(path).map(drop))?;
    for path in args.output.iter().chain(&args.fit.figure).chain(&args.fit.report) {
        files.writes(path)?;
    }
    if is_heights(scan_path) {
        return of_liquid(args, scene, scan_path);
    }
    let read = measurement::read(&scene, scan_path, args.drive.as_deref()).map_err(|error| anyhow!(error))?;
    let Reading { scan, drives, notes } = read;
    notes.iter().for_each(|text| note(text));
    let noise = args.snr.map(|snr| 10f64.powf(-snr / 20.0));
    let search = Search { free: free(args.fit.free.as_deref())?, width: args.fit.width, noise };
    let name = scan_path.display().to_string();
    let found = fit(&scene, &drives, &scan, &search, &progress::begin("Fitting")).context(name)?;
    let measured = Measured::new(scene, scan, found, noise);
    measured.notes().iter().for_each(|text| note(text));
    measured.warnings().iter().for_each(|warning| warn(warning));
    if let Some(path) = &args.output {
        if let Some(reason) = measured.unidentifiable() {
            bail!("no calibration was written: {reason}");
        }
        let elements = measured.scene.elements();
        output::write(path, measured.calibration(args.fit.gains).to_csv(elements).as_bytes())?;
    }
    let title = format!("{}: measured field", opening::stem(scan_path));
    if let Some(path) = &args.fit.figure {
        output::write(path, &report::drawn(&measured, &title, false)?.write(figure::format(path)?)?)?;
    }
    if let Some(path) = &args.fit.report {
        let bytes = match is_html(path)? {
            true => report::html(&measured, &title)?.into_bytes(),
            false => report::drawn(&measured, &title, true)?.write(Format::Pdf)?,
        };
        output::write(path, &bytes)?;
    }
    if args.fit.json {
        return say!("{:#}", measured.json());
    }
    measured.lines().iter().try_for_each(|line| say!("{line}"))
}

/// The strength from heights of a liquid.
fn of_liquid(args: &MeasureArgs, scene: Scene, path: &Path) -> anyhow::Result<()> {
    let others = [
        (args.output.is_some(), "-o: heights tell the strength, and no calibration of the elements"),
        (
            args.drive.is_some(),
            "--drive: heights are of the scene's own drive; name the file as `drive` in the scene",
        ),
        (args.fit.report.is_some(), "--report is of pressures: use --figure"),
        (args.fit.free.is_some() || args.fit.width.is_some(), "--free and --width are of pressures"),
    ];
    if let Some((_, reason)) = others.iter().find(|(is_given, _)| *is_given) {
        bail!("{reason}");
    }
    let heights = liquid::read(&scene, path).map_err(|error| anyhow!(error))?;
    let name = path.display().to_string();
    let measured = MeasuredLiquid::new(scene, &heights).map_err(|error| anyhow!("{name}: {error}"))?;
    if let Some(path) = &args.fit.figure {
        let title = format!("{}: measured depression", opening::stem(Path::new(&name)));
        output::write(path, &report::page(&measured.panels(), &title)?.write(figure::format(path)?)?)?;
    }
    if args.fit.json {
        return say!("{:#}", measured.json());
    }
    measured.lines().iter().try_for_each(|line| say!("{line}"))
}

/// Whether a report is a page of HTML rather than a PDF, by its ending.
fn is_html(path: &Path) -> anyhow::Result<bool> {
    match path.extension().unwrap_or_default().to_string_lossy().to_lowercase().as_str() {
        "html" | "htm" => Ok(true),
        "pdf" => Ok(false),
        _ => bail!("{}: reports are written as .html and .pdf, by the ending", path.display()),
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
