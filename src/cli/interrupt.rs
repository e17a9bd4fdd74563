//! Ctrl-C, Ctrl-\, termination and hangup as a flag, so that commands finish lines and files and silence boards.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use signal_hook::consts::TERM_SIGNALS;

#[derive(Debug)]
pub struct Interrupted(Arc<AtomicBool>);

impl Interrupted {
    pub fn is_set(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// Does this as soon as the flag is set, on another thread.
    ///
    /// # Errors
    /// System errors.
    #[cfg(unix)]
    pub fn then(&self, work: impl FnOnce() + Send + 'static) -> std::io::Result<()> {
        let mut signals = signal_hook::iterator::Signals::new(signals())?;
        let flag = Arc::clone(&self.0);
        let wait = move || {
            if flag.load(Ordering::Relaxed) || signals.forever().next().is_some() {
                work();
            }
        };
        std::thread::Builder::new().name("signals".to_owned()).spawn(wait).map(drop)
    }

    /// Windows tells no thread: the flag is looked at often enough.
    #[cfg(not(unix))]
    pub fn then(&self, _: impl FnOnce() + Send + 'static) -> std::io::Result<()> {
        Ok(())
    }
}

fn signals() -> impl Iterator<Item = i32> {
    let hangup = if cfg!(unix) { Some(1) } else { None };
    TERM_SIGNALS.iter().copied().chain(hangup)
}

/// Makes these signals only set the flag; a second one ends the program immediately.
///
/// # Errors
/// System errors.
pub fn watch() -> std::io::Result<Interrupted> {
    let flag = Arc::new(AtomicBool::new(false));
    for signal in signals() {
        signal_hook::flag::register_conditional_shutdown(signal, 130, Arc::clone(&flag))?;
        signal_hook::flag::register(signal, Arc::clone(&flag))?;
    }
    Ok(Interrupted(flag))
}
