//! Pipes, devices, folders and endless files in place of input files.

use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;

use crate::hostile::{folder_with, make_pipe, refused};
use crate::{SCENE, program};

/// An unwritten pipe, an endless device, a folder, a missing file, and one that is too large.
fn places(folder: &Path) -> [(&'static str, &'static str); 5] {
    make_pipe(&folder.join("pipe"));
    symlink("/dev/zero", folder.join("zero")).unwrap();
    fs::create_dir(folder.join("dir")).unwrap();
    fs::write(folder.join("large"), vec![b'\n'; 65 << 20]).unwrap();
    let device = "this is a device or a pipe, not a file";
    [
        ("pipe", device),
        ("zero", device),
        ("dir", "is a directory"),
        ("gone", "no such file"),
        ("large", "MiB that are read"),
    ]
}

#[test]
fn inputs_other_than_files_of_limited_size_are_refused() {
    let folder = folder_with(&[("a.toml", SCENE), ("points.csv", "x,y,z\n0,0,0.1\n")]);
    for (name, part) in places(folder.path()) {
        let picture =
            format!("format = 1\n[[target]]\nkind = \"picture\"\nfile = \"{name}\"\nat = [0, 0, 0.1]\n");
        fs::write(folder.path().join("pic.toml"), picture).unwrap();
        let mut commands = vec![
            format!("solve {name}"),
            format!("render {name} -o x.png"),
            "solve pic.toml".to_owned(),
            format!("send a.toml --port /dev/null --profile sonicsurface --calibration {name}"),
        ];
        // Tables are read row by row, so their size is not limited.
        if name != "large" {
            commands.push(format!("probe a.toml --points {name}"));
            commands.push(format!("probe a.toml --points points.csv --drive {name}"));
        }
        for command in commands {
            let args: Vec<_> = command.split(' ').collect();
            let message = refused(folder.path(), &mut program(folder.path(), &args));
            assert!(message.contains(part) && message.contains(name), "{command}: {message}");
        }
    }
}

#[cfg(feature = "window")]
#[test]
fn invalid_settings_and_recovery_files_are_refused() {
    use sonoglyph::app::recovery::Recovery;
    use sonoglyph::app::settings::{Memory, Settings};
    use sonoglyph::scene::Scene;

    for kind in ["pipe", "zero", "dir", "large"] {
        let folder = folder_with(&[]);
        places(folder.path());
        for name in ["settings.toml", "recovery.toml", "recovery.lock"] {
            symlink(kind, folder.path().join(name)).unwrap();
        }
        let (mut memory, settings, word) = Memory::at(folder.path());
        assert_eq!(settings, Settings::default());
        let word = word.unwrap();
        assert!(word.contains("settings.toml was ignored: "), "{word}");
        // Writing must not block on a pipe without a reader.
        memory.keep(Settings { section: true, ..Settings::default() }, 0.0);
        drop(memory);
        let mut recovery = Recovery::at(folder.path()).unwrap();
        assert_eq!(recovery.found(), None);
        recovery.keep(Some(&Scene::default()), 0.0);
        assert_eq!(recovery.trouble().is_some(), kind != "large", "{kind}");
    }
}

#[cfg(feature = "window")]
#[test]
fn settings_with_wrong_values_are_set_aside_with_a_short_message() {
    use sonoglyph::app::settings::Settings;

    let long = format!("theme = {}", "[".repeat(1 << 18));
    for text in
        ["size = [800, 600, 3]", "position = [1, 2, 3]", "size = [1]", "size = \"x\"", "panel = 3", &long]
    {
        let word = Settings::parse(text).unwrap_err();
        assert!(
            !word.is_empty() && word.len() < crate::hostile::LONGEST && !word.contains('\n'),
            "{text:.80}: {word}"
        );
    }
    let escapes = format!("\"\\u001b[2J{}\" = 1\nmaximized = \"\\u001b[31m\"", "x".repeat(1 << 18));
    let word = Settings::parse(&escapes).unwrap_err();
    assert!(word.len() < crate::hostile::LONGEST && !word.contains('\u{1b}'), "{word:.200}");
}
