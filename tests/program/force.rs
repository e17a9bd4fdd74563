//! Forces on beads on the command line.

use std::fs;

use crate::process::{POINT, folder_with, refuse, succeed};

/// A pair of points around a place along each axis, and the place.
const POINTS: &str = "x,y,z\n0.01199,0.021,0.101\n0.01201,0.021,0.101\n0.012,0.02099,0.101\n0.012,0.02101,0.101\n\
                      0.012,0.021,0.10099\n0.012,0.021,0.10101\n0.012,0.021,0.101\n";

#[test]
fn probe_prints_the_force_on_a_bead() {
    let scene = POINT.replace("format = 1", "format = 1\n[bead]\nradius = 0.0002");
    let folder = folder_with(&[("a.toml", &scene), ("points.csv", POINTS)]);
    let args = ["probe", "a.toml", "--points", "points.csv", "--quantity", "force"];
    let answer = succeed(folder.path(), &args);
    assert_eq!(answer.lines().next(), Some("x,y,z,gorkov,fx,fy,fz,kxx,kxy,kxz,kyy,kyz,kzz"));
    let rows: Vec<Vec<f64>> =
        answer.lines().skip(1).map(|line| line.split(',').map(|v| v.parse().unwrap()).collect()).collect();
    // Central difference of two rows.
    let slope = |axis: usize, column: usize| {
        (rows[2 * axis + 1][column] - rows[2 * axis][column])
            / (rows[2 * axis + 1][axis] - rows[2 * axis][axis])
    };
    let near = |column: usize, other: f64| {
        let own = rows[6][column];
        assert!((own - other).abs() < 1e-3 * rows[6][12].abs(), "{column}: {own} {other}");
    };
    // K is minus the symmetric part of the force's gradient.
    near(7, -slope(0, 4));
    near(8, -(slope(1, 4) + slope(0, 5)) / 2.0);
    near(9, -(slope(2, 4) + slope(0, 6)) / 2.0);
    near(10, -slope(1, 5));
    near(11, -(slope(2, 5) + slope(1, 6)) / 2.0);
    near(12, -slope(2, 6));
    // Without scattering, force is minus the gradient of the potential.
    assert!((rows[6][4] / -slope(0, 3) - 1.0).abs() < 0.1, "{rows:?}");
    assert!(refuse(folder.path(), &[&args[..], &["--backend", "cpu"]].concat()).contains("f64"));
    fs::write(folder.path().join("b.toml"), "format = 1\n[bead]\nradius = 0.2\n").unwrap();
    let refused = refuse(folder.path(), &["probe", "b.toml", "--points", "points.csv"]);
    assert!(refused.contains("b.toml:3: bead.radius = 0.2: must be a number from"), "{refused}");
}

#[test]
fn solve_states_whether_a_trap_holds() {
    let text = "format = 1\n[bead]\nradius = 0.0003\n[[board]]\n[[board]]\nat = [0, 0, 0.2]\nnormal = [0, 0, -1]\n\
                [[target]]\nkind = \"trap\"\ntrap = \"standing\"\n";
    let stroke = format!("{text}[[target]]\nkind = \"circle\"\n");
    let turns = text.replace("\"standing\"", "\"vortex\"\ncharge = 0");
    let folder = folder_with(&[("a.toml", text), ("stroke.toml", &stroke), ("turns.toml", &turns)]);
    let said = succeed(folder.path(), &["solve", "a.toml"]);
    assert!(said.contains("trap, target 1") && said.contains("stable trap: sag"), "{said}");
    let json: serde_json::Value =
        serde_json::from_str(&succeed(folder.path(), &["solve", "a.toml", "--json"])).unwrap();
    let trap = &json["traps"][0];
    assert_eq!((&trap["holds"], &trap["position"][2]), (&true.into(), &0.1.into()));
    assert!(trap["lift"].as_f64().unwrap() > 10.0 && trap["escape"].as_array().unwrap().len() == 6, "{trap}");
    assert!(trap["stiffness"][0]["stiffness"].as_f64().unwrap() > 1e-4, "{trap}");
    let refused = refuse(folder.path(), &["solve", "stroke.toml"]);
    assert!(
        refused.contains("stroke.toml:10: target[1].trap = \"standing\": traps combine only with points"),
        "{refused}"
    );
    let refused = refuse(folder.path(), &["solve", "turns.toml"]);
    assert!(
        refused.contains("turns.toml:11: target[1].charge = 0: must be a whole number from -8 to 8"),
        "{refused}"
    );
}
