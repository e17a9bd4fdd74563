//! Bodies in the field: solids with a place and an orientation, whose surfaces scatter the sound.

use std::path::PathBuf;

use glam::{DMat3, DVec3, dvec3};
use serde::{Deserialize, Serialize};
use strum::{EnumString, IntoStaticStr, VariantArray, VariantNames};

use crate::mesh::{Mesh, shapes};
use crate::scene::board::PARALLEL;
use crate::scene::loaded::Loaded;

/// A solid. Its own coordinates have x along `x_axis`, z along `normal`, and their origin `at`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Body {
    pub kind: BodyKind,
    /// m: the centre of a sphere or capsule, the middle of the palm's skin, the origin of a file's coordinates.
    pub at: DVec3,
    /// The direction to which a palm faces; `None` is [`Body::normal`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub normal: Option<DVec3>,
    /// The direction of a capsule's axis, and of the fingers; made orthogonal to the normal.
    #[serde(skip_serializing_if = "is_x")]
    pub x_axis: DVec3,
    /// m, of a sphere or capsule.
    #[serde(skip_serializing_if = "is_usual_radius")]
    pub radius: f64,
    /// m, of a capsule from end to end.
    #[serde(skip_serializing_if = "is_usual_length")]
    pub length: f64,
    /// m, of a palm: along x, across, and its thickness. A hand's palm grows with its fingers.
    #[serde(skip_serializing_if = "is_usual_size")]
    pub size: DVec3,
    /// Degrees by which thumb, index, middle, ring and little finger are bent.
    #[serde(skip_serializing_if = "is_straight")]
    pub fingers: [f64; 5],
    /// STL or OBJ, of a mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// m per unit of the file.
    #[serde(skip_serializing_if = "is_one")]
    pub scale: f64,
    /// Pressure reflection of its surface: 1 rigid.
    #[serde(skip_serializing_if = "is_one")]
    pub coefficient: f64,
    /// m, of the triangles that stand for its surface; `None` chooses a part of the wavelength.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub edge: Option<f64>,
    /// The file's surface, in the file's unit.
    #[serde(skip)]
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

/// The surface of a file, once loaded. A scene file only names it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    mesh: Loaded<Mesh>,
    /// The file of origin.
    pub from: Option<PathBuf>,
}

impl Surface {
    pub fn new(mesh: Mesh, from: Option<PathBuf>) -> Self {
        Self { mesh: Loaded::new(mesh), from }
    }

    pub fn get(&self) -> Option<&Mesh> {
        self.mesh.get()
    }
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
        let normal = self.normal().try_normalize()?;
        let x = self.x_axis.try_normalize()?;
        let x = x - normal * normal.dot(x);
        let x = x.try_normalize().filter(|_| x.length() > PARALLEL)?;
        Some(DMat3::from_cols(x, normal.cross(x), normal))
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

fn is_x(axis: &DVec3) -> bool {
    *axis == DVec3::X
}

fn is_one(factor: &f64) -> bool {
    *factor == 1.0
}

fn is_usual_radius(radius: &f64) -> bool {
    *radius == Body::default().radius
}

fn is_usual_length(length: &f64) -> bool {
    *length == Body::default().length
}

fn is_usual_size(size: &DVec3) -> bool {
    *size == Body::default().size
}

fn is_straight(fingers: &[f64; 5]) -> bool {
    fingers.iter().all(|angle| *angle == 0.0)
}
