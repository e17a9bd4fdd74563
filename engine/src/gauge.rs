//! Progress of long steps, reported to an observer, and their end before they are done.

use std::cell::RefCell;
use std::fmt;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use web_time::{Duration, Instant};

/// Cancels steps from another thread.
#[derive(Clone, Debug, Default)]
pub struct Cancel(Arc<AtomicBool>);

impl Cancel {
    /// From now on the steps are cancelled.
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Receives the completed fraction of a step, 0 to 1, on any thread, and limits the step; the default does neither.
#[derive(Clone, Debug, Default)]
pub struct Gauge {
    told: Option<Told>,
    cancel: Option<Cancel>,
    /// The step is cancelled after this moment.
    cancelled_at: Option<Instant>,
    /// Iterations take this time at most, and end after this moment.
    iterating: Option<(Duration, Instant)>,
}

/// The observer, and the part of the whole step that this one covers.
#[derive(Clone)]
struct Told {
    hear: Arc<dyn Fn(f64) + Send + Sync>,
    part: Range<f64>,
}

impl fmt::Debug for Told {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Told").field(&self.part).finish()
    }
}

thread_local! {
    /// Gauge of the step that this thread is in.
    static CURRENT: RefCell<Gauge> = RefCell::default();
}

/// The gauge of the enclosing step, restored even after a panic within.
struct Before(Gauge);

impl Drop for Before {
    fn drop(&mut self) {
        CURRENT.set(std::mem::take(&mut self.0));
    }
}

/// Whether this thread's step is cancelled. Its result is then dropped, and loops that last may leave it as it is.
pub fn is_cancelled() -> bool {
    CURRENT.with_borrow(Gauge::is_cancelled)
}

/// Iterations of this thread's step, up to a number: fewer if it is cancelled, or if their time is over; the first one
/// always has time.
pub(crate) fn iterations(most: u32) -> impl Iterator<Item = u32> {
    let gauge = Gauge::current();
    (0..most).take_while(move |&i| !gauge.is_cancelled() && (i == 0 || !gauge.is_late()))
}

impl Gauge {
    pub fn new(hear: impl Fn(f64) + Send + Sync + 'static) -> Self {
        Self { told: Some(Told { hear: Arc::new(hear), part: 0.0..1.0 }), ..Self::default() }
    }

    /// The gauge set by an enclosing [`Self::lead`], for deeply nested functions.
    pub(crate) fn current() -> Self {
        CURRENT.with_borrow(Self::clone)
    }

    /// Runs work with this as the current gauge.
    pub fn lead<T>(&self, work: impl FnOnce() -> T) -> T {
        let _before = Before(CURRENT.replace(self.clone()));
        work()
    }

    /// The same, ended by `cancel`.
    pub fn until(self, cancel: &Cancel) -> Self {
        Self { cancel: Some(cancel.clone()), ..self }
    }

    /// The same, cancelled after a time from now on.
    pub fn within(self, time: Duration) -> Self {
        Self { cancelled_at: Instant::now().checked_add(time), ..self }
    }

    /// The same, with a limit for the time of [`iterations`] from now on. What they have reached is the result.
    pub fn iterating_for(self, time: Duration) -> Self {
        Self { iterating: Instant::now().checked_add(time).map(|until| (time, until)), ..self }
    }

    /// The gauge of one of `of` equal steps that begins now: without observer, and with its share of the time.
    pub(crate) fn share(&self, of: usize) -> Self {
        let time = self.iterating.map(|(time, _)| time.div_f64(of.max(1) as f64));
        let own = Self { told: None, iterating: None, ..self.clone() };
        time.map_or(own.clone(), |time| own.iterating_for(time))
    }

    pub fn is_cancelled(&self) -> bool {
        self.cancel.as_ref().is_some_and(Cancel::is_cancelled)
            || self.cancelled_at.is_some_and(|at| Instant::now() > at)
    }

    fn is_late(&self) -> bool {
        self.iterating.is_some_and(|(_, until)| Instant::now() > until)
    }

    /// The gauge of some of `of` equal parts.
    pub fn part(&self, parts: Range<usize>, of: usize) -> Self {
        let told = self.told.as_ref().map(|told| {
            let Range { start, end } = told.part;
            let place = |part: usize| start + (end - start) * part as f64 / of.max(1) as f64;
            Told { hear: Arc::clone(&told.hear), part: place(parts.start)..place(parts.end) }
        });
        Self { told, ..self.clone() }
    }

    /// Whether a step's time is not yet over, and the step not cancelled; reports the elapsed fraction.
    pub fn lasts(&self, over: Duration, of: Duration) -> bool {
        if !of.is_zero() {
            self.tell(over.min(of).as_millis() as usize, of.as_millis() as usize);
        }
        over < of && !self.is_cancelled()
    }

    /// Reports that `done` of `of` parts are done.
    pub fn tell(&self, done: usize, of: usize) {
        if let Some(Told { hear, part }) = &self.told {
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
