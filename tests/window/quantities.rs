//! All quantities by their keys and buttons, and the figures of radiation pressure on a liquid.

use std::f64::consts::{PI, TAU};
use std::process::Command as Program;

use egui_kittest::kittest::NodeT;
use sonoglyph::app::Window;
use sonoglyph::field::Evaluator;
use sonoglyph::scene::{Envelope, Light, Target};
use sonoglyph::studio::probe;
use sonoglyph::ui::document::Document;

use super::*;

const FOCUS: DVec3 = DVec3::new(0.012, -0.008, 0.1);

/// One focus above a small plane, with amplitude modulation.
fn scene_at(height: f64) -> Scene {
    let mut scene = Scene { targets: vec![Target::new(Shape::Point { at: FOCUS })], ..Scene::default() };
    scene.array.strength = 3.0;
    scene.plane.centre.z = height;
    scene.plane.size = DVec2::new(0.08, 0.06);
    (scene.modulation.shape, scene.modulation.frequency) = (Envelope::Sine, 200.0);
    scene
}

fn open(scene: Scene) -> Screen {
    let harness = Harness::builder().with_size(vec2(1440.0, 800.0));
    let mut screen = harness.build_eframe(move |context| {
        let mut window = Window::new(&context.egui_ctx, Document::new(scene, "test"), Evaluator::Cpu);
        window.editor_mut().oscillation.playing = false;
        window
    });
    rest(&mut screen);
    screen
}

/// Asserts that the map on the screen is of this quantity, with the f64 values at single points.
fn shows(screen: &mut Screen, quantity: Quantity) {
    let (_, values) = screen.state_mut().numbers().unwrap();
    let shown = screen.state().shown();
    assert_eq!((shown.problem.as_ref(), shown.pending.as_ref()), (None, None), "{quantity:?}");
    let (map, sound) = (shown.map.as_ref().unwrap(), shown.sound.as_ref().unwrap());
    assert_eq!(map.quantity, quantity);
    assert!(
        map.largest > 0.0 && map.error < quantity.declaration().tolerance(&Scene::default()),
        "{quantity:?}: {map:?}"
    );
    let axes = [map.axes.x, map.axes.y, map.axes.x.cross(map.axes.y)];
    let lens = lens(screen);
    let part = if quantity.declaration().is_slow { scene(screen).modulation.mean_square() } else { 1.0 };
    let place = lens.screen(map.axes.flat(FOCUS)) - lens.rect.min;
    // At the focus and beside it.
    for offset in [vec2(0.0, 0.0), vec2(7.0, 4.0), vec2(-5.0, 12.0)] {
        let column = (place.x + offset.x) / lens.rect.width() * map.width as f32;
        let row = (1.0 - (place.y + offset.y) / lens.rect.height()) * map.height as f32;
        let centre = vec2((column.floor() + 0.5) / map.width as f32, (row.floor() + 0.5) / map.height as f32);
        let centre = lens.rect.left_bottom() + vec2(centre.x, -centre.y) * lens.rect.size();
        let point = map.axes.world(lens.flat(centre));
        let air = (&sound.aperture, &sound.air, &sound.bead, sound.spread);
        let expected = probe::values(air, &sound.drives, (quantity, map.phase), axes, &[point]);
        let value = f64::from(values[row as usize * map.width + column as usize]);
        let (off, largest) = match expected[..] {
            [] => (0.0, 0.0),
            [expected] if quantity == Quantity::Phase => ((value - expected + PI).rem_euclid(TAU) - PI, PI),
            [expected] => (value - part * expected, map.largest),
            _ => panic!("one point has one value: {expected:?}"),
        };
        assert!(off.abs() <= 2e-3 * largest, "{quantity:?} at {point}: off by {off}");
    }
    let deepest = values.iter().copied().fold(f32::MIN, f32::max);
    let liquid = quantity.declaration().of_liquid;
    assert!(!liquid || (f64::from(deepest) / map.largest - 1.0).abs() < 1e-6, "{deepest} {}", map.largest);
}

#[test]
fn every_quantity_has_a_button_and_the_first_nine_a_key() {
    const DIGITS: [Key; 9] =
        [Key::Num1, Key::Num2, Key::Num3, Key::Num4, Key::Num5, Key::Num6, Key::Num7, Key::Num8, Key::Num9];
    let mut screen = open(scene_at(0.1));
    for (digit, quantity) in DIGITS.into_iter().zip(Quantity::ALL) {
        key(&mut screen, digit);
        shows(&mut screen, quantity);
    }
    for (place, quantity) in (1..).zip(Quantity::ALL) {
        let declaration = quantity.declaration();
        button(&screen, declaration.title).hover();
        screen.run_steps(5);
        let help = declaration.help;
        let tip = if place > DIGITS.len() { help.to_owned() } else { format!("{help} ({place})") };
        assert!(screen.query_by_label(&tip).is_some(), "{tip}");
        button(&screen, declaration.title).click();
        rest(&mut screen);
        shows(&mut screen, quantity);
    }
}

/// The button of a quantity; a page of the panel and a channel of the skin may have the same name.
fn button<'a>(screen: &'a Screen, title: &'a str) -> egui_kittest::Node<'a> {
    let all = screen.query_all_by_label(title);
    let first = all.min_by(|a, b| a.rect().left().total_cmp(&b.rect().left()));
    first.unwrap_or_else(|| panic!("no button {title}"))
}

/// The number after a name in the panel.
fn fact(screen: &Screen, name: &str) -> f64 {
    let text = |node: &egui_kittest::Node<'_>| {
        let node = node.accesskit_node();
        node.label().or_else(|| node.value()).unwrap_or_default()
    };
    let texts: Vec<_> = screen.root().children_recursive().map(|node| text(&node)).collect();
    let after = texts.iter().skip_while(|text| *text != name).find(|text| *text != name && !text.is_empty());
    number(after.unwrap_or_else(|| panic!("no {name} in {texts:?}")))
}

fn number(text: &str) -> f64 {
    text.split(' ').next().unwrap().parse().unwrap_or_else(|error| panic!("{text}: {error}"))
}

/// The command line's number after these words for a scene and a quantity; mN or mm³.
fn printed(path: &Path, quantity: &str, before: &str) -> f64 {
    let program = Program::new(env!("CARGO_BIN_EXE_sonoglyph"))
        .args(["render", "scene.toml", "-o", "a.png", "--backend", "cpu", "--quantity", quantity])
        .current_dir(path)
        .output()
        .unwrap();
    let said = String::from_utf8(program.stdout).unwrap();
    let rest = said.split(before).nth(1).unwrap_or_else(|| panic!("{said}"));
    match rest.split([' ', '\n']).nth(1) {
        Some("mN" | "mm³") => number(rest),
        Some("µN") => 1e-3 * number(rest),
        unit => panic!("{unit:?}: {said}"),
    }
}

#[test]
fn force_and_volume_are_those_of_the_scene_on_any_view() {
    let folder = tempfile::tempdir().unwrap();
    let written = scene_at(0.1);
    std::fs::write(folder.path().join("scene.toml"), file::write(&written)).unwrap();
    let volume = printed(folder.path(), "depression", "m, ");
    let force = printed(folder.path(), "radiation", "Pa, ");
    assert!(volume > 10.0 && force > 1.0, "{volume} mm³, {force} mN");

    let mut screen = open(written);
    screen.get_by_label("Liquid").click();
    rest(&mut screen);
    screen.get_by_label("Show the depression").click();
    rest(&mut screen);
    let figures = |screen: &Screen| (fact(screen, "Force"), fact(screen, "Displaced"));
    let (own_force, own_volume) = figures(&screen);
    assert!((own_volume - volume).abs() < 0.11, "{own_volume} mm³, and {volume} is printed");
    assert!((own_force - force).abs() < 0.006, "{own_force} mN, and {force} is printed");
    // Another part of the plane, zoomed in, and another height.
    screen.hover_at(lens(&screen).rect.center());
    let window = lens(&screen).window;
    for _ in 0..5 {
        screen.event(Event::MouseWheel {
            unit: egui::MouseWheelUnit::Line,
            delta: vec2(0.0, 3.0),
            phase: egui::TouchPhase::Move,
            modifiers: Modifiers::NONE,
            source: egui::MouseWheelSource::Wheel,
        });
        rest(&mut screen);
    }
    assert_ne!(lens(&screen).window, window, "it is zoomed");
    assert_eq!(figures(&screen), (own_force, own_volume));
    screen.state_mut().editor_mut().view.heights[0] = 0.13;
    rest(&mut screen);
    assert_eq!(figures(&screen), (own_force, own_volume));
    key(&mut screen, Key::Num3);
    assert!((fact(&screen, "Force") - force).abs() < 0.006, "{} mN", fact(&screen, "Force"));
    // Weaker sound presses less.
    screen.state_mut().editor_mut().document.scene.array.strength = 1.5;
    rest(&mut screen);
    assert!((fact(&screen, "Force") / force - 0.25).abs() < 0.02, "{} mN", fact(&screen, "Force"));
}

#[test]
fn force_on_a_plane_near_the_array_is_that_of_the_whole_plane() {
    let folder = tempfile::tempdir().unwrap();
    let near = scene_at(0.006);
    std::fs::write(folder.path().join("scene.toml"), file::write(&near)).unwrap();
    let force = printed(folder.path(), "radiation", "elements, ");
    let mut screen = open(near);
    screen.get_by_label("Liquid").click();
    key(&mut screen, Key::Num3);
    let own = fact(&screen, "Force");
    assert!((own / force - 1.0).abs() < 0.02, "{own} mN, and {force} is printed");
}

#[test]
fn a_caustic_follows_the_screens_distance() {
    let mut screen = open(scene_at(0.1));
    screen.get_by_label("Liquid").click();
    rest(&mut screen);
    screen.get_by_label("Show the caustic").click();
    rest(&mut screen);
    shows(&mut screen, Quantity::Caustic);
    assert!(screen.query_by_label("Show the caustic").is_none());
    assert!((fact(&screen, "Light on the screen") - 100.0).abs() < 5.0);
    let largest = |screen: &Screen| screen.state().shown().map.as_ref().unwrap().largest;
    let far = largest(&screen);
    // Light on a screen at the surface is not displaced yet.
    screen.state_mut().editor_mut().document.scene.liquid.screen = 1e-5;
    rest(&mut screen);
    shows(&mut screen, Quantity::Caustic);
    let near = largest(&screen);
    assert!(far > 1.2 && near < 1.01, "{far} far away, {near} at the surface");
    screen.state_mut().editor_mut().document.scene.liquid.light = Light::Reflected;
    rest(&mut screen);
    assert_ne!(largest(&screen), near);
}

#[test]
fn the_solver_page_says_where_linear_theory_ends() {
    let mut screen = open(scene_at(0.1));
    assert!(screen.state().editor().parts.harmonic.newest().is_none(), "nobody asked for it");
    screen.get_by_label("Solver").click();
    rest(&mut screen);
    // 0.375 by sums over lattices at 3.4 Pa m.
    let percent = fact(&screen, "Second harmonic");
    assert!((percent / (37.5 * 3.0 / 3.4) - 1.0).abs() < 0.03, "{percent}");
    assert!(screen.query_by_label("Streaming").is_some() && screen.query_by_label("Audible sound").is_none());
    screen.state_mut().editor_mut().document.scene.array.strength = 1.5;
    rest(&mut screen);
    assert!((fact(&screen, "Second harmonic") / percent - 0.5).abs() < 0.03);
}

#[test]
fn method_and_quantity_are_chosen_by_clicks() {
    let mut screen = open_best();
    screen.get_by_label("Solver").click();
    rest(&mut screen);
    let bound = *screen.state().editor().parts.bound.exact().unwrap();
    assert!(screen.state().shown().solution.as_ref().unwrap().certified(bound) > 0.3);
    screen.get_by_label("Compare all methods").scroll_to_me();
    rest(&mut screen);
    screen.get_by_label("Compare all methods").click();
    rest(&mut screen);
    assert_eq!(screen.state().shown().methods.len(), Method::VARIANTS.len());
    let best = screen.state().shown().solution.as_ref().unwrap().quality.min_pressure;
    screen.get_by_label("phase conjugation").scroll_to_me();
    rest(&mut screen);
    screen.get_by_label("phase conjugation").click();
    rest(&mut screen);
    assert_eq!(scene(&screen).solver.method, Method::Naive);
    assert!(screen.state().shown().solution.as_ref().unwrap().quality.min_pressure < best);
    key(&mut screen, Key::Num4);
    let radiation = screen.state().editor().parts.radiation.newest().unwrap().as_ref().unwrap();
    let depression = radiation.pressed.depression.unwrap();
    assert!(depression.deepest > 1e-6 && depression.slope > 0.0);
    assert_eq!(screen.state().shown().map.as_ref().unwrap().quantity, Quantity::Depression);
    for panel in ["Drive", "Liquid", "Motion", "Device", "Scene"] {
        screen.get_by_label(panel).click();
        rest(&mut screen);
    }
}

#[test]
fn a_liquid_on_a_vertical_plane_offers_a_level_one() {
    let mut screen = open(scene_at(0.1));
    key(&mut screen, Key::Num4);
    screen.get_by_label("XZ").click();
    rest(&mut screen);
    let shown = screen.state().shown();
    assert!(shown.map.is_none() && shown.problem.is_none());
    assert!(screen.query_by_label("A liquid surface must be horizontal.").is_some());
    screen.get_by_label("Show XY").click();
    rest(&mut screen);
    shows(&mut screen, Quantity::Depression);
    assert!(screen.query_by_label("Show XY").is_none());
    // There, it is not offered in the first place.
    key(&mut screen, Key::Num1);
    screen.get_by_label("XZ").click();
    rest(&mut screen);
    assert!(button(&screen, "Depression").accesskit_node().is_disabled());
    key(&mut screen, Key::Num4);
    shows(&mut screen, Quantity::Rms);
}

#[test]
fn peak_or_rms_is_offered_where_it_matters() {
    let mut screen = open(scene_at(0.1));
    for quantity in Quantity::ALL {
        screen.state_mut().editor_mut().view.quantity = quantity;
        screen.step();
        let is_offered = screen.query_by_label("Peak").is_some();
        assert_eq!(is_offered, quantity.declaration().is_root, "{quantity:?}");
    }
}
