//! Printed peak side lobes, against a fine grid of the plane with its edge.

use rayon::prelude::*;
use serde_json::Value;

use crate::dice::Dice;
use crate::figures::judge::{HEAD, Point, Sources, WAVELENGTH};
use crate::figures::program::{folder, scenes, solved};

struct Case {
    scene: String,
    centre: Point,
    axes: [Point; 2],
    size: [f64; 2],
}

/// Foci on a plane that cuts off much of the field around them.
fn case(number: usize) -> Case {
    let mut dice = Dice::new(0x10BE, number);
    let centre = [dice.between(-0.02, 0.02), dice.between(-0.02, 0.02), dice.between(0.08, 0.2)];
    let axes =
        [[1.0, 0.0, 0.0], dice.one_of(&[[0.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.8, 0.6]])];
    let size = [dice.between(0.02, 0.1), dice.between(0.02, 0.1)];
    let mut scene = format!("{HEAD}strength = 1.0\n");
    for _ in 0..dice.one_of(&[1, 1, 2, 3]) {
        let at = at(&centre, &axes, [0, 1].map(|axis| dice.between(-0.5, 0.5) * size[axis]));
        scene += &format!("[[target]]\nat = {at:?}\n");
    }
    let method = dice.one_of(&["best", "naive", "pinv"]);
    scene += &format!(
        "[plane]\ncentre = {centre:?}\nx_axis = {:?}\ny_axis = {:?}\nsize = {size:?}\n[solver]\nmethod = \"{method}\"\n",
        axes[0], axes[1]
    );
    Case { scene, centre, axes, size }
}

fn at(centre: &Point, axes: &[Point; 2], place: [f64; 2]) -> Point {
    std::array::from_fn(|i| centre[i] + axes[0][i] * place[0] + axes[1][i] * place[1])
}

fn distance(a: Point, b: Point) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}

/// Whether a point is in the main lobe of a focus: path lengths to the point less those to the focus have a standard
/// deviation of less than a third of a wavelength, weighted by the sound at the focus.
fn is_in_lobe(point: Point, focus: Point) -> bool {
    let (mut weights, mut mean, mut square) = (0.0, 0.0, 0.0);
    for n in 0..256u32 {
        let from = [n % 16, n / 16].map(|i| 0.0105 * (f64::from(i) - 7.5));
        let [to_point, to_focus] = [point, focus].map(|to| distance([from[0], from[1], 0.0], to));
        let (weight, late) = (1.0 / to_focus, to_point - to_focus);
        weights += weight;
        mean += weight * late;
        square += weight * late * late;
    }
    square / weights - (mean / weights).powi(2) < (WAVELENGTH / 3.0).powi(2)
}

/// The loudest maximum of |p| (Pa) on the rectangle and its edge, outside all main lobes and a wavelength from the
/// array.
fn loudest(sources: &Sources, case: &Case, foci: &[Point]) -> f64 {
    let Case { centre, axes, size, .. } = case;
    let counts = size.map(|length| (30.0 * length / WAVELENGTH).ceil() as usize + 1);
    let place = |i: usize, axis: usize| size[axis] * (i as f64 / (counts[axis] - 1) as f64 - 0.5);
    let places = |i: usize| [place(i % counts[0], 0), place(i / counts[0], 1)];
    let count = counts[0] * counts[1];
    let field: Vec<f64> =
        (0..count).into_par_iter().map(|i| sources.modulus(at(centre, axes, places(i)))).collect();
    let near = |at: usize, count: usize| at.saturating_sub(1)..(at + 2).min(count);
    let is_maximum = |&i: &usize| {
        let is_lower = |j: usize, k: usize| field[j * counts[0] + k] <= field[i];
        near(i / counts[0], counts[1]).all(|j| near(i % counts[0], counts[0]).all(|k| is_lower(j, k)))
    };
    let climbed = |i: usize| {
        let (mut best, mut step) = ((places(i), field[i]), WAVELENGTH / 60.0);
        while step > 1e-7 {
            let sides = (0..9).map(|side| {
                let by = [f64::from(side % 3) - 1.0, f64::from(side / 3) - 1.0];
                [0, 1].map(|axis| (best.0[axis] + by[axis] * step).clamp(-size[axis] / 2.0, size[axis] / 2.0))
            });
            let louder = sides.map(|side| (side, sources.modulus(at(centre, axes, side))));
            match louder.max_by(|a, b| a.1.total_cmp(&b.1)) {
                Some(louder) if louder.1 > best.1 => best = louder,
                _ => step /= 2.0,
            }
        }
        best
    };
    let maxima = (0..count).filter(is_maximum).map(climbed);
    let counts = maxima.filter(|(place, _)| {
        let point = at(centre, axes, *place);
        point[2] > WAVELENGTH && !foci.iter().any(|&focus| is_in_lobe(point, focus))
    });
    counts.map(|(_, modulus)| modulus).fold(0.0, f64::max)
}

fn foci(solution: &Value) -> Vec<Point> {
    let point = |focus: &Value| std::array::from_fn(|i| focus["position"][i].as_f64().unwrap());
    solution["foci"].as_array().unwrap().iter().map(point).collect()
}

#[test]
fn the_side_lobe_is_the_loudest_maximum_of_the_plane_and_its_edge() {
    let mut worst = 0.0f64;
    for number in 0..2 * scenes() {
        let case = case(number);
        let solution = solved(folder(&case.scene).path());
        let sources = Sources::new(&solution, 1.0);
        let foci = foci(&solution);
        let mean = foci.iter().map(|&focus| sources.modulus(focus)).sum::<f64>() / foci.len() as f64;
        let expected = loudest(&sources, &case, &foci) / mean;
        let printed = solution["quality"]["side_lobe"].as_f64().unwrap_or(0.0);
        assert_eq!(solution["quality"]["ghost"], solution["quality"]["side_lobe"]);
        let below = if expected == printed { 0.0 } else { 1.0 - printed / expected };
        println!("{number}: {printed} of {expected}: {below:.2e}");
        worst = if below.abs() > worst.abs() { below } else { worst };
    }
    assert!(worst.abs() < 1e-3, "off by {worst}");
}
