//! What one's own transducers do differently, element by element, from a file.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;

/// Per element; an element that is not listed is as it should be.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Calibration {
    elements: Vec<Element>,
}

/// One row of the file.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct Element {
    element: usize,
    /// How far its sound is ahead of the others', degrees; 180 for one that is soldered the other way round.
    offset: f64,
    /// Factor on its amplitude, 0 to 1.
    gain: f64,
    /// 1: not driven
    off: u8,
}

#[derive(Debug, PartialEq, thiserror::Error)]
pub enum CalibrationError {
    #[error("{0}")]
    Unreadable(String),
    #[error("line {line}: {reason}")]
    Row { line: u64, reason: String },
    #[error("{} of {elements} elements are missing: {}", missing.len(), listed(missing))]
    Gaps { missing: Vec<usize>, elements: usize },
}

/// The first few numbers.
fn listed(numbers: &[usize]) -> String {
    const SHOWN: usize = 8;
    let shown: Vec<_> = numbers.iter().take(SHOWN).map(ToString::to_string).collect();
    format!("{}{}", shown.join(", "), if numbers.len() > SHOWN { ", ..." } else { "" })
}

impl Calibration {
    /// From CSV with the columns `element` (from 0), `offset` (degrees), `gain` (0 to 1) and `off` (0 or 1), one row for each of
    /// the `elements`, in any order.
    ///
    /// # Errors
    /// A file that cannot be read, a row that makes no sense, elements listed twice or not at all.
    pub fn read(path: &Path, elements: usize) -> Result<Self, CalibrationError> {
        let text =
            std::fs::read_to_string(path).map_err(|error| CalibrationError::Unreadable(error.to_string()))?;
        Self::parse(&text, elements)
    }

    /// As [`Self::read`], from the file's text.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn parse(text: &str, elements: usize) -> Result<Self, CalibrationError> {
        let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text.as_bytes());
        let mut rows = BTreeMap::new();
        let headers = reader.headers().cloned().unwrap_or_default();
        let mut record = csv::StringRecord::new();
        loop {
            let line = reader.position().line();
            let row = |reason: String| CalibrationError::Row { line, reason };
            match reader.read_record(&mut record) {
                Ok(false) => break,
                Ok(true) => {}
                Err(error) => return Err(row(error.to_string())),
            }
            let element: Element = record.deserialize(Some(&headers)).map_err(|error| row(reason(&error)))?;
            element.check(elements).map_err(row)?;
            if rows.insert(element.element, element).is_some() {
                return Err(row(format!("element {} stands here a second time", element.element)));
            }
        }
        let missing: Vec<_> = (0..elements).filter(|element| !rows.contains_key(element)).collect();
        if !missing.is_empty() {
            return Err(CalibrationError::Gaps { missing, elements });
        }
        Ok(Self { elements: rows.into_values().collect() })
    }

    /// Amplitude and phase (rad) that make `element` sound as an ordinary one would at these.
    pub fn corrected(&self, element: usize, amplitude: f64, phase: f64) -> (f64, f64) {
        match self.elements.get(element) {
            None => (amplitude, phase),
            Some(one) if one.off == 1 => (0.0, phase),
            Some(one) => (amplitude * one.gain, phase - one.offset.to_radians()),
        }
    }

    /// Whether an element is to play more softly than others.
    pub fn has_gains(&self) -> bool {
        self.elements.iter().any(|one| one.off == 0 && one.gain > 0.0 && one.gain < 1.0)
    }
}

/// What the CSV reader has to say about a row, without its own account of where.
fn reason(error: &csv::Error) -> String {
    match error.kind() {
        csv::ErrorKind::Deserialize { err, .. } => {
            format!("{err}; the columns are element, offset (degrees), gain (0 to 1), off (0 or 1)")
        }
        _ => error.to_string(),
    }
}

impl Element {
    fn check(&self, elements: usize) -> Result<(), String> {
        if self.element >= elements {
            return Err(format!(
                "element {} is beyond the last, {}",
                self.element,
                elements.saturating_sub(1)
            ));
        }
        if !(-360.0..=360.0).contains(&self.offset) {
            return Err(format!("offset {} is not between -360 and 360 degrees", self.offset));
        }
        if !(0.0..=1.0).contains(&self.gain) {
            return Err(format!("gain {} is not between 0 and 1", self.gain));
        }
        if self.off > 1 {
            return Err(format!("off {} is neither 0 nor 1", self.off));
        }
        Ok(())
    }
}
