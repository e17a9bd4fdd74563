//! Drives from files: shown, judged, flown and sent instead of solved ones.

use std::f64::consts::{PI, SQRT_2, TAU};
use std::fs;
use std::path::Path;

use num_complex::Complex64;
use serde_json::Value;

use crate::process::{folder_with, output_of, refuse, run, succeed};

const SPEED: f64 = 343.2;
/// Pa·m
const STRENGTH: f64 = 2.4;
/// A TinyLev without loss in air; its target is where both halves are heard alike.
const TINYLEV: &str = "format = 1
[medium]
sound_speed = 343.2
absorption = 0.0
[array]
elements = \"preset:tinylev-72\"
element = \"point\"
strength = 2.4
[[target]]
at = [0.001, 0.0, 0.002]
[plane]
centre = [0.0, 0.0, 0.0]
x_axis = [1.0, 0.0, 0.0]
y_axis = [0.0, 0.0, 1.0]
size = [0.02, 0.02]
";

/// Positions (m) of the array's published table.
fn positions() -> Vec<[f64; 3]> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/arrays/tinylev-72.csv");
    let text = fs::read_to_string(path).unwrap();
    let rows = text.lines().filter(|line| !line.starts_with(['#', 'x']));
    let place = |row: &str| {
        let mut numbers = row.split(',').map(|number| number.parse().unwrap());
        [0, 1, 2].map(|_| numbers.next().unwrap())
    };
    rows.map(place).collect()
}

/// Two channels: the lower half in phase, and the upper half at this phase.
fn halves(upper: f64) -> Vec<Complex64> {
    positions().iter().map(|[.., z]| Complex64::cis(if *z < 0.0 { 0.0 } else { upper })).collect()
}

/// The peak pressure (Pa) at a point, from the formula of a point source.
fn pressure(u: &[Complex64], at: [f64; 3]) -> Complex64 {
    let k = TAU * 40e3 / SPEED;
    let one = |(u, place): (&Complex64, [f64; 3])| {
        let r = (0..3).map(|axis| (at[axis] - place[axis]).powi(2)).sum::<f64>().sqrt();
        u * Complex64::from_polar(STRENGTH / r, PI / 2.0 - k * r)
    };
    u.iter().zip(positions()).map(one).sum()
}

/// Without an element table's z, from the last element to the first, with a remark.
fn file_of(drives: &[Vec<Complex64>]) -> String {
    let mut text = "# two channels\nframe;phase;y;remark;element;x;amplitude\n".to_owned();
    for (frame, u) in drives.iter().enumerate() {
        for (element, (u, [x, y, _])) in u.iter().zip(positions()).enumerate().rev() {
            text += &format!("{frame};{};{y};a;{element};{x};{}\n", u.arg() + TAU, u.norm());
        }
    }
    text
}

fn json(folder: &Path, args: &[&str]) -> Value {
    serde_json::from_str(&succeed(folder, args)).unwrap()
}

#[test]
fn own_drive_is_shown_judged_flown_and_sent() {
    let (u, alike) = (halves(PI), halves(0.0));
    let silent_in_part: Vec<_> = u.iter().map(|u| 0.5 * u).collect();
    let folder = folder_with(&[
        ("t.toml", TINYLEV),
        ("bare.toml", &TINYLEV.replace("[[target]]\nat = [0.001, 0.0, 0.002]\n", "")),
        ("own.csv", &file_of(std::slice::from_ref(&silent_in_part))),
        ("alike.csv", &file_of(&[alike])),
        ("points.csv", "x,y,z\n0.001,0,0.002\n0.0,0.003,-0.004\n"),
    ]);
    let folder = folder.path();
    let at = |place| pressure(&silent_in_part, place);
    // Figures at the target, and nothing of a solver.
    let solved = json(folder, &["solve", "t.toml", "--drive", "own.csv", "--json", "--csv", "again.csv"]);
    let focus = &solved["foci"][0];
    let expected = at([0.001, 0.0, 0.002]);
    assert_eq!(solved["method"], "drive");
    assert!(
        (focus["pressure"].as_f64().unwrap() / expected.norm() - 1.0).abs() < 1e-9,
        "{focus}: {expected}"
    );
    assert!((focus["phase"].as_f64().unwrap() - expected.arg()).abs() < 1e-8, "{focus}: {expected}");
    assert_eq!(solved["quality"]["efficiency"], 1.0);
    let said = succeed(folder, &["solve", "t.toml", "--drive", "again.csv"]);
    assert!(said.contains("again.csv, nothing is solved") && said.contains("72 of 72, at 50.00 %"), "{said}");
    // The same at points.
    let probed = succeed(folder, &["probe", "t.toml", "--points", "points.csv", "--drive", "own.csv"]);
    for (row, place) in probed.lines().skip(1).zip([[0.001, 0.0, 0.002], [0.0, 0.003, -0.004]]) {
        let numbers: Vec<f64> = row.split(',').map(|number| number.parse().unwrap()).collect();
        assert!(
            (Complex64::new(numbers[3], numbers[4]) - at(place)).norm() < 1e-9 * at(place).norm(),
            "{row}"
        );
    }
    // A map, also without targets, and the file's amplitudes.
    for scene in ["t.toml", "bare.toml"] {
        let args = ["--drive", "own.csv", "--data", "o.npy", "--size", "20", "--tolerance", "exact"];
        succeed(folder, &[&["render", scene, "-o", "o.png"][..], &args].concat());
        let map: Vec<f32> =
            npyz::NpyFile::new(&fs::read(folder.join("o.npy")).unwrap()[..]).unwrap().into_vec().unwrap();
        for (column, row) in [(3, 4), (10, 9), (17, 12)] {
            let [x, z] = [column, row].map(|pixel| (f64::from(pixel) + 0.5) * 0.001 - 0.01);
            let rms = at([x, 0.0, z]).norm() / SQRT_2;
            let drawn = f64::from(map[(row * 20 + column) as usize]);
            assert!((drawn - rms).abs() < 1e-4 * 2000.0, "{scene} {x} {z}: {drawn} and {rms}");
        }
        for quantity in ["sheet", "drive", "gorkov"] {
            succeed(
                folder,
                &["render", scene, "-o", "page.png", "--drive", "own.csv", "--quantity", quantity],
            );
        }
    }
    let no_target = refuse(folder, &["solve", "bare.toml", "--drive", "own.csv"]);
    assert!(no_target.contains("no target"), "{no_target}");
    // In antiphase the centre is a node, which holds the bead; in phase it is pushed away.
    let flown = |drive| json(folder, &["levitate", "t.toml", "--drive", drive, "--from", "0,0,0", "--json"]);
    let (held, lost) = (flown("own.csv"), flown("alike.csv"));
    assert_eq!(held["stays"], true, "{held}");
    assert!(held["at"][2].as_f64().unwrap().abs() < 1e-3, "{held}");
    assert!(lost["at"][2].as_f64().unwrap().abs() > 1e-3, "{lost}");
}

#[cfg(unix)]
#[test]
fn own_drive_is_sent_with_its_levels() {
    let scene = "format = 1\n[[target]]\nat = [0, 0, 0.1]\n";
    let phase = |element: usize| TAU * (element % 16) as f64 / 16.0;
    let rows: String = (0..256).map(|element| format!("{}\n", phase(element))).collect();
    let folder = folder_with(&[("a.toml", scene), ("own.csv", &format!("phase\n{rows}"))]);
    let args = ["send", "a.toml", "--port", "virtual:native", "--profile", "native", "--drive", "own.csv"];
    let (said, _) = output_of(folder.path(), &args);
    assert!(said.contains("frames"), "{said}");
    let args = ["send", "a.toml", "--port", "virtual:native", "--profile", "native", "--method", "focus"];
    let both = refuse(folder.path(), &[&args[..], &["--drive", "own.csv"]].concat());
    assert!(both.contains("--method") && both.contains("--drive"), "{both}");
}

#[test]
fn own_drives_are_frames_with_times_and_turns_without() {
    let moving =
        "format = 1\n[[target]]\nat = [0, 0, 0.1]\n[motion]\npath = \"circle\"\nframes = 6\nrate = 2.0\n";
    let still = "format = 1\n[[target]]\nat = [0, 0, 0.1]\n";
    let folder = folder_with(&[("m.toml", moving), ("s.toml", still), ("points.csv", "x,y,z\n0,0,0.1\n")]);
    let folder = folder.path();
    succeed(folder, &["solve", "m.toml", "--motion", "--csv", "frames.csv"]);
    let wide = fs::read_to_string(folder.join("frames.csv")).unwrap();
    let rows = wide.lines().skip(1).map(|row| row.split(',').skip(2).map(str::to_owned).collect::<Vec<_>>());
    let rows: Vec<_> = rows.collect();
    let mut long = "phase,frame\n".to_owned();
    for (frame, row) in rows.iter().enumerate() {
        row.iter().for_each(|phase| long += &format!("{phase},{frame}\n"));
    }
    fs::write(folder.join("turns.csv"), long).unwrap();
    // Every frame of the film is that of the solved motion.
    let film = |name: &str, args: &[&str]| {
        succeed(folder, &[&["render", "m.toml", "-o", name, "--motion", "--size", "24"], args].concat());
        fs::read(folder.join(name)).unwrap()
    };
    let solved = film("solved.gif", &[]);
    assert_eq!(film("own.gif", &["--drive", "frames.csv"]), solved);
    assert_eq!(film("turns.gif", &["--drive", "turns.csv"]), solved);
    // A cycle of six frames: 12 a second by the file's times, also where nothing moves.
    let course = |scene: &str, drive: &str| {
        let args = ["probe", scene, "--points", "points.csv", "--time", "--drive", drive];
        output_of(folder, &args).1
    };
    assert!(course("s.toml", "frames.csv").contains("12.000 frames/s, 2.000 cycles/s"));
    assert!(course("m.toml", "turns.csv").contains("12.000 frames/s, 2.000 cycles/s"));
    assert!(!course("s.toml", "turns.csv").contains("12.000 frames/s"));
    // In turn, the mean counts.
    let value = json(folder, &["solve", "s.toml", "--drive", "turns.csv", "--json"]);
    assert_eq!(value["frames"].as_array().unwrap().len(), 6);
    let each = |frame: usize| {
        fs::write(folder.join("one.csv"), format!("phase\n{}\n", rows[frame].join("\n"))).unwrap();
        let one = json(folder, &["solve", "s.toml", "--drive", "one.csv", "--json"]);
        one["foci"][0]["pressure"].as_f64().unwrap().powi(2)
    };
    let mean = ((0..6).map(each).sum::<f64>() / 6.0).sqrt();
    assert!((value["foci"][0]["pressure"].as_f64().unwrap() / mean - 1.0).abs() < 1e-9);
}

#[test]
fn scene_and_batch_name_their_drive() {
    let rows: String = (0..256).map(|element| format!("{element},0.5\n")).collect();
    let named = "format = 1\ndrive = \"sub/own.csv\"\n[[target]]\nat = [0, 0, 0.1]\n";
    let folder = folder_with(&[("a.toml", named)]);
    fs::create_dir(folder.path().join("sub")).unwrap();
    fs::write(folder.path().join("sub/own.csv"), format!("element,phase\n{rows}")).unwrap();
    let own = json(folder.path(), &["solve", "a.toml", "--json"]);
    assert_eq!((&own["method"], &own["phases"][77]), (&"drive".into(), &0.5.into()));
    let solved = json(folder.path(), &["solve", "a.toml", "--method", "focus", "--json"]);
    assert_eq!(solved["method"], "focus");
    fs::write(folder.path().join("sub/part.csv"), "element,phase\n3,0\n").unwrap();
    let lines = "{\"drive\": \"sub/own.csv\", \"target\": [{}]}\n{\"drive\": \"sub/part.csv\", \"target\": [{}]}\n\
                 {\"drive\": \"gone.csv\"}\n";
    let answers = batch(folder.path(), lines);
    assert_eq!(answers[0]["quality"]["mean_pressure"], own["quality"]["mean_pressure"]);
    assert!(
        answers[1]["warnings"][0].as_str().unwrap().contains("no row for 255 of 256 elements"),
        "{}",
        answers[1]
    );
    assert!(answers[2]["error"].as_str().unwrap().contains("drive: gone.csv: "), "{}", answers[2]);
}

fn batch(folder: &Path, lines: &str) -> Vec<Value> {
    use std::io::Write;
    use std::process::Stdio;
    let mut batch = crate::process::program(folder, &["batch"]);
    let mut batch = batch.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    batch.stdin.take().unwrap().write_all(lines.as_bytes()).unwrap();
    let output = batch.wait_with_output().unwrap();
    String::from_utf8(output.stdout)
        .unwrap()
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect()
}

#[test]
fn a_file_without_a_drive_is_refused_by_its_line() {
    let scene = "format = 1\n[array]\nrows = 1\ncolumns = 2\n[[target]]\nat = [0, 0, 0.1]\n";
    let folder = folder_with(&[("a.toml", scene)]);
    for (text, error) in [
        ("phase\n0\n", "own.csv:2: the file has 1 rows, and the scene has 2 elements"),
        ("element,phase,amplitude\n0,0,1\n1,0,1.5\n", "own.csv:3: amplitude = 1.5: must be from 0 to 1"),
        ("element,phase\n1,0\n1,0\n", "own.csv:3: element 1 is given twice"),
        ("element,phase\n0,nan\n", "own.csv:2: phase = `nan`: not a finite number"),
        ("element,phase\n2,0\n", "own.csv:2: element = 2.0: the scene's elements are numbered 0 to 1"),
        ("x,y,phase\n0.1,0,0\n", "own.csv:2: element 0 is at (0.1, 0.0, 0.0) m, and the scene's at"),
        ("element,amplitude\n0,1\n", "own.csv:1: the column `phase` is missing"),
    ] {
        fs::write(folder.path().join("own.csv"), text).unwrap();
        for command in
            [&["solve", "a.toml"][..], &["levitate", "a.toml"], &["render", "a.toml", "-o", "o.png"]]
        {
            let refused = refuse(folder.path(), &[command, &["--drive", "own.csv"]].concat());
            assert!(refused.starts_with(&format!("error: {error}")), "{text:?}: {refused}");
        }
    }
    for other in [&["--method", "best"][..], &["--search", "1"], &["--motion"]] {
        let refused = refuse(folder.path(), &[&["solve", "a.toml", "--drive", "own.csv"], other].concat());
        assert!(refused.contains(other[0]) && refused.contains("--drive"), "{refused}");
    }
    assert!(!run(folder.path(), &["solve", "a.toml", "--drive", "gone.csv"]).status.success());
}
