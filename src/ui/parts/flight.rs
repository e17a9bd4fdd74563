//! The flight of the scene's bead after its release in the sound, played from its path.

use egui::{Color32, Painter, Pos2, Stroke};
use glam::DVec3;

use crate::acoustics::response::responding;
use crate::drive::Drive;
use crate::force::Flight;
use crate::gauge::Gauge;
use crate::scene::{Scene, motion};
use crate::studio::flight::{Course, place};
use crate::ui::part::{Derived, Now, Part};

/// Duration of a flight in a scene at rest, and of one that is carried at most, s.
const SECONDS: f64 = 0.5;
const MOST_SECONDS: f64 = 2.0;
/// Repetitions of a motion, at least.
const ROUNDS: f64 = 2.0;
/// Points of a trail, at most.
const MOST_POINTS: usize = 1500;
/// Radius on the screen in points.
const BEAD: f32 = 6.0;
const TRAIL: Color32 = Color32::from_rgb(120, 220, 255);

/// The release of the bead, and the moment of its flight on the screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Release {
    /// `None`: it has not been released.
    pub from: Option<Start>,
    pub playing: bool,
    /// s since the release.
    pub time: f64,
    /// Slowdown of the playback.
    pub slowness: f64,
}

impl Default for Release {
    fn default() -> Self {
        Self { from: None, playing: false, time: 0.0, slowness: 10.0 }
    }
}

/// Where a bead is let go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    /// The place of its trap in the scene, m.
    pub trap: DVec3,
    /// Another place, m; in a scene in motion a bead starts otherwise at rest in the trap of the first frame.
    pub typed: Option<DVec3>,
    /// The target that is the trap.
    pub target: Option<usize>,
}

/// The fields, the position of the trap in each, and the place of the release.
#[derive(Clone, Debug, PartialEq)]
pub struct Input {
    scene: Scene,
    fields: Vec<Vec<Drive>>,
    wanted: Vec<DVec3>,
    /// Duration of a field (s); infinite at rest.
    span: f64,
    /// m; `None`: at rest in the trap of the first field.
    from: Option<DVec3>,
}

impl Part for Release {
    type Input = Input;
    type Output = Flight;

    fn input(&self, now: &Now<'_>) -> Option<Input> {
        let Start { trap, typed, target } = self.from?;
        let (sound, scene) = (now.sound?, now.scene.clone());
        let at_rest = |heard: Vec<Drive>| Input {
            scene: scene.clone(),
            fields: vec![heard],
            wanted: vec![trap],
            span: f64::INFINITY,
            from: Some(typed.unwrap_or(trap)),
        };
        if !motion::moves(now.scene) {
            return Some(at_rest(sound.heard.clone()));
        }
        let (cycle, frames) = (motion::cycle(now.scene)?, &now.cycle?.frames);
        let wanted = frames.iter().map(|frame| place(&frame.foci, target)).collect::<Option<_>>()?;
        let drives = frames.iter().map(|frame| frame.drive.clone()).collect();
        let fields = responding(now.scene, drives, false).into_iter().map(|drive| vec![drive]).collect();
        let span = cycle.frames_per_second().recip();
        Some(Input { scene, fields, wanted, span, from: typed })
    }

    fn may_begin(&self, now: &Now<'_>) -> bool {
        now.rests
    }

    fn computation(&self) -> impl FnOnce(&Input) -> Flight + Send + 'static {
        |Input { scene, fields, wanted, span, from }| {
            let course = Course::playing(scene, fields, wanted.clone(), *span);
            let round = course.round();
            let seconds =
                if round.is_finite() { (ROUNDS * round).clamp(SECONDS, MOST_SECONDS) } else { SECONDS };
            course.fly(from.unwrap_or_else(|| course.start()), seconds, 1.0, &Gauge::default())
        }
    }
}

impl Release {
    /// Releases the bead.
    pub fn release(&mut self, from: Start) {
        (self.from, self.playing, self.time) = (Some(from), true, 0.0);
    }
}

impl Derived<Release> {
    /// Moves a flight on by some seconds of the screen. Returns whether it plays.
    pub fn go_on(&mut self, passed: f64) -> bool {
        let last = self.newest().and_then(|flight| flight.moments.last()).map(|last| last.time);
        let Some(end) = last.filter(|_| self.form.playing) else { return false };
        let time = self.form.time + passed / self.form.slowness.max(1.0);
        self.form.time = if time > end { 0.0 } else { time };
        true
    }
}

/// The bead at the displayed moment, with its trail, wherever its places are on the screen.
pub fn paint(flight: &Derived<Release>, painter: &Painter, screen: impl Fn(DVec3) -> Option<Pos2>) {
    let Some(moments) = flight.newest().map(|flight| &flight.moments[..]) else { return };
    let behind = moments.partition_point(|moment| moment.time <= flight.form.time).max(1);
    let Some(bead) = moments.get(behind - 1) else { return };
    let apart = behind.div_ceil(MOST_POINTS).max(1);
    let trail: Vec<_> =
        moments[..behind].iter().step_by(apart).filter_map(|moment| screen(moment.at)).collect();
    for (width, colour) in [(3.4, Color32::from_black_alpha(140)), (1.5, TRAIL)] {
        painter.line(trail.clone(), Stroke::new(width, colour));
    }
    if let Some(at) = screen(bead.at) {
        painter.circle(at, BEAD, Color32::WHITE, Stroke::new(1.5, Color32::from_black_alpha(200)));
    }
}
