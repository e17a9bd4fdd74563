//! The ink of a picture: dark pixels, and strokes thinned to lines of one pixel.

use glam::DVec2;

/// The dark pixels of a picture with a margin of one light pixel all around.
#[derive(Clone, Debug)]
pub struct Ink {
    pub width: usize,
    dark: Vec<bool>,
}

impl Ink {
    /// The ink of a picture of `width` x `height` without its margin, from its dark pixels (x, y).
    pub fn new(width: usize, height: usize, dark: impl Iterator<Item = (usize, usize)>) -> Self {
        let (width, height) = (width + 2, height + 2);
        let mut ink = Self { width, dark: vec![false; width * height] };
        for (x, y) in dark {
            ink.dark[(y + 1) * width + x + 1] = true;
        }
        ink
    }

    /// Indices of the dark pixels, row by row.
    pub fn dark(&self) -> impl Iterator<Item = usize> {
        self.dark.iter().enumerate().filter(|(_, dark)| **dark).map(|(index, _)| index)
    }

    pub fn is_dark(&self, index: usize) -> bool {
        self.dark[index]
    }

    pub fn pixels(&self) -> usize {
        self.dark.len()
    }

    /// Neighbouring pixels, clockwise from the one above.
    pub fn neighbours(&self, index: usize) -> [usize; 8] {
        let (w, i) = (self.width, index);
        [i - w, i - w + 1, i + 1, i + w + 1, i + w, i + w - 1, i - 1, i - w - 1]
    }

    /// x to the right and y downwards.
    pub fn place(&self, index: usize) -> DVec2 {
        DVec2::new((index % self.width) as f64, (index / self.width) as f64)
    }

    /// Whether a pixel is one of the picture's outermost.
    pub fn is_border(&self, index: usize) -> bool {
        let (x, y, height) = (index % self.width, index / self.width, self.dark.len() / self.width);
        x == 1 || y == 1 || x == self.width - 2 || y == height - 2
    }

    /// Number of pixels, of some dark ones, that are beside a light one.
    pub fn edge(&self, pixels: &[usize]) -> usize {
        let is_edge = |&&index: &&usize| {
            [index - 1, index + 1, index - self.width, index + self.width]
                .iter()
                .any(|&beside| !self.dark[beside])
        };
        pixels.iter().filter(is_edge).count()
    }

    /// Mean width of strokes in pixels, from their area and edges.
    pub fn stroke_width(&self) -> f64 {
        let dark: Vec<_> = self.dark().collect();
        2.0 * dark.len() as f64 / self.edge(&dark).max(1) as f64
    }

    /// Mean width over the area, of the mean along strokes: 1 for one width, 1.6 if every second stroke is very thin.
    pub fn unevenness(&self) -> f64 {
        const DIAGONAL: f32 = std::f32::consts::SQRT_2;
        let far = self.dark.len() as f32;
        let mut distances: Vec<f32> = self.dark.iter().map(|&dark| if dark { far } else { 0.0 }).collect();
        let dark: Vec<_> = self.dark().collect();
        // Distances from light pixels in two sweeps (Borgefors 1986).
        let mut sweep = |index: usize, beside: [usize; 4]| {
            let steps = beside.into_iter().zip([1.0, DIAGONAL, 1.0, DIAGONAL]);
            let nearest = steps.map(|(beside, step)| distances[beside] + step).fold(f32::INFINITY, f32::min);
            distances[index] = distances[index].min(nearest);
        };
        for &index in &dark {
            let [above, above_right, .., left, above_left] = self.neighbours(index);
            sweep(index, [above, above_right, left, above_left]);
        }
        for &index in dark.iter().rev() {
            let [_, _, right, below_right, below, below_left, ..] = self.neighbours(index);
            sweep(index, [right, below_right, below, below_left]);
        }
        // From the edge, half a pixel before a light centre, a stroke's mean distance is a quarter of its width.
        let sum: f64 = dark.iter().map(|&index| f64::from(distances[index]) - 0.5).sum();
        4.0 * sum / dark.len().max(1) as f64 / self.stroke_width()
    }

    /// The dark pixels that are light in other ink of the same size.
    pub fn without(&self, other: &Self) -> Self {
        let dark = self.dark.iter().zip(&other.dark).map(|(own, other)| *own && !other);
        Self { width: self.width, dark: dark.collect() }
    }

    /// Connected parts.
    pub fn parts(&self) -> Vec<Vec<usize>> {
        let mut is_left = self.dark.clone();
        let mut parts = Vec::new();
        for start in self.dark() {
            if !std::mem::take(&mut is_left[start]) {
                continue;
            }
            let (mut part, mut seen) = (vec![start], 0);
            while let Some(&index) = part.get(seen) {
                seen += 1;
                let around = self.neighbours(index).into_iter();
                part.extend(around.filter(|&neighbour| std::mem::take(&mut is_left[neighbour])));
            }
            parts.push(part);
        }
        parts
    }

    /// Darkens pixels.
    pub fn add(&mut self, pixels: &[usize]) {
        pixels.iter().for_each(|&index| self.dark[index] = true);
    }

    /// Thins strokes to lines of one pixel, preserving ends (Guo and Hall 1989).
    pub fn thin(&mut self) {
        let mut left: Vec<usize> = self.dark().collect();
        let (mut is_second, mut idle) = (false, 0);
        while idle < 2 {
            let goes: Vec<_> = left.iter().copied().filter(|&index| self.goes(index, is_second)).collect();
            idle = if goes.is_empty() { idle + 1 } else { 0 };
            for &index in &goes {
                self.dark[index] = false;
            }
            left.retain(|&index| self.dark[index]);
            is_second = !is_second;
        }
    }

    /// Whether a boundary pixel can be removed without splitting or shortening a stroke.
    fn goes(&self, index: usize, is_second: bool) -> bool {
        let [p2, p3, p4, p5, p6, p7, p8, p9] = self.neighbours(index).map(|neighbour| self.dark[neighbour]);
        let count = |pairs: [bool; 4]| pairs.into_iter().filter(|&pair| pair).count();
        let parts = count([!p2 && (p3 || p4), !p4 && (p5 || p6), !p6 && (p7 || p8), !p8 && (p9 || p2)]);
        let around = count([p9 || p2, p3 || p4, p5 || p6, p7 || p8]).min(count([
            p2 || p3,
            p4 || p5,
            p6 || p7,
            p8 || p9,
        ]));
        let is_open = if is_second { !((p2 || p3 || !p5) && p4) } else { !((p6 || p7 || !p9) && p8) };
        parts == 1 && (2..=3).contains(&around) && is_open
    }
}
