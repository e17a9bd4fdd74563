//! What a hand feels of a scene: levels over the threshold of feeling by channel, along strokes and at speeds; and a modulation for
//! steady sound, which is hardly felt.
//!
//! Below 80 Hz the most that is felt at one place counts. From 80 Hz on feeling adds up over the skin, by 3 dB per doubled area:
//! L = 10 log₁₀(∫ Σ (aₙ/thresholdₙ)² dA / 2.9 cm²) over the palm, a disc of 60 mm radius where it feels most; 2.9 cm² is the contact
//! that thresholds are measured with.
//!
//! Two points at rest feel as one below 15 mm, and as two at 32 mm on average (Howard et al. 2023). A focus in slow circles is felt as
//! even pressure if it is moved by less than 1 mm at a time (Morisaki et al. 2022). The displacement of a path grows with the speed of
//! the focus up to about 1.1 times that of surface waves (Frier et al. 2018).

use std::f64::consts::TAU;
use std::fmt;

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use serde_json::{Value, json};

use crate::device::profile::Profile;
use crate::device::stock::{self, Modulated};
use crate::drive::Drive;
use crate::field::cells::Cells;
use crate::field::{Evaluator, FieldError, Quantity, Request, SkinMotion, Stages};
use crate::rounding::millimetres;
use crate::scene::{
    Channel, Envelope, Focus, Liquid, Modulation, MotionPath, Part, Plane, Scene, Skin, SpectralLine, Target,
    Tempo, UNCERTAINTY, motion, outline,
};
use crate::solver::frames::{self, Sequence};
use crate::solver::{Solution, SolveError};

/// Hz; skin is most sensitive near it.
const FREQUENCY: f64 = 200.0;
/// Cycles per second from which a moving focus is felt without a modulation.
const FLUTTER: f64 = 20.0;
/// Level (dB) of what is not felt at all.
pub const FLOOR: f64 = -100.0;
/// Hz from which feeling adds up over the skin.
const SUMMED: f64 = 80.0;
/// m, radius of the palm.
const PALM: f64 = 0.06;
/// m², of the contact of thresholds.
const CONTACT: f64 = 2.9e-4;
/// Samples of a stroke per wavelength, and their limit in a drawing.
const PER_WAVELENGTH: f64 = 8.0;
const MOST_SAMPLES: f64 = 8192.0;
/// Vertices of the path of a moving target.
const VERTICES: u32 = 256;
/// Distance from the plane, in wavelengths, of what is still felt on it.
const NEAR: f64 = 0.5;
/// m; two points feel as one below the first, and as two on average at the second.
const ONE: f64 = 0.015;
const TWO: f64 = 0.032;
/// m, between frames, of motions that are felt as pressure.
const SMOOTH: f64 = 1e-3;
/// Of a wavelength, between frames of faster motions: neighbouring foci overlap.
const APART: f64 = 0.5;
/// Speeds that are tried, relative to that of surface waves: the first, the step to slower and faster ones, and how often a step is
/// made towards the maximum.
const MIDDLE: f64 = 1.1;
const FASTER: f64 = 0.15;
const MOVES: usize = 4;
/// Instants of a cycle, and places, at which displacements are compared.
const INSTANTS: usize = 256;
const PLACES: usize = 16;

/// What is felt on the scene's plane, with the skin of the scene or the default one. Levels are dB over threshold, at least
/// [`FLOOR`].
#[derive(Clone, Debug, PartialEq)]
pub struct Felt {
    /// The largest of all channels.
    pub level: f64,
    /// Below 20 Hz.
    pub pressure: f64,
    /// 20 to 60 Hz.
    pub flutter: f64,
    /// Above 60 Hz.
    pub vibration: f64,
    /// The place (m) of the largest local level; `None` where nothing moves.
    pub position: Option<DVec3>,
    /// The drawn strokes on the plane, and paths of moving points.
    pub strokes: Vec<Stroke>,
    /// Part of their length that is over threshold; `None` without strokes.
    pub share: Option<f64>,
    /// Of a motion along a path.
    pub speeds: Option<Speeds>,
}

/// A stroke on the skin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stroke {
    /// The index of its target.
    pub target: usize,
    /// The largest local level along it, dB over threshold.
    pub level: f64,
}

/// Speeds along a path, m/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Speeds {
    pub own: f64,
    /// At which the skin moves most.
    pub best: f64,
}

/// Reasons for not knowing what is felt.
#[derive(Debug, thiserror::Error)]
pub enum Unknown {
    #[error(transparent)]
    Solve(#[from] SolveError),
    #[error(transparent)]
    Field(#[from] FieldError),
}

/// The drives of all frames.
pub fn drives(sequence: &Sequence) -> Vec<Drive> {
    sequence.frames.iter().map(|frame| frame.drive.clone()).collect()
}

impl Felt {
    /// Of all frames of a motion, or of drives in turn; without speeds.
    ///
    /// # Errors
    /// The errors of [`Stages::skin`].
    pub fn new(scene: &Scene, drives: Vec<Drive>, stages: &mut Stages) -> Result<Self, FieldError> {
        let skin = scene.skin.clone().unwrap_or_default();
        let motion = stages.skin(&request(scene, drives))?;
        let strokes = strokes(scene);
        Ok(Self::of_motion(scene, &skin, motion, &strokes))
    }

    /// The same with speeds, from a solution and its stages.
    ///
    /// # Errors
    /// The errors of [`Self::new`].
    pub fn with_speeds(scene: &Scene, drives: &[Drive], stages: &mut Stages) -> Result<Self, FieldError> {
        let felt = Self::new(scene, drives.to_vec(), stages)?;
        Ok(Self { speeds: Speeds::new(scene, drives, stages)?, ..felt })
    }

    /// The same of a solution that stands alone.
    ///
    /// # Errors
    /// The errors of [`frames::follow`] and [`Self::new`].
    pub fn of_solution(scene: &Scene, solution: &Solution) -> Result<Self, Unknown> {
        let drives = if motion::moves(scene) { drives(&frames::follow(scene)?) } else { solution.drives() };
        Ok(Self::with_speeds(scene, &drives, &mut Stages::new(Evaluator::Cpu))?)
    }

    /// The same of all frames, if the scene has a skin.
    pub fn of_sequence(scene: &Scene, sequence: &Sequence) -> Option<Result<Self, FieldError>> {
        scene.skin.as_ref()?;
        Some(Self::with_speeds(scene, &drives(sequence), &mut Stages::new(Evaluator::Cpu)))
    }

    fn of_motion(scene: &Scene, skin: &Skin, motion: &SkinMotion, strokes: &[(usize, Vec<DVec3>)]) -> Self {
        let peak = |felt: &dyn Fn(f64) -> bool| Peak::new(&scene.plane, skin, motion, felt);
        let power = |felt: &dyn Fn(f64) -> bool| peak(felt).map_or(0.0, |peak| peak.power);
        let vibration =
            power(&|f| Channel::Vibration.contains(f) && f < SUMMED).max(summed(&scene.plane, skin, motion));
        let [pressure, flutter] =
            [Channel::Pressure, Channel::Flutter].map(|channel| power(&|f| channel.contains(f)));
        let along = Along::new(scene, skin, motion, strokes);
        let place = peak(&|_| true).filter(|peak| level(peak.power) > FLOOR);
        Self {
            level: level(pressure.max(flutter).max(vibration)),
            pressure: level(pressure),
            flutter: level(flutter),
            vibration: level(vibration),
            position: place.and_then(|peak| point(&scene.plane, peak.place)),
            strokes: along.strokes,
            share: (along.length > 0.0).then(|| along.felt / along.length),
            speeds: None,
        }
    }

    /// The object that other programs know.
    pub fn json(&self) -> Value {
        let stroke = |stroke: &Stroke| json!({ "target": stroke.target, "level": stroke.level });
        let [absolute, differences] = UNCERTAINTY;
        let mut value = json!({
            "level": self.level,
            "pressure": self.pressure,
            "flutter": self.flutter,
            "vibration": self.vibration,
            "position": self.position.map(|at| at.to_array()),
            "uncertainty": { "level": absolute, "difference": differences },
        });
        if let Some(share) = self.share {
            value["strokes"] = self.strokes.iter().map(stroke).collect();
            value["share"] = json!(share);
        }
        if let Some(Speeds { own, best }) = self.speeds {
            value["speed"] = json!(own);
            value["best_speed"] = json!(best);
        }
        value
    }

    /// Labels and values, a row each.
    pub fn rows(&self) -> Vec<(&'static str, String)> {
        let [absolute, differences] = UNCERTAINTY;
        let place = match self.position {
            Some(at) => {
                let [x, y, z] = at.to_array().map(|coordinate| millimetres(coordinate, 1));
                format!(", most at ({x}, {y}, {z}) mm")
            }
            None => String::new(),
        };
        let channels =
            [("pressure", self.pressure), ("flutter", self.flutter), ("vibration", self.vibration)];
        let channels: Vec<_> =
            channels.iter().map(|(name, level)| format!("{name} {}", decibels(*level))).collect();
        let mut rows = vec![
            ("felt", format!("{} over threshold, ± {absolute:.0} dB{place}", decibels(self.level))),
            ("felt as", format!("{}; ± {differences:.0} dB relative to each other", channels.join(", "))),
        ];
        if let Some(share) = self.share {
            let levels = self.strokes.iter().map(|stroke| stroke.level);
            let [least, most] =
                [levels.clone().fold(f64::INFINITY, f64::min), levels.fold(FLOOR, f64::max)].map(decibels);
            let strokes = match self.strokes.len() {
                1 => format!("at most {most}"),
                count => format!("{count} strokes at {least} to {most}"),
            };
            rows.push(("felt along", format!("{:.0} % of what is drawn; {strokes}", 100.0 * share)));
        }
        if let Some(Speeds { own, best }) = self.speeds {
            rows.push((
                "best speed",
                format!("{best:.1} m/s moves the skin most along this path, which runs at {own:.1} m/s"),
            ));
        }
        rows
    }

    /// Warnings about a scene with these foci, a sentence each.
    pub fn warnings(&self, scene: &Scene, foci: &[Focus]) -> Vec<String> {
        let native = Profile::Native;
        let steady = || Offer::new(scene, motion::moves(scene), native, native.baud());
        let weak = (self.level < 0.0).then(|| match steady() {
            Some(offer) => offer.to_string(),
            None if self.level == FLOOR => "steady sound is hardly felt".to_owned(),
            None => format!(
                "the scene is hardly felt: {} over threshold, ± {:.0} dB",
                decibels(self.level),
                UNCERTAINTY[0]
            ),
        });
        weak.into_iter().chain(merged(scene, foci)).chain(coarse(scene)).collect()
    }
}

/// Rows and reasons of what is felt, for people; none without a skin.
pub fn rows<E: fmt::Display>(felt: Option<&Result<Felt, E>>) -> Vec<(&'static str, String)> {
    match felt {
        None => Vec::new(),
        Some(Ok(felt)) => felt.rows(),
        Some(Err(why)) => vec![("felt", format!("-, {why}"))],
    }
}

/// dB over threshold.
fn level(power: f64) -> f64 {
    (10.0 * power.log10()).max(FLOOR)
}

fn decibels(level: f64) -> String {
    if level > FLOOR { format!("{level:.0} dB") } else { "-".to_owned() }
}

fn request(scene: &Scene, drives: Vec<Drive>) -> Request {
    // Cells of the plane, whatever the pixels.
    Request::new(scene, drives, Quantity::Felt, (1, 1))
}

/// The weight of a squared amplitude (m, peak) at a frequency, Hz.
fn weight(skin: &Skin, frequency: f64) -> f64 {
    skin.threshold_at(frequency).powi(-2)
}

/// A point of a plane, from m along its axes.
fn point(plane: &Plane, place: DVec2) -> Option<DVec3> {
    let (x, y) = plane.axes()?;
    Some(plane.centre + x * place.x + y * place.y)
}

/// The place (m along the plane's axes, from its centre) where most is felt.
struct Peak {
    place: DVec2,
    power: f64,
}

impl Peak {
    fn new(plane: &Plane, skin: &Skin, motion: &SkinMotion, felt: &dyn Fn(f64) -> bool) -> Option<Self> {
        let (cells, values) =
            motion.powers(|frequency| if felt(frequency) { weight(skin, frequency) } else { 0.0 })?;
        let [columns, rows] = ranges(plane, cells);
        let indices = rows.flat_map(|row| columns.clone().map(move |column| [column, row]));
        let value = |[column, row]: [usize; 2]| values[row * cells.counts[0] + column];
        let most = indices.max_by(|a, b| value(*a).total_cmp(&value(*b))).filter(|&at| value(at) > 0.0)?;
        // Near its peak a power falls like a Gaussian.
        let vertex = |axis: usize| {
            let beside = |step: isize| {
                let mut at = most;
                at[axis] = most[axis].checked_add_signed(step).filter(|i| *i < cells.counts[axis])?;
                Some(value(at).ln())
            };
            let (before, here, after) = (beside(-1)?, value(most).ln(), beside(1)?);
            let bend = before - 2.0 * here + after;
            (bend < 0.0).then(|| (0.5 * (before - after) / bend).clamp(-0.5, 0.5))
        };
        let place = |axis: usize| {
            let centre = cells.places(axis).nth(most[axis]).unwrap_or(0.0);
            let half = plane.size[axis] / 2.0;
            (centre + cells.step * vertex(axis).unwrap_or(0.0)).clamp(-half, half)
        };
        let place = DVec2::new(place(0), place(1));
        let power = skin.felt(motion.at(&[place]).concat().iter().filter(|line| felt(line.frequency)));
        Some(Self { place, power })
    }
}

/// The columns and rows of cells whose centres are on the plane; the nearest one at least.
fn ranges(plane: &Plane, cells: &Cells) -> [std::ops::Range<usize>; 2] {
    [0, 1].map(|axis| {
        let half = plane.size[axis] / 2.0;
        let middle = cells.counts[axis] / 2;
        let within: Vec<_> =
            cells.places(axis).enumerate().filter(|(_, at)| at.abs() <= half).map(|(i, _)| i).collect();
        match (within.first(), within.last()) {
            (Some(first), Some(last)) => *first..last + 1,
            (None, _) | (_, None) => middle..middle + 1,
        }
    })
}

/// The power from 80 Hz on that the palm feels where it feels most.
fn summed(plane: &Plane, skin: &Skin, motion: &SkinMotion) -> f64 {
    let of_line = |frequency: f64| if frequency < SUMMED { 0.0 } else { weight(skin, frequency) };
    let Some((cells, values)) = motion.powers(of_line) else { return 0.0 };
    let [columns, rows] = ranges(plane, cells);
    let width = columns.len();
    // Of every row the sums of the first cells: a piece of it is a difference.
    let sums: Vec<Vec<f64>> = rows
        .map(|row| {
            let mut sum = 0.0;
            let after = |value: &f64| {
                sum += value;
                sum
            };
            let row = &values[row * cells.counts[0]..][columns.clone()];
            std::iter::once(0.0).chain(row.iter().map(after)).collect()
        })
        .collect();
    let reach = (PALM / cells.step) as usize;
    let half_widths: Vec<_> = (0..=reach)
        .map(|up| ((PALM.powi(2) - (up as f64 * cells.step).powi(2)).max(0.0).sqrt() / cells.step) as usize)
        .collect();
    let of_palm = |row: usize, column: usize| -> f64 {
        let around = row.saturating_sub(reach)..(row + reach + 1).min(sums.len());
        let of_row = |other: usize| {
            let half = half_widths[other.abs_diff(row)];
            sums[other][(column + half + 1).min(width)] - sums[other][column.saturating_sub(half)]
        };
        around.map(of_row).sum()
    };
    let best = |row: usize| (0..width).map(|column| of_palm(row, column)).fold(0.0, f64::max);
    let most = (0..sums.len()).into_par_iter().map(best).reduce(|| 0.0, f64::max);
    most * cells.step.powi(2) / CONTACT
}

/// The strokes of targets at rest, with the indices of these, and the paths of points that move.
fn strokes(scene: &Scene) -> Vec<(usize, Vec<DVec3>)> {
    let shown = scene.targets.iter().enumerate().filter(|(_, target)| target.visible);
    let of_target = |(index, target): (usize, &Target)| {
        let motion = target.motion.as_ref().unwrap_or(&scene.motion);
        let is_at_rest = matches!(motion.path, MotionPath::None | MotionPath::Outline | MotionPath::Steps);
        let shape = &target.shape;
        let strokes = match (is_at_rest, shape.is_point()) {
            (true, true) | (false, false) => Vec::new(),
            (true, false) if target.is_area() || shape.is_picture() || shape.is_trap() => Vec::new(),
            (true, false) => outline::strokes(target).unwrap_or_default(),
            (false, true) => {
                let part = |n: u32| f64::from(n % VERTICES) / f64::from(VERTICES);
                let at = |n: u32| outline::centre(shape) + motion::pose_of(scene, index, part(n)).at;
                vec![(0..=VERTICES).map(at).collect()]
            }
        };
        strokes.into_iter().map(move |stroke| (index, stroke))
    };
    shown.flat_map(of_target).collect()
}

/// A piece of a stroke on the plane.
#[derive(Clone, Copy, Debug)]
struct Piece {
    /// m along the plane's axes, from its centre.
    place: DVec2,
    /// m
    length: f64,
}

/// The pieces of a stroke that lie on a plane, about `step` (m) long.
fn pieces(plane: &Plane, (step, near): (f64, f64), stroke: &[DVec3]) -> Vec<Piece> {
    let Some((x, y)) = plane.axes() else { return Vec::new() };
    let of_segment = |ends: &[DVec3]| {
        let (from, to) = (ends[0], ends[1]);
        let length = from.distance(to);
        let count = (length / step).ceil() as u32;
        (0..count).map(move |n| {
            let part = (f64::from(n) + 0.5) / f64::from(count);
            (from.lerp(to, part) - plane.centre, length / f64::from(count))
        })
    };
    let on_plane = |(offset, length): (DVec3, f64)| {
        let place = DVec2::new(offset.dot(x), offset.dot(y));
        let is_on = offset.dot(x.cross(y)).abs() <= near && (place.abs().cmple(plane.size / 2.0)).all();
        is_on.then_some(Piece { place, length })
    };
    stroke.windows(2).flat_map(of_segment).filter_map(on_plane).collect()
}

/// Pieces of all strokes, of a length that keeps their number in bounds.
fn all_pieces(scene: &Scene, strokes: &[(usize, Vec<DVec3>)]) -> Vec<(usize, Vec<Piece>)> {
    let wavelength = scene.wavelength();
    let length = |stroke: &[DVec3]| stroke.windows(2).map(|ends| ends[0].distance(ends[1])).sum::<f64>();
    let whole: f64 = strokes.iter().map(|(_, stroke)| length(stroke)).sum();
    let step = (wavelength / PER_WAVELENGTH).max(whole / MOST_SAMPLES);
    let sizes = (step, NEAR * wavelength);
    let all = strokes.iter().map(|(target, stroke)| (*target, pieces(&scene.plane, sizes, stroke)));
    all.filter(|(_, pieces)| !pieces.is_empty()).collect()
}

/// What is felt along strokes.
struct Along {
    strokes: Vec<Stroke>,
    /// m
    length: f64,
    /// m, over threshold.
    felt: f64,
}

impl Along {
    fn new(scene: &Scene, skin: &Skin, motion: &SkinMotion, strokes: &[(usize, Vec<DVec3>)]) -> Self {
        let mut along = Self { strokes: Vec::new(), length: 0.0, felt: 0.0 };
        for (target, pieces) in all_pieces(scene, strokes) {
            let places: Vec<_> = pieces.iter().map(|piece| piece.place).collect();
            let powers: Vec<_> = motion.at(&places).iter().map(|lines| skin.felt(lines)).collect();
            for (piece, power) in pieces.iter().zip(&powers) {
                along.length += piece.length;
                along.felt += if *power >= 1.0 { piece.length } else { 0.0 };
            }
            let most = powers.into_iter().fold(0.0, f64::max);
            along.strokes.push(Stroke { target, level: level(most) });
        }
        along
    }
}

impl Speeds {
    /// Of foci along the scene's path, or that of its slowest target: at which speed of elements that follow at once the skin is
    /// displaced most, from peak to peak on the path. `None` without a path on the plane, or a maximum near the speed of surface waves.
    fn new(scene: &Scene, drives: &[Drive], stages: &mut Stages) -> Result<Option<Self>, FieldError> {
        let Some(cycle) = motion::cycle(scene).filter(|_| !scene.drive.is_named()) else { return Ok(None) };
        let Some(leader) = cycle.groups.get(cycle.leader).filter(|group| group.length > 0.0) else {
            return Ok(None);
        };
        let pieces: Vec<_> =
            all_pieces(scene, &strokes(scene)).into_iter().flat_map(|(_, pieces)| pieces).collect();
        let every = pieces.len().div_ceil(PLACES).max(1);
        let places: Vec<_> = pieces.iter().step_by(every).map(|piece| piece.place).collect();
        if places.is_empty() {
            return Ok(None);
        }
        let skin = scene.skin.clone().unwrap_or_default();
        let mut swing = |speed: f64| -> Result<f64, FieldError> {
            let mut played = scene.clone();
            played.array.response = None;
            played.modulations_mut().for_each(|(_, modulation)| *modulation = Modulation::default());
            let factor = speed / (leader.length * cycle.rate);
            let own = played.targets.iter_mut().filter_map(|target| target.motion.as_mut());
            for motion in own.chain([&mut played.motion]) {
                motion.tempo = match motion.tempo {
                    Tempo::Own => motion.rate(0.0).map_or(Tempo::Own, |rate| Tempo::Rate(rate * factor)),
                    Tempo::Rate(rate) => Tempo::Rate(rate * factor),
                    Tempo::Speed(speed) => Tempo::Speed(speed * factor),
                };
            }
            let motion = stages.skin(&request(&played, drives.to_vec()))?;
            let rate = cycle.rate * factor;
            Ok(motion.at(&places).iter().map(|lines| swing_of(lines, rate)).sum())
        };
        let step = FASTER * skin.wave_speed;
        let mut middle = MIDDLE * skin.wave_speed;
        let mut swings = [swing(middle - step)?, swing(middle)?, swing(middle + step)?];
        for _ in 0..MOVES {
            let [before, here, after] = swings;
            if here >= before && here >= after {
                let offset = 0.5 * (before - after) / (before - 2.0 * here + after);
                let speeds = Self { own: leader.length * cycle.rate, best: middle + step * offset };
                return Ok(Some(speeds).filter(|_| offset.is_finite()));
            }
            if after > before {
                middle += step;
                swings = [here, after, swing(middle + step)?];
            } else {
                middle -= step;
                swings = [swing(middle - step)?, before, here];
            }
        }
        Ok(None)
    }
}

/// Displacement (m) from peak to peak of lines of a cycle.
fn swing_of(lines: &[SpectralLine], cycle: f64) -> f64 {
    let moving: Vec<_> = lines.iter().filter(|line| line.frequency > 0.0).collect();
    let at = |instant: usize| -> f64 {
        let time = instant as f64 / (cycle * INSTANTS as f64);
        let value = |line: &&SpectralLine| line.amplitude * (TAU * line.frequency * time + line.phase).cos();
        moving.iter().map(value).sum()
    };
    let (least, most) = (0..INSTANTS)
        .map(at)
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), u| (least.min(u), most.max(u)));
    most - least
}

/// Two separate points at rest that are too close to be felt as two.
fn merged(scene: &Scene, foci: &[Focus]) -> Option<String> {
    if motion::moves(scene) {
        return None;
    }
    let separate: Vec<_> = foci.iter().filter(|focus| focus.is_separate()).collect();
    let points = separate.iter().enumerate().filter(|(_, focus)| focus.part == Part::Point);
    let pairs = points.clone().flat_map(|(a, one)| {
        let others = points.clone().skip_while(move |(b, _)| *b <= a);
        others.map(move |(b, other)| (a, b, one.position.distance(other.position)))
    });
    let (a, b, distance) = pairs.min_by(|x, y| x.2.total_cmp(&y.2))?;
    let how = match distance {
        distance if distance < ONE => "merge and are felt as one point",
        distance if distance < TWO => "may be felt as one point",
        _ => return None,
    };
    Some(format!(
        "foci {} and {}, {} mm apart, {how}: two points are felt as one below {} mm, and as two from {} mm on \
         (mean; Howard et al. 2023)",
        a + 1,
        b + 1,
        millimetres(distance, 1),
        millimetres(ONE, 0),
        millimetres(TWO, 0)
    ))
}

/// A motion whose steps are felt.
fn coarse(scene: &Scene) -> Option<String> {
    let cycle = motion::cycle(scene).filter(|_| !scene.drive.is_named())?;
    let longest = cycle.groups.iter().filter(|group| group.length > 0.0).map(|group| {
        let step = group.length * group.rounds as f64 / f64::from(cycle.frames);
        let most = if cycle.played(group) < FLUTTER { SMOOTH } else { APART * scene.wavelength() };
        (step, most)
    });
    let (step, most) = longest.max_by(|a, b| (a.0 / a.1).total_cmp(&(b.0 / b.1)))?;
    (step > most).then(|| {
        let frames = (f64::from(cycle.frames) * step / most).ceil();
        let how = if most == SMOOTH { "slow motions feel smooth" } else { "a path is felt as a line" };
        format!(
            "the focus moves by {} mm from frame to frame: {how} below {} mm, motion.frames = {frames}",
            millimetres(step, 1),
            millimetres(most, 1)
        )
    })
}

/// A modulation that makes a scene felt on a board.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Offer {
    /// Hz
    pub frequency: f64,
    profile: Profile,
    /// Bits per second, if the board's line is too slow for more.
    slow: Option<u32>,
}

impl Offer {
    /// For a scene at rest, or in motion, on a board at a bit rate; `None` if it is felt, or not for a hand.
    pub fn new(scene: &Scene, moves: bool, profile: Profile, baud: u32) -> Option<Self> {
        let flutters = moves && motion::cycle(scene).is_some_and(|cycle| cycle.rate >= FLUTTER);
        if !scene.envelope().is_steady() || scene.has_own_envelopes() || flutters || !is_for_a_hand(scene) {
            return None;
        }
        let asked = Modulation { shape: Envelope::Sine, frequency: FREQUENCY, ..Modulation::default() };
        let fastest = match profile.answers() {
            true => None,
            false => match stock::modulated(profile, &asked, baud) {
                // It modulates all that it plays.
                Modulated::ByBoard(..) => return None,
                Modulated::Never(fastest) => Some(fastest),
                Modulated::Steady | Modulated::FromHere(_) | Modulated::OneFrequency => None,
            },
        };
        let frequency = fastest.map_or(FREQUENCY, |fastest| fastest.floor().max(1.0));
        Some(Self { frequency, profile, slow: fastest.map(|_| baud) })
    }

    /// The same modulation with this waveform.
    pub fn of(self, modulation: &Modulation) -> Modulation {
        Modulation { shape: Envelope::Sine, frequency: self.frequency, depth: 1.0, ..modulation.clone() }
    }

    /// Reason for the board's limit, as text.
    pub fn limit(self) -> Option<String> {
        let baud = self.slow?;
        let (name, frequency) = (self.profile.name(), self.frequency);
        Some(format!("{name} is switched on and off at most {frequency} times a second at {baud} baud"))
    }
}

impl fmt::Display for Offer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { frequency, .. } = self;
        write!(f, "steady sound is hardly felt: [modulation] shape = \"sine\", frequency = {frequency:?} ")?;
        match self.limit() {
            None => f.write_str("makes it felt"),
            Some(limit) => write!(f, "makes it felt a little; {limit}"),
        }
    }
}

/// A scene with a liquid or a trap is for them, and so is the standing wave between opposed boards.
pub fn is_for_a_hand(scene: &Scene) -> bool {
    let mut visible = scene.targets.iter().filter(|target| target.visible).peekable();
    let is_liquid = scene.liquid != Liquid::default() || scene.aims_at_depression();
    let mut boards = scene.boards.iter();
    let are_opposed =
        boards.next().is_some_and(|first| boards.any(|board| board.normal.dot(first.normal) < 0.0));
    visible.peek().is_some() && !visible.any(|target| target.shape.is_trap()) && !is_liquid && !are_opposed
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::studio::opening;

    fn offer(text: &str, profile: Profile) -> Option<Offer> {
        let scene = opening::parse(&format!("format = 1\n{text}"), "a.toml".as_ref()).unwrap();
        Offer::new(&scene, true, profile, profile.baud())
    }

    #[test]
    fn a_steady_scene_for_a_hand_is_offered_200_hz() {
        let steady = [
            "[[target]]\n",
            "[[target]]\n[modulation]\nshape = \"sine\"\ndepth = 0.0\n",
            "[[target]]\n[motion]\npath = \"circle\"\nrate = 5.0\n",
            "[[target]]\n[[target]]\nkind = \"trap\"\nvisible = false\n",
        ];
        for text in steady {
            assert_eq!(offer(text, Profile::SonicSurfaceTactile), None, "it modulates by itself");
            let others = [Profile::SonicSurfaceTactile, Profile::Acoustophoretic512];
            for profile in Profile::choices().filter(|profile| !others.contains(profile)) {
                let offer = offer(text, profile).unwrap_or_else(|| panic!("{text} on {}", profile.name()));
                assert_eq!((offer.frequency, offer.limit()), (200.0, None), "{text}");
            }
        }
        let others = [
            "",
            "[[target]]\nvisible = false\n",
            "[[target]]\n[modulation]\nshape = \"square\"\nfrequency = 40.0\n",
            "[[target]]\n[motion]\npath = \"circle\"\nrate = 50.0\n",
            "[[target]]\n[liquid]\nname = \"water\"\n",
            "[[target]]\n[liquid]\ndepth = 0.01\n",
            "[[target]]\nkind = \"circle\"\n[solver]\ntarget = \"depression\"\n",
            "[[target]]\nkind = \"trap\"\n",
            "[[target]]\n[[board]]\n[[board]]\nat = [0, 0, 0.2]\nnormal = [0, 0, -1]\n",
        ];
        for text in others {
            assert_eq!(offer(text, Profile::Native), None, "{text}");
        }
    }

    #[test]
    fn a_slow_board_is_offered_what_it_can_play() {
        let profile = Profile::Acoustophoretic512;
        let offer = offer("[[target]]\n", profile).unwrap();
        let played = stock::modulated(profile, &offer.of(&Modulation::default()), profile.baud());
        assert_eq!(played, Modulated::FromHere(24.0));
        assert_eq!(
            offer.to_string(),
            "steady sound is hardly felt: [modulation] shape = \"sine\", frequency = 24.0 makes it felt a little; \
             acoustophoretic-512 is switched on and off at most 24 times a second at 250000 baud"
        );
    }
}
