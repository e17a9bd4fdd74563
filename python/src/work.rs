//! Long work beside the interpreter: other threads of Python go on, Ctrl-C is heard, and progress is told.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::time::Duration;

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use sonoglyph::gauge::Gauge;

/// How often the interpreter is asked for Ctrl-C, and progress is told.
const LOOK: Duration = Duration::from_millis(40);

/// Does work on a thread of its own, of all of which `progress` is told the part that is done, 0 to 1.
///
/// # Errors
/// Ctrl-C (the work ends at its next sign of progress), and what `progress` raises.
pub fn run<T: Send + 'static>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Gauge) -> T + Send + 'static,
) -> PyResult<T> {
    let (stop, part) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicU64::new(0)));
    let (stopped, told) = (Arc::clone(&stop), Arc::clone(&part));
    let gauge = Gauge::new(move |part| {
        told.store(part.to_bits(), Ordering::Relaxed);
        if stopped.load(Ordering::Relaxed) {
            // Whoever waited is gone.
            resume_unwind(Box::new("interrupted"));
        }
    });
    let (sender, receiver) = sync_channel(1);
    let thread = std::thread::Builder::new().name("sonoglyph".to_owned());
    thread.spawn(move || {
        let made = catch_unwind(AssertUnwindSafe(|| gauge.lead(|| work(&gauge))));
        // The receiver is gone after Ctrl-C.
        let _ = sender.send(made);
    })?;
    let receiver = std::sync::Mutex::new(receiver);
    let wait = || {
        let receiver = receiver.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        receiver.recv_timeout(LOOK)
    };
    let mut last = 0;
    loop {
        match py.detach(wait) {
            Ok(Ok(made)) => return Ok(made),
            Ok(Err(_)) | Err(RecvTimeoutError::Disconnected) => {
                return Err(PyRuntimeError::new_err("a bug of Sonoglyph: see standard error"));
            }
            Err(RecvTimeoutError::Timeout) => {
                let now = part.load(Ordering::Relaxed);
                let tell = progress.filter(|_| now != std::mem::replace(&mut last, now));
                let heard = py
                    .check_signals()
                    .and_then(|()| tell.map_or(Ok(()), |tell| tell.call1((f64::from_bits(now),)).map(drop)));
                if let Err(error) = heard {
                    stop.store(true, Ordering::Relaxed);
                    return Err(error);
                }
            }
        }
    }
}
