//! The ghost of a drive: the loudest place on a plane where nobody asked for sound.
//!
//! It is the largest local maximum of |p| outside the main lobes of the foci. A main lobe ends where paths from the aperture
//! differ by a wavelength, and that says how far it reaches, for an aperture of half-width h, a focus at the distance r from its
//! middle, and a point at s along the beam and t across it:
//!
//! - across, paths from the two edges: t = λ √(s² + h²)/2h, the first null of a line of sources;
//! - along, paths from an edge and from the middle: |g(s) - g(r)| = λ with g(s) = √(s² + h²) - s, the first null on the axis
//!   of a disk. Where g(r) < λ, the beam has no end.
//!
//! A point is in the lobe where the squares of both add up to less than 1, t taken a quarter further. For a square array of
//! 16 x 16 and foci from 3 cm to 1 m, steered by up to 22°, the first null across lies at 1.00 to 1.18 of λ √(s² + h²)/2h, and the
//! first side lobe at 1.44 to 1.68. (Kept to λ r/2h times 1.5, as papers have it, the first side lobe of foci beyond
//! 30 cm would count as their own.)

use glam::DVec3;

use crate::acoustics::Aperture;
use crate::drive::Drive;
use crate::field::{FieldError, Samples, Stages, Wanted};
use crate::scene::Plane;

/// Samples in a wavelength: a maximum of |p| is half a wavelength wide or more.
const PER_WAVELENGTH: f64 = 8.0;
/// Samples of a plane that are searched at most.
const MOST_SAMPLES: f64 = 4e6;
/// Of the peak: what the map may be off while maxima are found; their pressures are then evaluated in f64.
const TOLERANCE: f64 = 1e-3;
/// How far beyond its first null across a main lobe is taken to reach.
const MARGIN: f64 = 1.25;
/// Parabolas that are laid through a maximum, each over half the distance of the last.
const PARABOLAS: i32 = 4;

/// The loudest place beside the foci.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ghost {
    /// m
    pub position: DVec3,
    /// |P|, Pa
    pub pressure: f64,
    /// Of the mean |P| at the foci.
    pub part: f64,
}

/// Why there is no ghost to name.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NoGhost {
    #[error("the plane meets no focus")]
    NoFocus,
    #[error("the plane is too large to be searched in steps of an eighth of a wavelength")]
    TooLarge,
    #[error("nothing on the plane is louder than its surroundings but the foci")]
    NoMaximum,
    #[error(transparent)]
    Field(#[from] FieldError),
}

/// The ghost of a drive on a plane.
///
/// # Errors
/// [`NoGhost`]: it may have none, or the field may fail.
pub fn loudest(
    stages: &mut Stages,
    aperture: &Aperture,
    plane: &Plane,
    drive: &Drive,
    foci: &[DVec3],
) -> Result<Ghost, NoGhost> {
    let lobes: Vec<_> = foci.iter().map(|&focus| Lobe::new(aperture, focus)).collect();
    let is_rectangle = plane.size.is_finite() && plane.size.min_element() > 0.0;
    let (x_axis, y_axis) = plane.axes().filter(|_| is_rectangle).ok_or(FieldError::NoPlane)?;
    if !lobes.iter().any(|lobe| lobe.contains(nearest(plane, [x_axis, y_axis], lobe.focus))) {
        return Err(NoGhost::NoFocus);
    }
    let step = aperture.wavelength() / PER_WAVELENGTH;
    let [width, height] = (plane.size / step).to_array().map(|samples| samples.ceil().max(3.0));
    if width * height > MOST_SAMPLES {
        return Err(NoGhost::TooLarge);
    }
    let (width, height) = (width as usize, height as usize);
    let plane = Plane { tolerance: TOLERANCE, ..plane.clone() };
    let samples = Samples::on_plane(&plane, width, height).ok_or(FieldError::NoPlane)?;
    let field = stages.read(&Wanted { aperture, plane: &plane, drive, width, height })?;
    let power: Vec<_> = field.iter().map(|p| p.norm_sqr()).collect();
    // Nearer to the array than a wavelength it is the elements themselves that are loud.
    let is_ghost = |&index: &usize| {
        let point = samples.point(index);
        point.z > aperture.wavelength() && !lobes.iter().any(|lobe| lobe.contains(point))
    };
    let mut maxima = maxima(&power, width);
    maxima.sort_by(|&a, &b| power[b].total_cmp(&power[a]));
    let found = maxima.into_iter().find(is_ghost).ok_or(NoGhost::NoMaximum)?;

    let excitation = drive.excitation(&aperture.driven);
    let pressure = |point: DVec3| aperture.transfer(&[point]).pressure(&excitation)[0].norm();
    let position = climbed(samples.point(found), [x_axis * step, y_axis * step], pressure);
    let focal = aperture.transfer(foci).pressure(&excitation);
    let mean = focal.iter().map(|p| p.norm()).sum::<f64>() / focal.len() as f64;
    let pressure = pressure(position);
    Ok(Ghost { position, pressure, part: pressure / mean.max(f64::MIN_POSITIVE) })
}

/// The point of a plane's rectangle that is nearest to another.
fn nearest(plane: &Plane, axes: [DVec3; 2], point: DVec3) -> DVec3 {
    let along = |axis: DVec3, size: f64| {
        let place: f64 = axis.dot(point - plane.centre);
        axis * place.clamp(-size / 2.0, size / 2.0)
    };
    plane.centre + along(axes[0], plane.size.x) + along(axes[1], plane.size.y)
}

/// Samples of a grid, `width` to a row, that are louder than their eight neighbours.
fn maxima(power: &[f32], width: usize) -> Vec<usize> {
    let is_maximum = |&at: &usize| {
        let before = [at - width - 1, at - width, at - width + 1, at - 1];
        let after = [at + 1, at + width - 1, at + width, at + width + 1];
        // Of several that are equally loud, one.
        before.iter().all(|&other| power[at] > power[other])
            && after.iter().all(|&other| power[at] >= power[other])
    };
    let rows = power.len() / width;
    (1..rows - 1).flat_map(|row| row * width + 1..(row + 1) * width - 1).filter(is_maximum).collect()
}

/// The maximum near a point, by parabolas along two steps that become smaller.
fn climbed(mut point: DVec3, steps: [DVec3; 2], pressure: impl Fn(DVec3) -> f64) -> DVec3 {
    for halving in 0..PARABOLAS {
        let middle = pressure(point);
        let [x, y] = steps.map(|step| {
            let step = step * 0.5f64.powi(halving);
            let (before, after) = (pressure(point - step), pressure(point + step));
            let curvature = before - 2.0 * middle + after;
            let part = if curvature < 0.0 { 0.5 * (before - after) / curvature } else { 0.0 };
            step * part.clamp(-1.0, 1.0)
        });
        if pressure(point + x + y) > middle {
            point += x + y;
        }
    }
    point
}

/// The main lobe of a focus.
struct Lobe {
    focus: DVec3,
    wavelength: f64,
    /// Middle of the driven elements.
    middle: DVec3,
    beam: DVec3,
    /// Across the beam, as near as can be to the array's axes.
    sides: [DVec3; 2],
    /// Half-widths of the aperture along the same.
    half: [f64; 2],
}

impl Lobe {
    fn new(aperture: &Aperture, focus: DVec3) -> Self {
        let (low, high) = aperture.extent();
        let middle = ((low + high) / 2.0).extend(0.0);
        let beam = (focus - middle).normalize_or(DVec3::Z);
        let x = DVec3::X.reject_from_normalized(beam).normalize_or(-DVec3::Z);
        Self {
            focus,
            wavelength: aperture.wavelength(),
            middle,
            beam,
            sides: [x, beam.cross(x)],
            half: ((high - low + aperture.pitch) / 2.0).to_array(),
        }
    }

    fn contains(&self, point: DVec3) -> bool {
        let r = self.beam.dot(self.focus - self.middle);
        let s = self.beam.dot(point - self.middle);
        if s <= 0.0 {
            return false;
        }
        let widest = self.half[0].max(self.half[1]);
        let path = |s: f64| s.hypot(widest) - s;
        let along = (path(s) - path(r)) / self.wavelength;
        let across = |axis: usize| {
            let (half, t) = (self.half[axis], self.sides[axis].dot(point - self.focus));
            // Nearer than its focus a beam is no narrower than there.
            2.0 * half * t / (MARGIN * self.wavelength * s.max(r).hypot(half))
        };
        along.powi(2) + across(0).powi(2) + across(1).powi(2) < 1.0
    }
}
