//! The displayed map and its position.

use glam::DVec2;

use crate::field::Quantity;
use crate::field::contour::Line;
use crate::ui::view::{Axes, Cut, Lens, Window};

/// A displayed map and its position.
#[derive(Debug)]
pub struct Map {
    pub texture: Texture,
    pub cut: Cut,
    pub axes: Axes,
    pub window: Window,
    /// Points of the screen.
    pub rect: egui::Rect,
    pub quantity: Quantity,
    /// rad, the ωt of an instantaneous pressure.
    pub phase: f64,
    /// An overlay that dims the picture.
    pub veil: Option<egui::TextureId>,
    /// The value of the last colour, if not the largest.
    pub full: Option<f64>,
    /// The value of the first colour of a linear scale, if chosen.
    pub low: Option<f64>,
    /// The largest value, as [`crate::field::Map::peak`] has it.
    pub largest: f64,
    /// On what the colours do not show.
    pub remark: Option<String>,
    /// Relative to the largest value.
    pub error: f64,
    pub how: String,
    pub width: usize,
    pub height: usize,
    pub contours: Vec<Line>,
    /// Vertical exaggeration of a shaded depression.
    pub exaggeration: Option<f64>,
    /// Points of the screen per metre of its depth.
    pub per_depth: f64,
    /// Values row by row from the smallest y, if available and not derivable from the sound at a point.
    pub numbers: Option<Vec<f32>>,
}

impl Map {
    /// The value at a point of the plane.
    pub fn number(&self, uv: DVec2) -> Option<f64> {
        let numbers = self.numbers.as_ref()?;
        let at = Lens { rect: self.rect, window: self.window }.screen(uv) - self.rect.min;
        let column = at.x / self.rect.width() * self.width as f32;
        let row = (1.0 - at.y / self.rect.height()) * self.height as f32;
        let inside = |place: f32, count: usize| (place as usize).min(count.saturating_sub(1));
        let index = inside(row, self.height) * self.width + inside(column, self.width);
        numbers.get(index).map(|&value| f64::from(value))
    }
}

/// Storage of a map's picture.
pub enum Texture {
    InEgui(egui::TextureHandle),
    /// On the device that draws the window, under this name.
    OnGpu(egui::TextureId),
}

impl Texture {
    pub fn id(&self) -> egui::TextureId {
        match self {
            Self::InEgui(texture) => texture.id(),
            Self::OnGpu(id) => *id,
        }
    }
}

impl std::fmt::Debug for Texture {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("Texture").field(&self.id()).finish()
    }
}
