//! Bring-up of a board in the window: the current step and the findings so far.

use crate::device::calibration::Calibration;
use crate::device::wiring::Wiring;
use crate::studio::bring_up::{Finding, Report, Verdict};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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
            Self::Line => "1 of 5: the line",
            Self::Elements => "2 of 5: the elements",
            Self::Focus => "3 of 5: a focus",
            Self::EmergencyStop => "4 of 5: the emergency stop",
            Self::Done => "5 of 5: the report",
        }
    }
}

#[derive(Clone, Debug, PartialEq)]
pub struct BringUp {
    pub step: Step,
    pub report: Report,
    /// Silent elements are switched off in it.
    pub calibration: Calibration,
    /// The element that sounds.
    pub element: usize,
    /// The emergency stop was noticed.
    pub pressed: bool,
    /// Where the calibration goes.
    pub file: String,
}

impl Default for BringUp {
    fn default() -> Self {
        Self {
            step: Step::Line,
            report: Report::default(),
            calibration: Calibration::default(),
            element: 0,
            pressed: false,
            file: "calibration.csv".to_owned(),
        }
    }
}

/// The result of a line's survey.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Surveyed {
    pub findings: Vec<Finding>,
    /// The fastest error-free bit rate, if known.
    pub baud: Option<u32>,
}

impl BringUp {
    /// Records whether an element was audible, and goes to the next one. `None`: ends the test.
    pub fn heard(&mut self, wiring: &Wiring, heard: Option<bool>) {
        let wired: Vec<_> = wiring.wired().collect();
        if let Some(heard) = heard {
            self.calibration.set_off(self.element, wiring.elements(), !heard);
            self.element = wired.iter().copied().find(|&n| n > self.element).unwrap_or(wiring.elements());
        }
        if heard.is_some() && self.element < wiring.elements() {
            return;
        }
        let silent: Vec<_> = self.calibration.off().iter().map(ToString::to_string).collect();
        let tried = wired.iter().filter(|&&n| n < self.element).count();
        let (elements, count) = (wired.len(), silent.len());
        match count {
            0 => self.report.note(Verdict::Passed, format!("{tried} of {elements} elements were heard")),
            _ => {
                self.report
                    .note(Verdict::Failed, format!("{count} elements are silent: {}", silent.join(", ")));
            }
        }
        self.step = Step::Focus;
    }
}
