//! The radiation pressure on the scene plane and its effects.

use std::sync::{Arc, Mutex, PoisonError};

use crate::field::{Declaration, Evaluator, Pressed, Request, Stages};
use crate::studio::liquid;
use crate::ui::part::{Now, Part};

/// Pixels per wavelength: a square of the sound has two cycles per wavelength.
const PER_WAVELENGTH: f64 = 6.0;
const MOST_PER_SIDE: f64 = 1024.0;

/// The figures of the Liquid page.
#[derive(Debug)]
pub struct Radiation {
    /// Stages with cached results.
    stages: Arc<Mutex<Stages>>,
}

impl Default for Radiation {
    fn default() -> Self {
        Self { stages: Arc::new(Mutex::new(Stages::new(Evaluator::Cpu))) }
    }
}

/// The radiation pressure, and a warning about a depression beyond linear theory.
#[derive(Clone, Debug)]
pub struct RadiationFigures {
    pub pressed: Pressed,
    pub beyond: Option<String>,
}

impl Part for Radiation {
    type Input = Request;
    type Output = Option<RadiationFigures>;

    fn input(&self, now: &Now<'_>) -> Option<Request> {
        let quantity = now.view.quantity;
        let Declaration { is_slow, of_skin, .. } = *quantity.declaration();
        let sound = now.sound.filter(|_| is_slow && !of_skin)?;
        // On planes too near for cells, the force is computed from pixels.
        let pixels = now.scene.plane.size * PER_WAVELENGTH / sound.aperture.wavelength();
        let [width, height] = pixels.to_array().map(|side| side.ceil().clamp(1.0, MOST_PER_SIDE) as usize);
        Some(Request::new(now.scene, now.drives(quantity), quantity, (width, height)))
    }

    fn may_begin(&self, now: &Now<'_>) -> bool {
        now.rests
    }

    fn computation(&self) -> impl FnOnce(&Request) -> Self::Output + Send + 'static {
        let stages = Arc::clone(&self.stages);
        move |request| {
            let mut stages = stages.lock().unwrap_or_else(PoisonError::into_inner);
            let pressed = stages.pressed(request).ok()?;
            let depression = pressed.depression;
            let beyond = depression.and_then(|depression| liquid::beyond_linear_theory(depression.slope));
            Some(RadiationFigures { pressed, beyond })
        }
    }
}
