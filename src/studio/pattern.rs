//! The beam pattern: the level of the far field against the angle, with its lobes, in f64.
//!
//! A cut is a half circle of directions d = n cos θ + (x cos φ + y sin φ) sin θ at an azimuth φ, θ from -90° to 90°, with the axes x, y and the normal n of the first board. The level is 20 lg |F(θ)|/|F| relative to the largest |F| of
//! all cuts; of several drives in turn, |F|² is the mean square. A lobe is a maximum of |F|² and lies at a root of its
//! derivative, a null or the dip between two lobes likewise; the width of the main lobe is between the two points around
//! it at which |F|² is a half (half power, -3.01 dB) or a quarter (half pressure, -6.02 dB) of its maximum.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::fmt::Write as _;

use glam::{DVec2, DVec3};
use num_complex::Complex64;
use rayon::prelude::*;
use serde_json::{Value, json};

use crate::acoustics::Aperture;
use crate::drive::Drive;
use crate::picture::figure::Axis;
use crate::picture::figure::axes::signed;
use crate::picture::figure::curve::Curve;
use crate::picture::figure::page::Plot;
use crate::picture::figure::polar::Polar;
use crate::scene::{Focus, Scene};
use crate::studio::width::root;

/// Angles of a table of levels, from -90° to 90°: steps of 0.1°.
pub const ANGLES: usize = 1801;
/// dB: lower levels are numerical noise.
pub const LOWEST: f64 = -300.0;
/// Of the largest power: smaller differences are rounding.
const NOISE: f64 = 1e-13;
/// dB: the lowest level of a chart.
pub const FLOOR: f64 = -40.0;
/// rad: a beam nearer to a plane is in it.
const IN_PLANE: f64 = 1e-3;
/// rad, of roots.
const ERROR: f64 = 1e-14;

/// The pattern in some cuts.
#[derive(Clone, Debug, PartialEq)]
pub struct Pattern {
    pub cuts: Vec<Cut>,
}

/// The pattern on a half circle of directions.
#[derive(Clone, Debug, PartialEq)]
pub struct Cut {
    /// rad, from x to y.
    pub azimuth: f64,
    /// dB at [`ANGLES`] angles.
    pub levels: Vec<f64>,
    /// `None` where no sound goes.
    pub main: Option<MainLobe>,
    /// The other maxima by their angle.
    pub side_lobes: Vec<Extremum>,
}

/// A maximum or a minimum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extremum {
    /// rad from the normal.
    pub angle: f64,
    /// dB
    pub level: f64,
}

/// The largest lobe of a cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MainLobe {
    pub top: Extremum,
    /// rad: its ends at half the power, and at half the pressure; `None` if it does not fall so far on both sides.
    pub half_power: Option<[f64; 2]>,
    pub half_pressure: Option<[f64; 2]>,
    /// The first minimum on either side.
    pub nulls: [Option<Extremum>; 2],
}

impl MainLobe {
    /// rad
    pub fn half_power_width(&self) -> Option<f64> {
        self.half_power.map(|[low, high]| high - low)
    }

    /// rad
    pub fn half_pressure_width(&self) -> Option<f64> {
        self.half_pressure.map(|[low, high]| high - low)
    }
}

/// The far field of drives in turn.
struct Beam<'a> {
    aperture: &'a Aperture,
    /// u per drive and driven element.
    played: Vec<Vec<Complex64>>,
    /// x, y and the normal.
    axes: [DVec3; 3],
    /// The largest phase (rad) between the middle and an element.
    reach: f64,
}

impl<'a> Beam<'a> {
    fn new(scene: &Scene, aperture: &'a Aperture, drives: &[Drive]) -> Self {
        let board = scene.standing().into_iter().next().unwrap_or_default();
        let axes = board
            .axes()
            .map_or([DVec3::X, DVec3::Y, DVec3::Z], |axes| axes.to_cols_array_2d().map(DVec3::from));
        let places = || aperture.driven.iter().map(|&n| aperture.positions[n]);
        let middle = places().sum::<DVec3>() / aperture.driven.len().max(1) as f64;
        let farthest = places().map(|at| at.distance(middle)).fold(0.0, f64::max);
        Self {
            aperture,
            played: drives.iter().map(|drive| drive.excitation(&aperture.driven)).collect(),
            axes,
            reach: (aperture.element.wavenumber * farthest).max(1.0),
        }
    }

    /// |F|², mean over the drives; zero behind reflectors.
    fn power_towards(&self, direction: DVec3) -> f64 {
        if self.aperture.mirrors.iter().any(|mirror| mirror.normal.dot(direction) < 0.0) {
            return 0.0;
        }
        let heard = self.aperture.far_field(direction);
        let pressure =
            |u: &Vec<Complex64>| heard.iter().zip(u).map(|(h, u)| h * u).sum::<Complex64>().norm_sqr();
        self.played.iter().map(pressure).sum::<f64>() / self.played.len().max(1) as f64
    }

    fn direction(&self, azimuth: f64, angle: f64) -> DVec3 {
        let ([x, y, normal], flat) = (self.axes, DVec2::from_angle(azimuth));
        normal * angle.cos() + (x * flat.x + y * flat.y) * angle.sin()
    }

    /// |F|² in a cut, continued beyond ±90° as that of a flat array.
    fn power(&self, azimuth: f64, angle: f64) -> f64 {
        let angle = if angle.abs() > FRAC_PI_2 { PI.copysign(angle) - angle } else { angle };
        self.power_towards(self.direction(azimuth, angle))
    }

    /// Its derivative by the angle, by central differences of sixth order.
    fn slope(&self, azimuth: f64, angle: f64) -> f64 {
        /// Of the angle in which the phase of the outermost element turns by 1 rad.
        const STEP: f64 = 0.05;
        let step = STEP / self.reach;
        let pairs = [(1.0, 0.75), (2.0, -0.15), (3.0, 1.0 / 60.0)];
        let difference = |(away, weight): (f64, f64)| {
            let [after, before] =
                [angle + away * step, angle - away * step].map(|at| self.power(azimuth, at));
            weight * (after - before)
        };
        pairs.into_iter().map(difference).sum::<f64>() / step
    }

    /// The azimuth of the loudest direction in front of the array, unless it is within [`IN_PLANE`] of the xz or the yz plane.
    fn oblique_azimuth(&self, foci: &[Focus]) -> Option<f64> {
        /// Transfers between an element and a direction at most, and steps across the main lobe.
        const MOST: f64 = 3e6;
        const PER_LOBE: f64 = 4.0;
        let finest = (MOST / self.aperture.driven.len().max(1) as f64).sqrt();
        let side = (PER_LOBE * self.reach / PI).clamp(16.0, finest.max(16.0)) as usize;
        let [x, y, normal] = self.axes;
        let at =
            |flat: DVec2| x * flat.x + y * flat.y + normal * (1.0 - flat.length_squared()).max(0.0).sqrt();
        let middle = |index: usize| (2 * index + 1) as f64 / side as f64 - 1.0;
        let mut places: Vec<_> = (0..side * side)
            .map(|index| DVec2::new(middle(index % side), middle(index / side)))
            .filter(|flat| flat.length_squared() < 1.0)
            .collect();
        places.push(DVec2::ZERO);
        let towards = |focus: &Focus| focus.position.normalize_or_zero();
        places.extend(foci.iter().map(towards).map(|way| DVec2::new(way.dot(x), way.dot(y))));
        let loudness: Vec<_> = places.par_iter().map(|&flat| self.power_towards(at(flat))).collect();
        let most = (0..places.len()).max_by(|&a, &b| loudness[a].total_cmp(&loudness[b]))?;
        let (mut flat, mut power) = (places[most], loudness[most]);
        // Ascent in steps that halve.
        let mut step = 1.0 / side as f64;
        while step > 1e-7 {
            let ways = [DVec2::X, DVec2::NEG_X, DVec2::Y, DVec2::NEG_Y].map(|way| flat + way * step);
            let next = ways.into_iter().filter(|flat| flat.length_squared() < 1.0);
            let next =
                next.map(|flat| (flat, self.power_towards(at(flat)))).max_by(|a, b| a.1.total_cmp(&b.1));
            match next.filter(|next| next.1 > power) {
                Some(louder) => (flat, power) = louder,
                None => step /= 2.0,
            }
        }
        let is_oblique = flat.abs().min_element() > IN_PLANE;
        // The cut to the right of the normal is the positive one.
        is_oblique.then(|| if flat.x < 0.0 { (-flat).to_angle() } else { flat.to_angle() })
    }

    fn cut(&self, azimuth: f64) -> Sampled {
        /// Samples in a lobe, which is π/reach wide or wider.
        const PER_LOBE: f64 = 12.0;
        let pieces = ANGLES - 1;
        let finer = (PI / pieces as f64 * PER_LOBE * self.reach / PI).ceil().max(1.0) as usize;
        let count = pieces * finer;
        let angle = |index: usize| (index as f64 / count as f64 - 0.5) * PI;
        let powers: Vec<_> =
            (0..=count).into_par_iter().map(|index| self.power(azimuth, angle(index))).collect();
        Sampled { azimuth, finer, powers }
    }
}

/// |F|² of a cut at equally distant angles.
struct Sampled {
    azimuth: f64,
    /// Samples per row of the table.
    finer: usize,
    powers: Vec<f64>,
}

impl Sampled {
    fn angle(&self, index: usize) -> f64 {
        (index as f64 / (self.powers.len() - 1) as f64 - 0.5) * PI
    }

    /// The extremum near a sample: the root of the derivative between its neighbours.
    fn extremum(&self, beam: &Beam<'_>, index: usize) -> (f64, f64) {
        let ends =
            [index.saturating_sub(1), (index + 1).min(self.powers.len() - 1)].map(|index| self.angle(index));
        let slopes = ends.map(|angle| beam.slope(self.azimuth, angle));
        let angle = match slopes[0] * slopes[1] < 0.0 {
            true => {
                let ends = [(ends[0], slopes[0]), (ends[1], slopes[1])];
                root(|angle| beam.slope(self.azimuth, angle), ends, ERROR)
            }
            false => self.angle(index),
        };
        (angle, beam.power(self.azimuth, angle))
    }

    /// The first minimum beside a sample on one side, after which the power rises by more than rounding does.
    fn minimum(&self, from: usize, step: isize, noise: f64) -> Option<usize> {
        let (mut lowest, mut index) = (from, from);
        while let Some(next) = index.checked_add_signed(step).filter(|next| *next < self.powers.len()) {
            index = next;
            if self.powers[index] < self.powers[lowest] {
                lowest = index;
            } else if self.powers[index] > self.powers[lowest] + noise {
                return Some(lowest);
            }
        }
        None
    }

    /// Whether the power falls from a sample to both sides by more than rounding does before it rises above it.
    fn is_maximum(&self, index: usize, noise: f64) -> bool {
        let own = self.powers[index];
        let falls = |others: &mut dyn Iterator<Item = &f64>| {
            let mut others = others.peekable();
            let is_edge = others.peek().is_none();
            let decided = others.find(|&&power| power > own || power < own - noise);
            is_edge || decided.is_some_and(|&power| power < own)
        };
        // Of equal neighbours the first counts.
        let is_first = index == 0 || self.powers[index - 1] < own;
        is_first
            && falls(&mut self.powers[..index].iter().rev())
            && falls(&mut self.powers[index + 1..].iter())
    }

    /// The cut with levels relative to a power.
    fn finish(&self, beam: &Beam<'_>, full: f64) -> Cut {
        let level = |power: f64| (10.0 * (power / full).log10()).max(LOWEST);
        let extremum = |(angle, power): (f64, f64)| Extremum { angle, level: level(power) };
        let levels = self.powers.iter().step_by(self.finer).map(|&power| level(power)).collect();
        let azimuth = self.azimuth;
        let top = self.loudest();
        if full <= 0.0 || full.is_nan() || self.powers[top] == 0.0 {
            return Cut { azimuth, levels: vec![LOWEST; ANGLES], main: None, side_lobes: Vec::new() };
        }
        let (angle, power) = self.extremum(beam, top);
        let noise = NOISE * full;
        let width = |part: f64| {
            let end = |step: isize| {
                let mut before = (angle, power - part * power);
                let mut index = top;
                loop {
                    index = index.checked_add_signed(step).filter(|index| *index < self.powers.len())?;
                    let here = (self.angle(index), self.powers[index] - part * power);
                    if here.1 <= 0.0 {
                        let over = |angle: f64| beam.power(azimuth, angle) - part * power;
                        return Some(root(over, [before, here], ERROR));
                    }
                    before = here;
                }
            };
            Some([end(-1)?, end(1)?])
        };
        let main = MainLobe {
            top: extremum((angle, power)),
            half_power: width(0.5),
            half_pressure: width(0.25),
            nulls: [-1, 1]
                .map(|step| self.minimum(top, step, noise).map(|index| extremum(self.extremum(beam, index)))),
        };
        let others: Vec<_> =
            (0..self.powers.len()).filter(|&index| index != top && self.is_maximum(index, noise)).collect();
        let side_lobes = others.into_par_iter().map(|index| extremum(self.extremum(beam, index))).collect();
        Cut { azimuth, levels, main: Some(main), side_lobes }
    }

    fn loudest(&self) -> usize {
        let most = self.powers.iter().copied().fold(0.0, f64::max);
        // Of equal ones that nearest to the normal; rounding makes none louder.
        let middle = self.powers.len() / 2;
        let is_loudest = |index: &usize| self.powers[*index] >= most * (1.0 - 1e-9);
        (0..self.powers.len()).filter(is_loudest).min_by_key(|index| index.abs_diff(middle)).unwrap_or(middle)
    }
}

impl Pattern {
    /// The pattern of drives in turn at some azimuths (rad); without any, in the xz and the yz plane, or if the main beam is
    /// in neither, in the plane of the beam and that across it.
    pub fn new(scene: &Scene, drives: &[Drive], foci: &[Focus], azimuths: &[f64]) -> Self {
        let aperture = Aperture::new(scene);
        let beam = Beam::new(scene, &aperture, drives);
        let azimuths = match azimuths {
            [] => {
                let first = beam.oblique_azimuth(foci).unwrap_or(0.0);
                vec![first, first + FRAC_PI_2]
            }
            given => given.to_vec(),
        };
        let cuts: Vec<_> = azimuths.into_iter().map(|azimuth| beam.cut(azimuth)).collect();
        let full = cuts.iter().map(|cut| cut.extremum(&beam, cut.loudest()).1).fold(0.0, f64::max);
        Self { cuts: cuts.iter().map(|cut| cut.finish(&beam, full)).collect() }
    }

    /// Columns `angle` (degrees) and `level` (dB), and a `level_N` for each further cut.
    pub fn csv(&self) -> String {
        let mut text = "angle".to_owned();
        for index in 0..self.cuts.len() {
            let number = if index == 0 { String::new() } else { format!("_{}", index + 1) };
            text.push_str(&format!(",level{number}"));
        }
        for row in 0..ANGLES {
            let _ = write!(text, "\n{}", degrees_of(row));
            self.cuts.iter().for_each(|cut| text.push_str(&format!(",{}", cut.levels[row])));
        }
        text.push('\n');
        text
    }

    /// Angles in degrees, levels in dB.
    pub fn json(&self) -> Value {
        let degrees = |angle: Option<f64>| angle.map(f64::to_degrees);
        let point = |it: &Extremum| json!({ "angle": it.angle.to_degrees(), "level": it.level });
        let main = |lobe: &MainLobe| {
            json!({
                "angle": lobe.top.angle.to_degrees(),
                "level": lobe.top.level,
                "half_power_width": degrees(lobe.half_power_width()),
                "half_pressure_width": degrees(lobe.half_pressure_width()),
                "first_nulls": lobe.nulls.each_ref().map(|null| null.as_ref().map(point)),
            })
        };
        let cut = |cut: &Cut| {
            json!({
                "plane": cut.name(),
                "azimuth": cut.azimuth.to_degrees(),
                "main_lobe": cut.main.as_ref().map(main),
                "side_lobes": cut.side_lobes.iter().map(point).collect::<Vec<_>>(),
            })
        };
        json!({ "cuts": self.cuts.iter().map(cut).collect::<Vec<_>>() })
    }

    /// Both charts, with their titles.
    pub fn panels(&self) -> [(&'static str, Plot); 2] {
        [("Beam pattern", self.curve()), ("Beam pattern, polar", self.polar())]
    }

    /// The Cartesian chart.
    pub fn curve(&self) -> Plot {
        let line = |cut: &Cut| {
            (0..ANGLES).map(degrees_of).zip(&cut.levels).map(|(angle, &level)| [angle, level]).collect()
        };
        let mut lines = self.cuts.iter().map(line);
        Plot::Curve(Curve {
            axes: [
                Axis { ends: [-90.0, 90.0], label: "Angle / °".to_owned() },
                Axis { ends: [FLOOR, 0.0], label: "Level / dB".to_owned() },
            ],
            points: lines.next().unwrap_or_default(),
            others: lines.collect(),
            names: self.cuts.iter().map(Cut::name).collect(),
            ..Curve::default()
        })
    }

    /// The polar chart.
    pub fn polar(&self) -> Plot {
        let line = |cut: &Cut| (0..ANGLES).map(degrees_of).zip(cut.levels.iter().copied()).collect();
        Plot::Polar(Polar {
            floor: FLOOR,
            lines: self.cuts.iter().map(line).collect(),
            names: self.cuts.iter().map(Cut::name).collect(),
        })
    }
}

impl Cut {
    /// The plane in words.
    pub fn name(&self) -> String {
        match self.azimuth.rem_euclid(PI) {
            azimuth if azimuth < 1e-9 || PI - azimuth < 1e-9 => "xz plane".to_owned(),
            azimuth if (azimuth - FRAC_PI_2).abs() < 1e-9 => "yz plane".to_owned(),
            _ => signed(&format!("azimuth {:.1}°", (self.azimuth + PI).rem_euclid(TAU).to_degrees() - 180.0)),
        }
    }

    pub fn highest_side_lobe(&self) -> Option<Extremum> {
        self.side_lobes.iter().copied().max_by(|a, b| a.level.total_cmp(&b.level))
    }

    /// Labels and values, a row each.
    pub fn rows(&self) -> Vec<(&'static str, String)> {
        let degrees = |angle: f64| signed(&format!("{:.3}°", angle.to_degrees()));
        let width = |width: Option<f64>| width.map_or_else(|| "-".to_owned(), degrees);
        let decibels = |level: f64| signed(&format!("{level:.2} dB"));
        let Some(main) = &self.main else { return vec![("main lobe", "no sound".to_owned())] };
        let null = |null: &Extremum| match null.level {
            // A pattern without real nulls has dips.
            level if level > -60.0 => format!("{} ({})", degrees(null.angle), decibels(level)),
            _ => degrees(null.angle),
        };
        let nulls: Vec<_> = main.nulls.iter().flatten().map(null).collect();
        let lobe = self.highest_side_lobe().map_or_else(
            || "-".to_owned(),
            |lobe| {
                let level = decibels(lobe.level - main.top.level);
                format!("{level} at {}", degrees(lobe.angle))
            },
        );
        vec![
            ("main lobe", format!("{} at {}", decibels(main.top.level), degrees(main.top.angle))),
            ("half power (−3 dB) width", width(main.half_power_width())),
            ("half pressure (−6 dB) width", width(main.half_pressure_width())),
            ("first nulls", if nulls.is_empty() { "-".to_owned() } else { nulls.join(", ") }),
            ("side lobe over main lobe", lobe),
            ("side lobes", self.side_lobes.len().to_string()),
        ]
    }
}

/// The angle of a row of the table.
pub fn degrees_of(row: usize) -> f64 {
    (row as f64 - (ANGLES / 2) as f64) / 10.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Array, ElementModel};

    /// A line of N point elements at a pitch (m), steered to an angle (rad).
    fn line(count: u32, pitch: f64, steered: f64) -> (Pattern, f64) {
        let array =
            Array { rows: 1, columns: count, pitch, element: ElementModel::Point, ..Array::default() };
        let scene = Scene { array, ..Scene::default() };
        let aperture = Aperture::new(&scene);
        let turn = aperture.element.wavenumber * pitch;
        let phases = (0..count).map(|n| -turn * f64::from(n) * steered.sin()).collect();
        let drive = Drive { phases, amplitudes: vec![1.0; count as usize] };
        (Pattern::new(&scene, &[drive], &[], &[0.0]), turn)
    }

    /// A root by bisection of a function with a change of sign.
    fn bisected(value: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
        let is_positive = value(low) > 0.0;
        for _ in 0..200 {
            let middle = f64::midpoint(low, high);
            if (value(middle) > 0.0) == is_positive { low = middle } else { high = middle }
        }
        low
    }

    #[test]
    fn lines_have_the_lobes_of_their_array_factor() {
        for (count, pitch, steered) in [(16, 0.0043, 0.0), (8, 0.004, 0.3), (12, 0.0043, -0.5)] {
            let (pattern, turn) = line(count, pitch, steered);
            let n = f64::from(count);
            let (cut, main) = (&pattern.cuts[0], pattern.cuts[0].main.unwrap());
            assert!((main.top.angle - steered).abs() < 1e-9, "{}", main.top.angle);
            // |sin(Nψ/2)/(N sin(ψ/2))| with ψ = kd (sin θ - sin θ₀).
            let factor = |psi: f64| (n * psi / 2.0).sin() / (n * (psi / 2.0).sin());
            let angle = |psi: f64| (psi / turn + steered.sin()).asin();
            for (part, ends) in [(0.5f64, main.half_power), (0.25, main.half_pressure)] {
                let psi = bisected(|psi| factor(psi) - part.sqrt(), 1e-9, TAU / n);
                let expected = [angle(-psi), angle(psi)];
                let off = ends.unwrap().iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(off < 1e-9, "{count} {part}: {ends:?}, not {expected:?}");
            }
            for (null, psi) in main.nulls.iter().zip([-TAU / n, TAU / n]) {
                let null = null.unwrap();
                assert!(
                    (null.angle - angle(psi)).abs() < 1e-8 && null.level < -150.0,
                    "{null:?} {}",
                    angle(psi)
                );
            }
            // The first side lobe: tan(Nψ/2) = N tan(ψ/2).
            let slope = |psi: f64| {
                n * (n * psi / 2.0).cos() * (psi / 2.0).sin() - (n * psi / 2.0).sin() * (psi / 2.0).cos()
            };
            let psi = bisected(slope, 1.1 * TAU / n, 1.9 * TAU / n);
            for psi in [-psi, psi] {
                let level = 20.0 * factor(psi).abs().log10();
                let near = |lobe: &&Extremum| {
                    (lobe.angle - angle(psi)).abs() < 1e-8 && (lobe.level - level).abs() < 1e-8
                };
                assert!(
                    cut.side_lobes.iter().any(|lobe| near(&lobe)),
                    "{} {level}: {:?}",
                    angle(psi),
                    cut.side_lobes
                );
            }
        }
    }

    #[test]
    fn levels_are_those_of_the_array_factor() {
        let (pattern, turn) = line(10, 0.0043, 0.2);
        let text = pattern.csv();
        let mut rows = text.lines();
        assert_eq!(rows.next(), Some("angle,level"));
        assert_eq!(rows.clone().count(), ANGLES);
        for row in rows {
            let (angle, level) = row.split_once(',').unwrap();
            let [angle, level] = [angle, level].map(|number| number.parse::<f64>().unwrap());
            let psi = turn * (angle.to_radians().sin() - 0.2f64.sin());
            let factor = ((5.0 * psi).sin() / (10.0 * (psi / 2.0).sin())).abs();
            assert!((10f64.powf(level / 20.0) - factor).abs() < 1e-9, "{angle}: {level}");
        }
    }
}
