//! What a hand feels: the Felt page with its skin and sliders, maps of levels over the threshold, and the skin over time.

use egui::accesskit::Role;
use sonoglyph::scene::{Envelope, Law, LiquidName, Modulation, Motion, MotionPath, Skin, Target, Tempo};
use sonoglyph::scene::{check, motion};
use sonoglyph::studio::primaries::Primaries;
use sonoglyph::ui::parts::FeltFigures;
use sonoglyph::ui::{Moment, Panel};

use super::*;

/// The window on one point of the default array, with the Felt page.
fn open_on_felt(modulation: Modulation, motion: Motion) -> Screen {
    let mut screen = open();
    let editor = screen.state_mut().editor_mut();
    let targets = vec![Target::new(Shape::Point { at: DVec3::new(0.0, 0.0, 0.1) })];
    let scene = Scene { targets, modulation, motion, ..Scene::default() };
    editor.replace(Document::new(scene, "felt"));
    editor.panel = Panel::Felt;
    // The whole page.
    screen.set_size(vec2(1280.0, 1200.0));
    rest(&mut screen);
    screen
}

fn figures(screen: &Screen) -> FeltFigures {
    screen.state().editor().parts.feeling.newest().cloned().unwrap().unwrap()
}

fn largest(screen: &Screen) -> f64 {
    screen.state().shown().map.as_ref().unwrap().largest
}

#[test]
fn sliders_mix_pressure_flutter_and_vibration() {
    let mut screen = open_on_felt(Modulation::default(), Motion::default());
    let mixed = |screen: &Screen| Primaries::of(scene(screen));
    assert!(figures(&screen).felt.level < 0.0, "steady sound is not felt");
    let steps = |screen: &mut Screen| {
        let mut count = 0;
        while screen.state().editor().document.can_undo() {
            press(screen, Modifiers::COMMAND, Key::Z);
            count += 1;
        }
        count
    };
    let place = screen.get_by_role_and_label(Role::Slider, "Vibration, 150 Hz slider").rect();
    drag(&mut screen, place.left_center() + vec2(5.0, 0.0), place.center());
    let Modulation { shape, law, tones, .. } = &scene(&screen).modulation;
    assert_eq!((*shape, *law, tones.len(), tones[0].frequency), (Envelope::Tones, Law::Power, 1, 150.0));
    assert!((tones[0].depth - 0.5).abs() < 0.03, "{tones:?}");
    let vibration = mixed(&screen).vibration;
    assert!(figures(&screen).felt.vibration > 20.0);
    // Limited by the other tone.
    type_in(&mut screen, "Flutter, 30 Hz", "95");
    assert!((mixed(&screen).flutter + vibration - 1.0).abs() < 1e-9);
    type_in(&mut screen, "Pressure", "50");
    assert!(motion::moves(scene(&screen)) && scene(&screen).motion.size == 0.004);
    check::check(scene(&screen)).unwrap();
    rest(&mut screen);
    assert!(figures(&screen).felt.pressure > -90.0);
    assert_eq!(steps(&mut screen), 3, "a drag is one step");
    assert_eq!(mixed(&screen), Primaries { pressure: 0.0, flutter: 0.0, vibration: 0.0 });
}

#[test]
fn a_map_of_what_is_felt_has_levels_and_contours() {
    let sine = Modulation { shape: Envelope::Sine, ..Modulation::default() };
    let mut screen = open_on_felt(sine, Motion::default());
    screen.get_by_label("Show what is felt").click();
    rest(&mut screen);
    // Of the default array and skin, by a model in numpy.
    assert!((largest(&screen) - 36.5).abs() < 0.5, "{}", largest(&screen));
    assert!((figures(&screen).felt.vibration - 32.0).abs() < 1.0, "{:?}", figures(&screen));
    let count = |screen: &Screen| screen.state().shown().map.as_ref().unwrap().contours.len();
    assert!(count(&screen) >= 3, "at 0, 10 and 20 dB");
    screen.get_by_label("Colour scale").click();
    rest(&mut screen);
    screen.get_by_label("Contours").click();
    rest(&mut screen);
    assert_eq!(count(&screen), 0);
    screen.get_by_role_and_label(Role::Button, "Flutter").click();
    rest(&mut screen);
    assert!(largest(&screen) < 0.0, "200 Hz is no flutter");
    assert!(screen.state().shown().problem.is_none());
    // Beside the button that sends it to a hand, and not to a liquid.
    let on_device = |screen: &mut Screen, liquid: Option<LiquidName>| {
        let editor = screen.state_mut().editor_mut();
        (editor.panel, editor.document.scene.liquid.name) = (Panel::Device, liquid);
        rest(screen);
        screen.state().editor().parts.feeling.newest().is_some()
    };
    assert!(on_device(&mut screen, None) && !on_device(&mut screen, Some(LiquidName::Water)));
}

#[test]
fn a_moving_focus_is_felt_by_all_its_frames() {
    let tempo = Tempo::Speed(8.0);
    let circle = Motion { path: MotionPath::Circle, size: 0.04, tempo, frames: 64, ..Motion::default() };
    let mut screen = open_on_felt(Modulation::default(), circle);
    screen.get_by_label("Show what is felt").click();
    rest(&mut screen);
    // The focus is weaker off the axis than in the model.
    assert!((largest(&screen) - 31.6).abs() < 0.7, "{}", largest(&screen));
    // Also while a frame is displayed.
    screen.state_mut().editor_mut().playback.moment = Moment::Frame(3);
    rest(&mut screen);
    assert!((largest(&screen) - 31.6).abs() < 0.7, "{}", largest(&screen));
    let editor = screen.state_mut().editor_mut();
    (editor.playback.moment, editor.panel) = (Moment::Rest, Panel::Motion);
    editor.document.scene.skin = Some(Skin::default());
    rest(&mut screen);
    screen.get_by_label("Time course and spectrum at a point").click();
    rest(&mut screen);
    let of_skin = |screen: &Screen| {
        let course = screen.state().editor().parts.course.newest().cloned().unwrap().unwrap();
        course.skin.unwrap()
    };
    // The focus circles about its target.
    let (place, off) = (at(&screen, 20.0, 0.0), DVec3::new(0.0, 0.0, 0.15));
    pick(&mut screen, "Place", "pointer");
    screen.hover_at(place);
    rest(&mut screen);
    let curve = of_skin(&screen).unwrap();
    let (low, high) =
        curve.iter().fold((f64::MAX, f64::MIN), |(low, high), [_, u]| (low.min(*u), high.max(*u)));
    assert!((4e-6..8e-6).contains(&(high - low)), "{low} to {high} m");
    screen.state_mut().editor_mut().pointed = Some(off);
    screen.event(Event::PointerGone);
    rest(&mut screen);
    assert!(of_skin(&screen).is_err_and(|why| why.contains("off the scene plane")));
}

#[test]
fn the_skin_is_set_on_its_page_with_thresholds_of_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let mut screen = open_on_felt(Modulation::default(), Motion::default());
    assert_eq!(scene(&screen).skin, None);
    type_in(&mut screen, "Wave speed", "9");
    screen.get_by_label("On bone").click();
    rest(&mut screen);
    pick(&mut screen, "Threshold", "afferents");
    let usual = Skin::default();
    let wanted = Skin { wave_speed: 9.0, depth: Some(0.008), threshold: "afferents".to_owned(), ..usual };
    assert_eq!(scene(&screen).skin, Some(wanted));
    pick(&mut screen, "Threshold", "file");
    let path = folder.path().join("mine.csv");
    std::fs::write(&path, "frequency,displacement\n10,1e-5\n10,1e-6\n").unwrap();
    answer(&mut screen, Purpose::Thresholds, &path);
    rest(&mut screen);
    assert!(
        matches!(&screen.state().editor().dialog, Some(Dialog::Message { text, .. }) if text.contains("mine.csv:3"))
    );
    screen.state_mut().editor_mut().dialog = None;
    std::fs::write(&path, "frequency,displacement\n10,1e-5\n1000,1e-6\n").unwrap();
    rest(&mut screen);
    pick(&mut screen, "Threshold", "file");
    answer(&mut screen, Purpose::Thresholds, &path);
    rest(&mut screen);
    let skin = scene(&screen).skin.clone().unwrap();
    assert!((skin.threshold_at(100.0) - 1e-5 / 10f64.sqrt()).abs() < 1e-12 && skin.depth.is_some());
    screen.get_by_label("Skin on the plane").click();
    rest(&mut screen);
    assert_eq!(scene(&screen).skin, None);
}
