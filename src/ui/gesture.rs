//! Edits in progress: what a pointer or a text being typed holds.

use std::collections::BTreeSet;

use glam::{DVec2, DVec3};

use crate::import::curve::Knot;
use crate::scene::{Body, Motion, Target};
use crate::ui::view::Lens;

/// Pick distance (points) between the ends of a stroke.
const CLOSES: f64 = 14.0;

/// A grabbed motion path: one of its handles, or the curve between them.
#[derive(Clone, Debug)]
pub struct Pull {
    /// The target's index, or `None` for the scene's motion.
    pub target: Option<usize>,
    /// Origin of its offsets, m.
    pub centre: DVec3,
    pub handle: Option<usize>,
    /// Grabbed point in the plane, m.
    pub from: DVec2,
    pub before: Motion,
}

/// The last grabbed vertex or keyframe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Vertex {
    pub target: Option<usize>,
    pub index: usize,
}

/// An edit in progress while the button is held.
#[derive(Clone, Debug)]
pub enum Gesture {
    Pan,
    /// Starting point, and the targets before.
    Move {
        from: DVec2,
        before: Vec<(usize, Target)>,
        /// Grabbed inside the box of the selection, beside the outlines: a click there clears the selection.
        beside: bool,
    },
    /// A handle of the single selected target, and its state before.
    Pull {
        index: usize,
        handle: usize,
        before: Box<Target>,
    },
    /// The path of a motion.
    Way(Pull),
    /// A body, grabbed inside or by the handle that turns it, and its state before.
    Body {
        index: usize,
        from: DVec2,
        before: Box<Body>,
        turns: bool,
    },
    Band {
        from: DVec2,
        /// Selected before, and kept.
        kept: BTreeSet<usize>,
    },
    /// A shape being drawn: its index in the scene once it has a size.
    Draw {
        from: DVec2,
        index: Option<usize>,
    },
    Stroke {
        points: Vec<DVec2>,
        index: Option<usize>,
    },
    /// The handle of the pen's last knot follows the pointer, which was pressed here.
    Bend {
        from: DVec2,
    },
    Brush {
        /// Position in the previous frame.
        last: Option<DVec2>,
        /// The painted picture, once it exists.
        index: Option<usize>,
    },
    Erase {
        last: Option<DVec2>,
    },
    /// A line is measured from here.
    Measure {
        fixed: DVec2,
    },
    /// The selection is being scaled or rotated.
    Transform {
        grip: Grip,
        from: DVec2,
        before: Vec<(usize, Target)>,
    },
}

/// A text being typed.
#[derive(Clone, Debug)]
pub struct Typing {
    pub at: DVec2,
    pub text: String,
    /// Letters that were typed last and that the font lacks.
    pub lacking: Vec<char>,
    /// Its index in the scene once it is not empty.
    pub index: Option<usize>,
}

impl Typing {
    pub fn new(at: DVec2) -> Self {
        Self { at, text: String::new(), lacking: Vec::new(), index: None }
    }
}

/// A path being drawn with the pen.
#[derive(Clone, Debug, Default)]
pub struct Pen {
    /// m in the plane
    pub knots: Vec<Knot>,
    /// Its index in the scene, once it has two knots.
    pub index: Option<usize>,
}

/// The grabbed part of the box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Grip {
    /// A corner, and the fixed opposite one: m in the plane.
    Corner { held: DVec2, fixed: DVec2 },
    /// Rotation about this point.
    Turn(DVec2),
}

/// Whether a stroke ends close to its start.
pub fn closes(points: &[DVec2], lens: &Lens) -> bool {
    let reach = CLOSES * lens.window.scale;
    let [first, .., last] = points else { return false };
    let length: f64 = points.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
    points.len() > 4 && first.distance(*last) <= reach && length > 4.0 * reach
}
