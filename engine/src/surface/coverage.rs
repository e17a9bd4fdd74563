//! Area coverage of pixels by polygons, computed from edges: an edge adds, to every pixel on its right, its height
//! within the pixel's row times the polygon's weight. Prefix sums along the rows give the pixels.

use crate::simd::{Instructions, Isa, Kernel, lanes};

/// Edges processed together.
const LANES: usize = 8;
/// Columns processed together: most pieces reach two, and affect the next one.
const TOGETHER: usize = 3;

/// Some rows of pixels, from the row `first` on.
#[derive(Clone, Debug)]
pub struct Coverage {
    columns: usize,
    first: f64,
    rows: usize,
    /// Stride of the rows of sums: one entry more for everything beyond the last column.
    stride: usize,
    /// Increment of each pixel for all pixels to its right.
    sums: Vec<f64>,
}

/// A sequence of points, in pixels from the outer corner of the first pixel.
#[derive(Clone, Copy, Debug, Default)]
pub struct Places<T = Vec<f64>> {
    pub x: T,
    pub y: T,
}

impl Places {
    pub fn part(&self, places: std::ops::Range<usize>) -> Places<&[f64]> {
        Places { x: &self.x[places.clone()], y: &self.y[places] }
    }
}

impl Places<&[f64]> {
    pub fn of(&self, index: usize) -> [f64; 2] {
        [self.x[index], self.y[index]]
    }
}

/// Edges between points, each with its density: the difference between its left and its right side, upwards.
#[derive(Clone, Copy, Debug)]
pub struct Edges<'a> {
    pub from: [&'a [f64]; 2],
    pub to: [&'a [f64]; 2],
    pub density: &'a [f64],
}

impl Coverage {
    pub fn new(columns: usize, first: usize, rows: usize) -> Self {
        let stride = columns + 1;
        Self { columns, first: first as f64, rows, stride, sums: vec![0.0; stride * rows] }
    }

    /// Span from the first row to behind the last.
    pub fn span(&self) -> [f64; 2] {
        [self.first, self.first + self.rows as f64]
    }

    /// Adds an amount at a point.
    pub fn point(&mut self, [x, y]: [f64; 2], amount: f64) {
        let row = y - self.first;
        if (0.0..self.rows as f64).contains(&row) && (0.0..self.columns as f64).contains(&x) {
            let place = row as usize * self.stride + x as usize;
            self.sums[place] += amount;
            self.sums[place + 1] -= amount;
        }
    }

    /// Adds edges: the density times the height of each edge within a row, to the left of it, signed by its upward
    /// direction. Its right side receives correspondingly less.
    ///
    /// # Panics
    /// Lists of different lengths.
    pub fn edges(&mut self, edges: &Edges<'_>) {
        let count = edges.density.len();
        assert!(
            edges.from.iter().chain(&edges.to).all(|places| places.len() == count),
            "a place for every edge"
        );
        Isa::best().run(Addition { coverage: self, edges });
    }

    /// The value of every pixel, and their sum; negative rounding errors are clamped to zero.
    pub fn fill(&self, values: &mut [f32]) -> f64 {
        let mut total = 0.0;
        for (values, sums) in values.chunks_exact_mut(self.columns).zip(self.sums.chunks_exact(self.stride)) {
            let (mut value, mut row) = (0.0, 0.0);
            for (to, sum) in values.iter_mut().zip(sums) {
                value += sum;
                row += value;
                *to = value.max(0.0) as f32;
            }
            total += row;
        }
        total
    }
}

/// Adds edges, some side by side.
struct Addition<'a, 'b> {
    coverage: &'a mut Coverage,
    edges: &'b Edges<'b>,
}

impl Kernel for Addition<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<I: Instructions>(self) {
        let Self { coverage, edges: Edges { from: [from_x, from_y], to: [to_x, to_y], density } } = self;
        for start in (0..density.len()).step_by(LANES) {
            coverage.add(
                [load(from_x, start), load(from_y, start)],
                [load(to_x, start), load(to_y, start)],
                load(density, start),
            );
        }
    }
}

/// Some numbers of a list, zero beyond its end.
#[inline(always)]
fn load(list: &[f64], start: usize) -> [f64; LANES] {
    let list = &list[start..];
    if let Some(lanes) = list.first_chunk::<LANES>() {
        return *lanes;
    }
    let mut lanes = [0.0; LANES];
    lanes.iter_mut().zip(list).for_each(|(lane, value)| *lane = *value);
    lanes
}

impl Coverage {
    #[inline(always)]
    fn add(
        &mut self,
        [from_x, from_y]: [[f64; LANES]; 2],
        [to_x, to_y]: [[f64; LANES]; 2],
        density: [f64; LANES],
    ) {
        let (rows, columns) = (self.rows as f64, self.columns as f64);
        let left: [f64; LANES] = lanes(|i| smaller(from_x[i], to_x[i]));
        let right: [f64; LANES] = lanes(|i| larger(from_x[i], to_x[i]));
        let bottom: [f64; LANES] = lanes(|i| smaller(from_y[i], to_y[i]) - self.first);
        let top: [f64; LANES] = lanes(|i| larger(from_y[i], to_y[i]) - self.first);
        let low: [f64; LANES] = lanes(|i| smaller(larger(bottom[i], 0.0), rows));
        let high: [f64; LANES] = lanes(|i| smaller(larger(top[i], 0.0), rows));
        let row: [f64; LANES] = lanes(|i| smaller(low[i].floor(), rows - 1.0));
        let rises: [f64; LANES] = lanes(|i| if to_y[i] > from_y[i] { 1.0 } else { 0.0 });
        let amount: [f64; LANES] = lanes(|i| density[i] * (1.0 - 2.0 * rises[i]));
        let foot: [f64; LANES] = lanes(|i| if rises[i] > 0.0 { from_x[i] } else { to_x[i] });
        let head: [f64; LANES] = lanes(|i| if rises[i] > 0.0 { to_x[i] } else { from_x[i] });
        let per_height: [f64; LANES] = lanes(|i| 1.0 / larger(top[i] - bottom[i], f64::MIN_POSITIVE));
        let reached: [f64; LANES] = lanes(|i| if left[i] < columns { high[i] - row[i] } else { 0.0 });
        let reached = largest(&reached);
        let slants = Slants { foot, head, left, right, bottom, per_height };
        let (mut x, mut y) = (slants.at(&low), low);
        let mut above = 0.0;
        while above < reached {
            let next_y: [f64; LANES] = lanes(|i| smaller(row[i] + above + 1.0, high[i]));
            let next_x = slants.at(&next_y);
            let part: [f64; LANES] = lanes(|i| amount[i] * (next_y[i] - y[i]));
            let start: [f64; LANES] = lanes(|i| (row[i] + above) * self.stride as f64);
            self.pieces(&start, [&x, &next_x], &part);
            (x, y) = (next_x, next_y);
            above += 1.0;
        }
    }

    /// Adds pieces of edges to rows whose sums start at `start`, each to the part of every pixel to its right.
    #[inline(always)]
    fn pieces(&mut self, start: &[f64; LANES], [from, to]: [&[f64; LANES]; 2], height: &[f64; LANES]) {
        let columns = self.columns as f64;
        let left: [f64; LANES] = lanes(|i| smaller(from[i], to[i]));
        let right: [f64; LANES] = lanes(|i| larger(from[i], to[i]));
        let first: [f64; LANES] = lanes(|i| smaller(larger(left[i], 0.0).floor(), columns));
        let wide: [f64; LANES] = lanes(|i| right[i] - left[i]);
        let per_wide: [f64; LANES] = lanes(|i| 0.5 / larger(wide[i], f64::MIN_POSITIVE));
        let reached: [f64; LANES] = lanes(|i| smaller(right[i], columns) - first[i]);
        // Everything left of the first column counts there.
        let reached = larger(largest(&reached), 0.0) + 1.0;
        let piece = Piece { left, right, wide, per_wide };
        let (mut so_far, mut before) = (piece.beyond(&first), [0.0; LANES]);
        let mut along = 0.0;
        while along <= reached {
            let mut parts = [[0.0; LANES]; TOGETHER];
            let mut places = [[0.0; LANES]; TOGETHER];
            for (parts, places) in parts.iter_mut().zip(&mut places) {
                let end: [f64; LANES] = lanes(|i| first[i] + along + 1.0);
                let next = piece.beyond(&end);
                let own: [f64; LANES] = lanes(|i| next[i] - so_far[i]);
                *parts = lanes(|i| height[i] * (own[i] - before[i]));
                *places = lanes(|i| start[i] + smaller(first[i] + along, columns));
                (so_far, before) = (next, own);
                along += 1.0;
            }
            self.scatter(&places, &parts);
        }
    }

    /// Adds to sums. Not inlined: otherwise the compiler would scalarise its callers.
    #[inline(never)]
    fn scatter(&mut self, places: &[[f64; LANES]; TOGETHER], parts: &[[f64; LANES]; TOGETHER]) {
        for (place, part) in places.as_flattened().iter().zip(parts.as_flattened()) {
            if let Some(sum) = self.sums.get_mut(*place as u32 as usize) {
                *sum += part;
            }
        }
    }
}

/// Pieces of edges within one row.
struct Piece {
    left: [f64; LANES],
    right: [f64; LANES],
    wide: [f64; LANES],
    /// Half of one over it.
    per_wide: [f64; LANES],
}

impl Piece {
    /// The mean distance of a point to the right of the piece.
    #[inline(always)]
    fn beyond(&self, place: &[f64; LANES]) -> [f64; LANES] {
        let within: [f64; LANES] = lanes(|i| smaller(larger(place[i] - self.left[i], 0.0), self.wide[i]));
        lanes(|i| within[i] * within[i] * self.per_wide[i] + larger(place[i] - self.right[i], 0.0))
    }
}

/// Edges from their lower ends to their upper ends.
struct Slants {
    foot: [f64; LANES],
    head: [f64; LANES],
    left: [f64; LANES],
    right: [f64; LANES],
    bottom: [f64; LANES],
    per_height: [f64; LANES],
}

impl Slants {
    /// Their positions at a height, clamped to their ends against rounding.
    #[inline(always)]
    fn at(&self, y: &[f64; LANES]) -> [f64; LANES] {
        let along: [f64; LANES] = lanes(|i| smaller((y[i] - self.bottom[i]) * self.per_height[i], 1.0));
        let x: [f64; LANES] = lanes(|i| self.foot[i] + along[i] * (self.head[i] - self.foot[i]));
        lanes(|i| smaller(larger(x[i], self.left[i]), self.right[i]))
    }
}

/// Folded in half until one is left.
#[inline(always)]
fn largest(lanes: &[f64; LANES]) -> f64 {
    let mut lanes = *lanes;
    let mut width = LANES;
    while width > 1 {
        width /= 2;
        for lane in 0..width {
            lanes[lane] = larger(lanes[lane], lanes[lane + width]);
        }
    }
    lanes[0]
}

/// The smaller number as by vector instructions, without NaN handling.
#[inline(always)]
pub fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

#[inline(always)]
pub fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_fall_into_the_rows_from_the_first_on() {
        let mut coverage = Coverage::new(4, 5, 3);
        for (place, amount) in
            [([1.5, 6.2], 2.0), ([3.9, 5.0], 1.0), ([0.5, 4.9], 7.0), ([0.5, 8.0], 7.0), ([-0.1, 6.0], 7.0)]
        {
            coverage.point(place, amount);
        }
        let mut values = [0.0; 12];
        let total = coverage.fill(&mut values);
        let mut expected = [0.0; 12];
        (expected[3], expected[5]) = (1.0, 2.0);
        assert_eq!((values, total, coverage.span()), (expected, 3.0, [5.0, 8.0]));
    }
}
