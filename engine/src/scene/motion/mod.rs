//! Motion: targets along closed paths, keyframes or routes of a file, foci along drawn strokes, or targets in turn.
//!
//! [`cycle()`] is the common cycle of a scene's motions, and [`frames()`] are the focal points of its frames.

mod course;
mod cycle;
mod envelopes;
mod frames;
mod keyframes;
mod limits;
mod mover;
mod pose;
mod posed;
mod route;
mod track;

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use serde::ser::SerializeMap;
use serde::{Deserialize, Serialize, Serializer};
use strum::{EnumString, IntoStaticStr, VariantArray, VariantNames};

use crate::scene::range::{Key, KeyError};
use crate::scene::run::Vertex;
use crate::scene::solver::is_zero;

pub(crate) use cycle::has_dynamics;
pub use cycle::{Cycle, Group, cycle, moves, runs};
pub(crate) use envelopes::{Envelopes, shares};
pub(crate) use frames::envelopes_of;
pub use frames::{check, count, frames};
pub use keyframes::{Easing, Keyframe, insert};
pub(crate) use mover::governing;
#[doc(hidden)]
pub use mover::{pose_of, ways};
use pose::Mover;
#[doc(hidden)]
pub use pose::Pose;
pub(crate) use posed::Posed;
#[doc(hidden)]
pub use route::{Routes, Trace, TracePlace};
use track::Track;

/// Pieces of a figure-eight, which has no closed form for its arc length; their chords are 1e-5 too short.
const PIECES: usize = 512;
/// Repetitions per second by default.
const USUAL_RATE: f64 = 5.0;

/// The motion of targets. A repetition ends where it begins.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Motion {
    pub path: MotionPath,
    /// m: length of a line, diameter of a circle, side of a square or triangle, width of a figure-eight.
    pub size: f64,
    /// Counter-clockwise rotation of the path, rad.
    #[serde(skip_serializing_if = "is_zero")]
    pub angle: f64,
    #[serde(flatten)]
    pub tempo: Tempo,
    /// Frames per cycle; 0, with `path = "file"` alone: as many as the file's places need.
    #[serde(skip_serializing_if = "is_automatic")]
    pub frames: u32,
    /// The offsets (m) that `path = "points"` visits.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub points: Vec<DVec3>,
    /// The keyframes of `path = "keyframes"`, in temporal order.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub keyframes: Vec<Keyframe>,
    /// The CSV or G-code file of `path = "file"`, relative to the scene's file.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub file: String,
    /// The routes of the file, once loaded.
    #[serde(skip)]
    #[doc(hidden)]
    pub routes: Routes,
    /// Focal points that run along an outline, at equal distances.
    #[serde(skip_serializing_if = "is_one")]
    pub foci: u32,
    /// Foci are ahead of their places by the time that the elements need to follow.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub lead: bool,
}

fn is_automatic(frames: &u32) -> bool {
    *frames == 0
}

fn is_one(foci: &u32) -> bool {
    *foci == 1
}

impl Default for Motion {
    fn default() -> Self {
        let tempo = Tempo::usual(MotionPath::None);
        Self {
            path: MotionPath::None,
            size: 0.03,
            angle: 0.0,
            tempo,
            frames: 64,
            points: Vec::new(),
            keyframes: Vec::new(),
            file: String::new(),
            routes: Routes::default(),
            foci: 1,
            lead: false,
        }
    }
}

/// Speed or rate of a motion; the other follows from its length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tempo {
    /// The tempo of the file, with `path = "file"`; without times in it, the usual rate.
    Own,
    /// Repetitions per second.
    Rate(f64),
    /// m/s
    Speed(f64),
}

impl Tempo {
    /// The default tempo of a path: along outlines, the speed of best tactile perception.
    pub fn usual(path: MotionPath) -> Self {
        match path {
            MotionPath::Outline => Self::Speed(6.0),
            MotionPath::File => Self::Own,
            MotionPath::None
            | MotionPath::Line
            | MotionPath::Circle
            | MotionPath::Square
            | MotionPath::Triangle
            | MotionPath::FigureEight
            | MotionPath::Points
            | MotionPath::Keyframes
            | MotionPath::Steps => Self::Rate(USUAL_RATE),
        }
    }

    /// Repetitions per second of a path of this length (m); `None` for a speed without length, and for a file's own.
    pub fn rate(self, length: f64) -> Option<f64> {
        match self {
            Self::Own => None,
            Self::Rate(rate) => Some(rate),
            Self::Speed(speed) => (length > 0.0).then(|| speed / length),
        }
    }
}

impl Serialize for Tempo {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut keys = serializer.serialize_map(None)?;
        match self {
            Self::Own => {}
            Self::Rate(rate) => keys.serialize_entry("rate", rate)?,
            Self::Speed(speed) => keys.serialize_entry("speed", speed)?,
        }
        keys.end()
    }
}

/// The `[motion]` table as written: mutually exclusive keys are reported at their position.
#[doc(hidden)]
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MotionTable {
    path: MotionPath,
    size: Option<f64>,
    angle: f64,
    rate: Option<f64>,
    speed: Option<f64>,
    frames: Option<u32>,
    points: Vec<DVec3>,
    keyframes: Vec<Keyframe>,
    file: String,
    foci: Option<u32>,
    lead: bool,
}

impl MotionTable {
    /// The motion of this table.
    ///
    /// # Errors
    /// Both a rate and a speed.
    pub fn into_motion(self) -> Result<Motion, KeyError> {
        let Self { path, size, angle, rate, speed, frames, points, keyframes, file, foci, lead } = self;
        let tempo = match (rate, speed) {
            (Some(_), Some(_)) => {
                let message =
                    "give either `rate` or `speed`, not both: the other follows from the path's length";
                return Err(KeyError::new([Key::from("speed")], message));
            }
            (Some(rate), None) => Tempo::Rate(rate),
            (None, Some(speed)) => Tempo::Speed(speed),
            (None, None) => Tempo::usual(path),
        };
        let Motion { size: usual_size, frames: usual_frames, .. } = Motion::default();
        let usual_frames = if path == MotionPath::File { Motion::AUTOMATIC } else { usual_frames };
        let (size, frames, foci) =
            (size.unwrap_or(usual_size), frames.unwrap_or(usual_frames), foci.unwrap_or(1));
        let routes = Routes::default();
        Ok(Motion { path, size, angle, tempo, frames, points, keyframes, file, routes, foci, lead })
    }
}

/// Paths are parallel to the array and traversed at constant speed, counter-clockwise. All except `points`,
/// `keyframes` and `file` are centred on the targets' positions.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, EnumString, IntoStaticStr, VariantArray, VariantNames,
)]
#[strum(serialize_all = "kebab-case", const_into_str)]
pub enum MotionPath {
    #[default]
    None,
    /// Foci run along the drawn strokes, in their order and direction: no target moves.
    Outline,
    /// Along x from the left end to the right and back.
    Line,
    /// From +x.
    Circle,
    /// From the corner at smallest x and y.
    Square,
    /// Equilateral, from the corner at largest y.
    Triangle,
    /// Gerono's: twice as wide as high, from the crossing to the upper right.
    FigureEight,
    /// The offsets in `points`, one after the other and back to the first.
    Points,
    /// From keyframe to keyframe, at their times.
    Keyframes,
    /// To the places of a file, at its times or at constant speed.
    File,
    /// Targets take turns at rest: first those with `step = 0`, then those with `step = 1`, and so on.
    Steps,
}

impl Motion {
    /// [`Self::frames`] of a file: as many as its places need.
    #[doc(hidden)]
    pub const AUTOMATIC: u32 = 0;

    /// Offset of the targets (m) after a fraction of a repetition, in [0, 1); along a file the place of its first target.
    pub fn offset(&self, part: f64) -> DVec3 {
        self.pose(part).at
    }

    /// Factor on target pressures at this time.
    pub fn pressure(&self, part: f64) -> f64 {
        self.pose(part).pressure
    }

    /// The pose at this time; along a file of its first target, with a place for the offset.
    #[doc(hidden)]
    pub fn pose(&self, part: f64) -> Pose {
        self.round().at(part, Mover { target: self.routes.targets().next().unwrap_or(0), from: DVec3::ZERO })
    }

    /// Frames per cycle, of a file as many as its places need unless they are given.
    #[doc(hidden)]
    pub fn frame_count(&self) -> u32 {
        match self.path {
            MotionPath::File if self.frames == Self::AUTOMATIC => self.routes.frames(),
            MotionPath::None
            | MotionPath::Outline
            | MotionPath::Line
            | MotionPath::Circle
            | MotionPath::Square
            | MotionPath::Triangle
            | MotionPath::FigureEight
            | MotionPath::Points
            | MotionPath::Keyframes
            | MotionPath::File
            | MotionPath::Steps => self.frames.max(1),
        }
    }

    /// Repetitions per second of a path of this length (m); `None` for a speed without length.
    #[doc(hidden)]
    pub fn rate(&self, length: f64) -> Option<f64> {
        match self.tempo {
            Tempo::Own => Some(self.routes.period().map_or(USUAL_RATE, f64::recip)),
            Tempo::Rate(_) | Tempo::Speed(_) => self.tempo.rate(length),
        }
    }

    /// Whether targets turn, or traps have their phases shifted.
    pub(crate) fn turns(&self) -> bool {
        let turns = |keyframe: &Keyframe| keyframe.angle != 0.0 || keyframe.phase != 0.0;
        self.path == MotionPath::Keyframes && self.keyframes.iter().any(turns)
    }

    /// Whether the phases of traps are shifted.
    pub(crate) fn shifts(&self) -> bool {
        self.path == MotionPath::Keyframes && self.keyframes.iter().any(|keyframe| keyframe.phase != 0.0)
    }

    /// Whether a named file is not yet loaded.
    #[doc(hidden)]
    pub fn lacks_routes(&self) -> bool {
        self.path == MotionPath::File && self.routes.is_missing()
    }

    /// Remarks on the file of the path: what was left aside in it, and places that no frame shows.
    #[doc(hidden)]
    pub fn remarks(&self) -> Vec<String> {
        if self.path != MotionPath::File {
            return Vec::new();
        }
        let (places, frames) = (self.routes.places(), self.frame_count());
        let skipped = (self.frames == Self::AUTOMATIC && places > frames as usize).then(|| {
            format!(
                "{}: its {places} places are resampled to {frames} frames: `frames` gives more",
                self.file
            )
        });
        let own = self.routes.remarks().iter().map(|remark| format!("{}: {remark}", self.file));
        own.chain(skipped).collect()
    }

    /// Length of a repetition (m); 0 for steps, and for outlines, whose length is that of the targets:
    /// [`Group::length`].
    pub fn length(&self) -> f64 {
        self.round().length()
    }

    fn round(&self) -> Round<'_> {
        match self.path {
            MotionPath::Keyframes => Round::Keyframes(&self.keyframes),
            MotionPath::File => Round::File(&self.routes),
            MotionPath::None
            | MotionPath::Line
            | MotionPath::Circle
            | MotionPath::Square
            | MotionPath::Triangle
            | MotionPath::Points
            | MotionPath::FigureEight
            | MotionPath::Steps
            | MotionPath::Outline => Round::Track(self.track()),
        }
    }

    fn track(&self) -> Track {
        let size = self.size;
        let turn = DVec2::from_angle(self.angle);
        let turned = |v: DVec2| (turn.rotate(v) * size).extend(0.0);
        let flat = |vertices: &[DVec2]| Track::round(vertices.iter().map(|&v| turned(v)));
        match self.path {
            MotionPath::None
            | MotionPath::Steps
            | MotionPath::Outline
            | MotionPath::Keyframes
            | MotionPath::File => Track::round([DVec3::ZERO]),
            MotionPath::Circle => {
                let centre = Vertex { at: DVec3::ZERO, pressure: 1.0 };
                Track::Circle { centre, x: turned(DVec2::X / 2.0), y: turned(DVec2::Y / 2.0) }
            }
            MotionPath::Line => flat(&[(-0.5, 0.0), (0.5, 0.0)].map(DVec2::from)),
            MotionPath::Square => {
                flat(&[(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)].map(DVec2::from))
            }
            MotionPath::Triangle => {
                let corner = |i: u32| DVec2::from_angle(TAU * (0.25 + f64::from(i) / 3.0)) / 3.0_f64.sqrt();
                flat(&[0, 1, 2].map(corner))
            }
            MotionPath::FigureEight => Track::round((0..PIECES).map(|i| {
                let (sin, cos) = (TAU * i as f64 / PIECES as f64).sin_cos();
                turned(DVec2::new(sin, sin * cos) / 2.0)
            })),
            MotionPath::Points => Track::round(self.points.iter().copied()),
        }
    }
}

/// The course of one repetition, by its completed fraction.
enum Round<'a> {
    /// At constant speed.
    Track(Track),
    Keyframes(&'a [Keyframe]),
    File(&'a Routes),
}

impl Round<'_> {
    /// The pose of a target after a fraction in [0, 1).
    fn at(&self, part: f64, mover: Mover) -> Pose {
        match self {
            Self::Track(track) => track.at(part * track.length()).into(),
            Self::Keyframes(keyframes) => keyframes::between(keyframes, part),
            Self::File(routes) => routes.at(part, mover),
        }
    }

    /// m
    fn length(&self) -> f64 {
        match self {
            Self::Track(track) => track.length(),
            Self::Keyframes(keyframes) => keyframes::length(keyframes),
            Self::File(routes) => routes.length(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MOVING: [MotionPath; 6] = [
        MotionPath::Line,
        MotionPath::Circle,
        MotionPath::Square,
        MotionPath::Triangle,
        MotionPath::FigureEight,
        MotionPath::Points,
    ];

    fn motion(path: MotionPath) -> Motion {
        let points = vec![DVec3::ZERO, DVec3::new(0.03, 0.0, 0.01), DVec3::new(0.0, 0.02, -0.01)];
        Motion { path, size: 0.04, points, ..Motion::default() }
    }

    #[test]
    fn every_path_is_closed_and_run_through_at_constant_speed() {
        const STEPS: u32 = 4000;
        for path in MOVING {
            let motion = motion(path);
            let at = |i: u32| motion.offset(f64::from(i % STEPS) / f64::from(STEPS));
            let step = motion.length() / f64::from(STEPS);
            let distances: Vec<_> = (0..STEPS).map(|i| at(i).distance(at(i + 1))).collect();
            // Corners are cut short, and there are few.
            let uneven = distances.iter().filter(|&&d| (d / step - 1.0).abs() > 0.01).count();
            assert!(uneven <= 4, "{path:?}: {uneven} uneven steps");
            assert!(distances.iter().all(|&d| d < 1.01 * step), "{path:?} jumps");
            let mean = (0..STEPS).map(at).sum::<DVec3>() / f64::from(STEPS);
            assert!(path == MotionPath::Points || mean.length() < 1e-6, "{path:?}: {mean}");
        }
    }

    #[test]
    fn lengths_and_extents_are_those_of_the_figures() {
        let size = 0.04;
        for (path, length, width, height) in [
            (MotionPath::Line, 2.0 * size, size, 0.0),
            (MotionPath::Circle, TAU / 2.0 * size, size, size),
            (MotionPath::Square, 4.0 * size, size, size),
            (MotionPath::Triangle, 3.0 * size, size, 0.75_f64.sqrt() * size),
            // ∫ √(cos² t + cos² 2t) dt = 6.09722 for a figure that is two wide.
            (MotionPath::FigureEight, 6.097_22 / 2.0 * size, size, size / 2.0),
            (MotionPath::None, 0.0, 0.0, 0.0),
            (MotionPath::Steps, 0.0, 0.0, 0.0),
        ] {
            let motion = motion(path);
            assert!((motion.length() - length).abs() < 1e-4 * size, "{path:?}: {}", motion.length());
            let offsets: Vec<_> = (0..2400).map(|i| motion.offset(f64::from(i) / 2400.0)).collect();
            let extent = |of: fn(&DVec3) -> f64| {
                let values = offsets.iter().map(of);
                values.clone().fold(f64::MIN, f64::max) - values.fold(f64::MAX, f64::min)
            };
            assert!((extent(|o| o.x) - width).abs() < 2e-3 * size, "{path:?}");
            assert!((extent(|o| o.y) - height).abs() < 2e-3 * size, "{path:?}");
        }
        let square = motion(MotionPath::Square).length();
        assert!((Tempo::Speed(0.8).rate(square).unwrap() - 5.0).abs() < 1e-12, "4 x 40 mm, 5 times a second");
        assert_eq!((Tempo::Rate(2.0).rate(0.0), Tempo::Speed(2.0).rate(0.0)), (Some(2.0), None));
    }

    #[test]
    fn paths_begin_where_they_say() {
        let (h, part) = (0.02, 1e-3);
        for (path, start, towards) in [
            (MotionPath::Line, DVec3::new(-h, 0.0, 0.0), DVec3::X),
            (MotionPath::Circle, DVec3::new(h, 0.0, 0.0), DVec3::Y),
            (MotionPath::Square, DVec3::new(-h, -h, 0.0), DVec3::X),
            (
                MotionPath::Triangle,
                DVec3::new(0.0, 0.04 / 3.0_f64.sqrt(), 0.0),
                DVec3::new(-0.5, -0.866, 0.0),
            ),
            (MotionPath::FigureEight, DVec3::ZERO, (DVec3::X + DVec3::Y) * std::f64::consts::FRAC_1_SQRT_2),
        ] {
            let motion = motion(path);
            assert!(motion.offset(0.0).distance(start) < 1e-12, "{path:?}");
            let direction = (motion.offset(part) - start).normalize_or_zero();
            assert!(direction.dot(towards) > 0.999, "{path:?}: {direction}");
        }
    }

    #[test]
    fn points_without_a_way_between_them_stand_still() {
        let at = DVec3::new(0.01, 0.0, 0.0);
        for points in [vec![at], vec![at, at]] {
            let motion = Motion { points, ..motion(MotionPath::Points) };
            assert_eq!((motion.offset(0.4), motion.length()), (at, 0.0));
        }
    }
}
