//! Thresholds of feeling from tables of a user: the displacement of the skin that is just felt, by frequency.

use std::path::Path;

use strum::VariantNames;

use crate::scene::{Curve, Threshold};
use crate::source;
use crate::table::{Table, TableError};

/// Bytes of a file, at most.
const MOST_BYTES: u64 = 1 << 20;
/// Hz
const FREQUENCIES: std::ops::RangeInclusive<f64> = 1e-3..=1e5;
/// m; larger displacements are slips of the unit.
const LARGEST: f64 = 0.01;

/// The curve of a file: CSV with the columns `frequency` (Hz, increasing) and `displacement` (m, peak).
///
/// # Errors
/// A file that cannot be read, with the known curves, or an invalid table.
pub fn read(path: &Path) -> Result<Curve, String> {
    let bytes = source::read(path, MOST_BYTES).map_err(|error| {
        let known = Threshold::VARIANTS.join(", ");
        let path = path.display();
        format!("unknown threshold: {known}, or a CSV file; {path}: {error}")
    })?;
    let rows = rows(&bytes).map_err(|error| format!("{}:{error}", path.display()))?;
    Ok(Curve::new(rows, path.to_owned()))
}

fn rows(csv: &[u8]) -> Result<Vec<[f64; 2]>, TableError> {
    let mut table = Table::open(csv, ["frequency", "displacement"], [])?;
    let mut rows: Vec<[f64; 2]> = Vec::new();
    while let Some(row) = table.next_row()? {
        let ([frequency, displacement], []) = (row.required, row.optional);
        if !FREQUENCIES.contains(&frequency) {
            let (least, most) = (FREQUENCIES.start(), FREQUENCIES.end());
            let reason = format!("frequency = {frequency}: must be from {least} to {most} Hz");
            return Err(table.refusal(reason));
        }
        if let Some([before, _]) = rows.last().filter(|[before, _]| frequency <= *before) {
            let reason =
                format!("frequency = {frequency}: must be more than {before} Hz, that of the row before");
            return Err(table.refusal(reason));
        }
        if !(displacement > 0.0 && displacement <= LARGEST) {
            let reason = format!(
                "displacement = {displacement}: must be metres (peak), more than 0 and at most {LARGEST}"
            );
            return Err(table.refusal(reason));
        }
        rows.push([frequency, displacement]);
    }
    match rows.len() {
        0 | 1 => Err(table.refusal(format!("rows = {}: a curve has at least two", rows.len()))),
        _ => Ok(rows),
    }
}
