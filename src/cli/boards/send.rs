//! `sonoglyph send`: solves a scene, or takes the drives of a file, and plays them on a board.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::time::{Duration, Instant};

use anyhow::{Context, bail};
use clap::Args;

use crate::cli::arguments::{DriveArgs, seconds};
use crate::cli::boards::arguments::{calibration, parse_profile};
use crate::cli::scene::{Source, read_scene};
use crate::cli::{interrupt, names, progress};
use crate::device::envelope;
use crate::device::health::{Found, Health, State};
use crate::device::levels;
use crate::device::link::{Event, Link, Settings};
use crate::device::profile::Profile;
use crate::device::wiring::{Share, Wiring};
use crate::rounding;
use crate::scene::{Method, Scene, motion};
use crate::studio::felt::Offer;
use crate::studio::output::{Files, mention, note, say, warn};
use crate::studio::performance::Performance;
use crate::studio::player::{self, Player};

/// Default playing time of a scene at rest.
const AT_REST: Duration = Duration::from_secs(1);
/// Limit of the wait for a lost board, unless it plays endlessly.
const LOST_TIMEOUT: Duration = Duration::from_secs(15);
/// Limit of the wait for the first frame; then the time of --seconds starts anyway.
const START_TIMEOUT: Duration = Duration::from_millis(300);
/// Interval of status lines.
const REPORT: Duration = Duration::from_secs(1);

#[derive(Debug, Args)]
pub struct SendArgs {
    /// Scene file
    scene: PathBuf,
    /// Serial port of the board; `sonoglyph ports` lists them. Several play the boards of the scene, in its order
    #[arg(long = "port", value_name = "PORT", required = true)]
    ports: Vec<PathBuf>,
    /// Kind of board; `sonoglyph ports` lists them
    #[arg(long, value_parser = parse_profile)]
    profile: Profile,
    /// Bits per second, instead of the board's default
    #[arg(long, value_parser = clap::value_parser!(u32).range(1200..=12_000_000))]
    baud: Option<u32>,
    /// Solver method, instead of the scene's
    #[arg(long, value_parser = names::method(), conflicts_with = "drive")]
    method: Option<Method>,
    #[command(flatten)]
    drive: DriveArgs,
    /// Play until Ctrl-C
    #[arg(long = "loop")]
    repeat: bool,
    /// Playing time (s)
    #[arg(long, value_name = "S", value_parser = seconds(1e9))]
    seconds: Option<f64>,
    /// Corrections: CSV with the columns element, offset (degrees), gain (0 to 1), off (0 or 1), and a row per element;
    /// or the .pat of an OpenMPD board. One for all elements, or one for each board of the scene
    #[arg(long = "calibration", value_name = "FILE")]
    calibrations: Vec<PathBuf>,
    /// Play a single board of the scene, counted from 1, for boards with their own ports
    #[arg(long, value_name = "NUMBER")]
    board: Option<usize>,
}

impl SendArgs {
    /// Plays a drive without corrections, for a time or until Ctrl-C.
    pub fn of_drive(
        (scene, drive): (PathBuf, PathBuf),
        port: PathBuf,
        profile: Profile,
        baud: Option<u32>,
        seconds: Option<f64>,
    ) -> Self {
        Self {
            scene,
            ports: vec![port],
            profile,
            baud,
            method: None,
            drive: DriveArgs { drive: Some(drive) },
            repeat: seconds.is_none(),
            seconds,
            calibrations: Vec::new(),
            board: None,
        }
    }
}

pub fn run(args: &SendArgs) -> anyhow::Result<()> {
    let source = Source { method: args.method, drive: args.drive.drive.as_deref() };
    let mut scene = read_scene(&args.scene, source, &mut Files::new())?;
    let name = args.scene.display().to_string();
    let shares = shares(args, &scene)?;
    for share in &shares {
        Wiring::of(args.profile, &scene, *share).with_context(|| name.clone())?;
    }
    if let Err(error) = envelope::plays(args.profile, &scene) {
        bail!("{name}: {error}");
    }
    let calibration = calibration(&args.calibrations, &scene, args.board)?;
    let interrupted = interrupt::watch()?;
    let baud = args.baud.unwrap_or(args.profile.baud());
    note(&args.profile.bandwidth(baud));
    if let Some(offer) = Offer::new(&scene, true, args.profile, baud) {
        note(&offer.to_string());
    }
    let mut players = Vec::new();
    for (port, share) in args.ports.iter().zip(shares) {
        let settings = Settings { port: port.clone(), profile: args.profile, baud: args.baud };
        let mut player = Player::open(settings, calibration.clone(), Box::new(|| {}))?;
        player.share = share;
        players.push(player);
    }
    for player in &players {
        let found = player::ready(&player.link, || interrupted.is_set(), note)?;
        let Some(found) = found else { return Ok(()) };
        follow_carrier(&mut scene, found);
    }
    args.profile.steady(&mut scene, baud).iter().for_each(|text| note(text));
    let cycle = motion::cycle(&scene).map(|cycle| Duration::from_secs_f64(1.0 / cycle.rate));
    let played = scene.clone();
    // On its own thread, so that an interrupt need not wait for the solver.
    let (sender, solved) = sync_channel(1);
    let solve = move || sender.send(Performance::of(&scene, &name, progress::begin));
    std::thread::Builder::new().name("solve".to_owned()).spawn(solve)?;
    let performance = loop {
        match solved.recv_timeout(Duration::from_millis(20)) {
            Ok(performance) => break performance?,
            Err(RecvTimeoutError::Disconnected) => bail!("the solver ended without a solution"),
            Err(RecvTimeoutError::Timeout) if interrupted.is_set() => return Ok(()),
            Err(RecvTimeoutError::Timeout) => {}
        }
    };
    for (index, player) in players.iter_mut().enumerate() {
        let notices = player.play(&played, performance.clone()).map_err(|error| anyhow::anyhow!(error))?;
        notices.iter().filter(|_| index == 0).for_each(|notice| warn(notice));
    }
    let links: Vec<Link> = players.into_iter().map(|player| player.link).collect();
    let lasts = match (args.seconds, args.repeat) {
        (Some(seconds), _) => Some(Duration::from_secs_f64(seconds)),
        (None, true) => None,
        (None, false) => Some(cycle.unwrap_or(AT_REST)),
    };
    let mut begun = None;
    let shown = Instant::now();
    let mut next_report = Instant::now() + REPORT;
    let mut lost: Option<Instant> = None;
    let given_up =
        |lost: Option<Instant>| lost.is_some_and(|lost| lasts.is_some() && lost.elapsed() > LOST_TIMEOUT);
    while !interrupted.is_set() && !over(begun, lasts) && !given_up(lost) {
        for link in &links {
            match link.event_within(Duration::from_millis(5)) {
                Some(Event::Lost(why)) => {
                    lost.get_or_insert_with(Instant::now);
                    warn(&format!("{why}; looking for it"));
                }
                Some(Event::Ready(_)) => note("the board is back"),
                Some(Event::Notice(text)) => note(&text),
                None => {}
            }
        }
        let healths: Vec<_> = links.iter().map(Link::health).collect();
        if healths.iter().all(|health| health.in_place) {
            begun.get_or_insert_with(Instant::now);
            lost = None;
        }
        // --seconds limits the time even if the board never plays.
        if args.seconds.is_some() && shown.elapsed() >= START_TIMEOUT {
            begun.get_or_insert(shown + START_TIMEOUT);
        }
        if Instant::now() >= next_report {
            next_report += REPORT;
            healths.iter().for_each(|health| mention(&line(health)));
        }
    }
    let last: Vec<_> = links.iter().map(Link::health).collect();
    let closed: Vec<_> = links.into_iter().map(Link::close).collect();
    last.iter().try_for_each(|health| say!("{}", line(health)))?;
    for ((port, last), health) in args.ports.iter().zip(&last).zip(&closed) {
        verdict(port, last, health, interrupted.is_set())?;
    }
    Ok(())
}

/// The end of a board's playing: its state before and after its link was closed.
fn verdict(port: &Path, last: &Health, health: &Health, was_interrupted: bool) -> anyhow::Result<()> {
    match &health.state {
        State::Lost(why) => bail!("{why}: the board was lost, in an unknown state"),
        State::Connecting | State::Ready if !health.silenced => {
            bail!("{}: the board could not be silenced: its port takes no bytes", port.display())
        }
        State::Connecting | State::Ready if !last.in_place && !was_interrupted => {
            bail!(
                "{}: the board did not play{}",
                port.display(),
                match last.stopped {
                    true => ": its emergency stop was pressed",
                    false => " in this time",
                }
            )
        }
        State::Connecting | State::Ready => Ok(()),
    }
}

/// Whether the playing time is over.
fn over(begun: Option<Instant>, lasts: Option<Duration>) -> bool {
    begun.zip(lasts).is_some_and(|(begun, lasts)| begun.elapsed() >= lasts)
}

/// The part of each port: all boards, one of several, or the only one, counted from 1.
fn shares(args: &SendArgs, scene: &Scene) -> anyhow::Result<Vec<Share>> {
    let (ports, boards) = (args.ports.len(), scene.boards.len().max(1));
    match args.board {
        None => Ok((0..ports).map(|index| Share { index, of: ports }).collect()),
        Some(number) if (1..=boards).contains(&number) && ports == 1 => {
            Ok(vec![Share { index: number - 1, of: boards }])
        }
        Some(number) if ports == 1 => bail!("--board {number}: the scene has {boards}, counted from 1"),
        Some(number) => bail!("--board {number} plays one board: give one --port, not {ports}"),
    }
}

/// Gives the scene the board's carrier frequency.
fn follow_carrier(scene: &mut Scene, found: Found) {
    if let Some(notice) = levels::carrier_notice(found.carrier, scene.array.frequency) {
        warn(&notice);
        scene.array.frequency = found.carrier;
    }
}

/// The status line of a link.
fn line(health: &Health) -> String {
    let milliseconds =
        |duration: Duration, decimals| rounding::milliseconds(duration.as_secs_f64(), decimals);
    let mut line = format!(
        "{} frames, {:.1} frames/s on the line, {:.1} kB/s, {} retransmissions",
        health.frames,
        health.frames_per_second,
        health.bytes_per_second / 1e3,
        health.refused
    );
    if let Some(rates) = health.rates {
        line += &format!("; {rates}");
    }
    if let Some(spread) = health.round_trip {
        line += &format!(
            ", answers after {} (jitter {})",
            milliseconds(spread.median, 2),
            milliseconds(spread.jitter, 2)
        );
    }
    if let Some(spread) = health.swaps {
        line += &format!(
            ", modulated at {:.2} Hz (jitter {})",
            0.5 / spread.mean.as_secs_f64(),
            milliseconds(spread.jitter, 3)
        );
    }
    line
}
