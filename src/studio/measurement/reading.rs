//! A scan's file with the drives that were played.

use std::path::Path;

use crate::drive::Drive;
use crate::measure::Scan;
use crate::scene::Scene;
use crate::solver;
use crate::source;
use crate::studio::opening;

/// The name of a plan's drives, which a scan beside them takes.
pub const DRIVE: &str = "drive.csv";

/// A scan, its drives, and remarks on their origin.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    pub scan: Scan,
    pub drives: Vec<Drive>,
    pub notes: Vec<String>,
}

/// Reads a scan and its drives: those of a file, of `drive.csv` beside the scan, or else the scene's own.
///
/// # Errors
/// A file that cannot be read, with its name and line, or a scene that cannot be solved.
pub fn read(scene: &Scene, path: &Path, drive: Option<&Path>) -> Result<Reading, String> {
    let name = path.display();
    let file = source::open(path).map_err(|error| format!("{name}: {error}"))?;
    let mut scan = Scan::read(file).map_err(|error| format!("{name}:{error}"))?;
    let beside = path.with_file_name(DRIVE);
    let mut notes = Vec::new();
    let drive = match drive {
        None if beside.is_file() => {
            notes.push(format!("the drive is that of {}", beside.display()));
            Some(beside.as_path())
        }
        given => given,
    };
    let drives = match drive {
        Some(path) => {
            let read = opening::read_drive(path, path.display().to_string(), scene)?;
            read.table().map(|table| table.drives.clone()).unwrap_or_default()
        }
        None => {
            notes.push("the drive is the scene's own: if another was played, give it".to_owned());
            solver::solve(scene).map_err(|error| error.to_string())?.drives()
        }
    };
    let ends = scan.drives.iter().fold((usize::MAX, 0), |(low, high), &own| (low.min(own), high.max(own)));
    if ends.0 >= 1 && ends.1 == drives.len() {
        notes.push("the scan counts its drives from 1".to_owned());
        scan.drives.iter_mut().for_each(|own| *own -= 1);
    }
    Ok(Reading { scan, drives, notes })
}
