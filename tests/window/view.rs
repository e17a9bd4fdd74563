//! Views of the map: contours, instantaneous pressure, colour scales, a shaded depression and an oblique plane.

use std::f64::consts::SQRT_2;

use egui::{Key, Modifiers, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use glam::{DVec2, DVec3};
use sonoglyph::app::Window;
use sonoglyph::field::contour::Line;
use sonoglyph::field::{Evaluator, Quantity, Request, Stages, Work};
use sonoglyph::picture::relief::Sight;
use sonoglyph::scene::{MotionPath, Scene, Shape, Target};
use sonoglyph::ui::document::Document;
use sonoglyph::ui::view::{Cut, FreePlane, Lens};
use sonoglyph::ui::{Dialog, Map};

use super::{Screen, lens, rest, scene, type_in};

fn focused(foci: &[DVec3]) -> Scene {
    let target = |&at: &DVec3| Target::new(Shape::Point { at });
    Scene { targets: foci.iter().map(target).collect(), ..Scene::default() }
}

fn open(scene: Scene) -> Screen {
    // A time step that is no simple fraction of a period.
    let harness = Harness::builder().with_size(vec2(1280.0, 800.0)).with_step_dt(0.0171);
    let mut screen = harness.build_eframe(move |context| {
        Window::new(&context.egui_ctx, Document::new(scene, "test"), Evaluator::Cpu)
    });
    rest(&mut screen);
    screen
}

fn click(screen: &mut Screen, label: &str) {
    screen.get_by_label(label).click();
    rest(screen);
}

/// Chooses an item of the colour scale's menu.
fn choose(screen: &mut Screen, label: &str) {
    click(screen, "Colour scale");
    click(screen, label);
    screen.key_press(Key::Escape);
    rest(screen);
    assert!(screen.query_by_label(label).is_none(), "the menu is closed");
}

fn map(screen: &Screen) -> &Map {
    screen.state().shown().map.as_ref().unwrap()
}

fn numbers(screen: &mut Screen) -> Vec<f32> {
    screen.state_mut().numbers().unwrap().1
}

/// m on the plane, from pixels.
fn place(map: &Map, [x, y]: [f32; 2]) -> DVec2 {
    let lens = Lens { rect: map.rect, window: map.window };
    let part = vec2(x / map.width as f32, y / map.height as f32);
    lens.flat(map.rect.left_bottom() + vec2(part.x, -part.y) * map.rect.size())
}

/// Pa RMS by the f64 reference.
fn rms(screen: &Screen, point: DVec3) -> f64 {
    let sound = screen.state().shown().sound.as_ref().unwrap();
    let drive = sound.drive().excitation(&sound.aperture.driven);
    sound.aperture.transfer(&[point]).pressure(&drive)[0].norm() / SQRT_2
}

/// Winding number of a closed line around a place.
fn winding(map: &Map, line: &Line, centre: DVec2) -> i32 {
    let at = |&pixel: &[f32; 2]| place(map, pixel) - centre;
    let turned: f64 = line.windows(2).map(|pair| at(&pair[0]).angle_to(at(&pair[1]))).sum();
    (turned / std::f64::consts::TAU).round() as i32
}

#[test]
fn a_contour_surrounds_the_focus_at_its_level() {
    let focus = DVec3::new(0.02, -0.01, 0.1);
    let mut screen = open(focused(&[focus]));
    assert_eq!(
        (screen.state().work().contours, map(&screen).contours.len()),
        (0, 0),
        "no contours by default"
    );
    choose(&mut screen, "Contours");
    for (level, largest_error) in [(-6.0f64, 0.01), (-3.0, 0.01), (-20.0, 0.03)] {
        screen.state_mut().editor_mut().view.contour_level = level;
        rest(&mut screen);
        let map = map(&screen);
        let wanted = map.largest * 10f64.powf(level / 20.0);
        let round: Vec<_> =
            map.contours.iter().filter(|line| winding(map, line, focus.truncate()) == 1).collect();
        assert_eq!(round.len(), 1, "{level} dB");
        for &pixel in map.contours.iter().flatten().step_by(7) {
            let found = rms(&screen, map.axes.world(place(map, pixel)));
            assert!((found / wanted - 1.0).abs() < largest_error, "{level} dB: {found}, not {wanted}");
        }
    }
    let work = screen.state().work();
    screen.run_steps(5);
    assert_eq!(screen.state().work(), work, "lines are kept");
    for key in [Key::Num3, Key::Num4] {
        screen.key_press_modifiers(Modifiers::NONE, key);
        rest(&mut screen);
        let map = map(&screen);
        let round = map.contours.iter().filter(|line| winding(map, line, focus.truncate()) == 1).count();
        assert_eq!(round, 1, "{:?}", map.quantity);
    }
    choose(&mut screen, "Contours");
    let before = screen.state().work();
    screen.state_mut().editor_mut().document.scene.targets[0].shape = Shape::Point { at: DVec3::Z * 0.1 };
    rest(&mut screen);
    assert_eq!(screen.state().work().since(before).contours, 0, "hidden contours are not computed");
}

#[test]
fn one_convention_holds_for_the_whole_window() {
    let mut screen = open(focused(&[DVec3::new(0.0, 0.0, 0.1)]));
    click(&mut screen, "Solver");
    let mean = |screen: &Screen| {
        let said = |node: &egui_kittest::Node<'_>| {
            let text = node.accesskit_node().value().unwrap_or_default();
            let (number, unit) = text.split_once(' ')?;
            let number: f64 = number.parse().ok()?;
            unit.strip_prefix("kPa ")
                .map(|name| (1e3 * number, name.to_owned()))
                .or_else(|| Some((number, unit.strip_prefix("Pa ")?.to_owned())))
        };
        screen.root().children_recursive().filter_map(|node| said(&node)).collect::<Vec<_>>()
    };
    let rms = mean(&screen);
    assert!(rms.len() >= 2 && rms.iter().all(|(_, name)| name == "RMS"), "{rms:?}");
    click(&mut screen, "Peak");
    let peak = mean(&screen);
    assert_eq!(peak.len(), rms.len());
    for ((peak, name), (rms, _)) in peak.into_iter().zip(rms) {
        assert!(name == "peak" && (peak / rms / SQRT_2 - 1.0).abs() < 1e-3, "{peak} {name}, {rms}");
    }
    choose(&mut screen, "Lock");
    let full = screen.state().editor().view.full.unwrap();
    assert!((full / map(&screen).largest - 1.0).abs() < 1e-9, "the range does not depend on the convention");
}

/// The exported map, row by row from the smallest y.
fn picture(screen: &mut Screen) -> Vec<[u8; 4]> {
    let folder = tempfile::tempdir().unwrap();
    click(screen, "Export");
    click(screen, "View as PNG…");
    let path = folder.path().join("map.png");
    let Some(Dialog::Path { purpose, .. }) = screen.state().editor().dialog.clone() else {
        panic!("no question")
    };
    screen.state_mut().editor_mut().dialog = Some(Dialog::Path { purpose, text: path.display().to_string() });
    screen.key_press(Key::Enter);
    rest(screen);
    let picture = image::open(path).unwrap().to_rgba8();
    picture.rows().rev().flat_map(|row| row.map(|pixel| pixel.0).collect::<Vec<_>>()).collect()
}

#[test]
fn both_ends_of_the_colour_scale_can_be_typed() {
    let mut screen = open(focused(&[DVec3::new(0.0, 0.0, 0.1)]));
    click(&mut screen, "Colour scale");
    type_in(&mut screen, "Smallest value that has a colour", "0,2 kPa");
    type_in(&mut screen, "Largest value that has a colour", "2 * 200 Pa");
    let view = screen.state().editor().view.clone();
    assert_eq!((view.low, view.full), (Some(200.0), Some(400.0)));
    screen.key_press(Key::Escape);
    rest(&mut screen);
    let (values, picture) = (numbers(&mut screen), picture(&mut screen));
    let table = view.table();
    let at = |place: f32| table[place.clamp(0.0, 255.0) as usize];
    let mut between = 0;
    for (value, colour) in values.iter().zip(&picture) {
        let place = 255.0 * (value - 200.0) / 200.0;
        // At a step of the colour table rounding may go either way.
        assert!([place.floor(), place.ceil()].map(at).contains(colour), "{value}: {colour:?}");
        between += usize::from((0.0..255.0).contains(&place));
    }
    assert!(between > 100, "{between}");
    click(&mut screen, "Colour scale");
    type_in(&mut screen, "Largest value that has a colour", "1");
    let full = screen.state().editor().view.full.unwrap();
    assert!((200.0..201.0).contains(&full), "not below the lower end: {full}");
    click(&mut screen, "Lock");
    let view = &screen.state().editor().view;
    assert_eq!((view.low, view.full), (None, None), "both ends follow the map again");
    click(&mut screen, "dB");
    type_in(&mut screen, "Lowest level that has a colour", "-40");
    assert!((screen.state().editor().view.floor - 0.01).abs() < 1e-9);
}

#[test]
fn the_brightness_of_a_phase_follows_its_amplitude_on_both_grounds() {
    let mut screen = open(focused(&[DVec3::new(0.02, 0.0, 0.1)]));
    let values = numbers(&mut screen);
    let largest = values.iter().copied().fold(0.0, f32::max);
    screen.key_press_modifiers(Modifiers::NONE, Key::Num2);
    rest(&mut screen);
    let plain = picture(&mut screen);
    choose(&mut screen, "Follows amplitude");
    assert!(map(&screen).veil.is_some());
    let dark = picture(&mut screen);
    choose(&mut screen, "White background");
    let light = picture(&mut screen);
    for (i, value) in values.iter().enumerate() {
        let part = value / largest;
        for channel in 0..3 {
            let plain = f32::from(plain[i][channel]);
            let near = |colour: [u8; 4], expected: f32| (f32::from(colour[channel]) - expected).abs() < 3.0;
            assert!(near(dark[i], part * plain), "{i}: {:?} {part}", dark[i]);
            assert!(near(light[i], 255.0 + part * (plain - 255.0)), "{i}: {:?} {part}", light[i]);
        }
    }
    choose(&mut screen, "Follows amplitude");
    assert!(map(&screen).veil.is_none());
    assert_eq!(picture(&mut screen), plain);
}

#[test]
fn the_background_of_a_map_is_chosen_not_the_themes() {
    let mut screen = open(focused(&[DVec3::new(0.0, 0.0, 0.1)]));
    let faintest = |screen: &mut Screen| {
        let (values, picture) = (numbers(screen), picture(screen));
        let least = values.iter().zip(picture).min_by(|a, b| a.0.total_cmp(b.0)).unwrap();
        least.1
    };
    assert!(faintest(&mut screen)[0] < 20);
    for name in ["View", "Dark theme"] {
        screen.get_by_label(name).click();
        rest(&mut screen);
    }
    assert_eq!(screen.ctx.theme(), egui::Theme::Light);
    assert!(faintest(&mut screen)[0] < 20, "the light theme keeps the map's colours");
    for name in ["View", "White background"] {
        screen.get_by_label(name).click();
        rest(&mut screen);
    }
    assert!(faintest(&mut screen)[0] > 240);
}

#[test]
fn instantaneous_pressures_have_half_period_symmetry_and_the_shown_rms() {
    let mut screen = open(focused(&[DVec3::new(0.02, 0.0, 0.1), DVec3::new(-0.02, 0.01, 0.1)]));
    let shown_rms = numbers(&mut screen);
    screen.state_mut().editor_mut().oscillation.playing = false;
    screen.key_press_modifiers(Modifiers::NONE, Key::Num5);
    rest(&mut screen);
    assert_eq!(map(&screen).quantity, Quantity::Instantaneous);
    let before = screen.state().work();
    const MOMENTS: u32 = 12;
    let mut squares = vec![0.0f32; shown_rms.len()];
    let mut moments = Vec::new();
    for moment in 0..MOMENTS {
        screen.state_mut().editor_mut().oscillation.part = f64::from(moment) / f64::from(MOMENTS);
        rest(&mut screen);
        let pressures = numbers(&mut screen);
        for (square, p) in squares.iter_mut().zip(&pressures) {
            *square += p * p / MOMENTS as f32;
        }
        moments.push(pressures);
    }
    let picture = u64::from(MOMENTS) - 1;
    let work = screen.state().work().since(before);
    assert_eq!(
        work,
        Work { forming: picture, picture, ..Work::default() },
        "another moment needs only forming and colouring"
    );
    let largest = map(&screen).largest as f32;
    assert!((largest / shown_rms.iter().copied().fold(0.0, f32::max) - SQRT_2 as f32).abs() < 1e-3);
    let half = moments.len() / 2;
    for pixel in 0..shown_rms.len() {
        assert!((moments[0][pixel] + moments[half][pixel]).abs() < 1e-5 * largest, "pixel {pixel}");
        assert!((squares[pixel].sqrt() - shown_rms[pixel]).abs() < 1e-4 * largest, "pixel {pixel}");
    }
}

#[test]
fn oscillation_runs_only_while_shown() {
    let mut screen = open(focused(&[DVec3::Z * 0.1]));
    let part = |screen: &Screen| screen.state().editor().oscillation.part;
    screen.run_steps(10);
    assert_eq!(part(&screen), 0.0, "not shown");
    screen.key_press_modifiers(Modifiers::NONE, Key::Num5);
    screen.run_steps(30);
    let (running, work) = (part(&screen), screen.state().work());
    assert!(running > 0.0);
    screen.run_steps(30);
    assert_ne!(part(&screen), running);
    let since = screen.state().work().since(work);
    assert_eq!(since, Work { forming: since.picture, picture: since.picture, ..Work::default() });
    assert!(since.picture > 10);
    click(&mut screen, "Pause");
    let stopped = part(&screen);
    screen.run_steps(10);
    assert_eq!(part(&screen), stopped);
    assert!(screen.run() <= 2, "a paused oscillation requests no frames");
}

#[test]
fn a_shaded_depression_is_at_the_focus_and_cannot_be_edited() {
    let at = |x: f64| Shape::Point { at: DVec3::new(x, 0.0, 0.1) };
    let mut screen = open(focused(&[DVec3::new(-0.04, 0.0, 0.1)]));
    screen.key_press_modifiers(Modifiers::NONE, Key::Num4);
    rest(&mut screen);
    click(&mut screen, "Shaded");
    let rect = map(&screen).rect;
    // The column that differs most from a level one at the side.
    let roughest = |screen: &mut Screen| {
        rest(screen);
        let picture = screen.state_mut().picture().unwrap();
        assert_eq!((picture.width, picture.height), (rect.width() as usize, rect.height() as usize));
        let apart = |x: usize| {
            (picture.height / 4..picture.height * 3 / 4)
                .map(|y| picture.pixel(x, y)[1].abs_diff(picture.pixel(picture.width / 20, y)[1]))
                .map(u32::from)
                .sum::<u32>()
        };
        let column = (picture.width / 20..picture.width * 19 / 20).max_by_key(|&x| apart(x)).unwrap();
        column as f32 / picture.width as f32
    };
    let left = roughest(&mut screen);
    screen.state_mut().editor_mut().document.scene.targets[0].shape = at(0.04);
    let right = roughest(&mut screen);
    assert!(left < 0.4 && right > 0.6, "{left} {right}");
    assert!(map(&screen).exaggeration.unwrap() >= 1.0);

    let before = screen.state().editor().document.scene.clone();
    screen.hover_at(rect.center());
    screen.step();
    screen.drag_at(rect.center());
    screen.step();
    screen.hover_at(rect.center() + vec2(100.0, 0.0));
    screen.step();
    screen.drop_at(rect.center() + vec2(100.0, 0.0));
    rest(&mut screen);
    assert_eq!(screen.state().editor().document.scene, before);
    // It turns the relief instead; heights are those that are chosen.
    assert_ne!(screen.state().editor().view.relief.sight, Sight::default());
    click(&mut screen, "Front");
    assert_eq!(screen.state().editor().view.relief.sight, Sight::default());
    screen.state_mut().editor_mut().view.relief.exaggeration = Some(7.0);
    rest(&mut screen);
    assert_eq!(map(&screen).exaggeration, Some(7.0));
    // A drag that turns the view can end.
    screen.event(egui::Event::PointerButton {
        pos: rect.center(),
        button: egui::PointerButton::Secondary,
        pressed: true,
        modifiers: Modifiers::NONE,
    });
    screen.step();
    screen.hover_at(rect.center() + vec2(30.0, 0.0));
    screen.step();
    assert!(screen.state().editor().is_in_gesture());
    screen.event(egui::Event::PointerButton {
        pos: rect.center() + vec2(30.0, 0.0),
        button: egui::PointerButton::Secondary,
        pressed: false,
        modifiers: Modifiers::NONE,
    });
    rest(&mut screen);
    assert!(!screen.state().editor().is_in_gesture());
    click(&mut screen, "Flat");
    assert_eq!(map(&screen).exaggeration, None);
}

#[test]
fn an_oblique_plane_shows_a_focus_in_its_place() {
    let plane = FreePlane { centre: DVec3::new(0.01, -0.01, 0.11), tilt: 0.6, turn: 0.4 };
    let on_plane = DVec2::new(-0.012, 0.018);
    let mut screen = open(focused(&[plane.axes().world(on_plane)]));
    click(&mut screen, "Oblique plane");
    screen.state_mut().editor_mut().view.free = plane;
    rest(&mut screen);
    assert_eq!(screen.state().editor().view.cut, Cut::Free);
    let values = numbers(&mut screen);
    let map = map(&screen);
    let loudest = (0..values.len()).max_by(|&a, &b| values[a].total_cmp(&values[b])).unwrap();
    let pixel = [(loudest % map.width) as f32 + 0.5, (loudest / map.width) as f32 + 0.5];
    let found = place(map, pixel);
    assert!(found.distance(on_plane) < 3e-3, "{found}, not {on_plane}");
    let focus = screen.state().shown().sound.as_ref().unwrap().foci[0].position;
    assert!(map.axes.flat(focus).distance(on_plane) < 1e-9 && map.axes.height(focus).abs() < 1e-9);
    let expected = rms(&screen, map.axes.world(found));
    assert!((f64::from(values[loudest]) / expected - 1.0).abs() < 1e-3);
}

#[test]
fn during_the_solution_of_a_motion_the_scene_at_rest_is_shown_with_a_note() {
    let mut scene = focused(&[DVec3::Z * 0.1]);
    (scene.motion.path, scene.motion.frames) = (MotionPath::Circle, 256);
    let mut screen = open(scene);
    assert_eq!(screen.state().shown().pending, None, "a map of the scene at rest is not pending");
    screen.state_mut().editor_mut().view.quantity = Quantity::Depression;
    // Results of this frame's request arrive in the next frame at the earliest.
    screen.step();
    let shown = screen.state().shown();
    assert!(shown.round.is_none() && shown.pending.as_ref().unwrap().contains("scene at rest"));
    rest(&mut screen);
    let shown = screen.state().shown();
    assert!(shown.round.is_some() && shown.pending.is_none());
}

#[test]
fn force_and_volume_do_not_depend_on_the_zoom() {
    let mut screen = open(focused(&[DVec3::new(0.01, 0.0, 0.1)]));
    screen.state_mut().editor_mut().view.quantity = Quantity::Depression;
    rest(&mut screen);
    let figures = |screen: &Screen| {
        let radiation = screen.state().editor().parts.radiation.newest().unwrap().as_ref().unwrap();
        (radiation.pressed.force, radiation.pressed.depression.unwrap().volume)
    };
    let whole = figures(&screen);
    let lens = lens(&screen);
    screen.state_mut().editor_mut().view.window = Some(lens.zoomed(lens.rect.center(), 8.0));
    rest(&mut screen);
    assert_eq!(figures(&screen), whole);
    // As on the command line.
    let scene = scene(&screen).clone();
    let drive = screen.state().shown().sound.as_ref().unwrap().drive().clone();
    let request = Request::new(&scene, vec![drive], Quantity::Depression, (64, 64));
    let pressed = Stages::new(Evaluator::Cpu).pressed(&request).unwrap();
    assert!((pressed.force / whole.0 - 1.0).abs() < 1e-9, "{} {}", pressed.force, whole.0);
    let weight = whole.1 * scene.liquid.density() * scene.liquid.gravity;
    assert!(weight > whole.0 / 2.0, "{weight} N displaced under {} N", whole.0);
}
