//! The scene: array, medium, targets, plane and all else that the user edits, as plain data in SI units.
//!
//! A [`Scene`] is a value: everything the program shows or sends is a function of it. The TOML file is read and
//! written by [`mod@file`], and by [`mod@rewrite`] into the text of an earlier one; the limits of every number are
//! held by [`check`], and shapes and letters become focal points in [`outline`], frame by frame in [`motion`].

mod bead;
pub mod chart;
pub mod check;
pub mod cover;
pub mod file;
pub mod font;
mod inline;
pub mod liquid;
mod loaded;
mod location;
pub mod modulation;
pub mod motion;
mod names;
pub mod outline;
pub mod pixels;
mod range;
pub mod rewrite;
mod run;
pub mod space;
pub mod strict;
mod stroke;
pub mod target;
mod trap;
mod turns;
pub mod wave;
pub mod zone;

use std::ops::RangeInclusive;

use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};
use strum::{EnumString, IntoStaticStr, VariantArray, VariantNames};

pub use bead::{Bead, Material};
pub use check::KeyError;
pub use cover::Cover;
pub use liquid::{Light, Liquid, LiquidName};
pub use modulation::{Envelope, Law, Modulation, Tone};
pub use motion::{Easing, Keyframe, Motion, MotionPath, Tempo};
pub use pixels::{Dab, Grey, Pixels};
pub use space::{Board, Elements, Placed, Reflector};
pub use target::{Sampling, Shape, Target};
pub use trap::{Lobe, Trap};
pub use turns::Turns;
pub use wave::Wave;
pub use zone::{Area, Zone};

/// The content of a scene file.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Scene {
    pub format: u32,
    pub medium: Medium,
    pub array: Array,
    /// The boards of the array; element numbers continue from board to board. Without boards the array lies in z = 0.
    #[serde(rename = "board", skip_serializing_if = "Vec::is_empty")]
    pub boards: Vec<Board>,
    #[serde(rename = "reflector", skip_serializing_if = "Vec::is_empty")]
    pub reflectors: Vec<Reflector>,
    #[serde(rename = "target")]
    pub targets: Vec<Target>,
    /// Quiet zones, in addition to the rest of the plane.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub quiet: Vec<Zone>,
    pub solver: Solver,
    pub plane: Plane,
    pub liquid: Liquid,
    #[serde(skip_serializing_if = "Bead::is_default")]
    pub bead: Bead,
    pub modulation: Modulation,
    pub motion: Motion,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub listener: Option<Listener>,
}

impl Default for Scene {
    fn default() -> Self {
        Self {
            format: file::FORMAT,
            medium: Medium::default(),
            array: Array::default(),
            boards: Vec::new(),
            reflectors: Vec::new(),
            targets: Vec::new(),
            quiet: Vec::new(),
            solver: Solver::default(),
            plane: Plane::default(),
            liquid: Liquid::default(),
            bead: Bead::default(),
            modulation: Modulation::default(),
            motion: Motion::default(),
            listener: None,
        }
    }
}

impl Scene {
    /// Whether the targets prescribe a liquid's depression.
    pub fn aims_at_depression(&self) -> bool {
        self.solver.target == Aim::Depression && self.solver.method == Method::Best
    }

    /// Whether |p|² or a depression is prescribed over areas.
    pub fn has_areas(&self) -> bool {
        self.aims_at_depression() || self.targets.iter().any(|target| target.visible && target.is_area())
    }

    /// Numbers of drives in turn of a drag's frame and of a whole search. Without a number in the scene, areas at rest
    /// have as many as pay, since their |p|² counts in the mean.
    pub fn drives_in_turn(&self) -> RangeInclusive<usize> {
        /// Of a portrait two more lower the error by 1 % and the side lobe by 4 %, for a third more time.
        const PAY: usize = 6;
        match self.solver.frames {
            Turns::Count(count) => count as usize..=count as usize,
            Turns::Auto if self.solver.method == Method::Best && self.has_areas() && !motion::moves(self) => {
                1..=PAY
            }
            Turns::Auto => 1..=1,
        }
    }

    /// Whether named files are not yet loaded; without them the scene has no foci.
    pub fn is_incomplete(&self) -> bool {
        self.lacks_pixels() || self.array.lacks_elements()
    }

    /// Whether visible pictures are not yet loaded.
    pub fn lacks_pixels(&self) -> bool {
        self.targets.iter().any(|target| target.visible && target.lacks_pixels())
    }

    /// m, of the carrier.
    pub fn wavelength(&self) -> f64 {
        self.medium.speed_of_sound() / self.array.frequency
    }
}

/// A focal point, or a sample of a stroke or an area.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Focus {
    /// m
    pub position: DVec3,
    /// Target pressure: relative to the other foci, or Pa (peak), depending on [`Solver::pressures`].
    pub target: f64,
    /// The origin of the focus.
    pub part: Part,
}

/// The origin of a focus.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Part {
    /// A focal point of its own.
    Point,
    /// A sample of a continuous stroke.
    Stroke,
    /// A sample of an area: of the scene's target with this number.
    Area(usize),
    /// A lobe of a trap: of the scene's target with this number.
    Trap(usize),
}

impl Focus {
    /// A separate focal point; position in m.
    pub fn new(position: DVec3, target: f64) -> Self {
        Self { position, target, part: Part::Point }
    }

    /// Whether it is a separate focal point rather than a sample of a stroke or an area.
    pub fn is_separate(&self) -> bool {
        match self.part {
            Part::Point | Part::Trap(_) => true,
            Part::Stroke | Part::Area(_) => false,
        }
    }

    /// Whether it is a sample of an area.
    pub fn is_of_area(&self) -> bool {
        matches!(self.part, Part::Area(_))
    }
}

/// The air. `None` is derived from temperature, humidity and pressure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Medium {
    /// °C
    pub temperature: f64,
    /// Relative humidity, %
    pub humidity: f64,
    /// Pa
    pub pressure: f64,
    /// m/s
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sound_speed: Option<f64>,
    /// kg/m³
    #[serde(skip_serializing_if = "Option::is_none")]
    pub density: Option<f64>,
    /// dB/m
    #[serde(skip_serializing_if = "Option::is_none")]
    pub absorption: Option<f64>,
}

impl Default for Medium {
    fn default() -> Self {
        Self {
            temperature: 20.0,
            humidity: 50.0,
            pressure: 101_325.0,
            sound_speed: None,
            density: None,
            absorption: None,
        }
    }
}

impl Medium {
    /// K at 0 °C.
    pub(crate) const ZERO_CELSIUS: f64 = 273.15;

    /// K
    pub fn kelvin(&self) -> f64 {
        self.temperature + Self::ZERO_CELSIUS
    }

    /// m/s: the scene's value, or that of dry air, c = 331.3 √(T/273.15 K).
    pub fn speed_of_sound(&self) -> f64 {
        self.sound_speed.unwrap_or_else(|| 331.3 * (self.kelvin() / Self::ZERO_CELSIUS).sqrt())
    }
}

/// An array of equal elements, in rows and columns or at tabulated positions, radiating towards its own +z.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Array {
    pub rows: u32,
    pub columns: u32,
    /// m, centre to centre
    pub pitch: f64,
    /// m
    pub element_radius: f64,
    /// Hz
    pub frequency: f64,
    /// Pa·m, peak, on axis at full drive
    pub strength: f64,
    pub element: ElementModel,
    /// Elements that are not driven.
    pub off: Vec<usize>,
    /// A table of elements instead of rows, columns and pitch, relative to the scene file.
    #[serde(rename = "elements", skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// The content of that table.
    #[serde(skip)]
    pub placed: Elements,
    /// Pressure reflection coefficient of the array's own face.
    #[serde(skip_serializing_if = "is_zero")]
    pub reflectivity: f64,
}

impl Default for Array {
    fn default() -> Self {
        Self {
            rows: 16,
            columns: 16,
            pitch: 0.0105,
            element_radius: 0.005,
            frequency: 40_000.0,
            strength: 3.4,
            element: ElementModel::Piston,
            off: Vec::new(),
            file: None,
            placed: Elements::default(),
            reflectivity: 0.0,
        }
    }
}

impl Array {
    /// Number of elements of one board, driven or not.
    pub fn elements(&self) -> usize {
        self.placed.get().map_or(self.rows as usize * self.columns as usize, <[Placed]>::len)
    }
}

/// How one element radiates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, VariantArray)]
#[serde(rename_all = "kebab-case")]
pub enum ElementModel {
    /// Far field of a baffled circular piston, the paper's equation (1).
    Piston,
    /// The baffled circular piston itself, near field too.
    ExactPiston,
    /// The same strength in every direction.
    Point,
}

/// How the drive is found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Solver {
    pub method: Method,
    /// 0: the method's own default.
    pub iterations: u32,
    pub pressures: Pressures,
    pub amplitudes: Amplitudes,
    /// Trade-off: 0 for the strongest drive, 1 for the lowest side lobes.
    #[serde(skip_serializing_if = "is_default_quiet")]
    pub quiet: f64,
    /// s of further search for a better drive.
    #[serde(skip_serializing_if = "is_zero")]
    pub search: f64,
    /// Number of drives in turn whose mean |p|² fits the targets.
    #[serde(skip_serializing_if = "is_auto")]
    pub frames: Turns,
    #[serde(skip_serializing_if = "is_pressure")]
    pub target: Aim,
}

/// The quantity prescribed by the targets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Aim {
    /// |p|
    #[default]
    Pressure,
    /// The surface depression of the liquid at rest, on the scene's plane.
    Depression,
}

fn is_pressure(aim: &Aim) -> bool {
    *aim == Aim::Pressure
}

impl Solver {
    /// Default of `quiet`.
    pub const QUIET: f64 = 0.5;
}

fn is_default_quiet(quiet: &f64) -> bool {
    *quiet == Solver::QUIET
}

fn is_auto(turns: &Turns) -> bool {
    *turns == Turns::Auto
}

fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

impl Default for Solver {
    fn default() -> Self {
        Self {
            method: Method::Best,
            iterations: 0,
            pressures: Pressures::Relative,
            amplitudes: Amplitudes::Uniform,
            quiet: Self::QUIET,
            search: 0.0,
            frames: Turns::Auto,
            target: Aim::Pressure,
        }
    }
}

/// The meaning of the targets' pressures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Pressures {
    /// Ratios; the loudest element is at full drive.
    Relative,
    /// Pa (peak) at every focus; the drive is turned down to them.
    Pascal,
}

/// The amplitudes of the played drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Amplitudes {
    /// One amplitude for all elements.
    Uniform,
    /// An amplitude for each.
    Free,
}

/// The solver's method; see `crate::solver`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, EnumString, IntoStaticStr, VariantArray, VariantNames)]
#[strum(serialize_all = "kebab-case", const_into_str)]
pub enum Method {
    Focus,
    Pinv,
    Weighted,
    Naive,
    Gs,
    Gspat,
    Wgs,
    Greedy,
    Best,
}

impl Method {
    /// Full name.
    pub fn title(self) -> &'static str {
        match self {
            Self::Focus => "time of flight",
            Self::Pinv => "pseudo-inverse",
            Self::Weighted => "weighted pseudo-inverse",
            Self::Naive => "phase conjugation",
            Self::Gs => "Gerchberg-Saxton",
            Self::Gspat => "GS-PAT",
            Self::Wgs => "weighted Gerchberg-Saxton",
            Self::Greedy => "greedy search",
            Self::Best => "levelled Gauss-Newton",
        }
    }
}

/// The rectangle on which the field is evaluated.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Plane {
    /// m
    pub centre: DVec3,
    /// Towards the right of the picture; any length but zero.
    pub x_axis: DVec3,
    /// Upwards in the picture; made orthogonal to `x_axis` by [`Plane::axes`].
    pub y_axis: DVec3,
    /// m
    pub size: DVec2,
    /// Tolerated error relative to the map's peak; 0 for direct evaluation.
    pub tolerance: f64,
}

impl Default for Plane {
    fn default() -> Self {
        Self {
            centre: DVec3::new(0.0, 0.0, 0.1),
            x_axis: DVec3::X,
            y_axis: DVec3::Y,
            size: DVec2::new(0.2, 0.2),
            tolerance: 1e-3,
        }
    }
}

impl Plane {
    /// The unit vectors of the plane, or `None` if the given axes are zero or parallel.
    pub fn axes(&self) -> Option<(DVec3, DVec3)> {
        const PARALLEL: f64 = 1e-9;
        let x = self.x_axis.try_normalize()?;
        let y = self.y_axis.try_normalize()?;
        let y = y - x * x.dot(y);
        (y.length() > PARALLEL).then(|| (x, y.normalize_or_zero()))
    }
}

/// The position of an ear.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Listener {
    /// m
    pub at: DVec3,
}
