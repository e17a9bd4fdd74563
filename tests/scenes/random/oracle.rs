//! The model as the contract states it, written down a second time and as plainly as can be.

use std::f64::consts::{PI, SQRT_2, TAU};

use glam::{DVec2, DVec3};
use num_complex::Complex64;
use sonoglyph::acoustics::air;
use sonoglyph::drive::Drive;
use sonoglyph::scene::{ElementModel, Liquid, LiquidName, Scene};

/// Np per dB: e^{-αr} = 10^{-dB/20}.
const NEPER_PER_DB: f64 = std::f64::consts::LN_10 / 20.0;
/// m; nearer to the array's plane, the program takes a point for one at this height.
pub const NEAREST: f64 = 1e-5;

/// What an array and its medium are, in numbers of the oracle's own.
#[derive(Clone, Debug)]
pub struct Oracle {
    /// m, of every element of the array.
    pub elements: Vec<DVec3>,
    pub is_off: Vec<bool>,
    /// rad/m
    pub wavenumber: f64,
    /// Np/m
    pub attenuation: f64,
    /// m/s
    pub sound_speed: f64,
    /// kg/m³
    pub density: f64,
    pub model: ElementModel,
    /// m
    pub radius: f64,
    strength: f64,
    frequency: f64,
}

impl Oracle {
    pub fn new(scene: &Scene) -> Self {
        let (array, medium) = (&scene.array, &scene.medium);
        let kelvin = 273.15 + medium.temperature;
        let sound_speed = medium.sound_speed.unwrap_or(331.3 * (kelvin / 273.15).sqrt());
        let decibels = medium.absorption.unwrap_or_else(|| {
            air::absorption(array.frequency, medium.temperature, medium.humidity, medium.pressure)
        });
        let mut elements = Vec::new();
        for row in 0..array.rows {
            for column in 0..array.columns {
                let x = f64::from(column) - (f64::from(array.columns) - 1.0) / 2.0;
                let y = f64::from(row) - (f64::from(array.rows) - 1.0) / 2.0;
                elements.push(DVec3::new(x * array.pitch, y * array.pitch, 0.0));
            }
        }
        Self {
            is_off: (0..elements.len()).map(|n| array.off.contains(&n)).collect(),
            elements,
            wavenumber: TAU * array.frequency / sound_speed,
            attenuation: decibels * NEPER_PER_DB,
            sound_speed,
            density: medium.density.unwrap_or(medium.pressure / (287.05 * kelvin)),
            model: array.element,
            radius: array.element_radius,
            strength: array.strength,
            frequency: array.frequency,
        }
    }

    /// m
    pub fn wavelength(&self) -> f64 {
        TAU / self.wavenumber
    }

    /// Pa (peak) at a point per unit of drive of one element; `None` where the oracle's own integral of the exact piston is
    /// not good enough: on a piston, or of one many wavelengths wide.
    pub fn transfer(&self, element: usize, point: DVec3) -> Option<Complex64> {
        let offset = point - self.elements[element];
        if offset.z < -NEAREST {
            return Some(Complex64::ZERO);
        }
        let lowest = if self.model == ElementModel::ExactPiston { 0.0 } else { NEAREST };
        let offset = offset.with_z(offset.z.max(lowest));
        let r = offset.length();
        let wave = Complex64::from_polar(1.0 / r, PI / 2.0 - self.wavenumber * r);
        let wave = match self.model {
            ElementModel::Point => wave,
            ElementModel::Piston => {
                let x = self.wavenumber * self.radius * offset.truncate().length() / r;
                wave * if x < 1e-8 { 1.0 } else { 2.0 * libm::j1(x) / x }
            }
            ElementModel::ExactPiston => self.disk(offset)?,
        };
        Some(wave * self.strength * (-self.attenuation * r).exp())
    }

    /// Rayleigh's integral, the mean of what the points of the disk send: by Gauss's rule in ρ² and midpoints round the half circle,
    /// both of which converge faster than any power.
    fn disk(&self, offset: DVec3) -> Option<Complex64> {
        /// Places in [-1, 1] and weights of eight points.
        const GAUSS: [(f64, f64); 4] = [
            (0.183_434_642_495_649_8, 0.362_683_783_378_362),
            (0.525_532_409_916_329, 0.313_706_645_877_887_3),
            (0.796_666_477_413_626_7, 0.222_381_034_453_374_5),
            (0.960_289_856_497_536_3, 0.101_228_536_290_376_3),
        ];
        const SPOKES: u32 = 16;
        if offset.length() < 3.0 * self.radius || self.wavenumber * self.radius > 6.0 {
            return None;
        }
        let aside = DVec2::new(offset.truncate().length(), 0.0);
        let mut sum = Complex64::ZERO;
        for (place, weight) in
            GAUSS.into_iter().flat_map(|(place, weight)| [(place, weight), (-place, weight)])
        {
            let rho = self.radius * ((1.0 + place) / 2.0).sqrt();
            for spoke in 0..SPOKES {
                let at = DVec2::from_angle(PI * (f64::from(spoke) + 0.5) / f64::from(SPOKES)) * rho;
                let r = (aside - at).length().hypot(offset.z);
                sum += weight * Complex64::from_polar(1.0 / r, PI / 2.0 - self.wavenumber * r);
            }
        }
        Some(sum / f64::from(2 * SPOKES))
    }

    /// Pa (peak) that a drive makes at a point, and the sum of what its elements send there, phases left aside.
    pub fn pressure(&self, drive: &Drive, point: DVec3) -> Option<(Complex64, f64)> {
        let (mut sum, mut moduli) = (Complex64::ZERO, 0.0);
        for n in (0..self.elements.len()).filter(|&n| !self.is_off[n] && drive.amplitudes[n] > 0.0) {
            let wave = self.transfer(n, point)? * Complex64::from_polar(drive.amplitudes[n], drive.phases[n]);
            sum += wave;
            moduli += wave.norm();
        }
        Some((sum, moduli))
    }

    /// Pa/m (peak) along a direction, by differences that are off by (k h)²/6 = 7e-6 of the steepest wave's.
    fn slope(&self, drive: &Drive, point: DVec3, direction: DVec3) -> Option<Complex64> {
        let step = 1e-3 * self.wavelength();
        let ahead = self.pressure(drive, point + step * direction)?.0;
        let behind = self.pressure(drive, point - step * direction)?.0;
        Some((ahead - behind) / (2.0 * step))
    }

    /// Pa on a reflecting surface with these axes: |P|²/(ρc²) - |∇P|²/(ρω²), ∇ along the surface, and the first part alone.
    pub fn radiation(&self, drive: &Drive, point: DVec3, axes: [DVec3; 2]) -> Option<(f64, f64)> {
        let angular = TAU * self.frequency;
        let (pressure, _) = self.pressure(drive, point)?;
        let mut along = 0.0;
        for axis in axes {
            along += self.slope(drive, point, axis)?.norm_sqr();
        }
        let of_pressure = pressure.norm_sqr() / (self.density * self.sound_speed * self.sound_speed);
        Some((of_pressure - along / (self.density * angular * angular), of_pressure))
    }

    /// m/s (peak) along a direction: jωρV = -∂P/∂n.
    fn velocity(&self, drive: &Drive, point: DVec3, direction: DVec3) -> Option<Complex64> {
        let slope = self.slope(drive, point, direction)?;
        Some(-slope / (Complex64::I * TAU * self.frequency * self.density))
    }

    /// RMS velocity (m/s) of the air along a direction.
    pub fn rms_velocity(&self, drive: &Drive, point: DVec3, direction: DVec3) -> Option<f64> {
        Some(self.velocity(drive, point, direction)?.norm() / SQRT_2)
    }

    /// W/m²: the magnitude of ½ Re{P V*}.
    pub fn intensity(&self, drive: &Drive, point: DVec3) -> Option<f64> {
        let (pressure, _) = self.pressure(drive, point)?;
        let mut flow = DVec3::ZERO;
        for (axis, along) in [DVec3::X, DVec3::Y, DVec3::Z].into_iter().enumerate() {
            flow[axis] = 0.5 * (pressure * self.velocity(drive, point, along)?.conj()).re;
        }
        Some(flow.length())
    }
}

/// Density (kg/m³) and surface tension (N/m) of a liquid, by the table of the scene file's reference.
pub fn density_and_tension(liquid: &Liquid) -> (f64, f64) {
    let (density, tension) = match liquid.name {
        LiquidName::Water => (998.2, 0.0728),
        LiquidName::Glycerol => (1261.0, 0.0634),
        LiquidName::SiliconeOil => (960.0, 0.0208),
        LiquidName::VegetableOil => (919.0, 0.0330),
        LiquidName::Ethanol => (789.3, 0.0223),
    };
    (liquid.density.unwrap_or(density), liquid.surface_tension.unwrap_or(tension))
}
