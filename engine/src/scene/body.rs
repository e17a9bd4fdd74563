//! Bodies in the field: solids with a place and an orientation, whose surfaces scatter the sound.

use std::path::PathBuf;

use glam::{DMat3, DVec3, dvec3};
use serde::{Deserialize, Serialize};
use strum::{EnumString, IntoStaticStr, VariantArray, VariantNames};

use crate::mesh::{Mesh, shapes};
use crate::scene::board::PARALLEL;
use crate::scene::loaded::Loaded;
use crate::scene::range::{Key, KeyError};

/// A solid. Its own coordinates have x along `x_axis`, z along `normal`, and their origin `at`. A file has only the keys
/// of its kind.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(into = "BodyTable")]
pub struct Body {
    pub kind: BodyKind,
    /// m: the centre of a sphere or capsule, the middle of the palm's skin, the origin of a file's coordinates.
    pub at: DVec3,
    /// The direction to which a palm faces, a file's z; `None` is that of [`Body::normal`].
    pub normal: Option<DVec3>,
    /// The direction of a capsule's axis, and of the fingers; made orthogonal to the normal.
    pub x_axis: DVec3,
    /// m, of a sphere or capsule.
    pub radius: f64,
    /// m, of a capsule from end to end.
    pub length: f64,
    /// m, of a palm: along x, across, and its thickness. A hand's palm grows with its fingers.
    pub size: DVec3,
    /// Degrees by which thumb, index, middle, ring and little finger are bent.
    pub fingers: [f64; 5],
    /// STL or OBJ, of a mesh.
    pub file: Option<String>,
    /// m per unit of the file.
    pub scale: f64,
    /// Pressure reflection of its surface: 1 rigid.
    pub coefficient: f64,
    /// m, of the triangles that stand for its surface; `None` chooses a part of the wavelength.
    pub edge: Option<f64>,
    /// The file's surface, in the file's unit.
    pub surface: Surface,
}

/// Kinds of bodies.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, EnumString, IntoStaticStr, VariantArray, VariantNames,
)]
#[strum(serialize_all = "kebab-case", const_into_str)]
pub enum BodyKind {
    #[default]
    Sphere,
    Capsule,
    Palm,
    Hand,
    Mesh,
}

impl BodyKind {
    /// The keys that bodies of this kind have besides those of all.
    fn keys(self) -> &'static [&'static str] {
        match self {
            Self::Sphere => &["radius"],
            Self::Capsule => &["x_axis", "radius", "length"],
            Self::Palm => &["normal", "x_axis", "size"],
            Self::Hand => &["normal", "x_axis", "size", "fingers"],
            Self::Mesh => &["normal", "x_axis", "file", "scale"],
        }
    }

    pub(crate) fn has(self, key: &str) -> bool {
        self.keys().contains(&key)
    }
}

/// The surface of a file, once loaded. A scene file only names it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    mesh: Loaded<Mesh>,
    hull: Loaded<[DVec3]>,
    /// The file of origin.
    pub from: Option<PathBuf>,
}

impl Surface {
    pub fn new(mesh: Mesh, from: Option<PathBuf>) -> Self {
        Self { hull: Loaded::new(hull(&mesh)), mesh: Loaded::new(mesh), from }
    }

    pub fn get(&self) -> Option<&Mesh> {
        self.mesh.get()
    }

    /// The vertices farthest in many directions, which stand for all where only its extent counts.
    pub(crate) fn hull(&self) -> &[DVec3] {
        self.hull.get().unwrap_or_default()
    }
}

fn hull(mesh: &Mesh) -> Vec<DVec3> {
    /// 20 · parts² directions' triangles.
    const PARTS: usize = 4;
    let axes = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|axis| [axis, -axis]);
    let directions = axes.chain(shapes::geodesic(1.0, PARTS).vertices);
    let farthest =
        |way: DVec3| mesh.vertices.iter().copied().max_by(|a, b| way.dot(*a).total_cmp(&way.dot(*b)));
    let mut hull: Vec<_> = directions.filter_map(farthest).collect();
    hull.sort_unstable_by(|a, b| a.to_array().map(f64::to_bits).cmp(&b.to_array().map(f64::to_bits)));
    hull.dedup();
    hull
}

impl Default for Body {
    fn default() -> Self {
        Self {
            kind: BodyKind::Sphere,
            at: dvec3(0.0, 0.0, 0.12),
            normal: None,
            x_axis: DVec3::X,
            radius: 0.01,
            length: 0.04,
            size: dvec3(0.1, 0.085, 0.025),
            fingers: [0.0; 5],
            file: None,
            scale: 1.0,
            coefficient: 1.0,
            edge: None,
            surface: Surface::default(),
        }
    }
}

impl Body {
    /// The direction of its own z: of palms and hands down to an array in z = 0, of others up, unless given.
    pub fn normal(&self) -> DVec3 {
        self.normal.unwrap_or(match self.kind {
            BodyKind::Palm | BodyKind::Hand => DVec3::NEG_Z,
            BodyKind::Sphere | BodyKind::Capsule | BodyKind::Mesh => DVec3::Z,
        })
    }

    /// Its own axes as columns of a rotation. `None` if the given ones are zero or parallel.
    pub fn axes(&self) -> Option<DMat3> {
        let x = self.x_axis.try_normalize()?;
        let normal = match self.kind {
            // They are round about x: any normal serves.
            BodyKind::Sphere | BodyKind::Capsule => {
                let normal = self.normal().reject_from_normalized(x);
                normal
                    .try_normalize()
                    .filter(|_| normal.length() > PARALLEL)
                    .unwrap_or(x.any_orthonormal_vector())
            }
            BodyKind::Palm | BodyKind::Hand | BodyKind::Mesh => self.normal().try_normalize()?,
        };
        let x = x - normal * normal.dot(x);
        let x = x.try_normalize().filter(|_| x.length() > PARALLEL)?;
        Some(DMat3::from_cols(x, normal.cross(x), normal))
    }

    /// Whether its file is not yet loaded.
    #[doc(hidden)]
    pub fn lacks_surface(&self) -> bool {
        self.kind == BodyKind::Mesh && self.surface.get().is_none()
    }

    /// The body as in its file: without a loaded surface, and with the defaults of the keys that its kind lacks.
    pub(crate) fn as_written(&self) -> Self {
        let table = BodyTable::from(Self { surface: Surface::default(), ..self.clone() });
        table.into_body(0).unwrap_or_default()
    }

    /// A point of its own coordinates (m) in the scene's.
    pub(crate) fn world(&self, place: DVec3) -> DVec3 {
        self.at + self.axes().unwrap_or(DMat3::IDENTITY) * place
    }

    /// Its surface in its own coordinates, with edges of about a length (m); `None` of a mesh that is not loaded.
    pub fn solid(&self, edge: f64) -> Option<Mesh> {
        let edge = self.edge.unwrap_or(edge);
        match self.kind {
            BodyKind::Sphere => Some(shapes::sphere(self.radius, edge)),
            BodyKind::Capsule => {
                let end = DVec3::X * (self.length / 2.0 - self.radius).max(0.0);
                Some(shapes::capsule(-end, end, self.radius, edge))
            }
            BodyKind::Palm => {
                let palm = shapes::slab(self.size, 0.5 * self.size.min_element(), edge);
                Some(palm.mapped(|at| at - DVec3::Z * (self.size.z / 2.0)))
            }
            BodyKind::Hand => Some(shapes::hand(self.size, self.fingers, edge)),
            BodyKind::Mesh => {
                let mesh = self.surface.get()?.clone().mapped(|at| at * self.scale);
                Some(mesh.with_edges(edge))
            }
        }
    }
}

/// The `[[body]]` table as written: every key of every kind, so that stray keys are reported at their position.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct BodyTable {
    #[serde(default)]
    kind: BodyKind,
    #[serde(skip_serializing_if = "Option::is_none")]
    at: Option<DVec3>,
    #[serde(skip_serializing_if = "Option::is_none")]
    normal: Option<DVec3>,
    #[serde(skip_serializing_if = "Option::is_none")]
    x_axis: Option<DVec3>,
    #[serde(skip_serializing_if = "Option::is_none")]
    radius: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    length: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    size: Option<DVec3>,
    #[serde(skip_serializing_if = "Option::is_none")]
    fingers: Option<[f64; 5]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    file: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    scale: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    coefficient: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    edge: Option<f64>,
}

impl BodyTable {
    /// The body of this table, the `index`-th in the file.
    pub(crate) fn into_body(self, index: usize) -> Result<Body, KeyError> {
        let Self { kind, at, normal, x_axis, radius, length, size, fingers, file, scale, coefficient, edge } =
            self;
        let given = [
            ("normal", normal.is_some()),
            ("x_axis", x_axis.is_some()),
            ("radius", radius.is_some()),
            ("length", length.is_some()),
            ("size", size.is_some()),
            ("fingers", fingers.is_some()),
            ("file", file.is_some()),
            ("scale", scale.is_some()),
        ];
        if let Some((key, _)) = given.into_iter().find(|(key, given)| *given && !kind.has(key)) {
            return Err(KeyError::new(
                [Key::from("body"), Key::from(index), Key::from(key)],
                format!(
                    "a body of kind `{}` has no such key; its own are {}",
                    kind.into_str(),
                    kind.keys().iter().map(|key| format!("`{key}`")).collect::<Vec<_>>().join(", ")
                ),
            ));
        }
        let usual = Body::default();
        Ok(Body {
            kind,
            at: at.unwrap_or(usual.at),
            normal,
            x_axis: x_axis.unwrap_or(usual.x_axis),
            radius: radius.unwrap_or(usual.radius),
            length: length.unwrap_or(usual.length),
            size: size.unwrap_or(usual.size),
            fingers: fingers.unwrap_or(usual.fingers),
            file,
            scale: scale.unwrap_or(usual.scale),
            coefficient: coefficient.unwrap_or(usual.coefficient),
            edge,
            surface: usual.surface,
        })
    }
}

impl From<Body> for BodyTable {
    fn from(body: Body) -> Self {
        let has = |key| body.kind.has(key);
        Self {
            kind: body.kind,
            at: Some(body.at),
            normal: body.normal.filter(|_| has("normal")),
            x_axis: has("x_axis").then_some(body.x_axis),
            radius: has("radius").then_some(body.radius),
            length: has("length").then_some(body.length),
            size: has("size").then_some(body.size),
            fingers: has("fingers").then_some(body.fingers),
            scale: has("scale").then_some(body.scale),
            file: body.file.filter(|_| body.kind.has("file")),
            coefficient: (body.coefficient != 1.0).then_some(body.coefficient),
            edge: body.edge,
        }
    }
}
