//! Help texts, completions and manual pages are complete.

use std::fs;
use std::path::Path;

use sonoglyph::field::Quantity;

use crate::process::{folder_with, refuse, succeed};

#[test]
fn help_names_every_quantity_and_renderer() {
    let folder = folder_with(&[]);
    let render = succeed(folder.path(), &["render", "--help"]);
    for name in Quantity::ALL.map(|quantity| quantity.declaration().name) {
        assert!(render.contains(&format!("- {name}:")), "{name}: {render}");
    }
    let all = succeed(folder.path(), &["--help"]);
    assert!(["--renderer", "wgpu", "glow"].iter().all(|word| all.contains(word)), "{all}");
}

#[test]
fn every_command_that_takes_input_has_an_example() {
    let folder = folder_with(&[]);
    for command in commands(folder.path()) {
        let own = succeed(folder.path(), &[&command, "--help"]);
        let has_example = own.matches(&format!("sonoglyph {command} ")).count() > 1;
        assert!(has_example || ["devices", "ports"].contains(&&*command), "{own}");
    }
}

/// The commands listed by `--help`.
fn commands(folder: &Path) -> Vec<String> {
    let help = succeed(folder, &["--help"]);
    let list = help.split_once("\nCommands:\n").unwrap().1.split_once("\n\nArguments:").unwrap().0;
    let named = |line: &str| {
        let name = line.strip_prefix("  ").filter(|line| !line.starts_with(' '));
        name.and_then(|line| line.split_whitespace().next()).map(str::to_owned)
    };
    list.lines().filter_map(named).filter(|name| name != "help").collect()
}

#[test]
fn completions_of_every_shell_name_every_command() {
    let folder = folder_with(&[]);
    let commands = commands(folder.path());
    assert!(commands.len() >= 14, "{commands:?}");
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = succeed(folder.path(), &["completions", shell]);
        for word in commands.iter().map(String::as_str).chain(["renderer", "quantity", "depression"]) {
            assert!(script.contains(word), "{shell} lacks {word}");
        }
    }
    let refused = refuse(folder.path(), &["completions", "tcsh"]);
    assert!(refused.contains("tcsh") && refused.contains("zsh"), "{refused}");
}

#[test]
fn every_command_has_a_manual_page() {
    let folder = folder_with(&[]);
    let program = succeed(folder.path(), &["manual"]);
    assert!(program.contains(".TH sonoglyph 1"), "{program}");
    fs::create_dir(folder.path().join("man")).unwrap();
    succeed(folder.path(), &["manual", "-o", "man"]);
    assert_eq!(fs::read_to_string(folder.path().join("man/sonoglyph.1")).unwrap(), program);
    let commands = commands(folder.path());
    for command in &commands {
        assert!(program.contains(&format!("sonoglyph\\-{command}(1)")), "{command}: {program}");
        let page = succeed(folder.path(), &["manual", command]);
        assert!(page.contains(&format!(".TH sonoglyph-{command} 1")), "{page}");
        let written = folder.path().join(format!("man/sonoglyph-{command}.1"));
        assert_eq!(fs::read_to_string(written).unwrap(), page);
    }
    assert_eq!(fs::read_dir(folder.path().join("man")).unwrap().count(), commands.len() + 1);
    let refused = refuse(folder.path(), &["manual", "draw"]);
    assert!(refused.contains("draw: no such command") && refused.contains("render, solve"), "{refused}");
}
