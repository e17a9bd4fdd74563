//! Motions: paths edited on the canvas, keyframes on the timeline, and the displayed frame.

use egui::accesskit::Role;
use egui::{PointerButton, Pos2};
use glam::DVec2;
use sonoglyph::scene::{Easing, Keyframe, Motion, MotionPath, Target, Tempo, motion};
use sonoglyph::ui::{Moment, Panel};

use super::*;

const AT: DVec3 = DVec3::new(0.0, 0.0, 0.1);

/// The window on a point with this motion, with the Motion panel.
fn open_on(motion: Motion) -> Screen {
    // A step short enough for a double click.
    let mut screen = show(0.02, window);
    let editor = screen.state_mut().editor_mut();
    editor.document.scene.targets = vec![Target::new(Shape::Point { at: AT })];
    editor.document.scene.motion = motion;
    editor.document.settle();
    editor.panel = Panel::Motion;
    rest(&mut screen);
    screen
}

fn keyed() -> Motion {
    let keyframes = [(0.0, 0.0), (0.5, 0.03)].map(|(time, x)| Keyframe::new(time, DVec3::X * x)).to_vec();
    Motion { path: MotionPath::Keyframes, keyframes, frames: 8, ..Motion::default() }
}

fn undo(screen: &mut Screen) {
    press(screen, Modifiers::COMMAND, Key::Z);
}

/// Position on the timeline at a fraction of the cycle.
fn moment(screen: &Screen, part: f32) -> Pos2 {
    let ruler = screen.get_by_label("Playhead").rect();
    let (left, right) = (ruler.left() + 84.0, ruler.right() - 6.0);
    Pos2::new(left + (right - left) * part, ruler.center().y)
}

#[test]
fn a_path_is_resized_and_rotated_in_one_undo_step() {
    for (path, from, to, size, degrees) in [
        (MotionPath::Line, (15.0, 0.0), (0.0, 25.0), 0.05, 90.0),
        (MotionPath::Circle, (15.0, 0.0), (0.0, 25.0), 0.05, 0.0),
        (MotionPath::Square, (15.0, 15.0), (30.0, 30.0), 0.06, 0.0),
    ] {
        let before = Motion { path, frames: 8, ..Motion::default() };
        let mut screen = open_on(before.clone());
        let (from, to) = (at(&screen, from.0, from.1), at(&screen, to.0, to.1));
        drag(&mut screen, from, to);
        let motion = &scene(&screen).motion;
        assert!((motion.size - size).abs() < 1e-3, "{path:?}: {}", motion.size);
        assert!((motion.angle.to_degrees() - degrees).abs() < 1e-9, "{path:?}: {}", motion.angle);
        undo(&mut screen);
        assert_eq!(scene(&screen).motion, before);
    }
}

#[test]
fn vertices_are_moved_added_and_deleted() {
    let points =
        [(0.0, 20.0), (30.0, 20.0), (30.0, -20.0)].map(|(x, y)| DVec3::new(x, y, 0.0) * 1e-3).to_vec();
    let mut screen = open_on(Motion { path: MotionPath::Points, points, frames: 8, ..Motion::default() });
    let (from, to) = (at(&screen, 30.0, -20.0), at(&screen, 10.0, -30.0));
    drag(&mut screen, from, to);
    let place = scene(&screen).motion.points[2];
    assert!(place.distance(DVec3::new(0.01, -0.03, 0.0)) < 5e-4, "{place}");
    key(&mut screen, Key::Delete);
    assert_eq!((scene(&screen).motion.points.len(), scene(&screen).targets.len()), (2, 1));
    undo(&mut screen);
    undo(&mut screen);
    assert_eq!(scene(&screen).motion.points[2], DVec3::new(0.03, -0.02, 0.0));
    let middle = at(&screen, 15.0, 20.0);
    screen.hover_at(middle);
    for _ in 0..2 {
        screen.drag_at(middle);
        screen.step();
        screen.drop_at(middle);
        screen.step();
    }
    rest(&mut screen);
    let points = &scene(&screen).motion.points;
    assert!(points.len() == 4 && points[1].distance(DVec3::new(0.015, 0.02, 0.0)) < 5e-4, "{points:?}");
    assert!(screen.state().editor().view.window.is_none());
}

#[test]
fn the_timeline_shows_the_moment_under_the_pointer() {
    let mut screen = open_on(keyed());
    assert_eq!(screen.state().editor().playback.moment, Moment::Rest);
    let (from, to) = (moment(&screen, 0.1), moment(&screen, 0.26));
    drag(&mut screen, from, to);
    assert_eq!(screen.state().editor().playback.moment, Moment::Frame(2));
    let foci = &screen.state().shown().sound.as_ref().unwrap().foci;
    assert!(foci[0].position.distance(AT + DVec3::X * 0.015) < 1e-12, "{foci:?}");
    assert!(rms(&mut screen, 15.0, 0.0) > 5.0 * rms(&mut screen, -30.0, 20.0));
    screen.get_by_label("At rest").click();
    rest(&mut screen);
    assert_eq!(screen.state().shown().sound.as_ref().unwrap().foci[0].position, AT);
}

#[test]
fn playback_runs_once_or_in_a_loop_and_then_stops() {
    let mut screen = open_on(keyed());
    screen.get_by_label("Loop").click();
    screen.run_steps(2);
    screen.get_by_role_and_label(Role::Button, "Play").click();
    screen.run_steps(300);
    let playback = screen.state().editor().playback;
    assert_eq!(
        (playback.playing, playback.moment),
        (false, Moment::Frame(7)),
        "200 ms at 1/20 end after 4 s"
    );
    assert!(screen.run() <= 2, "an idle window requests no frames");
    screen.get_by_label("Loop").click();
    screen.run_steps(2);
    screen.get_by_role_and_label(Role::Button, "Play").click();
    screen.run_steps(300);
    assert!(screen.state().editor().playback.playing);
    screen.get_by_role_and_label(Role::Button, "Pause").click();
    rest(&mut screen);
    assert!(!screen.state().editor().playback.playing);
}

#[test]
fn keyframes_are_added_moved_eased_and_deleted() {
    let mut screen = open_on(keyed());
    let there = moment(&screen, 0.26);
    click(&mut screen, there);
    screen.get_by_label("Add keyframe").click();
    rest(&mut screen);
    let keyframes = scene(&screen).motion.keyframes.clone();
    assert_eq!(keyframes[1], Keyframe::new(0.25, DVec3::X * 0.015), "a new keyframe keeps the path");
    // The marker at the playhead moves the keyframe.
    let (from, to) = (at(&screen, 15.0, 0.0), at(&screen, 15.0, 25.0));
    drag(&mut screen, from, to);
    let place = scene(&screen).motion.keyframes[1].at;
    assert!(place.distance(DVec3::new(0.015, 0.025, 0.0)) < 5e-4, "{place}");
    let round = screen.state().shown().round.clone().unwrap();
    assert!(round.frames[2].foci[0].position.distance(AT + place) < 1e-12, "the frames follow");
    // Moves it in time, from 1/4 to 3/8.
    let diamond = |screen: &Screen, number: u32| {
        screen.get_by_label(&format!("All targets keyframe {number}")).rect().center()
    };
    let from = diamond(&screen, 2);
    let to = Pos2::new(moment(&screen, 0.38).x, from.y);
    drag(&mut screen, from, to);
    assert_eq!(scene(&screen).motion.keyframes[1].time, 0.375);
    undo(&mut screen);
    assert_eq!(scene(&screen).motion.keyframes[1].time, 0.25, "a drag is one undo step");
    let place = diamond(&screen, 2);
    click(&mut screen, place);
    screen.get_by_role_and_label(Role::Button, "hold").click();
    rest(&mut screen);
    assert_eq!(scene(&screen).motion.keyframes[1].easing, Easing::Hold);
    let place = diamond(&screen, 2);
    screen.hover_at(place);
    screen.step();
    for pressed in [true, false] {
        let (pos, button, modifiers) = (place, PointerButton::Secondary, Modifiers::NONE);
        screen.event(Event::PointerButton { pos, button, pressed, modifiers });
        screen.step();
    }
    rest(&mut screen);
    assert_eq!(scene(&screen).motion.keyframes, keyed().keyframes);
}

#[test]
fn dragging_the_marker_between_keyframes_adds_one() {
    let mut screen = open_on(keyed());
    let there = moment(&screen, 0.26);
    click(&mut screen, there);
    let (from, to) = (at(&screen, 15.0, 0.0), at(&screen, 15.0, -20.0));
    drag(&mut screen, from, to);
    let keyframes = &scene(&screen).motion.keyframes;
    assert!(keyframes.len() == 3 && keyframes[1].time == 0.25, "{keyframes:?}");
    assert!(keyframes[1].at.distance(DVec3::new(0.015, -0.02, 0.0)) < 5e-4);
    undo(&mut screen);
    assert_eq!(scene(&screen).motion, keyed());
}

#[test]
fn a_target_has_keyframes_of_its_own() {
    let mut screen = open_on(Motion::default());
    let editor = screen.state_mut().editor_mut();
    editor.document.scene.targets[0].motion = Some(keyed());
    editor.selection = [0].into();
    rest(&mut screen);
    assert!(screen.query_by_label("Target 1 keyframe 2").is_some());
    let (from, to) = (at(&screen, 30.0, 0.0), at(&screen, 30.0, 20.0));
    drag(&mut screen, from, to);
    let own = scene(&screen).targets[0].motion.clone().unwrap();
    assert!(own.keyframes[1].at.distance(DVec3::new(0.03, 0.02, 0.0)) < 5e-4, "{own:?}");
    assert_eq!(scene(&screen).motion, Motion::default());
    assert_eq!(motion::frames(scene(&screen)).unwrap()[4][0].position, AT + own.keyframes[1].at);
}

#[test]
fn the_frames_of_keyframes_have_their_pressures() {
    let mut motion = keyed();
    motion.keyframes = [(0.0, 1.0), (0.5, 0.5)]
        .map(|(time, pressure)| Keyframe { pressure, ..Keyframe::new(time, DVec3::ZERO) })
        .to_vec();
    let screen = open_on(motion);
    let round = screen.state().shown().round.clone().unwrap();
    let loud: Vec<_> = round.frames.iter().map(|frame| frame.mean_pressure()).collect();
    for (i, part) in [1.0, 0.875, 0.75, 0.625, 0.5, 0.625, 0.75, 0.875].into_iter().enumerate() {
        assert!((loud[i] / loud[0] - part).abs() < 1e-9, "{i}: {loud:?}");
    }
}

#[test]
fn a_response_brings_figures_and_a_lead_beside_speed() {
    let mut screen = open_on(Motion { path: MotionPath::Circle, frames: 10, ..Motion::default() });
    assert!(screen.query_by_label("Pressure kept").is_none());
    screen.state_mut().editor_mut().panel = Panel::Scene;
    rest(&mut screen);
    screen.get_by_label("Array").click();
    rest(&mut screen);
    pick(&mut screen, "Response", "T4010A1");
    screen.state_mut().editor_mut().panel = Panel::Motion;
    rest(&mut screen);
    assert!(screen.query_by_label("Pressure kept").is_some());
    assert!(screen.query_by_label_contains("take more frames").is_some(), "ten frames are few");
    screen.get_by_label("Ahead").click();
    rest(&mut screen);
    assert!(scene(&screen).motion.lead);
}

/// The window on a scene of the gallery, by the fastest method.
fn open_on_example(name: &'static str) -> Screen {
    let mut screen = show(0.02, window);
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/scenes").join(name);
    let mut scene = file::read(&path).unwrap();
    scene.solver.method = Method::Naive;
    screen.state_mut().editor_mut().replace(Document::new(scene, name));
    rest(&mut screen);
    screen
}

#[test]
fn a_scanned_drawing_opens_on_its_mean() {
    let mut screen = open_on_example("heart-and-hit.toml");
    assert_eq!(screen.state().editor().playback.moment, Moment::Mean);
    // On the heart, in the letter I, and between both.
    let part = |screen: &mut Screen| {
        let [heart, letter, empty] = [(0.0, 38.0), (0.0, -30.0), (40.0, 0.0)].map(|(x, y)| rms(screen, x, y));
        [heart / empty, letter / empty]
    };
    let mean = part(&mut screen);
    assert!(mean.iter().all(|part| *part > 3.0), "both are there: {mean:?}");
    let reading = screen.state().shown().sound.as_ref().unwrap().drives.len();
    assert_eq!(reading, 48, "figures are of the mean, too");
    screen.get_by_role_and_label(Role::Button, "At rest").click();
    rest(&mut screen);
    assert_eq!(screen.state().shown().sound.as_ref().unwrap().drives.len(), 1);
    key(&mut screen, Key::Num2);
    screen.get_by_role_and_label(Role::Button, "At rest");
    let editor = screen.state_mut().editor_mut();
    editor.replace(Document::new(Scene::default(), "still"));
    assert_eq!(editor.playback.moment, Moment::Rest);
}

#[test]
fn space_plays_and_pauses_also_in_presentations() {
    let mut screen = open_on(keyed());
    let tap = |screen: &mut Screen| {
        key(screen, Key::Space);
        screen.run_steps(3);
        screen.state().editor().playback.playing
    };
    assert!(tap(&mut screen));
    key(&mut screen, Key::F11);
    assert!(!tap(&mut screen) && tap(&mut screen) && !tap(&mut screen));
    // The space bar held for a drag moves the view.
    let before = screen.state().editor().view.window;
    let (from, to) = (at(&screen, 0.0, 0.0), at(&screen, 20.0, 0.0));
    let space = |pressed| Event::Key {
        key: Key::Space,
        physical_key: None,
        pressed,
        repeat: false,
        modifiers: Modifiers::NONE,
    };
    screen.event(space(true));
    screen.step();
    drag(&mut screen, from, to);
    screen.event(space(false));
    rest(&mut screen);
    assert!(!screen.state().editor().playback.playing);
    assert_ne!(screen.state().editor().view.window, before);
    key(&mut screen, Key::F8);
    assert!(screen.query_by_label("Playhead").is_some(), "the timeline on demand");
}

#[test]
fn waves_of_a_liquid_play_from_the_onset() {
    let mut screen = open_on(Motion::default());
    let editor = screen.state_mut().editor_mut();
    editor.view.quantity = Quantity::Depression;
    editor.document.scene.plane.size = DVec2::splat(0.04);
    rest(&mut screen);
    let deepest = f64::from(screen.state_mut().numbers().unwrap().1.into_iter().fold(0.0, f32::max));
    screen.get_by_label("Waves").click();
    screen.run_steps(2);
    rest(&mut screen);
    assert!(screen.state().editor().playback.playing);
    // Paused at the beginning, a surface is nearly level; later it swings about the one at rest.
    screen.get_by_role_and_label(Role::Button, "Pause").click();
    let surface = |screen: &mut Screen, part: f32| {
        let there = moment(screen, part);
        click(screen, there);
        rest(screen);
        screen.state_mut().numbers().unwrap().1.into_iter().map(f64::from).fold(0.0, f64::max)
    };
    let all: Vec<_> = [0.001, 0.3, 0.6, 0.9].map(|part| surface(&mut screen, part)).to_vec();
    assert!(all[0] < 0.5 * deepest && all[3] > 0.5 * deepest, "{all:?} of {deepest}");
    assert_ne!(all[1], all[2]);
    assert!(screen.run() <= 2, "a paused wave requests no frames");
    // Its light moves likewise, coarsely while it plays.
    let width = |screen: &Screen| screen.state().shown().map.as_ref().unwrap().width;
    let fine = width(&screen);
    screen.state_mut().editor_mut().view.quantity = Quantity::Caustic;
    rest(&mut screen);
    key(&mut screen, Key::Space);
    screen.run_steps(4);
    assert_eq!(width(&screen), fine.div_ceil(2));
    key(&mut screen, Key::Space);
    rest(&mut screen);
    assert_eq!(width(&screen), fine);
    screen.state_mut().editor_mut().view.quantity = Quantity::Depression;
    rest(&mut screen);
    // The pictures are kept while nothing changes.
    assert_eq!(surface(&mut screen, 0.6), all[2]);
    screen.get_by_label("Waves").click();
    rest(&mut screen);
    assert_eq!(screen.state().editor().playback.moment, Moment::Rest);
    press(&mut screen, Modifiers::COMMAND, Key::P);
    letters(&mut screen, "wave");
    assert!(screen.query_by_label_contains("Waves of the liquid").is_some());
}

#[test]
fn a_path_is_chosen_from_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let mut screen = open_on(Motion::default());
    pick(&mut screen, "Path", "file");
    let editor = screen.state().editor();
    assert!(matches!(editor.dialog, Some(Dialog::Path { purpose: Purpose::Path(None), .. })));
    assert_eq!(scene(&screen).motion.path, MotionPath::None, "unchanged until a file is chosen");
    let path = folder.path().join("way.csv");
    std::fs::write(&path, "x,y\n0,0\n0.03,0\n0.03,0.04\n").unwrap();
    answer(&mut screen, Purpose::Path(None), &path);
    rest(&mut screen);
    let moving = scene(&screen);
    assert_eq!((moving.motion.path, moving.motion.file.as_str()), (MotionPath::File, path.to_str().unwrap()));
    let frames = motion::frames(moving).unwrap();
    assert_eq!(frames.len(), 120);
    assert!(frames[70][0].position.distance(DVec3::new(0.03, 0.04, AT.z)) < 1e-9);
    // The window can give what the file left open.
    screen.get_by_label("As in the file").click();
    rest(&mut screen);
    assert_eq!(scene(&screen).motion.tempo, Tempo::Rate(5.0));
    let saved = folder.path().join("a.toml");
    let placed = screen.state().editor().document.placed(&saved);
    let text = screen.state().editor().document.text_of(&placed.scene);
    assert!(text.contains("file = \"way.csv\""), "{text}");
    std::fs::write(&saved, text).unwrap();
    assert_eq!(sonoglyph::studio::opening::open(&saved).unwrap().motion, placed.scene.motion);
}
