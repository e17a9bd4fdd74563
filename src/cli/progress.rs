//! How far a long step is: a bar with the time that is left on a terminal, and one note with an estimate elsewhere.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use indicatif::{HumanDuration, ProgressBar, ProgressStyle};

use crate::gauge::Gauge;
use crate::studio::output::note;

/// In which progress is counted.
const STEPS: f64 = 10_000.0;
/// s that need no progress bar, and after which an estimate is worth something.
const SHORT: f64 = 1.0;
/// s that are worth a note.
const LONG: f64 = 5.0;

/// Shows the progress of a step of this name.
pub fn begin(name: &'static str) -> Gauge {
    let style = ProgressStyle::with_template("{msg} {bar:30} {percent} %, {eta} left");
    let bar = ProgressBar::new(STEPS as u64)
        .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
        .with_message(name);
    let (begun, is_noted) = (Instant::now(), AtomicBool::new(false));
    Gauge::new(move |part| {
        let elapsed = begun.elapsed();
        if part >= 1.0 {
            return bar.finish_and_clear();
        }
        if elapsed.as_secs_f64() < SHORT || part <= 0.0 {
            return;
        }
        bar.set_position((part * STEPS) as u64);
        let all = elapsed.div_f64(part);
        if bar.is_hidden() && all.as_secs_f64() > LONG && !is_noted.swap(true, Ordering::Relaxed) {
            note(&format!(
                "{name}: {:.0} % are done; they take about {} in all",
                100.0 * part,
                HumanDuration(all)
            ));
        }
    })
}
