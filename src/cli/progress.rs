//! Progress of long steps: a bar with the remaining time on a terminal, elsewhere one note with the expected time.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use indicatif::{HumanDuration, ProgressBar, ProgressStyle};

use crate::gauge::Gauge;
use crate::studio::output::note;

/// Resolution of the bar.
const STEPS: f64 = 10_000.0;
/// s without a bar; earlier estimates are unreliable.
const SHORT: f64 = 1.0;
/// Expected s of a step with a note.
const LONG: f64 = 5.0;

/// Starts to show the progress of a step.
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
        let expected = elapsed.div_f64(part);
        if bar.is_hidden() && expected.as_secs_f64() > LONG && !is_noted.swap(true, Ordering::Relaxed) {
            note(&format!("{name}: {:.0} % done, about {} in all", 100.0 * part, HumanDuration(expected)));
        }
    })
}
