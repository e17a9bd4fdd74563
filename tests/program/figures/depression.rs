//! Printed depths and slopes, against the maxima of a continuous surface and of any map.

use crate::dice::Dice;
use crate::figures::judge::{HEAD, Sources, Surface};
use crate::figures::program::{folder, number_after, scenes, solved};
use crate::process::output_of;

struct Case {
    scene: String,
    strength: f64,
    centre: [f64; 3],
    size: [f64; 2],
    density: f64,
    tension: f64,
}

/// One to four foci under a liquid, some off its plane.
fn case(number: usize) -> Case {
    let mut dice = Dice::new(0x5EED, number);
    let strength = dice.between(2.0, 5.0);
    let (density, tension) = (dice.between(700.0, 1300.0), dice.between(0.02, 0.075));
    let z = dice.between(0.08, 0.15);
    let centre = [dice.between(-0.02, 0.02), dice.between(-0.02, 0.02), z];
    let size = [dice.between(0.02, 0.08), dice.between(0.02, 0.08)];
    let mut scene = format!("{HEAD}strength = {strength}\n");
    for _ in 0..dice.one_of(&[1, 1, 2, 3, 4]) {
        let [x, y] = [0, 1].map(|axis| centre[axis] + dice.between(-0.6, 0.6) * size[axis]);
        scene += &format!("[[target]]\nat = [{x}, {y}, {z}]\n");
    }
    scene += &format!(
        "[plane]\ncentre = {centre:?}\nsize = {size:?}\ntolerance = 1e-4\n[liquid]\ndensity = {density}\n\
         surface_tension = {tension}\ngravity = 9.81\n"
    );
    Case { scene, strength, centre, size, density, tension }
}

/// The printed depth (m) and slope, and the largest pixel of the map.
fn printed(folder: &std::path::Path) -> [f64; 3] {
    let args =
        ["render", "a.toml", "-o", "a.png", "--quantity", "depression", "--size", "997", "--data", "a.npy"];
    let (text, _) = output_of(folder, &[&args[..], &["--backend", "cpu"]].concat());
    let (deepest, unit) = number_after(&text, "deepest ");
    let metres = if unit.starts_with(" mm") { 1e-3 } else { 1e-6 };
    let bytes = std::fs::read(folder.join("a.npy")).unwrap();
    let header = usize::from(u16::from_le_bytes([bytes[8], bytes[9]])) + 10;
    let pixels =
        bytes[header..].chunks_exact(4).map(|b| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])));
    [deepest * metres, number_after(&text, "steepest slope ").0, pixels.fold(0.0, f64::max)]
}

#[test]
fn printed_depths_and_slopes_are_the_maxima_of_surface_and_map() {
    let mut worst = [0.0f64; 3];
    for number in 0..scenes() {
        let Case { scene, strength, centre, size, density, tension } = case(number);
        let folder = folder(&scene);
        let sources = Sources::new(&solved(folder.path()), strength);
        let surface = Surface::new(&sources, centre, size[0].max(size[1]), density, tension);
        let largest = surface.largest(centre, size);
        let [deepest, slope, pixel] = printed(folder.path());
        let below = [1.0 - deepest / largest[0], 1.0 - slope / largest[1], 1.0 - deepest / pixel];
        println!("{number}: {below:?} of {largest:?}");
        for (worst, below) in worst.iter_mut().zip(below) {
            *worst = if below.abs() > worst.abs() { below } else { *worst };
        }
    }
    println!("worst: {worst:?}");
    assert!(worst[0].abs() < 2e-3 && worst[1].abs() < 2e-3, "depth, slope, below a pixel: {worst:?}");
    assert!(worst[2] < 1e-3, "depth, slope, below a pixel: {worst:?}");
}
