//! A shaded relief of a liquid's surface, as a photograph would show it.
//!
//! The picture is one march per column over the surface, from front to back, on all cores, from any side; the window gives it
//! half the canvas' pixels. The same code draws the pages of `render`, frames of films and rasters of figures. Targets are
//! edited over the flat map.

use std::f64::consts::TAU;
use std::ops::RangeInclusive;

use glam::{DVec2, Vec2, Vec3, Vec4};
use rayon::prelude::*;

use crate::picture::Picture;
use crate::picture::figure::mark::{Anchor, Ink, Mark};
use crate::picture::figure::raster::draw_on;

/// Reference width and height of the page for the measures below.
const PAGE: (f64, f64) = (1600.0, 1000.0);
/// Margins in pixels: at the sides, at the top for text, and at the bottom for the front of the liquid.
const SIDE: f64 = 70.0;
const TOP: f64 = 185.0;
const BOTTOM: f64 = 110.0;
/// Elevation of the view above the horizon, rad.
const ELEVATION: f64 = 0.62;
/// Drawn depth of the deepest point relative to the plane's width, if exaggerated accordingly.
const DRAWN_DEPTH: f64 = 0.09;
/// Drawn columns per column of the picture, for antialiasing.
const FINENESS: usize = 2;
/// Columns of the picture drawn together.
const STRIP: usize = 32;
/// Margins on a screen at the sides, above, and below for the front of the liquid, relative to the picture's height.
const ON_SCREEN: [f64; 3] = [0.04, 0.05, 0.09];
/// Elevations of the view, rad.
pub const ELEVATIONS: RangeInclusive<f64> = 0.12..=1.5;

const SKY: Vec3 = Vec3::new(0.90, 0.94, 0.97);
const DEEP: Vec3 = Vec3::new(0.03, 0.20, 0.33);
const BODY: Vec3 = Vec3::splat(0.5);
const SHALLOW: Vec3 = Vec3::new(0.10, 0.47, 0.60);
pub const PAPER: [u8; 3] = [255; 3];
const INK: Ink = [30, 30, 34];
const WARNING: Ink = [178, 34, 20];

/// A surface to be drawn.
#[derive(Clone, Copy, Debug)]
pub struct Relief<'a> {
    /// m, positive down, row by row, row 0 at the front.
    pub depth: &'a [f32],
    pub columns: usize,
    /// m
    pub size: DVec2,
    /// Vertical exaggeration.
    pub exaggeration: f64,
    pub sight: Sight,
}

/// The direction of the view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sight {
    /// rad, counter-clockwise from the front.
    pub azimuth: f64,
    /// rad, above the horizon.
    pub elevation: f64,
}

impl Default for Sight {
    fn default() -> Self {
        Self { azimuth: 0.0, elevation: ELEVATION }
    }
}

impl Sight {
    /// The view from another side, after a drag by parts of a picture's height.
    pub fn orbited(self, by: DVec2) -> Self {
        let azimuth = (self.azimuth - 3.0 * by.x).rem_euclid(TAU);
        let elevation = (self.elevation + 2.0 * by.y).clamp(*ELEVATIONS.start(), *ELEVATIONS.end());
        Self { azimuth, elevation }
    }

    /// Width, and depth along the view, of a level surface of this size; m.
    fn extent(self, size: DVec2) -> DVec2 {
        let [right, along] = self.axes().map(DVec2::abs);
        DVec2::new(right.dot(size), along.dot(size))
    }

    /// The directions to the right and away from the viewer.
    fn axes(self) -> [DVec2; 2] {
        let right = DVec2::from_angle(self.azimuth);
        [right, right.perp()]
    }
}

/// The user's choices for a relief.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Look {
    pub sight: Sight,
    /// `None`: that of the surface's own largest depth.
    pub exaggeration: Option<f64>,
}

/// Position of the surface in a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Pixels of the picture.
    pub width: usize,
    pub height: usize,
    /// Margins in pixels on the left and on the right, above, and below for the front of the liquid.
    pub side: f64,
    pub top: f64,
    pub bottom: f64,
    /// r, g, b outside the liquid.
    pub ground: [u8; 3],
}

/// Text above the surface on a page.
#[derive(Clone, Copy, Debug, Default)]
pub struct Words<'a> {
    /// The first line larger.
    pub lines: &'a [String],
    /// A warning.
    pub warning: Option<&'a str>,
}

/// Height of a page of this width.
pub fn height(width: usize) -> usize {
    (width as f64 * PAGE.1 / PAGE.0).round() as usize
}

/// Vertical exaggeration for depths up to this one (m) on a plane of this size (m): a round number, at least 1.
pub fn exaggeration(deepest: f64, size: DVec2) -> f64 {
    let wanted = DRAWN_DEPTH * size.x / deepest.max(1e-9);
    let decade = 10f64.powf(wanted.log10().floor());
    let round = [5.0, 2.0, 1.0].map(|step| step * decade).into_iter().find(|round| *round <= wanted);
    round.unwrap_or(1.0).clamp(1.0, 1e6)
}

/// Aspect ratio (height over width) of the view of a level surface of this size (m).
pub fn shape(size: DVec2) -> f64 {
    size.y / size.x * ELEVATION.sin()
}

impl Place {
    /// A place that fills a screen of this size in pixels.
    pub fn on_screen(width: usize, height: usize, ground: [u8; 3]) -> Self {
        let [side, top, bottom] = ON_SCREEN.map(|part| part * height as f64);
        Self { width, height, side, top, bottom, ground }
    }

    fn room(&self) -> DVec2 {
        let (width, height) = (self.width as f64, self.height as f64);
        DVec2::new(width - 2.0 * self.side, height - self.top - self.bottom).max(DVec2::ONE)
    }

    /// The size (m) of a surface of this width that fills the place, seen from the front.
    pub fn filled(&self, width: f64) -> DVec2 {
        let room = self.room();
        DVec2::new(width, width * room.y / room.x / ELEVATION.sin())
    }

    /// Pixels of a metre to the right on a surface of this size (m), seen from the front.
    pub fn scale(&self, size: DVec2) -> f64 {
        self.scale_from(Sight::default(), size)
    }

    fn scale_from(&self, sight: Sight, size: DVec2) -> f64 {
        let (room, extent) = (self.room(), sight.extent(size));
        (room.x / extent.x).min(room.y / (extent.y * sight.elevation.sin()))
    }
}

impl<'a> Relief<'a> {
    /// The surface with the exaggeration of its own largest depth.
    pub fn new(depth: &'a [f32], columns: usize, size: DVec2) -> Self {
        let deepest = depth.iter().fold(0.0f32, |most, depth| most.max(depth.abs()));
        let sight = Sight::default();
        Self { depth, columns, size, exaggeration: exaggeration(deepest.into(), size), sight }
    }

    /// Vertical pixels per metre of depth, given the horizontal pixels per metre.
    pub fn sinks(&self, scale: f64) -> f64 {
        scale * self.exaggeration * self.sight.elevation.cos()
    }

    /// Vertical pixels per metre of depth in a place.
    pub fn sinks_in(&self, place: &Place) -> f64 {
        self.sinks(place.scale_from(self.sight, self.size))
    }

    /// Draws it with words on a page.
    pub fn page(&self, words: Words<'_>, (width, height): (usize, usize)) -> Picture {
        let unit = (width as f64 / PAGE.0).min(height as f64 / PAGE.1);
        let (side, top, bottom) = (SIDE * unit, TOP * unit, BOTTOM * unit);
        let mut picture = self.draw(&Place { width, height, side, top, bottom, ground: PAPER });
        letter(&mut picture, words, unit);
        picture
    }

    /// Draws it, seen from above, without perspective.
    pub fn draw(&self, place: &Place) -> Picture {
        let Place { width, height, .. } = *place;
        let seen = Seen::new(self, place);
        let strips: Vec<Vec<[u8; 3]>> = (0..width)
            .into_par_iter()
            .step_by(STRIP)
            .map(|first| seen.strip(first..(first + STRIP).min(width), height))
            .collect();
        let mut rgba = vec![255; width * height * 4];
        rgba.par_chunks_mut((width * 4).max(1)).enumerate().for_each(|(y, row)| {
            for (strip, pixels) in strips.iter().zip(row.chunks_mut(STRIP * 4)) {
                for (x, pixel) in pixels.chunks_exact_mut(4).enumerate() {
                    pixel[..3].copy_from_slice(&strip[x * height + y]);
                }
            }
        });
        Picture { width, height, rgba }
    }
}

/// The projected surface.
struct Seen<'a> {
    relief: &'a Relief<'a>,
    columns: usize,
    rows: usize,
    /// The place of the last point.
    last: Vec2,
    /// Colour of every point, and its displacement down the picture in pixels.
    lit: Vec<Vec4>,
    /// Pixels per metre to the right, and away from the viewer.
    scale: f64,
    away: f64,
    /// Pixels: the horizontal middle, and the level surface there.
    middle: f64,
    horizon: f64,
    /// Pixels of the liquid's front.
    wall: f32,
    ground: [u8; 3],
}

/// A march over the surface: from front to back, in grid points and in pixels down the picture.
struct March {
    from: Vec2,
    to: Vec2,
    y: [f32; 2],
    steps: usize,
}

impl<'a> Seen<'a> {
    fn new(relief: &'a Relief<'a>, place: &Place) -> Self {
        let Relief { size, sight, .. } = *relief;
        let scale = place.scale_from(sight, size);
        let (top, bottom) = (place.top, place.height as f64 - place.bottom);
        let columns = relief.columns.max(1);
        let rows = relief.depth.len() / columns;
        let light = Light::new(relief, (columns, rows));
        let sinks = relief.sinks(scale) as f32;
        let mut lit = vec![Vec4::ZERO; columns * rows];
        lit.par_chunks_mut(columns).enumerate().for_each(|(row, lit)| {
            for (column, lit) in lit.iter_mut().enumerate() {
                let sunk = relief.depth[row * columns + column] * sinks;
                // A body stands out of the level surface.
                *lit = match sunk.is_nan() {
                    true => BODY.extend(0.0),
                    false => light.colour(relief.depth, column, row).extend(sunk),
                };
            }
        });
        Self {
            relief,
            columns,
            rows,
            last: Vec2::new((columns - 1) as f32, rows.saturating_sub(1) as f32),
            lit,
            scale,
            away: scale * sight.elevation.sin(),
            middle: place.width as f64 / 2.0,
            horizon: (top + bottom) / 2.0,
            wall: (0.7 * place.bottom) as f32,
            ground: place.ground,
        }
    }

    /// The march of a horizontal position in the picture.
    fn march(&self, x: f64) -> Option<March> {
        let Relief { size, sight, .. } = *self.relief;
        let [right, along] = sight.axes();
        let start = right * ((x - self.middle) / self.scale);
        let (mut near, mut far) = (f64::NEG_INFINITY, f64::INFINITY);
        for axis in [0, 1] {
            let half = size[axis] / 2.0;
            if along[axis].abs() < 1e-9 {
                if start[axis].abs() > half {
                    return None;
                }
                continue;
            }
            let ends = [-half, half].map(|end| (end - start[axis]) / along[axis]);
            (near, far) = (near.max(ends[0].min(ends[1])), far.min(ends[0].max(ends[1])));
        }
        if near >= far || self.rows == 0 {
            return None;
        }
        let counts = DVec2::new(self.columns as f64, self.rows as f64);
        let grid = |along_it: f64| (((start + along * along_it) / size + 0.5) * counts - 0.5).as_vec2();
        let per_metre = (along.abs() * counts / size).element_sum();
        Some(March {
            from: grid(near),
            to: grid(far),
            y: [near, far].map(|along_it| (self.horizon - along_it * self.away) as f32),
            steps: (((far - near) * per_metre).round() as usize).max(1),
        })
    }

    /// The colour and the displacement at a place of the grid.
    fn at(&self, place: Vec2) -> Vec4 {
        /// Closer places are on a row: seen from the front, a march meets the rows one by one.
        const ON_ROW: f32 = 1e-3;
        let place = place.clamp(Vec2::ZERO, self.last);
        let column = place.x as usize;
        let part = place.x - column as f32;
        let right = (column + 1).min(self.columns - 1);
        let line = |row: usize| {
            let line = &self.lit[row * self.columns..][..self.columns];
            line[column].lerp(line[right], part)
        };
        let nearest = place.y.round();
        if (place.y - nearest).abs() < ON_ROW {
            return line(nearest as usize);
        }
        let row = place.y as usize;
        line(row).lerp(line((row + 1).min(self.rows - 1)), place.y - row as f32)
    }

    /// Columns of the picture, one after the other, each from the top.
    fn strip(&self, columns: std::ops::Range<usize>, height: usize) -> Vec<[u8; 3]> {
        let mut strip = Vec::with_capacity(columns.len() * height);
        let mut covered = vec![Vec4::ZERO; height];
        let fine = |x: usize| (0..FINENESS).map(move |i| x as f64 + (i as f64 + 0.5) / FINENESS as f64);
        for x in columns {
            covered.fill(Vec4::ZERO);
            for march in fine(x).filter_map(|x| self.march(x)) {
                self.column(&march, &mut covered);
            }
            strip.extend(covered.iter().map(|&sum| {
                if sum.w == 0.0 {
                    return self.ground;
                }
                let sum = sum / FINENESS as f32;
                let ground = Vec3::from(self.ground.map(f32::from)) / 255.0;
                let colour = sum + ground.extend(1.0) * (1.0 - sum.w).max(0.0);
                let [r, g, b, _] = (colour.min(Vec4::ONE) * 255.0 + 0.5).to_array();
                [r as u8, g as u8, b as u8]
            }));
        }
        strip
    }

    /// Adds a column of the view upwards, from front to back, with hidden parts removed. The last component of a sum is the
    /// coverage.
    fn column(&self, march: &March, covered: &mut [Vec4]) {
        let [near, far] = march.y;
        let point = |part: f32| {
            let found = self.at(march.from.lerp(march.to, part));
            (near + (far - near) * part + found.w, found.truncate().extend(1.0))
        };
        let mut before = point(0.0);
        let mut top = before.0;
        let wall = |part: f32| SHALLOW.lerp(DEEP, part).extend(1.0);
        fill(covered, (top, wall(0.35)), ((near + self.wall).max(top), wall(1.0)));
        let steps = (0..march.steps).map(|step| (step as f32 + 0.5) / march.steps as f32);
        for part in steps.chain([1.0]) {
            let (y, colour) = point(part);
            if y < top {
                let hidden = (before.0 - top) / (before.0 - y);
                fill(covered, (y, colour), (top, before.1.lerp(colour, hidden)));
                top = y;
            }
            before = (y, colour);
        }
    }
}

/// Adds a segment of a column to the pixels that it covers.
#[inline]
fn fill(covered: &mut [Vec4], from: (f32, Vec4), to: (f32, Vec4)) {
    let last = covered.len() as f32;
    let (start, end) = (from.0.clamp(0.0, last), to.0.clamp(0.0, last));
    let (first, behind) = (start as usize, end.ceil() as usize);
    if behind <= first + 1 {
        // Most stretches are within a pixel.
        if let Some(sum) = covered.get_mut(first) {
            *sum += (from.1 + to.1) * (0.5 * (end - start));
        }
        return;
    }
    let slope = (to.1 - from.1) / (to.0 - from.0);
    for (y, sum) in covered[first..behind].iter_mut().enumerate() {
        let above = ((first + y) as f32).max(start);
        let below = ((first + y + 1) as f32).min(end);
        *sum += (from.1 + slope * (0.5 * (above + below) - from.0)) * (below - above);
    }
}

/// The light on the surface.
struct Light {
    columns: usize,
    rows: usize,
    /// Factors from depth differences of neighbours to drawn slopes.
    steepness: [f32; 2],
    towards: Vec3,
    /// Factor that gives a level surface a brightness of 1.
    brightness: f32,
    eye: Vec3,
}

impl Light {
    /// A light that goes with the viewer.
    fn new(relief: &Relief<'_>, (columns, rows): (usize, usize)) -> Self {
        let step = relief.size / DVec2::new(columns as f64, rows.max(1) as f64);
        let steepness = DVec2::splat(relief.exaggeration) / (2.0 * step);
        let [right, along] = relief.sight.axes().map(|axis| axis.as_vec2().extend(0.0));
        let (sine, cosine) = relief.sight.elevation.sin_cos();
        let turned = |v: Vec3| right * v.x + along * v.y + Vec3::Z * v.z;
        let towards = turned(Vec3::new(-0.55, -0.25, 0.8)).normalize_or_zero();
        Self {
            columns,
            rows,
            steepness: [steepness.x as f32, steepness.y as f32],
            towards,
            brightness: 1.0 / towards.z,
            eye: turned(Vec3::new(0.0, -cosine as f32, sine as f32)),
        }
    }

    fn colour(&self, depth: &[f32], column: usize, row: usize) -> Vec3 {
        let own = depth[row * self.columns + column];
        let at = |column: usize, row: usize| match depth[row * self.columns + column] {
            beside if beside.is_nan() => own,
            beside => beside,
        };
        let (left, right) = (column.saturating_sub(1), (column + 1).min(self.columns - 1));
        let (ahead, behind) = (row.saturating_sub(1), (row + 1).min(self.rows - 1));
        let slope_x = (at(right, row) - at(left, row)) * self.steepness[0];
        let slope_y = (at(column, behind) - at(column, ahead)) * self.steepness[1];
        let length = (1.0 + slope_x * slope_x + slope_y * slope_y).sqrt();
        let normal = Vec3::new(slope_x, slope_y, 1.0) / length;
        let lit = normal.dot(self.towards).max(0.0) * self.brightness;
        let faced = normal.dot(self.eye);
        let mirrored = 2.0 * faced * normal - self.eye;
        let straight = mirrored.dot(self.towards).max(0.0);
        let fourth = straight * straight * (straight * straight);
        let (eighth, sixteenth) = (fourth * fourth, fourth * fourth * fourth * fourth);
        // The 60th power.
        let glint = sixteenth * sixteenth * sixteenth * eighth * fourth;
        // Schlick's approximation for water.
        let grazing = 1.0 - faced.clamp(0.0, 1.0);
        let reflected = 0.02 + 0.98 * grazing * (grazing * grazing) * (grazing * grazing);
        let body = DEEP.lerp(SHALLOW, (lit * lit).min(1.6) * 0.75);
        let surface = body.lerp(SKY, (reflected * (0.4 + mirrored.z.max(0.0))).min(0.85));
        surface + Vec3::splat(0.75 * glint)
    }
}

/// Sets words above the surface.
fn letter(picture: &mut Picture, words: Words<'_>, unit: f64) {
    let lines = words.lines.iter().map(|line| (line.as_str(), INK));
    let mut top = 34.0;
    let set = |(index, (line, ink))| {
        let em = if index == 0 { 29.75 } else { 20.7 };
        let at = [SIDE * unit, (top + 0.6 * em) * unit];
        top += 1.755 * em;
        Mark::text(at, em * unit, Anchor::Start, ink, line)
    };
    let marks: Vec<_> = lines.chain(words.warning.map(|line| (line, WARNING))).enumerate().map(set).collect();
    draw_on(picture, &marks);
}

/// A few words on a map, in its lower left corner.
pub fn label(picture: &mut Picture, words: &str) {
    let em = (picture.width.min(picture.height) as f64 / 31.5).clamp(6.6, 23.1);
    let (left, base) = (0.73 * em, picture.height as f64 - 1.45 * em);
    let rim = [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0)].map(|offset| (offset, [0; 3]));
    let marks: Vec<_> = rim
        .into_iter()
        .chain([((0.0, 0.0), [255; 3])])
        .map(|((x, y), ink)| Mark::text([left + x, base + y], em, Anchor::Start, ink, words))
        .collect();
    draw_on(picture, &marks);
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    fn relief(depth: &[f32]) -> Relief<'_> {
        Relief::new(depth, 40, DVec2::new(0.1, 0.075))
    }

    fn bowl(deepest: f64) -> Vec<f32> {
        let at = |i: usize| {
            let (x, y) = ((i % 40) as f64 - 19.5, (i / 40) as f64 - 14.5);
            (deepest * (-(x * x + y * y) / 12.0).exp()) as f32
        };
        (0..1200).map(at).collect()
    }

    #[test]
    fn a_level_surface_is_even_and_a_dent_shows_in_the_middle() {
        let level = vec![0.0; 1200];
        let flat = relief(&level).page(Words::default(), (400, 250));
        let middle = flat.pixel(200, 125);
        assert_eq!(middle, flat.pixel(120, 110), "level");
        assert_eq!(flat.pixel(2, 125)[..3], [255, 255, 255], "paper at the side");
        let bowl = bowl(1e-4);
        let dented = relief(&bowl).page(Words::default(), (400, 250));
        let changed = |x: usize, y: usize| {
            dented
                .pixel(x, y)
                .iter()
                .zip(flat.pixel(x, y))
                .map(|(a, b)| i32::from(a.abs_diff(b)))
                .sum::<i32>()
        };
        assert!((90..170).map(|y| changed(200, y)).sum::<i32>() > 500);
        assert_eq!(changed(60, 125), 0, "far from the dent nothing changes");
    }

    #[test]
    fn dents_are_drawn_a_round_number_of_times_as_deep() {
        for (deepest, times) in [(1e-4, 50.0), (0.9e-2, 1.0), (1.0, 1.0), (2.1e-6, 2000.0)] {
            let bowl = bowl(deepest);
            assert_eq!(relief(&bowl).exaggeration, times, "{deepest}");
        }
    }

    #[test]
    fn from_behind_is_the_front_of_the_turned_surface() {
        let depth: Vec<_> = bowl(1e-4).iter().enumerate().map(|(i, depth)| depth * (i % 7) as f32).collect();
        let turned: Vec<_> = depth.iter().rev().copied().collect();
        let place = Place::on_screen(300, 200, [0; 3]);
        let behind = Relief { sight: Sight { azimuth: PI, ..Sight::default() }, ..relief(&depth) };
        let [a, b] = [behind.draw(&place), relief(&turned).draw(&place)];
        let apart = a.rgba.iter().zip(&b.rgba).filter(|(a, b)| a.abs_diff(**b) > 3).count();
        assert!(apart < a.rgba.len() / 200, "{apart}");
        let aside = Relief { sight: Sight { azimuth: 0.7, ..Sight::default() }, ..relief(&depth) };
        assert_ne!(aside.draw(&place).rgba, b.rgba);
    }

    #[test]
    fn a_label_changes_its_corner_alone() {
        let mut picture = Picture { width: 300, height: 200, rgba: vec![128; 300 * 200 * 4] };
        let before = picture.clone();
        label(&mut picture, "beyond linear theory");
        assert_ne!(picture, before);
        assert_eq!(picture.rgba[..300 * 150 * 4], before.rgba[..300 * 150 * 4]);
    }
}
