//! Acoustic traps: the phase signature added to a focus, and the equivalent lobes for use beside other targets.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use strum::{EnumString, IntoStaticStr, VariantArray, VariantNames};

use crate::scene::range::{KeyError, refuse};

/// The kind of a trap, relative to its axis.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, EnumString, IntoStaticStr, VariantArray, VariantNames,
)]
#[strum(serialize_all = "lowercase", const_into_str)]
pub enum Trap {
    /// A plain focus, which holds beads denser or stiffer than air only in standing waves.
    Focus,
    /// Two lobes in opposite phase beside each other.
    #[default]
    Twin,
    /// A ring with an azimuthal phase.
    Vortex,
    /// A ring around a lobe in opposite phase.
    Bottle,
    /// Two lobes in opposite phase along the axis.
    Standing,
}

/// A point (m, relative to the trap's centre, with its axis along z) and the phase (rad) of the sound there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lobe {
    pub at: DVec3,
    pub phase: f64,
}

impl Trap {
    /// Limit of the topological charge, of either sign.
    pub const MOST_TURNS: i32 = 8;

    pub(super) fn check(charge: i32) -> Result<(), KeyError> {
        if charge == 0 || charge.abs() > Self::MOST_TURNS {
            let most = Self::MOST_TURNS;
            return refuse("charge", format!("must be a whole number from -{most} to {most}, and not 0"));
        }
        Ok(())
    }

    /// Short display name.
    pub fn title(self) -> &'static str {
        match self {
            Self::Focus => "focus that holds",
            Self::Twin => "twin trap",
            Self::Vortex => "vortex",
            Self::Bottle => "bottle",
            Self::Standing => "standing wave",
        }
    }

    /// Name of a target.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Focus => "Focus trap",
            Self::Twin => "Twin trap",
            Self::Vortex => "Vortex trap",
            Self::Bottle => "Bottle trap",
            Self::Standing => "Standing-wave trap",
        }
    }

    /// The phase (rad) added to the focusing phase of an element at a position (m) relative to the trap, in its axes;
    /// half of the elements are within `radius` (m) of the axis, and `shift` (rad) is that of [`Self::shifted`].
    pub fn signature(self, charge: i32, shift: f64, place: DVec3, radius: f64) -> f64 {
        let opposite = |is_opposite: bool| if is_opposite { PI } else { 0.0 };
        self.shifted(
            shift,
            match self {
                Self::Focus => 0.0,
                Self::Twin => opposite(place.x < 0.0),
                Self::Vortex => f64::from(charge) * place.y.atan2(place.x),
                Self::Bottle => opposite(place.truncate().length() > radius),
                Self::Standing => opposite(place.z > 0.0),
            },
        )
    }

    /// The same of a trap that turns: elements of a twin trap pass from one half to the other gradually, at both ends of
    /// their border in opposite senses, so that its node stays in the middle.
    #[doc(hidden)]
    pub fn gradual_signature(self, charge: i32, shift: f64, place: DVec3, radius: f64) -> f64 {
        /// Half the angle of the passage, rad.
        const HALF: f64 = 0.15;
        match self {
            Self::Twin => {
                let angle = place.y.atan2(place.x);
                let passed = ((angle.abs() - PI / 2.0 + HALF) / (2.0 * HALF)).clamp(0.0, 1.0);
                passed * (PI.copysign(angle) + shift)
            }
            Self::Focus | Self::Vortex | Self::Bottle | Self::Standing => {
                self.signature(charge, shift, place, radius)
            }
        }
    }

    /// A phase (rad) of the signature or of a lobe, shifted: in the opposite part of the trap, or everywhere in a vortex,
    /// whose pattern then turns.
    pub(crate) fn shifted(self, shift: f64, phase: f64) -> f64 {
        match self {
            Self::Vortex => phase + shift,
            Self::Focus | Self::Twin | Self::Bottle | Self::Standing => {
                if phase == PI {
                    phase + shift
                } else {
                    phase
                }
            }
        }
    }

    /// The lobes of the trap.
    pub(crate) fn lobes(self, charge: i32, wavelength: f64) -> Vec<Lobe> {
        /// Distance from the centre in wavelengths.
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
