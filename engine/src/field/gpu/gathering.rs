//! Gathers a map's results for panels in one small buffer that is read back.

use num_complex::Complex32;
use wgpu::BufferUsages;

use crate::field::gpu::Gpu;
use crate::field::gpu::device::Step;
use crate::field::gpu::program::{GatherParams, Program};
use crate::field::gpu::tuning::WORKGROUP;
use crate::field::quantity::{Part, Sound};

/// The results of a map for panels.
#[derive(Clone, Debug, PartialEq)]
pub struct Gathered {
    /// The largest extents: the peak, see [`crate::field::Map::peak`], and that of the pixels that do not count for it.
    pub largest: [f32; 2],
    /// Sounds at the probes.
    pub sounds: Vec<Sound>,
    /// GPU time (s), if it can be measured.
    pub seconds: Option<f64>,
}

/// A pixel to compare with the reference.
pub(super) struct Probe<'a> {
    /// Among all of a map.
    pub(super) number: usize,
    /// The index of the first sample of its interpolation.
    pub(super) first: usize,
    /// Weights of these samples, of values and of slopes along the second axis.
    pub(super) weights: [&'a [f32]; 2],
}

/// The gathering passes and their output.
#[derive(Debug)]
pub(super) struct Gathering {
    pub(super) steps: Vec<Step>,
    /// The parts of the sound at the probes in sequence, the largest extents, and the begin and end times of a map's passes.
    pub(super) buffer: wgpu::Buffer,
    parts: u8,
    probes: usize,
}

impl Gathering {
    pub(super) fn new(gpu: &Gpu, parts: u8, probes: usize) -> Self {
        let sounds = probes * parts.count_ones() as usize;
        let buffer = gpu.storage("gathered", (sounds as u64 + 3) * 8);
        Self { steps: Vec::new(), buffer, parts, probes }
    }

    /// Adds some of the probes, with a stride of `samples` between parts of the sound.
    pub(super) fn add(
        &mut self,
        gpu: &Gpu,
        [samples, peak]: [&wgpu::Buffer; 2],
        [tap_stride, part_stride]: [usize; 2],
        probes: &[Probe<'_>],
    ) {
        let sloped = Part::of(self.parts).position(|part| part == Part::AlongY);
        let params = GatherParams {
            probes: probes.len() as u32,
            all: self.probes as u32,
            parts: self.parts.count_ones(),
            sloped: sloped.map_or(u32::MAX, |place| place as u32),
            taps: probes.first().map_or(0, |probe| probe.weights[0].len() as u32),
            tap_stride: tap_stride as u32,
            part_stride: part_stride as u32,
        };
        let mut made_of: Vec<u32> = Vec::new();
        for Probe { number, first, weights } in probes {
            made_of.extend([*number as u32, *first as u32]);
            made_of.extend(weights.iter().flat_map(|weights| weights.iter().map(|weight| weight.to_bits())));
        }
        if made_of.is_empty() {
            made_of.push(0);
        }
        let made_of = gpu.filled("probes", bytemuck::cast_slice(&made_of), BufferUsages::STORAGE);
        let step = gpu.step(
            Program::Gather,
            &[
                (0, gpu.params(bytemuck::bytes_of(&params)).as_entire_binding()),
                (1, samples.as_entire_binding()),
                (2, made_of.as_entire_binding()),
                (3, peak.as_entire_binding()),
                (4, self.buffer.as_entire_binding()),
            ],
            ((params.probes * params.parts).max(1).div_ceil(WORKGROUP), 1),
        );
        self.steps.push(step);
    }

    /// The results read back.
    pub(super) fn read(&self, gpu: &Gpu, bytes: &[u8]) -> Gathered {
        let numbers: &[Complex32] = bytemuck::cast_slice(bytes);
        let count = self.parts.count_ones() as usize;
        let sound = |probe: usize| {
            let mut sound = Sound::default();
            for (place, part) in Part::of(self.parts).enumerate() {
                *sound.part_mut(part) = numbers[place * self.probes + probe];
            }
            sound
        };
        let times: &[u64] = bytemuck::cast_slice(&numbers[count * self.probes + 1..]);
        Gathered {
            largest: [numbers[count * self.probes].re, numbers[count * self.probes].im],
            sounds: (0..self.probes).map(sound).collect(),
            seconds: gpu.tick.map(|tick| times[1].saturating_sub(times[0]) as f64 * f64::from(tick) * 1e-9),
        }
    }
}
