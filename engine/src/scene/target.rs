//! Targets: points, shapes, letters, pictures and traps, and their table in the scene file.

use glam::{DQuat, DVec3};
use serde::ser::SerializeMap;
use serde::{Deserialize, Serialize, Serializer};
use strum::VariantArray;

use crate::scene::modulation::Modulation;
use crate::scene::motion::MotionTable;
use crate::scene::range::{Key, KeyError};
use crate::scene::shape::Kind;
use crate::scene::shape::{Shape, ShapeKey, ShapeValue};
use crate::scene::solver::is_zero;
use crate::scene::{motion::Motion, trap::Trap};

/// A shape that becomes focal points.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Target {
    #[serde(flatten)]
    pub shape: Shape,
    /// Target pressure relative to the other targets.
    pub pressure: f64,
    /// Factors on `pressure` per vertex of a path, interpolated along the path; empty: constant.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub pressures: Vec<f64>,
    #[serde(flatten)]
    pub sampling: Sampling,
    /// rad, about the target's centre.
    #[serde(skip_serializing_if = "is_zero")]
    pub angle: f64,
    /// Normal of a flat shape; +z is parallel to the array.
    #[serde(skip_serializing_if = "is_z")]
    pub normal: DVec3,
    /// The step in which it is shown, from 0, with `path = "steps"`; `None`: in every step.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub step: Option<u32>,
    /// A hidden target is kept and not played.
    #[serde(skip_serializing_if = "is_true")]
    pub visible: bool,
    /// Name; empty: by its kind.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub name: String,
    /// Targets with the same group are selected together; empty: in no group.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub group: String,
    /// Phase (rad) that a keyframe adds to a trap's signature.
    #[serde(skip)]
    #[doc(hidden)]
    pub phase: f64,
    /// Its own motion, instead of the scene's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub motion: Option<Motion>,
    /// Its own modulation, instead of the scene's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub modulation: Option<Modulation>,
}

impl Target {
    /// A target of this shape with everything else at its default.
    pub fn new(shape: Shape) -> Self {
        let sampling = if shape.is_whole() { Sampling::Whole } else { Sampling::default() };
        Self {
            shape,
            pressure: 1.0,
            pressures: Vec::new(),
            sampling,
            angle: 0.0,
            normal: DVec3::Z,
            step: None,
            visible: true,
            name: String::new(),
            group: String::new(),
            phase: 0.0,
            motion: None,
            modulation: None,
        }
    }

    /// Whether it is an area: filled, a stroke of some width, or a picture.
    pub fn is_area(&self) -> bool {
        match self.sampling {
            Sampling::Fill | Sampling::Stroke(_) => true,
            Sampling::Whole => self.shape.is_picture(),
            Sampling::Continuous | Sampling::Spacing(_) | Sampling::Points(_) => false,
        }
    }

    /// Rotation of a flat shape from the array's plane.
    pub fn turn(&self) -> DQuat {
        facing(self.normal) * DQuat::from_rotation_z(self.angle)
    }

    /// Whether it is a picture without loaded pixels.
    pub fn lacks_pixels(&self) -> bool {
        self.shape.picture().is_some_and(|(_, _, pixels)| pixels.get().is_none())
    }

    /// Whether it is shown in a step of the motion.
    pub fn is_in(&self, step: u32) -> bool {
        self.visible && self.step.is_none_or(|own| own == step)
    }
}

/// The sampling of a shape: its outline as one stroke or as separate focal points, or an area.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Sampling {
    /// A point is its own focal point, a trap its lobes, a picture its whole area.
    Whole,
    /// A continuous stroke of even pressure, sampled as densely as the wavelength requires.
    #[default]
    Continuous,
    /// Distance between neighbours along the outline (m), as closely as the corners allow.
    Spacing(f64),
    /// Focal points on the whole outline.
    Points(usize),
    /// The area inside a closed outline.
    Fill,
    /// The area within half of this (m) of the outline.
    Stroke(f64),
}

impl Serialize for Sampling {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut keys = serializer.serialize_map(None)?;
        match self {
            Self::Whole | Self::Continuous => {}
            Self::Spacing(spacing) => keys.serialize_entry("spacing", spacing)?,
            Self::Points(points) => keys.serialize_entry("points", points)?,
            Self::Fill => keys.serialize_entry("fill", &true)?,
            Self::Stroke(width) => keys.serialize_entry("stroke", width)?,
        }
        keys.end()
    }
}

fn is_true(visible: &bool) -> bool {
    *visible
}

/// The rotation from +z to a normal.
pub(super) fn facing(normal: DVec3) -> DQuat {
    DQuat::from_rotation_arc(DVec3::Z, normal.try_normalize().unwrap_or(DVec3::Z))
}

pub(super) fn is_z(normal: &DVec3) -> bool {
    *normal == DVec3::Z
}

/// The `[[target]]` table as written: every key of every kind, so that stray keys are reported at their position.
#[doc(hidden)]
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TargetTable {
    #[serde(default = "Kind::point")]
    kind: Kind,
    at: Option<DVec3>,
    direction: Option<DVec3>,
    from: Option<DVec3>,
    to: Option<DVec3>,
    radius: Option<f64>,
    width: Option<f64>,
    height: Option<f64>,
    size: Option<f64>,
    sides: Option<u32>,
    vertices: Option<Vec<DVec3>>,
    closed: Option<bool>,
    text: Option<String>,
    file: Option<String>,
    trap: Option<Trap>,
    charge: Option<i32>,
    pressure: Option<f64>,
    pressures: Option<Vec<f64>>,
    spacing: Option<f64>,
    points: Option<usize>,
    fill: Option<bool>,
    stroke: Option<f64>,
    angle: Option<f64>,
    normal: Option<DVec3>,
    step: Option<u32>,
    visible: Option<bool>,
    #[serde(default)]
    name: String,
    #[serde(default)]
    group: String,
    motion: Option<MotionTable>,
    modulation: Option<Modulation>,
}

impl TargetTable {
    /// The target of this table, the `index`-th in the file.
    ///
    /// # Errors
    /// Missing keys, or keys of other kinds.
    pub fn into_target(mut self, index: usize) -> Result<Target, KeyError> {
        let table = &mut self;
        let refuse = |key: &'static str, message: &str| {
            Err(KeyError::new([Key::from("target"), Key::from(index), Key::from(key)], message))
        };
        if table.kind == Kind::Picture && table.file.is_none() {
            return refuse("file", "a target of kind `picture` needs the `file` that holds the picture");
        }
        let mut target = Target::new(table.kind.usual());
        for key in target.shape.keys() {
            table.take(key);
        }
        target.step = table.step;
        target.visible = table.visible.unwrap_or(target.visible);
        target.name = std::mem::take(&mut table.name);
        target.group = std::mem::take(&mut table.group);
        let under = |e: KeyError| e.under(&["target".into(), index.into(), "motion".into()]);
        target.motion = table.motion.take().map(MotionTable::into_motion).transpose().map_err(under)?;
        target.modulation = table.modulation.take();
        target.pressure = table.pressure.unwrap_or(target.pressure);
        if !(target.shape.is_point() || target.shape.is_direction()) {
            take(&mut table.angle, &mut target.angle);
        }
        if !target.shape.is_whole() {
            target.sampling = table.sampling(index)?.unwrap_or(target.sampling);
        }
        if target.shape.is_path() {
            take(&mut table.pressures, &mut target.pressures);
        }
        if target.shape.is_flat() {
            take(&mut table.normal, &mut target.normal);
        }
        match table.stray_key() {
            None => Ok(target),
            Some(key) => refuse(key, &format!("a target of kind `{}` has no such key", self.kind.into_str())),
        }
    }

    /// At most one of the sampling keys may be present.
    fn sampling(&mut self, index: usize) -> Result<Option<Sampling>, KeyError> {
        let given: Vec<_> = [
            self.spacing.take().map(|spacing| ("spacing", Sampling::Spacing(spacing))),
            self.points.take().map(|points| ("points", Sampling::Points(points))),
            self.fill.take().filter(|fill| *fill).map(|_| ("fill", Sampling::Fill)),
            self.stroke.take().map(|width| ("stroke", Sampling::Stroke(width))),
        ]
        .into_iter()
        .flatten()
        .collect();
        match given[..] {
            [] => Ok(None),
            [(_, sampling)] => Ok(Some(sampling)),
            [(first, _), (second, _), ..] => Err(KeyError::new(
                [Key::from("target"), Key::from(index), Key::from(second)],
                format!("give either `{first}` or `{second}`, not both"),
            )),
        }
    }

    /// Moves the value of a shape's key out of the table. Returns whether it was given.
    fn take(&mut self, key: ShapeKey<'_>) -> bool {
        match (key.name, key.value) {
            ("at", ShapeValue::Point(at)) => take(&mut self.at, at),
            ("from", ShapeValue::Point(from)) => take(&mut self.from, from),
            ("to", ShapeValue::Point(to)) => take(&mut self.to, to),
            ("radius", ShapeValue::Length(radius)) => take(&mut self.radius, radius),
            ("width", ShapeValue::Length(width)) => take(&mut self.width, width),
            ("height", ShapeValue::Length(height)) => take(&mut self.height, height),
            ("size", ShapeValue::Length(size)) => take(&mut self.size, size),
            (_, ShapeValue::Sides(sides)) => take(&mut self.sides, sides),
            (_, ShapeValue::Vertices(vertices)) => take(&mut self.vertices, vertices),
            (_, ShapeValue::Closed(closed)) => take(&mut self.closed, closed),
            (_, ShapeValue::Letters(text)) => take(&mut self.text, text),
            (_, ShapeValue::File(file)) => take(&mut self.file, file),
            (_, ShapeValue::Trap(trap)) => take(&mut self.trap, trap),
            (_, ShapeValue::Charge(charge)) => take(&mut self.charge, charge),
            (_, ShapeValue::Direction(direction)) => take(&mut self.direction, direction),
            (_, ShapeValue::Point(_) | ShapeValue::Length(_)) => false,
        }
    }

    /// A key unused by the kind, once the used ones are taken.
    fn stray_key(&mut self) -> Option<&'static str> {
        let mut others: Vec<_> = Kind::VARIANTS.iter().map(|kind| kind.usual()).collect();
        let keys = others.iter_mut().flat_map(Shape::keys);
        let of_shape = keys.map(|key| (key.name, self.take(key))).find(|(_, given)| *given);
        let of_target = [
            ("pressures", self.pressures.is_some()),
            ("spacing", self.spacing.is_some()),
            ("points", self.points.is_some()),
            ("fill", self.fill.is_some()),
            ("stroke", self.stroke.is_some()),
            ("angle", self.angle.is_some()),
            ("normal", self.normal.is_some()),
        ];
        of_shape.into_iter().chain(of_target).find_map(|(key, given)| given.then_some(key))
    }
}

fn take<T>(given: &mut Option<T>, value: &mut T) -> bool {
    given.take().map(|given| *value = given).is_some()
}
