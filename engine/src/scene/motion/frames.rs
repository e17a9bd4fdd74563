//! The focal points of every frame of a cycle, and the errors of impossible motions.

use glam::DVec3;

use crate::scene::check::MOST_FOCI;
use crate::scene::motion::Round;
use crate::scene::motion::course::Course;
use crate::scene::motion::cycle::{self, Cycle, Group, cycle};
use crate::scene::motion::envelopes::{self, Envelopes};
use crate::scene::motion::limits::{
    behind, check_group, check_memory, check_routes, check_steps, check_turns, key, refuse, steps,
};
use crate::scene::motion::mover::mover;
use crate::scene::motion::pose::{Mover, Pose};
use crate::scene::range::KeyError;
use crate::scene::response::Response;
use crate::scene::space::Front;
use crate::scene::{content::Scene, focus::Focus, motion::MotionPath, outline, target::Target};

/// Frames of a cycle, or the one that a scene without motion has.
pub fn count(scene: &Scene) -> usize {
    cycle(scene).map_or(1, |cycle| cycle.frames as usize)
}

/// The focal points of every frame of a cycle: of each target in the order of the file, and then those that run along outlines.
///
/// # Errors
/// The errors of [`outline::foci`] and [`check`].
pub fn frames(scene: &Scene) -> Result<Vec<Vec<Focus>>, KeyError> {
    let score = Score::new(scene)?;
    Ok((0..score.frames).map(|frame| score.foci(frame)).collect())
}

/// The envelopes of all foci in the frames of a cycle; `None` if they are alike, and no frame's.
///
/// # Errors
/// Invalid focal points.
pub fn envelopes_of(scene: &Scene) -> Result<Option<Envelopes>, KeyError> {
    match cycle(scene).filter(|_| scene.has_own_envelopes()) {
        None => Ok(None),
        Some(cycle) => envelopes::values(scene, 1.0 / cycle.rate, cycle.frames).map(Some),
    }
}

/// Checks targets and motions together.
///
/// # Errors
/// Invalid focal points, a step without targets or a target whose step is never shown, an outline or a speed without
/// length, too few frames for a motion repeated several times, different modulations of targets that cannot be frames,
/// frames that need more than 1 GiB, or a focal point that moves behind the array.
pub fn check(scene: &Scene) -> Result<(), KeyError> {
    Score::new(scene).map(drop)
}

/// Positions of all foci per frame.
pub(super) struct Score<'a> {
    scene: &'a Scene,
    frames: u64,
    /// The groups, each with the kind of its motion and its repetitions per cycle.
    ways: Vec<(Group<'a>, Way<'a>)>,
    steps: Vec<Vec<Part>>,
    /// Fraction of the cycle in which the elements follow a change.
    lead: f64,
}

enum Way<'a> {
    /// The whole target, displaced from its position in the file.
    Offset(Round<'a>),
    /// Foci running along its outline.
    Run(Course),
}

/// The focal points of a target at its position in the file, and its motion, if any.
struct Part {
    foci: Vec<Focus>,
    way: Option<usize>,
    mover: Mover,
    /// Centre (m) and axis of turns.
    centre: DVec3,
    normal: DVec3,
}

impl<'a> Score<'a> {
    pub fn new(scene: &'a Scene) -> Result<Self, KeyError> {
        check_steps(scene)?;
        check_routes(scene)?;
        let at_rest = |step: u32| outline::foci_of_step(scene, step).map(drop);
        (0..steps(scene)).try_for_each(at_rest)?;
        let cycle = cycle(scene);
        check_turns(scene, cycle.is_some())?;
        let frames = cycle.as_ref().map_or(1, |cycle| cycle.frames.into());
        let way = |group: &Group<'a>| {
            let way = if group.motion.path == MotionPath::Outline {
                Way::Run(cycle::course(scene, group.target)?)
            } else {
                Way::Offset(group.motion.round())
            };
            Ok((group.clone(), way))
        };
        let groups = cycle.iter().flat_map(|cycle| &cycle.groups);
        let ways = groups.map(way).collect::<Result<Vec<_>, KeyError>>()?;
        for (group, way) in &ways {
            check_group(group, matches!(way, Way::Run(_)), frames)?;
        }
        let follows = scene.array.response.map_or(0.0, Response::tau);
        let lead = cycle.as_ref().map_or(0.0, |cycle| cycle.rate * follows);
        let mut score = Self { scene, frames, ways, steps: Vec::new(), lead };
        score.steps = (0..steps(scene)).map(|step| score.parts(step)).collect::<Result<_, _>>()?;
        envelopes::check(scene, cycle::of_motions(scene).and_then(|cycle| cycle.moving()))?;
        if let Some(cycle) = &cycle {
            score.check_directions()?;
            score.check_size(cycle)?;
            score.check_heights(&scene.front())?;
        }
        Ok(score)
    }

    /// The targets of a step, without running foci.
    fn parts(&self, step: u32) -> Result<Vec<Part>, KeyError> {
        let targets: Vec<_> =
            self.scene.targets.iter().enumerate().filter(|(_, target)| target.is_in(step)).collect();
        let course = |way: Option<usize>| match way.map(|way| &self.ways[way].1) {
            Some(Way::Run(course)) => Some(course),
            Some(Way::Offset(_)) | None => None,
        };
        let is_whole = |(index, target): &(usize, &Target)| course(self.way_of(*index, target)).is_none();
        let whole: Vec<_> = targets.iter().copied().filter(is_whole).collect();
        let mut foci = outline::foci_of_targets(self.scene, &whole)?.into_iter();
        let part = |(index, target): (usize, &Target)| {
            let way = self.way_of(index, target);
            let (mover, centre) = (mover(self.scene, index, target), target.shape.centre());
            let part = |foci, way| Part { foci, way, mover, centre, normal: target.normal };
            let Some(course) = course(way) else { return part(foci.next().unwrap_or_default(), way) };
            let still = course.still.iter().filter(|(of, _)| *of == index).map(|(_, focus)| *focus);
            part(still.collect(), None)
        };
        Ok(targets.into_iter().map(part).collect())
    }

    /// The motion of a target, unless it is at rest.
    fn way_of(&self, index: usize, target: &Target) -> Option<usize> {
        let own = target.motion.is_some().then_some(index);
        let way = self.ways.iter().position(|(group, _)| group.target == own)?;
        // Foci do not run along pictures and directions.
        let runs = matches!(self.ways[way].1, Way::Run(_));
        let stands = runs && (target.shape.is_picture() || target.shape.is_direction());
        (!stands).then_some(way)
    }

    /// The pose in a frame of what follows a way.
    fn pose(&self, way: Option<usize>, frame: u64, mover: Mover) -> Pose {
        match way.map(|way| &self.ways[way]) {
            Some((group, Way::Offset(round))) => round.at(self.part(group, frame, 0), mover),
            Some((_, Way::Run(_))) | None => Pose::AT_REST,
        }
    }

    /// The poses of all targets in a frame.
    pub fn poses(&self, frame: u64) -> Vec<Pose> {
        let targets = self.scene.targets.iter().enumerate();
        let of = |(index, target): (usize, &Target)| {
            self.pose(self.way_of(index, target), frame, mover(self.scene, index, target))
        };
        targets.map(of).collect()
    }

    fn foci(&self, frame: u64) -> Vec<Focus> {
        let step = self.step(frame);
        let mut foci = Vec::new();
        for part in &self.steps[step as usize] {
            let pose = self.pose(part.way, frame, part.mover);
            foci.extend(part.foci.iter().map(|focus| Focus {
                position: pose.moved(focus.position, part.centre, part.normal),
                target: focus.target * pose.pressure,
                ..*focus
            }));
        }
        for (group, course) in self.courses(step) {
            let runner = |focus: u32| course.at(self.part(group, frame, focus));
            foci.extend((0..group.motion.foci).map(runner));
        }
        foci
    }

    /// Where foci run in a step.
    fn courses(&self, step: u32) -> impl Iterator<Item = (&Group<'a>, &Course)> {
        let is_shown =
            move |group: &Group<'_>| group.target.is_none_or(|target| self.scene.targets[target].is_in(step));
        self.ways.iter().filter_map(move |(group, way)| match way {
            Way::Run(course) if is_shown(group) => Some((group, course)),
            Way::Run(_) | Way::Offset(_) => None,
        })
    }

    /// The fraction of a repetition of one of its foci, without accumulated rounding errors.
    fn part(&self, group: &Group<'_>, frame: u64, focus: u32) -> f64 {
        let (frames, foci) = (u128::from(self.frames), u128::from(group.motion.foci));
        let whole = frames * foci;
        let done = u128::from(frame) * u128::from(group.rounds) * foci + u128::from(focus) * frames;
        let part = (done % whole) as f64 / whole as f64;
        if self.lead == 0.0 || !group.motion.lead {
            return part;
        }
        (part + self.lead * group.rounds as f64).fract()
    }

    /// The step, counted from 0, that a frame shows: steps share the frames evenly.
    fn step(&self, frame: u64) -> u32 {
        (frame * self.steps.len() as u64 / self.frames) as u32
    }

    /// The most foci that a frame has.
    fn most_foci(&self) -> usize {
        let in_step = |(step, parts): (u32, &Vec<Part>)| {
            let running: usize = self.courses(step).map(|(group, _)| group.motion.foci as usize).sum();
            parts.iter().map(|part| part.foci.len()).sum::<usize>() + running
        };
        (0..).zip(&self.steps).map(in_step).max().unwrap_or(0)
    }

    fn check_size(&self, cycle: &Cycle<'_>) -> Result<(), KeyError> {
        let foci = self.most_foci();
        if foci > MOST_FOCI
            && let Some((group, _)) = self.ways.iter().find(|(_, way)| matches!(way, Way::Run(_)))
        {
            let message = format!("a frame has {foci} with those of other targets: the limit is {MOST_FOCI}");
            return refuse(group.target, "foci", message);
        }
        let leader = cycle.groups.get(cycle.leader).and_then(|group| group.target);
        check_memory(self.scene, self.frames, foci).map_err(|message| match self.scene.has_own_envelopes() {
            false => KeyError::new(key(leader, "frames"), message),
            true => KeyError::new(
                envelopes::key(self.scene),
                format!(
                    "different modulations are played as frames, and repeat together after {:.4} s. {message}; frequencies \
                     with a larger common divisor, or a shorter waveform, take fewer",
                    1.0 / cycle.rate
                ),
            ),
        })
    }

    /// Directions stand still: a path displaces places.
    fn check_directions(&self) -> Result<(), KeyError> {
        for part in self.steps.iter().flatten().filter(|part| part.foci.iter().any(Focus::is_direction)) {
            let Some((group, _)) = part.way.map(|way| &self.ways[way]) else { continue };
            if !matches!(group.motion.path, MotionPath::None | MotionPath::Steps) {
                let message = "a direction has no place that a path could move: give moving targets a [target.motion] of their \
                               own, or play several directions with path = \"steps\"";
                return refuse(group.target, "path", message.to_owned());
            }
        }
        Ok(())
    }

    /// The first frame that takes targets with a common pose behind the boards, and a place (m) there.
    fn behind(
        &self,
        front: &Front,
        (group, round): (&Group<'_>, &Round<'_>),
        parts: &[&Part],
    ) -> Option<(u64, DVec3)> {
        let first = parts.first()?;
        let placed = parts.iter().flat_map(|part| &part.foci).filter(|focus| !focus.is_direction());
        let foci: Vec<_> = placed.map(|focus| focus.position).collect();
        let lowest = |foci: &[DVec3]| {
            front.lowest(|up| foci.iter().copied().min_by(|a, b| a.dot(up).total_cmp(&b.dot(up))))
        };
        let at_rest = lowest(&foci);
        let outside = |frame: u64| {
            let pose = round.at(self.part(group, frame, 0), first.mover);
            if pose.angle == 0.0 {
                return front.outside_moved(&at_rest, pose.at);
            }
            let turned: Vec<_> = foci.iter().map(|at| pose.moved(*at, first.centre, first.normal)).collect();
            front.outside_moved(&lowest(&turned), DVec3::ZERO)
        };
        (0..self.frames).find_map(|frame| Some((frame, outside(frame)?)))
    }

    fn check_heights(&self, front: &Front) -> Result<(), KeyError> {
        for (index, (group, way)) in self.ways.iter().enumerate() {
            let round = match way {
                Way::Offset(round) => round,
                Way::Run(course) => {
                    if let Some(place) = front.outside(|up| course.lowest(up)) {
                        let message = format!("the outline goes to {}", behind(place, front));
                        return refuse(group.target, "path", message);
                    }
                    continue;
                }
            };
            let moved = self.steps.iter().flatten().filter(|part| part.way == Some(index));
            // Only places of a file and turns differ from target to target.
            let is_common = !matches!(round, Round::File(_)) && !group.motion.turns();
            let moved: Vec<_> = moved.collect();
            let together = if is_common { moved.len().max(1) } else { 1 };
            for parts in moved.chunks(together) {
                if let Some((frame, place)) = self.behind(front, (group, round), parts) {
                    let (number, count, place) = (frame + 1, self.frames, behind(place, front));
                    let message =
                        format!("in frame {number} of {count} the motion takes a focal point to {place}");
                    let key = match round {
                        Round::Track(_) => "points",
                        Round::Keyframes(_) => "keyframes",
                        Round::File(_) => "file",
                    };
                    return refuse(group.target, key, message);
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use glam::DVec2;

    use super::*;
    use crate::scene::motion::{Motion, Tempo};
    use crate::scene::shape::Shape;

    fn motion(path: MotionPath) -> Motion {
        let points = vec![DVec3::ZERO, DVec3::new(0.03, 0.0, 0.01), DVec3::new(0.0, 0.02, -0.01)];
        Motion { path, size: 0.04, points, ..Motion::default() }
    }

    fn scene(motion: Motion, at: &[DVec3]) -> Scene {
        let target = |&at: &DVec3| Target::new(Shape::Point { at });
        Scene { motion, targets: at.iter().map(target).collect(), ..Scene::default() }
    }

    #[test]
    fn frames_move_every_focus_and_leave_a_still_scene_alone() {
        let at = [DVec3::new(0.0, 0.0, 0.1), DVec3::new(0.02, 0.0, 0.12)];
        let moving = scene(Motion { frames: 8, ..motion(MotionPath::Circle) }, &at);
        let moved = frames(&moving).unwrap();
        assert_eq!(moved.len(), 8);
        for (i, foci) in moved.iter().enumerate() {
            let offset = (DVec2::from_angle(TAU * i as f64 / 8.0) * 0.02).extend(0.0);
            for (focus, at) in foci.iter().zip(at) {
                assert!(focus.position.distance(at + offset) < 1e-12);
            }
        }
        assert_eq!(frames(&scene(Motion::default(), &at)).unwrap().len(), 1);
    }

    #[test]
    fn steps_take_turns_and_share_the_frames() {
        let at = [DVec3::new(0.0, 0.0, 0.1), DVec3::new(0.02, 0.0, 0.1), DVec3::new(0.0, 0.02, 0.1)];
        let mut scene = scene(Motion { frames: 5, ..motion(MotionPath::Steps) }, &at);
        scene.targets[0].step = Some(1);
        scene.targets[1].step = Some(0);
        let frames = frames(&scene).unwrap();
        let shown: Vec<Vec<_>> =
            frames.iter().map(|foci| foci.iter().map(|focus| focus.position).collect()).collect();
        let (first, second) = (vec![at[1], at[2]], vec![at[0], at[2]]);
        assert_eq!(shown, [first.clone(), first.clone(), first.clone(), second.clone(), second]);
        let still: Vec<_> = outline::foci(&scene).unwrap().iter().map(|focus| focus.position).collect();
        assert_eq!(still, first, "a still view shows the first step");
    }

    /// A scene of these targets with this motion.
    fn of(motion: Motion, targets: Vec<Target>) -> Scene {
        Scene { motion, targets, ..Scene::default() }
    }

    fn moving(path: MotionPath, shape: Shape) -> Target {
        Target { motion: Some(motion(path)), ..Target::new(shape) }
    }

    fn positions(frame: &[Focus]) -> Vec<DVec3> {
        frame.iter().map(|focus| focus.position).collect()
    }

    #[test]
    fn a_target_moves_by_itself_or_stands_while_the_others_move() {
        let at = [0.0, 0.02, -0.03].map(|x| DVec3::new(x, 0.0, 0.1));
        let point = |at| Shape::Point { at };
        let targets = vec![
            Target::new(point(at[0])),
            moving(MotionPath::None, point(at[1])),
            moving(MotionPath::Line, point(at[2])),
        ];
        let scene = of(Motion { frames: 16, ..motion(MotionPath::Circle) }, targets);
        let line = motion(MotionPath::Line);
        for (i, frame) in frames(&scene).unwrap().iter().enumerate() {
            let part = i as f64 / 16.0;
            let wanted = [at[0] + scene.motion.offset(part), at[1], at[2] + line.offset(part)];
            assert!(positions(frame).iter().zip(wanted).all(|(a, b)| a.distance(b) < 1e-12), "frame {i}");
        }
    }

    #[test]
    fn a_target_makes_whole_rounds_in_the_cycle_of_the_scene_or_of_the_slowest() {
        let at = DVec3::new(0.0, 0.0, 0.1);
        let with = |path: MotionPath, rates: [f64; 2]| {
            let mut targets =
                [MotionPath::Circle, MotionPath::Line].map(|own| moving(own, Shape::Point { at }));
            for (target, (rate, frames)) in targets.iter_mut().zip(rates.into_iter().zip([48, 60])) {
                let own = target.motion.as_mut().unwrap();
                (own.tempo, own.frames) = (Tempo::Rate(rate), frames);
            }
            of(Motion { frames: 40, ..motion(path) }, targets.to_vec())
        };
        for (path, rates, cycle_of, rounds) in [
            (MotionPath::Square, [5.0, 14.6], (5.0, 40), vec![1, 1, 3]),
            (MotionPath::Square, [0.1, 22.0], (5.0, 40), vec![1, 1, 4]),
            (MotionPath::None, [4.0, 2.0], (2.0, 60), vec![2, 1]),
            (MotionPath::None, [2.0, 2.9], (2.0, 48), vec![1, 1]),
        ] {
            let scene = with(path, rates);
            let cycle = cycle(&scene).unwrap();
            assert_eq!((cycle.rate, cycle.frames), cycle_of);
            assert_eq!(cycle.groups.iter().map(|group| group.rounds).collect::<Vec<_>>(), rounds);
            let last = cycle.groups.last().unwrap();
            assert_eq!(cycle.played(last), cycle.rate * *rounds.last().unwrap() as f64);
            let frames = frames(&scene).unwrap();
            assert_eq!(frames.len(), cycle_of.1 as usize);
            for (i, frame) in frames.iter().enumerate() {
                let part = (i as u64 * last.rounds) as f64 / frames.len() as f64;
                let place = at + last.motion.offset(part.fract());
                assert!(frame[1].position.distance(place) < 1e-12, "frame {i}");
            }
        }
    }

    #[test]
    fn speed_and_rate_agree() {
        let ring = Shape::Circle { at: DVec3::new(0.0, 0.0, 0.1), radius: 0.2 / TAU };
        for (path, length) in [(MotionPath::Outline, 0.2), (MotionPath::Square, 0.16)] {
            let of = |tempo| of(Motion { tempo, ..motion(path) }, vec![Target::new(ring.clone())]);
            let (by_speed, by_rate) = (of(Tempo::Speed(6.0)), of(Tempo::Rate(6.0 / length)));
            let (a, b) = (cycle(&by_speed).unwrap(), cycle(&by_rate).unwrap());
            assert!((a.rate - 6.0 / length).abs() < 1e-9 && (a.rate - b.rate).abs() < 1e-9, "{path:?}");
            assert!((a.groups[0].length - length).abs() < 1e-12);
            assert_eq!(frames(&by_speed), frames(&by_rate));
        }
    }

    #[test]
    fn own_outlines_are_run_along_while_others_stand_or_move() {
        let at = DVec3::new(0.0, 0.0, 0.1);
        let (ring, line) = (
            Shape::Circle { at, radius: 0.01 },
            Shape::Line { from: at - DVec3::Y * 0.02, to: at + DVec3::new(0.02, -0.02, 0.0) },
        );
        let mut runner = moving(MotionPath::Outline, ring);
        runner.motion.as_mut().unwrap().foci = 2;
        let scene = of(motion(MotionPath::Circle), vec![runner, Target::new(line)]);
        let still = outline::foci(&of(Motion::default(), vec![scene.targets[1].clone()])).unwrap();
        for (i, frame) in frames(&scene).unwrap().iter().enumerate() {
            let offset = scene.motion.offset(i as f64 / 64.0);
            let (moved, running) = frame.split_at(still.len());
            for (focus, still) in moved.iter().zip(&still) {
                assert!(!focus.is_separate() && focus.position.distance(still.position + offset) < 1e-12);
            }
            assert!(running.len() == 2 && running.iter().all(|focus| focus.is_separate()));
            assert!((running[0].position + running[1].position - 2.0 * at).length() < 1e-12, "frame {i}");
            assert!((running[0].position.distance(at) - 0.01).abs() < 1e-12);
        }
    }

    #[test]
    fn own_motions_that_cannot_be_are_refused_where_they_stand() {
        let at = DVec3::new(0.0, 0.0, 0.005);
        let (point, ring) = (Shape::Point { at }, Shape::Circle { at, radius: 0.004 });
        let line = Shape::Line { from: at, to: at + DVec3::X };
        let with = |own: Motion, shape: &Shape| {
            let target = Target { motion: Some(own), ..Target::new(shape.clone()) };
            of(motion(MotionPath::Circle), vec![Target::new(point.clone()), target])
        };
        let outline = |tempo, foci| Motion { tempo, foci, ..motion(MotionPath::Outline) };
        let speed = Tempo::Speed(6.0);
        let mut upright = with(outline(speed, 1), &Shape::Circle { at, radius: 0.0051 });
        upright.targets[1].normal = DVec3::X;
        upright.targets[1].angle = 0.3;
        let mut standing = with(motion(MotionPath::Points), &ring);
        standing.targets[1].motion.as_mut().unwrap().points = vec![DVec3::X];
        standing.targets[1].motion.as_mut().unwrap().tempo = speed;
        let own = |key: &str| format!("target[2].motion.{key}");
        for (scene, key, part) in [
            (with(outline(speed, 1), &point), own("path"), "no outline"),
            (of(outline(speed, 1), vec![Target::new(point.clone())]), "motion.path".to_owned(), "no outline"),
            (with(outline(Tempo::Speed(1e5), 1), &ring), own("speed"), "cycles per second"),
            (with(outline(Tempo::Rate(108.0), 1), &ring), own("rate"), "22 rounds in one cycle of 64 frames"),
            (with(outline(Tempo::Speed(120.0), 1), &line), own("speed"), "rounds in one cycle"),
            (standing, own("speed"), "no length"),
            (with(outline(speed, 1024), &line), own("foci"), "a frame has 1025"),
            (with(motion(MotionPath::Points), &point), own("points"), "in frame 44 of 64"),
        ] {
            let error = check(&scene).unwrap_err();
            assert!(error.key() == key && error.message.contains(part), "{key}: {error}");
        }
        let error = check(&upright).unwrap_err();
        assert!(error.key().starts_with("target[2]"), "{error}");
        assert!(error.message.contains("on or behind the array"), "{error}");
        check(&with(outline(Tempo::Rate(105.0), 1), &ring)).unwrap();
    }

    #[test]
    fn what_does_not_go_together_is_refused() {
        let at = [DVec3::new(0.0, 0.0, 0.005), DVec3::new(0.02, 0.0, 0.1)];
        let stepped = |steps: [Option<u32>; 2], frames: u32| {
            let mut scene = scene(Motion { frames, ..motion(MotionPath::Steps) }, &at);
            (scene.targets[0].step, scene.targets[1].step) = (steps[0], steps[1]);
            scene
        };
        let mut stray = scene(motion(MotionPath::Circle), &at);
        stray.targets[1].step = Some(0);
        let circle = |frames| scene(Motion { frames, ..motion(MotionPath::Circle) }, &at);
        for (scene, key, part) in [
            (stray, "target[2].step", "path = \"steps\""),
            (stepped([None, None], 4), "motion.path", "`step = 0`"),
            (stepped([Some(0), Some(2)], 4), "motion.path", "`step = 1`"),
            (stepped([Some(0), Some(u32::MAX)], 4), "motion.path", "`step = 1`"),
            (stepped([Some(0), Some(1)], 1), "motion.frames", "2 steps"),
            (circle(1_000_000), "motion.frames", "1000000 frames of 256 elements and 2 foci need 10.3 GiB"),
            (circle(u32::MAX), "motion.frames", "take up to 97"),
            (scene(motion(MotionPath::Points), &at), "motion.points", "in frame 44 of 64"),
        ] {
            let error = check(&scene).unwrap_err();
            assert!(error.key() == key && error.message.contains(part), "{error}");
        }
        check(&circle(90_000)).unwrap();
    }
}
