//! Dispersion of waves on a viscous liquid: frequency and decay rate of each mode.

use num_complex::Complex64;

use crate::scene::Liquid;

/// Depths below this, m, count as this: about one molecule.
const THINNEST: f64 = 1e-9;
/// Depth (in 1/q) beyond which the floor has no effect.
const DEEP: f64 = 20.0;
/// Ratio of the slow to the fast root below which a mode counts as creeping, and limit in n for Orchard's rate to
/// 1e-7.
const CREEPING: f64 = 0.1;
const SLOWEST: f64 = 1e-6;
/// Newton's method: step of difference quotients, convergence limit, and divergence limit; all relative.
const NUDGE: f64 = 1e-6;
const ENOUGH: f64 = 1e-9;
const MOST_STEPS: usize = 60;

/// A mode of the surface as an oscillator with the two exact roots of its motion: h'' + 2γh' + Ω²(h - rest) = 0.
///
/// Free motion is e^{st}, s = -γ ± √(γ² - Ω²): a damped wave if γ < Ω, otherwise a fast and a slow creep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mode {
    /// γ, 1/s: the decay of a wave, or the mean of the two rates of a creeping mode.
    pub damping: f64,
    /// Ω², 1/s²: the product of the two roots.
    pub square: f64,
    /// Ω² - γ², 1/s²: the square of a wave's angular frequency; below 0 for a mode that creeps.
    pub swing: f64,
}

impl Mode {
    /// The mode with wavenumber `q` (1/m), for small slopes: exact roots of the linear equations of a viscous liquid
    /// over a no-slip floor. Of a creeping mode only the slow root is exact; the fast one contributes little.
    pub fn new(liquid: &Liquid, q: f64) -> Self {
        let depth = q * liquid.depth.max(THINNEST);
        let restoring = liquid.gravity * q + liquid.surface_tension() * q.powi(3) / liquid.density();
        let natural = restoring * depth.tanh();
        if natural <= 0.0 {
            return Self { damping: 0.0, square: 0.0, swing: 0.0 };
        }
        let viscous = liquid.viscosity() / liquid.density() * q * q;
        let near = Self::deep(natural, hindrance(depth) * viscous);
        let floor = Floor { depth, ratio: restoring / viscous.powi(2) };
        if depth > DEEP || !floor.ratio.is_finite() {
            return near;
        }
        floor.refine(near.in_units_of(viscous)).map_or(near, |mode| mode.in_units_of(1.0 / viscous))
    }

    /// The mode over no floor, from ω² and n = νq², by Lamb's equation (Hydrodynamics, § 349):
    /// (s + 2n)² + ω² = 4n² √(1 + s/n), ω² = g q + σ q³/ρ.
    ///
    /// A floor acts about as if ω² were less by tanh(q d) and n more by [`hindrance`].
    ///
    /// With x = √(1 + s/n), Re x > 0, the equation is (x² + 1)² - 4x + (ω/n)² = 0. As it has no x³, it is (x² - 2ax +
    /// b)(x² + 2ax + c) = 0 with real a > 0, and the roots with Re x > 0 are the two of the first factor, real or
    /// conjugate. Comparing powers: b, c = 1 + 2a² ∓ 1/a, and 4B³ + 4nB² - ω²B - n³ = 0 for B = n a². For B > 0 this
    /// cubic has one root, so ν = 0, critical damping (n = 1.31 ω) and creep need no special cases.
    fn deep(natural: f64, viscous: f64) -> Self {
        let root = root(natural, viscous);
        let inverse = (viscous / root).sqrt();
        // s₁s₂ = n²(1 - 2a + b)(1 + 2a + b) and ω² = n²(1 - 2a + b)(1 + 2a + c): no cancellation for small slow
        // roots.
        let even = 2.0 * (1.0 + inverse + inverse * inverse);
        let odd = inverse.powi(3);
        Self {
            damping: viscous * (2.0 - inverse),
            square: natural * (even - odd) / (even + odd),
            swing: 4.0 * root * (root + viscous * (1.0 - inverse)),
        }
    }

    fn in_units_of(self, rate: f64) -> Self {
        let square = rate * rate;
        Self { damping: self.damping / rate, square: self.square / square, swing: self.swing / square }
    }

    fn of_creep(slow: f64, fast: f64) -> Self {
        let apart = (fast - slow) / 2.0;
        Self { damping: (slow + fast) / 2.0, square: slow * fast, swing: -apart * apart }
    }

    /// The slow and the fast rate of a mode that creeps.
    fn rates(self) -> Option<[f64; 2]> {
        let fast = self.damping + (-self.swing).sqrt();
        (self.swing < 0.0).then(|| [self.square / fast, fast])
    }
}

/// A viscous liquid over a floor, in units of n = νq²: no slip at the floor, no shear at the surface.
#[derive(Clone, Copy, Debug)]
struct Floor {
    /// δ = q d.
    depth: f64,
    /// (g q + σ q³/ρ)/n².
    ratio: f64,
}

impl Floor {
    /// Refines a mode to the roots of the determinant of the four boundary conditions. `None` if it is already
    /// converged.
    fn refine(self, near: Mode) -> Option<Mode> {
        match near.rates() {
            Some([slow, fast]) if slow < CREEPING * fast => {
                (slow > SLOWEST).then(|| self.creep(slow)).flatten().map(|slow| Mode::of_creep(slow, fast))
            }
            _ => self.pair(near),
        }
    }

    /// The slow rate of a mode that creeps, by Newton's method.
    fn creep(self, near: f64) -> Option<f64> {
        let left = (1.0 - near).max(0.0).sqrt();
        let value = |rate: f64| self.determinant(Complex64::from(-rate), left).re;
        let mut rate = near;
        for _ in 0..MOST_STEPS {
            let by = NUDGE * rate;
            let step = 2.0 * by * value(rate) / (value(rate + by) - value(rate - by));
            let next = if step < rate { rate - step } else { rate / 2.0 };
            if (next - rate).abs() < ENOUGH * rate {
                return Some(next);
            }
            rate = next;
        }
        None
    }

    /// Both roots at once, real or conjugate, by Newton's method on the remainder of a division by (s - s₁)(s - s₂)
    /// (Bairstow): unlike single roots, their sum and product converge well where the two meet.
    fn pair(self, near: Mode) -> Option<Mode> {
        let Mode { mut damping, mut square, swing } = near;
        let left = (1.0 + Complex64::new(-damping, swing.max(0.0).sqrt())).sqrt().re;
        for _ in 0..MOST_STEPS {
            let here = self.remainder(damping, square, left);
            let by = [NUDGE * damping, NUDGE * square];
            let [a, b] = [(by[0], 0.0), (0.0, by[1])].map(|(d, s)| {
                let [[a, b], [c, e]] =
                    [1.0, -1.0].map(|sign| self.remainder(damping + sign * d, square + sign * s, left));
                [a - c, b - e]
            });
            let determinant = a[0] * b[1] - b[0] * a[1];
            let mut step = [
                2.0 * by[0] * (here[0] * b[1] - here[1] * b[0]) / determinant,
                2.0 * by[1] * (here[1] * a[0] - here[0] * a[1]) / determinant,
            ];
            if !step.iter().all(|step| step.is_finite()) {
                return None;
            }
            while step[0] >= damping || step[1] >= square {
                step = step.map(|step| step / 2.0);
            }
            damping -= step[0];
            square -= step[1];
            if step[0].abs() < ENOUGH * damping && step[1].abs() < ENOUGH * square {
                return Some(Mode { damping, square, swing: square - damping * damping });
            }
        }
        None
    }

    /// A and B of the remainder A s + B of the determinant divided by s² + 2γs + Ω².
    fn remainder(self, damping: f64, square: f64, left: f64) -> [f64; 2] {
        let apart = Complex64::from(damping * damping - square).sqrt();
        // Coinciding roots are separated by a negligible distance.
        let apart = if apart.norm() < NUDGE * damping { Complex64::from(NUDGE * damping) } else { apart };
        let slow = if apart.im == 0.0 && damping * damping > square {
            Complex64::from(-square / (damping + apart.re))
        } else {
            apart - damping
        };
        let fast = -apart - damping;
        let [at_slow, at_fast] = [slow, fast].map(|s| self.determinant(s, left));
        let a = (at_slow - at_fast) / (slow - fast);
        [a.re, (at_slow - a * slow).re]
    }

    /// The determinant of the boundary conditions at s (in n), without the spurious root s = 0, and times 2 e^{-left
    /// δ}.
    ///
    /// With z = x² = s + 1, C = cosh xδ, S = sinh xδ / x, T = tanh δ it is F(z) = 4(z + 1)/cosh δ + (z² + 6z + 1) T
    /// S - (z² + 2z + 5) C - ratio (T C - S), which is 0 at z = 1; (F(z) - F(1))/(z - 1) is written without
    /// cancellation.
    fn determinant(self, s: Complex64, left: f64) -> Complex64 {
        let Self { depth, ratio } = self;
        let z = s + 1.0;
        let x = z.sqrt();
        let (up, down) = (((x - left) * depth).exp(), ((-x - left) * depth).exp());
        let away = 2.0 * (-left * depth).exp();
        let (c, tanh) = (up + down, depth.tanh());
        let s_x = if x.norm() * depth < 1e-4 {
            away * depth * (1.0 + z * depth * depth / 6.0)
        } else {
            (up - down) / x
        };
        // Slopes of C and S from z = 1 on.
        let [slope_c, slope_s] = if s.norm() < 0.5 {
            let (sum, difference) = ((x + 1.0) * depth / 2.0, s / (x + 1.0) * depth / 2.0);
            let by = sinhc(difference) * depth;
            let slope_c = by * sinhc(sum) * (away * depth / 2.0);
            [slope_c, (sum.cosh() * by - depth.sinh()) * away / (x * (x + 1.0))]
        } else {
            [(c - away * depth.cosh()) / s, (s_x - away * depth.sinh()) / s]
        };
        4.0 * away / depth.cosh() + ((z + 7.0) * s_x + 8.0 * slope_s) * tanh
            - (z + 3.0) * c
            - 8.0 * slope_c
            - ratio * (tanh * slope_c - slope_s)
    }
}

/// sinh u / u.
fn sinhc(u: Complex64) -> Complex64 {
    if u.norm() < 1e-4 { 1.0 + u * u / 6.0 } else { u.sinh() / u }
}

/// The positive root B of 4B³ + 4nB² - ω²B - n³, from ω² and n.
fn root(natural: f64, viscous: f64) -> f64 {
    // B ≥ 0.41964 n, the root for ω = 0; with that in 4B² + 4nB - ω² = n³/B, B is no more than this. From above the
    // root, Newton's method decreases monotonically: at most seven steps.
    let mut root = f64::INFINITY;
    let mut next = 0.5 * ((natural + 3.383 * viscous * viscous).sqrt() - viscous);
    while next < root {
        root = next;
        let value = (4.0 * root * (root + viscous) - natural) * root - viscous.powi(3);
        next = root - value / ((12.0 * root + 8.0 * viscous) * root - natural);
    }
    root
}

/// Slowing factor of creep over a rigid floor at `depth` δ (in 1/q), beyond tanh: tanh(δ)/F(δ), F(δ) = (sinh 2δ -
/// 2δ)/(cosh 2δ + 1 + 2δ²) (Orchard, Appl. Sci. Res. A 11 (1963)). 1 for deep liquids.
fn hindrance(depth: f64) -> f64 {
    if depth > DEEP {
        return 1.0;
    }
    let twice = 2.0 * depth;
    // All times 2 e^{-2δ}; a series where the difference would cancel.
    let left = (-twice).exp();
    let apart = if twice < 0.01 {
        2.0 * left * twice.powi(3) / 6.0 * (1.0 + twice.powi(2) / 20.0)
    } else {
        1.0 - left * left - 2.0 * left * twice
    };
    let sum = 1.0 + left * left + left * (2.0 + twice.powi(2));
    depth.tanh() * sum / apart
}

#[cfg(test)]
mod tests;
