//! Wirings as data: the bytes for arrays of any size and order, decoded by published tables or by the wiring file.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::fs;
use std::path::Path;

use glam::{DVec2, DVec3, dvec3};
use num_complex::Complex64;
use serde_json::Value;
use sonoglyph::device::calibration::Calibration;
use sonoglyph::device::levels::Levels;
use sonoglyph::device::native::packet::Packet;
use sonoglyph::device::profile::Profile;
use sonoglyph::device::stock;
use sonoglyph::device::wiring::{Share, Wiring};
use sonoglyph::scene::Scene;
use sonoglyph::solver;
use sonoglyph::studio::opening;

use crate::numbers;
use crate::published::channels;

const FOCUS: DVec3 = dvec3(0.03, -0.02, 0.1);
/// rad/m in the program's air at 20 °C, 343.2 m/s.
const WAVENUMBER: f64 = TAU * 40_000.0 / 343.2;

/// A scene file with others beside it.
fn scene(array: &str, more: &str, files: &[(&str, String)]) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        fs::write(folder.path().join(name), text).unwrap();
    }
    let [x, y, z] = FOCUS.to_array();
    let text = format!(
        "format = 1\n[array]\n{array}\n{more}\n[medium]\nsound_speed = 343.2\n[[target]]\nat = [{x}, {y}, {z}]\n"
    );
    let path = folder.path().join("s.toml");
    fs::write(&path, text).unwrap();
    opening::open(&path).unwrap()
}

fn levels(profile: Profile, scene: &Scene, share: Share) -> Levels {
    let drive = solver::solve(scene).unwrap().drive;
    Wiring::of(profile, scene, share).unwrap().levels(&drive, &Calibration::of(scene)).unwrap()
}

fn bytes(levels: &Levels) -> Vec<u8> {
    match levels.profile {
        Profile::Native => Packet::playing(levels, 0, true).to_line(),
        _ => stock::frame(levels),
    }
}

/// |sum| of the sound of elements at these places at the focus, relative to the sum in phase; distances count alike.
fn coherence(played: &[(DVec3, Complex64)]) -> f64 {
    let arrives = |(at, plays): &(DVec3, Complex64)| plays * Complex64::cis(-WAVENUMBER * at.distance(FOCUS));
    let sum: Complex64 = played.iter().map(arrives).sum();
    sum.norm() / played.iter().map(|(_, plays)| plays.norm()).sum::<f64>()
}

/// Shuffled channels of a board for elements in order, as the rows of a file in another order.
fn shuffled(elements: usize, board: usize, seed: u32) -> (Vec<usize>, String) {
    let mut number = numbers(seed);
    let mut channels: Vec<_> = (0..board).collect();
    for n in (1..board).rev() {
        channels.swap(n, (number() * n as f64) as usize);
    }
    channels.truncate(elements);
    let rows: Vec<_> = channels.iter().enumerate().map(|(n, channel)| format!("{channel},{n},u\n")).collect();
    (
        channels,
        format!("# by hand\nchannel,element,remark\n{}", rows.iter().rev().cloned().collect::<String>()),
    )
}

/// A table of elements on a disc, as an AUTD is no grid.
fn table(elements: usize) -> String {
    let place = |n: usize| {
        let (radius, angle) = (0.0065 * (n as f64 + 0.5).sqrt(), 2.399_963 * n as f64);
        format!("{},{},0,0,0,1\n", radius * angle.cos(), radius * angle.sin())
    };
    format!("x,y,z,nx,ny,nz\n{}", (0..elements).map(place).collect::<String>())
}

fn places(scene: &Scene) -> Vec<DVec3> {
    let grid = |n: usize| {
        let (columns, rows) = (scene.array.columns as usize, scene.array.rows as usize);
        let middle = DVec2::new((columns - 1) as f64, (rows - 1) as f64) / 2.0;
        ((DVec2::new((n % columns) as f64, (n / columns) as f64) - middle) * scene.array.pitch).extend(0.0)
    };
    match scene.array.placed.get() {
        Some(placed) => placed.iter().map(|it| it.at).collect(),
        None => (0..scene.array.elements()).map(grid).collect(),
    }
}

#[test]
fn any_array_plays_on_any_board_by_its_wiring() {
    let grid = |columns: usize, rows: usize| format!("columns = {columns}\nrows = {rows}\n");
    for (profile, array, elements) in [
        (Profile::SonicSurface, grid(8, 8), 64),
        (Profile::SonicSurface, grid(10, 10), 100),
        (Profile::SonicSurface, "elements = \"e.csv\"\n".to_owned(), 249),
        (Profile::UltrainoMega64, grid(7, 1), 7),
        (Profile::UltrainoMega64, "elements = \"e.csv\"\n".to_owned(), 64),
        (Profile::UltrainoSimpleFpga, grid(10, 10), 100),
        (Profile::Acoustophoretic512, grid(10, 10), 100),
        (Profile::Acoustophoretic512, "elements = \"e.csv\"\n".to_owned(), 249),
        (Profile::Native, "elements = \"e.csv\"\n".to_owned(), 249),
        (Profile::Native, grid(16, 16), 256),
    ] {
        let (wires, csv) = shuffled(elements, profile.elements(), elements as u32);
        let files = [("e.csv", table(elements)), ("w.csv", csv)];
        let scene = scene(&array, "wiring = \"w.csv\"", &files);
        let plays = channels(profile, &bytes(&levels(profile, &scene, Share::default())));
        let played: Vec<_> = places(&scene).into_iter().zip(wires.iter().map(|&own| plays[own])).collect();
        let part = coherence(&played);
        // Of few elements with ten phases, some are far off.
        let least = if profile == Profile::UltrainoMega64 { 0.95 } else { 0.98 };
        assert!(part > least, "{} of {elements}: {part}", profile.name());
        let silent = (0..plays.len()).filter(|channel| !wires.contains(channel));
        assert!(silent.into_iter().all(|channel| plays[channel].norm() == 0.0), "{}", profile.name());
    }
}

#[test]
fn several_boards_begin_at_their_own_first_channels() {
    let boards = "[[board]]\n[[board]]\nat = [0.3, 0, 0]";
    let scene = scene("columns = 10\nrows = 10", boards, &[]);
    let channel = |profile, share, element: usize| {
        let one = Wiring::of(profile, &scene, share).unwrap().one(element);
        one.channels.iter().position(Option::is_some)
    };
    let alone = Share::default();
    assert_eq!([99, 100, 199].map(|n| channel(Profile::Natives(2), alone, n)), [99, 256, 355].map(Some));
    assert_eq!([99, 100, 199].map(|n| channel(Profile::Native, alone, n)), [99, 100, 199].map(Some));
    let second = Share { index: 1, of: 2 };
    assert_eq!([99, 100, 199].map(|n| channel(Profile::Native, second, n)), [None, Some(0), Some(99)]);
    let refused = Wiring::of(Profile::SonicSurface, &scene, alone).unwrap_err().to_string();
    assert!(refused.contains("2 boards of 10 x 10") && refused.contains("array.wiring"), "{refused}");
}

#[test]
fn native_drives_small_arrays_without_a_wiring() {
    for (array, elements) in [
        ("columns = 8\nrows = 8", 64),
        ("columns = 10\nrows = 10", 100),
        ("columns = 7\nrows = 1", 7),
        ("elements = \"preset:autd3-249\"", 249),
    ] {
        let scene = scene(array, "", &[]);
        let plays = channels(Profile::Native, &bytes(&levels(Profile::Native, &scene, Share::default())));
        let places = places(&scene);
        assert_eq!(places.len(), elements);
        let played: Vec<_> =
            places.iter().map(|&at| DVec3::new(at.x, at.y, at.z)).zip(plays.clone()).collect();
        assert!(coherence(&played) > 0.999, "{array}: {}", coherence(&played));
        assert!(plays[elements..].iter().all(|plays| plays.norm() == 0.0), "{array}");
    }
}

/// Elements without a wire cannot sound: they are left out of the solution.
#[test]
fn unwired_elements_are_off_in_the_solution() {
    let csv = "element,channel\n".to_owned() + &(0..60).map(|n| format!("{n},{n}\n")).collect::<String>();
    let scene = scene("columns = 8\nrows = 8", "off = [5]\nwiring = \"w.csv\"", &[("w.csv", csv)]);
    let drive = solver::solve(&scene).unwrap().drive;
    let off: Vec<_> = (0..64).filter(|&n| drive.amplitudes[n] == 0.0).collect();
    assert_eq!(off, [5, 60, 61, 62, 63]);
    let without = Scene { array: sonoglyph::scene::Array { off, ..scene.array.clone() }, ..scene };
    assert_eq!(solver::solve(&without).unwrap().drive, drive);
}

/// A made-up file with the statistics of the published ones (OpenMPD_Client/board_0 to 37): half of the transducers
/// about 180° from the others, and 10° of spread about each; order, axes and pins as in them.
fn board_file(seed: u32, shift: f64, amplitude: f64) -> (String, Vec<(DVec3, usize, f64)>) {
    let source =
        fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference/board_places.json"));
    let sources: Value = serde_json::from_str(&source.unwrap()).unwrap();
    let source = &sources["acoustophoretic-512"];
    let mut number = numbers(seed);
    let mut transducers = Vec::new();
    let pairs = source["places"].as_array().unwrap().iter().zip(source["channels"].as_array().unwrap());
    for (place, channel) in pairs {
        let at = DVec3::new(place[0].as_f64().unwrap(), place[1].as_f64().unwrap(), 0.0) * 1e-3;
        let mounted = if number() < 0.5 { 0.0 } else { 180.0 };
        let spread: f64 = (0..6).map(|_| number() - 0.5).sum::<f64>() * 14.0;
        let adjust = (shift + mounted + spread + 180.0_f64).rem_euclid(360.0) - 180.0;
        transducers.push((at, channel.as_u64().unwrap() as usize, adjust.round()));
    }
    let list = |value: &dyn Fn(&(DVec3, usize, f64)) -> String| -> String {
        transducers.iter().map(|it| value(it) + ",").collect()
    };
    let text = format!(
        "FTMADEUP\n256\n128\n{}\n{}\n{}\n{}\n",
        list(&|(at, ..)| format!("({:.6}, {:.6}, {:.6})", at.x, at.y, at.z)),
        list(&|(_, channel, _)| channel.to_string()),
        list(&|(.., adjust)| adjust.to_string()),
        list(&|_| format!("{amplitude:.6}")),
    );
    (text, transducers)
}

/// What arrives when the transducers lag by their own phases: `CommandReader.vhd` and `MuxPhase.vhd`, in the tests'
/// own decoder.
fn heard(bytes: &[u8], transducers: &[(DVec3, usize, f64)]) -> f64 {
    let plays = channels(Profile::Acoustophoretic512, bytes);
    let own = |&(at, channel, adjust): &(DVec3, usize, f64)| {
        (at, plays[channel] * Complex64::cis(-adjust.to_radians()))
    };
    coherence(&transducers.iter().map(own).collect::<Vec<_>>())
}

#[test]
fn openmpd_boards_focus_with_their_own_file_only() {
    let profile = Profile::Acoustophoretic512;
    let mut least: f64 = 1.0;
    let mut without: f64 = 0.0;
    for seed in 1..=38 {
        let (text, transducers) = board_file(seed, [-30.0, 60.0, 145.0][seed as usize % 3], 1.0);
        let own = scene("elements = \"b.pat\"", "", &[("b.pat", text.clone())]);
        least = least.min(heard(&bytes(&levels(profile, &own, Share::default())), &transducers));
        // The program's own numbering, with the file as a calibration.
        let grid = scene("", "", &[]);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("b.pat");
        fs::write(&path, text).unwrap();
        let calibration = Calibration::read(&path, &grid).unwrap();
        let drive = solver::solve(&grid).unwrap().drive;
        let wiring = Wiring::of(profile, &grid, Share::default()).unwrap();
        let of = |calibration| bytes(&wiring.levels(&drive, calibration).unwrap());
        least = least.min(heard(&of(&calibration), &transducers));
        without = without.max(heard(&of(&Calibration::default()), &transducers));
    }
    println!("coherence at the focus: {least:.4} at least with the files, {without:.3} at most without");
    assert!(least > 0.99, "{least}");
    assert!(without < 0.25, "{without}");
}

#[test]
fn a_pat_is_matched_by_position_and_others_are_refused() {
    let (text, transducers) = board_file(3, 60.0, 0.5);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("b.pat");
    fs::write(&path, &text).unwrap();
    let grid = scene("pitch = 0.0103", "", &[]);
    let calibration = Calibration::read(&path, &grid).unwrap();
    for (n, at) in places(&grid).iter().enumerate() {
        let nearest = transducers.iter().min_by(|a, b| a.0.distance(*at).total_cmp(&b.0.distance(*at)));
        let (amplitude, phase) = calibration.corrected(n, 1.0, 0.0);
        assert!(amplitude == 0.5 && (phase.to_degrees() - nearest.unwrap().2).abs() < 1e-9, "{n}");
    }
    for (array, more, words) in [
        ("columns = 8\nrows = 32", "", "line 4: no place is that of element"),
        ("columns = 8\nrows = 8", "", "line 4: 256 places, and the array has 64"),
        ("", "[[board]]\n[[board]]\nat = [0, 0, 0.3]\nnormal = [0, 0, -1]", "give each board its own file"),
    ] {
        let error = Calibration::read(&path, &scene(array, more, &[])).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
    for (from, to, words) in [
        ("FTMADEUP\n256", "FTMADEUP\n255", "4: 256 places for 255 elements"),
        ("249,253,", "249,249,", "5: pin 249 is that of the transducers 0 and 1"),
        ("249,253,", "249,", "5: 255 pins for 256 elements"),
        ("0.500000,", "1.500000,", "7: amplitude 0 is 1.5, not from 0 to 1"),
        ("249,253,", "249,one,", "5: `one` in the list of pins: not a number"),
    ] {
        assert!(text.contains(from));
        fs::write(&path, text.replacen(from, to, 1)).unwrap();
        let error = Calibration::read(&path, &scene("", "", &[])).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
}

/// Two boards face to face, each at its own port with its own file.
#[test]
fn two_openmpd_boards_have_an_order_and_phases_each() {
    let profile = Profile::Acoustophoretic512;
    let folder = tempfile::tempdir().unwrap();
    let boards = "[[board]]\n[[board]]\nat = [0, 0, 0.2388]\nnormal = [0, 0, -1]\nx_axis = [-1, 0, 0]";
    let both = scene("", boards, &[]);
    let one = Scene { boards: Vec::new(), ..both.clone() };
    let drive = solver::solve(&both).unwrap().drive;
    let files: Vec<_> = [7, 8].map(|seed| board_file(seed, 40.0 * f64::from(seed), 1.0)).into();
    let read = |(text, _): &(String, _)| {
        let path = folder.path().join("board.pat");
        fs::write(&path, text).unwrap();
        Some(Calibration::read(&path, &one).unwrap())
    };
    let calibration = Calibration::of_boards(files.iter().map(read), 256);
    // The first as its driver has it, and upside down: local x and z against the world's.
    let worlds = [|at: DVec3| at, |at: DVec3| DVec3::new(-at.x, at.y, 0.2388 - at.z)];
    let mut sum = Vec::new();
    for (index, world) in worlds.into_iter().enumerate() {
        let wiring = Wiring::of(profile, &both, Share { index, of: 2 }).unwrap();
        let plays = channels(profile, &bytes(&wiring.levels(&drive, &calibration).unwrap()));
        let own = |&(at, channel, adjust): &(DVec3, usize, f64)| {
            (world(at), plays[channel] * Complex64::cis(-adjust.to_radians()))
        };
        sum.extend(files[index].1.iter().map(own));
    }
    assert!(sum.len() == 512 && coherence(&sum) > 0.99, "{}", coherence(&sum));
    // A wiring of the user for both: channel 256 board + c.
    let csv: String = (0..512).map(|n| format!("{n},{}\n", 256 * (n / 256) + 255 - n % 256)).collect();
    let own = scene("wiring = \"w.csv\"", boards, &[("w.csv", format!("element,channel\n{csv}"))]);
    for index in 0..2 {
        let wiring = Wiring::of(profile, &own, Share { index, of: 2 }).unwrap();
        let board: Vec<_> = wiring.wired().collect();
        assert!(board.into_iter().eq(256 * index..256 * (index + 1)));
        assert!(wiring.one(256 * index).channels[255].is_some());
    }
    assert!(Wiring::of(profile, &own, Share::default()).unwrap_err().to_string().contains("channel 511"));
}

/// The second PCB: `AsiersMapping` of `SerialNumberList.h` as its driver uses it, x fastest, rows from the largest y.
#[test]
fn the_second_pcb_is_a_preset() {
    let scene = scene("wiring = \"preset:acoustophoretic-512-asier\"", "", &[]);
    let wiring = Wiring::of(Profile::Acoustophoretic512, &scene, Share::default()).unwrap();
    let channel = |element| wiring.one(element).channels.iter().position(Option::is_some).unwrap();
    assert_eq!([240, 241, 242, 243, 244].map(channel), [199, 198, 196, 197, 135]);
    assert_eq!([224, 225, 226, 227].map(channel), [194, 195, 192, 193]);
    assert_eq!([0, 1, 2, 3, 15].map(channel), [250, 251, 248, 249, 57]);
    let own = Wiring::of(Profile::Acoustophoretic512, &Scene::default(), Share::default()).unwrap();
    assert_eq!(own, Wiring::own(Profile::Acoustophoretic512));
    assert_ne!(own, wiring);
}

#[test]
fn wires_that_make_no_sense_are_refused_with_their_line() {
    let opened = |csv: &str| -> BTreeMap<&str, String> {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("w.csv"), csv).unwrap();
        let text = "format = 1\n[array]\ncolumns = 2\nrows = 2\nwiring = \"w.csv\"\n[[target]]\n";
        let path = folder.path().join("s.toml");
        fs::write(&path, text).unwrap();
        let mut said = BTreeMap::new();
        match opening::open(&path) {
            Err(error) => said.insert("open", error.to_string()),
            Ok(scene) => {
                let wiring = Wiring::of(Profile::SonicSurface, &scene, Share::default());
                said.insert("send", wiring.map_or_else(|error| error.to_string(), |_| "fits".to_owned()))
            }
        };
        said
    };
    for (csv, when, words) in [
        ("element,channel\n0,1\n1,255\n", "send", "fits"),
        (
            "element,channel\n0,1\n\n1,256\n",
            "send",
            "w.csv:4: channel 256 is out of range: sonicsurface has 0-255",
        ),
        ("element,channel\n0,1\n0,2\n", "open", "w.csv:3: element 0 is already wired in line 2"),
        ("element,channel\n0,1\n3,1\n", "open", "w.csv:3: channel 1 is already wired in line 2"),
        ("element,channel\n4,1\n", "open", "w.csv:2: element 4 is out of range (0-3)"),
        ("element,channel\n-1,1\n", "open", "w.csv:2: element -1 is out of range (0-3)"),
        ("element,channel\n0,0.5\n", "open", "w.csv:2: channel 0.5 is out of range (0-65535)"),
        ("element,channel\n0,one\n", "open", "w.csv:2: channel = `one`: not a finite number"),
        ("element,channel\n", "open", "w.csv:1: no element is wired"),
        ("element,pin\n0,0\n", "open", "w.csv:1: the column `channel` is missing"),
    ] {
        let said = opened(csv);
        let message = said.get(when).unwrap_or_else(|| panic!("{csv}: {said:?}"));
        assert!(message.contains(words), "{csv:?}: {message}");
        assert!(when == "send" || message.contains("s.toml:5: array.wiring = \"w.csv\""), "{message}");
    }
}
