//! The model as the contract states it, written down a second time and as plainly as can be.

use std::f64::consts::{PI, SQRT_2, TAU};

use glam::{DQuat, DVec2, DVec3};
use num_complex::Complex64;
use sonoglyph::acoustics::absorption;
use sonoglyph::drive::Drive;
use sonoglyph::scene::{Array, ElementModel, Liquid, LiquidName, Placed, Reflector, Scene};

/// Np per dB: e^{-αr} = 10^{-dB/20}.
const NEPER_PER_DB: f64 = std::f64::consts::LN_10 / 20.0;
/// m; nearer to the array's plane, the program takes a point for one at this height.
pub const NEAREST: f64 = 1e-5;

/// An element of a board, or its image in a reflector.
#[derive(Clone, Copy, Debug)]
struct Source {
    /// Its number in the array.
    element: usize,
    /// m
    at: DVec3,
    /// Unit vector: the direction of radiation.
    normal: DVec3,
    /// Unit vector: its x axis.
    aside: DVec3,
    /// Factor on the drive.
    gain: f64,
}

impl Source {
    fn mirrored(self, mirror: &Reflector) -> Self {
        let up = mirror.normal.normalize_or(DVec3::Z);
        let turned = |direction: DVec3| direction - 2.0 * up.dot(direction) * up;
        let at = mirror.point + turned(self.at - mirror.point);
        let (normal, aside) = (turned(self.normal), turned(self.aside));
        Self { at, normal, aside, gain: self.gain * mirror.coefficient, ..self }
    }
}

/// An array and its medium, independent of the program's model.
#[derive(Clone, Debug)]
pub struct Oracle {
    sources: Vec<Source>,
    /// m and a unit vector: centres and directions of boards and their images.
    faces: Vec<(DVec3, DVec3)>,
    /// m, largest distance of an element from its board's centre.
    extent: f64,
    /// m, largest distance of a source from the origin.
    pub reach: f64,
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
    /// m
    size: DVec2,
    exponent: f64,
    strength: f64,
    frequency: f64,
}

impl Oracle {
    pub fn new(scene: &Scene) -> Self {
        let (array, medium) = (&scene.array, &scene.medium);
        let kelvin = 273.15 + medium.temperature;
        let sound_speed = medium.sound_speed.unwrap_or(331.3 * (kelvin / 273.15).sqrt());
        let decibels = medium.absorption.unwrap_or_else(|| {
            absorption(array.frequency, medium.temperature, medium.humidity, medium.pressure)
        });
        let places = array.placed.get().map_or_else(|| grid(array), <[_]>::to_vec);
        let (mut sources, mut faces) = (Vec::new(), Vec::new());
        for (number, board) in scene.standing().iter().enumerate() {
            let z = board.normal.normalize_or(DVec3::Z);
            let x = (board.x_axis - board.x_axis.dot(z) * z).normalize_or(DVec3::X);
            let world = |local: DVec3| local.x * x + local.y * z.cross(x) + local.z * z;
            let source = |(index, it): (usize, &Placed)| Source {
                element: number * places.len() + index,
                at: board.at + world(it.at),
                normal: world(it.normal),
                aside: world(DQuat::from_rotation_arc(DVec3::Z, it.normal) * DVec3::X),
                gain: 1.0,
            };
            let own: Vec<_> = places.iter().enumerate().map(source).collect();
            faces.push((board.at, z));
            sources.extend(&own);
            for mirror in &scene.reflectors {
                let images = images(&own, board.at, z, mirror, array.reflectivity);
                faces.extend(images.iter().map(|image| (image.at, image.normal)));
                sources.extend(images);
            }
        }
        // The share of a source at any distance in the rounding of the sum depends on its gain alone.
        let loud = sources.iter().filter(|source| source.gain.abs() > 1e-2);
        let reach = loud.map(|source| source.at.length()).fold(0.0, f64::max);
        Self {
            extent: places.iter().map(|it| it.at.length()).fold(0.0, f64::max),
            sources: sources.into_iter().filter(|source| !array.off.contains(&source.element)).collect(),
            faces,
            reach,
            wavenumber: TAU * array.frequency / sound_speed,
            attenuation: decibels * NEPER_PER_DB,
            sound_speed,
            density: medium.density.unwrap_or(medium.pressure / (287.05 * kelvin)),
            model: array.element,
            radius: match array.element {
                ElementModel::Rectangle => array.element_size.length() / 2.0,
                _ => array.element_radius,
            },
            size: array.element_size,
            exponent: array.element_exponent,
            strength: array.strength,
            frequency: array.frequency,
        }
    }

    /// m
    pub fn wavelength(&self) -> f64 {
        TAU / self.wavenumber
    }

    /// m, from a point to the nearest plane of an element, in front of it or behind.
    pub fn height(&self, point: DVec3) -> f64 {
        let heights = self.sources.iter().map(|source| source.normal.dot(point - source.at).abs());
        heights.fold(f64::INFINITY, f64::min)
    }

    /// m, largest distance of a point from a board's axis, and of the elements from it.
    pub fn across(&self, point: DVec3) -> f64 {
        let aside =
            self.faces.iter().map(|(at, normal)| (point - at).reject_from_normalized(*normal).length());
        self.extent + aside.fold(0.0, f64::max)
    }

    /// Pa (peak) at a point per unit of drive of one source; `None` where the oracle's own integral of the exact piston is
    /// not good enough: on a piston, or of one many wavelengths wide.
    fn transfer(&self, source: &Source, point: DVec3) -> Option<Complex64> {
        let away = point - source.at;
        let offset = away;
        let z = source.normal.dot(offset);
        let offset = (offset - z * source.normal).length();
        let offset = DVec3::new(offset, 0.0, z);
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
            ElementModel::Rectangle => {
                let sinc = |x: f64| if x.abs() < 1e-6 { 1.0 } else { x.sin() / x };
                let [x, y] = [source.aside, source.normal.cross(source.aside)].map(|axis| axis.dot(away) / r);
                let half = self.wavenumber / 2.0 * self.size;
                wave * sinc(half.x * x) * sinc(half.y * y)
            }
            ElementModel::Cosine => wave * (offset.z / r).powf(self.exponent),
            // The fit of a table is tested by itself.
            ElementModel::Measured => wave,
        };
        Some(wave * source.gain * self.strength * (-self.attenuation * r).exp())
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
        for source in self.sources.iter().filter(|source| drive.amplitudes[source.element] > 0.0) {
            let n = source.element;
            let wave =
                self.transfer(source, point)? * Complex64::from_polar(drive.amplitudes[n], drive.phases[n]);
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

/// The elements of rows and columns in z = 0, row by row.
fn grid(array: &Array) -> Vec<Placed> {
    let mut elements = Vec::new();
    for row in 0..array.rows {
        for column in 0..array.columns {
            let x = f64::from(column) - (f64::from(array.columns) - 1.0) / 2.0;
            let y = f64::from(row) - (f64::from(array.rows) - 1.0) / 2.0;
            elements.push(Placed { at: DVec3::new(x, y, 0.0) * array.pitch, normal: DVec3::Z });
        }
    }
    elements
}

/// The images of a board's elements in a reflector: one, or the series between the reflector and a parallel board that
/// faces it.
fn images(own: &[Source], at: DVec3, normal: DVec3, mirror: &Reflector, reflectivity: f64) -> Vec<Source> {
    let up = mirror.normal.normalize_or(DVec3::Z);
    let is_parallel = up.dot(normal) < 0.0 && up.cross(normal).length() < 1e-9;
    let both = if is_parallel { reflectivity * mirror.coefficient } else { 0.0 };
    let height = up.dot(at - mirror.point);
    let mut images = Vec::new();
    for times in 0..2000 {
        let (gain, by) = (both.powi(times), 2.0 * f64::from(times) * height * up);
        if gain.abs() < 1e-15 {
            break;
        }
        for source in own {
            let moved = Source { at: source.at + by, gain, ..*source };
            images.extend((times > 0).then_some(moved));
            images.push(moved.mirrored(mirror));
        }
    }
    images
}

/// Density (kg/m³) and surface tension (N/m) of a liquid, by the table of the scene file's reference.
pub fn density_and_tension(liquid: &Liquid) -> (f64, f64) {
    let (density, tension) = match liquid.named() {
        LiquidName::Water => (998.2, 0.0728),
        LiquidName::Glycerol => (1261.0, 0.0634),
        LiquidName::SiliconeOil => (960.0, 0.0208),
        LiquidName::VegetableOil => (919.0, 0.0330),
        LiquidName::Ethanol => (789.3, 0.0223),
    };
    (liquid.density.unwrap_or(density), liquid.surface_tension.unwrap_or(tension))
}
