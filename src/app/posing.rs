//! The played state: the solution of a scene and its sound.

use crate::acoustics::response::{responding, responding_at};
use crate::acoustics::{Air, Aperture};
use crate::drive::Drive;
use crate::scene::{Focus, Scene};
use crate::solver::frames::Sequence;
use crate::studio::performance::Performance;
use crate::studio::probe::{self, Reading};
use crate::ui::{Moment, Sound};

/// A moment of a performance.
#[derive(Clone, Debug, PartialEq)]
pub struct Source {
    pub performance: Performance,
    /// A frame of a motion, or its mean.
    pub moment: Moment,
}

/// The played drive and its pressures, quantised to a number of phase levels if given.
pub fn sound(scene: &Scene, levels: Option<u32>, source: &Source) -> Sound {
    let aperture = Aperture::new(scene);
    let standing;
    let rounded = |drive: &Drive| levels.map_or_else(|| drive.clone(), |levels| drive.at_levels(levels));
    let (drives, foci, pressures): (Vec<_>, &[Focus], _) = match &source.performance {
        Performance::Still(solution) => {
            (solution.drives().iter().map(rounded).collect(), &solution.foci, &solution.pressures)
        }
        Performance::Motion(sequence) => {
            let frame = &sequence.frames[source.moment.frame().unwrap_or(0)];
            match source.moment {
                Moment::Frame(_) => (vec![rounded(&frame.drive)], &frame.foci, &frame.pressures),
                Moment::Rest | Moment::Mean | Moment::Wave(_) => {
                    standing = foci_of_all(sequence);
                    let drives = sequence.frames.iter().map(|frame| rounded(&frame.drive)).collect();
                    (drives, &standing, &frame.pressures)
                }
            }
        }
    };
    let follows = scene.array.response.is_some();
    let heard = match &source.performance {
        Performance::Motion(sequence) if follows && source.moment.frame().is_some() => {
            let frames: Vec<_> = sequence.frames.iter().map(|frame| rounded(&frame.drive)).collect();
            vec![responding_at(scene, &frames, source.moment.frame().unwrap_or(0))]
        }
        Performance::Still(_) | Performance::Motion(_) => responding(scene, drives.clone(), false),
    };
    let at_foci = |(focus, &pressure): (&Focus, _)| Reading { position: focus.position, pressure };
    let readings = foci.iter().zip(pressures).map(at_foci).collect();
    let is_mean = matches!(source.performance, Performance::Motion(_)) && drives.len() > 1;
    let is_own = drives[0].phases.len() == aperture.positions.len();
    let air = Air::new(&scene.medium, scene.array.frequency);
    let (bead, spread) = (scene.bead.clone(), scene.array.spread);
    let mut sound = Sound { aperture, air, bead, spread, drives, heard, foci: foci.to_vec(), readings };
    if (levels.is_some() || follows || is_mean) && is_own && sound.is_at_hand() {
        sound.readings = probe::readings_of(&sound.aperture, &sound.heard, &sound.foci);
    }
    sound
}

/// The foci that are the same in all frames, or else those of the first.
fn foci_of_all(sequence: &Sequence) -> Vec<Focus> {
    let (first, others) = (&sequence.frames[0].foci, &sequence.frames[1..]);
    let stands = |focus: &&Focus| {
        others.iter().all(|frame| frame.foci.iter().any(|other| other.position == focus.position))
    };
    let standing: Vec<_> = first.iter().filter(stands).cloned().collect();
    if standing.is_empty() { first.clone() } else { standing }
}
