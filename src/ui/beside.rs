//! The comparison map: the user's choice and its result.

use egui::Rect;
use glam::{DVec2, DVec3};

use crate::field::Quantity;
use crate::scene::Method;
use crate::ui::map::{Map, Texture};
use crate::ui::sound::Sound;
use crate::ui::view::{Cut, View, Window};

/// The difference of the second map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum With {
    /// Another method.
    Method,
    /// The drive on a number of phase levels.
    Levels,
    /// Another plane.
    Plane,
}

/// The comparison map.
#[derive(Clone, Debug, PartialEq)]
pub struct Compare {
    pub with: With,
    pub method: Method,
    pub levels: u32,
    pub cut: Cut,
    /// Whether the difference is shown on the right.
    pub difference: bool,
    /// Whether there is room for two maps.
    pub is_split: bool,
    /// Position of the pointer on either map, m.
    pub pointer: Option<DVec3>,
    /// Centre of another plane's view, m; shared coordinates follow the first map.
    pub centre: Option<DVec2>,
}

impl Default for Compare {
    fn default() -> Self {
        Self {
            with: With::Method,
            method: Method::Naive,
            levels: 16,
            cut: Cut::Xz,
            difference: false,
            is_split: false,
            pointer: None,
            centre: None,
        }
    }
}

impl Compare {
    /// The view of the second map.
    pub fn view(&self, view: &View) -> View {
        match self.with {
            With::Plane => View { cut: self.cut, window: None, ..view.clone() },
            With::Method | With::Levels => view.clone(),
        }
    }

    /// Whether a difference is shown, for maps that have one.
    pub fn is_subtracted(&self) -> bool {
        self.difference && self.with != With::Plane
    }

    /// Names of both sides, from what the first map shows.
    pub fn names(&self, own: &str, levels: Option<u32>, cut: Cut) -> [String; 2] {
        let drive =
            |levels: Option<u32>| levels.map_or("ideal drive".to_owned(), |n| format!("{n} phase levels"));
        match self.with {
            With::Method => [own.to_owned(), self.method.title().to_owned()],
            With::Levels => [drive(levels), drive(Some(self.levels))],
            With::Plane => [cut.into_str().to_owned(), self.cut.into_str().to_owned()],
        }
    }
}

/// The result of the second map.
#[derive(Debug, Default)]
pub struct Beside {
    pub map: Option<Map>,
    pub sound: Option<Sound>,
    pub problem: Option<String>,
    /// It is still being solved.
    pub is_pending: bool,
    pub difference: Option<Difference>,
}

/// The first map minus the second.
#[derive(Debug)]
pub struct Difference {
    pub texture: Texture,
    /// The largest amount.
    pub largest: f64,
    pub quantity: Quantity,
    pub window: Window,
    /// Rectangle of the first map in points.
    pub rect: Rect,
}
