//! Coarse surfaces of the scene's bodies, by which they are seen before their sound is known.

use std::sync::{Arc, Mutex, PoisonError};

use glam::DVec3;

use crate::mesh::Mesh;
use crate::scene::{Body, BodyKind};
use crate::ui::part::{Now, Part};

/// Shapes with their surfaces, in their own coordinates; `None` of a file that is not loaded.
pub type Shapes = Vec<(Body, Option<Arc<Mesh>>)>;

/// The surfaces that were made last.
#[derive(Clone, Debug, Default)]
pub struct Solids {
    kept: Arc<Mutex<Shapes>>,
}

impl Part for Solids {
    type Input = Vec<Body>;
    type Output = Shapes;

    fn input(&self, now: &Now<'_>) -> Option<Vec<Body>> {
        let bodies = &now.scene.bodies;
        (!bodies.is_empty()).then(|| bodies.iter().map(shape).collect())
    }

    fn computation(&self) -> impl FnOnce(&Vec<Body>) -> Shapes + Send + 'static {
        let kept = Arc::clone(&self.kept);
        move |shapes| {
            let mut kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
            let of = |shape: &Body| {
                let found = kept.iter().find(|(own, _)| own == shape).map(|(_, mesh)| mesh.clone());
                (shape.clone(), found.unwrap_or_else(|| shape.solid(edge(shape)).map(Arc::new)))
            };
            let made: Shapes = shapes.iter().map(of).collect();
            kept.clone_from(&made);
            made
        }
    }
}

/// A body at the origin, by all that its shape depends on.
pub fn shape(body: &Body) -> Body {
    Body { at: DVec3::ZERO, normal: None, x_axis: DVec3::X, coefficient: 1.0, edge: None, ..body.clone() }
}

/// m, of triangles fine enough for the eye.
fn edge(shape: &Body) -> f64 {
    match shape.kind {
        BodyKind::Sphere => shape.radius / 6.0,
        BodyKind::Capsule => shape.radius / 4.0,
        BodyKind::Palm | BodyKind::Hand => shape.size.max_element() / 25.0,
        BodyKind::Mesh => shape.reach() / 20.0,
    }
}
