//! Boards whose program is stopped, ended or joined by another: they fall silent when they should, and nothing that is sent is torn.

use std::io::{BufRead, BufReader};
use std::process::Stdio;
use std::sync::mpsc::{Receiver, sync_channel};
use std::time::{Duration, Instant};

use sonoglyph::device::board::{Board, Setup, Shown};
use sonoglyph::device::levels::Levels;
use sonoglyph::device::profile::Profile;
use tempfile::TempDir;

use crate::{Running, eventually, folder, message_of, program, program_after};

/// A virtual board, what it shows, and a folder for who sends to it.
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

    /// Plays the scene for ever; returns when it sounds.
    fn play(&self, scene: &str, profile: Profile) -> Running {
        let mut send = program(self.folder.path(), &self.args(scene, profile));
        let send = Running(send.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap());
        // Some boards are loud when they are switched on.
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

    /// What was shown since this was last asked for.
    fn seen(&self) -> Vec<Levels> {
        self.shown.try_iter().map(|shown| shown.levels).collect()
    }
}

#[test]
fn whatever_ends_a_program_that_sends_its_board_falls_silent() {
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
    // Nobody can do anything after that, so the board itself does.
    let stage = Stage::new(Profile::Native);
    drop(stage.play("still.toml", Profile::Native));
    stage.wait_for_silence();
}

#[test]
fn a_program_that_sends_goes_on_when_nobody_reads_what_it_says() {
    let stage = Stage::new(Profile::Native);
    let mut send = program(stage.folder.path(), &stage.args("still.toml", Profile::Native));
    let mut send = Running(send.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap());
    drop((send.0.stdout.take(), send.0.stderr.take()));
    eventually("sound", || stage.board.report().frames > 0 && stage.sounds());
    // It says how it fares every second.
    std::thread::sleep(Duration::from_millis(2500));
    assert!(stage.sounds() && send.0.try_wait().unwrap().is_none());
    send.signal("INT");
    assert_eq!(send.ended().code(), Some(0), "what nobody reads is no error");
    stage.wait_for_silence();
}

#[test]
fn a_program_that_is_stopped_is_silenced_by_the_board_and_sounds_again_when_it_goes_on() {
    for (scene, pause) in [("still.toml", 600), ("still.toml", 2500), ("a.toml", 2500)] {
        let stage = Stage::new(Profile::Native);
        let mut send = stage.play(scene, Profile::Native);
        // As a laptop does to all its programs when it is shut.
        send.signal("STOP");
        let stopped = Instant::now();
        stage.wait_for_silence();
        std::thread::sleep(Duration::from_millis(pause).saturating_sub(stopped.elapsed()));
        assert!(!stage.sounds(), "nobody is there to tell it to");
        send.signal("CONT");
        eventually("sound", || stage.sounds());
        std::thread::sleep(Duration::from_millis(500));
        assert!(stage.sounds() && send.0.try_wait().unwrap().is_none(), "{scene} stays");
        send.signal("TERM");
        assert!(send.ended().success());
    }
}

#[test]
fn a_second_program_is_turned_away_at_once_and_the_first_is_not_disturbed() {
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
        eventually("what the first goes on with", || stage.board.report().bytes > after.bytes);
        drop(send);
        // The port is free again, and not before.
        let mut last = program(stage.folder.path(), &stage.args("still.toml", profile));
        let last = Running(last.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap());
        eventually("the next program's frame", || !stage.seen().is_empty());
        last.signal("TERM");
    }
}

#[test]
fn a_virtual_board_whose_picture_finds_no_room_says_so() {
    let folder = folder();
    std::fs::write(folder.path().join("x.png"), "old").unwrap();
    let args = ["board", "--profile", "native", "-o", "x.png", "--seconds", "60"];
    let mut board = program_after("ulimit -f 1", folder.path(), &args);
    let mut board = board.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    // It prints on until it ends, and would not like to be left alone.
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
    assert!(!std::path::Path::new(port.trim()).exists(), "its port is gone with it");
}
