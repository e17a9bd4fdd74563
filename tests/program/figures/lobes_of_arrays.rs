//! Side lobes of curved and facing arrays, of traps and behind reflectors.

use serde_json::Value;

use crate::figures::program::{folder, solved};

const TINYLEV: &str = "format = 1\n[array]\nelements = \"preset:tinylev-72\"\nelement_radius = 0.0045\nstrength = 2.4\n\
     [plane]\ncentre = [0, 0, 0]\nx_axis = [1, 0, 0]\ny_axis = [0, 0, 1]\nsize = [0.13, 0.13]\n";

/// The side lobe over the mean, and its place.
fn side_lobe(scene: &str) -> (f64, [f64; 3]) {
    let quality = solved(folder(scene).path())["quality"].take();
    let place = |at: &Value| std::array::from_fn(|i| at[i].as_f64().unwrap());
    (quality["side_lobe"].as_f64().unwrap(), place(&quality["side_lobe_position"]))
}

#[test]
fn a_focus_between_facing_bowls_has_a_side_lobe() {
    for z in [-0.001, 0.0, 0.001] {
        let (part, [x, y, beside]) = side_lobe(&format!("{TINYLEV}[[target]]\nat = [0, 0, {z}]\n"));
        // The next fringe along the axis, half a wavelength away.
        assert!(x.abs() < 1e-4 && y.abs() < 1e-9, "{z}: {x}, {y}");
        assert!((3.8e-3..5.2e-3).contains(&(beside - z).abs()), "{z}: {beside}");
        assert!((0.9..1.05).contains(&part), "{z}: {part}");
    }
}

#[test]
fn lobes_of_a_trap_are_no_side_lobes() {
    let trap = "[[target]]\nkind = \"trap\"\ntrap = \"standing\"\nat = [0, 0, 0]\n";
    let (part, [x, _, z]) = side_lobe(&format!("{TINYLEV}{trap}"));
    assert!(x.hypot(z) > 5e-3 && (0.8..1.1).contains(&part), "{part} at {x}, {z}");
}

#[test]
fn what_is_behind_a_reflector_is_no_side_lobe() {
    let wall = "format = 1\n[[reflector]]\npoint = [0.09, 0, 0]\nnormal = [-1, 0, 0]\n[[target]]\nat = [0.03, 0, 0.12]\n\
                [plane]\ncentre = [0.1, 0, 0.12]\nsize = [0.2, 0.1]\n";
    let (part, [x, ..]) = side_lobe(wall);
    assert!(x <= 0.09 && part < 0.6, "{part} at {x}");
}

#[test]
fn no_drive_is_stronger_than_the_strongest() {
    let foci: String = (0..21)
        .map(|i| {
            let (x, y) = (0.02 * f64::from(i / 7) - 0.02, 0.015 * f64::from(i % 7) - 0.045);
            format!("[[target]]\nat = [{x}, {y}, 0.12]\n")
        })
        .collect();
    for method in ["best", "naive"] {
        let scene = format!("format = 1\n[solver]\nmethod = \"{method}\"\n{foci}");
        let strength = solved(folder(&scene).path())["quality"]["strength"].as_f64().unwrap();
        assert!((0.8..=1.0).contains(&strength), "{method}: {strength}");
    }
}
