//! The real window on an X server: drawing, saving and closing by pointer and keys.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use sonoglyph::scene::{Shape, file};

use crate::running::Running;

/// An X server and its display's number; `None`, with a note, without one.
fn display() -> Option<(Running, String)> {
    for program in ["Xvfb", "xdotool"] {
        let is_there = Command::new(program).arg("-version").output();
        crate::requirement::found("display", is_there.map_err(|error| format!("{program}: {error}")))?;
    }
    let mut server = Command::new("Xvfb")
        .args(["-displayfd", "1", "-screen", "0", "1280x800x24", "-nolisten", "tcp"])
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut number = String::new();
    BufReader::new(server.stdout.take().unwrap()).read_line(&mut number).unwrap();
    Some((Running(server), format!(":{}", number.trim())))
}

/// Sends input to the window, and gives it time to draw.
fn xdotool(display: &str, args: &[&str]) -> String {
    let output = Command::new("xdotool").args(args).env("DISPLAY", display).output().unwrap();
    sleep(Duration::from_millis(400));
    String::from_utf8_lossy(&output.stdout).trim().to_owned()
}

/// The program in a folder, with its window's number.
fn open(display: &str, folder: &Path, args: &[&str]) -> Running {
    let program = Command::new(env!("CARGO_BIN_EXE_sonoglyph"))
        .args(args)
        .current_dir(folder)
        .env("DISPLAY", display)
        .env_remove("WAYLAND_DISPLAY")
        .env("XDG_RUNTIME_DIR", folder)
        .env("XDG_STATE_HOME", folder)
        .env("NODEVICE_SELECT", "1")
        .spawn()
        .unwrap();
    let mut program = Running(program);
    let start = Instant::now();
    let window = loop {
        let found = xdotool(display, &["search", "--name", "Sonoglyph"]);
        if let Some(window) = found.lines().last() {
            break window.to_owned();
        }
        assert!(program.0.try_wait().unwrap().is_none(), "the program ended without a window");
        assert!(start.elapsed() < Duration::from_secs(60), "no window opens");
    };
    sleep(Duration::from_secs(2));
    // Without a window manager the window has to be given the keyboard focus.
    xdotool(display, &["windowfocus", &window]);
    program
}

fn until_there(path: &Path) {
    let start = Instant::now();
    while !path.exists() {
        assert!(start.elapsed() < Duration::from_secs(60), "nothing was saved");
        sleep(Duration::from_millis(200));
    }
}

#[test]
fn a_drawing_or_a_broken_file_opens_the_window() {
    let Some((_server, display)) = display() else { return };
    let folder = tempfile::tempdir().unwrap();
    let svg = "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 10 10'><path d='M0 0 L10 10' stroke='black' fill='none'/></svg>";
    std::fs::write(folder.path().join("a.svg"), svg).unwrap();
    std::fs::write(folder.path().join("broken.toml"), "format = 1\n[array]\npitch = nan\n").unwrap();
    let path = folder.path().join("imported.toml");
    let mut program = open(&display, folder.path(), &["a.svg"]);
    let act = |args: &[&str]| xdotool(&display, args);
    act(&["key", "Return"]);
    act(&["key", "ctrl+shift+s"]);
    act(&["key", "ctrl+a"]);
    act(&["type", path.to_str().unwrap()]);
    act(&["key", "Return"]);
    until_there(&path);
    act(&["key", "ctrl+q"]);
    assert!(program.ended().success());
    assert_eq!(file::read(&path).unwrap().targets.len(), 1);
    // A message, then an empty scene.
    let mut program = open(&display, folder.path(), &["broken.toml"]);
    act(&["key", "Return"]);
    act(&["key", "ctrl+q"]);
    assert!(program.ended().success());
}

#[test]
fn a_session_draws_saves_and_quits() {
    let Some((_server, display)) = display() else { return };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("drawn.toml");
    let mut program = open(&display, folder.path(), &[]);
    let act = |args: &[&str]| xdotool(&display, args);
    act(&["key", "ctrl+a"]);
    act(&["key", "Delete"]);
    act(&["key", "t"]);
    act(&["mousemove", "450", "300", "click", "1"]);
    for letter in ["shift+h", "shift+i", "shift+t"] {
        act(&["key", letter]);
    }
    act(&["key", "Return"]);
    act(&["key", "c"]);
    act(&["mousemove", "450", "550"]);
    act(&["mousedown", "1"]);
    act(&["mousemove", "480", "550"]);
    act(&["mousemove", "510", "550"]);
    act(&["mouseup", "1"]);
    act(&["key", "ctrl+shift+s"]);
    act(&["key", "ctrl+a"]);
    act(&["type", path.to_str().unwrap()]);
    act(&["key", "Return"]);
    until_there(&path);
    act(&["key", "ctrl+q"]);
    let status = program.ended();
    assert!(status.success(), "{status}");
    let scene = file::read(&path).unwrap();
    let [text, circle] = &scene.targets[..] else { panic!("{:?}", scene.targets) };
    assert!(matches!(&text.shape, Shape::Text { text, .. } if text == "HIT"), "{text:?}");
    let Shape::Circle { radius, .. } = circle.shape else { panic!("{circle:?}") };
    assert!((0.01..0.03).contains(&radius), "{radius}");
}
