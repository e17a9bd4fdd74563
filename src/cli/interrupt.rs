//! Ctrl-C, termination and hangup as a flag, so that commands finish lines and files and silence boards.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use signal_hook::consts::{SIGINT, SIGTERM};

#[derive(Debug)]
pub struct Interrupted(Arc<AtomicBool>);

impl Interrupted {
    pub fn is_set(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// From now on these signals only set the flag; a second one ends the program immediately.
///
/// # Errors
/// System errors.
pub fn watch() -> std::io::Result<Interrupted> {
    let flag = Arc::new(AtomicBool::new(false));
    let hangup = if cfg!(unix) { Some(1) } else { None };
    for signal in [SIGINT, SIGTERM].into_iter().chain(hangup) {
        signal_hook::flag::register_conditional_shutdown(signal, 130, Arc::clone(&flag))?;
        signal_hook::flag::register(signal, Arc::clone(&flag))?;
    }
    Ok(Interrupted(flag))
}
