//! Maps that take longer than a frame of the window: made on a thread, first with fewer pixels, then whole, and kept for
//! a return to their plane.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use egui::Context;

use crate::field::{Evaluator, FieldError, Gpu, Map, Request, Stages};
use crate::gauge::Gauge;
use crate::studio::later::Later;
use crate::ui::part::wake;

/// Drives of a map that is made between two frames, at most.
const MOST_DRIVES: usize = 4;
/// Maps that are kept.
const KEPT: usize = 4;
/// Pixels of a whole map per pixel of the first one, along each axis.
const COARSENESS: usize = 4;

/// A map with its request, which has fewer pixels than the one it was made for if it came first.
pub type Made = (Request, Map);

/// The slow maps of one view.
#[derive(Debug)]
pub struct SlowMaps {
    later: Later<Request, Result<Made, FieldError>>,
    /// They keep their results between threads.
    stages: Arc<Mutex<Stages>>,
    /// Whole maps, the newest first.
    kept: VecDeque<Made>,
}

/// Whether a map takes longer than a frame of the window. Those of a given surface play.
pub fn is_slow(request: &Request) -> bool {
    let declaration = request.quantity.declaration();
    let is_long = !declaration.has_formula() || declaration.of_light || request.drives.len() > MOST_DRIVES;
    (is_long && request.depth.is_none()) || !request.aperture.bodies.is_empty()
}

impl SlowMaps {
    /// Maps by the GPU, if there is one.
    pub fn new(gpu: Option<Gpu>) -> Self {
        // A page cannot wait for its GPU.
        let gpu = gpu.filter(|_| !cfg!(target_arch = "wasm32"));
        let evaluator = gpu.map_or(Evaluator::Cpu, |gpu| Evaluator::Gpu(Box::new(gpu)));
        Self {
            later: Later::default(),
            stages: Arc::new(Mutex::new(Stages::new(evaluator))),
            kept: VecDeque::new(),
        }
    }

    /// Collects finished maps. Call it every frame.
    pub fn collect(&mut self) {
        if self.later.collect()
            && let Some(Ok(made)) = self.later.newest()
            && self.later.latest() == Some(&made.0)
        {
            self.kept.retain(|(request, _)| *request != made.0);
            self.kept.push_front(made.clone());
            self.kept.truncate(KEPT);
        }
    }

    /// The best map of a request so far.
    pub fn get(&self, request: &Request) -> Option<Result<&Made, FieldError>> {
        let kept = self.kept.iter().find(|(of, _)| of == request);
        kept.map(Ok).or_else(|| self.later.get(request).map(|made| made.as_ref().map_err(Clone::clone)))
    }

    pub fn is_running(&self) -> bool {
        self.later.is_running()
    }

    /// Gives up the map being made.
    pub fn stop(&mut self) {
        self.later.keep(None);
    }

    /// Begins a map, unless one is being made, or this one failed.
    pub fn begin(&mut self, request: &Request, ctx: &Context) {
        let is_other_moment = |of: &Request| {
            let Request { quantity, moment, .. } = request.clone();
            Request { quantity, moment, ..of.clone() } == *request
        };
        let is_of_known_sound = self.kept.front().is_some_and(|(of, _)| is_other_moment(of));
        let stages = Arc::clone(&self.stages);
        let wake_up = wake(ctx);
        self.later.ask_with(request, wake(ctx), move |request, answer| {
            let mut stages = stages.lock().unwrap_or_else(PoisonError::into_inner);
            let gauge = Gauge::default().until(&answer.cancel);
            let mut make = |request: &Request| {
                stages.show_progress(gauge.clone());
                let mut made = stages.map(request).cloned();
                if let Err(FieldError::Gpu(_)) = made {
                    *stages = Stages::new(Evaluator::Cpu);
                    stages.show_progress(gauge.clone());
                    made = stages.map(request).cloned();
                }
                Ok((request.clone(), made?))
            };
            let (width, height) = request.size;
            let size = (width.div_ceil(COARSENESS), height.div_ceil(COARSENESS));
            // Sound of the air's whole volume takes no longer for more pixels, and known sound hardly.
            if !request.quantity.declaration().of_volume && !is_of_known_sound {
                answer.so_far(make(&Request { size, ..request.clone() }));
                wake_up();
            }
            make(request)
        });
    }
}
