//! Targets: points, shapes, letters, pictures and traps, and their table in the scene file.

use glam::{DQuat, DVec3};
use serde::ser::SerializeMap;
use serde::{Deserialize, Serialize, Serializer};
use strum::{EnumString, IntoStaticStr, VariantNames};

use crate::scene::motion::MotionTable;
use crate::scene::pixels::Pixels;
use crate::scene::range::{Key, KeyError};
use crate::scene::{Motion, Trap};

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
    /// Its own motion, instead of the scene's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub motion: Option<Motion>,
}

impl Target {
    /// A target of this shape with everything else at its default.
    pub fn new(shape: Shape) -> Self {
        let is_whole = matches!(shape, Shape::Point { .. } | Shape::Trap { .. } | Shape::Picture { .. });
        let sampling = if is_whole { Sampling::Whole } else { Sampling::default() };
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
            motion: None,
        }
    }

    /// Whether it is an area: filled, a stroke of some width, or a picture.
    pub fn is_area(&self) -> bool {
        match self.sampling {
            Sampling::Fill | Sampling::Stroke(_) => true,
            Sampling::Whole => matches!(self.shape, Shape::Picture { .. }),
            Sampling::Continuous | Sampling::Spacing(_) | Sampling::Points(_) => false,
        }
    }

    /// Rotation of a flat shape from the array's plane.
    pub fn turn(&self) -> DQuat {
        let normal = self.normal.try_normalize().unwrap_or(DVec3::Z);
        DQuat::from_rotation_arc(DVec3::Z, normal) * DQuat::from_rotation_z(self.angle)
    }

    /// Whether it is a picture without loaded pixels.
    pub fn lacks_pixels(&self) -> bool {
        matches!(&self.shape, Shape::Picture { pixels, .. } if pixels.get().is_none())
    }

    /// Whether it is shown in a step of the motion.
    pub fn is_in(&self, step: u32) -> bool {
        self.visible && self.step.is_none_or(|own| own == step)
    }
}

/// The outline of a target. Lengths in m.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
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
    /// A trap for a bead.
    Trap {
        at: DVec3,
        trap: Trap,
        /// Topological charge of a vortex.
        charge: i32,
    },
    /// Its brightness prescribes |p|².
    Picture {
        /// As in the scene file: relative to the scene's folder, or absolute.
        file: String,
        at: DVec3,
        width: f64,
        #[serde(skip)]
        pixels: Pixels,
    },
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

fn is_zero(angle: &f64) -> bool {
    *angle == 0.0
}

fn is_true(visible: &bool) -> bool {
    *visible
}

fn is_z(normal: &DVec3) -> bool {
    *normal == DVec3::Z
}

/// The `[[target]]` table as written: every key of every kind, so that stray keys are reported at their position.
#[doc(hidden)]
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TargetTable {
    #[serde(default)]
    kind: Kind,
    at: Option<DVec3>,
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
}

#[derive(Clone, Copy, Debug, Default, PartialEq, EnumString, IntoStaticStr, VariantNames)]
#[strum(serialize_all = "lowercase", const_into_str)]
pub(super) enum Kind {
    #[default]
    Point,
    Line,
    Circle,
    Rectangle,
    Triangle,
    Polygon,
    Path,
    Text,
    Picture,
    Trap,
}

impl TargetTable {
    /// The target of this table, the `index`-th in the file.
    ///
    /// # Errors
    /// Missing keys, or keys of other kinds.
    pub fn into_target(mut self, index: usize) -> Result<Target, KeyError> {
        let table = &mut self;
        let at = DVec3::new(0.0, 0.0, 0.1);
        let side = DVec3::new(0.02, 0.0, 0.0);
        let shape = match table.kind {
            Kind::Point => Shape::Point { at: table.at.take().unwrap_or(at) },
            Kind::Line => Shape::Line {
                from: table.from.take().unwrap_or(at - side),
                to: table.to.take().unwrap_or(at + side),
            },
            Kind::Circle => Shape::Circle {
                at: table.at.take().unwrap_or(at),
                radius: table.radius.take().unwrap_or(0.02),
            },
            Kind::Rectangle => Shape::Rectangle {
                at: table.at.take().unwrap_or(at),
                width: table.width.take().unwrap_or(0.04),
                height: table.height.take().unwrap_or(0.04),
            },
            Kind::Triangle => {
                Shape::Triangle { at: table.at.take().unwrap_or(at), size: table.size.take().unwrap_or(0.04) }
            }
            Kind::Polygon => Shape::Polygon {
                at: table.at.take().unwrap_or(at),
                radius: table.radius.take().unwrap_or(0.02),
                sides: table.sides.take().unwrap_or(6),
            },
            Kind::Path => Shape::Path {
                vertices: table.vertices.take().unwrap_or_default(),
                closed: table.closed.take().unwrap_or(false),
            },
            Kind::Text => Shape::Text {
                text: table.text.take().unwrap_or_else(|| "HIT".to_owned()),
                at: table.at.take().unwrap_or(at),
                height: table.height.take().unwrap_or(0.04),
            },
            Kind::Trap => Shape::Trap {
                at: table.at.take().unwrap_or(at),
                trap: table.trap.take().unwrap_or_default(),
                charge: table.charge.take().unwrap_or(1),
            },
            Kind::Picture => Shape::Picture {
                file: table.file.take().ok_or_else(|| no_file(index))?,
                at: table.at.take().unwrap_or(at),
                width: table.width.take().unwrap_or(0.08),
                pixels: Pixels::default(),
            },
        };
        let mut target = Target::new(shape);
        target.step = table.step;
        target.visible = table.visible.unwrap_or(target.visible);
        target.name = std::mem::take(&mut table.name);
        target.group = std::mem::take(&mut table.group);
        let under = |e: KeyError| e.under(&["target".into(), index.into(), "motion".into()]);
        target.motion = table.motion.take().map(MotionTable::into_motion).transpose().map_err(under)?;
        target.pressure = table.pressure.take().unwrap_or(target.pressure);
        if table.kind != Kind::Point {
            target.angle = table.angle.take().unwrap_or(target.angle);
        }
        if !matches!(table.kind, Kind::Point | Kind::Trap | Kind::Picture) {
            target.sampling = table.sampling(index)?.unwrap_or(target.sampling);
        }
        if table.kind == Kind::Path {
            target.pressures = table.pressures.take().unwrap_or_default();
        }
        if !matches!(table.kind, Kind::Point | Kind::Line | Kind::Path) {
            target.normal = table.normal.take().unwrap_or(target.normal);
        }
        match self.stray_key() {
            None => Ok(target),
            Some(key) => Err(KeyError::new(
                [Key::from("target"), Key::from(index), Key::from(key)],
                format!("a target of kind `{}` has no such key", self.kind.into_str()),
            )),
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

    /// A key unused by the kind.
    fn stray_key(&self) -> Option<&'static str> {
        let Self {
            kind: _,
            at,
            from,
            to,
            radius,
            width,
            height,
            size,
            sides,
            vertices,
            closed,
            text,
            file,
            trap,
            charge,
            pressure: _,
            pressures,
            spacing,
            points,
            fill,
            stroke,
            angle,
            normal,
            step: _,
            visible: _,
            name: _,
            group: _,
            motion: _,
        } = self;
        [
            ("at", at.is_some()),
            ("from", from.is_some()),
            ("to", to.is_some()),
            ("radius", radius.is_some()),
            ("width", width.is_some()),
            ("height", height.is_some()),
            ("size", size.is_some()),
            ("sides", sides.is_some()),
            ("vertices", vertices.is_some()),
            ("closed", closed.is_some()),
            ("text", text.is_some()),
            ("file", file.is_some()),
            ("trap", trap.is_some()),
            ("charge", charge.is_some()),
            ("pressures", pressures.is_some()),
            ("spacing", spacing.is_some()),
            ("points", points.is_some()),
            ("fill", fill.is_some()),
            ("stroke", stroke.is_some()),
            ("angle", angle.is_some()),
            ("normal", normal.is_some()),
        ]
        .into_iter()
        .find_map(|(key, given)| given.then_some(key))
    }
}

fn no_file(index: usize) -> KeyError {
    let path = [Key::from("target"), Key::from(index), Key::from("file")];
    KeyError::new(path, "a target of kind `picture` needs the `file` that holds the picture")
}
