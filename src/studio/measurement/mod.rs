//! A measured field: what a fit says of elements and bench in words, JSON and a calibration, and what the correction wins.

pub mod figure;
pub mod liquid;
pub mod plan;
mod reading;
pub mod report;

use std::collections::BTreeMap;

use glam::DVec3;
use num_complex::Complex64;
use serde_json::{Value, json};

use crate::acoustics::Aperture;
use crate::device::calibration::Calibration;
use crate::measure::{Estimate, Fit, Parameter, Readings, Scan, State};
use crate::picture::figure::axes::signed;
use crate::scene::{Correction, Scene};
pub use figure::panels;
pub use reading::{DRIVE, Reading, read};

/// Signal-to-noise of a quiet bench, dB: a residual that is larger needs an explanation.
const QUIET: f64 = 25.0;
/// Degrees of freedom of repeated readings that make their noise known.
const REPEATED: usize = 8;
/// Part by which a residual may exceed the noise by chance.
const CHANCE: f64 = 1.25;
/// m: the focus by which corrections are judged is so far from the array's middle, or nearer before a small one.
const JUDGED_AT: f64 = 0.1;

/// The remark on a scan of one plane.
const ONE_PLANE: &str = "one plane: speed of sound and height are hardly told apart from a curvature of the phases; give the \
                         temperature, or scan a second plane 30 mm or more away";

/// A fit with what is known about its scan besides.
#[derive(Clone, Debug)]
pub struct Measured {
    pub scene: Scene,
    pub scan: Scan,
    pub fit: Fit,
    /// Relative noise of the readings, complex, from elsewhere than the residual: repeated readings or the user.
    pub noise: Option<f64>,
    /// Whether a focus dominates readings without phases.
    pub is_focused: bool,
}

/// What the residual tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The model explains the readings to within their noise.
    Explained,
    /// The noise is not known, and the residual is that of a quiet bench.
    Plausible,
    /// More than noise is left.
    SomethingElse,
}

/// The win of a calibration at a focus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Win {
    /// Pressure of a focus over that without corrections: with phases alone, and with gains, too.
    pub phases: f64,
    pub gains: f64,
}

impl Measured {
    pub fn new(scene: Scene, scan: Scan, fit: Fit, noise: Option<f64>) -> Self {
        let is_focused = matches!(scan.readings, Readings::Moduli(_))
            && fit.gains.len() > 8
            && crate::measure::plan::is_focused(&scan.readings);
        let noise = noise.or_else(|| repeated(&scan));
        Self { scene, scan, fit, noise, is_focused }
    }

    /// Whether the scan tells gains and phases of the elements.
    pub fn is_identifiable(&self) -> bool {
        self.unidentifiable().is_none()
    }

    /// The reason for which it does not.
    pub fn unidentifiable(&self) -> Option<String> {
        let has_lost_its_way = self.is_focused && self.verdict() == Verdict::SomethingElse;
        let lost =
            || "a focus dominates the readings, which have no phases, and the fit does not explain them";
        match &self.fit.vague {
            Some(vague) => Some(vague.to_string()),
            None => has_lost_its_way.then(|| lost().to_owned()),
        }
    }

    pub fn verdict(&self) -> Verdict {
        match self.noise {
            Some(noise) if self.fit.noise <= CHANCE * noise => Verdict::Explained,
            Some(_) => Verdict::SomethingElse,
            None if self.fit.noise <= 10f64.powf(-QUIET / 20.0) => Verdict::Plausible,
            None => Verdict::SomethingElse,
        }
    }

    /// Pa m
    pub fn strength(&self) -> Estimate {
        let of_scene = self.scene.array.strength;
        let Estimate { value, error, is_free } = self.fit.scale;
        Estimate { value: value * of_scene, error: error * of_scene, is_free }
    }

    pub fn parameter(&self, parameter: Parameter) -> Estimate {
        self.fit.parameters[parameter as usize]
    }

    /// °C at which dry air has the fitted speed of sound.
    pub fn temperature(&self) -> f64 {
        let speed = self.parameter(Parameter::SoundSpeed).value;
        273.15 * (speed / 331.3).powi(2) - 273.15
    }

    pub fn count(&self, state: State) -> usize {
        self.fit.states.iter().filter(|own| **own == state).count()
    }

    /// Numbers of the elements in a state.
    pub fn elements(&self, state: State) -> Vec<usize> {
        (0..self.fit.states.len()).filter(|&n| self.fit.states[n] == state).collect()
    }

    /// Corrections of all elements: phases, and gains if wanted. Gains weaken the louder elements to the weaker ones' level;
    /// they cost pressure, and boards without amplitudes ignore them.
    pub fn calibration(&self, with_gains: bool) -> Calibration {
        let level = self.equal_gain();
        let correction = |(g, state): (&Complex64, &State)| match state {
            State::Good | State::Reversed => Correction {
                offset: g.arg().to_degrees(),
                gain: if with_gains { (level / g.norm()).min(1.0) } else { 1.0 },
                off: false,
            },
            State::Dead => Correction { off: true, ..Correction::default() },
            State::Undriven => Correction::default(),
        };
        Calibration::from_iter(self.fit.gains.iter().zip(&self.fit.states).map(correction))
    }

    /// The gain to which louder elements are weakened: a tenth of the elements stay below.
    fn equal_gain(&self) -> f64 {
        let mut moduli: Vec<_> = self.living().map(|n| self.fit.gains[n].norm()).collect();
        moduli.sort_by(f64::total_cmp);
        moduli.get(moduli.len() / 10).copied().unwrap_or(1.0)
    }

    fn living(&self) -> impl Iterator<Item = usize> {
        let states = &self.fit.states;
        (0..states.len()).filter(|&n| matches!(states[n], State::Good | State::Reversed))
    }

    /// The predicted win at a focus in front of the array.
    pub fn win(&self) -> Win {
        let aperture = Aperture::new(&self.scene);
        let count = aperture.positions.len().max(1) as f64;
        let middle = aperture.positions.iter().sum::<DVec3>() / count;
        let normal = aperture.normals.iter().sum::<DVec3>().normalize_or_zero();
        let transfer = aperture.transfer(&[middle + JUDGED_AT * normal]);
        let level = self.equal_gain();
        let (mut before, mut phases, mut gains) = (Complex64::ZERO, 0.0, 0.0);
        for (h, &n) in transfer.row(0).zip(&aperture.driven) {
            let g = self.fit.gains[n];
            before += h.norm() * g;
            if self.fit.states[n] != State::Dead {
                phases += h.norm() * g.norm();
                gains += h.norm() * g.norm().min(level);
            }
        }
        let before = before.norm().max(f64::MIN_POSITIVE);
        Win { phases: phases / before, gains: gains / before }
    }

    /// What was found, a line each.
    pub fn lines(&self) -> Vec<String> {
        self.findings().into_iter().chain(self.bench()).collect()
    }

    /// What the readings tell of the model and the elements, a line each.
    pub fn findings(&self) -> Vec<String> {
        let fit = &self.fit;
        let mut lines = Vec::new();
        let percent = |part: f64| format!("{:.2} %", 100.0 * part);
        let verdict = match self.verdict() {
            Verdict::Explained => "the model explains the readings",
            Verdict::Plausible => {
                "that of a quiet bench; repeated readings, or --snr, would tell noise from error"
            }
            Verdict::SomethingElse => {
                "something else is in the room, or the drive is another: reflections, a moved table, scattered positions"
            }
        };
        let noise = self.noise.map_or_else(String::new, |noise| format!(", noise {}", percent(noise)));
        lines.push(format!("residual {}{noise}: {verdict}", percent(fit.residual)));
        match &fit.vague {
            Some(vague) => lines.push(format!("elements taken to be alike: {vague}")),
            None => {
                let phases: Vec<_> = self
                    .living()
                    .filter(|&n| fit.states[n] == State::Good)
                    .map(|n| fit.gains[n].arg())
                    .collect();
                let gains: Vec<_> = self
                    .living()
                    .filter(|&n| fit.states[n] == State::Good)
                    .map(|n| fit.gains[n].norm() - 1.0)
                    .collect();
                let driven = self.living().count() + self.count(State::Dead);
                if driven > 1 {
                    lines.push(format!(
                        "{driven} elements: phases {:.1}° rms (± {:.2}°), gains {:.1} % rms",
                        rms(&phases).to_degrees(),
                        fit.phase_error.to_degrees(),
                        100.0 * rms(&gains)
                    ));
                }
                for (state, words) in
                    [(State::Dead, "dead"), (State::Reversed, "reversed"), (State::Undriven, "never driven")]
                {
                    let own = self.elements(state);
                    if !own.is_empty() {
                        lines.push(format!("{words}: {}", listed(&own)));
                    }
                }
                if driven == 1 {
                    return lines;
                }
                let win = self.win();
                let [phases, gains] = [win.phases, win.gains]
                    .map(|win| format!("{:+.1}", 100.0 * (win - 1.0)).replace('-', "−"));
                lines.push(format!("correction: focus {phases} % with phases, {gains} % with gains, too"));
            }
        }
        lines
    }

    /// Strength and bench, a line for each that was fitted and one for those that were not.
    pub fn bench(&self) -> Vec<String> {
        let strength = self.strength();
        let mut lines = vec![format!(
            "strength {:.3} ± {:.3} Pa·m (scene {} Pa·m)",
            strength.value, strength.error, self.scene.array.strength
        )];
        let (free, held): (Vec<_>, Vec<_>) =
            Parameter::ALL.into_iter().partition(|parameter| self.parameter(*parameter).is_free);
        lines.extend(free.into_iter().map(|parameter| {
            let [value, error] = self.text(parameter);
            let (words, unit) = words(parameter);
            let air = match parameter {
                Parameter::SoundSpeed => format!(" (air at {:.1} °C)", self.temperature()),
                Parameter::X
                | Parameter::Y
                | Parameter::Z
                | Parameter::TiltX
                | Parameter::TiltY
                | Parameter::Radius
                | Parameter::WidthSquared => String::new(),
            };
            format!("{words} {value} ± {error} {unit}{air}")
        }));
        // What no reading speaks of has no error.
        let held: Vec<_> = held
            .into_iter()
            .filter(|parameter| self.parameter(*parameter).error.is_finite())
            .map(|parameter| {
                let [value, error] = self.text(parameter);
                let (words, unit) = words(parameter);
                format!("{words} {value} ± {error} {unit}")
            })
            .collect();
        if !held.is_empty() {
            lines.push(format!("held, as the readings ask for no other: {}", held.join(", ")));
        }
        lines
    }

    /// A parameter and its error as numbers in the unit of [`words`].
    fn text(&self, parameter: Parameter) -> [String; 2] {
        let Estimate { value, error, .. } = self.parameter(parameter);
        let (value, error) = stated(parameter, value, error);
        numbers(value, error)
    }

    /// Whether all readings are on one plane, and gains were fitted.
    fn has_one_plane(&self) -> bool {
        let is_moved = self.scan.points.iter().any(|point| point.distance(self.scan.points[0]) > 0.0);
        is_moved && self.scan.planes().len() == 1 && self.fit.vague.is_none() && self.fit.gains.len() > 1
    }

    /// Remarks that are no reasons for care, a line each.
    pub fn notes(&self) -> Vec<String> {
        let is_free = |parameter| self.parameter(parameter).is_free;
        let holds = !is_free(Parameter::SoundSpeed) && !is_free(Parameter::Z);
        (self.has_one_plane() && holds).then(|| ONE_PLANE.to_owned()).into_iter().collect()
    }

    /// Reasons for care, a line each.
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        if let Some(reason) = self.unidentifiable() {
            warnings.push(format!("gains and phases of the elements are not identifiable: {reason}"));
        }
        if self.is_focused {
            warnings.push(
                "a focus dominates the readings, which have no phases: from side lobes alone a fit may end in a wrong minimum; \
                 scan with a random drive (`measure --plan`)"
                    .to_owned(),
            );
        }
        let is_free = |parameter| self.parameter(parameter).is_free;
        if self.has_one_plane() && (is_free(Parameter::SoundSpeed) || is_free(Parameter::Z)) {
            warnings.push(ONE_PLANE.to_owned());
        }
        for (one, other, correlation) in &self.fit.correlated {
            let free = |it: &Parameter| self.parameter(*it).is_free;
            if free(one) && free(other) {
                let ((one, _), (other, _)) = (words(*one), words(*other));
                warnings.push(format!(
                    "{one} and {other} are hardly told apart: their correlation is {correlation:.2}"
                ));
            }
        }
        if self.verdict() == Verdict::SomethingElse {
            warnings.push(format!(
                "the residual, {:.1} % of the readings, is more than their noise: reflections, a moved table, another drive, or \
                 places that are not where the file says",
                100.0 * self.fit.residual
            ));
        }
        let strength = self.fit.scale.value;
        if !(0.05..20.0).contains(&strength) {
            warnings.push(format!(
                "the strength is {strength:.1e} times the scene's: readings in other units than Pa give gains and phases, and \
                 no strength"
            ));
        }
        warnings
    }

    pub fn json(&self) -> Value {
        let fit = &self.fit;
        let finite = |value: f64| if value.is_finite() { json!(value) } else { Value::Null };
        let strength = self.strength();
        let speed = self.parameter(Parameter::SoundSpeed);
        let mut pose = serde_json::Map::new();
        for parameter in [Parameter::X, Parameter::Y, Parameter::Z, Parameter::TiltX, Parameter::TiltY] {
            let Estimate { value, error, .. } = self.parameter(parameter);
            pose.insert(parameter.name().to_owned(), json!(value));
            pose.insert(format!("{}_error", parameter.name()), finite(error));
        }
        let radius = self.parameter(Parameter::Radius);
        let width = self.parameter(Parameter::WidthSquared);
        let (width_value, width_error) = stated(Parameter::WidthSquared, width.value, width.error);
        let free: Vec<_> = Parameter::ALL
            .into_iter()
            .filter(|it| self.parameter(*it).is_free)
            .map(Parameter::name)
            .collect();
        let held: Vec<_> = Parameter::ALL
            .into_iter()
            .filter(|it| !self.parameter(*it).is_free)
            .map(Parameter::name)
            .collect();
        let correlations: Vec<_> = fit
            .correlated
            .iter()
            .map(|(one, other, correlation)| json!([one.name(), other.name(), correlation]))
            .collect();
        let win = self.win();
        json!({
            "gains": fit.gains.iter().map(|g| g.norm()).collect::<Vec<_>>(),
            "phases": fit.gains.iter().map(|g| g.arg()).collect::<Vec<_>>(),
            "gain_errors": fit.errors.iter().map(|[gain, _]| finite(*gain)).collect::<Vec<_>>(),
            "phase_errors": fit.errors.iter().map(|[_, phase]| finite(*phase)).collect::<Vec<_>>(),
            "states": fit.states.iter().map(|state| state.name()).collect::<Vec<_>>(),
            "strength": strength.value,
            "strength_error": finite(strength.error),
            "sound_speed": speed.value,
            "sound_speed_error": finite(speed.error),
            "temperature": self.temperature(),
            "radius": radius.value,
            "radius_error": finite(radius.error),
            "microphone_width": width_value / 1e3,
            "microphone_width_error": finite(width_error / 1e3),
            "pose": pose,
            "fitted": free,
            "held": held,
            "correlations": correlations,
            "residual": fit.residual,
            "noise": self.noise.unwrap_or(fit.noise),
            "explained": self.verdict() != Verdict::SomethingElse,
            "identifiable": self.is_identifiable(),
            "win": { "phases": win.phases, "gains": win.gains },
            "warnings": self.warnings(),
            "notes": self.notes(),
        })
    }
}

/// The relative noise of readings taken more than once, complex.
fn repeated(scan: &Scan) -> Option<f64> {
    let mut of_place: BTreeMap<_, Vec<usize>> = BTreeMap::new();
    for (index, (point, drive)) in scan.points.iter().zip(&scan.drives).enumerate() {
        of_place.entry((point.to_array().map(f64::to_bits), *drive)).or_default().push(index);
    }
    let (mut squares, mut freedom) = (0.0, 0);
    for own in of_place.values().filter(|own| own.len() > 1) {
        let spread = |values: Vec<Complex64>| {
            let mean = values.iter().sum::<Complex64>() / values.len() as f64;
            values.iter().map(|value| (value - mean).norm_sqr()).sum::<f64>()
        };
        // Of moduli, a half of the noise of p; scaled up as the complex one's.
        squares += match &scan.readings {
            Readings::Complex(values) => spread(own.iter().map(|&i| values[i]).collect()),
            Readings::Moduli(values) => 2.0 * spread(own.iter().map(|&i| values[i].into()).collect()),
        };
        freedom += own.len() - 1;
    }
    (freedom >= REPEATED).then(|| (squares / freedom as f64).sqrt() / scan.readings.rms())
}

/// A value and its error in the unit of [`words`].
fn stated(parameter: Parameter, value: f64, error: f64) -> (f64, f64) {
    match parameter {
        Parameter::X | Parameter::Y | Parameter::Z | Parameter::Radius => (value * 1e3, error * 1e3),
        Parameter::TiltX | Parameter::TiltY => (value.to_degrees(), error.to_degrees()),
        Parameter::SoundSpeed => (value, error),
        Parameter::WidthSquared => {
            let width = value.sqrt();
            // Beside a point, the width whose square is the error of the square.
            (width * 1e3, if width > 0.0 { error / (2.0 * width) } else { error.sqrt() } * 1e3)
        }
    }
}

fn words(parameter: Parameter) -> (&'static str, &'static str) {
    match parameter {
        Parameter::X => ("shift x", "mm"),
        Parameter::Y => ("shift y", "mm"),
        Parameter::Z => ("shift z", "mm"),
        Parameter::TiltX => ("tilt about x", "°"),
        Parameter::TiltY => ("tilt about y", "°"),
        Parameter::SoundSpeed => ("sound speed", "m/s"),
        Parameter::Radius => ("element radius", "mm"),
        Parameter::WidthSquared => ("microphone width", "mm"),
    }
}

/// A value and its standard error with as many decimals as the error has.
fn numbers(value: f64, error: f64) -> [String; 2] {
    let known = error.is_finite() && error > 0.0;
    let decimals = if known { (1.5 - error.log10()).clamp(0.0, 5.0) as usize } else { 2 };
    [
        signed(&format!("{value:.decimals$}")),
        if known { format!("{error:.decimals$}") } else { "–".to_owned() },
    ]
}

fn listed(numbers: &[usize]) -> String {
    const MOST: usize = 16;
    let shown: Vec<_> = numbers.iter().take(MOST).map(ToString::to_string).collect();
    let rest = numbers.len().saturating_sub(MOST);
    format!("{}{}", shown.join(", "), if rest > 0 { format!(" and {rest} more") } else { String::new() })
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

/// Minutes and seconds of a duration, s.
pub fn duration(seconds: f64) -> String {
    let minutes = (seconds / 60.0).round() as u64;
    match minutes {
        0 => format!("{seconds:.0} s"),
        1..100 => format!("{minutes} min"),
        _ => format!("{} h {} min", minutes / 60, minutes % 60),
    }
}
