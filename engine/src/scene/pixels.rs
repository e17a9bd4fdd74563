//! The pixels of a picture target, loaded from the picture's file when a scene is opened, or painted.

use std::path::PathBuf;

use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::scene::loaded::Loaded;

/// Less than any grey level of 8 bits but black.
const DARK: f32 = 0.5 / LEVELS;
/// Grey levels above black of the files that paintings are saved to.
const LEVELS: f32 = 255.0;
/// In pixels: a thinner dab could fall between pixel centres.
const THINNEST: f64 = 0.5;

/// Grey values of a picture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Grey {
    /// The file of origin; `None` after painting.
    pub file: Option<PathBuf>,
    pub width: usize,
    pub height: usize,
    /// Brightness of every pixel, row by row from the top left: 0 for black and transparent, 1 for white.
    pub brightness: Vec<f32>,
}

impl Grey {
    /// Whether all pixels are black.
    pub fn is_black(&self) -> bool {
        self.brightness.iter().all(|brightness| *brightness < DARK)
    }
}

/// A straight brush stroke of radius `radius`, in pixels from the upper left corner of a raster.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dab {
    pub from: DVec2,
    pub to: DVec2,
    pub radius: f64,
}

/// The pixels of a picture target, once they are loaded. A scene file only names the picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pixels(Loaded<Grey>);

impl Pixels {
    /// # Panics
    /// The number of values differs from the number of pixels.
    pub fn new(grey: Grey) -> Self {
        assert_eq!(grey.brightness.len(), grey.width * grey.height, "a brightness per pixel");
        Self(Loaded::new(grey))
    }

    /// To be painted on.
    pub fn black(width: usize, height: usize) -> Self {
        Self::new(Grey { file: None, width, height, brightness: vec![0.0; width * height] })
    }

    pub fn get(&self) -> Option<&Grey> {
        self.0.get()
    }

    /// Height over width; 1 until they are loaded.
    pub fn aspect(&self) -> f64 {
        let of = |grey: &Grey| grey.height as f64 / grey.width as f64;
        self.get().filter(|grey| grey.width > 0 && grey.height > 0).map_or(1.0, of)
    }

    /// Sets the brightness (0 to 1) under a dab unless it is already higher, with antialiased edges. Returns whether
    /// this changed a pixel.
    pub fn paint(&mut self, dab: &Dab, brightness: f32) -> bool {
        self.change(dab, |before, part| before.max(level(brightness * part)))
    }

    /// Clears the brightness under a dab, with antialiased edges. Returns whether this changed a pixel.
    pub fn wipe(&mut self, dab: &Dab) -> bool {
        self.change(dab, |before, part| before.min(level(before * (1.0 - part))))
    }

    /// Updates every pixel under a dab from its brightness and coverage.
    fn change(&mut self, dab: &Dab, change: impl Fn(f32, f32) -> f32) -> bool {
        let Some(grey) = self.0.get().filter(|_| dab.radius > 0.0) else { return false };
        let radius = dab.radius.max(THINNEST);
        let mut changed: Option<Grey> = None;
        for (index, distance) in near([grey.width, grey.height], [dab.from, dab.to], radius) {
            let before = grey.brightness[index];
            let after = change(before, overlap(distance, radius) as f32);
            if after != before {
                changed.get_or_insert_with(|| Grey { file: None, ..grey.clone() }).brightness[index] = after;
            }
        }
        let Some(changed) = changed else { return false };
        self.0 = Loaded::new(changed);
        true
    }
}

/// The nearest 8-bit level, so that a painting is unchanged after saving and opening.
fn level(brightness: f32) -> f32 {
    (brightness * LEVELS).round() / LEVELS
}

/// The pixels of a raster that may be within `radius` of a segment, as row-by-row indices with distances of their
/// centres; all in pixels.
pub(crate) fn near(
    [columns, rows]: [usize; 2],
    [from, to]: [DVec2; 2],
    radius: f64,
) -> impl Iterator<Item = (usize, f64)> {
    let reach = radius + 1.0;
    let [low, high] = [from.min(to) - reach, from.max(to) + reach];
    let range = |low: f64, high: f64, count: usize| {
        (low.clamp(0.0, count as f64) as usize)..(high.ceil().clamp(0.0, count as f64) as usize)
    };
    let (along, length) = (to - from, from.distance_squared(to));
    let across = range(low.x, high.x, columns);
    range(low.y, high.y, rows).flat_map(move |row| {
        across.clone().map(move |column| {
            let place = DVec2::new(column as f64 + 0.5, row as f64 + 0.5);
            let part = if length > 0.0 { ((place - from).dot(along) / length).clamp(0.0, 1.0) } else { 0.0 };
            (row * columns + column, place.distance(from + along * part))
        })
    })
}

/// Coverage of a pixel by a line of this radius at a distance from its centre; in pixels.
pub(crate) fn overlap(distance: f64, radius: f64) -> f64 {
    ((distance + 0.5).min(radius) - (distance - 0.5).max(-radius)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTH: usize = 40;
    const HEIGHT: usize = 30;

    fn dab(from: [f64; 2], to: [f64; 2], radius: f64) -> Dab {
        Dab { from: from.into(), to: to.into(), radius }
    }

    fn sum(pixels: &Pixels) -> f64 {
        pixels.get().unwrap().brightness.iter().map(|brightness| f64::from(*brightness)).sum()
    }

    fn at(pixels: &Pixels, column: usize, row: usize) -> f32 {
        pixels.get().unwrap().brightness[row * WIDTH + column]
    }

    #[test]
    fn a_dab_covers_the_area_that_it_has_and_painting_it_again_changes_nothing() {
        for (from, to, radius) in [
            ([20.0, 15.0], [20.0, 15.0], 6.0),
            ([12.3, 9.1], [27.6, 18.9], 4.3),
            ([10.0, 15.0], [30.0, 15.0], 2.5),
        ] {
            let mut pixels = Pixels::black(WIDTH, HEIGHT);
            let dab = dab(from, to, radius);
            assert!(pixels.paint(&dab, 1.0) && !pixels.paint(&dab, 1.0));
            let area = std::f64::consts::PI * radius * radius + 2.0 * radius * dab.from.distance(dab.to);
            assert!((sum(&pixels) - area).abs() < 0.02 * area, "{} of {area}", sum(&pixels));
            let edges = pixels.get().unwrap().brightness.iter().filter(|it| **it > 0.0 && **it < 1.0).count();
            assert!(edges > 4, "its edge is smooth: {edges}");
        }
    }

    #[test]
    fn painting_never_darkens_and_wiping_never_brightens() {
        let mut pixels = Pixels::black(WIDTH, HEIGHT);
        let spot = dab([20.0, 15.0], [20.0, 15.0], 5.0);
        pixels.paint(&spot, 1.0);
        assert!(!pixels.paint(&spot, 0.5) && at(&pixels, 20, 15) == 1.0);
        assert!(pixels.paint(&dab([20.0, 15.0], [33.0, 15.0], 5.0), 0.5));
        assert_eq!((at(&pixels, 20, 15), at(&pixels, 33, 15)), (1.0, level(0.5)));
        let before = pixels.clone();
        assert!(pixels.wipe(&dab([20.0, 15.0], [20.0, 15.0], 3.0)));
        let brightness = |pixels: &Pixels| pixels.get().unwrap().brightness.clone();
        assert!(brightness(&pixels).iter().zip(brightness(&before)).all(|(after, before)| *after <= before));
        assert_eq!((at(&pixels, 20, 15), at(&pixels, 33, 15)), (0.0, level(0.5)));
        assert!(pixels.wipe(&dab([0.0, 15.0], [40.0, 15.0], 1e6)) && pixels.get().unwrap().is_black());
    }

    #[test]
    fn dabs_beside_the_raster_tiny_huge_or_without_a_place_are_harmless() {
        let mut pixels = Pixels::black(WIDTH, HEIGHT);
        for (from, to, radius) in [
            ([-20.0, 15.0], [-8.0, 40.0], 5.0),
            ([1e12, 15.0], [1e12, 15.0], 5.0),
            ([20.0, 15.0], [20.0, 15.0], 0.0),
            ([20.0, 15.0], [20.0, 15.0], -3.0),
            ([f64::NAN, 15.0], [20.0, f64::NAN], 5.0),
        ] {
            assert!(!pixels.paint(&dab(from, to, radius), 1.0), "{from:?} {to:?} {radius}");
        }
        assert!(pixels.paint(&dab([20.0, 15.0], [20.0, 15.0], 0.2), 1.0), "less than a pixel is seen");
        assert!(sum(&pixels) < 1.7, "{}", sum(&pixels));
        assert!(pixels.paint(&dab([-1e9, 15.0], [1e9, 15.0], 1e9), 1.0));
        assert_eq!(sum(&pixels), (WIDTH * HEIGHT) as f64);
        let mut lacking = Pixels::default();
        assert!(!lacking.paint(&dab([20.0, 15.0], [20.0, 15.0], 5.0), 1.0) && lacking == Pixels::default());
    }

    #[test]
    fn what_is_painted_on_is_of_no_file_and_leaves_copies_alone() {
        let loaded = Pixels::new(Grey {
            file: Some("a.png".into()),
            width: WIDTH,
            height: HEIGHT,
            brightness: vec![0.25; WIDTH * HEIGHT],
        });
        let mut painted = loaded.clone();
        assert!(!painted.paint(&dab([-9.0, 0.0], [-9.0, 0.0], 2.0), 1.0) && painted == loaded);
        assert!(painted.paint(&dab([9.0, 9.0], [9.0, 9.0], 2.0), 1.0));
        assert_eq!((painted.get().unwrap().file.as_ref(), at(&painted, 9, 9)), (None, 1.0));
        assert!(loaded.get().unwrap().file.is_some() && at(&loaded, 9, 9) == 0.25);
    }
}
