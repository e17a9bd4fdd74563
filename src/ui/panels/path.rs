//! The panel of a motion's path and speed, for the scene or a target.

use std::f64::consts::TAU;

use egui::{ComboBox, Ui};
use glam::DVec3;
use strum::VariantArray;

use crate::echo;
use crate::rounding::percent;
use crate::scene::check::FACTORS;
use crate::scene::{Easing, Keyframe, Motion, MotionPath, Scene, Tempo, motion};
use crate::studio::response::Moving;
use crate::ui::panels::form::{choice, coordinates, count, heading, variants};
use crate::ui::panels::{DEGREES, MM, PERCENT, PLAIN, Unit, bare_number, caption, fact, form, number, value};

/// Time between two keyframes, in cycles.
const APART: f64 = 1e-4;
/// Initial points of a path, m.
const FIRST_POINTS: [DVec3; 3] = [DVec3::ZERO, DVec3::new(0.02, 0.0, 0.0), DVec3::new(0.02, 0.02, 0.0)];
/// Initial keyframes: times in a cycle and offsets.
const FIRST_KEYFRAMES: [(f64, DVec3); 2] = [(0.0, DVec3::ZERO), (0.5, DVec3::new(0.02, 0.0, 0.0))];
/// Turns and phases of a keyframe, rad.
const TURNS: std::ops::RangeInclusive<f64> = -100.0 * TAU..=100.0 * TAU;
const HERTZ: Unit = Unit { per: 1.0, suffix: " Hz", decimals: 2, speed: 0.1 };
const SPEED: Unit = Unit { per: 1.0, suffix: " m/s", decimals: 2, speed: 0.05 };

/// Values derived from a motion and the others of its scene.
#[derive(Clone, Copy)]
pub struct Figures {
    /// Length of a repetition, m.
    length: f64,
    /// Requested repetitions per second.
    asked: f64,
    /// Repetitions per cycle.
    rounds: u64,
    /// Cycles and frames per second.
    rate: f64,
    frames_per_second: f64,
    /// Whether one repetition of it is the cycle.
    leads: bool,
    /// Whether elements need time to follow.
    is_slow: bool,
    /// What the cycle keeps, if that is known.
    moving: Option<Moving>,
}

impl Figures {
    /// For a target's motion, or the scene's; `None` if it moves no target.
    pub fn of(scene: &Scene, target: Option<usize>) -> Option<Self> {
        let cycle = motion::cycle(scene)?;
        let index = cycle.groups.iter().position(|group| group.target == target)?;
        let group = &cycle.groups[index];
        Some(Self {
            length: group.length,
            asked: group.asked(),
            rounds: group.rounds,
            rate: cycle.rate,
            frames_per_second: cycle.frames_per_second(),
            leads: index == cycle.leader,
            is_slow: scene.array.response.is_some(),
            moving: None,
        })
    }
}

impl Figures {
    /// The same beside what the cycle keeps.
    pub fn with(self, moving: Option<Moving>) -> Self {
        Self { moving, ..self }
    }
}

/// Path, size and tempo of a target's own motion, or of the scene's, which alone can have steps.
/// Returns whether a file is to be chosen.
pub fn settings(motion: &mut Motion, figures: Option<Figures>, is_own: bool, ui: &mut Ui) -> bool {
    let mut asks_for_file = false;
    form(ui, "motion", |ui| {
        let tip =
            "Of the targets. Outline: foci run along the drawn strokes. Steps: targets are played in turn";
        let mut paths = variants::<MotionPath>(Into::into);
        paths.retain(|(path, _)| !is_own || *path != MotionPath::Steps);
        let mut path = motion.path;
        choice(ui, ("Path", tip), &mut path, &paths);
        asks_for_file = choose(motion, path);
        let path = motion.path;
        match path {
            MotionPath::None | MotionPath::Points | MotionPath::Keyframes | MotionPath::Steps => {}
            MotionPath::File => asks_for_file |= file(motion, ui),
            MotionPath::Outline => {
                let tip = "Foci along the strokes, equally spaced";
                count(ui, ("Running foci", tip), &mut motion.foci, 1..=64);
            }
            MotionPath::Line
            | MotionPath::Circle
            | MotionPath::Square
            | MotionPath::Triangle
            | MotionPath::FigureEight => {
                let tip = "Length, diameter, side or width of the path";
                number(ui, ("Size", tip), &mut motion.size, MM, 1e-4..=1.0);
                if path != MotionPath::Circle {
                    let tip = "Rotation of the path, counter-clockwise";
                    number(ui, ("Angle", tip), &mut motion.angle, DEGREES, -TAU..=TAU);
                }
            }
        }
        if let Some(figures) = figures.filter(|_| path != MotionPath::None) {
            tempo(motion, figures, ui);
        }
    });
    if motion.path == MotionPath::Keyframes {
        keyframes(&mut motion.keyframes, ui);
    }
    if motion.path == MotionPath::Points {
        points(&mut motion.points, ui);
    }
    asks_for_file
}

/// The file of a path; returns whether another is to be chosen.
fn file(motion: &mut Motion, ui: &mut Ui) -> bool {
    fact(ui, ("Path file", "CSV or G-code; places in m"), echo::value(&motion.file).to_string());
    fact(ui, ("Places", "Of the target with most"), motion.routes.places().to_string());
    caption(ui, "");
    let button = value(ui, |ui| ui.button("Choose…")).on_hover_text("Another CSV or G-code file");
    ui.end_row();
    caption(ui, "Tempo");
    let mut is_own = motion.tempo == Tempo::Own;
    let tip = "At the times or feeds of the file, if it has any; otherwise at the rate or the speed below";
    let is_changed = value(ui, |ui| ui.checkbox(&mut is_own, "As in the file").on_hover_text(tip)).changed();
    ui.end_row();
    if is_changed {
        let asked = motion.rate(motion.length()).map_or(Tempo::Own, Tempo::Rate);
        motion.tempo = if is_own { Tempo::Own } else { asked };
    }
    button.clicked()
}

/// Rate and speed: the given one is kept, the other follows.
fn tempo(motion: &mut Motion, figures: Figures, ui: &mut Ui) {
    let Figures { length, asked, rounds, rate, frames_per_second, leads, is_slow, moving } = figures;
    let mut rounds_per_second = asked;
    let tip = "Repetitions of the path per second; of rate and speed, the one typed last is kept";
    if number(ui, ("Rate", tip), &mut rounds_per_second, HERTZ, 0.01..=1e4).changed() {
        motion.tempo = Tempo::Rate(rounds_per_second);
    }
    if length > 0.0 {
        let mut speed = length * asked;
        let tip = "Of a focus along its path; 5 to 8 m/s feel strongest";
        if number(ui, ("Speed", tip), &mut speed, SPEED, 1e-3..=1e3).changed() {
            motion.tempo = Tempo::Speed(speed);
        }
    }
    if is_slow && length > 0.0 {
        caption(ui, "Lead");
        let tip =
            "Foci run ahead of their path by the elements' response time, which regains half of the loss";
        value(ui, |ui| ui.checkbox(&mut motion.lead, "Ahead").on_hover_text(tip));
        ui.end_row();
    }
    if let Some(moving) = moving {
        let tip = "RMS pressure at the moving foci, relative to foci at rest: elements follow with a delay. A lower speed keeps more";
        fact(ui, ("Pressure kept", tip), percent(moving.kept));
        let tip = "The least pressure between two frames, relative to the focus at rest. More frames make it shallower";
        fact(ui, ("Deepest dip", tip), percent(moving.dip));
        let advice = if moving.is_coarse() { ": take more frames" } else { ", fine" };
        let tip = "Mean phase change per frame: up to 9° dips stay shallow and frames inaudible";
        fact(ui, ("Steps", tip), format!("{:.1}°{advice}", moving.step.to_degrees()));
        if let Some(noise) = moving.noise {
            let tip = "A-weighted changes of |p|² at the foci, relative to its mean";
            fact(ui, ("Step noise", tip), format!("{noise:.0} dB(A)"));
        }
    }
    if leads {
        let mut frames = motion.frame_count();
        if count(ui, ("Frames", "Drives per cycle"), &mut frames, 1..=4096).changed() {
            motion.frames = frames;
        }
        let shown = format!("{frames_per_second:.0} per second");
        fact(ui, ("Frame rate", "The board has to keep up with it"), shown);
    } else {
        let times = if rounds == 1 { "once".to_owned() } else { format!("{rounds} times") };
        let tip = "A whole number of repetitions fits into the scene's cycle";
        fact(ui, ("Played", tip), format!("{times} a cycle: {:.2} Hz", rate * rounds as f64));
    }
}

/// Selects a path, with its required points and a sensible tempo; returns whether a file is required first.
fn choose(motion: &mut Motion, path: MotionPath) -> bool {
    if path == motion.path {
        return false;
    }
    if path == MotionPath::File && motion.routes.file().is_none() {
        return true;
    }
    if motion.path == MotionPath::File {
        motion.frames = motion.frame_count();
    }
    motion.path = path;
    if path == MotionPath::Points && motion.points.is_empty() {
        motion.points = FIRST_POINTS.to_vec();
    }
    if path == MotionPath::Keyframes && motion.keyframes.is_empty() {
        motion.keyframes = FIRST_KEYFRAMES.map(|(time, at)| Keyframe::new(time, at)).to_vec();
    }
    let has_no_speed = path == MotionPath::Steps && matches!(motion.tempo, Tempo::Speed(_));
    let has_no_own = path != MotionPath::File && motion.tempo == Tempo::Own;
    if path == MotionPath::Outline || has_no_speed || has_no_own {
        motion.tempo = Tempo::usual(path);
    }
    false
}

/// Times, offsets in mm, pressures and easings.
fn keyframes(keyframes: &mut Vec<Keyframe>, ui: &mut Ui) {
    heading(ui, "Keyframes");
    ui.label(
        "Time in the cycle; offset from the target in mm; factor of its pressure; turn, and phase of a trap:",
    );
    let (only, mut removed) = (keyframes.len() == 1, None);
    let times: Vec<_> = keyframes.iter().map(|keyframe| keyframe.time).collect();
    for (index, keyframe) in keyframes.iter_mut().enumerate() {
        let name = |what: &str| format!("Keyframe {} {what}", index + 1);
        ui.horizontal(|ui| {
            ui.label(format!("{}", index + 1));
            let before = index.checked_sub(1).map_or(0.0, |before| times[before] + APART);
            let most = times.get(index + 1).copied().unwrap_or(1.0) - APART;
            let time = bare_number(ui, &mut keyframe.time, PERCENT, before.min(most)..=most);
            time.on_hover_text("Part of the cycle").accessible_name(name("time"));
            coordinates(ui, &name("offset"), &mut keyframe.at, -2000.0);
        });
        ui.horizontal(|ui| {
            ui.add_space(18.0);
            let pressure = bare_number(ui, &mut keyframe.pressure, PLAIN, FACTORS);
            pressure.on_hover_text("Factor of the target's pressure").accessible_name(name("pressure"));
            let angle = bare_number(ui, &mut keyframe.angle, DEGREES, TURNS);
            angle
                .on_hover_text("Turn about the target's normal; 360° is a full turn")
                .accessible_name(name("angle"));
            let phase = bare_number(ui, &mut keyframe.phase, DEGREES, TURNS);
            let tip = "Added to the opposite part of a trap, or to the phase of a vortex";
            phase.on_hover_text(tip).accessible_name(name("phase"));
            let combo =
                ComboBox::from_id_salt(name("easing")).width(76.0).selected_text(keyframe.easing.into_str());
            let response = combo.show_ui(ui, |ui| {
                for &easing in Easing::VARIANTS {
                    ui.selectable_value(&mut keyframe.easing, easing, easing.into_str());
                }
            });
            let tip = "Easing on the way to the next keyframe";
            response.response.on_hover_text(tip).accessible_name(name("easing"));
            let button = ui.add_enabled(!only, egui::Button::new("-").small());
            if button
                .on_hover_text("Delete")
                .accessible_name(format!("Delete keyframe {}", index + 1))
                .clicked()
            {
                removed = Some(index);
            }
        });
    }
    if let Some(index) = removed {
        keyframes.remove(index);
    }
}

/// The offsets that a path through points visits, in mm.
fn points(points: &mut Vec<DVec3>, ui: &mut Ui) {
    heading(ui, "Points");
    ui.label("Offsets from the target in mm, visited in turn:");
    let (mut added, mut removed) = (None, None);
    let only = points.len() == 1;
    form(ui, "points", |ui| {
        for (index, offset) in points.iter_mut().enumerate() {
            ui.label(format!("{}", index + 1));
            ui.horizontal(|ui| {
                coordinates(ui, &format!("Point {}", index + 1), offset, -2000.0);
                let number = index + 1;
                let button = ui.small_button("+").on_hover_text("Insert a point after this one");
                if button.accessible_name(format!("Add a point after {number}")).clicked() {
                    added = Some(index);
                }
                let button = ui.add_enabled(!only, egui::Button::new("-").small());
                let button = button.on_hover_text("Remove this point");
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
