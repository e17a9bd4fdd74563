//! The drawing tools of the canvas, and the targets that they create.

use std::f64::consts::TAU;

use std::ops::RangeInclusive;

use egui::{Key, Painter, Pos2, Rect, Stroke, StrokeKind};
use glam::DVec2;
use strum::{IntoStaticStr, VariantArray};

use crate::scene::{Pixels, Scene, Shape, Target};
use crate::ui::view::Axes;

/// Size of a target drawn by a click, m.
const DEFAULT_SIZE: f64 = 0.04;
/// m: shapes smaller than this are slips of the hand.
const SMALLEST: f64 = 1e-3;
/// Limits of a brush's diameter (m) and brightness.
pub const DIAMETER: RangeInclusive<f64> = 1e-3..=0.1;
pub const BRIGHTNESS: RangeInclusive<f64> = 0.01..=1.0;
/// Factor of a brush's size per key press.
pub const STEP: f64 = 1.25;

/// The brush of the tool of this name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Brush {
    /// m
    pub diameter: f64,
    /// Target |p|² of the paint relative to white.
    pub brightness: f64,
}

impl Default for Brush {
    fn default() -> Self {
        Self { diameter: 0.006, brightness: 1.0 }
    }
}

impl Brush {
    pub fn scale(&mut self, factor: f64) {
        self.diameter = (self.diameter * factor).clamp(*DIAMETER.start(), *DIAMETER.end());
    }
}
#[derive(Clone, Copy, Debug, PartialEq, Eq, IntoStaticStr, VariantArray)]
#[strum(const_into_str)]
pub enum Tool {
    #[strum(serialize = "Select and move")]
    Select,
    Point,
    Line,
    Circle,
    Rectangle,
    Triangle,
    Polygon,
    Pen,
    Freehand,
    Text,
    Brush,
    Erase,
    Measure,
}

impl Tool {
    pub fn key(self) -> Key {
        match self {
            Self::Select => Key::V,
            Self::Point => Key::P,
            Self::Line => Key::L,
            Self::Circle => Key::C,
            Self::Rectangle => Key::R,
            Self::Triangle => Key::G,
            Self::Polygon => Key::Y,
            Self::Pen => Key::N,
            Self::Freehand => Key::F,
            Self::Text => Key::T,
            Self::Brush => Key::B,
            Self::Erase => Key::E,
            Self::Measure => Key::D,
        }
    }

    pub fn tooltip(self) -> &'static str {
        match self {
            Self::Select => {
                "Click to select, shift-click for more, drag to move, pull a handle to resize, drag over empty space to select \
                 a rectangle"
            }
            Self::Point => "Click to place a focal point; hold and drag it about",
            Self::Line => "Drag from end to end",
            Self::Circle => "Drag from the centre outwards",
            Self::Rectangle => "Drag from corner to corner",
            Self::Triangle => "Drag from the centre outwards",
            Self::Polygon => "Drag from the centre outwards; the number of sides is on the Scene page",
            Self::Pen => {
                "Click for corners, drag for curves; a click on the first knot closes, Enter or a double click ends. Curves are kept as \
                 the vertices of a path"
            }
            Self::Freehand => "Draw with the button held",
            Self::Text => "Click at the position of the text, then type; Enter ends",
            Self::Brush => {
                "Drag to paint target pressure, as a picture in the plane or on the selected one; size and brightness are \
                 above the map"
            }
            Self::Erase => {
                "Click or drag over targets to delete them; pictures are wiped as wide as the brush is"
            }
            Self::Measure => {
                "Drag a line: its length, its angle and the profile along it; drag an end to move it, Esc removes it"
            }
        }
    }

    /// The shape that a drag from one point of a cut to another draws.
    fn shape(self, axes: &Axes, from: DVec2, to: DVec2) -> Option<Shape> {
        let at = axes.world(from);
        let radius = from.distance(to);
        if radius < SMALLEST {
            return None;
        }
        Some(match self {
            Self::Line => Shape::Line { from: at, to: axes.world(to) },
            Self::Circle => Shape::Circle { at, radius },
            Self::Rectangle => {
                let size = (to - from).abs().max(DVec2::splat(SMALLEST));
                Shape::Rectangle { at: axes.world((from + to) / 2.0), width: size.x, height: size.y }
            }
            Self::Triangle => Shape::Triangle { at, size: radius * 3.0_f64.sqrt() },
            Self::Polygon => Shape::Polygon { at, radius, sides: 6 },
            Self::Select
            | Self::Point
            | Self::Pen
            | Self::Freehand
            | Self::Text
            | Self::Brush
            | Self::Erase
            | Self::Measure => return None,
        })
    }

    /// The target that a drag draws.
    pub fn drag(self, axes: &Axes, from: DVec2, to: DVec2) -> Option<Target> {
        self.shape(axes, from, to).map(|shape| facing(shape, axes))
    }

    /// With Shift, lines go in steps of 15° and rectangles become squares.
    pub fn straight(self, from: DVec2, to: DVec2) -> DVec2 {
        let offset = to - from;
        match self {
            Self::Line => {
                let step = TAU / 24.0;
                let angle = (offset.to_angle() / step).round() * step;
                from + DVec2::from_angle(angle) * offset.length()
            }
            Self::Rectangle => from + offset.signum() * offset.abs().max_element(),
            Self::Select
            | Self::Point
            | Self::Circle
            | Self::Triangle
            | Self::Polygon
            | Self::Pen
            | Self::Freehand
            | Self::Text
            | Self::Brush
            | Self::Erase
            | Self::Measure => to,
        }
    }

    /// The target that a click draws.
    pub fn click(self, axes: &Axes, at: DVec2) -> Option<Target> {
        let half = DEFAULT_SIZE / 2.0;
        match self {
            Self::Point => Some(Target::new(Shape::Point { at: axes.world(at) })),
            Self::Line => self.drag(axes, at - DVec2::X * half, at + DVec2::X * half),
            Self::Rectangle => self.drag(axes, at - DVec2::splat(half), at + DVec2::splat(half)),
            _ => self.drag(axes, at, at + DVec2::X * half),
        }
    }
}

/// Text that is being typed.
pub fn text(axes: &Axes, at: DVec2, text: &str) -> Target {
    let shape = Shape::Text { text: text.to_owned(), at: axes.world(at), height: DEFAULT_SIZE };
    facing(shape, axes)
}

/// A stroke through points of a cut.
pub fn path(axes: &Axes, points: &[DVec2], closed: bool) -> Target {
    Target::new(Shape::Path { vertices: points.iter().map(|&uv| axes.world(uv)).collect(), closed })
}

/// A black picture for painting: in the plane, of the scene plane's size and near its centre.
pub fn canvas(axes: &Axes, scene: &Scene, file: String) -> Target {
    /// Pixels in a wavelength, and of a side at most.
    const PER_WAVELENGTH: f64 = 10.0;
    const MOST: f64 = 512.0;
    let size = scene.plane.size;
    let pixel = (scene.wavelength() / PER_WAVELENGTH).max(size.max_element() / MOST);
    let [columns, rows] = (size / pixel).to_array().map(|count| count.round().clamp(1.0, MOST) as usize);
    let at = axes.world(axes.flat(scene.plane.centre));
    let shape = Shape::Picture { file, at, width: size.x, pixels: Pixels::black(columns, rows) };
    facing(shape, axes)
}

/// A target in the plane, upright there.
fn facing(shape: Shape, axes: &Axes) -> Target {
    let mut target = Target::new(shape);
    if target.shape.is_flat() {
        target.face(axes.x.cross(axes.y), axes.x);
        // A zero rotation is not written to the file.
        target.angle = if target.angle.abs() < 1e-9 { 0.0 } else { target.angle };
    }
    target
}

/// Draws a tool's picture on its button.
pub fn icon(painter: &Painter, tool: Tool, rect: Rect, stroke: Stroke) {
    let centre = rect.center();
    let r = rect.width().min(rect.height()) * 0.30;
    let at = |x: f32, y: f32| centre + egui::vec2(x, y) * r;
    let ring = |n: usize, turn: f64| -> Vec<Pos2> {
        let corner = |i: usize| {
            let angle = TAU * (i as f64 / n as f64 + turn);
            at(angle.cos() as f32, -angle.sin() as f32)
        };
        (0..n).map(corner).collect()
    };
    let closed = |points: Vec<Pos2>| {
        painter.add(egui::Shape::closed_line(points, stroke));
    };
    match tool {
        Tool::Select => closed(vec![
            at(-0.6, -1.0),
            at(0.8, 0.25),
            at(0.15, 0.3),
            at(0.5, 1.0),
            at(0.2, 1.1),
            at(-0.15, 0.45),
            at(-0.6, 0.8),
        ]),
        Tool::Point => {
            painter.circle_filled(centre, r * 0.35, stroke.color);
            painter.circle_stroke(centre, r * 0.85, Stroke::new(stroke.width * 0.7, stroke.color));
        }
        Tool::Line => {
            painter.line_segment([at(-0.9, 0.8), at(0.9, -0.8)], stroke);
        }
        Tool::Circle => {
            painter.circle_stroke(centre, r, stroke);
        }
        Tool::Rectangle => {
            let corners = Rect::from_two_pos(at(-1.0, -0.75), at(1.0, 0.75));
            painter.rect_stroke(corners, 0.0, stroke, StrokeKind::Middle);
        }
        Tool::Triangle => closed(ring(3, 0.25)),
        Tool::Polygon => closed(ring(6, 0.25)),
        Tool::Pen => {
            closed(vec![at(0.0, 1.0), at(-0.6, 0.1), at(-0.35, -1.0), at(0.35, -1.0), at(0.6, 0.1)]);
            painter.line_segment([at(0.0, 1.0), at(0.0, 0.05)], stroke);
            painter.circle_filled(at(0.0, 0.0), r * 0.2, stroke.color);
        }
        Tool::Freehand => {
            let wave = |i: u8| {
                let x = f32::from(i) / 10.0 - 1.0;
                at(x, (x * 4.0).sin() * 0.6)
            };
            painter.add(egui::Shape::line((0..=20).map(wave).collect(), stroke));
        }
        Tool::Text => {
            painter.line_segment([at(-0.8, -0.85), at(0.8, -0.85)], stroke);
            painter.line_segment([at(0.0, -0.85), at(0.0, 0.95)], stroke);
        }
        Tool::Brush => {
            painter.line_segment([at(1.0, -1.0), at(0.15, -0.05)], stroke);
            closed(vec![at(-0.2, -0.2), at(0.3, 0.3), at(-0.1, 0.75), at(-1.0, 1.0), at(-0.7, 0.2)]);
        }
        Tool::Erase => {
            closed(vec![at(-1.0, 0.35), at(0.1, -0.8), at(1.0, 0.05), at(-0.1, 1.0), at(-0.4, 1.0)]);
            painter.line_segment([at(-0.5, -0.2), at(0.45, 0.6)], stroke);
        }
        Tool::Measure => {
            closed(vec![at(-1.1, 0.55), at(0.55, -1.1), at(1.1, -0.55), at(-0.55, 1.1)]);
            for part in [0.2, 0.45, 0.7] {
                let from = at(-1.1 + 1.65 * part, 0.55 - 1.65 * part);
                painter.line_segment([from, from + egui::vec2(0.25, 0.25) * r], stroke);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::outline;
    use crate::ui::view::{Cut, View};

    #[test]
    fn shapes_lie_in_the_cut_that_they_are_drawn_on_and_stand_upright() {
        let scene = Scene::default();
        for cut in [Cut::Xy, Cut::Xz, Cut::Yz] {
            let axes = View { cut, ..View::of(&scene) }.axes(&scene);
            let (from, to) = (DVec2::new(-0.01, 0.08), DVec2::new(0.03, 0.1));
            for tool in Tool::VARIANTS {
                let Some(target) = tool.drag(&axes, from, to) else { continue };
                for point in outline::strokes(&target).unwrap().concat() {
                    assert!(axes.height(point).abs() < 1e-9, "{cut:?} {tool:?}: {point}");
                }
            }
            let corners = outline::strokes(&Tool::Rectangle.drag(&axes, from, to).unwrap()).unwrap().concat();
            let flat: Vec<_> = corners.into_iter().map(|p| axes.flat(p)).collect();
            for corner in [from, to, DVec2::new(from.x, to.y)] {
                assert!(flat.iter().any(|p| p.distance(corner) < 1e-9), "{cut:?}: {corner} in {flat:?}");
            }
            let letter = outline::strokes(&text(&axes, from, "L")).unwrap().concat();
            let lowest = letter.iter().map(|&p| axes.flat(p).y).fold(f64::INFINITY, f64::min);
            let at_bottom = letter.iter().filter(|&&p| axes.flat(p).y < lowest + 1e-6).count();
            assert!(at_bottom >= 2, "{cut:?}: an L stands on its foot");
        }
    }

    #[test]
    fn a_slip_of_the_hand_draws_nothing() {
        let scene = Scene::default();
        let axes = View::of(&scene).axes(&scene);
        assert_eq!(Tool::Circle.drag(&axes, DVec2::ZERO, DVec2::splat(1e-5)), None);
    }
}
