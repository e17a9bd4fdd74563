//! Senders that are stopped, killed or joined by another: the board falls silent, and no frame is torn.

use std::io::{BufRead, BufReader};
use std::os::unix::process::CommandExt;
use std::process::Stdio;
use std::sync::mpsc::{Receiver, sync_channel};
use std::time::{Duration, Instant};

use sonoglyph::device::board::{Board, Setup, Shown};
use sonoglyph::device::levels::Levels;
use sonoglyph::device::profile::Profile;
use tempfile::TempDir;

use crate::{Running, eventually, folder, message_of, program, program_after};

/// A virtual board, its output, and a folder for programs that send to it.
struct Stage {
    board: Board,
    shown: Receiver<Shown>,
    folder: TempDir,
}

impl Stage {
    fn new(profile: Profile) -> Self {
        let (sender, shown) = sync_channel(100_000);
        let watch = move |frame: &Shown| drop(sender.try_send(frame.clone()));
        let board = Board::start(Setup::new(profile), Box::new(watch)).unwrap();
        let folder = folder();
        std::fs::write(folder.path().join("still.toml"), crate::SCENE.replace("circle", "none")).unwrap();
        Self { board, shown, folder }
    }

    fn args<'a>(&'a self, scene: &'a str, profile: Profile) -> Vec<&'a str> {
        let port = self.board.path().to_str().unwrap();
        vec!["send", scene, "--port", port, "--profile", profile.name(), "--loop"]
    }

    /// Plays the scene in a loop; returns once it sounds.
    fn play(&self, scene: &str, profile: Profile) -> Running {
        let mut send = program(self.folder.path(), &self.args(scene, profile));
        let send = Running(send.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap());
        // Some boards sound from power-up.
        eventually("sound", || self.board.report().frames > 0 && self.sounds());
        send
    }

    fn sounds(&self) -> bool {
        let playing = self.board.report().playing.unwrap();
        playing.drive().amplitudes.iter().any(|&amplitude| amplitude > 0.0)
    }

    fn wait_for_silence(&self) {
        eventually("silence", || !self.sounds());
    }

    /// Frames shown since the last call.
    fn seen(&self) -> Vec<Levels> {
        self.shown.try_iter().map(|shown| shown.levels).collect()
    }
}

#[test]
fn a_board_falls_silent_however_its_sender_ends() {
    for profile in [Profile::Native, Profile::SonicSurface] {
        for signal in ["TERM", "INT", "HUP"] {
            let stage = Stage::new(profile);
            let mut send = stage.play("still.toml", profile);
            send.signal(signal);
            let status = send.ended();
            assert!(status.success(), "{}, SIG{signal}: {status}", profile.name());
            stage.wait_for_silence();
        }
    }
    // After SIGKILL only the board itself can act, or the guardian.
    let stage = Stage::new(Profile::Native);
    drop(stage.play("still.toml", Profile::Native));
    stage.wait_for_silence();
}

/// A scene whose array is this board's, modulated at 200 Hz.
fn scene_for(profile: Profile) -> String {
    let [columns, rows] = profile.shape().unwrap_or([16, 16]);
    let array = format!("[array]\ncolumns = {columns}\nrows = {rows}\n[modulation]\nshape = \"square\"\n");
    crate::SCENE.replace("circle", "none") + &array
}

#[test]
fn a_stock_board_falls_silent_after_a_crash() {
    let stock = Profile::ALL.into_iter().filter(|profile| !profile.answers());
    std::thread::scope(|scope| {
        for profile in stock {
            scope.spawn(move || {
                let stage = Stage::new(profile);
                std::fs::write(stage.folder.path().join("own.toml"), scene_for(profile)).unwrap();
                for signal in ["KILL", "QUIT", "ABRT", "SEGV"] {
                    // The whole group, as from a terminal.
                    let mut send = program(stage.folder.path(), &stage.args("own.toml", profile));
                    send.stdout(Stdio::piped()).stderr(Stdio::null()).process_group(0);
                    let mut send = Running(send.spawn().unwrap());
                    stage.seen();
                    eventually("a frame", || {
                        stage.seen().iter().any(|levels| *levels != Levels::off(profile))
                    });
                    let script = format!("kill -{signal} -{}", send.0.id());
                    assert!(
                        std::process::Command::new("sh").args(["-c", &script]).status().unwrap().success()
                    );
                    send.ended();
                    eventually("silence", || {
                        std::thread::sleep(Duration::from_millis(300));
                        stage.seen();
                        let dark = |_| !stage.sounds() && stage.seen().is_empty();
                        (0..50).all(dark)
                    });
                    // No other process holds the caller's pipe.
                    std::io::read_to_string(send.0.stdout.take().unwrap()).unwrap();
                }
            });
        }
    });
}

#[test]
fn a_sender_continues_after_its_output_is_closed() {
    let stage = Stage::new(Profile::Native);
    let mut send = program(stage.folder.path(), &stage.args("still.toml", Profile::Native));
    let mut send = Running(send.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap());
    drop((send.0.stdout.take(), send.0.stderr.take()));
    eventually("sound", || stage.board.report().frames > 0 && stage.sounds());
    // It prints its state every second.
    std::thread::sleep(Duration::from_millis(2500));
    assert!(stage.sounds() && send.0.try_wait().unwrap().is_none());
    send.signal("INT");
    assert_eq!(send.ended().code(), Some(0), "unread output is no error");
    stage.wait_for_silence();
}

#[test]
fn a_stopped_sender_is_silenced_by_the_board_and_sounds_again_when_continued() {
    for (scene, pause) in [("still.toml", 600), ("still.toml", 2500), ("a.toml", 2500)] {
        let stage = Stage::new(Profile::Native);
        let mut send = stage.play(scene, Profile::Native);
        // As on suspending a laptop.
        send.signal("STOP");
        let stopped = Instant::now();
        stage.wait_for_silence();
        std::thread::sleep(Duration::from_millis(pause).saturating_sub(stopped.elapsed()));
        assert!(!stage.sounds(), "silent while stopped");
        send.signal("CONT");
        eventually("sound", || stage.sounds());
        std::thread::sleep(Duration::from_millis(500));
        assert!(stage.sounds() && send.0.try_wait().unwrap().is_none(), "{scene} stays");
        send.signal("TERM");
        assert!(send.ended().success());
    }
}

#[test]
fn a_second_sender_is_refused_without_disturbing_the_first() {
    for profile in [Profile::Native, Profile::SonicSurface] {
        let stage = Stage::new(profile);
        let send = stage.play("still.toml", profile);
        std::thread::sleep(Duration::from_millis(300));
        let before = stage.board.report();
        let playing = stage.seen().pop().unwrap();
        for _ in 0..5 {
            let args = [&stage.args("a.toml", profile)[..], &["--seconds", "2"]].concat();
            let output = program(stage.folder.path(), &args).output().unwrap();
            let message = message_of(&output);
            assert!(message.contains("is in use by another program"), "{message}");
        }
        assert!(stage.seen().iter().all(|levels| *levels == playing), "{}: another frame", profile.name());
        let after = stage.board.report();
        assert_eq!((after.spoiled, after.wrong_baud), (before.spoiled, before.wrong_baud));
        eventually("the next frame of the first", || stage.board.report().bytes > after.bytes);
        drop(send);
        // Only now is the port free.
        let mut last = program(stage.folder.path(), &stage.args("still.toml", profile));
        let last = Running(last.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap());
        eventually("the next program's frame", || !stage.seen().is_empty());
        last.signal("TERM");
    }
}

#[test]
fn a_virtual_board_reports_a_picture_beyond_the_size_limit() {
    let folder = folder();
    std::fs::write(folder.path().join("x.png"), "old").unwrap();
    let args = ["board", "--profile", "native", "-o", "x.png", "--seconds", "60"];
    let mut board = program_after("ulimit -f 1", folder.path(), &args);
    let mut board = board.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    // It prints until it ends, so its output must stay open.
    let mut said = BufReader::new(board.stdout.take().unwrap());
    let mut port = String::new();
    said.read_line(&mut port).unwrap();
    let scene = crate::SCENE.replace("circle", "none");
    std::fs::write(folder.path().join("still.toml"), scene).unwrap();
    let args = ["send", "still.toml", "--port", port.trim(), "--profile", "native", "--loop"];
    let mut send = program(folder.path(), &args);
    let _send = Running(send.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap());
    let message = message_of(&board.wait_with_output().unwrap());
    assert!(message.contains("x.png: cannot write: files may not become that large here"), "{message}");
    assert_eq!(std::fs::read_to_string(folder.path().join("x.png")).unwrap(), "old");
    drop(said);
    assert!(!std::path::Path::new(port.trim()).exists(), "its port is removed");
}
