//! Partial waves about many points of a plane, from the pressure and its first two normal slopes on the plane.
//!
//! A coefficient is a derivative: a = 4π 𝒴(∇)p/kⁿ, with 𝒴 the harmonic as a homogeneous polynomial of its degree. Of
//! third and higher powers of ∂z, ∂z² is -k² - ∂x² - ∂y², so derivatives along the plane suffice: those of the
//! interpolating sinc, which is band-limited as the sound is. The second normal slope is kept, since the sound of far-field
//! pistons is not quite a wave.

use std::f64::consts::PI;
use std::ops::Range;

use num_complex::Complex32;

use crate::acoustics::{PartialWaves, couplings};
use crate::force::Sphere;
use crate::simd::{Instructions, Kernel};

/// Orders along the normal that are not replaced.
pub const NORMALS: usize = 3;
/// Points processed together.
const LANES: usize = 16;

/// A derivative of the sound: its orders along x, y and the normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Derivative {
    pub orders: [usize; 2],
    pub normal: usize,
}

/// The derivatives that partial waves up to an order need.
pub fn derivatives(order: usize) -> Vec<Derivative> {
    let of_normal = |normal: usize| {
        let most = order - normal;
        let pairs = (0..=most).flat_map(move |x| (0..=most - x).map(move |y| [x, y]));
        pairs.map(move |orders| Derivative { orders, normal })
    };
    (0..NORMALS.min(order + 1)).flat_map(of_normal).collect()
}

/// A polynomial in X, Y and Z, the derivatives over k, with Z³ = -(1 + X² + Y²) Z: the coefficients of XⁱYʲ, XⁱYʲZ and XⁱYʲZ².
#[derive(Clone, Debug)]
struct Polynomial {
    degree: usize,
    coefficients: [Vec<f64>; NORMALS],
}

impl Polynomial {
    fn constant(degree: usize, value: f64) -> Self {
        let mut coefficients = [(); NORMALS].map(|()| vec![0.0; (degree + 1).pow(2)]);
        coefficients[0][0] = value;
        Self { degree, coefficients }
    }

    fn zero(&self) -> Self {
        Self::constant(self.degree, 0.0)
    }

    fn add(mut self, other: &Self, factor: f64) -> Self {
        for (own, other) in self.coefficients.iter_mut().flatten().zip(other.coefficients.iter().flatten()) {
            *own += factor * other;
        }
        self
    }

    fn times(&self, orders: [usize; 2]) -> Self {
        let mut product = self.zero();
        let width = self.degree + 1;
        for (to, own) in product.coefficients.iter_mut().zip(&self.coefficients) {
            for (i, value) in own.iter().enumerate().filter(|(_, value)| **value != 0.0) {
                let (x, y) = (i / width + orders[0], i % width + orders[1]);
                to[x * width + y] += value;
            }
        }
        product
    }

    fn times_z(&self) -> Self {
        let [constant, linear, square] = &self.coefficients;
        let none = vec![0.0; constant.len()];
        // Z³
        let cube = Self { coefficients: [none.clone(), square.clone(), none.clone()], ..*self };
        let product = Self { coefficients: [none, constant.clone(), linear.clone()], ..*self };
        product.add(&cube, -1.0).add(&cube.times([2, 0]), -1.0).add(&cube.times([0, 2]), -1.0)
    }

    /// The product with X² + Y² + Z².
    fn times_square(&self) -> Self {
        self.times_z().times_z().add(&self.times([2, 0]), 1.0).add(&self.times([0, 2]), 1.0)
    }
}

/// 4π 𝒴 of every harmonic up to an order.
fn harmonics(order: usize) -> Vec<Polynomial> {
    let one = Polynomial::constant(order, 1.0);
    let mut all = vec![one.zero(); (order + 1).pow(2)];
    // Real and imaginary part of (X + jY)^m.
    let (mut flat, mut first) = ([one.clone(), one.zero()], 4.0 * PI * 0.5 / PI.sqrt());
    for m in 0..=order {
        let norm = if m == 0 { first } else { std::f64::consts::SQRT_2 * first };
        for (part, sign) in [(0, 1), (1, -1)] {
            if m == 0 && part == 1 {
                continue;
            }
            let (mut before, mut this) = (one.zero(), one.zero().add(&flat[part], norm));
            for n in m..=order {
                all[(n * n + n).wrapping_add_signed(sign * m as isize)] = this.clone();
                if n == order {
                    break;
                }
                let (n, m) = ((n + 1) as f64, m as f64);
                let scale = ((4.0 * n * n - 1.0) / (n * n - m * m)).sqrt();
                let last = (((n - 1.0).powi(2) - m * m) / (4.0 * (n - 1.0).powi(2) - 1.0)).sqrt();
                let next = one.zero().add(&this.times_z(), scale).add(&before.times_square(), -scale * last);
                (before, this) = (this, next);
            }
        }
        if m < order {
            first *= ((2 * m + 3) as f64 / (2 * m + 2) as f64).sqrt();
            let [re, im] = &flat;
            flat =
                [re.times([1, 0]).add(&im.times([0, 1]), -1.0), im.times([1, 0]).add(&re.times([0, 1]), 1.0)];
        }
    }
    all
}

/// Potential and force of a bead, from derivatives of the sound or from the sound on a sphere about it.
#[derive(Debug)]
pub struct Formation {
    /// Index of a given value and its weight, per harmonic.
    waves: Vec<Vec<(usize, f32)>>,
    /// U_n of every harmonic.
    potential: Vec<f32>,
    /// Harmonics and entry of the force along each axis.
    force: [Vec<(usize, usize, Complex32)>; 3],
}

impl Formation {
    /// From the derivatives in the order of [`derivatives`], for sound of a wavenumber (rad/m).
    pub fn new(sphere: &Sphere, wavenumber: f64) -> Self {
        let order = sphere.order();
        let derivatives = derivatives(order);
        let of_harmonic = |polynomial: Polynomial| {
            let weight = |(index, derivative): (usize, &Derivative)| {
                let Derivative { orders: [x, y], normal } = *derivative;
                let coefficient = polynomial.coefficients[normal][x * (order + 1) + y];
                let degree = x + y + normal;
                (coefficient != 0.0).then(|| (index, (coefficient / wavenumber.powi(degree as i32)) as f32))
            };
            derivatives.iter().enumerate().filter_map(weight).collect()
        };
        Self::with(sphere, harmonics(order).into_iter().map(of_harmonic).collect())
    }

    /// From the pressures at [`PartialWaves::points`].
    pub fn on_spheres(sphere: &Sphere, wavenumber: f64) -> Self {
        let weights = PartialWaves::weights(sphere.order(), wavenumber * sphere.shell());
        let of_harmonic =
            |weights: Vec<f64>| weights.into_iter().map(|weight| weight as f32).enumerate().collect();
        Self::with(sphere, weights.map(of_harmonic).collect())
    }

    fn with(sphere: &Sphere, waves: Vec<Vec<(usize, f32)>>) -> Self {
        let order = sphere.order();
        let force = couplings(order).each_ref().map(|axis| {
            let entry = |coupling| {
                let entry = sphere.entry(coupling);
                (coupling.lower, coupling.upper, Complex32::new(entry.re as f32, entry.im as f32))
            };
            axis.iter().map(entry).collect()
        });
        let potential = (0..(order + 1).pow(2)).map(|harmonic| sphere.potentials()[harmonic.isqrt()] as f32);
        Self { waves, potential: potential.collect(), force }
    }
}

/// Adds a part of potential (J) and force (N) at a run of points to sums.
pub struct Form<'a> {
    pub formation: &'a Formation,
    /// What the formation begins with, at all points.
    pub given: &'a [Vec<Complex32>],
    /// The run.
    pub points: Range<usize>,
    pub part: f32,
    /// One per point of the run.
    pub potential: &'a mut [f32],
    /// Along x, y and the normal; a value per point of the run, or none.
    pub force: [&'a mut [f32]; 3],
}

impl Kernel for Form<'_> {
    type Output = ();

    #[inline(always)]
    fn run<I: Instructions>(self) {
        let Self { formation, given, points, part, potential, mut force } = self;
        let count = formation.waves.len();
        let mut waves = vec![[[0.0f32; LANES]; 2]; count];
        for start in (points.start..points.end).step_by(LANES) {
            let run = start..points.end.min(start + LANES);
            for (terms, wave) in formation.waves.iter().zip(&mut waves) {
                let [mut re, mut im] = [[0.0f32; LANES]; 2];
                for &(index, weight) in terms {
                    for (lane, value) in given[index][run.clone()].iter().enumerate() {
                        re[lane] += weight * value.re;
                        im[lane] += weight * value.im;
                    }
                }
                *wave = [re, im];
            }
            let to = run.start - points.start..run.end - points.start;
            let mut sum = [0.0f32; LANES];
            for ([re, im], weight) in waves.iter().zip(&formation.potential) {
                for lane in 0..LANES {
                    sum[lane] += weight * (re[lane] * re[lane] + im[lane] * im[lane]);
                }
            }
            potential[to.clone()].iter_mut().zip(sum).for_each(|(to, own)| *to += part * own);
            for (entries, force) in formation.force.iter().zip(&mut force).filter(|(_, to)| !to.is_empty()) {
                let mut sum = [0.0f32; LANES];
                for &(lower, upper, entry) in entries {
                    let ([a, b], [c, d]) = (&waves[lower], &waves[upper]);
                    // Re of the conjugate entry, the conjugate lower and the upper wave.
                    for lane in 0..LANES {
                        sum[lane] += entry.re * (a[lane] * c[lane] + b[lane] * d[lane])
                            + entry.im * (a[lane] * d[lane] - b[lane] * c[lane]);
                    }
                }
                force[to.clone()].iter_mut().zip(sum).for_each(|(to, own)| *to += part * own);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, dvec3};
    use num_complex::Complex64;

    use super::*;
    use crate::acoustics::Air;
    use crate::scene::{Bead, Medium};
    use crate::simd::Isa;

    #[test]
    fn derivatives_form_the_potential_and_force_of_waves() {
        let air = Air::new(&Medium::default(), 40e3);
        let k = 732.0;
        let sphere = Sphere::new(&Bead { radius: 1.5e-3, ..Bead::default() }, &air, k);
        let ways =
            [(dvec3(0.48, -0.64, 0.6), 1.0), (dvec3(-0.36, 0.48, 0.8), 0.7), (dvec3(0.6, 0.0, -0.8), 0.4)];
        let waves = ways.map(|(way, size)| (way, Complex64::from_polar(1000.0 * size, 2.0 * size)));
        let field = |at: &DVec3| -> Complex64 {
            waves.iter().map(|(way, size)| size * Complex64::cis(-k * way.dot(*at))).sum()
        };
        let expected = PartialWaves::new(sphere.order(), k, (DVec3::ZERO, sphere.shell()), |points| {
            points.iter().map(field).collect()
        });
        let value = |derivative: &Derivative| {
            let Derivative { orders: [x, y], normal } = *derivative;
            let of_wave = |(way, size): &(DVec3, Complex64)| {
                let slope = |axis: usize, order: usize| (-Complex64::I * k * way[axis]).powu(order as u32);
                size * slope(0, x) * slope(1, y) * slope(2, normal)
            };
            let sum: Complex64 = waves.iter().map(of_wave).sum();
            vec![Complex32::new(sum.re as f32, sum.im as f32); 3]
        };
        let values: Vec<_> = derivatives(sphere.order()).iter().map(value).collect();
        let (mut potential, mut force) = ([0.0f32; 2], [[0.0f32; 2]; 3]);
        Isa::best().run(Form {
            formation: &Formation::new(&sphere, k),
            given: &values,
            points: 1..3,
            part: 1.0,
            potential: &mut potential,
            force: force.each_mut().map(|axis| &mut axis[..]),
        });
        let (u, f) = (sphere.potential(&expected), sphere.force(&expected));
        for point in [0, 1] {
            assert!((f64::from(potential[point]) / u - 1.0).abs() < 1e-5, "{} J, not {u}", potential[point]);
            let own = DVec3::from_array(force.map(|axis| f64::from(axis[point])));
            assert!(own.distance(f) < 1e-5 * f.length(), "{own} N, not {f}");
        }
    }
}
