//! Averages on the GPU: squares of the pressure at cells, and the dent under them.
//!
//! The cosine transforms of the dent are products with matrices, for which the interpolation's program serves: every mode is
//! a weighted sum of all cells of a line, and every cell one of all modes.

use std::f64::consts::PI;

use crate::field::gpu::field::{Band, WALKING_GROUPS};
use crate::field::gpu::program::{self, ComplianceParams, JoinParams, SquaresParams, WORKGROUP};
use crate::field::gpu::{Gpu, GpuError, GpuField, GpuResampling};
use crate::field::interpolation::Resampling;
use crate::scene::Liquid;
use crate::surface::Reflector;

const INVOCATIONS: u32 = WALKING_GROUPS * WORKGROUP;

/// From cells to modes and back.
#[derive(Debug)]
pub struct GpuTank {
    to_modes: GpuResampling,
    to_cells: GpuResampling,
    counts: [usize; 2],
    /// 1/m, q of the first mode along each axis.
    wavenumber: [f32; 2],
}

impl Gpu {
    /// A tank of `counts` cells, `step` (m) apart; `None` if it has no room in a buffer.
    pub fn tank(&self, counts: [usize; 2], step: f64) -> Option<GpuTank> {
        let to_modes = counts.map(|count| {
            let share = |mode: usize| if mode == 0 { 1.0 } else { 2.0 } / count as f64;
            matrix(count, |mode, cell| share(mode) * cosine(mode, cell, count))
        });
        let to_cells = counts.map(|count| matrix(count, |cell, mode| cosine(mode, cell, count)));
        let product = |[across, up]: &[Resampling; 2]| self.resampling(across, up, counts[0]);
        Some(GpuTank {
            to_modes: product(&to_modes)?,
            to_cells: product(&to_cells)?,
            counts,
            wavenumber: counts.map(|count| (PI / (step * count as f64)) as f32),
        })
    }

    /// Adds one drive's `share` of the mean squares at cells: |p|², and beside it the radiation pressure where there is a
    /// reflector. `pressure` and its slopes lie in one buffer each.
    pub fn add_squares(
        &self,
        [pressure, along_x, along_y]: [&GpuField; 3],
        reflector: Option<Reflector>,
        share: f64,
        squares: &GpuField,
    ) {
        let ([pressure], [along_x], [along_y], [squares]) =
            (pressure.bands(), along_x.bands(), along_y.bands(), squares.bands())
        else {
            return;
        };
        let params = SquaresParams {
            count: squares.len(),
            invocations: INVOCATIONS,
            of_pressure: reflector.map_or(0.0, |reflector| reflector.of_pressure as f32),
            of_gradient: reflector.map_or(0.0, |reflector| reflector.of_gradient as f32),
            share: share as f32,
            padding: 0,
        };
        let pipeline = self.other(("squares", None), program::squares_source);
        let buffers = [pressure, along_x, along_y, squares];
        self.walk(&pipeline, bytemuck::bytes_of(&params), &buffers);
    }

    /// The depth (m) of a liquid's cells under the radiation pressure in `squares`; `None` if a buffer has no room.
    ///
    /// # Errors
    /// The device was lost.
    pub fn dent(
        &self,
        tank: &GpuTank,
        liquid: &Liquid,
        squares: &GpuField,
    ) -> Result<Option<GpuField>, GpuError> {
        let Some(modes) = self.interpolate(squares, &tank.to_modes)? else { return Ok(None) };
        let yielding = self.zeros(tank.counts[0] * tank.counts[1]);
        let ([modes], [dent]) = (modes.bands(), yielding.bands()) else { return Ok(None) };
        let params = ComplianceParams {
            count: dent.len(),
            invocations: INVOCATIONS,
            columns: tank.counts[0] as u32,
            weight: (liquid.density() * liquid.gravity) as f32,
            tension: liquid.surface_tension() as f32,
            padding: 0,
            wavenumber: tank.wavenumber,
        };
        let pipeline = self.other(("compliance", None), program::compliance_source);
        self.walk(&pipeline, bytemuck::bytes_of(&params), &[modes, dent]);
        self.interpolate(&yielding, &tank.to_cells)
    }

    /// A shape and the radiation pressure side by side, with a factor on each.
    pub fn join(&self, shape: &GpuField, squares: &GpuField, [of_shape, of_radiation]: [f64; 2]) -> GpuField {
        let joined = self.zeros(squares.bands().iter().map(|band| band.len() as usize).sum());
        let params = |band: &Band| JoinParams {
            count: band.len(),
            invocations: INVOCATIONS,
            of_shape: of_shape as f32,
            of_radiation: of_radiation as f32,
        };
        let pipeline = self.other(("join", None), program::join_source);
        for ((shape, squares), out) in shape.bands().iter().zip(squares.bands()).zip(joined.bands()) {
            self.walk(&pipeline, bytemuck::bytes_of(&params(out)), &[shape, squares, out]);
        }
        joined
    }

    /// Runs a program that walks over whole bands, bound in this order.
    fn walk(&self, pipeline: &wgpu::ComputePipeline, params: &[u8], bands: &[&Band]) {
        let params = self.params(params);
        let mut bindings = vec![(0, &params)];
        bindings.extend((1..).zip(bands.iter().map(|band| &band.pressure)));
        let mut encoder = self.encoder();
        self.dispatch(&mut encoder, pipeline, &bindings, (WALKING_GROUPS, 1));
        self.submit(encoder);
    }
}

/// A square matrix as weights: every pixel is made of all samples.
fn matrix(count: usize, weight: impl Fn(usize, usize) -> f64) -> Resampling {
    let weights = (0..count * count).map(|i| weight(i / count, i % count) as f32).collect();
    Resampling { taps: count, first: vec![0; count], weights }
}

/// cos(πk(i + ½)/N)
fn cosine(mode: usize, cell: usize, count: usize) -> f64 {
    (PI * (mode * (2 * cell + 1) % (4 * count)) as f64 / (2 * count) as f64).cos()
}
