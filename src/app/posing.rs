//! What is played: the part of a scene that is solved, what came of it, and the sound of that.

use std::sync::Arc;

use crate::acoustics::{Air, Aperture};
use crate::scene::{Focus, Liquid, Method, Plane, Scene, Target, outline};
use crate::solver::frames::Sequence;
use crate::solver::{self, Solution};
use crate::studio::probe::{self, Reading};
use crate::ui::Sound;

pub type Solved = Result<Arc<Solution>, String>;

/// What is played: the scene at rest, or a frame of its motion.
#[derive(Clone, Debug)]
pub enum Source {
    Still(Arc<Solution>),
    Frame(Arc<Sequence>, usize),
}

/// The part of a scene that its drive follows from.
pub fn posed(scene: &Scene) -> Scene {
    Scene {
        medium: scene.medium.clone(),
        array: scene.array.clone(),
        boards: scene.boards.clone(),
        reflectors: scene.reflectors.clone(),
        targets: scene.targets.iter().map(at_rest).collect(),
        quiet: scene.quiet.clone(),
        solver: scene.solver.clone(),
        liquid: if has_surface(scene) { scene.liquid.clone() } else { Liquid::default() },
        plane: if is_shape(scene) || has_surface(scene) {
            quiet_plane(&scene.plane)
        } else {
            Plane::default()
        },
        ..Scene::default()
    }
}

/// Whether the drive depends on where a liquid's surface lies.
fn has_surface(scene: &Scene) -> bool {
    scene.aims_at_depression() || scene.liquid.reflects
}

fn at_rest(target: &Target) -> Target {
    Target { motion: None, ..target.clone() }
}

/// What is not drawn is to be quiet there, whatever part of it is shown.
fn quiet_plane(plane: &Plane) -> Plane {
    let Plane { size, tolerance, .. } = Plane::default();
    Plane { size, tolerance, ..plane.clone() }
}

/// Whether its drive goes on being searched for.
pub fn is_shape(scene: &Scene) -> bool {
    scene.solver.method == Method::Best
        && (outline::is_continuous(scene)
            || !scene.quiet.is_empty()
            || scene.aims_at_depression()
            || scene.solver.frames > 1)
}

/// The part of a scene that the drives of its frames follow from.
pub fn posed_in_motion(scene: &Scene) -> Scene {
    Scene { motion: scene.motion.clone(), targets: scene.targets.clone(), ..posed(scene) }
}

pub fn solve(scene: &Scene) -> Solved {
    solver::solve(scene).map(Arc::new).map_err(|error| error.to_string())
}

/// What is played and what arrives, as a board with few phases plays it if that is asked for.
pub fn sound(scene: &Scene, levels: Option<u32>, source: &Source) -> Sound {
    let aperture = Aperture::new(scene);
    let (drives, foci, pressures): (_, &[Focus], _) = match source {
        Source::Still(solution) => (solution.drives(), &solution.foci, &solution.pressures),
        Source::Frame(round, frame) => {
            let frame = &round.frames[*frame];
            (vec![frame.drive.clone()], &frame.foci, &frame.pressures)
        }
    };
    let at_foci = |(focus, &pressure): (&Focus, _)| Reading { position: focus.position, pressure };
    let (mut drives, mut readings) = (drives, foci.iter().zip(pressures).map(at_foci).collect());
    if let Some(levels) = levels {
        drives.iter_mut().for_each(|drive| *drive = drive.at_levels(levels));
        if drives[0].phases.len() == aperture.positions.len() {
            let points: Vec<_> = foci.iter().map(|focus| focus.position).collect();
            readings = probe::readings(&aperture, &drives, &points);
        }
    }
    let air = Air::new(&scene.medium, scene.array.frequency);
    Sound { aperture, air, bead: scene.bead.clone(), drives, foci: foci.to_vec(), readings }
}
