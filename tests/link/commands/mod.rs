//! The commands `ports`, `check`, `send` and `board` with virtual boards on real pseudo-terminals.

mod bring_up;

use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use sonoglyph::device::board::Setup;
use sonoglyph::device::calibration::Calibration;
use sonoglyph::device::levels::Levels;
use sonoglyph::device::profile::Profile;
use sonoglyph::device::wiring::Wiring;
use sonoglyph::scene::{Scene, file};
use sonoglyph::solver;

use crate::running::Running;
use crate::waiting::{PATIENCE, eventually};
use crate::{board, is_silent};

const POINT: &str = "format = 1\n[[target]]\nkind = \"point\"\nat = [0.01, 0.02, 0.1]\n";

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    }
}

fn sonoglyph() -> Command {
    Command::new(env!("CARGO_BIN_EXE_sonoglyph"))
}

fn send(scene: &Path, port: &Path, profile: Profile, more: &[&str]) -> Output {
    let mut command = sonoglyph();
    command.arg("send").arg(scene).arg("--port").arg(port).args(["--profile", profile.name()]).args(more);
    command.output().unwrap()
}

fn said(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn read(path: &Path) -> Scene {
    file::read(path).unwrap()
}

fn levels(scene: &Scene, profile: Profile) -> Levels {
    let drive = solver::solve(scene).unwrap().drive;
    Wiring::own(profile).levels(&drive, &Calibration::default()).unwrap()
}

#[test]
fn a_scene_is_played_and_followed_by_silence() {
    let folder = Folder::new();
    let scene = folder.write("point.toml", POINT);
    for profile in [Profile::Native, Profile::SonicSurface, Profile::Acoustophoretic512] {
        let (board, shown) = board(Setup::new(profile));
        let output = send(&scene, board.path(), profile, &["--seconds", "0.3"]);
        assert!(output.status.success(), "{}", said(&output.stderr));
        assert!(said(&output.stdout).contains(" frames"), "{}", said(&output.stdout));
        let frames: Vec<_> = shown.try_iter().map(|shown| shown.levels).collect();
        assert!(frames.contains(&levels(&read(&scene), profile)), "{}", profile.name());
        eventually("silence", || is_silent(&board));
    }
}

#[test]
fn an_interrupted_sender_leaves_silence() {
    let folder = Folder::new();
    let scene = folder.write("point.toml", POINT);
    for profile in [Profile::Native, Profile::SonicSurface] {
        let (board, shown) = board(Setup::new(profile));
        let mut sender = sonoglyph();
        sender.arg("send").arg(&scene).arg("--port").arg(board.path());
        let mut sender = Running(sender.args(["--profile", profile.name(), "--loop"]).spawn().unwrap());
        let wanted = levels(&read(&scene), profile);
        while shown.recv_timeout(PATIENCE).unwrap().levels != wanted {}
        eventually("sound", || !is_silent(&board));
        sender.signal("INT");
        assert!(sender.ended().success());
        eventually("silence", || is_silent(&board));
    }
}

#[test]
fn a_motion_is_uploaded_to_the_native_device() {
    let folder = Folder::new();
    let circle = format!("{POINT}[motion]\npath = \"circle\"\nsize = 0.02\nrate = 20.0\nframes = 16\n");
    let ring = "format = 1\n[[target]]\nkind = \"circle\"\n[motion]\npath = \"outline\"\nframes = 16\n";
    for text in [&circle, ring] {
        let scene = folder.write("motion.toml", text);
        let (board, _shown) = board(Setup::new(Profile::Native));
        let output = send(&scene, board.path(), Profile::Native, &["--seconds", "0.5"]);
        assert!(output.status.success(), "{}", said(&output.stderr));
        // Every frame once; some twice, if a busy machine answers late.
        let sent: u32 = said(&output.stdout).split_once(' ').unwrap().0.parse().unwrap();
        assert!((16..60).contains(&sent), "{}", said(&output.stdout));
    }
}

#[test]
fn the_time_limit_ends_even_if_the_board_is_silent() {
    let folder = Folder::new();
    let scene = folder.write("point.toml", POINT);
    let (board, _shown) = board(Setup::new(Profile::Native));
    board.press(true);
    let mut sender = sonoglyph();
    sender.arg("send").arg(&scene).arg("--port").arg(board.path()).args(["--profile", "native"]);
    let mut sender = Running(sender.args(["--seconds", "0.3"]).stderr(Stdio::piped()).spawn().unwrap());
    assert_eq!(sender.ended().code(), Some(2));
    let mut said = String::new();
    sender.0.stderr.take().unwrap().read_to_string(&mut said).unwrap();
    assert!(said.contains("emergency stop was pressed"), "{said}");
}

#[test]
fn drives_in_turn_are_sent_in_turn() {
    let folder = Folder::new();
    let text = "format = 1\n[[target]]\nkind = \"line\"\n[solver]\nframes = 3\n";
    let scene = folder.write("line.toml", text);
    for profile in [Profile::Native, Profile::SonicSurface] {
        let (board, shown) = board(Setup::new(profile));
        let output = send(&scene, board.path(), profile, &["--seconds", "0.5"]);
        assert!(output.status.success(), "{}", said(&output.stderr));
        let seen: Vec<_> = shown.try_iter().map(|shown| shown.levels).collect();
        for drive in solver::solve(&read(&scene)).unwrap().drives() {
            let levels = Wiring::own(profile).levels(&drive, &Calibration::default()).unwrap();
            let times = seen.iter().filter(|seen| **seen == levels).count();
            // A native board plays them faster than its output is sampled.
            assert!(profile == Profile::Native || times > 0, "{profile:?} never showed one of them");
        }
        let sent: u32 = said(&output.stdout).split_once(' ').unwrap().0.parse().unwrap();
        assert!(sent >= 3, "{profile:?}: {}", said(&output.stdout));
    }
}

#[test]
fn the_scene_is_solved_for_the_boards_carrier() {
    let folder = Folder::new();
    let scene = folder.write("point.toml", POINT);
    let (board, shown) = board(Setup { carrier_millihertz: 39_950_000, ..Setup::new(Profile::Native) });
    let output = send(&scene, board.path(), Profile::Native, &["--seconds", "0.2"]);
    let warned = said(&output.stderr);
    assert!(warned.contains("39950 Hz") && warned.contains("40000 Hz"), "{warned}");
    let mut scene = read(&scene);
    scene.array.frequency = 39_950.0;
    let wanted = levels(&scene, Profile::Native);
    assert!(shown.try_iter().any(|shown| shown.levels == wanted));
}

#[test]
fn sending_errors_state_their_reason() {
    let folder = Folder::new();
    let scene = folder.write("point.toml", POINT);
    let small = folder.write("small.toml", &format!("{POINT}[array]\nrows = 8\ncolumns = 8\n"));
    let gaps = folder.write("gaps.csv", "element,offset,gain,off\n0,0,1,0\n");
    let nowhere = Path::new("/dev/there-is-no-such-port");
    let refused = |output: Output, words: &[&str]| {
        let error = said(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{error}");
        for word in words {
            assert!(error.contains(word), "{word} is not in: {error}");
        }
    };
    let sonic = Profile::SonicSurface;
    refused(send(&scene, nowhere, sonic, &[]), &["there is no port"]);
    refused(send(&small, nowhere, sonic, &[]), &["small.toml", "8 x 8", "16 x 16"]);
    refused(
        send(&scene, nowhere, sonic, &["--calibration", gaps.to_str().unwrap()]),
        &["gaps.csv", "255 of 256"],
    );
    refused(send(&scene, nowhere, sonic, &["--baud", "0"]), &["--baud"]);
    refused(send(&scene, nowhere, sonic, &["--seconds", "nan"]), &["seconds"]);
    let mut unknown = sonoglyph();
    unknown.arg("send").arg(&scene).args(["--port", "x", "--profile", "abacus"]);
    refused(unknown.output().unwrap(), &["abacus", "sonicsurface-tactile"]);
    // Stock boards do not answer.
    let (board, _shown) = board(Setup::new(Profile::UltrainoSimpleFpga));
    refused(send(&scene, board.path(), Profile::Native, &[]), &["does not answer"]);
}

#[test]
fn a_virtual_board_prints_its_port_and_its_output() {
    let folder = Folder::new();
    let scene = folder.write("point.toml", POINT);
    let picture = folder.0.path().join("field.png");
    let mut board = sonoglyph();
    board.args(["board", "--profile", "sonicsurface", "--scene"]).arg(&scene).arg("-o").arg(&picture);
    let mut board = Running(board.stdout(Stdio::piped()).spawn().unwrap());
    let mut lines = BufReader::new(board.0.stdout.take().unwrap()).lines().map(Result::unwrap);
    let port = PathBuf::from(lines.next().unwrap());
    let output = send(&scene, &port, Profile::SonicSurface, &["--seconds", "2.5"]);
    assert!(output.status.success(), "{}", said(&output.stderr));
    board.signal("TERM");
    assert!(board.ended().success());
    let lines: Vec<_> = lines.collect();
    // The focus is in its place, to a pixel.
    let place = lines.iter().find_map(|line| line.split_once("at (")).unwrap().1;
    let coordinates: Vec<f64> =
        place.trim_end_matches(") mm").split(", ").map(|coordinate| coordinate.parse().unwrap()).collect();
    assert!((coordinates[0] - 10.0).abs() < 1.0 && (coordinates[1] - 20.0).abs() < 1.0, "{lines:?}");
    assert!(lines.last().unwrap().contains("0 spoiled"), "{lines:?}");
    assert!(std::fs::read(&picture).unwrap().starts_with(b"\x89PNG"));
    assert!(!port.exists(), "the port is removed with the board");
}

#[test]
fn ports_lists_the_boards() {
    let output = sonoglyph().arg("ports").output().unwrap();
    let text = said(&output.stdout);
    assert!(output.status.success());
    for profile in Profile::ALL {
        assert!(text.contains(profile.name()), "{text}");
    }
    assert!(text.contains("89 frames/s at 230400 baud"));
    assert!(text.contains("sonicsurface: every element sounds from power-up"), "{text}");
    let (board, _shown) = board(Setup::new(Profile::SonicSurface2));
    let listed = format!("{} (virtual board, sonicsurface-2)", board.path().display());
    let ports = || said(&sonoglyph().arg("ports").output().unwrap().stdout);
    assert!(ports().lines().any(|line| line == listed), "{}", ports());
    // A killed board leaves its link; no process has the number 0.
    let name = board.path().file_name().unwrap().to_str().unwrap().to_owned();
    let stale = board.path().with_file_name(name.replace(&std::process::id().to_string(), "0"));
    std::os::unix::fs::symlink("/dev/null", &stale).unwrap();
    let there = ports().contains(stale.to_str().unwrap());
    std::fs::remove_file(&stale).unwrap();
    assert!(!there, "{}", stale.display());
}

#[test]
fn an_installed_program_finds_the_gateware_or_lists_the_searched_folders() {
    let gateware = Path::new(env!("CARGO_MANIFEST_DIR")).join("gateware");
    let installed = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).unwrap();
    let empty = Folder::new();
    // Linked, not copied: a file that another thread's child holds open for writing cannot be executed.
    let program = installed.path().join("sonoglyph");
    std::fs::hard_link(env!("CARGO_BIN_EXE_sonoglyph"), &program).unwrap();
    let simulate = |more: &[&str]| {
        let mut command = Command::new(&program);
        command.args(["board", "--rtl", "--seconds", "0.1"]).args(more).current_dir(empty.0.path());
        command.output().unwrap()
    };
    let missing = |more: &[&str], looked_for: &[&str]| {
        let output = simulate(more);
        let error = said(&output.stderr);
        assert_eq!((output.status.code(), error.lines().count()), (Some(2), 1), "{error}");
        for part in
            [looked_for, &["--rtl needs the gateware's sources; looked for ", "apt-get install verilator"]]
                .concat()
        {
            assert!(error.contains(part), "{part} is not in: {error}");
        }
    };
    let beside = installed.path().join("gateware");
    let script = beside.join("sim/build").display().to_string();
    missing(&[], &[&script, "./gateware/sim/build"]);
    missing(&["--gateware", "elsewhere"], &["elsewhere/sim/build"]);

    let verilator = Command::new("verilator").arg("--version").output();
    if crate::requirement::found("rtl", verilator.map_err(|error| format!("verilator: {error}"))).is_none() {
        return;
    }
    let played = |output: Output| {
        assert!(output.status.success(), "{}", said(&output.stderr));
        assert!(said(&output.stdout).contains("0 spoiled"), "{}", said(&output.stdout));
    };
    played(simulate(&["--gateware", gateware.to_str().unwrap()]));
    std::os::unix::fs::symlink(&gateware, empty.0.path().join("gateware")).unwrap();
    played(simulate(&[]));
    std::fs::remove_file(empty.0.path().join("gateware")).unwrap();
    std::os::unix::fs::symlink(&gateware, &beside).unwrap();
    played(simulate(&[]));
}
