//! Outputs and inputs other than plain files: links, pipes, devices, folders, and missing permissions.

use std::fs::{self, File, Permissions};
use std::io::Read;
use std::os::unix::fs::{FileTypeExt, MetadataExt, PermissionsExt, symlink};
use std::path::Path;
use std::process::Command;

use crate::{PROGRAM, folder, listing, program, refused, succeed};

const TO: [&str; 4] = ["solve", "a.toml", "--csv", "x.csv"];

fn is_a_drive(path: &Path) -> bool {
    fs::read_to_string(path).unwrap().starts_with("element,x,y,phase,amplitude\n0,")
}

fn solve_to(folder: &Path, path: &str) -> Command {
    program(folder, &["solve", "a.toml", "--csv", path])
}

/// Permissions hardly restrict root.
fn is_root() -> bool {
    fs::metadata("/proc/self").unwrap().uid() == 0
}

#[test]
fn a_link_stays_and_its_target_is_written() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir(at("elsewhere")).unwrap();
    fs::write(at("elsewhere/old.csv"), "old").unwrap();
    symlink("elsewhere/old.csv", at("near.csv")).unwrap();
    symlink("near.csv", at("far.csv")).unwrap();
    // This link is dangling.
    symlink(at("elsewhere/new.csv"), at("dangling.csv")).unwrap();
    for (link, target) in [("far.csv", "old.csv"), ("dangling.csv", "new.csv")] {
        succeed(&mut solve_to(folder.path(), link));
        assert!(fs::symlink_metadata(at(link)).unwrap().is_symlink(), "{link}");
        assert!(is_a_drive(&at("elsewhere").join(target)), "{link}");
    }
    assert!(fs::symlink_metadata(at("near.csv")).unwrap().is_symlink());
    assert_eq!(listing(&at("elsewhere")), ["new.csv", "old.csv"]);
    symlink("circle.csv", at("circle.csv")).unwrap();
    assert!(refused(&mut solve_to(folder.path(), "circle.csv")).contains("circle.csv: cannot write: "));
}

#[test]
fn a_file_keeps_its_mode_and_owner_when_it_is_replaced() {
    let folder = folder();
    let path = folder.path().join("x.csv");
    for mode in [0o600, 0o644, 0o664, 0o755] {
        fs::write(&path, "old").unwrap();
        fs::set_permissions(&path, Permissions::from_mode(mode)).unwrap();
        // Only root can change owners.
        let owner = if is_root() { 4711 } else { fs::metadata(&path).unwrap().uid() };
        std::os::unix::fs::chown(&path, Some(owner), None).unwrap();
        succeed(&mut program(folder.path(), &TO));
        let there = fs::metadata(&path).unwrap();
        assert_eq!((there.permissions().mode() & 0o777, there.uid()), (mode, owner));
        assert!(is_a_drive(&path));
    }
    // A new file follows the umask.
    fs::remove_file(&path).unwrap();
    succeed(&mut crate::program_after("umask 027", folder.path(), &TO));
    assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o640);
}

#[test]
fn pipes_and_devices_are_written_and_stay() {
    let folder = folder();
    let pipe = folder.path().join("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let reader = std::thread::Builder::new().spawn({
        let pipe = pipe.clone();
        move || {
            let mut text = String::new();
            File::open(pipe).unwrap().read_to_string(&mut text).unwrap();
            text
        }
    });
    succeed(&mut solve_to(folder.path(), "pipe"));
    let text = reader.unwrap().join().unwrap();
    assert_eq!(text.lines().count(), 257);
    assert!(fs::metadata(&pipe).unwrap().file_type().is_fifo());
    succeed(&mut solve_to(folder.path(), "/dev/null"));
    assert!(fs::metadata("/dev/null").unwrap().file_type().is_char_device());
    let said = succeed(&mut solve_to(folder.path(), "/dev/stdout"));
    assert!(said.contains("element,x,y,phase,amplitude\n0,"), "{said}");
    assert_eq!(listing(folder.path()), ["a.toml", "pipe"]);
}

#[test]
fn a_folder_as_output_and_a_missing_folder_give_different_messages() {
    let folder = folder();
    fs::create_dir(folder.path().join("x.csv")).unwrap();
    let message = refused(&mut program(folder.path(), &TO));
    assert!(message.contains("x.csv: cannot write: ") && message.contains("directory"), "{message}");
    let message = refused(&mut solve_to(folder.path(), "gone/x.csv"));
    assert!(message.contains("gone/x.csv: cannot write: its folder is not there"), "{message}");
    let message = refused(&mut solve_to(folder.path(), "a.toml/x.csv"));
    assert!(message.contains("a.toml/x.csv: cannot write: "), "{message}");
    let message = refused(&mut program(folder.path(), &["render", "a.toml", "-o", "a.toml/"]));
    assert!(message.contains("a.toml/"), "{message}");
}

/// The program as an unprivileged user; for root, as uid 65534 with a copy of the program, whose original that user may
/// not be able to read.
fn as_nobody(folder: &Path) -> Command {
    fs::set_permissions(folder, Permissions::from_mode(0o777)).unwrap();
    if !is_root() {
        return Command::new(PROGRAM);
    }
    let copy = folder.join("program");
    // By another process: a child that a test beside this one starts meanwhile would inherit the open copy, which then
    // cannot be run.
    assert!(Command::new("cp").args([PROGRAM.as_ref(), copy.as_os_str()]).status().unwrap().success());
    let mut command = Command::new("setpriv");
    command.args(["--reuid=65534", "--regid=65534", "--clear-groups"]).arg(copy);
    command
}

#[test]
fn outputs_without_permission_are_refused_before_the_work() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let mode = |name: &str, mode| fs::set_permissions(at(name), Permissions::from_mode(mode)).unwrap();
    fs::write(at("mine.csv"), "old").unwrap();
    fs::write(at("locked.csv"), "old").unwrap();
    mode("locked.csv", 0o444);
    fs::create_dir(at("closed")).unwrap();
    fs::write(at("closed/open.csv"), "old").unwrap();
    mode("closed/open.csv", 0o666);
    mode("closed", 0o555);
    for path in ["locked.csv", "closed/new.csv", "closed/open.csv"] {
        let mut solve = as_nobody(folder.path());
        let message = refused(solve.args(["solve", "a.toml", "--csv", path]).current_dir(folder.path()));
        assert!(message.contains(&format!("{path}: cannot write: permission denied")), "{message}");
    }
    assert_eq!(fs::read_to_string(at("locked.csv")).unwrap(), "old");
    assert_eq!(fs::read_to_string(at("closed/open.csv")).unwrap(), "old");
    assert_eq!(listing(&at("closed")), ["open.csv"]);
    let mut solve = as_nobody(folder.path());
    succeed(solve.args(["solve", "a.toml", "--csv", "own.csv"]).current_dir(folder.path()));
    assert!(is_a_drive(&at("own.csv")));
    mode("closed", 0o755);
}

#[test]
fn a_scene_may_come_from_a_pipe_but_not_from_an_endless_device() {
    let folder = folder();
    let scene = File::open(folder.path().join("a.toml")).unwrap();
    let said = succeed(program(folder.path(), &["solve", "/dev/stdin", "--json"]).stdin(scene));
    assert!(said.contains("\"foci\""));
    let message = refused(&mut program(folder.path(), &["solve", "/dev/zero"]));
    assert!(message.contains("/dev/zero: this is a device or a pipe, not a file"), "{message}");
}
