//! `sonoglyph send`: solves a scene, or takes the drives of a file, and plays them on a board.

use std::ops::Range;
use std::path::PathBuf;
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
use crate::device::link::{Event, Settings};
use crate::device::profile::Profile;
use crate::rounding;
use crate::scene::{Method, Scene, motion};
use crate::studio::felt::Offer;
use crate::studio::output::{Files, mention, note, say, warn};
use crate::studio::performance::Performance;
use crate::studio::player::{self, Player};

/// Default playing time of a scene at rest.
const AT_REST: Duration = Duration::from_secs(1);
/// Limit of the wait for a lost board, unless it plays endlessly.
const LOST_TIMEOUT: Duration = Duration::from_secs(10);
/// Limit of the wait for the first frame; then the time of --seconds starts anyway.
const START_TIMEOUT: Duration = Duration::from_millis(300);
/// Interval of status lines.
const REPORT: Duration = Duration::from_secs(1);

#[derive(Debug, Args)]
pub struct SendArgs {
    /// Scene file
    scene: PathBuf,
    /// Serial port of the board; `sonoglyph ports` lists them
    #[arg(long)]
    port: PathBuf,
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
    /// CSV with the columns element, offset (degrees), gain (0 to 1), off (0 or 1), and a row per element
    #[arg(long, value_name = "FILE.csv")]
    calibration: Option<PathBuf>,
    /// Play a single board of the scene, counted from 1, for boards with their own ports
    #[arg(long, value_name = "NUMBER")]
    board: Option<usize>,
}

pub fn run(args: &SendArgs) -> anyhow::Result<()> {
    let source = Source { method: args.method, drive: args.drive.drive.as_deref() };
    let mut scene = read_scene(&args.scene, source, &mut Files::new())?;
    let name = args.scene.display().to_string();
    let part = part(&scene, args.board)?;
    let played = match args.board {
        Some(_) => Scene { boards: Vec::new(), ..scene.clone() },
        None => scene.clone(),
    };
    args.profile.drives(&played).with_context(|| name.clone())?;
    if let Err(error) = envelope::playable(args.profile, &scene.modulation) {
        bail!("{name}: {error}");
    }
    let calibration = calibration(args.calibration.as_deref(), args.profile)?;
    let interrupted = interrupt::watch()?;
    let settings = Settings { port: args.port.clone(), profile: args.profile, baud: args.baud };
    note(&args.profile.bandwidth(settings.baud()));
    if let Some(offer) = Offer::new(&scene, true, args.profile, settings.baud()) {
        note(&offer.to_string());
    }
    let mut player = Player::open(settings.clone(), calibration, Box::new(|| {}))?;
    player.part = Some(part);
    let found = player::ready(&player.link, || interrupted.is_set(), note)?;
    let Some(found) = found else { return Ok(()) };
    follow_carrier(&mut scene, found);
    args.profile.steady(&mut scene, settings.baud()).iter().for_each(|text| note(text));
    let cycle = motion::cycle(&scene).map(|cycle| Duration::from_secs_f64(1.0 / cycle.rate));
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
    let notice = player.play(&played, performance).map_err(|error| anyhow::anyhow!(error))?;
    notice.iter().for_each(|notice| warn(notice));

    let link = player.link;
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
        match link.event_within(Duration::from_millis(5)) {
            Some(Event::Lost(why)) => {
                lost.get_or_insert_with(Instant::now);
                warn(&format!("{why}; looking for it"));
            }
            Some(Event::Ready(_)) => note("the board is back"),
            Some(Event::Notice(text)) => note(&text),
            None => {}
        }
        let health = link.health();
        if health.in_place {
            begun.get_or_insert_with(Instant::now);
            lost = None;
        }
        // --seconds limits the time even if the board never plays.
        if args.seconds.is_some() && shown.elapsed() >= START_TIMEOUT {
            begun.get_or_insert(shown + START_TIMEOUT);
        }
        if Instant::now() >= next_report {
            next_report += REPORT;
            mention(&line(&health));
        }
    }
    let last = link.health();
    let health = link.close();
    say!("{}", line(&last))?;
    match health.state {
        State::Lost(why) => bail!("{why}: the board was lost, in an unknown state"),
        State::Connecting | State::Ready if !health.silenced => {
            bail!("{}: the board could not be silenced: its port takes no bytes", args.port.display())
        }
        State::Connecting | State::Ready if !last.in_place && !interrupted.is_set() => {
            bail!(
                "{}: the board did not play{}",
                args.port.display(),
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

/// The played elements: of all boards, or of one, counted from 1.
fn part(scene: &Scene, board: Option<usize>) -> anyhow::Result<Range<usize>> {
    let (each, boards) = (scene.array.elements(), scene.boards.len().max(1));
    match board {
        None => Ok(0..scene.elements()),
        Some(number) if (1..=boards).contains(&number) => Ok(each * (number - 1)..each * number),
        Some(number) => bail!("--board {number}: the scene has {boards}, counted from 1"),
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
            0.5 / spread.median.as_secs_f64(),
            milliseconds(spread.jitter, 3)
        );
    }
    line
}
