//! The played state: the solution of a scene and its sound.

use crate::acoustics::{Air, Aperture};
use crate::scene::{Focus, Scene};
use crate::studio::performance::Performance;
use crate::studio::probe::{self, Reading};
use crate::ui::Sound;

/// A moment of a performance.
#[derive(Clone, Debug)]
pub struct Source {
    pub performance: Performance,
    /// Frame of a motion.
    pub frame: usize,
}

/// The played drive and its pressures, quantised to a number of phase levels if given.
pub fn sound(scene: &Scene, levels: Option<u32>, source: &Source) -> Sound {
    let aperture = Aperture::new(scene);
    let (drives, foci, pressures): (_, &[Focus], _) = match &source.performance {
        Performance::Still(solution) => (solution.drives(), &solution.foci, &solution.pressures),
        Performance::Motion(sequence) => {
            let frame = &sequence.frames[source.frame];
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
    let (bead, spread) = (scene.bead.clone(), scene.array.spread);
    Sound { aperture, air, bead, spread, drives, foci: foci.to_vec(), readings }
}
