//! The sound at a point: pressure, its slopes, and the properties of the air used by formulae.

use num_complex::{Complex, Complex32, Complex64};
use strum::VariantArray;

use crate::acoustics::Air;

/// The sound of one drive at a point: complex peak amplitudes, in f32 on maps and in f64 for their comparison.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sound<T = f32> {
    /// Pa
    pub p: Complex<T>,
    /// Slopes of the pressure along the plane's first axis, its second, and its normal; Pa/m.
    pub x: Complex<T>,
    pub y: Complex<T>,
    pub n: Complex<T>,
}

impl<T> Sound<T> {
    pub fn part_mut(&mut self, part: Part) -> &mut Complex<T> {
        match part {
            Part::Pressure => &mut self.p,
            Part::AlongX => &mut self.x,
            Part::AlongY => &mut self.y,
            Part::Normal => &mut self.n,
        }
    }
}

impl Sound<f64> {
    /// Deviation from another sound.
    pub fn less(&self, other: &Sound) -> Self {
        let less = |own: Complex64, other: Complex32| own - Complex64::new(other.re.into(), other.im.into());
        Self {
            p: less(self.p, other.p),
            x: less(self.x, other.x),
            y: less(self.y, other.y),
            n: less(self.n, other.n),
        }
    }
}

/// One of the numbers of a [`Sound`], in the order of the evaluators.
#[derive(Clone, Copy, Debug, PartialEq, Eq, VariantArray)]
pub enum Part {
    Pressure,
    AlongX,
    AlongY,
    Normal,
}

impl Part {
    const fn bit(self) -> u8 {
        1 << self as u8
    }

    /// The parts of a bit set.
    pub fn of(bits: u8) -> impl Iterator<Item = Self> {
        Self::VARIANTS.iter().copied().filter(move |part| bits & part.bit() != 0)
    }
}

/// Bits of parts.
pub const PRESSURE: u8 = Part::Pressure.bit();
pub const ALONG: u8 = Part::AlongX.bit() | Part::AlongY.bit();
pub const NORMAL: u8 = Part::Normal.bit();

/// Constants of the air and the moment in formulae.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Constants<T = f32> {
    /// 1/(ρc²), 1/Pa
    pub of_pressure: T,
    /// 1/(ρω²), m²/Pa
    pub of_gradient: T,
    /// 1/(ρω), m²/(Pa·s): |v| of |∇p|.
    pub of_velocity: T,
    /// e^{jωt} of an instantaneous pressure.
    pub turn: Complex<T>,
}

impl Constants<f64> {
    /// The constants of this air, for a wavenumber (1/m), at the moment ωt (rad).
    pub fn new(air: &Air, wavenumber: f64, moment: f64) -> Self {
        let angular = wavenumber * air.sound_speed;
        Self {
            of_pressure: 1.0 / (air.density * air.sound_speed.powi(2)),
            of_gradient: 1.0 / (air.density * angular * angular),
            of_velocity: 1.0 / (air.density * angular),
            turn: Complex64::cis(moment),
        }
    }

    /// The constants in f32, for maps.
    pub fn narrow(self) -> Constants {
        Constants {
            of_pressure: self.of_pressure as f32,
            of_gradient: self.of_gradient as f32,
            of_velocity: self.of_velocity as f32,
            turn: narrow(self.turn),
        }
    }
}

/// The parts of the sound at a run of points; unused parts are empty.
#[derive(Clone, Copy, Debug)]
pub struct Sounds<'a>(pub [&'a [Complex32]; 4]);

impl<'a> Sounds<'a> {
    /// The sound of the parts in `of` alone, in their order.
    pub fn of(of: u8, parts: impl IntoIterator<Item = &'a [Complex32]>) -> Self {
        let mut parts = parts.into_iter();
        Self(std::array::from_fn(|i| if of & 1 << i == 0 { &[][..] } else { parts.next().unwrap_or(&[]) }))
    }
}

/// The number in f32.
pub fn narrow(p: Complex64) -> Complex32 {
    Complex32::new(p.re as f32, p.im as f32)
}
