//! The piston's directivity D = 2 J1(x)/x as a function of w = x², with three derivatives.
//!
//! With Eₙ = Jₙ(x)/xⁿ, D = 2 E₁, dEₙ/dw = -Eₙ₊₁/2, and Eₙ₋₁ = 2n Eₙ - w Eₙ₊₁.

use crate::acoustics::row::{LANES, horner};
use crate::simd::{Instructions, lanes};

/// Terms of the series for x up to 4, and up to 10: 1e-15 off.
const FEW_TERMS: usize = 16;
const MANY_TERMS: usize = 30;
/// x below which the series converges without loss.
const SMALL: f64 = 4.0;

/// D, D', D'' and D''' by w, for w of at most `largest`.
#[inline(always)]
pub(super) fn directivity<I: Instructions>(largest: f64, w: &[f64; LANES]) -> [[f64; LANES]; 4] {
    let [e3, e4] = if largest <= 16.0 {
        [horner::<I, FEW_TERMS>(&const { series(3) }, w), horner::<I, FEW_TERMS>(&const { series(4) }, w)]
    } else if largest <= 100.0 {
        [horner::<I, MANY_TERMS>(&const { series(3) }, w), horner::<I, MANY_TERMS>(&const { series(4) }, w)]
    } else {
        let each = w.map(third_and_fourth);
        [lanes(|l| each[l][0]), lanes(|l| each[l][1])]
    };
    let e2 = lanes::<LANES>(|l| 6.0 * e3[l] - w[l] * e4[l]);
    let e1 = lanes::<LANES>(|l| 4.0 * e2[l] - w[l] * e3[l]);
    [lanes(|l| 2.0 * e1[l]), lanes(|l| -e2[l]), lanes(|l| 0.5 * e3[l]), lanes(|l| -0.25 * e4[l])]
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

/// E₃ and E₄ of any w.
fn third_and_fourth(w: f64) -> [f64; 2] {
    let x = w.sqrt();
    if x < SMALL {
        let value = |coefficients: [f64; MANY_TERMS]| coefficients.iter().rfold(0.0, |sum, c| sum * w + c);
        return [value(series(3)), value(series(4))];
    }
    // The upward recurrence is stable for n below x.
    let (j0, j1) = (libm::j0(x), libm::j1(x));
    let j2 = 2.0 / x * j1 - j0;
    let j3 = 4.0 / x * j2 - j1;
    let j4 = 6.0 / x * j3 - j2;
    [j3 / (x * w), j4 / (w * w)]
}
