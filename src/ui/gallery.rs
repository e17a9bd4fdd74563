//! The examples as pictures: over an empty scene until closed, and in a dialog; and the hints of the first start.

use egui::{Align2, Area, Button, Frame, Id, Image, Order, Rect, RichText, ScrollArea, Ui, vec2};

use crate::ui::tool::Tool;
use crate::ui::{command::Command, editor::Editor, shown::Card, shown::Shown, theme};

/// Points of the screen: a card's picture, its caption, and the gap between cards.
const PICTURE: egui::Vec2 = vec2(132.0, 88.0);
const CAPTION: f32 = 18.0;
const GAP: f32 = 10.0;
/// Pixels of a thumbnail.
pub const PIXELS: (usize, usize) = (198, 132);
/// Points of the screen that a gallery needs, its margins, and its most columns.
const LEAST: egui::Vec2 = vec2(200.0, 180.0);
const MARGIN: f32 = 64.0;
const COLUMNS: usize = 5;

const HINTS: [(&str, &str); 3] = [
    ("Draw", "Pick a tool on the left and draw on the map: the array's phases follow at once."),
    ("Look", "Turn the wheel to zoom, press 1 to 9 for another quantity, and XZ for the side view."),
    ("Find", "Ctrl P lists every command; F1 the keys."),
];

/// Whether the gallery is over the canvas: the scene is empty, nothing is being drawn, and it was not closed.
pub fn is_open(editor: &Editor) -> bool {
    let is_idle = editor.tool == Tool::Select && !editor.is_in_gesture() && editor.dialog.is_none();
    let is_closed = editor.has_closed_gallery || editor.layout.presents;
    editor.scene().targets.is_empty() && is_idle && !is_closed
}

/// Draws it over the canvas, if there is content.
pub(super) fn show(canvas: Rect, editor: &mut Editor, shown: &Shown, ui: &Ui, commands: &mut Vec<Command>) {
    let has_room = canvas.width() >= LEAST.x && canvas.height() >= LEAST.y;
    if !has_room || editor.layout.presents || editor.dialog.is_some() {
        return;
    }
    if is_open(editor) {
        let area = Area::new(Id::unique("gallery")).order(Order::Middle).pivot(Align2::CENTER_CENTER);
        area.fixed_pos(canvas.center()).show(ui.ctx(), |ui| {
            Frame::popup(ui.style()).show(ui, |ui| over_canvas(canvas, editor, shown, ui, commands));
        });
    } else if editor.hints {
        let area = Area::new(Id::unique("hints")).order(Order::Middle).pivot(Align2::LEFT_BOTTOM);
        area.fixed_pos(canvas.left_bottom() + vec2(12.0, -12.0)).show(ui.ctx(), |ui| {
            Frame::popup(ui.style()).show(ui, |ui| hints(editor, ui));
        });
    }
}

fn over_canvas(canvas: Rect, editor: &mut Editor, shown: &Shown, ui: &mut Ui, commands: &mut Vec<Command>) {
    let height = (canvas.height() - 100.0).clamp(80.0, 420.0);
    let width = canvas.width() - MARGIN;
    ui.set_max_width(width);
    let cards = columns(width);
    ui.allocate_ui(vec2(wide(cards), 22.0), |ui| {
        ui.horizontal(|ui| {
            let close = Button::new("Close").small();
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                if ui
                    .add(close)
                    .on_hover_text("Esc; Examples > All, with pictures shows them again")
                    .clicked()
                {
                    editor.has_closed_gallery = true;
                }
                let text = RichText::new("Start from an example, or pick a tool and draw").strong();
                ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
                    ui.add(egui::Label::new(text).truncate());
                });
            });
        });
    });
    show_cards((width, height), editor, shown, ui, commands);
}

/// Cards beside each other in this width.
fn columns(width: f32) -> usize {
    let room = width - egui::style::ScrollStyle::solid().bar_width - 8.0;
    ((room / (PICTURE.x + GAP)) as usize).clamp(1, COLUMNS)
}

/// Width of cards with a scroll bar beside them.
fn wide(columns: usize) -> f32 {
    columns as f32 * (PICTURE.x + GAP) + egui::style::ScrollStyle::solid().bar_width + 8.0
}

/// The cards, group by group. Returns whether one was chosen.
pub fn show_cards(
    (width, height): (f32, f32),
    editor: &mut Editor,
    shown: &Shown,
    ui: &mut Ui,
    commands: &mut Vec<Command>,
) -> bool {
    let columns = columns(width);
    ui.set_width(wide(columns));
    // A floating bar covers the last column.
    ui.spacing_mut().scroll = egui::style::ScrollStyle::solid();
    // A faded row reads as disabled.
    ui.spacing_mut().scroll.fade.strength = 0.0;
    let mut is_chosen = false;
    let cards: Vec<(usize, Card)> = shown.examples.iter().copied().enumerate().collect();
    ScrollArea::vertical().max_height(height).min_scrolled_height(height).auto_shrink([false, true]).show(
        ui,
        |ui| {
            ui.spacing_mut().item_spacing = vec2(GAP, GAP);
            for group in cards.chunk_by(|(_, a), (_, b)| a.group == b.group) {
                ui.label(theme::heading(group[0].1.group));
                for row in group.chunks(columns) {
                    ui.horizontal(|ui| {
                        for &(index, card) in row {
                            is_chosen |= example(index, card, editor, shown, ui, commands);
                        }
                    });
                }
            }
        },
    );
    is_chosen
}

fn example(
    index: usize,
    card: Card,
    editor: &mut Editor,
    shown: &Shown,
    ui: &mut Ui,
    commands: &mut Vec<Command>,
) -> bool {
    let size = PICTURE + vec2(0.0, CAPTION);
    // Only visible pictures are drawn, and only drawn ones are rendered.
    if !ui.is_rect_visible(Rect::from_min_size(ui.cursor().min, size)) {
        ui.allocate_space(size);
        return false;
    }
    let card_ui = |ui: &mut Ui| {
        ui.set_min_size(size);
        ui.spacing_mut().item_spacing.y = 2.0;
        ui.spacing_mut().button_padding = egui::Vec2::ZERO;
        let response = match shown.thumbnails.get(&index) {
            Some(texture) => {
                let image = Image::new((texture.id(), PICTURE)).fit_to_exact_size(PICTURE);
                // Of the size and in the place of the other, so that a click survives the arrival of the picture.
                ui.add_sized(PICTURE, Button::image(image).frame_when_inactive(false))
            }
            None => {
                commands.push(Command::Thumbnail(index));
                ui.add_sized(PICTURE, Button::new("…"))
            }
        };
        let response = response.accessible_name(format!("Example: {}", card.title));
        // Only what the caption cuts off has a tooltip.
        ui.add(egui::Label::new(RichText::new(card.title).small()).truncate());
        response.clicked()
    };
    let is_chosen = ui.allocate_ui_with_layout(size, egui::Layout::top_down(egui::Align::Min), card_ui).inner;
    if is_chosen {
        editor.ask(Command::Example(index), commands);
    }
    is_chosen
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
