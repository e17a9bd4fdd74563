//! The arrangement of panels around the map, with folding in small windows.

use egui::{Frame, Margin, Panel as Side, Ui, UiBuilder};

use crate::ui::{
    command::Command, editor::Editor, menu, panels, section, shown::Shown, status, theme, timeline, view_bar,
};

/// Widths of the right panel, beside the map and over it, in points.
const PANEL: std::ops::Range<f32> = 260.0..520.0;

const DRAWER: f32 = 340.0;

/// Minimum width of tools, map and axes beside the panel.
const SMALLEST_MAP: f32 = 520.0;

/// Menu, view bar, status, tools, panel and line profile, as space permits.
pub(super) fn around(
    editor: &mut Editor,
    shown: &Shown,
    clear: Frame,
    ui: &mut Ui,
    commands: &mut Vec<Command>,
) {
    let frame = clear.inner_margin(Margin::symmetric(8, 4));
    let (is_wide, is_high) = has_room(ui);
    let is_narrow = theme::is_narrow(ui.ctx());
    Side::top("menu").frame(frame).show(ui, |ui| menu::bar(editor, shown, ui, commands));
    if is_high {
        Side::top("view").frame(frame).show(ui, |ui| view_bar::show(editor, ui));
        Side::bottom("status").frame(frame).show(ui, |ui| status::bar(editor, shown, ui));
    }
    if is_wide {
        let columns = menu::tool_columns(ui.available_height() - 8.0);
        let width = menu::tool_width(columns);
        let tools = Side::left("tools").resizable(false).exact_size(width).frame(frame);
        tools.show(ui, |ui| menu::tools(editor, columns, ui));
    }
    if is_narrow {
        drawer(editor, shown, ui, commands);
    } else if !editor.layout.is_folded {
        panel(editor, shown, clear, ui, commands);
    }
    if is_high {
        timeline(editor, shown, clear, ui);
    }
    if is_high && editor.view.section && !editor.space.is_on {
        let section = Side::bottom("section")
            .frame(clear)
            .default_size(editor.layout.section)
            .size_range(110.0..=320.0);
        let section = section.resizable(true).show(ui, |ui| section::show(editor, shown, ui));
        editor.layout.section = section.response.rect.height();
    }
}

/// The timeline, if there is something to play.
pub(super) fn timeline(editor: &mut Editor, shown: &Shown, clear: Frame, ui: &mut Ui) {
    if timeline::is_wanted(editor) {
        let frame = clear.inner_margin(Margin::symmetric(8, 4));
        let timeline = Side::bottom("timeline").resizable(false).frame(frame);
        timeline.show(ui, |ui| timeline::show(editor, shown, ui));
    }
}

/// The panel beside the map: the user's width, independent of its content, limited to leave space for the map.
fn panel(editor: &mut Editor, shown: &Shown, clear: Frame, ui: &mut Ui, commands: &mut Vec<Command>) {
    let most = (ui.ctx().content_rect().width() - SMALLEST_MAP).clamp(PANEL.start, PANEL.end);
    let side = Side::right("panel").frame(clear).default_size(editor.layout.panel.min(most));
    let side = side.size_range(PANEL.start..=most).show(ui, |ui| {
        let rect = ui.available_rect_before_wrap();
        let mut inner = ui.new_child(UiBuilder::new().max_rect(rect));
        inner.shrink_clip_rect(rect);
        panels::show(editor, shown, &mut inner, commands);
        ui.advance_cursor_after_rect(rect);
    });
    editor.layout.panel = side.response.rect.width();
}

/// The panel over the map, in narrow windows.
fn drawer(editor: &mut Editor, shown: &Shown, ui: &Ui, commands: &mut Vec<Command>) {
    if !editor.layout.is_drawn_out {
        return;
    }
    let room = ui.available_rect_before_wrap();
    let width = DRAWER.min(room.width() - 16.0);
    let area = egui::Area::new(egui::Id::unique("drawer")).order(egui::Order::Middle);
    area.fixed_pos(room.right_top() - egui::vec2(width + 16.0, 0.0)).show(ui.ctx(), |ui| {
        Frame::popup(ui.style()).show(ui, |ui| {
            let rect = egui::Rect::from_min_size(ui.cursor().min, egui::vec2(width, room.height() - 16.0));
            let mut inner = ui.new_child(UiBuilder::new().max_rect(rect));
            inner.shrink_clip_rect(rect);
            panels::show(editor, shown, &mut inner, commands);
            ui.advance_cursor_after_rect(rect);
        });
    });
}

/// Whether a window has width and height for more than the menu and the canvas.
fn has_room(ui: &Ui) -> (bool, bool) {
    const WIDE: f32 = 460.0;
    const HIGH: f32 = 320.0;
    let size = ui.ctx().content_rect().size();
    (size.x >= WIDE, size.y >= HIGH)
}
