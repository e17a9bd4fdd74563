//! The brightness of light on a screen, after a liquid's surface has bent it: every patch of the surface spreads its light evenly
//! over the patch of the screen that it lands on, also where patches fold over each other.
//!
//! A patch with signed area a on the screen covers its pixels with its light over a. Coverage is summed along
//! edges: an edge gives every pixel to its right the height that it spans in the pixel's row, times the difference of the two patches
//! that it parts. Sums along the rows are then the light, and what a patch sends is what arrives.

use rayon::prelude::*;

/// Rows of pixels that are lit together.
const BAND: usize = 64;
/// Patches smaller than this part of their own size on the surface light one pixel.
const POINT: f64 = 1e-9;

/// Rays through a lattice of places on a surface, row by row. Lengths are in pixels of the screen, from the outer corner of its first
/// one.
#[derive(Clone, Copy, Debug)]
pub struct Rays<'a> {
    /// Places along a row, and rows; two of each at least.
    pub counts: [usize; 2],
    /// Where the first place stands.
    pub first: [f64; 2],
    /// From place to place.
    pub step: [f64; 2],
    /// Slopes of the surface's depth at every place, along a row and from row to row.
    pub slopes: [&'a [f32]; 2],
    /// What a slope of 1 displaces the light by, against the slope.
    pub throw: [f64; 2],
}

/// Where the light went, with the undisturbed light of a pixel as 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Light {
    /// Of all rays.
    pub sent: f64,
    /// On the screen.
    pub landed: f64,
    /// Whether rays cross before the screen, of patches whose rows reach it: there are caustics.
    pub crosses: bool,
}

impl Rays<'_> {
    /// Light that a patch sends.
    fn patch(&self) -> f64 {
        self.step[0] * self.step[1]
    }

    fn sent(&self) -> f64 {
        self.patch() * ((self.counts[0] - 1) * (self.counts[1] - 1)) as f64
    }

    fn row(&self, row: usize, landings: &mut Vec<[f64; 2]>) {
        let columns = self.counts[0];
        let [x, y] = self.slopes.map(|slopes| &slopes[row * columns..][..columns]);
        let height = self.first[1] + self.step[1] * row as f64;
        landings.clear();
        landings.extend(x.iter().zip(y).enumerate().map(|(i, (&x, &y))| {
            let place = self.first[0] + self.step[0] * i as f64;
            [place - self.throw[0] * f64::from(x), height - self.throw[1] * f64::from(y)]
        }));
    }

    fn reach(&self) -> Reach {
        let columns = self.counts[0];
        let span = |place: f64, step: f64, throw: f64, slopes: &mut dyn Iterator<Item = f32>| {
            let landings =
                (0..).zip(slopes).map(|(i, slope)| place + step * f64::from(i) - throw * f64::from(slope));
            landings.fold([f64::MAX, f64::MIN], |[low, high], x| [low.min(x), high.max(x)])
        };
        let [x, y] = self.slopes;
        let lines = x
            .chunks(columns)
            .map(|x| span(self.first[0], self.step[0], self.throw[0], &mut x.iter().copied()));
        let rows = y.chunks(columns).enumerate().map(|(row, y)| {
            span(self.first[1] + self.step[1] * row as f64, 0.0, self.throw[1], &mut y.iter().copied())
        });
        let rows: Vec<_> = rows.collect();
        Reach { whole: [widest(lines), widest(rows.iter().copied())], rows }
    }
}

/// From where to where rays land.
struct Reach {
    /// Along a row, and from row to row.
    whole: [[f64; 2]; 2],
    /// From row to row, of every row of rays.
    rows: Vec<[f64; 2]>,
}

fn widest(spans: impl Iterator<Item = [f64; 2]>) -> [f64; 2] {
    spans.fold([f64::MAX, f64::MIN], |[low, high], span| [low.min(span[0]), high.max(span[1])])
}

/// Lights a screen of pixels, row by row, `columns` in a row, by lattices of rays that cover a surface side by side: the `values` become
/// 1 where light is undisturbed.
///
/// # Panics
/// No pixels, fewer than two rows or columns of rays, or slopes that are not one per ray.
pub fn light(lattices: &[Rays<'_>], columns: usize, values: &mut [f32]) -> Light {
    for rays in lattices {
        let places = rays.counts[0] * rays.counts[1];
        assert!(rays.counts.iter().all(|&count| count > 1), "no patches: {:?}", rays.counts);
        assert!(rays.slopes.iter().all(|slopes| slopes.len() == places), "a slope for every ray");
    }
    let reaches: Vec<_> = lattices.par_iter().map(Rays::reach).collect();
    let bands: Vec<_> = values
        .par_chunks_mut(BAND * columns)
        .enumerate()
        .map(|(index, values)| {
            let mut band = Band::new(columns, index * BAND, values.len() / columns);
            for (rays, reach) in lattices.iter().zip(&reaches) {
                band.light(rays, reach);
            }
            (band.fill(values), band.crosses)
        })
        .collect();
    Light {
        sent: lattices.iter().map(Rays::sent).sum(),
        landed: bands.iter().map(|(landed, _)| landed).sum(),
        crosses: bands.iter().any(|(_, crosses)| *crosses),
    }
}

/// Light over area of the lower and the upper half of a patch, which meet in the diagonal from its first corner; alike where it does
/// not fold.
type Density = [f64; 2];

/// Some rows of pixels.
struct Band {
    columns: usize,
    first: f64,
    rows: usize,
    /// From one row of sums to the next: room for what lies beyond the last column.
    stride: usize,
    /// What every pixel adds to those left of it.
    sums: Vec<f64>,
    crosses: bool,
}

impl Band {
    fn new(columns: usize, first: usize, rows: usize) -> Self {
        let stride = columns + 3;
        Self { columns, first: first as f64, rows, stride, sums: vec![0.0; stride * rows], crosses: false }
    }

    /// Adds the light of all patches that reach these rows.
    fn light(&mut self, rays: &Rays<'_>, reach: &Reach) {
        let (low, high) = (self.first, self.first + self.rows as f64);
        let meets = |span: [f64; 2], ends: [f64; 2]| span[0] < ends[1] && span[1] > ends[0];
        if !meets(reach.whole[1], [low, high]) || !meets(reach.whole[0], [0.0, self.columns as f64]) {
            return;
        }
        let reaches = |pair: &[[f64; 2]]| meets(widest(pair.iter().copied()), [low, high]);
        let mut reached = reach.rows.windows(2).map(reaches);
        let patches = rays.counts[0] - 1;
        let none = vec![[0.0; 2]; patches];
        let (mut below, mut own) = (none.clone(), none.clone());
        let [mut lower, mut upper] = [const { Vec::new() }; 2];
        // Edges are shared: those between rows of patches belong to the upper row, the last of a run to none.
        let mut is_open = false;
        for row in 0..rays.counts[1] {
            let is_reached = reached.next().unwrap_or(false);
            if !is_reached && !is_open {
                continue;
            }
            if is_open {
                std::mem::swap(&mut lower, &mut upper);
            } else {
                rays.row(row, &mut lower);
                below.copy_from_slice(&none);
            }
            if is_reached {
                rays.row(row + 1, &mut upper);
                self.densities(rays.patch(), [&lower, &upper], &mut own);
            } else {
                own.copy_from_slice(&none);
            }
            for (i, edge) in lower.windows(2).enumerate() {
                self.edge(edge[0], edge[1], own[i][0] - below[i][1]);
            }
            if is_reached {
                for (i, (&from, &to)) in lower.iter().zip(&upper).enumerate() {
                    let before = if i > 0 { own[i - 1][0] } else { 0.0 };
                    let after = own.get(i).map_or(0.0, |own| own[1]);
                    self.edge(from, to, before - after);
                }
                for (i, own) in own.iter().enumerate().filter(|(_, [lower, upper])| lower != upper) {
                    self.edge(lower[i], upper[i + 1], own[1] - own[0]);
                }
            }
            std::mem::swap(&mut below, &mut own);
            is_open = is_reached;
        }
    }

    /// The densities of a row of patches between two rows of landings. Halves without area light a pixel here and now.
    fn densities(&mut self, light: f64, [lower, upper]: [&[[f64; 2]]; 2], densities: &mut [Density]) {
        let patches = lower.windows(2).zip(upper.windows(2));
        for ((below, above), density) in patches.zip(densities) {
            let (a, b, c, d) = (below[0], below[1], above[1], above[0]);
            let [first, second] = [twice_area(a, b, c), twice_area(a, c, d)];
            if first > 0.0 && second > 0.0 && first + second > 2.0 * POINT * light {
                *density = [2.0 * light / (first + second); 2];
                continue;
            }
            self.crosses |= first + second <= 0.0;
            if first < 0.0 && second < 0.0 && first + second < -2.0 * POINT * light {
                *density = [2.0 * light / (first + second); 2];
                continue;
            }
            *density = [(first, [a, b, c]), (second, [a, c, d])].map(|(area, corners)| {
                if area.abs() > POINT * light {
                    return light / area;
                }
                let centre = [0, 1].map(|axis| corners.iter().map(|corner| corner[axis]).sum::<f64>() / 3.0);
                self.point(centre, light / 2.0);
                0.0
            });
        }
    }

    /// Adds light at a place.
    fn point(&mut self, [x, y]: [f64; 2], light: f64) {
        let row = y - self.first;
        if (0.0..self.rows as f64).contains(&row) && (0.0..self.columns as f64).contains(&x) {
            let place = row as usize * self.stride + x as usize;
            self.sums[place] += light;
            self.sums[place + 1] -= light;
        }
    }

    /// Adds an edge: `density` times the height that it spans of every row, to the left of it with the sign of its direction
    /// upwards. What lies to its right ends up with that much less.
    fn edge(&mut self, from: [f64; 2], to: [f64; 2], density: f64) {
        let (from_y, to_y) = (from[1] - self.first, to[1] - self.first);
        let (bottom, top) = if from_y < to_y { (from_y, to_y) } else { (to_y, from_y) };
        let (left, right) = if from[0] < to[0] { (from[0], to[0]) } else { (to[0], from[0]) };
        let (low, high) = (bottom.max(0.0), top.min(self.rows as f64));
        if low >= high || left >= self.columns as f64 {
            return;
        }
        let sign = if to_y > from_y { -density } else { density };
        let mut row = low as u32 as usize;
        if low == bottom && high == top && high <= (row + 1) as f64 {
            return self.piece(row, [left, right], sign * (high - low));
        }
        let per_row = (to[0] - from[0]) / (to_y - from_y);
        // Rounding must not carry a piece beyond its edge.
        let at = |y: f64| (from[0] + (y - from_y) * per_row).max(left).min(right);
        let (mut bottom, mut x) = (low, at(low));
        while bottom < high {
            let top = ((row + 1) as f64).min(high);
            let next = at(top);
            self.piece(row, if x < next { [x, next] } else { [next, x] }, sign * (top - bottom));
            (bottom, x) = (top, next);
            row += 1;
        }
    }

    /// Adds a piece of an edge in one row, from `left` to `right`: `height` to the part of every pixel that lies to the right of it.
    #[inline]
    fn piece(&mut self, row: usize, [left, right]: [f64; 2], height: f64) {
        if left >= self.columns as f64 {
            return;
        }
        let sums = &mut self.sums[row * self.stride..][..self.stride];
        // Negative ones become 0.
        let column = left as u32;
        let (first, column) = (f64::from(column), column as usize);
        let width = (right - left).max(f64::MIN_POSITIVE);
        if left >= 0.0 && right <= first + 2.0 {
            let Some([this, next, rest]) = sums.get_mut(column..column + 3) else { return };
            let (one, middle) = (first + 1.0, 0.5 * (left + right));
            // Parts to the right of the piece, of this pixel and of the next.
            let over = (right - one).max(0.0);
            let of_this = one - middle + over * over / (2.0 * width);
            let of_next = one + 1.0 - middle - of_this;
            *this += height * of_this;
            *next += height * (of_next - of_this);
            *rest += height * (1.0 - of_next);
            return;
        }
        // The mean over the piece of how far a place lies to the right of it.
        let beyond = |place: f64| {
            if place <= left {
                0.0
            } else if place >= right {
                place - 0.5 * (left + right)
            } else {
                (place - left) * (place - left) / (2.0 * width)
            }
        };
        let (mut before, mut so_far) = (0.0, beyond(first));
        for (i, sum) in sums[column..].iter_mut().enumerate() {
            let next = beyond(first + (i + 1) as f64);
            let own = next - so_far;
            *sum += height * (own - before);
            (before, so_far) = (own, next);
            if first + i as f64 >= right {
                break;
            }
        }
    }

    /// The light of every pixel, and all of it.
    fn fill(&self, values: &mut [f32]) -> f64 {
        let mut landed = 0.0;
        for (values, sums) in values.chunks_exact_mut(self.columns).zip(self.sums.chunks_exact(self.stride)) {
            let mut light = 0.0;
            for (value, sum) in values.iter_mut().zip(sums) {
                light += sum;
                landed += light;
                // Rounding leaves less than nothing where there is none.
                *value = light.max(0.0) as f32;
            }
        }
        landed
    }
}

fn twice_area(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])
}
