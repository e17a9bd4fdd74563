//! A liquid's surface seen at an angle: what a photograph of the dents would look like.

use glam::{DVec2, DVec3};
use plotters::prelude::*;

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
/// Points drawn per pixel and axis: smooth edges.
const FINENESS: usize = 2;

const SKY: [f64; 3] = [0.90, 0.94, 0.97];
const DEEP: [f64; 3] = [0.03, 0.20, 0.33];
const SHALLOW: [f64; 3] = [0.10, 0.47, 0.60];
const PAPER: [f64; 3] = [1.0, 1.0, 1.0];
const INK: RGBColor = RGBColor(30, 30, 34);
const WARNING: RGBColor = RGBColor(178, 34, 20);

/// A surface to be drawn.
#[derive(Clone, Debug)]
pub struct Relief<'a> {
    /// m, positive down, row by row, row 0 at the front.
    pub depth: &'a [f32],
    pub columns: usize,
    /// m
    pub size: DVec2,
    /// What stands above it, the first line larger.
    pub words: &'a [String],
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

    /// Draws it.
    ///
    /// # Errors
    /// The words cannot be set.
    pub fn draw(&self, (width, height): (usize, usize)) -> Result<Picture, PictureError> {
        let (wide, high) = (width * FINENESS, height * FINENESS);
        let mut fine = vec![PAPER; wide * high];
        let unit = (wide as f64 / PAGE.0).min(high as f64 / PAGE.1);
        let view = View::new(self, (wide, high), unit);
        for x in 0..wide {
            view.column(x, |y, colour| fine[y * wide + x] = colour);
        }
        let mut rgb = Vec::with_capacity(width * height * 3);
        for pixel in 0..width * height {
            let (x, y) = (pixel % width * FINENESS, pixel / width * FINENESS);
            let parts = (0..FINENESS * FINENESS).map(|i| fine[(y + i / FINENESS) * wide + x + i % FINENESS]);
            let sum = parts.fold(DVec3::ZERO, |sum, colour| sum + DVec3::from(colour));
            let mean = sum / (FINENESS * FINENESS) as f64;
            rgb.extend((mean.clamp(DVec3::ZERO, DVec3::ONE) * 255.0).round().to_array().map(|c| c as u8));
        }
        self.letter(&mut rgb, (width, height))?;
        let rgba = rgb.chunks_exact(3).flat_map(|pixel| [pixel[0], pixel[1], pixel[2], 255]).collect();
        Ok(Picture { width, height, rgba })
    }

    fn letter(&self, rgb: &mut [u8], (width, height): (usize, usize)) -> Result<(), PictureError> {
        register_font();
        let root = BitMapBackend::with_buffer(rgb, (width as u32, height as u32)).into_drawing_area();
        let unit = (width as f64 / PAGE.0).min(height as f64 / PAGE.1);
        let mut top = 34.0;
        let lines = self.words.iter().map(|words| (words.as_str(), INK));
        for (index, (words, colour)) in lines.chain(self.warning.map(|words| (words, WARNING))).enumerate() {
            let size = if index == 0 { 36.0 } else { 25.0 };
            let style = ("sans-serif", size * unit).into_font().color(&colour);
            root.draw_text(words, &style, ((SIDE * unit) as i32, (top * unit) as i32))?;
            top += 1.45 * size;
        }
        root.present()?;
        Ok(())
    }
}

/// How the surface is projected: seen from the front and above, without perspective.
struct View<'a> {
    relief: &'a Relief<'a>,
    rows: usize,
    /// Pixels per metre, and per metre of exaggerated height.
    scale: f64,
    rise: f64,
    exaggeration: f64,
    /// Where the front left corner of the level surface is, and the lower edge of the liquid.
    left: f64,
    front: f64,
    bottom: f64,
    light: DVec3,
}

impl<'a> View<'a> {
    fn new(relief: &'a Relief<'a>, (width, height): (usize, usize), unit: f64) -> Self {
        let (width, height) = (width as f64, height as f64);
        let room = DVec2::new(width - 2.0 * SIDE * unit, height - (TOP + BOTTOM) * unit);
        let scale = (room.x / relief.size.x).min(room.y / (relief.size.y * ELEVATION.sin()));
        let exaggeration = relief.exaggeration();
        let front = height - BOTTOM * unit - (room.y - scale * relief.size.y * ELEVATION.sin()) / 2.0;
        Self {
            relief,
            rows: relief.depth.len() / relief.columns,
            scale,
            rise: scale * exaggeration * ELEVATION.cos(),
            exaggeration,
            left: (width - scale * relief.size.x) / 2.0,
            front,
            bottom: (front + 0.7 * BOTTOM * unit).min(height - 1.0),
            light: DVec3::new(-0.55, -0.25, 0.8).normalize_or_zero(),
        }
    }

    /// Paints one column of pixels from the front to the back; what is nearer hides what is behind it.
    fn column(&self, x: usize, mut paint: impl FnMut(usize, [f64; 3])) {
        let across = (x as f64 + 0.5 - self.left) / (self.scale * self.relief.size.x);
        if !(0.0..=1.0).contains(&across) {
            return;
        }
        let place = |part: f64| {
            let depth = self.depth(across, part);
            self.front - part * self.relief.size.y * self.scale * ELEVATION.sin() + depth * self.rise
        };
        let mut top = place(0.0);
        for y in top.max(0.0).ceil() as usize..=self.bottom as usize {
            let part = (y as f64 - top) / (self.bottom - top).max(1.0);
            paint(y, mixed(SHALLOW, DEEP, 0.35 + 0.65 * part));
        }
        let steps = (self.relief.size.y * self.scale * ELEVATION.sin()).ceil().max(1.0) as usize * 2;
        for step in 1..=steps {
            let part = step as f64 / steps as f64;
            let y = place(part);
            if y < top {
                let colour = self.colour(across, part);
                for pixel in y.max(0.0).ceil() as usize..top.max(0.0).ceil() as usize {
                    paint(pixel, colour);
                }
                top = y;
            }
        }
    }

    /// m; between the points of the surface, which are as fine as the pixels, along straight lines.
    fn depth(&self, across: f64, along: f64) -> f64 {
        let columns = self.relief.columns;
        let place = |part: f64, count: usize| (part * count as f64 - 0.5).clamp(0.0, (count - 1) as f64);
        let (x, y) = (place(across, columns), place(along, self.rows));
        let (column, row) = (x as usize, y as usize);
        let (right, behind) = ((column + 1).min(columns - 1), (row + 1).min(self.rows - 1));
        let at = |column: usize, row: usize| f64::from(self.relief.depth[row * columns + column]);
        let line = |row: usize| at(column, row) + (at(right, row) - at(column, row)) * (x - column as f64);
        line(row) + (line(behind) - line(row)) * (y - row as f64)
    }

    fn colour(&self, across: f64, along: f64) -> [f64; 3] {
        let size = self.relief.size;
        let hair = DVec2::new(1.0 / self.relief.columns as f64, 1.0 / self.rows as f64);
        let slope_x = self.depth(across + hair.x, along) - self.depth(across - hair.x, along);
        let slope_y = self.depth(across, along + hair.y) - self.depth(across, along - hair.y);
        let slope = self.exaggeration * DVec2::new(slope_x, slope_y) / (2.0 * hair * size);
        let normal = DVec3::new(slope.x, slope.y, 1.0).normalize_or_zero();
        let eye = DVec3::new(0.0, -ELEVATION.cos(), ELEVATION.sin());
        let lit = normal.dot(self.light).max(0.0);
        let mirrored = 2.0 * normal.dot(eye) * normal - eye;
        let glint = mirrored.dot(self.light).max(0.0).powi(60);
        // Schlick's approximation for water.
        let reflected = 0.02 + 0.98 * (1.0 - normal.dot(eye).clamp(0.0, 1.0)).powi(5);
        let body = mixed(DEEP, SHALLOW, (lit / self.light.z).powi(2).min(1.6) * 0.75);
        let surface = mixed(body, SKY, (reflected * (0.4 + mirrored.z.max(0.0))).min(0.85));
        surface.map(|channel| channel + 0.75 * glint)
    }
}

fn mixed(from: [f64; 3], to: [f64; 3], part: f64) -> [f64; 3] {
    std::array::from_fn(|i| from[i] + (to[i] - from[i]) * part)
}

/// A few words on a map, in its lower left corner.
///
/// # Errors
/// The words cannot be set.
pub fn label(picture: &mut Picture, words: &str) -> Result<(), PictureError> {
    register_font();
    let size = (picture.width.min(picture.height) as f64 / 26.0).clamp(8.0, 28.0);
    let mut rgb: Vec<u8> =
        picture.rgba.chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
    {
        let extent = (picture.width as u32, picture.height as u32);
        let root = BitMapBackend::with_buffer(&mut rgb, extent).into_drawing_area();
        let (left, top) = ((0.6 * size) as i32, picture.height as i32 - (1.7 * size) as i32);
        let style = ("sans-serif", size).into_font();
        for (offset, colour) in [((1, 1), BLACK), ((-1, 1), BLACK), ((1, -1), BLACK), ((0, 0), WHITE)] {
            root.draw_text(words, &style.color(&colour), (left + offset.0, top + offset.1))?;
        }
        root.present()?;
    }
    for (pixel, rgb) in picture.rgba.chunks_exact_mut(4).zip(rgb.chunks_exact(3)) {
        pixel[..3].copy_from_slice(rgb);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn relief(depth: &[f32]) -> Relief<'_> {
        Relief { depth, columns: 40, size: DVec2::new(0.1, 0.075), words: &[], warning: None }
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
        let flat = relief(&level).draw((400, 250)).unwrap();
        let middle = flat.pixel(200, 125);
        assert_eq!(middle, flat.pixel(120, 110), "level");
        assert_eq!(flat.pixel(2, 125)[..3], [255, 255, 255], "paper at the side");
        let bowl = bowl(1e-4);
        let dented = relief(&bowl).draw((400, 250)).unwrap();
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
