//! Acoustic traps: the phase signature added to a focus, and the equivalent lobes for use beside other targets.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::scene::range::{KeyError, refuse};

/// What a trap is like about its axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Trap {
    /// A plain focus, which holds what is denser or stiffer than air nowhere but in standing waves.
    Focus,
    /// Two lobes in opposite phase beside each other.
    #[default]
    Twin,
    /// A ring whose phase goes round.
    Vortex,
    /// A ring around a lobe in opposite phase.
    Bottle,
    /// Two lobes in opposite phase along the axis.
    Standing,
}

/// A place (m, about the trap's centre, its axis being z) and the phase (rad) of the sound there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lobe {
    pub at: DVec3,
    pub phase: f64,
}

impl Trap {
    pub const ALL: [Self; 5] = [Self::Focus, Self::Twin, Self::Vortex, Self::Bottle, Self::Standing];
    /// Turns of a vortex's phase, either way.
    pub const MOST_TURNS: i32 = 8;

    pub(super) fn check(charge: i32) -> Result<(), KeyError> {
        if charge == 0 || charge.abs() > Self::MOST_TURNS {
            let most = Self::MOST_TURNS;
            return refuse("charge", format!("must be a whole number from -{most} to {most}, and not 0"));
        }
        Ok(())
    }

    /// The name in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Focus => "focus",
            Self::Twin => "twin",
            Self::Vortex => "vortex",
            Self::Bottle => "bottle",
            Self::Standing => "standing",
        }
    }

    /// What it is called beside others.
    pub fn title(self) -> &'static str {
        match self {
            Self::Focus => "focus that holds",
            Self::Twin => "twin trap",
            Self::Vortex => "vortex",
            Self::Bottle => "bottle",
            Self::Standing => "standing wave",
        }
    }

    /// What is added to the focus phase (rad) of an element that stands at a place (m) about the trap, in its axes; half of the
    /// elements stand within `radius` (m) of the axis.
    pub fn signature(self, charge: i32, place: DVec3, radius: f64) -> f64 {
        let opposite = |is_opposite: bool| if is_opposite { PI } else { 0.0 };
        match self {
            Self::Focus => 0.0,
            Self::Twin => opposite(place.x < 0.0),
            Self::Vortex => f64::from(charge) * place.y.atan2(place.x),
            Self::Bottle => opposite(place.truncate().length() > radius),
            Self::Standing => opposite(place.z > 0.0),
        }
    }

    /// Lobes that make the trap.
    pub fn lobes(self, charge: i32, wavelength: f64) -> Vec<Lobe> {
        /// Wavelengths from the centre.
        const BESIDE: f64 = 0.5;
        const ALONG: f64 = 0.25;
        const RING: f64 = 0.5;
        const WIDE: f64 = 0.9;
        let pair = |way: DVec3| vec![Lobe { at: -way, phase: PI }, Lobe { at: way, phase: 0.0 }];
        let ring = |count: u32, radius: f64, turns: f64, phase: f64| {
            (0..count).map(move |i| {
                let angle = TAU * f64::from(i) / f64::from(count);
                let at = DVec3::new(angle.cos(), angle.sin(), 0.0) * radius * wavelength;
                Lobe { at, phase: phase + turns * angle }
            })
        };
        match self {
            Self::Focus => vec![Lobe { at: DVec3::ZERO, phase: 0.0 }],
            Self::Twin => pair(DVec3::X * BESIDE * wavelength),
            Self::Standing => pair(DVec3::Z * ALONG * wavelength),
            Self::Vortex => {
                let turns = charge.unsigned_abs();
                let radius = RING * f64::from(turns + 1) / 2.0;
                ring(4 * turns + 2, radius, charge.into(), 0.0).collect()
            }
            Self::Bottle => {
                let along = |z: f64| Lobe { at: DVec3::Z * z * wavelength, phase: 0.0 };
                ring(6, WIDE, 0.0, PI).chain([along(-1.0), along(1.0)]).collect()
            }
        }
    }
}
