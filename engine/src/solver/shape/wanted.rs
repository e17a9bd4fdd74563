//! Sample points of areas and their margins, with target values.
//!
//! An area is a raster of the prescribed |p|² (`scene::cover`: filled shapes, broad strokes, pictures). Its foci,
//! λ/2 apart, serve display and figures; the solver fits |p|² on samples λ/4 apart, over the area and 3.7 λ around
//! it.

use glam::{DVec2, DVec3};

use crate::acoustics::{Aperture, Clearance};
use crate::scene::{Cover, Focus};
use crate::solver::problem::Problem;
use crate::solver::shape::grid::{Grid, Layout};
use crate::solver::shape::picture::{Picture, Wanted};
use crate::solver::shape::real::Real;
use crate::solver::shape::region;
use crate::solver::shape::response::Response;
use crate::solver::shape::samples::Samples;
use crate::solver::shape::surroundings::Surroundings;
use crate::solver::shape::table::{BLOCK, Table};

/// Lengths in wavelengths: sample spacing; quiet margin of an area; width of strokes and points drawn as areas.
const SPACING: f64 = 0.245;
const MARGIN: f64 = 3.7;
pub const STROKE: f64 = 0.5;
/// Excitations for a picture are padded to whole blocks of this.
pub const PADDING: usize = BLOCK;
/// Wavelengths between planes that count as one.
const SAME: f64 = 0.01;
/// Brightness relative to its usual value.
const FAINTEST: f64 = 1e-6;
/// Limits of a table's values and samples.
const MOST_VALUES: usize = 16 << 20;
const MOST_SAMPLES: usize = 10_000;

/// The samples of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fineness {
    /// Samples of the solver; on the quiet plane where areas lie in it.
    Solver,
    /// Samples of the figures.
    Figures,
}

/// The areas of a drawing with their transfers.
pub fn picture<T: Real>(
    problem: &Problem<'_>,
    surroundings: &Surroundings,
    fineness: Fineness,
    scale: f64,
) -> Option<Picture<T>> {
    let drawn = Drawn::new(problem, surroundings)?;
    let aperture = problem.aperture;
    let spacing = SPACING * aperture.wavelength();
    let (quiet, spacing) = match fineness {
        Fineness::Figures => (None, spacing / 1.25),
        Fineness::Solver => (drawn.on_quiet_plane(problem, surroundings), spacing),
    };
    let layout = quiet.or_else(|| drawn.layout(aperture, spacing));
    let (samples, wanted) = match layout {
        Some(layout) => {
            let wanted = drawn.on_grid(aperture, &layout);
            (Samples::Grid(Box::new(Grid::new(aperture, layout, scale))), wanted)
        }
        None => drawn.in_table(aperture, spacing, scale),
    };
    let response = surroundings.liquid.as_ref().zip(layout);
    let response = response.map(|(liquid, layout)| Response::new(liquid, &layout, aperture.pitch));
    // Scaled as for strokes, unless too small for f32.
    let mean = problem.targets().iter().sum::<f64>() / problem.foci.len() as f64;
    let brightest = wanted.iter().map(|(brightness, _)| *brightness).fold(0.0, f64::max);
    let unit = (mean * mean).min(FAINTEST.recip() * brightest);
    if !(unit.is_normal() && scale.is_normal()) {
        return None;
    }
    // A liquid's surface must be parallel to the samples for a response.
    if surroundings.liquid.is_some() && response.is_none() {
        return None;
    }
    let part = |(brightness, weight): &(f64, f64)| (T::of(brightness / unit), T::of(*weight));
    let (brightness, weight) = wanted.iter().map(part).unzip();
    let mut picture = Picture::new(samples, Wanted::new(brightness, weight), response);
    if let Some(layout) = quiet {
        picture.be_quiet(region::mask(&layout, aperture, &problem.foci));
    }
    Some(picture)
}

/// Areas, and foci drawn as discs.
struct Drawn<'a> {
    covers: &'a [Cover],
    discs: Vec<&'a Focus>,
    wavelength: f64,
}

impl<'a> Drawn<'a> {
    /// `None` without areas.
    fn new(problem: &'a Problem<'_>, surroundings: &'a Surroundings) -> Option<Self> {
        let as_disc = |focus: &&Focus| surroundings.liquid.is_some() && !focus.is_of_area();
        let discs: Vec<_> = problem.foci.iter().filter(as_disc).collect();
        let covers = &surroundings.areas[..];
        let is_something = !covers.is_empty() || !discs.is_empty();
        is_something.then_some(Self { covers, discs, wavelength: problem.aperture.wavelength() })
    }

    /// Margin around the drawing, m.
    fn margin(&self) -> f64 {
        MARGIN * self.wavelength
    }

    /// The common height of the drawing, if it is horizontal.
    fn height(&self) -> Option<f64> {
        let is_level = |cover: &Cover| cover.axes.iter().all(|axis| axis.z.abs() < 1e-9);
        let discs = self.discs.iter().map(|focus| focus.position.z);
        let mut heights = self.covers.iter().map(|cover| cover.centre.z).chain(discs);
        let first = heights.next()?;
        let is_same = heights.all(|height| (height - first).abs() < SAME * self.wavelength);
        (is_same && first > 0.0 && self.covers.iter().all(is_level)).then_some(first)
    }

    /// Samples of a plane parallel to the array.
    fn layout(&self, aperture: &Aperture, spacing: f64) -> Option<Layout> {
        aperture.lattice()?;
        let height = self.height()?;
        let grids = (aperture.pitch / spacing).ceil().clamp(1.0, 16.0) as usize;
        Self::grid(aperture, height, self.reach(aperture, height), grids)
    }

    /// Extent (m) of the drawing and its margin from the axis.
    fn reach(&self, aperture: &Aperture, height: f64) -> DVec2 {
        let far = |cover: &Cover| {
            let half = cover.half + self.margin();
            let along = (cover.axes[0] * half.x).abs() + (cover.axes[1] * half.y).abs();
            cover.centre.truncate().abs() + along.truncate()
        };
        let discs = self.discs.iter().map(|focus| focus.position.truncate().abs() + self.margin());
        // The array covers only a part of larger drawings.
        let most = 2.0 * (height + aperture.reach().length());
        let reach = self.covers.iter().map(far).chain(discs).fold(DVec2::ZERO, DVec2::max);
        reach.min(DVec2::splat(most))
    }

    /// `None` if it is too large.
    fn grid(aperture: &Aperture, height: f64, reach: DVec2, grids: usize) -> Option<Layout> {
        if reach.max_element() >= 1e4 * aperture.pitch {
            return None;
        }
        let layout = Layout::new(aperture, height, reach, grids);
        (layout.area() <= 64 * aperture.positions.len() + (1 << 16)).then_some(layout)
    }

    /// Samples of the quiet plane, if the areas lie in it and |p| is prescribed: half a fringe apart, they also hold
    /// every detail of |p|².
    fn on_quiet_plane(&self, problem: &Problem<'_>, surroundings: &Surroundings) -> Option<Layout> {
        /// Fraction of the region's reach: the array hardly radiates beyond, and transforms are shorter.
        const HEARD: f64 = 0.95;
        let (aperture, plane) = (problem.aperture, &surroundings.plane);
        let height = self.height().filter(|_| region::is_parallel(plane, aperture))?;
        let is_in_plane = (height - plane.centre.z).abs() < SAME * self.wavelength;
        if !is_in_plane || surroundings.liquid.is_some() || surroundings.quiet <= 0.0 {
            return None;
        }
        let reach = (HEARD * region::reach(problem, height)).max(self.reach(aperture, height));
        Self::grid(aperture, height, reach, region::grids(aperture, height))
    }

    /// T and w of every value of a field.
    fn on_grid(&self, aperture: &Aperture, layout: &Layout) -> Vec<(f64, f64)> {
        let mut wanted = vec![(0.0, 0.0); layout.len()];
        let spacing = layout.spacing(aperture.pitch);
        for cover in self.covers {
            let half = cover.half + self.margin();
            let middle = cover.centre.truncate();
            for (index, place) in layout.places_near(aperture.pitch, middle, half.length()) {
                let flat = cover.flat(place.extend(cover.centre.z));
                if flat.abs().cmple(half).all() {
                    let brightness = cover.pressure * cover.pressure * cover.brightness(flat, spacing);
                    wanted[index] = (brightness.max(wanted[index].0), 1.0);
                }
            }
        }
        for focus in &self.discs {
            let middle = focus.position.truncate();
            for (index, place) in layout.places_near(aperture.pitch, middle, self.margin()) {
                let brightness = self.disc(focus, place.distance(middle), spacing);
                wanted[index] = (brightness.max(wanted[index].0), 1.0);
            }
        }
        wanted
    }

    /// Target value of a focus at a distance (m) from it, averaged over a cell.
    fn disc(&self, focus: &Focus, distance: f64, cell: f64) -> f64 {
        let inside = (0.5 * STROKE * self.wavelength - distance) / cell + 0.5;
        focus.target * focus.target * inside.clamp(0.0, 1.0)
    }

    /// A table of all areas and their surroundings, each in its own plane, and T and w of its rows.
    fn in_table<T: Real>(
        &self,
        aperture: &Aperture,
        spacing: f64,
        scale: f64,
    ) -> (Samples<T>, Vec<(f64, f64)>) {
        let most = (MOST_VALUES / aperture.driven.len().next_multiple_of(BLOCK)).clamp(64, MOST_SAMPLES);
        let sizes = self.covers.iter().map(|cover| 2.0 * (cover.half + self.margin()));
        let area: f64 = sizes.map(DVec2::element_product).sum();
        let spacing = spacing.max((area / most as f64).sqrt());
        let points = self.covers.iter().flat_map(|cover| around(cover, cover.half + self.margin(), spacing));
        let clearance = Clearance::new(aperture);
        let points: Vec<_> = points.filter(|&point| clearance.at(point) > 0.0).collect();
        let mut table = Table::new(aperture.driven.len());
        aperture.transfer(&points).rows().for_each(|row| table.push(row, scale));
        let wanted = points.iter().map(|&point| (self.at(point, spacing), 1.0)).collect();
        (Samples::Table(table), wanted)
    }

    /// T at a point of any of the planes.
    fn at(&self, point: DVec3, cell: f64) -> f64 {
        let of = |cover: &Cover| {
            let flat = cover.flat(point);
            let is_on_plane = cover.world(flat).distance(point) < 0.25 * self.wavelength;
            let brightness = if is_on_plane { cover.brightness(flat, cell) } else { 0.0 };
            cover.pressure * cover.pressure * brightness
        };
        self.covers.iter().map(of).fold(0.0, f64::max)
    }
}

/// Points of an area's plane on a square grid, up to `half` (m) from its centre.
fn around(cover: &Cover, half: DVec2, spacing: f64) -> impl Iterator<Item = DVec3> {
    let [x, y] = (half / spacing).floor().to_array().map(|steps| steps as i64);
    let row = move |j: i64| (-x..=x).map(move |i| (i, j));
    (-y..=y).flat_map(row).map(move |(i, j)| cover.world(DVec2::new(i as f64, j as f64) * spacing))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Sampling, Scene, Shape, Target};

    const WIDTH: f64 = 0.02;
    const HEIGHT: f64 = 0.012;

    fn scene(side: u32) -> Scene {
        let mut scene = Scene::default();
        (scene.array.rows, scene.array.columns) = (side, side);
        scene
    }

    fn area(at: DVec3, width: f64, height: f64) -> Target {
        Target { sampling: Sampling::Fill, ..Target::new(Shape::Rectangle { at, width, height }) }
    }

    fn cover(area: &Target, aperture: &Aperture) -> Cover {
        Cover::new(area, aperture.wavelength()).unwrap().unwrap()
    }

    fn drawn<'a>(covers: &'a [Cover], aperture: &Aperture) -> Drawn<'a> {
        Drawn { covers, discs: Vec::new(), wavelength: aperture.wavelength() }
    }

    #[test]
    fn areas_have_a_height_if_all_are_level_at_one_above_the_array() {
        let aperture = Aperture::new(&scene(4));
        let level = |height: f64| area(DVec3::new(10.0 * height, 0.0, height), WIDTH, HEIGHT);
        let tilted = Target { normal: DVec3::new(0.3, 0.0, 1.0), ..level(0.1) };
        for (areas, expected) in [
            (vec![level(0.1)], Some(0.1)),
            (vec![level(0.1), level(0.1)], Some(0.1)),
            (vec![level(0.1), level(0.11)], None),
            (vec![level(0.1), tilted], None),
            (vec![level(-0.1)], None),
        ] {
            let covers: Vec<_> = areas.iter().map(|area| cover(area, &aperture)).collect();
            assert_eq!(drawn(&covers, &aperture).height(), expected, "{areas:?}");
        }
    }

    #[test]
    fn tables_want_the_squares_of_pressures() {
        let aperture = Aperture::new(&scene(4));
        let tilted = |pressure: f64, x: f64| {
            let normal = DVec3::new(0.2, 0.0, 1.0);
            let at = DVec3::new(x, 0.0, 0.1);
            cover(&Target { normal, pressure, ..area(at, WIDTH, HEIGHT) }, &aperture)
        };
        let covers = [tilted(3.0, 0.0), tilted(0.5, 0.05)];
        let drawn = drawn(&covers, &aperture);
        for (cover, expected) in covers.iter().zip([9.0, 0.25]) {
            let brightness = drawn.at(cover.centre, 1e-3);
            assert!((brightness - expected).abs() < 1e-12, "{brightness}, not {expected}");
        }
    }
}
