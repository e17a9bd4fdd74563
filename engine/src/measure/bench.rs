//! The bench: what a scan's readings depend on besides the gains of the elements.

use glam::{DMat3, DVec3};
use strum::{EnumIter, IntoStaticStr};

use crate::acoustics::{Air, Aperture};
use crate::scene::Scene;

/// A parameter of the bench.
#[derive(Clone, Copy, Debug, PartialEq, Eq, EnumIter, IntoStaticStr)]
#[strum(serialize_all = "snake_case", const_into_str)]
pub enum Parameter {
    /// m: shift of the scan from where its file says.
    X,
    Y,
    Z,
    /// rad: rotation of the scan about the x axis through its middle, and about the y axis.
    TiltX,
    TiltY,
    /// m/s
    SoundSpeed,
    /// m, of an element.
    Radius,
    /// m²: the square of the diameter of the microphone's disk, with which readings change evenly.
    #[strum(serialize = "microphone_width")]
    WidthSquared,
}

impl Parameter {
    pub const COUNT: usize = 8;
    pub const ALL: [Self; Self::COUNT] = [
        Self::X,
        Self::Y,
        Self::Z,
        Self::TiltX,
        Self::TiltY,
        Self::SoundSpeed,
        Self::Radius,
        Self::WidthSquared,
    ];
    /// Those that are freed together.
    pub const GROUPS: [&[Self]; 6] = [
        &[Self::X, Self::Y],
        &[Self::Z],
        &[Self::TiltX, Self::TiltY],
        &[Self::SoundSpeed],
        &[Self::Radius],
        &[Self::WidthSquared],
    ];

    pub fn name(self) -> &'static str {
        self.into_str()
    }

    /// The standard deviation that it has about its nominal value before anything is measured, in its unit.
    pub fn scatter(self, nominal: &Bench) -> f64 {
        match self {
            Self::X | Self::Y | Self::Z => 5e-3,
            Self::TiltX | Self::TiltY => 0.05,
            // 5 K of air.
            Self::SoundSpeed => 0.009 * nominal.at(self),
            Self::Radius => 0.2 * nominal.at(self).max(1e-4),
            // A membrane of 5 mm.
            Self::WidthSquared => 2.5e-5,
        }
    }

    /// A step of finite differences, in its unit.
    pub(super) fn step(self) -> f64 {
        match self {
            Self::X | Self::Y | Self::Z => 1e-6,
            Self::TiltX | Self::TiltY => 1e-5,
            Self::SoundSpeed => 1e-2,
            Self::Radius => 1e-6,
            Self::WidthSquared => 1e-7,
        }
    }
}

/// The values of all parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bench([f64; Parameter::COUNT]);

impl Bench {
    /// The bench as scene and scan say, with a point as microphone.
    pub fn nominal(scene: &Scene) -> Self {
        let mut bench = Self([0.0; Parameter::COUNT]);
        bench.set(Parameter::SoundSpeed, Air::new(&scene.medium, scene.array.frequency).sound_speed);
        bench.set(Parameter::Radius, scene.array.element_radius);
        bench
    }

    pub fn at(&self, parameter: Parameter) -> f64 {
        self.0[parameter as usize]
    }

    /// Sets a parameter, within what there can be.
    pub fn set(&mut self, parameter: Parameter, value: f64) {
        self.0[parameter as usize] = match parameter {
            Parameter::X | Parameter::Y | Parameter::Z => value.clamp(-0.1, 0.1),
            Parameter::TiltX | Parameter::TiltY => value.clamp(-0.5, 0.5),
            Parameter::SoundSpeed => value.max(1.0),
            Parameter::Radius => value.max(0.0),
            Parameter::WidthSquared => value.clamp(0.0, 4e-4),
        };
    }

    pub fn shift(&self) -> DVec3 {
        DVec3::new(self.at(Parameter::X), self.at(Parameter::Y), self.at(Parameter::Z))
    }

    /// m: diameter of the microphone's disk.
    pub fn width(&self) -> f64 {
        self.at(Parameter::WidthSquared).sqrt()
    }

    /// An array that is that of the `nominal` bench, in this one's air and with its elements.
    pub(super) fn aperture(&self, aperture: &Aperture, nominal: &Self) -> Aperture {
        let mut own = aperture.clone();
        own.element.wavenumber *= nominal.at(Parameter::SoundSpeed) / self.at(Parameter::SoundSpeed);
        own.element.radius = self.at(Parameter::Radius);
        own
    }

    /// The rotation of the scan.
    pub(super) fn turn(&self) -> DMat3 {
        DMat3::from_rotation_y(self.at(Parameter::TiltY)) * DMat3::from_rotation_x(self.at(Parameter::TiltX))
    }

    /// The places of a scan in the array's coordinates; tilts are about `middle`.
    pub fn places(&self, points: &[DVec3], middle: DVec3) -> Vec<DVec3> {
        let turn = self.turn();
        points.iter().map(|&point| middle + self.shift() + turn * (point - middle)).collect()
    }
}
