//! The passes of one map in their order, with the buffers that they share: made once for its shape, and run for every drive.

use std::ops::Range;

use glam::DVec3;
use num_complex::Complex32;
use wgpu::BufferUsages;

use crate::acoustics::Aperture;
use crate::drive::Drive;
use crate::field::colouring::Colouring;
use crate::field::gpu::forming::Forming;
use crate::field::gpu::painting::{Painting, Source, Texture};
use crate::field::gpu::program::{GatherParams, MOST_GROUPS, Program, WORKGROUP};
use crate::field::gpu::reading::Reading;
use crate::field::gpu::resampling::{self, Lines};
use crate::field::gpu::superposition::{Elements, Superposition};
use crate::field::gpu::{Gpu, GpuError, Step};
use crate::field::interpolation::Resampling;
use crate::field::quantity::{Constants, Part, Quantity, Sound};
use crate::field::slope::{shifted, stencil};
use crate::field::{Samples, Sources, Wave};

/// Figures that may be on their way at once: one arrives while the next is made.
const ON_THEIR_WAY: usize = 3;

/// What the passes depend on.
#[derive(Debug)]
pub struct Shape<'a> {
    /// With every element driven.
    pub aperture: &'a Aperture,
    pub quantity: Quantity,
    /// Width and height in pixels.
    pub size: (usize, usize),
    pub interpolated: Option<Interpolated<'a>>,
    /// First rows and places of those that are evaluated pixel by pixel.
    pub direct: Vec<(usize, Samples)>,
    /// Of the plane.
    pub normal: DVec3,
    /// Pixels that are compared with the reference.
    pub probes: &'a [usize],
}

/// Rows of pixels that are interpolated.
#[derive(Debug)]
pub struct Interpolated<'a> {
    pub rows: Range<usize>,
    pub samples: &'a Samples,
    /// For every part of the sound, across and up.
    pub weights: Vec<[&'a Resampling; 2]>,
}

/// The passes of a map.
#[derive(Debug)]
pub struct Chain {
    /// Of the first superposition; the others differ from it by a gain.
    wave: Wave,
    elements: Elements,
    superpositions: Vec<Superposition>,
    /// What superpositions add to.
    sums: Vec<wgpu::Buffer>,
    interpolation: Vec<Step>,
    forming: Forming,
    gather: Step,
    values: wgpu::Buffer,
    gathered: wgpu::Buffer,
    clock: Option<Clock>,
    parts: u8,
    probes: usize,
    size: (usize, usize),
    painting: Option<Painting>,
    /// The run that figures are of, and those on their way.
    run: u64,
    figures: Vec<(u64, Reading)>,
    /// Of the values, and the run that they are of.
    reading: Option<(u64, Reading)>,
}

/// What times the passes.
#[derive(Debug)]
struct Clock {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
}

/// What panels want to know of a map.
#[derive(Clone, Debug, PartialEq)]
pub struct Figures {
    /// See [`crate::field::Map::peak`].
    pub peak: f32,
    /// At the probes.
    pub sounds: Vec<Sound>,
    /// s that the GPU took, where it can be timed.
    pub seconds: Option<f64>,
}

impl Chain {
    /// `None` where f32 has no room for the elements or is not right beside them, or a buffer has none for the map.
    pub fn new(gpu: &Gpu, shape: &Shape<'_>) -> Option<Self> {
        let declaration = shape.quantity.declaration();
        let (width, height) = shape.size;
        // A pass may have a workgroup for every row.
        if width.max(height) > MOST_GROUPS as usize {
            return None;
        }
        let (parts, pixels) = (declaration.parts, width * height);
        let bytes = |values: usize| Some((values * 8) as u64).filter(|&bytes| bytes <= gpu.buffer_limit);
        let lattice = gpu.storage("sound", bytes(pixels * parts.count_ones() as usize)?);
        let values = gpu.storage("values", bytes(pixels.div_ceil(2))?);
        let elements = Elements::with_room(gpu, shape.aperture.positions.len());
        let mut chain =
            Making { gpu, shape, wave: None, elements, superpositions: Vec::new(), sums: Vec::new() };
        let mut interpolation = Vec::new();
        if let Some(Interpolated { rows, samples, weights }) = &shape.interpolated {
            bytes(samples.len())?;
            let wide = gpu.storage("wide", bytes(samples.rows.len() * width)?);
            let mut sampled: [Option<wgpu::Buffer>; 2] = [None, None];
            for (place, (part, [across, up])) in Part::of(parts).zip(weights).enumerate() {
                let normal = part == Part::Normal;
                let sampled = match &mut sampled[usize::from(normal)] {
                    Some(sampled) => sampled.clone(),
                    none => none.insert(chain.sample(samples, normal)?).clone(),
                };
                let columns = samples.columns.len();
                let lines = Lines {
                    count: samples.rows.len(),
                    start: 0,
                    out_start: 0,
                    strides: [columns, width],
                    steps: [1, 1],
                };
                interpolation.push(resampling::step(gpu, across, [&sampled, &wide], &lines));
                let lines = Lines {
                    count: width,
                    start: 0,
                    out_start: place * pixels + rows.start * width,
                    strides: [1, 1],
                    steps: [width, width],
                };
                interpolation.push(resampling::step(gpu, up, [&wide, &lattice], &lines));
            }
        }
        for (row, places) in &shape.direct {
            // A slope beside the array takes more than one pass; the CPU makes it.
            let is_pressure = Part::of(parts).eq([Part::Pressure]);
            chain.add(places, (&lattice, (row * width) as u32), 1.0).filter(|()| is_pressure)?;
        }
        if !shape.direct.is_empty() {
            chain.sums.push(lattice.clone());
        }
        let Making { wave, elements, superpositions, sums, .. } = chain;
        let forming = Forming::new(gpu, shape.quantity, pixels, [&lattice, &values]);
        let count = shape.probes.len() * parts.count_ones() as usize;
        // Behind the sounds stand the peak, and the times at which the passes began and ended.
        let gathered = gpu.storage("gathered", (count as u64 + 3) * 8);
        let gather = gather(gpu, shape, [&lattice, &forming.peak, &gathered], count);
        Some(Self {
            wave: wave?,
            elements,
            superpositions,
            sums,
            interpolation,
            forming,
            gather,
            values,
            gathered,
            clock: Clock::new(gpu),
            parts,
            probes: shape.probes.len(),
            size: shape.size,
            painting: None,
            run: 0,
            figures: Vec::new(),
            reading: None,
        })
    }

    /// What runs: with another drive everything, with other constants what follows the sound.
    pub fn run(&mut self, gpu: &Gpu, drive: Option<(&Aperture, &Drive)>, constants: &Constants, factor: f32) {
        self.run += 1;
        self.forming.set(gpu, constants, factor);
        let mut encoder = gpu.encoder();
        encoder.clear_buffer(&self.forming.peak, 0, None);
        let mut steps: Vec<&Step> = Vec::new();
        if let Some((aperture, drive)) = drive {
            let sounding = self.wave.elements(aperture, drive);
            self.elements.write(gpu, &sounding);
            for superposition in &mut self.superpositions {
                superposition.set(gpu, sounding.len() as u32);
            }
            for sum in &self.sums {
                encoder.clear_buffer(sum, 0, None);
            }
            steps.extend(self.superpositions.iter().flat_map(Superposition::steps));
            steps.extend(&self.interpolation);
        }
        steps.extend([&self.forming.step, &self.gather]);
        let timed = |beginning, end| {
            self.clock.as_ref().map(|clock| wgpu::ComputePassTimestampWrites {
                query_set: &clock.queries,
                beginning_of_pass_write_index: beginning,
                end_of_pass_write_index: end,
            })
        };
        let mut rest = &steps[..];
        let mut is_first = true;
        while !rest.is_empty() {
            let mut pairs = 0;
            let fits = |step: &&&Step| {
                pairs += step.pairs;
                pairs <= gpu.tuning.most_pairs
            };
            let count = rest.iter().take_while(fits).count().max(1);
            let (now, later) = rest.split_at(count);
            let end = later.is_empty().then_some(1);
            let beginning = is_first.then_some(0);
            let timestamp_writes = if beginning.or(end).is_some() { timed(beginning, end) } else { None };
            let mut pass =
                encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: None, timestamp_writes });
            now.iter().for_each(|step| step.run(&mut pass));
            drop(pass);
            (rest, is_first) = (later, false);
            if !rest.is_empty() {
                gpu.submit(std::mem::replace(&mut encoder, gpu.encoder()));
            }
        }
        if let Some(clock) = &self.clock {
            encoder.resolve_query_set(&clock.queries, 0..2, &clock.resolved, 0);
            let end = self.gathered.size() - 16;
            encoder.copy_buffer_to_buffer(&clock.resolved, 0, &self.gathered, end, 16);
        }
        gpu.submit(encoder);
    }

    /// The map in colours, and whether it was painted anew.
    pub fn paint(&mut self, gpu: &Gpu, colouring: &Colouring) -> (Texture, bool) {
        let source = Source { values: &self.values, peak: &self.forming.peak, size: self.size };
        let fits = self.painting.take().filter(|painting| painting.scale() == colouring.scale());
        let painting = fits.unwrap_or_else(|| Painting::new(gpu, &source, colouring.scale()));
        self.painting.insert(painting).paint(gpu, colouring, self.run)
    }

    /// Figures of the last run, if they are there; never waits. They are asked for if nobody has.
    ///
    /// # Errors
    /// The device was lost.
    pub fn figures(&mut self, gpu: &Gpu) -> Result<Option<Figures>, GpuError> {
        let mut found = None;
        for (run, reading) in &mut self.figures {
            if let Some(bytes) = reading.poll(gpu)?.filter(|_| *run == self.run) {
                found = Some(bytes);
            }
        }
        if let Some(bytes) = found {
            return Ok(Some(self.read(gpu, &bytes)));
        }
        let is_asked = self.figures.iter().any(|(run, reading)| *run == self.run && !reading.is_free());
        if !is_asked {
            self.ask(gpu);
        }
        Ok(None)
    }

    fn ask(&mut self, gpu: &Gpu) {
        if self.figures.is_empty() {
            let bytes = self.gathered.size();
            self.figures.extend((0..ON_THEIR_WAY).map(|_| (0, Reading::with_room(gpu, bytes))));
        }
        // If all are on their way, the next frame asks again.
        if let Some((run, reading)) = self.figures.iter_mut().find(|(_, reading)| reading.is_free()) {
            reading.ask(gpu, gpu.encoder(), &[&self.gathered]);
            *run = self.run;
        }
    }

    /// Asks for the values of all pixels and the figures of the last run; `None` while they are on their way, which ends if it
    /// may `wait`.
    ///
    /// # Errors
    /// The device was lost.
    pub fn values(&mut self, gpu: &Gpu, wait: bool) -> Result<Option<(Vec<f32>, Figures)>, GpuError> {
        loop {
            let bytes = self.gathered.size() + self.values.size();
            let (run, reading) = self.reading.get_or_insert_with(|| (0, Reading::with_room(gpu, bytes)));
            if reading.is_free() {
                reading.ask(gpu, gpu.encoder(), &[&self.gathered, &self.values]);
                *run = self.run;
            }
            let bytes = if wait { Some(reading.wait(gpu)?) } else { reading.poll(gpu)? };
            let Some(bytes) = bytes else { return Ok(None) };
            // What an earlier run made is of no use any more.
            if *run == self.run {
                let (figures, values) = bytes.split_at(self.gathered.size() as usize);
                let values = &bytemuck::cast_slice(values)[..self.size.0 * self.size.1];
                return Ok(Some((values.to_vec(), self.read(gpu, figures))));
            }
        }
    }

    fn read(&self, gpu: &Gpu, bytes: &[u8]) -> Figures {
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
        Figures {
            peak: numbers[count * self.probes].re,
            sounds: (0..self.probes).map(sound).collect(),
            seconds: gpu.tick.map(|tick| times[1].saturating_sub(times[0]) as f64 * f64::from(tick) * 1e-9),
        }
    }
}

/// What a chain starts with.
struct Making<'a> {
    gpu: &'a Gpu,
    shape: &'a Shape<'a>,
    wave: Option<Wave>,
    elements: Elements,
    superpositions: Vec<Superposition>,
    sums: Vec<wgpu::Buffer>,
}

impl Making<'_> {
    /// The pressure at the samples, or its slope along the normal, as a buffer that superpositions fill.
    fn sample(&mut self, samples: &Samples, normal: bool) -> Option<wgpu::Buffer> {
        let out = self.gpu.storage("samples", (samples.len() * 8) as u64);
        self.sums.push(out.clone());
        if !normal {
            return self.add(samples, (&out, 0), 1.0).map(|()| out);
        }
        for (shift, weight) in stencil(self.shape.aperture.wavelength()) {
            self.add(&shifted(samples, self.shape.normal * shift), (&out, 0), weight)?;
        }
        Some(out)
    }

    /// `None` where f32 is not right.
    fn add(&mut self, samples: &Samples, out: (&wgpu::Buffer, u32), gain: f64) -> Option<()> {
        let aperture = self.shape.aperture;
        let wave = Wave::new(aperture, samples)?;
        let everything = Drive {
            amplitudes: vec![1.0; aperture.positions.len()],
            phases: vec![0.0; aperture.positions.len()],
        };
        let sources = Sources { elements: wave.elements(aperture, &everything), wave: wave.clone() };
        if !sources.beside_rims(samples).is_empty() {
            return None;
        }
        let gain = gain * self.wave.as_ref().map_or(1.0, |first| wave.gain_over(first));
        self.superpositions.push(Superposition::new(self.gpu, &wave, &self.elements, samples, out, gain));
        self.wave.get_or_insert(wave);
        Some(())
    }
}

fn gather(gpu: &Gpu, shape: &Shape<'_>, [lattice, peak, gathered]: [&wgpu::Buffer; 3], count: usize) -> Step {
    let params = GatherParams {
        count: (shape.size.0 * shape.size.1) as u32,
        probes: shape.probes.len() as u32,
        gathered: count as u32,
    };
    let params = gpu.params(bytemuck::bytes_of(&params));
    let places: Vec<_> = shape.probes.iter().map(|&place| place as u32).collect();
    let places = gpu.filled("probes", bytemuck::cast_slice(&places), BufferUsages::STORAGE);
    gpu.step(
        Program::Gather,
        &[
            (0, params.as_entire_binding()),
            (1, lattice.as_entire_binding()),
            (2, places.as_entire_binding()),
            (3, peak.as_entire_binding()),
            (4, gathered.as_entire_binding()),
        ],
        ((count as u32 + 1).div_ceil(WORKGROUP), 1),
    )
}

impl Clock {
    fn new(gpu: &Gpu) -> Option<Self> {
        gpu.tick?;
        let queries = gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
            label: Some("passes"),
            ty: wgpu::QueryType::Timestamp,
            count: 2,
        });
        let usage = BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC;
        Some(Self { queries, resolved: gpu.buffer("times", 16, usage) })
    }
}
