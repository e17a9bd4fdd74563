//! CPU and wall time: medians and quartiles over rounds in which the compared tasks alternate.

use std::ops::AddAssign;
use std::time::{Duration, Instant};

use cpu_time::ProcessTime;
use serde_json::{Value, json};

/// Rounds in which a task and its baseline alternate, so that both see the same load.
pub const ROUNDS: usize = 5;
/// Time for the runs of a task in one round, from one to [`MOST_RUNS`]: enough runs of a fast task that those with cold
/// caches do not determine the median.
const BUDGET: Duration = Duration::from_millis(60);
const MOST_RUNS: usize = 30;

/// Time of a task, s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spent {
    /// Sum over all threads of the process.
    pub cpu: f64,
    pub wall: f64,
}

impl Spent {
    /// Times one run.
    pub fn once<T>(work: impl FnOnce() -> T) -> (Self, T) {
        let (cpu, wall) = (ProcessTime::now(), Instant::now());
        let done = work();
        (Self { cpu: cpu.elapsed().as_secs_f64(), wall: wall.elapsed().as_secs_f64() }, done)
    }

    /// Medians of as many runs as the budget allows; `work` receives the number of the run.
    pub fn on<E>(mut work: impl FnMut(usize) -> Result<(), E>) -> Result<Self, E> {
        let mut runs = Vec::new();
        let start = Instant::now();
        while runs.is_empty() || (start.elapsed() < BUDGET && runs.len() < MOST_RUNS) {
            let (spent, done) = Self::once(|| work(runs.len()));
            done?;
            runs.push(spent);
        }
        Ok(Self::median(&runs))
    }

    /// Means over several tasks.
    pub fn mean(pieces: &[Self]) -> Self {
        let of = |time: fn(&Self) -> f64| pieces.iter().map(time).sum::<f64>() / pieces.len() as f64;
        Self { cpu: of(|piece| piece.cpu), wall: of(|piece| piece.wall) }
    }

    /// Medians over several runs.
    pub fn median(runs: &[Self]) -> Self {
        let of = |time: fn(&Self) -> f64| median(&runs.iter().map(time).collect::<Vec<_>>());
        Self { cpu: of(|run| run.cpu), wall: of(|run| run.wall) }
    }
}

impl AddAssign for Spent {
    fn add_assign(&mut self, other: Self) {
        self.cpu += other.cpu;
        self.wall += other.wall;
    }
}

/// Time of a task in each round.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Times(Vec<Spent>);

impl Times {
    pub fn push(&mut self, spent: Spent) {
        self.0.push(spent);
    }

    /// Median over the rounds, ms of all threads.
    pub fn cpu_ms(&self) -> f64 {
        1e3 * Spent::median(&self.0).cpu
    }

    /// Median over the rounds, ms.
    pub fn wall_ms(&self) -> f64 {
        1e3 * Spent::median(&self.0).wall
    }

    /// Ratio of the CPU times, round by round.
    pub fn over(&self, other: &Self) -> Spread {
        Spread::of(self.0.iter().zip(&other.0).map(|(own, other)| own.cpu / other.cpu).collect())
    }

    /// Mean over several tasks, round by round.
    pub fn mean(works: &[&Self]) -> Self {
        let rounds = works.iter().map(|work| work.0.len()).min().unwrap_or_default();
        let round = |round: usize| Spent::mean(&works.iter().map(|work| work.0[round]).collect::<Vec<_>>());
        (0..rounds).map(round).collect()
    }

    pub fn scaled(&self, factor: f64) -> Self {
        let scaled = |spent: &Spent| Spent { cpu: spent.cpu * factor, wall: spent.wall * factor };
        Self(self.0.iter().map(scaled).collect())
    }

    /// CPU ms, and wall ms in brackets.
    pub fn text(&self) -> String {
        if self.0.is_empty() {
            return "-".to_owned();
        }
        format!("{} ({})", digits(self.cpu_ms()), digits(self.wall_ms()))
    }

    pub fn json(&self) -> Value {
        json!({ "cpu_ms": self.cpu_ms(), "wall_ms": self.wall_ms() })
    }
}

impl FromIterator<Spent> for Times {
    fn from_iter<I: IntoIterator<Item = Spent>>(rounds: I) -> Self {
        Self(rounds.into_iter().collect())
    }
}

/// Median and quartiles of repeated measurements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    pub median: f64,
    pub quartiles: [f64; 2],
}

impl Spread {
    /// NaN without values.
    pub fn of(mut values: Vec<f64>) -> Self {
        values.sort_by(f64::total_cmp);
        let [low, median, high] = [0.25, 0.5, 0.75].map(|part| quantile(&values, part));
        Self { median, quartiles: [low, high] }
    }

    /// The median with three significant digits.
    pub fn text(&self) -> String {
        digits(self.median)
    }

    pub fn quartiles_text(&self) -> String {
        self.quartiles.map(digits).join(" … ")
    }

    pub fn json(&self) -> Value {
        json!({ "median": self.median, "quartiles": self.quartiles })
    }
}

pub fn median(values: &[f64]) -> f64 {
    Spread::of(values.to_vec()).median
}

/// Linear interpolation between the neighbouring sorted values; NaN without values.
fn quantile(sorted: &[f64], part: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else { return f64::NAN };
    let place = part * last as f64;
    let (below, above) = (sorted[place.floor() as usize], sorted[place.ceil() as usize]);
    // Infinite values have no difference.
    if below == above { below } else { below + (above - below) * place.fract() }
}

/// Three significant digits.
pub fn digits(value: f64) -> String {
    let magnitude = value.abs();
    match magnitude {
        0.0 => "0".to_owned(),
        0.001..0.995 => {
            let decimals = 3 + (-magnitude.log10()).floor().max(0.0) as usize;
            format!("{value:.decimals$}")
        }
        0.995..9.995 => format!("{value:.2}"),
        9.995..99.95 => format!("{value:.1}"),
        99.95..1e6 => format!("{value:.0}"),
        _ => format!("{value:.1e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quartiles_interpolate_between_values() {
        let spread = Spread::of(vec![5.0, 1.0, 4.0, 2.0]);
        assert_eq!((spread.median, spread.quartiles), (3.0, [1.75, 4.25]));
        assert_eq!(Spread::of(vec![7.0]), Spread { median: 7.0, quartiles: [7.0, 7.0] });
        assert!(Spread::of(Vec::new()).median.is_nan());
        assert_eq!(Spread::of(vec![f64::INFINITY; 2]).median, f64::INFINITY);
    }

    #[test]
    fn ratios_are_of_the_same_round() {
        let times = |cpu: &[f64]| Times(cpu.iter().map(|&cpu| Spent { cpu, wall: cpu / 2.0 }).collect());
        // The ratio is independent of the machine's slowdown from round to round.
        let ratio = times(&[10.0, 20.0, 40.0]).over(&times(&[1.0, 2.0, 4.0]));
        assert_eq!((ratio.median, ratio.quartiles), (10.0, [10.0, 10.0]));
        assert_eq!(times(&[10.0, 20.0, 40.0]).cpu_ms(), 20_000.0);
        assert_eq!(times(&[10.0, 20.0, 40.0]).scaled(0.1).wall_ms(), 1000.0);
    }

    #[test]
    fn numbers_have_three_significant_digits() {
        let texts = [0.0, 0.001_234, 0.0512, 0.999, 1.5, 31.46, 512.3, 2e7, -3.0, 1e-5].map(digits);
        assert_eq!(
            texts,
            ["0", "0.00123", "0.0512", "1.00", "1.50", "31.5", "512", "2.0e7", "-3.00", "1.0e-5"]
        );
    }
}
