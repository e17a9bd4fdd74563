//! Outputs that are also inputs, and two outputs of one name.

use std::fs::{self, File, OpenOptions};
use std::os::unix::fs::symlink;

use crate::hostile::{contents, folder_with, refused};
use crate::{SCENE, program};

const PICTURE: &str = "[[target]]\nkind = \"picture\"\nfile = \"p.png\"\nat = [0, 0, 0.1]\n";

/// A scene, one with a picture, points, a drive, and links to them.
fn stage() -> tempfile::TempDir {
    let folder = folder_with(&[
        ("a.toml", SCENE),
        ("still.toml", &SCENE.replace("circle", "none")),
        ("pic.toml", &format!("format = 1\n{PICTURE}")),
        ("points.csv", "x,y,z\n0,0,0.1\n"),
        ("water.toml", &SCENE.replace("frames = 6", "frames = 3")),
    ]);
    let at = |name: &str| folder.path().join(name);
    image::GrayImage::from_fn(8, 8, |x, _| image::Luma([if x < 4 { 0 } else { 255 }]))
        .save(at("p.png"))
        .unwrap();
    let drive = program(folder.path(), &["solve", "still.toml", "--csv", "drive.csv"]).output().unwrap();
    assert!(drive.status.success());
    for name in ["a.toml", "points.csv", "drive.csv", "p.png"] {
        symlink(name, at(&format!("soft-{name}"))).unwrap();
        fs::hard_link(at(name), at(&format!("hard-{name}"))).unwrap();
    }
    fs::create_dir(at("sub")).unwrap();
    symlink("..", at("sub/back")).unwrap();
    symlink("new.png", at("dangling.png")).unwrap();
    folder
}

#[test]
fn an_output_that_is_an_input_is_refused_by_every_command() {
    let folder = stage();
    for args in [
        "solve a.toml --csv a.toml",
        "solve a.toml --csv soft-a.toml",
        "solve a.toml --csv hard-a.toml",
        "solve a.toml --csv sub/back/a.toml",
        "solve soft-a.toml --csv ./a.toml",
        "solve a.toml --motion --csv hard-a.toml",
        "solve pic.toml --csv soft-p.png",
        "render a.toml -o a.toml",
        "render a.toml -o x.png --data soft-a.toml",
        "render pic.toml -o p.png",
        "render pic.toml -o hard-p.png",
        "render pic.toml -o x.png --data p.png",
        "render a.toml pic.toml -o sub/back/",
        "probe still.toml --points points.csv -o still.toml",
        "probe still.toml --points points.csv -o soft-points.csv",
        "probe still.toml --points points.csv --drive drive.csv -o hard-drive.csv",
        "solve still.toml --drive drive.csv --csv hard-drive.csv",
        "render still.toml --drive drive.csv -o x.png --data soft-drive.csv",
        "board --scene still.toml -o still.toml --seconds 0.1",
    ] {
        // A scene named p would be drawn over the picture p.png.
        fs::copy(folder.path().join("pic.toml"), folder.path().join("p.toml")).unwrap();
        let args = args.replace("render a.toml pic.toml", "render a.toml p.toml");
        let args: Vec<_> = args.split(' ').collect();
        let message = refused(folder.path(), &mut program(folder.path(), &args));
        assert!(message.contains("writing it would destroy it"), "{args:?}: {message}");
    }
}

#[test]
fn an_animation_over_its_scenes_picture_is_refused() {
    let folder = stage();
    // The third of four frames would have the picture's name.
    let motion = "[motion]\npath = \"circle\"\nframes = 4\n[solver]\nmethod = \"naive\"\n";
    let picture = PICTURE.replace("p.png", "m-3.png");
    fs::copy(folder.path().join("p.png"), folder.path().join("m-3.png")).unwrap();
    fs::write(folder.path().join("m.toml"), format!("format = 1\n{picture}{motion}")).unwrap();
    for args in ["render m.toml --motion -o sub/back/", "render m.toml --motion -o m-3.png"] {
        let args: Vec<_> = args.split(' ').collect();
        let message = refused(folder.path(), &mut program(folder.path(), &args));
        assert!(message.contains("writing it would destroy it"), "{args:?}: {message}");
    }
    let args =
        "render water.toml --quantity depression --waves --seconds 0.0025 -o x.times.npy/ --data x.npy";
    let output = program(folder.path(), &args.split(' ').collect::<Vec<_>>()).output().unwrap();
    assert_eq!(output.status.code(), Some(2), "the frame times are also a file");
}

#[test]
fn two_outputs_of_one_name_are_refused() {
    let folder = stage();
    for args in [
        "render a.toml -o x.png --data x.png",
        "render a.toml -o x.png --data sub/back/x.png",
        "render a.toml -o dangling.png --data new.png",
        "bench field --json sub/field-error.png --plots sub",
    ] {
        let args: Vec<_> = args.split(' ').collect();
        let message = refused(folder.path(), &mut program(folder.path(), &args));
        assert!(message.contains("this would be written twice"), "{args:?}: {message}");
    }
    // Devices may be named twice.
    let args = ["render", "a.toml", "-o", "/dev/null", "--data", "/dev/null", "--size", "16"];
    assert!(program(folder.path(), &args).output().unwrap().status.success());
}

#[test]
fn standard_input_and_output_are_files_like_others() {
    let folder = stage();
    let scene = folder.path().join("a.toml");
    let mut solve = program(folder.path(), &["solve", "a.toml", "--json"]);
    let message = refused(folder.path(), solve.stdout(OpenOptions::new().append(true).open(&scene).unwrap()));
    assert!(message.contains("writing it would destroy it"), "{message}");
    let mut solve = program(folder.path(), &["solve", "/dev/stdin", "--csv", "a.toml"]);
    let message = refused(folder.path(), solve.stdin(File::open(&scene).unwrap()));
    assert!(message.contains("writing it would destroy it"), "{message}");
    let line =
        format!("{{{}}}\n", r#""target": [{"kind": "picture", "file": "out/2.npy", "at": [0, 0, 0.1]}]"#);
    fs::create_dir(folder.path().join("out")).unwrap();
    fs::copy(folder.path().join("p.png"), folder.path().join("out/2.npy")).unwrap();
    fs::write(folder.path().join("lines"), line.repeat(2)).unwrap();
    let args =
        ["batch", "--no-limits", "--method", "naive", "--data", "out", "--size", "8", "--threads", "1"];
    let before = fs::read(folder.path().join("out/2.npy")).unwrap();
    let lines = File::open(folder.path().join("lines")).unwrap();
    let output = program(folder.path(), &args).stdin(lines).output().unwrap();
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(said.lines().nth(1).unwrap().contains("writing it would destroy it"), "{said}");
    assert_eq!(fs::read(folder.path().join("out/2.npy")).unwrap(), before);
    assert!(
        contents(folder.path()).iter().any(|(name, _)| name.ends_with("out/1.npy")),
        "the other line is solved"
    );
}

#[test]
fn a_picture_without_a_display_is_not_overwritten_by_a_sheet() {
    let folder = folder_with(&[("sonoglyph.png", SCENE)]);
    let message = refused(folder.path(), &mut program(folder.path(), &["sonoglyph.png"]));
    assert!(message.contains("only the window reads this"), "{message}");
    assert_eq!(fs::read_to_string(folder.path().join("sonoglyph.png")).unwrap(), SCENE);
}
