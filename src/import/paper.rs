//! Separates ink and paper in any light: dark strokes on light paper, or light chalk on a dark board.
//!
//! Light multiplies the lightness of ink and paper alike. So the logarithm of lightness is compared with that of the
//! paper, its [`closed`] plane, and the depth of ink 1 - lightness / paper is split in two. Chalk is ink after a change
//! of sign. Squares narrower than a stroke miss it, and squares broader than a shadow include it; those are right that
//! separate two depths best. In a drawing these are distinct, edges are sharp, and strokes have about one width.
//!
//! Closing takes strokes along the border, and surfaces broader than all squares, for paper. In pictures of two flat
//! shades one threshold for lightness finds both.

use crate::import::ImportError;
use crate::import::ink::Ink;
use crate::import::split::Split;
use crate::import::windows::{closed, extremes, opened};

/// Smallest difference between paper and ink, of 1.
const LEAST_CONTRAST: f64 = 0.094;
/// Smallest [`Split::separation`] of a drawing, and that of two flat shades.
const LEAST_SEPARATION: f64 = 0.8;
const FLAT: f64 = 0.93;
/// Largest depth of three quarters of the paper, of the contrast.
const EVEN_PAPER: f64 = 0.3;
/// Largest [`Ink::unevenness`] of strokes that are not flat.
const EVEN_STROKES: f64 = 1.35;
/// Widest edge, of the picture's longer side: more is out of focus, or no edge.
const BROADEST_EDGE: f64 = 0.04;
/// Added to lightness: noise in black is no contrast.
const BLACK: f32 = 0.1;
/// Halves of the sides of squares, of the picture's longer side.
const REACHES: [f64; 4] = [0.1, 0.05, 0.025, 0.0125];
/// Smaller squares must separate better by this.
const BETTER: f64 = 0.003;
/// Half the side of windows that tell paper from ink by its area.
const SURROUNDINGS: f64 = 0.05;
/// Widths of strokes along the border, and the least area, of the mean width and its square.
const BROADEST: f64 = 1.5;
const SMALLEST: f64 = 4.0;

/// A picture's smallest and largest channels from 0 to 1, row by row: ink of any colour is dark in the smallest, chalk
/// is light in the largest.
#[derive(Clone, Debug)]
pub struct Shades {
    pub width: usize,
    pub darkest: Vec<f32>,
    pub lightest: Vec<f32>,
}

/// The ink of a drawing.
///
/// # Errors
/// Blank paper, and pictures that are no drawing.
pub fn ink(shades: &Shades) -> Result<Ink, ImportError> {
    let is_chalk = is_chalk(shades);
    let side = Side::new(shades, is_chalk);
    let mut is_blank = true;
    if let Some(ink) = side.strokes(&mut is_blank) {
        return Ok(ink);
    }
    // Surroundings of thick strokes are no wider than these, so they may be mistaken.
    let surface = side.surface.ok_or(if is_blank { ImportError::Blank } else { ImportError::NoStrokes })?;
    Ok(Side::new(shades, !is_chalk).strokes(&mut is_blank).unwrap_or(surface))
}

/// A picture with ink that is dark, or with chalk.
struct Side {
    width: usize,
    /// Logarithms of lightness; of chalk negative.
    tones: Vec<f32>,
    /// The darker (of chalk lighter) of two flat shades, if there are two.
    surface: Option<Ink>,
}

impl Side {
    fn new(shades: &Shades, is_chalk: bool) -> Self {
        let tone = |value: &f32| (value + BLACK).ln();
        let (greys, tones): (Vec<f32>, Vec<f32>) = if is_chalk {
            shades.lightest.iter().map(|value| (*value, -tone(value))).unzip()
        } else {
            shades.darkest.iter().map(|value| (1.0 - value, tone(value))).unzip()
        };
        let split = Split::new(&greys);
        let is_flat = split.separation >= FLAT && split.contrast >= LEAST_CONTRAST;
        let surface = is_flat.then(|| above(&greys, shades.width, split.threshold));
        Self { width: shades.width, tones, surface }
    }

    /// Strokes, if the picture is a drawing. Some contrast means that it is not blank.
    fn strokes(&self, is_blank: &mut bool) -> Option<Ink> {
        let mut best: Option<(f64, Ink)> = None;
        for part in REACHES {
            let depths = self.depths(self.reach(part));
            let split = Split::new(&depths);
            *is_blank &= split.contrast < LEAST_CONTRAST;
            let least = best.as_ref().map_or(LEAST_SEPARATION, |(separation, _)| separation + BETTER);
            if split.contrast < LEAST_CONTRAST
                || split.separation < least
                || split.quartile > EVEN_PAPER * split.contrast
                || edge_width(&depths, self.width, &split) > self.reach(BROADEST_EDGE) as f64
            {
                continue;
            }
            let ink = above(&depths, self.width, split.threshold);
            let is_flat = split.separation >= FLAT;
            if is_flat || ink.unevenness() <= EVEN_STROKES {
                best = Some((split.separation, ink));
            }
            if is_flat {
                break;
            }
        }
        let (_, mut ink) = best?;
        self.surface.iter().for_each(|surface| add_border(&mut ink, surface));
        Some(ink)
    }

    fn reach(&self, part: f64) -> usize {
        reach(self.width, self.tones.len(), part)
    }

    /// Depths of ink from 0 to 1.
    fn depths(&self, reach: usize) -> Vec<f32> {
        let depth = |(paper, tone): (f32, &f32)| (1.0 - (tone - paper).exp()).max(0.0);
        // Single light pixels are no paper.
        let paper = closed(&opened(&self.tones, self.width, 1), self.width, reach);
        paper.into_iter().zip(&self.tones).map(depth).collect()
    }
}

/// Pixels of a part of the longer side.
fn reach(width: usize, pixels: usize, part: f64) -> usize {
    ((width.max(pixels / width) as f64 * part) as usize).max(4)
}

fn above(values: &[f32], width: usize, threshold: f32) -> Ink {
    let places = values.iter().enumerate().filter(|(_, value)| **value > threshold);
    Ink::new(width, values.len() / width, places.map(|(place, _)| (place % width, place / width)))
}

/// Pixels from paper to ink, at the slope of the edges.
fn edge_width(depths: &[f32], width: usize, split: &Split) -> f64 {
    let is_ink = |depth: f32| depth > split.threshold;
    let across = depths.chunks(width).flat_map(|row| row.windows(2).map(|pair| [pair[0], pair[1]]));
    let along = depths.iter().zip(depths.iter().skip(width)).map(|(above, below)| [*above, *below]);
    let edges = across.chain(along).filter(|&[a, b]| is_ink(a) != is_ink(b));
    let (count, steps) =
        edges.fold((0.0, 0.0), |(count, steps), [a, b]| (count + 1.0, steps + f64::from((a - b).abs())));
    split.contrast * count / steps
}

/// Whether dark surroundings of strokes are larger than light ones.
fn is_chalk(shades: &Shades) -> bool {
    let reach = reach(shades.width, shades.darkest.len(), SURROUNDINGS);
    // Half the pixels per side are enough.
    let rows = |values: &[f32]| -> Vec<f32> {
        values.chunks(shades.width).step_by(2).flat_map(|row| row.iter().step_by(2).copied()).collect()
    };
    let lightest = rows(&shades.lightest);
    let greys: Vec<f32> =
        rows(&shades.darkest).iter().zip(&lightest).map(|(dark, light)| (dark + light) / 2.0).collect();
    let [highest, lowest] = extremes(&greys, shades.width.div_ceil(2), reach / 2);
    let vote = |(grey, (high, low)): (&f32, (&f32, &f32))| {
        f64::from(if grey - low > high - grey { high - low } else { low - high })
    };
    greys.iter().zip(highest.iter().zip(&lowest)).map(vote).sum::<f64>() < 0.0
}

/// Adds parts of the surface that lie along the border and are as narrow as strokes: a table there is broader.
fn add_border(ink: &mut Ink, surface: &Ink) {
    let width = ink.stroke_width();
    for part in surface.without(ink).parts() {
        let (area, edge) = (part.len() as f64, surface.edge(&part).max(1) as f64);
        let is_stroke = 2.0 * area <= BROADEST * width * edge && area >= SMALLEST * width * width;
        if is_stroke && part.iter().any(|&index| surface.is_border(index)) {
            ink.add(&part);
        }
    }
}
