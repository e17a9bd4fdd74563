//! The Measure page: opening a scan, what was found, and its calibration for the board.

use std::path::Path;

use egui::{Button, Color32, Label, ProgressBar, RichText, Sense, Ui, vec2};

use crate::echo;
use crate::studio::measurement::Verdict;
use crate::ui::command::{Export, Purpose};
use crate::ui::dialog::state::Dialog;
use crate::ui::panels::form::{MM, bare_number, caption, form, heading, value};
use crate::ui::parts::measuring::{Finding, Measuring};
use crate::ui::{editor::Editor, shown::Shown, theme};

/// The first width of a microphone that is known, m: a quarter of an inch.
const FIRST_WIDTH: f64 = 6.35e-3;
/// Limit of the widths of a microphone, m.
const WIDEST: f64 = 0.02;
/// The command that makes a scan.
const PLAN: &str = "sonoglyph measure SCENE --plan -o FOLDER";

pub fn show(editor: &mut Editor, shown: &Shown, ui: &mut Ui) {
    heading(ui, "Measured field");
    if editor.parts.measuring.form.scan.is_none() {
        return blank(editor, ui);
    }
    files(editor, ui);
    let measuring = &editor.parts.measuring;
    if let Some(part) = measuring.part() {
        ui.add_space(6.0);
        ui.add(ProgressBar::new(part).text(format!("Fitting {:.0} %", 100.0 * part)));
    } else if let Some(Err(problem)) = measuring.exact() {
        ui.add_space(6.0);
        let text = RichText::new(echo::message(problem)).color(theme::error(ui.visuals()));
        ui.add(Label::new(text).wrap());
    }
    let Some(finding) = measuring.finding().cloned() else { return };
    if measuring.exact().is_none() {
        ui.weak("Below is the result before the change.");
    }
    found(&finding, ui);
    calibration(editor, &finding, ui);
    figure(editor, shown, &finding, ui);
}

/// The page without a scan.
fn blank(editor: &mut Editor, ui: &mut Ui) {
    ui.label(
        "Finds the gain and phase of every element from the readings of a microphone in front of the array.",
    );
    ui.add_space(4.0);
    if ui.add(theme::primary("Open scan…")).clicked() {
        editor.ask_for_file(Purpose::Scan);
    }
    ui.weak(
        "Or drop it on the window: CSV with x, y, z (m) and re and im, amplitude, rms (Pa) or level (dB).",
    );
    ui.add_space(6.0);
    ui.weak("The command line plans a scan:");
    let command = Label::new(RichText::new(PLAN).monospace()).wrap().selectable(true);
    ui.add(command).on_hover_text("Writes the drive to play and the places to read");
}

fn files(editor: &mut Editor, ui: &mut Ui) {
    let (mut asks_for, mut reads_again, mut resets) = (None, false, false);
    let form_of_scan = &mut editor.parts.measuring.form;
    form(ui, "scan", |ui| {
        caption(ui, "Scan");
        value(ui, |ui| named(form_of_scan.scan.as_deref(), "", ui));
        ui.end_row();
        caption(ui, "Drive").on_hover_text("What the board played during the scan");
        value(ui, |ui| {
            if ui.button("Choose…").on_hover_text("A CSV file of drives").clicked() {
                asks_for = Some(Purpose::ScanDrive);
            }
            let tip = "The file drive.csv beside the scan, or else the drive of the scene";
            resets = form_of_scan.drive.is_some() && ui.button("Default").on_hover_text(tip).clicked();
            named(form_of_scan.drive(), "the scene's", ui);
        });
        ui.end_row();
        let mut is_known = form_of_scan.width.is_some();
        let tip = "Diameter of the microphone's membrane. Off: fitted";
        if ui.checkbox(&mut is_known, "Microphone width").on_hover_text(tip).changed() {
            form_of_scan.width = is_known.then_some(FIRST_WIDTH);
        }
        value(ui, |ui| match &mut form_of_scan.width {
            Some(width) => {
                let field = bare_number(ui, width, MM, 0.0..=WIDEST);
                field.on_hover_text(tip).accessible_name("Width of the microphone");
            }
            None => {
                ui.add_space(ui.spacing().button_padding.x);
                ui.label("fitted");
            }
        });
        ui.end_row();
    });
    ui.horizontal(|ui| {
        if ui.button("Open scan…").clicked() {
            asks_for = Some(Purpose::Scan);
        }
        reads_again = ui.button("Read again").on_hover_text("If the files have changed").clicked();
    });
    if reads_again {
        editor.parts.measuring.read_again();
    }
    if resets {
        editor.parts.measuring.take_drive(None);
    }
    if let Some(purpose) = asks_for {
        editor.ask_for_file(purpose);
    }
}

/// The name of a file, with its path.
fn named(path: Option<&Path>, otherwise: &str, ui: &mut Ui) {
    let name = path.and_then(Path::file_name).map(|name| echo::value(&name.to_string_lossy()));
    let label = ui.add(Label::new(name.unwrap_or_else(|| otherwise.to_owned())).truncate());
    if let Some(path) = path {
        label.on_hover_text(path.display().to_string());
    }
}

/// The verdict, what was found, and warnings.
fn found(finding: &Finding, ui: &mut Ui) {
    ui.add_space(8.0);
    let is_identifiable = finding.measured.is_identifiable();
    let colour = match finding.measured.verdict() {
        Verdict::SomethingElse => theme::error(ui.visuals()),
        Verdict::Explained | Verdict::Plausible if is_identifiable => theme::good(ui.visuals()),
        Verdict::Explained | Verdict::Plausible => theme::warning(ui.visuals()),
    };
    ui.horizontal(|ui| {
        sign(colour, ui);
        ui.add(Label::new(RichText::new(&finding.verdict).strong()).wrap());
    });
    for warning in &finding.warnings {
        ui.add(Label::new(RichText::new(warning).color(theme::warning(ui.visuals()))).wrap());
    }
    ui.add_space(4.0);
    form(ui, "found", |ui| {
        for (name, value) in finding.facts.iter().filter(|(name, _)| !name.is_empty()) {
            caption(ui, name);
            ui.add(Label::new(value).wrap());
            ui.end_row();
        }
    });
    for (_, line) in finding.facts.iter().filter(|(name, _)| name.is_empty()) {
        ui.add(Label::new(line).wrap());
    }
    for note in &finding.notes {
        ui.add(Label::new(RichText::new(note).weak()).wrap());
    }
}

fn sign(colour: Color32, ui: &mut Ui) {
    const SIDE: f32 = 12.0;
    let (rect, _) = ui.allocate_exact_size(vec2(SIDE, SIDE), Sense::hover());
    ui.painter().circle_filled(rect.center(), SIDE * 0.4, colour);
}

/// The calibration and the report of a result.
fn calibration(editor: &mut Editor, finding: &Finding, ui: &mut Ui) {
    heading(ui, "Calibration");
    let tip = "Weakens louder elements to the level of the weaker ones; boards without amplitudes ignore it";
    ui.checkbox(&mut editor.parts.measuring.with_gains, "Gains, too (less pressure)").on_hover_text(tip);
    let measuring = &editor.parts.measuring;
    let is_exact = measuring.exact().is_some();
    let lacks = finding.measured.unidentifiable();
    let reason = match &lacks {
        Some(reason) => format!("The scan does not tell the elements apart: {reason}"),
        None => "The fit is being computed".to_owned(),
    };
    let mut asks_for = None;
    let mut uses = None;
    ui.horizontal_wrapped(|ui| {
        let has_calibration = is_exact && lacks.is_none();
        let press = |ui: &mut Ui, is_possible: bool, name: &str, tip: &str| {
            let button = ui.add_enabled(is_possible, Button::new(name));
            button.on_hover_text(tip).on_disabled_hover_text(&reason).clicked()
        };
        let tip = "Phases and gains that even the elements out, as CSV for boards";
        if press(ui, has_calibration, "Save calibration…", tip) {
            asks_for = Some((Export::Calibration { is_used: false }, "calibration.csv"));
        }
        let tip = "The Device page takes the calibration; it is saved first";
        if press(ui, has_calibration, "Use for this board", tip) {
            match measuring.saved() {
                Some(path) => uses = Some(path.display().to_string()),
                None => asks_for = Some((Export::Calibration { is_used: true }, "calibration.csv")),
            }
        }
        let tip = "Figure and findings as PDF, HTML, SVG or PNG, by the ending";
        if press(ui, is_exact && !finding.panels.is_empty(), "Save report…", tip) {
            asks_for = Some((Export::Report, "report.pdf"));
        }
    });
    if let Some(path) = used(editor, measuring) {
        ui.weak(format!("The Device page uses {path}, from the next connection on."));
    }
    if let (Some((export, name)), Some(scan)) = (asks_for, &measuring.form.scan) {
        let text = scan.with_file_name(name).display().to_string();
        editor.dialog = Some(Dialog::Path { purpose: Purpose::Export(export), text });
    }
    if let Some(path) = uses {
        editor.board.calibration = path;
    }
}

/// The file of this result's calibration, if the board has it.
fn used(editor: &Editor, measuring: &Measuring) -> Option<String> {
    let path = measuring.saved()?;
    let name = path.file_name()?.to_string_lossy();
    (editor.board.calibration().as_deref() == Some(path)).then(|| echo::value(&name))
}

/// Measured, model and difference; a click enlarges them.
fn figure(editor: &mut Editor, shown: &Shown, finding: &Finding, ui: &mut Ui) {
    if finding.panels.is_empty() {
        return;
    }
    heading(ui, "Measured, model and difference");
    match &shown.measured {
        None => {
            ui.spinner();
        }
        Some(Err(problem)) => {
            ui.add(Label::new(RichText::new(problem).color(theme::error(ui.visuals()))).wrap());
        }
        Some(Ok(preview)) => {
            let mut is_enlarged = ui.button("Enlarge").clicked();
            let picture = preview.texture.size_vec2();
            let size = picture * (ui.available_width() / picture.x.max(1.0));
            let image = egui::Image::new((preview.texture.id(), size)).fit_to_exact_size(size);
            let image = image.sense(Sense::click()).alt_text("Figure of the measured field");
            is_enlarged |= ui.add(image).on_hover_text("Click to enlarge").clicked();
            if is_enlarged {
                editor.dialog = Some(Dialog::Measured);
            }
        }
    }
}
