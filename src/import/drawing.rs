//! Drawings: polylines within a unit box, and the errors of their import.

use glam::DVec2;

use crate::echo;
use crate::import::Line;

/// Bytes of a file, at most.
pub const MOST_BYTES: usize = 64 << 20;
/// Limit of lines of a drawing: the limit of focal points.
const MOST_LINES: usize = crate::scene::check::MOST_FOCI;
/// Limits of points of all lines, as read and as kept.
pub const MOST_READ: usize = 200_000;
const MOST_POINTS: usize = 20_000;
/// Largest deviation of a line from the original, relative to the drawing's longer side.
const TOLERANCE: f64 = 1.0 / 4000.0;

/// Lines about the origin, y upwards; the longer side of the box around them is 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawing {
    /// The longest first.
    pub lines: Vec<Line>,
    /// Width and height.
    pub size: DVec2,
    /// m, the longer side as the file states it; `None` for pictures, which state none.
    pub side: Option<f64>,
    /// Distances of each line's ends from the nearest earlier line; infinite without one.
    pub(super) gaps: Vec<[f64; 2]>,
    /// Omissions, a sentence each.
    pub remarks: Vec<String>,
}

/// Reasons for a file without a drawing.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ImportError {
    #[error("the file has {} MiB, the limit is {}", .0 >> 20, MOST_BYTES >> 20)]
    TooLarge(usize),
    #[error("this is neither an SVG nor a PNG, JPEG or BMP picture")]
    UnknownFormat,
    #[error("the file cannot be unpacked: {}", echo::line(.0))]
    Compressed(String),
    #[error("the SVG cannot be read: {0}")]
    Svg(String),
    #[error("the SVG has no painted path{}", if *.has_text { "; convert its text to paths first" } else { "" })]
    NoPaths { has_text: bool },
    #[error("nothing of the SVG is seen: {}", echo::line(.0))]
    Unseen(String),
    #[error("the picture cannot be read: {}", echo::line(.0.trim_end()))]
    Picture(String),
    #[error("the picture is blank: it has no strokes")]
    Blank,
    #[error(
        "the picture has no dark strokes on light paper: it seems to be a photograph or a painted surface"
    )]
    NoStrokes,
    #[error("the drawing has {0} lines, the limit is {MOST_LINES}")]
    TooManyLines(usize),
    #[error("the drawing has {0} points, the limit is {MOST_READ}: simplify it first")]
    TooDetailed(usize),
}

impl Drawing {
    /// The drawing of lines of any size and position; non-finite points are left out.
    pub(super) fn new(lines: Vec<Line>, remarks: Vec<String>) -> Result<Self, ImportError> {
        Self::of_unit(lines, remarks, None)
    }

    /// As [`Self::new`], with the lines' unit in metres if it is known.
    pub(super) fn of_unit(
        mut lines: Vec<Line>,
        remarks: Vec<String>,
        unit: Option<f64>,
    ) -> Result<Self, ImportError> {
        lines.retain(|line| !line.points.is_empty() && line.points.iter().all(|point| point.is_finite()));
        let points = || lines.iter().flat_map(|line| &line.points).copied();
        let (Some(low), Some(high)) = (points().reduce(DVec2::min), points().reduce(DVec2::max)) else {
            return Err(ImportError::NoPaths { has_text: false });
        };
        let side = (high - low).max_element();
        if side <= 0.0 || !side.is_finite() {
            return Err(ImportError::NoPaths { has_text: false });
        }
        if lines.len() > MOST_LINES {
            return Err(ImportError::TooManyLines(lines.len()));
        }
        let count = points().count();
        if count > MOST_READ {
            return Err(ImportError::TooDetailed(count));
        }
        let middle = (low + high) / 2.0;
        for line in &mut lines {
            line.points.iter_mut().for_each(|point| *point = (*point - middle) / side);
        }
        let mut lines = sparse(&lines);
        lines.sort_by(|a, b| b.length().total_cmp(&a.length()));
        let gaps = gaps(&lines);
        Ok(Self { lines, size: (high - low) / side, side: unit.map(|unit| side * unit), gaps, remarks })
    }
}

/// The lines simplified within the tolerance, and further if still too many.
pub fn sparse(lines: &[Line]) -> Vec<Line> {
    let mut tolerance = TOLERANCE;
    loop {
        let sparse: Vec<_> = lines.iter().map(|line| line.with_at_most(MOST_LINES, tolerance)).collect();
        if sparse.iter().map(|line| line.points.len()).sum::<usize>() <= MOST_POINTS {
            return sparse;
        }
        tolerance *= 2.0;
    }
}

/// Distances of every line's ends from the nearest of the earlier lines.
pub fn gaps(lines: &[Line]) -> Vec<[f64; 2]> {
    let low = |line: &Line| line.points.iter().copied().fold(DVec2::INFINITY, DVec2::min);
    let high = |line: &Line| line.points.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max);
    let boxes: Vec<_> = lines.iter().map(|line| (low(line), high(line))).collect();
    let gap = |end: DVec2, earlier: usize| {
        let mut nearest = f64::INFINITY;
        for (line, &(low, high)) in lines[..earlier].iter().zip(&boxes) {
            if end.distance(end.clamp(low, high)) < nearest {
                nearest = nearest.min(line.distance(end));
            }
        }
        nearest
    };
    let ends = |line: &Line| [line.points[0], line.points[line.points.len() - 1]];
    lines.iter().enumerate().map(|(i, line)| ends(line).map(|end| gap(end, i))).collect()
}
