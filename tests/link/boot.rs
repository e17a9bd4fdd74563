//! An Arduino, which opening its port resets into its boot loader, and whose echo shows whether it is there.

use std::fs::File;
use std::io::{Read, Write};
use std::process::{Command, Output};

use rustix::fs::OFlags;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use sonoglyph::device::declaration::BootLoader;

use super::*;

const MEGA: Profile = Profile::UltrainoMega64;

fn sounds(board: &Board) -> bool {
    !is_silent(board)
}

/// The outcome of `send` to a port.
fn send(port: &str, folder: &std::path::Path) -> Output {
    let scene = "format = 1\n[array]\nrows = 8\ncolumns = 8\n[[target]]\nat = [0, 0, 0.1]\n";
    std::fs::write(folder.join("a.toml"), scene).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_sonoglyph"));
    let arguments = ["send", "a.toml", "--profile", MEGA.name(), "--seconds", "1", "--port", port];
    command.args(arguments).current_dir(folder).output().unwrap()
}

#[test]
fn no_byte_reaches_a_boot_loader() {
    std::thread::scope(|scope| {
        for loader in [BootLoader::Factory, BootLoader::Optiboot] {
            scope.spawn(move || {
                let setup = Setup { boot_loader: Some(loader), ..Setup::new(MEGA) };
                let (board, shown) = board(setup);
                let link = link_to(&board, MEGA, None);
                let frame = numbered(MEGA, 7);
                link.show(Content::Still(frame.clone()));
                eventually("the boot loader", || is_silent(&board));
                // The sketch sounds by itself.
                eventually("the sketch", || sounds(&board));
                eventually("the frame", || shown.try_iter().any(|shown| shown.levels == frame));
                assert_eq!(board.report().spoiled, 0, "{loader:?}");
                drop(link);
                eventually("silence", || is_silent(&board));
            });
        }
    });
}

#[test]
fn a_reset_board_is_noticed_and_plays_again() {
    let (board, shown) = board(Setup::new(MEGA));
    let link = link_to(&board, MEGA, None);
    let frame = numbered(MEGA, 7);
    link.show(Content::Still(frame.clone()));
    eventually("the frame", || shown.try_iter().any(|shown| shown.levels == frame));
    // Any opening of the port resets the board, and the link's bytes hold its boot loader.
    drop(File::open(board.path()).unwrap());
    let why = wait_for(&link, |event| matches!(event, Event::Lost(_)));
    assert!(matches!(&why, Event::Lost(why) if why.contains("stopped answering")), "{why:?}");
    shown.try_iter().for_each(drop);
    eventually("the frame", || shown.try_iter().any(|shown| shown.levels == frame));
    assert_eq!(link.health().found, 2);
}

#[test]
fn silent_and_foreign_boards_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (other, _shown) = board(Setup::new(Profile::SonicSurface));
    let output = send(other.path().to_str().unwrap(), folder.path());
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(2) && said.contains("nothing comes back from"), "{said}");
    assert!(!output.stdout.ends_with(b"\n"), "nothing was played");

    // Two connected wires.
    let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
    grantpt(&master).and_then(|()| unlockpt(&master)).unwrap();
    let name = ptsname(&master, Vec::new()).unwrap().into_string().unwrap();
    let _slave = rustix::fs::open(&*name, OFlags::RDWR | OFlags::NOCTTY, rustix::fs::Mode::empty()).unwrap();
    let mut master = File::from(master);
    let echo = move || {
        let mut bytes = [0; 4096];
        while let Ok(count) = master.read(&mut bytes) {
            if master.write_all(&bytes[..count]).is_err() {
                return;
            }
        }
    };
    std::thread::Builder::new().name("wires".to_owned()).spawn(echo).unwrap();
    let output = send(&name, folder.path());
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(2) && said.contains("are two wires connected?"), "{said}");
}
