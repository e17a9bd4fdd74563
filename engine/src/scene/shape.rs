//! Shapes: their kinds, the one table of their keys, and what all other modules ask of a shape.

use std::path::Path;

use glam::DVec3;
use serde::ser::{Serialize, SerializeMap, Serializer};
use strum::{EnumDiscriminants, EnumIs, EnumString, IntoStaticStr, VariantArray, VariantNames};

use crate::scene::{pixels::Pixels, trap::Trap};

/// m; scaling and dragging stop at this size.
pub(super) const SMALLEST: f64 = 1e-3;
/// m: length of the arrow that stands for a direction.
pub(super) const ARROW: f64 = 0.1;

/// The outline of a target. Lengths in m. The brightness of a picture prescribes |p|²; its file is relative to the
/// scene's folder, or absolute. The charge of a trap for a bead is the topological one of a vortex.
#[derive(Clone, Debug, PartialEq, EnumDiscriminants, EnumIs, IntoStaticStr)]
#[strum_discriminants(name(Kind), derive(EnumString, IntoStaticStr, VariantArray, VariantNames))]
#[strum_discriminants(strum(serialize_all = "lowercase", const_into_str))]
pub enum Shape {
    Point {
        at: DVec3,
    },
    Line {
        from: DVec3,
        to: DVec3,
    },
    Circle {
        at: DVec3,
        radius: f64,
    },
    Rectangle {
        at: DVec3,
        width: f64,
        height: f64,
    },
    Triangle {
        at: DVec3,
        size: f64,
    },
    Polygon {
        at: DVec3,
        radius: f64,
        sides: u32,
    },
    Path {
        vertices: Vec<DVec3>,
        closed: bool,
    },
    Text {
        text: String,
        at: DVec3,
        height: f64,
    },
    Picture {
        file: String,
        at: DVec3,
        width: f64,
        pixels: Pixels,
    },
    Trap {
        at: DVec3,
        trap: Trap,
        charge: i32,
    },
    /// A plane wave towards this direction, of any length.
    Direction {
        direction: DVec3,
    },
}

/// A key of a shape in the scene file, and its row in the window.
#[derive(Debug)]
pub struct ShapeKey<'a> {
    pub name: &'static str,
    /// Label and description of the row.
    pub row: (&'static str, &'static str),
    pub value: ShapeValue<'a>,
}

/// The value of a key. Its type has the unit and the limits.
#[derive(Debug, serde::Serialize)]
#[serde(untagged)]
pub enum ShapeValue<'a> {
    /// m
    Point(&'a mut DVec3),
    /// m
    Vertices(&'a mut Vec<DVec3>),
    /// m
    Length(&'a mut f64),
    Sides(&'a mut u32),
    Closed(&'a mut bool),
    Letters(&'a mut String),
    File(&'a mut String),
    Trap(&'a mut Trap),
    /// Of any length but zero.
    Direction(&'a mut DVec3),
    Charge(&'a mut i32),
}

impl Serialize for Shape {
    fn serialize<S: Serializer>(&self, format: S) -> Result<S::Ok, S::Error> {
        let mut table = format.serialize_map(None)?;
        table.serialize_entry("kind", Kind::from(self).into_str())?;
        for key in self.clone().keys() {
            table.serialize_entry(key.name, &key.value)?;
        }
        table.end()
    }
}

impl Kind {
    /// The kind of targets without one.
    pub fn point() -> Self {
        Self::Point
    }

    /// A shape with the default of every key.
    pub fn usual(self) -> Shape {
        let at = DVec3::new(0.0, 0.0, 0.1);
        let side = DVec3::new(0.02, 0.0, 0.0);
        match self {
            Self::Point => Shape::Point { at },
            Self::Line => Shape::Line { from: at - side, to: at + side },
            Self::Circle => Shape::Circle { at, radius: 0.02 },
            Self::Rectangle => Shape::Rectangle { at, width: 0.04, height: 0.04 },
            Self::Triangle => Shape::Triangle { at, size: 0.04 },
            Self::Polygon => Shape::Polygon { at, radius: 0.02, sides: 6 },
            Self::Path => Shape::Path { vertices: Vec::new(), closed: false },
            Self::Text => Shape::Text { text: "HIT".to_owned(), at, height: 0.04 },
            Self::Picture => {
                Shape::Picture { file: String::new(), at, width: 0.08, pixels: Pixels::default() }
            }
            Self::Trap => Shape::Trap { at, trap: Trap::default(), charge: 1 },
            Self::Direction => Shape::Direction { direction: DVec3::Z },
        }
    }
}

/// A direction as a unit vector; +z of a zero vector, which the checks refuse.
fn unit(direction: DVec3) -> DVec3 {
    direction.try_normalize().unwrap_or(DVec3::Z)
}

/// Name of a regular polygon.
fn polygon(sides: u32) -> String {
    let name = match sides {
        3 => "Triangle",
        4 => "Square",
        5 => "Pentagon",
        6 => "Hexagon",
        7 => "Heptagon",
        8 => "Octagon",
        9 => "Nonagon",
        10 => "Decagon",
        12 => "Dodecagon",
        sides => return format!("Polygon ({sides} sides)"),
    };
    name.to_owned()
}

impl Shape {
    /// Its keys: the scene file, the checks, the window and all moves read this table.
    pub fn keys(&mut self) -> Vec<ShapeKey<'_>> {
        use ShapeValue::{Charge, Closed, File, Length, Letters, Point, Sides, Vertices};
        const CENTRE: (&str, &str) = ("Centre", "");
        let rows = match self {
            Self::Point { at } => vec![("at", ("At", ""), Point(at))],
            Self::Line { from, to } => {
                vec![("from", ("From", ""), Point(from)), ("to", ("To", ""), Point(to))]
            }
            Self::Circle { at, radius } => vec![
                ("at", CENTRE, Point(at)),
                ("radius", ("Radius", "From the centre to the line"), Length(radius)),
            ],
            Self::Rectangle { at, width, height } => vec![
                ("at", CENTRE, Point(at)),
                ("width", ("Width", "Along x"), Length(width)),
                ("height", ("Height", "Along y"), Length(height)),
            ],
            Self::Triangle { at, size } => {
                vec![("at", CENTRE, Point(at)), ("size", ("Side", "Length of a side"), Length(size))]
            }
            Self::Polygon { at, radius, sides } => vec![
                ("at", CENTRE, Point(at)),
                ("radius", ("Radius", "From the centre to a corner"), Length(radius)),
                ("sides", ("Sides", "Number of corners"), Sides(sides)),
            ],
            Self::Path { vertices, closed } => vec![
                ("vertices", CENTRE, Vertices(vertices)),
                ("closed", ("Closed", "The last vertex joins the first"), Closed(closed)),
            ],
            Self::Text { text, at, height } => vec![
                ("text", ("Text", ""), Letters(text)),
                ("at", CENTRE, Point(at)),
                ("height", ("Letter height", "Of a capital letter"), Length(height)),
            ],
            Self::Picture { file, at, width, pixels: _ } => vec![
                ("file", ("Picture", "Brightness is target pressure squared"), File(file)),
                ("at", CENTRE, Point(at)),
                ("width", ("Width", "Of the picture"), Length(width)),
            ],
            Self::Trap { at, trap, charge } => vec![
                ("at", ("At", ""), Point(at)),
                ("trap", ("Trap", ""), ShapeValue::Trap(trap)),
                ("charge", ("Turns", ""), Charge(charge)),
            ],
            Self::Direction { direction } => {
                let row =
                    ("Direction", "x, y, z of the direction of a plane wave; its length does not count");
                vec![("direction", row, ShapeValue::Direction(direction))]
            }
        };
        rows.into_iter().map(|(name, row, value)| ShapeKey { name, row, value }).collect()
    }

    /// Its points: the centre, both ends, or the vertices; m.
    pub fn points(&mut self) -> Vec<&mut DVec3> {
        let mut points = Vec::new();
        for key in self.keys() {
            match key.value {
                ShapeValue::Point(at) => points.push(at),
                ShapeValue::Vertices(vertices) => points.extend(vertices),
                ShapeValue::Length(_)
                | ShapeValue::Sides(_)
                | ShapeValue::Closed(_)
                | ShapeValue::Letters(_)
                | ShapeValue::File(_)
                | ShapeValue::Trap(_)
                | ShapeValue::Direction(_)
                | ShapeValue::Charge(_) => {}
            }
        }
        points
    }

    /// The centre of rotation, which is also its position for edits; m. Of a direction the tip of its arrow.
    pub fn centre(&self) -> DVec3 {
        match self {
            Self::Line { from, to } => (*from + *to) / 2.0,
            Self::Path { vertices, .. } => vertices.iter().sum::<DVec3>() / vertices.len().max(1) as f64,
            Self::Point { at }
            | Self::Circle { at, .. }
            | Self::Rectangle { at, .. }
            | Self::Triangle { at, .. }
            | Self::Polygon { at, .. }
            | Self::Text { at, .. }
            | Self::Picture { at, .. }
            | Self::Trap { at, .. } => *at,
            Self::Direction { direction } => unit(*direction) * ARROW,
        }
    }

    /// Moves its centre to this point (m); turns a direction towards it.
    pub fn move_to(&mut self, place: DVec3) {
        if let Self::Direction { direction } = self {
            *direction = place.try_normalize().unwrap_or(*direction);
        }
        let by = place - self.centre();
        match &mut self.points()[..] {
            [at] => **at = place,
            points => points.iter_mut().for_each(|at| **at += by),
        }
    }

    /// Moves it (m); turns the arrow of a direction.
    pub fn translate(&mut self, by: DVec3) {
        if self.is_direction() {
            self.move_to(self.centre() + by);
        }
        self.points().into_iter().for_each(|at| *at += by);
    }

    /// Scales its lengths, and moves its points.
    pub fn scale(&mut self, factor: f64, place: impl Fn(&mut DVec3)) {
        self.points().into_iter().for_each(place);
        for key in self.keys() {
            if let ShapeValue::Length(length) = key.value {
                *length = (*length * factor).max(SMALLEST);
            }
        }
    }

    /// Whether it has no outline to sample: a point and a direction are their own focal points, a trap its lobes, a
    /// picture its area.
    pub fn is_whole(&self) -> bool {
        self.is_point() || self.is_direction() || self.is_trap() || self.is_picture()
    }

    /// Whether it lies in a plane of its own, with a normal.
    pub fn is_flat(&self) -> bool {
        !(self.is_point() || self.is_direction() || self.is_line() || self.is_path())
    }

    /// Whether a rotation about its centre changes nothing.
    pub fn is_round(&self) -> bool {
        self.is_point() || self.is_direction() || self.is_circle()
    }

    /// Whether it has an inside that can be filled.
    ///
    /// # Errors
    /// The reason why it has none.
    pub fn inside(&self) -> Result<(), &'static str> {
        match self {
            Self::Circle { .. } | Self::Rectangle { .. } | Self::Triangle { .. } | Self::Polygon { .. } => {
                Ok(())
            }
            Self::Path { closed: true, .. } => Ok(()),
            Self::Path { closed: false, .. } => {
                Err("an open path has no inside: give `closed = true`, or `stroke`, a width in metres")
            }
            Self::Line { .. } => Err("a line has no inside: give `stroke`, a width in metres, instead"),
            Self::Text { .. } => Err("letters are strokes: give `stroke`, their width in metres, instead"),
            Self::Point { .. } | Self::Trap { .. } | Self::Picture { .. } | Self::Direction { .. } => {
                Err("only closed shapes are filled")
            }
        }
    }

    /// Default name of its targets.
    pub fn title(&self) -> String {
        match self {
            Self::Polygon { sides, .. } => polygon(*sides),
            Self::Path { vertices, .. } => format!("Path ({} points)", vertices.len()),
            Self::Text { text, .. } => format!("Text “{text}”"),
            Self::Picture { file, .. } => {
                let name = Path::new(file).file_name().map_or(file.into(), |name| name.to_string_lossy());
                format!("Picture {name}")
            }
            Self::Trap { trap, .. } => trap.name().to_owned(),
            Self::Point { .. }
            | Self::Line { .. }
            | Self::Circle { .. }
            | Self::Rectangle { .. }
            | Self::Triangle { .. }
            | Self::Direction { .. } => <&str>::from(self).to_owned(),
        }
    }

    /// Its size, with lengths as text by `mm`; `None` of a shape without lengths.
    pub fn size(&self, mm: impl Fn(f64) -> String) -> Option<String> {
        Some(match self {
            Self::Point { .. }
            | Self::Trap { .. }
            | Self::Line { .. }
            | Self::Path { .. }
            | Self::Direction { .. } => return None,
            Self::Circle { radius, .. } => format!("Ø {} mm", mm(2.0 * radius)),
            Self::Rectangle { width, height, .. } => format!("{} x {} mm", mm(*width), mm(*height)),
            Self::Triangle { size, .. } => format!("side {} mm", mm(*size)),
            Self::Polygon { radius, sides, .. } => format!("Ø {} mm, {sides} corners", mm(2.0 * radius)),
            Self::Text { height, .. } => format!("height {} mm", mm(*height)),
            Self::Picture { width, pixels, .. } => {
                format!("{} x {} mm", mm(*width), mm(width * pixels.aspect()))
            }
        })
    }

    /// The radius of a circle, m.
    pub fn circle(&self) -> Option<f64> {
        let Self::Circle { radius, .. } = *self else { return None };
        Some(radius)
    }

    /// The unit vector of a direction.
    #[doc(hidden)]
    pub fn direction(&self) -> Option<DVec3> {
        let Self::Direction { direction } = *self else { return None };
        Some(unit(direction))
    }

    /// A trap, with its charge.
    pub fn trap(&self) -> Option<(Trap, i32)> {
        let Self::Trap { trap, charge, .. } = *self else { return None };
        Some((trap, charge))
    }

    /// The letters of a text.
    pub fn text_mut(&mut self) -> Option<&mut String> {
        let Self::Text { text, .. } = self else { return None };
        Some(text)
    }

    /// The file, the width (m) and the pixels of a picture.
    pub fn picture(&self) -> Option<(&str, f64, &Pixels)> {
        let Self::Picture { file, width, pixels, .. } = self else { return None };
        Some((file, *width, pixels))
    }

    /// The file and the pixels of a picture.
    pub fn picture_mut(&mut self) -> Option<(&mut String, &mut Pixels)> {
        let Self::Picture { file, pixels, .. } = self else { return None };
        Some((file, pixels))
    }
}
