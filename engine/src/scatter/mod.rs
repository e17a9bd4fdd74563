//! Bodies that scatter sound: spheres by their series, others by boundary elements.
//!
//! A body is a [`crate::mesh::Mesh`], from a file or a formula ([`crate::mesh`]), with edges of about a sixth of a wavelength
//! ([`crate::mesh::Mesh::with_edges`]). [`Boundary::new`] makes the matrix of its surface, which a body keeps while it moves
//! and turns: bring the incident sound to the body's own coordinates. [`Boundary::solve`] takes the right side of
//! incident pressures and slopes at [`Boundary::points`] to pressures at the vertices, from which
//! [`Boundary::scattered`] makes the sound anywhere outside. With the columns of [`Boundary::solve`] for every element
//! of an array, its scattered sound at any points is one more transfer matrix. For few points and many drives
//! [`Boundary::solve_transposed`] takes one solution per point: sums of incident sound with
//! [`Boundary::right_side_weights`].
//!
//! ```
//! use glam::dvec3;
//! use num_complex::Complex64;
//! use sonoglyph_engine::mesh::shapes;
//! use sonoglyph_engine::scatter::{Boundary, TOLERANCE};
//!
//! # fn main() -> Result<(), sonoglyph_engine::scatter::TooLarge> {
//! // A plane wave along z (1 Pa, rad/m) on a rigid fingertip of 5 mm.
//! let k = 732.0;
//! let body = Boundary::new(&shapes::sphere(0.005, 0.0014), 1.0, k)?;
//! let (points, normals) = body.points();
//! let pressures: Vec<_> = points.iter().map(|at| Complex64::cis(-k * at.z)).collect();
//! let slope = |p: &Complex64, z: f64| p * Complex64::new(0.0, -k * z);
//! let slopes: Vec<_> = pressures.iter().zip(&normals).map(|(p, n)| slope(p, n.z)).collect();
//! let right = body.right_side(&pressures, &slopes);
//! let solution = body.solve(&[right], None, TOLERANCE).remove(0);
//! let behind = body.scattered(&solution.values, &[dvec3(0.0, 0.0, 0.01)])[0];
//! assert!(behind.norm() > 0.2 && body.error(&solution, &pressures, &incident(&body, k)).outside < 0.1);
//! # Ok(())
//! # }
//! # fn incident(body: &Boundary, k: f64) -> Vec<Complex64> {
//! #     body.inner_points().iter().map(|at| Complex64::cis(-k * at.z)).collect()
//! # }
//! ```

mod bodies;
mod boundary;
mod emission;
mod facets;
mod gmres;
mod grid;
mod hierarchy;
mod near;
mod pairs;
mod patch;
mod radiation;
mod rows;
mod sphere;
mod table;
mod waves;

pub use bodies::{Answer, Bodies, Incident, Skin};
pub use boundary::{BodyError, Boundary, TOLERANCE, TooLarge};
#[doc(hidden)]
pub use emission::Emission;
pub use gmres::Outcome;
pub use patch::{Patch, Sound};
pub use rows::Rows;
pub use sphere::Sphere;
pub(crate) use waves::{COSINE, SINE};
