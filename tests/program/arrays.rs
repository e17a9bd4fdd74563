//! Arrays in scene files: refusals, and results of boards and element tables.

use std::fs;
use std::path::Path;

use serde_json::Value;
use sonoglyph::scene::file;

use crate::process::{folder_with, refuse, run, succeed};

const CURVED: &str = "format = 1\n[array]\nelements = \"e.csv\"\n[[target]]\nat = [0.0, 0.0, 0.1]\n";
const ELEMENTS: &str = "x,y,z,nx,ny,nz\n0,0,0,0,0,2\n0.03,0,0.01,-0.3,0,1\n-0.03,0,0.01,0.3,0,1\n";

#[test]
fn elements_are_read_from_a_table_and_written_to_one() {
    let folder = folder_with(&[("a.toml", CURVED), ("e.csv", ELEMENTS)]);
    succeed(folder.path(), &["elements", "a.toml", "-o", "b.csv"]);
    fs::write(folder.path().join("b.toml"), CURVED.replace("e.csv", "b.csv")).unwrap();
    let solved = |scene: &str| -> Value {
        serde_json::from_str(&succeed(folder.path(), &["solve", scene, "--json"])).unwrap()
    };
    let (a, b) = (solved("a.toml"), solved("b.toml"));
    assert_eq!(a["elements"], 3);
    // Directions are normalised a second time.
    for (a, b) in a["phases"].as_array().unwrap().iter().zip(b["phases"].as_array().unwrap()) {
        assert!((a.as_f64().unwrap() - b.as_f64().unwrap()).abs() < 1e-12, "{a} is not {b}");
    }
    fs::write(
        folder.path().join("p.toml"),
        CURVED.replace("e.csv", "preset:tinylev-72").replace("0.1]", "0.0]"),
    )
    .unwrap();
    assert_eq!(solved("p.toml")["elements"], 72);
    assert!(succeed(folder.path(), &["elements", "p.toml"]).lines().count() == 73);
}

/// 16 x 16 places with a pitch of 10.5 mm, in mm.
fn places() -> impl Iterator<Item = [f64; 2]> {
    let at = |n: i32| 10.5 * (f64::from(n) - 7.5);
    (0..256).map(move |n| [at(n % 16), at(n / 16)])
}

#[test]
fn arrays_of_other_programs_are_the_same_array() {
    let rows = |line: &dyn Fn(f64, f64) -> String| places().map(|[x, y]| line(x, y)).collect::<String>();
    let pos = |x: f64, y: f64| format!("<pos Name=\"p\" x=\"{}\" y=\"{}\" z=\"0\"/>\n", x / 1e3, y / 1e3);
    let acoular = format!("<?xml version=\"1.0\"?>\n<MicArray>\n{}</MicArray>\n", rows(&pos));
    let savetxt = rows(&|x, y| format!("{:.18e} {:.18e} {:.18e}\n", x / 1e3, y / 1e3, 0.0));
    let german = rows(&|x, y| format!("{x};{y};0\n").replace('.', ","));
    let bare = rows(&|x, y| format!("{x},{y},0\n"));
    let folder = folder_with(&[
        ("grid.toml", "format = 1\n[[target]]\nat = [0.0, 0.0, 0.1]\n"),
        ("e.xml", &acoular),
        ("e.txt", &savetxt),
        ("e.csv", &format!("X [mm];Y [mm];Z [mm]\n{german}")),
        ("bare.csv", &format!("x,y,z\n{bare}")),
        ("sheet.xlsx", "PK\u{3}\u{4}[Content_Types].xml"),
        ("far.csv", "x,y,z\n0,0,100\n"),
        ("near.csv", "x/mm;y/mm;z/mm\n0;0;100\n"),
        ("metres.toml", "format = 1\n[array]\npitch = 10.5\n[[target]]\nat = [0.0, 0.0, 100.0]\n"),
    ]);
    let pressure = |scene: &str| -> f64 {
        let solved: Value =
            serde_json::from_str(&succeed(folder.path(), &["solve", scene, "--json"])).unwrap();
        solved["foci"][0]["pressure"].as_f64().unwrap_or_else(|| panic!("{solved}"))
    };
    let grid = pressure("grid.toml");
    for table in ["e.xml", "e.txt", "e.csv"] {
        fs::write(folder.path().join("a.toml"), CURVED.replace("e.csv", table)).unwrap();
        assert!((pressure("a.toml") / grid - 1.0).abs() < 1e-3, "{table}");
    }
    for (table, words) in [("bare.csv", "x [mm]"), ("sheet.xlsx", "this is an Excel workbook (.xlsx)")] {
        fs::write(folder.path().join("a.toml"), CURVED.replace("e.csv", table)).unwrap();
        let message = refuse(folder.path(), &["solve", "a.toml"]);
        assert!(message.contains("a.toml:3: array.elements") && message.contains(words), "{message}");
    }
    for (args, warns) in [
        (&["probe", "grid.toml", "--points", "far.csv"][..], true),
        (&["probe", "grid.toml", "--points", "near.csv"], false),
        (&["solve", "metres.toml"], true),
    ] {
        let output = run(folder.path(), args);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success() && said.contains("millimetres") == warns, "{args:?}: {said}");
    }
    // A board of rows and columns plays a table of its own places, in any order.
    fs::write(folder.path().join("a.toml"), CURVED.replace("e.csv", "e.txt")).unwrap();
    let port = ["--port", "virtual:acoustophoretic-512", "--profile", "acoustophoretic-512"];
    succeed(folder.path(), &[&["send", "a.toml", "--seconds", "0.2"], &port[..]].concat());
}

#[test]
fn invalid_tables_and_boards_are_refused_with_line_and_column() {
    let folder = folder_with(&[
        ("a.toml", CURVED),
        ("e.csv", "x,y,z,nx,ny,nz\n0,0,0,0,0,1\n0,zero,0,0,0,1\n"),
        ("none.toml", &CURVED.replace("e.csv", "none.csv")),
        ("preset.toml", &CURVED.replace("e.csv", "preset:none")),
        ("over.toml", "format = 1\n[[board]]\n[[board]]\nat = [0.05, 0, 0]\n"),
        ("series.toml", "format = 1\n[array]\nreflectivity = 1\n[[reflector]]\n"),
        ("p.csv", "x,y,z\n0,0,0.1\n"),
        ("two.toml", "format = 1\n[[board]]\n[[board]]\nat = [0, 0, 0.3]\n[[target]]\n"),
    ]);
    for (args, words) in [
        (&["solve", "a.toml"][..], &["a.toml:3: array.elements = \"e.csv\"", "e.csv:3: y = `zero`"][..]),
        (&["solve", "none.toml"], &["none.toml:3: array.elements", "none.csv"]),
        (&["solve", "preset.toml"], &["preset.toml:3", "tinylev-72"]),
        (&["probe", "over.toml", "--points", "p.csv"], &["over.toml:4: board[2].at", "overlaps board 1"]),
        (
            &["probe", "series.toml", "--points", "p.csv"],
            &["series.toml:3: array.reflectivity", "not converge"],
        ),
        (
            &["send", "two.toml", "--port", "/dev/null", "--profile", "sonicsurface", "--board", "3"],
            &["--board 3", "the scene has 2"],
        ),
        (
            &["send", "two.toml", "--port", "/dev/null", "--profile", "sonicsurface"],
            &["2 boards of 16 x 16", "sonicsurface", "--port for each board"],
        ),
    ] {
        let message = refuse(folder.path(), args);
        assert!(words.iter().all(|word| message.contains(word)), "{args:?}: {message}");
    }
}

/// An OpenMPD board's file of four transducers: positions, pins, phases and amplitudes.
const PAT: &str = "FTMADEUP\n4\n128\n(-0.01,0.01,0),(0.01,0.01,0),(-0.01,-0.01,0),(0.01,-0.01,0),\n\
                   249,248,253,252,\n40,-140,-140,40,\n1,1,1,1,\n";

#[test]
fn boards_are_sent_to_by_their_wires_and_own_files() {
    let folder = folder_with(&[
        ("pat.toml", &CURVED.replace("e.csv", "b.pat")),
        ("b.pat", PAT),
        ("grid.toml", "format = 1\n[[target]]\n"),
        ("two.toml", "format = 1\n[[board]]\n[[board]]\nat = [0, 0, 0.3]\nnormal = [0, 0, -1]\n[[target]]\n"),
        ("small.toml", "format = 1\n[array]\nrows = 2\ncolumns = 2\nwiring = \"w.csv\"\n[[target]]\n"),
        ("w.csv", "element,channel\n0,255\n1,3\n"),
        ("far.toml", "format = 1\n[array]\nrows = 2\ncolumns = 2\nwiring = \"far.csv\"\n[[target]]\n"),
        ("far.csv", "element,channel\n0,255\n1,256\n"),
    ]);
    let send = |scene: &str, profile: &str, ports: usize| {
        let port = format!("virtual:{profile}");
        let ports = ["--port", &port].repeat(ports);
        run(folder.path(), &[&["send", scene, "--profile", profile, "--seconds", "0.2"], &ports[..]].concat())
    };
    const WITHOUT: &str = "0 to 19 % of the focus";
    for (scene, profile, ports, is_raw) in [
        ("pat.toml", "acoustophoretic-512", 1, false),
        ("grid.toml", "acoustophoretic-512", 1, true),
        ("two.toml", "acoustophoretic-512", 2, true),
        ("small.toml", "sonicsurface", 1, false),
    ] {
        let output = send(scene, profile, ports);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success() && said.contains(WITHOUT) == is_raw, "{scene}: {said}");
        assert_eq!(String::from_utf8_lossy(&output.stdout).lines().count(), ports, "{scene}");
    }
    let output = send("far.toml", "sonicsurface", 1);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("far.csv:3: channel 256 is out of range: sonicsurface has 0-255"), "{said}");
}

#[test]
fn boards_that_face_away_and_slow_series_give_warnings() {
    let folder = folder_with(&[
        ("away.toml", "format = 1\n[[board]]\n[[board]]\nat = [0, 0, 0.3]\n[[target]]\nat = [0, 0, 0.1]\n"),
        (
            "slow.toml",
            "format = 1\n[array]\nrows = 2\ncolumns = 2\nreflectivity = 1\n[liquid]\nreflects = true\n[[target]]\n",
        ),
    ]);
    for (scene, words) in [("away.toml", "Board 2 faces away"), ("slow.toml", "converge slowly")] {
        let output = run(folder.path(), &["solve", scene]);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success() && said.contains(words), "{scene}: {said}");
    }
}

fn refused(text: &str) -> String {
    file::parse(&format!("format = 1\n{text}"), Path::new("a.toml")).unwrap_err().to_string()
}

#[test]
fn impossible_geometry_is_refused_with_its_line() {
    for (text, start, what) in [
        ("[[board]]\n[[board]]\nat = [0.1, 0, 0]", "a.toml:4: board[2].at = ", "overlaps board 1"),
        ("[[board]]\n[[board]]\nnormal = [1, 0, 0]\nx_axis = [0, 1, 0]", "a.toml:3: board[2].at", "overlaps"),
        ("[[board]]\nnormal = [0, 0, 0]", "a.toml:3: board[1].normal", "must be a direction"),
        ("[[board]]\nnormal = [2, 0, 0]", "a.toml:2: board[1].x_axis", "runs along `normal`"),
        ("[[reflector]]\npoint = [0, 0, -0.1]", "a.toml:3: reflector[1].point", "board 1 lies behind it"),
        ("[[reflector]]\npoint = [0, 0, 0]\nnormal = [1, 0, 0]", "a.toml:3: reflector[1]", "is cut by it"),
        ("[[reflector]]\npoint = [0, 0, 0]\nnormal = [0, 0, 1]", "a.toml:3: reflector[1]", "lies in it"),
        ("[[reflector]]\ncoefficient = 1.5", "a.toml:3: reflector[1].coefficient = 1.5", "from -1 to 1"),
        ("[array]\nreflectivity = 2", "a.toml:3: array.reflectivity = 2", "from -1 to 1"),
        ("[array]\nreflectivity = -1\n[[reflector]]", "a.toml:3: array.reflectivity = -1", "not converge"),
        ("[liquid]\nreflects = true\n[plane]\ny_axis = [0, 0, 1]", "a.toml:3: liquid.reflects", "level"),
        ("[array]\nrows = 200\ncolumns = 200\n[[board]]\n[[board]]\nat = [9, 0, 0]", "a.toml:", "80000"),
        ("[array]\noff = [600]\n[[board]]\n[[board]]\nat = [9, 0, 0]", "a.toml:3: array.off[1]", "0 to 511"),
        (
            "[[board]]\n[[board]]\nat = [0, 0, 1]\n[[target]]\nat = [0, 0, -1]",
            "a.toml:5: target[1]",
            "every board",
        ),
    ] {
        let error = refused(text);
        assert!(error.starts_with(start) && error.contains(what), "{text}: {error}");
    }
}

#[test]
fn adjacent_boards_do_not_overlap() {
    let text = "format = 1\n[[board]]\n[[board]]\nat = [0.168, 0, 0]\n[[board]]\nat = [0, 0, 0.001]\n";
    assert!(file::parse(text, Path::new("a.toml")).is_ok());
    let scene = file::parse(&text.replace("0.001", "0.2"), Path::new("a.toml")).unwrap();
    assert_eq!(scene.elements(), 768);
    let again = file::parse(&file::write(&scene), Path::new("b.toml")).unwrap();
    assert_eq!(again, scene);
}
