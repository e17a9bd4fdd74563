//! The window without a display: pointer and keys as input, and the state of editor, solver and field as output.

#![cfg(feature = "window")]
#![expect(clippy::unwrap_used, reason = "a test's helper may panic")]

mod bead;
mod beam;
#[cfg(unix)]
mod board;
mod bodies;
mod brush;
mod canvas;
mod compare;
mod course;
#[path = "../dice/mod.rs"]
#[expect(dead_code, reason = "used by other test binaries")]
mod dice;
#[cfg(target_os = "linux")]
mod display;
mod edits;
mod elements;
mod felt;
mod figure;
mod files;
mod gpu;
mod measure;
mod motion;
#[cfg(all(unix, feature = "cli"))]
mod parity;
mod quantities;
mod reach;
#[path = "../requirement/mod.rs"]
mod requirement;
mod robust;
#[cfg(target_os = "linux")]
#[path = "../running/mod.rs"]
#[expect(dead_code, reason = "no window is ended by a signal")]
mod running;
mod serving;
mod shape;
mod shell;
mod space;
mod spread;
mod view;

use std::path::Path;
use std::time::{Duration, Instant};

use egui::{Event, Key, Modifiers, Pos2, Rect, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use glam::{DVec2, DVec3};
use sonoglyph::app::Window;
use sonoglyph::field::{Evaluator, Quantity};
use sonoglyph::scene::{Method, Scene, Shape, file};
use sonoglyph::ui::document::Document;
use sonoglyph::ui::tool::Tool;
use sonoglyph::ui::view::Lens;
use sonoglyph::ui::{Command, Dialog, Purpose};
use strum::VariantArray;

type Screen = Harness<'static, Window>;

/// Upper limit of every wait, for slow machines.
const PATIENCE: Duration = Duration::from_secs(300);

/// The window on the word HIT.
fn window_by(ctx: &egui::Context, method: Method) -> Window {
    let mut scene =
        file::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/scenes/hit.toml")).unwrap();
    scene.solver.method = method;
    Window::new(ctx, Document::new(scene, "hit"), Evaluator::Cpu)
}

/// Solved by the fastest method: most tests do not look at the drive.
fn window(ctx: &egui::Context) -> Window {
    window_by(ctx, Method::Naive)
}

fn open() -> Screen {
    show(0.25, window)
}

fn open_best() -> Screen {
    show(0.25, |ctx| window_by(ctx, Method::Best))
}

/// With a time step (s) between layouts.
fn show(step: f32, window: fn(&egui::Context) -> Window) -> Screen {
    let mut screen = Harness::builder()
        .with_size(vec2(1280.0, 800.0))
        .with_step_dt(step)
        .build_eframe(|context| window(&context.egui_ctx));
    rest(&mut screen);
    screen
}

/// Runs the frames that the window asks for, until no work is pending: background work must wake the window.
fn rest(screen: &mut Screen) {
    let start = Instant::now();
    settle(screen);
    while screen.state().is_busy() {
        while !screen.ctx.has_requested_repaint() {
            assert!(
                start.elapsed() < PATIENCE,
                "a background task does not end, or does not wake the window"
            );
            std::thread::sleep(Duration::from_millis(1));
        }
        settle(screen);
    }
}

/// A frame per event, and those that the window asks for at once; an animation has a few, and so has a result.
fn settle(screen: &mut Screen) {
    screen.step();
    let mut frames = 0;
    while frames < 3 && screen.output().viewport_output[&egui::ViewportId::ROOT].repaint_delay.is_zero() {
        let was_busy = screen.state().is_busy();
        screen.step();
        let is_result = was_busy && !screen.state().is_busy();
        frames = if is_result { 0 } else { frames + 1 };
    }
}

/// Turns the wheel to zoom in at a place.
fn turn_wheel(screen: &mut Screen, at: Pos2) {
    screen.hover_at(at);
    screen.step();
    let (unit, source) = (egui::MouseWheelUnit::Point, egui::MouseWheelSource::Wheel);
    let (delta, phase) = (vec2(0.0, 120.0), egui::TouchPhase::Move);
    screen.event(Event::MouseWheel { unit, delta, modifiers: Modifiers::NONE, phase, source });
    for _ in 0..30 {
        screen.step();
    }
    rest(screen);
}

/// Drags from one place to another without releasing the button.
fn drag_and_hold(screen: &mut Screen, from: Pos2, to: Pos2) {
    screen.hover_at(from);
    screen.step();
    screen.drag_at(from);
    screen.step();
    screen.hover_at(to);
    rest(screen);
}

/// The button of a page of the panel on the right, if it is open; a quantity may have the same name.
fn page<'a>(screen: &'a Screen, name: &'a str) -> Option<egui_kittest::Node<'a>> {
    screen.query_all_by_label(name).max_by(|a, b| a.rect().left().total_cmp(&b.rect().left()))
}

/// Chooses an entry of a list.
fn pick(screen: &mut Screen, name: &str, entry: &str) {
    screen.get_by_role_and_label(egui::accesskit::Role::ComboBox, name).click();
    rest(screen);
    screen.get_by_label(entry).click();
    rest(screen);
}

fn scene(screen: &Screen) -> &Scene {
    &screen.state().editor().document.scene
}

fn lens(screen: &Screen) -> Lens {
    let map = screen.state().shown().map.as_ref().expect("the window has a map");
    Lens { rect: map.rect, window: map.window }
}

/// The screen position of mm on the plane.
fn at(screen: &Screen, x: f64, y: f64) -> Pos2 {
    lens(screen).screen(DVec2::new(x, y) * 1e-3)
}

fn drag(screen: &mut Screen, from: Pos2, to: Pos2) {
    screen.hover_at(from);
    screen.step();
    screen.drag_at(from);
    screen.step();
    for part in [0.3, 0.7, 1.0] {
        screen.hover_at(from + (to - from) * part);
        screen.step();
    }
    screen.drop_at(to);
    rest(screen);
}

fn click(screen: &mut Screen, place: Pos2) {
    screen.hover_at(place);
    screen.step();
    screen.drag_at(place);
    screen.step();
    screen.drop_at(place);
    rest(screen);
}

/// Shows the depression shaded, and chooses from the menu of exports.
fn export_shaded(screen: &mut Screen, item: &str) {
    key(screen, Key::Num4);
    for label in ["Shaded", "Export", item] {
        screen.get_by_label(label).click();
        rest(screen);
    }
}

fn press(screen: &mut Screen, modifiers: Modifiers, key: Key) {
    screen.key_press_modifiers(modifiers, key);
    rest(screen);
}

fn key(screen: &mut Screen, key: Key) {
    press(screen, Modifiers::NONE, key);
}

fn letters(screen: &mut Screen, text: &str) {
    for letter in text.chars() {
        screen.event(Event::Text(letter.to_string()));
        rest(screen);
    }
}

fn clear(screen: &mut Screen) {
    press(screen, Modifiers::COMMAND, Key::A);
    key(screen, Key::Delete);
    assert!(scene(screen).targets.is_empty());
}

/// RMS pressure (Pa) of the map at a place in mm.
fn rms(screen: &mut Screen, x: f64, y: f64) -> f32 {
    let place = at(screen, x, y) - lens(screen).rect.min;
    let size = lens(screen).rect.size();
    let (shape, values) = screen.state_mut().numbers().unwrap();
    let (height, width) = (shape[0] as f32, shape[1] as f32);
    let (column, row) = (place.x / size.x * width, (1.0 - place.y / size.y) * height);
    values[row as usize * width as usize + column as usize]
}

#[test]
fn the_first_scene_is_solved_and_drawn() {
    let screen = open();
    let shown = screen.state().shown();
    assert!(shown.problem.is_none() && shown.solution.is_some());
    let map = shown.map.as_ref().unwrap();
    assert!(map.largest > 100.0 && map.error < 1e-3, "{map:?}");
    assert!(!screen.state().editor().document.is_unsaved());
}

#[test]
fn the_sound_follows_a_drawn_and_moved_point() {
    let mut screen = open();
    clear(&mut screen);
    assert!(screen.state().shown().map.is_none(), "no target");
    key(&mut screen, Key::P);
    let place = screen.get_by_label("Canvas: the field on the plane").rect().center();
    click(&mut screen, place);
    assert_eq!(scene(&screen).targets.len(), 1);
    let Shape::Point { at: first } = scene(&screen).targets[0].shape else { panic!("no point") };
    assert!(first.distance(DVec3::new(0.0, 0.0, 0.1)) < 1e-3, "{first}");
    let loud = rms(&mut screen, 0.0, 0.0);
    let silent = rms(&mut screen, 40.0, 30.0);
    assert!(loud > 10.0 * silent, "{loud} {silent}");

    key(&mut screen, Key::V);
    let (from, to) = (at(&screen, first.x * 1e3, first.y * 1e3), at(&screen, 40.0, 30.0));
    drag(&mut screen, from, to);
    let Shape::Point { at: moved } = scene(&screen).targets[0].shape else { panic!("no point") };
    assert!(moved.distance(DVec3::new(0.04, 0.03, 0.1)) < 1e-3, "{moved}");
    let (loud, silent) = (rms(&mut screen, 40.0, 30.0), rms(&mut screen, 0.0, 0.0));
    assert!(loud > 10.0 * silent, "{loud} {silent}");

    press(&mut screen, Modifiers::COMMAND, Key::Z);
    let Shape::Point { at: back } = scene(&screen).targets[0].shape else { panic!("no point") };
    assert_eq!(back, first, "a drag is one undo step");
    press(&mut screen, Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    let Shape::Point { at: again } = scene(&screen).targets[0].shape else { panic!("no point") };
    assert_eq!(again, moved);
}

#[test]
fn escape_cancels_a_gesture() {
    let mut screen = open();
    let before = scene(&screen).clone();
    let canvas = screen.get_by_label("Canvas: the field on the plane").rect();
    key(&mut screen, Key::R);
    screen.hover_at(canvas.center());
    screen.step();
    screen.drag_at(canvas.center());
    screen.step();
    screen.hover_at(canvas.center() + vec2(80.0, 80.0));
    rest(&mut screen);
    assert_eq!(scene(&screen).targets.len(), 2);
    key(&mut screen, Key::Escape);
    assert_eq!(*scene(&screen), before);
    screen.drop_at(canvas.center());
    rest(&mut screen);
    assert_eq!(*scene(&screen), before);
    assert!(!screen.state().editor().document.can_undo());
}

#[test]
fn every_shape_is_drawn_with_its_tool() {
    let mut screen = open();
    clear(&mut screen);
    let canvas = screen.get_by_label("Canvas: the field on the plane").rect();
    for (tool, kind) in [
        (Tool::Line, "Line"),
        (Tool::Circle, "Circle"),
        (Tool::Rectangle, "Rectangle"),
        (Tool::Triangle, "Triangle"),
        (Tool::Polygon, "Polygon"),
        (Tool::Freehand, "Path"),
    ] {
        key(&mut screen, tool.key());
        let from = canvas.center();
        drag(&mut screen, from, from + vec2(90.0, 60.0));
        assert_eq!(scene(&screen).targets.len(), 1, "{tool:?}");
        let shape = format!("{:?}", scene(&screen).targets[0].shape);
        assert!(shape.starts_with(kind), "{tool:?}: {shape}");
        assert!(screen.state().shown().problem.is_none(), "{:?}", screen.state().shown().problem);
        key(&mut screen, Key::E);
        let on_outline = screen.state().shown().sound.as_ref().unwrap().foci[0].position;
        let place = at(&screen, on_outline.x * 1e3, on_outline.y * 1e3);
        click(&mut screen, place);
        assert_eq!(scene(&screen).targets.len(), 0, "{tool:?} is erased");
    }
}

#[test]
fn text_is_typed_on_the_canvas_as_one_undo_step() {
    let mut screen = open();
    clear(&mut screen);
    key(&mut screen, Key::T);
    let place = screen.get_by_label("Canvas: the field on the plane").rect().center();
    click(&mut screen, place);
    letters(&mut screen, "HI木T");
    key(&mut screen, Key::Backspace);
    letters(&mut screen, "T");
    key(&mut screen, Key::Enter);
    let text = |screen: &Screen| match &scene(screen).targets[..] {
        [target] => match &target.shape {
            Shape::Text { text, .. } => text.clone(),
            shape => panic!("{shape:?}"),
        },
        targets => panic!("{targets:?}"),
    };
    assert_eq!(text(&screen), "HIT", "missing glyphs are left out, and letters are not shortcuts");
    assert!(screen.state().shown().sound.as_ref().unwrap().foci.len() > 20);
    press(&mut screen, Modifiers::COMMAND, Key::Z);
    assert!(scene(&screen).targets.is_empty());
    press(&mut screen, Modifiers::COMMAND, Key::Y);
    assert_eq!(text(&screen), "HIT");
}

#[test]
fn a_rubber_band_selects_targets_which_move_and_are_deleted() {
    let mut screen = open();
    clear(&mut screen);
    let canvas = screen.get_by_label("Canvas: the field on the plane").rect();
    key(&mut screen, Key::P);
    for offset in [vec2(-60.0, 0.0), vec2(60.0, 0.0), vec2(0.0, 200.0)] {
        click(&mut screen, canvas.center() + offset);
    }
    key(&mut screen, Key::V);
    drag(&mut screen, canvas.center() - vec2(100.0, 40.0), canvas.center() + vec2(100.0, 40.0));
    assert_eq!(screen.state().editor().selection.len(), 2);
    let before = scene(&screen).clone();
    key(&mut screen, Key::ArrowRight);
    let x = |scene: &Scene, index: usize| match scene.targets[index].shape {
        Shape::Point { at } => at.x,
        _ => panic!("no point"),
    };
    assert!((x(scene(&screen), 0) - x(&before, 0) - 1e-3).abs() < 1e-12);
    assert_eq!(x(scene(&screen), 2), x(&before, 2));
    press(&mut screen, Modifiers::COMMAND, Key::D);
    assert_eq!(scene(&screen).targets.len(), 5);
    key(&mut screen, Key::Delete);
    assert_eq!(scene(&screen).targets.len(), 3);
}

#[test]
fn a_file_is_saved_and_opened_and_an_invalid_one_changes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mine.toml");
    let mut screen = open();
    key(&mut screen, Key::P);
    let place = screen.get_by_label("Canvas: the field on the plane").rect().center() + vec2(0.0, 150.0);
    click(&mut screen, place);
    press(&mut screen, Modifiers::COMMAND | Modifiers::SHIFT, Key::S);
    answer(&mut screen, Purpose::SaveAs, &path);
    assert!(!screen.state().editor().document.is_unsaved());
    assert_eq!(file::read(&path).unwrap(), *scene(&screen));
    let saved = scene(&screen).clone();

    // Unsaved changes are asked about.
    clear(&mut screen);
    press(&mut screen, Modifiers::COMMAND, Key::N);
    assert_eq!(screen.state().editor().dialog, Some(Dialog::Unsaved(Command::New)));
    screen.get_by_label("Cancel").click();
    rest(&mut screen);
    assert!(screen.state().editor().document.is_unsaved());
    press(&mut screen, Modifiers::COMMAND, Key::O);
    answer(&mut screen, Purpose::Open, &path);
    screen.get_by_label("Don't save").click();
    rest(&mut screen);
    assert_eq!(*scene(&screen), saved);

    let broken = folder.path().join("broken.toml");
    std::fs::write(&broken, "format = 1\n[array]\npitch = nan\n").unwrap();
    press(&mut screen, Modifiers::COMMAND, Key::O);
    answer(&mut screen, Purpose::Open, &broken);
    let problem = screen.get_by_label_contains("broken.toml:3: array.pitch = nan");
    assert!(problem.rect().is_positive(), "the dialog stays, with the reason");
    let typed = screen.state().editor().dialog.clone();
    assert!(matches!(typed, Some(Dialog::Path { text, .. }) if text.ends_with("broken.toml")));
    assert_eq!(*scene(&screen), saved);
    assert!(screen.state().shown().map.is_some());
}

/// Answers a file dialog.
fn answer(screen: &mut Screen, purpose: Purpose, path: &Path) {
    let Some(Dialog::Path { purpose: asked, .. }) = &screen.state().editor().dialog else {
        panic!("no question: {:?}", screen.state().editor().dialog)
    };
    assert_eq!(*asked, purpose);
    let text = path.display().to_string();
    screen.state_mut().editor_mut().dialog = Some(Dialog::Path { purpose, text });
    rest(screen);
    let verb = match purpose {
        Purpose::Open | Purpose::Drive | Purpose::Scan | Purpose::ScanDrive => "Open",
        Purpose::Elements
        | Purpose::Wiring
        | Purpose::Import
        | Purpose::Waveform(_)
        | Purpose::Thresholds
        | Purpose::Directivity
        | Purpose::Body(_)
        | Purpose::Path(_) => "Read",
        Purpose::SaveAs | Purpose::Export(_) => "Save",
    };
    screen.get_by_label(verb).click();
    rest(screen);
}

#[test]
fn exports_are_written() {
    let folder = tempfile::tempdir().unwrap();
    let mut screen = open();
    for (name, item) in [
        ("map.png", "View as PNG…"),
        ("sheet.png", "Sheet as PNG…"),
        ("map.npy", "Map data (NPY)…"),
        ("drive.csv", "Phases and amplitudes (CSV)…"),
    ] {
        screen.get_by_label("Export").click();
        rest(&mut screen);
        screen.get_by_label(item).click();
        rest(&mut screen);
        let Some(Dialog::Path { purpose, .. }) = screen.state().editor().dialog.clone() else {
            panic!("{item}")
        };
        let path = folder.path().join(name);
        let text = path.display().to_string();
        screen.state_mut().editor_mut().dialog = Some(Dialog::Path { purpose, text });
        key(&mut screen, Key::Enter);
        assert!(std::fs::metadata(&path).unwrap().len() > 1000, "{name}");
    }
    let picture = image::open(folder.path().join("map.png")).unwrap();
    let rect = lens(&screen).rect;
    assert_eq!((picture.width(), picture.height()), (rect.width() as u32, rect.height() as u32));
}

#[test]
fn an_idle_window_computes_nothing() {
    let mut screen = open();
    let work = screen.state().work();
    screen.run_steps(5);
    assert_eq!(screen.state().work(), work);
    screen.run();
    assert!(screen.run() <= 2, "an idle window requests no frames");
}

#[test]
fn invalid_planes_and_scenes_keep_the_last_picture_and_give_a_reason() {
    let mut screen = open();
    screen.state_mut().editor_mut().document.scene.targets[0].pressure = 1.0;
    screen.state_mut().editor_mut().view.heights[0] = 0.0;
    rest(&mut screen);
    assert!(screen.state().shown().map.is_some());
    key(&mut screen, Key::Num4);
    assert!(screen.state().shown().problem.as_ref().unwrap().contains("array"));
    let editor = screen.state_mut().editor_mut();
    editor.view.heights[0] = 0.1;
    editor.document.scene.targets[0].shape = Shape::Point { at: DVec3::new(0.0, 0.0, -0.1) };
    rest(&mut screen);
    assert!(screen.state().shown().problem.as_ref().unwrap().contains("behind the array"));
    assert!(screen.state().shown().map.is_some(), "the last picture stays");
    screen.set_size(vec2(200.0, 150.0));
    rest(&mut screen);
}

/// Types into the field with this name.
fn type_in(screen: &mut Screen, name: &str, text: &str) {
    screen.get_by_role_and_label(egui::accesskit::Role::SpinButton, name).focus();
    screen.run_steps(2);
    screen.event(Event::Text(text.to_owned()));
    screen.step();
    key(screen, Key::Enter);
}
