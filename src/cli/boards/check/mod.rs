//! `sonoglyph check`: brings up a board step by step, and reports the findings.

mod answers;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::{Context, bail};
use clap::Args;

use crate::cli::boards::arguments::{calibration, parse_profile};
use crate::cli::boards::check::answers::{Answer, Answers};
use crate::cli::interrupt::{self, Interrupted};
use crate::cli::scene::{Source, read_scene};
use crate::device::calibration::Calibration;
use crate::device::health::{Found, Health, State};
use crate::device::levels::Levels;
use crate::device::link::{Content, Event, Link, Settings};
use crate::device::profile::Profile;
use crate::device::task::finish;
use crate::device::wiring::{Share, Wiring};
use crate::scene::{Envelope, Modulation, Scene};
use crate::solver;
use crate::studio::bring_up::{HEIGHT, Report, Verdict, board_scene, focus_scene, named, survey_line};
use crate::studio::output::{self, Files, note, say, warn};
use crate::studio::player;

/// Duration of an element without questions.
const ELEMENT: Duration = Duration::from_millis(40);
/// Duration of the focus.
const FOCUS: Duration = Duration::from_secs(2);
/// Limit of the wait for content to play, or for the emergency stop.
const TIMEOUT: Duration = Duration::from_secs(5);
/// Interval of polling.
const POLL: Duration = Duration::from_millis(5);

#[derive(Debug, Args)]
pub struct CheckArgs {
    /// Serial port of the board; `sonoglyph ports` lists them
    #[arg(long)]
    port: PathBuf,
    /// Kind of board; `sonoglyph ports` lists them
    #[arg(long, value_parser = parse_profile, default_value = "native")]
    profile: Profile,
    /// Bits per second, instead of the fastest rate without loss
    #[arg(long, value_parser = clap::value_parser!(u32).range(1200..=12_000_000))]
    baud: Option<u32>,
    /// Ask after each element whether it gives a signal; answers are read from standard input
    #[arg(long)]
    listen: bool,
    /// Scene with the tested array and its wiring [default: the board's own array]
    #[arg(long)]
    scene: Option<PathBuf>,
    /// Calibration: read if it exists, and written with the elements without a signal
    #[arg(long, value_name = "FILE.csv")]
    calibration: Option<PathBuf>,
    /// Also write the report
    #[arg(short, long, value_name = "REPORT.txt")]
    output: Option<PathBuf>,
}

pub fn run(args: &CheckArgs) -> anyhow::Result<()> {
    let mut files = Files::new();
    if let Some(path) = &args.calibration {
        files.writes(path)?;
    }
    if let Some(path) = &args.output {
        files.writes(path)?;
    }
    let (scene, wiring) = match &args.scene {
        Some(path) => {
            let scene = read_scene(path, Source::default(), &mut files)?;
            let wiring = Wiring::of(args.profile, &scene, Share::default());
            (scene, wiring.with_context(|| path.display().to_string())?)
        }
        None => (board_scene(args.profile), Wiring::own(args.profile)),
    };
    if let Some(path) =
        args.calibration.as_ref().filter(|path| path.extension().is_some_and(|it| it == "pat"))
    {
        bail!(
            "{}: the calibration is written as CSV; a .pat is named by the scene as `array.elements`",
            path.display()
        );
    }
    let known: Vec<_> = args.calibration.iter().filter(|path| path.exists()).cloned().collect();
    let calibration = match calibration(&known, &scene, None)? {
        given if given.elements() > 0 => given,
        _ => Calibration::of(&scene),
    };
    let mut check = Check {
        report: Report::default(),
        answers: Answers::new(args.listen),
        interrupted: interrupt::watch()?,
        profile: args.profile,
        scene,
        wiring,
        calibration,
    };
    let baud = check.line(args)?;
    check.board(args, baud)?;
    if let Some(path) = &args.calibration {
        output::write(path, check.calibration.to_csv(check.wiring.elements()).as_bytes())?;
        note(&format!("{}: {} elements are off", path.display(), check.calibration.off().len()));
    }
    if let Some(path) = &args.output {
        output::write(path, check.report.text(args.profile, &args.port.display().to_string()).as_bytes())?;
    }
    match check.report.failed() {
        0 => say!("{}", check.report.conclusion()),
        failed => bail!("{failed} of the steps failed"),
    }
}

struct Check {
    report: Report,
    answers: Answers,
    interrupted: Interrupted,
    profile: Profile,
    scene: Scene,
    wiring: Wiring,
    calibration: Calibration,
}

impl Check {
    fn note(&mut self, verdict: Verdict, what: impl Into<String>) -> anyhow::Result<()> {
        self.report.note(verdict, what);
        self.report.findings.last().map_or(Ok(()), |finding| say!("{finding}"))
    }

    /// Identifies the board and surveys its line; returns the bit rate of the next steps.
    fn line(&mut self, args: &CheckArgs) -> anyhow::Result<Option<u32>> {
        let mut said = Ok(());
        let fastest = finish(survey_line(&args.port, self.profile, &mut |verdict, what| {
            if said.is_ok() {
                said = self.note(verdict, what);
            }
        }))?;
        said?;
        Ok(args.baud.or(fastest))
    }

    /// The audible steps.
    fn board(&mut self, args: &CheckArgs, baud: Option<u32>) -> anyhow::Result<()> {
        let settings = Settings { port: args.port.clone(), profile: self.profile, baud };
        let link = Link::open(settings, Box::new(|| {}))?;
        let found = player::ready(&link, || self.interrupted.is_set(), warn)?;
        let Some(found) = found else { return Ok(()) };
        let baud = found.baud;
        match (self.profile.answers(), self.profile.echoes()) {
            (true, _) => self.note(Verdict::Passed, format!("the link is open at {baud} baud"))?,
            (false, true) => self.note(
                Verdict::Passed,
                format!("the board is there: it sends back commands at {baud} baud"),
            )?,
            (false, false) => self.note(
                self.of_sent(),
                format!("the port takes bytes at {baud} baud; whether a board reads them is unknown"),
            )?,
        }
        self.walk(&link)?;
        self.focus(&link, found)?;
        self.stop(&link)?;
        let health = link.close();
        self.leave(&health, &args.port)
    }

    /// The verdict on what was sent without an error. A person who listens judges boards that do not.
    fn of_sent(&self) -> Verdict {
        match (self.profile.answers(), self.answers.listen()) {
            (true, _) => Verdict::Passed,
            (false, true) => Verdict::Noted,
            (false, false) => Verdict::Unverified,
        }
    }

    /// Whether the content plays in time. Notices of the link go to standard error.
    fn plays(&self, link: &Link, content: Content) -> bool {
        link.show(content);
        let until = Instant::now() + TIMEOUT;
        while Instant::now() < until && !self.interrupted.is_set() {
            if let Some(Event::Notice(text) | Event::Lost(text)) = link.event_within(POLL) {
                warn(&text);
            }
            if link.health().in_place {
                return true;
            }
        }
        false
    }

    /// Plays one element at a time, in the array's numbering.
    fn walk(&mut self, link: &Link) -> anyhow::Result<()> {
        let wired: Vec<_> = self.wiring.wired().collect();
        if self.answers.listen() {
            say!(
                "One element plays at a time: hold a spare transducer with an oscilloscope over it. Enter: signal seen, n: no \
                 signal, r: repeat, b: back, q: skip the rest."
            )?;
        }
        let mut next = 0;
        let mut silent = Vec::new();
        while let Some(&element) = wired.get(next).filter(|_| !self.interrupted.is_set()) {
            if !self.plays(link, Content::Still(self.wiring.one(element))) {
                return self.note(Verdict::Failed, format!("element {element} was not played"));
            }
            if !self.answers.listen() {
                std::thread::sleep(ELEMENT);
                next += 1;
                continue;
            }
            let question = format!("{}? ", named(&self.scene, element));
            match self.answers.ask(&question, &self.interrupted)? {
                Answer::Yes => {
                    self.calibration.set_off(element, self.wiring.elements(), false);
                    silent.retain(|&other| other != element);
                    next += 1;
                }
                Answer::No => {
                    self.calibration.set_off(element, self.wiring.elements(), true);
                    silent.push(element);
                    next += 1;
                }
                Answer::Again => {}
                Answer::Back => next = next.saturating_sub(1),
                Answer::End => break,
            }
        }
        match (self.answers.listen(), silent.is_empty()) {
            (false, _) => self.note(
                self.of_sent(),
                format!("{} elements were sent one by one; --listen asks which give a signal", wired.len()),
            ),
            (true, true) if next < wired.len() => self.note(
                Verdict::Unverified,
                format!("{next} of {} elements gave a signal, and the rest were skipped", wired.len()),
            ),
            (true, true) => {
                self.note(Verdict::Passed, format!("{next} of {} elements gave a signal", wired.len()))
            }
            (true, false) => {
                let list: Vec<_> = silent.iter().map(ToString::to_string).collect();
                self.note(
                    Verdict::Failed,
                    format!("{} elements gave no signal: {}", silent.len(), list.join(", ")),
                )
            }
        }
    }

    fn focus(&mut self, link: &Link, found: Found) -> anyhow::Result<()> {
        let solution = solver::solve(&focus_scene(&self.scene, found.carrier))?;
        let levels = self.wiring.levels(&solution.drive, &self.calibration)?;
        link.modulate(Modulation { shape: Envelope::Sine, ..Modulation::default() });
        if !self.plays(link, Content::Still(levels)) {
            return self.note(Verdict::Failed, "the focus was not played");
        }
        let until = Instant::now() + FOCUS;
        let what = format!("focus {:.0} mm above the centre, modulated at 200 Hz", HEIGHT * 1e3);
        if self.answers.listen() {
            return match self
                .answers
                .ask(&format!("{what}: is it felt? (Enter: yes, n: no) "), &self.interrupted)?
            {
                Answer::No => self.note(Verdict::Failed, format!("{what}: not felt")),
                Answer::Yes | Answer::Again | Answer::Back => {
                    self.note(Verdict::Passed, format!("{what}: felt"))
                }
                Answer::End => self.note(Verdict::Unverified, format!("{what}: skipped")),
            };
        }
        while Instant::now() < until && !self.interrupted.is_set() {
            std::thread::sleep(POLL);
        }
        self.note(self.of_sent(), format!("{what}, sent for {} s", FOCUS.as_secs()))
    }

    /// Tests the emergency stop: it must silence the board until new content.
    fn stop(&mut self, link: &Link) -> anyhow::Result<()> {
        if !self.profile.answers() {
            return self.note(Verdict::Noted, "emergency stop: this board cannot report one");
        }
        if !self.answers.listen() {
            return self.note(Verdict::Noted, "emergency stop: not tried; --listen asks you to press it");
        }
        say!("Press the emergency stop and release it, then Enter; q skips this step.")?;
        if self.answers.ask("emergency stop: ", &self.interrupted)? == Answer::End {
            return self.note(Verdict::Noted, "emergency stop: skipped");
        }
        let until = Instant::now() + TIMEOUT;
        while !link.health().stopped {
            if Instant::now() > until || self.interrupted.is_set() {
                return self.note(Verdict::Failed, "emergency stop: the board did not notice");
            }
            std::thread::sleep(POLL);
        }
        let one = self.wiring.wired().next().map(|element| self.wiring.one(element));
        if self.plays(link, Content::Still(one.unwrap_or_else(|| Levels::off(self.profile)))) {
            self.note(
                Verdict::Passed,
                "emergency stop: silent until the next send, and sounds again after it",
            )
        } else {
            self.note(Verdict::Failed, "emergency stop: the board stays silent; is it released?")
        }
    }

    fn leave(&mut self, health: &Health, port: &Path) -> anyhow::Result<()> {
        if self.interrupted.is_set() {
            self.note(Verdict::Noted, "interrupted: the remaining steps were not tried")?;
        }
        match &health.state {
            State::Lost(why) => self.note(Verdict::Failed, format!("{why}: the board was lost")),
            State::Connecting | State::Ready if !health.silenced => self.note(
                Verdict::Failed,
                format!("{}: the port takes no bytes, and the board may still sound", port.display()),
            ),
            State::Connecting | State::Ready if self.profile.answers() => self.note(
                Verdict::Passed,
                format!(
                    "the board is silent again; {} retransmissions at {} frames",
                    health.refused, health.frames
                ),
            ),
            State::Connecting | State::Ready => {
                self.note(self.of_sent(), format!("silence was sent after {} frames", health.frames))
            }
        }
    }
}
