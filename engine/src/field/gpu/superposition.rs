//! Sums over the elements on the GPU.
//!
//! There is no table of transfer values as on the CPU: with llvmpipe, reading a value took three times as long as
//! computing it, and a real GPU computes faster still.

use std::ops::Range;

use bytemuck::Zeroable;
use num_complex::Complex32;
use wgpu::BufferUsages;

use crate::field::gpu::device::Step;
use crate::field::gpu::program::{FieldProgram, Params, Program, UNIFORM_ELEMENTS, Waves};
use crate::field::gpu::tuning::MOST_GROUPS;
use crate::field::gpu::{Gpu, Reading};
use crate::field::sources::MOST_NODES;
use crate::field::sources::{Form, Sources, Wave};
use crate::field::{gpu_report::GpuError, samples::Samples};

/// The sounding elements of a board in the layout of programs, shared by all superpositions of a map.
#[derive(Debug)]
pub(super) struct Elements {
    buffer: wgpu::Buffer,
    room: usize,
    waves: Waves,
}

impl Elements {
    /// Buffers with room for `count` elements.
    pub(super) fn with_room(gpu: &Gpu, room: usize, waves: Waves) -> Self {
        let vectors = room * waves.vectors();
        let (length, usage) = match vectors {
            0..=UNIFORM_ELEMENTS => (UNIFORM_ELEMENTS, BufferUsages::UNIFORM),
            _ => (vectors, BufferUsages::STORAGE),
        };
        let buffer = gpu.buffer("elements", (length * 16) as u64, usage | BufferUsages::COPY_DST);
        Self { buffer, room, waves }
    }

    /// Writes the elements, and the tilts of a curved board.
    pub(super) fn write(&self, gpu: &Gpu, elements: &[[f32; 4]], tilts: &[[f32; 4]]) {
        if tilts.is_empty() {
            gpu.queue.write_buffer(&self.buffer, 0, bytemuck::cast_slice(elements));
        } else {
            let both: Vec<_> =
                elements.iter().zip(tilts).flat_map(|(element, tilt)| [*element, *tilt]).collect();
            gpu.queue.write_buffer(&self.buffer, 0, bytemuck::cast_slice(&both));
        }
    }
}

impl Waves {
    pub(super) fn of(wave: &Wave) -> Self {
        match (wave.form, wave.is_flat, &wave.piston) {
            (Form::Cosine, true, _) => Self::Cosine,
            (Form::Cosine, false, _) => Self::CurvedCosine,
            // Never of curved boards.
            (Form::Rectangle, _, _) => Self::Rectangle,
            (Form::Round, false, _) => Self::Curved,
            (Form::Round, true, None) => Self::Piston,
            (Form::Round, true, Some(_)) => Self::ExactPiston,
        }
    }
}

/// Passes that add the waves of all elements at some samples to a buffer.
#[derive(Debug)]
pub(super) struct Superposition {
    runs: Vec<Run>,
}

#[derive(Debug)]
struct Run {
    step: Step,
    params: Params,
    buffer: wgpu::Buffer,
    elements: Range<u32>,
}

impl Superposition {
    /// The sums for samples, with pressure written to `out`, times a `gain`.
    pub(super) fn new(
        gpu: &Gpu,
        wave: &Wave,
        elements: &Elements,
        samples: &Samples,
        out: &wgpu::Buffer,
        gain: f64,
    ) -> Self {
        let program = FieldProgram {
            waves: elements.waves,
            many_elements: elements.room * elements.waves.vectors() > UNIFORM_ELEMENTS,
            many_terms: wave.directivity.iter().any(|part| part.terms > 8) || wave.decay.terms > 4,
        };
        let wide = |points: &[glam::DVec3]| -> Vec<[f32; 4]> {
            points.iter().map(|p| [p.x as f32, p.y as f32, p.z as f32, wave.turns(p.z)]).collect()
        };
        let storage = |label, values: &[[f32; 4]]| {
            gpu.filled(label, bytemuck::cast_slice(values), BufferUsages::STORAGE)
        };
        let (columns, rows) =
            (storage("columns", &wide(&samples.columns)), storage("rows", &wide(&samples.rows)));
        let nodes = wave.piston.as_ref().map(|piston| {
            let mut nodes: Vec<_> = piston.nodes.iter().map(|&[cos, sin2]| [cos, sin2, 0.0, 0.0]).collect();
            nodes.resize(MOST_NODES, [0.0; 4]);
            gpu.filled("nodes", bytemuck::cast_slice(&nodes), BufferUsages::UNIFORM)
        });
        let common = Params { gain: gain as f32, ..params(wave, samples) };
        let rounds = 1 + 2 * common.nodes + if program.many_terms { 2 * (4 + 3) } else { 0 };
        let (room, count) = (elements.room as u32, samples.len() as u32);
        let mut runs = Vec::new();
        for first_element in (0..room).step_by((gpu.tuning.most_rounds / rounds) as usize) {
            let elements_ = first_element..room.min(first_element + gpu.tuning.most_rounds / rounds);
            let together = gpu.tuning.samples_together();
            let most = u64::from(count.min(MOST_GROUPS * together));
            let length = (gpu.tuning.most_pairs / elements_.len() as u64).min(most) as u32;
            for first in (0..count).step_by(length as usize) {
                let params = Params { first, count: length.min(count - first), ..common };
                let buffer = gpu.params(bytemuck::bytes_of(&params));
                let mut bindings = vec![
                    (0, buffer.as_entire_binding()),
                    (1, elements.buffer.as_entire_binding()),
                    (2, columns.as_entire_binding()),
                    (3, rows.as_entire_binding()),
                    (4, out.as_entire_binding()),
                ];
                bindings.extend(nodes.as_ref().map(|nodes| (5, nodes.as_entire_binding())));
                let groups = params.count.div_ceil(together);
                let mut step = gpu.step(Program::Field(program), &bindings, (groups, 1));
                step.pairs = u64::from(params.count) * elements_.len() as u64;
                runs.push(Run { step, params, buffer, elements: elements_.clone() });
            }
        }
        Self { runs }
    }

    /// Sets the number of sounding elements.
    pub(super) fn set(&mut self, gpu: &Gpu, sounding: u32) {
        for Run { params, buffer, elements, .. } in &mut self.runs {
            (params.first_element, params.last_element) =
                (elements.start.min(sounding), elements.end.min(sounding));
            gpu.queue.write_buffer(buffer, 0, bytemuck::bytes_of(params));
        }
    }

    pub(super) fn steps(&self) -> impl Iterator<Item = &Step> {
        self.runs.iter().map(|run| &run.step)
    }
}

impl Gpu {
    /// Complex pressure (Pa, peak) of all boards together at every sample, in pieces that fit a
    /// buffer. Waits for it.
    ///
    /// # Errors
    /// The device was lost or has not enough memory.
    pub fn pressure(&self, faces: &[Sources<'_>]) -> Result<Vec<Complex32>, GpuError> {
        let mut sum = Vec::new();
        for face in faces {
            let field = of_face(self, face)?;
            if sum.is_empty() {
                sum = field;
            } else {
                sum.iter_mut().zip(field).for_each(|(sum, p)| *sum += p);
            }
        }
        Ok(sum)
    }
}

fn of_face(gpu: &Gpu, sources: &Sources<'_>) -> Result<Vec<Complex32>, GpuError> {
    let samples = &sources.samples;
    if samples.is_empty() {
        return Ok(Vec::new());
    }
    let elements = Elements::with_room(gpu, sources.elements.len().max(1), Waves::of(&sources.wave));
    elements.write(gpu, &sources.elements, &sources.tilts);
    let most = (gpu.buffer_limit / 8) as usize;
    let (mut field, columns) = (Vec::with_capacity(samples.len()), samples.columns.len());
    let rows_together = (most / columns).max(1).min(samples.rows.len());
    for rows in samples.rows.chunks(rows_together) {
        for columns in samples.columns.chunks(most / rows.len()) {
            let piece = Samples { columns: columns.to_vec(), rows: rows.to_vec() };
            let out = gpu.storage("pressure", (piece.len() * 8) as u64);
            let mut runs = Superposition::new(gpu, &sources.wave, &elements, &piece, &out, 1.0);
            runs.set(gpu, sources.elements.len() as u32);
            for step in runs.steps() {
                let mut encoder = gpu.encoder();
                step.run(&mut encoder.begin_compute_pass(&Default::default()));
                gpu.submit(encoder);
            }
            let bytes = Reading::new(gpu, gpu.encoder(), &out).wait(gpu)?;
            field.extend_from_slice(bytemuck::cast_slice(&bytes));
        }
    }
    Ok(field)
}

fn params(wave: &Wave, samples: &Samples) -> Params {
    let (radius, nodes) = wave.piston.as_ref().map_or((0.0, 0), |piston| (piston.radius, piston.nodes.len()));
    Params {
        directivity: bytemuck::cast(wave.directivity[0].coefficients),
        second: bytemuck::cast(wave.directivity[1].coefficients),
        decay: bytemuck::cast(wave.decay.coefficients),
        decay_scale: wave.decay_scale,
        turns_per_metre: wave.turns_per_metre,
        columns: samples.columns.len() as u32,
        nodes: nodes as u32,
        radius,
        piston_scale: if nodes > 0 { 2.0 / (radius * nodes as f32) } else { 0.0 },
        ..Params::zeroed()
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};

    use super::*;
    use crate::acoustics::Aperture;

    use crate::field::gpu::adapter;
    use crate::field::gpu::tuning::Tuning;

    use crate::requirement::found;
    use crate::scene::{Array, Plane, Scene};

    /// Work cut much finer than any adapter needs.
    const STARVED: Tuning = Tuning { most_rounds: 1 << 9, most_pairs: 1 << 9, ..Tuning::SOFTWARE };

    fn array() -> Array {
        Array { columns: 4, rows: 4, ..Array::default() }
    }

    fn samples() -> Samples {
        let plane = Plane { centre: DVec3::Z * 0.06, size: DVec2::new(0.06, 0.05), ..Plane::default() };
        Samples::on_plane(&plane, 31, 23).unwrap()
    }

    #[test]
    fn no_submission_has_more_pairs_than_allowed_and_none_is_missing() {
        let Some(gpu) = found("gpu", adapter::open_best(true)) else { return };
        let (gpu, samples) = (gpu.with_tuning(STARVED), samples());
        let aperture = Aperture::new(&Scene { array: array(), ..Scene::default() });
        let wave = Wave::new(&aperture.element, &aperture.faces[0].layout, &samples).unwrap();
        let elements = Elements::with_room(&gpu, 16, Waves::of(&wave));
        let out = gpu.storage("out", (samples.len() * 8) as u64);
        let superposition = Superposition::new(&gpu, &wave, &elements, &samples, &out, 1.0);
        let pairs: Vec<_> = superposition.steps().map(|step| step.pairs).collect();
        assert!(pairs.iter().all(|pairs| *pairs <= STARVED.most_pairs), "{pairs:?}");
        assert_eq!(pairs.iter().sum::<u64>(), 16 * samples.len() as u64);
    }
}
