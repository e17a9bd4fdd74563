//! The skin that feels the sound: an incompressible viscoelastic half-space, or a layer of it on bone, with thresholds of feeling.
//!
//! Thresholds are displacements (m, peak) of a sine that is just felt. They hang on contact, place and person: absolute levels are
//! worth ± 15 dB, differences ± 3 dB ([`UNCERTAINTY`]).
//!
//! - `hand`: the whole hand on a handle, Morioka and Griffin (2006), accelerations (m/s², RMS) as tabulated in HDActuatorSpec.
//! - `psychohaptic`: 62 |log₁₀²(f/550 + 6/11)| / log₁₀²(6/11) dB of the reference software of MPEG's haptics (VC-PWQ), whose zero is
//!   its own; it is set to the hand's threshold at its least, 250 Hz.
//! - `afferents`: the median unit of whichever class of mechanoreceptors (SA1, RA, PC) fires first under a probe of 1 mm radius,
//!   by the TouchSim model.

use std::f64::consts::TAU;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};
use strum::{EnumString, IntoStaticStr, VariantArray, VariantNames};

use crate::scene::loaded::Loaded;
use crate::scene::modulation::SpectralLine;
use crate::scene::range::{KeyError, refuse, within};

/// dB, of absolute levels and of differences between levels.
pub const UNCERTAINTY: [f64; 2] = [15.0, 3.0];

/// Speed of surface waves relative to that of shear waves, without viscosity, of an incompressible half-space.
const RAYLEIGH: f64 = 0.955_313;

/// Hz and m/s² (RMS).
const HAND: [[f64; 2]; 17] = [
    [8.0, 0.095],
    [10.0, 0.1],
    [12.5, 0.095],
    [16.0, 0.108],
    [20.0, 0.15],
    [25.0, 0.16],
    [31.5, 0.109],
    [40.0, 0.065],
    [50.0, 0.072],
    [63.0, 0.049],
    [80.0, 0.028],
    [100.0, 0.023],
    [125.0, 0.022],
    [160.0, 0.021],
    [200.0, 0.029],
    [250.0, 0.032],
    [315.0, 0.061],
];
/// Hz and µm (peak) of SA1, RA and PC afferents.
const AFFERENTS: [[f64; 4]; 12] = [
    [5.0, 106.0, 200.0, 59.0],
    [10.0, 83.0, 104.0, 29.0],
    [20.0, 61.0, 58.0, 15.0],
    [30.0, 49.0, 42.0, 9.0],
    [50.0, 36.0, 28.0, 4.3],
    [80.0, 29.0, 21.0, 2.3],
    [100.0, 32.0, 22.0, 1.5],
    [150.0, 59.0, 36.0, 0.69],
    [200.0, 106.0, 67.0, 0.43],
    [250.0, 171.0, 96.0, 0.30],
    [300.0, 254.0, 143.0, 0.24],
    [400.0, 440.0, 204.0, 0.22],
];

/// The skin.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Skin {
    /// m/s, of surface waves on a half-space without viscosity.
    pub wave_speed: f64,
    /// Pa·s
    pub viscosity: f64,
    /// kg/m³
    pub density: f64,
    /// Thickness (m) of a layer on bone; `None` for a half-space.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth: Option<f64>,
    /// A known curve, or a file (CSV) with one, relative to the scene's file.
    pub threshold: String,
    /// The curve of the file, once loaded.
    #[serde(skip)]
    #[doc(hidden)]
    pub curve: Curve,
}

impl Default for Skin {
    fn default() -> Self {
        Self {
            wave_speed: 7.0,
            viscosity: 3.0,
            density: 1100.0,
            depth: None,
            threshold: Threshold::Hand.into_str().to_owned(),
            curve: Curve::default(),
        }
    }
}

/// Thresholds from a file, once loaded. A scene file only names it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curve {
    thresholds: Loaded<[[f64; 2]]>,
    /// The file of origin.
    pub from: Option<PathBuf>,
}

impl Curve {
    /// Hz and m (peak), two rows at least, by increasing frequency.
    pub fn new(thresholds: Vec<[f64; 2]>, from: PathBuf) -> Self {
        Self { thresholds: Loaded::new(thresholds), from: Some(from) }
    }

    pub fn get(&self) -> Option<&[[f64; 2]]> {
        self.thresholds.get()
    }
}

/// A known curve of thresholds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, EnumString, IntoStaticStr, VariantArray, VariantNames)]
#[strum(serialize_all = "lowercase", const_into_str)]
pub enum Threshold {
    Hand,
    Psychohaptic,
    Afferents,
}

impl Threshold {
    /// The displacement (m, peak) of a sine at a frequency (Hz) that is just felt.
    fn at(self, frequency: f64) -> f64 {
        let displacement =
            |acceleration: f64| std::f64::consts::SQRT_2 * acceleration / (TAU * frequency).powi(2);
        match self {
            Self::Hand => displacement(along(&HAND, frequency)),
            Self::Psychohaptic => {
                const LEAST: f64 = 250.0;
                let bend = |ratio: f64| ratio.log10().powi(2);
                let level = 62.0 * bend(frequency / 550.0 + 6.0 / 11.0) / bend(6.0 / 11.0);
                Self::Hand.at(LEAST) * 10f64.powf(level / 20.0)
            }
            Self::Afferents => {
                let of_class = |class: usize| along(&AFFERENTS.map(|row| [row[0], row[class]]), frequency);
                1e-6 * (1..=3).map(of_class).fold(f64::INFINITY, f64::min)
            }
        }
    }
}

/// A curve at a frequency, straight in logarithms between its values; nobody has measured beyond its ends, so nothing is felt there.
fn along(curve: &[[f64; 2]], frequency: f64) -> f64 {
    if !(curve[0][0]..=curve[curve.len() - 1][0]).contains(&frequency) {
        return f64::INFINITY;
    }
    let above = curve.partition_point(|[at, _]| *at <= frequency).clamp(1, curve.len() - 1);
    let [[f0, y0], [f1, y1]] = [curve[above - 1], curve[above]];
    y0 * (y1 / y0).powf((frequency / f0).ln() / (f1 / f0).ln())
}

impl Skin {
    /// Shear modulus, Pa.
    #[doc(hidden)]
    pub fn shear_modulus(&self) -> f64 {
        self.density * (self.wave_speed / RAYLEIGH).powi(2)
    }

    /// The known curve of thresholds; `None` if a file has it.
    #[doc(hidden)]
    pub fn known(&self) -> Option<Threshold> {
        self.threshold.parse().ok()
    }

    /// Whether a named curve is not yet loaded.
    #[doc(hidden)]
    pub fn lacks_curve(&self) -> bool {
        self.known().is_none() && self.curve.get().is_none()
    }

    /// The displacement (m, peak) of a sine at a frequency (Hz) that is just felt; straight in logarithms between the values of a table,
    /// infinite beyond its ends.
    pub fn threshold_at(&self, frequency: f64) -> f64 {
        match (self.known(), self.curve.get()) {
            (Some(known), _) => known.at(frequency),
            (None, Some(curve)) => along(curve, frequency),
            (None, None) => Threshold::Hand.at(frequency),
        }
    }

    /// What is felt of a motion with these lines (m, peak), relative to the threshold: the sum of their squares over those of their
    /// thresholds.
    #[doc(hidden)]
    pub fn felt<'a>(&self, lines: impl IntoIterator<Item = &'a SpectralLine>) -> f64 {
        let moving = lines.into_iter().filter(|line| line.frequency > 0.0);
        moving.map(|line| (line.amplitude / self.threshold_at(line.frequency)).powi(2)).sum()
    }

    pub(super) fn check(&self) -> Result<(), KeyError> {
        within("wave_speed", self.wave_speed, 0.5, 100.0, "m/s")?;
        within("viscosity", self.viscosity, 0.01, 1e3, "Pa·s")?;
        within("density", self.density, 100.0, 1e4, "kg/m³")?;
        if self.threshold.is_empty() {
            let known = <Threshold as VariantNames>::VARIANTS.join(", ");
            return refuse("threshold", format!("must be {known}, or the name of a CSV file"));
        }
        self.depth.map_or(Ok(()), |depth| within("depth", depth, 5e-4, 0.1, "m"))
    }
}

/// A range of frequencies that is felt in its own way.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Hash, EnumString, IntoStaticStr, VariantArray, VariantNames,
)]
#[strum(serialize_all = "lowercase", const_into_str)]
pub enum Channel {
    #[default]
    All,
    /// Below 20 Hz.
    Pressure,
    /// 20 to 60 Hz.
    Flutter,
    /// Above 60 Hz.
    Vibration,
}

impl Channel {
    /// Whether a frequency (Hz) belongs to it.
    pub fn contains(self, frequency: f64) -> bool {
        match self {
            Self::All => true,
            Self::Pressure => frequency < 20.0,
            Self::Flutter => (20.0..=60.0).contains(&frequency),
            Self::Vibration => frequency > 60.0,
        }
    }
}
