//! The timeline below the canvas: the displayed frame or wave, the playback speed, and keyframes.

use egui::{
    Align2, Button, CursorIcon, DragValue, FontId, Painter, Rect, Response, ScrollArea, Sense, Stroke, Ui,
    WidgetInfo, pos2, vec2,
};
use strum::VariantArray;

use crate::field::Quantity;
use crate::picture::figure::axes::round_step;
use crate::scene::motion::{self, Cycle, Group};
use crate::scene::{Easing, Keyframe, MotionPath};
use crate::ui::board::Plays;
use crate::ui::gesture::Vertex;
use crate::ui::playback::{Moment, Playback};
use crate::ui::{editor::Editor, layout::Panel, level, path_marks, shown::Shown, theme, way};

/// Points of the screen.
const RULER: f32 = 20.0;
const LANE: f32 = 22.0;
const NAMES: f32 = 84.0;
const HALF: f32 = 6.0;
/// Limit of lanes before scrolling.
const MOST_LANES: f32 = 4.0;
/// Points of the screen between two times of the ruler, at least.
const TICK: f64 = 70.0;
/// Width below which the timeline is abbreviated, with fewer lanes, in points.
const NARROW: f32 = 460.0;
const LOW: f32 = 600.0;
/// Slowdown at which the pictures of waves follow each other smoothly.
const SMOOTH: f64 = 10.0;
/// Limit of frames for stepping through keyframes frame by frame.
const MOST_STEPS: f64 = 4096.0;

/// Whether the timeline is shown: there is something to play, and it is edited, chosen or asked for.
pub fn is_wanted(editor: &Editor) -> bool {
    if editor.layout.presents {
        return editor.layout.has_timeline && Played::of(editor).is_some();
    }
    match Played::of(editor) {
        Some(Played::Waves(_)) => matches!(editor.playback.moment, Moment::Wave(_)),
        Some(Played::Motion(_)) => {
            let is_at_rest = editor.playback.moment == Moment::Rest;
            let is_made_by_motion = Moment::opening(editor.scene()) == Moment::Mean;
            editor.panel == Panel::Motion || !is_at_rest || is_made_by_motion
        }
        None => false,
    }
}

pub fn show(editor: &mut Editor, shown: &Shown, ui: &mut Ui) {
    let Some(played) = Played::of(editor) else { return };
    ui.horizontal_wrapped(|ui| {
        controls(editor, shown, ui, played);
        match played {
            Played::Motion(_) => keyframe(editor, ui),
            Played::Waves(_) => duration(editor, ui),
        }
    });
    lanes(editor, ui, played);
}

/// Plays, or pauses, what is displayed: a bead in flight, the wave of the sound, waves of a liquid, or a motion. Returns whether
/// there was any.
pub fn play_or_pause(editor: &mut Editor) -> bool {
    let flight = &mut editor.parts.flight.form;
    if flight.from.is_some() {
        flight.playing = !flight.playing;
        return true;
    }
    if !editor.space.is_on && editor.view.quantity == Quantity::Instantaneous {
        editor.oscillation.playing = !editor.oscillation.playing;
        return true;
    }
    let played = Played::of(editor);
    played.into_iter().for_each(|played| toggle(editor, played));
    played.is_some()
}

/// Goes on by so many frames, or back.
pub fn step(editor: &mut Editor, by: isize) {
    let Some(played) = Played::of(editor) else { return };
    let count = played.clock().frames.max(1);
    let index = editor.playback.moment.playing(editor.view.quantity);
    let next = index.map_or(0, |index| (index as isize + by).rem_euclid(count as isize));
    show_part(editor, next as f64 / count as f64, played);
}

/// The displayed moment in words; `None` at rest.
pub fn moment_in_words(editor: &Editor) -> Option<String> {
    let played = Played::of(editor)?;
    let clock = played.clock();
    match (editor.playback.moment.of(editor.view.quantity), played) {
        (Moment::Mean, Played::Motion(_)) => Some("mean of a cycle".to_owned()),
        (Moment::Frame(index), Played::Motion(_)) => Some(format!("frame {} of {}", index + 1, clock.frames)),
        (Moment::Wave(index), Played::Waves(_)) => {
            Some(format!("{} ms after the onset", clock.time(index as f64 / clock.frames.max(1) as f64)))
        }
        (
            Moment::Rest | Moment::Mean | Moment::Frame(_) | Moment::Wave(_),
            Played::Motion(_) | Played::Waves(_),
        ) => None,
    }
}

/// Plays or pauses the frames; after the last one from the first.
fn toggle(editor: &mut Editor, played: Played) {
    let playback = &mut editor.playback;
    let index = playback.moment.playing(editor.view.quantity);
    playback.playing = !(playback.playing && index.is_some());
    let is_at_end = index.is_some_and(|index| index + 1 >= played.clock().frames) && !playback.loops;
    if index.is_none() || (playback.playing && is_at_end) {
        (playback.moment, playback.part) = (played.moment(0), 0.0);
    }
}

/// Whether anything can be played.
pub fn can_play(editor: &Editor) -> bool {
    let is_wave = !editor.space.is_on && editor.view.quantity == Quantity::Instantaneous;
    is_wave || editor.parts.flight.form.from.is_some() || Played::of(editor).is_some()
}

/// Shows the waves of a liquid from their beginning, or the surface at rest.
pub fn show_waves(editor: &mut Editor, is_on: bool) {
    if is_on && !editor.view.quantity.declaration().of_liquid {
        editor.view.quantity = Quantity::Depression;
    }
    if is_on {
        editor.space.is_on = false;
        if !editor.view.is_level(editor.scene()) {
            level::show_xy(editor);
        }
    }
    let moment = if is_on { Moment::Wave(0) } else { Moment::Rest };
    let slowness = if is_on { editor.playback.slowness.min(SMOOTH) } else { editor.playback.slowness };
    editor.playback = Playback { moment, playing: is_on, part: 0.0, slowness, ..editor.playback };
}

/// What the timeline plays, with its units.
#[derive(Clone, Copy, Debug)]
enum Played {
    Motion(Clock),
    Waves(Clock),
}

impl Played {
    fn of(editor: &Editor) -> Option<Self> {
        let scene = editor.scene();
        if !scene.has_drive() {
            return None;
        }
        let cycle = motion::cycle(scene).map(|cycle| Self::Motion(Clock::of(&cycle)));
        let is_of_waves = matches!(editor.playback.moment.of(editor.view.quantity), Moment::Wave(_));
        let has_waves = editor.view.quantity.declaration().of_liquid
            && !editor.space.is_on
            && editor.view.is_level(scene)
            && (is_of_waves || cycle.is_none());
        let schedule = editor.parts.waves.schedule(scene).filter(|_| has_waves);
        let waves = schedule.map(|schedule| {
            let rate = schedule.rate() / schedule.pictures as f64;
            Self::Waves(Clock { rate, frames: schedule.pictures })
        });
        waves.or(cycle)
    }

    fn clock(self) -> Clock {
        match self {
            Self::Motion(clock) | Self::Waves(clock) => clock,
        }
    }

    /// A frame or picture by its number from 0.
    fn moment(self, index: usize) -> Moment {
        match self {
            Self::Motion(_) => Moment::Frame(index),
            Self::Waves(_) => Moment::Wave(index),
        }
    }
}

/// The units of the timeline.
#[derive(Clone, Copy, Debug)]
struct Clock {
    /// Cycles per second.
    rate: f64,
    frames: usize,
}

impl Clock {
    fn of(cycle: &Cycle<'_>) -> Self {
        Self { rate: cycle.rate, frames: cycle.frames as usize }
    }

    /// ms, of a part of the cycle.
    fn time(self, part: f64) -> String {
        let cycle = 1e3 / self.rate;
        let digits = (2.0 - cycle.log10().floor()).clamp(0.0, 3.0) as usize;
        format!("{:.digits$}", cycle * part)
    }
}

/// Shows the frame that begins at or before a part of the cycle.
fn show_part(editor: &mut Editor, part: f64, played: Played) {
    let frames = played.clock().frames;
    let frame = ((part * frames as f64 + 1e-9) as usize).min(frames.saturating_sub(1));
    editor.playback.playing = false;
    editor.playback.moment = played.moment(frame);
    editor.playback.part = frame as f64 / frames.max(1) as f64;
}

fn controls(editor: &mut Editor, shown: &Shown, ui: &mut Ui, played: Played) {
    let clock = played.clock();
    let quantity = editor.view.quantity;
    let index = editor.playback.moment.playing(quantity);
    let (name, tip) = match editor.playback.playing && index.is_some() {
        true => ("Pause", "Stay at this frame (Space)"),
        false => ("Play", "Show one frame after the other (Space)"),
    };
    if ui.button(name).on_hover_text(tip).clicked() {
        toggle(editor, played);
    }
    let count = clock.frames.max(1);
    for (name, tip, by) in [("◀", "Back by a frame", -1), ("▶", "On by a frame", 1)] {
        if ui.button(name).accessible_name(tip).on_hover_text(tip).clicked() {
            step(editor, by);
        }
    }
    moments(editor, ui, played);
    let playback = &mut editor.playback;
    ui.toggle_value(&mut playback.loops, "Loop").on_hover_text("Begin again after the last frame");
    let label = ui.label("Frame");
    let mut number = index.map_or(1, |frame| frame + 1);
    let field = DragValue::new(&mut number).range(1..=count).suffix(format!(" / {}", clock.frames));
    let field = ui.add(field).labelled_by(label.id).on_hover_text("The frame whose field is shown");
    let part = index.unwrap_or(0) as f64 / count as f64;
    let is_wide = ui.max_rect().width() >= NARROW;
    if is_wide {
        ui.label(format!("{} of {} ms", clock.time(part), clock.time(1.0)));
    }
    let label = ui.label("Playback");
    let slowness = DragValue::new(&mut playback.slowness).prefix("1/").range(1.0..=1000.0).speed(0.2);
    let slowness = ui.add(slowness.max_decimals(0)).labelled_by(label.id);
    slowness.on_hover_text(
        "Speed on the screen; 1/1 is real time, of which the screen shows the frames that it can",
    );
    if field.changed() {
        show_part(editor, (number - 1) as f64 / count as f64, played);
    }
    if shown.is_following {
        ui.spinner();
        ui.label("solving all frames");
    } else if let (Played::Waves(_), Some(Err(problem))) = (played, editor.parts.waves.exact()) {
        ui.colored_label(theme::warning(ui.visuals()), problem);
    }
    if shown.board.plays == Plays::Motion {
        let rates = shown.board.health.as_ref().and_then(|health| health.rates);
        let own = (clock.rate, clock.rate * clock.frames as f64);
        let (rate, frames) = rates.map_or(own, |rates| (rates.cycles, rates.played));
        let text = format!("Board plays {rate:.2} cycles/s, {frames:.0} frames/s");
        ui.colored_label(theme::CHOSEN, text).on_hover_text("At 1/1 the screen is in step with the board");
    }
}

/// What is shown besides frames: the scene at rest, and the mean of a cycle.
fn moments(editor: &mut Editor, ui: &mut Ui, played: Played) {
    let quantity = editor.view.quantity;
    let declaration = quantity.declaration();
    let shown = editor.playback.moment.of(quantity);
    let mut choose = |ui: &mut Ui, moment: Moment, name: &str, tip: &str, refusal: &str| {
        let button = Button::selectable(shown == moment, name);
        let button = ui.add_enabled(refusal.is_empty(), button).on_hover_text(tip);
        if button.on_disabled_hover_text(refusal).clicked() {
            (editor.playback.moment, editor.playback.playing) = (moment, false);
        }
    };
    match played {
        Played::Waves(_) => {
            let tip = "The surface under the mean of the sound, without waves";
            choose(ui, Moment::Rest, "At rest", tip, "");
        }
        Played::Motion(_) => {
            let refusal = match declaration.is_slow {
                true => "Liquids and skin respond to the mean of a cycle",
                false => "",
            };
            let tip = "Show the targets at their positions in the scene";
            choose(ui, Moment::Rest, "At rest", tip, refusal);
            let refusal = match declaration.has_mean {
                false => "This quantity has no mean over a cycle",
                true => "",
            };
            let tip = "The mean of all frames, RMS for pressures: what a hand or a liquid meets in a cycle";
            choose(ui, Moment::Mean, "Mean of a cycle", tip, refusal);
        }
    }
}

/// The time that waves are shown for.
fn duration(editor: &mut Editor, ui: &mut Ui) {
    /// s
    const LONGEST: f64 = 2.0;
    let Some(Played::Waves(clock)) = Played::of(editor) else { return };
    ui.separator();
    let label = ui.label("Duration");
    let mut seconds = 1.0 / clock.rate;
    let field = DragValue::new(&mut seconds).range(0.01..=LONGEST).speed(0.01).max_decimals(3).suffix(" s");
    let field = ui.add(field).labelled_by(label.id);
    if field.on_hover_text("Duration of the waves from the onset of the sound").changed() {
        editor.parts.waves.form.seconds = Some(seconds);
    }
}

/// The controls of the current keyframe, and for adding one.
fn keyframe(editor: &mut Editor, ui: &mut Ui) {
    let Some(target) = keyed(editor) else { return };
    ui.separator();
    if ui.button("Add keyframe").on_hover_text("At the playhead, where the target is then").clicked() {
        editor.playback.playing = false;
        if editor.playback.moment.frame().is_none() {
            editor.playback.moment = Moment::Frame(0);
        }
        way::add_keyframe(editor, target);
    }
    // Always present, so that the layout is stable.
    let vertex = editor.vertex;
    let motion = vertex.and_then(|vertex| way::motion_mut(&mut editor.document.scene, vertex.target));
    let keyframes =
        motion.filter(|motion| motion.path == MotionPath::Keyframes).map(|motion| &mut motion.keyframes);
    let chosen = keyframes.zip(vertex).and_then(|(all, vertex)| all.get_mut(vertex.index));
    let is_chosen = chosen.is_some();
    let (mut other, tip) = (Easing::Linear, "How the way to the next keyframe is gone");
    let easing = chosen.map_or(&mut other, |keyframe| &mut keyframe.easing);
    ui.add_enabled_ui(is_chosen, |ui| {
        for &choice in Easing::VARIANTS {
            let label = ui.selectable_label(is_chosen && *easing == choice, choice.into_str());
            if label.on_hover_text(tip).on_disabled_hover_text("Choose a keyframe").clicked() {
                *easing = choice;
            }
        }
    });
}

/// The motion that receives keyframes: that of the selected target, of the scene, or the first with keyframes.
fn keyed(editor: &Editor) -> Option<Option<usize>> {
    let scene = editor.scene();
    let is_keyed = |target: &Option<usize>| {
        way::motion_of(scene, *target).is_some_and(|motion| motion.path == MotionPath::Keyframes)
    };
    let chosen = editor.selection.iter().map(|&index| Some(index));
    let all = (0..scene.targets.len()).map(Some);
    chosen.chain([None]).chain(all).find(is_keyed)
}

/// A row of the timeline.
struct Lane {
    target: Option<usize>,
    name: String,
    rounds: u64,
    keyframes: Vec<Keyframe>,
}

impl Lane {
    fn of(group: &Group<'_>) -> Self {
        let name = group.target.map_or("All targets".to_owned(), |target| format!("Target {}", target + 1));
        let is_keyed = group.motion.path == MotionPath::Keyframes;
        let keyframes = if is_keyed { group.motion.keyframes.clone() } else { Vec::new() };
        Self { target: group.target, name, rounds: group.rounds, keyframes }
    }
}

fn lanes(editor: &mut Editor, ui: &mut Ui, played: Played) {
    let clock = played.clock();
    let lanes: Vec<_> = match played {
        Played::Motion(_) => {
            motion::cycle(editor.scene()).iter().flat_map(|cycle| &cycle.groups).map(Lane::of).collect()
        }
        Played::Waves(_) => Vec::new(),
    };
    let width = ui.available_width();
    let (rect, response) = ui.allocate_exact_size(vec2(width, RULER), Sense::click_and_drag());
    let bar = Rect::from_min_max(rect.min + vec2(NAMES, 0.0), rect.max - vec2(HALF, 0.0));
    response.widget_info(|| WidgetInfo::labeled(egui::Role::Slider, true, "Playhead"));
    ruler(ui, bar, clock);
    scrub(editor, &response, bar, played);
    if let (Played::Waves(_), Some(index)) = (played, editor.playback.moment.playing(editor.view.quantity)) {
        let x = bar.left() + bar.width() * index as f32 / clock.frames.max(1) as f32;
        playhead(ui.painter(), x, bar);
    }
    let most = if ui.ctx().content_rect().height() < LOW { 1.0 } else { MOST_LANES };
    let scroll = ScrollArea::vertical().max_height(LANE * most).id_salt("lanes");
    scroll.show(ui, |ui| {
        ui.spacing_mut().item_spacing.y = 0.0;
        for lane in &lanes {
            show_lane(editor, ui, lane, played);
        }
    });
}

/// Times of the cycle in ms.
fn ruler(ui: &Ui, bar: Rect, clock: Clock) {
    let (painter, ink) = (ui.painter(), ui.visuals().text_color());
    let cycle = 1e3 / clock.rate;
    let step = round_step(cycle * TICK / f64::from(bar.width().max(1.0)));
    let digits = (-step.log10().floor()).clamp(0.0, 6.0) as usize;
    let stroke = Stroke::new(1.0, ui.visuals().weak_text_color());
    painter.hline(bar.x_range(), bar.bottom() - 1.0, stroke);
    for i in 0..=(cycle / step).floor() as usize {
        let time = step * i as f64;
        let at = pos2(bar.left() + bar.width() * (time / cycle) as f32, bar.bottom() - 1.0);
        painter.line_segment([at, at - vec2(0.0, 5.0)], stroke);
        let unit = if i == 0 { " ms" } else { "" };
        let (align, text) = (Align2::LEFT_TOP, format!("{time:.digits$}{unit}"));
        if at.x + 30.0 < bar.right() {
            painter.text(pos2(at.x + 3.0, bar.top()), align, text, FontId::proportional(11.0), ink);
        }
    }
}

/// Shows the moment under the pointer.
fn scrub(editor: &mut Editor, response: &Response, bar: Rect, played: Played) {
    let is_held = response.is_pointer_button_down_on() || response.clicked();
    if let Some(at) = response.interact_pointer_pos().filter(|_| is_held) {
        let part = f64::from((at.x - bar.left()) / bar.width().max(1.0)).clamp(0.0, 1.0);
        show_part(editor, part, played);
    }
}

fn show_lane(editor: &mut Editor, ui: &mut Ui, lane: &Lane, played: Played) {
    let clock = played.clock();
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), LANE), Sense::click_and_drag());
    let bar = Rect::from_min_max(rect.min + vec2(NAMES, 1.0), rect.max - vec2(HALF, 1.0));
    let ink = ui.visuals().text_color();
    let name = pos2(rect.left(), rect.center().y);
    ui.painter().text(name, Align2::LEFT_CENTER, &lane.name, FontId::proportional(12.0), ink);
    ui.painter().rect_filled(bar, 3.0, ui.visuals().faint_bg_color);
    scrub(editor, &response, bar, played);
    for (index, keyframe) in lane.keyframes.iter().enumerate() {
        for round in 0..lane.rounds {
            let part = (round as f64 + keyframe.time) / lane.rounds as f64;
            let at = pos2(bar.left() + bar.width() * part as f32, bar.center().y);
            show_keyframe(editor, ui, lane, (index, round), at, (bar, played));
        }
    }
    if let Some(frame) = editor.playback.moment.frame() {
        let x = bar.left() + bar.width() * frame as f32 / clock.frames.max(1) as f32;
        playhead(ui.painter(), x, bar);
    }
}

fn playhead(painter: &Painter, x: f32, bar: Rect) {
    painter.vline(x, bar.expand2(vec2(0.0, 1.0)).y_range(), Stroke::new(2.0, theme::CHOSEN));
}

/// A keyframe that can be chosen, dragged in time and deleted.
fn show_keyframe(
    editor: &mut Editor,
    ui: &Ui,
    lane: &Lane,
    (index, round): (usize, u64),
    at: egui::Pos2,
    (bar, played): (Rect, Played),
) {
    let clock = played.clock();
    let id = ui.scope_id().with(("keyframe", lane.target, index, round));
    let rect = Rect::from_center_size(at, vec2(HALF, HALF) * 2.4);
    let response =
        ui.interact(rect, id, Sense::click_and_drag()).on_hover_cursor(CursorIcon::ResizeHorizontal);
    response.widget_info(|| {
        WidgetInfo::labeled(egui::Role::Button, true, format!("{} keyframe {}", lane.name, index + 1))
    });
    let vertex = Vertex { target: lane.target, index };
    let is_chosen = editor.vertex == Some(vertex);
    path_marks::diamond(ui.painter(), at, HALF, if is_chosen { theme::CHOSEN } else { theme::MARK });
    let Keyframe { time, pressure, angle, easing, .. } = lane.keyframes[index];
    if response.is_pointer_button_down_on() || response.clicked() {
        editor.vertex = Some(vertex);
    }
    if response.clicked() {
        show_part(editor, (round as f64 + time) / lane.rounds as f64, played);
    }
    if response.secondary_clicked() {
        editor.vertex = Some(vertex);
        way::delete(editor);
    } else if let Some(to) = response.interact_pointer_pos().filter(|_| response.dragged()) {
        let part = f64::from((to.x - bar.left()) / bar.width().max(1.0)) * lane.rounds as f64 - round as f64;
        let motion = way::motion_mut(&mut editor.document.scene, lane.target);
        motion.into_iter().for_each(|motion| retime(&mut motion.keyframes, index, part, clock.frames as f64));
    }
    response.on_hover_text(format!(
        "{} ms, pressure x {pressure:.2}, turned by {:.0}°, {} to the next. Drag to change its time; right click deletes.",
        clock.time(time / lane.rounds as f64),
        angle.to_degrees(),
        easing.into_str()
    ));
}

/// Moves a keyframe to the frame nearest to a part of the repetition, between its neighbours.
fn retime(keyframes: &mut [Keyframe], index: usize, part: f64, frames: f64) {
    let step = 1.0 / frames.clamp(1.0, MOST_STEPS);
    let least = index.checked_sub(1).map_or(0.0, |before| keyframes[before].time + step);
    let most = keyframes.get(index + 1).map_or(1.0, |next| next.time) - step;
    let time = (part / step).round() * step;
    if least <= most
        && let Some(keyframe) = keyframes.get_mut(index)
    {
        keyframe.time = time.clamp(least, most);
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn a_keyframe_stays_between_its_neighbours() {
        let times = |all: &[Keyframe]| all.iter().map(|keyframe| keyframe.time).collect::<Vec<_>>();
        let mut all: Vec<_> = [0.0, 0.5, 0.75].map(|time| Keyframe::new(time, DVec3::ZERO)).to_vec();
        for (index, part, wanted) in [
            (1, 0.26, [0.0, 0.25, 0.75]),
            (1, 0.9, [0.0, 0.625, 0.75]),
            (1, -1.0, [0.0, 0.125, 0.75]),
            (2, 3.0, [0.0, 0.125, 0.875]),
            (0, 0.1, [0.0, 0.125, 0.875]),
        ] {
            retime(&mut all, index, part, 8.0);
            assert_eq!(times(&all), wanted);
        }
    }
}
