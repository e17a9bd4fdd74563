//! Tests of blocks of cells: which are followed.

use super::*;
use crate::acoustics::Aperture;
use crate::scene::{Plane, Scene};

/// m on the screen for a difference of a metre from cell to cell.
const PER_CELL: f64 = 800.0;

fn cells() -> Cells {
    let plane = Plane { size: DVec2::new(0.03, 0.025), ..Plane::default() };
    Cells::new(&Aperture::new(&Scene::default()), &plane, 0.03, 1e-3).unwrap()
}

/// A surface with this depth (m) of the cell in a column and a row.
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
fn slopes_of_a_block_and_beside_it_count() {
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
