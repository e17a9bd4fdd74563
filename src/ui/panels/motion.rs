//! How the targets move, and which moment is shown.

use egui::{Slider, Ui};
use glam::DVec3;

use crate::picture::sheet::pascals;
use crate::scene::motion;
use crate::scene::{Envelope, Modulation, MotionPath, Scene};
use crate::solver::frames::Frame;
use crate::ui::panels::target::coordinates;
use crate::ui::panels::{MM, Unit, choice, count, fact, form, heading, number};
use crate::ui::{Editor, Shown};

const PATHS: [(MotionPath, &str); 8] = [
    (MotionPath::None, "none"),
    (MotionPath::Line, "line"),
    (MotionPath::Circle, "circle"),
    (MotionPath::Square, "square"),
    (MotionPath::Triangle, "triangle"),
    (MotionPath::FigureEight, "figure-eight"),
    (MotionPath::Points, "points"),
    (MotionPath::Steps, "steps"),
];
/// m: where a path through points goes until somebody says otherwise.
const FIRST_POINTS: [DVec3; 3] = [DVec3::ZERO, DVec3::new(0.02, 0.0, 0.0), DVec3::new(0.02, 0.02, 0.0)];

pub fn show(editor: &mut Editor, shown: &Shown, ui: &mut Ui) {
    modulation(&mut editor.document.scene.modulation, ui);
    ui.separator();
    settings(editor, ui);
    if editor.scene().motion.path == MotionPath::None {
        editor.playback.frame = None;
        editor.playback.playing = false;
        ui.label("Nothing moves. Choose a path: all targets follow it together.");
        return;
    }
    match editor.scene().motion.path {
        MotionPath::Points => points(&mut editor.document.scene.motion.points, ui),
        MotionPath::Steps => drop(ui.label("Every target shows its step in the Scene panel.")),
        _ => {}
    }
    ui.separator();
    playback(editor, shown, ui);
    if let Some(round) = &shown.round {
        let frames = &round.frames;
        heading(ui, "Cycle");
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
        let mut path = scene.motion.path;
        let tip = "Along which all targets move; in steps, they take turns instead";
        choice(ui, ("Path", tip), &mut path, &PATHS);
        choose(scene, path);
        if !matches!(path, MotionPath::Points | MotionPath::Steps) {
            let size = "Length, diameter, side or width of the path";
            number(ui, ("Size", size), &mut scene.motion.size, MM, 1e-4..=1.0);
        }
        let hertz = Unit { per: 1.0, suffix: " Hz", decimals: 2, speed: 0.1 };
        number(ui, ("Rate", "Cycles per second"), &mut scene.motion.rate, hertz, 0.01..=1e4);
        count(ui, ("Frames", "Drives per cycle"), &mut scene.motion.frames, 1..=4096);
        if !matches!(path, MotionPath::None | MotionPath::Steps) {
            let speed = format!("{:.2} m/s", scene.motion.speed());
            fact(ui, ("Speed", "Of a focus; 5 to 8 m/s are felt most"), speed);
        }
        if path != MotionPath::None {
            let rate = format!("{:.0} per second", scene.motion.frames_per_second());
            fact(ui, ("Frames shown", "What the board has to keep up with"), rate);
        }
    });
}

/// Another path, with what it needs: points to visit, or a step for every target.
fn choose(scene: &mut Scene, path: MotionPath) {
    if path == scene.motion.path {
        return;
    }
    scene.motion.path = path;
    if path == MotionPath::Points && scene.motion.points.is_empty() {
        scene.motion.points = FIRST_POINTS.to_vec();
    }
    let steps = path == MotionPath::Steps;
    for (index, target) in (0..).zip(&mut scene.targets) {
        target.step = steps.then_some(target.step.unwrap_or(index));
    }
    if steps {
        scene.motion.frames = scene.motion.frames.max(scene.targets.len() as u32);
    }
}

/// The offsets that a path through points visits, in mm.
fn points(points: &mut Vec<DVec3>, ui: &mut Ui) {
    heading(ui, "Points");
    ui.label("Where the targets go, one after the other and back to the first, from their own places:");
    let (mut added, mut removed) = (None, None);
    let only = points.len() == 1;
    form(ui, "points", |ui| {
        for (index, offset) in points.iter_mut().enumerate() {
            ui.label(format!("{}", index + 1));
            ui.horizontal(|ui| {
                coordinates(ui, &format!("Point {}", index + 1), offset, -2000.0);
                let number = index + 1;
                let button = ui.small_button("+").on_hover_text("Another one after this");
                if button.accessible_name(format!("Add a point after {number}")).clicked() {
                    added = Some(index);
                }
                let button = ui.add_enabled(!only, egui::Button::new("-").small());
                let button = button.on_hover_text("Without this one");
                if button.accessible_name(format!("Remove point {number}")).clicked() {
                    removed = Some(index);
                }
            });
            ui.end_row();
        }
    });
    if let Some(index) = added {
        let next = points[(index + 1) % points.len()];
        let middle = (points[index] + next) / 2.0;
        let place =
            if middle.distance(points[index]) > 1e-6 { middle } else { points[index] + FIRST_POINTS[1] };
        points.insert(index + 1, place);
    }
    if let Some(index) = removed {
        points.remove(index);
    }
}

/// What makes a hand feel the sound.
fn modulation(modulation: &mut Modulation, ui: &mut Ui) {
    heading(ui, "Modulation");
    form(ui, "modulation", |ui| {
        let shapes = [(Envelope::Off, "off"), (Envelope::Sine, "sine"), (Envelope::Square, "square")];
        let tip = "How the loudness goes up and down: a hand feels that, and no steady sound";
        choice(ui, ("Envelope", tip), &mut modulation.shape, &shapes);
        if modulation.shape != Envelope::Off {
            let hertz = Unit { per: 1.0, suffix: " Hz", decimals: 1, speed: 1.0 };
            let tip = "How often; skin feels 200 Hz best";
            number(ui, ("Frequency", tip), &mut modulation.frequency, hertz, 1.0..=1000.0);
            let percent = Unit { per: 100.0, suffix: " %", decimals: 0, speed: 0.5 };
            number(
                ui,
                ("Modulation depth", "100 %: down to silence"),
                &mut modulation.depth,
                percent,
                0.0..=1.0,
            );
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
