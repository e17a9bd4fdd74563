//! The file of an OpenMPD board (`.pat`): positions, pins and corrections of its transducers.
//!
//! Lines: the board's name, the number of transducers, of phase levels; then lists by transducer: positions `(x, y, z)`
//! in metres, pins (the board's channels), phases in degrees and amplitudes. OpenMPD sends `phase - adjust`, and its
//! phases are delays: a transducer with a positive phase lags. Its document has the corrections by pin, its driver
//! (`AsierInhoImpl.cpp`, `discretizePhases`) and solver (`discretise`) by transducer, as here.

use crate::echo;
use crate::scene::{Correction, Wire};
use crate::table::TableError;

/// The content of a file, by transducer.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct BoardFile {
    /// m; they radiate along z.
    pub places: Vec<[f64; 3]>,
    /// Line of the places.
    pub line: u64,
    /// Empty if the file ends with the places.
    pub wires: Vec<Wire>,
    /// As many as wires.
    pub corrections: Vec<Correction>,
}

/// Whether a text is such a file: its fourth line is a list of positions.
pub(crate) fn is_board(text: &str) -> bool {
    lines(text).nth(3).is_some_and(|(_, line)| line.starts_with('('))
}

/// Lines with content, and their numbers.
fn lines(text: &str) -> impl Iterator<Item = (u64, &str)> {
    let text = text.trim_start_matches('\u{feff}');
    let lines = text.lines().enumerate().map(|(index, line)| (index as u64 + 1, line.trim()));
    lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#'))
}

/// # Errors
/// A missing list, one of another length, an invalid number, or a pin of two transducers.
pub(crate) fn read(text: &str) -> Result<BoardFile, TableError> {
    let mut lines = lines(text).skip(1);
    let mut count = |what: &str| {
        let (line, text) = lines.next().ok_or_else(|| refusal(1, "the table ends early"))?;
        text.parse::<usize>()
            .map_err(|_| refusal(line, format!("`{}`: not the number of {what}", echo::value(text))))
    };
    let (elements, _) = (count("elements")?, count("phase levels")?);
    let (line, text) = lines.next().ok_or_else(|| refusal(1, "the table ends early"))?;
    let places = places(line, text)?;
    if places.len() != elements {
        return Err(refusal(line, format!("{} places for {elements} elements", places.len())));
    }
    let mut list = |what: &str| match lines.next() {
        Some((line, text)) => numbers(line, text, what, elements).map(|numbers| Some((line, numbers))),
        None => Ok(None),
    };
    let Some((pins_line, pins)) = list("pins")? else {
        return Ok(BoardFile { places, line, ..BoardFile::default() });
    };
    let wires = wires(pins_line, &pins)?;
    let (phases_line, phases) =
        list("phases")?.ok_or_else(|| refusal(pins_line, "no phases follow the pins"))?;
    let (gains_line, gains) = list("amplitudes")?.unwrap_or_else(|| (phases_line, vec![1.0; elements]));
    let corrections = phases.iter().zip(gains).enumerate().map(|(n, (&phase, gain))| {
        if !(-360.0..=360.0).contains(&phase) {
            return Err(refusal(phases_line, format!("phase {n} is {phase}, not from -360 to 360 degrees")));
        }
        if !(0.0..=1.0).contains(&gain) {
            return Err(refusal(gains_line, format!("amplitude {n} is {gain}, not from 0 to 1")));
        }
        Ok(Correction { offset: -phase, gain, off: false })
    });
    let corrections = corrections.collect::<Result<_, _>>()?;
    Ok(BoardFile { places, line, wires, corrections })
}

fn places(line: u64, text: &str) -> Result<Vec<[f64; 3]>, TableError> {
    let place = |(index, place): (usize, &str)| {
        let fields = place.split(')').next().unwrap_or("").split(',');
        let numbers: Result<Vec<f64>, _> = fields.map(|field| field.trim().parse()).collect();
        match numbers.map(<[f64; 3]>::try_from) {
            Ok(Ok(place)) => Ok(place),
            Ok(Err(_)) | Err(_) => {
                Err(refusal(line, format!("place {}: not (x, y, z) in metres", index + 1)))
            }
        }
    };
    text.split('(').skip(1).enumerate().map(place).collect()
}

/// As many numbers as elements, with or without a last comma.
fn numbers(line: u64, text: &str, what: &str, elements: usize) -> Result<Vec<f64>, TableError> {
    let number = |field: &str| match field.trim().parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(refusal(line, format!("`{}` in the list of {what}: not a number", echo::value(field)))),
    };
    let fields = text.strip_suffix(',').unwrap_or(text).split(',');
    let numbers = fields.map(number).collect::<Result<Vec<_>, _>>()?;
    if numbers.len() == elements {
        return Ok(numbers);
    }
    Err(refusal(line, format!("{} {what} for {elements} elements", numbers.len())))
}

fn wires(line: u64, pins: &[f64]) -> Result<Vec<Wire>, TableError> {
    let mut wires: Vec<Wire> = Vec::new();
    let mut seen = std::collections::HashMap::new();
    for (n, &pin) in pins.iter().enumerate() {
        if pin.fract() != 0.0 || !(0.0..f64::from(u16::MAX)).contains(&pin) {
            return Err(refusal(line, format!("pin {pin} of transducer {n}: not a channel's number")));
        }
        if let Some(first) = seen.insert(pin as u32, n) {
            return Err(refusal(line, format!("pin {pin} is that of the transducers {first} and {n}")));
        }
        wires.push(Wire { channel: pin as u32, line });
    }
    Ok(wires)
}

impl BoardFile {
    /// The transducer at each place of an array (m), whatever their order.
    ///
    /// # Errors
    /// An array with other places.
    pub(crate) fn transducers_at(&self, places: &[[f64; 3]]) -> Result<Vec<usize>, TableError> {
        if places.len() != self.places.len() {
            let reason = format!("{} places, and the array has {}", self.places.len(), places.len());
            return Err(refusal(self.line, reason));
        }
        let nearest = |at: [f64; 3], but: Option<usize>| {
            let others = (0..self.places.len()).filter(|&n| Some(n) != but);
            others
                .map(|n| (n, distance(self.places[n], at)))
                .min_by(|(_, a), (_, b)| a.total_cmp(b))
                .unwrap_or((0, f64::INFINITY))
        };
        let mut taken = vec![false; places.len()];
        let transducer = |(element, &at): (usize, &[f64; 3])| {
            let (transducer, apart) = nearest(at, None);
            let spacing = nearest(self.places[transducer], Some(transducer)).1;
            if apart < spacing / 2.0 && !std::mem::replace(&mut taken[transducer], true) {
                return Ok(transducer);
            }
            let [x, y, z] = at.map(|it| 1e3 * it);
            let reason = format!("no place is that of element {element}, ({x:.2}, {y:.2}, {z:.2}) mm");
            Err(refusal(self.line, reason))
        };
        places.iter().enumerate().map(transducer).collect()
    }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.into_iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

fn refusal(line: u64, reason: impl Into<String>) -> TableError {
    TableError { line, reason: reason.into() }
}
