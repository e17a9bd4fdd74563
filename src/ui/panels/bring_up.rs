//! The bring-up panel: line, elements, a focus, the emergency stop, and a report.

use egui::{RichText, Ui};

use crate::device::health::{Health, State};
use crate::device::profile::Profile;
use crate::studio::bring_up::{Finding, Verdict, named, tested};
use crate::ui::board::{BoardCommand, BoardShown, Plays};
use crate::ui::bring_up::{BringUp, Step};
use crate::ui::panels::form::heading;
use crate::ui::{editor::Editor, theme};

/// The steps, or a button that starts them.
pub fn show(editor: &mut Editor, board: &BoardShown, ui: &mut Ui, ask: &mut impl FnMut(BoardCommand)) {
    let Some(mut run) = editor.board.bring_up.take() else { return begin(editor, board, ui, ask) };
    heading(ui, &format!("Bring-up, step {}", run.step.title()));
    let profile = editor.board.profile;
    let was = run.step;
    match run.step {
        Step::Line => line(editor, &mut run, board, ui, ask),
        Step::Elements => elements(editor, &mut run, board, ui, ask),
        Step::Focus => focus(&mut run, profile, ui, ask),
        Step::EmergencyStop => emergency_stop(&mut run, board, ui, ask),
        Step::Done => done(editor, &mut run, ui, ask),
    }
    if was != run.step {
        enter(run.step, ask);
    }
    let ends = ui.button("End").on_hover_text("Ends the bring-up; the board falls silent").clicked();
    if ends {
        ask(BoardCommand::Stop);
    }
    // Below the buttons, which keep their position while it grows.
    findings(ui, &run.report.findings);
    if let (Step::Line, Some(surveyed)) = (run.step, &board.surveyed) {
        findings(ui, &surveyed.findings);
    }
    // Commands run after the panel is drawn, and need it here.
    editor.board.bring_up = (!ends).then_some(run);
}

fn begin(editor: &mut Editor, board: &BoardShown, ui: &mut Ui, ask: &mut impl FnMut(BoardCommand)) {
    let named = !editor.board.port().is_empty();
    let button = ui.add_enabled(named, egui::Button::new("Bring up a board"));
    let tip = "Tests the line, every element, a focus and the emergency stop, step by step";
    if button.on_hover_text(tip).on_disabled_hover_text(board.ports_from.first()).clicked() {
        editor.board.bring_up = Some(Box::default());
        ask(BoardCommand::Survey);
    }
}

/// The sound at the beginning of a step.
fn enter(step: Step, ask: &mut impl FnMut(BoardCommand)) {
    match step {
        Step::Line => {}
        Step::Elements => ask(BoardCommand::One),
        Step::Focus => ask(BoardCommand::Focus),
        Step::EmergencyStop => ask(BoardCommand::One),
        Step::Done => ask(BoardCommand::Stop),
    }
}

fn findings(ui: &mut Ui, findings: &[Finding]) {
    for finding in findings {
        let colour = match finding.verdict {
            Verdict::Passed => ui.visuals().text_color(),
            Verdict::Failed => theme::error(ui.visuals()),
            Verdict::Noted | Verdict::Unverified => ui.visuals().weak_text_color(),
        };
        ui.add(egui::Label::new(RichText::new(finding.to_string()).color(colour).small()).wrap());
    }
}

fn line(
    editor: &mut Editor,
    run: &mut BringUp,
    board: &BoardShown,
    ui: &mut Ui,
    ask: &mut impl FnMut(BoardCommand),
) {
    let Some(surveyed) = &board.surveyed else {
        ui.horizontal(|ui| {
            ui.spinner();
            ui.label("testing the line and its bit rates");
        });
        return;
    };
    let failed = surveyed.findings.iter().any(|finding| finding.verdict == Verdict::Failed);
    ui.horizontal(|ui| {
        if ui.button("Try again").clicked() {
            ask(BoardCommand::Survey);
        }
        let next = ui.add_enabled(!failed, egui::Button::new("Next: the elements"));
        if next.on_disabled_hover_text("The line has to carry frames first").clicked() {
            run.report.findings.clone_from(&surveyed.findings);
            editor.board.baud = surveyed.baud.unwrap_or(editor.board.baud);
            run.element = tested(editor.board.profile, editor.scene()).1.wired().next().unwrap_or(0);
            editor.board.element = run.element as u32;
            run.step = Step::Elements;
            ask(BoardCommand::Connect);
        }
    });
}

fn elements(
    editor: &mut Editor,
    run: &mut BringUp,
    board: &BoardShown,
    ui: &mut Ui,
    ask: &mut impl FnMut(BoardCommand),
) {
    if !is_ready(board.health.as_ref()) {
        ui.label("Waiting for the board.");
        return;
    }
    let (scene, wiring) = tested(editor.board.profile, editor.scene());
    let name = named(&scene, run.element);
    ui.label(format!("Of {} elements, {name} sounds alone.", wiring.wired().count()));
    let before = run.element;
    ui.horizontal_wrapped(|ui| {
        if ui.button("Heard").clicked() {
            run.heard(&wiring, Some(true));
        }
        if ui.button("Silent").on_hover_text("It is left out by the calibration").clicked() {
            run.heard(&wiring, Some(false));
        }
        let back = wiring.wired().rev().find(|&n| n < run.element);
        if ui.add_enabled(back.is_some(), egui::Button::new("Back")).clicked() {
            run.element = back.unwrap_or(run.element);
        }
        if ui.button("Skip the rest").clicked() {
            run.heard(&wiring, None);
        }
    });
    let element = run.element as u32;
    if run.step == Step::Elements && (before != run.element || board.plays != Plays::One(element)) {
        editor.board.element = element;
        ask(BoardCommand::One);
    }
}

fn focus(run: &mut BringUp, profile: Profile, ui: &mut Ui, ask: &mut impl FnMut(BoardCommand)) {
    ui.label("A focus 100 mm above the centre, modulated at 200 Hz. Hold a hand there.");
    ui.horizontal(|ui| {
        let felt = ui.button("Felt").clicked();
        let unfelt = ui.button("Not felt").clicked();
        if ui.button("Once more").clicked() {
            ask(BoardCommand::Focus);
        }
        if felt {
            run.report.note(Verdict::Passed, "a focus was felt 100 mm above the centre");
        }
        if unfelt {
            run.report.note(Verdict::Failed, "no focus was felt 100 mm above the centre");
        }
        if felt || unfelt {
            run.step = if profile.answers() { Step::EmergencyStop } else { Step::Done };
        }
    });
}

fn emergency_stop(run: &mut BringUp, board: &BoardShown, ui: &mut Ui, ask: &mut impl FnMut(BoardCommand)) {
    let health = board.health.as_ref();
    run.pressed |= health.is_some_and(|health| health.stopped);
    let sounds = health.is_some_and(|health| health.in_place && !health.stopped);
    if run.pressed && sounds {
        run.report
            .note(Verdict::Passed, "emergency stop: silent until the next send, and sounds again after it");
        run.step = Step::Done;
        return;
    }
    ui.label(match run.pressed {
        true => "The board noticed, and is silent. Release the emergency stop and play again.",
        false => "One element sounds. Press the emergency stop now.",
    });
    ui.horizontal(|ui| {
        if ui.add_enabled(run.pressed, egui::Button::new("Play again")).clicked() {
            ask(BoardCommand::One);
        }
        if ui.button("Leave it out").clicked() {
            run.report.note(Verdict::Noted, "emergency stop: not tried");
            run.step = Step::Done;
        }
    });
}

fn done(editor: &mut Editor, run: &mut BringUp, ui: &mut Ui, ask: &mut impl FnMut(BoardCommand)) {
    ui.label(run.report.conclusion());
    if ui.button("Copy the report").on_hover_text("As a text, to send to others").clicked() {
        ui.ctx().copy_text(run.report.text(editor.board.profile, editor.board.port()));
    }
    let off = run.calibration.off().len();
    if off == 0 {
        return;
    }
    ui.horizontal(|ui| {
        let label = ui.label("Calibration");
        ui.add(egui::TextEdit::singleline(&mut run.file).desired_width(150.0)).labelled_by(label.id);
        let tip = "Leaves the silent elements out from the next connection on";
        if ui.button("Save").on_hover_text(tip).clicked() {
            let (_, wiring) = tested(editor.board.profile, editor.scene());
            let text = run.calibration.to_csv(wiring.elements());
            ask(BoardCommand::SaveCalibration(text));
        }
    });
}

fn is_ready(health: Option<&Health>) -> bool {
    health.is_some_and(|health| health.state == State::Ready)
}
