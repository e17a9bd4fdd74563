//! Bring-up of a board, shared by command line and window: findings as text, the survey of its line, and the test
//! focus.

use std::fmt;
use std::path::Path;

use crate::device::link::survey::{Discovery, Trial, TrialOutcome, survey};
use crate::device::native::packet::{Info, Status};
use crate::device::profile::Profile;
use crate::scene::{Scene, Shape, Target};

/// Height of the test focus above the array's centre, m.
pub const HEIGHT: f64 = 0.1;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    Passed,
    Failed,
    /// A neutral fact, or a skipped step.
    Noted,
    /// Bytes were written, and nothing tells whether the board plays them.
    Unverified,
}

/// One finding.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    pub verdict: Verdict,
    pub what: String,
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let verdict = match self.verdict {
            Verdict::Passed => "passed",
            Verdict::Failed => "FAILED",
            Verdict::Noted => "   -  ",
            Verdict::Unverified => "   ?  ",
        };
        write!(f, "{verdict}  {}", self.what)
    }
}

/// Findings in the order of the steps.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Report {
    pub findings: Vec<Finding>,
}

impl Report {
    pub fn note(&mut self, verdict: Verdict, what: impl Into<String>) {
        self.findings.push(Finding { verdict, what: what.into() });
    }

    /// Steps that failed.
    pub fn failed(&self) -> usize {
        self.count(Verdict::Failed)
    }

    fn count(&self, verdict: Verdict) -> usize {
        self.findings.iter().filter(|finding| finding.verdict == verdict).count()
    }

    /// The outcome, as text.
    pub fn conclusion(&self) -> String {
        match (self.failed(), self.count(Verdict::Unverified)) {
            (0, 0) => "The board passed.".to_owned(),
            (0, unverified) => format!(
                "No step failed, but {unverified} could not be verified (?): only listening and feeling show what the \
                 board plays."
            ),
            (failed, _) => format!("{failed} of the steps failed."),
        }
    }

    /// A text to send to others.
    pub fn text(&self, profile: Profile, port: &str) -> String {
        let (version, system) = (env!("CARGO_PKG_VERSION"), std::env::consts::OS);
        let mut text =
            format!("Sonoglyph {version} on {system}: check of a {} board at {port}\n", profile.name());
        for finding in &self.findings {
            text += &format!("{finding}\n");
        }
        text
    }
}

/// Identifies the board at a port and surveys its line; returns the fastest error-free bit rate.
///
/// # Errors
/// A missing port, or a native board that does not answer.
pub async fn survey_line(
    port: &Path,
    profile: Profile,
    tell: &mut dyn FnMut(Verdict, String),
) -> anyhow::Result<Option<u32>> {
    if !profile.answers() {
        let name = profile.name();
        let what = match profile.echoes() {
            true => format!("{name} boards send back commands, but do not report what they play"),
            false => format!("{name} boards never answer: no program can verify that one is there"),
        };
        tell(Verdict::Noted, what);
        return Ok(None);
    }
    let fastest = survey(port, &mut |found| match found {
        Discovery::Board(info, status) => introduce(&info, &status, tell),
        Discovery::Rate(trial) => tell(verdict(&trial), in_words(&trial)),
    })
    .await?;
    match fastest {
        Some(baud) => tell(Verdict::Passed, format!("fastest bit rate without loss: {baud} (--baud {baud})")),
        None => tell(
            Verdict::Failed,
            "no bit rate carried every frame: look at cable, adapter and ground".to_owned(),
        ),
    }
    Ok(fastest)
}

fn introduce(info: &Info, status: &Status, tell: &mut dyn FnMut(Verdict, String)) {
    let carrier = f64::from(info.carrier_millihertz) / 1e3;
    tell(
        Verdict::Passed,
        format!(
            "a native board answers: protocol {}, gateware {}, {} phase bits, {} slots, carrier {carrier:.3} Hz",
            info.protocol, info.version, info.phase_bits, info.slots
        ),
    );
    tell(
        Verdict::Noted,
        format!(
            "its counters before: {} good packets, {} spoiled, {} framing errors, {:.1} s since power-up",
            status.good,
            status.spoiled,
            status.framing_errors,
            f64::from(status.periods) / carrier
        ),
    );
}

/// A rate too fast for a line is a fact, not a fault: slower ones may be error-free.
fn verdict(trial: &Trial) -> Verdict {
    if trial.is_clean() { Verdict::Passed } else { Verdict::Noted }
}

fn in_words(trial: &Trial) -> String {
    match &trial.outcome {
        TrialOutcome::Impossible(why) => format!("{} baud: {why}", trial.baud),
        TrialOutcome::Tried(figures) => format!(
            "{} baud: {} frames, {} lost, {} read back wrong, {:.0} frames/s, answers after {:.2} ms",
            trial.baud,
            figures.sent,
            figures.lost,
            figures.wrong,
            figures.frames_per_second,
            figures.round_trip.as_secs_f64() * 1e3
        ),
    }
}

/// One focus above an array of the board's shape, at a carrier (Hz).
pub fn focus_scene(profile: Profile, carrier: f64) -> Scene {
    let mut scene = Scene::default();
    let rows = profile.elements().div_ceil(16) as u32;
    [scene.array.columns, scene.array.rows] = profile.shape().unwrap_or([16, rows]);
    scene.array.frequency = carrier;
    scene.targets = vec![Target::new(Shape::Point { at: glam::DVec3::new(0.0, 0.0, HEIGHT) })];
    scene
}
