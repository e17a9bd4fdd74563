//! One-off tasks on a thread, with progress and cancellation.
//!
//! Reading drawings, listing folders, exporting motions and file dialogs are errands: no frame waits for a disk.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError, sync_channel};

use egui::Context;

use crate::import::Drawing;
use crate::picture::Picture;
use crate::scene::motion::Routes;
use crate::scene::{Array, Curve, Directivity, DriveFile, Surface, Wave};
use crate::studio::later;
use crate::ui::{Folder, Purpose};

/// Resolution of progress.
const STEPS: f32 = 1000.0;

/// Progress and cancellation of an errand.
#[derive(Clone, Debug, Default)]
pub struct Progress {
    done: Arc<AtomicU32>,
    is_off: Arc<AtomicBool>,
}

impl Progress {
    /// So large a part is done.
    pub fn tell(&self, part: f32) {
        self.done.store((part.clamp(0.0, 1.0) * STEPS) as u32, Ordering::Relaxed);
    }

    /// The completed fraction, 0 to 1.
    pub fn part(&self) -> f32 {
        self.done.load(Ordering::Relaxed) as f32 / STEPS
    }

    pub fn call_off(&self) {
        self.is_off.store(true, Ordering::Relaxed);
    }

    pub fn is_off(&self) -> bool {
        self.is_off.load(Ordering::Relaxed)
    }
}

/// A running task. Dropped, it continues and its result is ignored.
#[derive(Debug)]
pub struct Errand<T> {
    pub progress: Progress,
    receiver: Receiver<T>,
}

/// The state of an errand.
#[derive(Debug, PartialEq)]
pub enum State<T> {
    UnderWay,
    Done(T),
    /// The thread ended without a result.
    Failed,
}

impl<T: Send + 'static> Errand<T> {
    /// # Errors
    /// No thread could be started.
    pub fn start(ctx: &Context, work: impl FnOnce(&Progress) -> T + Send + 'static) -> std::io::Result<Self> {
        let (sender, receiver) = sync_channel(1);
        let progress = Progress::default();
        let (own, ctx) = (progress.clone(), ctx.clone());
        let run = move || {
            // The receiver may be gone.
            let _ = sender.send(work(&own));
            drop(sender);
            ctx.request_repaint();
        };
        later::begin("errand", run)?;
        Ok(Self { progress, receiver })
    }

    /// Waits for an external operation.
    ///
    /// # Errors
    /// The errors of [`Self::start`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn wait(ctx: &Context, work: impl Future<Output = T> + Send + 'static) -> std::io::Result<Self> {
        Self::start(ctx, move |_| pollster::block_on(work))
    }

    /// Waits for an external operation.
    ///
    /// # Errors
    /// None.
    #[cfg(target_arch = "wasm32")]
    pub fn wait(ctx: &Context, work: impl Future<Output = T> + 'static) -> std::io::Result<Self> {
        let (sender, receiver) = sync_channel(1);
        let ctx = ctx.clone();
        wasm_bindgen_futures::spawn_local(async move {
            // The receiver may be gone.
            let _ = sender.send(work.await);
            ctx.request_repaint();
        });
        Ok(Self { progress: Progress::default(), receiver })
    }

    pub fn state(&self) -> State<T> {
        match self.receiver.try_recv() {
            Ok(value) => State::Done(value),
            Err(TryRecvError::Empty) => State::UnderWay,
            Err(TryRecvError::Disconnected) => State::Failed,
        }
    }
}

/// The result of an errand.
#[derive(Debug)]
pub enum Outcome {
    /// The answer of the desktop's file dialog; `Err` with the current text if there is no dialog or no choice.
    Chosen(Purpose, Result<PathBuf, String>),
    /// A dropped file, with the browser's reason.
    #[cfg(target_arch = "wasm32")]
    Unreadable(String),
    Listed(Folder),
    Read(PathBuf, anyhow::Result<Drawing>),
    /// A waveform of the scene's modulation, or of a target's own.
    Heard(Option<usize>, Result<Wave, String>),
    /// Thresholds of the skin, read.
    Felt(Result<Curve, String>),
    /// Directivity of the elements, read.
    Directed(Result<Directivity, String>),
    /// The surface of a body, or of a new one.
    Shaped(Option<usize>, Result<Surface, String>),
    /// The path of a target's own motion, or of the scene's.
    Routed(Option<usize>, Result<Routes, String>),
    /// An array with loaded elements.
    Placed(Result<Box<Array>, String>),
    /// An array with loaded wires.
    Wired(Result<Box<Array>, String>),
    /// The drives of a file, read.
    Driven(Result<Box<DriveFile>, String>),
    /// The motion was exported, if it was not called off.
    Filmed(PathBuf, anyhow::Result<Option<()>>),
    /// A figure or a sheet was written.
    Printed(PathBuf, anyhow::Result<()>),
    /// A figure for the clipboard.
    Copied(anyhow::Result<Picture>),
}

/// A motion being exported.
#[derive(Debug)]
pub struct Film {
    /// The file's.
    pub name: String,
    pub progress: Progress,
}

#[cfg(test)]
mod tests {
    use std::thread;

    use super::*;

    fn wait<T: Send + 'static>(errand: &Errand<T>) -> State<T> {
        loop {
            match errand.state() {
                State::UnderWay => thread::yield_now(),
                state => return state,
            }
        }
    }

    #[test]
    fn it_tells_how_far_it_is_and_hears_when_it_is_called_off() {
        let ctx = Context::default();
        let errand = Errand::start(&ctx, |progress: &Progress| {
            progress.tell(0.25);
            while !progress.is_off() {
                thread::yield_now();
            }
            7
        })
        .unwrap();
        while errand.progress.part() == 0.0 {
            thread::yield_now();
        }
        assert_eq!((errand.progress.part(), errand.state()), (0.25, State::UnderWay));
        errand.progress.call_off();
        assert_eq!(wait(&errand), State::Done(7));
        let fails = Errand::<()>::start(&ctx, |_| panic!("on purpose")).unwrap();
        assert_eq!(wait(&fails), State::Failed);
    }
}
