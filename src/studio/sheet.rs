//! The words of a sheet, and the legend of its map: pressures in one convention, which each of them names.

use crate::acoustics::Aperture;
use crate::field::{Map, Quantity};
use crate::picture::sheet::{Pressure, Words, amount};
use crate::picture::{ColourMap, Picture};
use crate::rounding::percent_at_least;
use crate::scene::Scene;
use crate::solver::{self, Problem, Solution};
use crate::studio::convention::Convention;
use crate::studio::{figure, map};

/// Title, method and foci, and the figures of the solution.
pub fn words(scene: &Scene, solution: &Solution, title: &str, convention: Convention) -> Words {
    let quality = &solution.quality;
    let method = solution.method.map_or("drive of a file", |method| method.title());
    let title = title.to_owned();
    if solution.foci.is_empty() {
        return Words { title, summary: [method.to_owned(), String::new()] };
    }
    let aperture = Aperture::new(scene);
    let bound = solver::bound(&Problem::new(&aperture, solution.foci.clone()));
    let figures = format!(
        "mean {}, weakest {}, std/mean {:.1} %     η {:.1} %     at least {} of the upper bound",
        convention.pressure(quality.mean_pressure),
        convention.pressure(quality.min_pressure),
        100.0 * quality.spread,
        100.0 * quality.efficiency,
        percent_at_least(solution.certified(bound), 0),
    );
    Words { title, summary: [format!("{method}, {}", amount(&solution.foci)), figures] }
}

/// The map of the RMS pressure as it stands on a sheet.
pub fn pressure(picture: Picture, map: &Map, colours: ColourMap, convention: Convention) -> Pressure {
    let remark = map::remark(Quantity::Rms, map);
    let remark = remark.map_or_else(String::new, |remark| format!(", {remark}"));
    let peak = f64::from(map.peak);
    let largest = convention.pressure(peak / Convention::Rms.of_peak());
    let bar = figure::pressure_bar(colours, convention, peak);
    Pressure { picture, title: format!("Pressure up to {largest}{remark}"), bar }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::file;
    use crate::studio::EXAMPLE;

    #[test]
    fn every_pressure_of_a_sheet_names_its_convention() {
        let scene = file::parse(EXAMPLE, "hit.toml".as_ref()).unwrap();
        let solution = solver::solve(&scene).unwrap();
        for (convention, name) in [(Convention::Rms, "RMS"), (Convention::Peak, "peak")] {
            let [_, figures] = words(&scene, &solution, "hit", convention).summary;
            let mean = convention.pressure(solution.quality.mean_pressure);
            assert!(
                mean.ends_with(name) && figures.starts_with(&format!("mean {mean}, weakest ")),
                "{figures}"
            );
            assert_eq!(figures.matches(name).count(), figures.matches("Pa").count(), "{figures}");
        }
    }
}
