//! Arrays of the wrong shape for a board, and boards lost during play.

use std::process::{Child, Stdio};
use std::time::Duration;

use sonoglyph::device::board::{Board, Setup};
use sonoglyph::device::profile::Profile;

use crate::hostile::{folder_with, message_of, refused};
use crate::{SCENE, eventually, program};

fn board(profile: Profile) -> Board {
    Board::start(Setup::new(profile), Box::new(|_| {})).unwrap()
}

#[test]
fn an_array_of_another_shape_is_refused_with_the_boards_own() {
    for (profile, [columns, rows], part) in [
        (Profile::SonicSurface, [32, 8], "has 32 x 8 elements (columns x rows), and sonicsurface is 16 x 16"),
        (Profile::SonicSurface, [64, 4], "sonicsurface is 16 x 16"),
        (Profile::SonicSurface, [1, 256], "sonicsurface is 16 x 16"),
        (Profile::SonicSurfaceTactile, [8, 32], "sonicsurface-tactile is 16 x 16"),
        (Profile::SonicSurface2, [32, 16], "sonicsurface-2 is 16 x 32"),
        (Profile::UltrainoMega64, [16, 4], "ultraino-mega64 is 8 x 8"),
        (Profile::Acoustophoretic512, [32, 8], "acoustophoretic-512 is 16 x 16"),
        (Profile::UltrainoSimpleFpga, [16, 17], "drives up to 256 elements in any rows and columns"),
        (Profile::Native, [8, 33], "native drives up to 256 elements in any rows and columns"),
    ] {
        let scene = format!("{SCENE}[array]\nrows = {rows}\ncolumns = {columns}\n");
        let folder = folder_with(&[("a.toml", &scene)]);
        let board = board(profile);
        let args = ["send", "a.toml", "--port", board.path().to_str().unwrap(), "--profile", profile.name()];
        let message = refused(folder.path(), &mut program(folder.path(), &args));
        assert!(message.contains(part), "{columns} x {rows}: {message}");
        assert_eq!(board.report().frames, 0);
        let args = ["board", "--scene", "a.toml", "--seconds", "0.1", "--profile", profile.name()];
        let message = refused(folder.path(), &mut program(folder.path(), &args));
        assert!(message.contains(part), "{columns} x {rows}: {message}");
    }
}

#[test]
fn every_shape_of_a_board_is_played() {
    for (profile, [columns, rows]) in [
        (Profile::Native, [32, 8]),
        (Profile::Native, [7, 1]),
        (Profile::UltrainoSimpleFpga, [256, 1]),
        (Profile::SonicSurface2, [16, 32]),
        (Profile::UltrainoMega64, [8, 8]),
    ] {
        let scene = format!("{SCENE}[array]\nrows = {rows}\ncolumns = {columns}\npitch = 0.02\n")
            .replace("circle", "none");
        let folder = folder_with(&[("a.toml", &scene)]);
        let board = board(profile);
        let port = board.path().to_str().unwrap();
        let args = ["send", "a.toml", "--port", port, "--profile", profile.name(), "--seconds", "0.2"];
        let output = program(folder.path(), &args).output().unwrap();
        assert!(output.status.success(), "{}: {}", profile.name(), String::from_utf8_lossy(&output.stderr));
        assert!(board.report().frames > 0, "{}", profile.name());
    }
}

/// Plays a motion for this time; returns once the board has received it.
fn play(board: &Board, folder: &std::path::Path, profile: Profile, seconds: &[&str]) -> Child {
    let port = board.path().to_str().unwrap();
    let args = [&["send", "a.toml", "--port", port, "--profile", profile.name()], seconds].concat();
    let send = program(folder, &args).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    eventually("a frame", || board.report().frames > 0);
    send
}

#[test]
fn a_board_lost_or_blocked_at_the_end_of_the_time_is_an_error() {
    let scene = SCENE.replace("frames = 6", "frames = 100\nrate = 1");
    let folder = folder_with(&[("a.toml", &scene)]);
    for profile in [Profile::SonicSurface, Profile::Native] {
        for is_unplugged in [true, false] {
            let board = board(profile);
            let send = play(&board, folder.path(), profile, &["--seconds", "4"]);
            if is_unplugged {
                board.unplug(true);
            } else {
                board.stall(true);
            }
            let message = message_of(&send.wait_with_output().unwrap());
            let is_told = message.contains("the board was lost") || message.contains("could not be silenced");
            assert!(is_told, "{}, {is_unplugged}: {message}", profile.name());
        }
    }
}

#[test]
fn a_board_that_returns_in_time_is_no_error() {
    let folder = folder_with(&[("a.toml", &SCENE.replace("circle", "none"))]);
    let board = board(Profile::SonicSurface);
    let send = play(&board, folder.path(), Profile::SonicSurface, &["--loop"]);
    board.unplug(true);
    std::thread::sleep(Duration::from_millis(600));
    board.unplug(false);
    let frames = board.report().frames;
    eventually("the next frame", || board.report().frames > frames + 2);
    let kill = std::process::Command::new("kill").args(["-INT", &send.id().to_string()]).status().unwrap();
    assert!(kill.success());
    let output = send.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}
