//! Background tasks with waits: threads on a computer; in a page, which has one thread and may not block, tasks
//! between other work.
//!
//! Waiting code is `async` and exists once. On a thread it never yields: waits block, as exactly as the system's
//! clock allows, and the task spins on the clock for the last 0.3 ms before a swap. In a page each wait is a timer
//! or an event. The timers run in a worker (`page.js`), accurate to about a millisecond also in a hidden page,
//! without spinning.

mod lock;
#[cfg(not(target_arch = "wasm32"))]
mod thread;
#[cfg(not(target_arch = "wasm32"))]
use crate::device::task::thread as here;

#[cfg(target_arch = "wasm32")]
mod page;
#[cfg(target_arch = "wasm32")]
use crate::device::task::page as here;

pub use crate::device::task::lock::locked;
#[cfg(target_arch = "wasm32")]
pub use crate::device::task::page::within;

use std::io;
use std::sync::{Mutex, MutexGuard};

use web_time::{Duration, Instant};

#[cfg(not(target_arch = "wasm32"))]
pub use pollster::block_on as finish;

/// Waits for a time. A page always does its other work meanwhile.
pub async fn sleep(time: Duration) {
    here::sleep(time).await;
}

/// Runs short work: immediately, or in a page as soon as possible.
pub fn run(work: impl Future<Output = ()> + 'static) {
    here::run(work);
}

/// Waits without yielding. A page does not wait, since the remaining work runs without this program.
pub fn linger(time: Duration) {
    here::linger(time);
}

/// Asks for this task to run before others, where tasks are threads and the system allows it.
pub fn hurry() {
    here::hurry();
}

/// A wait ends this long before an exact deadline; [`watch`] covers the rest.
pub const WATCHFUL: Duration = here::WATCHFUL;

/// Waits until a time less than [`WATCHFUL`] away by polling the clock where sleeping is inexact. A page relies on
/// its timers.
pub fn watch(due: Instant) {
    here::watch(due);
}

/// A running task. It continues when this is dropped.
#[derive(Debug)]
pub struct Task(here::Task);

impl Task {
    /// Starts the future made by `make` in its own context, which it never leaves.
    ///
    /// # Errors
    /// The thread could not be started.
    pub fn start<F>(name: &str, make: impl FnOnce() -> F + Send + 'static) -> io::Result<Self>
    where
        F: Future<Output = ()> + 'static,
    {
        here::Task::start(name, make).map(Self)
    }

    /// Waits for its end; a page continues without waiting.
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

    /// Wakes waiting tasks after a change.
    pub fn ring(&self) {
        self.bell.ring();
    }

    /// Waits while the condition holds, at most for `timeout`.
    pub async fn wait_while(&self, timeout: Duration, is_so: impl Fn(&T) -> bool) {
        self.bell.wait_while(&self.value, timeout, is_so).await;
    }
}

#[cfg(all(test, not(target_arch = "wasm32")))]
mod tests {
    use std::sync::atomic::{AtomicBool, Ordering};

    use super::*;

    #[test]
    fn a_change_wakes_who_waits_for_it() {
        let watched = std::sync::Arc::new(Watched::new(false));
        let its = std::sync::Arc::clone(&watched);
        const TIMEOUT: Duration = Duration::from_secs(20);
        let wait = move || {
            let begun = Instant::now();
            finish(its.wait_while(TIMEOUT, |value| !value));
            begun.elapsed()
        };
        let waiting = std::thread::Builder::new().name("waiting".to_owned()).spawn(wait).unwrap();
        std::thread::sleep(Duration::from_millis(20));
        *watched.lock() = true;
        watched.ring();
        assert!(waiting.join().unwrap() < TIMEOUT);
    }

    #[test]
    fn lingering_takes_its_time() {
        const TIME: Duration = Duration::from_millis(20);
        let begun = Instant::now();
        linger(TIME);
        assert!(begun.elapsed() >= TIME);
    }

    #[test]
    fn a_joined_task_has_ended() {
        static ENDED: AtomicBool = AtomicBool::new(false);
        let work = || async {
            sleep(Duration::from_millis(20)).await;
            ENDED.store(true, Ordering::SeqCst);
        };
        Task::start("a test's", work).unwrap().join();
        assert!(ENDED.load(Ordering::SeqCst));
    }
}
