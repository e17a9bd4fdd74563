//! How the targets move, and which moment is shown.

use egui::{Slider, Ui};

use crate::picture::sheet::pascals;
use crate::scene::MotionPath;
use crate::scene::motion;
use crate::solver::frames::Frame;
use crate::ui::panels::{MM, Unit, choice, count, fact, form, heading, number};
use crate::ui::{Editor, Shown};

const PATHS: [(MotionPath, &str); 6] = [
    (MotionPath::None, "none"),
    (MotionPath::Line, "line"),
    (MotionPath::Circle, "circle"),
    (MotionPath::Square, "square"),
    (MotionPath::Triangle, "triangle"),
    (MotionPath::FigureEight, "figure-eight"),
];

pub fn show(editor: &mut Editor, shown: &Shown, ui: &mut Ui) {
    settings(editor, ui);
    if editor.scene().motion.path == MotionPath::None {
        editor.playback.frame = None;
        editor.playback.playing = false;
        ui.label("Nothing moves. Choose a path: all targets follow it together.");
        return;
    }
    ui.separator();
    playback(editor, shown, ui);
    if let Some(round) = &shown.round {
        let frames = &round.frames;
        heading(ui, "The round");
        form(ui, "round", |ui| {
            let mean = frames.iter().map(Frame::mean_pressure).sum::<f64>() / frames.len().max(1) as f64;
            fact(ui, ("Mean pressure", "Over focal points and frames, peak"), pascals(mean));
            let weakest = frames.iter().map(Frame::min_pressure).fold(f64::INFINITY, f64::min);
            fact(ui, ("Weakest", "In the weakest frame, peak"), pascals(weakest));
            let step = format!(
                "{:.0}° at most, {:.1}° RMS",
                round.steps.largest.to_degrees(),
                round.steps.rms.to_degrees()
            );
            fact(ui, ("Phase steps", "How far phases go from frame to frame: small steps are silent"), step);
            fact(ui, ("Solved in", "All frames"), format!("{:.0} ms", 1e3 * round.seconds));
        });
    }
}

fn settings(editor: &mut Editor, ui: &mut Ui) {
    heading(ui, "Path");
    let scene = &mut editor.document.scene;
    form(ui, "motion", |ui| {
        // What only a file can hold is offered where the file has it.
        let mut paths = PATHS.to_vec();
        if !paths.iter().any(|(path, _)| *path == scene.motion.path) {
            paths.push((scene.motion.path, scene.motion.path.name()));
        }
        choice(
            ui,
            ("Path", "Along which all targets move, parallel to the array"),
            &mut scene.motion.path,
            &paths,
        );
        let size = "Length, diameter, side or width of the path";
        number(ui, ("Size", size), &mut scene.motion.size, MM, 1e-4..=1.0);
        let hertz = Unit { per: 1.0, suffix: " Hz", decimals: 2, speed: 0.1 };
        number(ui, ("Rate", "Rounds per second"), &mut scene.motion.rate, hertz, 0.01..=1e4);
        count(ui, ("Frames", "Drives per round"), &mut scene.motion.frames, 1..=4096);
        if scene.motion.path != MotionPath::None {
            let speed = format!("{:.2} m/s", scene.motion.speed());
            fact(ui, ("Speed", "Of a focus; 5 to 8 m/s are felt most"), speed);
            let rate = format!("{:.0} per second", scene.motion.frames_per_second());
            fact(ui, ("Frames shown", "What the board has to keep up with"), rate);
        }
    });
}

fn playback(editor: &mut Editor, shown: &Shown, ui: &mut Ui) {
    heading(ui, "Play");
    let count = motion::count(editor.scene());
    let playback = &mut editor.playback;
    ui.horizontal(|ui| {
        let name = if playback.playing { "Pause" } else { "Play" };
        if ui.button(name).clicked() {
            playback.playing = !playback.playing;
            playback.frame.get_or_insert(0);
        }
        if ui.add_enabled(playback.frame.is_some(), egui::Button::new("At rest")).clicked() {
            playback.playing = false;
            playback.frame = None;
        }
        if shown.is_following {
            ui.spinner();
            ui.label("solving all frames");
        }
    });
    let mut frame = playback.frame.unwrap_or(0) + 1;
    let label = ui.label("Frame").on_hover_text("The moment whose field is shown");
    let slider = ui.add(Slider::new(&mut frame, 1..=count.max(1))).labelled_by(label.id);
    if slider.changed() {
        playback.playing = false;
        playback.frame = Some(frame - 1);
        playback.part = (frame - 1) as f64 / count.max(1) as f64;
    }
    let label = ui.label("Slower than it is").on_hover_text("1 is as fast as the hand feels it");
    let slider = Slider::new(&mut playback.slowness, 1.0..=1000.0).logarithmic(true).suffix(" x");
    ui.add(slider.max_decimals(0)).labelled_by(label.id);
}
