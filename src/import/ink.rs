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
