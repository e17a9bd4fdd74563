//! A drive as plain data, and drives of the user's own: from a file, played instead of the solver's.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::scene::loaded::Loaded;
use crate::scene::range::{KeyError, refuse};

/// One value per element of the array, in its numbering; u_n = amplitude · e^{j phase}.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Drive {
    /// 0 to 1; 0 for elements that are off.
    pub amplitudes: Vec<f64>,
    /// rad, in (-π, π]
    pub phases: Vec<f64>,
}

/// The drives of a file, in turn or frame by frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DriveTable {
    /// At least one.
    pub drives: Vec<Drive>,
    /// Drives per second, if the file has times.
    pub rate: Option<f64>,
    /// Elements that the file leaves out of a drive, at most.
    pub left_out: usize,
}

/// The file whose drives a scene plays instead of solved ones, if it is named. A scene file only names it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct DriveFile {
    /// As in the scene file; empty without a file.
    pub name: String,
    #[serde(skip)]
    table: Loaded<DriveTable>,
    /// The file of origin.
    #[serde(skip)]
    pub from: Option<PathBuf>,
}

impl DriveFile {
    pub fn new(name: String, table: DriveTable, from: Option<PathBuf>) -> Self {
        Self { name, table: Loaded::new(table), from }
    }

    /// Whether the scene has one.
    pub fn is_named(&self) -> bool {
        !self.is_absent()
    }

    #[doc(hidden)]
    pub fn is_absent(&self) -> bool {
        self.name.is_empty()
    }

    /// Whether it is named but not yet loaded.
    #[doc(hidden)]
    pub fn is_missing(&self) -> bool {
        self.is_named() && self.table.get().is_none()
    }

    /// The drives, once loaded.
    pub fn table(&self) -> Option<&DriveTable> {
        self.table.get()
    }

    /// The file by its name alone.
    #[doc(hidden)]
    pub fn named(name: String) -> Self {
        Self { name, ..Self::default() }
    }

    /// Whether its drives fit an array of some elements.
    pub(crate) fn check(&self, elements: usize) -> Result<(), KeyError> {
        let of = self.table().map_or(elements, |table| table.drives[0].phases.len());
        if of == elements {
            return Ok(());
        }
        refuse(
            "drive",
            format!("`{}` holds drives of {of} elements, and the scene has {elements}", self.name),
        )
    }
}
