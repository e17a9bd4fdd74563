//! Descent by limited-memory BFGS (Nocedal & Wright, Numerical Optimization, algorithm 7.4), one step at a time.

use std::collections::VecDeque;

use crate::gauge;

/// Stored pairs of steps and gradient changes; 5 and 20 work equally well.
const PAIRS: usize = 10;
/// The largest change of an unknown in the first step, and in any other.
const FIRST: f64 = 0.1;
const LARGEST: f64 = 1.0;
/// Armijo's part of the descent that the slope promises.
const PROMISED: f64 = 1e-4;
const TRIALS: usize = 12;

/// A function to minimise: its value, with the gradient written to the second argument.
pub trait Function {
    fn evaluate(&mut self, x: &[f64], gradient: &mut [f64]) -> f64;
}

/// The state of a descent.
#[derive(Clone, Debug)]
pub struct Descent {
    pub x: Vec<f64>,
    pub value: f64,
    gradient: Vec<f64>,
    pairs: VecDeque<Pair>,
}

#[derive(Clone, Debug)]
struct Pair {
    step: Vec<f64>,
    change: Vec<f64>,
    /// step · change
    product: f64,
}

impl Descent {
    pub fn new(x: Vec<f64>, function: &mut impl Function) -> Self {
        let mut gradient = vec![0.0; x.len()];
        let value = function.evaluate(&x, &mut gradient);
        Self { x, value, gradient, pairs: VecDeque::new() }
    }

    /// Re-evaluates value and gradient after a small change of the function. Pairs are kept.
    pub fn renew(&mut self, function: &mut impl Function) {
        self.value = function.evaluate(&self.x, &mut self.gradient);
    }

    /// One step; false if no descent is found, or the search is cancelled.
    pub fn step(&mut self, function: &mut impl Function) -> bool {
        let mut direction = self.direction();
        let mut slope = dot(&direction, &self.gradient);
        if slope >= 0.0 || !slope.is_finite() {
            self.pairs.clear();
            direction = self.gradient.iter().map(|g| -g).collect();
            slope = dot(&direction, &self.gradient);
        }
        let largest = direction.iter().fold(0.0f64, |most, d| most.max(d.abs()));
        let can_go = self.value.is_finite() && slope.is_finite() && largest > 0.0 && !gauge::is_cancelled();
        if !can_go {
            return false;
        }
        let mut length = if self.pairs.is_empty() { FIRST / largest } else { (LARGEST / largest).min(1.0) };
        let mut x = vec![0.0; self.x.len()];
        let mut gradient = x.clone();
        for _ in 0..TRIALS {
            for ((to, from), d) in x.iter_mut().zip(&self.x).zip(&direction) {
                *to = from + length * d;
            }
            let value = function.evaluate(&x, &mut gradient);
            if value.is_finite() && value <= self.value + PROMISED * length * slope {
                self.go(x, value, gradient);
                return true;
            }
            // The minimum of the parabola through both values, kept inside.
            let parabola = -slope * length * length / (2.0 * (value - self.value - slope * length));
            let shorter = if parabola.is_finite() { parabola } else { 0.0 };
            length = shorter.clamp(0.1 * length, 0.5 * length);
        }
        let had_pairs = !self.pairs.is_empty();
        self.pairs.clear();
        had_pairs
    }

    /// -B⁻¹ g with the Hessian B estimated from the pairs.
    fn direction(&self) -> Vec<f64> {
        let mut direction: Vec<_> = self.gradient.iter().map(|g| -g).collect();
        let mut parts = Vec::with_capacity(self.pairs.len());
        for pair in self.pairs.iter().rev() {
            let part = dot(&pair.step, &direction) / pair.product;
            add(&mut direction, -part, &pair.change);
            parts.push(part);
        }
        if let Some(last) = self.pairs.back() {
            let scale = last.product / dot(&last.change, &last.change);
            direction.iter_mut().for_each(|d| *d *= scale);
        }
        for (pair, part) in self.pairs.iter().zip(parts.into_iter().rev()) {
            let back = dot(&pair.change, &direction) / pair.product;
            add(&mut direction, part - back, &pair.step);
        }
        direction
    }

    fn go(&mut self, x: Vec<f64>, value: f64, gradient: Vec<f64>) {
        /// Curvature relative to both lengths: pairs of less are rounding.
        const LEAST_CURVATURE: f64 = 1e-10;
        let difference =
            |to: &[f64], from: &[f64]| to.iter().zip(from).map(|(a, b)| a - b).collect::<Vec<_>>();
        let (step, change) = (difference(&x, &self.x), difference(&gradient, &self.gradient));
        let product = dot(&step, &change);
        if product > LEAST_CURVATURE * (dot(&step, &step) * dot(&change, &change)).sqrt() {
            if self.pairs.len() == PAIRS {
                self.pairs.pop_front();
            }
            self.pairs.push_back(Pair { step, change, product });
        }
        (self.x, self.value, self.gradient) = (x, value, gradient);
    }
}

/// Σ a b in partial sums, for vectorisation.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    const LANES: usize = 8;
    let (a_runs, a_rest) = a.as_chunks::<LANES>();
    let (b_runs, b_rest) = b.as_chunks::<LANES>();
    let mut sums = [0.0; LANES];
    for (a, b) in a_runs.iter().zip(b_runs) {
        for lane in 0..LANES {
            sums[lane] += a[lane] * b[lane];
        }
    }
    sums.iter().sum::<f64>() + a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum::<f64>()
}

/// to += scale · from
fn add(to: &mut [f64], scale: f64, from: &[f64]) {
    to.iter_mut().zip(from).for_each(|(to, from)| *to += scale * from);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rosenbrock's valley over neighbours: its floor is bent, and its minimum 0 at 1.
    struct Valley;

    impl Function for Valley {
        fn evaluate(&mut self, x: &[f64], gradient: &mut [f64]) -> f64 {
            gradient.fill(0.0);
            let mut value = 0.0;
            for i in 0..x.len() - 1 {
                let (off, short) = (x[i + 1] - x[i] * x[i], 1.0 - x[i]);
                value += 100.0 * off * off + short * short;
                gradient[i] -= 400.0 * off * x[i] + 2.0 * short;
                gradient[i + 1] += 200.0 * off;
            }
            value
        }
    }

    #[test]
    fn a_bent_valley_is_followed_to_its_end() {
        let mut descent = Descent::new(vec![-1.0; 20], &mut Valley);
        let mut before = descent.value;
        for step in 0..400 {
            if !descent.step(&mut Valley) {
                break;
            }
            assert!(descent.value <= before, "step {step} climbs");
            before = descent.value;
        }
        assert!(descent.value < 1e-12, "{}", descent.value);
        assert!(descent.x.iter().all(|x| (x - 1.0).abs() < 1e-5), "{:?}", descent.x);
    }

    #[test]
    fn where_nothing_is_gained_there_is_no_step() {
        struct Flat(f64);
        impl Function for Flat {
            fn evaluate(&mut self, _: &[f64], gradient: &mut [f64]) -> f64 {
                gradient.fill(self.0);
                self.0
            }
        }
        for value in [0.0, f64::NAN, f64::INFINITY] {
            let mut descent = Descent::new(vec![1.0; 3], &mut Flat(value));
            assert!(!descent.step(&mut Flat(value)), "{value}");
            assert_eq!(descent.x, [1.0; 3]);
        }
    }

    #[test]
    fn slopes_whose_squares_underflow_are_descended() {
        /// 1e-200 Σ (x - 1)²
        struct Shallow;
        impl Function for Shallow {
            fn evaluate(&mut self, x: &[f64], gradient: &mut [f64]) -> f64 {
                gradient.iter_mut().zip(x).for_each(|(slope, x)| *slope = 2e-200 * (x - 1.0));
                1e-200 * x.iter().map(|x| (x - 1.0).powi(2)).sum::<f64>()
            }
        }
        let mut descent = Descent::new(vec![0.0, 0.2, 0.4], &mut Shallow);
        for step in 0..9 {
            let before = descent.value;
            assert!(descent.step(&mut Shallow) && descent.value < before, "step {step}: {descent:?}");
        }
    }
}
