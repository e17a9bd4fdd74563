//! Replaces the link in builds without serial ports.

use eframe::egui::Context;

use crate::ui::board::{BoardCommand, BoardShown};
use crate::ui::{Editor, Shown};

#[derive(Debug, Default)]
pub struct Board {}

impl Board {
    pub fn shown() -> BoardShown {
        let why = "This program was built without serial links, so no board can be driven from here.";
        BoardShown { unavailable: Some(why.to_owned()), ..BoardShown::default() }
    }

    pub fn silencer(&self) -> Box<dyn Fn() + Send + Sync> {
        Box::new(|| {})
    }

    pub fn attend(&mut self, _: &mut Shown) {}

    pub fn execute(&mut self, _: &BoardCommand, _: &mut Editor, _: &mut Shown, _: &Context) {}

    pub fn update(&mut self, _: &mut Editor, _: &mut Shown, _: &Context) {}
}
