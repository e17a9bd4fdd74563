//! A table of words and numbers.

use crate::picture::figure::font;
use crate::picture::figure::layout::{CAPITAL, Frame, GAP, HAIRLINE, LABEL, Pen};
use crate::picture::figure::mark::{Anchor, BLACK, Mark};

/// Height of a row, and the space between columns.
const ROW: f64 = 4.2;
const BETWEEN: f64 = 4.0;

/// Rows of cells; the first column is aligned to the left, the others to the right.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    pub head: Vec<String>,
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// The widths of the columns, mm.
    fn columns(&self) -> Vec<f64> {
        let width = |column: usize| {
            let cells = std::iter::once(&self.head).chain(&self.rows).filter_map(|row| row.get(column));
            cells.map(|cell| font::width(cell, LABEL)).fold(0.0, f64::max)
        };
        (0..self.head.len()).map(width).collect()
    }

    /// mm
    fn size(&self) -> [f64; 2] {
        let columns = self.columns();
        let gaps = BETWEEN * columns.len().saturating_sub(1) as f64;
        [columns.iter().sum::<f64>() + gaps, ROW * (self.rows.len() + 1) as f64 + GAP]
    }

    /// Height over width: a table that fits has its own height.
    pub(in crate::picture) fn height(&self, width: f64) -> f64 {
        let [wide, high] = self.size();
        high * (width / wide.max(1e-9)).min(1.0)
    }

    pub(in crate::picture) fn marks(&self, frame: &Frame) -> Vec<Mark> {
        let mut pen = Pen::new(frame);
        let ([left, top], [width, height], [wide, high]) = (frame.corner(), frame.size(), self.size());
        let scale = (width / wide.max(1e-9)).min(height / high).min(1.0);
        let columns = self.columns();
        let rule = |y: f64| [[left, top + y * scale], [left + wide * scale, top + y * scale]];
        for y in [0.0, ROW, high] {
            pen.line(&rule(y), HAIRLINE, BLACK);
        }
        for (index, row) in std::iter::once(&self.head).chain(&self.rows).enumerate() {
            let gap = if index == 0 { 0.0 } else { GAP / 2.0 };
            let base = top + (ROW * (index as f64 + 0.5) + gap + LABEL * CAPITAL / 2.0) * scale;
            let mut x = 0.0;
            for (column, (cell, column_width)) in row.iter().zip(&columns).enumerate() {
                let (anchor, at) =
                    if column == 0 { (Anchor::Start, x) } else { (Anchor::End, x + column_width) };
                pen.list.push(Mark::text([left + at * scale, base], LABEL * scale, anchor, BLACK, cell));
                x += column_width + BETWEEN;
            }
        }
        pen.list
    }
}
