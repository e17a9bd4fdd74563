//! The sound that bodies scatter to many points, summed over the sources of their surfaces on the GPU.

use glam::DVec3;
use num_complex::Complex32;
use wgpu::BufferUsages;

use crate::field::gpu::program::{EmissionParams, Program};
use crate::field::gpu::tuning::MOST_GROUPS;
use crate::field::gpu::{Gpu, Reading};
use crate::field::gpu_report::GpuError;
use crate::scatter::Emission;

/// Bytes of a source, and of a point.
const SOURCE: u64 = 32;
const POINT: u64 = 16;

impl Gpu {
    /// Complex pressures (Pa, peak) of all emissions together at points (m), in pieces that fit a buffer, without the
    /// corrections near surfaces. Waits for it.
    ///
    /// # Errors
    /// The device was lost or has not enough memory.
    pub fn scattered(&self, emissions: &[Emission], points: &[DVec3]) -> Result<Vec<Complex32>, GpuError> {
        let mut all = Vec::with_capacity(points.len());
        for points in points.chunks((self.buffer_limit / POINT) as usize) {
            let out = self.storage("scattered", points.len() as u64 * 8);
            for emission in emissions {
                let seen = |at: &DVec3| {
                    let [x, y, z] = emission.seen(*at);
                    [x, y, z, 0.0]
                };
                let seen: Vec<[f32; 4]> = points.iter().map(seen).collect();
                let seen = self.filled("points", bytemuck::cast_slice(&seen), BufferUsages::STORAGE);
                for sources in emission.sources.chunks((self.buffer_limit / SOURCE) as usize) {
                    let sources_ =
                        self.filled("sources", bytemuck::cast_slice(sources), BufferUsages::STORAGE);
                    self.emit(
                        emission,
                        (&sources_, sources.len() as u32),
                        (&seen, points.len() as u32),
                        &out,
                    );
                }
            }
            let bytes = Reading::new(self, self.encoder(), &out).wait(self)?;
            all.extend_from_slice(bytemuck::cast_slice(&bytes));
        }
        Ok(all)
    }

    /// Submits the sums over sources at points, a run each of what an adapter does at once.
    fn emit(
        &self,
        emission: &Emission,
        (sources, source_count): (&wgpu::Buffer, u32),
        (points, count): (&wgpu::Buffer, u32),
        out: &wgpu::Buffer,
    ) {
        let together = self.tuning.samples_together();
        for first_source in (0..source_count).step_by(self.tuning.most_rounds as usize) {
            let last_source = source_count.min(first_source + self.tuning.most_rounds);
            let most = u64::from(count.min(MOST_GROUPS * together));
            let pairs_of_point = u64::from(last_source - first_source);
            let length = (self.tuning.most_pairs / pairs_of_point).clamp(1, most) as u32;
            for first in (0..count).step_by(length as usize) {
                let params = EmissionParams {
                    first_source,
                    last_source,
                    first,
                    count: length.min(count - first),
                    leak: emission.leak,
                    least: emission.least,
                };
                let buffer = self.params(bytemuck::bytes_of(&params));
                let bindings = [
                    (0, buffer.as_entire_binding()),
                    (1, sources.as_entire_binding()),
                    (2, points.as_entire_binding()),
                    (3, out.as_entire_binding()),
                ];
                let step = self.step(Program::Emission, &bindings, (params.count.div_ceil(together), 1));
                let mut encoder = self.encoder();
                step.run(&mut encoder.begin_compute_pass(&Default::default()));
                self.submit(encoder);
            }
        }
    }
}
