//! Calibration of transducers, element by element, from a file.

use std::collections::BTreeMap;
use std::path::Path;

use crate::device::pat;
use crate::drive::Drive;
use crate::scene::{Correction, Scene};
use crate::source;
use crate::table::{Table, TableError};

/// Bytes of a file, at most.
const MOST_BYTES: u64 = 1 << 20;

/// Per element of a scene; empty without corrections.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Calibration {
    elements: Vec<Correction>,
}

#[derive(Debug, PartialEq, thiserror::Error)]
pub enum CalibrationError {
    #[error("{0}")]
    Unreadable(String),
    #[error("line {0}")]
    Row(TableError),
    #[error("{} of {elements} elements are missing: {}", missing.len(), listed(missing))]
    Gaps { missing: Vec<usize>, elements: usize },
    #[error("this is the file of one board, and the scene has {0}: give each board its own file")]
    OneBoard(usize),
    #[error("the file has places but no corrections")]
    NoCorrections,
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
    /// Reads the corrections of a scene's elements: CSV as for [`Self::parse`], or an OpenMPD board's `.pat`, whose
    /// transducers are matched by position.
    ///
    /// # Errors
    /// An unreadable file, the errors of [`Self::parse`], or a broken `.pat` or that of another array.
    pub fn read(path: &Path, scene: &Scene) -> Result<Self, CalibrationError> {
        let bytes = source::read(path, MOST_BYTES);
        let bytes = bytes.map_err(|error| CalibrationError::Unreadable(error.to_string()))?;
        let text = String::from_utf8_lossy(&bytes);
        if !pat::is_board(&text) {
            return Self::of_table(&bytes, scene.elements());
        }
        if scene.boards.len() > 1 {
            return Err(CalibrationError::OneBoard(scene.boards.len()));
        }
        let file = pat::read(&text)?;
        if file.corrections.is_empty() {
            return Err(CalibrationError::NoCorrections);
        }
        let places: Vec<_> = scene.array.places().iter().map(|it| it.at.to_array()).collect();
        let transducers = file.transducers_at(&places)?;
        Ok(Self { elements: transducers.into_iter().map(|n| file.corrections[n]).collect() })
    }

    /// The corrections that a scene has from its boards' own file.
    pub fn of(scene: &Scene) -> Self {
        let own = scene.array.placed.corrections().unwrap_or_default();
        Self { elements: own.repeat(scene.boards.len().max(1)) }
    }

    /// The corrections of a scene's boards, of `each` elements; those without need none.
    pub fn of_boards(boards: impl IntoIterator<Item = Option<Self>>, each: usize) -> Self {
        let none = || Self { elements: vec![Correction::default(); each] };
        Self { elements: boards.into_iter().flat_map(|own| own.unwrap_or_else(none).elements).collect() }
    }

    /// Elements with a correction: all of the scene's, or 0.
    pub fn elements(&self) -> usize {
        self.elements.len()
    }

    /// Reads CSV with the columns `element` (from 0), `offset` (degrees), `gain` (0 to 1) and `off` (0 or 1), one row
    /// for each of the `elements`, in any order. Other columns are the user's own.
    ///
    /// # Errors
    /// An invalid row, duplicate or missing elements.
    pub fn parse(text: &str, elements: usize) -> Result<Self, CalibrationError> {
        Self::of_table(text.as_bytes(), elements)
    }

    fn of_table(bytes: &[u8], elements: usize) -> Result<Self, CalibrationError> {
        let mut table = Table::open(bytes, ["element", "offset", "gain", "off"], [])?;
        let mut rows = BTreeMap::new();
        while let Some(row) = table.next_row()? {
            let (number, element) =
                correction(row.required, elements).map_err(|reason| table.refusal(reason))?;
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

    /// The sound of a drive by elements that need these corrections.
    pub fn sound(&self, mut drive: Drive) -> Drive {
        let values = drive.amplitudes.iter_mut().zip(&mut drive.phases);
        for ((amplitude, phase), one) in values.zip(&self.elements) {
            *amplitude = if one.off || one.gain == 0.0 { 0.0 } else { *amplitude / one.gain };
            *phase += one.offset.to_radians();
        }
        drive
    }

    /// Has an element of `elements` driven, or not.
    pub fn set_off(&mut self, element: usize, elements: usize, off: bool) {
        self.elements.resize(self.elements.len().max(elements), Correction::default());
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
        let mut text = "element,offset,gain,off\n".to_owned();
        for element in 0..elements {
            let Correction { offset, gain, off } = self.elements.get(element).copied().unwrap_or_default();
            text += &format!("{element},{offset},{gain},{}\n", u8::from(off));
        }
        text
    }

    /// Whether any element has a reduced gain.
    pub fn has_gains(&self) -> bool {
        self.elements.iter().any(|one| !one.off && one.gain > 0.0 && one.gain < 1.0)
    }
}

/// Corrections of all elements, in their order.
impl FromIterator<Correction> for Calibration {
    fn from_iter<T: IntoIterator<Item = Correction>>(elements: T) -> Self {
        Self { elements: elements.into_iter().collect() }
    }
}

/// The number of a row's element, and its correction.
fn correction(
    [element, offset, gain, off]: [f64; 4],
    elements: usize,
) -> Result<(usize, Correction), String> {
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
    Ok((element as usize, Correction { offset, gain, off: off == 1.0 }))
}
