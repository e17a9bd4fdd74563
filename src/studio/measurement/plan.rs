//! The plan of a scan: its drives, places and files, its duration, and what it will tell.

use std::fmt::Write as _;

use glam::DVec3;

use crate::drive::Drive;
use crate::measure::plan::{Bound, Raster, bound, random_drives, single_drives};
use crate::measure::{MeasureError, Parameter, Vague};
use crate::scene::Scene;
use crate::studio::measurement::{duration, rms, stated, words};

/// m/s of a plotter.
const SPEED: f64 = 0.05;
/// Places that are read again at the end, for the noise and the drift: every so many, and how many at most.
const AGAIN: usize = 64;
/// Readings per unknown of a microphone that does not move.
const REDUNDANCY: usize = 4;
/// Degrees of phase that a calibration should have, at most: the error of 32 phase levels.
const USEFUL: f64 = 5.6;

/// Where a microphone is taken, and under which drives.
#[derive(Clone, Debug)]
pub struct Plan {
    pub drives: Vec<Drive>,
    /// m, in the order of the path; every drive is played for all of them.
    pub places: Vec<DVec3>,
    /// Whether readings have phases.
    pub has_phases: bool,
    /// s at each place.
    pub dwell: f64,
    /// dB
    pub signal_to_noise: f64,
    pub bound: Bound,
}

/// The choices of a plan.
#[derive(Clone, Debug)]
pub struct PlanWish {
    pub course: Course,
    /// Drives of the user's own.
    pub drives: Option<Vec<Drive>>,
    /// Number of random drives.
    pub count: Option<usize>,
    pub seed: u64,
    /// Levels of a turn of the random phases.
    pub levels: u16,
    pub has_phases: bool,
    pub dwell: f64,
    pub signal_to_noise: f64,
}

/// The course of a microphone.
#[derive(Clone, Debug)]
pub enum Course {
    Planes(Raster),
    /// It does not move; elements sound one at a time, or together with random phases.
    Still {
        at: DVec3,
        is_single: bool,
    },
}

impl Plan {
    /// # Errors
    /// An array without driven elements, silent drives, or too many readings.
    pub fn new(scene: &Scene, wish: &PlanWish) -> Result<Self, MeasureError> {
        let driven = scene.driven().len();
        let (mut places, of_place) = match &wish.course {
            Course::Planes(raster) => (raster.places(), 1),
            // Complex readings have two numbers each.
            Course::Still { at, .. } => {
                let parts = if wish.has_phases { 2 } else { 1 };
                (vec![*at], (REDUNDANCY * driven).div_ceil(parts).max(4))
            }
        };
        let is_single = matches!(wish.course, Course::Still { is_single: true, .. });
        let drives = match &wish.drives {
            Some(drives) => drives.clone(),
            None if is_single => single_drives(scene),
            None => random_drives(scene, wish.count.unwrap_or(of_place), wish.levels, wish.seed),
        };
        let again = places.iter().step_by((places.len() / AGAIN).max(AGAIN)).copied().collect::<Vec<_>>();
        if places.len() > AGAIN {
            places.extend(again);
        }
        let every = |drive: usize| std::iter::repeat_n(drive, places.len());
        let of: Vec<_> = (0..drives.len()).flat_map(every).collect();
        let points = places.repeat(drives.len());
        let bound = bound(scene, &drives, &points, &of, wish.has_phases, wish.signal_to_noise)?;
        Ok(Self {
            drives,
            places,
            has_phases: wish.has_phases,
            dwell: wish.dwell,
            signal_to_noise: wish.signal_to_noise,
            bound,
        })
    }

    /// The reason for which the scan would not tell the elements apart.
    pub fn refusal(&self) -> Option<String> {
        if let Some(vague) = &self.bound.fit.vague {
            let hint = match vague {
                Vague::TooFew { .. } => "add places (--step, --size) or drives (--drives)",
                Vague::Blurred { .. } => "choose a plane as wide as the array, nearer or with a smaller step",
            };
            return Some(format!("{vague}; {hint}"));
        }
        let is_lost = self.bound.is_focused && !self.has_phases && self.bound.fit.gains.len() > 8;
        is_lost.then(|| {
            "a focus dominates the readings, which have no phases: most tell of side lobes alone, from which a fit does not find the \
             elements; leave --drive out for a random drive, or read phases"
                .to_owned()
        })
    }

    /// s of one drive's scan.
    pub fn seconds(&self) -> f64 {
        let way: f64 = self.places.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
        self.places.len() as f64 * self.dwell + way / SPEED
    }

    /// Numbers of the plan and what it will tell, a line each.
    pub fn lines(&self) -> Vec<String> {
        let fit = &self.bound.fit;
        let (places, drives) = (self.places.len(), self.drives.len());
        let gains: Vec<_> =
            fit.errors.iter().map(|[gain, _]| *gain).filter(|gain| gain.is_finite()).collect();
        let in_all = self.seconds() * drives as f64;
        let mut lines = vec![
            match drives {
                1 => format!("{places} places, one drive: {}", duration(in_all)),
                _ if places == 1 => format!("one place, {drives} drives: {}", duration(in_all)),
                _ => format!("{places} places, {drives} drives: {}", duration(in_all)),
            },
            format!(
                "at a signal-to-noise of {} dB: phases ± {:.2}°, gains ± {:.1} %",
                self.signal_to_noise,
                fit.phase_error.to_degrees(),
                100.0 * rms(&gains)
            ),
        ];
        let bench = |parameter: Parameter| {
            let estimate = fit.parameters[parameter as usize];
            let (_, error) = stated(parameter, estimate.value, estimate.error);
            let (name, unit) = words(parameter);
            format!("{name} ± {error:.2} {unit}")
        };
        if places > 1 {
            let all: Vec<_> =
                [Parameter::SoundSpeed, Parameter::Z, Parameter::X, Parameter::TiltX, Parameter::Radius]
                    .map(bench)
                    .into();
            lines.push(format!("if they are not known: {}", all.join(", ")));
        }
        if fit.phase_error.to_degrees() > USEFUL {
            lines.push(format!(
                "± {:.0}° is more than the step of 32 phase levels: scan a plane, read phases, or add drives",
                fit.phase_error.to_degrees()
            ));
        }
        let apart = fit.correlated.iter().map(|(one, other, correlation)| {
            format!(
                "{} and {} are hardly told apart (correlation {correlation:.2})",
                words(*one).0,
                words(*other).0
            )
        });
        lines.extend(apart.filter(|_| places > 1));
        lines
    }

    /// Columns element, phase (rad), amplitude and, with several drives, drive.
    pub fn drive_csv(&self) -> String {
        let mut text = String::from(if self.drives.len() > 1 {
            "element,phase,amplitude,drive\n"
        } else {
            "element,phase,amplitude\n"
        });
        for (number, drive) in self.drives.iter().enumerate() {
            for (element, (phase, amplitude)) in drive.phases.iter().zip(&drive.amplitudes).enumerate() {
                let _ = write!(text, "{element},{phase},{amplitude}");
                text += &if self.drives.len() > 1 { format!(",{number}\n") } else { "\n".to_owned() };
            }
        }
        text
    }

    /// Columns x, y, z (m).
    pub fn positions_csv(&self) -> String {
        let mut text = String::from("x,y,z\n");
        for DVec3 { x, y, z } in &self.places {
            let _ = writeln!(text, "{x:.6},{y:.6},{z:.6}");
        }
        text
    }

    /// A table to fill in, in the order of the path.
    pub fn scan_csv(&self) -> String {
        let (columns, empty) = if self.has_phases { ("re,im", ",") } else { ("amplitude", "") };
        let mut text = format!("x,y,z,drive,{columns}\n");
        for drive in 0..self.drives.len() {
            for DVec3 { x, y, z } in &self.places {
                let _ = writeln!(text, "{x:.6},{y:.6},{z:.6},{drive},{empty}");
            }
        }
        text
    }

    /// Columns element, phase_error (degrees) and gain_error (relative): the Cramér-Rao bound of each element.
    pub fn expected_csv(&self) -> String {
        let mut text = String::from("element,phase_error,gain_error\n");
        for (element, [gain, phase]) in self.bound.fit.errors.iter().enumerate() {
            let _ = writeln!(text, "{element},{:.4},{gain:.5}", phase.to_degrees());
        }
        text
    }

    /// The path for a plotter or printer, mm, its zero in the array's middle on the height of the elements.
    pub fn gcode(&self) -> String {
        let mut text = String::from(
            "; microphone scan: origin in the middle of the array, z = 0 at its elements\nG21 ; mm\nG90 ; absolute\n",
        );
        let speed = SPEED * 6e4;
        for drive in 0..self.drives.len() {
            if self.drives.len() > 1 {
                let _ = writeln!(text, "M0 ; play drive {drive}, then go on");
            }
            for (index, place) in self.places.iter().enumerate() {
                let DVec3 { x, y, z } = place * 1e3;
                let _ = writeln!(text, "G1 X{x:.3} Y{y:.3} Z{z:.3} F{speed:.0}");
                let _ = writeln!(
                    text,
                    "G4 P{:.0} ; reading {}",
                    self.dwell * 1e3,
                    drive * self.places.len() + index + 1
                );
            }
        }
        text
    }
}
