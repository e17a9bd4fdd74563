//! Dispersion of a viscous liquid's waves: how fast a mode of its surface swings, and how fast it dies away.

use crate::scene::Liquid;

/// Depths below this, m, count as this: about one molecule.
const THINNEST: f64 = 1e-9;

/// A mode of the surface as an oscillator with the two exact roots of its motion: h'' + 2γh' + Ω²(h - rest) = 0.
///
/// Free, it goes as e^{st}, s = -γ ± √(γ² - Ω²): as a damped wave if γ < Ω, and else as a fast and a slow creep.
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
    /// The mode with wavenumber `q` (1/m), from Lamb's equation (Hydrodynamics, § 349) for small slopes:
    /// (s + 2νq²)² + ω² = 4ν²q⁴ √(1 + s/νq²), ω² = (g q + σ q³/ρ) tanh(q d).
    ///
    /// Lamb's liquid is deep. A floor acts through tanh and through a greater viscosity, `hindrance` · ν.
    ///
    /// With n = νq² and x = √(1 + s/n), Re x > 0, the equation is (x² + 1)² - 4x + (ω/n)² = 0. As it has no x³, it is
    /// (x² - 2ax + b)(x² + 2ax + c) = 0 with real a > 0, and the roots with Re x > 0 are the two of the first factor, real or
    /// conjugate. Comparing powers: b, c = 1 + 2a² ∓ 1/a, and 4B³ + 4nB² - ω²B - n³ = 0 for B = n a². For B > 0 this cubic has
    /// one root, so ν = 0, critical damping (n = 1.31 ω) and creep need no cases of their own.
    pub fn new(liquid: &Liquid, q: f64) -> Self {
        let depth = q * liquid.depth.max(THINNEST);
        let natural =
            (liquid.gravity * q + liquid.surface_tension() * q.powi(3) / liquid.density()) * depth.tanh();
        if natural <= 0.0 {
            return Self { damping: 0.0, square: 0.0, swing: 0.0 };
        }
        let viscous = hindrance(depth) * liquid.viscosity() / liquid.density() * q * q;
        let root = root(natural, viscous);
        let inverse = (viscous / root).sqrt();
        // s₁s₂ = n²(1 - 2a + b)(1 + 2a + b) and ω² = n²(1 - 2a + b)(1 + 2a + c): nothing cancels where the slow root is small.
        let even = 2.0 * (1.0 + inverse + inverse * inverse);
        let odd = inverse.powi(3);
        Self {
            damping: viscous * (2.0 - inverse),
            square: natural * (even - odd) / (even + odd),
            swing: 4.0 * root * (root + viscous * (1.0 - inverse)),
        }
    }
}

/// The positive root B of 4B³ + 4nB² - ω²B - n³, from ω² and n.
fn root(natural: f64, viscous: f64) -> f64 {
    // B ≥ 0.41964 n, the root for ω = 0; with that in 4B² + 4nB - ω² = n³/B, B is no more than this. From beyond the root,
    // Newton's steps only fall: at most seven.
    let mut root = f64::INFINITY;
    let mut next = 0.5 * ((natural + 3.383 * viscous * viscous).sqrt() - viscous);
    while next < root {
        root = next;
        let value = (4.0 * root * (root + viscous) - natural) * root - viscous.powi(3);
        next = root - value / ((12.0 * root + 8.0 * viscous) * root - natural);
    }
    root
}

/// Factor by which a rigid floor at `depth` δ (in 1/q) slows creep, beyond tanh: tanh(δ)/F(δ),
/// F(δ) = (sinh 2δ - 2δ)/(cosh 2δ + 1 + 2δ²) (Orchard, Appl. Sci. Res. A 11 (1963)). 1 where the liquid is deep.
fn hindrance(depth: f64) -> f64 {
    if depth > 20.0 {
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

    /// (ω/n)²/tanh δ at which s/n is a root of a viscous liquid's exact equation over a floor that holds it: ratio of two
    /// determinants, from no slip at the floor and the two stresses at the surface.
    fn over_floor(s: Complex64, depth: f64) -> Complex64 {
        let x = (s + 1.0).sqrt();
        let (deep, tanh) = (depth.tanh(), (x * depth).tanh() / x);
        let echo = 4.0 * (x * x + 1.0) / (depth.cosh() * (x * depth).cosh());
        (echo + (x.powi(4) + 6.0 * x * x + 1.0) * deep * tanh - (x.powi(4) + 2.0 * x * x + 5.0))
            / (deep - tanh)
    }

    #[test]
    fn a_floor_slows_what_creeps_and_damps_what_swings() {
        for depth in [0.05, 0.2, 0.5, 1.0, 2.0, 4.0, 8.0] {
            for (part, allowed) in [(0.01, 0.003), (0.1, 0.03), (0.3, 0.1)] {
                let viscous = (2.0 * f64::tanh(depth) / part).sqrt() / hindrance(depth);
                let rate = creep(Mode::new(&Liquid { depth, ..deep(viscous) }, 1.0)) / viscous;
                let exact = over_floor(Complex64::from(-rate), depth) * viscous * viscous;
                assert!((exact.re / 2.0 - 1.0).abs() < allowed, "{depth} {part}: {exact}");
            }
        }
        // s/n of exact waves over a floor, for (ω/n)² of ten times hindrance².
        for (depth, exact) in [(0.2, [-34.288, 109.2]), (1.0, [-2.9895, 9.1806]), (4.0, [-1.1083, 2.6207])] {
            let [real, imaginary] = exact;
            let s = Complex64::new(real, imaginary);
            let viscous = (2.0 / over_floor(s, depth).re).sqrt();
            let mode = Mode::new(&Liquid { depth, ..deep(viscous) }, 1.0);
            let decay = mode.damping / viscous / -real;
            let frequency = mode.swing.sqrt() / viscous / imaginary;
            assert!(
                (0.95..1.5).contains(&decay) && (0.85..1.05).contains(&frequency),
                "{depth}: {decay} {frequency}"
            );
        }
    }
}
