//! The convention of displayed pressures, peak or RMS: each view uses and names one.

use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};

use strum::{IntoStaticStr, VariantArray};

use crate::field::Quantity;
use crate::rounding::pascals;

/// Convention for the amplitude of a sinusoidal pressure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase", const_into_str)]
pub enum Convention {
    #[default]
    #[strum(serialize = "RMS")]
    Rms,
    Peak,
}

impl Convention {
    /// The same as a title.
    pub fn title(self) -> &'static str {
        match self {
            Self::Rms => "RMS",
            Self::Peak => "Peak",
        }
    }

    /// Factor on the values of a map, where pressures and velocities are RMS.
    pub fn factor(self, quantity: Quantity) -> f64 {
        if self == Self::Peak && quantity.declaration().is_root { SQRT_2 } else { 1.0 }
    }

    /// Factor on a peak amplitude.
    pub fn of_peak(self) -> f64 {
        match self {
            Self::Rms => FRAC_1_SQRT_2,
            Self::Peak => 1.0,
        }
    }

    /// A peak amplitude (Pa) with its unit and this convention's name.
    pub fn pressure(self, peak: f64) -> String {
        format!("{} {}", pascals(peak * self.of_peak()), self.into_str())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_amplitude_is_stated_in_either_convention() {
        assert_eq!(Convention::Rms.pressure(1000.0), "707.1 Pa RMS");
        assert_eq!(Convention::Peak.pressure(1000.0), "1.000 kPa peak");
    }
}
