//! The played state: the solution of a scene and its sound.

use std::sync::Arc;

use crate::acoustics::{Air, Aperture};
use crate::scene::{Focus, Scene};
use crate::solver::frames::Sequence;
use crate::solver::{self, Solution};
use crate::studio::probe::{self, Reading};
use crate::ui::Sound;

pub type Solved = Result<Arc<Solution>, String>;

/// The played state: the scene at rest, or a frame of its motion.
#[derive(Clone, Debug)]
pub enum Source {
    Still(Arc<Solution>),
    Frame(Arc<Sequence>, usize),
}

pub fn solve(scene: &Scene) -> Solved {
    solve_with(scene, &mut |_| {})
}

/// Solutions with fewer drives in turn go to `so_far`.
pub fn solve_with(scene: &Scene, so_far: &mut dyn FnMut(Solved)) -> Solved {
    let solved = solver::solve_with(scene, &mut |found| so_far(Ok(Arc::new(found))));
    solved.map(Arc::new).map_err(|error| error.to_string())
}

/// The played drive and its pressures, quantised to a number of phase levels if given.
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
