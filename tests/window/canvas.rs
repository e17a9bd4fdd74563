//! The canvas: measuring, alignment, transformation, and keys.

use egui::PointerButton;
use egui::accesskit::Role;
use sonoglyph::scene::Target;

use super::*;

const AT: DVec3 = DVec3::new(0.0, 0.0, 0.1);
const CANVAS: &str = "Canvas: the field on the plane";

/// The window on these shapes alone.
fn open_with(shapes: &[Shape]) -> Screen {
    let mut screen = open();
    screen.state_mut().editor_mut().document.scene.targets =
        shapes.iter().cloned().map(Target::new).collect();
    rest(&mut screen);
    screen
}

fn point(x: f64, y: f64) -> Shape {
    Shape::Point { at: AT + DVec3::new(x, y, 0.0) }
}

/// mm
fn centres(screen: &Screen) -> Vec<DVec2> {
    let centre = |target: &Target| sonoglyph::scene::outline::centre(&target.shape).truncate() * 1e3;
    scene(screen).targets.iter().map(centre).collect()
}

fn hold(screen: &mut Screen, modifiers: Modifiers) {
    screen.event(Event::ModifiersChanged(modifiers));
    screen.step();
}

fn click_right(screen: &mut Screen, pos: Pos2) {
    screen.hover_at(pos);
    screen.step();
    for pressed in [true, false] {
        let button = PointerButton::Secondary;
        screen.event(Event::PointerButton { pos, button, pressed, modifiers: Modifiers::NONE });
        screen.step();
    }
    rest(screen);
}

fn choose(screen: &mut Screen, item: &str) {
    screen.get_by_role_and_label(Role::Button, item).click();
    rest(screen);
}

#[test]
fn a_line_profile_is_measured_moved_exported_and_removed() {
    let mut screen = open_with(&[point(0.0, 0.0)]);
    key(&mut screen, Key::D);
    let (from, to) = (at(&screen, -30.0, 0.0), at(&screen, 30.0, 0.0));
    drag(&mut screen, from, to);
    assert_eq!(scene(&screen).targets.len(), 1, "no target is drawn");
    assert!(screen.query_by_label("60.0 mm, 0.0°").is_some());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("profile.csv");
    screen.get_by_label("CSV…").click();
    rest(&mut screen);
    let purpose = Purpose::Export(sonoglyph::ui::Export::Profile);
    screen.state_mut().editor_mut().dialog = Some(Dialog::Path { purpose, text: path.display().to_string() });
    key(&mut screen, Key::Enter);
    let text = std::fs::read_to_string(&path).unwrap();
    let rows: Vec<Vec<f64>> = text
        .lines()
        .skip(1)
        .map(|line| line.split(',').map(|number| number.parse().unwrap()).collect())
        .collect();
    assert_eq!((text.lines().next().unwrap(), rows.len()), ("distance,x,y,z,rms", 400));
    let loudest = rows.iter().max_by(|a, b| a[4].total_cmp(&b[4])).unwrap();
    assert!((loudest[0] - 0.03).abs() < 5e-4 && loudest[1].abs() < 5e-4 && loudest[3] == 0.1, "{loudest:?}");

    let (from, to) = (at(&screen, 30.0, 0.0), at(&screen, -30.0, 40.0));
    drag(&mut screen, from, to);
    assert!(screen.query_by_label("40.0 mm, 90.0°").is_some(), "the other end stays");
    key(&mut screen, Key::Escape);
    assert!(!screen.state().editor().view.section, "Escape removes the line");
}

#[test]
fn the_line_profile_follows_the_map_and_starts_in_front_of_the_array() {
    let mut screen = open_with(&[point(0.01, 0.0)]);
    key(&mut screen, Key::X);
    let (plot, map) = (screen.get_by_label("Line profile plot").rect(), lens(&screen).rect);
    assert!((plot.left() - map.left()).abs() < 1e-3 && (plot.right() - map.right()).abs() < 1e-3);
    assert!(plot.top() > map.bottom());
    assert!(screen.query_by_label("−6 dB width").is_some());
    screen.get_by_label("Axial").click();
    rest(&mut screen);
    assert_eq!(screen.state().editor().view.cut, sonoglyph::ui::view::Cut::Xz);
    let profile =
        sonoglyph::ui::section::Profile::of(screen.state().editor(), screen.state().shown()).unwrap();
    let (first, last) = (profile.points[0], profile.points[profile.points.len() - 1]);
    assert!(first.z > 0.003 && first.z < 0.006, "half a wavelength in front of the array: {first}");
    assert!((last.z - 0.2).abs() < 1e-9 && (first.x - 0.01).abs() < 1e-9);
}

#[test]
fn a_freehand_stroke_that_nearly_closes_is_closed() {
    let mut screen = open_with(&[point(0.0, 0.07)]);
    key(&mut screen, Key::F);
    let around = |part: f64| DVec2::from_angle(std::f64::consts::TAU * part) * 25.0;
    let place = |screen: &Screen, part: f64| at(screen, around(part).x, around(part).y);
    for (last, closed) in [(0.985, true), (0.8, false)] {
        let from = place(&screen, 0.0);
        screen.hover_at(from);
        screen.step();
        screen.drag_at(from);
        screen.step();
        for i in 0..=40 {
            let to = place(&screen, last * f64::from(i) / 40.0);
            screen.hover_at(to);
            screen.step();
        }
        let to = place(&screen, last);
        screen.drop_at(to);
        rest(&mut screen);
        let Some(Target { shape: Shape::Path { closed: is_closed, .. }, .. }) = scene(&screen).targets.last()
        else {
            panic!("no path")
        };
        assert_eq!(*is_closed, closed, "{last} of a circle");
    }
}

#[test]
fn alt_drags_a_copy_that_guides_align_unless_ctrl_is_held() {
    let mut screen = open_with(&[point(0.0, 0.0), point(-0.03, 0.02)]);
    let (from, to) = (at(&screen, 0.0, 0.0), at(&screen, 35.0, 19.3));
    hold(&mut screen, Modifiers::ALT);
    drag(&mut screen, from, to);
    hold(&mut screen, Modifiers::NONE);
    let places = centres(&screen);
    assert_eq!(places.len(), 3);
    assert_eq!(places[0], DVec2::ZERO, "the original stays");
    assert!((places[2].y - 20.0).abs() < 1e-9, "in line with the other: {}", places[2]);
    assert!((places[2].x - 35.0).abs() < 0.5);
    let from = at(&screen, places[2].x, places[2].y);
    let to = at(&screen, 30.0, 19.3);
    hold(&mut screen, Modifiers::COMMAND);
    drag(&mut screen, from, to);
    hold(&mut screen, Modifiers::NONE);
    assert!((centres(&screen)[2].y - 19.3).abs() < 0.3, "free: {}", centres(&screen)[2]);
}

#[test]
fn a_selection_is_scaled_at_a_corner_and_rotated_at_its_handle() {
    let mut screen = open_with(&[point(-0.02, -0.01), point(0.02, 0.01)]);
    press(&mut screen, Modifiers::COMMAND, Key::A);
    let corner = at(&screen, 20.0, 10.0) + vec2(14.0, -14.0);
    let twice = corner + (at(&screen, 60.0, 30.0) - at(&screen, 20.0, 10.0));
    drag(&mut screen, corner, twice);
    let places = centres(&screen);
    assert!(places[0].distance(DVec2::new(-20.0, -10.0)) < 1e-9, "the opposite corner stays");
    assert!(places[1].distance(DVec2::new(60.0, 30.0)) < 0.7, "{}", places[1]);
    press(&mut screen, Modifiers::COMMAND, Key::Z);
    assert_eq!(screen.state().editor().selection, [0, 1].into(), "undo keeps the selection");
    press(&mut screen, Modifiers::COMMAND, Key::A);
    let middle = at(&screen, 0.0, 0.0);
    let handle = middle + vec2(0.0, at(&screen, 0.0, 10.0).y - middle.y - 36.0);
    drag(&mut screen, handle, middle + vec2(-60.0, 0.0));
    let places = centres(&screen);
    assert!(places[1].distance(DVec2::new(-10.0, 20.0)) < 0.3, "a quarter to the left: {}", places[1]);
}

#[test]
fn the_right_button_opens_a_menu_for_the_selection() {
    let mut screen = open_with(&[point(-0.02, -0.01), point(0.02, 0.01), point(0.01, 0.03)]);
    let place = at(&screen, 20.0, 10.0);
    click_right(&mut screen, place);
    assert_eq!(screen.state().editor().selection, [1].into());
    choose(&mut screen, "Copy");
    let place = at(&screen, 40.0, -30.0);
    click_right(&mut screen, place);
    choose(&mut screen, "Paste here");
    assert!(centres(&screen)[3].distance(DVec2::new(40.0, -30.0)) < 0.3);
    press(&mut screen, Modifiers::COMMAND, Key::A);
    click_right(&mut screen, place);
    choose(&mut screen, "Align left");
    assert!(centres(&screen).iter().all(|centre| (centre.x + 20.0).abs() < 1e-9));
}

#[test]
fn a_target_is_placed_moved_and_selected_by_keys_alone() {
    let mut screen = open_with(&[]);
    key(&mut screen, Key::P);
    screen.get_by_label(CANVAS).focus();
    rest(&mut screen);
    press(&mut screen, Modifiers::SHIFT, Key::ArrowRight);
    key(&mut screen, Key::ArrowUp);
    press(&mut screen, Modifiers::COMMAND, Key::ArrowUp);
    key(&mut screen, Key::Enter);
    assert!(centres(&screen)[0].distance(DVec2::new(10.0, 1.1)) < 1e-9, "{:?}", centres(&screen));
    press(&mut screen, Modifiers::SHIFT, Key::ArrowLeft);
    key(&mut screen, Key::Space);
    assert_eq!(centres(&screen).len(), 2);
    // Selects the next target in the list, which the arrow keys then move.
    key(&mut screen, Key::Period);
    assert_eq!(screen.state().editor().selection, [0].into());
    press(&mut screen, Modifiers::COMMAND, Key::ArrowDown);
    key(&mut screen, Key::ArrowDown);
    assert!(centres(&screen)[0].distance(DVec2::new(10.0, 0.0)) < 1e-9, "{:?}", centres(&screen));
    press(&mut screen, Modifiers::COMMAND, Key::Z);
    assert_eq!(centres(&screen)[0].y.mul_add(10.0, 0.0).round(), 10.0, "menu shortcuts still work");
    key(&mut screen, Key::T);
    key(&mut screen, Key::Enter);
    letters(&mut screen, "HI");
    key(&mut screen, Key::Enter);
    assert!(matches!(&scene(&screen).targets[2].shape, Shape::Text { text, .. } if text == "HI"));
}

#[test]
fn a_shape_in_drawing_has_its_size_beside_the_pointer() {
    let mut screen = open_with(&[point(0.0, 0.07)]);
    key(&mut screen, Key::C);
    let (from, to) = (at(&screen, 0.0, 0.0), at(&screen, 0.0, 20.0));
    drag_and_hold(&mut screen, from, to);
    let texts: Vec<String> = texts(&screen).into_iter().map(|(text, _)| text).collect();
    assert!(texts.iter().any(|text| text.starts_with("Ø 40.") || text.starts_with("Ø 39.9")), "{texts:?}");
    screen.drop_at(to);
    rest(&mut screen);
}

/// The texts on the screen, with their rectangles.
fn texts(screen: &Screen) -> Vec<(String, Rect)> {
    let text = |shape: &egui::epaint::ClippedShape| match &shape.shape {
        egui::Shape::Text(text) => {
            Some((text.galley.text().to_owned(), text.galley.rect.translate(text.pos.to_vec2())))
        }
        _ => None,
    };
    screen.output().shapes.iter().filter_map(text).collect()
}

#[test]
fn the_read_out_fits_a_narrow_map() {
    let mut screen = open_with(&[point(0.0, 0.0)]);
    screen.set_size(vec2(500.0, 600.0));
    rest(&mut screen);
    let map = lens(&screen).rect;
    assert!(map.width() < 340.0, "{}", map.width());
    screen.hover_at(map.center());
    rest(&mut screen);
    let (_, place) = texts(&screen)
        .into_iter()
        .find(|(text, _)| text.starts_with("x\u{a0}") && text.contains("z\u{a0}"))
        .unwrap();
    assert!(map.contains_rect(place), "{place:?} in {map:?}");
}

#[test]
fn a_target_out_of_reach_gives_a_warning() {
    let mut screen = open_with(&[point(0.0, 0.0)]);
    let warned =
        |screen: &Screen| screen.state().shown().warnings.iter().any(|it| it.starts_with("Target 1 is too"));
    assert!(!warned(&screen));
    screen.state_mut().editor_mut().document.scene.targets[0].shape = Shape::Point { at: DVec3::Z * 5.0 };
    rest(&mut screen);
    assert!(warned(&screen), "{:?}", screen.state().shown().warnings);
}

#[test]
fn a_group_is_selected_moved_copied_named_and_dissolved() {
    let mut screen = open_with(&[point(-0.03, 0.0), point(0.0, 0.0), point(0.04, 0.04)]);
    let groups = |screen: &Screen| -> Vec<String> {
        scene(screen).targets.iter().map(|target| target.group.clone()).collect()
    };
    let (left, far) = (at(&screen, -30.0, 0.0), at(&screen, 40.0, 40.0));
    press(&mut screen, Modifiers::COMMAND, Key::A);
    click(&mut screen, far);
    let (from, to) = (at(&screen, -60.0, -60.0), at(&screen, 20.0, 20.0));
    drag(&mut screen, from, to);
    press(&mut screen, Modifiers::COMMAND, Key::G);
    assert_eq!(groups(&screen), ["Group 1", "Group 1", ""]);

    click(&mut screen, far);
    let to = at(&screen, -30.0, 20.0);
    drag(&mut screen, left, to);
    let moved = scene(&screen).targets.iter().map(|it| sonoglyph::scene::outline::centre(&it.shape).y);
    let moved: Vec<f64> = moved.collect();
    assert!(moved[0] > 0.015 && moved[1] == moved[0] && moved[2] == 0.04, "{moved:?}");

    press(&mut screen, Modifiers::COMMAND, Key::D);
    assert_eq!(groups(&screen), ["Group 1", "Group 1", "", "Group 2", "Group 2"]);
    let field = |screen: &mut Screen, label: &str, text: &str| {
        screen.get_by_role_and_label(Role::TextInput, label).focus();
        rest(screen);
        press(screen, Modifiers::COMMAND, Key::A);
        screen.event(Event::Text(text.to_owned()));
        rest(screen);
        key(screen, Key::Enter);
    };
    field(&mut screen, "Group", "eyes");
    assert_eq!(groups(&screen)[3..], ["eyes", "eyes"]);
    press(&mut screen, Modifiers::COMMAND | Modifiers::SHIFT, Key::G);
    assert_eq!(groups(&screen)[3..], ["", ""]);

    screen.get_by_role_and_label(Role::Button, "3  Point").click();
    rest(&mut screen);
    field(&mut screen, "Name", "ear");
    assert_eq!(scene(&screen).targets[2].name, "ear");
    assert!(screen.query_by_label("3  ear").is_some(), "the list has the name");
}

#[test]
fn the_pen_draws_corners_and_curves_and_closes() {
    let mut screen = open();
    let [a, b, c] = [(-30.0, 0.0), (0.0, 40.0), (30.0, 0.0)].map(|(x, y)| at(&screen, x, y));
    clear(&mut screen);
    key(&mut screen, Key::N);
    let path = |screen: &Screen| match &scene(screen).targets[..] {
        [target] => match &target.shape {
            Shape::Path { vertices, closed } => (vertices.len(), *closed),
            shape => panic!("{shape:?}"),
        },
        targets => panic!("{targets:?}"),
    };
    click(&mut screen, a);
    assert!(scene(&screen).targets.is_empty(), "a knot alone is no path");
    click(&mut screen, b);
    assert_eq!(path(&screen), (2, false), "corners");
    drag(&mut screen, c, c + vec2(0.0, 60.0));
    assert!(path(&screen).0 > 5, "a curve has more vertices");
    key(&mut screen, Key::Backspace);
    assert_eq!(path(&screen), (2, false), "the last knot is taken back");
    drag(&mut screen, c, c + vec2(0.0, 60.0));
    click(&mut screen, a);
    let (vertices, closed) = path(&screen);
    assert!(closed && vertices > 5, "a click on the first knot closes: {vertices}");
    let elsewhere = at(&screen, 0.0, -50.0);
    click(&mut screen, elsewhere);
    assert_eq!(scene(&screen).targets.len(), 1, "the next click begins another path");
    key(&mut screen, Key::Enter);
    press(&mut screen, Modifiers::COMMAND, Key::Z);
    assert!(scene(&screen).targets.is_empty(), "a path is one undo step");
}

#[test]
fn a_drag_inside_the_box_moves_a_text() {
    let text = Shape::Text { text: "HIT".to_owned(), at: AT, height: 0.04 };
    let mut screen = open_with(std::slice::from_ref(&text));
    screen.state_mut().editor_mut().selection = [0].into();
    rest(&mut screen);
    // Between the strokes of the H and the I.
    let beside = at(&screen, -12.0, 12.0);
    click(&mut screen, beside);
    assert!(screen.state().editor().selection.is_empty(), "a click beside the strokes selects nothing");
    screen.state_mut().editor_mut().selection = [0].into();
    rest(&mut screen);
    let to = at(&screen, 8.0, 22.0);
    press_guides_off(&mut screen);
    drag(&mut screen, beside, to);
    let moved = scene(&screen).targets[0].shape.centre();
    assert!(moved.distance(AT + DVec3::new(0.02, 0.01, 0.0)) < 1e-3, "{moved}");
    assert_eq!(screen.state().editor().selection, [0].into());
}

fn press_guides_off(screen: &mut Screen) {
    screen.state_mut().editor_mut().view.guides = false;
    rest(screen);
}
