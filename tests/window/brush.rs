//! Pressure painted by hand: strokes, the eraser, undo, and the files of paintings.

use egui_kittest::kittest::NodeT;
use sonoglyph::app::recovery::Recovery;
use sonoglyph::scene::{Grey, Pixels, Target};
use sonoglyph::solver;
use sonoglyph::studio::opening;

use super::*;

fn open_empty() -> Screen {
    let mut screen = open_best();
    screen.state_mut().editor_mut().document.scene.targets.clear();
    screen.state_mut().editor_mut().document.settle();
    rest(&mut screen);
    screen
}

/// Drags with a tool from one place to another, in mm.
fn sweep(screen: &mut Screen, tool: Tool, from: [f64; 2], to: [f64; 2]) {
    key(screen, tool.key());
    let (from, to) = (at(screen, from[0], from[1]), at(screen, to[0], to[1]));
    drag(screen, from, to);
}

/// The window on a plane with one stroke, from (-20, 10) to (20, 10).
fn open_painted() -> Screen {
    let mut screen = open_empty();
    key(&mut screen, Tool::Point.key());
    let canvas = screen.get_by_label("Canvas: the field on the plane").rect();
    click(&mut screen, canvas.center());
    clear(&mut screen);
    key(&mut screen, Tool::Brush.key());
    let lens = screen.state().editor().view.lens(scene(&screen), canvas);
    let on_screen = |x: f64, y: f64| lens.screen(DVec2::new(x, y) * 1e-3);
    drag(&mut screen, on_screen(-20.0, 10.0), on_screen(20.0, 10.0));
    screen
}

fn picture(target: &Target) -> (&str, &Grey) {
    let Shape::Picture { file, pixels, .. } = &target.shape else {
        panic!("{:?} is no picture", target.shape)
    };
    (file, pixels.get().expect("its pixels are loaded"))
}

fn only(screen: &Screen) -> (&str, &Grey) {
    assert_eq!(scene(screen).targets.len(), 1);
    picture(&scene(screen).targets[0])
}

/// Brightness of the first target at mm from its centre.
fn painted(screen: &Screen, x: f64, y: f64) -> f32 {
    let Shape::Picture { width, pixels, .. } = &scene(screen).targets[0].shape else { panic!("no picture") };
    let grey = pixels.get().unwrap();
    let pixel = width * 1e3 / grey.width as f64;
    let (column, row) = (grey.width as f64 / 2.0 + x / pixel, grey.height as f64 / 2.0 - y / pixel);
    grey.brightness[row as usize * grey.width + column as usize]
}

fn save_as(screen: &mut Screen, path: &Path) {
    press(screen, Modifiers::COMMAND | Modifiers::SHIFT, Key::S);
    answer(screen, Purpose::SaveAs, path);
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

#[test]
fn a_stroke_of_the_brush_is_a_picture_with_loud_sound() {
    let mut screen = open_painted();
    let (file, grey) = only(&screen);
    assert_eq!((file, grey.file.as_deref()), ("painting.png", None));
    assert!(grey.width.max(grey.height) <= 512 && grey.width > 200, "{} x {}", grey.width, grey.height);
    assert_eq!([painted(&screen, 0.0, 10.0), painted(&screen, -20.0, 12.0)], [1.0, 1.0]);
    assert_eq!([painted(&screen, 0.0, -10.0), painted(&screen, 0.0, 14.0)], [0.0, 0.0]);
    assert!(screen.state().shown().problem.is_none(), "{:?}", screen.state().shown().problem);
    let loud = (-20..=20).step_by(5).map(|x| rms(&mut screen, f64::from(x), 10.0)).collect::<Vec<_>>();
    let largest = screen.state().shown().map.as_ref().unwrap().largest as f32;
    assert!(loud.iter().any(|&loud| loud > 0.8 * largest), "{loud:?} of {largest}");
    assert!(loud.iter().all(|&loud| loud > 0.4 * largest), "{loud:?} of {largest}");

    sweep(&mut screen, Tool::Brush, [0.0, -30.0], [0.0, -30.0]);
    assert_eq!((only(&screen).0, painted(&screen, 0.0, -30.0)), ("painting.png", 1.0), "on the same picture");
    press(&mut screen, Modifiers::COMMAND, Key::Z);
    assert_eq!(
        [painted(&screen, 0.0, -30.0), painted(&screen, 0.0, 10.0)],
        [0.0, 1.0],
        "a stroke is one undo step"
    );
    press(&mut screen, Modifiers::COMMAND, Key::Z);
    assert!(scene(&screen).targets.is_empty());
    press(&mut screen, Modifiers::COMMAND, Key::Y);
    press(&mut screen, Modifiers::COMMAND, Key::Y);
    assert_eq!([painted(&screen, 0.0, -30.0), painted(&screen, 0.0, 10.0)], [1.0, 1.0]);
    // Beside the plane strokes have no effect.
    clear(&mut screen);
    key(&mut screen, Tool::Brush.key());
    let canvas = screen.get_by_label("Canvas: the field on the plane").rect();
    click(&mut screen, canvas.left_center() + vec2(3.0, 0.0));
    assert!(scene(&screen).targets.is_empty(), "{:?}", scene(&screen).targets);
}

#[test]
fn the_eraser_wipes_pictures_and_deletes_empty_ones_and_other_targets() {
    let mut screen = open_painted();
    screen
        .state_mut()
        .editor_mut()
        .document
        .scene
        .targets
        .push(Target::new(Shape::Circle { at: DVec3::new(0.0, -0.04, 0.1), radius: 0.01 }));
    screen.state_mut().editor_mut().selection.clear();
    rest(&mut screen);
    sweep(&mut screen, Tool::Erase, [10.0, 20.0], [10.0, 0.0]);
    assert_eq!(scene(&screen).targets.len(), 2);
    assert_eq!([painted(&screen, 10.0, 10.0), painted(&screen, 0.0, 10.0)], [0.0, 1.0]);
    sweep(&mut screen, Tool::Erase, [0.0, -30.0], [0.0, -30.0]);
    assert_eq!(only(&screen).0, "painting.png", "the circle is gone");
    type_in(&mut screen, "Diameter", "40");
    sweep(&mut screen, Tool::Erase, [-30.0, 10.0], [30.0, 10.0]);
    assert!(scene(&screen).targets.is_empty(), "the empty picture is deleted");
    press(&mut screen, Modifiers::COMMAND, Key::Z);
    assert_eq!(painted(&screen, 0.0, 10.0), 1.0);
}

#[test]
fn the_brush_paints_upright_planes_and_selected_pictures_with_its_settings() {
    let mut screen = open_painted();
    type_in(&mut screen, "Diameter", "20");
    type_in(&mut screen, "Brightness", "0.5");
    sweep(&mut screen, Tool::Brush, [0.0, -30.0], [0.0, -30.0]);
    let half = painted(&screen, 0.0, -30.0);
    assert!((half - 0.5).abs() < 0.003 && painted(&screen, 8.0, -30.0) == half, "{half}");
    assert_eq!(painted(&screen, 12.0, -30.0), 0.0);
    key(&mut screen, Key::OpenBracket);
    assert!((screen.state().editor().brush.diameter - 0.016).abs() < 1e-12);

    screen.get_by_label("XZ").click();
    rest(&mut screen);
    sweep(&mut screen, Tool::Brush, [0.0, 120.0], [10.0, 120.0]);
    assert_eq!(scene(&screen).targets.len(), 2, "the first lies in another plane");
    let foci = &screen.state().shown().sound.as_ref().unwrap().foci;
    let upright: Vec<_> = foci.iter().filter(|focus| focus.position.z > 0.101).collect();
    assert!(!upright.is_empty());
    for focus in upright {
        let at = focus.position * 1e3;
        let off = at.x - at.x.clamp(0.0, 10.0);
        assert!(at.y.abs() < 1e-6 && off.hypot(at.z - 120.0) < 10.0, "{at}");
    }
    let names: Vec<_> = scene(&screen).targets.iter().map(|target| picture(target).0).collect();
    assert_eq!(names, ["painting.png", "painting-2.png"]);
}

#[test]
fn paintings_are_saved_beside_the_scene_and_solved_from_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mine.toml");
    let mut screen = open_painted();
    save_as(&mut screen, &path);
    assert_eq!(names(folder.path()), ["mine-painting.png", "mine.toml"]);
    assert!(!screen.state().editor().document.is_unsaved());
    assert_eq!(only(&screen).0, "mine-painting.png");
    let png = folder.path().join("mine-painting.png");
    assert_eq!(image::open(&png).unwrap().color(), image::ColorType::L8);
    let again = opening::open(&path).unwrap();
    assert_eq!(picture(&again.targets[0]).1.brightness, only(&screen).1.brightness);
    let drive = |scene: &Scene| solver::solve(scene).unwrap().drive;
    assert_eq!(drive(&again), drive(scene(&screen)));

    // After undo, save and redo there is one file, with the window's pixels.
    let bytes = |place: &Path| std::fs::read(place).unwrap();
    let first = bytes(&png);
    sweep(&mut screen, Tool::Brush, [0.0, -30.0], [20.0, -30.0]);
    assert!(screen.state().editor().document.is_unsaved());
    press(&mut screen, Modifiers::COMMAND, Key::S);
    let second = bytes(&png);
    assert_ne!(first, second);
    press(&mut screen, Modifiers::COMMAND, Key::Z);
    press(&mut screen, Modifiers::COMMAND, Key::S);
    assert_eq!((bytes(&png), names(folder.path()).len()), (first, 2));
    press(&mut screen, Modifiers::COMMAND, Key::Y);
    press(&mut screen, Modifiers::COMMAND, Key::S);
    assert_eq!((bytes(&png), names(folder.path()).len()), (second.clone(), 2));

    // After opening and painting, the file still belongs to the scene.
    press(&mut screen, Modifiers::COMMAND, Key::O);
    answer(&mut screen, Purpose::Open, &path);
    sweep(&mut screen, Tool::Erase, [-30.0, 10.0], [-10.0, 10.0]);
    assert_eq!(picture(&scene(&screen).targets[0]).0, "painting.png", "not yet in a file");
    press(&mut screen, Modifiers::COMMAND, Key::Z);
    press(&mut screen, Modifiers::COMMAND, Key::S);
    assert_eq!((bytes(&png), names(folder.path()).len()), (second.clone(), 2));
    press(&mut screen, Modifiers::COMMAND, Key::Y);
    press(&mut screen, Modifiers::COMMAND, Key::S);
    assert!(bytes(&png) != second && names(folder.path()).len() == 2, "{:?}", names(folder.path()));
    // By now, the file of these pixels holds others.
    press(&mut screen, Modifiers::COMMAND, Key::Z);
    press(&mut screen, Modifiers::COMMAND, Key::S);
    assert_eq!((bytes(&png), names(folder.path()).len()), (second, 2));
}

#[test]
fn foreign_pictures_are_never_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    let (foreign, taken) = (folder.path().join("star.png"), folder.path().join("star-painting.png"));
    image::GrayImage::from_pixel(20, 10, image::Luma([128])).save(&foreign).unwrap();
    std::fs::write(&taken, b"of another program").unwrap();
    let path = folder.path().join("star.toml");
    let text = "format = 1\n# A star.\n[[target]]\nkind = \"picture\"\nfile = \"star.png\"\nwidth = 0.04\n";
    std::fs::write(&path, text).unwrap();
    let before = [&foreign, &taken].map(|file| std::fs::read(file).unwrap());
    let mut screen = open();
    press(&mut screen, Modifiers::COMMAND, Key::O);
    answer(&mut screen, Purpose::Open, &path);
    // Two targets of one picture, one of which is painted on.
    press(&mut screen, Modifiers::COMMAND, Key::A);
    press(&mut screen, Modifiers::COMMAND, Key::D);
    sweep(&mut screen, Tool::Brush, [10.0, -10.0], [15.0, -10.0]);
    assert_eq!(scene(&screen).targets.len(), 2, "no new target");
    press(&mut screen, Modifiers::COMMAND, Key::S);
    assert_eq!([&foreign, &taken].map(|file| std::fs::read(file).unwrap()), before);
    let written = std::fs::read_to_string(&path).unwrap();
    assert!(written.contains("# A star.") && written.contains("\"star.png\""), "{written}");
    assert!(written.contains("file = \"star-painting-2.png\""), "{written}");
    let again = opening::open(&path).unwrap();
    let brightest = |target: &Target| picture(target).1.brightness.iter().copied().fold(0.0, f32::max);
    let expected = [128.0 / 255.0, 1.0];
    let found: Vec<_> = again.targets.iter().map(brightest).collect();
    assert!(found.iter().zip(expected).all(|(a, b): (&f32, f32)| (a - b).abs() < 1e-5), "{found:?}");

    // In another folder, the foreign picture is named by its whole path, and the painting is written again.
    let other = tempfile::tempdir().unwrap();
    save_as(&mut screen, &other.path().join("moved.toml"));
    assert_eq!(names(other.path()), ["moved-painting.png", "moved.toml"]);
    assert_eq!(picture(&scene(&screen).targets[0]).0, foreign.to_str().unwrap());
}

#[test]
fn a_painting_that_cannot_be_written_stays_in_the_window() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mine.toml");
    let mut screen = open_painted();
    save_as(&mut screen, &path);
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::remove_file(folder.path().join("mine-painting.png")).unwrap();
    std::fs::create_dir(folder.path().join("mine-painting.png")).unwrap();
    sweep(&mut screen, Tool::Brush, [0.0, -30.0], [20.0, -30.0]);
    let before = scene(&screen).clone();
    press(&mut screen, Modifiers::COMMAND, Key::S);
    let Some(Dialog::Message { text: said, .. }) = &screen.state().editor().dialog else {
        panic!("no message")
    };
    assert!(said.contains("mine-painting.png"), "{said}");
    assert!(*scene(&screen) == before && screen.state().editor().document.is_unsaved());
    assert_eq!(std::fs::read_to_string(&path).unwrap(), text);
}

#[test]
fn paintings_survive_a_crash_and_the_clipboard() {
    let folder = tempfile::tempdir().unwrap();
    let mut screen = open_painted();
    let unsaved = scene(&screen).clone();
    let mut recovery = Recovery::at(folder.path()).unwrap();
    assert_eq!(recovery.keep(Some(&Document::new(unsaved.clone(), "mine")), 0.0), None);
    assert_eq!(recovery.trouble(), None);
    drop(recovery);
    let mut recovery = Recovery::at(folder.path()).unwrap();
    let found = recovery.found().unwrap();
    let (_, grey) = picture(&found.targets[0]);
    let own = only(&screen).1;
    assert!(grey.file.is_none() && (grey.width, grey.height) == (own.width, own.height));
    assert!(grey.brightness.iter().zip(&own.brightness).all(|(a, b)| (a - b).abs() < 1e-6));
    recovery.forget();
    assert_eq!(names(folder.path()), ["recovery.lock"]);

    press(&mut screen, Modifiers::COMMAND, Key::A);
    screen.event(Event::Cut);
    screen.step();
    let copied = screen.output().platform_output.commands.iter().find_map(|command| match command {
        egui::OutputCommand::CopyText(text) => Some(text.clone()),
        _ => None,
    });
    rest(&mut screen);
    assert!(scene(&screen).targets.is_empty());
    screen.event(Event::Paste(copied.expect("the clipboard has a text")));
    rest(&mut screen);
    let pixels = |scene: &Scene| match &scene.targets[0].shape {
        Shape::Picture { pixels, .. } => pixels.clone(),
        _ => Pixels::default(),
    };
    assert!(pixels(scene(&screen)) == pixels(&unsaved));
}

#[test]
fn the_brush_has_its_settings_above_the_map() {
    let mut screen = open();
    let has = |screen: &Screen, name: &str| {
        let nodes = screen.root().children_recursive();
        nodes.filter(|node| node.accesskit_node().label().as_deref() == Some(name)).count() > 0
    };
    for (tool, expected) in
        [(Tool::Brush, [true, true]), (Tool::Erase, [true, false]), (Tool::Line, [false, false])]
    {
        key(&mut screen, tool.key());
        assert_eq!(["Diameter", "Brightness"].map(|name| has(&screen, name)), expected, "{tool:?}");
    }
}
