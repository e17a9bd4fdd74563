//! Replaces the GPU stages in builds without GPU.

use crate::field::gpu::{Gpu, Texture};
use crate::field::stages::job::Job;
use crate::field::stages::{Map, Work};
use crate::field::{colouring::Colouring, gpu_report::GpuError};

#[derive(Debug)]
pub(super) struct OnGpu(Gpu);

/// State of a map on the GPU.
#[expect(dead_code, reason = "what there is with a GPU")]
pub(super) enum Progress {
    Declined,
    UnderWay,
    Made(Map),
}

impl OnGpu {
    pub(super) fn new(gpu: Gpu) -> Self {
        match gpu {}
    }

    pub(super) fn work(&self) -> Work {
        match self.0 {}
    }

    pub(super) fn gpu(&self) -> &Gpu {
        match self.0 {}
    }

    pub(super) fn forget(&mut self) {
        match self.0 {}
    }

    pub(super) fn map(&mut self, _: &Job<'_>, _: bool) -> Result<Progress, GpuError> {
        match self.0 {}
    }

    pub(super) fn picture(&mut self, _: &Job<'_>, _: &Colouring) -> Result<Option<Texture>, GpuError> {
        match self.0 {}
    }

    pub(super) fn figures(&mut self, _: &Job<'_>) -> Result<Option<(Map, Option<f64>)>, GpuError> {
        match self.0 {}
    }
}
