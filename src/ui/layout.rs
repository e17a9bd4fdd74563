//! The arrangement of the window: its pages, and the sizes of its panels.

use strum::{EnumString, IntoStaticStr, VariantArray};

use crate::ui::theme;

/// The page of the right panel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, EnumString, IntoStaticStr, VariantArray)]
#[strum(const_into_str)]
pub enum Panel {
    Scene,
    Solver,
    Drive,
    Liquid,
    Motion,
    Felt,
    Device,
    Measure,
}

/// Sizes of resizable panels in points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layout {
    /// Width of the one on the right.
    pub panel: f32,
    /// Height of the cross-section.
    pub section: f32,
    /// The panel on the right is folded away.
    pub is_folded: bool,
    /// In a narrow window: whether it covers the map.
    pub is_drawn_out: bool,
    /// Presentation mode: the map and its colour bar alone.
    pub presents: bool,
    /// Whether the timeline is shown in it.
    pub has_timeline: bool,
}

impl Layout {
    /// Whether the panel on the right is shown.
    pub fn has_panel(&self, ctx: &egui::Context) -> bool {
        if theme::is_narrow(ctx) { self.is_drawn_out } else { !self.is_folded }
    }

    /// Folds the panel on the right away, or brings it back.
    pub fn toggle(&mut self, ctx: &egui::Context) {
        if theme::is_narrow(ctx) {
            self.is_drawn_out = !self.is_drawn_out;
        } else {
            self.is_folded = !self.is_folded;
        }
    }
}
