//! The part of a scene that determines its solution, so that other edits cost no solve.

use crate::scene::{Liquid, Method, Modulation, Plane, Scene, Solver, Target, Turns, motion, outline};

/// The part of a scene that its drive follows from.
pub fn posed(scene: &Scene) -> Scene {
    Scene {
        drive: scene.drive.clone(),
        medium: scene.medium.clone(),
        array: scene.array.clone(),
        boards: scene.boards.clone(),
        reflectors: scene.reflectors.clone(),
        targets: scene.targets.iter().map(at_rest).collect(),
        quiet: scene.quiet.clone(),
        solver: Solver { frames: turns(scene), ..scene.solver.clone() },
        liquid: if has_surface(scene) { scene.liquid.clone() } else { Liquid::default() },
        plane: if is_shape(scene) || has_surface(scene) || scene.aims_at_felt() {
            quiet_plane(&scene.plane)
        } else {
            Plane::default()
        },
        skin: scene.skin.clone().filter(|_| scene.aims_at_felt()),
        modulation: if scene.aims_at_felt() { scene.envelope().clone() } else { Modulation::default() },
        ..Scene::default()
    }
}

/// Only areas at rest have several drives by themselves; a scene in motion has one per frame, at rest too.
fn turns(scene: &Scene) -> Turns {
    match scene.solver.frames {
        Turns::Auto if !scene.has_areas() || motion::moves(scene) => Turns::Count(1),
        turns => turns,
    }
}

/// Whether the drive depends on the position of a liquid's surface.
fn has_surface(scene: &Scene) -> bool {
    scene.aims_at_depression() || scene.liquid.reflects
}

fn at_rest(target: &Target) -> Target {
    Target { motion: None, modulation: None, ..target.clone() }
}

/// The quiet plane, independent of the displayed part.
fn quiet_plane(plane: &Plane) -> Plane {
    let Plane { size, tolerance, .. } = Plane::default();
    Plane { size, tolerance, ..plane.clone() }
}

/// Whether its drive is improved by further search.
pub fn is_shape(scene: &Scene) -> bool {
    scene.solver.method == Method::Best
        && (outline::is_continuous(scene)
            || !scene.quiet.is_empty()
            || scene.aims_at_depression()
            || scene.solver.frames.are_several())
}

/// The part of a scene that the drives of its frames follow from.
pub fn posed_in_motion(scene: &Scene) -> Scene {
    let posed = posed(scene);
    let modulation =
        if scene.has_own_envelopes() { scene.modulation.clone() } else { posed.modulation.clone() };
    Scene { motion: scene.motion.clone(), targets: scene.targets.clone(), modulation, ..posed }
}
