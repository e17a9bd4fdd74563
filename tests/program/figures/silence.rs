//! Where no sound arrives, the program says so instead of printing ratios to zero.

use crate::figures::program::folder;
use crate::process::output_of;

/// Absorption of 1000 dB/m.
fn silent() -> String {
    "format = 1\n[medium]\nabsorption = 1000\n[[target]]\nat = [0, 0, 5]\n[[target]]\nat = [2, 0, 5]\n\
     [plane]\ncentre = [0, 0, 5]\n"
        .to_owned()
}

#[test]
fn a_silent_plane_has_no_figures() {
    let folder = folder(&silent());
    for quantity in ["rms", "radiation", "depression", "phase", "intensity", "velocity", "instantaneous"] {
        let args =
            ["render", "a.toml", "-o", "a.png", "--size", "32", "--backend", "cpu", "--quantity", quantity];
        let (text, _) = output_of(folder.path(), &args);
        assert!(text.contains("no sound reaches the plane"), "{quantity}: {text}");
        assert!(!text.contains("up to") && !text.contains("deepest"), "{quantity}: {text}");
    }
}

#[test]
fn a_silent_drive_has_no_relative_figures() {
    let folder = folder(&silent());
    let (text, _) = output_of(folder.path(), &["solve", "a.toml", "--levels", "8"]);
    for row in ["uniformity", "evenness", "relative to single", "peak side lobe", "residual"] {
        let line = text.lines().find(|line| line.starts_with(row)).unwrap_or_else(|| panic!("{row}: {text}"));
        assert!(line.contains("-, no sound reaches"), "{line}");
    }
    let of_levels = text.split("phase levels").nth(1).unwrap();
    assert!(of_levels.contains("no sound reaches the foci") && !of_levels.contains("rounded"), "{of_levels}");
    let (text, _) = output_of(folder.path(), &["solve", "a.toml", "--method", "all"]);
    let best = text.lines().find(|line| line.starts_with("| best")).unwrap();
    let cells: Vec<_> = best.split('|').map(str::trim).collect();
    assert_eq!((cells[4], cells[7]), ("-", "-"), "{best}");
}
