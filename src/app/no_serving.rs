//! Replaces the server for other programs in a page, which has no sockets.

use eframe::egui::Context;

use crate::ui::{Editor, Shown};

#[derive(Debug, Default)]
pub struct Serving {}

impl Serving {
    pub fn switch(
        &mut self,
        _: bool,
        _: &Editor,
        _: &mut Shown,
        _: Box<dyn Fn() + Send + Sync>,
        _: &Context,
    ) {
    }

    pub fn exchange(&mut self, _: &mut Editor, _: &Shown, _: &Context) {}

    pub fn tell(&mut self, _: &Editor, _: &mut Shown) {}

    pub fn is_in_burst(&mut self, _: &Context) -> bool {
        false
    }
}
