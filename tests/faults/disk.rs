//! Disks that are full, and files that may not become so large: one message, the old file as it was, nothing half written.

use std::fs::{self, File, OpenOptions};
use std::path::Path;
use std::process::Command;

use crate::{PROGRAM, folder, listing, message_of, program, program_after, refused, succeed};

const OLD: &str = "what was there before";

/// Every command that writes a file by name, and the file.
const WRITERS: [(&[&str], &str); 10] = [
    (&["render", "a.toml", "-o", "x.png"], "x.png"),
    (&["render", "a.toml", "-o", "x.png", "--quantity", "sheet"], "x.png"),
    (&["render", "a.toml", "-o", "y.png", "--data", "x.npy"], "x.npy"),
    (&["render", "a.toml", "--motion", "-o", "x.gif", "--size", "64"], "x.gif"),
    (&["render", "a.toml", "--motion", "-o", "x.png", "--size", "64"], "x.png"),
    (&["solve", "a.toml", "--csv", "x.csv"], "x.csv"),
    (&["solve", "a.toml", "--motion", "--csv", "x.csv"], "x.csv"),
    (&["probe", "a.toml", "--points", "points.csv", "-o", "x.csv"], "x.csv"),
    (&["render", "a.toml", "--motion", "-o", "frames/", "--size", "64"], "frames/a-1.png"),
    (&[], "sonoglyph.png"),
];

fn points(folder: &Path) {
    fs::write(folder.join("points.csv"), format!("x,y,z\n{}", "0,0,0.1\n".repeat(50))).unwrap();
}

#[test]
fn a_file_that_may_not_grow_leaves_the_old_one_and_nothing_else() {
    for (args, name) in WRITERS {
        let folder = folder();
        let folder = folder.path();
        points(folder);
        let path = folder.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, OLD).unwrap();
        let before = listing(folder);
        // 512 bytes.
        let message = refused(&mut program_after("ulimit -f 1", folder, args));
        assert!(message.contains(name) && message.contains("files may not become that large"), "{message}");
        assert_eq!(fs::read_to_string(&path).unwrap(), OLD, "{args:?}");
        assert_eq!(listing(folder), before, "{args:?}");
        assert_eq!(listing(path.parent().unwrap()).iter().filter(|name| name.starts_with('.')).count(), 0);
    }
}

#[test]
fn a_device_that_is_full_is_said_to_be_and_stays_a_device() {
    // An animation's format is told by its name, and a folder is no file.
    let is_of_any_name = |args: &[&str]| {
        args.first().is_some_and(|&command| command != "render" || !args.contains(&"--motion"))
    };
    for (args, name) in WRITERS.into_iter().filter(|(args, _)| is_of_any_name(args)) {
        let folder = folder();
        points(folder.path());
        let args: Vec<_> = args.iter().map(|&arg| if arg == name { "/dev/full" } else { arg }).collect();
        let before = listing(folder.path());
        let message = refused(&mut program(folder.path(), &args));
        assert!(message.contains("/dev/full: cannot write: the disk is full"), "{args:?}: {message}");
        assert_eq!(listing(folder.path()), before, "{args:?}");
    }
    assert!(!fs::metadata("/dev/full").unwrap().is_file());
}

#[test]
fn a_small_disk_that_fills_up_keeps_its_old_file() {
    let can_mount = Command::new("unshare").args(["-rm", "true"]).status();
    if !can_mount.is_ok_and(|status| status.success()) {
        eprintln!("NOT TESTED ON A SMALL DISK: this machine lets nobody mount one");
        return;
    }
    let folder = folder();
    for args in [
        "render a.toml -o disk/x.png",
        "render a.toml -o disk/x.png --motion",
        "render a.toml -o disk/x.gif --motion",
        "solve a.toml --csv disk/x.csv",
    ] {
        let name = args.split_whitespace().find(|arg| arg.starts_with("disk/")).unwrap();
        let script = format!(
            "mkdir -p disk && mount -t tmpfs -o size=8k none disk || exit 9\n\
             echo '{OLD}' > {name} && \"$0\" {args}; status=$?\n\
             cat {name}; ls -A disk; exit $status"
        );
        let output = Command::new("unshare")
            .args(["-rm", "sh", "-c", &script, PROGRAM])
            .current_dir(folder.path())
            .env("NODEVICE_SELECT", "1")
            .output()
            .unwrap();
        let message = message_of(&output);
        assert!(message.contains(name) && message.contains("the disk is full"), "{args}: {message}");
        let left = String::from_utf8(output.stdout).unwrap();
        assert_eq!(left, format!("{OLD}\n{}\n", &name[5..]), "{args}");
    }
}

#[test]
fn what_cannot_be_printed_is_an_error_and_no_panic() {
    let folder = folder();
    let full = || OpenOptions::new().write(true).open("/dev/full").unwrap();
    for args in [
        &["solve", "a.toml"][..],
        &["solve", "a.toml", "--json"],
        &["solve", "a.toml", "--motion", "--json"],
        &["solve", "a.toml", "--method", "all"],
        &["solve", "a.toml", "--levels", "16"],
        &["render", "a.toml", "-o", "a.png", "--size", "16"],
        &["devices"],
        &["ports"],
    ] {
        let message = refused(program(folder.path(), args).stdout(full()));
        assert!(message.contains("standard output: cannot write: No space left"), "{args:?}: {message}");
        // Warnings and notes that nobody can hear end nothing.
        succeed(program(folder.path(), args).stderr(full()));
    }
    let mut batch = program(folder.path(), &["batch", "--no-limits"]);
    fs::write(folder.path().join("lines"), "{\"target\": [{}]}\n".repeat(3)).unwrap();
    batch.stdin(File::open(folder.path().join("lines")).unwrap());
    assert!(refused(batch.stdout(full())).contains("standard output"));
}

#[test]
fn who_stops_reading_is_not_told_of_an_error() {
    let folder = folder();
    for args in ["solve a.toml --json", "devices", "ports", "solve a.toml --method all"] {
        // The reader is gone before the first line.
        let script = format!("(sleep 0.2; \"$0\" {args}; echo \"status $?\" >&2) | true");
        let output =
            Command::new("sh").args(["-c", &script, PROGRAM]).current_dir(folder.path()).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(said.contains("status 0") && !said.contains("panicked"), "{args}: {said}");
    }
}

#[test]
fn a_batch_without_room_says_so_for_every_line_and_goes_on() {
    let folder = folder();
    fs::write(folder.path().join("lines"), "{\"target\": [{}]}\n".repeat(3)).unwrap();
    let mut batch = program_after(
        "ulimit -f 1",
        folder.path(),
        &["batch", "--no-limits", "--data", "out", "--size", "32"],
    );
    let answers = succeed(batch.stdin(File::open(folder.path().join("lines")).unwrap()));
    assert_eq!(answers.lines().count(), 3);
    for (number, answer) in (1..).zip(answers.lines()) {
        let error = serde_json::from_str::<serde_json::Value>(answer).unwrap()["error"].to_string();
        assert!(error.contains(&format!("out/{number}.npy: cannot write: files may not")), "{error}");
    }
    assert!(listing(&folder.path().join("out")).is_empty());
}
