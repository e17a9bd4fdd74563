//! The Solver page: the method, its settings and its figures.

use std::path::Path;

use egui::Ui;

use crate::echo;
use crate::rounding::{millimetres, milliseconds, percent_at_least};
use crate::scene::{Aim, Amplitudes, DriveFile, Method, Pressures, Turns, motion};
use crate::solver::{Figures, Quality, Solution};
use crate::studio::spread;
use crate::ui::panels::form::{choice, count, heading, variants};
use crate::ui::panels::{PLAIN, fact, form, number, profile};
use crate::ui::{command::Command, editor::Editor, shown::Shown, theme};

/// Width of a method in the table, in points.
const METHOD: f32 = 116.0;

pub fn show(editor: &mut Editor, shown: &Shown, ui: &mut Ui, commands: &mut Vec<Command>) {
    match editor.scene().drive.is_named() {
        true => drive(editor, ui),
        false => settings(editor, ui),
    }
    if let Some(solution) = &shown.solution {
        quality(editor, shown, solution, ui);
    }
    comparison(editor, shown, ui, commands);
    if let Some(sound) = &shown.sound {
        profile::show(sound, ui);
    }
}

/// Description of a method.
fn describe(method: Method) -> &'static str {
    match method {
        Method::Focus => "Phases from the times of flight to one focal point",
        Method::Pinv => "Pseudo-inverse: prescribes the pressure at every point, with its phase",
        Method::Weighted => "The paper's weighted pseudo-inverse: evens out the elements' amplitudes",
        Method::Naive => "Sum of the phase-conjugated fields of all points",
        Method::Gs => "Gerchberg-Saxton iteration between array and points",
        Method::Gspat => "GS-PAT: Gerchberg-Saxton on the points alone",
        Method::Wgs => "Weighted Gerchberg-Saxton: weights level the points",
        Method::Greedy => "Coordinate descent: the best phase of one element after the other",
        Method::Best => "Levelled Gauss-Newton from several starts",
    }
}

/// The file of the drive, and the way back to the solver.
fn drive(editor: &mut Editor, ui: &mut Ui) {
    let file = &editor.scene().drive;
    let name = Path::new(&file.name).file_name().unwrap_or_default().to_string_lossy();
    heading(ui, "Drive of a file");
    form(ui, "drive", |ui| {
        let place = file.from.as_ref().map_or_else(String::new, |place| place.display().to_string());
        fact(
            ui,
            ("From file", &format!("{place}: its drives are played, and nothing is solved")),
            echo::value(&name).to_string(),
        );
        let Some(table) = file.table() else { return };
        let count = match (table.drives.len(), motion::cycle(editor.scene())) {
            (count, Some(cycle)) => format!("{count}, {:.1} per second", cycle.frames_per_second()),
            (1, None) => "1".to_owned(),
            (count, None) => format!("{count}, in turn"),
        };
        fact(ui, ("Drives", "Of the file"), count);
    });
    if ui
        .button("Solve instead")
        .on_hover_text("Lets the solver find the drive of the targets again")
        .clicked()
    {
        editor.document.scene.drive = DriveFile::default();
    }
}

fn settings(editor: &mut Editor, ui: &mut Ui) {
    let solver = &mut editor.document.scene.solver;
    heading(ui, "Method");
    // Its names are too long for the column of the others.
    ui.horizontal(|ui| {
        let names = variants(Method::title);
        choice(ui, ("Method", describe(solver.method)), &mut solver.method, &names);
    });
    form(ui, "solver", |ui| {
        let tip = "0: the default of the method";
        count(ui, ("Iterations", tip), &mut solver.iterations, 0..=10_000);
        let amplitudes = [(Amplitudes::Uniform, "uniform"), (Amplitudes::Free, "per element")];
        choice(ui, ("Amplitudes", "Uniform on most boards"), &mut solver.amplitudes, &amplitudes);
        let tip = "0: the strongest drive, 1: the lowest side lobes";
        number(ui, ("Side-lobe suppression", tip), &mut solver.quiet, PLAIN, 0.0..=1.0);
        let tip = "Several drives, played one after the other, whose mean intensity has the drawn shape: their side lobes average out";
        turns(ui, ("Alternating drives", tip), &mut solver.frames);
        let pressures = [(Pressures::Relative, "relative"), (Pressures::Pascal, "pascals")];
        choice(
            ui,
            ("Target pressures", "Relative to each other, or absolute in pascals (peak)"),
            &mut solver.pressures,
            &pressures,
        );
        let aims =
            [(Aim::Pressure, "pressure"), (Aim::Depression, "surface depression"), (Aim::Felt, "felt level")];
        let tip = "The field that gets the drawn shape";
        choice(ui, ("Target", tip), &mut solver.target, &aims);
    });
    ui.label(egui::RichText::new(describe(solver.method)).weak());
}

fn quality(editor: &Editor, shown: &Shown, solution: &Solution, ui: &mut Ui) {
    let convention = editor.view.convention;
    let quality = &solution.quality;
    heading(ui, "Quality");
    if solution.foci.is_empty() {
        ui.label("No targets: the quality of the drive is not defined");
        return;
    }
    if quality.is_silent() {
        ui.label("No sound reaches the foci");
        return;
    }
    form(ui, "quality", |ui| {
        fact(ui, ("Mean pressure", "Over the focal points"), convention.pressure(quality.mean_pressure));
        fact(
            ui,
            ("Weakest", "Pressure at the weakest focal point"),
            convention.pressure(quality.min_pressure),
        );
        fact(
            ui,
            ("Uniformity (std/mean)", "Standard deviation over mean of the focal pressures"),
            format!("{:.1} %", 100.0 * quality.spread),
        );
        if solution.foci.iter().any(|focus| !focus.is_separate()) {
            shape(solution.figures.as_ref(), ui);
        } else {
            foci(quality, ui);
        }
        let certified = match editor.parts.bound.exact() {
            Some(&bound) => format!("at least {}", percent_at_least(solution.certified(bound), 0)),
            None => "…".to_owned(),
        };
        fact(ui, ("Fraction of the upper bound", "Guaranteed; no drive exceeds the bound"), certified);
        nonlinear(editor, ui);
    });
    ranges(editor, ui);
    for warning in &shown.warnings {
        ui.label(egui::RichText::new(warning).color(theme::warning(ui.visuals())));
    }
}

/// Where linear theory ends.
fn nonlinear(editor: &Editor, ui: &mut Ui) {
    let tip = "Amplitude at twice the frequency over that of the sound, at the loudest focus, and the drive below which it is a \
               tenth: up to there linear theory is right";
    let found = match editor.parts.harmonic.exact() {
        None => return fact(ui, ("Second harmonic", tip), "…".to_owned()),
        Some(Err(why)) => return fact(ui, ("Second harmonic", &why.to_string()), "-".to_owned()),
        Some(Ok(found)) => found,
    };
    let linear = match found.linear_drive {
        part if part < 1.0 => format!(", a tenth at {:.0} % drive", 100.0 * part),
        _ => String::new(),
    };
    fact(ui, ("Second harmonic", tip), format!("{:.0} %{linear}", 100.0 * found.harmonic));
    let tip = "Upper bound of the air speed along the beam, driven by absorbed sound";
    fact(ui, ("Streaming", tip), format!("at most {:.1} m/s", found.streaming));
    if let Some(audible) = found.audible {
        let tip = format!(
            "At the listener, from the modulated beam itself, mostly at {:.0} Hz; an estimate to some 6 dB",
            audible.frequency
        );
        fact(ui, ("Audible sound", &tip), format!("{:.0} dB(A)", audible.weighted_level()));
    }
}

/// 5, 50 and 95 % of the figures, if elements differ.
fn ranges(editor: &Editor, ui: &mut Ui) {
    let (scene, convention) = (editor.scene(), editor.view.convention);
    if scene.array.spread.is_none() {
        return;
    }
    heading(ui, "Spread of elements");
    ui.label(egui::RichText::new(format!("Of {}", spread::title(scene.array.spread))).weak());
    let Some(Some(ranges)) = editor.parts.ranges.exact() else {
        ui.weak("…");
        return;
    };
    form(ui, "ranges", |ui| {
        for (name, values) in spread::rows(ranges, |pressure| convention.pressure(pressure)) {
            fact(ui, (name, "5, 50 and 95 % of arrays with such elements"), values);
        }
        let tip = "Over the median: the gain if every element were measured and corrected";
        fact(ui, ("Gain by calibration", tip), spread::won(ranges));
    });
    ui.label(egui::RichText::new(spread::faults(scene)).weak());
}

/// The number of alternating drives: as many as pay, or a given number.
fn turns(ui: &mut Ui, (name, tip): (&str, &str), turns: &mut Turns) {
    /// The number after another choice.
    const NAMED: u32 = 4;
    let named = match *turns {
        Turns::Auto => Turns::Count(NAMED),
        Turns::Count(_) => *turns,
    };
    choice(ui, (name, tip), turns, &[(Turns::Auto, "automatic"), (named, "by number")]);
    if let Turns::Count(number) = turns {
        count(ui, ("Number of drives", "Played one after the other"), number, 1..=32);
    }
}

/// Figures of separate foci.
fn foci(quality: &Quality, ui: &mut Ui) {
    fact(
        ui,
        ("Efficiency", "Of the excitation before it is made uniform: Σ|u|² / (N max|u|²)"),
        format!("{:.1} %", 100.0 * quality.efficiency),
    );
    let tip = "Mean pressure of M foci times √M over that of a single focus";
    fact(ui, ("Relative to a single focus", tip), format!("{:.2}", quality.relative_to_single));
}

/// Figures of shapes, computed when nothing is dragged.
fn shape(figures: Option<&Figures>, ui: &mut Ui) {
    let told = |tell: &dyn Fn(&Figures) -> String| figures.map_or("…".to_owned(), tell);
    let percent = |part: f64| format!("{:.0} %", 100.0 * part);
    let tip = "Least over mean pressure along the strokes, and the ripple from least to largest";
    fact(ui, ("Evenness", tip), told(&|it| format!("{}, {:.1} dB", percent(it.evenness), it.ripple_db)));
    let lobe = |it: &Figures| if it.side_lobe > 0.0 { percent(it.side_lobe) } else { "-".to_owned() };
    let place = told(&|it| {
        let [x, y, z] = it.side_lobe_position.to_array().map(|place| millimetres(place, 0));
        format!("{x}, {y}, {z} mm")
    });
    let tip = format!(
        "Loudest place on the plane outside the main lobes, relative to the mean of the drawing: at {place}"
    );
    fact(ui, ("Peak side lobe", &tip), told(&lobe));
    let tip = "Mean pressure relative to the strongest known drive";
    fact(ui, ("Relative to strongest", tip), told(&|it| percent(it.strength)));
    if let Some(areas) = figures.and_then(|figures| figures.areas) {
        let tip = "Mean of pressure squared inside the areas over that around them, or of the depression";
        fact(ui, ("Contrast", tip), format!("{:.1}", areas.contrast));
        let tip = "Σ (s I - T)²/Σ T²: relative squared error of squared pressure, or of the depression";
        fact(ui, ("Error", tip), format!("{:.1} %", 100.0 * areas.error));
    }
}

/// All methods on the same scene, side by side.
fn comparison(editor: &mut Editor, shown: &Shown, ui: &mut Ui, commands: &mut Vec<Command>) {
    heading(ui, "Methods compared");
    ui.horizontal(|ui| {
        let button = egui::Button::new("Compare all methods");
        if ui
            .add_enabled(!shown.is_comparing, button)
            .on_hover_text("Solves the scene with every method")
            .clicked()
        {
            commands.push(Command::CompareMethods);
        }
        if shown.is_comparing {
            ui.spinner();
        }
    });
    if shown.methods.is_empty() {
        return;
    }
    let table = egui::Grid::new("methods").num_columns(4).striped(true).spacing([6.0, 4.0]);
    egui::ScrollArea::horizontal().id_salt("methods").show(ui, |ui| {
        table.show(ui, |ui| {
            for (title, tip) in [
                ("Method", "Click to use it"),
                ("Weakest", "Pressure at the weakest focal point"),
                ("std/mean", "Standard deviation over mean of the focal pressures"),
                ("Time", "Solving time, without quality figures"),
            ] {
                ui.strong(title).on_hover_text(tip);
            }
            ui.end_row();
            let solver = &editor.scene().solver;
            let current = (!editor.scene().drive.is_named()).then_some(solver.method);
            for row in &shown.methods {
                let chosen = current == Some(row.method);
                // Long names wrap, so that all columns are in sight.
                let name = ui.scope(|ui| {
                    ui.set_max_width(METHOD);
                    ui.spacing_mut().button_padding.x = 3.0;
                    ui.add(egui::Button::selectable(chosen, row.method.title()).wrap())
                });
                let response = name.inner.on_hover_text(describe(row.method));
                match &row.solution {
                    Ok(solution) => {
                        if response.clicked() {
                            editor.document.scene.solve_by(row.method);
                        }
                        ui.label(editor.view.convention.pressure(solution.quality.min_pressure));
                        ui.label(format!("{:.1} %", 100.0 * solution.quality.spread));
                        ui.label(milliseconds(solution.seconds, usize::from(solution.seconds < 0.1)));
                    }
                    Err(why) => {
                        ui.weak("–").on_hover_text(why);
                        ui.weak("–");
                        ui.weak("–");
                    }
                }
                ui.end_row();
            }
        })
    });
}
