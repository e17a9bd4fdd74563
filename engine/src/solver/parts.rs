//! A drive as a sum of parts, one for each envelope of its targets.
//!
//! The drive u of all foci together, with the pressures p = H u, is cut into parts u_j that reach p at their own foci and
//! nothing at the others, and add up to u. Under envelopes m_j the drive Σ m_j u_j then has m_j p at the foci of each target:
//! whatever the others do, none of their sound gets there. Such parts are those of the pseudo-inverse, e_j = W H* (H W H*)⁺ p_j,
//! with weights W = 1/√Σ|H|² of the elements that make amplitudes even.
//! They do not add up to u: the rest r = u - Σ e_j, which no focus hears, is what makes the amplitudes of u even, and with them
//! the drive strong. It is shared out by power,
//!
//! ```text
//! u_j = e_j + w_j r,    w_j = |e_j|²/Σ|e|²
//! ```
//!
//! so that all targets at full amplitude are as loud as ever, and elements seldom exceed full drive in between: for two foci
//! alike, with e = a e^{iα}, a e^{iβ} and r half and half, |m₁u₁ + m₂u₂|² = a² (m₁ - m₂)² sin² + (m₁ + m₂)²/4 with a = 2/π: 1 at
//! most. Where some do, they are brought back, and e of what is then missing at the foci is added, in turn: a few times give the
//! same pressures within full drive, since fewer foci need less. What is left is scaled away, for all frames alike.
//!
//! Foci closer than waves can tell apart, as of strokes that meet, would need loud drives: the inverse is damped by 1e-5 of a
//! focus' own Σ W|H|², and by more until no part alone needs twice full drive. Neighbours then share some of their sound.

use num_complex::Complex64;

use crate::acoustics::{Aperture, Transfer};
use crate::drive::Drive;
use crate::scene::{Focus, Modulation, Scene, motion};
use crate::solver::cholesky::Factor;

/// Damping of the inverse, relative to Σ W|H|² of a focus: the least that no part exceeds [`MOST`] with, or else the last.
const DAMPING: [f64; 5] = [1e-5, 1e-4, 1e-3, 1e-2, 1e-1];
const MOST: f64 = 2.0;
/// Limit of the rounds that bring elements back to full drive, and their tolerance.
const ROUNDS: usize = 20;
const NEAR: f64 = 1e-3;

/// The parts of a drive, with their pressures at all foci.
#[derive(Debug)]
pub struct Parts<'a> {
    transfer: &'a Transfer,
    inverse: Option<Inverse<'a>>,
    /// u and p of each.
    parts: Vec<[Vec<Complex64>; 2]>,
}

fn largest(u: &[Complex64]) -> f64 {
    u.iter().map(|u| u.norm_sqr()).fold(0.0, f64::max).sqrt()
}

impl<'a> Parts<'a> {
    /// The parts of u (a value per driven element, of modulus 1 at most), for foci of so many envelopes.
    pub fn new(transfer: &'a Transfer, u: &[Complex64], of_foci: &[usize], count: usize) -> Self {
        let [all @ .., last] = DAMPING;
        let damped = |damping: f64| Self::damped(transfer, u, (of_foci, count), damping);
        let is_quiet = |parts: &Self| parts.parts.iter().all(|[u, _]| largest(u) <= MOST);
        all.into_iter().map(damped).find(is_quiet).unwrap_or_else(|| damped(last))
    }

    fn damped(
        transfer: &'a Transfer,
        u: &[Complex64],
        (of_foci, count): (&[usize], usize),
        damping: f64,
    ) -> Self {
        let pressures = transfer.pressure(u);
        let inverse = Inverse::new(transfer, damping);
        let own = |envelope: usize| {
            let is_own = |(p, of): (&Complex64, &usize)| if *of == envelope { *p } else { Complex64::ZERO };
            let wanted: Vec<_> = pressures.iter().zip(of_foci).map(is_own).collect();
            inverse.as_ref().map_or_else(|| vec![Complex64::ZERO; u.len()], |inverse| inverse.drive(&wanted))
        };
        let mut parts: Vec<_> = (0..count).map(own).collect();
        let power = |part: &Vec<Complex64>| part.iter().map(|u| u.norm_sqr()).sum::<f64>();
        let powers: Vec<_> = parts.iter().map(power).collect();
        let all: f64 = powers.iter().sum();
        let weight = |power: f64| if all > 0.0 { power / all } else { 1.0 / count as f64 };
        let rest: Vec<_> =
            (0..u.len()).map(|n| u[n] - parts.iter().map(|part| part[n]).sum::<Complex64>()).collect();
        for (part, power) in parts.iter_mut().zip(&powers) {
            part.iter_mut().zip(&rest).for_each(|(own, rest)| *own += weight(*power) * rest);
        }
        let with_pressures = |part: Vec<Complex64>| {
            let pressures = transfer.pressure(&part);
            [part, pressures]
        };
        Self { transfer, inverse, parts: parts.into_iter().map(with_pressures).collect() }
    }

    /// The power Σ|u|² of each part.
    pub fn powers(&self) -> Vec<f64> {
        self.parts.iter().map(|[u, _]| u.iter().map(|u| u.norm_sqr()).sum()).collect()
    }

    /// Drive and pressures under these envelopes, of elements within full drive if the foci need no more.
    pub fn under(&self, envelopes: &[f64]) -> [Vec<Complex64>; 2] {
        let [mut u, wanted] = self.sum(envelopes);
        let mut peak = largest(&u);
        for _ in 0..ROUNDS {
            let Some(inverse) = self.inverse.as_ref().filter(|_| peak > 1.0 + NEAR) else { break };
            let mut next: Vec<_> = u.iter().map(|u| u / u.norm().max(1.0)).collect();
            let now = self.transfer.pressure(&next);
            let missing: Vec<_> = wanted.iter().zip(now).map(|(wanted, now)| wanted - now).collect();
            next.iter_mut().zip(inverse.drive(&missing)).for_each(|(u, more)| *u += more);
            let after = largest(&next);
            if after >= peak {
                break;
            }
            (u, peak) = (next, after);
        }
        let pressures = self.transfer.pressure(&u);
        [u, pressures]
    }

    fn sum(&self, envelopes: &[f64]) -> [Vec<Complex64>; 2] {
        [0, 1].map(|which| {
            let mut sum = vec![Complex64::ZERO; self.parts.first().map_or(0, |part| part[which].len())];
            for (part, envelope) in self.parts.iter().zip(envelopes) {
                sum.iter_mut().zip(&part[which]).for_each(|(sum, value)| *sum += envelope * value);
            }
            sum
        })
    }
}

/// The different modulations of a scene's targets, each with the Σ|u|² of its part of drives for its foci, as a mean over drives in
/// turn.
pub fn powers<'a>(
    scene: &'a Scene,
    aperture: &Aperture,
    drives: &[Drive],
    foci: &[Focus],
) -> Vec<(&'a Modulation, f64)> {
    let shared =
        motion::shares(scene).ok().filter(|(_, of)| scene.has_own_envelopes() && of.len() == foci.len());
    let (all, of_foci) = shared.unwrap_or_else(|| (vec![scene.envelope()], vec![0; foci.len()]));
    let points: Vec<_> = foci.iter().map(|focus| focus.position).collect();
    let transfer = (all.len() > 1).then(|| aperture.transfer(&points));
    let mut sums = vec![0.0; all.len()];
    for drive in drives {
        let u = drive.excitation(&aperture.driven);
        let powers = match &transfer {
            Some(transfer) => Parts::new(transfer, &u, &of_foci, all.len()).powers(),
            None => vec![u.iter().map(|u| u.norm_sqr()).sum()],
        };
        sums.iter_mut().zip(powers).for_each(|(sum, power)| *sum += power / drives.len() as f64);
    }
    all.into_iter().zip(sums).collect()
}

/// The damped W H* D (D H W H* D + damping)⁻¹ D, D the diagonal that brings rows to norm 1, by the factor of the real
/// and the imaginary part together.
#[derive(Debug)]
struct Inverse<'a> {
    transfer: &'a Transfer,
    weights: Vec<f64>,
    scales: Vec<f64>,
    factor: Factor,
}

impl<'a> Inverse<'a> {
    /// `None` of a transfer that is no number.
    fn new(transfer: &'a Transfer, damping: f64) -> Option<Self> {
        let count = transfer.points;
        let scale = |norm: f64| if norm > 0.0 { norm.sqrt().recip() } else { 0.0 };
        let mut heard = vec![0.0; transfer.elements];
        for row in transfer.rows() {
            let all: f64 = row.clone().map(|h| h.norm_sqr()).sum();
            let part = if all > 0.0 { all.recip() } else { 0.0 };
            heard.iter_mut().zip(row).for_each(|(sum, h)| *sum += h.norm_sqr() * part);
        }
        let weights: Vec<_> = heard.into_iter().map(scale).collect();
        let gram = transfer.gram(Some(&weights));
        let scales: Vec<_> = (0..count).map(|m| scale(gram.at(m * count + m).re)).collect();
        let entry = |row: usize, column: usize| {
            let (m, n) = (row % count, column % count);
            let value = gram.at(m * count + n) * scales[m] * scales[n];
            let part = match (row < count, column < count) {
                (true, true) | (false, false) => value.re,
                (true, false) => -value.im,
                (false, true) => value.im,
            };
            part + if row == column { damping } else { 0.0 }
        };
        let factor = Factor::new(2 * count, entry)?;
        Some(Self { transfer, weights, scales, factor })
    }

    fn drive(&self, pressures: &[Complex64]) -> Vec<Complex64> {
        let scaled = pressures.iter().zip(&self.scales).map(|(p, scale)| p * scale);
        let scaled: Vec<_> = scaled.collect();
        let b: Vec<_> = scaled.iter().map(|p| p.re).chain(scaled.iter().map(|p| p.im)).collect();
        let x = self.factor.solve(&b);
        let (re, im) = x.split_at(pressures.len());
        let values =
            re.iter().zip(im).zip(&self.scales).map(|((re, im), scale)| Complex64::new(*re, *im) * scale);
        let mut drive = self.transfer.back(&values.collect::<Vec<_>>());
        drive.iter_mut().zip(&self.weights).for_each(|(u, weight)| *u *= weight);
        drive
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn parts_reach_their_own_foci_alone_and_add_up() {
        let aperture = Aperture::new(&Scene::default());
        let at = [[-0.02, 0.0], [0.025, 0.01], [0.0, -0.03]].map(|[x, y]| DVec3::new(x, y, 0.12));
        let transfer = aperture.transfer(&at);
        let back = transfer.back(&[1.0, 0.8, 1.2].map(Complex64::from));
        let u: Vec<_> = back.iter().map(|u| u / u.norm()).collect();
        let (of_foci, p) = ([0, 1, 0], transfer.pressure(&u));
        let parts = Parts::new(&transfer, &u, &of_foci, 2);
        let [whole, _] = parts.under(&[1.0, 1.0]);
        assert!(whole.iter().zip(&u).all(|(a, b)| (a - b).norm() < 1e-12));
        for envelopes in [[1.0, 0.0], [0.0, 1.0], [0.3, 0.6]] {
            let [u, pressures] = parts.under(&envelopes);
            for ((p, own), of) in p.iter().zip(&pressures).zip(of_foci) {
                assert!((own - envelopes[of] * p).norm() < 1e-4 * p.norm(), "{envelopes:?}: {own}, {p}");
            }
            let direct = transfer.pressure(&u);
            assert!(direct.iter().zip(&pressures).all(|(a, b)| (a - b).norm() < 1e-9 * p[0].norm()));
            assert!(largest(&u) < 1.01, "{envelopes:?}: {}", largest(&u));
        }
    }

    #[test]
    fn strokes_that_meet_share_sound_instead_of_loud_drives() {
        let aperture = Aperture::new(&Scene::default());
        let at: Vec<_> = (0..60).map(|i| DVec3::new(f64::from(i) * 1.4e-3 - 0.041, 0.0, 0.12)).collect();
        let transfer = aperture.transfer(&at);
        let back = transfer.back(&vec![Complex64::ONE; at.len()]);
        let u: Vec<_> = back.iter().map(|u| u / u.norm()).collect();
        let of_foci: Vec<_> = (0..60).map(|i| i / 30).collect();
        let parts = Parts::new(&transfer, &u, &of_foci, 2);
        let [one, pressures] = parts.under(&[1.0, 0.0]);
        let power = |half: &[Complex64]| half.iter().map(|p| p.norm_sqr()).sum::<f64>();
        let (own, other) = pressures.split_at(30);
        assert!(
            largest(&one) < 2.0 && power(other) < 0.1 * power(own),
            "{} {} {}",
            largest(&one),
            power(other),
            power(own)
        );
    }
}
