//! The Device page: connecting to a board, playing on it, testing it, and the state of its line.

use egui::{RichText, Ui};

use crate::device::health::{Health, State};
use crate::device::profile::Profile;
use crate::device::wiring::{Share, Wiring};
use crate::rounding;
use crate::scene::{UNCERTAINTY, motion};
use crate::studio::bring_up::tested;
use crate::studio::felt::Offer;
use crate::ui::board::{BoardCommand, BoardShown, Plays, Ports, absence, sentence};
use crate::ui::bring_up::Step;
use crate::ui::panels::form::{choice, count, heading};
use crate::ui::panels::{bring_up, caption, fact, felt, form, others};
use crate::ui::{command::Command, editor::Editor, shown::Shown, theme};

/// Bits per second that the most usual adapters have.
const BAUDS: [u32; 10] =
    [115_200, 230_400, 921_600, 1_000_000, 1_462_857, 2_000_000, 3_000_000, 4_000_000, 6_000_000, 8_000_000];

pub fn show(editor: &mut Editor, shown: &Shown, ui: &mut Ui, commands: &mut Vec<Command>) {
    let board = &shown.board;
    if let Some(why) = &board.unavailable {
        heading(ui, "Board");
        ui.label(why);
        others::show(shown, ui, commands);
        return;
    }
    let mut ask = |command| commands.push(Command::Board(command));
    connection(editor, board, ui, &mut ask);
    ui.separator();
    bring_up::show(editor, board, ui, &mut ask);
    if let Some(health) = board.health.as_ref().filter(|_| editor.board.bring_up.is_none()) {
        ui.separator();
        sending(editor, board, health, ui, &mut ask);
        ui.separator();
        trial(editor, board, health, ui, &mut ask);
        ui.separator();
        line(board, editor.board.profile, health, ui);
    }
    ui.separator();
    played(editor, board, ui);
    others::show(shown, ui, commands);
}

fn connection(editor: &mut Editor, board: &BoardShown, ui: &mut Ui, ask: &mut impl FnMut(BoardCommand)) {
    heading(ui, "Connection");
    let is_open = board.health.is_some();
    let is_testing = editor.board.bring_up.is_some();
    ui.add_enabled_ui(!is_open && !is_testing, |ui| {
        form(ui, "board", |ui| {
            let profiles: Vec<_> = Profile::choices().map(|profile| (profile, profile.title())).collect();
            choice(ui, ("Board", "Kind of board"), &mut editor.board.profile, &profiles);
            port(editor, board, ui, ask);
            rate(editor, ui);
            // A page has the files that it has written, and no others to name.
            if board.ports_from == Ports::Computer || !editor.board.calibration.is_empty() {
                calibration(editor, ui);
            }
        });
    });
    let profile = editor.board.profile;
    // A native board may round the phases that it is sent.
    let phases = match board.found.and_then(|found| found.phase_bits) {
        Some(bits) => format!("{} of {}", 1_u32 << u32::from(bits).min(31), profile.levels()),
        None => profile.levels().to_string(),
    };
    ui.label(
        RichText::new(format!(
            "{} elements, {phases} phases; line: up to {}",
            profile.elements(),
            profile.bandwidth(editor.board.baud().unwrap_or(profile.baud()))
        ))
        .weak(),
    );
    if let Some(remark) = profile.remark() {
        ui.label(RichText::new(format!("{}: {remark}", profile.title())).color(theme::warning(ui.visuals())));
    }
    let has_corrections =
        !editor.board.calibration.trim().is_empty() || editor.scene().array.placed.corrections().is_some();
    if let Some(warning) = profile.uncalibrated().filter(|_| !has_corrections) {
        ui.label(RichText::new(sentence(warning)).color(theme::warning(ui.visuals())));
    }
    ui.horizontal(|ui| {
        if is_open {
            if ui.button("Disconnect").on_hover_text("The board falls silent").clicked() {
                ask(BoardCommand::Disconnect);
            }
        } else if !is_testing {
            let named = !editor.board.port().is_empty();
            let button = ui.add_enabled(named, egui::Button::new("Connect"));
            let button = button
                .on_hover_text("Opens the port and silences the board")
                .on_disabled_hover_text(board.ports_from.first());
            if button.clicked() {
                ask(BoardCommand::Connect);
            }
            let tip = "Starts a virtual board of this kind and connects to it";
            if ui.button("Try without a board").on_hover_text(tip).clicked() {
                ask(BoardCommand::TryWithout);
            }
        }
        state(editor, board, ui);
    });
}

/// The bit rate: the board's own, or another of board and adapter.
fn rate(editor: &mut Editor, ui: &mut Ui) {
    let own = editor.board.profile.baud();
    // A test may have found the default, too.
    let before = editor.board.baud().filter(|baud| *baud != own);
    let odd = before.filter(|other| !BAUDS.contains(other));
    let others = BAUDS.into_iter().filter(|&other| other != own).chain(odd);
    let mut names = vec![(None, format!("{own} (default)"))];
    names.extend(others.map(|other| (Some(other), other.to_string())));
    let choices: Vec<_> = names.iter().map(|(value, name)| (*value, name.as_str())).collect();
    let mut baud = before;
    choice(ui, ("Bit rate", "Bits per second, of this kind of board and its adapter"), &mut baud, &choices);
    if baud != before {
        editor.board.set_baud(baud);
    }
}

fn calibration(editor: &mut Editor, ui: &mut Ui) {
    let tip = "CSV with the columns element, offset (degrees), gain (0 to 1), off (0 or 1), or an OpenMPD board's PAT; may \
               be empty";
    let label = caption(ui, "Calibration").on_hover_text(tip);
    ui.add(egui::TextEdit::singleline(&mut editor.board.calibration).hint_text("CSV or PAT file"))
        .labelled_by(label.id)
        .on_hover_text(tip);
    ui.end_row();
}

/// A menu of ports, and a field for others where they can be typed.
fn port(editor: &mut Editor, board: &BoardShown, ui: &mut Ui, ask: &mut impl FnMut(BoardCommand)) {
    let tip = "Serial port of the board";
    let label = caption(ui, "Port").on_hover_text(tip);
    if let Some(port) = &editor.board.virtual_port {
        ui.label("virtual board").on_hover_text(port);
        ui.end_row();
        return;
    }
    match board.ports_from {
        Ports::Computer => {
            ui.horizontal(|ui| {
                let field = egui::TextEdit::singleline(&mut editor.board.port).desired_width(128.0);
                ui.add(field.hint_text("/dev/ttyUSB0")).labelled_by(label.id).on_hover_text(tip);
                listed(editor, board, "Choose…", "Serial ports of this computer", ui, ask);
            });
        }
        Ports::Browser => {
            let chosen = editor.board.port.trim();
            if !board.ports.is_empty() {
                let name = if chosen.is_empty() { "Choose…" } else { chosen }.to_owned();
                ui.horizontal(|ui| {
                    listed(editor, board, &name, "Serial ports that this page may use", ui, ask);
                });
                ui.end_row();
                ui.label("");
            }
            let tip = "The browser asks which port this page may use";
            if ui.button("Allow a port…").on_hover_text(tip).clicked() {
                ask(BoardCommand::ChoosePort);
            }
        }
        Ports::Nowhere => {
            ui.weak("This browser has no serial ports for pages; Chrome and Edge on a computer have.");
        }
    }
    ui.end_row();
}

/// A menu of the available ports.
fn listed(
    editor: &mut Editor,
    board: &BoardShown,
    name: &str,
    tip: &str,
    ui: &mut Ui,
    ask: &mut impl FnMut(BoardCommand),
) {
    let menu = ui.menu_button(name, |ui| {
        if board.ports.is_empty() {
            ui.label("No serial ports found");
        }
        for port in &board.ports {
            if ui.button(&port.label).clicked() {
                editor.board.port.clone_from(&port.name);
                editor.board.profile = port.profile.unwrap_or(editor.board.profile);
                ui.close();
            }
        }
    });
    if menu.response.on_hover_text(tip).clicked() {
        ask(BoardCommand::ListPorts);
    }
}

fn state(editor: &Editor, board: &BoardShown, ui: &mut Ui) {
    let profile = editor.board.profile;
    match board.health.as_ref().map(|health| &health.state) {
        None => match &editor.board.bring_up {
            Some(run) if run.step == Step::Line && board.surveyed.is_none() => {
                ui.spinner();
                ui.label("testing the serial link");
            }
            Some(_) => {
                ui.weak("serial link tested");
            }
            None => {
                ui.weak("not connected");
            }
        },
        Some(State::Connecting) => {
            ui.spinner();
            ui.label("searching");
        }
        Some(State::Ready) if profile.answers() => {
            ui.label(RichText::new("connected").strong());
        }
        Some(State::Ready) if profile.echoes() => {
            let tip = "This board sends back commands, but does not report what it plays";
            ui.label(RichText::new("connected").strong()).on_hover_text(tip);
        }
        Some(State::Ready) => {
            let tip = "This board sends no answers, so its presence and state are unknown";
            ui.label(RichText::new("port open, unconfirmed").strong()).on_hover_text(tip);
        }
        // A board may be missing for hours: no spinner meanwhile.
        Some(State::Lost(_)) => {
            let was_found = board.health.as_ref().is_some_and(|health| health.found > 0);
            let text = match was_found {
                true => "lost, reconnecting".to_owned(),
                false => format!("Waiting for {}", editor.board.port()),
            };
            ui.label(RichText::new(text).color(theme::error(ui.visuals())));
        }
    }
}

fn sending(
    editor: &mut Editor,
    board: &BoardShown,
    health: &Health,
    ui: &mut Ui,
    ask: &mut impl FnMut(BoardCommand),
) {
    heading(ui, "Play");
    if let State::Lost(why) = &health.state {
        let text = absence(why, health.found > 0);
        ui.label(RichText::new(text).color(theme::error(ui.visuals())));
    }
    ui.horizontal(|ui| {
        let obstacle = obstacle(health);
        let tip = "The board plays the scene at rest from now on";
        if button(ui, "Send scene", tip, obstacle.as_deref()) {
            ask(BoardCommand::Send);
        }
        let rests = (!motion::moves(editor.scene())).then(|| "The scene is static".to_owned());
        let tip = "Repeats all frames; a native board stores them and plays on its own";
        if button(ui, "Play motion", tip, obstacle.or(rests).as_deref()) {
            ask(BoardCommand::PlayMotion);
        }
    });
    ui.checkbox(&mut editor.board.live, "Live")
        .on_hover_text("Every change goes to the board at once, also during a drag");
    let what = match board.plays {
        Plays::Nothing => "silent".to_owned(),
        Plays::Scene => "the scene".to_owned(),
        Plays::Motion => "the motion".to_owned(),
        Plays::One(element) => format!("element {element} alone"),
        Plays::Checkerboard => "a checkerboard".to_owned(),
        Plays::Focus => "a focus above the centre".to_owned(),
    };
    form(ui, "plays", |ui| {
        fact(ui, ("Playing", "As sent to the board"), what);
        if let Some(Ok(figures)) = editor.parts.feeling.newest() {
            let moves = motion::moves(editor.scene()) && board.plays != Plays::Scene;
            let name = if moves { "Felt in motion" } else { "Felt" };
            let tip = "Level of the scene over the threshold of feeling; see the Felt page";
            let level = felt::decibels(figures.felt.level);
            fact(ui, (name, tip), format!("{level}, ± {:.0} dB", UNCERTAINTY[0]));
        }
    });
    offer(editor, board, ui);
    ways(editor, obstacle(health).as_deref(), ui, ask);
    if let Some(carrier) = other_carrier(editor, board) {
        let frequency = editor.scene().array.frequency;
        ui.label(
            RichText::new(format!("The board's carrier is {carrier} Hz, the scene's {frequency} Hz."))
                .color(theme::warning(ui.visuals())),
        );
        if ui.button("Use the board's carrier").clicked() {
            ask(BoardCommand::TakeCarrier);
        }
    }
}

/// A modulation for a scene that is hardly felt, unless a liquid is in view.
fn offer(editor: &mut Editor, board: &BoardShown, ui: &mut Ui) {
    let profile = editor.board.profile;
    let baud = editor.board.baud().unwrap_or(profile.baud());
    let offer = Offer::new(editor.scene(), board.plays == Plays::Motion, profile, baud);
    let Some(offer) = offer.filter(|_| !editor.view.quantity.declaration().of_liquid) else { return };
    ui.label(RichText::new("Steady sound is hardly felt by a hand.").color(theme::warning(ui.visuals())));
    if let Some(limit) = offer.limit() {
        ui.label(RichText::new(sentence(&limit)).weak());
    }
    let tip = "Sets the modulation of the scene: a sine, down to silence";
    if ui.button(format!("Modulate at {} Hz", offer.frequency)).on_hover_text(tip).clicked() {
        editor.document.scene.modulation = offer.of(&editor.scene().modulation);
    }
}

/// The ways of playing the drawing, and the one that is felt most.
fn ways(editor: &mut Editor, obstacle: Option<&str>, ui: &mut Ui, ask: &mut impl FnMut(BoardCommand)) {
    let tip = "Tries modulations, small circles, running foci and drives in turn, and compares what a hand feels of each; may take a minute";
    ui.checkbox(&mut editor.parts.ways.form.is_shown, "Ways of playing").on_hover_text(tip);
    if !editor.parts.ways.form.is_shown {
        return;
    }
    let best = match editor.parts.ways.newest() {
        None => {
            ui.label("Being computed; for drawings that a hand feels.");
            return;
        }
        Some(Err(why)) => {
            ui.label(why);
            return;
        }
        Some(Ok(all)) => {
            form(ui, "ways", |ui| {
                for way in all {
                    fact(ui, (way.kind.into_str(), &way.keys()), felt::decibels(way.felt.level));
                }
            });
            all.first().map(|way| way.scene.clone())
        }
    };
    let Some(best) = best else { return };
    if button(ui, "Play what is felt most", "Sets motion and modulation of the scene, and plays it", obstacle)
    {
        let moves = motion::moves(&best);
        let scene = &mut editor.document.scene;
        (scene.modulation, scene.motion, scene.solver.frames) =
            (best.modulation, best.motion, best.solver.frames);
        scene.targets.iter_mut().for_each(|target| target.motion = None);
        ask(if moves { BoardCommand::PlayMotion } else { BoardCommand::Send });
    }
}

/// The reason for not being able to send.
fn obstacle(health: &Health) -> Option<String> {
    match &health.state {
        State::Ready => None,
        State::Connecting => Some("The board is not ready yet".to_owned()),
        State::Lost(why) => Some(absence(why, health.found > 0)),
    }
}

/// A button, or the reason for its absence. Returns whether it was clicked.
fn button(ui: &mut Ui, name: &str, tip: &str, obstacle: Option<&str>) -> bool {
    let button = ui.add_enabled(obstacle.is_none(), egui::Button::new(name)).on_hover_text(tip);
    button.on_disabled_hover_text(obstacle.unwrap_or_default()).clicked()
}

/// The board's carrier (Hz), if it differs from the scene's frequency.
fn other_carrier(editor: &Editor, board: &BoardShown) -> Option<f64> {
    let carrier = board.found?.carrier;
    crate::device::levels::carrier_notice(carrier, editor.scene().array.frequency).map(|_| carrier)
}

fn trial(
    editor: &mut Editor,
    board: &BoardShown,
    health: &Health,
    ui: &mut Ui,
    ask: &mut impl FnMut(BoardCommand),
) {
    heading(ui, "Element test");
    let (_, wiring) = tested(editor.board.profile, editor.scene());
    let last = wiring.elements().saturating_sub(1) as u32;
    form(ui, "trial", |ui| {
        let tip = "From 0, row by row, starting at smallest x and y";
        let before = editor.board.element;
        count(ui, ("Element", tip), &mut editor.board.element, 0..=last);
        if before != editor.board.element && matches!(board.plays, Plays::One(_)) {
            ask(BoardCommand::One);
        }
    });
    let obstacle = obstacle(health);
    ui.horizontal(|ui| {
        if button(ui, "Single element", "Only this element sounds, at full amplitude", obstacle.as_deref()) {
            ask(BoardCommand::One);
        }
        let tip = "Neighbours in antiphase: no far field";
        if button(ui, "Checkerboard", tip, obstacle.as_deref()) {
            ask(BoardCommand::Checkerboard);
        }
    });
}

fn line(board: &BoardShown, profile: Profile, health: &Health, ui: &mut Ui) {
    heading(ui, "Link");
    let milliseconds = |duration: std::time::Duration| rounding::milliseconds(duration.as_secs_f64(), 2);
    form(ui, "line", |ui| {
        let frames = format!("{}, {:.0} per second", health.frames, health.frames_per_second);
        let tip = if profile.answers() { "Confirmed by the board" } else { "Sent" };
        fact(ui, ("Frames", tip), frames);
        fact(ui, ("Data rate", "To the board"), format!("{:.1} kB/s", health.bytes_per_second / 1e3));
        if let Some(rates) = health.rates {
            let value = match rates.differ() {
                true => format!("{:.0} of {:.0} frames/s", rates.played, rates.asked),
                false => format!("{:.0} frames/s", rates.played),
            };
            fact(ui, ("Motion", "Frames per second as played, of those that the scene asks for"), value);
        }
        if let Some(latency) = health.latency {
            let tip = "From a change to the last byte of its frame on the line, median";
            fact(ui, ("Latency", tip), milliseconds(latency.median));
        }
        if let Some(round_trip) = health.round_trip {
            let value = format!("{} ± {}", milliseconds(round_trip.median), milliseconds(round_trip.jitter));
            fact(ui, ("Round trip", "From the last byte of a packet to its answer, median ± jitter"), value);
            let tip = "Packets corrupted on the line or refused";
            fact(ui, ("Retransmissions", tip), health.refused.to_string());
        }
        if let Some(swaps) = health.swaps {
            let hertz = 0.5 / swaps.mean.as_secs_f64();
            let value = format!("{hertz:.2} Hz ± {}", milliseconds(swaps.jitter));
            fact(ui, ("Modulated at", "By exchanging buffers from here, with jitter"), value);
        }
        if health.found > 1 {
            fact(ui, ("Reconnected", "After losses of the link"), format!("{} times", health.found - 1));
        }
    });
    for message in board.messages.iter().rev().take(4) {
        ui.label(RichText::new(message).weak());
    }
}

/// The drive as played by the board.
fn played(editor: &mut Editor, board: &BoardShown, ui: &mut Ui) {
    heading(ui, "On this board");
    let levels = u32::from(editor.board.profile.levels());
    let mut as_played = editor.levels == Some(levels);
    let tip = "Map and pressures with the board's phase steps";
    if ui.checkbox(&mut as_played, "Show what the board plays").on_hover_text(tip).changed() {
        editor.levels = as_played.then_some(levels);
    }
    let convention = editor.view.convention;
    match board.pressures {
        Some((ideal, played)) => form(ui, "played", |ui| {
            let tip = "Mean pressure over the foci, with the phases of the solution";
            fact(ui, ("Exact", tip), convention.pressure(ideal));
            let part = match ideal > 0.0 {
                true => format!("{} ({:.1} %)", convention.pressure(played), 100.0 * played / ideal),
                false => "no sound reaches the foci".to_owned(),
            };
            let tip = "With the board's phases and amplitudes, without its calibration";
            fact(ui, (&format!("With {levels} phase steps"), tip), part);
        }),
        None => {
            let wiring = Wiring::of(editor.board.profile, editor.scene(), Share::default());
            if let Err(error) = wiring {
                let text = sentence(&error.to_string());
                ui.label(RichText::new(text).color(theme::warning(ui.visuals())));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;
    use std::rc::Rc;

    use egui_kittest::Harness;
    use egui_kittest::kittest::{NodeT, Queryable};

    use super::*;
    use crate::scene::Scene;
    use crate::ui::board::PortShown;
    use crate::ui::document::Document;

    type Asked = Rc<RefCell<Vec<Command>>>;

    /// The panel with ports from this source and of these names, and its commands.
    fn panel(ports_from: Ports, names: &[&str]) -> (Harness<'static, Editor>, Asked) {
        let mut shown = Shown::default();
        shown.board.ports_from = ports_from;
        let port =
            |name: &&str| PortShown { name: (*name).to_owned(), label: (*name).to_owned(), profile: None };
        shown.board.ports = names.iter().map(port).collect();
        let asked = Asked::default();
        let theirs = Rc::clone(&asked);
        let mut has_fonts = false;
        let draw = move |ui: &mut Ui, editor: &mut Editor| match std::mem::replace(&mut has_fonts, true) {
            true => show(editor, &shown, ui, &mut theirs.borrow_mut()),
            // Available from the next frame on.
            false => theme::install(ui.ctx()),
        };
        let editor = Editor::new(Document::new(Scene::default(), "scene"));
        let mut panel = Harness::new_ui_state(draw, editor);
        panel.run_steps(4);
        (panel, asked)
    }

    #[test]
    fn a_page_has_the_ports_that_its_user_chooses_in_the_browser() {
        let (mut panel, asked) = panel(Ports::Browser, &["USB 0403:6010"]);
        assert!(
            panel.query_by_label("Calibration").is_none()
                && panel.get_by_label("Connect").accesskit_node().is_disabled()
        );
        panel.get_by_label("Allow a port…").click();
        panel.run_steps(2);
        assert_eq!(asked.take(), [Command::Board(BoardCommand::ChoosePort)]);
        panel.get_by_label("Choose…").click();
        panel.run_steps(2);
        panel.get_by_label("USB 0403:6010").click();
        panel.run_steps(2);
        assert_eq!(
            (asked.take(), panel.state().board.port.as_str()),
            (vec![Command::Board(BoardCommand::ListPorts)], "USB 0403:6010")
        );
        panel.get_by_label("Connect").click();
        panel.run_steps(2);
        assert_eq!(asked.take(), [Command::Board(BoardCommand::Connect)]);
        // The bring-up's files live as long as the page.
        panel.state_mut().board.calibration = "calibration.csv".to_owned();
        panel.run_steps(2);
        assert!(panel.query_by_label("Calibration").is_some());
    }

    #[test]
    fn where_a_browser_has_no_ports_a_virtual_board_is_left() {
        let (mut panel, asked) = panel(Ports::Nowhere, &[]);
        assert!(panel.query_by_label("Allow a port…").is_none() && panel.query_by_label("Choose…").is_none());
        assert!(panel.query_by_label_contains("This browser has no serial ports").is_some());
        panel.get_by_label("Try without a board").click();
        panel.run_steps(2);
        assert_eq!(asked.take(), [Command::Board(BoardCommand::TryWithout)]);
    }
}
