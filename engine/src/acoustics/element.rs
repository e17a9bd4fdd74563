//! One element: its complex pressure at a point per unit of drive.
//!
//! Pressure is p(t) = Re{P e^{+jωt}} with P the complex peak amplitude, and the far field of an element is
//! P = S · D(θ)/r · j e^{-jkr} · e^{-αr} with S = ρ u a² ω/2 for a piston of surface velocity u: equation (1) of
//! Long et al. 2022. The element lies in z = 0 in a rigid baffle: nothing is radiated to z < 0.

use std::f64::consts::PI;
use std::sync::LazyLock;

use glam::DVec3;
use num_complex::Complex64;

use crate::acoustics::gauss;
use crate::scene::ElementModel;

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
}

impl Element {
    pub fn radiator(&self) -> Radiator {
        match self.model {
            ElementModel::Point => Radiator::Monopole,
            ElementModel::Piston => Radiator::Piston(self.radius),
            ElementModel::ExactPiston if self.radius < SMALLEST_DISK => Radiator::Monopole,
            ElementModel::ExactPiston => Radiator::Disk(self.radius),
        }
    }

    /// Complex pressure (Pa, peak) at `offset` (m) from the element's centre, driven fully and with phase 0.
    pub fn transfer(&self, offset: DVec3) -> Complex64 {
        if offset.z < -NEAREST {
            return Complex64::ZERO;
        }
        let lowest = match self.radiator() {
            Radiator::Monopole | Radiator::Piston(_) => NEAREST,
            Radiator::Disk(_) => 0.0,
        };
        let (rho, z) = (offset.truncate().length(), offset.z.max(lowest));
        let r = (rho * rho + z * z).sqrt();
        let wave = match self.radiator() {
            Radiator::Monopole => spherical(self.wavenumber, r),
            Radiator::Piston(_) => spherical(self.wavenumber, r) * self.directivity(rho / r),
            Radiator::Disk(radius) => self.disk(radius, rho, z),
        };
        wave * self.strength * (-self.attenuation * r).exp()
    }

    /// The same of an element that radiates along `normal`, a unit vector.
    pub fn towards(&self, offset: DVec3, normal: DVec3) -> Complex64 {
        let height = offset.dot(normal);
        self.transfer(DVec3::new((offset - normal * height).length(), 0.0, height))
    }

    /// The far field towards a direction, a unit vector, of an element that radiates along `normal`: the limit of
    /// r e^{jkr} P without absorption, in Pa·m.
    pub(crate) fn far(&self, direction: DVec3, normal: DVec3) -> Complex64 {
        if direction.dot(normal) < 0.0 {
            return Complex64::ZERO;
        }
        Complex64::I * (self.strength * self.directivity(direction.cross(normal).length()))
    }

    /// D = 2 J1(x)/x with x = ka sinθ.
    pub fn directivity(&self, sin: f64) -> f64 {
        match self.radiator() {
            Radiator::Monopole => 1.0,
            Radiator::Piston(radius) | Radiator::Disk(radius) => directivity(self.wavenumber * radius * sin),
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
static GAUSS: LazyLock<Vec<(f64, f64)>> = LazyLock::new(|| gauss::legendre(PANEL));

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

fn sinc(x: f64) -> f64 {
    if x.abs() < 1e-4 { 1.0 - x * x / 6.0 } else { x.sin() / x }
}

#[cfg(test)]
mod tests {
    use strum::VariantArray;

    use super::*;

    fn element(model: ElementModel) -> Element {
        Element { model, wavenumber: 732.7, radius: 0.005, strength: 1.0, attenuation: 0.0 }
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
