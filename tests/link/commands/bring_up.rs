//! `sonoglyph check` with virtual boards: its findings, questions, and files.

use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

use sonoglyph::device::board::faults::Faults;
use sonoglyph::device::board::{Board, Setup};
use sonoglyph::device::calibration::Calibration;
use sonoglyph::device::profile::Profile;
use sonoglyph::studio::bring_up::board_scene;

use crate::commands::sonoglyph;
use crate::running::Running;
use crate::{eventually, is_silent, requirement};

fn board(profile: Profile, faults: Faults) -> Board {
    Board::start(Setup { faults, ..Setup::new(profile) }, Box::new(|_| {})).unwrap()
}

/// The command with these answers on its standard input.
fn check(board: &Board, folder: &Path, profile: Profile, more: &[&str], answers: &str) -> Output {
    let port = board.path().display().to_string();
    let arguments = [&["check", "--port", &port, "--profile", profile.name()], more].concat();
    let mut command = sonoglyph();
    command
        .args(arguments)
        .current_dir(folder)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    let mut running = command.spawn().unwrap();
    let mut stdin = running.stdin.take().unwrap();
    // A command that fails early does not read.
    let _ = stdin.write_all(answers.as_bytes());
    drop(stdin);
    running.wait_with_output().unwrap()
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

#[test]
fn a_good_native_board_passes_with_its_facts_in_the_report() {
    let folder = tempfile::tempdir().unwrap();
    let board = board(Profile::Native, Faults::default());
    let output = check(&board, folder.path(), Profile::Native, &["-o", "report.txt"], "");
    assert!(output.status.success(), "{}", said(&output));
    let report = std::fs::read_to_string(folder.path().join("report.txt")).unwrap();
    for part in [
        "protocol 2",
        "7 phase bits, 64 slots, carrier 40000.000 Hz",
        "115200 baud: ",
        "2000000 baud: ",
        "fastest bit rate without loss",
        "256 elements were sent one by one",
        "focus 100 mm above the centre",
        "emergency stop: not tried",
        "the board is silent again",
    ] {
        assert!(report.contains(part), "{part} in {report}");
    }
    eventually("silence", || is_silent(&board));
}

#[test]
fn a_line_that_loses_frames_is_detected() {
    let board = board(Profile::Native, Faults { flip: 1e-4, ..Faults::default() });
    let mut command = sonoglyph();
    command.args(["check", "--profile", "native", "--port"]).arg(board.path()).stdout(Stdio::piped());
    // The steps after the bit rates are not waited for.
    let mut running = Running(command.spawn().unwrap());
    let lines = BufReader::new(running.0.stdout.take().unwrap()).lines().map(Result::unwrap);
    let mut seen = Vec::new();
    let lossy = |line: &str| line.contains("baud: ") && line.contains("lost") && !line.contains(" 0 lost");
    assert!(lines.inspect(|line| seen.push(line.clone())).any(|line| lossy(&line)), "{seen:?}");
}

#[test]
fn silent_elements_are_written_into_the_calibration() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mine.csv");
    let board = board(Profile::UltrainoMega64, Faults::default());
    // Element 2 is silent; 3 seemed so until repeated; for 5 the first answer is invalid.
    let answers = "\n\nn\nn\nb\ny\n\nwhat\nr\n\nq\nn\n";
    let more = ["--listen", "--calibration", "mine.csv"];
    let output = check(&board, folder.path(), Profile::UltrainoMega64, &more, answers);
    // A silent element, and a focus that is not felt.
    assert!(!output.status.success(), "{}", said(&output));
    assert!(
        said(&output).contains("1 elements gave no signal: 2") && said(&output).contains("not felt"),
        "{}",
        said(&output)
    );
    assert!(
        said(&output).contains("passed  the board is there: it sends back commands"),
        "{}",
        said(&output)
    );
    let calibration = Calibration::read(&path, &board_scene(Profile::UltrainoMega64)).unwrap();
    assert_eq!(calibration.off(), [2]);
    // The next run starts from this file.
    let output = check(&board, folder.path(), Profile::UltrainoMega64, &more, "\n\n\nq\n\n");
    assert!(output.status.success(), "{}", said(&output));
    let calibration = Calibration::read(&path, &board_scene(Profile::UltrainoMega64)).unwrap();
    assert!(calibration.off().is_empty());
}

#[test]
fn a_board_that_never_answers_does_not_pass() {
    let folder = tempfile::tempdir().unwrap();
    let board = board(Profile::SonicSurface, Faults::default());
    let output = check(&board, folder.path(), Profile::SonicSurface, &[], "");
    assert!(output.status.success(), "{}", said(&output));
    let said = said(&output);
    assert!(!said.contains("passed") && said.contains("4 could not be verified"), "{said}");
}

#[test]
fn the_emergency_stop_is_tested_by_pressing_it() {
    let folder = tempfile::tempdir().unwrap();
    let board = board(Profile::Native, Faults::default());
    let port = board.path().display().to_string();
    let mut command = sonoglyph();
    command.args(["check", "--port", &port, "--listen"]).current_dir(folder.path());
    let mut running = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    let (mut stdin, stdout) = (running.stdin.take().unwrap(), BufReader::new(running.stdout.take().unwrap()));
    stdin.write_all(b"q\n\n").unwrap();
    let mut lines = stdout.lines().map(Result::unwrap);
    assert!(lines.any(|line| line.contains("Press the emergency stop")));
    board.press(true);
    std::thread::sleep(Duration::from_millis(20));
    board.press(false);
    stdin.write_all(b"\n").unwrap();
    let rest: Vec<_> = lines.collect();
    assert!(rest.iter().any(|line| line.contains("sounds again after it")), "{rest:?}");
    assert!(running.wait().unwrap().success(), "{rest:?}");
}

#[test]
fn an_emergency_stop_that_is_never_pressed_fails_its_step() {
    let folder = tempfile::tempdir().unwrap();
    let board = board(Profile::Native, Faults::default());
    let output = check(&board, folder.path(), Profile::Native, &["--listen"], "q\n\n\n");
    assert!(!output.status.success());
    assert!(said(&output).contains("emergency stop: the board did not notice"), "{}", said(&output));
}

#[test]
fn a_port_without_a_board_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let board = board(Profile::SonicSurface, Faults::default());
    let output = check(&board, folder.path(), Profile::Native, &[], "");
    assert!(!output.status.success());
    assert!(said(&output).contains("does not answer"), "{}", said(&output));
}

#[test]
fn the_protocols_example_client_works() {
    let python = Command::new("python3").arg("--version").output();
    if requirement::found("rtl", python.map_err(|error| format!("python3: {error}"))).is_none() {
        return;
    }
    let board = board(Profile::Native, Faults::default());
    let client = Path::new(env!("CARGO_MANIFEST_DIR")).join("gateware/doc/client.py");
    let output = Command::new("python3").arg(client).arg(board.path()).output().unwrap();
    assert!(output.status.success(), "{}", said(&output));
}
