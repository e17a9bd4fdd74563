//! Tables of a measured directivity: amplitude and phase of an element by the angle from its axis.

use std::path::Path;

use crate::scene::{Directivity, Reading};
use crate::source;
use crate::table::{Table, TableError};

/// Bytes of a file, at most.
const MOST_BYTES: u64 = 1 << 20;
/// dB; louder and fainter values are slips.
const LOUDEST: f64 = 400.0;
/// Angles (degrees) that count as equal.
const EQUAL: f64 = 1e-9;

/// The directivity of a file: CSV with the columns `angle` (degrees), `amplitude` (relative) or `level` (dB), and
/// perhaps `phase` (degrees, more is earlier). Angles of both sides are averaged.
///
/// # Errors
/// A file that cannot be read, or an invalid table.
pub fn read(path: &Path) -> Result<Directivity, String> {
    let bytes = source::read(path, MOST_BYTES).map_err(|error| format!("{}: {error}", path.display()))?;
    let readings = readings(&bytes).map_err(|error| format!("{}:{error}", path.display()))?;
    Ok(Directivity::new(readings, Some(path.to_owned())))
}

fn readings(csv: &[u8]) -> Result<Vec<Reading>, TableError> {
    let mut table = Table::open(csv, ["angle"], ["amplitude", "level", "phase"])?;
    match (table.has("amplitude"), table.has("level")) {
        (true, true) => return Err(table.refusal("one of the columns `amplitude` and `level` is enough")),
        (false, false) => {
            return Err(table.refusal("the column `amplitude` (relative) or `level` (dB) is missing"));
        }
        (true, false) | (false, true) => {}
    }
    // Angle, with the sums and the number of the values there.
    let mut all: Vec<(f64, [f64; 2], f64)> = Vec::new();
    while let Some(row) = table.next_row()? {
        let [angle] = row.required;
        let [amplitude, level, phase] = row.optional;
        if !(-180.0..=180.0).contains(&angle) {
            return Err(table.refusal(format!("angle = {angle}: must be degrees from -180 to 180")));
        }
        let amplitude = match (amplitude, level) {
            (_, Some(level)) if level.abs() > LOUDEST => {
                return Err(
                    table.refusal(format!("level = {level}: must be dB from -{LOUDEST} to {LOUDEST}"))
                );
            }
            (_, Some(level)) => 10f64.powf(level / 20.0),
            (amplitude, None) => amplitude.unwrap_or_default(),
        };
        let limits = 10f64.powf(LOUDEST / 20.0);
        if amplitude.abs() > limits {
            return Err(table.refusal(format!("amplitude = {amplitude}: must be at most {limits:e}")));
        }
        let (sin, cos) = phase.unwrap_or_default().to_radians().sin_cos();
        all.push((angle.abs(), [amplitude * cos, amplitude * sin], 1.0));
    }
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    all.dedup_by(|next, first| {
        let is_equal = next.0 - first.0 <= EQUAL;
        if is_equal {
            first.1 = [first.1[0] + next.1[0], first.1[1] + next.1[1]];
            first.2 += 1.0;
        }
        is_equal
    });
    let reading = |&(angle, [re, im], count): &(f64, [f64; 2], f64)| Reading {
        angle,
        amplitude: re.hypot(im) / count,
        phase: im.atan2(re).to_degrees(),
    };
    let readings: Vec<_> = all.iter().map(reading).collect();
    match &readings[..] {
        [] | [_] => {
            Err(table.refusal(format!("angles = {}: a directivity has two at least", readings.len())))
        }
        [first, ..] if first.angle > EQUAL => {
            Err(table.refusal(format!("the first angle is {}: the axis, 0 degrees, is missing", first.angle)))
        }
        [first, ..] if first.amplitude == 0.0 => {
            Err(table.refusal("the amplitude at 0 degrees is 0: it is what the others are relative to"))
        }
        [_, ..] => Ok(readings),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_sides_of_a_table_and_decibels_are_taken() {
        let plain = readings(b"angle,amplitude\n0,2\n30,1\n90,0.5\n").unwrap();
        let sides = readings(b"angle;amplitude\n-90;0,4\n-30;1\n0;2\n30;1\n90;0,6\n").unwrap();
        assert_eq!(plain.len(), 3);
        for (a, b) in plain.iter().zip(&sides) {
            assert!((a.amplitude - b.amplitude).abs() < 1e-12 && a.angle == b.angle, "{a:?} {b:?}");
        }
        let levels = readings(b"angle,level,phase\n0,0,10\n45,-20,-170\n").unwrap();
        assert!((levels[1].amplitude - 0.1).abs() < 1e-12 && (levels[1].phase + 170.0).abs() < 1e-9);
    }

    #[test]
    fn errors_name_the_line() {
        for (text, error) in [
            ("angle\n0\n", "1: the column `amplitude` (relative) or `level` (dB) is missing"),
            ("angle,amplitude\n0,1\n200,1\n", "3: angle = 200: must be degrees from -180 to 180"),
            ("angle,amplitude\n0,1\n", "2: angles = 1: a directivity has two at least"),
            ("angle,amplitude\n10,1\n20,1\n", "3: the first angle is 10: the axis, 0 degrees, is missing"),
        ] {
            assert_eq!(readings(text.as_bytes()).unwrap_err().to_string(), error, "{text:?}");
        }
    }
}
