//! Maps of the played scene, for other programs.

use std::sync::Mutex;

use serde_json::{Value, json};

use crate::control::json::MapWish;
use crate::control::report::Report;
use crate::device::task::locked;
use crate::echo;
use crate::field::{Evaluator, Request, Stages};

/// Maps are made one at a time, reusing the stages.
#[derive(Debug)]
pub struct Maps(Mutex<Stages>);

impl Default for Maps {
    fn default() -> Self {
        Self(Mutex::new(Stages::new(Evaluator::Cpu)))
    }
}

/// A map's values with their description.
#[derive(Clone, Debug)]
pub struct Drawn {
    pub head: Value,
    /// Float32, little-endian, row 0 at the smallest y.
    pub numbers: Vec<u8>,
}

impl Maps {
    /// The map of a report's drive on the scene's plane, at rest.
    ///
    /// # Errors
    /// A scene without a drive, and a map that the field refuses.
    pub fn draw(&self, wish: MapWish, report: &Report) -> Result<Drawn, String> {
        let (Some(solution), Some(scene)) = (&report.solution, report.wish.as_ref().map(|wish| &wish.scene))
        else {
            return Err(report.problem.clone().unwrap_or_else(|| "nothing is solved yet".to_owned()));
        };
        if solution.drive.phases.len() != scene.elements() {
            return Err("the scene is being solved: ask again".to_owned());
        }
        let MapWish { quantity, size } = wish;
        let request = Request::new(scene, solution.drives(), quantity, size);
        let mut stages = locked(&self.0);
        let map = stages.map(&request).map_err(|error| echo::message(&error.to_string()))?;
        let head = json!({
            "quantity": quantity.declaration().name,
            "unit": quantity.declaration().unit.symbol(),
            "size": [map.width, map.height],
            "peak": map.peak,
            "loudest": map.loudest,
            "error": map.error,
            "plane": scene.plane,
            "change": report.generation,
        });
        Ok(Drawn { head, numbers: map.values.iter().flat_map(|value| value.to_le_bytes()).collect() })
    }
}
