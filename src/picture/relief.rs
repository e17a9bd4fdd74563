//! A liquid's surface seen at an angle: what a photograph of the dents would look like.

use glam::{DVec2, Vec3};
use plotters::prelude::*;
use rayon::prelude::*;

use crate::picture::{Picture, PictureError, register_font};

/// Width and height of the page for which the measures below are meant.
const PAGE: (f64, f64) = (1600.0, 1000.0);
/// Pixels kept free at the sides, at the top for words, and at the bottom for the front of the liquid.
const SIDE: f64 = 70.0;
const TOP: f64 = 185.0;
const BOTTOM: f64 = 110.0;
/// rad above the horizon from which one looks.
const ELEVATION: f64 = 0.62;
/// Part of the plane's width that the deepest dent is drawn deep, if it is exaggerated so much.
const DRAWN_DEPTH: f64 = 0.09;
/// Columns that are drawn for one of the picture: smooth edges.
const FINENESS: usize = 2;
/// Columns of the picture that are drawn together, so that neighbours find the surface in the cache.
const STRIP: usize = 8;

const SKY: Vec3 = Vec3::new(0.90, 0.94, 0.97);
const DEEP: Vec3 = Vec3::new(0.03, 0.20, 0.33);
const SHALLOW: Vec3 = Vec3::new(0.10, 0.47, 0.60);
const PAPER: [u8; 3] = [255; 3];
const INK: RGBColor = RGBColor(30, 30, 34);
const WARNING: RGBColor = RGBColor(178, 34, 20);

/// A surface to be drawn.
#[derive(Clone, Copy, Debug)]
pub struct Relief<'a> {
    /// m, positive down, row by row, row 0 at the front.
    pub depth: &'a [f32],
    pub columns: usize,
    /// m
    pub size: DVec2,
}

/// Where in a picture the surface is to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Pixels of the picture.
    pub width: usize,
    pub height: usize,
    /// Pixels kept free on the left and on the right, above, and below, where the front of the liquid is.
    pub side: f64,
    pub top: f64,
    pub bottom: f64,
    /// r, g, b of what is no liquid.
    pub ground: [u8; 3],
}

/// What stands above the surface on a page.
#[derive(Clone, Copy, Debug, Default)]
pub struct Words<'a> {
    /// The first line larger.
    pub lines: &'a [String],
    /// What must not be overlooked.
    pub warning: Option<&'a str>,
}

/// Height of a page of this width.
pub fn height(width: usize) -> usize {
    (width as f64 * PAGE.1 / PAGE.0).round() as usize
}

impl Relief<'_> {
    /// How many times as deep as they are dents are drawn: a round number, at least 1.
    pub fn exaggeration(&self) -> f64 {
        let deepest = self.depth.iter().fold(0.0f32, |most, depth| most.max(depth.abs()));
        let wanted = DRAWN_DEPTH * self.size.x / f64::from(deepest).max(1e-9);
        let decade = 10f64.powf(wanted.log10().floor());
        let round = [5.0, 2.0, 1.0].map(|step| step * decade).into_iter().find(|round| *round <= wanted);
        round.unwrap_or(1.0).clamp(1.0, 1e6)
    }

    /// Draws it with words on a page.
    ///
    /// # Errors
    /// The words cannot be set.
    pub fn page(&self, words: Words<'_>, (width, height): (usize, usize)) -> Result<Picture, PictureError> {
        let unit = (width as f64 / PAGE.0).min(height as f64 / PAGE.1);
        let (side, top, bottom) = (SIDE * unit, TOP * unit, BOTTOM * unit);
        let mut picture = self.draw(&Place { width, height, side, top, bottom, ground: PAPER });
        letter(&mut picture, words, unit)?;
        Ok(picture)
    }

    /// Draws it, seen from the front and above, without perspective.
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

/// A point of the surface as it is seen: how far below its level place (pixels), and its colour.
#[derive(Clone, Copy, Debug, Default)]
struct Point {
    sunk: f32,
    colour: Vec3,
}

/// The surface as it is projected and lit.
struct Seen {
    points: Vec<Point>,
    columns: usize,
    rows: usize,
    /// Pixels: the left edge and the width of the surface, the front edge of the level surface and how far above it the back
    /// one is, and the lower edge of the liquid.
    left: f64,
    wide: f64,
    front: f64,
    far: f64,
    bottom: f64,
    ground: Vec3,
}

impl Seen {
    fn new(relief: &Relief<'_>, place: &Place) -> Self {
        let (width, height) = (place.width as f64, place.height as f64);
        let size = relief.size;
        let room = DVec2::new(width - 2.0 * place.side, height - place.top - place.bottom).max(DVec2::ONE);
        let scale = (room.x / size.x).min(room.y / (size.y * ELEVATION.sin()));
        let far = scale * size.y * ELEVATION.sin();
        let front = height - place.bottom - (room.y - far) / 2.0;
        let columns = relief.columns.max(1);
        let rows = relief.depth.len() / columns;
        let exaggeration = relief.exaggeration();
        let rise = scale * exaggeration * ELEVATION.cos();
        let light = Light::new(size, (columns, rows), exaggeration);
        let mut points = vec![Point::default(); rows * columns];
        points.par_chunks_mut(columns).enumerate().for_each(|(row, points)| {
            for (column, point) in points.iter_mut().enumerate() {
                let sunk = (f64::from(relief.depth[row * columns + column]) * rise) as f32;
                *point = Point { sunk, colour: light.colour(relief.depth, column, row) };
            }
        });
        Self {
            points,
            columns,
            rows,
            left: (width - scale * size.x) / 2.0,
            wide: scale * size.x,
            front,
            far,
            bottom: (front + 0.7 * place.bottom).min(height),
            ground: Vec3::from(place.ground.map(f32::from)) / 255.0,
        }
    }

    /// Columns of the picture, one after the other, each from the top.
    fn strip(&self, columns: std::ops::Range<usize>, height: usize) -> Vec<[u8; 3]> {
        let mut strip = Vec::with_capacity(columns.len() * height);
        let mut covered = vec![(Vec3::ZERO, 0.0); height];
        for x in columns {
            covered.fill((Vec3::ZERO, 0.0));
            for i in 0..FINENESS {
                self.column(x as f64 + (i as f64 + 0.5) / FINENESS as f64, &mut covered);
            }
            strip.extend(covered.iter().map(|&(sum, part)| {
                let part = part / FINENESS as f32;
                let colour = sum / FINENESS as f32 + self.ground * (1.0 - part).max(0.0);
                (colour.clamp(Vec3::ZERO, Vec3::ONE) * 255.0 + 0.5).to_array().map(|channel| channel as u8)
            }));
        }
        strip
    }

    /// Adds what is seen along a line upwards, from the front to the back; what is nearer hides what is behind it.
    fn column(&self, x: f64, covered: &mut [(Vec3, f32)]) {
        let across = (x - self.left) / self.wide;
        if !(0.0..=1.0).contains(&across) || self.rows == 0 {
            return;
        }
        let place = (across * self.columns as f64 - 0.5).clamp(0.0, (self.columns - 1) as f64);
        let (column, part) = (place as usize, place.fract() as f32);
        let right = (column + 1).min(self.columns - 1);
        let point = |row: usize| {
            let at = |column: usize| self.points[row * self.columns + column];
            let (from, to) = (at(column), at(right));
            (from.sunk + (to.sunk - from.sunk) * part, from.colour.lerp(to.colour, part))
        };
        let (front, far) = (self.front as f32, self.far as f32);
        let (sunk, colour) = point(0);
        let mut before = (front + sunk, colour);
        let mut top = before.0;
        let wall = |part: f32| SHALLOW.lerp(DEEP, part);
        fill(covered, (top, wall(0.35)), (self.bottom as f32, wall(1.0)));
        for row in 0..=self.rows {
            // The last stands for the back edge.
            let along = ((row as f32 + 0.5) / self.rows as f32).min(1.0);
            let (sunk, colour) = point(row.min(self.rows - 1));
            let y = front - along * far + sunk;
            if y < top {
                let hidden = ((before.0 - top) / (before.0 - y)).clamp(0.0, 1.0);
                fill(covered, (y, colour), (top, before.1.lerp(colour, hidden)));
                top = y;
            }
            before = (y, colour);
        }
    }
}

/// Adds a stretch of a column, from a place above to a place below, to the pixels that it covers.
fn fill(covered: &mut [(Vec3, f32)], from: (f32, Vec3), to: (f32, Vec3)) {
    let last = covered.len() as f32;
    let (start, end) = (from.0.clamp(0.0, last), to.0.clamp(0.0, last));
    let per_pixel = 1.0 / (to.0 - from.0).max(1e-6);
    for (y, (sum, part)) in covered.iter_mut().enumerate().take(end.ceil() as usize).skip(start as usize) {
        let (above, below) = (start.max(y as f32), end.min(y as f32 + 1.0));
        let share = below - above;
        let place = ((0.5 * (above + below) - from.0) * per_pixel).clamp(0.0, 1.0);
        *sum += from.1.lerp(to.1, place) * share;
        *part += share;
    }
}

/// How the surface is lit.
struct Light {
    columns: usize,
    rows: usize,
    /// From differences of depth between the two neighbours to slopes as they are drawn.
    steepness: [f32; 2],
    towards: Vec3,
    eye: Vec3,
}

impl Light {
    fn new(size: DVec2, (columns, rows): (usize, usize), exaggeration: f64) -> Self {
        let step = size / DVec2::new(columns as f64, rows.max(1) as f64);
        let steepness = DVec2::splat(exaggeration) / (2.0 * step);
        Self {
            columns,
            rows,
            steepness: [steepness.x as f32, steepness.y as f32],
            towards: Vec3::new(-0.55, -0.25, 0.8).normalize_or_zero(),
            eye: Vec3::new(0.0, -ELEVATION.cos() as f32, ELEVATION.sin() as f32),
        }
    }

    fn colour(&self, depth: &[f32], column: usize, row: usize) -> Vec3 {
        let at = |column: usize, row: usize| depth[row * self.columns + column];
        let (left, right) = (column.saturating_sub(1), (column + 1).min(self.columns - 1));
        let (ahead, behind) = (row.saturating_sub(1), (row + 1).min(self.rows - 1));
        let slope_x = (at(right, row) - at(left, row)) * self.steepness[0];
        let slope_y = (at(column, behind) - at(column, ahead)) * self.steepness[1];
        let normal = Vec3::new(slope_x, slope_y, 1.0).normalize_or_zero();
        let lit = normal.dot(self.towards).max(0.0);
        let faced = normal.dot(self.eye);
        let mirrored = 2.0 * faced * normal - self.eye;
        let glint = mirrored.dot(self.towards).max(0.0).powi(60);
        // Schlick's approximation for water.
        let reflected = 0.02 + 0.98 * (1.0 - faced.clamp(0.0, 1.0)).powi(5);
        let body = DEEP.lerp(SHALLOW, (lit / self.towards.z).powi(2).min(1.6) * 0.75);
        let surface = body.lerp(SKY, (reflected * (0.4 + mirrored.z.max(0.0))).min(0.85));
        surface + Vec3::splat(0.75 * glint)
    }
}

/// Sets words above the surface.
fn letter(picture: &mut Picture, words: Words<'_>, unit: f64) -> Result<(), PictureError> {
    let mut top = 34.0;
    let lines = words.lines.iter().map(|line| (line.as_str(), INK));
    let lines: Vec<_> = lines.chain(words.warning.map(|line| (line, WARNING))).collect();
    on_picture(picture, |root| {
        for (index, (line, colour)) in lines.iter().enumerate() {
            let size = if index == 0 { 36.0 } else { 25.0 };
            let style = ("sans-serif", size * unit).into_font().color(colour);
            root.draw_text(line, &style, ((SIDE * unit) as i32, (top * unit) as i32))?;
            top += 1.45 * size;
        }
        Ok(())
    })
}

/// Lets something draw on the colours of a picture.
fn on_picture(
    picture: &mut Picture,
    draw: impl FnOnce(&DrawingArea<BitMapBackend<'_>, plotters::coord::Shift>) -> Result<(), PictureError>,
) -> Result<(), PictureError> {
    register_font();
    let mut rgb: Vec<u8> =
        picture.rgba.chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
    {
        let extent = (picture.width as u32, picture.height as u32);
        let root = BitMapBackend::with_buffer(&mut rgb, extent).into_drawing_area();
        draw(&root)?;
        root.present()?;
    }
    for (pixel, rgb) in picture.rgba.chunks_exact_mut(4).zip(rgb.chunks_exact(3)) {
        pixel[..3].copy_from_slice(rgb);
    }
    Ok(())
}

/// A few words on a map, in its lower left corner.
///
/// # Errors
/// The words cannot be set.
pub fn label(picture: &mut Picture, words: &str) -> Result<(), PictureError> {
    let size = (picture.width.min(picture.height) as f64 / 26.0).clamp(8.0, 28.0);
    let (left, top) = ((0.6 * size) as i32, picture.height as i32 - (1.7 * size) as i32);
    on_picture(picture, |root| {
        let style = ("sans-serif", size).into_font();
        for (offset, colour) in [((1, 1), BLACK), ((-1, 1), BLACK), ((1, -1), BLACK), ((0, 0), WHITE)] {
            root.draw_text(words, &style.color(&colour), (left + offset.0, top + offset.1))?;
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn relief(depth: &[f32]) -> Relief<'_> {
        Relief { depth, columns: 40, size: DVec2::new(0.1, 0.075) }
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
        let flat = relief(&level).page(Words::default(), (400, 250)).unwrap();
        let middle = flat.pixel(200, 125);
        assert_eq!(middle, flat.pixel(120, 110), "level");
        assert_eq!(flat.pixel(2, 125)[..3], [255, 255, 255], "paper at the side");
        let bowl = bowl(1e-4);
        let dented = relief(&bowl).page(Words::default(), (400, 250)).unwrap();
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
            assert_eq!(relief(&bowl).exaggeration(), times, "{deepest}");
        }
    }

    #[test]
    fn a_label_changes_its_corner_alone() {
        let mut picture = Picture { width: 300, height: 200, rgba: vec![128; 300 * 200 * 4] };
        let before = picture.clone();
        label(&mut picture, "beyond linear theory").unwrap();
        assert_ne!(picture, before);
        assert_eq!(picture.rgba[..300 * 150 * 4], before.rgba[..300 * 150 * 4]);
    }
}
