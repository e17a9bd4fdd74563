//! Printed bounds ("at least", "no more than") are rounded outwards from the full values in JSON.

use crate::dice::Dice;
use crate::figures::program::{folder, number_after, scenes, solved};
use crate::process::output_of;

/// Three to eight foci, some with targets in pascals.
fn scene(number: usize) -> String {
    let mut dice = Dice::new(0xB0D, number);
    let in_pascals = dice.one_of(&[true, false]);
    let mut scene = "format = 1\n".to_owned();
    if in_pascals {
        scene += "[solver]\npressures = \"pascal\"\n";
    }
    for _ in 0..dice.one_of(&[3, 5, 8]) {
        let [x, y] = [0, 1].map(|_| dice.between(-0.04, 0.04));
        let pressure = if in_pascals { dice.between(500.0, 4000.0) } else { dice.between(0.5, 2.0) };
        scene += &format!("[[target]]\nat = [{x}, {y}, 0.1]\npressure = {pressure}\n");
    }
    scene
}

#[test]
fn bounds_are_rounded_outwards() {
    for number in 0..scenes() {
        let scene = scene(number);
        let folder = folder(&scene);
        let quality = &solved(folder.path())["quality"];
        let [bound, certified] = ["bound", "certified"].map(|key| quality[key].as_f64().unwrap());
        let (text, warned) = output_of(folder.path(), &["solve", "a.toml"]);
        let (printed, _) = number_after(&text, "fraction of the bound   at least ");
        // Two runs may differ in the last bits.
        let part = 100.0 * certified * (1.0 + 1e-12);
        assert!(printed <= part && printed > part - 0.0101, "{number}: {printed} % of {part} %: {scene}");
        let (printed, unit) = number_after(&text, "upper bound             ");
        let unit = if unit.starts_with(" kPa") {
            1e3
        } else if unit.starts_with(" %") {
            1e-2
        } else {
            1.0
        };
        assert!(printed * unit >= bound * (1.0 - 1e-12), "{number}: {printed} x {unit} for {bound}: {scene}");
        assert!(printed * unit < bound * 1.01, "{number}: {printed} x {unit} for {bound}: {scene}");
        if let Some((_, said)) = warned.split_once("to more than ") {
            let (asked, _) = number_after(said, "");
            assert!(asked >= 100.0 * bound * (1.0 - 1e-12), "{number}: {asked} % for {bound}: {scene}");
        }
        let (text, _) = output_of(folder.path(), &["solve", "a.toml", "--method", "all"]);
        let row = text.lines().find(|line| line.starts_with("| best")).unwrap();
        let (printed, _) = number_after(row.split('|').nth(6).unwrap(), "");
        assert!(printed <= part && printed > part - 0.0101, "{number}: {printed} % of {part} %: {scene}");
    }
}

#[test]
fn linear_theory_holds_at_the_printed_part_of_the_drive() {
    for strength in [5.0, 6.0, 7.3] {
        let scene = format!(
            "format = 1\n[array]\nstrength = {strength}\n[[target]]\nat = [0.01, 0.02, 0.1]\n[plane]\nsize = [0.08, 0.06]\n"
        );
        let folder = folder(&scene);
        let args = ["render", "a.toml", "-o", "a.png", "--quantity", "depression", "--size", "60"];
        let (text, warned) = output_of(folder.path(), &args);
        // Slopes are proportional to the square of the drive.
        let (slope, _) = number_after(&text, "steepest slope ");
        let (part, _) = number_after(&warned, "valid up to ");
        let at = |part: f64| slope * (part / 100.0).powi(2);
        assert!(at(part) <= 0.3 * 1.0002 && at(part + 1.0) > 0.3, "{slope} at {part} %");
        let (said, _) = number_after(&warned, "slope ");
        assert!(said >= slope - 5e-5, "{said} for {slope}");
    }
}

#[test]
fn printed_maxima_are_rounded_up() {
    for number in 0..scenes() {
        let folder = folder(&scene(number));
        for quantity in ["rms", "intensity", "velocity"] {
            let args = [
                "render",
                "a.toml",
                "-o",
                "a.png",
                "--size",
                "64",
                "--quantity",
                quantity,
                "--data",
                "a.npy",
            ];
            let (text, _) = output_of(folder.path(), &args);
            let bytes = std::fs::read(folder.path().join("a.npy")).unwrap();
            let header = usize::from(u16::from_le_bytes([bytes[8], bytes[9]])) + 10;
            let pixels =
                bytes[header..].chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
            let largest = f64::from(pixels.fold(0.0, f32::max));
            let (printed, unit) = number_after(&text, "up to ");
            let unit = if unit.starts_with(" k") {
                1e3
            } else if unit.starts_with(" m") && !unit.starts_with(" m/") {
                1e-3
            } else {
                1.0
            };
            assert!(printed * unit >= largest, "{number}, {quantity}: {printed} x {unit} for {largest}");
            assert!(
                printed * unit < 1.02 * largest,
                "{number}, {quantity}: {printed} x {unit} for {largest}"
            );
        }
    }
}

#[test]
fn force_and_volume_name_their_area() {
    let folder = folder("format = 1\n[[target]]\nat = [0.0, 0.0, 0.1]\n[plane]\nsize = [0.0425, 0.03]\n");
    for (quantity, before) in [("depression", "N on "), ("radiation", "N on ")] {
        let args = ["render", "a.toml", "-o", "a.png", "--size", "40", "--quantity", quantity];
        let (text, _) = output_of(folder.path(), &args);
        let (width, rest) = number_after(&text, before);
        let (height, rest) = number_after(&rest, " x ");
        assert_eq!((width, height), (42.5, 30.0), "{text}");
        assert!(rest.starts_with(" mm"), "{text}");
    }
}
