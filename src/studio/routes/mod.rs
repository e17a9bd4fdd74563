//! Routes of targets from files: tables of places (CSV), or programs of plotters and tools (G-code).

mod gcode;
mod limits;
mod places;

use std::path::Path;

use crate::scene::motion::Routes;
use crate::source;
use crate::studio::routes::limits::Traced;
use crate::table::TableError;

/// Bytes of a file, at most.
const MOST_BYTES: u64 = 64 << 20;
/// Extensions of tables and programs.
pub const ENDINGS: &[&str] = &["csv", "txt", "tsv", "gcode", "nc", "ngc", "gco", "g", "tap"];
/// Number of those of tables; files with other extensions are told by their content.
const TABLES: usize = 3;

/// The routes of a file.
///
/// # Errors
/// An error with the file's name and line: unreadable, without places, or with one that is invalid.
pub fn read(path: &Path) -> Result<Routes, String> {
    let bytes = source::read(path, MOST_BYTES).map_err(|error| format!("{}: {error}", path.display()))?;
    let (traces, remarks) =
        decode(&bytes, is_program(path)).map_err(|error| format!("{}:{error}", path.display()))?;
    Ok(Routes::new(path.to_owned(), &traces, remarks))
}

/// The traces of the bytes of a file, which may be called a program.
///
/// # Errors
/// The errors of [`read`].
pub fn decode(bytes: &[u8], is_called_program: bool) -> Result<Traced, TableError> {
    let text = text(bytes);
    if is_called_program || text.as_deref().is_some_and(gcode::is_program) {
        let not_text = || TableError { line: 1, reason: "this is not a text file".to_owned() };
        return gcode::read(&text.ok_or_else(not_text)?);
    }
    places::read(bytes)
}

fn is_program(path: &Path) -> bool {
    let ending = path.extension().unwrap_or_default().to_string_lossy();
    ENDINGS[TABLES..].iter().any(|program| ending.eq_ignore_ascii_case(program))
}

/// The text of a file, if it is one; comments of old programs are in Latin-1.
fn text(bytes: &[u8]) -> Option<String> {
    let is_text = !bytes.contains(&0);
    is_text.then(|| match std::str::from_utf8(bytes) {
        Ok(text) => text.trim_start_matches('\u{feff}').to_owned(),
        Err(_) => bytes.iter().map(|byte| char::from(*byte)).collect(),
    })
}
