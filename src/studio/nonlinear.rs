//! Where linear theory ends: the second harmonic at the loudest focus, the flow that a beam drives, and the audible sound that
//! a modulated beam makes.
//!
//! *Harmonic.* P₂/P at the loudest focus ([`harmonic`]), of the drive that is loudest there. It grows with the drive,
//! which gives the drive below which it is a tenth.
//!
//! *Streaming.* Absorbed sound pushes the air by F = (α|P|² + α₂|P₂|²)/(ρc²) per volume (2αI/c of both waves). Without
//! friction and entrainment, air that follows the axis gains ρv²/2 = ∫ F ds: a bound of the steady flow, since both only
//! slow it down (J. Lighthill, J. Sound Vib. 61:391, 1978, has the jet that results). The axis leads from the array through the focus,
//! and as far beyond.
//!
//! *Audible sound.* The square of the envelope, m², makes a source of sound at its own frequencies: Westervelt's
//! parametric array (J. Acoust. Soc. Am. 35:535, 1963). Of a line of m² at ω with the amplitude M, and a beam of the
//! power W, ∫|P|²dA = 2ρcW e^{-2αs} across it at the distance s,
//!
//! ```text
//! p(x) = β ω² M W/c³ ∫ e^{-2αs} e^{-jω(s + R)/c}/(4πR) ds,    R = |x - x(s)|
//! ```
//!
//! along the axis, as long as the beam is narrower than R and than a wavelength of the audible sound. W is the power of
//! the elements by themselves. Walls that end the beam, or reflect it, and the parts that a modulated force shakes are left
//! out: levels are estimates to some 6 dB.

use std::f64::consts::{PI, SQRT_2, TAU};

use glam::DVec3;
use num_complex::Complex64;

use crate::acoustics::{Air, Aperture};
use crate::drive::Drive;
use crate::field::harmonic::{self, NONLINEARITY, NoHarmonic};
use crate::scene::{Scene, SpectralLine};
use crate::solver::Solution;
use crate::studio::demodulation::{self, AUDIBLE, a_weight, power};

/// The ratio of the harmonic up to which sound counts as linear.
const LINEAR: f64 = 0.1;
/// Samples per wavelength along the axis.
const PER_WAVELENGTH: f64 = 8.0;

/// The figures of a drive beyond linear theory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nonlinear {
    /// m, the loudest focus.
    pub position: DVec3,
    /// Amplitude of the second harmonic there, over that of the sound; of drives in turn, of the loudest.
    pub harmonic: f64,
    /// The part of full drive up to which it is a tenth; 1 if it always is.
    pub linear_drive: f64,
    /// Bound of the streaming on the beam's axis, m/s.
    pub streaming: f64,
    /// Audible sound at the listener.
    pub audible: Option<Audible>,
}

/// The sound that an envelope makes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Audible {
    /// RMS, Pa.
    pub rms: f64,
    /// The same weighted by A.
    pub weighted: f64,
    /// Hz, of the line that is loudest to the ear.
    pub frequency: f64,
}

impl Audible {
    /// dB re 20 µPa
    pub fn level(&self) -> f64 {
        20.0 * (self.rms / AUDIBLE).log10()
    }

    /// dB(A)
    pub fn weighted_level(&self) -> f64 {
        20.0 * (self.weighted / AUDIBLE).log10()
    }
}

/// The loudest focus, m; `None` of silent foci and of directions.
pub fn loudest(solution: &Solution) -> Option<DVec3> {
    let foci = solution.foci.iter().zip(&solution.pressures);
    let loudest =
        foci.filter(|(focus, _)| !focus.is_direction()).max_by(|a, b| a.1.norm().total_cmp(&b.1.norm()));
    loudest.filter(|(_, p)| p.norm() > 0.0).map(|(focus, _)| focus.position)
}

impl Nonlinear {
    /// The figures of the solution of a scene.
    ///
    /// # Errors
    /// Silent foci, or reflectors that are not rigid.
    pub fn of_solution(scene: &Scene, aperture: &Aperture, solution: &Solution) -> Result<Self, NoHarmonic> {
        let position = loudest(solution).ok_or(NoHarmonic::Silent)?;
        Self::new(scene, aperture, &solution.drives(), position)
    }

    /// The figures of drives in turn with their loudest focus (m).
    ///
    /// # Errors
    /// A silent focus, or reflectors that are not rigid.
    pub fn new(
        scene: &Scene,
        aperture: &Aperture,
        drives: &[Drive],
        position: DVec3,
    ) -> Result<Self, NoHarmonic> {
        let air = Air::new(&scene.medium, scene.array.frequency);
        let of_drive = |drive: &Drive| {
            let u = drive.excitation(&aperture.driven);
            let p = aperture.pressures(&[position], &u)[0].norm();
            (drive.clone(), u, p)
        };
        let all = drives.iter().map(of_drive);
        let (drive, u, p) = all.max_by(|a, b| a.2.total_cmp(&b.2)).ok_or(NoHarmonic::Silent)?;
        if p == 0.0 {
            return Err(NoHarmonic::Silent);
        }
        let harmonic = harmonic::at(aperture, &air, &u, position)?.norm() / p;
        let largest = drive.amplitudes.iter().copied().fold(0.0, f64::max);
        let axis = Axis::new(aperture, &drive, position);
        let audible = scene.listener.as_ref().and_then(|listener| {
            axis.audible((aperture, &air), &u, &demodulation::lines(scene, scene.envelope()), listener.at)
        });
        Ok(Self {
            position,
            harmonic,
            linear_drive: (largest * LINEAR / harmonic).min(1.0),
            streaming: axis.streaming((aperture, &air), &u, harmonic),
            audible,
        })
    }
}

/// The axis of a beam.
struct Axis {
    /// m, the middle of the driven elements.
    from: DVec3,
    direction: DVec3,
    /// m, to the focus.
    length: f64,
}

impl Axis {
    fn new(aperture: &Aperture, drive: &Drive, focus: DVec3) -> Self {
        let amplitudes = || aperture.driven.iter().map(|&n| (aperture.positions[n], drive.amplitudes[n]));
        let total: f64 = amplitudes().map(|(_, amplitude)| amplitude).sum();
        let from = amplitudes().map(|(at, amplitude)| at * amplitude).sum::<DVec3>() / total;
        let direction = (focus - from).try_normalize();
        Self { from, direction: direction.unwrap_or(DVec3::Z), length: focus.distance(from) }
    }

    /// Bound of the streaming, m/s.
    fn streaming(&self, (aperture, air): (&Aperture, &Air), u: &[Complex64], ratio: f64) -> f64 {
        let wavelength = aperture.wavelength();
        // Nearer, the far field of elements has no meaning.
        let span = 2.0 * self.length - wavelength;
        if span <= 0.0 {
            return 0.0;
        }
        let count = (span * PER_WAVELENGTH / wavelength).ceil() as usize;
        let step = span / count as f64;
        let place = |i: usize| self.from + self.direction * (wavelength + step * (i as f64 + 0.5));
        let places: Vec<_> = (0..count).map(place).collect();
        let squares = aperture.pressures(&places, u).into_iter().map(|p| p.norm_sqr());
        let absorbed = air.attenuation + air.attenuation_of_second * ratio * ratio;
        let pushed: f64 = squares.sum::<f64>() * step * absorbed / (air.density * air.sound_speed.powi(2));
        (2.0 * pushed / air.density).sqrt()
    }

    /// `None` of a steady envelope.
    fn audible(
        &self,
        (aperture, air): (&Aperture, &Air),
        u: &[Complex64],
        lines: &[SpectralLine],
        listener: DVec3,
    ) -> Option<Audible> {
        let power = power(aperture, air, u);
        let c = air.sound_speed;
        let of_line = |line: &SpectralLine| {
            let omega = TAU * line.frequency;
            let factor = NONLINEARITY * omega * omega * line.amplitude * power / c.powi(3);
            let rms = factor * self.line_source(air, omega / c, listener).norm() / SQRT_2;
            (line.frequency, rms, rms * a_weight(line.frequency))
        };
        let heard: Vec<_> = lines.iter().map(of_line).collect();
        let (frequency, ..) = *heard.iter().max_by(|a, b| a.2.total_cmp(&b.2))?;
        let sum =
            |part: fn(&(f64, f64, f64)) -> f64| heard.iter().map(part).map(|p| p * p).sum::<f64>().sqrt();
        Some(Audible { rms: sum(|line| line.1), weighted: sum(|line| line.2), frequency })
    }

    /// ∫ e^{-2αs} e^{-jk(s + R)}/(4πR) ds, 1.
    fn line_source(&self, air: &Air, k: f64, listener: DVec3) -> Complex64 {
        /// Absorption to which the axis is followed, Np of the power, and its length (m) in still air.
        const FADED: f64 = 5.0;
        const LONGEST: f64 = 100.0;
        /// Closest distance to the axis, m: the beam has a width.
        const WIDTH: f64 = 0.01;
        /// Steps per radian, and for a distance that grows by e; and their number.
        const FINE: f64 = 2.0;
        const FEWEST: f64 = 32.0;
        const MOST: f64 = 1e5;
        let decay = 2.0 * air.attenuation;
        let end = (FADED / decay).min(LONGEST);
        let along = (listener - self.from).dot(self.direction);
        let across = (self.from + self.direction * along).distance(listener).max(WIDTH);
        // s = along + across · sinh(v): dv = ds/R.
        let [first, last] = [-along, end - along].map(|place| (place / across).asinh());
        let count = ((last - first) * FEWEST.max(FINE * k * end)).ceil().min(MOST) as usize;
        let step = (last - first) / count as f64;
        let value = |i: usize| {
            let v = first + step * (i as f64 + 0.5);
            let (s, r) = (along + across * v.sinh(), across * v.cosh());
            Complex64::from_polar((-decay * s).exp(), -k * (s + r))
        };
        (0..count).map(value).sum::<Complex64>() * (step / (4.0 * PI))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Envelope, Listener, Modulation, Shape, Target};
    use crate::solver;

    #[test]
    fn the_default_focus_at_full_drive_is_not_linear() {
        let target = Target::new(Shape::Point { at: DVec3::Z * 0.1 });
        let mut scene = Scene { targets: vec![target], ..Scene::default() };
        scene.listener = Some(Listener { at: DVec3::new(0.3, 0.0, 0.3) });
        let nonlinear = |scene: &Scene| {
            Nonlinear::of_solution(scene, &Aperture::new(scene), &solver::solve(scene).unwrap()).unwrap()
        };
        let steady = nonlinear(&scene);
        // 0.376 by sums on lattices.
        assert!((steady.harmonic / 0.376 - 1.0).abs() < 0.02, "{steady:?}");
        assert!((steady.linear_drive - 0.1 / steady.harmonic).abs() < 1e-12, "{steady:?}");
        // The integrals in numpy.
        assert!((steady.streaming / 1.145 - 1.0).abs() < 0.02 && steady.audible.is_none(), "{steady:?}");
        scene.modulation =
            Modulation { shape: Envelope::Sine, frequency: 200.0, depth: 1.0, ..scene.modulation };
        let slow = nonlinear(&scene).audible.unwrap();
        assert!((slow.level() - 49.0).abs() < 0.2, "{slow:?}");
        scene.modulation.frequency = 400.0;
        let fast = nonlinear(&scene).audible.unwrap();
        // The source grows with the square of the frequency.
        assert!((8.0..16.0).contains(&(fast.level() - slow.level())), "{slow:?}, {fast:?}");
        assert!(slow.weighted < slow.rms && fast.weighted > slow.weighted, "{slow:?}, {fast:?}");
    }
}
