//! Stress: random commands, invalid numbers, and very many targets.

use egui::accesskit::Role;
use egui_kittest::kittest::NodeT;
use sonoglyph::scene::{Listener, MotionPath, Target, check};

use super::*;
use crate::dice::Dice;

/// All visible fields with a number, by name and index among fields of that name.
fn fields(screen: &Screen) -> Vec<(String, usize)> {
    let mut fields: Vec<(String, usize)> = Vec::new();
    for node in screen.root().children_recursive() {
        let node = node.accesskit_node();
        if node.role() == Role::SpinButton && !node.is_disabled() {
            let name = node.label().unwrap_or_default();
            let before = fields.iter().filter(|(own, _)| *own == name).count();
            fields.push((name, before));
        }
    }
    fields
}

fn focus(screen: &mut Screen, (name, place): &(String, usize)) -> bool {
    let Some(node) = screen
        .get_all_by_label(name)
        .filter(|node| node.accesskit_node().role() == Role::SpinButton)
        .nth(*place)
    else {
        return false;
    };
    node.focus();
    screen.run_steps(2);
    true
}

/// Types invalid text and extreme numbers into all fields. The result is a valid scene, or the last picture with a
/// reason, and can be undone.
fn mistype_everywhere(screen: &mut Screen) -> usize {
    let before = scene(screen).clone();
    let fields = fields(screen);
    for field in &fields {
        for text in ["abc", "NaN", "1e300", "-1e300", "1e-300"] {
            if !focus(screen, field) {
                continue;
            }
            screen.event(Event::Text(text.to_owned()));
            screen.step();
            key(screen, Key::Enter);
            let shown = screen.state().shown();
            assert!(shown.map.is_some(), "{field:?} = {text}: no picture");
            let is_scene = check::check(scene(screen));
            assert!(is_scene.is_ok() || shown.problem.is_some(), "{field:?} = {text}: {is_scene:?}");
            let written = file::write(scene(screen));
            assert!(!written.contains("nan") && !written.contains("inf"), "{field:?} = {text}: {written}");
            let editor = screen.state_mut().editor_mut();
            while editor.document.can_undo() {
                editor.undo();
            }
            assert_eq!(editor.document.scene, before, "{field:?} = {text} cannot be taken back");
            editor.selection = [0].into();
            screen.step();
        }
    }
    fields.len()
}

/// The window on these targets, with a fast method.
fn open_with(targets: Vec<Target>, motion: MotionPath) -> Screen {
    let mut scene = Scene { targets, ..Scene::default() };
    scene.solver.method = Method::Naive;
    scene.motion.path = motion;
    scene.motion.points = vec![DVec3::ZERO, DVec3::X * 0.01];
    scene.modulation.shape = sonoglyph::scene::Envelope::Sine;
    scene.listener = Some(Listener { at: DVec3::new(0.0, -0.3, 0.3) });
    open_on(scene)
}

/// The window on a scene, with fewer elements: some numbers have every pixel of the map evaluated in f64.
fn open_on(mut scene: Scene) -> Screen {
    (scene.array.rows, scene.array.columns) = (4, 4);
    let mut screen = open();
    let editor = screen.state_mut().editor_mut();
    // As if opened from a file: without undo steps.
    editor.replace(Document::new(scene, "test"));
    editor.selection = [0].into();
    screen.set_size(SIZE);
    rest(&mut screen);
    screen
}

/// Wide enough for the panel beside the map.
const SIZE: egui::Vec2 = vec2(880.0, 480.0);
const AT: DVec3 = DVec3::new(0.0, 0.0, 0.1);

#[test]
fn typed_numbers_do_no_harm() {
    let shapes = [
        Shape::Line { from: AT, to: AT + DVec3::X * 0.02 },
        Shape::Rectangle { at: AT, width: 0.02, height: 0.01 },
        Shape::Polygon { at: AT, radius: 0.02, sides: 5 },
        Shape::Text { text: "L".to_owned(), at: AT, height: 0.02 },
    ];
    let mut count = 0;
    for shape in shapes {
        let mut screen = open_with(vec![Target::new(shape)], MotionPath::None);
        count += mistype_everywhere(&mut screen);
    }
    let mut screen = open_with(vec![Target::new(Shape::Point { at: AT })], MotionPath::Points);
    for part in ["Listener", "Array", "Air"] {
        screen.get_by_label(part).click();
        rest(&mut screen);
    }
    for panel in ["Scene", "Solver", "Liquid", "Motion", "Felt"] {
        page(&screen, panel).unwrap().click();
        rest(&mut screen);
        count += mistype_everywhere(&mut screen);
    }
    assert!(count > 45, "{count} fields");
}

#[test]
fn hundreds_of_targets_stay_editable() {
    let mut screen = open();
    let place = |i: u32| AT + DVec3::new(f64::from(i % 25) - 12.0, f64::from(i / 25) - 10.0, 0.0) * 6e-3;
    let targets: Vec<_> = (0..500).map(|i| Target::new(Shape::Point { at: place(i) })).collect();
    let first = screen.state().shown().map.as_ref().unwrap().largest;
    screen.state_mut().editor_mut().document.scene.targets = targets.clone();
    screen.step();
    assert!(screen.state().is_busy(), "solved in the background");
    assert_eq!(screen.state().shown().map.as_ref().unwrap().largest, first, "the last picture stays");
    let rows = screen.get_all_by_role(Role::CheckBox).count();
    assert!(rows < 30, "only visible rows are drawn: {rows}");
    press(&mut screen, Modifiers::COMMAND, Key::A);
    assert_eq!(screen.state().editor().selection.len(), 500);
    assert_eq!(screen.state().shown().sound.as_ref().unwrap().foci.len(), 500);
    key(&mut screen, Key::Delete);
    assert!(scene(&screen).targets.is_empty());
    press(&mut screen, Modifiers::COMMAND, Key::Z);
    assert_eq!(scene(&screen).targets, targets);
    rest(&mut screen);
    // Beyond the limit of a scene, targets are kept, with the reason.
    press(&mut screen, Modifiers::COMMAND, Key::A);
    for _ in 0..2 {
        press(&mut screen, Modifiers::COMMAND, Key::D);
    }
    assert_eq!(scene(&screen).targets.len(), 1500);
    assert!(screen.state().shown().problem.as_ref().unwrap().contains("a scene may have 1024"));
    assert!(screen.state().shown().map.is_some());
}

#[test]
fn tiny_windows_and_empty_scenes_work() {
    let mut screen = open();
    for size in [vec2(200.0, 150.0), vec2(1.0, 1.0), vec2(3000.0, 60.0), vec2(1280.0, 800.0)] {
        screen.set_size(size);
        rest(&mut screen);
        if size.x >= 200.0 && size.y >= 150.0 {
            let seen = Rect::from_min_size(Pos2::ZERO, size);
            assert!(seen.contains_rect(lens(&screen).rect), "{size}: {:?}", lens(&screen).rect);
        }
        for panel in ["Solver", "Drive", "Liquid", "Motion", "Felt", "Device", "Scene"] {
            if let Some(node) = page(&screen, panel) {
                node.click();
            }
            rest(&mut screen);
        }
    }
    assert!(screen.state().shown().map.is_some());
    clear(&mut screen);
    for quantity in [Key::Num1, Key::Num2, Key::Num3, Key::Num4] {
        key(&mut screen, quantity);
    }
    press(&mut screen, Modifiers::COMMAND, Key::Z);
    rest(&mut screen);
    assert!(screen.state().shown().map.is_some() && screen.state().shown().problem.is_none());
}

fn drag_briskly(screen: &mut Screen, from: Pos2, to: Pos2) {
    screen.hover_at(from);
    screen.step();
    screen.drag_at(from);
    screen.step();
    screen.hover_at(to);
    screen.step();
    screen.drop_at(to);
    screen.step();
}

fn place_in(rect: Rect, dice: &mut Dice) -> Pos2 {
    rect.min + vec2(dice.unit() as f32 * rect.width(), dice.unit() as f32 * rect.height())
}

/// Commands of a default run; `SONOGLYPH_COMMANDS=20000` gives more.
fn commands() -> usize {
    std::env::var("SONOGLYPH_COMMANDS").map_or(250, |count| count.parse().unwrap())
}

#[test]
fn random_commands_do_no_harm_and_can_be_undone() {
    let line = Shape::Line { from: AT, to: AT + DVec3::X * 0.02 };
    let mut screen = open_on(Scene { targets: vec![Target::new(line)], ..Scene::default() });
    let first = scene(&screen).clone();
    let window = Rect::from_min_size(Pos2::ZERO, SIZE);
    let mut dice = Dice::seeded(7);
    for _ in 0..commands() {
        let canvas =
            screen.query_by_label("Canvas: the field on the plane").map_or(window, |node| node.rect());
        match dice.index(12) {
            0..4 => {
                let tool = Tool::VARIANTS[dice.index(Tool::VARIANTS.len())];
                screen.key_press(tool.key());
                screen.step();
                let (from, to) = (place_in(canvas, &mut dice), place_in(canvas, &mut dice));
                drag_briskly(&mut screen, from, to);
            }
            4 => {
                let keys =
                    [Key::Delete, Key::ArrowUp, Key::Enter, Key::Num1, Key::Num2, Key::Num3, Key::M, Key::K];
                screen.key_press(keys[dice.index(keys.len())]);
            }
            5 => {
                let keys = [Key::Z, Key::Y, Key::D, Key::A];
                screen.key_press_modifiers(Modifiers::COMMAND, keys[dice.index(keys.len())]);
            }
            6 => {
                let letters = ["H", "é", "7", "木", " "];
                screen.event(Event::Text(letters[dice.index(letters.len())].to_owned()));
            }
            7 => {
                let labels = [
                    "Scene",
                    "Solver",
                    "Drive",
                    "Liquid",
                    "Motion",
                    "XY",
                    "XZ",
                    "YZ",
                    "Scene plane",
                    "Oblique plane",
                    "Colour scale",
                    "dB",
                    "Lock",
                    "Peak",
                    "Line profile",
                    "Target 1 is played",
                    "Target 2 is played",
                    "Listener",
                    "Exposure at a listener",
                    "Array",
                    "Air",
                    "Closed",
                    "In step",
                    "Add a point after 1",
                    "Remove point 2",
                    "Amplitude modulation",
                    "sine",
                    "Path",
                    "points",
                    "steps",
                    "none",
                    "Stroke",
                    "Count",
                    "Spacing",
                    "Continuous",
                ];
                if let Some(node) = screen.query_all_by_label(labels[dice.index(labels.len())]).next() {
                    node.click();
                }
            }
            // A single selected target has handles; the pointer drags one.
            10 => {
                screen.key_press(Key::V);
                screen.step();
                let count = scene(&screen).targets.len();
                if count > 0 {
                    screen.state_mut().editor_mut().selection = [dice.index(count)].into();
                    screen.step();
                    let index = screen.state().editor().selection.first().copied().unwrap();
                    let target = &scene(&screen).targets[index];
                    let corner = sonoglyph::scene::outline::strokes(target).unwrap_or_default().concat();
                    if let (Some(&corner), Some(map)) = (corner.first(), &screen.state().shown().map) {
                        let from = Lens { rect: map.rect, window: map.window }.screen(map.axes.flat(corner));
                        let to = place_in(canvas, &mut dice);
                        drag_briskly(&mut screen, from, to);
                    }
                }
            }
            11 => {
                let copied = file::write_targets(&scene(&screen).targets);
                let events = [Event::Copy, Event::Cut, Event::Paste(copied), Event::Paste("木".to_owned())];
                screen.event(events[dice.index(events.len())].clone());
            }
            // Anywhere beside the canvas, except the menu, which could leave the window.
            8 => {
                let panel =
                    Rect::from_min_max(Pos2::new(canvas.right(), 70.0), window.max - vec2(10.0, 40.0));
                let (from, to) = (place_in(panel, &mut dice), place_in(panel, &mut dice));
                drag_briskly(&mut screen, from, to);
            }
            _ => {
                let wheel = vec2(0.0, dice.below(400) as f32 - 200.0);
                screen.hover_at(place_in(canvas, &mut dice));
                screen.event(Event::MouseWheel {
                    unit: egui::MouseWheelUnit::Point,
                    delta: wheel,
                    source: egui::MouseWheelSource::Wheel,
                    phase: egui::TouchPhase::Move,
                    modifiers: Modifiers::NONE,
                });
            }
        }
        screen.step();
        // More foci would be slow, and are tested elsewhere.
        let targets = &mut screen.state_mut().editor_mut().document.scene.targets;
        targets.truncate(6);
    }
    screen.state_mut().editor_mut().dialog = None;
    key(&mut screen, Key::Escape);
    key(&mut screen, Key::Escape);
    let last = scene(&screen).clone();
    assert_ne!(last, first);
    let editor = screen.state_mut().editor_mut();
    while editor.document.can_undo() {
        editor.undo();
    }
    assert_eq!(editor.document.scene, first);
    while editor.document.can_redo() {
        editor.redo();
    }
    assert_eq!(editor.document.scene, last);
}
