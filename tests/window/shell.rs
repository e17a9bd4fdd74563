//! What stands around the map: questions for files, numbers that are typed, menus, and small windows.

use egui::accesskit::Role;
use sonoglyph::app::recovery::Recovery;
use sonoglyph::scene::Target;

use super::*;

fn point(y: f64) -> Scene {
    let at = DVec3::new(0.0, y, 0.1);
    Scene { targets: vec![Target::new(Shape::Point { at })], ..Scene::default() }
}

fn open_after_a_crash(folder: &Path) -> Screen {
    let there = folder.to_owned();
    let mut screen = Harness::builder().with_size(vec2(1280.0, 800.0)).build_eframe(move |context| {
        let mut window = Window::with_example(&context.egui_ctx);
        window.recover(Recovery::at(&there));
        window
    });
    rest(&mut screen);
    screen
}

#[test]
fn what_a_crash_left_is_offered_until_it_is_taken_or_discarded() {
    let folder = tempfile::tempdir().unwrap();
    Recovery::at(folder.path()).unwrap().keep(Some(&point(0.02)), 0.0);
    let left = || Recovery::at(folder.path()).unwrap().found();
    {
        let mut screen = open_after_a_crash(folder.path());
        key(&mut screen, Key::Escape);
        click(&mut screen, Pos2::new(20.0, 700.0));
        assert!(matches!(screen.state().editor().dialog, Some(Dialog::Recovered(_))));
    }
    assert_eq!(left(), Some(point(0.02)), "a window that is killed with the question open keeps it");
    {
        let mut screen = open_after_a_crash(folder.path());
        let viewport = screen.input_mut().viewports.entry(egui::ViewportId::ROOT).or_default();
        viewport.events.push(egui::ViewportEvent::Close);
        rest(&mut screen);
    }
    assert_eq!(left(), Some(point(0.02)), "and so does one that is closed");
    {
        let mut screen = open_after_a_crash(folder.path());
        screen.get_by_label("Discard").click();
        rest(&mut screen);
        assert_eq!(screen.state().editor().dialog, None);
    }
    assert_eq!(left(), None);
}

/// Opens the question for a file and writes the answer into its field.
fn type_path(screen: &mut Screen, modifiers: Modifiers, asks: Key, text: &str) {
    press(screen, modifiers, asks);
    press(screen, Modifiers::COMMAND, Key::A);
    screen.event(Event::Text(text.to_owned()));
    rest(screen);
}

#[test]
fn saving_adds_the_ending_and_asks_before_it_writes_over_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let mut screen = open();
    let save_as = Modifiers::COMMAND | Modifiers::SHIFT;
    let name = folder.path().join("mine").display().to_string();
    let other = folder.path().join("mine.toml");
    std::fs::write(&other, "precious").unwrap();
    type_path(&mut screen, save_as, Key::S, &name);
    key(&mut screen, Key::Enter);
    assert!(matches!(screen.state().editor().dialog, Some(Dialog::Replace { .. })));
    screen.get_by_label("Cancel").click();
    rest(&mut screen);
    assert!(matches!(&screen.state().editor().dialog, Some(Dialog::Path { text, .. }) if *text == name));
    assert_eq!(std::fs::read_to_string(&other).unwrap(), "precious");
    screen.get_by_label("Save").click();
    rest(&mut screen);
    key(&mut screen, Key::Enter);
    assert_eq!(screen.state().editor().dialog, None, "Enter replaces");
    assert_eq!(file::read(&other).unwrap(), *scene(&screen));
    assert_eq!(screen.state().editor().document.path(), Some(other.as_path()));
    // Its own file is written without a word, an export over another is not.
    type_path(&mut screen, save_as, Key::S, &other.display().to_string());
    key(&mut screen, Key::Enter);
    assert_eq!(screen.state().editor().dialog, None);
    screen.get_by_label("Export").click();
    rest(&mut screen);
    screen.get_by_label("Drive as CSV…").click();
    rest(&mut screen);
    let drive = folder.path().join("mine.csv");
    std::fs::write(&drive, "precious").unwrap();
    key(&mut screen, Key::Enter);
    assert!(matches!(screen.state().editor().dialog, Some(Dialog::Replace { .. })));
    key(&mut screen, Key::Escape);
    assert_eq!(std::fs::read_to_string(&drive).unwrap(), "precious");
}

#[test]
fn files_are_found_by_clicks_and_a_wrong_path_stays_with_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("inner")).unwrap();
    std::fs::write(folder.path().join("inner").join("a.toml"), file::write(&point(0.03))).unwrap();
    std::fs::write(folder.path().join("inner").join("b.txt"), "").unwrap();
    let mut screen = open();
    type_path(&mut screen, Modifiers::COMMAND, Key::O, "/no/such/a.toml");
    key(&mut screen, Key::Enter);
    assert!(screen.query_by_label("/no/such/a.toml: no such file").is_some());
    type_path(&mut screen, Modifiers::NONE, Key::End, &folder.path().display().to_string());
    key(&mut screen, Key::Enter);
    screen.get_by_label("inner/").click();
    rest(&mut screen);
    assert!(screen.query_by_label("b.txt").is_none(), "only scenes are listed");
    screen.get_by_label("a.toml").click();
    rest(&mut screen);
    screen.get_by_label("Open").click();
    rest(&mut screen);
    assert_eq!(*scene(&screen), point(0.03));
}

/// What is typed into a number's field, and the number that stands there afterwards.
fn pitch_of(screen: &mut Screen, text: &str) -> f64 {
    type_in(screen, "Pitch", text);
    scene(screen).array.pitch
}

#[test]
fn numbers_are_read_as_people_type_them_and_what_is_none_is_explained() {
    let mut screen = open();
    screen.get_by_label("Array").click();
    rest(&mut screen);
    assert!((pitch_of(&mut screen, "12,5") - 0.0125).abs() < 1e-9);
    assert!((pitch_of(&mut screen, "2cm") - 0.02).abs() < 1e-9);
    assert!((pitch_of(&mut screen, "3*7/2") - 0.0105).abs() < 1e-9);
    assert!(screen.query_by_label_contains("is not").is_none());
    assert!((pitch_of(&mut screen, "wide") - 0.0105).abs() < 1e-9, "the old value stays");
    assert!(screen.query_by_label_contains("“wide” is not a number").is_some());
    let before = screen.get_by_role_and_label(Role::SpinButton, "Pitch").rect();
    assert!((pitch_of(&mut screen, "5 m") - 0.2).abs() < 1e-9);
    assert!(screen.query_by_label("Set to the largest value here: 200 mm").is_some());
    assert_eq!(screen.get_by_role_and_label(Role::SpinButton, "Pitch").rect(), before);
    assert!(screen.run() < 400, "it comes to rest");
    assert!(screen.query_by_label_contains("largest value").is_none(), "the word goes by itself");
}

#[test]
fn letters_that_the_font_lacks_are_named_while_they_are_typed() {
    let mut screen = open();
    clear(&mut screen);
    key(&mut screen, Key::T);
    let place = screen.get_by_label("Canvas: the field on the plane").rect().center();
    click(&mut screen, place);
    letters(&mut screen, "HI");
    key(&mut screen, Key::Enter);
    screen.get_by_role_and_label(Role::TextInput, "Text").focus();
    rest(&mut screen);
    letters(&mut screen, "ß");
    assert!(screen.query_by_label("the stroke font has no “ß”").is_some());
    letters(&mut screen, "T");
    assert!(screen.query_by_label("the stroke font has no “ß”").is_none());
}
