//! One element: its complex pressure at a point per unit of drive.
//!
//! Pressure is p(t) = Re{P e^{+jωt}} with P the complex peak amplitude, and the far field of an element is
//! P = S · D(θ)/r · j e^{-jkr} · e^{-αr} with S = ρ u a² ω/2 for a piston of surface velocity u: equation (1) of
//! Long et al. 2022. The element lies in z = 0 in a rigid baffle: nothing is radiated to z < 0.

use std::f64::consts::PI;
use std::sync::LazyLock;

use glam::{DVec2, DVec3};
use num_complex::Complex64;

use crate::scene::ElementModel;
use crate::scene::directivity::{self as table, Series};
use crate::special::gauss_legendre;

/// m. Far fields diverge at the element, so heights above the array are clamped to this value. A point this little
/// behind the array counts as in front, to be robust against rounding.
pub const NEAREST: f64 = 1e-5;
/// m. Smaller disks are treated as points: no point is close enough to tell the difference.
const SMALLEST_DISK: f64 = 1e-9;
/// Relative error of the exact piston's integral requested from [`piston_nodes`] in f64.
const PISTON_ERROR: f64 = 1e-14;
/// Number of midpoint nodes beyond which panels need fewer.
const MOST_MIDPOINTS: usize = 400;
/// Nodes of a panel, and the largest phase (rad) of its wave: an error of 1e-15.
const PANEL: usize = 32;
const TURN_OF_PANEL: f64 = 48.0;
/// Smallest width of the first panel, rad: closer to the rim there is no structure.
const FINEST_PANEL: f64 = 1e-8;

/// An element and the wave it sends out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Element {
    pub model: ElementModel,
    /// rad/m
    pub wavenumber: f64,
    /// m
    pub radius: f64,
    /// m, width and height of a rectangle.
    #[doc(hidden)]
    pub size: DVec2,
    /// n of cosⁿθ.
    #[doc(hidden)]
    pub exponent: f64,
    /// Coefficients of a measured directivity.
    #[doc(hidden)]
    pub measured: Series,
    /// Pa·m, peak, on axis at full drive
    pub strength: f64,
    /// Np/m
    pub attenuation: f64,
}

/// The form of an element's wave, which every evaluator implements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Radiator {
    /// A point source, the same in all directions.
    Monopole,
    /// The far field of a baffled disk with this radius, m.
    Piston(f64),
    /// The near and far field of such a disk.
    Disk(f64),
    /// The far field of a baffled rectangle of this width and height, m.
    Rectangle(DVec2),
    /// cosⁿθ
    Cosine(f64),
    /// A sum of Chebyshev polynomials in 2 cosθ - 1.
    Measured,
}

/// A directivity towards a point, and its derivatives by the components of the unit vector there, in the element's axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pattern {
    pub value: Complex64,
    pub slopes: [Complex64; 3],
}

impl Element {
    pub fn radiator(&self) -> Radiator {
        match self.model {
            ElementModel::Point => Radiator::Monopole,
            ElementModel::Piston => Radiator::Piston(self.radius),
            ElementModel::ExactPiston if self.radius < SMALLEST_DISK => Radiator::Monopole,
            ElementModel::ExactPiston => Radiator::Disk(self.radius),
            ElementModel::Rectangle => Radiator::Rectangle(self.size),
            ElementModel::Cosine => Radiator::Cosine(self.exponent),
            ElementModel::Measured => Radiator::Measured,
        }
    }

    /// m: the radius of a piston whose directivity is as steep; 0 of points, and of disks, which are none.
    pub(crate) fn steepness(&self) -> f64 {
        /// Largest slope of 2 J1(x)/x.
        const OF_PISTON: f64 = 0.36;
        const ANGLES: u32 = 180;
        match self.radiator() {
            Radiator::Monopole | Radiator::Disk(_) => 0.0,
            Radiator::Piston(radius) => radius,
            // Along a diagonal, two sincs multiply.
            Radiator::Rectangle(size) => size.length() / 2.0,
            Radiator::Cosine(_) | Radiator::Measured => {
                let slope = |i: u32| {
                    let angle = PI / 2.0 * (f64::from(i) - 0.5) / f64::from(ANGLES);
                    let pattern = self.pattern(DVec3::new(angle.sin(), 0.0, angle.cos()));
                    (pattern.slopes[2] * angle.sin()).norm()
                };
                (1..=ANGLES).map(slope).fold(0.0, f64::max) / (OF_PISTON * self.wavenumber)
            }
        }
    }

    /// Complex pressure (Pa, peak) at `offset` (m) from the element's centre, driven fully and with phase 0.
    pub fn transfer(&self, offset: DVec3) -> Complex64 {
        if offset.z < -NEAREST {
            return Complex64::ZERO;
        }
        let lowest = match self.radiator() {
            Radiator::Monopole
            | Radiator::Piston(_)
            | Radiator::Rectangle(_)
            | Radiator::Cosine(_)
            | Radiator::Measured => NEAREST,
            Radiator::Disk(_) => 0.0,
        };
        let (rho, z) = (offset.truncate().length(), offset.z.max(lowest));
        let r = (rho * rho + z * z).sqrt();
        let wave = match self.radiator() {
            Radiator::Monopole => spherical(self.wavenumber, r),
            Radiator::Piston(_) => spherical(self.wavenumber, r) * self.directivity(rho / r),
            Radiator::Disk(radius) => self.disk(radius, rho, z),
            Radiator::Rectangle(_) | Radiator::Cosine(_) | Radiator::Measured => {
                spherical(self.wavenumber, r) * self.pattern(offset.with_z(z) / r).value
            }
        };
        wave * self.strength * (-self.attenuation * r).exp()
    }

    /// The same of an element that radiates along `normal`, a unit vector, with its x axis along `aside`, another.
    pub fn towards(&self, offset: DVec3, normal: DVec3, aside: DVec3) -> Complex64 {
        let height = offset.dot(normal);
        let across = match self.radiator() {
            Radiator::Rectangle(_) => DVec2::new(offset.dot(aside), offset.dot(normal.cross(aside))),
            Radiator::Monopole
            | Radiator::Piston(_)
            | Radiator::Disk(_)
            | Radiator::Cosine(_)
            | Radiator::Measured => DVec2::new((offset - normal * height).length(), 0.0),
        };
        self.transfer(across.extend(height))
    }

    /// The far field towards a direction, a unit vector, of an element that radiates along `normal`, with its x axis along
    /// `aside`: the limit of r e^{jkr} P without absorption, in Pa·m.
    pub(crate) fn far(&self, direction: DVec3, normal: DVec3, aside: DVec3) -> Complex64 {
        let height = direction.dot(normal);
        if height < 0.0 {
            return Complex64::ZERO;
        }
        let directivity = match self.radiator() {
            Radiator::Monopole | Radiator::Piston(_) | Radiator::Disk(_) => {
                self.directivity(direction.cross(normal).length()).into()
            }
            Radiator::Rectangle(_) | Radiator::Cosine(_) | Radiator::Measured => {
                let across = DVec2::new(direction.dot(aside), direction.dot(normal.cross(aside)));
                self.pattern(across.extend(height)).value
            }
        };
        Complex64::I * self.strength * directivity
    }

    /// The modulus of the directivity at an angle from the axis; of a rectangle along its width. D = 2 J1(x)/x with x = ka sinθ
    /// of a piston.
    pub fn directivity(&self, sin: f64) -> f64 {
        match self.radiator() {
            Radiator::Monopole => 1.0,
            Radiator::Piston(radius) | Radiator::Disk(radius) => directivity(self.wavenumber * radius * sin),
            Radiator::Rectangle(_) | Radiator::Cosine(_) | Radiator::Measured => {
                self.pattern(DVec3::new(sin, 0.0, (1.0 - sin * sin).max(0.0).sqrt())).value.norm()
            }
        }
    }

    /// The modulus of the directivity towards an offset from an element with a normal and an x axis; 0 behind it.
    #[doc(hidden)]
    pub fn loudness(&self, offset: DVec3, normal: DVec3, aside: DVec3) -> f64 {
        let (height, r) = (offset.dot(normal), offset.length());
        match self.radiator() {
            _ if height <= 0.0 => 0.0,
            Radiator::Rectangle(_) => {
                let towards = [aside, normal.cross(aside), normal].map(|axis| axis.dot(offset) / r);
                self.pattern(DVec3::from_array(towards)).value.norm()
            }
            Radiator::Monopole
            | Radiator::Piston(_)
            | Radiator::Disk(_)
            | Radiator::Cosine(_)
            | Radiator::Measured => self.directivity((offset - normal * height).length() / r).abs(),
        }
    }

    /// D towards a unit vector in the element's axes, of a height above 0; 1 for forms of another kind.
    pub(super) fn pattern(&self, towards: DVec3) -> Pattern {
        let real = |value: f64, slopes: [f64; 3]| Pattern {
            value: value.into(),
            slopes: slopes.map(Complex64::from),
        };
        match self.radiator() {
            Radiator::Monopole | Radiator::Piston(_) | Radiator::Disk(_) => real(1.0, [0.0; 3]),
            Radiator::Rectangle(size) => {
                let half = size * (self.wavenumber / 2.0);
                let ([x, dx], [y, dy]) =
                    (sinc_with_slope(half.x * towards.x), sinc_with_slope(half.y * towards.y));
                real(x * y, [half.x * dx * y, half.y * dy * x, 0.0])
            }
            Radiator::Cosine(exponent) => {
                let value = towards.z.powf(exponent);
                real(value, [0.0, 0.0, exponent * value / towards.z])
            }
            Radiator::Measured => {
                let [value, slope] = table::with_slope(&self.measured, towards.z);
                let [value, slope] = [value, slope].map(|[re, im]| Complex64::new(re, im));
                Pattern { value, slopes: [Complex64::ZERO, Complex64::ZERO, slope] }
            }
        }
    }

    /// A baffled disk of radius `a` by McGough's single integral (JASA 115:1942, 2004), per unit strength and without
    /// absorption, at distance `rho` from the axis and `z` from the plane.
    ///
    /// The difference of exponentials over the squared distance to the rim is written as a sinc, which removes the
    /// removable singularity of the textbook form.
    fn disk(&self, a: f64, rho: f64, z: f64) -> Complex64 {
        let k = self.wavenumber;
        let integrand = |psi: f64| {
            let sin_half2 = (psi / 2.0).sin().powi(2);
            let rim_squared = (rho - a).powi(2) + 4.0 * a * rho * sin_half2;
            let path = (rim_squared + z * z).sqrt() + z;
            let sinc = sinc(0.5 * k * rim_squared / path);
            let across = a - rho + 2.0 * rho * sin_half2;
            Complex64::from_polar(across / path * sinc, PI / 2.0 - 0.5 * k * path)
        };
        let nodes = piston_nodes(k * a, rho / a, z / a, PISTON_ERROR);
        let mean = if nodes <= MOST_MIDPOINTS {
            let midpoints = (0..nodes).map(|node| integrand(PI * (node as f64 + 0.5) / nodes as f64));
            midpoints.sum::<Complex64>() / nodes as f64
        } else {
            by_panels(strip(rho / a, z / a), k * a.min(rho), integrand) / PI
        };
        mean * (2.0 / a)
    }
}

/// The integral of a wave over ψ from 0 to π by Gauss's rule on panels that double their width, for a wave analytic
/// up to a distance `near` from ψ = 0, with a phase rate of at most `rate` rad per rad.
fn by_panels(near: f64, rate: f64, integrand: impl Fn(f64) -> Complex64) -> Complex64 {
    let mut sum = Complex64::ZERO;
    let (mut start, mut end) = (0.0, near.clamp(FINEST_PANEL, PI));
    while start < PI {
        let parts = (rate * (end - start) / TURN_OF_PANEL).ceil().max(1.0) as usize;
        let half = (end - start) / parts as f64 / 2.0;
        for part in 0..parts {
            let middle = start + half * (2 * part + 1) as f64;
            let at = |&(place, weight): &(f64, f64)| integrand(middle + half * place) * weight;
            sum += GAUSS.iter().map(at).sum::<Complex64>() * half;
        }
        (start, end) = (end, (2.0 * end).min(PI));
    }
    sum
}

/// Gauss's rule for a panel.
static GAUSS: LazyLock<Vec<(f64, f64)>> = LazyLock::new(|| gauss_legendre(PANEL));

/// Number of midpoint nodes for a relative error of about `error` of the piston's integral.
///
/// `ka` is the wavenumber times the radius, `rho` and `z` the point in radii. The integrand is periodic and analytic
/// in a strip about the real axis, so the midpoint rule converges as e^{-2nτ} times the integrand's growth e^{ka sinh
/// τ} for every τ inside the strip, whose half-width depends on the distance to the rim.
pub fn piston_nodes(ka: f64, rho: f64, z: f64, error: f64) -> usize {
    let digits = -error.ln();
    // The τ at which growth and accuracy balance for large ka.
    let tau = (0.9 * strip(rho, z)).min((3.0 * digits / ka).cbrt().min(2.0)).max(f64::MIN_POSITIVE);
    // The factor in front of the exponential grows like one over the distance to the strip's edge.
    let growth = ka * tau.sinh() + (2.0 / tau).ln();
    (((digits + growth) / (2.0 * tau)).ceil() as usize).max(2)
}

/// Half the width of the strip in which the piston's integrand is analytic: cosh η = (ρ² + 1 + z²)/2ρ.
fn strip(rho: f64, z: f64) -> f64 {
    let excess = ((rho - 1.0).powi(2) + z * z) / (2.0 * rho.max(1e-12));
    // acosh(1 + e) without the loss of small e.
    (excess + (excess * (2.0 + excess)).sqrt()).ln_1p()
}

fn spherical(wavenumber: f64, r: f64) -> Complex64 {
    Complex64::from_polar(1.0 / r, PI / 2.0 - wavenumber * r)
}

/// 2 J1(x)/x.
pub fn directivity(x: f64) -> f64 {
    if x.abs() < 1e-4 { 1.0 - x * x / 8.0 } else { 2.0 * libm::j1(x) / x }
}

/// sin x/x.
pub(crate) fn sinc(x: f64) -> f64 {
    if x.abs() < 1e-4 { 1.0 - x * x / 6.0 } else { x.sin() / x }
}

/// sin x/x and its derivative.
fn sinc_with_slope(x: f64) -> [f64; 2] {
    /// Below, cosine and sinc are too much alike, and this series is right to 1e-16.
    const SMALL: f64 = 0.5;
    let square = x * x;
    let slope = if x.abs() < SMALL {
        // Σ (-1)ⁿ 2n/(2n + 1)! x²ⁿ⁻¹
        let terms =
            [-1.0 / 3.0, 1.0 / 30.0, -1.0 / 840.0, 1.0 / 45_360.0, -1.0 / 3_991_680.0, 1.0 / 518_918_400.0];
        x * terms.iter().rev().fold(0.0, |sum, term| sum * square + term)
    } else {
        (x.cos() - x.sin() / x) / x
    };
    [sinc(x), slope]
}

#[cfg(test)]
mod tests {
    use strum::VariantArray;

    use super::*;

    fn element(model: ElementModel) -> Element {
        let size = DVec2::new(0.008, 0.003);
        let (wavenumber, exponent, measured) = (732.7, 1.3, table::EVEN);
        Element {
            model,
            wavenumber,
            radius: 0.005,
            size,
            exponent,
            measured,
            strength: 1.0,
            attenuation: 0.0,
        }
    }

    #[test]
    fn the_exact_piston_meets_its_closed_form_on_the_axis() {
        let element = element(ElementModel::ExactPiston);
        for z in [NEAREST, 1e-4, 0.003, 0.05, 0.5] {
            let (k, a) = (element.wavenumber, element.radius);
            let rim = f64::hypot(z, a);
            // 2 ρcU |sin(k(R - z)/2)| with ρcU = 2S/(k a²)
            let amplitude = 4.0 / (k * a * a) * (0.5 * k * a * a / (rim + z)).sin();
            let expected = Complex64::from_polar(amplitude, PI / 2.0 - 0.5 * k * (rim + z));
            let got = element.transfer(DVec3::new(0.0, 0.0, z));
            assert!((got - expected).norm() < 1e-12 * amplitude.abs(), "z = {z}: {got} {expected}");
        }
    }

    /// The far field of a rectangle is the Fourier transform of its surface: Gauss's rule over the rectangle of e^{jk(ux + vy)}.
    #[test]
    fn the_rectangle_is_the_transform_of_its_surface() {
        let element = element(ElementModel::Rectangle);
        for (u, v) in [(0.0, 0.0), (0.3, -0.2), (-0.9, 0.1), (1e-5, 0.999), (0.6, 0.6)] {
            let z = f64::sqrt(1.0 - u * u - v * v);
            let along = |half: f64, u: f64| {
                let part = |(x, weight): (f64, f64)| {
                    Complex64::cis(element.wavenumber * u * half * x) * weight / 2.0
                };
                gauss_legendre(40).into_iter().map(part).sum::<Complex64>()
            };
            let transform = along(0.004, u) * along(0.0015, v);
            let expected = spherical(element.wavenumber, 0.1) * transform;
            let got = element.transfer(DVec3::new(u, v, z) * 0.1);
            assert!((got - expected).norm() < 1e-12 * 10.0, "({u}, {v}): {got} {expected}");
            // Towards a normal, with its own x axis.
            let (normal, aside) = (DVec3::new(0.6, 0.0, 0.8), DVec3::new(0.8, 0.0, -0.6));
            let turned = (aside * u + normal.cross(aside) * v + normal * z) * 0.1;
            assert!((element.towards(turned, normal, aside) - got).norm() < 1e-11, "({u}, {v})");
        }
    }

    #[test]
    fn slopes_of_directivities_are_their_differences() {
        let models = [ElementModel::Rectangle, ElementModel::Cosine, ElementModel::Measured];
        for mut element in models.map(element) {
            element.measured[3] = [0.4, -0.2];
            for towards in [DVec3::new(0.3, -0.5, 0.4), DVec3::new(1e-3, 0.2, 0.9)] {
                let own = element.pattern(towards);
                for axis in 0..3 {
                    let step = DVec3::AXES[axis] * 1e-5;
                    let [ahead, behind] =
                        [towards + step, towards - step].map(|at| element.pattern(at).value);
                    let off = (own.slopes[axis] - (ahead - behind) / 2e-5).norm();
                    assert!(off < 1e-8, "{:?} {towards}, {axis}: {own:?}", element.model);
                }
            }
        }
    }

    #[test]
    fn the_stated_error_of_the_piston_is_kept() {
        let ka: f64 = 3.7;
        let sum = |nodes: usize, rho: f64, z: f64| -> Complex64 {
            let terms = (0..nodes).map(|i| {
                let psi = PI * (i as f64 + 0.5) / nodes as f64;
                let path = (1.0 + rho * rho - 2.0 * rho * psi.cos() + z * z).sqrt() + z;
                let rim_squared = path * (path - 2.0 * z);
                Complex64::from_polar(
                    (1.0 - rho * psi.cos()) / path * sinc(0.5 * ka * rim_squared / path),
                    -0.5 * ka * path,
                )
            });
            terms.sum::<Complex64>() / nodes as f64
        };
        for (rho, z) in [
            (0.3, 0.2),
            (0.9, 0.3),
            (1.5, 0.1),
            (3.0, 1.0),
            (20.0, 20.0),
            (40.0, 0.1),
            (1.0, 0.03),
            (0.98, 0.01),
            (1.03, 0.003),
        ] {
            let truth = sum(2000, rho, z);
            for error in [1e-2, 1e-3, 1e-6, 1e-9] {
                let nodes = piston_nodes(ka, rho, z, error);
                let scale = 1.0 / (rho * rho + z * z).sqrt().max(1.0);
                let reached = (sum(nodes, rho, z) - truth).norm() / scale;
                assert!(reached < error, "({rho}, {z}) {error}: {nodes} nodes reach {reached}");
            }
        }
    }

    #[test]
    fn the_directivity_has_its_limit_and_its_null() {
        assert_eq!(directivity(0.0), 1.0);
        assert!(directivity(1.1e-4) < directivity(0.9e-4) && directivity(0.9e-4) < 1.0);
        assert!(directivity(3.831_705_970_207_512).abs() < 1e-15);
    }

    #[test]
    fn nothing_is_radiated_backwards_and_nothing_is_infinite() {
        for &model in ElementModel::VARIANTS {
            let element = element(model);
            assert_eq!(element.transfer(DVec3::new(0.0, 0.01, -0.01)), Complex64::ZERO);
            for offset in [DVec3::ZERO, DVec3::new(0.005, 0.0, 0.0), DVec3::new(0.0, 0.0, -1e-7)] {
                assert!(element.transfer(offset).is_finite(), "{model:?} {offset}");
            }
        }
    }

    #[test]
    fn absorption_is_what_the_medium_says() {
        let lossy = Element { attenuation: 0.5, ..element(ElementModel::Piston) };
        let offset = DVec3::new(0.1, 0.0, 0.2);
        let ratio = lossy.transfer(offset) / element(ElementModel::Piston).transfer(offset);
        assert!((ratio - (-0.5 * offset.length()).exp()).norm() < 1e-14);
    }

    #[test]
    fn the_sinc_falls_from_its_limit_to_its_null() {
        assert_eq!(sinc(0.0), 1.0);
        assert!(sinc(1.1e-4) < sinc(0.9e-4) && sinc(0.9e-4) < 1.0);
        assert!(sinc(PI).abs() < 1e-15);
    }
}
