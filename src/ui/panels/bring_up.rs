//! The board test: serial link, every element, a focus, the emergency stop, and a report. Each step says what to look
//! at and with what.

use egui::{RichText, Ui};

use crate::device::health::{Health, State};
use crate::device::profile::Profile;
use crate::device::wiring::{Share, Wiring};
use crate::scene::Scene;
use crate::studio::bring_up::{Finding, Verdict, named, tested};
use crate::ui::board::{BoardCommand, BoardShown, Plays, sentence};
use crate::ui::bring_up::{self, BringUp, Step};
use crate::ui::panels::form::heading;
use crate::ui::{editor::Editor, theme};

const LOOK: &str = "Hold a spare 40 kHz transducer, connected to an oscilloscope, over the element, at some millimetres: a sine of \
                    40 kHz, strongest right above the element, is the signal.";

/// Aids besides an oscilloscope, and what does not work.
const WITHOUT: [&str; 4] = [
    "A sound card that records at 96 or 192 kHz shows 40 kHz as a line in a spectrum program, with the spare transducer at its \
     line input.",
    "At 44.1 or 48 kHz no microphone or sound card shows 40 kHz: it lies above half the sampling rate and is filtered out.",
    "With “For microphones” the element is modulated at 500 Hz. Some microphones, also of laptops and telephones, turn this into \
     a tone of 500 Hz when held at 1 to 2 cm: a tone shows that the element works, silence shows nothing.",
    "Ears and hands notice no single element. Driving at 20 kHz does not help: the boards' carrier is 40 kHz, and the transducers \
     hardly radiate elsewhere.",
];

/// The steps, or a button that starts them.
pub fn show(editor: &mut Editor, board: &BoardShown, ui: &mut Ui, ask: &mut impl FnMut(BoardCommand)) {
    let Some(mut run) = editor.board.bring_up.take() else { return begin(editor, board, ui, ask) };
    heading(ui, &format!("Board test, {}", run.step.title()));
    let profile = editor.board.profile;
    let was = run.step;
    match run.step {
        Step::Line => line(editor, &mut run, board, ui, ask),
        Step::Elements => elements(editor, &mut run, board, ui, ask),
        Step::Focus => focus(&mut run, profile, board, ui, ask),
        Step::EmergencyStop => emergency_stop(&mut run, board, ui, ask),
        Step::Done => done(editor, &mut run, ui, ask),
    }
    if was != run.step {
        enter(run.step, ask);
    }
    let end = end(&mut run, ui);
    // Below the buttons, which keep their position while it grows.
    findings(ui, &run.report.findings);
    if let (Step::Line, Some(surveyed)) = (run.step, &board.surveyed) {
        findings(ui, &surveyed.findings);
    }
    // Commands run after the panel is drawn, and need it here.
    editor.board.bring_up = Some(run);
    match end {
        None => return,
        Some(End::Keep) => editor.board.leave_test(),
        Some(End::Discard) => editor.board.bring_up = None,
    }
    ask(BoardCommand::EndTest);
}

/// The end of a test before its last step, or after it.
enum End {
    Keep,
    Discard,
}

/// The buttons that end the test; discarding results is confirmed.
fn end(run: &mut BringUp, ui: &mut Ui) -> Option<End> {
    if run.is_asked {
        ui.label("Discard the results of this test?");
    }
    ui.horizontal(|ui| {
        if run.is_asked {
            let discards = ui.add(theme::destructive("Discard results")).clicked();
            run.is_asked = !ui.button("Keep testing").clicked();
            return discards.then_some(End::Discard);
        }
        if run.step == Step::Done {
            let tip = "Closes the report, which is kept; the board is silent";
            return ui.button("Close").on_hover_text(tip).clicked().then_some(End::Keep);
        }
        let tip = "The board falls silent; the results are kept for later";
        let pauses = run.has_results() && ui.button("Pause test").on_hover_text(tip).clicked();
        if ui.button("Cancel test").on_hover_text("The board falls silent").clicked() {
            run.is_asked = run.has_results();
            return (!run.is_asked).then_some(End::Discard);
        }
        pauses.then_some(End::Keep)
    })
    .inner
}

fn begin(editor: &mut Editor, board: &BoardShown, ui: &mut Ui, ask: &mut impl FnMut(BoardCommand)) {
    let named = !editor.board.port().is_empty();
    let kept = editor.board.kept_test().map(|kept| {
        let run = &kept.run;
        let (marked, silent) = (run.signals.iter().flatten().count(), run.silent().len());
        let text = match run.step {
            Step::Done => format!("Last test of this board: {}", run.report.conclusion()),
            Step::Line | Step::Elements | Step::Focus | Step::EmergencyStop => {
                format!(
                    "Unfinished test of this board: {} tested, {silent} without signal.",
                    elements_of(marked)
                )
            }
        };
        (run.step, text)
    });
    let (name, tip) = match &kept {
        Some((Step::Done, text)) => {
            ui.label(text);
            ("Show report", "The findings, and the calibration without silent elements")
        }
        Some((_, text)) => {
            ui.label(text);
            ("Continue test", "From the step where it was left")
        }
        None => (
            "Test a board…",
            "Tests the serial link, every element, a focus and the emergency stop, step by step",
        ),
    };
    ui.horizontal(|ui| {
        let first = ui.add_enabled(named, egui::Button::new(name)).on_hover_text(tip);
        if first.on_disabled_hover_text(board.ports_from.first()).clicked() {
            let run = editor.board.take_test().map(|kept| kept.run).unwrap_or_default();
            start(run, editor, board, ask);
        }
        let tip = "From the beginning; the last results are kept until there are new ones";
        if kept.is_some() && ui.button("Test again").on_hover_text(tip).clicked() {
            start(BringUp::default(), editor, board, ask);
        }
    });
}

/// "1 element", "16 elements"
fn elements_of(count: usize) -> String {
    if count == 1 { "1 element".to_owned() } else { format!("{count} elements") }
}

/// Starts a test, or continues one.
fn start(run: BringUp, editor: &mut Editor, board: &BoardShown, ask: &mut impl FnMut(BoardCommand)) {
    let step = run.step;
    editor.board.element = run.element as u32;
    editor.board.bring_up = Some(Box::new(run));
    match step {
        Step::Line => ask(BoardCommand::Survey),
        Step::Done => {}
        Step::Elements | Step::Focus | Step::EmergencyStop => {
            if board.health.is_none() {
                ask(BoardCommand::Connect);
            }
            enter(step, ask);
        }
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
        let finding = Finding { verdict: finding.verdict, what: sentence(&finding.what) };
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
        ui.label("The board is asked for its identity, and bit rates are tried. Nothing sounds; keep the transducers' supply off.");
        return;
    };
    let failed = surveyed.findings.iter().any(|finding| finding.verdict == Verdict::Failed);
    let next = match (failed, editor.board.profile.answers()) {
        (true, _) => "Look at cable, adapter, ground, port and kind of board, then try again.",
        (false, true) => {
            "Next, each element plays alone: switch on the transducers' supply, at a low voltage."
        }
        (false, false) => {
            "This kind of board cannot be verified over its line. Next, each element plays alone: switch on the transducers' supply, \
             at a low voltage."
        }
    };
    ui.label(next);
    ui.horizontal(|ui| {
        if ui.button("Try again").clicked() {
            ask(BoardCommand::Survey);
        }
        let next = ui.add_enabled(!failed, egui::Button::new("Next: elements"));
        if next.on_disabled_hover_text("The line has to carry frames first").clicked() {
            run.report.findings.clone_from(&surveyed.findings);
            run.baud = surveyed.baud;
            run.element = tested(editor.board.profile, editor.scene()).1.wired().next().unwrap_or(0);
            editor.board.element = run.element as u32;
            run.step = Step::Elements;
            ask(BoardCommand::Connect);
        }
    });
}

/// Whether the board is silent although a step plays: after Stop, or its emergency stop.
fn is_silent(board: &BoardShown) -> bool {
    board.plays == Plays::Nothing || board.health.as_ref().is_some_and(|health| health.stopped)
}

/// A button that answers what the board does: only while it sounds.
fn answer(ui: &mut Ui, sounds: bool, button: egui::Button<'_>) -> egui::Response {
    ui.add_enabled(sounds, button).on_disabled_hover_text("The board is silent: play again first")
}

/// The way on from a silent board, with a word about it.
fn silence(board: &BoardShown, again: BoardCommand, ui: &mut Ui, ask: &mut impl FnMut(BoardCommand)) {
    let is_silent = is_silent(board);
    ui.horizontal(|ui| {
        if ui.add_enabled(is_silent, egui::Button::new("Play again")).clicked() {
            ask(again);
        }
        if is_silent {
            let text = "The board is silent: play again.";
            ui.label(RichText::new(text).color(theme::warning(ui.visuals())));
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
    let wired: Vec<_> = wiring.wired().collect();
    let (marked, before) = (run.signals.iter().flatten().count(), run.element);
    let sounds = !is_silent(board);
    let state = if sounds { "Plays alone" } else { "Silent, to be tested" };
    ui.label(format!("{state}: {}", named(&scene, run.element)));
    ui.label(LOOK);
    egui::CollapsingHeader::new("Without an oscilloscope").show(ui, |ui| {
        WITHOUT.iter().for_each(|text| drop(ui.label(*text)));
        let tip = "Modulates the element at 500 Hz; an oscilloscope then shows bursts";
        ui.checkbox(&mut run.modulates, "For microphones").on_hover_text(tip);
    });
    ui.horizontal_wrapped(|ui| {
        if answer(ui, sounds, theme::primary("Signal seen")).clicked() {
            run.mark([run.element], &wiring, true);
        }
        let without = answer(ui, sounds, egui::Button::new("No signal"));
        if without.on_hover_text("The calibration will switch it off").clicked() {
            run.mark([run.element], &wiring, false);
        }
        let back = wired.iter().copied().rfind(|&n| n < run.element).filter(|_| sounds);
        if ui.add_enabled(back.is_some(), egui::Button::new("Back")).clicked() {
            run.element = back.unwrap_or(run.element);
        }
    });
    silence(board, BoardCommand::One, ui, ask);
    ui.label(format!("{marked} of {} tested, {} without signal", wired.len(), run.silent().len()));
    several(&scene, run, &wiring, sounds, ui);
    ui.horizontal_wrapped(|ui| {
        let columns = scene.array.columns as usize;
        let row = run.element / columns.max(1);
        let is_grid = scene.array.file.is_none();
        let tip = "Marks the rest of the row of this element: those that are not marked yet";
        let rest = "Rest of row seen";
        if is_grid && answer(ui, sounds, egui::Button::new(rest)).on_hover_text(tip).clicked() {
            let open = |n: &usize| run.signals.get(*n).copied().flatten().is_none();
            let row: Vec<_> = (row * columns..(row + 1) * columns).filter(open).collect();
            run.mark(row, &wiring, true);
        }
        if ui.button("Skip the rest").on_hover_text("To the next step").clicked() {
            run.end_elements(&wiring);
        }
    });
    if run.step == Step::Elements && before != run.element {
        editor.board.element = run.element as u32;
        ask(BoardCommand::One);
    }
}

/// Marks for several elements, typed.
fn several(scene: &Scene, run: &mut BringUp, wiring: &Wiring, sounds: bool, ui: &mut Ui) {
    let last = scene.elements().saturating_sub(1);
    let mut marked = None;
    ui.horizontal(|ui| {
        let label = ui.label("Elements");
        let field =
            egui::TextEdit::singleline(&mut run.range).desired_width(76.0).hint_text(format!("0-{last}"));
        let tip = "Numbers and ranges to mark together, such as 0-15, 32";
        ui.add(field).labelled_by(label.id).on_hover_text(tip);
        if answer(ui, sounds, egui::Button::new("All seen")).clicked() {
            marked = Some(true);
        }
        if answer(ui, sounds, egui::Button::new("None seen")).clicked() {
            marked = Some(false);
        }
    });
    let named = bring_up::elements(&run.range, wiring);
    match (marked, named) {
        (Some(signal), Ok(elements)) => {
            run.mark(elements, wiring, signal);
            run.range.clear();
        }
        (_, Err(why)) if marked.is_some() || !run.range.trim().is_empty() => {
            ui.label(RichText::new(why).color(theme::warning(ui.visuals())));
        }
        (_, Ok(_) | Err(_)) => {}
    }
}

fn focus(
    run: &mut BringUp,
    profile: Profile,
    board: &BoardShown,
    ui: &mut Ui,
    ask: &mut impl FnMut(BoardCommand),
) {
    ui.label(
        "All elements make a focus 100 mm above the centre, modulated at 200 Hz. Hold a hand there: it buzzes. The whole array is \
         also heard as a quiet hum.",
    );
    ui.horizontal_wrapped(|ui| {
        let sounds = !is_silent(board);
        let felt = answer(ui, sounds, egui::Button::new("Felt")).clicked();
        let unfelt = answer(ui, sounds, egui::Button::new("Not felt")).clicked();
        if ui.button("Back to elements").clicked() {
            run.step = Step::Elements;
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
    silence(board, BoardCommand::Focus, ui, ask);
}

fn emergency_stop(run: &mut BringUp, board: &BoardShown, ui: &mut Ui, ask: &mut impl FnMut(BoardCommand)) {
    let health = board.health.as_ref();
    run.pressed |= health.is_some_and(|health| health.stopped);
    let sounds = health.is_some_and(|health| health.in_place && !health.stopped);
    if run.pressed && sounds && board.plays != Plays::Nothing {
        run.report
            .note(Verdict::Passed, "emergency stop: silent until the next send, and sounds again after it");
        run.step = Step::Done;
        return;
    }
    let is_stopped = health.is_some_and(|health| health.stopped);
    ui.label(match (is_stopped, is_silent(board)) {
        (true, _) => "The board noticed its emergency stop. Release it, then play again.",
        (false, true) => "The board was stopped here, not by its emergency stop. Play again, then press the emergency stop.",
        (false, false) => {
            "One element plays. Press the board's emergency stop now: the signal on the oscilloscope disappears, and the board \
             reports it."
        }
    });
    silence(board, BoardCommand::One, ui, ask);
    ui.horizontal(|ui| {
        if ui.button("Skip").on_hover_text("For boards without an emergency stop").clicked() {
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
    if run.calibration.off().is_empty() {
        return;
    }
    let (_, wiring) = tested(editor.board.profile, editor.scene());
    ui.horizontal(|ui| {
        let label = ui.label("Calibration");
        ui.add(egui::TextEdit::singleline(&mut run.file).desired_width(150.0)).labelled_by(label.id);
        let tip = "Leaves the elements without a signal out from the next connection on";
        if ui.button("Save").on_hover_text(tip).clicked() {
            let text = run.calibration.to_csv(wiring.elements());
            ask(BoardCommand::SaveCalibration(text));
        }
    });
    let is_scene = Wiring::of(editor.board.profile, editor.scene(), Share::default()).is_ok();
    let off = &editor.scene().array.off;
    let silent: Vec<_> = run.silent().into_iter().filter(|n| !off.contains(n)).collect();
    let tip = "Adds the elements without a signal to the scene's array.off: the solver does without them";
    if is_scene && !silent.is_empty() && ui.button("Switch off in the scene").on_hover_text(tip).clicked() {
        let off = &mut editor.document.scene.array.off;
        off.extend(silent);
        off.sort_unstable();
    }
}

fn is_ready(health: Option<&Health>) -> bool {
    health.is_some_and(|health| health.state == State::Ready)
}
