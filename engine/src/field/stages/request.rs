//! The request for a map, the resulting map, and its errors.

use std::sync::Arc;

use glam::DVec2;
use num_complex::Complex64;

use crate::acoustics::{Air, Aperture, course::Course, response::responding};
use crate::drive::Drive;
use crate::field::gpu_report::GpuError;
use crate::field::harmonic::{MarchError, NoHarmonic};
use crate::field::quantity::{Constants, Declaration, Quantity};
use crate::field::stages::depression::Depression;
use crate::scene::{Bead, Channel, Liquid, Plane, Reflector, Scene, Skin, Spread};
use crate::surface::Light;

/// Pixels that a map may have.
pub const MOST_PIXELS: usize = 1 << 26;

/// All inputs of a map.
#[derive(Clone, Debug, PartialEq)]
pub struct Request {
    pub aperture: Aperture,
    pub air: Air,
    /// Including the map's tolerance, relative to its peak.
    pub plane: Plane,
    /// Drives in turn with equal durations; the map shows their mean, or for quantities without a mean (phases,
    /// instantaneous pressures) the first.
    pub drives: Arc<[Drive]>,
    pub quantity: Quantity,
    /// rad, the ωt of an instantaneous pressure.
    pub moment: f64,
    /// The part of a steady radiation pressure that the envelope leaves, 0 to 1.
    pub part: f64,
    /// The liquid whose surface the plane is.
    pub liquid: Liquid,
    /// The bead of a potential.
    pub bead: Bead,
    /// Differences between elements: squares of the sound are then means over all such arrays.
    pub spread: Spread,
    /// The skin on the plane.
    pub skin: Skin,
    /// The frequencies of the skin's motion that count.
    pub channel: Channel,
    /// When each drive is played, under which envelope; for the skin.
    #[doc(hidden)]
    pub course: Course,
    /// The scene's reflectors; their images are in the aperture.
    pub mirrors: Vec<Reflector>,
    /// A moving surface of the liquid, instead of the one at rest: its depth (m) in every cell of
    /// [`crate::field::Stages::surface`]; or the skin at a moment ([`crate::field::SkinMotion::surface`]).
    pub depth: Option<Vec<f64>>,
    /// Pixels, width and height.
    pub size: (usize, usize),
}

impl Request {
    /// A request on the scene's plane, in its air, with its envelope and liquid.
    pub fn new(scene: &Scene, drives: Vec<Drive>, quantity: Quantity, size: (usize, usize)) -> Self {
        let Declaration { is_slow, of_skin, .. } = *quantity.declaration();
        let (course, drives) = match of_skin {
            true => Course::new(scene, drives.len()).unrolled(drives),
            false => (Course::default(), responding(scene, drives, is_slow)),
        };
        Self {
            aperture: Aperture::new(scene),
            air: Air::new(&scene.medium, scene.array.frequency),
            plane: scene.plane.clone(),
            drives: drives.into(),
            quantity,
            moment: 0.0,
            part: if is_slow && !of_skin { scene.envelope().mean_square() } else { 1.0 },
            liquid: scene.liquid.clone(),
            bead: scene.bead.clone(),
            spread: scene.array.spread,
            skin: scene.skin.clone().unwrap_or_default(),
            channel: Channel::All,
            course,
            mirrors: scene.mirrors(),
            depth: None,
            size,
        }
    }

    /// The request reduced to the quantity's inputs.
    ///
    /// # Errors
    /// An invalid request.
    pub(super) fn relevant(&self) -> Result<Self, FieldError> {
        self.check()?;
        let Declaration { of_liquid, of_light, of_bead, of_moment, of_skin, .. } =
            *self.quantity.declaration();
        let liquid = match (of_liquid, of_light) {
            (_, true) => self.liquid.clone(),
            (true, false) => self.liquid.in_the_dark(),
            (false, false) => Liquid::default(),
        };
        Ok(Self {
            aperture: self.incident(),
            mirrors: Vec::new(),
            drives: self.counted(),
            moment: if of_moment { self.moment } else { 0.0 },
            liquid,
            bead: if of_bead { self.bead.clone() } else { Bead::default() },
            spread: if self.is_of_many_arrays() { self.spread } else { Spread::default() },
            depth: self.depth.clone().filter(|_| of_liquid || of_skin),
            skin: if of_skin { self.skin.clone() } else { Skin::default() },
            channel: if of_skin { self.channel } else { Channel::All },
            course: if of_skin { self.course.clone() } else { Course::default() },
            ..self.clone()
        })
    }

    /// Whether the map is a mean over arrays of different elements.
    pub(super) fn is_of_many_arrays(&self) -> bool {
        self.quantity.declaration().has_scatter() && !self.spread.is_none()
    }

    /// The contributing part of the aperture: for radiation pressure on a plane that is a reflector, the incident
    /// sound, since the formula assumes doubling.
    fn incident(&self) -> Aperture {
        let axes = self.plane.axes().filter(|_| self.quantity.declaration().is_slow);
        let lies_in =
            |mirror: &&Reflector| axes.is_some_and(|(x, y)| mirror.lies_in(self.plane.centre, x.cross(y)));
        match self.mirrors.iter().find(lies_in) {
            Some(mirror) => self.aperture.incident_on(mirror),
            None => self.aperture.clone(),
        }
    }

    pub(super) fn constants(&self) -> Constants<f64> {
        Constants::new(&self.air, self.aperture.element.wavenumber, self.moment)
    }

    /// u of every element of the array, 0 for undriven ones, for every relevant drive.
    pub(super) fn excitations(&self) -> Arc<Vec<Vec<Complex64>>> {
        let of_drive = |drive: &Drive| {
            let mut excitation = vec![Complex64::ZERO; self.aperture.positions.len()];
            let driven = &self.aperture.driven;
            for (&n, u) in driven.iter().zip(drive.excitation(driven)) {
                excitation[n] = u;
            }
            excitation
        };
        Arc::new(self.counted().iter().map(of_drive).collect())
    }

    /// The drives that count.
    pub(super) fn counted(&self) -> Arc<[Drive]> {
        let is_all = self.quantity.declaration().has_mean || self.drives.len() == 1;
        if is_all { Arc::clone(&self.drives) } else { self.drives[..1].into() }
    }

    /// # Errors
    /// No pixels or too many, drives of another array, an invalid envelope or moment.
    fn check(&self) -> Result<(), FieldError> {
        let (width, height) = self.size;
        let is_map = width.checked_mul(height).is_some_and(|pixels| (1..=MOST_PIXELS).contains(&pixels));
        if !is_map {
            return Err(FieldError::NoPixels(width, height));
        }
        if self.drives.is_empty() || !(0.0..=1.0).contains(&self.part) || !self.moment.is_finite() {
            return Err(FieldError::NoMean);
        }
        // NaN would go unnoticed in comparisons for peak and error.
        let is_drive = |values: &[f64]| {
            values.len() == self.aperture.positions.len() && values.iter().all(|value| value.is_finite())
        };
        let fits = |drive: &Drive| is_drive(&drive.amplitudes) && is_drive(&drive.phases);
        if !self.drives.iter().all(fits) {
            return Err(FieldError::NoDrive);
        }
        let has_course = !self.quantity.declaration().of_skin || self.drives.len() == self.course.frames();
        if has_course { Ok(()) } else { Err(FieldError::NoCourse(self.course.frames())) }
    }
}

/// A map, with its error.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Map {
    pub width: usize,
    pub height: usize,
    /// Values of every pixel, row by row, row 0 at the smallest y, in the quantity's unit.
    pub values: Vec<f32>,
    /// The largest magnitude of a value; of phases and instantaneous pressures the largest |P| (Pa, peak). Pixels
    /// within a wavelength of an element do not count, unless all of them are. 0 of a silent map.
    pub peak: f32,
    /// The same over all pixels.
    pub loudest: f32,
    /// Number of pixels within a wavelength of an element, in front of it.
    pub near: usize,
    /// Number of pixels within bodies, whose values are not numbers.
    #[doc(hidden)]
    pub within: usize,
    /// Bound of the rounding of the sums behind the values of a silent map, if these are not all 0; they stay below it.
    pub rounding: f64,
    /// An estimate of the largest deviation of any pixel from the f64 reference, relative to the peak or to a louder
    /// pixel itself: three times that of 48 pixels and more, including those with the worst rounding; for a
    /// depression and its caustic, the error of the radiation pressure. 0 for a silent map.
    pub error: f64,
    /// Number of points with a sum over the elements.
    pub evaluated: usize,
    pub by: By,
    /// The method of evaluation, as text.
    pub how: String,
}

impl Map {
    /// The same without its values.
    pub fn without_values(&self) -> Self {
        let how = self.how.clone();
        Self { values: Vec::new(), how, ..*self }
    }

    /// Whether values within a wavelength of an element exceed the peak.
    pub fn has_larger(&self) -> bool {
        self.peak > 0.0 && self.loudest > self.peak
    }
}

/// The radiation pressure on the plane, and the liquid's response.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pressed {
    /// Width and height (m) of the plane: the area of all figures.
    pub size: DVec2,
    /// N on the plane.
    pub force: f64,
    /// Depression of a liquid's surface.
    pub depression: Option<Depression>,
    /// Light on the screen, in units of the light of the plane's own area.
    pub light: Option<Light>,
}

/// The maker of a map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum By {
    /// The f64 reference, each pixel for itself.
    Reference,
    #[default]
    Cpu,
    /// The CPU with samples in f64, since f32 does not suffice for the tolerance or the elements.
    CpuInF64,
    Gpu,
}

/// Errors of a map.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FieldError {
    #[error("a map of {0} x {1} pixels: must have 1 to {MOST_PIXELS} pixels")]
    NoPixels(usize, usize),
    #[error("the drive must give every element of the array a finite amplitude and phase")]
    NoDrive,
    #[error("a map needs a drive, a moment, and a part from 0 to 1 of the steady pressure")]
    NoMean,
    #[doc(hidden)]
    #[error("the motion of the skin needs the drives of all {0} frames of its cycle")]
    NoCourse(usize),
    #[error(
        "invalid plane: its axes are parallel or zero, or its centre, size or tolerance are out of a scene's range"
    )]
    NoPlane,
    #[error(
        "the plane comes nearer than a wavelength to the array: the surface of a liquid, or the skin, must stay clear of it"
    )]
    TooNear,
    #[error("a liquid's surface is level: `x_axis` and `y_axis` of its plane must have no z component")]
    NotLevel,
    #[error(
        "the plane and the margin of a depression, 14 capillary lengths √(σ/ρg), are too wide: use a smaller plane, or a \
         liquid of lower surface tension or higher density"
    )]
    TooManyCells,
    #[error(
        "{0} frames on this plane exceed the memory for the motion of the skin: take fewer frames, or a smaller plane"
    )]
    TooManyFrames(usize),
    #[doc(hidden)]
    #[error("the map was cancelled")]
    Cancelled,
    #[error(transparent)]
    Harmonic(#[from] NoHarmonic),
    #[error(transparent)]
    Gpu(#[from] GpuError),
}

impl From<MarchError> for FieldError {
    fn from(error: MarchError) -> Self {
        match error {
            MarchError::None(why) => Self::Harmonic(why),
            MarchError::Gpu(error) => Self::Gpu(error),
        }
    }
}

/// The inputs of plan and transfer: positions of elements and plane, and the medium.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Setting {
    /// The aperture with every element driven, which makes no difference here.
    pub(super) aperture: Aperture,
    pub(super) plane: Plane,
}

impl Setting {
    pub(super) fn new(aperture: &Aperture, plane: Plane) -> Self {
        let all = (0..aperture.positions.len()).collect();
        Self { aperture: Aperture { driven: all, ..aperture.clone() }, plane }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Array;

    fn scene() -> Scene {
        Scene { array: Array { columns: 2, rows: 2, ..Array::default() }, ..Scene::default() }
    }

    fn drive() -> Drive {
        Drive { amplitudes: vec![1.0; 4], phases: vec![0.0; 4] }
    }

    #[test]
    fn every_drive_must_give_every_element_a_finite_amplitude_and_phase() {
        let refused = |second: Drive| {
            let request = Request::new(&scene(), vec![drive(), second], Quantity::Rms, (8, 8));
            request.check() == Err(FieldError::NoDrive)
        };
        assert!(!refused(drive()));
        for values in [vec![0.5; 3], vec![0.5; 5], vec![], vec![0.5, 0.5, f64::NAN, 0.5]] {
            assert!(refused(Drive { amplitudes: values.clone(), ..drive() }), "{values:?}");
            assert!(refused(Drive { phases: values.clone(), ..drive() }), "{values:?}");
            assert!(refused(Drive { amplitudes: values.clone(), phases: values }));
        }
    }

    #[test]
    fn a_mean_needs_drives_a_part_and_a_moment() {
        let request = Request::new(&scene(), vec![drive()], Quantity::Rms, (8, 8));
        for part in [0.0, 0.5, 1.0] {
            assert_eq!(Request { part, ..request.clone() }.check(), Ok(()), "{part}");
        }
        let part = |part: f64| Request { part, ..request.clone() };
        let moment = |moment: f64| Request { moment, ..request.clone() };
        for refused in [
            Request { drives: Vec::new().into(), ..request.clone() },
            part(-0.1),
            part(1.1),
            part(f64::NAN),
            moment(f64::INFINITY),
            moment(f64::NAN),
        ] {
            assert_eq!(refused.check(), Err(FieldError::NoMean), "{refused:?}");
        }
    }
}
