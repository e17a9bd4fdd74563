//! Areas (filled shapes, broad strokes, pictures) as rasters of the prescribed |p|².

use std::ops::Range;

use glam::{DVec2, DVec3};

use crate::scene::range::{KeyError, refuse};
use crate::scene::stroke;
use crate::scene::target::{Sampling, Target};
use crate::scene::{content::Scene, motion, solver::Method, turns::Turns};
use crate::scene::{pixels, pixels::Grey};
use std::ops::RangeInclusive;

/// Pixels of a raster in a wavelength, of its longer side at least, and of a side at most.
const PER_WAVELENGTH: f64 = 16.0;
const FEWEST: f64 = 16.0;
const MOST: f64 = 512.0;
/// Scan lines per pixel, with exact ends.
const LINES: usize = 4;
/// Tolerance for the vertices of a planar path, in m and relative to its extent.
const FLAT: f64 = 1e-4;
const FLAT_PART: f64 = 1e-3;

/// An area of the scene as a raster of target brightness, 0 to 1, in its own plane.
#[derive(Clone, Debug, PartialEq)]
pub struct Cover {
    /// Target pressure at brightness 1.
    pub pressure: f64,
    /// m, the middle of the raster.
    pub centre: DVec3,
    /// Unit vectors along the raster's rows and up its columns.
    pub axes: [DVec3; 2],
    /// m, half the sides of the raster.
    pub half: DVec2,
    counts: [usize; 2],
    /// Sums of brightness over all pixels below and to the left of a corner, row by row from the lowest.
    sums: Vec<f64>,
    /// The target brightness is 1 wherever covered.
    is_plain: bool,
}

/// A part of an area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// Centre of its covered part, m.
    pub at: DVec3,
    /// Target brightness, 0 to 1.
    pub brightness: f64,
}

impl Cover {
    /// The area of a target; `None` if the target is not an area.
    ///
    /// # Errors
    /// A path that is not planar or has no inside, a missing glyph, or a picture that is black or not loaded.
    pub fn new(target: &Target, wavelength: f64) -> Result<Option<Self>, KeyError> {
        let cover = match (target.shape.picture(), target.sampling) {
            (Some((_, width, pixels)), _) => {
                let Some(grey) = pixels.get() else { return refuse("file", "the picture is not loaded") };
                Self::of_picture(target, grey, DVec2::new(width, width * pixels.aspect()))
            }
            (_, Sampling::Fill) => Self::of_strokes(target, 0.0, wavelength)?,
            (_, Sampling::Stroke(width)) => Self::of_strokes(target, width, wavelength)?,
            (_, Sampling::Whole | Sampling::Continuous | Sampling::Spacing(_) | Sampling::Points(_)) => {
                return Ok(None);
            }
        };
        let is_black = cover.sums.last().is_none_or(|&sum| sum <= 0.0);
        if is_black && target.shape.is_picture() {
            return refuse("file", "the picture is black: it prescribes no sound");
        }
        if is_black && target.shape.is_path() && target.sampling == Sampling::Fill {
            return refuse("fill", "the path encloses no area");
        }
        Ok(Some(cover))
    }

    /// A black margin is cropped: the surroundings are quiet anyway.
    fn of_picture(target: &Target, grey: &Grey, size: DVec2) -> Self {
        let axes = [DVec3::X, DVec3::Y].map(|axis| target.turn() * axis);
        let width = grey.width.max(1);
        let rows: Vec<_> = grey.brightness.chunks_exact(width).rev().collect();
        let is_bright = |brightness: &f32| *brightness > 0.0;
        let [columns, rows_kept] = [
            bounds((0..width).map(|column| rows.iter().any(|row| is_bright(&row[column])))),
            bounds(rows.iter().map(|row| row.iter().any(is_bright))),
        ];
        let kept = rows[rows_kept.clone()].iter().flat_map(|row| &row[columns.clone()]);
        let brightness: Vec<_> = kept.map(|brightness| f64::from(brightness.clamp(0.0, 1.0))).collect();
        let pixel = size / DVec2::new(grey.width as f64, grey.height as f64);
        let ends = |start: usize, end: usize| 0.5 * (start + end) as f64;
        let middle = DVec2::new(ends(columns.start, columns.end), ends(rows_kept.start, rows_kept.end));
        let from_centre = middle * pixel - size / 2.0;
        let counts = [columns.len(), rows_kept.len()];
        Self {
            pressure: target.pressure,
            centre: target.shape.centre() + axes[0] * from_centre.x + axes[1] * from_centre.y,
            axes,
            half: DVec2::new(counts[0] as f64, counts[1] as f64) * pixel / 2.0,
            counts,
            sums: sums(counts, &brightness),
            is_plain: false,
        }
    }

    /// The area within half of `width` (m) of the outline, or inside it where that is 0.
    fn of_strokes(target: &Target, width: f64, wavelength: f64) -> Result<Self, KeyError> {
        let strokes = stroke::strokes(target)?;
        let middle = target.shape.centre();
        let axes = if target.shape.is_line() || target.shape.is_path() {
            plane_of(&strokes.concat())?
        } else {
            [DVec3::X, DVec3::Y].map(|axis| target.turn() * axis)
        };
        let flat = |point: &DVec3| DVec2::from(axes.map(|axis| (*point - middle).dot(axis)));
        let flat: Vec<Vec<_>> = strokes.iter().map(|stroke| stroke.iter().map(flat).collect()).collect();
        let points = || flat.iter().flatten().copied();
        let low = points().reduce(DVec2::min).unwrap_or_default() - width / 2.0;
        let high = points().reduce(DVec2::max).unwrap_or_default() + width / 2.0;
        let (size, corner) = (high - low, low);
        let longest = size.max_element();
        let pixel = (wavelength / PER_WAVELENGTH).min(longest / FEWEST).max(longest / MOST);
        let counts = (size / pixel).to_array().map(|count| (count.ceil() as usize).max(1));
        let size = DVec2::new(counts[0] as f64, counts[1] as f64) * pixel;
        // In pixels from the lower left corner.
        let placed = |stroke: &Vec<DVec2>| stroke.iter().map(|&point| (point - corner) / pixel).collect();
        let placed: Vec<Vec<DVec2>> = flat.iter().map(placed).collect();
        let brightness =
            if width > 0.0 { broad(counts, &placed, width / pixel) } else { filled(counts, &placed) };
        let on_plane = corner + size / 2.0;
        Ok(Self {
            pressure: target.pressure,
            centre: middle + axes[0] * on_plane.x + axes[1] * on_plane.y,
            axes,
            half: size / 2.0,
            counts,
            sums: sums(counts, &brightness),
            is_plain: true,
        })
    }

    /// A point (m) projected onto the area's plane, relative to the raster's centre.
    pub fn flat(&self, point: DVec3) -> DVec2 {
        DVec2::from(self.axes.map(|axis| (point - self.centre).dot(axis)))
    }

    /// A point of the area's plane (m from the raster's centre) in space.
    pub fn world(&self, flat: DVec2) -> DVec3 {
        self.centre + self.axes[0] * flat.x + self.axes[1] * flat.y
    }

    /// Mean brightness, 0 to 1, of a square of side `cell` (m) of the area's plane, `at` m from the raster's middle.
    pub fn brightness(&self, at: DVec2, cell: f64) -> f64 {
        let half = DVec2::splat(cell.max(1e-3 * self.half.max_element()) / 2.0);
        let [low, high] = [at - half, at + half].map(|corner| self.pixels(corner));
        let [low, high] = [low, high].map(|place| place.to_array());
        let sum = self.sum([high[0], high[1]]) - self.sum([low[0], high[1]]) - self.sum([high[0], low[1]])
            + self.sum([low[0], low[1]]);
        let area = (high[0] - low[0]) * (high[1] - low[1]);
        (sum / area).clamp(0.0, 1.0)
    }

    /// A point in pixels from the lower left corner.
    fn pixels(&self, flat: DVec2) -> DVec2 {
        (flat + self.half) / (2.0 * self.half) * DVec2::new(self.counts[0] as f64, self.counts[1] as f64)
    }

    /// The sum over everything below and to the left of a point in pixels.
    fn sum(&self, [x, y]: [f64; 2]) -> f64 {
        let [columns, rows] = self.counts;
        let split = |place: f64, count: usize| {
            let place = place.clamp(0.0, count as f64);
            let whole = (place as usize).min(count.saturating_sub(1));
            (whole, place - whole as f64)
        };
        let ((i, x), (j, y)) = (split(x, columns), split(y, rows));
        let corner = |i: usize, j: usize| self.sums[j * (columns + 1) + i];
        let along = |j: usize| corner(i, j) * (1.0 - x) + corner(i + 1, j) * x;
        along(j) * (1.0 - y) + along(j + 1) * y
    }

    /// Patches of the area, at most `spacing` m apart: at least one.
    pub fn patches(&self, spacing: f64) -> Vec<Patch> {
        /// Relative to the brightest patch: a darker patch is merged into its neighbours, or dark.
        const LEAST: f64 = 0.25;
        const LEAST_OF_PICTURE: f64 = 0.02;
        /// Samples across a patch.
        const PLACES: usize = 4;
        let counts =
            (2.0 * self.half / spacing).to_array().map(|count| count.ceil().clamp(1.0, MOST) as usize);
        let size = 2.0 * self.half / DVec2::new(counts[0] as f64, counts[1] as f64);
        let part = |index: usize| {
            let corner =
                DVec2::new((index % counts[0]) as f64, (index / counts[0]) as f64) * size - self.half;
            let (mut sum, mut square, mut middle) = (0.0, 0.0, DVec2::ZERO);
            for place in 0..PLACES * PLACES {
                let inside = DVec2::new((place % PLACES) as f64, (place / PLACES) as f64) + 0.5;
                let at = corner + inside / PLACES as f64 * size;
                let brightness = self.brightness(at, size.min_element() / PLACES as f64);
                sum += brightness;
                square += brightness * brightness;
                middle += at * brightness;
            }
            (sum, square, middle)
        };
        let parts: Vec<_> = (0..counts[0] * counts[1]).map(part).collect();
        let most = parts.iter().map(|(sum, ..)| *sum).fold(f64::MIN_POSITIVE, f64::max);
        let least = if self.is_plain { LEAST } else { LEAST_OF_PICTURE };
        let is_kept = |(sum, ..): &&(f64, f64, DVec2)| *sum >= least * most;
        let patch = |&(sum, square, middle): &(f64, f64, DVec2)| Patch {
            at: self.world(middle / sum),
            brightness: if self.is_plain { 1.0 } else { square / sum },
        };
        parts.iter().filter(is_kept).map(patch).collect()
    }
}

/// The range from the first to the last match; the full range without a match.
fn bounds(holds: impl ExactSizeIterator<Item = bool> + DoubleEndedIterator + Clone) -> Range<usize> {
    let count = holds.len();
    let (mut from, mut back) = (holds.clone(), holds);
    match (from.position(|it| it), back.rposition(|it| it)) {
        (Some(first), Some(last)) => first..last + 1,
        (None, _) | (_, None) => 0..count,
    }
}

/// Axes of the plane of a path; as horizontal as possible for a straight path.
fn plane_of(vertices: &[DVec3]) -> Result<[DVec3; 2], KeyError> {
    let farthest = |distance: &dyn Fn(&DVec3) -> f64| {
        vertices.iter().copied().max_by(|a, b| distance(a).total_cmp(&distance(b)))
    };
    let Some(&first) = vertices.first() else { return Ok([DVec3::X, DVec3::Y]) };
    let other = farthest(&|vertex| vertex.distance(first)).unwrap_or(first);
    let along = (other - first).normalize_or(DVec3::X);
    let aside = |vertex: DVec3| (vertex - first).reject_from_normalized(along);
    let third = aside(farthest(&|vertex| aside(*vertex).length()).unwrap_or(first));
    let extent = other.distance(first);
    let level = DVec3::Z.reject_from_normalized(along).try_normalize().unwrap_or(DVec3::Y);
    let normal =
        if third.length() > FLAT_PART * extent { along.cross(third.normalize_or_zero()) } else { level };
    let normal = if normal.z < 0.0 { -normal } else { normal };
    let away = vertices.iter().map(|vertex| (*vertex - first).dot(normal).abs()).fold(0.0, f64::max);
    if away > FLAT.max(FLAT_PART * extent) {
        return refuse("vertices", "the path is not flat: an area lies in a plane");
    }
    let x = DVec3::X.reject_from_normalized(normal).try_normalize().unwrap_or(DVec3::Y);
    Ok([x, normal.cross(x)])
}

/// Prefix sums of a raster: for every pixel corner, the sum below and to the left.
fn sums([columns, rows]: [usize; 2], brightness: &[f64]) -> Vec<f64> {
    let wide = columns + 1;
    let mut sums = vec![0.0; wide * (rows + 1)];
    for row in 0..rows {
        let mut along = 0.0;
        for column in 0..columns {
            along += brightness[row * columns + column];
            sums[(row + 1) * wide + column + 1] = sums[row * wide + column + 1] + along;
        }
    }
    sums
}

/// Coverage of pixels by closed polygons, by the non-zero winding rule; in pixels.
fn filled([columns, rows]: [usize; 2], polygons: &[Vec<DVec2>]) -> Vec<f64> {
    let mut raster = vec![0.0; columns * rows];
    let mut crossings = Vec::new();
    for line in 0..rows * LINES {
        let y = (line as f64 + 0.5) / LINES as f64;
        crossings.clear();
        for polygon in polygons {
            let next = polygon.iter().cycle().skip(1);
            for (from, to) in polygon.iter().zip(next).filter(|(from, to)| (from.y <= y) != (to.y <= y)) {
                let x = from.x + (to.x - from.x) * (y - from.y) / (to.y - from.y);
                crossings.push((x, if to.y > from.y { 1 } else { -1 }));
            }
        }
        crossings.sort_by(|a: &(f64, i32), b| a.0.total_cmp(&b.0));
        let mut winding = 0;
        for pair in crossings.windows(2) {
            winding += pair[0].1;
            if winding != 0 {
                add_span(&mut raster[line / LINES * columns..][..columns], pair[0].0, pair[1].0);
            }
        }
    }
    raster
}

/// Adds a span of a scan line to a row of pixels.
fn add_span(row: &mut [f64], from: f64, to: f64) {
    let [from, to] = [from, to].map(|end| end.clamp(0.0, row.len() as f64));
    let last = (to.ceil() as usize).min(row.len());
    for (column, pixel) in row.iter_mut().enumerate().take(last).skip(from as usize) {
        let part = to.min(column as f64 + 1.0) - from.max(column as f64);
        *pixel += part.max(0.0) / LINES as f64;
    }
}

/// Coverage of pixels by polylines of `width`; in pixels.
fn broad([columns, rows]: [usize; 2], strokes: &[Vec<DVec2>], width: f64) -> Vec<f64> {
    let mut distances = vec![f64::INFINITY; columns * rows];
    let mut near = |a: DVec2, b: DVec2| {
        for (index, distance) in pixels::near([columns, rows], [a, b], width / 2.0) {
            distances[index] = distances[index].min(distance);
        }
    };
    for stroke in strokes {
        match stroke[..] {
            [only] => near(only, only),
            _ => stroke.windows(2).for_each(|pair| near(pair[0], pair[1])),
        }
    }
    distances.into_iter().map(|distance| pixels::overlap(distance, width / 2.0)).collect()
}

impl Scene {
    /// Numbers of solved drives in turn of a drag's frame and of a whole search. Without a number in the scene, areas at rest
    /// have as many as pay, since their |p|² counts in the mean.
    pub fn drives_in_turn(&self) -> RangeInclusive<usize> {
        /// Frames that pay: two more lower the error of a portrait by 1 % and the side lobe by 4 %, for a third more time.
        const PAY: usize = 6;
        if self.drive.is_named() {
            return 1..=1;
        }
        match self.solver.frames {
            Turns::Count(count) => count as usize..=count as usize,
            Turns::Auto if self.solver.method == Method::Best && self.has_areas() && !motion::moves(self) => {
                1..=PAY
            }
            Turns::Auto => 1..=1,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{pixels::Pixels, shape::Shape};

    #[test]
    fn a_black_rim_is_left_out_and_moves_nothing() {
        let bright = |column: usize, row: usize| if (2..5).contains(&column) && row == 1 { 0.5 } else { 0.0 };
        let brightness = (0..32).map(|index| bright(index % 8, index / 8)).collect();
        let grey = Grey { file: None, width: 8, height: 4, brightness };
        let at = DVec3::new(0.01, -0.02, 0.1);
        let shape = Shape::Picture { file: "rim.png".to_owned(), at, width: 0.08, pixels: Pixels::new(grey) };
        let target = Target { angle: std::f64::consts::FRAC_PI_2, ..Target::new(shape) };
        let cover = Cover::new(&target, 8.5e-3).unwrap().unwrap();
        assert!(cover.half.distance(DVec2::new(0.015, 0.005)) < 1e-12, "{}", cover.half);
        // The second row from the top is 5 mm above the centre, to the left after a quarter turn.
        let middle = at + DVec3::new(-0.005, -0.005, 0.0);
        assert!(cover.centre.distance(middle) < 1e-12, "{}", cover.centre);
        assert!((cover.brightness(cover.flat(middle), 1e-3) - 0.5).abs() < 1e-12);
        assert_eq!(cover.brightness(cover.flat(at + DVec3::X * 0.01), 1e-3), 0.0);
    }
}
