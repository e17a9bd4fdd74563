//! Test of a board in the window: the current step, the marks of the elements, and the findings so far.

use serde::{Deserialize, Serialize};

use crate::device::calibration::Calibration;
use crate::device::profile::Profile;
use crate::device::wiring::Wiring;
use crate::studio::bring_up::{Finding, Report, Verdict};

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Step {
    /// Identification and bit rates.
    Line,
    /// One element after the other.
    Elements,
    Focus,
    EmergencyStop,
    Done,
}

impl Step {
    pub fn title(self) -> &'static str {
        match self {
            Self::Line => "1 of 5: serial link",
            Self::Elements => "2 of 5: elements",
            Self::Focus => "3 of 5: focus",
            Self::EmergencyStop => "4 of 5: emergency stop",
            Self::Done => "5 of 5: report",
        }
    }
}

#[derive(Clone, Debug, PartialEq)]
pub struct BringUp {
    pub step: Step,
    pub report: Report,
    /// Elements without a signal are switched off in it.
    pub calibration: Calibration,
    /// Whether each element gave a signal; `None`: not tested.
    pub signals: Vec<Option<bool>>,
    /// The element that plays.
    pub element: usize,
    /// The fastest error-free bit rate of this board at this port.
    pub baud: Option<u32>,
    /// Elements are modulated, for microphones.
    pub modulates: bool,
    /// Elements to mark together, as typed.
    pub range: String,
    /// The emergency stop was noticed.
    pub pressed: bool,
    /// The question before results are discarded.
    pub is_asked: bool,
    /// Where the calibration goes.
    pub file: String,
}

impl Default for BringUp {
    fn default() -> Self {
        Self {
            step: Step::Line,
            report: Report::default(),
            calibration: Calibration::default(),
            signals: Vec::new(),
            element: 0,
            baud: None,
            modulates: false,
            range: String::new(),
            pressed: false,
            is_asked: false,
            file: "calibration.csv".to_owned(),
        }
    }
}

/// A test that was left, to be continued with the same board.
#[derive(Clone, Debug, PartialEq)]
pub struct KeptTest {
    pub port: String,
    pub profile: Profile,
    pub run: BringUp,
}

/// The result of a line's survey.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Surveyed {
    pub findings: Vec<Finding>,
    /// The fastest error-free bit rate, if known.
    pub baud: Option<u32>,
}

impl BringUp {
    /// Whether cancelling would lose something.
    pub fn has_results(&self) -> bool {
        !self.report.findings.is_empty() || self.signals.iter().any(Option::is_some)
    }

    /// Elements without a signal.
    pub fn silent(&self) -> Vec<usize> {
        (0..self.signals.len()).filter(|&n| self.signals[n] == Some(false)).collect()
    }

    /// Continues from a calibration, in which elements without a signal are switched off.
    pub fn start_from(&mut self, calibration: Calibration) {
        self.calibration = calibration;
        for (element, signal) in self.signals.iter().enumerate() {
            if let Some(signal) = signal {
                self.calibration.set_off(element, self.signals.len(), !signal);
            }
        }
    }

    /// Records whether elements gave a signal, and goes to the next unmarked one; after the last, to the next step.
    pub fn mark(&mut self, elements: impl IntoIterator<Item = usize>, wiring: &Wiring, signal: bool) {
        let count = wiring.elements();
        self.signals.resize(count, None);
        let wired: Vec<_> = wiring.wired().collect();
        for element in elements {
            if wired.binary_search(&element).is_ok() {
                self.signals[element] = Some(signal);
                self.calibration.set_off(element, count, !signal);
            }
        }
        let is_open = |n: &usize| self.signals[*n].is_none();
        let next = wired.iter().copied().filter(|&n| n >= self.element).find(is_open);
        match next.or_else(|| wired.iter().copied().find(is_open)) {
            Some(next) => self.element = next,
            None => self.end_elements(wiring),
        }
    }

    /// Reports the elements, and goes to the focus.
    pub fn end_elements(&mut self, wiring: &Wiring) {
        // Elements may be tested again: the newest result counts.
        self.report.findings.retain(|finding| !finding.what.contains(SIGNAL));
        let tried = self.signals.iter().flatten().count();
        let (all, silent) = (wiring.wired().count(), self.silent());
        let names: Vec<_> = silent.iter().map(ToString::to_string).collect();
        let left = if tried < all { format!("; {} not tested", all - tried) } else { String::new() };
        let (verdict, what) = match silent.len() {
            0 => (Verdict::Passed, format!("{tried} of {all} {SIGNAL} a signal{left}")),
            count => {
                let names = names.join(", ");
                (Verdict::Failed, format!("{count} of {tried} {SIGNAL} no signal: {names}{left}"))
            }
        };
        let verdict = if tried == 0 { Verdict::Noted } else { verdict };
        self.report.note(verdict, what);
        self.step = Step::Focus;
    }
}

/// Words that mark the finding about elements.
const SIGNAL: &str = "elements gave";

/// Elements named as numbers and ranges: `0-15, 32`.
///
/// # Errors
/// The part that names no elements.
pub fn elements(text: &str, wiring: &Wiring) -> Result<Vec<usize>, String> {
    let last = wiring.elements().saturating_sub(1);
    let mut all = Vec::new();
    for part in text.split([',', ' ', ';']).filter(|part| !part.is_empty()) {
        let (from, to) = part.split_once(['-', '–']).unwrap_or((part, part));
        let number = |text: &str| text.trim().parse().ok().filter(|&n: &usize| n <= last);
        match (number(from), number(to)) {
            (Some(from), Some(to)) if from <= to => all.extend(from..=to),
            _ => return Err(format!("“{part}”: elements are 0 to {last}, such as 0-15, 32")),
        }
    }
    if all.is_empty() { Err("Type elements, such as 0-15, 32".to_owned()) } else { Ok(all) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_are_marked_one_by_one_and_by_range() {
        let wiring = Wiring::own(Profile::UltrainoMega64);
        let mut run = BringUp { step: Step::Elements, ..BringUp::default() };
        run.mark([0], &wiring, true);
        assert_eq!(run.element, 1);
        run.mark(elements("1-7, 9", &wiring).unwrap(), &wiring, true);
        assert_eq!(run.element, 8, "the first that is open");
        run.mark([8], &wiring, false);
        assert_eq!((run.element, run.silent(), run.calibration.off()), (10, vec![8], vec![8]));
        run.mark([8], &wiring, true);
        assert!(run.calibration.off().is_empty(), "the newest mark counts");
        assert_eq!(run.element, 10, "it is still open");
        for wrong in ["", "9-1", "64", "x"] {
            assert!(elements(wrong, &wiring).is_err(), "{wrong}");
        }
        run.mark(10..64, &wiring, true);
        assert_eq!(run.step, Step::Focus);
        assert_eq!(run.report.findings[0].what, "64 of 64 elements gave a signal");
    }
}
