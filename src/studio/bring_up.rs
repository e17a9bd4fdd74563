//! Bring-up of a board, shared by command line and window: findings as text, the survey of its line, and the test
//! focus.

use std::fmt;
use std::path::Path;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::acoustics::Aperture;
use crate::device::link::survey::{Discovery, Trial, TrialOutcome, survey};
use crate::device::native::packet::{Info, Status};
use crate::device::profile::Profile;
use crate::device::wiring::{Share, Wiring};
use crate::scene::{Scene, Shape, Target};

/// Height of the test focus above the array's centre, m.
pub const HEIGHT: f64 = 0.1;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    Passed,
    Failed,
    /// A neutral fact, or a skipped step.
    Noted,
    /// Bytes were written, and nothing tells whether the board plays them.
    Unverified,
}

/// One finding.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
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
            "{} baud: {} frames, {} lost, {} read back wrong, {:.0} frames/s acknowledged, answers after {:.2} ms",
            trial.baud,
            figures.sent,
            figures.lost,
            figures.wrong,
            figures.frames_per_second,
            figures.round_trip.as_secs_f64() * 1e3
        ),
    }
}

/// The tested array: a scene's if the board drives it, or else one of the board's shape.
pub fn tested(profile: Profile, scene: &Scene) -> (Scene, Wiring) {
    match Wiring::of(profile, scene, Share::default()) {
        Ok(wiring) => (scene.clone(), wiring),
        Err(_) => (board_scene(profile), Wiring::own(profile)),
    }
}

/// An array of the board's shape.
pub fn board_scene(profile: Profile) -> Scene {
    let mut scene = Scene::default();
    let rows = profile.elements().div_ceil(16) as u32;
    [scene.array.columns, scene.array.rows] = profile.shape().unwrap_or([16, rows]);
    scene
}

/// One focus in front of the middle of a scene's array, at a carrier (Hz).
pub fn focus_scene(array: &Scene, carrier: f64) -> Scene {
    let mut scene = Scene { array: array.array.clone(), boards: array.boards.clone(), ..Scene::default() };
    scene.array.frequency = carrier;
    let Aperture { positions, normals, driven, .. } = Aperture::new(&scene);
    let sum = |of: &[DVec3]| driven.iter().map(|&n| of[n]).sum::<DVec3>();
    let middle = sum(&positions) / driven.len().max(1) as f64;
    let at = middle + HEIGHT * sum(&normals).normalize_or_zero();
    scene.targets = vec![Target::new(Shape::Point { at })];
    scene
}

/// "element 3 (row 0, column 3)", or the position in a table.
pub(crate) fn named(scene: &Scene, element: usize) -> String {
    let each = scene.array.elements().max(1);
    let board = match scene.boards.len() {
        0 | 1 => String::new(),
        _ => format!("board {}, ", element / each + 1),
    };
    let (place, columns) = (element % each, scene.array.columns as usize);
    match scene.array.places().get(place).filter(|_| scene.array.file.is_some()) {
        Some(it) => {
            let [x, y, z] = (it.at * 1e3).to_array();
            format!("element {element} ({board}x = {x:.1}, y = {y:.1}, z = {z:.1} mm)")
        }
        None => format!("element {element} ({board}row {}, column {})", place / columns, place % columns),
    }
}
