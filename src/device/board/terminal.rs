//! Virtual boards on pseudo-terminals, each on a thread of its own, in real time.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};

use web_time::{Duration, Instant};

use crate::device::board::faults::{Damage, Faults};
use crate::device::board::logic::{BAUD_TOLERANCE, Heeded, Native, Playing, Shown};
use crate::device::board::pty::Pty;
use crate::device::board::rtl::Rtl;
use crate::device::declaration::BootLoader;
use crate::device::native::model::Model;
use crate::device::pace::BITS;
use crate::device::profile::Profile;
use crate::device::stock::Twin;
use crate::device::task::locked;

/// Polling interval of a board's line.
const TICK: Duration = Duration::from_micros(500);

/// The configuration of a virtual board.
#[derive(Clone, Debug)]
pub struct Setup {
    pub profile: Profile,
    /// Instead of the profile's.
    pub baud: Option<u32>,
    pub faults: Faults,
    /// Phase bits of the native device.
    pub phase_bits: u8,
    /// mHz, of the native device.
    pub carrier_millihertz: u32,
    /// Of an Arduino, which the opening of its port resets; without, it has the capacitor that prevents this.
    pub boot_loader: Option<BootLoader>,
    /// The Verilated gateware, built with these phase bits, in place of the model.
    pub program: Option<PathBuf>,
}

impl Setup {
    pub fn new(profile: Profile) -> Self {
        Self {
            profile,
            baud: None,
            faults: Faults::default(),
            phase_bits: 7,
            carrier_millihertz: 40_000_000,
            boot_loader: Some(BootLoader::Factory),
            program: None,
        }
    }
}

/// A board's observations so far.
#[derive(Clone, Debug, Default)]
pub struct Report {
    pub bytes: u64,
    /// Frames that were shown.
    pub frames: u64,
    /// Invalid bytes, lists or packets.
    pub spoiled: u64,
    /// Bytes received at a wrong bit rate.
    pub wrong_baud: u64,
    /// The current output.
    pub playing: Option<Playing>,
    /// Events in chronological order.
    pub events: Vec<String>,
}

/// External actions on a running virtual board.
#[derive(Debug, Default)]
struct Hand {
    stop: AtomicBool,
    unplugged: AtomicBool,
    stalled: AtomicBool,
    pressed: AtomicBool,
}

/// A running board, ended by dropping it.
#[derive(Debug)]
pub struct Board {
    path: PathBuf,
    hand: Arc<Hand>,
    report: Arc<Mutex<Report>>,
    thread: Option<JoinHandle<()>>,
}

/// Prefix of the links to virtual boards in the folder for temporary files.
const LINK: &str = "sonoglyph-";

/// The virtual boards running on this machine: sorted ports and profiles.
pub fn running() -> Vec<(PathBuf, Profile)> {
    let entries = std::fs::read_dir(std::env::temp_dir()).into_iter().flatten().flatten();
    let board = |path: PathBuf| {
        let (profile, process) = parse_link(path.file_name()?.to_str()?)?;
        // A killed board leaves its link, and its terminal may have been reused by another program.
        let runs = path.exists() && is_running(process);
        runs.then_some((path, profile))
    };
    let mut boards: Vec<_> = entries.filter_map(|entry| board(entry.path())).collect();
    boards.sort_by(|(one, _), (other, _)| one.cmp(other));
    boards
}

/// The board of a link's name, and the process that it runs in.
fn parse_link(name: &str) -> Option<(Profile, u32)> {
    let (rest, count) = name.strip_prefix(LINK)?.rsplit_once('-')?;
    let (profile, process) = rest.rsplit_once('-')?;
    count.parse::<u64>().ok()?;
    Some((Profile::of_name(profile)?, process.parse().ok()?))
}

/// Whether a process runs. On systems that do not list processes the link is trusted.
fn is_running(process: u32) -> bool {
    let processes = Path::new("/proc");
    !processes.join("self").exists() || processes.join(process.to_string()).exists()
}

/// Called for every shown frame, immediately.
pub type Watch = Box<dyn FnMut(&Shown) + Send>;

impl Board {
    /// # Errors
    /// No pseudo-terminal available.
    pub fn start(setup: Setup, watch: Watch) -> io::Result<Self> {
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        let name = format!("{LINK}{}-{}-{count}", setup.profile.name(), std::process::id());
        let path = std::env::temp_dir().join(name);
        let hand = Arc::new(Hand::default());
        let report = Arc::new(Mutex::new(Report::default()));
        let line = Line::new(&path, setup, watch, Arc::clone(&hand), Arc::clone(&report))?;
        locked(&report).playing = Some(line.playing());
        let thread = thread::Builder::new().name("board".to_owned()).spawn(|| line.run())?;
        Ok(Self { path, hand, report, thread: Some(thread) })
    }

    /// The port to open. It stays the same when the board is unplugged and comes back.
    pub fn path(&self) -> &Path {
        &self.path
    }

    pub fn report(&self) -> Report {
        locked(&self.report).clone()
    }

    pub fn unplug(&self, unplugged: bool) {
        self.hand.unplugged.store(unplugged, Ordering::Relaxed);
    }

    /// The board accepts nothing while stalled.
    pub fn stall(&self, stalled: bool) {
        self.hand.stalled.store(stalled, Ordering::Relaxed);
    }

    /// The emergency stop of a native board.
    pub fn press(&self, pressed: bool) {
        self.hand.pressed.store(pressed, Ordering::Relaxed);
    }
}

impl Drop for Board {
    fn drop(&mut self) {
        self.hand.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // A panic of the board has already been reported.
            let _ = thread.join();
        }
    }
}

#[derive(Debug)]
enum Logic {
    Stock(Twin),
    Native(Box<Native>),
    Rtl(Box<Rtl>),
}

/// The board's thread.
struct Line {
    path: PathBuf,
    setup: Setup,
    pty: Option<Pty>,
    logic: Logic,
    damage: Damage,
    /// Arrival time of the last accepted byte.
    taken_at: Instant,
    /// No byte was waiting then.
    idle: bool,
    watch: Watch,
    hand: Arc<Hand>,
    report: Arc<Mutex<Report>>,
}

impl Line {
    fn new(
        path: &Path,
        setup: Setup,
        watch: Watch,
        hand: Arc<Hand>,
        report: Arc<Mutex<Report>>,
    ) -> io::Result<Self> {
        const SEED: u64 = 0x5EED;
        let baud = setup.baud.unwrap_or(setup.profile.baud());
        let pty = Pty::open(path, baud)?;
        let line = Self {
            path: path.to_owned(),
            logic: switched_on(&setup)?,
            damage: Damage::new(setup.faults, SEED),
            pty: Some(pty),
            taken_at: Instant::now(),
            idle: true,
            setup,
            watch,
            hand,
            report,
        };
        line.greet();
        Ok(line)
    }

    /// Garbage of a line plugged in during traffic.
    fn greet(&self) {
        if let (true, Some(pty)) = (self.damage.faults.garbage, &self.pty) {
            pty.write(&[0x55, 0x00, 0x81, 0xFF, 0x00, 0x13, 0x37]);
        }
    }

    fn run(mut self) {
        let set = |flag: &AtomicBool| flag.load(Ordering::Relaxed);
        while !set(&self.hand.stop) {
            let plugged = !set(&self.hand.unplugged);
            if plugged != self.pty.is_some() {
                self.plug(plugged);
            }
            self.pty.iter().for_each(Pty::lift_claim);
            if matches!(self.logic, Logic::Rtl(_)) {
                if let Err(error) = self.simulate() {
                    locked(&self.report).events.push(format!("the simulated device ended: {error}"));
                    return;
                }
            } else {
                self.live();
            }
            locked(&self.report).playing = Some(self.playing());
        }
    }

    /// One look at the line, in real time.
    fn live(&mut self) {
        self.wait();
        let now = Instant::now();
        let stalled = self.hand.stalled.load(Ordering::Relaxed);
        let was_opened = self.pty.as_ref().is_some_and(Pty::was_opened);
        match &mut self.logic {
            Logic::Stock(twin) => {
                if let (true, Some(loader)) = (was_opened, self.setup.boot_loader) {
                    twin.reset(loader, now);
                }
                twin.pass(self.taken_at.min(now));
            }
            Logic::Native(native) => {
                native.press(self.hand.pressed.load(Ordering::Relaxed));
                native.run_until(self.taken_at.min(now));
            }
            // It has a line of its own.
            Logic::Rtl(_) => {}
        }
        if stalled {
            self.taken_at = now;
        } else {
            self.take(now);
        }
        if let Logic::Native(native) = &mut self.logic {
            native.run_until(self.taken_at);
        }
    }

    /// A slice of the simulated device's own time.
    fn simulate(&mut self) -> io::Result<()> {
        const SLICE: u32 = 40;
        const SLICE_TIME: Duration = Duration::from_millis(1);
        let begun = Instant::now();
        let baud = self.pty.as_ref().map_or(0, Pty::baud).max(1);
        let due = SLICE_TIME.as_secs_f64() * f64::from(baud) / BITS;
        let mut bytes = vec![0; due as usize];
        let reads = self.pty.as_ref().filter(|_| !self.hand.stalled.load(Ordering::Relaxed));
        let read = reads.map_or(0, |pty| pty.read(&mut bytes));
        let mut arrived = Vec::new();
        bytes[..read].iter().for_each(|&byte| self.damage.pass(byte, &mut arrived));
        let mut heeded = Heeded::default();
        if let Logic::Rtl(rtl) = &mut self.logic {
            rtl.press(self.hand.pressed.load(Ordering::Relaxed))?;
            rtl.run(&arrived, baud, SLICE, &mut heeded)?;
        }
        self.note(read, false, &heeded);
        // A fast machine waits for the time that it simulates.
        thread::sleep(SLICE_TIME.saturating_sub(begun.elapsed()));
        Ok(())
    }

    fn playing(&self) -> Playing {
        match &self.logic {
            Logic::Stock(twin) => Playing::Levels(twin.shown()),
            Logic::Native(native) => native.playing(),
            Logic::Rtl(rtl) => rtl.playing(),
        }
    }

    /// A replugged board has been switched off in between.
    fn plug(&mut self, plugged: bool) {
        self.pty = None;
        if plugged {
            let baud = self.setup.baud.unwrap_or(self.setup.profile.baud());
            self.pty = Pty::open(&self.path, baud).ok();
            if let Ok(logic) = switched_on(&self.setup) {
                self.logic = logic;
            }
            self.taken_at = Instant::now();
            self.greet();
        }
        locked(&self.report).events.push(if plugged { "plugged in" } else { "unplugged" }.to_owned());
    }

    fn own_baud(&self) -> f64 {
        match (&self.logic, self.setup.baud) {
            (Logic::Native(native), None) => native.baud(),
            (_, baud) => f64::from(baud.unwrap_or(self.setup.profile.baud())),
        }
    }

    /// Until a byte arrives if the line is idle, otherwise until more have had time to arrive.
    fn wait(&mut self) {
        match &self.pty {
            Some(pty) if self.idle && !self.hand.stalled.load(Ordering::Relaxed) => {
                pty.wait(TICK);
                self.taken_at = self.taken_at.max(Instant::now() - TICK / 10);
            }
            _ => thread::sleep(TICK),
        }
    }

    /// Accepts all bytes carried by the line until `now`.
    fn take(&mut self, now: Instant) {
        let Some(pty) = &self.pty else { return };
        let theirs = f64::from(pty.baud().max(1));
        let per_byte = Duration::from_secs_f64(BITS / theirs);
        let due = now.saturating_duration_since(self.taken_at).as_nanos() / per_byte.as_nanos().max(1);
        let mut bytes = [0; 4096];
        let due = usize::try_from(due).unwrap_or(bytes.len()).min(bytes.len());
        let read = pty.read(&mut bytes[..due]);
        let unread = matches!(theirs / self.own_baud() - 1.0, off if off.abs() > BAUD_TOLERANCE);
        let mut heeded = Heeded::default();
        let mut arrived = Vec::new();
        for &byte in &bytes[..read] {
            self.taken_at += per_byte;
            arrived.clear();
            if unread {
                self.damage.garble(&mut arrived);
            } else {
                self.damage.pass(byte, &mut arrived);
            }
            for &byte in &arrived {
                match &mut self.logic {
                    Logic::Stock(twin) => heeded.hear(twin, byte, self.taken_at),
                    Logic::Native(native) => native.hear(byte, unread, self.taken_at, &mut heeded),
                    // It has a line of its own.
                    Logic::Rtl(_) => {}
                }
            }
        }
        self.idle = read < due;
        if self.idle {
            self.taken_at = now;
        }
        self.note(read, unread, &heeded);
    }

    fn note(&mut self, read: usize, unread: bool, heeded: &Heeded) {
        if let (false, Some(pty)) = (unread || heeded.answer.is_empty(), &self.pty) {
            pty.write(&heeded.answer);
        }
        let mut report = locked(&self.report);
        report.bytes += read as u64;
        report.wrong_baud += if unread { read as u64 } else { 0 };
        report.frames += heeded.shown.len() as u64;
        report.spoiled += heeded.spoiled;
        drop(report);
        heeded.shown.iter().for_each(|shown| (self.watch)(shown));
    }
}

fn switched_on(setup: &Setup) -> io::Result<Logic> {
    Ok(match (setup.profile, &setup.program) {
        (Profile::Native, Some(program)) => Logic::Rtl(Box::new(Rtl::start(program, setup.phase_bits)?)),
        (profile, _) if profile.answers() => {
            let model = Model::new(setup.phase_bits).with_carrier(setup.carrier_millihertz);
            Logic::Native(Box::new(Native::new(&model, profile.devices(), Instant::now())))
        }
        (profile, _) => Logic::Stock(Twin::new(profile)),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const PATIENCE: Duration = Duration::from_secs(20);

    #[test]
    fn links_of_boards_are_told_from_other_files() {
        assert_eq!(parse_link("sonoglyph-sonicsurface-2-4711-0"), Some((Profile::SonicSurface2, 4711)));
        assert_eq!(parse_link("sonoglyph-native-1-12"), Some((Profile::Native, 1)));
        for other in
            ["sonoglyph-native-1", "sonoglyph-abacus-1-0", "sonoglyph-", "native-1-0", "sonoglyph-native-x-0"]
        {
            assert_eq!(parse_link(other), None, "{other}");
        }
        assert!(is_running(std::process::id()));
    }

    #[test]
    fn the_end_of_a_simulator_is_reported() {
        let setup = Setup { program: Some("/bin/true".into()), ..Setup::new(Profile::Native) };
        let board = Board::start(setup, Box::new(|_| {})).unwrap();
        let until = Instant::now() + PATIENCE;
        while board.report().events.is_empty() {
            assert!(Instant::now() < until);
            thread::sleep(TICK);
        }
        assert!(board.report().events[0].starts_with("the simulated device ended"));
    }
}
