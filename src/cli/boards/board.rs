//! `sonoglyph board`: a virtual board on a pseudo-terminal, with the field of its current frame and a microphone in it.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use anyhow::{Context, anyhow, bail};

use crate::acoustics::Aperture;
use crate::cli::boards::arguments::BoardArgs;
use crate::cli::interrupt;
use crate::cli::scene::{Source, read_scene};
use crate::device::board::hidden::Hidden;
use crate::device::board::microphone::{Microphone, Signal};
use crate::device::board::{Board, Playing, Report, Setup};
use crate::device::calibration::Calibration;
use crate::device::profile::Profile;
use crate::device::wiring::{Share, Wiring};
use crate::drive::Drive;
use crate::field::{Evaluator, Quantity, Request, Samples, Stages};
use crate::picture::{ColourMap, export};
use crate::rounding::pascals;
use crate::scene::Scene;
use crate::source;
use crate::studio::bring_up::board_scene;
use crate::studio::map;
use crate::studio::output::{self, Files, note, say};

/// Interval of status lines.
const REPORT: Duration = Duration::from_secs(1);
/// Time from the first frame to the faults that happen once.
const FAULTS_AFTER: Duration = Duration::from_secs(2);
/// Pixels per side of the field.
const SIDE: usize = 256;
/// Interval of looks at the board, and with a microphone.
const LOOK: Duration = Duration::from_millis(10);
const LOOK_OF_MICROPHONE: Duration = Duration::from_micros(1700);
/// Time, and number of looks, for which a drive must stay the same to be read; simulated gateware is slower than
/// its own time.
const STEADY: Duration = Duration::from_millis(10);
const STEADY_OF_GATEWARE: Duration = Duration::from_millis(500);
const STEADY_LOOKS: u32 = 4;
/// Time after the last frame from which on changes of the drive are the board's own: a motion or modulation.
const SETTLED: Duration = Duration::from_millis(100);
/// Time without a steady drive after which this is said.
const RESTLESS: Duration = Duration::from_secs(1);
/// Limit of the rows of readings.
const MOST_ROWS: usize = 2_000_000;

pub fn run(args: &BoardArgs) -> anyhow::Result<()> {
    let mut files = Files::new();
    let (scene, wiring) = scene(args, &mut files)?;
    if let Some(path) = &args.positions {
        files.reads(path)?;
    }
    for path in args.output.iter().chain(&args.readings).chain(&args.truth) {
        files.writes(path)?;
    }
    let hidden = args.hidden.map(|seed| Hidden::new(seed, scene.elements()));
    let truth = hidden.as_ref().map(|hidden| hidden.truth(&scene));
    let scene = room(args, &scene, hidden.as_ref())?;
    let mut scan = Scan::of(args, &scene, hidden.as_ref())?;
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
    if let (Some(path), Some(truth)) = (&args.truth, truth) {
        output::write(path, truth.as_bytes())?;
    }
    let board = Board::start(setup.clone(), Box::new(|_| {}))?;
    say!("{}", board.path().display())?;
    note(&format!(
        "a {} board listens there: {}",
        args.profile.name(),
        args.profile.bandwidth(args.baud.unwrap_or(args.profile.baud()))
    ));

    let begun = Instant::now();
    let look = if scan.is_some() { LOOK_OF_MICROPHONE } else { LOOK };
    let mut monitor = Monitor::new(scene, wiring, hidden, args.output.clone());
    let mut faults = SingleFaults { first_frame: None, setup };
    let mut next_report = begun + REPORT;
    while !interrupted.is_set() && args.seconds.is_none_or(|seconds| begun.elapsed().as_secs_f64() < seconds)
    {
        std::thread::sleep(look);
        faults.act(&board);
        if let Some(scan) = &mut scan {
            let report = board.report();
            scan.look(&monitor.played(&report), report.frames)?;
        }
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

/// The scene in which the board sounds: with its own air and the microphone's wall.
fn room(args: &BoardArgs, scene: &Scene, hidden: Option<&Hidden>) -> anyhow::Result<Scene> {
    let Some(hidden) = hidden else { return Ok(scene.clone()) };
    let room = args.microphone.unwrap_or_default().room(&hidden.scene(scene));
    room.map_err(|reason| anyhow!("--microphone {reason}"))
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

/// A change of what a board plays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Change {
    None,
    /// The drive has been the same for long enough.
    Steady,
    /// The latest steady drive has changed without a new frame: it was a part of a ramp or of a motion.
    Withdrawn,
    /// The drive keeps changing; of changes by the board itself, the latest steady drive may have been a part.
    Moving {
        withdraws: bool,
    },
}

/// The time for which a board has played the same drive.
#[derive(Debug)]
struct Steadiness {
    /// Required time.
    least: Duration,
    drive: Drive,
    /// The first look at the drive, with the frames until then.
    since: Instant,
    frames_then: u64,
    looks: u32,
    is_steady: bool,
    frames: u64,
    /// The latest frame.
    framed: Instant,
    /// Frames until a motion within the board, which ends with the next frame.
    moving: Option<u64>,
    /// The beginning of sound without a steady drive.
    restless: Option<Instant>,
}

impl Steadiness {
    fn new(least: Duration, now: Instant) -> Self {
        Self {
            least,
            drive: Drive::default(),
            since: now,
            frames_then: 0,
            looks: 0,
            is_steady: false,
            frames: 0,
            framed: now,
            moving: None,
            restless: None,
        }
    }

    /// The next look at a board that has shown so many frames.
    fn look(&mut self, drive: &Drive, frames: u64, now: Instant) -> Change {
        if frames != self.frames {
            (self.frames, self.framed, self.moving) = (frames, now, None);
        }
        if *drive == self.drive {
            self.looks += 1;
        } else {
            // A board that is silenced fades by itself.
            let is_own = is_heard(drive)
                && is_heard(&self.drive)
                && frames == self.frames_then
                && !fades(&self.drive, drive);
            let was_steady = std::mem::replace(&mut self.is_steady, false);
            self.drive.clone_from(drive);
            (self.since, self.frames_then, self.looks) = (now, frames, 1);
            if is_own && self.moving.is_none() && now.duration_since(self.framed) >= SETTLED {
                self.moving = Some(frames);
                return Change::Moving { withdraws: was_steady };
            }
            if is_own && was_steady {
                return Change::Withdrawn;
            }
        }
        if !is_heard(drive) || self.is_steady || self.moving.is_some() {
            self.restless = None;
            return Change::None;
        }
        if now.duration_since(self.since) >= self.least && self.looks >= STEADY_LOOKS {
            (self.is_steady, self.restless) = (true, None);
            return Change::Steady;
        }
        if now.duration_since(*self.restless.get_or_insert(now)) >= RESTLESS {
            self.restless = None;
            return Change::Moving { withdraws: false };
        }
        Change::None
    }
}

/// Whether no element is louder than before.
fn fades(before: &Drive, after: &Drive) -> bool {
    before.amplitudes.iter().zip(&after.amplitudes).all(|(before, after)| after <= before)
        && before.amplitudes != after.amplitudes
}

fn is_heard(drive: &Drive) -> bool {
    drive.amplitudes.iter().any(|&amplitude| amplitude > 0.0)
}

/// A microphone that reads each new steady drive at all positions, and the file of its readings.
struct Scan {
    microphone: Microphone,
    hidden: Hidden,
    aperture: Aperture,
    /// m, nominal.
    positions: Vec<[f64; 3]>,
    readings: PathBuf,
    steadiness: Steadiness,
    /// The drives that were read, and the rows of each.
    drives: Vec<(Drive, String)>,
    /// Whether the latest steady drive is the last of them, not one from before.
    is_new: bool,
    has_noted_motion: bool,
    has_noted_limit: bool,
}

impl Scan {
    /// The scan of the arguments in a room.
    fn of(args: &BoardArgs, room: &Scene, hidden: Option<&Hidden>) -> anyhow::Result<Option<Self>> {
        let (Some(hidden), Some(path), Some(readings)) = (hidden, &args.positions, &args.readings) else {
            return Ok(None);
        };
        let microphone = args.microphone.unwrap_or_default();
        Ok(Some(Self {
            microphone,
            hidden: hidden.clone(),
            aperture: Aperture::new(room),
            positions: positions(path, room, microphone.wall)?,
            readings: readings.clone(),
            steadiness: Steadiness::new(if args.rtl { STEADY_OF_GATEWARE } else { STEADY }, Instant::now()),
            drives: Vec::new(),
            is_new: false,
            has_noted_motion: false,
            has_noted_limit: false,
        }))
    }

    /// The next look at a board that has shown so many frames; reads a new steady drive.
    fn look(&mut self, drive: &Drive, frames: u64) -> anyhow::Result<()> {
        match self.steadiness.look(drive, frames, Instant::now()) {
            Change::None => Ok(()),
            Change::Steady => self.read(drive),
            Change::Withdrawn => self.withdraw(),
            Change::Moving { withdraws } => {
                if !std::mem::replace(&mut self.has_noted_motion, true) {
                    note(
                        "the drive keeps changing (a motion, drives in turn or a modulation), and the microphone reads \
                         steady drives only: play them one after the other",
                    );
                }
                if withdraws { self.withdraw() } else { Ok(()) }
            }
        }
    }

    fn read(&mut self, drive: &Drive) -> anyhow::Result<()> {
        self.is_new = self.drives.iter().all(|(other, _)| other != drive);
        if !self.is_new {
            return Ok(());
        }
        let number = self.drives.len();
        if (number + 1) * self.positions.len() > MOST_ROWS {
            self.is_new = false;
            if !std::mem::replace(&mut self.has_noted_limit, true) {
                note(&format!("more than {MOST_ROWS} readings: further drives are not read"));
            }
            return Ok(());
        }
        let signals =
            self.microphone.read(&self.aperture, &self.hidden, &self.positions, (number as u64, drive));
        self.drives.push((drive.clone(), self.rows(number, &signals)));
        self.write()?;
        let squares: f64 = signals.iter().map(|signal| signal.amplitude().powi(2)).sum();
        let rms = (squares / signals.len() as f64).sqrt();
        say!("drive {number} read at {} positions: {} peak, RMS over them", signals.len(), pascals(rms))
    }

    /// Drops the latest readings, which are not of a steady drive.
    fn withdraw(&mut self) -> anyhow::Result<()> {
        if std::mem::replace(&mut self.is_new, false) {
            self.drives.pop();
            say!("drive {} was not steady: its readings are dropped", self.drives.len())?;
            self.write()?;
        }
        Ok(())
    }

    fn rows(&self, drive: usize, signals: &[Signal]) -> String {
        let row = |([x, y, z], signal): (&[f64; 3], &Signal)| {
            let value = match self.microphone.complex {
                true => format!("{:?},{:?}", signal.re, signal.im),
                false => format!("{:?}", signal.amplitude()),
            };
            format!("{x:?},{y:?},{z:?},{value},{drive}\n")
        };
        self.positions.iter().zip(signals).map(row).collect()
    }

    fn write(&self) -> anyhow::Result<()> {
        let columns = if self.microphone.complex { "re,im" } else { "amplitude" };
        let rows: String = self.drives.iter().map(|(_, rows)| rows.as_str()).collect();
        output::write(&self.readings, format!("x,y,z,{columns},drive\n{rows}").as_bytes())
    }
}

/// The positions (m) of a file, all of them within the sound.
fn positions(path: &Path, room: &Scene, wall: Option<f64>) -> anyhow::Result<Vec<[f64; 3]>> {
    let name = path.display();
    let file = source::open(path).with_context(|| name.to_string())?;
    let samples = Samples::read(file).map_err(|error| anyhow!("{name}:{error}"))?;
    if samples.len() > MOST_ROWS {
        bail!("{name}: {} positions are more than the limit of {MOST_ROWS}", samples.len());
    }
    let front = room.front();
    for (index, &point) in samples.columns.iter().enumerate() {
        let refuse = |reason: &str| bail!("{name}: position {} at {point} m is {reason}", index + 1);
        if !front.contains(point) {
            return refuse(front.behind());
        }
        if wall.is_some_and(|height| point.z >= height) {
            return refuse("on or above the microphone's wall");
        }
    }
    Ok(samples.columns.iter().map(|point| point.to_array()).collect())
}

/// Prints the events and the field of a board as they change.
struct Monitor {
    scene: Scene,
    wiring: Wiring,
    /// Of the scene's transducers.
    calibration: Calibration,
    hidden: Option<Hidden>,
    output: Option<PathBuf>,
    stages: Stages,
    drive: Drive,
    frames: u64,
    events: usize,
}

impl Monitor {
    fn new(scene: Scene, wiring: Wiring, hidden: Option<Hidden>, output: Option<PathBuf>) -> Self {
        let (stages, calibration, drive) =
            (Stages::new(Evaluator::Cpu), Calibration::of(&scene), Drive::default());
        Self { scene, wiring, calibration, hidden, output, stages, drive, frames: 0, events: 0 }
    }

    /// The played drive as its model sounds.
    fn played(&self, report: &Report) -> Drive {
        let heard = |playing: &Playing| self.calibration.sound(self.wiring.drive(&playing.drive()));
        report.playing.as_ref().map(heard).unwrap_or_default()
    }

    /// Prints news since the last report, with the field if drive or frame count have changed.
    fn update(&mut self, report: &Report) -> anyhow::Result<()> {
        for event in &report.events[self.events..] {
            say!("{event}")?;
        }
        self.events = report.events.len();
        let drive = self.played(report);
        if drive == self.drive && report.frames == self.frames {
            return Ok(());
        }
        let field = if is_heard(&drive) { self.field(&drive)? } else { "silent".to_owned() };
        say!("{} frames, {} spoiled; {field}", report.frames, report.spoiled)?;
        (self.drive, self.frames) = (drive, report.frames);
        Ok(())
    }

    /// The largest pressure on the plane, as text. Also writes the picture, if requested.
    fn field(&mut self, drive: &Drive) -> anyhow::Result<String> {
        let sound = self.hidden.as_ref().map_or_else(|| drive.clone(), |hidden| hidden.sound(drive.clone()));
        let request = Request::new(&self.scene, vec![sound], Quantity::Rms, (SIDE, SIDE));
        let drawn = map::draw(&request, ColourMap::Inferno, &mut self.stages, false)?;
        if let Some(path) = &self.output {
            output::write(path, &export::png(&drawn.picture)?)?;
        }
        let numbers = &drawn.map.values;
        let outside = (0..numbers.len()).filter(|&pixel| !numbers[pixel].is_nan());
        let loudest = outside.max_by(|&a, &b| numbers[a].total_cmp(&numbers[b])).unwrap_or(0);
        let place = Samples::on_plane(&self.scene.plane, SIDE, SIDE)
            .filter(|samples| loudest < samples.len())
            .map(|samples| samples.point(loudest) * 1e3);
        let place =
            place.map_or(String::new(), |at| format!(" at ({:.1}, {:.1}, {:.1}) mm", at.x, at.y, at.z));
        Ok(format!("peak {} RMS{place}", pascals(drawn.map.peak.into())))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A drive of two elements, silent for 0.
    fn drive(level: f64) -> Drive {
        Drive { amplitudes: vec![level; 2], phases: vec![0.0; 2] }
    }

    /// The changes that looks at levels and frames find, `apart` ms from each other.
    fn changes(apart: u64, looks: impl IntoIterator<Item = (f64, u64)>) -> Vec<Change> {
        let start = Instant::now();
        let mut steadiness = Steadiness::new(STEADY, start);
        let change = |(index, (level, frames)): (u64, (f64, u64))| {
            steadiness.look(&drive(level), frames, start + Duration::from_millis(apart * index))
        };
        let all: Vec<_> = (0..).zip(looks).map(change).collect();
        all.into_iter().filter(|change| *change != Change::None).collect()
    }

    /// So many looks at one drive.
    fn hold(level: f64, frames: u64, looks: usize) -> Vec<(f64, u64)> {
        vec![(level, frames); looks]
    }

    #[test]
    fn steady_drives_are_found_once() {
        // Frames are counted before they sound, and may be sent again.
        let looks = [hold(0.0, 0, 9), hold(1.0, 1, 99), hold(1.0, 2, 1), hold(0.5, 2, 99), hold(0.5, 3, 99)];
        assert_eq!(changes(2, looks.concat()), [Change::Steady; 2]);
        let silence = [hold(1.0, 1, 20), hold(0.0, 1, 20), hold(1.0, 1, 20)];
        assert_eq!(changes(2, silence.concat()), [Change::Steady; 2]);
    }

    #[test]
    fn a_drive_needs_time_and_looks_to_be_steady() {
        assert_eq!(changes(2, hold(1.0, 1, 5)), []);
        assert_eq!(changes(2, hold(1.0, 1, 6)), [Change::Steady]);
        assert_eq!(changes(50, hold(1.0, 1, 3)), []);
        assert_eq!(changes(2, hold(0.0, 1, 99)), [], "silence is not read");
    }

    #[test]
    fn a_part_of_a_ramp_is_withdrawn() {
        let looks = [hold(0.2, 1, 9), hold(0.7, 1, 2), hold(1.0, 1, 99)];
        assert_eq!(changes(2, looks.concat()), [Change::Steady, Change::Withdrawn, Change::Steady]);
    }

    #[test]
    fn a_motion_within_the_board_is_not_read() {
        let slow = [hold(0.5, 9, 500), hold(1.0, 9, 500), hold(0.5, 9, 500)].concat();
        assert_eq!(changes(2, slow.clone()), [Change::Steady, Change::Moving { withdraws: true }]);
        let then = [slow, hold(0.7, 10, 99)].concat();
        let moving = Change::Moving { withdraws: true };
        assert_eq!(changes(2, then), [Change::Steady, moving, Change::Steady]);
        let fast = (0..999).map(|look| (0.5 + f64::from(look % 2) / 4.0, 9));
        assert_eq!(changes(2, fast), [Change::Moving { withdraws: false }]);
    }

    #[test]
    fn a_motion_keeps_the_readings_of_the_drive_before_it() {
        let motion = (0..99).map(|look| (0.5 + f64::from(look % 2) / 4.0, 9));
        let looks: Vec<_> = hold(1.0, 1, 99).into_iter().chain(motion).collect();
        assert_eq!(changes(2, looks), [Change::Steady, Change::Moving { withdraws: false }]);
    }

    #[test]
    fn drives_in_turn_by_frames_are_not_read() {
        let looks = (0..600).map(|look| (0.5 + f64::from(look % 2) / 4.0, look as u64));
        assert_eq!(changes(2, looks), [Change::Moving { withdraws: false }]);
    }
}
