//! The Jacobian of the moduli of the pressure at points by the phases of the elements.

use crate::acoustics::transfer::{BLOCK, block};
use crate::acoustics::transfer::{Phasors, Transfer};
use crate::gauge;
use crate::simd::{Instructions, Isa, Kernel, accumulate, fused64, lanes};

/// Number of points summed in parallel.
const TILE: usize = 4;

/// J Jᵀ of the derivatives of the moduli |p_m| by the phases of the elements, J_mn = -Im(e^{-jθ_m} H_mn u_n), θ_m the phase of
/// p_m: the Gram matrix of the phase Jacobian, Pa²/rad².
#[derive(Clone, Debug, Default)]
pub struct PhaseJacobian {
    /// Points, padded to whole blocks.
    stride: usize,
    /// J: a row per point, padded like the transfer's, and rows of zeros to whole blocks of points.
    by_point: Vec<f64>,
    /// Jᵀ: a row of `stride` per element.
    by_element: Vec<f64>,
    /// J Jᵀ, a row of `stride` per point; rows are padded to whole tiles.
    products: Vec<f64>,
}

impl PhaseJacobian {
    /// Updates to a drive of full amplitude and the directions e^{jθ} of its pressures.
    pub fn update(&mut self, transfer: &Transfer, excitation: &Phasors, directions: &Phasors) {
        self.stride = transfer.points.next_multiple_of(BLOCK);
        self.by_point.resize(transfer.stride * self.stride, 0.0);
        self.by_element.resize(transfer.stride * self.stride, 0.0);
        self.products.resize(transfer.points.next_multiple_of(TILE) * self.stride, 0.0);
        Isa::best().run(Update { transfer, excitation, directions, jacobian: self });
    }

    /// J Jᵀ of two points, the second no later than the first.
    pub fn product(&self, point: usize, other: usize) -> f64 {
        self.products[point * self.stride + other]
    }
}

struct Update<'a> {
    transfer: &'a Transfer,
    excitation: &'a Phasors,
    directions: &'a Phasors,
    jacobian: &'a mut PhaseJacobian,
}

impl Kernel for Update<'_> {
    type Output = ();

    #[inline(always)]
    fn run<I: Instructions>(self) {
        let Self { transfer, excitation, directions, jacobian } = self;
        let PhaseJacobian { stride, by_point, by_element, products } = jacobian;
        let stride = *stride;
        for (point, (&cos, &sin)) in directions.re.iter().zip(&directions.im).enumerate() {
            let row = &mut by_point[point * transfer.stride..(point + 1) * transfer.stride];
            for (index, derivative) in row.as_chunks_mut::<BLOCK>().0.iter_mut().enumerate() {
                let start = index * BLOCK;
                let u_re: &[f64; BLOCK] = excitation.re[start..].first_chunk().expect("as long as a row");
                let u_im: &[f64; BLOCK] = excitation.im[start..].first_chunk().expect("as long as a row");
                let (h_re, h_im) = block(transfer, point, start);
                // -Im(h u e^{-jθ}), u turned first.
                let re = lanes::<BLOCK>(|i| fused64::<I>(u_re[i], cos, u_im[i] * sin));
                let im = lanes::<BLOCK>(|i| fused64::<I>(u_re[i], sin, -u_im[i] * cos));
                *derivative = lanes(|i| fused64::<I>(h_re[i], im[i], -h_im[i] * re[i]));
            }
        }
        for first in (0..transfer.points).step_by(TILE) {
            let rows = &by_point[first * transfer.stride..(first + TILE) * transfer.stride];
            let (a, rest) = rows.split_at(transfer.stride);
            let (b, rest) = rest.split_at(transfer.stride);
            let (c, d) = rest.split_at(transfer.stride);
            let four = a.iter().zip(b).zip(c).zip(d);
            for (to, (((a, b), c), d)) in by_element.chunks_exact_mut(stride).zip(four) {
                to[first..first + TILE].copy_from_slice(&[*a, *b, *c, *d]);
            }
        }
        for first in (0..transfer.points).step_by(TILE).take_while(|_| !gauge::is_cancelled()) {
            for start in (0..first + TILE).step_by(BLOCK) {
                let mut sums = [[0.0; BLOCK]; TILE];
                for row in by_element.chunks_exact(stride) {
                    let others: &[f64; BLOCK] = row[start..].first_chunk().expect("whole blocks");
                    for (sum, &derivative) in sums.iter_mut().zip(&row[first..first + TILE]) {
                        accumulate::<I, BLOCK>(sum, others, derivative);
                    }
                }
                for (point, sum) in (first..).zip(&sums) {
                    products[point * stride + start..][..BLOCK].copy_from_slice(sum);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use num_complex::Complex64;

    use super::*;
    use crate::acoustics::aperture::Aperture;
    use crate::scene::Scene;

    #[test]
    fn it_is_how_moduli_change_with_phases() {
        // Points in twos and not, elements that fill no block, one and more.
        for (points, rows, columns) in [(1, 1, 3), (2, 4, 4), (5, 5, 7)] {
            let mut scene = Scene::default();
            (scene.array.rows, scene.array.columns) = (rows, columns);
            let at = |m: usize| DVec3::new(0.01 * m as f64, 0.003 * (m * m) as f64, 0.1);
            let transfer = Aperture::new(&scene).transfer(&(0..points).map(at).collect::<Vec<_>>());
            let phase = |n: usize| 7.0 * (n as f64 * 0.618_033_988).fract();
            let mut u = transfer.excitation();
            (0..transfer.elements).for_each(|n| u.set(n, Complex64::from_polar(1.0, phase(n))));
            let made = transfer.pressure(&u.to_vec(transfer.elements));
            let mut jacobian = PhaseJacobian::default();
            jacobian.update(&transfer, &u, &made.iter().map(|p| p / p.norm()).collect());

            let derivative = |m: usize, n: usize| {
                const STEP: f64 = 1e-6;
                let turned = |by: f64| {
                    let change = u.at(n) * (Complex64::from_polar(1.0, by) - 1.0);
                    (made[m] + transfer.at(m, n) * change).norm()
                };
                (turned(STEP) - turned(-STEP)) / (2.0 * STEP)
            };
            for i in 0..points {
                for j in 0..=i {
                    let all = 0..transfer.elements;
                    let expected: f64 = all.map(|n| derivative(i, n) * derivative(j, n)).sum();
                    let got = jacobian.product(i, j);
                    assert!((got - expected).abs() < 1e-2, "{points} {i} {j}: {got} is not {expected}");
                }
            }
        }
    }
}
