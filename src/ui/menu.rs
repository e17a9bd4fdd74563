//! The menus, the tools, and the board's state with its Send and Stop button.

use std::path::PathBuf;

use egui::containers::menu::MenuBar;
use egui::{
    Atom, Button, Color32, Context, IdSalt, Label, ProgressBar, RichText, Sense, Stroke, Ui, Vec2, vec2,
};
use strum::VariantArray;

use crate::device::health::State;
use crate::ui::action::{self, Action, Group};
use crate::ui::board::{BoardCommand, Plays, absence};
use crate::ui::tool::{self, Tool};
use crate::ui::{command::Command, editor::Editor, shown::Shown, theme, tip};

/// Points of the screen: a tool with the gap below it.
const TOOL: f32 = 32.0;
const GAP: f32 = 4.0;
/// Size of Send and Stop.
const SOUND: Vec2 = vec2(72.0, 22.0);
/// Points of the screen: a check mark.
const CHECK: f32 = 10.0;
const MARK: &str = "check mark";
/// Connected and silent.
const SILENT: Color32 = Color32::from_rgb(70, 190, 110);

pub fn bar(editor: &mut Editor, shown: &Shown, ui: &mut Ui, commands: &mut Vec<Command>) {
    MenuBar::new().ui(ui, |ui| {
        ui.menu_button("File", |ui| file(editor, shown, ui, commands));
        ui.menu_button("Edit", |ui| edit(editor, shown, ui, commands));
        ui.menu_button("View", |ui| view(editor, shown, ui, commands));
        ui.menu_button("Examples", |ui| examples(editor, shown, ui, commands));
        ui.menu_button("Export", |ui| group(Group::Export, editor, shown, ui, commands));
        ui.menu_button("Help", |ui| group(Group::Help, editor, shown, ui, commands));
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            state(editor, shown, ui, commands);
            ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
                ui.separator();
                export(shown, ui, commands);
                let unsaved = if editor.document.is_unsaved() { " •" } else { "" };
                let name = RichText::new(format!("{}{unsaved}", editor.document.name())).strong();
                let path = editor.document.path();
                let path = path.map_or_else(|| "No file yet".to_owned(), |path| path.display().to_string());
                ui.add(Label::new(name).truncate().show_tooltip_when_elided(false)).on_hover_text(path);
            });
        });
    });
}

/// At the right: unsaved changes, the board's state, and Send or Stop.
fn state(editor: &mut Editor, shown: &Shown, ui: &mut Ui, commands: &mut Vec<Command>) {
    send_or_stop(editor, shown, ui, commands);
    let panel = ui.button("Panel").on_hover_text("Show or hide the panel (F9)");
    if panel.clicked() {
        editor.layout.toggle(ui.ctx());
    }
    let (colour, word) = board(shown, ui);
    let name = if editor.board.virtual_port.is_some() { "Virtual board" } else { "Board" };
    if ui.add(dotted(colour, name)).on_hover_text(word).clicked() {
        Action::ShowPanel(crate::ui::Panel::Device).run(editor, shown, ui.ctx(), commands);
        editor.layout.is_folded = false;
    }
    let is_in_file = editor.document.path().is_some();
    let (colour, name, tip) = match (editor.document.is_unsaved(), is_in_file) {
        (true, _) => (
            theme::warning(ui.visuals()),
            "Unsaved",
            "Your changes have not been saved: click to save (Ctrl S)",
        ),
        (false, true) => (SILENT, "Saved", "All changes are saved"),
        (false, false) => (
            ui.visuals().weak_text_color(),
            "No file",
            "The scene is in no file yet: click to save it (Ctrl S)",
        ),
    };
    let can_save = editor.document.is_unsaved() || !is_in_file;
    if ui.add(dotted(colour, name)).on_hover_text(tip).clicked() && can_save {
        commands.push(Command::Save);
    }
}

fn dotted(colour: Color32, name: &str) -> Button<'_> {
    Button::new((RichText::new("•").color(colour).strong().size(18.0), name))
}

/// The colour of the board's dot, and its state in words.
fn board(shown: &Shown, ui: &Ui) -> (Color32, String) {
    let board = &shown.board;
    match board.health.as_ref().map(|health| &health.state) {
        None => (ui.visuals().weak_text_color(), "No board is connected".to_owned()),
        Some(State::Connecting) => (theme::warning(ui.visuals()), "Looking for the board".to_owned()),
        Some(State::Lost(why)) => {
            let was_found = board.health.as_ref().is_some_and(|health| health.found > 0);
            (theme::error(ui.visuals()), absence(why, was_found))
        }
        Some(State::Ready) if board.plays == Plays::Nothing => {
            (SILENT, "The board is connected and silent".to_owned())
        }
        Some(State::Ready) => (theme::ACCENT, "The board sounds".to_owned()),
    }
}

/// Send, or Stop while a board sounds: one place that never moves.
fn send_or_stop(editor: &mut Editor, shown: &Shown, ui: &mut Ui, commands: &mut Vec<Command>) {
    /// Time (s) after Stop in which a further click, meant for it, does not send.
    const HASTE: f64 = 1.0;
    if shown.board.plays != Plays::Nothing {
        return stop(shown, ui, commands);
    }
    let (stopped, now) = (ui.data(|data| data.get_temp(stopped_id())), ui.input(|input| input.time));
    let since = stopped.map_or(f64::INFINITY, |at: f64| now - at);
    if since < HASTE {
        ui.ctx().request_repaint_after_secs((HASTE - since) as f32);
    }
    let tip = match (&shown.board.health, editor.board.port()) {
        (Some(_), _) => "The board plays the scene, with its motion (Esc twice stops it)".to_owned(),
        (None, "") => "Opens the Device page, where a board is chosen".to_owned(),
        (None, port) => format!("Connects to the board at {port}, and plays the scene"),
    };
    let button = theme::primary("Send").min_size(SOUND);
    if ui.add_enabled(since >= HASTE, button).on_hover_text(tip).clicked() {
        Action::Send.run(editor, shown, ui.ctx(), commands);
    }
}

/// Where the time of the last click on Stop is kept.
fn stopped_id() -> egui::Id {
    egui::Id::unique("board stopped")
}

/// Shown whenever a board sounds.
fn stop(shown: &Shown, ui: &mut Ui, commands: &mut Vec<Command>) {
    if shown.board.plays == Plays::Nothing {
        return;
    }
    let button = theme::destructive("Stop").min_size(SOUND);
    if ui.add(button).on_hover_text("Silences the board (Esc twice)").clicked() {
        let now = ui.input(|input| input.time);
        ui.data_mut(|data| data.insert_temp(stopped_id(), now));
        commands.push(Command::Board(BoardCommand::Stop));
    }
}

/// The same over the map alone.
pub fn presented_stop(shown: &Shown, ctx: &Context, commands: &mut Vec<Command>) {
    if shown.board.plays == Plays::Nothing {
        return;
    }
    let area = egui::Area::new(egui::Id::unique("presented stop")).order(egui::Order::Foreground);
    area.anchor(egui::Align2::RIGHT_TOP, vec2(-12.0, 12.0)).show(ctx, |ui| stop(shown, ui, commands));
}

/// The export in progress.
fn export(shown: &Shown, ui: &mut Ui, commands: &mut Vec<Command>) {
    let Some((name, part)) = &shown.export else { return };
    let bar = ProgressBar::new(*part).desired_width(120.0).text(format!("{:.0} %", part * 100.0));
    ui.add(bar).on_hover_text(format!("Writing {name}"));
    let tip = format!("Ends the export; {name} is not written");
    if ui.button("Cancel export").on_hover_text(tip).clicked() {
        commands.push(Command::CallOff);
    }
    ui.separator();
}

/// Groups of examples, and all of them with pictures.
fn examples(editor: &mut Editor, shown: &Shown, ui: &mut Ui, commands: &mut Vec<Command>) {
    let cards: Vec<_> = shown.examples.iter().copied().enumerate().collect();
    for group in cards.chunk_by(|(_, a), (_, b)| a.group == b.group) {
        ui.menu_button(group[0].1.group, |ui| {
            for &(index, card) in group {
                if ui.button(card.title).clicked() {
                    editor.ask(Command::Example(index), commands);
                }
            }
        });
    }
    ui.separator();
    if ui.button("All, with pictures…").clicked() {
        Action::Examples.run(editor, shown, ui.ctx(), commands);
    }
}

/// The place of a check mark.
fn check() -> Atom<'static> {
    Atom::custom(IdSalt::new(MARK), vec2(CHECK, CHECK))
}

/// An action in a menu, with a check mark if it switches something on.
fn item(action: Action, editor: &mut Editor, shown: &Shown, ui: &mut Ui, commands: &mut Vec<Command>) {
    let possible = action.possible(editor, shown);
    let keys = action.shortcut(ui.ctx());
    let is_on = action.is_on(editor, ui.ctx());
    let name = action.name();
    let button = Button::new((check(), name.clone()));
    let button = if keys.is_empty() { button } else { button.shortcut_text(keys) };
    let drawn = ui.add_enabled_ui(possible.is_ok(), |ui| button.atom_ui(ui)).inner;
    if let (Some(true), Some(rect)) = (is_on, drawn.rect(IdSalt::new(MARK))) {
        let at = |x: f32, y: f32| rect.center() + vec2(x, y) * (CHECK / 2.0);
        let line = vec![at(-0.8, 0.0), at(-0.25, 0.6), at(0.8, -0.65)];
        ui.painter().line(line, Stroke::new(1.6, ui.visuals().text_color()));
    }
    let response = drawn.response;
    if let Some(is_on) = is_on {
        let enabled = possible.is_ok();
        response
            .widget_info(|| egui::WidgetInfo::selected(egui::Role::MenuItemCheckBox, enabled, is_on, &name));
    }
    if response.on_disabled_hover_text(possible.err().unwrap_or_default()).clicked() {
        action.run(editor, shown, ui.ctx(), commands);
    }
}

fn group(group: Group, editor: &mut Editor, shown: &Shown, ui: &mut Ui, commands: &mut Vec<Command>) {
    for action in Action::all().into_iter().filter(|action| action.group() == group) {
        item(action, editor, shown, ui, commands);
    }
}

fn file(editor: &mut Editor, shown: &Shown, ui: &mut Ui, commands: &mut Vec<Command>) {
    for action in Action::all().into_iter().filter(|action| action.group() == Group::File) {
        if matches!(action, Action::Save | Action::Import | Action::CopyLink | Action::Quit) {
            ui.separator();
        }
        item(action, editor, shown, ui, commands);
        if action == Action::Open {
            ui.add_enabled_ui(!shown.recent.is_empty(), |ui| {
                ui.menu_button((check(), "Open recent"), |ui| recent(editor, &shown.recent, ui, commands));
            });
        }
    }
}

fn view(editor: &mut Editor, shown: &Shown, ui: &mut Ui, commands: &mut Vec<Command>) {
    let actions = [
        Action::ShowEverything,
        Action::Space,
        Action::Targets,
        Action::Profile,
        Action::Compare,
        Action::Play,
        Action::Mean,
        Action::Waves,
        Action::TogglePanel,
        Action::Present,
        Action::Timeline,
        Action::DarkTheme,
        Action::WhiteBackground,
    ];
    for action in actions {
        item(action, editor, shown, ui, commands);
    }
    ui.separator();
    ui.menu_button((check(), "Scale"), |ui| {
        for factor in action::SCALES {
            let is_chosen = (ui.ctx().zoom_factor() - factor).abs() < 0.01;
            if ui.selectable_label(is_chosen, format!("{:.0} %", factor * 100.0)).clicked() {
                action::scale(ui.ctx(), factor);
            }
        }
    });
}

fn recent(editor: &mut Editor, recent: &[PathBuf], ui: &mut Ui, commands: &mut Vec<Command>) {
    for path in recent {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let button = ui.button(name);
        tip::beside(&button, &path.display().to_string());
        if button.clicked() {
            editor.ask(Command::Open(path.clone()), commands);
        }
    }
    ui.separator();
    if ui.button("Clear list").clicked() {
        commands.push(Command::ForgetRecent);
    }
}

fn edit(editor: &mut Editor, shown: &Shown, ui: &mut Ui, commands: &mut Vec<Command>) {
    let is_arrangement = |action: &Action| {
        matches!(action, Action::Align(_) | Action::DistributeAcross | Action::DistributeUp)
    };
    let actions = Action::all().into_iter().filter(|action| action.group() == Group::Edit);
    let (arrangements, others): (Vec<_>, Vec<_>) = actions.partition(is_arrangement);
    for action in others {
        if action == Action::Snap {
            ui.menu_button((check(), "Align"), |ui| {
                arrangements.iter().for_each(|&action| item(action, editor, shown, ui, commands));
            });
        }
        if matches!(action, Action::Cut | Action::Snap) {
            ui.separator();
        }
        item(action, editor, shown, ui, commands);
    }
}

/// Columns of tools for this height in points.
pub fn tool_columns(height: f32) -> usize {
    let rows = ((height + GAP) / (TOOL + GAP)).floor().max(1.0) as usize;
    Tool::VARIANTS.len().div_ceil(rows).min(3)
}

/// Width of tool columns with margins, in points.
pub fn tool_width(columns: usize) -> f32 {
    columns as f32 * (TOOL + GAP) - GAP + 16.0
}

/// The tools, one below the other.
pub fn tools(editor: &mut Editor, columns: usize, ui: &mut Ui) {
    ui.spacing_mut().item_spacing = vec2(GAP, GAP);
    egui::ScrollArea::vertical()
        .scroll_bar_visibility(egui::scroll_area::ScrollBarVisibility::AlwaysHidden)
        .show(ui, |ui| {
            for row in Tool::VARIANTS.chunks(columns) {
                ui.horizontal(|ui| row.iter().for_each(|&tool| button(editor, tool, ui)));
                // Shapes are separated in single-column layouts.
                if columns == 1 && matches!(row[0], Tool::Select | Tool::Text) {
                    ui.add_space(6.0);
                }
            }
        });
}

fn button(editor: &mut Editor, tool: Tool, ui: &mut Ui) {
    let (rect, response) = ui.allocate_exact_size(vec2(TOOL, TOOL), Sense::click());
    let chosen = editor.tool == tool;
    response
        .widget_info(|| egui::WidgetInfo::selected(egui::Role::RadioButton, true, chosen, tool.into_str()));
    if response.clicked() {
        editor.tool = tool;
    }
    let visuals = ui.style().interact_selectable(&response, chosen);
    let fill = if chosen { theme::ACCENT } else { visuals.bg_fill };
    if chosen || response.hovered() || response.has_focus() {
        ui.painter().rect_filled(rect, 6.0, fill);
    }
    if response.has_focus() {
        ui.painter().rect_stroke(rect, 6.0, theme::focus_ring(), egui::StrokeKind::Inside);
    }
    let ink = if chosen { Color32::WHITE } else { ui.visuals().text_color() };
    tool::icon(ui.painter(), tool, rect, Stroke::new(1.8, ink));
    response.on_hover_text(format!("{} ({})\n{}", tool.into_str(), tool.key().name(), tool.tooltip()));
}
