//! The brightness of light on a screen behind a curved liquid surface: every patch of the surface spreads its light
//! evenly over its image on the screen, also where patches fold over each other.
//!
//! A patch with signed area a on the screen covers its pixels with its light over a. [`Coverage`] sums along edges,
//! eight at a time, each with the difference of its two adjacent patches, row by row of pixels: folds are areas of
//! opposite sign, and light is conserved. Bands of rows are independent and sums have a fixed order, so the result
//! does not depend on the number of threads.

use rayon::prelude::*;

use crate::simd::{Instructions, Isa, Kernel, lanes};
use crate::surface::coverage::{Coverage, Edges, Places, larger, smaller};

/// Rows of pixels processed together.
const BAND: usize = 64;
/// Patches smaller than this fraction of their size on the surface light a single pixel.
const POINT: f64 = 1e-9;

/// Rays through a lattice of points on a surface, row by row. Lengths are in pixels of the screen, from the outer
/// corner of its first pixel.
#[derive(Clone, Copy, Debug)]
pub struct Rays<'a> {
    /// Points per row, and rows; at least two of each.
    pub counts: [usize; 2],
    /// Position of the first point.
    pub first: [f64; 2],
    /// Between neighbouring points.
    pub step: [f64; 2],
    /// Slopes of the surface's depth at every point, along a row and from row to row.
    pub slopes: [&'a [f32]; 2],
    /// Displacement of the light per unit slope, against the slope.
    pub throw: [f64; 2],
}

/// The light on the screen, in units of the undisturbed light of a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Light {
    /// Light of all rays.
    pub sent: f64,
    /// Light on the screen.
    pub landed: f64,
    /// Whether rays cross before the screen, in patches whose rows reach it: there are caustics.
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

    /// Landing points of all rays.
    fn landings(&self) -> Landings {
        let count = self.counts[0] * self.counts[1];
        let mut landings = Landings {
            places: Places { x: vec![0.0; count], y: vec![0.0; count] },
            rows: Vec::with_capacity(self.counts[1]),
            columns: NOWHERE,
        };
        Isa::best().run(Landing { rays: self, landings: &mut landings });
        landings
    }
}

/// A range; `NOWHERE` if empty.
type Span = [f64; 2];
const NOWHERE: Span = [f64::INFINITY, f64::NEG_INFINITY];

/// Landing points of rays, row by row.
struct Landings {
    places: Places,
    /// Span of every row of rays, from row to row of pixels.
    rows: Vec<Span>,
    /// Span of all rays along a row of pixels.
    columns: Span,
}

fn widest(spans: impl IntoIterator<Item = Span>) -> Span {
    spans.into_iter().fold(NOWHERE, |[low, high], span| [smaller(low, span[0]), larger(high, span[1])])
}

fn meets(span: Span, ends: Span) -> bool {
    span[0] < ends[1] && span[1] > ends[0]
}

/// Lets rays land.
struct Landing<'a, 'b> {
    rays: &'a Rays<'b>,
    landings: &'a mut Landings,
}

impl Kernel for Landing<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<I: Instructions>(self) {
        let Self { rays: Rays { counts: [columns, _], first, step, slopes, throw }, landings } = self;
        let Landings { places, rows, columns: whole } = landings;
        let slopes = slopes[0].chunks_exact(*columns).zip(slopes[1].chunks_exact(*columns));
        let places = places.x.chunks_exact_mut(*columns).zip(places.y.chunks_exact_mut(*columns));
        for (row, ((slope_x, slope_y), (x, y))) in slopes.zip(places).enumerate() {
            for ((i, x), slope) in (0i32..).zip(&mut *x).zip(slope_x) {
                *x = first[0] + step[0] * f64::from(i) - throw[0] * f64::from(*slope);
            }
            let height = first[1] + step[1] * row as f64;
            for (y, slope) in y.iter_mut().zip(slope_y) {
                *y = height - throw[1] * f64::from(*slope);
            }
            rows.push(span(y));
            *whole = widest([*whole, span(x)]);
        }
    }
}

/// The span of some places.
#[inline(always)]
fn span(places: &[f64]) -> Span {
    const LANES: usize = 8;
    let (runs, rest) = places.as_chunks::<LANES>();
    let (mut low, mut high) = ([NOWHERE[0]; LANES], [NOWHERE[1]; LANES]);
    for run in runs {
        low = lanes(|i| smaller(low[i], run[i]));
        high = lanes(|i| larger(high[i], run[i]));
    }
    let own = widest(low.into_iter().zip(high).map(|(low, high)| [low, high]));
    rest.iter().fold(own, |[low, high], &place| [smaller(low, place), larger(high, place)])
}

/// Lights a screen of pixels, row by row with `columns` per row, by lattices of rays that cover a surface side by
/// side: `values` of 1 are undisturbed light.
///
/// # Panics
/// No pixels, fewer than two rows or columns of rays, or numbers of slopes and rays that differ.
pub fn light(lattices: &[Rays<'_>], columns: usize, values: &mut [f32]) -> Light {
    for rays in lattices {
        let places = rays.counts[0] * rays.counts[1];
        assert!(rays.counts.iter().all(|&count| count > 1), "no patches: {:?}", rays.counts);
        assert!(rays.slopes.iter().all(|slopes| slopes.len() == places), "a slope for every ray");
    }
    let landings: Vec<_> = lattices.par_iter().map(Rays::landings).collect();
    let bands: Vec<_> = values
        .par_chunks_mut(BAND * columns)
        .enumerate()
        .map(|(index, values)| {
            let mut band = Band::new(columns, index * BAND, values.len() / columns);
            for (rays, landings) in lattices.iter().zip(&landings) {
                band.light(rays, landings, columns);
            }
            (band.coverage.fill(values), band.crosses)
        })
        .collect();
    Light {
        sent: lattices.iter().map(Rays::sent).sum(),
        landed: bands.iter().map(|(landed, _)| landed).sum(),
        crosses: bands.iter().any(|(_, crosses)| *crosses),
    }
}

/// Some rows of pixels, with the working data of rows of rays.
struct Band {
    coverage: Coverage,
    crosses: bool,
    /// Densities of this row of patches, and of the one below.
    own: Densities,
    below: Densities,
    /// Differences at the edges of a row.
    parted: Vec<f64>,
}

/// Light per area of the lower and the upper half of every patch of a row, separated by the diagonal from its first
/// corner; equal unless the patch folds. One more entry stands for the outside.
#[derive(Default)]
struct Densities {
    lower: Vec<f64>,
    upper: Vec<f64>,
}

impl Densities {
    fn clear(&mut self, patches: usize) {
        for half in [&mut self.lower, &mut self.upper] {
            half.clear();
            half.resize(patches + 1, 0.0);
        }
    }
}

impl Band {
    fn new(columns: usize, first: usize, rows: usize) -> Self {
        Self {
            coverage: Coverage::new(columns, first, rows),
            crosses: false,
            own: Densities::default(),
            below: Densities::default(),
            parted: Vec::new(),
        }
    }

    /// Adds the light of all patches that reach these rows of pixels.
    fn light(&mut self, rays: &Rays<'_>, landings: &Landings, columns: usize) {
        let rows = self.coverage.span();
        if !meets(landings.columns, [0.0, columns as f64]) {
            return;
        }
        let width = rays.counts[0];
        let row = |row: usize| landings.places.part(row * width..(row + 1) * width);
        // Edges are shared: those between rows of patches belong to the upper row; the last row of a run has none.
        let mut is_open = false;
        for (i, spans) in landings.rows.iter().enumerate() {
            let above = landings.rows.get(i + 1);
            let is_reached = above.is_some_and(|above| meets(widest([*spans, *above]), rows));
            if !is_reached && !is_open {
                continue;
            }
            if is_open {
                std::mem::swap(&mut self.below, &mut self.own);
            } else {
                self.below.clear(width - 1);
            }
            self.own.clear(width - 1);
            if is_reached {
                self.densities(row(i), row(i + 1), rays.patch());
            }
            self.along(row(i));
            if is_reached {
                self.across(row(i), row(i + 1));
            }
            is_open = is_reached;
        }
    }

    /// The edges along the lower side of the patches.
    fn along(&mut self, Places { x, y }: Places<&[f64]>) {
        let end = x.len() - 1;
        self.parted.clear();
        let pairs = self.own.lower.iter().zip(&self.below.upper);
        self.parted.extend(pairs.take(end).map(|(above, below)| above - below));
        self.coverage.edges(&Edges {
            from: [&x[..end], &y[..end]],
            to: [&x[1..], &y[1..]],
            density: &self.parted,
        });
    }

    /// The edges between patches, and within those that fold.
    fn across(&mut self, lower: Places<&[f64]>, upper: Places<&[f64]>) {
        let Self { coverage, own, parted, .. } = self;
        let before = std::iter::once(&0.0).chain(&own.lower);
        parted.clear();
        parted.extend(before.zip(&own.upper).map(|(before, after)| before - after));
        coverage.edges(&Edges { from: [lower.x, lower.y], to: [upper.x, upper.y], density: parted });
        for (i, (below, above)) in own.lower.iter().zip(&own.upper).enumerate() {
            if below != above {
                let [from, to] = [lower.of(i), upper.of(i + 1)].map(|place| place.map(|place| [place]));
                coverage.edges(&Edges {
                    from: [&from[0], &from[1]],
                    to: [&to[0], &to[1]],
                    density: &[above - below],
                });
            }
        }
    }

    /// The densities of the patches between two rows of landings. Halves without area light a pixel here and now.
    fn densities(&mut self, lower: Places<&[f64]>, upper: Places<&[f64]>, light: f64) {
        let own = &mut self.own;
        Isa::best().run(Spread { lower, upper, light, densities: own });
        for i in 0..own.lower.len() - 1 {
            if own.lower[i] > 0.0 {
                continue;
            }
            let corners = [lower.of(i), lower.of(i + 1), upper.of(i + 1), upper.of(i)];
            let [a, b, c, d] = corners;
            let [first, second] = [twice_area(a, b, c), twice_area(a, c, d)];
            self.crosses |= first + second <= 0.0;
            if first < 0.0 && second < 0.0 && first + second < -2.0 * POINT * light {
                let density = 2.0 * light / (first + second);
                (own.lower[i], own.upper[i]) = (density, density);
                continue;
            }
            [own.lower[i], own.upper[i]] =
                [(first, [a, b, c]), (second, [a, c, d])].map(|(area, corners)| {
                    if area.abs() > POINT * light {
                        return light / area;
                    }
                    let centre =
                        [0, 1].map(|axis| corners.iter().map(|corner| corner[axis]).sum::<f64>() / 3.0);
                    self.coverage.point(centre, light / 2.0);
                    0.0
                });
        }
    }
}

/// The densities of unfolded patches; folded ones have zero.
struct Spread<'a> {
    lower: Places<&'a [f64]>,
    upper: Places<&'a [f64]>,
    light: f64,
    densities: &'a mut Densities,
}

impl Kernel for Spread<'_> {
    type Output = ();

    #[inline(always)]
    fn run<I: Instructions>(self) {
        let Self { lower, upper, light, densities } = self;
        let patches = lower.x.len() - 1;
        let Densities { lower: own, upper: same } = densities;
        let (own, same) = (&mut own[..patches], &mut same[..patches]);
        let [ax, ay] = [&lower.x[..patches], &lower.y[..patches]];
        let [bx, by] = [&lower.x[1..=patches], &lower.y[1..=patches]];
        let [cx, cy] = [&upper.x[1..=patches], &upper.y[1..=patches]];
        let [dx, dy] = [&upper.x[..patches], &upper.y[..patches]];
        for i in 0..patches {
            let first = twice_area([ax[i], ay[i]], [bx[i], by[i]], [cx[i], cy[i]]);
            let second = twice_area([ax[i], ay[i]], [cx[i], cy[i]], [dx[i], dy[i]]);
            let is_flat = (first > 0.0) & (second > 0.0) & (first + second > 2.0 * POINT * light);
            own[i] = if is_flat { 2.0 * light / (first + second) } else { 0.0 };
            same[i] = own[i];
        }
    }
}

#[inline(always)]
fn twice_area(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIDE: usize = 16;

    /// The screen under a patch whose rays land on these corners, around the patch.
    fn lit([a, b, c, d]: [[f64; 2]; 4]) -> (Vec<f32>, Light) {
        let lands = [a, b, d, c];
        let rests = [[0.0, 0.0], [4.0, 0.0], [0.0, 4.0], [4.0, 4.0]];
        let slopes = [0, 1].map(|axis| {
            rests.iter().zip(lands).map(|(rest, land)| (rest[axis] - land[axis]) as f32).collect::<Vec<_>>()
        });
        let rays = Rays {
            counts: [2, 2],
            first: [0.0, 0.0],
            step: [4.0, 4.0],
            slopes: [&slopes[0], &slopes[1]],
            throw: [1.0, 1.0],
        };
        let mut values = vec![0.0; SIDE * SIDE];
        let light = light(&[rays], SIDE, &mut values);
        (values, light)
    }

    #[test]
    fn a_patch_lights_its_image_evenly_whichever_way_it_is_turned() {
        let corners = [[2.0, 2.0], [11.0, 3.0], [13.0, 12.0], [3.0, 7.0]];
        let area = 62.0;
        let is_inside =
            |point: [f64; 2]| (0..4).all(|i| twice_area(corners[i], corners[(i + 1) % 4], point) >= 0.0);
        for is_mirrored in [false, true] {
            // One half is larger than the other, or smaller.
            for turn in 0..4 {
                let mut image = [0, 1, 2, 3].map(|i| corners[(i + turn) % 4]);
                if is_mirrored {
                    image.reverse();
                }
                let (values, light) = lit(image);
                assert_eq!(light.crosses, is_mirrored, "{image:?}");
                assert!(light.sent == 16.0 && (light.landed - 16.0).abs() < 1e-5, "{image:?}: {light:?}");
                let mut inside = 0;
                for (i, value) in values.iter().enumerate() {
                    let (x, y) = ((i % SIDE) as f64, (i / SIDE) as f64);
                    let ends = [[x, y], [x + 1.0, y], [x, y + 1.0], [x + 1.0, y + 1.0]];
                    if ends.into_iter().all(is_inside) {
                        inside += 1;
                        let off = f64::from(*value) - 16.0 / area;
                        assert!(off.abs() < 1e-5, "{image:?}: {value} in {x}, {y}");
                    }
                }
                assert!(inside > 30, "{inside} pixels");
            }
        }
    }

    const NARROW: usize = 8;

    #[test]
    fn a_patch_that_shrinks_or_turns_over_keeps_its_light_and_its_place() {
        let slopes = [[0.0, 1.0, 0.0, 1.0], [0.0, 0.0, 1.0, 1.0]];
        for size in [0.9, 0.3, 0.01, 1e-4, 1e-5, 1e-8, 1e-11, 1e-13] {
            for sign in [1.0, -1.0] {
                // Of its image, 3/10 lie to the left of x = 4, or of its mirror image.
                let first = if sign > 0.0 { 4.0 - 0.3 * size } else { 4.0 + 0.7 * size };
                let rays = Rays {
                    counts: [2, 2],
                    first: [first, 3.05],
                    step: [1.0, 1.0],
                    slopes: [&slopes[0], &slopes[1]],
                    throw: [1.0 - sign * size, 1.0 - size],
                };
                let mut values = vec![0.0; NARROW * NARROW];
                let light = light(&[rays], NARROW, &mut values);
                let own = [values[3 * NARROW + 3], values[3 * NARROW + 4]].map(f64::from);
                assert_eq!(light.crosses, sign < 0.0, "{sign} {size}");
                assert!((light.landed - 1.0).abs() < 1e-6, "{sign} {size}: {light:?}");
                assert!((own[0] + own[1] - 1.0).abs() < 1e-6, "{sign} {size}: {values:?}");
                // The smallest count as two points.
                if size > 1e-3 {
                    assert!((own[0] - 0.3).abs() < 1e-6, "{sign} {size}: {own:?}");
                }
            }
        }
    }
}
