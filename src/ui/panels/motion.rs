//! The Motion page: modulation, motion of targets, and the pressures reached in the frames of a cycle.

use egui::Ui;

use crate::rounding::{at_most, milliseconds};
use crate::scene::{MotionPath, Scene, motion};
use crate::solver::frames::Frame;
use crate::ui::command::Purpose;
use crate::ui::dialog::state::Dialog;
use crate::ui::panels::form::heading;
use crate::ui::panels::path::{self, Figures};
use crate::ui::panels::{fact, form, modulation};
use crate::ui::parts::course;
use crate::ui::playback::Moment;
use crate::ui::{editor::Editor, shown::Shown};

pub fn show(editor: &mut Editor, shown: &Shown, ui: &mut Ui) {
    modulation::show(editor, ui);
    course::panel::show(editor, ui);
    ui.separator();
    settings(editor, ui);
    if !motion::moves(editor.scene()) {
        if !matches!(editor.playback.moment, Moment::Wave(_)) {
            (editor.playback.moment, editor.playback.playing) = (Moment::Rest, false);
        }
        ui.label(match editor.scene().drive.is_named() {
            true => "Nothing moves: the drive is that of a file, which has no frames.",
            false => "The scene is static. Choose a path that all targets follow.",
        });
        return;
    }
    if editor.scene().motion.path == MotionPath::Steps {
        ui.label("The Scene panel sets the step of each target.");
    }
    let own =
        editor.scene().targets.iter().filter(|target| target.visible && target.motion.is_some()).count();
    if own > 0 {
        let whose =
            if own == 1 { "1 target has its".to_owned() } else { format!("{own} targets have their") };
        ui.label(format!("{whose} own motion; see the Scene panel."));
    }
    ui.separator();
    if let Some(round) = &shown.round {
        let frames = &round.frames;
        let convention = editor.view.convention;
        heading(ui, "Cycle");
        form(ui, "cycle", |ui| {
            let mean = frames.iter().map(Frame::mean_pressure).sum::<f64>() / frames.len().max(1) as f64;
            fact(ui, ("Mean pressure", "Over focal points and frames"), convention.pressure(mean));
            let weakest = frames.iter().map(Frame::min_pressure).fold(f64::INFINITY, f64::min);
            fact(ui, ("Weakest", "In the weakest frame"), convention.pressure(weakest));
            let step = format!(
                "{}° at most, {:.1}° RMS",
                at_most(round.steps.largest.to_degrees(), 0),
                round.steps.rms.to_degrees()
            );
            fact(ui, ("Phase change per frame", "Of the elements; small changes are silent"), step);
            fact(ui, ("Solved in", "All frames"), milliseconds(round.seconds, 0));
        });
    }
}

fn settings(editor: &mut Editor, ui: &mut Ui) {
    heading(ui, "Path");
    let moving = editor.parts.response.newest().copied().flatten();
    let scene = &mut editor.document.scene;
    let figures = Figures::of(scene, None).map(|figures| figures.with(moving));
    let before = scene.motion.path;
    let asks_for_file = path::settings(&mut scene.motion, figures, false, ui);
    if scene.motion.path != before {
        take_turns(scene);
    }
    if asks_for_file {
        editor.dialog = Some(Dialog::path(Purpose::Path(None), &editor.document));
    }
}

/// Assigns a step to every target if they take turns, otherwise to none.
fn take_turns(scene: &mut Scene) {
    let steps = scene.motion.path == MotionPath::Steps;
    for (index, target) in (0..).zip(&mut scene.targets) {
        target.step = steps.then_some(target.step.unwrap_or(index));
    }
    if steps {
        scene.motion.frames = scene.motion.frames.max(scene.targets.len() as u32);
    }
}
