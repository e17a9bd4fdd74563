//! The passes of one map in order, with their shared buffers: built once per plan, size and quantity, and run for
//! every drive.

use std::ops::Range;

use glam::DVec3;
use wgpu::BufferUsages;

use crate::acoustics::Aperture;
use crate::drive::Drive;
use crate::field::colouring::Colouring;
use crate::field::gpu::Gpu;
use crate::field::gpu::device::Step;
use crate::field::gpu::forming::Forming;
use crate::field::gpu::gathering::{Gathered, Gathering, Probe};
use crate::field::gpu::painting::{Painting, Source, Texture};
use crate::field::gpu::program::{Program, Waves};
use crate::field::gpu::reading::Reading;
use crate::field::gpu::resampling::{self, Lines};
use crate::field::gpu::superposition::{Elements, Superposition};
use crate::field::gpu::tuning::MOST_GROUPS;
use crate::field::interpolation::Resampling;
use crate::field::quantity::{Constants, PRESSURE, Part, Quantity};
use crate::field::slope::{shifted, stencil};
use crate::field::sources::{Sources, Wave};
use crate::field::vicinity::LeftOut;
use crate::field::{gpu_report::GpuError, samples::Samples, sources};

/// Concurrent read-backs of figures: one arrives while the next is produced.
const ON_THEIR_WAY: usize = 3;

/// The inputs of the passes.
#[derive(Debug)]
pub struct Shape<'a> {
    /// The aperture with every element driven.
    pub aperture: &'a Aperture,
    pub quantity: Quantity,
    /// Width and height in pixels.
    pub size: (usize, usize),
    pub interpolated: Option<Interpolated<'a>>,
    /// Rows evaluated pixel by pixel: first row and samples.
    pub direct: Vec<(usize, Samples)>,
    /// The pixels that do not count for the peak.
    pub left_out: &'a LeftOut,
    /// Normal of the plane.
    pub normal: DVec3,
    /// Pixels to compare with the reference.
    pub probes: &'a [usize],
}

/// Rows of interpolated pixels.
#[derive(Debug)]
pub struct Interpolated<'a> {
    pub rows: Range<usize>,
    /// Boards and images that contribute there.
    pub heard: Vec<usize>,
    pub samples: &'a Samples,
    /// Weights across and up for every part of the sound.
    pub weights: Vec<[&'a Resampling; 2]>,
}

/// The passes of a map.
#[derive(Debug)]
pub struct Chain {
    /// Wave of the first superposition; the others differ from it by a gain.
    wave: Wave,
    /// Elements of the contributing boards, with their indices in the aperture.
    boards: Vec<(usize, Elements)>,
    /// Superpositions with the index of their board.
    superpositions: Vec<(usize, Superposition)>,
    /// Buffers of the superpositions.
    sums: Vec<wgpu::Buffer>,
    across: Vec<Step>,
    forming: Forming,
    gathering: Gathering,
    clock: Option<Clock>,
    size: (usize, usize),
    painting: Option<Painting>,
    /// The run that figures are of, and those on their way.
    run: u64,
    figures: Vec<(u64, Reading)>,
    /// Read-back of the values, and its run.
    reading: Option<(u64, Reading)>,
}

/// Timing of the passes.
#[derive(Debug)]
struct Clock {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
}

impl Chain {
    /// `None` if f32 has no room for the elements or is inaccurate next to them, or if the map exceeds a buffer.
    pub fn new(gpu: &Gpu, shape: &Shape<'_>) -> Option<Self> {
        let declaration = shape.quantity.declaration();
        let (width, height) = shape.size;
        // A pass may have a workgroup for every row.
        if width.max(height) > MOST_GROUPS as usize {
            return None;
        }
        let (parts, pixels) = (declaration.parts, width * height);
        let bytes = |values: usize| Some((values * 8) as u64).filter(|&bytes| bytes <= gpu.buffer_limit);
        bytes(pixels.div_ceil(2))?;
        let (boards, superpositions) = (Vec::new(), Vec::new());
        let mut making = Making { gpu, shape, wave: None, boards, superpositions, sums: Vec::new() };
        let mut across = Vec::new();
        let mut forming = Forming::new(gpu, shape.quantity, pixels);
        let mut gathering = Gathering::new(gpu, parts, shape.probes.len());
        if let Some(Interpolated { rows, heard, samples, weights }) = &shape.interpolated {
            let (columns, lines) = (samples.columns.len(), samples.rows.len());
            bytes(samples.len())?;
            let wide = gpu.storage("wide", bytes(lines * width * weights.len())?);
            let mut sampled: [Option<wgpu::Buffer>; 2] = [None, None];
            for (place, (part, [weights, _])) in Part::of(parts).zip(weights).enumerate() {
                let normal = part == Part::Normal;
                let sampled = match &mut sampled[usize::from(normal)] {
                    Some(sampled) => sampled.clone(),
                    none => none.insert(making.sample(samples, heard, normal)?).clone(),
                };
                let lines = Lines {
                    count: lines,
                    strides: [1, columns, 0],
                    first_pixel: place * lines * width,
                    pixel_strides: [1, width],
                };
                let made = [(3, wide.as_entire_binding())];
                across.push(resampling::step(
                    gpu,
                    (Program::Across, PRESSURE),
                    &sampled,
                    [weights; 2],
                    &lines,
                    &made,
                ));
            }
            // No quantity needs only slopes along the second axis.
            let values = weights[0][1];
            let slopes = Part::of(parts).position(|part| part == Part::AlongY);
            let slopes = slopes.map_or(values, |place| weights[place][1]);
            let strides = [width, 1, lines * width];
            let of_pixels =
                Lines { count: width, strides, first_pixel: rows.start * width, pixel_strides: [width, 1] };
            forming.interpolate(gpu, &wide, [values, slopes], &of_pixels);
            let probe = |(number, &place): (usize, &usize)| {
                let row = (place / width)
                    .checked_sub(rows.start)
                    .filter(|row| rows.contains(&(row + rows.start)))?;
                let ((first, values), (_, slopes)) = (values.of(row, 1), slopes.of(row, 1));
                Some(Probe { number, first: first * width + place % width, weights: [values, slopes] })
            };
            let probes: Vec<_> = shape.probes.iter().enumerate().filter_map(probe).collect();
            gathering.add(gpu, [&wide, &forming.peak], [width, lines * width], &probes);
        }
        for (row, places) in &shape.direct {
            // Slopes near the array need several passes and are left to the CPU.
            if !Part::of(parts).eq([Part::Pressure]) {
                return None;
            }
            let sums = gpu.storage("sums", bytes(places.len())?);
            let all: Vec<_> = (0..shape.aperture.faces.len()).collect();
            making.add(places, &all, &sums, 1.0)?;
            making.sums.push(sums.clone());
            let first = row * width;
            let left_out = shape.left_out.bits(first..first + places.len());
            forming.take(gpu, &sums, [width, places.rows.len()], first, &left_out);
            let probe = |(number, &place): (usize, &usize)| {
                let first = place.checked_sub(first).filter(|&place| place < places.len())?;
                Some(Probe { number, first, weights: [&[1.0]; 2] })
            };
            let probes: Vec<_> = shape.probes.iter().enumerate().filter_map(probe).collect();
            gathering.add(gpu, [&sums, &forming.peak], [1, 0], &probes);
        }
        let Making { wave, boards, superpositions, sums, .. } = making;
        Some(Self {
            wave: wave?,
            boards,
            superpositions,
            sums,
            across,
            forming,
            gathering,
            clock: Clock::new(gpu),
            size: shape.size,
            painting: None,
            run: 0,
            figures: Vec::new(),
            reading: None,
        })
    }

    /// Runs the passes: all of them after a change of the drive, those after the superposition after a change of
    /// constants.
    pub fn run(&mut self, gpu: &Gpu, drive: Option<(&Aperture, &Drive)>, constants: &Constants, factor: f32) {
        self.run += 1;
        self.forming.set(gpu, constants, factor);
        let mut encoder = gpu.encoder();
        encoder.clear_buffer(&self.forming.peak, 0, None);
        let mut steps: Vec<&Step> = Vec::new();
        if let Some((aperture, drive)) = drive {
            let counts: Vec<_> =
                self.boards.iter().map(|board| self.write(gpu, board, aperture, drive)).collect();
            for (board, superposition) in &mut self.superpositions {
                superposition.set(gpu, counts[*board]);
            }
            for sum in &self.sums {
                encoder.clear_buffer(sum, 0, None);
            }
            steps.extend(self.superpositions.iter().flat_map(|(_, superposition)| superposition.steps()));
            steps.extend(&self.across);
        }
        steps.extend(self.forming.steps.iter().chain(&self.gathering.steps));
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
            let gathered = &self.gathering.buffer;
            encoder.copy_buffer_to_buffer(&clock.resolved, 0, gathered, gathered.size() - 16, 16);
        }
        gpu.submit(encoder);
    }

    /// Writes the sounding elements of a board, and returns their number.
    fn write(
        &self,
        gpu: &Gpu,
        (number, elements): &(usize, Elements),
        aperture: &Aperture,
        drive: &Drive,
    ) -> u32 {
        let face = &aperture.faces[*number];
        let sounding = sources::sounding(aperture, face, drive);
        let tilts = sources::tilts(&face.layout, sounding.iter().map(|n| n - face.first));
        elements.write(gpu, &self.wave.elements(face, &sounding, drive), &tilts);
        sounding.len() as u32
    }

    /// The map in colours, and whether it was repainted.
    pub fn paint(&mut self, gpu: &Gpu, colouring: &Colouring) -> (Texture, bool) {
        let source = Source { values: &self.forming.values, peak: &self.forming.peak, size: self.size };
        let fits = self.painting.take().filter(|painting| painting.scale() == colouring.scale());
        let painting = fits.unwrap_or_else(|| Painting::new(gpu, &source, colouring.scale()));
        self.painting.insert(painting).paint(gpu, colouring, self.run)
    }

    /// Figures of the last run, if available, without waiting. Requests them if necessary.
    ///
    /// # Errors
    /// The device was lost.
    pub fn figures(&mut self, gpu: &Gpu) -> Result<Option<Gathered>, GpuError> {
        let mut found = None;
        for (run, reading) in &mut self.figures {
            if let Some(bytes) = reading.poll(gpu)?.filter(|_| *run == self.run) {
                found = Some(bytes);
            }
        }
        if let Some(bytes) = found {
            return Ok(Some(self.gathering.read(gpu, &bytes)));
        }
        let is_asked = self.figures.iter().any(|(run, reading)| *run == self.run && !reading.is_free());
        if !is_asked {
            self.ask(gpu);
        }
        Ok(None)
    }

    fn ask(&mut self, gpu: &Gpu) {
        if self.figures.is_empty() {
            let bytes = self.gathering.buffer.size();
            self.figures.extend((0..ON_THEIR_WAY).map(|_| (0, Reading::with_room(gpu, bytes))));
        }
        // If all read-backs are pending, the next frame requests again.
        if let Some((run, reading)) = self.figures.iter_mut().find(|(_, reading)| reading.is_free()) {
            reading.ask(gpu, gpu.encoder(), &[&self.gathering.buffer]);
            *run = self.run;
        }
    }

    /// Requests the values of all pixels and the figures of the last run; `None` while pending, unless it may `wait`.
    ///
    /// # Errors
    /// The device was lost.
    pub fn values(&mut self, gpu: &Gpu, wait: bool) -> Result<Option<(Vec<f32>, Gathered)>, GpuError> {
        loop {
            let bytes = self.gathering.buffer.size() + self.forming.values.size();
            let (run, reading) = self.reading.get_or_insert_with(|| (0, Reading::with_room(gpu, bytes)));
            if reading.is_free() {
                reading.ask(gpu, gpu.encoder(), &[&self.gathering.buffer, &self.forming.values]);
                *run = self.run;
            }
            let bytes = if wait { Some(reading.wait(gpu)?) } else { reading.poll(gpu)? };
            let Some(bytes) = bytes else { return Ok(None) };
            // Results of an earlier run are obsolete.
            if *run == self.run {
                let (figures, values) = bytes.split_at(self.gathering.buffer.size() as usize);
                let values = &bytemuck::cast_slice(values)[..self.size.0 * self.size.1];
                return Ok(Some((values.to_vec(), self.gathering.read(gpu, figures))));
            }
        }
    }
}

/// A chain under construction.
struct Making<'a> {
    gpu: &'a Gpu,
    shape: &'a Shape<'a>,
    wave: Option<Wave>,
    boards: Vec<(usize, Elements)>,
    superpositions: Vec<(usize, Superposition)>,
    sums: Vec<wgpu::Buffer>,
}

impl Making<'_> {
    /// The pressure of some boards at the samples, or its slope along the normal, as a buffer filled by
    /// superpositions.
    fn sample(&mut self, samples: &Samples, heard: &[usize], normal: bool) -> Option<wgpu::Buffer> {
        let out = self.gpu.storage("samples", (samples.len() * 8) as u64);
        self.sums.push(out.clone());
        if !normal {
            return self.add(samples, heard, &out, 1.0).map(|()| out);
        }
        for (shift, weight) in stencil(self.shape.aperture.wavelength()) {
            self.add(&shifted(samples, self.shape.normal * shift), heard, &out, weight)?;
        }
        Some(out)
    }

    fn add(&mut self, samples: &Samples, heard: &[usize], out: &wgpu::Buffer, gain: f64) -> Option<()> {
        heard.iter().try_for_each(|&number| self.add_face(samples, number, out, gain))
    }

    /// `None` if f32 is inaccurate.
    fn add_face(&mut self, samples: &Samples, number: usize, out: &wgpu::Buffer, gain: f64) -> Option<()> {
        let aperture = self.shape.aperture;
        let face = &aperture.faces[number];
        let samples = samples.seen_from(&face.pose);
        let wave = Wave::new(&aperture.element, &face.layout, &samples)?;
        let every: Vec<_> = face.elements().collect();
        let everything = Drive {
            amplitudes: vec![1.0; aperture.positions.len()],
            phases: vec![0.0; aperture.positions.len()],
        };
        let elements = wave.elements(face, &every, &everything);
        let sources = Sources { elements, tilts: Vec::new(), wave, samples };
        if !sources.has_no_sample_beside_rims() {
            return None;
        }
        let Sources { wave, samples, .. } = sources;
        // An image has the drive of its board.
        let board = aperture.boards().position(|board| board.first == face.first)?;
        let gain = gain * face.gain * self.wave.as_ref().map_or(1.0, |first| wave.gain_over(first));
        let place = self.board(board, &wave);
        let elements = &self.boards[place].1;
        let superposition = Superposition::new(self.gpu, &wave, elements, &samples, out, gain);
        self.superpositions.push((place, superposition));
        self.wave.get_or_insert(wave);
        Some(())
    }

    /// The index of a board's elements.
    fn board(&mut self, number: usize, wave: &Wave) -> usize {
        let known = self.boards.iter().position(|(known, _)| *known == number);
        known.unwrap_or_else(|| {
            let room = self.shape.aperture.faces[number].layout.positions.len();
            self.boards.push((number, Elements::with_room(self.gpu, room, Waves::of(wave))));
            self.boards.len() - 1
        })
    }
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
