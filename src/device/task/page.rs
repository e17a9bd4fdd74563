//! Tasks in a page: waits yield to the page.

use std::future::poll_fn;
use std::io;
use std::pin::{Pin, pin};
use std::sync::Mutex;
use std::task::{Poll, Waker};

use js_sys::Promise;
use wasm_bindgen::prelude::wasm_bindgen;
use wasm_bindgen_futures::{JsFuture, spawn_local};
use web_time::{Duration, Instant};

use crate::device::task::lock::locked;

#[wasm_bindgen(module = "/src/device/task/page.js")]
extern "C" {
    fn pause(milliseconds: f64) -> Promise;
}

/// A timer to the nearest millisecond.
fn timer(time: Duration) -> JsFuture {
    /// Timers have 31 bits.
    const LONGEST: f64 = 2e9;
    JsFuture::from(pause((1e3 * time.as_secs_f64()).round().min(LONGEST)))
}

pub async fn sleep(time: Duration) {
    // A timer does not fail.
    let _ = timer(time).await;
}

/// The result of `work`, if it ends in time.
pub async fn within<F: Future>(time: Duration, work: F) -> Option<F::Output> {
    let (mut work, mut timer) = (pin!(work), timer(time));
    poll_fn(|context| match work.as_mut().poll(context) {
        Poll::Ready(value) => Poll::Ready(Some(value)),
        Poll::Pending => Pin::new(&mut timer).poll(context).map(|_| None),
    })
    .await
}

pub fn run(work: impl Future<Output = ()> + 'static) {
    spawn_local(work);
}

pub fn linger(_: Duration) {}

pub fn hurry() {}

pub const WATCHFUL: Duration = Duration::ZERO;

pub fn watch(_: Instant) {}

#[derive(Debug)]
pub struct Task;

impl Task {
    pub fn start<F>(_: &str, make: impl FnOnce() -> F + Send + 'static) -> io::Result<Self>
    where
        F: Future<Output = ()> + 'static,
    {
        spawn_local(make());
        Ok(Self)
    }

    pub fn join(self) {}
}

/// One waits at a time.
#[derive(Debug, Default)]
pub struct Bell(Mutex<Option<Waker>>);

impl Bell {
    pub fn ring(&self) {
        let waker = locked(&self.0).take();
        waker.into_iter().for_each(Waker::wake);
    }

    pub async fn wait_while<T>(&self, value: &Mutex<T>, timeout: Duration, is_so: impl Fn(&T) -> bool) {
        let changed = poll_fn(|context| {
            *locked(&self.0) = Some(context.waker().clone());
            if is_so(&locked(value)) { Poll::Pending } else { Poll::Ready(()) }
        });
        within(timeout, changed).await;
    }
}
