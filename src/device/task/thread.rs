//! Tasks on threads: waits block.

use std::io;
use std::sync::{Condvar, Mutex, PoisonError};
use std::thread::{self, JoinHandle};

use web_time::{Duration, Instant};

use crate::device::task::lock::locked;

#[expect(clippy::unused_async, reason = "a page's waits")]
pub async fn sleep(time: Duration) {
    thread::sleep(time);
}

pub fn run(work: impl Future<Output = ()> + 'static) {
    pollster::block_on(work);
}

pub fn linger(time: Duration) {
    thread::sleep(time);
}

/// Asks the system to run this thread before others; most systems allow this to few users.
pub fn hurry() {
    use thread_priority::{
        RealtimeThreadSchedulePolicy as RealTime, ThreadPriority, ThreadPriorityValue, ThreadSchedulePolicy,
    };
    let priority =
        ThreadPriorityValue::try_from(10).map_or(ThreadPriority::Max, ThreadPriority::Crossplatform);
    #[cfg(unix)]
    let set = thread_priority::set_thread_priority_and_policy(
        thread_priority::thread_native_id(),
        priority,
        ThreadSchedulePolicy::Realtime(RealTime::RoundRobin),
    );
    #[cfg(windows)]
    let set = thread_priority::set_current_thread_priority(priority);
    // Without it, what is written ahead has to last.
    drop(set);
}

/// Tolerance of a sleeping thread's wake-up.
pub const WATCHFUL: Duration = Duration::from_micros(300);

pub fn watch(due: Instant) {
    while Instant::now() < due {
        std::hint::spin_loop();
    }
}

#[derive(Debug)]
pub struct Task(JoinHandle<()>);

impl Task {
    pub fn start<F>(name: &str, make: impl FnOnce() -> F + Send + 'static) -> io::Result<Self>
    where
        F: Future<Output = ()> + 'static,
    {
        thread::Builder::new().name(name.to_owned()).spawn(move || pollster::block_on(make())).map(Self)
    }

    pub fn join(self) {
        // A panic has already been reported, and its port closed while unwinding.
        let _ = self.0.join();
    }
}

#[derive(Debug, Default)]
pub struct Bell(Condvar);

impl Bell {
    pub fn ring(&self) {
        self.0.notify_all();
    }

    #[expect(clippy::unused_async, reason = "a page's waits")]
    pub async fn wait_while<T>(&self, value: &Mutex<T>, timeout: Duration, is_so: impl Fn(&T) -> bool) {
        let waited = self.0.wait_timeout_while(locked(value), timeout, |value| is_so(value));
        drop(waited.unwrap_or_else(PoisonError::into_inner));
    }
}
