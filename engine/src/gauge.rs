//! Progress of long steps, reported to an observer.

use std::cell::RefCell;
use std::fmt;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

/// Receives the completed fraction of a step, 0 to 1, on any thread; the default ignores it.
#[derive(Clone, Default)]
pub struct Gauge(Option<Told>);

/// The observer, and the part of the whole step that this one covers.
#[derive(Clone)]
struct Told {
    hear: Arc<dyn Fn(f64) + Send + Sync>,
    part: Range<f64>,
}

impl fmt::Debug for Gauge {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Gauge").field(&self.0.as_ref().map(|told| &told.part)).finish()
    }
}

thread_local! {
    /// Of the step that this thread is in.
    static CURRENT: RefCell<Gauge> = RefCell::default();
}

/// The gauge of the enclosing step, restored even after a panic within.
struct Before(Gauge);

impl Drop for Before {
    fn drop(&mut self) {
        CURRENT.set(std::mem::take(&mut self.0));
    }
}

impl Gauge {
    pub fn new(hear: impl Fn(f64) + Send + Sync + 'static) -> Self {
        Self(Some(Told { hear: Arc::new(hear), part: 0.0..1.0 }))
    }

    /// The gauge set by an enclosing [`Self::lead`], for deeply nested functions.
    pub fn current() -> Self {
        CURRENT.with_borrow(Self::clone)
    }

    /// Runs work with this as the current gauge.
    pub fn lead<T>(&self, work: impl FnOnce() -> T) -> T {
        let _before = Before(CURRENT.replace(self.clone()));
        work()
    }

    /// The gauge of some of `of` equal parts.
    pub fn part(&self, parts: Range<usize>, of: usize) -> Self {
        Self(self.0.as_ref().map(|told| {
            let Range { start, end } = told.part;
            let place = |part: usize| start + (end - start) * part as f64 / of.max(1) as f64;
            Told { hear: Arc::clone(&told.hear), part: place(parts.start)..place(parts.end) }
        }))
    }

    /// Whether a step's time is not yet over; reports the elapsed fraction.
    pub fn lasts(&self, over: Duration, of: Duration) -> bool {
        if !of.is_zero() {
            self.tell(over.min(of).as_millis() as usize, of.as_millis() as usize);
        }
        over < of
    }

    /// Reports that `done` of `of` parts are done.
    pub fn tell(&self, done: usize, of: usize) {
        if let Some(Told { hear, part }) = &self.0 {
            hear(part.start + (part.end - part.start) * done as f64 / of.max(1) as f64);
        }
    }

    /// Counts parts completed in any order, on any thread.
    pub fn count(&self, of: usize) -> Counter {
        Counter { gauge: self.clone(), done: AtomicUsize::new(0), of }
    }
}

/// Parts that are done.
#[derive(Debug)]
pub struct Counter {
    gauge: Gauge,
    done: AtomicUsize,
    of: usize,
}

impl Counter {
    /// One more part is done.
    pub fn add(&self) {
        /// Parts between two looks at the clock.
        const EVERY: usize = 64;
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        if done.is_multiple_of(EVERY) || done == self.of {
            self.gauge.tell(done, self.of);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use super::*;

    #[test]
    fn parts_of_parts_are_told_as_parts_of_the_whole() {
        let heard = Arc::new(Mutex::new(Vec::new()));
        let into = Arc::clone(&heard);
        let gauge = Gauge::new(move |part| into.lock().unwrap().push(part));
        gauge.tell(1, 4);
        gauge.part(1..3, 4).lead(|| {
            Gauge::current().tell(1, 2);
            Gauge::current().part(1..2, 2).lead(|| Gauge::current().count(1).add());
            Gauge::current().tell(0, 1);
        });
        Gauge::current().tell(1, 1);
        gauge.tell(1, 1);
        assert_eq!(*heard.lock().unwrap(), [0.25, 0.5, 0.75, 0.25, 1.0]);
    }
}
