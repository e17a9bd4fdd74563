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
pub mod scattering;
pub mod solids;
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
use crate::ui::parts::scattering::Scattering;
use crate::ui::parts::solids::Solids;
use crate::ui::parts::survey::Survey;
use crate::ui::parts::trade::Trade;
use crate::ui::parts::waves::Waves;
use crate::ui::parts::ways::Ways;

pub use feeling::FeltFigures;
pub use radiation::RadiationFigures;
pub use survey::Extremes;

/// The struct of all parts, and lists of them.
macro_rules! parts {
    ($($name:ident: $part:ty,)*) => {
        /// All parts.
        #[derive(Debug, Default)]
        pub struct Parts {
            $(pub $name: $part,)*
        }

        impl Parts {
            fn all(&self) -> [&dyn Background; [$(stringify!($name)),*].len()] {
                [$(&self.$name),*]
            }

            fn all_mut(&mut self) -> [&mut dyn Background; [$(stringify!($name)),*].len()] {
                [$(&mut self.$name),*]
            }
        }
    };
}

parts! {
    arrows: Derived<Arrows>,
    beam: Derived<Beam>,
    bound: Derived<Bound>,
    course: Derived<TimeCourse>,
    demodulation: Derived<Demodulation>,
    feeling: Derived<Feeling>,
    flight: Derived<Release>,
    harmonic: Derived<Harmonic>,
    levitation: Derived<Levitation>,
    measuring: Measuring,
    radiation: Derived<Radiation>,
    ranges: Derived<FigureRanges>,
    response: Derived<Response>,
    scattering: Derived<Scattering>,
    solids: Derived<Solids>,
    survey: Derived<Survey>,
    trade: Derived<Trade>,
    waves: Derived<Waves>,
    ways: Derived<Ways>,
}

impl Parts {
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
