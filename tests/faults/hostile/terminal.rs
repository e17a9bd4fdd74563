//! Output to a terminal: no control characters, bounded length, and closed or full outputs.

use std::fs;
use std::process::Stdio;

use crate::hostile::{LONGEST, folder_with, message_of, refused};
use crate::{PROGRAM, SCENE, program, program_after};

/// Colours, the bell, a title, C1 controls, bidirectional overrides, invisible characters, and a tag.
const NASTY: &str = "\u{1b}[31m\u{7}\u{1b}]0;x\u{9b}2J\u{202e}txt\u{2066}\u{200b}\u{e0041}\u{feff}";

/// Whether a text holds characters that control a terminal.
fn steers(text: &str) -> bool {
    text.chars().any(|c| {
        let is_hidden = ['\u{202e}', '\u{2066}', '\u{200b}', '\u{e0041}', '\u{feff}'].contains(&c);
        c != '\n' && (c.is_control() || is_hidden)
    })
}

fn is_plain(said: &[u8]) -> String {
    let said = String::from_utf8(said.to_vec()).unwrap();
    assert!(!steers(&said), "{said:?}");
    said
}

/// A TOML basic string of the same characters.
fn toml_string(text: &str) -> String {
    let escaped: String = text.chars().map(|c| format!("\\U{:08x}", u32::from(c))).collect();
    format!("\"{escaped}\"")
}

#[test]
fn control_characters_in_keys_values_and_names_are_escaped() {
    let nasty = toml_string(NASTY);
    for text in [
        format!("format = 1\n{nasty} = 3\n"),
        format!("format = 1\n[array]\n{nasty} = 3\n"),
        format!("format = 1\n[solver]\nmethod = {nasty}\n"),
        format!("format = 1\n[[target]]\nkind = \"text\"\ntext = {nasty}\n"),
        format!("format = 1\n[[target]]\nkind = \"picture\"\nfile = {nasty}\nat = [0, 0, 0.1]\n"),
        "format = 1\n# \u{202e}\n[array]\npitch = [\"\u{202e}\u{2066}\"]\n".to_owned(),
        format!("format = 1\n[array]\npitch = {}\n", "\u{1b}[31m"),
    ] {
        let folder = folder_with(&[("a.toml", &text)]);
        let message = refused(folder.path(), &mut program(folder.path(), &["solve", "a.toml"]));
        assert!(!steers(&message), "{text}: {message:?}");
    }
    // The scene's name is printed, and a file name may hold a line feed.
    let name = format!("{NASTY}\n.toml");
    let folder = folder_with(&[(&name, SCENE)]);
    let output = program(folder.path(), &["render", &name, "-o", "out/", "--size", "16"]).output().unwrap();
    assert!(output.status.success());
    assert_eq!(is_plain(&output.stdout).lines().count(), 1);
    is_plain(&output.stderr);
    let missing = format!("gone {NASTY}\nerror: forged");
    let message = refused(folder.path(), &mut program(folder.path(), &["solve", &missing]));
    assert!(!steers(&message) && message.contains("\\u{1b}") && message.contains("\\nerror"), "{message:?}");
}

#[test]
fn arguments_are_quoted_and_escaped_in_one_short_message() {
    let folder = folder_with(&[("a.toml", SCENE)]);
    let long = "x".repeat(100_000);
    for value in [NASTY, &long, &format!("{NASTY}{long}")] {
        let listener = format!("--listener={value}");
        for args in [
            &["solve", "a.toml", "--method", value][..],
            &["solve", "a.toml", &listener],
            &["render", "a.toml", "-o", "x.png", "--size", value],
            &[value, value],
            &["solve", "a.toml", value],
        ] {
            let output = program(folder.path(), args).output().unwrap();
            let message = message_of(&output);
            assert!(!steers(&message), "{message:?}");
        }
    }
}

#[test]
fn a_megabyte_is_not_echoed() {
    let long = "y".repeat(1 << 20);
    for text in [
        format!("format = 1\n{long} = 3\n"),
        format!("format = 1\n[array]\npitch = \"{long}\"\n"),
        format!("format = 1\n[[target]]\nkind = \"text\"\ntext = \"{long}\"\n"),
        format!("format = 1\n[[target]]\nkind = \"{long}\"\n"),
        format!("format = 1\n[array]\npitch = 0.{}\n", "0".repeat(1 << 20)),
        format!("format = 1\n[array]\npitch = {}\n", "1".repeat(1 << 20)),
    ] {
        let folder = folder_with(&[("a.toml", &text)]);
        refused(folder.path(), &mut program(folder.path(), &["solve", "a.toml"]));
    }
    let line = format!("{{\"{}\": 1}}", "z".repeat(900_000));
    let folder = folder_with(&[("lines", &line)]);
    let lines = fs::File::open(folder.path().join("lines")).unwrap();
    let output = program(folder.path(), &["batch"]).stdin(lines).output().unwrap();
    assert!(output.status.success() && output.stdout.len() < LONGEST, "{}", output.stdout.len());
}

#[test]
fn an_invalid_calibration_gives_one_message() {
    let table = format!("element,offset,gain,off\n0,{NASTY},1,0\n");
    let folder = folder_with(&[("a.toml", SCENE), ("c.csv", &table)]);
    let args = "send a.toml --port /dev/null --profile sonicsurface --calibration c.csv";
    let message = refused(folder.path(), &mut program(folder.path(), &args.split(' ').collect::<Vec<_>>()));
    assert_eq!(message.matches("not a finite number").count(), 1, "{message}");
    assert!(message.contains("c.csv: line 2: offset") && !steers(&message), "{message}");
}

#[test]
fn only_a_closed_pipe_is_no_error_of_output() {
    let line = "{\"target\": [{}]}\n";
    let folder = folder_with(&[("a.toml", SCENE), ("p.csv", "x,y,z\n0,0,0.1\n"), ("line", line)]);
    for args in [
        "--help",
        "--version",
        "solve --help",
        "solve a.toml",
        "solve a.toml --json",
        "solve a.toml --method all",
        "solve a.toml --levels 16",
        "solve a.toml --motion --json",
        "render a.toml -o a.png --size 16",
        "probe a.toml --points p.csv",
        "devices",
        "ports",
        "batch",
    ] {
        let args: Vec<_> = args.split(' ').collect();
        let output = program_after("exec >&-", folder.path(), &args).output().unwrap();
        assert!(message_of(&output).contains("standard output: cannot write: it is closed"), "{args:?}");
        let full = || fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let line = || fs::File::open(folder.path().join("line")).unwrap();
        let output = program(folder.path(), &args).stdin(line()).stdout(full()).output().unwrap();
        assert!(message_of(&output).contains("standard output: cannot write: No space left"), "{args:?}");
        // Warnings and notes may be lost without an error.
        let output = program(folder.path(), &args).stdin(line()).stderr(full()).output().unwrap();
        assert!(output.status.success(), "{args:?}");
        // Discarded output is no error.
        assert!(program(folder.path(), &args).stdout(Stdio::null()).status().unwrap().success(), "{args:?}");
        let script = format!("(sleep 0.2; \"$0\" {}; echo \"status $?\" >&2) | true", args.join(" "));
        let mut shell = std::process::Command::new("sh");
        let output =
            crate::at_home(&mut shell, folder.path()).args(["-c", &script, PROGRAM]).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(said.contains("status 0") && !said.contains("error"), "{args:?}: {said}");
    }
}
