//! Pictures as targets: PNG, JPEG and BMP. Their size is bounded, their values are finite, and they have foci.

use glam::DVec3;

use sonoglyph::picture::grey;
use sonoglyph::scene::check::MOST_FOCI;
use sonoglyph::scene::{Pixels, Scene, Shape, Target, outline};

use super::is_one_line;

pub fn run(bytes: &[u8]) {
    let grey = match grey::read(bytes) {
        Ok(grey) => grey,
        Err(error) => return is_one_line(&error.to_string()),
    };
    assert_eq!(grey.brightness.len(), grey.width * grey.height);
    assert!(grey.brightness.iter().all(|brightness| (0.0..=1.0).contains(brightness)) && !grey.is_black());
    let at = DVec3::new(0.0, 0.01, 0.1);
    let shape = Shape::Picture { file: String::new(), at, width: 0.05, pixels: Pixels::new(grey) };
    let scene = Scene { targets: vec![Target::new(shape)], ..Scene::default() };
    // A picture too tall for its width is an error of one line.
    match outline::foci(&scene) {
        Ok(foci) => assert!(foci.len() <= MOST_FOCI && foci.iter().all(|focus| focus.position.is_finite())),
        Err(error) => is_one_line(&error.to_string()),
    }
}
