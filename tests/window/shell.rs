//! The window around the map: file dialogs, typed numbers, menus, and small windows.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

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
        let mut opened = window(&context.egui_ctx);
        opened.recover(Recovery::at(&there));
        opened
    });
    rest(&mut screen);
    screen
}

#[test]
fn a_recovered_scene_is_offered_until_taken_or_discarded() {
    let folder = tempfile::tempdir().unwrap();
    Recovery::at(folder.path()).unwrap().keep(Some(&Document::new(point(0.02), "mine")), 0.0);
    let left = || Recovery::at(folder.path()).unwrap().found();
    {
        let mut screen = open_after_a_crash(folder.path());
        key(&mut screen, Key::Escape);
        click(&mut screen, Pos2::new(20.0, 700.0));
        assert!(matches!(screen.state().editor().dialog, Some(Dialog::Recovered { .. })));
        assert!(screen.query_by_label_contains("“mine” (1 target) was not saved.").is_some());
    }
    assert_eq!(left(), Some(point(0.02)), "kept if the window is killed with the dialog open");
    {
        let mut screen = open_after_a_crash(folder.path());
        let viewport = screen.input_mut().viewports.entry(egui::ViewportId::ROOT).or_default();
        viewport.events.push(egui::ViewportEvent::Close);
        rest(&mut screen);
    }
    assert_eq!(left(), Some(point(0.02)), "kept if the window is closed");
    {
        let mut screen = open_after_a_crash(folder.path());
        screen.get_by_label("Discard").click();
        rest(&mut screen);
        assert_eq!(screen.state().editor().dialog, None);
    }
    assert_eq!(left(), None);
}

#[test]
fn the_window_closes_without_further_events() {
    let mut screen = open();
    // eframe honours a repaint request only if it is at most one pass old.
    let asked = Arc::new(AtomicU64::new(0));
    let heard = Arc::clone(&asked);
    screen.ctx.set_request_repaint_callback(move |info| {
        heard.fetch_max(info.current_cumulative_pass_nr + 1, Ordering::Relaxed);
    });
    let is_wanted = |screen: &Screen| asked.load(Ordering::Relaxed) >= screen.ctx.cumulative_pass_nr();
    screen.step();
    assert!(!is_wanted(&screen), "an idle window requests no frames");
    let quit = |pressed| Event::Key {
        key: Key::Q,
        physical_key: None,
        pressed,
        repeat: false,
        modifiers: Modifiers::COMMAND,
    };
    screen.input_mut().events.extend([quit(true), quit(false)]);
    screen.step();
    let commands = &screen.output().viewport_output[&egui::ViewportId::ROOT].commands;
    assert!(commands.contains(&egui::ViewportCommand::Close), "{commands:?}");
    assert!(is_wanted(&screen), "the frame that closes the window is requested");
}

/// Opens a file dialog and types a path.
fn type_path(screen: &mut Screen, modifiers: Modifiers, asks: Key, text: &str) {
    press(screen, modifiers, asks);
    press(screen, Modifiers::COMMAND, Key::A);
    screen.event(Event::Text(text.to_owned()));
    rest(screen);
}

#[test]
fn saving_adds_the_ending_and_asks_before_overwriting() {
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
    // Its own file is saved without a question; an export over another file is not.
    type_path(&mut screen, save_as, Key::S, &other.display().to_string());
    key(&mut screen, Key::Enter);
    assert_eq!(screen.state().editor().dialog, None);
    screen.get_by_label("Export").click();
    rest(&mut screen);
    screen.get_by_label("Phases and amplitudes (CSV)…").click();
    rest(&mut screen);
    let drive = folder.path().join("mine.csv");
    std::fs::write(&drive, "precious").unwrap();
    key(&mut screen, Key::Enter);
    assert!(matches!(screen.state().editor().dialog, Some(Dialog::Replace { .. })));
    key(&mut screen, Key::Escape);
    assert_eq!(std::fs::read_to_string(&drive).unwrap(), "precious");
}

#[test]
fn files_are_chosen_by_clicks_and_a_wrong_path_stays_with_the_reason() {
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

/// Types into the pitch field, and gives the resulting number.
fn pitch_of(screen: &mut Screen, text: &str) -> f64 {
    type_in(screen, "Pitch", text);
    scene(screen).array.pitch
}

#[test]
fn numbers_have_units_and_expressions_and_invalid_ones_are_explained() {
    let mut screen = show(0.02, window);
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
    // The message stays for some seconds, and longer under the pointer.
    screen.hover_at(before.center());
    screen.run_steps(2);
    assert!(screen.query_by_label("Set to the largest value here: 200 mm").is_some());
    assert_eq!(
        screen.get_by_role_and_label(Role::SpinButton, "Pitch").rect().right_top(),
        before.right_top()
    );
    screen.hover_at(Pos2::ZERO);
    screen.run_steps(400);
    assert!(screen.query_by_label_contains("largest value").is_none(), "the message disappears");
}

#[test]
fn missing_glyphs_are_named_during_typing() {
    let mut screen = open();
    clear(&mut screen);
    key(&mut screen, Key::T);
    let place = screen.get_by_label("Canvas: the field on the plane").rect().center();
    click(&mut screen, place);
    letters(&mut screen, "HI");
    key(&mut screen, Key::Enter);
    screen.get_by_role_and_label(Role::TextInput, "Text").focus();
    rest(&mut screen);
    letters(&mut screen, "ł");
    assert!(screen.query_by_label("the stroke font has no “ł”").is_some());
    letters(&mut screen, "T");
    assert!(screen.query_by_label("the stroke font has no “ł”").is_none());
}

#[test]
fn commands_are_found_by_name_and_listed_with_their_keys() {
    let mut screen = open();
    press(&mut screen, Modifiers::COMMAND, Key::P);
    screen.event(Event::Text("all sel".to_owned()));
    rest(&mut screen);
    key(&mut screen, Key::Enter);
    assert_eq!(screen.state().editor().dialog, None);
    assert_eq!(screen.state().editor().selection.len(), scene(&screen).targets.len());
    press(&mut screen, Modifiers::COMMAND, Key::P);
    screen.event(Event::Text("viridis nonsense".to_owned()));
    rest(&mut screen);
    assert!(screen.query_by_label("No command matches").is_some());
    key(&mut screen, Key::Escape);
    assert_eq!(screen.state().editor().dialog, None);
    key(&mut screen, Key::F1);
    assert!(screen.query_by_label("Ctrl Shift S").is_some());
    key(&mut screen, Key::Enter);
    assert_eq!(screen.state().editor().dialog, None, "Enter closes a message");
}

#[test]
fn everything_is_reachable_in_a_small_window_and_at_twice_the_scale() {
    // The second size is 1280 x 800 at 200 %.
    for size in [vec2(640.0, 480.0), vec2(640.0, 400.0)] {
        let mut screen = open();
        screen.set_size(size);
        rest(&mut screen);
        let window = Rect::from_min_size(Pos2::ZERO, size);
        let map = lens(&screen).rect;
        assert!(map.width() >= 300.0 && map.height() >= 180.0, "{map:?} of {window:?}");
        for tool in Tool::VARIANTS {
            let rect = screen.get_by_role_and_label(Role::RadioButton, tool.into_str()).rect();
            assert!(window.contains_rect(rect), "{tool:?}: {rect:?}");
        }
        assert!(screen.query_by_label("Targets").is_none());
        key(&mut screen, Key::F9);
        let panel = screen.get_by_label("Device").rect();
        assert!(window.contains_rect(panel), "{panel:?}");
        assert_eq!(lens(&screen).rect, map, "the panel covers the map");
        screen.get_by_label("Solver").click();
        rest(&mut screen);
        screen.get_by_label("Panel").click();
        rest(&mut screen);
        assert!(screen.query_by_label("Solver").is_none());
    }
}

#[test]
fn a_long_text_does_not_widen_the_panel() {
    let mut screen = open();
    let before = screen.state().editor().layout.panel;
    let text = "M".repeat(300);
    let target = Target::new(Shape::Text { text, at: DVec3::new(0.0, 0.0, 0.1), height: 0.01 });
    screen.state_mut().editor_mut().document.scene.targets = vec![target];
    screen.state_mut().editor_mut().selection = [0].into();
    rest(&mut screen);
    assert_eq!(screen.state().editor().layout.panel, before);
    let window = Rect::from_min_size(Pos2::ZERO, vec2(1280.0, 800.0));
    assert!(window.contains_rect(screen.get_by_label("Device").rect()));
}

#[test]
fn the_scale_has_keys_and_bounds() {
    let mut screen = open();
    for _ in 0..6 {
        press(&mut screen, Modifiers::COMMAND, Key::Plus);
    }
    assert_eq!(screen.ctx.zoom_factor(), 2.0);
    press(&mut screen, Modifiers::COMMAND, Key::Num0);
    assert_eq!(screen.ctx.zoom_factor(), 1.0);
}

#[test]
fn presenting_shows_the_map_alone_and_escape_ends_it() {
    let mut screen = open();
    let before = lens(&screen).rect;
    key(&mut screen, Key::F11);
    assert!(screen.query_by_label("File").is_none());
    assert_eq!(screen.ctx.zoom_factor(), 1.5, "texts are enlarged");
    assert!(lens(&screen).rect.area() * 1.5 * 1.5 > 1.2 * before.area());
    key(&mut screen, Key::Escape);
    assert_eq!((lens(&screen).rect, screen.ctx.zoom_factor()), (before, 1.0));
}

#[test]
fn a_scene_goes_through_a_link() {
    let mut screen = open();
    let shared = scene(&screen).clone();
    let link = sonoglyph::studio::link::write(&shared).unwrap();
    clear(&mut screen);
    screen.event(Event::Paste(link.clone()));
    rest(&mut screen);
    assert!(matches!(screen.state().editor().dialog, Some(Dialog::Unsaved(Command::OpenLink(_)))));
    screen.get_by_label("Don't save").click();
    rest(&mut screen);
    assert_eq!(*scene(&screen), shared);
    assert!(screen.state().editor().document.is_unsaved());
    type_path(&mut screen, Modifiers::COMMAND, Key::O, &link[..link.len() - 9]);
    key(&mut screen, Key::Enter);
    assert!(screen.query_by_label_contains("incomplete Sonoglyph link").is_some());
}

#[test]
fn a_cut_is_reported_once() {
    let folder = tempfile::tempdir().unwrap();
    let mut screen = open();
    press(&mut screen, Modifiers::COMMAND | Modifiers::SHIFT, Key::S);
    answer(&mut screen, Purpose::SaveAs, &folder.path().join("long".repeat(40)).with_extension("toml"));
    let told = |screen: &Screen| screen.query_all_by_label_contains("longlonglong").count();
    let before = told(&screen);
    let notice = screen
        .query_all_by_label_contains("longlonglong")
        .max_by(|a, b| a.rect().center().y.total_cmp(&b.rect().center().y));
    let notice = notice.unwrap().rect().center();
    assert!(notice.y > 700.0, "in the status line: {notice}");
    screen.hover_at(notice);
    screen.run_steps(60);
    assert_eq!(told(&screen), before + 1);
}

/// An empty window of this size.
fn sized(width: f32, height: f32, window: fn(&egui::Context) -> Window) -> Screen {
    let mut screen = Harness::builder()
        .with_size(vec2(width, height))
        .with_step_dt(0.25)
        .build_eframe(|context| window(&context.egui_ctx));
    rest(&mut screen);
    screen
}

#[test]
fn no_quantity_or_tool_moves_the_map_at_1024() {
    let mut screen = sized(1024.0, 700.0, window);
    let canvas = |screen: &Screen| screen.get_by_label("Canvas: the field on the plane").rect();
    let before = canvas(&screen);
    for quantity in Quantity::ALL {
        screen.state_mut().editor_mut().view.quantity = quantity;
        rest(&mut screen);
        assert_eq!(canvas(&screen), before, "{quantity:?}");
        let last = screen.query_by_label("Peak").map(|peak| peak.rect().right());
        assert!(last.is_none_or(|right| right <= 1024.0), "{quantity:?}: the row ends at {last:?}");
    }
    screen.state_mut().editor_mut().tool = Tool::Brush;
    rest(&mut screen);
    assert_eq!(canvas(&screen), before, "brush");
}

#[test]
fn a_closed_gallery_stays_closed() {
    let mut screen = open();
    clear(&mut screen);
    assert!(screen.query_by_label("Example: A heart").is_some());
    key(&mut screen, Key::Escape);
    let is_closed = |screen: &Screen| screen.query_by_label("Example: A heart").is_none();
    assert!(is_closed(&screen));
    press(&mut screen, Modifiers::COMMAND, Key::Z);
    press(&mut screen, Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    assert!(scene(&screen).targets.is_empty() && is_closed(&screen), "an undo does not bring it back");
    for name in ["Examples", "All, with pictures…"] {
        screen.get_by_label(name).click();
        rest(&mut screen);
    }
    screen.get_by_label("Example: A heart").click();
    rest(&mut screen);
    let asks = matches!(screen.state().editor().dialog, Some(Dialog::Unsaved(_)));
    assert!(asks, "{:?}, {}", screen.state().editor().dialog, screen.state().editor().document.name());
    screen.get_by_label("Don't save").click();
    rest(&mut screen);
    assert_eq!(screen.state().editor().document.name(), "heart");
}

#[test]
fn the_list_and_the_page_show_a_new_target() {
    let mut screen = open();
    let many = (0..30).map(|i| Shape::Point { at: DVec3::new(f64::from(i) * 1e-3, 0.0, 0.1) });
    screen.state_mut().editor_mut().document.scene.targets = many.map(Target::new).collect();
    rest(&mut screen);
    page(&screen, "Solver").unwrap().click();
    rest(&mut screen);
    key(&mut screen, Key::P);
    let place = screen.get_by_label("Canvas: the field on the plane").rect().center() + vec2(0.0, 150.0);
    click(&mut screen, place);
    assert!(screen.query_by_label_contains("31  Point").is_some(), "its row is in sight");
}

#[test]
fn help_has_a_manual_and_the_version() {
    let mut screen = open();
    for (item, text) in [("Manual…", "Glossary"), ("About Sonoglyph…", env!("CARGO_PKG_VERSION"))] {
        for name in ["Help", item] {
            screen.get_by_label(name).click();
            rest(&mut screen);
        }
        assert!(screen.query_all_by_label_contains(text).next().is_some(), "{item}: {text}");
        key(&mut screen, Key::Escape);
    }
}
