//! Calibration of transducers, element by element, from a file.

use std::collections::BTreeMap;
use std::path::Path;

use crate::source;
use crate::table::{Table, TableError};

/// Bytes of a file, at most.
const MOST_BYTES: u64 = 1 << 20;

/// Per element; a missing element needs no correction.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Calibration {
    elements: Vec<Element>,
}

/// One row of the file.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Element {
    /// Phase lead of its sound, degrees; 180 for reversed polarity.
    offset: f64,
    /// Factor on its amplitude, 0 to 1.
    gain: f64,
    /// The element is not driven.
    off: bool,
}

#[derive(Debug, PartialEq, thiserror::Error)]
pub enum CalibrationError {
    #[error("{0}")]
    Unreadable(String),
    #[error("line {0}")]
    Row(TableError),
    #[error("{} of {elements} elements are missing: {}", missing.len(), listed(missing))]
    Gaps { missing: Vec<usize>, elements: usize },
}

/// The row's error is printed in full above, so it is not also a source.
impl From<TableError> for CalibrationError {
    fn from(error: TableError) -> Self {
        Self::Row(error)
    }
}

/// The first few numbers.
fn listed(numbers: &[usize]) -> String {
    const SHOWN: usize = 8;
    let shown: Vec<_> = numbers.iter().take(SHOWN).map(ToString::to_string).collect();
    format!("{}{}", shown.join(", "), if numbers.len() > SHOWN { ", ..." } else { "" })
}

impl Calibration {
    /// Reads CSV with the columns `element` (from 0), `offset` (degrees), `gain` (0 to 1) and `off` (0 or 1), one row
    /// for each of the `elements`, in any order. Other columns are the user's own.
    ///
    /// # Errors
    /// An unreadable file, an invalid row, duplicate or missing elements.
    pub fn read(path: &Path, elements: usize) -> Result<Self, CalibrationError> {
        let text = source::read_text(path, MOST_BYTES);
        let text = text.map_err(|error| CalibrationError::Unreadable(error.to_string()))?;
        Self::parse(&text, elements)
    }

    /// Reads the file's text, like [`Self::read`].
    ///
    /// # Errors
    /// The errors of [`Self::read`].
    pub fn parse(text: &str, elements: usize) -> Result<Self, CalibrationError> {
        let mut table = Table::open(text.as_bytes(), ["element", "offset", "gain", "off"], [])?;
        let mut rows = BTreeMap::new();
        while let Some(row) = table.next_row()? {
            let (number, element) =
                Element::of(row.required, elements).map_err(|reason| table.refusal(reason))?;
            if rows.insert(number, element).is_some() {
                return Err(table.refusal(format!("element {number} is listed twice")).into());
            }
        }
        let missing: Vec<_> = (0..elements).filter(|element| !rows.contains_key(element)).collect();
        if !missing.is_empty() {
            return Err(CalibrationError::Gaps { missing, elements });
        }
        Ok(Self { elements: rows.into_values().collect() })
    }

    /// Corrected amplitude and phase (rad) for `element`.
    pub fn corrected(&self, element: usize, amplitude: f64, phase: f64) -> (f64, f64) {
        match self.elements.get(element) {
            None => (amplitude, phase),
            Some(one) if one.off => (0.0, phase),
            Some(one) => (amplitude * one.gain, phase - one.offset.to_radians()),
        }
    }

    /// Has an element of `elements` driven, or not.
    pub fn set_off(&mut self, element: usize, elements: usize, off: bool) {
        self.elements
            .resize(self.elements.len().max(elements), Element { offset: 0.0, gain: 1.0, off: false });
        if let Some(one) = self.elements.get_mut(element) {
            one.off = off;
        }
    }

    /// Undriven elements.
    pub fn off(&self) -> Vec<usize> {
        (0..self.elements.len()).filter(|&element| self.elements[element].off).collect()
    }

    /// The file that [`Self::parse`] reads, with a row for each of the `elements`.
    pub fn to_csv(&self, elements: usize) -> String {
        let ordinary = Element { offset: 0.0, gain: 1.0, off: false };
        let mut text = "element,offset,gain,off\n".to_owned();
        for element in 0..elements {
            let Element { offset, gain, off } = self.elements.get(element).copied().unwrap_or(ordinary);
            text += &format!("{element},{offset},{gain},{}\n", u8::from(off));
        }
        text
    }

    /// Whether any element has a reduced gain.
    pub fn has_gains(&self) -> bool {
        self.elements.iter().any(|one| !one.off && one.gain > 0.0 && one.gain < 1.0)
    }
}

impl Element {
    /// The element's number and its correction.
    fn of([element, offset, gain, off]: [f64; 4], elements: usize) -> Result<(usize, Self), String> {
        if element.fract() != 0.0 || element < 0.0 || element >= elements as f64 {
            return Err(format!("element {element:?} is out of range (0-{})", elements.saturating_sub(1)));
        }
        if !(-360.0..=360.0).contains(&offset) {
            return Err(format!("offset {offset:?} is not between -360 and 360 degrees"));
        }
        if !(0.0..=1.0).contains(&gain) {
            return Err(format!("gain {gain:?} is not between 0 and 1"));
        }
        if off != 0.0 && off != 1.0 {
            return Err(format!("off {off:?} is neither 0 nor 1"));
        }
        Ok((element as usize, Self { offset, gain, off: off == 1.0 }))
    }
}
