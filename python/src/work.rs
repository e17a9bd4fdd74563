//! Long computations without the GIL, with Ctrl-C and progress reports.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use sonoglyph::gauge::{Cancel, Gauge};

/// Interval of checks for Ctrl-C and of progress reports.
const LOOK: Duration = Duration::from_millis(40);

/// Work of less time is done by the caller: Ctrl-C can wait for it, and handing it over may take as long.
pub const BRIEF: Duration = Duration::from_millis(10);

type Task = Box<dyn FnOnce() + Send>;

/// Idle threads: starting one costs a tenth of a millisecond, and fresh memory.
static IDLE: Mutex<Vec<SyncSender<Task>>> = Mutex::new(Vec::new());

fn idle() -> MutexGuard<'static, Vec<SyncSender<Task>>> {
    IDLE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Runs a task on an idle thread, or on a new one.
fn hand_over(task: Task) -> std::io::Result<()> {
    let waiting = idle().pop();
    let worker = match waiting {
        Some(worker) => worker,
        None => {
            let (worker, tasks) = sync_channel::<Task>(1);
            let again = worker.clone();
            let serve = move || {
                while let Ok(task) = tasks.recv() {
                    task();
                    idle().push(again.clone());
                }
            };
            std::thread::Builder::new().name("sonoglyph".to_owned()).spawn(serve)?;
            worker
        }
    };
    // It lives as long as the program.
    worker.send(task).map_err(|_| std::io::Error::other("a thread of Sonoglyph has ended"))
}

fn bug() -> PyErr {
    PyRuntimeError::new_err("a bug of Sonoglyph: see standard error")
}

/// Runs work without the GIL and reports its completed fraction, 0 to 1, to `progress`: on this thread if it `is_brief`, otherwise on a
/// separate one.
///
/// # Errors
/// Ctrl-C (the work ends at its next progress report, a solver at its next step), and exceptions of `progress`.
pub fn run<T: Send + 'static>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    is_brief: bool,
    work: impl FnOnce(&Gauge) -> T + Send + 'static,
) -> PyResult<T> {
    if is_brief && progress.is_none() {
        return py.detach(|| catch_unwind(AssertUnwindSafe(|| work(&Gauge::default())))).map_err(|_| bug());
    }
    let (stop, part) = (Cancel::default(), Arc::new(AtomicU64::new(0)));
    let (stopped, told) = (stop.clone(), Arc::clone(&part));
    let gauge = Gauge::new(move |part| {
        told.store(part.to_bits(), Ordering::Relaxed);
        if stopped.is_cancelled() {
            // The receiver is gone after Ctrl-C.
            resume_unwind(Box::new("interrupted"));
        }
    })
    .until(&stop);
    let (sender, receiver) = sync_channel(1);
    hand_over(Box::new(move || {
        let made = catch_unwind(AssertUnwindSafe(|| gauge.lead(|| work(&gauge))));
        // The receiver is gone after Ctrl-C.
        let _ = sender.send(made);
    }))?;
    let receiver = Mutex::new(receiver);
    let wait = || {
        let receiver = receiver.lock().unwrap_or_else(PoisonError::into_inner);
        receiver.recv_timeout(LOOK)
    };
    let mut last = 0;
    loop {
        match py.detach(wait) {
            Ok(Ok(made)) => return Ok(made),
            Ok(Err(_)) | Err(RecvTimeoutError::Disconnected) => {
                return Err(bug());
            }
            Err(RecvTimeoutError::Timeout) => {
                let now = part.load(Ordering::Relaxed);
                let tell = progress.filter(|_| now != std::mem::replace(&mut last, now));
                let heard = py
                    .check_signals()
                    .and_then(|()| tell.map_or(Ok(()), |tell| tell.call1((f64::from_bits(now),)).map(drop)));
                if let Err(error) = heard {
                    stop.cancel();
                    return Err(error);
                }
            }
        }
    }
}
