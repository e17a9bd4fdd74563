//! The fitted view of a plane, and transitions to other views.
//!
//! A fitted view stays while targets move within it.

use egui::Rect;

use crate::ui::editor::Editor;
use crate::ui::fitted::Fitted;
use crate::ui::gesture::Gesture;
use crate::ui::measure::ProfileLine;
use crate::ui::view::{Cut, Lens, Window};

impl Editor {
    /// Shows another plane, fitted.
    pub fn look_at(&mut self, cut: Cut) {
        self.view.cut = cut;
        self.view.line = self.view.middle(&self.document.scene);
        self.fit();
    }

    /// Shows everything.
    pub fn fit(&mut self) {
        self.view.window = None;
        self.fitted = None;
        self.space.go_home();
    }

    /// The part of the plane on this rectangle of the screen; `is_held` while something is dragged or typed.
    pub(in crate::ui) fn lens(&mut self, rect: Rect, is_held: bool) -> Lens {
        let is_held = is_held || self.is_in_gesture();
        let mut fitted = Fitted::next(self.fitted.take(), &self.view, &self.document.scene, is_held);
        let window = match (self.view.window, fitted.lens.filter(|_| is_held)) {
            (Some(window), _) => window,
            // Panels may shrink the map meanwhile: the point under the pointer stays.
            (None, Some(last)) => Window { centre: last.flat(rect.center()), ..last.window },
            (None, None) => fitted.window(rect),
        };
        let lens = Lens { rect, window };
        fitted.lens = Some(lens);
        self.fitted = Some(fitted);
        lens
    }

    /// Whether a measuring line is being drawn.
    pub(in crate::ui) fn is_measuring(&self) -> bool {
        let is_free = matches!(self.view.line, ProfileLine::Between(_));
        is_free && matches!(self.gesture, Some(Gesture::Measure { .. }))
    }

    /// Removes a measured line.
    pub(in crate::ui) fn put_line_away(&mut self) {
        if let ProfileLine::Between(_) = self.view.line {
            self.view.line = self.view.middle(&self.document.scene);
            self.view.section = false;
        }
    }
}
