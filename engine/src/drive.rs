//! The drive: amplitude and phase per element, and their quantisation to a board's levels.
//!
//! ```
//! use sonoglyph::drive::{Drive, delay_level};
//!
//! let drive = Drive { amplitudes: vec![1.0; 2], phases: vec![0.0, 1.6] };
//! // The nearest of 4 phases, and the delay that makes it.
//! assert!((drive.at_levels(4).phases[1] - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
//! assert_eq!(delay_level(drive.phases[1], 4), 3);
//! ```

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};
use std::io::Read;
use std::ops::{Range, RangeInclusive};

use glam::DVec3;
use num_complex::Complex64;

use crate::acoustics::Aperture;
pub use crate::scene::drive::{Drive, DriveTable};
use crate::table::{Table, TableError};

/// Wavelengths by which a file's positions may differ from the array's: a sixteenth of a turn.
const ASTRAY: f64 = 1.0 / 16.0;
/// Frames per second.
const RATES: RangeInclusive<f64> = 1e-6..=1e6;
/// Unevenness of the times of frames, relative to their spacing.
const UNEVEN: f64 = 0.01;
/// Limit of the memory of all drives of a file, in bytes.
const MOST_BYTES: usize = 1 << 30;
/// Excess of a modulus over 1 by rounding.
const ROUNDING: f64 = 1e-6;
/// Columns of a file with a row per element.
const COLUMNS: [&str; 11] =
    ["element", "phase", "amplitude", "re", "im", "frame", "time", "x", "y", "z", "drive"];
/// Columns of a file with a row per drive, before the number of the element.
const PHASES: &str = "phase_";
const AMPLITUDES: &str = "amplitude_";

impl Drive {
    /// Full amplitude on the `driven` elements of an array of `elements`, with the phases of `excitation` (one value
    /// per driven element).
    ///
    /// # Panics
    /// A driven element beyond the last; the same holds of the next two and of [`Drive::excitation`].
    pub fn uniform(elements: usize, driven: &[usize], excitation: &[Complex64]) -> Self {
        let mut drive = Self { amplitudes: vec![0.0; elements], phases: vec![0.0; elements] };
        for (&element, u) in driven.iter().zip(excitation) {
            drive.amplitudes[element] = 1.0;
            drive.phases[element] = u.arg();
        }
        drive
    }

    /// The `excitation` itself (one value per driven element, of modulus 1 at most).
    pub fn of(elements: usize, driven: &[usize], excitation: &[Complex64]) -> Self {
        /// Rounding error of a phasor of modulus 1.
        const ROUNDING: f64 = 1e-12;
        let mut drive = Self::uniform(elements, driven, excitation);
        for (&element, u) in driven.iter().zip(excitation) {
            // No overflow guard as in `hypot`: all values are at most 1.
            let modulus = u.norm_sqr().sqrt();
            drive.amplitudes[element] = if modulus > 1.0 - ROUNDING { 1.0 } else { modulus };
        }
        drive
    }

    /// The `excitation`, scaled so that the largest amplitude is full drive.
    pub fn free(elements: usize, driven: &[usize], excitation: &[Complex64]) -> Self {
        let largest = excitation.iter().map(|u| u.norm()).fold(f64::MIN_POSITIVE, f64::max);
        let scaled: Vec<_> = excitation.iter().map(|u| u / largest).collect();
        Self::of(elements, driven, &scaled)
    }

    /// Writes CSV for [`read`]: the columns `element`, `x`, `y` and, unless all are 0, `z` (m), `phase` (rad)
    /// and `amplitude`.
    pub fn write(&self, aperture: &Aperture) -> String {
        Self::write_in_turn(std::slice::from_ref(self), aperture)
    }

    /// The same of drives in turn, one after the other; several have a further column `frame`, from 0.
    pub fn write_in_turn(drives: &[Self], aperture: &Aperture) -> String {
        let is_flat = aperture.positions.iter().all(|position| position.z == 0.0);
        let mut text = String::from(if is_flat { "element,x,y" } else { "element,x,y,z" });
        text.push_str(",phase,amplitude");
        text.push_str(if drives.len() > 1 { ",frame\n" } else { "\n" });
        for (frame, drive) in drives.iter().enumerate() {
            let frame = if drives.len() > 1 { format!(",{frame}") } else { String::new() };
            for (element, position) in aperture.positions.iter().enumerate() {
                let (phase, amplitude) = (drive.phases[element], drive.amplitudes[element]);
                let z = if is_flat { String::new() } else { format!("{:?},", position.z) };
                text.push_str(&format!(
                    "{element},{:?},{:?},{z}{phase:?},{amplitude:?}{frame}\n",
                    position.x, position.y
                ));
            }
        }
        text
    }

    /// The drive quantised to `levels` phases per period.
    ///
    /// # Panics
    /// No levels.
    pub fn at_levels(&self, levels: u32) -> Self {
        let played = |&phase: &f64| {
            let turns = -f64::from(delay_level(phase, levels)) / f64::from(levels);
            TAU * if turns <= -0.5 { turns + 1.0 } else { turns }
        };
        Self { amplitudes: self.amplitudes.clone(), phases: self.phases.iter().map(played).collect() }
    }

    /// The drive of some elements.
    ///
    /// # Panics
    /// Elements out of range.
    pub fn part(&self, elements: Range<usize>) -> Self {
        let some = |values: &[f64]| values[elements.clone()].to_vec();
        Self { amplitudes: some(&self.amplitudes), phases: some(&self.phases) }
    }

    /// u of each of the `driven` elements.
    pub fn excitation(&self, driven: &[usize]) -> Vec<Complex64> {
        driven.iter().map(|&n| Complex64::from_polar(self.amplitudes[n], self.phases[n])).collect()
    }
}

/// Reads the drives of a file for an array, in one of two forms.
///
/// With a row per element: `phase` (rad) and optionally `amplitude` (0 to 1, by default 1), or `re` and `im`; optionally
/// `element` (from 0; without the column in order), which allows leaving elements out: they are silent; several drives
/// by `frame` (or `drive`), optionally with `time` (s); optionally the elements' `x`, `y` and `z` (m), which must be the array's.
///
/// With a row per drive: `phase_0`, `phase_1` … of all elements (`nan`: silent), and optionally `time` and `amplitude_0`,
/// `amplitude_1` ….
///
/// # Errors
/// Missing columns, an invalid row, duplicate elements, another number of elements than the array's, positions of
/// another array, or uneven times.
pub fn read(csv: impl Read, aperture: &Aperture) -> Result<DriveTable, TableError> {
    let mut table = Table::open(csv, [], COLUMNS)?;
    let elements = aperture.positions.len();
    let mut frames = Frames { elements, all: BTreeMap::new() };
    let (phases, amplitudes) = (table.series(PHASES, 0)?, table.series(AMPLITUDES, 0)?);
    if !phases.is_empty() {
        for (places, prefix) in [(&phases, PHASES), (&amplitudes, AMPLITUDES)] {
            if places.len() != elements && (prefix == PHASES || !places.is_empty()) {
                let last = places.len() - 1;
                let count = places.len();
                return Err(table.refusal(format!(
                    "the columns {prefix}0 to {prefix}{last} are of {count} elements, and the scene has {elements}"
                )));
            }
        }
        while let Some(row) = table.next_row()? {
            let [_, _, _, _, _, frame, time, _, _, _, drive] = row.optional;
            let refused = |reason: String| table.refusal(reason);
            let number = frame.or(drive).unwrap_or(frames.all.len() as f64);
            let frame = frames.at(number, time, table.line()).map_err(refused)?;
            for (element, &place) in phases.iter().enumerate() {
                let Some(phase) = table.value("phase", place)? else { continue };
                let amplitude =
                    amplitudes.get(element).map_or(Ok(Some(1.0)), |&at| table.value("amplitude", at))?;
                frame.set(element, phase, amplitude.unwrap_or(0.0)).map_err(refused)?;
            }
            frame.given.fill(true);
        }
        return frames.finish(table.line());
    }
    let is_complex = table.has("re") && table.has("im");
    if !is_complex && !table.has("phase") {
        return Err(table.refusal("the column `phase` is missing"));
    }
    let is_numbered = table.has("element");
    while let Some(row) = table.next_row()? {
        let [element, phase, amplitude, re, im, frame, time, x, y, z, drive] = row.optional;
        let refused = |reason: String| table.refusal(reason);
        let frame = frames.at(frame.or(drive).unwrap_or(0.0), time, table.line()).map_err(refused)?;
        frame.rows += 1;
        let element = match element {
            // Rows beyond the last element are counted and refused below.
            None if frame.rows > elements => continue,
            None => frame.rows - 1,
            Some(element) if element.fract() == 0.0 && (0.0..elements as f64).contains(&element) => {
                element as usize
            }
            Some(element) => {
                let last = elements.saturating_sub(1);
                return Err(refused(format!(
                    "element = {element:?}: the scene's elements are numbered 0 to {last}"
                )));
            }
        };
        let (phase, amplitude) = match (phase, re.zip(im)) {
            (Some(phase), _) => (phase, amplitude.unwrap_or(1.0)),
            (None, Some((re, im))) => polar(Complex64::new(re, im)).map_err(refused)?,
            (None, None) => (0.0, 0.0),
        };
        frame.set(element, phase, amplitude).map_err(refused)?;
        let place = aperture.positions[element];
        if let Some(at) = elsewhere(place, [x, y, z], ASTRAY * aperture.wavelength()) {
            return Err(refused(format!(
                "element {element} is at {}, and the scene's at {}: the drive is of another array",
                metres(at),
                metres(place)
            )));
        }
    }
    if !is_numbered {
        let whole = |frame: &Frame| frame.rows == elements;
        if let Some((number, frame)) = frames.all.iter().find(|(_, frame)| !whole(frame)) {
            let rows = match frames.all.len() {
                1 => format!("the file has {} rows", frame.rows),
                _ => format!("frame {number} has {} rows", frame.rows),
            };
            let hint = match frame.rows > elements {
                true => "several drives need a column `frame`",
                false => "only with a column `element` may some be left out",
            };
            let reason = format!("{rows}, and the scene has {elements} elements: {hint}");
            return Err(TableError { line: frame.line, reason });
        }
    }
    frames.finish(table.line())
}

/// Whether a file has the columns of drives.
#[doc(hidden)]
pub fn is_table(csv: impl Read) -> bool {
    Table::<_, 0, 11>::open(csv, [], COLUMNS).is_ok_and(|mut table| {
        let has_series = table.series(PHASES, 0).is_ok_and(|places| !places.is_empty());
        table.has("phase") || (table.has("re") && table.has("im")) || has_series
    })
}

/// The drives of a file by their numbers.
struct Frames {
    elements: usize,
    all: BTreeMap<u64, Frame>,
}

struct Frame {
    drive: Drive,
    given: Vec<bool>,
    time: Option<f64>,
    /// The line of its last row.
    line: u64,
    rows: usize,
}

impl Frames {
    /// The frame of a row.
    fn at(&mut self, number: f64, time: Option<f64>, line: u64) -> Result<&mut Frame, String> {
        /// Bytes per element: drive, and whether it is given.
        const EACH: usize = 2 * size_of::<f64>() + 1;
        if number.fract() != 0.0 || !(0.0..=u32::MAX.into()).contains(&number) {
            return Err(format!("frame = {number:?}: must be a whole number from 0"));
        }
        let (number, elements) = (number as u64, self.elements);
        if !self.all.contains_key(&number) && (self.all.len() + 1) * elements * EACH > MOST_BYTES {
            return Err(format!("more than {} frames of {elements} elements: the limit", self.all.len()));
        }
        let frame = self.all.entry(number).or_insert_with(|| Frame {
            drive: Drive { amplitudes: vec![0.0; elements], phases: vec![0.0; elements] },
            given: vec![false; elements],
            time,
            line,
            rows: 0,
        });
        frame.line = line;
        Ok(frame)
    }

    /// `line` is the last of the file.
    fn finish(self, line: u64) -> Result<DriveTable, TableError> {
        let frames: Vec<_> = self.all.into_values().collect();
        let left_out = |frame: &Frame| frame.given.iter().filter(|given| !**given).count();
        let Some(left_out) = frames.iter().map(left_out).max() else {
            let reason = format!("the table has no rows, and the scene has {} elements", self.elements);
            return Err(TableError { line, reason });
        };
        let rate = rate(&frames)?;
        Ok(DriveTable { drives: frames.into_iter().map(|frame| frame.drive).collect(), rate, left_out })
    }
}

impl Frame {
    fn set(&mut self, element: usize, phase: f64, amplitude: f64) -> Result<(), String> {
        if !(0.0..=1.0).contains(&amplitude) {
            return Err(format!("amplitude = {amplitude:?}: must be from 0 to 1"));
        }
        if std::mem::replace(&mut self.given[element], true) {
            return Err(format!("element {element} is given twice: several drives need a column `frame`"));
        }
        (self.drive.phases[element], self.drive.amplitudes[element]) = (wrapped(phase), amplitude);
        Ok(())
    }
}

/// Frames per second, if there are several with times.
fn rate(frames: &[Frame]) -> Result<Option<f64>, TableError> {
    let times: Option<Vec<_>> = frames.iter().map(|frame| Some((frame.time?, frame.line))).collect();
    let times = times.unwrap_or_default();
    let [(first, _), .., (last, _)] = times[..] else { return Ok(None) };
    let each = (last - first) / (times.len() - 1) as f64;
    let is_even = |pair: &[(f64, u64)]| ((pair[1].0 - pair[0].0) / each - 1.0).abs() < UNEVEN;
    let rate = each.recip();
    match times.windows(2).find(|pair| !is_even(pair)) {
        None if RATES.contains(&rate) => Ok(Some(rate)),
        None => {
            let [least, most] = [RATES.start(), RATES.end()];
            let reason = format!("the times make {rate:e} frames per second: must be {least:e} to {most:e}");
            Err(TableError { line: times[1].1, reason })
        }
        Some(pair) => {
            let (time, line) = pair[1];
            let reason = format!("time = {time:?}: frames must follow each other at even times");
            Err(TableError { line, reason })
        }
    }
}

/// Phase and amplitude.
fn polar(u: Complex64) -> Result<(f64, f64), String> {
    let amplitude = u.norm();
    if amplitude > 1.0 + ROUNDING {
        return Err(format!("|re + j im| = {amplitude:?}: must be at most 1, full drive"));
    }
    Ok((u.arg(), amplitude.min(1.0)))
}

/// A file's position (m), if it is not an element's.
fn elsewhere(place: DVec3, given: [Option<f64>; 3], tolerance: f64) -> Option<DVec3> {
    let own = place.to_array();
    let at = DVec3::from_array([0, 1, 2].map(|axis| given[axis].unwrap_or(own[axis])));
    (at.distance(place) > tolerance).then_some(at)
}

/// A position (m) in the digits of the file.
fn metres(place: DVec3) -> String {
    let [x, y, z] = place.to_array();
    format!("({x:?}, {y:?}, {z:?}) m")
}

/// A phase (rad) wrapped to (-π, π], unchanged if already there.
fn wrapped(phase: f64) -> f64 {
    if -PI < phase && phase <= PI { phase } else { phase.sin().atan2(phase.cos()) }
}

/// The delay level of a phase (rad), of `levels` per period: boards use delay, and the sign is converted only here. A
/// NaN phase has no delay.
///
/// # Panics
/// No levels.
pub fn delay_level(phase: f64, levels: u32) -> u32 {
    let delay = (-phase / TAU).rem_euclid(1.0);
    (delay * f64::from(levels)).round() as u32 % levels
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Array, Elements, Placed, Scene};

    fn one(text: &str, aperture: &Aperture) -> Result<Drive, TableError> {
        read(text.as_bytes(), aperture).map(|mut table| table.drives.remove(0))
    }

    /// A scene of one row of elements.
    fn row_of(columns: u32) -> Scene {
        Scene { array: Array { rows: 1, columns, ..Array::default() }, ..Scene::default() }
    }

    #[test]
    fn a_phase_ahead_is_a_delay_of_the_rest_of_the_period() {
        assert_eq!(delay_level(0.0, 32), 0);
        assert_eq!(delay_level(TAU / 4.0, 32), 24);
        assert_eq!(delay_level(-TAU / 4.0, 32), 8);
        assert_eq!(delay_level(5.0 * TAU - TAU / 4.0, 32), 8);
    }

    #[test]
    fn rounding_up_to_a_whole_period_wraps() {
        assert_eq!(delay_level(1e-9, 128), 0);
        assert_eq!(delay_level(TAU * 0.002, 128), 0);
    }

    #[test]
    fn played_phases_are_the_nearest_levels() {
        let drive =
            Drive { amplitudes: vec![1.0; 41], phases: (-20..=20).map(|i| f64::from(i) / 6.4).collect() };
        for levels in [2, 3, 8, 32, 256] {
            let played = drive.at_levels(levels);
            for (wanted, phase) in drive.phases.iter().zip(&played.phases) {
                let off = (wanted - phase).rem_euclid(TAU);
                assert!(
                    off.min(TAU - off) <= TAU / 2.0 / f64::from(levels) + 1e-12,
                    "{levels}: {wanted} as {phase}"
                );
                assert!(-PI < *phase && *phase <= PI, "{phase}");
                let level = delay_level(*phase, levels);
                assert_eq!(level, delay_level(*wanted, levels), "playing what is played changes nothing");
            }
        }
    }

    #[test]
    fn a_free_drive_keeps_ratios_and_its_loudest_element_plays_fully() {
        let values = [(3.0, 1.0), (0.0, 0.0), (6.0, -2.0)].map(|(r, phase)| Complex64::from_polar(r, phase));
        let drive = Drive::free(4, &[0, 1, 3], &values);
        assert!((drive.amplitudes[0] - 0.5).abs() < 1e-15 && drive.amplitudes[1..] == [0.0, 0.0, 1.0]);
        assert!((drive.phases[3] + 2.0).abs() < 1e-15);
        assert_eq!(Drive::free(1, &[0], &[Complex64::ZERO]).amplitudes, [0.0], "nothing stays nothing");
    }

    #[test]
    fn a_table_is_read_as_it_was_written() {
        let scene = Scene { array: Array { rows: 2, columns: 2, ..Array::default() }, ..Scene::default() };
        let drive = Drive { amplitudes: vec![1.0, 0.0, 0.3, 1.0], phases: vec![PI, -0.0, 1e-9, -3.0] };
        let aperture = Aperture::new(&scene);
        let text = drive.write(&aperture);
        assert_eq!(text.lines().count(), 5);
        assert!(text.starts_with("element,x,y,phase,amplitude\n"), "a flat array has no heights: {text}");
        assert_eq!(one(&text, &aperture), Ok(drive));
        let in_order = one("phase\n0\n7.0\n1e300\n-4.0\n", &aperture).unwrap();
        assert_eq!(in_order.amplitudes, [1.0; 4]);
        assert!((in_order.phases[3] - (TAU - 4.0)).abs() < 1e-12);
        assert!((in_order.phases[1] - (7.0 - TAU)).abs() < 1e-12 && in_order.phases[2].abs() <= PI);
    }

    #[test]
    fn heights_are_written_if_any_element_has_one() {
        let placed = |z: f64| Placed { at: [0.01, 2.0 * z, z].into(), normal: [0.0, 0.0, 1.0].into() };
        let placed = Elements::new([-0.004, 0.0, 0.004].map(placed).to_vec(), None);
        let array = Array { placed, file: Some("stairs.csv".to_owned()), ..Array::default() };
        let aperture = Aperture::new(&Scene { array, ..Scene::default() });
        assert_eq!(aperture.positions[1].z, 0.0);
        let drive = Drive { amplitudes: vec![1.0, 0.5, 0.25], phases: vec![0.1, -0.2, 0.3] };
        let text = drive.write(&aperture);
        assert!(text.starts_with("element,x,y,z,phase,amplitude\n"), "{text}");
        assert_eq!(one(&text, &aperture), Ok(drive));
    }

    #[test]
    fn phases_within_half_a_turn_are_kept_to_the_last_digit_and_others_wrapped() {
        for i in -999..=1000 {
            let phase = PI * f64::from(i) / 1000.0;
            assert_eq!(wrapped(phase), phase);
            for turns in [-3.0, -1.0, 1.0, 2.0] {
                let off = (wrapped(phase + TAU * turns) - phase).abs();
                assert!(off.min(TAU - off) < 1e-12, "{phase} and {turns} turns: {off}");
            }
        }
    }

    #[test]
    fn a_table_that_is_no_drive_is_refused_by_line() {
        let two = Aperture::new(&row_of(2));
        for (text, error) in [
            ("element\n0\n1\n", "1: the column `phase` is missing"),
            ("phase\n", "1: the table has no rows, and the scene has 2 elements"),
            ("phase\n0\n", "2: the file has 1 rows, and the scene has 2 elements: only with"),
            ("phase\n0\n\n0\n0\n", "5: the file has 3 rows, and the scene has 2 elements: several"),
            ("phase,frame\n0,1\n0,1\n1,2\n", "4: frame 2 has 1 rows, and the scene has 2"),
            ("phase,element\n0,0.5\n", "2: element = 0.5: the scene's elements are numbered 0 to 1"),
            ("phase,element\n0,1\n0,1\n", "3: element 1 is given twice"),
            ("phase,frame\n0,-1\n", "2: frame = -1.0: must be"),
            ("phase,amplitude\n0,1.5\n", "2: amplitude = 1.5: must be"),
            ("phase,amplitude\n0,0.5\n0,\n", "3: amplitude is empty"),
            ("phase\n0\nnan\n", "3: phase = `nan`: not a finite number"),
            ("re,im\n0,0.5\n1,1\n", "3: |re + j im| = 1.4142135623730951: must be"),
            ("phase,x\n0,-0.005\n0,0.05\n", "3: element 1 is at (0.05, 0.0, 0.0) m, and the scene's at ("),
            ("phase_0,phase_1,phase_2\n0,1,2\n", "1: the columns phase_0 to phase_2 are of 3 elements, and"),
            ("time,phase_0,phase_1\n0,0,0\n1,0,0\n3,0,0\n", "3: time = 1.0: frames must"),
            ("time,phase_0,phase_1\n1,0,0\n1,0,0\n", "3: time = 1.0: frames must"),
            ("time,phase_0,phase_1\n1,0,0\n0,0,0\n", "3: the times make -1e0 frames per second"),
        ] {
            let refused = read(text.as_bytes(), &two).unwrap_err().to_string();
            assert!(refused.starts_with(error), "{text:?}: {refused}");
        }
    }

    #[test]
    fn drives_of_several_forms_are_the_same() {
        let two = Aperture::new(&row_of(2));
        let drives = [([1.0, 0.5], [0.5, -1.0]), ([1.0, 0.0], [2.0, 0.0])];
        let drives =
            drives.map(|(amplitudes, phases)| Drive { amplitudes: amplitudes.into(), phases: phases.into() });
        for (text, rate, left_out) in [
            ("frame,phase,element,amplitude\n7,2,0,1\n2,-1,1,.5\n2,.5,0,1\n", None, 1),
            ("phase\tamplitude\tframe\n.5\t1\t0\n-1\t.5\t0\n2\t1\t1\n0\t0\t1\n", None, 0),
            ("time;phase_0;phase_1;amplitude_0;amplitude_1\n0;0,5;-1;1;0,5\n0,25;2;nan;1;1\n", Some(4.0), 0),
        ] {
            let read = read(text.as_bytes(), &two).unwrap();
            assert_eq!(read, DriveTable { drives: drives.to_vec(), rate, left_out }, "{text}");
        }
        let [re, im] = [0.5f64.cos(), 0.5f64.sin()];
        let read = one(&format!("im re\n{im} {re}\n0 -.5"), &two).unwrap();
        assert!((read.phases[0] - 0.5).abs() < 1e-12 && read.phases[1] == PI, "{read:?}");
        assert!((read.amplitudes[0] - 1.0).abs() < 1e-12 && read.amplitudes[1] == 0.5, "{read:?}");
        assert!(is_table(&b"x,y,Phase\n"[..]) && !is_table(&b"x,y,z,nx,ny,nz\n"[..]));
    }

    #[test]
    fn elements_that_are_off_stay_silent() {
        let drive =
            Drive::uniform(3, &[0, 2], &[Complex64::from_polar(5.0, 1.0), Complex64::from_polar(0.1, -2.0)]);
        assert_eq!(drive.amplitudes, [1.0, 0.0, 1.0]);
        assert!((drive.phases[0] - 1.0).abs() < 1e-15 && (drive.phases[2] + 2.0).abs() < 1e-15);
    }
}
