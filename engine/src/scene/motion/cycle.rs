//! The common cycle of all motions of a scene, and the repetitions of each motion in it.

use crate::scene::motion::course::Course;
use crate::scene::motion::envelopes;
use crate::scene::motion::{Motion, MotionPath};
use crate::scene::{content::Scene, range::KeyError, target::Target};

/// The common cycle of all motions.
#[derive(Clone, Debug)]
pub struct Cycle<'a> {
    /// Cycles per second.
    pub rate: f64,
    pub frames: u32,
    /// The scene's, if it has one, and then those of targets in the order of the file.
    pub groups: Vec<Group<'a>>,
    /// The group whose repetition is the cycle, and whose frames are its frames.
    pub leader: usize,
}

impl Cycle<'_> {
    pub fn frames_per_second(&self) -> f64 {
        f64::from(self.frames) * self.rate
    }

    /// Rate and frames of the motion, if anything moves.
    pub(super) fn moving(&self) -> Option<(f64, u32)> {
        (!self.groups.is_empty()).then_some((self.rate, self.frames))
    }

    /// Actual repetitions per second of a group: a whole number per cycle.
    pub fn played(&self, group: &Group<'_>) -> f64 {
        self.rate * group.rounds as f64
    }
}

/// The targets that share a motion: one with its own, or all others with the scene's.
#[derive(Clone, Debug)]
pub struct Group<'a> {
    /// The target's index in the scene; `None` for the scene's motion.
    pub target: Option<usize>,
    pub motion: &'a Motion,
    /// m, of a repetition.
    pub length: f64,
    /// Repetitions per cycle.
    pub rounds: u64,
}

impl Group<'_> {
    /// Requested repetitions per second.
    pub fn asked(&self) -> f64 {
        const OTHERWISE: f64 = 1.0;
        self.motion.rate(self.length).unwrap_or(OTHERWISE)
    }
}

/// Whether a scene has more than one frame, also because envelopes of targets differ. Several drives of a file are
/// frames if they have times or the scene moves, and otherwise take turns; a single drive stands still.
pub fn moves(scene: &Scene) -> bool {
    let has_path = || paths(scene).any(|path| path != MotionPath::None);
    match scene.drive.table() {
        None => has_path() || scene.has_own_envelopes(),
        Some(table) => table.drives.len() > 1 && (table.rate.is_some() || has_path()),
    }
}

/// Whether foci run along outlines.
pub fn runs(scene: &Scene) -> bool {
    paths(scene).any(|path| path == MotionPath::Outline)
}

/// Whether target pressures vary between frames, so that frames differ in loudness.
pub fn has_dynamics(scene: &Scene) -> bool {
    paths(scene).any(|path| matches!(path, MotionPath::Outline | MotionPath::Keyframes))
}

/// The paths of the scene and of visible targets.
fn paths(scene: &Scene) -> impl Iterator<Item = MotionPath> {
    let shown = scene.targets.iter().filter(|target| target.visible);
    let own = shown.filter_map(|target| target.motion.as_ref());
    std::iter::once(&scene.motion).chain(own).map(|motion| motion.path)
}

/// The scene's own motion sets the cycle, or else the slowest of its targets'; the others are repeated a whole number
/// of times. The drives of a file are the frames of the cycle, at their own rate if they have times. `None` for a scene
/// at rest.
///
/// Where envelopes of targets differ, the cycle is the one in which they repeat, too, in frames that follow them.
pub fn cycle(scene: &Scene) -> Option<Cycle<'_>> {
    let motion = of_motions(scene)?;
    Some(if scene.has_own_envelopes() { under_envelopes(motion, scene) } else { motion })
}

/// As many repetitions of a motion as the envelopes of targets need for theirs; itself without a common period, which a check
/// refuses.
fn under_envelopes<'a>(motion: Cycle<'a>, scene: &Scene) -> Cycle<'a> {
    let Ok(fit) = envelopes::fit(scene, motion.moving()) else { return motion };
    let again = |group: Group<'a>| Group { rounds: group.rounds * fit.rounds, ..group };
    let groups = motion.groups.into_iter().map(again).collect();
    Cycle { rate: 1.0 / fit.period, frames: fit.frames, groups, leader: motion.leader }
}

/// The cycle without the envelopes of targets: one frame, if nothing moves.
pub(super) fn of_motions(scene: &Scene) -> Option<Cycle<'_>> {
    if !moves(scene) {
        return None;
    }
    let own = scene.targets.iter().enumerate().filter(|(_, target)| target.visible);
    let own = own.filter_map(|(index, target)| Some((Some(index), target.motion.as_ref()?)));
    let moving = std::iter::once((None, &scene.motion)).chain(own);
    let mut groups: Vec<_> = moving
        .filter(|(_, motion)| motion.path != MotionPath::None)
        .map(|(target, motion)| Group { target, motion, length: length(scene, target, motion), rounds: 1 })
        .collect();
    let slower = |&a: &usize, &b: &usize| groups[a].asked().total_cmp(&groups[b].asked());
    let leader = match groups.first().and_then(|group| group.target) {
        None => 0,
        Some(_) => (0..groups.len()).min_by(slower)?,
    };
    // Without motions only the times of drives make a cycle.
    let (asked, frames) =
        groups.get(leader).map_or((1.0, 1), |group| (group.asked(), group.motion.frame_count()));
    for group in &mut groups {
        group.rounds = (group.asked() / asked).round().max(1.0) as u64;
    }
    let (rate, frames) = match scene.drive.table() {
        None => (asked, frames),
        Some(table) => {
            let count = table.drives.len() as u32;
            (table.rate.map_or(asked, |rate| rate / f64::from(count)), count)
        }
    };
    Some(Cycle { rate, frames, groups, leader })
}

/// m, of a repetition of a motion; 0 for an outline that cannot be drawn.
fn length(scene: &Scene, target: Option<usize>, motion: &Motion) -> f64 {
    if motion.path == MotionPath::Outline {
        course(scene, target).map_or(0.0, |course| course.length())
    } else {
        motion.length()
    }
}

/// The course along a target, or along all visible targets without their own motion.
pub(super) fn course(scene: &Scene, target: Option<usize>) -> Result<Course, KeyError> {
    let is_of = |(index, own): &(usize, &Target)| match target {
        Some(target) => *index == target,
        None => own.visible && own.motion.is_none(),
    };
    Course::new(scene.targets.iter().enumerate().filter(is_of))
}
