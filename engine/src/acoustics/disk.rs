//! The exact piston as outgoing partial waves about its centre, for rows of the transfer.
//!
//! The mean of e^{-jkR}/R over a disk of radius a is e^{-jkr}/r Σ w_l h_l(kr)/h_0(kr) P_l(cosθ) over even l, with
//! w_l = (2l + 1) P_l(0) 2/a² ∫ j_l(kρ) ρ dρ, by the addition theorem. It converges as (a/r)^l.

use num_complex::Complex64;

use crate::simd::{Instructions, Kernel, fused64, lanes};
use crate::special::bessel;
use crate::special::gauss_legendre as legendre;
use crate::special::series::LANES;

/// Radii from an element beyond which its wave is this sum.
pub(super) const CLEAR: f64 = 4.0;
/// Orders that reach [`ACCURACY`] at that distance, for any ka that rows accept.
const MOST: usize = 48;
const ACCURACY: f64 = 1e-15;
/// Largest ka with so few orders.
const LARGEST: f64 = 16.0;
/// Nodes of the integral of a coefficient.
const NODES: usize = 32;

/// The coefficients of a disk.
#[derive(Clone, Debug)]
pub(super) struct Disk {
    wavenumber: f64,
    radius: f64,
    /// w_l of even l.
    weights: Vec<f64>,
    /// Orders needed from 1, 2, 4 … times the clear distance on.
    orders: [usize; 5],
}

impl Disk {
    pub fn new(wavenumber: f64, radius: f64) -> Self {
        let mut means = vec![0.0; MOST + 1];
        for (x, weight) in legendre(NODES) {
            let part = f64::midpoint(x, 1.0);
            let values = bessel::spherical(MOST, wavenumber * radius * part);
            means.iter_mut().zip(values).for_each(|(mean, value)| *mean += weight * part * value);
        }
        let mut at_zero = 1.0;
        let weight = |l: usize| {
            if l > 0 {
                at_zero *= -((l - 1) as f64) / l as f64;
            }
            (2 * l + 1) as f64 * at_zero * means[l]
        };
        let weights: Vec<_> = (0..=MOST).step_by(2).map(weight).collect();
        let orders = [0, 1, 2, 3, 4].map(|power| {
            let x = wavenumber * radius * CLEAR * f64::from(1 << power);
            let sizes =
                sizes(x).into_iter().step_by(2).zip(&weights).map(|(size, weight)| size * weight.abs());
            2 * sizes.collect::<Vec<_>>().iter().rposition(|size| *size > ACCURACY).unwrap_or(0)
        });
        Self { wavenumber, radius, weights, orders }
    }

    /// Whether the coefficients of the orders at hand are all that count.
    pub fn is_series(&self) -> bool {
        self.wavenumber * self.radius <= LARGEST
    }

    /// m: from here on, elements are clear.
    pub fn clear(&self) -> f64 {
        CLEAR * self.radius
    }

    /// Orders for elements at this distance (m) or farther.
    fn order(&self, distance: f64) -> usize {
        let power = (distance / self.clear()).max(1.0).log2() as usize;
        self.orders[power.min(self.orders.len() - 1)]
    }
}

/// |h_l/h_0| at x.
fn sizes(x: f64) -> Vec<f64> {
    let mut all = vec![Complex64::ONE, Complex64::new(1.0 / x, 1.0)];
    for l in 1..MOST {
        all.push(all[l] * ((2 * l + 1) as f64 / x) - all[l - 1]);
    }
    all.into_iter().map(Complex64::norm).collect()
}

/// Turns waves of point sources into those of disks at the same places. Elements that are not clear get values without
/// meaning.
pub(super) struct FromPoints<'a> {
    pub disk: &'a Disk,
    /// m: the way from each element, and its height along the element's normal.
    pub ways: &'a dyn Fn(usize) -> (f64, f64),
    pub nearest: f64,
    pub re: &'a mut [f64],
    pub im: &'a mut [f64],
}

impl Kernel for FromPoints<'_> {
    type Output = ();

    #[inline(always)]
    fn run<I: Instructions>(self) {
        let Self { disk, ways, nearest, re, im } = self;
        let order = disk.order(nearest);
        for (block, (re, im)) in re.chunks_exact_mut(LANES).zip(im.chunks_exact_mut(LANES)).enumerate() {
            let (mut inverse, mut cosine) = ([0.0; LANES], [0.0; LANES]);
            for lane in 0..LANES {
                let (square, height) = ways(block * LANES + lane);
                let r = square.sqrt().max(disk.clear());
                (inverse[lane], cosine[lane]) = (1.0 / (disk.wavenumber * r), height / r);
            }
            let mut last = ([1.0; LANES], [0.0; LANES], [1.0; LANES]);
            let mut this = (inverse, [1.0; LANES], cosine);
            let mut sum = ([disk.weights[0]; LANES], [0.0; LANES]);
            for l in (1..order).step_by(2) {
                for l in [l, l + 1] {
                    let (twice, up, down) =
                        ((2 * l + 1) as f64, (2 * l + 1) as f64 / (l + 1) as f64, l as f64 / (l + 1) as f64);
                    let x = lanes::<LANES>(|i| twice * inverse[i]);
                    let next = (
                        lanes::<LANES>(|i| fused64::<I>(x[i], this.0[i], -last.0[i])),
                        lanes::<LANES>(|i| fused64::<I>(x[i], this.1[i], -last.1[i])),
                        lanes::<LANES>(|i| fused64::<I>(up * cosine[i], this.2[i], -down * last.2[i])),
                    );
                    (last, this) = (this, next);
                }
                // `last` has the even order l + 1.
                let weight = disk.weights[l.div_ceil(2)];
                let part = lanes::<LANES>(|i| weight * last.2[i]);
                sum.0 = lanes(|i| fused64::<I>(part[i], last.0[i], sum.0[i]));
                sum.1 = lanes(|i| fused64::<I>(part[i], last.1[i], sum.1[i]));
            }
            for lane in 0..LANES {
                let (a, b) = (re[lane], im[lane]);
                re[lane] = a * sum.0[lane] - b * sum.1[lane];
                im[lane] = a * sum.1[lane] + b * sum.0[lane];
            }
        }
    }
}
