//! The drives of a scene's file in place of solved ones, with their figures at the foci.

use web_time::Instant;

use crate::acoustics::Aperture;
use crate::drive::Drive;
use crate::scene::{KeyError, Scene, outline};
use crate::solver::problem::{Excitation, Problem};
use crate::solver::quality::{Quality, efficiency};
use crate::solver::solution::{Solution, SolveError, unless_cancelled};
use crate::solver::{room, warning};

/// The drives of the file, all of them in turn, with their figures at the scene's foci; `with_figures`: also those of
/// shapes. A scene without visible targets has no foci.
pub fn solution(scene: &Scene, with_figures: bool) -> Result<Solution, SolveError> {
    let start = Instant::now();
    let aperture = Aperture::new(scene);
    let mut drives = drives(scene, &aperture)?;
    let foci = if scene.has_foci() { outline::foci(scene)? } else { Vec::new() };
    let values: Vec<_> = drives.iter().flat_map(|drive| drive.excitation(&aperture.driven)).collect();
    let efficiency = efficiency(&values);
    let mut solution = Solution {
        method: None,
        drive: drives.remove(0),
        others: drives,
        turned_down: 1.0,
        excitation: Vec::new(),
        foci,
        pressures: Vec::new(),
        quality: Quality { efficiency, ..Quality::default() },
        figures: None,
        iterations: 0,
        seconds: 0.0,
        warnings: warning::of_drive(scene).into_iter().collect(),
    };
    solution.excitation = solution.drive.amplitudes.clone();
    if !solution.foci.is_empty() {
        let _room = room::of_methods(scene, solution.foci.len(), 1)?;
        let problem = unless_cancelled(Problem::of_scene(scene, &aperture, solution.foci.clone()))?;
        solution.pressures = problem.transfer.in_turn(&values);
        let excitation = Excitation { values, iterations: 0, residual: None, weights: None };
        solution.quality = Quality::new(&problem, &excitation, &solution.pressures);
        solution.warnings.extend(warning::of_foci(&aperture, &solution.foci));
        if with_figures && problem.surroundings.is_some() {
            solution.judge(scene, &problem);
        }
    }
    solution.seconds = start.elapsed().as_secs_f64();
    unless_cancelled(solution)
}

/// The drives of the file, silent on elements that are off.
pub fn drives(scene: &Scene, aperture: &Aperture) -> Result<Vec<Drive>, KeyError> {
    scene.drive.check(aperture.positions.len())?;
    let Some(table) = scene.drive.table() else {
        return Err(KeyError::new(["drive".into()], format!("`{}` is not loaded", scene.drive.name)));
    };
    let mut is_driven = vec![false; aperture.positions.len()];
    aperture.driven.iter().for_each(|&element| is_driven[element] = true);
    let silenced = |drive: &Drive| {
        let mut drive = drive.clone();
        let off = drive.amplitudes.iter_mut().zip(&is_driven).filter(|(_, is_driven)| !**is_driven);
        off.for_each(|(amplitude, _)| *amplitude = 0.0);
        drive
    };
    Ok(table.drives.iter().map(silenced).collect())
}
