//! `sonoglyph board`: a virtual board on a pseudo-terminal, with the field of its current frame.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use anyhow::{Context, bail};

use crate::cli::boards::arguments::BoardArgs;
use crate::cli::interrupt;
use crate::cli::scene::{Source, read_scene};
use crate::device::board::{Board, Playing, Report, Setup};
use crate::device::calibration::Calibration;
use crate::device::profile::Profile;
use crate::device::wiring::{Share, Wiring};
use crate::drive::Drive;
use crate::field::{Evaluator, Quantity, Request, Samples, Stages};
use crate::picture::{ColourMap, export};
use crate::rounding::pascals;
use crate::scene::Scene;
use crate::studio::bring_up::board_scene;
use crate::studio::map;
use crate::studio::output::{self, Files, note, say};

/// Interval of status lines.
const REPORT: Duration = Duration::from_secs(1);
/// Time from the first frame to the faults that happen once.
const FAULTS_AFTER: Duration = Duration::from_secs(2);
/// Pixels per side of the field.
const SIDE: usize = 256;

pub fn run(args: &BoardArgs) -> anyhow::Result<()> {
    let mut files = Files::new();
    let (scene, wiring) = scene(args, &mut files)?;
    if let Some(path) = &args.output {
        files.writes(path)?;
    }
    let interrupted = interrupt::watch()?;
    let mut setup = Setup::new(args.profile);
    setup.baud = args.baud;
    setup.faults = args.faults.unwrap_or_default();
    setup.phase_bits = args.phase_bits;
    if args.rtl {
        if args.profile != Profile::Native {
            bail!("--rtl simulates the native gateware, and {} is another board", args.profile.name());
        }
        setup.program = Some(build(&gateware(args.gateware.as_deref())?, args.phase_bits)?);
    }
    let board = Board::start(setup.clone(), Box::new(|_| {}))?;
    say!("{}", board.path().display())?;
    note(&format!(
        "a {} board listens there: {}",
        args.profile.name(),
        args.profile.bandwidth(args.baud.unwrap_or(args.profile.baud()))
    ));

    let begun = Instant::now();
    let mut monitor = Monitor::new(scene, wiring, args.output.clone());
    let mut faults = SingleFaults { first_frame: None, setup };
    let mut next_report = begun + REPORT;
    while !interrupted.is_set() && args.seconds.is_none_or(|seconds| begun.elapsed().as_secs_f64() < seconds)
    {
        std::thread::sleep(Duration::from_millis(10));
        faults.act(&board);
        if Instant::now() >= next_report {
            next_report += REPORT;
            monitor.update(&board.report())?;
        }
    }
    let report = board.report();
    monitor.update(&report)?;
    say!(
        "{} bytes, {} frames, {} spoiled, {} at another bit rate",
        report.bytes,
        report.frames,
        report.spoiled,
        report.wrong_baud
    )?;
    Ok(())
}

/// The scene with array and plane of the field; by default an array of the board's size.
fn scene(args: &BoardArgs, files: &mut Files) -> anyhow::Result<(Scene, Wiring)> {
    let Some(path) = &args.scene else {
        return Ok((board_scene(args.profile), Wiring::own(args.profile)));
    };
    let scene = read_scene(path, Source::default(), files)?;
    let wiring = Wiring::of(args.profile, &scene, Share::default());
    Ok((scene, wiring.with_context(|| path.display().to_string())?))
}

/// Script in the gateware's folder that builds the simulated device.
const SIMULATION: &str = "sim/build";

/// The gateware's folder: as given, or else beside the program or in the current folder.
fn gateware(given: Option<&Path>) -> anyhow::Result<PathBuf> {
    let beside = || std::env::current_exe().ok()?.parent().map(|folder| folder.join("gateware"));
    let folders = match given {
        Some(folder) => vec![folder.to_owned()],
        None => beside().into_iter().chain([PathBuf::from("./gateware")]).collect(),
    };
    let scripts: Vec<_> =
        folders.iter().map(|folder| folder.join(SIMULATION).display().to_string()).collect();
    folders.into_iter().find(|folder| folder.join(SIMULATION).is_file()).with_context(|| {
        format!(
            "--rtl needs the gateware's sources; looked for {}. Give the folder `gateware` of Sonoglyph's sources \
             with --gateware: Verilator builds the simulation there (on Debian, `apt-get install verilator make g++`)",
            scripts.join(" and ")
        )
    })
}

/// The simulated device, built by Verilator if missing.
fn build(gateware: &Path, phase_bits: u8) -> anyhow::Result<PathBuf> {
    let folder = gateware.join(format!("../target/gateware/{phase_bits}"));
    let script = gateware.join(SIMULATION);
    note("building the simulated gateware, which takes a minute the first time");
    let status = Command::new(&script).arg(phase_bits.to_string()).arg(&folder).status();
    if !status.with_context(|| script.display().to_string())?.success() {
        bail!(
            "the gateware was not built in {}; on Debian, `apt-get install verilator make g++` installs the tools",
            folder.display()
        );
    }
    Ok(folder.join("device"))
}

/// Triggers the faults that happen once.
struct SingleFaults {
    first_frame: Option<Instant>,
    setup: Setup,
}

impl SingleFaults {
    fn act(&mut self, board: &Board) {
        if self.first_frame.is_none() && board.report().frames > 0 {
            self.first_frame = Some(Instant::now());
        }
        let Some(first) = self.first_frame else { return };
        let now = |lasts: Duration| {
            !lasts.is_zero() && (FAULTS_AFTER..FAULTS_AFTER + lasts).contains(&first.elapsed())
        };
        board.stall(now(self.setup.faults.stall));
        board.unplug(now(self.setup.faults.unplug));
        board.press(now(self.setup.faults.press));
    }
}

/// Prints the events and the field of a board as they change.
struct Monitor {
    scene: Scene,
    wiring: Wiring,
    /// Of the scene's transducers.
    calibration: Calibration,
    output: Option<PathBuf>,
    stages: Stages,
    drive: Drive,
    frames: u64,
    events: usize,
}

impl Monitor {
    fn new(scene: Scene, wiring: Wiring, output: Option<PathBuf>) -> Self {
        let (stages, calibration) = (Stages::new(Evaluator::Cpu), Calibration::of(&scene));
        Self { scene, wiring, calibration, output, stages, drive: Drive::default(), frames: 0, events: 0 }
    }

    /// Prints news since the last report, with the field if drive or frame count have changed.
    fn update(&mut self, report: &Report) -> anyhow::Result<()> {
        for event in &report.events[self.events..] {
            say!("{event}")?;
        }
        self.events = report.events.len();
        let heard = |playing: &Playing| self.calibration.sound(self.wiring.drive(&playing.drive()));
        let drive = report.playing.as_ref().map(heard).unwrap_or_default();
        if drive == self.drive && report.frames == self.frames {
            return Ok(());
        }
        let field = if drive.amplitudes.iter().any(|&amplitude| amplitude > 0.0) {
            self.field(&drive)?
        } else {
            "silent".to_owned()
        };
        say!("{} frames, {} spoiled; {field}", report.frames, report.spoiled)?;
        (self.drive, self.frames) = (drive, report.frames);
        Ok(())
    }

    /// The largest pressure on the plane, as text. Also writes the picture, if requested.
    fn field(&mut self, drive: &Drive) -> anyhow::Result<String> {
        let request = Request::new(&self.scene, vec![drive.clone()], Quantity::Rms, (SIDE, SIDE));
        let drawn = map::draw(&request, ColourMap::Inferno, &mut self.stages, false)?;
        if let Some(path) = &self.output {
            output::write(path, &export::png(&drawn.picture)?)?;
        }
        let numbers = &drawn.map.values;
        let loudest = (0..numbers.len()).max_by(|&a, &b| numbers[a].total_cmp(&numbers[b])).unwrap_or(0);
        let place = Samples::on_plane(&self.scene.plane, SIDE, SIDE)
            .filter(|samples| loudest < samples.len())
            .map(|samples| samples.point(loudest) * 1e3);
        let place =
            place.map_or(String::new(), |at| format!(" at ({:.1}, {:.1}, {:.1}) mm", at.x, at.y, at.z));
        Ok(format!("peak {} RMS{place}", pascals(drawn.map.peak.into())))
    }
}
