//! Draws the field of a word as a PNG with the library alone, without window or GPU.
//!
//! `cargo run --release --example field --no-default-features`

use glam::dvec3;
use sonoglyph::field::{Colouring, Evaluator, Quantity, Request, Stages};
use sonoglyph::picture::{ColourMap, Picture, export};
use sonoglyph::scene::{Scene, Shape, Target};
use sonoglyph::solver;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let text = Shape::Text { text: "HIT".to_owned(), at: dvec3(0.0, 0.0, 0.1), height: 0.05 };
    let scene = Scene { targets: vec![Target::new(text)], ..Scene::default() };
    let solution = solver::solve(&scene)?;
    solution.warnings.iter().for_each(|warning| eprintln!("{warning}"));

    let (width, height) = (480, 480);
    let mut stages = Stages::new(Evaluator::Cpu);
    let request = Request::new(&scene, solution.drives(), Quantity::Rms, (width, height));
    let colouring = Colouring::new(Quantity::Rms, ColourMap::Inferno.table());
    let colours = stages.colours(&request, &colouring)?;
    let picture = Picture::from_field_order(width, height, colours.as_flattened());
    std::fs::write("field.png", export::png(&picture)?)?;

    let map = stages.map(&request)?;
    println!("field.png: peak {:.0} Pa RMS, error at most {:.1e} of it", map.peak, map.error);
    Ok(())
}
