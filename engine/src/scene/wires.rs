//! Tables of wires: the channel of a board for each element.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::scene::loaded::Loaded;

/// A table of wires, once loaded. A scene file only names it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Wires {
    of_elements: Loaded<[Option<Wire>]>,
    /// The table is that of one board, and the boards of a scene follow each other; otherwise it is that of the scene.
    pub repeats: bool,
    /// The file of origin.
    pub from: Option<PathBuf>,
}

/// The wire of an element.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Wire {
    pub channel: u32,
    /// Of its file, counted from 1.
    pub line: u64,
}

impl Wires {
    /// Wires by element; those that are missing are not wired.
    pub fn new(of_elements: Vec<Option<Wire>>, repeats: bool, from: Option<PathBuf>) -> Self {
        Self { of_elements: Loaded::new(of_elements), repeats, from }
    }

    pub fn get(&self) -> Option<&[Option<Wire>]> {
        self.of_elements.get()
    }

    /// The wire of an element, and the board that it repeats the table for, `each` elements to a board.
    pub fn wire(&self, element: usize, each: usize) -> Option<(usize, Wire)> {
        let (board, place) =
            if self.repeats { (element / each.max(1), element % each.max(1)) } else { (0, element) };
        let wire = self.get()?.get(place).copied().flatten()?;
        Some((board, wire))
    }
}

/// The measured correction of an element.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Correction {
    /// Phase lead of its sound, degrees; 180 for reversed polarity.
    pub offset: f64,
    /// Factor on its amplitude, 0 to 1.
    pub gain: f64,
    /// The element is not driven.
    pub off: bool,
}

impl Default for Correction {
    fn default() -> Self {
        Self { offset: 0.0, gain: 1.0, off: false }
    }
}
