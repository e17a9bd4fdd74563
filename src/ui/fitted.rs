//! The fitted view of a plane.

use egui::Rect;
use glam::DVec2;

use crate::scene::{Array, Plane, Scene, outline};
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
    pub(super) lens: Option<Lens>,
}

impl Fitted {
    pub(super) fn new(view: &View, scene: &Scene) -> Self {
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
    pub(super) fn next(before: Option<Self>, view: &View, scene: &Scene, is_held: bool) -> Self {
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

    pub(super) fn window(&self, rect: Rect) -> Window {
        Window::around(self.centre, self.size, rect)
    }
}
