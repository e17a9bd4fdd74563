//! Generalised minimal residuals for several right sides at once.
//!
//! Y. Saad, M. H. Schultz, SIAM J. Sci. Stat. Comput. 7, 856, 1986: the Krylov space grows by one product per step, and
//! rotations keep its Hessenberg matrix triangular. All right sides take each product together, so that a matrix passes
//! through the caches once for all of them.

use num_complex::Complex64;
use rayon::prelude::*;

/// What an iteration reached.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    pub values: Vec<Complex64>,
    /// |b - A x| / |b|.
    pub residual: f64,
    pub steps: usize,
}

/// One system on its way.
struct System {
    basis: Vec<Vec<Complex64>>,
    /// Columns of the triangular matrix.
    columns: Vec<Vec<Complex64>>,
    rotations: Vec<(f64, Complex64)>,
    /// The rotated right side.
    sides: Vec<Complex64>,
    start: Vec<Complex64>,
    /// |b|
    scale: f64,
    is_done: bool,
}

/// Solves A x = b for every right side, from starts (or zero) to residuals below a tolerance relative to |b|, within a
/// number of steps. `apply` is A; `prepare` is a rough inverse of A, applied first.
pub(super) fn solve(
    rights: &[Vec<Complex64>],
    starts: Option<&[Vec<Complex64>]>,
    (tolerance, most): (f64, usize),
    apply: impl Fn(&[Vec<Complex64>]) -> Vec<Vec<Complex64>>,
    prepare: impl Fn(&[Vec<Complex64>]) -> Vec<Vec<Complex64>>,
) -> Vec<Outcome> {
    let zeros = |b: &Vec<Complex64>| vec![Complex64::ZERO; b.len()];
    let starts: Vec<_> = match starts {
        Some(starts) => starts.to_vec(),
        None => rights.iter().map(zeros).collect(),
    };
    let begun =
        if starts.iter().flatten().any(|x| *x != Complex64::ZERO) { apply(&starts) } else { starts.clone() };
    let begin = |((b, ax), start): ((&Vec<Complex64>, &Vec<Complex64>), &Vec<Complex64>)| {
        let mut rest: Vec<_> = b.iter().zip(ax).map(|(b, ax)| b - ax).collect();
        let (size, scale) = (norm(&rest), norm(b));
        if size > 0.0 {
            rest.iter_mut().for_each(|x| *x /= size);
        }
        System {
            basis: vec![rest],
            columns: Vec::new(),
            rotations: Vec::new(),
            sides: vec![size.into()],
            start: start.clone(),
            scale,
            is_done: size <= tolerance * scale,
        }
    };
    let mut systems: Vec<_> = rights.iter().zip(&begun).zip(&starts).map(begin).collect();
    for _ in 0..most {
        let newest: Vec<_> =
            systems.iter().filter(|it| !it.is_done).map(|it| it.basis[it.basis.len() - 1].clone()).collect();
        if newest.is_empty() {
            break;
        }
        let products = apply(&prepare(&newest));
        let open: Vec<_> = systems.iter_mut().filter(|it| !it.is_done).zip(products).collect();
        open.into_par_iter().for_each(|(system, product)| system.take(product, tolerance));
    }
    let combined: Vec<_> = systems.par_iter().map(System::combination).collect();
    let prepared = prepare(&combined);
    let outcome = |(system, correction): (&System, Vec<Complex64>)| Outcome {
        values: system.start.iter().zip(correction).map(|(x, c)| x + c).collect(),
        residual: if system.scale > 0.0 {
            system.sides[system.columns.len()].norm() / system.scale
        } else {
            0.0
        },
        steps: system.columns.len(),
    };
    systems.iter().zip(prepared).map(outcome).collect()
}

impl System {
    /// Takes the product with the newest vector of the basis.
    fn take(&mut self, mut product: Vec<Complex64>, tolerance: f64) {
        let mut column = Vec::with_capacity(self.basis.len() + 1);
        for vector in &self.basis {
            let part: Complex64 = vector.iter().zip(&product).map(|(v, p)| v.conj() * p).sum();
            product.iter_mut().zip(vector).for_each(|(p, v)| *p -= part * v);
            column.push(part);
        }
        let rest = norm(&product);
        for (i, (cosine, sine)) in self.rotations.iter().enumerate() {
            let (upper, lower) = (column[i], column[i + 1]);
            column[i] = upper * *cosine + sine.conj() * lower;
            column[i + 1] = lower * *cosine - sine * upper;
        }
        let last = column.len() - 1;
        let diagonal = column[last];
        let size = diagonal.norm().hypot(rest);
        // The rotation takes (diagonal, rest) to (size, 0) up to a phase.
        let (cosine, sine) = if size == 0.0 {
            (1.0, Complex64::ZERO)
        } else if diagonal.norm() == 0.0 {
            (0.0, Complex64::ONE)
        } else {
            (diagonal.norm() / size, diagonal.conj() / diagonal.norm() * (rest / size))
        };
        column[last] = diagonal * cosine + sine.conj() * rest;
        self.rotations.push((cosine, sine));
        let side = self.sides[last];
        self.sides[last] = side * cosine;
        self.sides.push(-sine * side);
        self.columns.push(column);
        self.is_done = self.sides[last + 1].norm() <= tolerance * self.scale || rest <= 1e-14 * size;
        if rest > 0.0 {
            product.iter_mut().for_each(|x| *x /= rest);
        }
        self.basis.push(product);
    }

    /// The best combination of the basis.
    fn combination(&self) -> Vec<Complex64> {
        let count = self.columns.len();
        let mut weights = self.sides[..count].to_vec();
        for i in (0..count).rev() {
            for j in i + 1..count {
                let later = weights[j];
                weights[i] -= self.columns[j][i] * later;
            }
            let pivot = self.columns[i][i];
            weights[i] = if pivot == Complex64::ZERO { Complex64::ZERO } else { weights[i] / pivot };
        }
        let mut sum = vec![Complex64::ZERO; self.start.len()];
        for (weight, vector) in weights.iter().zip(&self.basis) {
            sum.iter_mut().zip(vector).for_each(|(sum, v)| *sum += weight * v);
        }
        sum
    }
}

fn norm(values: &[Complex64]) -> f64 {
    values.iter().map(Complex64::norm_sqr).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn systems_are_solved_together() {
        let count = 30;
        let unit = |i: usize, step: f64| (i as f64 * step).fract() - 0.5;
        let entry = |i: usize, j: usize| {
            let index = 1 + 31 * i + j;
            let own = if i == j { 3.0 } else { 0.0 };
            Complex64::new(own + unit(index, 0.618_034), unit(index, 0.754_878))
        };
        let apply = |vectors: &[Vec<Complex64>]| {
            let of = |x: &Vec<Complex64>| {
                (0..count).map(|i| (0..count).map(|j| entry(i, j) * x[j]).sum()).collect::<Vec<Complex64>>()
            };
            vectors.iter().map(of).collect::<Vec<_>>()
        };
        let wanted: Vec<Vec<_>> = [5, 9]
            .map(|seed| {
                (0..count).map(|i| Complex64::new(unit(i * seed + 1, 0.57), unit(i + seed, 0.31))).collect()
            })
            .to_vec();
        let rights = apply(&wanted);
        let third = |vectors: &[Vec<Complex64>]| {
            vectors.iter().map(|v| v.iter().map(|x| x / 3.0).collect()).collect::<Vec<Vec<_>>>()
        };
        let solved = solve(&rights, None, (1e-10, 60), apply, third);
        for (solved, wanted) in solved.iter().zip(&wanted) {
            let off = solved.values.iter().zip(wanted).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
            assert!(off < 1e-8 && solved.residual < 1e-10 && solved.steps <= 30, "{off} {}", solved.steps);
        }
        let again = solve(&rights, Some(&wanted), (1e-10, 60), apply, third);
        assert!(again.iter().all(|it| it.steps == 0), "a start at the solution");
        let silent = solve(&[vec![Complex64::ZERO; count]], None, (1e-6, 60), apply, third);
        assert!(silent[0].values.iter().all(|x| *x == Complex64::ZERO) && silent[0].residual == 0.0);
    }
}
