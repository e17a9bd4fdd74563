//! Values that take longer than a frame, computed on a thread.

use std::borrow::Borrow;
use std::sync::mpsc::{Receiver, TryRecvError, sync_channel};

use egui::Context;

use crate::app::beside;
use crate::app::job::Job;
use crate::gauge::Cancel;
#[cfg(not(target_arch = "wasm32"))]
use crate::gauge::Gauge;
use crate::scene::Scene;

/// Values before the end of a computation that wait until they are collected.
const KEPT: usize = 16;

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
    /// Of a job: its value is then dropped.
    cancel: Cancel,
}

/// A value before the end of its computation, or the last one.
#[derive(Debug)]
enum News<V> {
    SoFar(V),
    Last(V),
}

impl<K, V> Default for Later<K, V> {
    fn default() -> Self {
        Self { running: None, done: None, failed: None }
    }
}

impl<K: Clone + PartialEq + Send + 'static, V: Send + 'static> Later<K, V> {
    /// Ensures that the value for `key` is available or pending. One value is computed at a time; repeat the request
    /// every frame.
    pub fn ask(&mut self, key: &K, ctx: &Context, work: impl FnOnce(&K) -> V + Send + 'static) {
        self.ask_with(key, ctx, |key, _| work(key));
    }

    /// The same, of work that has values before its end, for its second argument.
    fn ask_with(
        &mut self,
        key: &K,
        ctx: &Context,
        work: impl FnOnce(&K, &mut dyn FnMut(V)) -> V + Send + 'static,
    ) {
        if self.is_refused(key) {
            return;
        }
        let (sender, receiver) = sync_channel(KEPT);
        let (own, ctx) = (key.clone(), ctx.clone());
        let make = move || {
            let send = |news| {
                // The receiver may be gone.
                let _ = sender.send(news);
                ctx.request_repaint();
            };
            let last = work(&own, &mut |value| send(News::SoFar(value)));
            send(News::Last(last));
        };
        match beside::run("later", make) {
            Ok(()) => {
                self.running = Some(Running { key: key.clone(), receiver, cancel: Cancel::default() });
            }
            Err(_) => self.failed = Some(key.clone()),
        }
    }

    /// Cancels a running job, unless it is for this key.
    pub fn keep(&mut self, key: Option<&K>) {
        if let Some(running) = &self.running
            && Some(&running.key) != key
        {
            running.cancel.cancel();
        }
    }

    /// The same for a job on a scene; a job for another scene is cancelled.
    pub fn ask_for<J: Job<Made = V>>(&mut self, key: &K, ctx: &Context)
    where
        K: Borrow<Scene>,
    {
        self.keep(Some(key));
        #[cfg(not(target_arch = "wasm32"))]
        if !self.is_refused(key) {
            let cancel = Cancel::default();
            let gauge = Gauge::default().until(&cancel);
            self.ask_with(key, ctx, move |key, so_far| gauge.lead(|| J::make_with(key.borrow(), so_far)));
            self.running.iter_mut().for_each(|running| running.cancel = cancel.clone());
        }
        #[cfg(target_arch = "wasm32")]
        if !self.is_refused(key) {
            let (sender, receiver) = sync_channel(1);
            let ctx = ctx.clone();
            crate::app::worker::ask::<J>(key.borrow(), move |made| {
                // The receiver may be gone.
                let _ = sender.send(News::Last(made));
                ctx.request_repaint();
            });
            self.running = Some(Running { key: key.clone(), receiver, cancel: Cancel::default() });
        }
    }

    /// Whether another value is pending, or this one is available or has failed.
    fn is_refused(&self, key: &K) -> bool {
        self.running.is_some() || self.get(key).is_some() || self.failed.as_ref() == Some(key)
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

    /// The inputs of the current value.
    pub fn latest(&self) -> Option<&K> {
        self.done.as_ref().map(|(key, _)| key)
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
        let ctx = Context::default();
        let mut later = Later::default();
        let (go, wait) = sync_channel(1);
        later.ask_with(&1, &ctx, move |key, so_far| {
            so_far(key * 10);
            wait.recv().unwrap();
            key * 100
        });
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
        let ctx = Context::default();
        let mut later = Later::default();
        let start = Instant::now();
        later.ask(&1, &ctx, |key| key * 10);
        while later.get(&2) != Some(&20) {
            later.collect();
            later.ask(&2, &ctx, |key| key * 10);
            assert!(start.elapsed() < Duration::from_secs(20));
            thread::sleep(Duration::from_millis(1));
        }
        assert_eq!(later.get(&1), None);
        later.ask(&3, &ctx, |_| panic!("on purpose"));
        while later.is_running() {
            later.collect();
            later.ask(&3, &ctx, |_| panic!("not again"));
            thread::sleep(Duration::from_millis(1));
        }
        later.ask(&3, &ctx, |_| 30);
        assert!(!later.is_running() && later.get(&3).is_none());
    }
}
