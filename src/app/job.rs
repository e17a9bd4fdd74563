//! Long computations on a scene: on a thread, or in a browser by a worker, a second instance of the program.

use serde::Serialize;
use serde::de::DeserializeOwned;
use strum::VariantArray;

use crate::scene::{Method, Scene};
use crate::studio::solving::{self, Followed, Solved};
use crate::ui::MethodRow;

/// A kind of work.
pub trait Job {
    type Made: Serialize + DeserializeOwned + Send + 'static;

    fn make(scene: &Scene) -> Self::Made;

    /// The same; what is there before the end goes to `so_far`.
    #[cfg(not(target_arch = "wasm32"))]
    fn make_with(scene: &Scene, _so_far: &mut dyn FnMut(Self::Made)) -> Self::Made {
        Self::make(scene)
    }
}

/// The full solution of the scene at rest.
pub struct Solve;
/// The solutions of all frames of its motion.
pub struct Follow;
/// The solutions of all methods.
pub struct CompareMethods;

impl Job for Solve {
    type Made = Solved;

    fn make(scene: &Scene) -> Solved {
        solving::solve(scene, &mut |_| {})
    }

    #[cfg(not(target_arch = "wasm32"))]
    fn make_with(scene: &Scene, so_far: &mut dyn FnMut(Solved)) -> Solved {
        solving::solve(scene, so_far)
    }
}

impl Job for Follow {
    type Made = Followed;

    fn make(scene: &Scene) -> Followed {
        solving::follow(scene)
    }
}

impl Job for CompareMethods {
    type Made = Vec<MethodRow>;

    fn make(scene: &Scene) -> Vec<MethodRow> {
        let row = |&method: &Method| {
            let mut scene = scene.clone();
            scene.solve_by(method);
            MethodRow { method, solution: solving::solve(&scene, &mut |_| {}) }
        };
        Method::VARIANTS.iter().map(row).collect()
    }
}
