//! The pixels of a picture that is a target: plain numbers, which whoever opens a scene loads from the picture's file.

use std::path::PathBuf;
use std::sync::Arc;

/// Grey values of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Grey {
    /// The file that they were loaded from.
    pub file: PathBuf,
    pub width: usize,
    pub height: usize,
    /// Of every pixel, row by row from the top left: 0 for black and transparent, 1 for white.
    pub brightness: Vec<f32>,
}

/// The pixels of a picture target, once they are loaded. A scene file holds the picture's name alone.
#[derive(Clone, Debug, Default)]
pub struct Pixels(Option<Arc<Grey>>);

impl Pixels {
    /// # Panics
    /// Other than a brightness per pixel.
    pub fn new(grey: Grey) -> Self {
        assert_eq!(grey.brightness.len(), grey.width * grey.height, "a brightness per pixel");
        Self(Some(Arc::new(grey)))
    }

    pub fn get(&self) -> Option<&Grey> {
        self.0.as_deref()
    }

    /// Height over width; 1 until they are loaded.
    pub fn aspect(&self) -> f64 {
        let of = |grey: &Grey| grey.height as f64 / grey.width as f64;
        self.get().filter(|grey| grey.width > 0 && grey.height > 0).map_or(1.0, of)
    }
}

impl PartialEq for Pixels {
    fn eq(&self, other: &Self) -> bool {
        match (&self.0, &other.0) {
            (None, None) => true,
            // Scenes are compared in every frame, and their pictures are mostly the same one.
            (Some(own), Some(others)) => Arc::ptr_eq(own, others) || own == others,
            (Some(_), None) | (None, Some(_)) => false,
        }
    }
}
