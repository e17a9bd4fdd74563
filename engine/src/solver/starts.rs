//! Focal phases with constructive interference, from several parallel starts.

#![expect(clippy::needless_range_loop, reason = "lanes are what is looped over, in several arrays at once")]

use std::f64::consts::TAU;

use num_complex::Complex64;

use crate::acoustics::Phasors;
use crate::simd::{Instructions, Isa, Kernel, fused};
use crate::solver::statistics;

/// Starts that climb side by side, one in each lane of a register.
const STARTS: usize = 8;
/// Rounding of powers in f32. Among equal starts, such as all those of a single focus, the first is taken: otherwise
/// rounding, which differs between instruction sets, would choose.
const ROUNDING: f32 = 1e-5;
/// Steps of the golden section are never near a fraction: 1/φ.
const GOLDEN: f64 = 0.618_033_988_749_894_8;

/// Gerchberg-Saxton on R = H H* from several starts: p ← A ph(R p) climbs to a maximum of the power p* R p that the foci
/// can share.
///
/// Equal phases are a fixed point of every symmetric set, and a poor one, so the starts are scattered; those of another
/// `batch` are others.
pub fn climbed(gram: &Phasors, targets: &[f64], iterations: usize, batch: usize) -> Climbed {
    climbed_with(Isa::best(), gram, targets, iterations, batch)
}

/// The ends of climbs from several starts.
pub struct Climbed {
    lanes: Lanes,
    strongest: usize,
    /// Standard deviation over mean of the powers of the starts.
    pub spread: f64,
}

impl Climbed {
    /// The end with the largest power, as one complex pressure per focus.
    pub fn strongest(&self) -> Phasors {
        self.lanes.phasors(self.strongest)
    }

    /// All ends.
    pub fn each(&self) -> impl Iterator<Item = Phasors> {
        (0..STARTS).map(|start| self.lanes.phasors(start))
    }
}

fn climbed_with(isa: Isa, gram: &Phasors, targets: &[f64], iterations: usize, batch: usize) -> Climbed {
    let count = targets.len();
    // Only phases are returned, so any scale, and f32, will do.
    let scale = (0..count).map(|m| gram.re[m * count + m]).fold(f64::MIN_POSITIVE, f64::max).recip();
    let loudest = targets.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let narrow = |values: &[f64]| values.iter().map(|value| (value * scale) as f32).collect::<Vec<_>>();
    let mut lanes = Lanes { re: vec![[0.0; STARTS]; count], im: vec![[0.0; STARTS]; count] };
    for start in 0..STARTS {
        for (m, p) in scattered(targets, batch * STARTS + start).enumerate() {
            lanes.re[m][start] = (p.re / loudest) as f32;
            lanes.im[m][start] = (p.im / loudest) as f32;
        }
    }
    let [before, after] = isa.run(Climb {
        gram_re: &narrow(&gram.re),
        gram_im: &narrow(&gram.im),
        targets: &targets.iter().map(|target| (target / loudest) as f32).collect::<Vec<_>>(),
        heard: Lanes { re: lanes.re.clone(), im: lanes.im.clone() },
        lanes: &mut lanes,
        iterations,
    });
    let most = after.iter().copied().fold(0.0, f32::max);
    let strongest = after.iter().position(|&power| power >= most * (1.0 - ROUNDING)).unwrap_or(0);
    Climbed { lanes, strongest, spread: statistics::spread(&before.map(f64::from)) }
}

/// A pressure per focus at its target, with phases that differ from number to number.
pub fn scattered(targets: &[f64], number: usize) -> impl Iterator<Item = Complex64> {
    let phase = move |m: usize| TAU * number as f64 * scatter(m + number);
    targets.iter().enumerate().map(move |(m, target)| Complex64::from_polar(*target, phase(m)))
}

/// A low-discrepancy number in [0, 1).
pub fn scatter(index: usize) -> f64 {
    (index as f64 * GOLDEN).fract()
}

/// A complex number per focus and start.
struct Lanes {
    re: Vec<[f32; STARTS]>,
    im: Vec<[f32; STARTS]>,
}

impl Lanes {
    fn phasors(&self, start: usize) -> Phasors {
        let p = |(re, im): (&[f32; STARTS], &[f32; STARTS])| {
            Complex64::new(f64::from(re[start]), f64::from(im[start]))
        };
        self.re.iter().zip(&self.im).map(p).collect()
    }
}

struct Climb<'a> {
    gram_re: &'a [f32],
    gram_im: &'a [f32],
    targets: &'a [f32],
    lanes: &'a mut Lanes,
    heard: Lanes,
    iterations: usize,
}

impl Kernel for Climb<'_> {
    /// p* R p of every start, before and after the iterations.
    type Output = [[f32; STARTS]; 2];

    #[inline(always)]
    fn run<I: Instructions>(mut self) -> [[f32; STARTS]; 2] {
        self.hear::<I>();
        let before = self.powers();
        for _ in 0..self.iterations {
            self.turn::<I>();
            self.hear::<I>();
        }
        [before, self.powers()]
    }
}

impl Climb<'_> {
    /// p* R p of every start, with heard = R p.
    #[inline(always)]
    fn powers(&self) -> [f32; STARTS] {
        let mut powers = [0.0; STARTS];
        for m in 0..self.targets.len() {
            for start in 0..STARTS {
                powers[start] += self.lanes.re[m][start] * self.heard.re[m][start]
                    + self.lanes.im[m][start] * self.heard.im[m][start];
            }
        }
        powers
    }

    /// heard = R p, four foci at a time as long as possible.
    #[inline(always)]
    fn hear<I: Instructions>(&mut self) {
        let count = self.targets.len();
        let mut m = 0;
        while m < count {
            if m + 4 <= count {
                self.hear_some::<I, 4>(m);
                m += 4;
            } else if m + 2 <= count {
                self.hear_some::<I, 2>(m);
                m += 2;
            } else {
                self.hear_some::<I, 1>(m);
                m += 1;
            }
        }
    }

    #[inline(always)]
    fn hear_some<I: Instructions, const FOCI: usize>(&mut self, first: usize) {
        let count = self.targets.len();
        let (mut re, mut im) = ([[0.0f32; STARTS]; FOCI], [[0.0f32; STARTS]; FOCI]);
        for (from, (p_re, p_im)) in self.lanes.re.iter().zip(&self.lanes.im).enumerate() {
            for to in 0..FOCI {
                let at = (first + to) * count + from;
                let (r_re, r_im) = (self.gram_re[at], self.gram_im[at]);
                for start in 0..STARTS {
                    re[to][start] = fused::<I>(r_re, p_re[start], re[to][start]);
                    im[to][start] = fused::<I>(r_re, p_im[start], im[to][start]);
                    re[to][start] = fused::<I>(-r_im, p_im[start], re[to][start]);
                    im[to][start] = fused::<I>(r_im, p_re[start], im[to][start]);
                }
            }
        }
        for to in 0..FOCI {
            (self.heard.re[first + to], self.heard.im[first + to]) = (re[to], im[to]);
        }
    }

    /// p = A ph(heard).
    #[inline(always)]
    fn turn<I: Instructions>(&mut self) {
        for m in 0..self.targets.len() {
            let (re, im) = (self.heard.re[m], self.heard.im[m]);
            let mut norm2 = [0.0; STARTS];
            for start in 0..STARTS {
                norm2[start] = fused::<I>(re[start], re[start], im[start] * im[start]).max(1e-30);
            }
            let rough = I::rough_inverse_roots(&norm2);
            for start in 0..STARTS {
                // Newton's step for 1/√x.
                let inverse =
                    -0.5 * rough[start] * fused::<I>(norm2[start] * rough[start], rough[start], -3.0);
                self.lanes.re[m][start] = self.targets[m] * re[start] * inverse;
                self.lanes.im[m][start] = self.targets[m] * im[start] * inverse;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::acoustics::Aperture;
    use crate::scene::Scene;

    /// R of foci in a row, 10 cm above the usual array and so far apart that neighbours hinder each other in phase.
    fn row(count: usize) -> Phasors {
        const APART: f64 = 0.011;
        let at = |m: usize| DVec3::new(APART * (m as f64 - (count - 1) as f64 / 2.0), 0.0, 0.1);
        Aperture::new(&Scene::default()).transfer(&(0..count).map(at).collect::<Vec<_>>()).gram(None)
    }

    /// R p.
    fn heard(gram: &Phasors, p: &[Complex64]) -> Vec<Complex64> {
        let count = p.len();
        (0..count).map(|m| (0..count).map(|i| gram.at(m * count + i) * p[i]).sum()).collect()
    }

    /// p* R p.
    fn power(gram: &Phasors, p: &[Complex64]) -> f64 {
        p.iter().zip(heard(gram, p)).map(|(p, heard)| (p.conj() * heard).re).sum()
    }

    fn found(gram: &Phasors, targets: &[f64], iterations: usize, batch: usize) -> Vec<Complex64> {
        climbed(gram, targets, iterations, batch).strongest().to_vec(targets.len())
    }

    #[test]
    fn the_strongest_of_scattered_starts_is_better_than_their_mean() {
        for count in [2, 5, 8] {
            let gram = row(count);
            let targets: Vec<_> = (1..=count).map(|m| 40.0 * m as f64).collect();
            let loudest = 40.0 * count as f64;
            // With scattered phases, interference between foci averages out.
            let mean: f64 = (0..count).map(|m| gram.re[m * count + m] * (targets[m] / loudest).powi(2)).sum();
            let [first, second] = [0, 1].map(|batch| found(&gram, &targets, 0, batch));
            assert!(power(&gram, &first) > 1.04 * mean && power(&gram, &second) > 1.04 * mean, "{count}");
            assert_ne!(first, second, "another batch has other starts");
        }
    }

    #[test]
    fn every_step_climbs_until_foci_play_what_they_hear() {
        // Foci in fours, in twos and alone.
        for count in 1..=9 {
            let gram = row(count);
            let targets: Vec<_> = (0..count).map(|m| 1.0 + m as f64).collect();
            let powers: Vec<_> =
                (0..8).map(|iterations| power(&gram, &found(&gram, &targets, iterations, 0))).collect();
            let climbs = powers.windows(2).all(|pair| pair[1] > pair[0] * (1.0 - 1e-5));
            // A few hardly need to.
            assert!(climbs && (count < 5 || powers[7] > 1.002 * powers[0]), "{count}: {powers:?}");
            let p = found(&gram, &targets, 400, 0);
            for ((p, heard), target) in p.iter().zip(heard(&gram, &p)).zip(&targets) {
                let expected = target / count as f64 * heard / heard.norm();
                assert!((p - expected).norm() < 2e-3, "{count}: {p} is not {expected}");
            }
        }
    }

    #[test]
    fn foci_play_their_targets_to_the_last_bits_of_f32() {
        let targets = [1.0, 2.5, 0.3, 7.0, 4.0];
        // Sets differ in how rough a root they begin with.
        for (isa, iterations) in Isa::available().into_iter().flat_map(|isa| [(isa, 1), (isa, 50)]) {
            let found = climbed_with(isa, &row(5), &targets, iterations, 0).strongest();
            for (p, target) in found.iter().zip(targets) {
                let off = p.norm() / (target / 7.0) - 1.0;
                assert!(off.abs() < 1e-6, "{}, {iterations}: {p} is off by {off}", isa.name());
            }
        }
    }

    #[test]
    fn a_silent_focus_leaves_the_others_alone() {
        // Behind the array, and before it.
        let places = [DVec3::Z * -0.1, DVec3::Z * 0.1];
        let gram = Aperture::new(&Scene::default()).transfer(&places).gram(None);
        assert!(gram.re[0] == 0.0 && gram.re[3] > 0.0, "{gram:?}");
        for iterations in [1, 20] {
            let heard = found(&gram, &[1.0, 2.0], iterations, 0)[1];
            assert!((heard.norm() - 1.0).abs() < 1e-6, "{iterations}: {heard}");
        }
    }
}
