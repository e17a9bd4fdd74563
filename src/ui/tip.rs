//! Tooltips beside entries of menus and lists, whose neighbours they must not cover.

use egui::{RectAlign, Response, Tooltip};

/// Shows a text beside a widget while the pointer rests on it.
pub fn beside(response: &Response, text: &str) {
    let mut tip = Tooltip::for_enabled(response);
    tip.popup = tip.popup.align(RectAlign::RIGHT_START).align_alternatives(&[RectAlign::LEFT_START]);
    tip.show(|ui| ui.label(text));
}
