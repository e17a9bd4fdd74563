//! The parts of the window, a folder or a file each.

pub mod arrows;
pub mod beam;
mod bound;
pub mod course;
mod demodulation;
pub(crate) mod feeling;
pub mod flight;
pub mod levitation;
pub mod measuring;
mod nonlinear;
pub(crate) mod radiation;
mod ranges;
mod response;
pub(crate) mod survey;
pub mod trade;
pub mod waves;
mod ways;

use egui::Context;

use crate::ui::part::{Background, Derived, Now};
use crate::ui::parts::arrows::Arrows;
use crate::ui::parts::beam::Beam;
use crate::ui::parts::bound::Bound;
use crate::ui::parts::course::TimeCourse;
use crate::ui::parts::demodulation::Demodulation;
use crate::ui::parts::feeling::Feeling;
use crate::ui::parts::flight::Release;
use crate::ui::parts::levitation::Levitation;
use crate::ui::parts::measuring::Measuring;
use crate::ui::parts::nonlinear::Harmonic;
use crate::ui::parts::radiation::Radiation;
use crate::ui::parts::ranges::FigureRanges;
use crate::ui::parts::response::Response;
use crate::ui::parts::survey::Survey;
use crate::ui::parts::trade::Trade;
use crate::ui::parts::waves::Waves;
use crate::ui::parts::ways::Ways;

pub use feeling::FeltFigures;
pub use radiation::RadiationFigures;
pub use survey::Extremes;

/// All parts.
#[derive(Debug, Default)]
pub struct Parts {
    pub arrows: Derived<Arrows>,
    pub beam: Derived<Beam>,
    pub bound: Derived<Bound>,
    pub course: Derived<TimeCourse>,
    pub demodulation: Derived<Demodulation>,
    pub feeling: Derived<Feeling>,
    pub flight: Derived<Release>,
    pub harmonic: Derived<Harmonic>,
    pub levitation: Derived<Levitation>,
    pub measuring: Measuring,
    pub radiation: Derived<Radiation>,
    pub ranges: Derived<FigureRanges>,
    pub response: Derived<Response>,
    pub survey: Derived<Survey>,
    pub trade: Derived<Trade>,
    pub waves: Derived<Waves>,
    pub ways: Derived<Ways>,
}

impl Parts {
    fn all(&self) -> [&dyn Background; 17] {
        let Self {
            arrows,
            beam,
            bound,
            course,
            demodulation,
            feeling,
            flight,
            harmonic,
            levitation,
            measuring,
            radiation,
            ranges,
            response,
            survey,
            trade,
            waves,
            ways,
        } = self;
        [
            arrows,
            beam,
            bound,
            course,
            demodulation,
            feeling,
            flight,
            harmonic,
            levitation,
            measuring,
            radiation,
            ranges,
            response,
            survey,
            trade,
            waves,
            ways,
        ]
    }

    fn all_mut(&mut self) -> [&mut dyn Background; 17] {
        let Self {
            arrows,
            beam,
            bound,
            course,
            demodulation,
            feeling,
            flight,
            harmonic,
            levitation,
            measuring,
            radiation,
            ranges,
            response,
            survey,
            trade,
            waves,
            ways,
        } = self;
        [
            arrows,
            beam,
            bound,
            course,
            demodulation,
            feeling,
            flight,
            harmonic,
            levitation,
            measuring,
            radiation,
            ranges,
            response,
            survey,
            trade,
            waves,
            ways,
        ]
    }

    /// Resets the settings that belong to a scene: what is shown for it, and its places and times.
    pub fn forget_scene(&mut self) {
        self.arrows.form = Arrows::default();
        self.flight.form = Release { slowness: self.flight.form.slowness, ..Release::default() };
        self.levitation.form = Levitation::default();
        self.trade.form = Trade::default();
        self.waves.form = Waves::default();
        self.ways.form = Ways::default();
        (self.course.form.is_shown, self.course.form.place) = Default::default();
    }

    /// Collects finished values, and returns whether there were any.
    pub fn collect(&mut self) -> bool {
        self.all_mut().map(|part| part.collect()).contains(&true)
    }

    /// Requests the displayed values.
    pub fn update(&mut self, now: &Now<'_>, ctx: &Context) {
        self.all_mut().into_iter().for_each(|part| part.update(now, ctx));
    }

    /// Whether anything is being computed.
    pub fn is_running(&self) -> bool {
        self.all().into_iter().any(|part| part.is_running())
    }
}
