//! Bodies in the window: adding, dragging, turning and deleting them, their figures, and the 3D view.

use sonoglyph::scene::{Body, BodyKind, Target};
use sonoglyph::ui::Export;
use sonoglyph::ui::parts::scattering::Scattered;

use super::*;

const CANVAS: &str = "Canvas: the field on the plane";

/// The window on a point at 10 cm.
fn open_on_point() -> Screen {
    let mut screen = open();
    let editor = screen.state_mut().editor_mut();
    editor.document.scene.targets = vec![Target::new(Shape::Point { at: DVec3::Z * 0.1 })];
    editor.document.settle();
    rest(&mut screen);
    screen
}

/// The same with a body from the menu.
fn open_with(entry: &str) -> Screen {
    let mut screen = open_on_point();
    screen.get_by_label("Bodies").click();
    rest(&mut screen);
    screen.get_by_label("Add body").click();
    rest(&mut screen);
    screen.get_by_label(entry).click();
    rest(&mut screen);
    screen
}

fn body(screen: &Screen) -> &Body {
    &scene(screen).bodies[0]
}

/// Its place on the screen.
fn place(screen: &Screen) -> Pos2 {
    at(screen, body(screen).at.x * 1e3, body(screen).at.y * 1e3)
}

fn figures(screen: &Screen) -> &Scattered {
    screen.state().editor().parts.scattering.exact().expect("the bodies have figures")
}

#[test]
fn a_sphere_is_added_dragged_and_deleted() {
    let mut screen = open_with("Sphere");
    let before = body(&screen).at;
    assert!((before.z - 0.1).abs() < 1e-12 && before.truncate().length() > 0.015, "{before}");
    assert_eq!(screen.state().editor().chosen_body(), Some(0));
    assert!(screen.query_by_label("exact series").is_some());
    let [x, y] = [before.x * 1e3, before.y * 1e3];
    assert!(rms(&mut screen, x, y).is_nan() && rms(&mut screen, x + 15.0, y) > 0.0);

    let (from, to) = (place(&screen), at(&screen, x + 12.0, 31.0));
    drag(&mut screen, from + vec2(5.0, 3.0), to + vec2(5.0, 3.0));
    let there = DVec3::new((x + 12.0) * 1e-3, 0.031, 0.1);
    assert!(body(&screen).at.distance(there) < 5e-4, "{}", body(&screen).at);
    assert!(rms(&mut screen, x + 12.0, 31.0).is_nan() && !rms(&mut screen, x, y).is_nan());
    key(&mut screen, Key::ArrowRight);
    assert!((body(&screen).at.x - there.x - 1e-3).abs() < 5e-4);
    press(&mut screen, Modifiers::COMMAND, Key::Z);
    press(&mut screen, Modifiers::COMMAND, Key::Z);
    assert_eq!(body(&screen).at, before, "a drag is one step");

    press(&mut screen, Modifiers::COMMAND, Key::D);
    assert_eq!(scene(&screen).bodies.len(), 2);
    assert!(screen.state().shown().problem.is_none(), "{:?}", screen.state().shown().problem);
    key(&mut screen, Key::Delete);
    assert_eq!((scene(&screen).bodies.len(), scene(&screen).targets.len()), (1, 1));
    let on_point = at(&screen, 0.0, 0.0);
    click(&mut screen, on_point);
    assert_eq!(screen.state().editor().chosen_body(), None, "a target is selected instead");
}

#[test]
fn numbers_of_a_body_are_typed() {
    let mut screen = open_with("Sphere");
    type_in(&mut screen, "Radius", "5");
    type_in(&mut screen, "Place y", "25");
    assert!((body(&screen).radius - 0.005).abs() < 1e-9 && (body(&screen).at.y - 0.025).abs() < 1e-9);
    type_in(&mut screen, "Reflection", "0,5");
    assert_eq!(body(&screen).coefficient, 0.5);
    pick(&mut screen, "Kind", "Capsule");
    assert_eq!(body(&screen).kind, BodyKind::Capsule);
    type_in(&mut screen, "Length", "4");
    assert!((body(&screen).length - 0.01).abs() < 1e-9, "twice the radius at least");
    rest(&mut screen);
    let error = figures(&screen).errors[0].outside;
    assert!(error > 0.0 && error < 0.2 && figures(&screen).triangles > 50, "{error}");
    assert!(screen.query_by_label_contains("scattered sound within").is_some());
    pick(&mut screen, "Kind", "Mesh");
    assert!(matches!(
        screen.state().editor().dialog,
        Some(Dialog::Path { purpose: Purpose::Body(Some(0)), .. })
    ));
    assert_eq!(body(&screen).kind, BodyKind::Capsule, "until there is a file");
}

#[test]
fn a_capsule_turns_by_its_handle_and_is_drawn_beside_the_plane() {
    let mut screen = open_with("Capsule");
    let before = body(&screen).x_axis;
    assert_eq!(before, DVec3::X);
    let middle = place(&screen);
    // Above the outline.
    let radius = body(&screen).radius / lens(&screen).window.scale;
    let handle = middle - vec2(0.0, radius as f32 + 30.0);
    drag(&mut screen, handle, middle + vec2(200.0, 0.0));
    let after = body(&screen).x_axis;
    assert!(after.distance(DVec3::NEG_Y) < 0.02, "a quarter to the right: {after}");
    assert_eq!(body(&screen).normal, None);

    screen.state_mut().editor_mut().document.scene.bodies[0].at.z = 0.13;
    rest(&mut screen);
    let [x, y] = [body(&screen).at.x * 1e3, body(&screen).at.y * 1e3];
    assert!(!rms(&mut screen, x, y).is_nan());
    let from = place(&screen);
    drag(&mut screen, from, from + vec2(30.0, 0.0));
    assert!(body(&screen).at.x * 1e3 > x + 1.0, "its outline is dragged");
}

#[test]
fn a_mesh_file_becomes_a_body() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("part.obj");
    // mm
    let text = "v 0 0 0\nv 12 0 0\nv 0 12 0\nv 0 0 12\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
    std::fs::write(&path, text).unwrap();
    let mut screen = open_on_point();
    let answer = Dialog::Path { purpose: Purpose::Body(None), text: path.display().to_string() };
    screen.state_mut().editor_mut().dialog = Some(answer);
    rest(&mut screen);
    key(&mut screen, Key::Enter);
    let own = body(&screen);
    assert_eq!((own.kind, own.scale, own.file.as_deref()), (BodyKind::Mesh, 1e-3, path.to_str()));
    assert!(screen.state().shown().problem.is_none(), "{:?}", screen.state().shown().problem);
    let [x, y] = [own.at.x * 1e3, own.at.y * 1e3];
    screen.state_mut().editor_mut().document.scene.bodies[0].at.z -= 0.002;
    rest(&mut screen);
    assert!(rms(&mut screen, x + 2.0, y + 2.0).is_nan() && !rms(&mut screen, x + 9.0, y + 9.0).is_nan());
}

#[test]
fn a_body_is_seen_in_space() {
    let mut screen = open_with("Sphere");
    key(&mut screen, Key::F3);
    rest(&mut screen);
    let picture = screen.state().shown().space.as_ref().expect("the view has a picture");
    assert!(!picture.is_coarse && picture.stage.screen(body(&screen).at).is_some());
    let stage = picture.stage.clone();
    let (before, from) = (body(&screen).at, stage.screen(body(&screen).at).unwrap());
    drag(&mut screen, from, from + vec2(12.0, 5.0));
    let after = body(&screen).at;
    assert!(after.distance(before) > 1e-3 && (after.z - before.z).abs() < 1e-12, "{after}");

    let folder = tempfile::tempdir().unwrap();
    let picture = |screen: &mut Screen, name: &str| {
        let path = folder.path().join(name);
        let (purpose, text) = (Purpose::Export(Export::Map), path.display().to_string());
        screen.state_mut().editor_mut().dialog = Some(Dialog::Path { purpose, text });
        rest(screen);
        key(screen, Key::Enter);
        rest(screen);
        std::fs::read(path).unwrap()
    };
    let with = picture(&mut screen, "with.png");
    screen.state_mut().editor_mut().document.scene.bodies[0].coefficient = 0.2;
    rest(&mut screen);
    assert!(picture(&mut screen, "soft.png") != with, "its pressure is seen");
    screen.state_mut().editor_mut().document.scene.bodies.clear();
    rest(&mut screen);
    assert!(picture(&mut screen, "without.png") != with);
}

#[test]
fn a_map_with_a_body_comes_coarse_then_whole() {
    let mut screen = open_on_point();
    let whole = screen.state().shown().map.as_ref().unwrap().width;
    let body = Body { at: DVec3::new(0.03, 0.0, 0.1), ..Body::default() };
    screen.state_mut().editor_mut().document.scene.bodies = vec![body];
    let mut widths = Vec::new();
    let start = Instant::now();
    while widths.is_empty() || screen.state().is_busy() {
        screen.step();
        widths.push(screen.state().shown().map.as_ref().unwrap().width);
        assert!(start.elapsed() < PATIENCE);
        std::thread::sleep(Duration::from_millis(1));
    }
    assert_eq!(widths.last(), Some(&whole));
    assert!(widths.iter().any(|width| *width < whole / 3), "{widths:?}");
    let canvas = screen.get_by_label(CANVAS).rect().center();
    screen.hover_at(canvas);
    rest(&mut screen);
    assert!(screen.state().shown().map.as_ref().unwrap().numbers.is_some(), "read from the map");
}
