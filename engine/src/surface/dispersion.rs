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
mod tests {
    use num_complex::Complex64;
    use strum::VariantArray;

    use super::*;
    use crate::scene::LiquidName;

    /// A liquid with ω² = 2 at q = 1, which is 100 deep, and with this n = ν.
    fn deep(viscous: f64) -> Liquid {
        let one = Some(1.0);
        Liquid {
            density: one,
            surface_tension: one,
            viscosity: Some(viscous),
            gravity: 1.0,
            depth: 100.0,
            ..Liquid::default()
        }
    }

    /// The two roots s/n of Lamb's equation, the slower one first: all four roots x of (x² + 1)² - 4x + (ω/n)² by Durand's and
    /// Kerner's iteration, and of these the ones with Re x > 0.
    fn lamb(ratio: f64) -> [Complex64; 2] {
        let size = 1.0 + ratio.powf(0.25);
        let mut roots = [0, 1, 2, 3].map(|k| Complex64::from_polar(size, 0.4 + 1.6 * f64::from(k)));
        for _ in 0..400 {
            for i in 0..4 {
                let x = roots[i];
                let others: Complex64 = (0..4).filter(|&j| j != i).map(|j| x - roots[j]).product();
                roots[i] = x - ((x * x + 1.0).powi(2) - 4.0 * x + ratio) / others;
            }
        }
        let mut physical: Vec<_> = roots.iter().filter(|x| x.re > 0.0).map(|x| x * x - 1.0).collect();
        physical.sort_by(|s, t| t.re.total_cmp(&s.re));
        physical.try_into().expect("two roots with Re x > 0")
    }

    #[test]
    fn the_two_roots_are_lambs_from_no_viscosity_to_creep() {
        let critical = 0.581_412_179_607_29_f64;
        let near = [-1e-3, -1e-6, -1e-9, 0.0, 1e-9, 1e-6, 1e-3].map(|part| critical * (1.0 + part));
        let far = (-60..=120).map(|tenths| 10f64.powf(f64::from(tenths) / 10.0));
        for ratio in far.chain(near) {
            let viscous = (2.0 / ratio).sqrt();
            let mode = Mode::new(&deep(viscous), 1.0);
            let [slow, fast] = lamb(ratio);
            let damping = -viscous * (slow + fast).re / 2.0;
            let square = viscous * viscous * (slow * fast).re;
            assert!((mode.damping / damping - 1.0).abs() < 1e-8, "{ratio}: {mode:?} {damping}");
            assert!((mode.square / square - 1.0).abs() < 1e-8, "{ratio}: {mode:?} {square}");
            let swing = mode.square - mode.damping.powi(2);
            assert!(
                (mode.swing - swing).abs() < 1e-12 * (mode.square + mode.damping.powi(2)),
                "{ratio}: {mode:?}"
            );
            assert!(
                (ratio / critical - 1.0).abs() < 1e-8 || (mode.swing > 0.0) == (ratio > critical),
                "{ratio}"
            );
        }
    }

    #[test]
    fn extremes_are_numbers() {
        let Mode { damping, square, swing } = Mode::new(&deep(0.0), 1.0);
        assert!(
            damping == 0.0 && (square - 2.0).abs() < 1e-12 && (swing - 2.0).abs() < 1e-12,
            "{square} {swing}"
        );
        assert_eq!(Mode::new(&deep(1.0), 0.0), Mode { damping: 0.0, square: 0.0, swing: 0.0 });
        for viscosity in [0.0, 5e-324, 1e-3, 1e4] {
            for depth in [5e-324, 1e-9, 1e-3, 100.0] {
                for q in [1e-6, 1.0, 1e3, 1e7] {
                    let liquid =
                        Liquid { viscosity: Some(viscosity), density: Some(1.0), depth, ..Liquid::default() };
                    let Mode { damping, square, swing } = Mode::new(&liquid, q);
                    let is_sound = damping >= 0.0 && square > 0.0 && square.is_finite() && swing.is_finite();
                    assert!(is_sound, "{viscosity} Pa·s, {depth} m, {q} 1/m: {damping} {square} {swing}");
                }
            }
        }
    }

    #[test]
    fn creep_over_a_floor_is_slowed_as_orchard_says() {
        for depth in [1e-3_f64, 0.004, 0.0049, 0.0051, 0.02, 0.3, 1.0, 4.0, 10.0, 30.0] {
            let twice = 2.0 * depth;
            let f = (twice.sinh() - twice) / (twice.cosh() + 1.0 + 2.0 * depth * depth);
            assert!(
                (hindrance(depth) * f / depth.tanh() - 1.0).abs() < 1e-9,
                "{depth}: {}",
                hindrance(depth)
            );
        }
    }

    #[test]
    fn the_determinant_has_its_spurious_root_divided_away() {
        for (depth, ratio) in [(0.3_f64, 2.0), (1.5, 0.4), (4.0, 30.0)] {
            let floor = Floor { depth, ratio };
            let places = [
                (0.7, 0.2),
                (-2.5, 0.4),
                (0.1, 0.3),
                (-0.2, -0.3),
                (-0.49, 0.0),
                (-0.51, 0.0),
                (-1.0, 1e-10),
            ];
            for (re, im) in places {
                let s = Complex64::new(re, im);
                let plain = |z: Complex64| {
                    let x = z.sqrt();
                    let (c, s, t) = ((x * depth).cosh(), (x * depth).sinh() / x, depth.tanh());
                    4.0 * (z + 1.0) / depth.cosh() + (z * z + 6.0 * z + 1.0) * t * s
                        - (z * z + 2.0 * z + 5.0) * c
                        - ratio * (t * c - s)
                };
                for left in [0.0, 0.4] {
                    let expected = 2.0 * (-left * depth).exp() * plain(s + 1.0) / s;
                    let own = floor.determinant(s, left);
                    assert!(
                        (own - expected).norm() < 1e-10 * expected.norm(),
                        "{depth} {ratio} {s}: {own} {expected}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_remainder_is_the_determinant_at_both_roots() {
        let floor = Floor { depth: 1.5, ratio: 2.0 };
        for (damping, square) in [(0.3_f64, 2.0), (1.2, 0.4), (0.5, 0.25), (1e-3, 1e-6)] {
            let [a, b] = floor.remainder(damping, square, 0.2);
            let apart = Complex64::from(damping * damping - square).sqrt();
            for s in [apart - damping, -apart - damping] {
                let (own, expected) = (a * s + b, floor.determinant(s, 0.2));
                assert!(
                    (own - expected).norm() < 1e-6 * expected.norm(),
                    "{damping} {square}: {own} {expected}"
                );
            }
            // Where the roots meet, the slope too.
            if apart.norm() == 0.0 {
                let at = |s: f64| floor.determinant(Complex64::from(s), 0.2).re;
                let by = 1e-4 * damping;
                let slope = (at(by - damping) - at(-by - damping)) / (2.0 * by);
                assert!((a / slope - 1.0).abs() < 1e-4, "{damping}: {a} {slope}");
            }
        }
    }

    /// The slow rate of a mode that creeps, 1/s.
    fn creep(mode: Mode) -> f64 {
        assert!(mode.swing < 0.0, "{mode:?}");
        mode.square / (mode.damping + (-mode.swing).sqrt())
    }

    #[test]
    fn a_thick_liquid_levels_over_a_floor_as_orchard_says() {
        let q = 300.0f64;
        for depth in [1e-6, 1.66e-5, 1.67e-5, 1e-3, 3e-3, 1e-2, 0.1] {
            let liquid =
                Liquid { name: LiquidName::Glycerol, viscosity: Some(1e4), depth, ..Liquid::default() };
            let restoring = liquid.density() * liquid.gravity + liquid.surface_tension() * q * q;
            let twice = 2.0 * q * depth;
            let orchard = (twice.sinh() - twice) / (twice.cosh() + 1.0 + twice * twice / 2.0);
            let rate = creep(Mode::new(&liquid, q));
            assert!((rate / (restoring / (2e4 * q) * orchard) - 1.0).abs() < 1e-7, "{depth} m: {rate}");
            let film = restoring * q * q * depth.powi(3) / 3e4;
            assert!(depth > 1e-6 || (rate / film - 1.0).abs() < 1e-4, "{rate} {film}");
        }
    }

    /// The determinant of the boundary conditions at s, in two ways of which one is well-conditioned: with the vertical speed
    /// A (cosh q(z + d) - cosh xq(z + d)) + B (sinh q(z + d) - sinh xq(z + d) / x), at rest on the floor, if vorticity fills the
    /// liquid; and else with the four speeds e^{qz}, e^{-q(z + d)}, e^{xqz} and e^{-xq(z + d)}.
    fn determinant(restoring: f64, n: f64, depth: f64, s: Complex64, fills: bool) -> Complex64 {
        let (x, one) = ((s / n + 1.0).sqrt(), Complex64::from(1.0));
        if fills {
            let [(cosh, sinh), (cosh_x, sinh_x)] = [one, x].map(|x| ((x * depth).cosh(), (x * depth).sinh()));
            let shear = [2.0 * cosh - (x * x + 1.0) * cosh_x, 2.0 * sinh - (x * x + 1.0) * sinh_x / x];
            let speed = [cosh - cosh_x, sinh - sinh_x / x];
            let (slope, pressure) = ([sinh - x * sinh_x, cosh - cosh_x], [sinh, cosh]);
            let normal = [0, 1].map(|i| restoring / s * speed[i] + s * pressure[i] + 2.0 * n * slope[i]);
            return shear[0] * normal[1] - shear[1] * normal[0];
        }
        let (a, b) = (Complex64::from((-depth).exp()), (-x * depth).exp());
        let (weight, shear) = (restoring / s, x * x + 1.0);
        let floor = [[a, one, b, one], [a, -one, x * b, -x]];
        let surface = [
            [2.0 * one, 2.0 * a, shear, shear * b],
            [
                weight + s + 2.0 * n,
                (weight - s - 2.0 * n) * a,
                weight + 2.0 * n * x,
                (weight - 2.0 * n * x) * b,
            ],
        ];
        let minor = |rows: &[[Complex64; 4]; 2], i: usize, j: usize| {
            rows[0][i] * rows[1][j] - rows[0][j] * rows[1][i]
        };
        let pairs = [([0, 1], [2, 3]), ([2, 0], [1, 3]), ([0, 3], [1, 2])];
        let both = pairs.into_iter().flat_map(|(own, other)| [(own, other), (other, own)]);
        both.map(|([i, j], [k, l])| minor(&floor, i, j) * minor(&surface, k, l)).sum()
    }

    /// How far s is from a root, relative to s, by Newton's step.
    fn distance(liquid: &Liquid, q: f64, s: Complex64) -> f64 {
        let n = liquid.viscosity() / liquid.density() * q * q;
        let restoring = liquid.gravity * q + liquid.surface_tension() * q.powi(3) / liquid.density();
        let depth = q * liquid.depth;
        let fills = (s / n + 1.0).sqrt().re * depth < 3.0;
        let determinant = |s: Complex64| determinant(restoring, n, depth, s, fills);
        let by = s * 1e-5;
        let slope = (determinant(s + by) - determinant(s - by)) / (2.0 * by);
        (determinant(s) / slope / s).norm()
    }

    #[test]
    fn modes_over_any_floor_are_roots_of_the_boundary_conditions() {
        let named = |&name: &LiquidName| Liquid { name, ..Liquid::default() };
        let oil = Liquid {
            density: Some(975.0),
            surface_tension: Some(0.0205),
            viscosity: Some(9.75),
            ..Liquid::default()
        };
        let liquids = LiquidName::VARIANTS.iter().map(named).chain([oil]);
        let mut kinds = [0; 2];
        for liquid in liquids {
            for depth in [1e-3, 2e-3, 5e-3, 0.01, 0.02, 0.05, 0.2, 1.0] {
                for part in -20..=20 {
                    let q = 10f64.powf(f64::from(part) / 20.0) / liquid.capillary_length();
                    let liquid = Liquid { depth, ..liquid.clone() };
                    let mode = Mode::new(&liquid, q);
                    let s = mode.rates().map_or_else(
                        || Complex64::new(-mode.damping, mode.swing.sqrt()),
                        |[slow, _]| Complex64::from(-slow),
                    );
                    let off = distance(&liquid, q, s);
                    assert!(off < 1e-6, "{:?} {depth} m, {q} 1/m: {s} {off:e}", liquid.name);
                    kinds[usize::from(mode.swing < 0.0)] += 1;
                }
            }
        }
        assert!(kinds.iter().all(|&count| count > 100), "waves and creep: {kinds:?}");
    }
}
