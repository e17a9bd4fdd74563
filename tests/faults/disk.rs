//! Full disks and file size limits: one message, the old file unchanged, no partial file.

use std::fs::{self, File};
use std::path::Path;
use std::process::Command;

use crate::{PROGRAM, folder, listing, message_of, program, program_after, refused, succeed};

const OLD: &str = "what was there before";

/// Every command that writes a named file, with that file.
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
fn a_file_beyond_the_size_limit_keeps_the_old_one() {
    for (args, name) in WRITERS {
        let folder = folder();
        let folder = folder.path();
        points(folder);
        let path = folder.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, OLD).unwrap();
        let before = listing(folder);
        // The limit is 512 bytes.
        let message = refused(&mut program_after("ulimit -f 1", folder, args));
        assert!(message.contains(name) && message.contains("files may not become that large"), "{message}");
        assert_eq!(fs::read_to_string(&path).unwrap(), OLD, "{args:?}");
        assert_eq!(listing(folder), before, "{args:?}");
        assert_eq!(listing(path.parent().unwrap()).iter().filter(|name| name.starts_with('.')).count(), 0);
    }
}

#[test]
fn a_full_device_gives_an_error_and_stays_a_device() {
    // The format of an animation follows from its file name, and a folder is not a file.
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
fn a_disk_that_fills_up_keeps_the_old_file() {
    let can_mount = Command::new("unshare").args(["-rm", "true"]).status();
    if !can_mount.is_ok_and(|status| status.success()) {
        eprintln!("NOT TESTED ON A SMALL DISK: mounting is not permitted here");
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
fn a_batch_on_a_full_disk_answers_every_line_with_the_error() {
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
