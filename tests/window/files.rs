//! Files: imported drawings, comments of a scene, exported motions, and settings.

use std::path::PathBuf;
use std::sync::Arc;

use sonoglyph::studio::animate::Kind;
use sonoglyph::ui::Import;

use super::*;

/// A file dropped on the window.
#[derive(Debug)]
struct Dropped(PathBuf);

impl egui::DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        std::fs::read(&self.0).map_err(|error| error.to_string())
    }
}

pub fn drop_file(screen: &mut Screen, path: &Path) {
    screen.input_mut().dropped_files.push(Arc::new(Dropped(path.to_owned())));
    screen.step();
    rest(screen);
}

fn question(screen: &Screen) -> &Import {
    match &screen.state().editor().dialog {
        Some(Dialog::Import(import)) => import,
        other => panic!("no question: {other:?}"),
    }
}

#[test]
fn a_dropped_drawing_becomes_targets_where_it_is_placed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ring.svg");
    let text =
        "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 10 10'><circle cx='3' cy='3' r='2'/></svg>";
    std::fs::write(&path, text).unwrap();
    let mut screen = open();
    clear(&mut screen);
    drop_file(&mut screen, &path);
    assert!(question(&screen).placement.side > 0.0);
    assert!(screen.query_by_label("1 line, even pressure").is_some());
    pick(&mut screen, "Stroke", "Spacing");
    assert!(screen.query_by_label_contains("focal points on 1 line").is_some());
    pick(&mut screen, "Stroke", "Continuous");
    if let Some(Dialog::Import(import)) = &mut screen.state_mut().editor_mut().dialog {
        import.placement.side = 0.05;
        import.placement.at = DVec3::new(0.01, -0.02, 0.1);
    }
    rest(&mut screen);
    screen.get_by_label("Import").click();
    rest(&mut screen);
    let foci = screen.state().shown().sound.as_ref().unwrap().foci.clone();
    assert_eq!(foci.len(), 74, "2π · 25 mm in pieces of 2.1 mm");
    for focus in &foci {
        let radius = focus.position.distance(DVec3::new(0.01, -0.02, 0.1));
        assert!((radius - 0.025).abs() < 1e-4, "{radius}");
    }
    assert_eq!(screen.state().editor().selection.len(), 1);
    press(&mut screen, Modifiers::COMMAND, Key::Z);
    assert!(scene(&screen).targets.is_empty());
}

#[test]
fn a_drawing_comes_in_the_size_that_it_is_drawn_in() {
    let folder = tempfile::tempdir().unwrap();
    let mut screen = open();
    clear(&mut screen);
    let drawing = |side: f64| {
        format!(
            "<svg xmlns='http://www.w3.org/2000/svg' width='{}mm' height='{side}mm' viewBox='0 0 20 10'>\
             <rect width='20' height='10' fill='none' stroke='#000'/></svg>",
            2.0 * side
        )
    };
    let path = folder.path().join("plate.svg");
    std::fs::write(&path, drawing(20.0)).unwrap();
    drop_file(&mut screen, &path);
    assert!((question(&screen).placement.side - 0.04).abs() < 1e-8, "{}", question(&screen).placement.side);
    assert!(screen.query_by_label_contains("larger").is_none());
    screen.get_by_label("Fit to 60 mm").click();
    rest(&mut screen);
    assert_eq!(question(&screen).placement.side, 0.06);
    screen.get_by_label("40 mm, as drawn").click();
    rest(&mut screen);
    screen.get_by_label("Import").click();
    rest(&mut screen);
    let Shape::Path { vertices, .. } = &scene(&screen).targets[0].shape else { panic!("a path") };
    assert!((vertices[0].distance(vertices[2]) - 0.04_f64.hypot(0.02)).abs() < 1e-7, "{vertices:?}");
    std::fs::write(&path, drawing(300.0)).unwrap();
    drop_file(&mut screen, &path);
    assert!(screen.query_by_label_contains("larger (600 mm) than the array (157.5 mm)").is_some());
}

#[test]
fn an_invalid_drawing_leaves_the_scene_and_gives_a_reason() {
    let folder = tempfile::tempdir().unwrap();
    let mut screen = open();
    let before = scene(&screen).clone();
    let deep = format!("<svg xmlns='http://www.w3.org/2000/svg'>{}</svg>", "<g>".repeat(100_000));
    let svg = |body: &str| format!("<svg xmlns='http://www.w3.org/2000/svg'>{body}</svg>");
    let copies = |i: i32| format!("<g id='g{i}'>{}</g>", format!("<use href='#g{}'/>", i - 1).repeat(10));
    let bomb =
        svg(&format!("<path id='g0' d='M0 0h9' stroke='red'/>{}", (1..9).map(copies).collect::<String>()));
    for (name, bytes, reason) in [
        ("bomb.svg", bomb, "cannot be read"),
        ("empty.svg", String::new(), "neither an SVG nor"),
        ("broken.svg", "<svg".to_owned(), "cannot be read"),
        ("deep.svg", deep, "cannot be read"),
        ("blank.svg", svg(""), "no painted path"),
        ("text.svg", svg("<text>Hi</text>"), "convert its text to paths"),
        ("nan.svg", svg("<path d='M nan 1e999 L 1 2' stroke='red'/>"), ""),
        ("far.svg", svg("<path d='M -1e300 0 L 1e300 1e300' stroke='red'/>"), ""),
        ("odd.png", "\u{89}PNG\r\n".to_owned(), "neither an SVG nor"),
    ] {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        drop_file(&mut screen, &path);
        match &screen.state().editor().dialog {
            Some(Dialog::Message { text, .. }) => {
                assert!(text.contains(reason) && text.contains(name), "{text}");
            }
            other => panic!("{name}: {other:?}"),
        }
        screen.state_mut().editor_mut().dialog = None;
        assert_eq!(*scene(&screen), before, "{name}");
    }
    drop_file(&mut screen, &folder.path().join("missing.png"));
    assert!(matches!(screen.state().editor().dialog, Some(Dialog::Message { .. })));
}

#[test]
fn comments_survive_an_edit_and_an_unedited_file_is_unchanged() {
    const TEXT: &str = "format = 1\n\n# The only one.\n[[target]]\nat = [0, 0, 0.10]   # above the middle\n";
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("by-hand.toml");
    std::fs::write(&path, TEXT).unwrap();
    let mut screen = open();
    drop_file(&mut screen, &path);
    press(&mut screen, Modifiers::COMMAND, Key::S);
    assert_eq!(std::fs::read_to_string(&path).unwrap(), TEXT);
    press(&mut screen, Modifiers::COMMAND, Key::A);
    key(&mut screen, Key::ArrowRight);
    press(&mut screen, Modifiers::COMMAND, Key::S);
    assert!(!screen.state().editor().document.is_unsaved());
    let text = std::fs::read_to_string(&path).unwrap();
    assert_eq!(text, TEXT.replace("[0, 0, 0.10]", "[0.001, 0.0, 0.1]"));
    assert_eq!(file::read(&path).unwrap(), *scene(&screen));
}

/// A circular motion of the focus with this number of frames.
fn circle(screen: &mut Screen, frames: u32) {
    let scene = &mut screen.state_mut().editor_mut().document.scene;
    scene.targets = vec![sonoglyph::scene::Target::new(Shape::Point { at: DVec3::new(0.0, 0.0, 0.1) })];
    (scene.motion.path, scene.motion.frames) = (sonoglyph::scene::MotionPath::Circle, frames);
    rest(screen);
}

#[test]
fn a_motion_is_exported_and_can_be_cancelled() {
    let folder = tempfile::tempdir().unwrap();
    let mut screen = open();
    circle(&mut screen, 6);
    let path = folder.path().join("round.gif");
    export_motion(&mut screen, &path);
    assert!(screen.state().is_busy(), "exported in the background");
    rest(&mut screen);
    let mut decoder = gif::DecodeOptions::new().read_info(std::fs::File::open(&path).unwrap()).unwrap();
    let map = screen.state().shown().map.as_ref().unwrap();
    assert_eq!((usize::from(decoder.width()), usize::from(decoder.height())), (map.width, map.height));
    let mut frames = 0;
    while decoder.read_next_frame().unwrap().is_some() {
        frames += 1;
    }
    assert_eq!(frames, 6);

    screen.state_mut().editor_mut().document.scene.motion.frames = 4000;
    rest(&mut screen);
    let never = folder.path().join("never.gif");
    export_motion(&mut screen, &never);
    screen.run_steps(3);
    screen.get_by_label("Cancel export").click();
    rest(&mut screen);
    let notice = screen.state().shown().notice.as_ref().unwrap();
    assert!(notice.text.contains("never.gif was not written"), "{notice:?}");
    assert!(!never.exists());
}

/// Exports a motion through the dialog, without waiting for it.
fn export_motion(screen: &mut Screen, path: &Path) {
    let kind = Kind::VARIANTS.iter().find(|kind| path.extension().unwrap() == kind.endings()[0]).unwrap();
    let purpose = Purpose::Export(sonoglyph::ui::Export::Motion(*kind));
    let text = path.display().to_string();
    screen.state_mut().editor_mut().dialog = Some(Dialog::Path { purpose, text });
    rest(screen);
    screen.key_press(Key::Enter);
    screen.step();
}

#[test]
fn a_shaded_film_has_the_settings_of_its_dialog() {
    let folder = tempfile::tempdir().unwrap();
    let mut screen = open();
    circle(&mut screen, 4);
    export_shaded(&mut screen, "Motion…");
    assert_eq!(screen.state().editor().dialog, Some(Dialog::Film));
    for (name, value) in [("Width", "401"), ("Frame rate", "10")] {
        let field = screen.get_by_role_and_label(egui::accesskit::Role::SpinButton, name);
        field.click();
        rest(&mut screen);
        press(&mut screen, Modifiers::COMMAND, Key::A);
        letters(&mut screen, value);
        key(&mut screen, Key::Enter);
    }
    assert!(screen.query_by_label_contains("4 frames in 0.40 s").is_some());
    screen.get_by_label("Export…").click();
    rest(&mut screen);
    let path = folder.path().join("water.gif");
    export_motion(&mut screen, &path);
    rest(&mut screen);
    let notice = screen.state().shown().notice.as_ref().unwrap();
    assert!(notice.text.contains("Wrote ") && !notice.is_error, "{notice:?}");
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let mut decoder = options.read_info(std::fs::File::open(&path).unwrap()).unwrap();
    assert_eq!(decoder.width(), 401);
    let (mut frames, mut blue) = (0, 0);
    while let Some(frame) = decoder.read_next_frame().unwrap() {
        assert_eq!(frame.delay, 10);
        blue += frame.buffer.chunks(4).filter(|pixel| pixel[2] > pixel[0].saturating_add(40)).count();
        frames += 1;
    }
    assert!(frames == 4 && blue > 4 * 401 * 60, "water is blue: {blue} pixels");
}

#[test]
fn settings_are_restored_at_the_next_start() {
    let folder = tempfile::tempdir().unwrap();
    let open_there = || {
        let there = folder.path().to_owned();
        let mut screen = Harness::builder().with_size(vec2(1280.0, 800.0)).build_eframe(move |context| {
            let mut opened = window(&context.egui_ctx);
            opened.remember_in(&there, &context.egui_ctx);
            opened
        });
        rest(&mut screen);
        screen
    };
    let saved = folder.path().join("mine.toml");
    {
        let mut screen = open_there();
        assert!(screen.state().shown().recent.is_empty());
        press(&mut screen, Modifiers::COMMAND | Modifiers::SHIFT, Key::S);
        answer(&mut screen, Purpose::SaveAs, &saved);
        screen.get_by_label("Liquid").click();
        screen.get_by_label("Peak").click();
        for overlay in
            ["Line profile", "Show grid", "Guides", "Show elements", "Show peak and side lobe", "Show palm"]
        {
            screen.get_by_label(overlay).click();
            rest(&mut screen);
        }
        screen.get_by_label("Colour scale").click();
        rest(&mut screen);
        screen.get_by_label("dB").click();
        rest(&mut screen);
        screen.key_press(Key::Escape);
        rest(&mut screen);
        screen.state_mut().editor_mut().grid = 0.002;
        screen.ctx.set_theme(egui::Theme::Light);
        let edge = Pos2::new(screen.get_by_label("Canvas: the field on the plane").rect().right(), 400.0);
        let edge = edge + vec2(sonoglyph::ui::canvas::RIGHT, 0.0);
        drag(&mut screen, edge, edge - vec2(60.0, 0.0));
    }
    let settings = std::fs::read_to_string(folder.path().join("settings.toml")).unwrap();
    assert!(settings.contains("theme = \"light\""), "{settings}");
    let mut screen = open_there();
    let editor = screen.state().editor();
    assert_eq!((editor.panel, editor.grid), (sonoglyph::ui::Panel::Liquid, 0.002));
    assert_eq!(editor.view.convention, sonoglyph::studio::convention::Convention::Peak);
    assert!(editor.view.section && editor.view.scale == sonoglyph::field::Scale::Logarithmic);
    let view = &editor.view;
    assert_eq!(
        [view.grid, view.guides, view.elements, view.extremes, view.palm],
        [true, false, true, true, true]
    );
    assert!((editor.layout.panel - 412.0).abs() < 12.0, "{:?}", editor.layout);
    assert_eq!(screen.state().shown().recent, std::slice::from_ref(&saved));
    screen.get_by_label("File").click();
    rest(&mut screen);
    screen.get_by_label("Open recent").click();
    rest(&mut screen);
    screen.get_by_label("mine.toml").click();
    rest(&mut screen);
    assert_eq!(screen.state().editor().document.path(), Some(saved.as_path()));
}

#[test]
fn an_own_drive_is_played_until_solve_instead() {
    let folder = tempfile::tempdir().unwrap();
    let [own, elements, wrong] =
        ["own.csv", "elements.csv", "wrong.csv"].map(|name| folder.path().join(name));
    let rows: String = (0..256).map(|element| format!("{element};{}\n", 0.01 * f64::from(element))).collect();
    std::fs::write(&own, format!("element;phase\n{rows}")).unwrap();
    std::fs::write(&wrong, "element,phase\n7,0\n7,1\n").unwrap();
    std::fs::write(&elements, "x,y,z,nx,ny,nz\n0,0,0,0,0,1\n0.01,0,0,0,0,1\n").unwrap();
    let mut screen = open();
    screen.get_by_label("Solver").click();
    rest(&mut screen);
    let drive = |screen: &Screen| screen.state().shown().sound.as_ref().unwrap().drives[0].clone();
    let solved = drive(&screen);
    for label in ["File", "Open drive…"] {
        screen.get_by_label(label).click();
        rest(&mut screen);
    }
    answer(&mut screen, Purpose::Drive, &own);
    assert!((drive(&screen).phases[100] - 1.0).abs() < 1e-12, "{:?}", drive(&screen).phases[100]);
    assert!(screen.query_by_label("own.csv").is_some() && screen.query_by_label("Iterations").is_none());
    let judged = |screen: &Screen| screen.state().shown().solution.as_ref().unwrap().clone();
    let before = judged(&screen);
    assert_eq!(before.method, None);
    // A moved target is judged with the same drive.
    press(&mut screen, Modifiers::COMMAND, Key::A);
    key(&mut screen, Key::ArrowRight);
    assert_eq!(drive(&screen), before.drive);
    assert_ne!(judged(&screen).quality.mean_pressure, before.quality.mean_pressure);
    // Without targets it is still shown.
    clear(&mut screen);
    assert_eq!(drive(&screen), before.drive);
    assert!(screen.state().shown().map.is_some() && screen.state().shown().problem.is_none());
    press(&mut screen, Modifiers::COMMAND, Key::Z);
    press(&mut screen, Modifiers::COMMAND, Key::Z);
    // The scene's file names it, and is read with it.
    let saved = folder.path().join("scene.toml");
    press(&mut screen, Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::S);
    answer(&mut screen, Purpose::SaveAs, &saved);
    let text = std::fs::read_to_string(&saved).unwrap();
    assert!(text.contains("drive = \"own.csv\"\n"), "{text}");
    assert_eq!(sonoglyph::studio::opening::open(&saved).unwrap(), *scene(&screen));
    // A file without a drive leaves it, and a table of elements is none.
    drop_file(&mut screen, &wrong);
    match &screen.state().editor().dialog {
        Some(Dialog::Message { text, .. }) => {
            assert!(text.contains("wrong.csv:3: element 7 is given twice"), "{text}");
        }
        other => panic!("{other:?}"),
    }
    screen.state_mut().editor_mut().dialog = None;
    rest(&mut screen);
    assert!(scene(&screen).drive.is_named());
    screen.get_by_label("Solve instead").click();
    rest(&mut screen);
    assert_eq!(drive(&screen).phases, solved.phases);
    press(&mut screen, Modifiers::COMMAND, Key::Z);
    assert_eq!(drive(&screen), before.drive);
    press(&mut screen, Modifiers::COMMAND, Key::Y);
    drop_file(&mut screen, &own);
    assert_eq!(drive(&screen), before.drive);
    screen.get_by_label("Solve instead").click();
    rest(&mut screen);
    drop_file(&mut screen, &elements);
    assert_eq!(scene(&screen).elements(), 2);
}

#[test]
fn imported_paths_keep_their_labels_and_groups() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("two.svg");
    let text = "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 10 10' \
                xmlns:inkscape='http://www.inkscape.org/namespaces/inkscape'>\
                <circle id='circle7' inkscape:label='Ring' cx='3' cy='3' r='2'/>\
                <g inkscape:label='Stand' id='g5'><g id='g6'><path id='stem' stroke='#000' d='M 6 1 L 9 1'/></g></g><path stroke='#000' d='M 6 5 L 7 5'/></svg>";
    std::fs::write(&path, text).unwrap();
    let mut screen = open();
    clear(&mut screen);
    drop_file(&mut screen, &path);
    screen.get_by_label("Import").click();
    rest(&mut screen);
    let names: Vec<_> = scene(&screen).targets.iter().map(|target| target.name.as_str()).collect();
    assert_eq!(names, ["Ring", "stem", ""]);
    let groups: Vec<_> = scene(&screen).targets.iter().map(|target| target.group.as_str()).collect();
    assert_eq!(groups, ["", "Stand", ""]);
}
