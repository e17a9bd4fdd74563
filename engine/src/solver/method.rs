//! Every method by its name: from a problem to an excitation.

use num_complex::Complex64;
use web_time::Duration;

use crate::acoustics::Aperture;
use crate::scene::Method;
use crate::solver::problem::{Excitation, Problem};
use crate::solver::solution::SolveError;
use crate::solver::{contest, inverse, iteration, shape, trap};

/// The excitation of a method; `iterations` 0 takes the method's default.
///
/// # Errors
/// `focus` with several foci.
pub fn excite(problem: &Problem<'_>, method: Method, iterations: u32) -> Result<Excitation, SolveError> {
    if let Some(traps) = &problem.traps {
        return Ok(trap::best(problem, traps, Duration::ZERO));
    }
    let or = |default: u32| if iterations == 0 { default } else { iterations };
    Ok(match method {
        Method::Focus => focus(problem)?,
        Method::Pinv => inverse::pinv(problem),
        Method::Weighted => inverse::weighted(problem, or(7)),
        Method::Naive => iteration::naive(problem),
        Method::Gs => iteration::gs(problem, or(100)),
        Method::Gspat => iteration::gspat(problem, or(100)),
        Method::Wgs => iteration::wgs(problem, or(100)),
        Method::Greedy => iteration::greedy(problem, or(1)),
        Method::Best => match &problem.surroundings {
            Some(surroundings) => shape::best(problem, surroundings),
            None => contest::best(problem, or(20)),
        },
    })
}

/// The excitation of `best` for slightly moved foci, continued from `before`: faster than a search, and with
/// continuous phases.
pub fn excite_from(problem: &Problem<'_>, before: &Excitation) -> Excitation {
    /// Over many frames the weights follow all the same.
    const ITERATIONS: u32 = 1;
    if let Some(traps) = &problem.traps {
        return trap::best_from(problem, traps, &before.values);
    }
    match &problem.surroundings {
        Some(surroundings) => shape::best_from(problem, surroundings, &before.values),
        None => contest::best_from(problem, before, ITERATIONS),
    }
}

/// The strongest drive of `batches` of eight starts, levelled for long: a baseline for `best`, and hundreds of times slower.
pub fn search(problem: &Problem<'_>, batches: usize) -> Excitation {
    const ITERATIONS: u32 = 200;
    iteration::search(problem, batches, ITERATIONS)
}

/// Time of flight, equations (4) and (5) of Long et al. 2022: φ_n = k r_n.
pub fn focus(problem: &Problem<'_>) -> Result<Excitation, SolveError> {
    if problem.foci.len() != 1 {
        return Err(SolveError::SeveralFoci(problem.foci.len()));
    }
    let Aperture { element, positions, driven, .. } = problem.aperture;
    let focus = problem.foci[0];
    // To a focus at infinity only differences of distances count.
    let distance = |&n: &usize| match focus.is_direction() {
        true => -focus.position.dot(positions[n]),
        false => focus.position.distance(positions[n]),
    };
    let values =
        driven.iter().map(|n| Complex64::from_polar(1.0, element.wavenumber * distance(n))).collect();
    Ok(Excitation { values, iterations: 0, residual: None, weights: None })
}
