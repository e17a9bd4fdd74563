//! Tests of blocks of cells: which are followed, and how closely.

use super::*;
use crate::acoustics::Aperture;
use crate::scene::{Plane, Scene};

/// m on the screen for a difference of a metre from cell to cell.
const PER_CELL: f64 = 800.0;

fn cells() -> Cells {
    let plane = Plane { size: DVec2::new(0.03, 0.025), ..Plane::default() };
    Cells::new(&Aperture::new(&Scene::default()), &plane, 0.03, 1e-3).unwrap()
}

/// With this depth (m) of the cell in a column and a row.
fn surface(cells: &Cells, depth: impl Fn([usize; 2]) -> f64) -> Surface<'_> {
    let at = |i: usize| depth([i % cells.counts[0], i / cells.counts[0]]);
    let depth: Vec<_> = (0..cells.count()).map(at).collect();
    let around = cells.beyond_walls();
    let size = DVec2::new(0.03, 0.025);
    Surface {
        cells,
        depth: cells.mirrored(&depth, 1.0),
        columns: around.counts[0],
        reach: (around.counts[0] - cells.counts[0]) / 2,
        per_cell: PER_CELL,
        size,
        pixel: size / 40.0,
    }
}

/// Irregular depths along an axis, steep for a few cells out of many.
fn rough(i: usize) -> f64 {
    let unit = (i as f64 * 0.754_877_666).fract();
    1e-5 * unit.powi(8)
}

#[test]
fn blocks_of_a_steep_surface_have_every_cell_once() {
    let cells = cells();
    let steep = Surface { per_cell: 1e9, ..surface(&cells, |[column, row]| rough(column) + rough(row)) };
    let mut covered = vec![0; cells.count()];
    for block in steep.blocks() {
        for row in block.first[1]..block.first[1] + block.cells[1] {
            for column in block.first[0]..block.first[0] + block.cells[0] {
                covered[row * cells.counts[0] + column] += 1;
            }
        }
    }
    assert!(covered.iter().all(|times| *times == 1));
}

#[test]
fn light_is_followed_from_where_its_slope_may_bend_it_onto_the_screen() {
    let cells = cells();
    let mut dropped = 0;
    // Also of a single step at the far end of a block.
    let step = |i: usize| if i < 2 * SIDE { 0.0 } else { 1e-5 };
    let profiles: [&dyn Fn(usize) -> f64; 2] = [&rough, &step];
    for (axis, profile) in [0, 1].into_iter().flat_map(|axis| profiles.map(|profile| (axis, profile))) {
        let bent = surface(&cells, |place| profile(place[axis]));
        let flat = surface(&cells, |_| 1e-3);
        // Walls mirror the cells.
        let count = cells.counts[axis];
        let depth = |i: isize| {
            let i = if i < 0 { -1 - i } else { i } as usize;
            profile(if i < count { i } else { 2 * count - 1 - i })
        };
        for row in (0..cells.counts[1]).step_by(SIDE) {
            for column in (0..cells.counts[0]).step_by(SIDE) {
                let first = [column, row];
                let ends = first.map(|first| first as isize);
                let last = [0, 1].map(|axis| (first[axis] + SIDE).min(cells.counts[axis]));
                let beyond = [0, 1].map(|axis| {
                    let edge = |edge: usize| (edge as f64 - cells.counts[axis] as f64 / 2.0) * cells.step;
                    let half = flat.size[axis] / 2.0;
                    (edge(first[axis]) - half).max(-half - edge(last[axis])).max(0.0)
                });
                let is_beside = |axis: usize| beyond[axis] > 0.0;
                assert_eq!(flat.block(first).is_some(), !is_beside(0) && !is_beside(1), "{first:?}");
                // From the cell before the block to the one behind it.
                let steps = (ends[axis]..=last[axis] as isize).map(|i| (depth(i) - depth(i - 1)).abs());
                let steepest = steps.fold(0.0, f64::max);
                let is_met = beyond[axis] <= STEEPER * PER_CELL * steepest;
                assert_eq!(bent.block(first).is_some(), is_met && !is_beside(1 - axis), "{axis}: {first:?}");
                dropped += usize::from(!is_met);
            }
        }
    }
    assert!(dropped > 0);
}

#[test]
fn an_even_slope_needs_one_ray_to_a_cell_and_a_rough_surface_many() {
    let cells = cells();
    // Exact in f32.
    let unit = 0.5f64.powi(20);
    let even = surface(&cells, |[column, row]| unit * (column + 2 * row) as f64);
    let middle = cells.counts.map(|count| count / 2 / SIDE * SIDE);
    assert_eq!(even.block(middle).map(|block| block.rays), Some(1));
    for axis in [0, 1] {
        let bent = surface(&cells, |place| 1e-5 * (place[axis] as f64).sin());
        assert!(bent.block(middle).is_some_and(|block| block.rays > 3), "{axis}");
    }
}

#[test]
fn slopes_of_all_rows_and_columns_of_a_block_and_of_those_beside_it_count() {
    let cells = cells();
    for axis in [0, 1] {
        for place in 0..3 * SIDE {
            let depth =
                |at: [usize; 2]| if at[axis] == place { 1e-4 * (at[1 - axis] % 2) as f64 } else { 0.0 };
            let mut size = DVec2::splat(0.03);
            // Light reaches it by slopes along the row or column alone.
            size[1 - axis] = 1e-3;
            let surface = Surface { size, ..surface(&cells, depth) };
            let mut first = [SIDE; 2];
            first[1 - axis] = 0;
            let is_followed = surface.block(first).is_some();
            assert_eq!(is_followed, (SIDE - 1..=2 * SIDE).contains(&place), "{axis}: {place}");
        }
    }
}

/// Square cells that go on beyond a square screen, with a depth (m) by the place (m) from its centre.
fn with_surface<T>(depth: impl Fn(DVec2) -> f64, look: impl Fn(&Surface<'_>) -> T) -> T {
    let size = DVec2::splat(0.04);
    let scene = Scene { plane: Plane { size, ..Plane::default() }, ..Scene::default() };
    let cells = Cells::new(&Aperture::new(&scene), &scene.plane, 0.08, 1e-3).unwrap();
    let [columns, rows] = [0, 1].map(|axis| cells.places(axis).collect::<Vec<_>>());
    let depths: Vec<_> =
        rows.iter().flat_map(|y| columns.iter().map(|x| depth(DVec2::new(*x, *y)))).collect();
    let around = cells.beyond_walls();
    look(&Surface {
        cells: &cells,
        depth: cells.mirrored(&depths, 1.0),
        columns: around.counts[0],
        reach: (around.counts[0] - cells.counts[0]) / 2,
        per_cell: 0.1 / cells.step,
        size,
        pixel: size / 100.0,
    })
}

#[test]
fn blocks_are_left_out_whose_light_misses_the_screen() {
    with_surface(
        |_| 1e-5,
        |surface| {
            let reaches = |block: &Block| {
                [0, 1].into_iter().all(|axis| {
                    let end = block.first[axis] + block.cells[axis];
                    let edge = surface.size[axis] / 2.0;
                    surface.place(axis, block.first[axis]) <= edge && surface.place(axis, end) >= -edge
                })
            };
            let blocks = surface.blocks();
            let all = surface.cells.counts.map(|count| count.div_ceil(SIDE));
            assert!(blocks.iter().all(reaches) && blocks.len() * 4 < all[0] * all[1], "{}", blocks.len());
            let area: usize = blocks.iter().map(|block| block.cells[0] * block.cells[1]).sum();
            assert!(area as f64 * surface.cells.step.powi(2) >= surface.size.element_product());
        },
    );
}

#[test]
fn waves_across_and_up_and_deeper_ones_take_the_same_blocks_and_rays() {
    let blocks = |along: DVec2, deeper: f64| {
        with_surface(
            |place| deeper + 1e-5 * (place.dot(along) * 1000.0).sin(),
            |surface| {
                let blocks = surface.blocks();
                let mut blocks: Vec<_> = blocks.iter().map(|block| (block.first, block.rays)).collect();
                if along.y > 0.0 {
                    blocks.iter_mut().for_each(|(first, _)| first.reverse());
                }
                blocks.sort_unstable();
                blocks
            },
        )
    };
    let across = blocks(DVec2::X, 0.0);
    assert!(across.iter().any(|(_, rays)| (2..48).contains(rays)), "{across:?}");
    assert_eq!(across, blocks(DVec2::Y, 0.0));
    assert_eq!(across, blocks(DVec2::X, 1e-4));
}
