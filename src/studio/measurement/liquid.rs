//! A liquid as the sensor: measured heights of its surface and the strength that they tell.

use std::fs::File;
use std::path::Path;

use glam::{DVec2, DVec3};
use serde_json::{Value, json};

use crate::acoustics::response::responding;
use crate::field::{Evaluator, Quantity, Request, Stages};
use crate::measure::{DepressionFit, Estimate, fit_depression};
use crate::scene::{Plane, Scene};
use crate::solver;
use crate::source;
use crate::studio::figure::Panel;
use crate::studio::measurement::figure::{Sheet, maps, row_of_loudest};
use crate::table::{Table, TableError, npy};

/// Pixels of the model along the longer side: the cubic between them is exact to 1e-4.
const FINE: f64 = 800.0;
/// Heights, at most.
const MOST: usize = 1 << 20;
/// Largest array file, bytes.
const MOST_BYTES: u64 = 64 << 20;

/// Depressions of a liquid at places of the scene's plane.
#[derive(Clone, Debug, PartialEq)]
pub struct Heights {
    /// m from the plane's centre, along its axes.
    pub places: Vec<DVec2>,
    /// m, down.
    pub depressions: Vec<f64>,
}

/// Heights with the fit of the scene's strength.
#[derive(Clone, Debug)]
pub struct MeasuredLiquid {
    pub scene: Scene,
    pub heights: Heights,
    pub fit: DepressionFit,
}

/// Whether a file holds heights rather than pressures: an array, or a table with `depression` or `height`.
pub fn is_heights(path: &Path) -> bool {
    let is_array = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("npy"));
    let is_table = || {
        let file = File::open(path).ok()?;
        let table = Table::<_, 2, 3>::open(file, ["x", "y"], COLUMNS).ok()?;
        Some(table.has("depression") || table.has("height"))
    };
    is_array || is_table().unwrap_or(false)
}

const COLUMNS: [&str; 3] = ["z", "depression", "height"];

/// Reads heights: CSV with `x`, `y` and, off the plane, `z` (m), and `depression` (m, down) or `height` (m, up); or an NPY
/// array that covers the scene's plane as that of `render --data` does, in metres down.
///
/// # Errors
/// An unreadable file, an invalid row with its line, or an array without two dimensions.
pub fn read(scene: &Scene, path: &Path) -> Result<Heights, String> {
    let name = path.display();
    if path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("npy")) {
        let bytes = source::read(path, MOST_BYTES).map_err(|error| format!("{name}: {error}"))?;
        return of_array(&scene.plane, &bytes).map_err(|error| format!("{name}: {error}"));
    }
    let file = source::open(path).map_err(|error| format!("{name}: {error}"))?;
    of_table(&scene.plane, file).map_err(|error| format!("{name}:{error}"))
}

fn of_array(plane: &Plane, bytes: &[u8]) -> Result<Heights, String> {
    let (shape, values) = npy::read(bytes)?;
    let [rows, columns] = shape[..] else {
        return Err(format!("the array has {} dimensions: must have rows and columns", shape.len()));
    };
    let count = DVec2::new(columns as f64, rows as f64);
    let place = |index: usize| {
        let at = DVec2::new((index % columns) as f64, (index / columns) as f64) + 0.5;
        (at / count - 0.5) * plane.size
    };
    let known = values.iter().enumerate().filter(|(_, value)| value.is_finite());
    let (places, depressions) = known.map(|(index, value)| (place(index), *value)).unzip();
    Ok(Heights { places, depressions })
}

fn of_table(plane: &Plane, file: impl std::io::Read) -> Result<Heights, TableError> {
    let mut table = Table::open(file, ["x", "y"], COLUMNS)?;
    let (x_axis, y_axis) = plane.axes().unwrap_or((DVec3::X, DVec3::Y));
    let mut heights = Heights { places: Vec::new(), depressions: Vec::new() };
    while let Some(row) = table.next_row()? {
        let ([x, y], [z, depression, height]) = (row.required, row.optional);
        let offset = DVec3::new(x, y, z.unwrap_or(plane.centre.z)) - plane.centre;
        let Some(down) = depression.or(height.map(|height| -height)) else {
            return Err(table.refusal("must have a column depression (m, down) or height (m, up)"));
        };
        if heights.places.len() == MOST {
            return Err(table.refusal(format!("more than {MOST} heights")));
        }
        heights.places.push(DVec2::new(offset.dot(x_axis), offset.dot(y_axis)));
        heights.depressions.push(down);
    }
    Ok(heights)
}

impl MeasuredLiquid {
    /// Fits the strength of a scene with a liquid to heights of its surface under the scene's own drive.
    ///
    /// # Errors
    /// A scene that cannot be solved or has no depression, or heights that do not tell the strength.
    pub fn new(scene: Scene, heights: &Heights) -> Result<Self, String> {
        let solution = solver::solve(&scene).map_err(|error| error.to_string())?;
        let drives = responding(&scene, solution.drives(), false);
        let size = scene.plane.size;
        let pixels = (size / size.max_element() * FINE).ceil().as_uvec2();
        let size_of = (pixels.x as usize, pixels.y as usize);
        let request = Request::new(&scene, drives, Quantity::Depression, size_of);
        let mut stages = Stages::new(Evaluator::Cpu);
        let map = stages.map(&request).map_err(|error| error.to_string())?;
        let half = size / 2.0;
        let inside = |place: &DVec2| place.abs().cmple(half).all();
        let (places, depressions): (Vec<_>, Vec<_>) = heights
            .places
            .iter()
            .zip(&heights.depressions)
            .filter(|(place, _)| inside(place))
            .map(|(place, value)| (*place, *value))
            .unzip();
        let heights = Heights { places, depressions };
        let fit = fit_depression(map, size, &heights.places, &heights.depressions).ok_or_else(|| {
            let count = heights.places.len();
            format!("{count} heights on the scene's plane do not tell the strength: measure where the surface sinks")
        })?;
        if fit.scale.value == 0.0 {
            return Err("the surface rises where the sound presses it down: give heights upwards in a column height, \
                        depressions downwards in a column depression"
                .to_owned());
        }
        Ok(Self { scene, heights, fit })
    }

    /// Pa m
    pub fn strength(&self) -> Estimate {
        let of_scene = self.scene.array.strength;
        let Estimate { value, error, is_free } = self.fit.scale;
        Estimate { value: value * of_scene, error: error * of_scene, is_free }
    }

    /// What was found, a line each.
    pub fn lines(&self) -> Vec<String> {
        let Estimate { value, error, .. } = self.strength();
        let (shift, off) = (self.fit.shift * 1e3, self.fit.shift_error * 1e3);
        vec![
            format!("residual {:.1} % of the depression", 100.0 * self.fit.residual),
            format!("strength {value:.3} ± {error:.3} Pa·m (scene {} Pa·m)", self.scene.array.strength),
            format!("picture shifted by {:.2} ± {:.2}, {:.2} ± {:.2} mm", shift.x, off.x, shift.y, off.y),
            format!("zero of the heights {:.1} µm", self.fit.offset * 1e6),
        ]
    }

    pub fn json(&self) -> Value {
        let Estimate { value, error, .. } = self.strength();
        json!({
            "strength": value,
            "strength_error": error,
            "residual": self.fit.residual,
            "offset": self.fit.offset,
            "identifiable": true,
            "pose": {
                "x": self.fit.shift.x,
                "x_error": self.fit.shift_error.x,
                "y": self.fit.shift.y,
                "y_error": self.fit.shift_error.y,
            },
        })
    }

    /// Measured, model and difference, and the row through the deepest place.
    pub fn panels(&self) -> Vec<Panel> {
        let sheet = Sheet {
            drive: 0,
            plane: self.scene.plane.clone(),
            readings: (0..self.heights.places.len()).collect(),
            places: self.heights.places.clone(),
        };
        let (read, model) = (&self.heights.depressions, &self.fit.model);
        let mut panels =
            maps(&sheet, (Quantity::Depression, 1.0), read, model, (self.fit.residual, "")).to_vec();
        panels.extend(row_of_loudest(&sheet, (1e6, "depression / µm"), read, model));
        panels
    }
}
