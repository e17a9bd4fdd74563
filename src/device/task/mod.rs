//! Background tasks with waits: threads on a computer; in a page, which has one thread and may not block, tasks
//! between other work.
//!
//! Waiting code is `async`. On a thread it never yields: waits block, as exactly as the system's clock allows. In a
//! page each wait is a timer or an event.

#[cfg(not(target_arch = "wasm32"))]
mod thread;
#[cfg(not(target_arch = "wasm32"))]
use crate::device::task::thread as here;

#[cfg(target_arch = "wasm32")]
mod page;
#[cfg(target_arch = "wasm32")]
use crate::device::task::page as here;

#[cfg(target_arch = "wasm32")]
pub use crate::device::task::page::within;

use std::io;
use std::sync::{Mutex, MutexGuard, PoisonError};

use web_time::{Duration, Instant};

#[cfg(not(target_arch = "wasm32"))]
pub use pollster::block_on as finish;

/// What is locked here stays whole when a thread panics.
pub fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Waits for a time. A page is always let do its other work meanwhile, however short the time.
pub async fn sleep(time: Duration) {
    here::sleep(time).await;
}

/// Runs what takes a moment only: here and now, or in a page as soon as that can be.
pub fn run(work: impl Future<Output = ()> + 'static) {
    here::run(work);
}

/// Lets a time pass where nothing may yield. A page goes on at once: what is left to do there has no need of this program.
pub fn linger(time: Duration) {
    here::linger(time);
}

/// So long before an exact moment a wait ends, and [`watch`] begins.
pub const WATCHFUL: Duration = here::WATCHFUL;

/// Until a moment that is less than [`WATCHFUL`] away: looks at the clock where sleeping is not exact. A page cannot, and is as exact as
/// its timers.
pub fn watch(due: Instant) {
    here::watch(due);
}

/// Work under way. It goes on when this is dropped.
#[derive(Debug)]
pub struct Task(here::Task);

impl Task {
    /// Begins what `make` makes, which is made where it runs and never leaves.
    ///
    /// # Errors
    /// No thread to be had.
    pub fn start<F>(name: &str, make: impl FnOnce() -> F + Send + 'static) -> io::Result<Self>
    where
        F: Future<Output = ()> + 'static,
    {
        here::Task::start(name, make).map(Self)
    }

    /// Waits until it has ended; a page cannot wait, and goes on.
    pub fn join(self) {
        self.0.join();
    }
}

/// A value that one changes and another waits on.
#[derive(Debug)]
pub struct Watched<T> {
    value: Mutex<T>,
    bell: here::Bell,
}

impl<T> Watched<T> {
    pub fn new(value: T) -> Self {
        Self { value: Mutex::new(value), bell: here::Bell::default() }
    }

    pub fn lock(&self) -> MutexGuard<'_, T> {
        locked(&self.value)
    }

    /// Wakes who waits, after a change.
    pub fn ring(&self) {
        self.bell.ring();
    }

    /// Waits as long as the value is so, for `timeout` at most.
    pub async fn wait_while(&self, timeout: Duration, is_so: impl Fn(&T) -> bool) {
        self.bell.wait_while(&self.value, timeout, is_so).await;
    }
}
