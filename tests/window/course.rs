//! Modulation by tones, by power and by a file, and the time course of the pressure at a point.

use egui::accesskit::Role;
use sonoglyph::scene::{Envelope, Law, Listener, Motion, MotionPath, Target};
use sonoglyph::ui::Panel;
use sonoglyph::ui::parts::course::{Course, Place};

use super::*;

/// The window on one point, with the Motion page.
fn open_on_motion() -> Screen {
    let mut screen = open();
    let editor = screen.state_mut().editor_mut();
    editor.document.scene.targets = vec![Target::new(Shape::Point { at: DVec3::new(0.0, 0.0, 0.1) })];
    editor.document.settle();
    editor.panel = Panel::Motion;
    rest(&mut screen);
    screen
}

fn press_button(screen: &mut Screen, name: &str) {
    screen.get_by_role_and_label(Role::Button, name).click();
    rest(screen);
}

fn course(screen: &Screen) -> Course {
    screen.state().editor().parts.course.newest().cloned().unwrap().unwrap()
}

#[test]
fn tones_are_edited_one_by_one_and_never_exceed_full_depth() {
    let mut screen = open_on_motion();
    pick(&mut screen, "Amplitude modulation", "tones");
    pick(&mut screen, "Waveform of", "power");
    let modulation = &scene(&screen).modulation;
    assert_eq!((modulation.shape, modulation.law, modulation.tones.len()), (Envelope::Tones, Law::Power, 2));
    type_in(&mut screen, "Tone 1 frequency", "150");
    type_in(&mut screen, "Tone 1 depth", "30");
    type_in(&mut screen, "Tone 1 phase", "90");
    // Limited, because the other tone has half of the depth.
    type_in(&mut screen, "Tone 2 depth", "95");
    press_button(&mut screen, "Add a tone");
    let tones = &scene(&screen).modulation.tones;
    assert_eq!((tones[0].frequency, tones[0].depth), (150.0, 0.3));
    assert!((tones[0].phase - std::f64::consts::FRAC_PI_2).abs() < 1e-9);
    assert!((tones[1].depth - 0.7).abs() < 1e-12 && tones[2].depth.abs() < 1e-12, "{tones:?}");
    press_button(&mut screen, "Remove tone 2");
    assert_eq!(scene(&screen).modulation.tones.len(), 2);
    sonoglyph::scene::check::check(scene(&screen)).unwrap();
    press(&mut screen, Modifiers::COMMAND, Key::Z);
    assert_eq!(scene(&screen).modulation.tones.len(), 3);
}

#[test]
fn the_time_course_at_a_focus_has_the_spectrum_of_the_modulation() {
    let mut screen = open_on_motion();
    assert_eq!(screen.state().editor().parts.course.newest(), None, "computed on demand");
    pick(&mut screen, "Amplitude modulation", "sine");
    screen.get_by_label("Time course and spectrum at a point").click();
    rest(&mut screen);
    let found = course(&screen);
    let parts: Vec<_> =
        found.lines.iter().map(|line| (line.frequency, line.amplitude / found.mean() * 3.0 / 8.0)).collect();
    let near = |(frequency, part): (f64, f64), expected: (f64, f64)| {
        (frequency - expected.0).abs() < 1e-9 && (part - expected.1).abs() < 1e-6
    };
    let expected = [(0.0, 0.375), (200.0, 0.5), (400.0, 0.125)];
    assert!(parts.len() == 3 && parts.iter().zip(expected).all(|(&a, b)| near(a, b)), "{parts:?}");
    let peak = found.moduli.iter().fold(0.0f64, |most, [_, p]| most.max(*p));
    let focus = screen.state().shown().sound.as_ref().unwrap().readings[0].peak();
    assert!((peak / focus - 1.0).abs() < 1e-9, "{peak} and {focus} Pa");
    assert!(screen.query_by_label_contains("133.3 % at 200 Hz").is_some());

    // A listener, first missing, then present.
    pick(&mut screen, "Place", "listener");
    assert!(screen.query_by_label_contains("There is no listener").is_some());
    let ear = DVec3::new(0.1, -0.3, 0.3);
    screen.state_mut().editor_mut().document.scene.listener = Some(Listener { at: ear });
    rest(&mut screen);
    assert_eq!(course(&screen).at, ear);

    // At the last position of the pointer on the map.
    pick(&mut screen, "Place", "pointer");
    assert_eq!(screen.state().editor().parts.course.form.place, Place::Pointer);
    let place = at(&screen, 20.0, -10.0);
    screen.hover_at(place);
    rest(&mut screen);
    let found = course(&screen).at;
    assert!(found.distance(DVec3::new(0.02, -0.01, 0.1)) < 1e-3, "{found}");
}

#[test]
fn a_moving_focus_has_harmonics_of_its_cycle() {
    let mut screen = open_on_motion();
    let motion = Motion { path: MotionPath::Circle, frames: 16, ..Motion::default() };
    screen.state_mut().editor_mut().document.scene.motion = motion;
    screen.get_by_label("Time course and spectrum at a point").click();
    rest(&mut screen);
    pick(&mut screen, "Place", "pointer");
    let place = at(&screen, 15.0, 0.0);
    screen.hover_at(place);
    rest(&mut screen);
    let found = course(&screen);
    assert!(found.lines.len() > 10, "{}", found.lines.len());
    assert!(
        found.lines.iter().all(|line| (line.frequency / 5.0 - (line.frequency / 5.0).round()).abs() < 1e-9)
    );
    assert!((found.moduli.last().unwrap()[0] - 0.2).abs() < 1e-9, "a cycle");
}

#[test]
fn a_waveform_is_chosen_from_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let mut screen = open_on_motion();
    let before = scene(&screen).modulation.shape;
    pick(&mut screen, "Amplitude modulation", "file");
    let editor = screen.state().editor();
    assert!(matches!(editor.dialog, Some(Dialog::Path { purpose: Purpose::Waveform(None), .. })));
    assert_eq!(scene(&screen).modulation.shape, before, "unchanged until a file is chosen");
    let path = folder.path().join("buzz.wav");
    std::fs::write(&path, "no sound").unwrap();
    answer(&mut screen, Purpose::Waveform(None), &path);
    rest(&mut screen);
    assert!(
        matches!(&screen.state().editor().dialog, Some(Dialog::Message { text, .. }) if text.contains("no WAV file"))
    );
    screen.state_mut().editor_mut().dialog = None;
    let mut bytes =
        b"RIFF\x28\0\0\0WAVEfmt \x10\0\0\0\x01\0\x01\0\xE8\x03\0\0\xD0\x07\0\0\x02\0\x10\0data\x04\0\0\0"
            .to_vec();
    bytes.extend([0u8, 0x40, 0, 0xC0]);
    std::fs::write(&path, bytes).unwrap();
    rest(&mut screen);
    pick(&mut screen, "Amplitude modulation", "file");
    answer(&mut screen, Purpose::Waveform(None), &path);
    rest(&mut screen);
    let modulation = &scene(&screen).modulation;
    assert_eq!((modulation.shape, modulation.file.as_str()), (Envelope::File, path.to_str().unwrap()));
    assert_eq!(modulation.wave.get().unwrap().values, [0.5, -0.5]);
    // Saved beside the waveform, the scene holds only the file name, and can read it again.
    let saved = folder.path().join("a.toml");
    let placed = screen.state().editor().document.placed(&saved);
    let text = screen.state().editor().document.text_of(&placed.scene);
    assert!(text.contains("file = \"buzz.wav\""), "{text}");
    std::fs::write(&saved, text).unwrap();
    assert_eq!(sonoglyph::studio::opening::open(&saved).unwrap().modulation, placed.scene.modulation);
}
