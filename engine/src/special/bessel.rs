//! Bessel functions: the piston's directivity D = 2 J1(x)/x as a function of w = x² with its derivative, and the
//! spherical functions of partial waves.
//!
//! With Eₙ = Jₙ(x)/xⁿ, D = 2 E₁ and dEₙ/dw = -Eₙ₊₁/2.

use crate::simd::{Instructions, lanes};
use crate::special::series::{LANES, horner};

/// Terms of the series for x up to 4, and up to 10: 1e-15 off.
const FEW_TERMS: usize = 16;
const MANY_TERMS: usize = 30;
/// x below which the series converges without loss.
const SMALL: f64 = 4.0;

/// D and its derivative by w, for w of at most `largest`.
#[inline(always)]
pub(crate) fn directivity<I: Instructions>(largest: f64, w: &[f64; LANES]) -> [[f64; LANES]; 2] {
    let [e1, e2] = if largest <= 16.0 {
        [horner::<I, FEW_TERMS>(&const { series(1) }, w), horner::<I, FEW_TERMS>(&const { series(2) }, w)]
    } else if largest <= 100.0 {
        [horner::<I, MANY_TERMS>(&const { series(1) }, w), horner::<I, MANY_TERMS>(&const { series(2) }, w)]
    } else {
        let each = w.map(first_and_second);
        [lanes(|l| each[l][0]), lanes(|l| each[l][1])]
    };
    [lanes(|l| 2.0 * e1[l]), lanes(|l| -e2[l])]
}

/// Eₙ = Σ (-w/4)ᵐ/(2ⁿ m! (n+m)!).
const fn series<const TERMS: usize>(n: usize) -> [f64; TERMS] {
    let (mut term, mut i) = (1.0, 1);
    while i <= n {
        term /= 2.0 * i as f64;
        i += 1;
    }
    let (mut terms, mut m) = ([0.0; TERMS], 0);
    while m < TERMS {
        terms[m] = term;
        term *= -0.25 / ((m + 1) * (n + m + 1)) as f64;
        m += 1;
    }
    terms
}

/// E₁ and E₂ of any w.
fn first_and_second(w: f64) -> [f64; 2] {
    let x = w.sqrt();
    if x < SMALL {
        let value = |coefficients: [f64; MANY_TERMS]| coefficients.iter().rfold(0.0, |sum, c| sum * w + c);
        return [value(series(1)), value(series(2))];
    }
    let (j0, j1) = (libm::j0(x), libm::j1(x));
    [j1 / x, (2.0 / x * j1 - j0) / w]
}

/// Spherical functions j₀ … j_order of x > 0: upwards up to the order x, and above by quotients, which are stable there.
pub fn spherical(order: usize, x: f64) -> Vec<f64> {
    let quotients = quotients(order, x);
    let mut all = vec![x.sin() / x];
    for n in 0..order {
        let next = match n {
            _ if (n + 1) as f64 > x => quotients[n] * all[n],
            0 => (x.sin() / x - x.cos()) / x,
            _ => (2 * n + 1) as f64 / x * all[n] - all[n - 1],
        };
        all.push(next);
    }
    all
}

/// j_{n+1}/j_n of the orders up to one, downwards from an order where it is small.
pub fn quotients(order: usize, x: f64) -> Vec<f64> {
    /// Orders beyond the last or beyond x: from there the quotient of 0 is forgotten.
    const BEYOND: usize = 40;
    let mut quotient = 0.0;
    let mut all = vec![0.0; order + 1];
    for n in (0..=order.max(x as usize) + BEYOND).rev() {
        quotient = 1.0 / ((2 * n + 3) as f64 / x - quotient);
        if n <= order {
            all[n] = quotient;
        }
    }
    all
}

/// Spherical functions y₀ … y_order of x > 0.
pub fn spherical_second(order: usize, x: f64) -> Vec<f64> {
    let mut all = vec![-x.cos() / x, -(x.cos() / x + x.sin()) / x];
    for n in 1..order {
        all.push((2 * n + 1) as f64 / x * all[n] - all[n - 1]);
    }
    all.truncate(order + 1);
    all
}
