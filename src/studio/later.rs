//! Values that take longer than a frame, computed in the background.

use std::io;
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, sync_channel};

use crate::device::task::Task;
use crate::gauge::Cancel;

/// Values before the end of a computation that wait until they are collected.
const KEPT: usize = 16;
/// Time in which a page shows a frame.
#[cfg(target_arch = "wasm32")]
const FRAME: web_time::Duration = web_time::Duration::from_millis(20);

/// Begins background work: on a thread, or in a page, which has one, once a frame is on the screen.
///
/// # Errors
/// No thread can be started.
pub fn begin(name: &str, work: impl FnOnce() + Send + 'static) -> io::Result<()> {
    let make = async move || {
        #[cfg(target_arch = "wasm32")]
        crate::device::task::sleep(FRAME).await;
        work();
    };
    Task::start(name, make).map(drop)
}

/// A value computed elsewhere, with its inputs. Of several requests only the latest is fulfilled.
#[derive(Debug)]
pub struct Later<K, V> {
    running: Option<Running<K, V>>,
    done: Option<(K, V)>,
    /// The key of a failed computation.
    failed: Option<K>,
}

#[derive(Debug)]
struct Running<K, V> {
    key: K,
    receiver: Receiver<News<V>>,
    cancel: Cancel,
}

/// A value before the end of its computation, or the last one.
#[derive(Debug)]
enum News<V> {
    SoFar(V),
    Last(V),
}

/// The end at which a computation puts its values.
#[derive(Debug)]
pub struct Answer<V> {
    sender: SyncSender<News<V>>,
    /// Set once the value is no longer needed.
    pub cancel: Cancel,
}

impl<V> Answer<V> {
    /// Gives a value before the end.
    pub fn so_far(&self, value: V) {
        // The receiver may be gone.
        let _ = self.sender.send(News::SoFar(value));
    }

    /// Gives the last value.
    pub fn last(self, value: V) {
        let _ = self.sender.send(News::Last(value));
    }
}

impl<K, V> Default for Later<K, V> {
    fn default() -> Self {
        Self { running: None, done: None, failed: None }
    }
}

impl<K: Clone + PartialEq + Send + 'static, V: Send + 'static> Later<K, V> {
    /// Ensures that the value for `key` is available or pending. One value is computed at a time; repeat the request
    /// every frame. `wake` is called when the value is there.
    pub fn ask(
        &mut self,
        key: &K,
        wake: impl Fn() + Send + 'static,
        work: impl FnOnce(&K) -> V + Send + 'static,
    ) {
        self.ask_with(key, wake, |key, _| work(key));
    }

    /// The same, of work with values before its end.
    pub fn ask_with(
        &mut self,
        key: &K,
        wake: impl Fn() + Send + 'static,
        work: impl FnOnce(&K, &Answer<V>) -> V + Send + 'static,
    ) {
        let own = key.clone();
        self.ask_by(key, |answer| {
            let make = move || {
                let last = work(&own, &answer);
                answer.last(last);
                wake();
            };
            begin("later", make).is_ok()
        });
    }

    /// The same, of work done elsewhere; `begin` returns whether it has begun.
    pub fn ask_by(&mut self, key: &K, begin: impl FnOnce(Answer<V>) -> bool) {
        if self.running.is_some() || self.get(key).is_some() || self.failed.as_ref() == Some(key) {
            return;
        }
        let (sender, receiver) = sync_channel(KEPT);
        let cancel = Cancel::default();
        if begin(Answer { sender, cancel: cancel.clone() }) {
            self.running = Some(Running { key: key.clone(), receiver, cancel });
        } else {
            self.failed = Some(key.clone());
        }
    }

    /// Cancels running work, unless it is for this key.
    pub fn keep(&mut self, key: Option<&K>) {
        if let Some(running) = &self.running
            && Some(&running.key) != key
        {
            running.cancel.cancel();
        }
    }

    /// Collects the newest value, and returns whether there was one, or none will come. Call it every frame.
    pub fn collect(&mut self) -> bool {
        let Some(running) = self.running.take() else { return false };
        let mut has_news = false;
        loop {
            match running.receiver.try_recv() {
                Ok(News::SoFar(_)) if running.cancel.is_cancelled() => {}
                Ok(News::Last(_)) if running.cancel.is_cancelled() => return true,
                Ok(News::SoFar(value)) => (self.done, has_news) = (Some((running.key.clone(), value)), true),
                Ok(News::Last(value)) => {
                    self.done = Some((running.key, value));
                    return true;
                }
                Err(TryRecvError::Empty) => {
                    self.running = Some(running);
                    return has_news;
                }
                Err(TryRecvError::Disconnected) => {
                    self.failed = Some(running.key);
                    return true;
                }
            }
        }
    }

    pub fn get(&self, key: &K) -> Option<&V> {
        self.done.as_ref().filter(|(own, _)| own == key).map(|(_, value)| value)
    }

    /// The key of the newest value.
    pub fn latest(&self) -> Option<&K> {
        self.done.as_ref().map(|(key, _)| key)
    }

    /// The newest value.
    pub fn newest(&self) -> Option<&V> {
        self.done.as_ref().map(|(_, value)| value)
    }

    pub fn is_running(&self) -> bool {
        self.running.is_some()
    }
}

#[cfg(test)]
mod tests {
    use std::thread;
    use std::time::{Duration, Instant};

    use super::*;

    #[test]
    fn values_before_the_end_count_until_the_last_comes() {
        let mut later = Later::default();
        let (go, wait) = sync_channel(1);
        later.ask_with(
            &1,
            || {},
            move |key, answer| {
                answer.so_far(key * 10);
                wait.recv().unwrap();
                key * 100
            },
        );
        let start = Instant::now();
        let until = |later: &mut Later<i32, i32>, expected| {
            while later.get(&1) != Some(&expected) {
                later.collect();
                assert!(start.elapsed() < Duration::from_secs(20));
                thread::sleep(Duration::from_millis(1));
            }
        };
        until(&mut later, 10);
        assert!(later.is_running() && !later.collect());
        go.send(()).unwrap();
        until(&mut later, 100);
        assert!(!later.is_running());
    }

    #[test]
    fn the_latest_wish_is_fulfilled_and_what_panics_is_not_tried_again() {
        let mut later = Later::default();
        let start = Instant::now();
        later.ask(&1, || {}, |key| key * 10);
        while later.get(&2) != Some(&20) {
            later.collect();
            later.ask(&2, || {}, |key| key * 10);
            assert!(start.elapsed() < Duration::from_secs(20));
            thread::sleep(Duration::from_millis(1));
        }
        assert_eq!(later.get(&1), None);
        later.ask(&3, || {}, |_| panic!("on purpose"));
        while later.is_running() {
            later.collect();
            later.ask(&3, || {}, |_| panic!("not again"));
            thread::sleep(Duration::from_millis(1));
        }
        later.ask(&3, || {}, |_| 30);
        assert!(!later.is_running() && later.get(&3).is_none());
    }
}
