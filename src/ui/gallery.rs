//! The start view of an empty scene: the examples as pictures, and at the first start three hints.

use egui::{Align2, Area, Button, Frame, Id, Image, Order, Rect, RichText, ScrollArea, Ui, vec2};

use crate::ui::tool::Tool;
use crate::ui::{command::Command, editor::Editor, shown::Shown};

/// Points of the screen: a card's picture, and the gap between cards.
const PICTURE: egui::Vec2 = vec2(132.0, 88.0);
const GAP: f32 = 10.0;
/// Pixels of a thumbnail.
pub const PIXELS: (usize, usize) = (198, 132);
/// Points of the screen that a gallery needs.
const LEAST: egui::Vec2 = vec2(200.0, 180.0);

const HINTS: [(&str, &str); 3] = [
    ("Draw", "Pick a tool on the left and draw on the map: the array's phases follow at once."),
    ("Look", "Turn the wheel to zoom, press 1 to 9 for another quantity, and XZ for the side view."),
    ("Find", "Ctrl P lists every command; F1 the keys."),
];

/// Draws it over the canvas, if there is content.
pub(super) fn show(canvas: Rect, editor: &mut Editor, shown: &Shown, ui: &Ui, commands: &mut Vec<Command>) {
    let has_room = canvas.width() >= LEAST.x && canvas.height() >= LEAST.y;
    if !has_room || editor.layout.presents || editor.dialog.is_some() {
        return;
    }
    let is_empty =
        editor.scene().targets.is_empty() && editor.tool == Tool::Select && !editor.is_in_gesture();
    if is_empty {
        let area = Area::new(Id::unique("gallery")).order(Order::Middle).pivot(Align2::CENTER_CENTER);
        area.fixed_pos(canvas.center()).show(ui.ctx(), |ui| {
            Frame::popup(ui.style()).show(ui, |ui| cards(canvas, editor, shown, ui, commands));
        });
    } else if editor.hints {
        let area = Area::new(Id::unique("hints")).order(Order::Middle).pivot(Align2::LEFT_BOTTOM);
        area.fixed_pos(canvas.left_bottom() + vec2(12.0, -12.0)).show(ui.ctx(), |ui| {
            Frame::popup(ui.style()).show(ui, |ui| hints(editor, ui));
        });
    }
}

fn cards(canvas: Rect, editor: &mut Editor, shown: &Shown, ui: &mut Ui, commands: &mut Vec<Command>) {
    let columns = (((canvas.width() - 60.0) / (PICTURE.x + GAP)) as usize).clamp(1, 5);
    ui.set_width(columns as f32 * (PICTURE.x + GAP) + 8.0);
    ui.label(RichText::new("Start from an example, or pick a tool and draw").strong());
    ui.add_space(4.0);
    let rows = shown.examples.len().div_ceil(columns);
    let height = (canvas.height() - 90.0).clamp(80.0, 420.0);
    let card = PICTURE.y + 24.0;
    ui.spacing_mut().item_spacing = vec2(GAP, GAP);
    // Only visible pictures are drawn, and only drawn ones are rendered.
    ScrollArea::vertical().max_height(height).show_rows(ui, card, rows, |ui, seen| {
        for row in seen {
            ui.horizontal(|ui| {
                for index in (row * columns..(row + 1) * columns).take_while(|&i| i < shown.examples.len()) {
                    example(index, editor, shown, ui, commands);
                }
            });
        }
    });
}

fn example(index: usize, editor: &mut Editor, shown: &Shown, ui: &mut Ui, commands: &mut Vec<Command>) {
    let title = &shown.examples[index];
    ui.vertical(|ui| {
        ui.set_width(PICTURE.x);
        ui.spacing_mut().item_spacing.y = 2.0;
        ui.spacing_mut().button_padding = egui::Vec2::ZERO;
        let response = match shown.thumbnails.get(&index) {
            Some(texture) => {
                let image = Image::new((texture.id(), PICTURE)).fit_to_exact_size(PICTURE);
                ui.add(Button::image(image).frame_when_inactive(false))
            }
            None => {
                commands.push(Command::Thumbnail(index));
                ui.add_sized(PICTURE, Button::new("…"))
            }
        };
        let response = response.accessible_name(format!("Example: {title}"));
        if response.on_hover_text(title).clicked() {
            editor.ask(Command::Example(index), commands);
        }
        ui.add(egui::Label::new(RichText::new(title).small()).truncate());
    });
}

fn hints(editor: &mut Editor, ui: &mut Ui) {
    ui.set_max_width(380.0);
    for (name, text) in HINTS {
        ui.horizontal_wrapped(|ui| {
            ui.strong(name);
            ui.label(text);
        });
    }
    if ui.button("Got it").on_hover_text("Hides the hints for good").clicked() {
        editor.hints = false;
    }
}
