//! Faults around the window: full disks, other windows on the same file, a lost GPU.

use std::fs;
use std::path::Path;
use std::process::Command;

use egui::{Key, Modifiers, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use sonoglyph::app::Window;
use sonoglyph::field::Evaluator;
use sonoglyph::scene::file;
use sonoglyph::studio::animate::Kind;
use sonoglyph::ui::document::Document;
use sonoglyph::ui::{Dialog, Export, Purpose};

use crate::{folder, gpu, listing};

type Screen = Harness<'static, Window>;

fn open_on(document: Document, evaluator: Evaluator) -> Screen {
    let build = Harness::builder().with_size(vec2(800.0, 600.0));
    let mut screen = build.build_eframe(move |context| Window::new(&context.egui_ctx, document, evaluator));
    rest(&mut screen);
    screen
}

fn open(path: &Path) -> Screen {
    open_on(Document::read(path).unwrap(), Evaluator::Cpu)
}

fn rest(screen: &mut Screen) {
    screen.run_steps(3);
    crate::eventually("rest", || {
        screen.run_steps(2);
        !screen.state().is_busy()
    });
}

fn press(screen: &mut Screen, modifiers: Modifiers, key: Key) {
    screen.key_press_modifiers(modifiers, key);
    rest(screen);
}

fn save(screen: &mut Screen) {
    press(screen, Modifiers::COMMAND, Key::S);
}

fn choose(screen: &mut Screen, button: &str) {
    screen.get_by_label(button).click();
    rest(screen);
}

/// Answers a file dialog for this purpose with a path.
fn answer(screen: &mut Screen, purpose: Purpose, path: &Path) {
    let text = path.display().to_string();
    screen.state_mut().editor_mut().dialog = Some(Dialog::Path { purpose, text });
    rest(screen);
    press(screen, Modifiers::NONE, Key::Enter);
}

/// Moves the only target by a step.
fn edit(screen: &mut Screen) {
    press(screen, Modifiers::COMMAND, Key::A);
    press(screen, Modifiers::NONE, Key::ArrowRight);
    assert!(screen.state().editor().document.is_unsaved());
}

/// The reason of a refused action.
fn refusal(screen: &mut Screen) -> String {
    let editor = screen.state_mut().editor_mut();
    match (editor.dialog.take(), editor.asking.problem.take()) {
        (Some(Dialog::Message { text, .. }), _) => text,
        // A refused answer stays in the dialog, with the reason.
        (Some(Dialog::Path { .. }), Some((_, why))) => why,
        other => panic!("no refusal: {other:?}"),
    }
}

#[test]
fn a_scene_that_cannot_be_saved_stays_as_it_is_and_unsaved() {
    // The size limit holds for a whole process, so this test runs in its own.
    const INSIDE: &str = "SONOGLYPH_TEST_ON_A_FULL_DISK";
    if let Some(folder) = std::env::var_os(INSIDE) {
        return on_a_full_disk(Path::new(&folder));
    }
    let folder = folder();
    let own = std::env::current_exe().unwrap();
    let name = "window::a_scene_that_cannot_be_saved_stays_as_it_is_and_unsaved";
    let output = Command::new("sh")
        .args(["-c", "trap '' XFSZ; ulimit -f 0; exec \"$0\" \"$@\""])
        .arg(own)
        .args(["--exact", name, "--nocapture"])
        .env(INSIDE, folder.path())
        .output()
        .unwrap();
    let said =
        String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && said.contains("1 passed"), "{said}");
}

fn on_a_full_disk(folder: &Path) {
    let path = folder.join("a.toml");
    let mut screen = open(&path);
    screen.state_mut().recover(sonoglyph::app::recovery::Recovery::at(&folder.join("state")));
    edit(&mut screen);
    let edited = screen.state().editor().document.scene.clone();
    assert!(screen.state().shown().notice.as_ref().unwrap().text.contains("A crash would take"));
    save(&mut screen);
    assert!(refusal(&mut screen).contains("a.toml: cannot write: files may not become that large here"));
    for (export, name) in [
        (Export::Map, "x.png"),
        (Export::Sheet, "x.png"),
        (Export::Numbers, "x.npy"),
        (Export::Drive, "x.csv"),
    ] {
        answer(&mut screen, Purpose::Export(export), &folder.join(name));
        assert!(refusal(&mut screen).contains("files may not become that large here"), "{export:?}");
    }
    answer(&mut screen, Purpose::Export(Export::Motion(Kind::Gif)), &folder.join("x.gif"));
    rest(&mut screen);
    assert!(refusal(&mut screen).contains("x.gif: cannot write: files may not become that large here"));
    // Closing asks about unsaved changes, and a failed save does not close the window.
    let document = &screen.state().editor().document;
    assert!(document.is_unsaved() && document.scene == edited);
    assert_eq!(fs::read_to_string(&path).unwrap(), crate::SCENE, "the old file");
    assert_eq!(listing(folder), ["a.toml", "state"]);
    edit(&mut screen);
    assert!(screen.state().shown().map.is_some(), "the window still works");
}

#[test]
fn a_window_does_not_block_on_pipes_and_does_not_write_devices() {
    let folder = folder();
    let pipe = folder.path().join("pipe.toml");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let mut screen = open(&folder.path().join("a.toml"));
    edit(&mut screen);
    for path in [&pipe, Path::new("/dev/null")] {
        for purpose in
            [Purpose::SaveAs, Purpose::Export(Export::Map), Purpose::Export(Export::Motion(Kind::Gif))]
        {
            answer(&mut screen, purpose, path);
            let text = refusal(&mut screen);
            assert!(text.contains("this is a device or a pipe, not a file"), "{purpose:?}: {text}");
        }
        answer(&mut screen, Purpose::Open, path);
        let text = refusal(&mut screen);
        assert!(text.contains("this is a device or a pipe, not a file"), "{text}");
        answer(&mut screen, Purpose::Import, path);
        let text = refusal(&mut screen);
        assert!(text.contains("this is a device or a pipe, not a file"), "{text}");
    }
    assert!(screen.state().editor().document.is_unsaved());
}

#[test]
fn two_windows_on_one_file_do_not_overwrite_each_other() {
    let folder = folder();
    let path = folder.path().join("a.toml");
    let (mut one, mut other) = (open(&path), open(&path));
    edit(&mut one);
    save(&mut one);
    save(&mut one);
    assert!(one.state().editor().dialog.is_none(), "its own changes of the file need no question");
    let of_one = fs::read_to_string(&path).unwrap();
    edit(&mut other);
    edit(&mut other);
    save(&mut other);
    assert_eq!(other.state().editor().dialog, Some(Dialog::Changed(path.clone())));
    choose(&mut other, "Cancel");
    assert_eq!(fs::read_to_string(&path).unwrap(), of_one);
    assert!(other.state().editor().document.is_unsaved());
    save(&mut other);
    choose(&mut other, "Save as…");
    answer(&mut other, Purpose::SaveAs, &folder.path().join("b.toml"));
    assert!(!other.state().editor().document.is_unsaved());
    assert_eq!(fs::read_to_string(&path).unwrap(), of_one);
    // Overwriting is possible on request.
    fs::write(&path, crate::SCENE).unwrap();
    edit(&mut one);
    save(&mut one);
    choose(&mut one, "Replace");
    assert_eq!(file::read(&path).unwrap(), one.state().editor().document.scene);
    assert!(!one.state().editor().document.is_unsaved());
}

#[test]
fn a_lost_gpu_is_replaced_by_the_cpu_with_one_message() {
    let document = || Document::parse(crate::SCENE.to_owned(), "a").unwrap();
    let before = open_on(document(), Evaluator::Cpu).state_mut().numbers().unwrap();
    let peak = before.1.iter().copied().fold(0.0, f32::max);
    for loses_before_export in [false, true] {
        let Some(gpu) = gpu::gpu() else { return };
        let mut screen = open_on(document(), Evaluator::Gpu(Box::new(gpu)));
        screen.state().gpu().unwrap().lose();
        if loses_before_export {
            // These were on the GPU only.
            let numbers = screen.state_mut().numbers().unwrap();
            assert!(before.1.iter().zip(&numbers.1).all(|(a, b)| (a - b).abs() < 2e-3 * peak));
            assert!(screen.state_mut().picture().is_some());
        }
        // Cached results need no GPU, new ones do.
        edit(&mut screen);
        rest(&mut screen);
        let shown = screen.state().shown();
        assert!(screen.state().gpu().is_none() && shown.evaluator.starts_with("CPU"), "{}", shown.evaluator);
        let said = &shown.notice.as_ref().unwrap().text;
        assert!(said.contains("the GPU was lost") && said.contains("from now on"), "{said}");
        assert!(shown.map.is_some() && shown.problem.is_none(), "{:?}", shown.problem);
        edit(&mut screen);
        let moved = screen.state_mut().numbers().unwrap();
        assert!((moved.1.iter().copied().fold(0.0, f32::max) / peak - 1.0).abs() < 0.1);
    }
}
