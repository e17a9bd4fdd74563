//! The pressure at a point with all its derivatives up to the third order.

use std::ops::{AddAssign, Mul};

use num_complex::Complex64;

/// Number of derivatives of the orders 0, 1, 2 and 3.
pub(super) const COUNT: usize = 1 + 3 + 6 + 10;
/// Index of a second derivative among these, by its two axes.
pub(super) const SECOND: [[usize; 3]; 3] = [[4, 5, 6], [5, 7, 8], [6, 8, 9]];
/// The axes of the second derivatives, in their order.
pub(super) const PAIRS: [[usize; 2]; 6] = [[0, 0], [0, 1], [0, 2], [1, 1], [1, 2], [2, 2]];
/// The axes of the third derivatives, in their order.
pub(super) const TRIPLES: [[usize; 3]; 10] = [
    [0, 0, 0],
    [0, 0, 1],
    [0, 0, 2],
    [0, 1, 1],
    [0, 1, 2],
    [0, 2, 2],
    [1, 1, 1],
    [1, 1, 2],
    [1, 2, 2],
    [2, 2, 2],
];
/// Index of a third derivative, by the index of a second derivative and another axis.
const THIRD: [[usize; 3]; 6] =
    [[10, 11, 12], [11, 13, 14], [12, 14, 15], [13, 16, 17], [14, 17, 18], [15, 18, 19]];

/// Complex peak amplitudes along the scene's axes: Pa, Pa/m, Pa/m², Pa/m³.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Derivatives(pub(super) [Complex64; COUNT]);

impl Derivatives {
    pub const COUNT: usize = COUNT;

    /// All of them, by their order and then by their axes.
    pub fn values(&self) -> &[Complex64; COUNT] {
        &self.0
    }

    /// The derivatives of a field, from a function of the orders in x, y and z.
    pub fn of(derivative: impl Fn([u32; 3]) -> Complex64) -> Self {
        let along = |axes: &[usize]| {
            let mut orders = [0; 3];
            axes.iter().for_each(|&axis| orders[axis] += 1);
            derivative(orders)
        };
        let mut all = [derivative([0; 3]); COUNT];
        (0..3).for_each(|axis| all[1 + axis] = along(&[axis]));
        PAIRS.iter().zip(&mut all[4..]).for_each(|(pair, to)| *to = along(pair));
        TRIPLES.iter().zip(&mut all[10..]).for_each(|(triple, to)| *to = along(triple));
        Self(all)
    }

    /// Pa
    pub fn pressure(&self) -> Complex64 {
        self.0[0]
    }

    /// ∂p/∂xᵢ, Pa/m
    pub fn slope(&self, i: usize) -> Complex64 {
        self.0[1 + i]
    }

    /// ∂²p/∂xᵢ∂xⱼ, Pa/m²
    pub fn second(&self, i: usize, j: usize) -> Complex64 {
        self.0[SECOND[i][j]]
    }

    /// ∂³p/∂xᵢ∂xⱼ∂xₖ, Pa/m³
    pub fn third(&self, i: usize, j: usize, k: usize) -> Complex64 {
        self.0[THIRD[SECOND[i][j] - 4][k]]
    }

    /// Derivatives along a direction.
    pub(crate) fn along(&self, v: [f64; 3]) -> Along {
        let sum = |of: &dyn Fn(usize) -> Complex64| (0..3).map(|j| of(j) * v[j]).sum::<Complex64>();
        let slopes = [0, 1, 2].map(|i| sum(&|j| self.second(i, j)));
        let seconds = [0, 1, 2].map(|i| sum(&|j| sum(&|k| self.third(i, j, k))));
        Along {
            pressure: self.pressure(),
            own: [0, 1, 2].map(|i| self.slope(i)),
            first: sum(&|j| self.slope(j)),
            slopes,
            second: sum(&|i| slopes[i]),
            seconds,
        }
    }

    /// Σ conj(g) d over all of them.
    pub fn product(&self, other: &Self) -> Complex64 {
        self.0.iter().zip(&other.0).map(|(own, other)| own.conj() * other).sum()
    }

    /// Derivatives of the product of two fields, by Leibniz's rule.
    pub(super) fn times(&self, other: &Self) -> Self {
        let (a, b) = (self, other);
        let mut product = Self::default();
        product.0[0] = a.pressure() * b.pressure();
        for i in 0..3 {
            product.0[1 + i] = a.slope(i) * b.pressure() + a.pressure() * b.slope(i);
        }
        for (&[i, j], to) in PAIRS.iter().zip(&mut product.0[4..]) {
            *to = a.second(i, j) * b.pressure()
                + a.slope(i) * b.slope(j)
                + a.slope(j) * b.slope(i)
                + a.pressure() * b.second(i, j);
        }
        for (&[i, j, k], to) in TRIPLES.iter().zip(&mut product.0[10..]) {
            *to = a.third(i, j, k) * b.pressure() + a.pressure() * b.third(i, j, k);
            for (i, j, k) in [(i, j, k), (i, k, j), (j, k, i)] {
                *to += a.second(i, j) * b.slope(k) + a.slope(k) * b.second(i, j);
            }
        }
        product
    }
}

impl From<[Complex64; COUNT]> for Derivatives {
    /// The derivatives with these values, in the order of [`Derivatives::values`].
    fn from(values: [Complex64; COUNT]) -> Self {
        Self(values)
    }
}

impl AddAssign for Derivatives {
    fn add_assign(&mut self, other: Self) {
        self.0.iter_mut().zip(other.0).for_each(|(own, other)| *own += other);
    }
}

impl Mul<Complex64> for Derivatives {
    type Output = Self;

    fn mul(self, factor: Complex64) -> Self {
        Self(self.0.map(|own| own * factor))
    }
}

/// Derivatives of the pressure along a direction v.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Along {
    pub pressure: Complex64,
    /// ∂ᵢp
    pub own: [Complex64; 3],
    /// ∂ᵥp, ∂ᵢ∂ᵥp
    pub first: Complex64,
    pub slopes: [Complex64; 3],
    /// ∂ᵥ²p, ∂ᵢ∂ᵥ²p
    pub second: Complex64,
    pub seconds: [Complex64; 3],
}

impl Along {
    /// Factors of the derivatives along the axes that correspond to these factors.
    pub fn spread(&self, v: [f64; 3]) -> Derivatives {
        let mut all = Derivatives::default();
        all.0[0] = self.pressure;
        for i in 0..3 {
            all.0[1 + i] += self.own[i] + self.first * v[i];
            for j in 0..3 {
                all.0[SECOND[i][j]] += self.slopes[i] * v[j] + self.second * (v[i] * v[j]);
                for k in 0..3 {
                    all.0[THIRD[SECOND[i][j] - 4][k]] += self.seconds[i] * (v[j] * v[k]);
                }
            }
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_product_of_waves_is_the_wave_of_their_sum() {
        let wave = |rates: [Complex64; 3]| {
            Derivatives::of(|orders| (0..3).map(|axis| rates[axis].powu(orders[axis])).product())
        };
        let [re, im] = [[0.3, -0.7, 1.1], [-0.9, 0.4, 0.6]];
        let a = [0, 1, 2].map(|axis| Complex64::new(re[axis], im[axis]));
        let b = [0, 1, 2].map(|axis| Complex64::new(-im[axis], 2.0 * re[axis]));
        let own = wave(a).times(&wave(b));
        let expected = wave([0, 1, 2].map(|axis| a[axis] + b[axis]));
        for (at, (own, expected)) in own.0.iter().zip(expected.0).enumerate() {
            assert!((own - expected).norm() < 1e-13, "{at}: {own}, not {expected}");
        }
    }
}
