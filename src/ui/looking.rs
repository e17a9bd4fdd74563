//! The fitted view of a plane, and transitions to other views.
//!
//! A fitted view stays while targets move within it.

use egui::Rect;
use glam::DVec2;

use crate::scene::{Array, Plane, Scene, outline};
use crate::ui::Editor;
use crate::ui::gesture::Gesture;
use crate::ui::measure::ProfileLine;
use crate::ui::view::{Cut, Lens, View, Window};

/// Limit of a fitted view's size relative to the required one.
const MOST_FREE: f64 = 3.0;

/// The fitted view. It is kept while targets move within it, so that the map does not shift under the pointer.
#[derive(Clone, Debug, PartialEq)]
pub struct Fitted {
    cut: Cut,
    plane: Plane,
    array: Array,
    /// m
    centre: DVec2,
    size: DVec2,
    /// Where it was last.
    lens: Option<Lens>,
}

impl Fitted {
    fn new(view: &View, scene: &Scene) -> Self {
        let (centre, size) = view.whole(scene);
        Self {
            cut: view.cut,
            plane: scene.plane.clone(),
            array: scene.array.clone(),
            centre,
            size,
            lens: None,
        }
    }

    /// The view of the next frame; `is_held` while something is dragged or typed.
    fn next(before: Option<Self>, view: &View, scene: &Scene, is_held: bool) -> Self {
        let fresh = Self::new(view, scene);
        match before.filter(|before| before.cut == fresh.cut) {
            Some(before) if is_held || before.holds(&fresh, scene) => before,
            _ => fresh,
        }
    }

    /// Whether it contains every target at a reasonable size.
    fn holds(&self, fresh: &Self, scene: &Scene) -> bool {
        let highest = scene.targets.iter().map(|target| outline::centre(&target.shape).z).fold(0.0, f64::max);
        let is_in = match self.cut {
            Cut::Xz | Cut::Yz => {
                let is_near = self.size.y <= MOST_FREE * fresh.size.y && self.size.x == fresh.size.x;
                highest <= self.size.y && is_near
            }
            Cut::Xy | Cut::Free | Cut::Own => (self.centre, self.size) == (fresh.centre, fresh.size),
        };
        is_in && (&self.plane, &self.array) == (&fresh.plane, &fresh.array)
    }

    fn window(&self, rect: Rect) -> Window {
        Window::around(self.centre, self.size, rect)
    }
}

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
