//! A virtual microphone: what it would read at the positions of a scan in the field of a hidden board.
//!
//! Its disk averages the pressure by Gauss's rule along the radius and equal steps around the circle: 64 points, exact
//! for polynomials up to the degree 15, so that even the widest disk is right for waves of 40 kHz at grazing incidence.

use std::f64::consts::TAU;

use crate::acoustics::Aperture;
use crate::device::board::hidden::{Hidden, Stream, normal};
use crate::drive::Drive;
use crate::scene::{Reflector, Scene, check};

/// m, diameter.
const WIDEST: f64 = 0.02;
/// Pressure reflection coefficient of the wall.
const WALL: f64 = 0.3;
/// Places on [0, 1] and weights of Gauss's rule with 4 points, for r² on the disk.
const RINGS: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_9),
    (0.330_009_478_207_571_9, 0.326_072_577_431_273_1),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_1),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_9),
];
/// Points of a ring.
const AROUND: usize = 16;
/// Points whose pressures are computed together, which bounds the memory.
const TOGETHER: usize = 1 << 16;

/// The properties of a microphone, its plotter and its room.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Microphone {
    /// dB: RMS of a drive's readings over RMS of the noise.
    pub snr: f64,
    /// m, diameter of its disk, which is parallel to z = 0.
    pub width: f64,
    /// m, RMS per axis, of its place about each nominal position.
    pub position: f64,
    /// m, height of a wall above the array and parallel to it.
    pub wall: Option<f64>,
    /// Whether it reads phases, as a lock-in amplifier does, up to a constant.
    pub complex: bool,
}

impl Default for Microphone {
    fn default() -> Self {
        Self { snr: 40.0, width: 0.0, position: 0.0, wall: None, complex: false }
    }
}

/// A reading: complex peak amplitude, Pa.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Signal {
    pub re: f64,
    pub im: f64,
}

impl Signal {
    /// Pa, peak.
    pub fn amplitude(self) -> f64 {
        self.re.hypot(self.im)
    }
}

/// A point of the microphone's disk.
#[derive(Clone, Copy, Debug)]
struct DiskNode {
    /// m, from the centre.
    x: f64,
    y: f64,
    weight: f64,
}

impl Microphone {
    /// The microphone of a text such as "snr=30,width=0.005,complex".
    ///
    /// # Errors
    /// Names the invalid part, and what would be right.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut microphone = Self::default();
        for part in text.split(',').map(str::trim) {
            let (name, value) = match part.split_once('=') {
                Some((name, value)) => (name.trim(), Some(value.trim())),
                None => (part, None),
            };
            let number = |least: f64, most: f64, meaning: &str| {
                let number = value.and_then(|value| value.parse::<f64>().ok());
                number
                    .filter(|number| (least..=most).contains(number))
                    .ok_or_else(|| format!("{part}: {name}= takes {meaning}, from {least} to {most}"))
            };
            match name {
                "snr" if value == Some("inf") => microphone.snr = f64::INFINITY,
                "snr" => microphone.snr = number(-20.0, 200.0, "inf or the signal-to-noise ratio in dB")?,
                "width" => microphone.width = number(0.0, WIDEST, "the diameter of the disk in m")?,
                "position" => {
                    microphone.position = number(0.0, 0.01, "the RMS error of positions per axis in m")?;
                }
                "wall" => microphone.wall = Some(number(0.01, 100.0, "the height of the wall in m")?),
                "complex" if value.is_none() => microphone.complex = true,
                "complex" => return Err(format!("{part}: complex takes no value")),
                _ => return Err(format!("{part}: a microphone has snr, width, position, wall, complex")),
            }
        }
        Ok(microphone)
    }

    /// The scene with the microphone's wall.
    ///
    /// # Errors
    /// The scene has no place for it.
    pub fn room(&self, scene: &Scene) -> Result<Scene, String> {
        /// Sine of the largest angle between parallel planes.
        const PARALLEL: f64 = 1e-9;
        let mut room = scene.clone();
        let Some(height) = self.wall else { return Ok(room) };
        let is_level = |mirror: &Reflector| {
            let [x, y, _] = mirror.normal.normalize_or_zero().to_array();
            x.hypot(y) < PARALLEL
        };
        if scene.mirrors().iter().any(is_level) {
            return Err(format!(
                "wall={height}: the scene has a reflector parallel to it, and echoes between both are not \
                 computed: leave one of them out"
            ));
        }
        let (point, normal) = ([0.0, 0.0, height].into(), [0.0, 0.0, -1.0].into());
        room.reflectors.push(Reflector { point, normal, coefficient: WALL });
        check::check(&room).map_err(|error| format!("wall={height}: {}", error.message))?;
        Ok(room)
    }

    /// Readings of a drive at the nominal positions (m) of a scan in the room of `aperture`; `number` is that of the
    /// drive, whose noise is its own. The microphone's places are the same for all drives.
    ///
    /// # Panics
    /// A drive of fewer elements than the aperture's.
    pub fn read(
        &self,
        aperture: &Aperture,
        hidden: &Hidden,
        positions: &[[f64; 3]],
        (number, drive): (u64, &Drive),
    ) -> Vec<Signal> {
        let excitation = hidden.sound(drive.clone()).excitation(&aperture.driven);
        let disk = self.disk();
        let mut signals = Vec::with_capacity(positions.len());
        for places in self.places(hidden, positions).chunks(TOGETHER / disk.len()) {
            let points = |&[x, y, z]: &[f64; 3]| {
                disk.iter().map(move |node| [x + node.x, y + node.y, z].into()).collect::<Vec<_>>()
            };
            let points: Vec<_> = places.iter().flat_map(points).collect();
            let pressures = aperture.pressures(&points, &excitation);
            signals.extend(pressures.chunks(disk.len()).map(|pressures| {
                let weighted = || pressures.iter().zip(&disk).map(|(p, node)| p * node.weight);
                Signal { re: weighted().map(|p| p.re).sum(), im: weighted().map(|p| p.im).sum() }
            }));
        }
        self.distort(hidden, number, &mut signals);
        signals
    }

    /// Adds the noise, and turns the phases by that of the reference.
    fn distort(&self, hidden: &Hidden, number: u64, signals: &mut [Signal]) {
        let squares: f64 = signals.iter().map(|signal| signal.amplitude().powi(2)).sum();
        let rms = (squares / signals.len().max(1) as f64).sqrt();
        // Real and imaginary part have half of the noise's power each.
        let deviation = rms * 10f64.powf(-self.snr / 20.0) / 2f64.sqrt();
        let (sin, cos) = (TAU * hidden.chance(Stream::Reference).f64()).sin_cos();
        let mut chance = hidden.chance(Stream::Noise(number));
        for signal in signals {
            let re = signal.re + deviation * normal(&mut chance);
            let im = signal.im + deviation * normal(&mut chance);
            *signal = Signal { re: re * cos - im * sin, im: re * sin + im * cos };
        }
    }

    /// The real places (m) of its centre.
    fn places(&self, hidden: &Hidden, positions: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let mut chance = hidden.chance(Stream::Places);
        let mut place = |at: [f64; 3]| at.map(|value| value + self.position * normal(&mut chance));
        hidden.places(positions).into_iter().map(&mut place).collect()
    }

    /// The points of its disk, with weights that add up to 1.
    fn disk(&self) -> Vec<DiskNode> {
        if self.width == 0.0 {
            return vec![DiskNode { x: 0.0, y: 0.0, weight: 1.0 }];
        }
        let node = |(square, weight): (f64, f64), step: usize| {
            let (sin, cos) = (TAU * step as f64 / AROUND as f64).sin_cos();
            let radius = self.width / 2.0 * square.sqrt();
            DiskNode { x: radius * cos, y: radius * sin, weight: weight / AROUND as f64 }
        };
        RINGS.into_iter().flat_map(|ring| (0..AROUND).map(move |step| node(ring, step))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::acoustics::directivity;
    use crate::scene::{Array, Board, ElementModel};

    /// One element that sounds equally in all directions, without absorption.
    fn point() -> Scene {
        let array = Array { rows: 1, columns: 1, element: ElementModel::Point, ..Array::default() };
        let mut scene = Scene { array, ..Scene::default() };
        scene.medium.absorption = Some(0.0);
        scene
    }

    fn drive(elements: usize) -> Drive {
        Drive { amplitudes: vec![1.0; elements], phases: vec![0.0; elements] }
    }

    /// A board of one element and a scan, both as the model says.
    fn exact() -> Hidden {
        let mut hidden = Hidden::new(1, 1);
        (hidden.gains, hidden.phases, hidden.speed) = (vec![1.0], vec![0.0], 1.0);
        (hidden.shift, hidden.tilts) = ([0.0; 3], [0.0; 2]);
        hidden
    }

    fn silent() -> Microphone {
        Microphone { snr: f64::INFINITY, ..Microphone::default() }
    }

    /// A grid of positions.
    fn grid(side: usize) -> Vec<[f64; 3]> {
        let at = |n: usize| (n as f64 / (side - 1) as f64 - 0.5) * 0.1;
        (0..side * side).map(|n| [at(n % side), at(n / side), 0.1]).collect()
    }

    #[test]
    fn a_disk_averages_a_plane_wave_to_2_j1_x_over_x() {
        let scene = point();
        let aperture = Aperture::new(&scene);
        let positions = [[8.0, 0.0, 1e-3], [0.0, -8.0, 1e-3]];
        let read = |width: f64| {
            let microphone = Microphone { width, ..silent() };
            microphone.read(&aperture, &exact(), &positions, (0, &drive(1)))
        };
        for width in [0.001, 0.005, 0.0127, WIDEST] {
            let x = aperture.element.wavenumber * width / 2.0;
            for (disk, centre) in read(width).iter().zip(read(0.0)) {
                let mean = (disk.re * centre.re + disk.im * centre.im) / centre.amplitude().powi(2);
                assert!((mean - directivity(x)).abs() < 1e-3, "{width} m: {mean}, not {}", directivity(x));
            }
        }
    }

    #[test]
    fn noise_is_as_strong_as_stated() {
        let (scene, positions) = (Scene::default(), grid(60));
        let (aperture, hidden) = (Aperture::new(&scene), Hidden::new(5, 256));
        let read = |snr: f64, number: u64| {
            let microphone = Microphone { snr, ..Microphone::default() };
            microphone.read(&aperture, &hidden, &positions, (number, &drive(256)))
        };
        let pure = read(f64::INFINITY, 0);
        let power = |signals: &mut dyn Iterator<Item = Signal>| -> f64 {
            signals.map(|signal| signal.amplitude().powi(2)).sum()
        };
        let noise = |snr: f64, number: u64| -> Vec<_> {
            let difference = |(a, b): (Signal, &Signal)| Signal { re: a.re - b.re, im: a.im - b.im };
            read(snr, number).into_iter().zip(&pure).map(difference).collect()
        };
        for snr in [10.0, 30.0] {
            let ratio = power(&mut pure.iter().copied()) / power(&mut noise(snr, 0).into_iter());
            assert!((10.0 * ratio.log10() - snr).abs() < 0.3, "{snr} dB: {ratio}");
        }
        assert_ne!(noise(30.0, 0), noise(30.0, 1), "each drive has its own");
        assert_eq!(read(f64::INFINITY, 0), read(f64::INFINITY, 1));
    }

    #[test]
    fn phases_are_those_of_the_model_up_to_a_constant() {
        let (scene, positions) = (point(), grid(4));
        let (aperture, hidden) = (Aperture::new(&scene), exact());
        let signals = silent().read(&aperture, &hidden, &positions, (0, &drive(1)));
        let points: Vec<_> = positions.iter().map(|&at| at.into()).collect();
        let expected = aperture.pressures(&points, &drive(1).excitation(&aperture.driven));
        let turns: Vec<_> = signals
            .iter()
            .zip(&expected)
            .map(|(own, p)| [own.re * p.re + own.im * p.im, own.im * p.re - own.re * p.im])
            .map(|[re, im]| im.atan2(re))
            .collect();
        assert!(turns.iter().all(|turn| (turn - turns[0]).cos() > 1.0 - 1e-12), "{turns:?}");
        for (own, p) in signals.iter().zip(&expected) {
            assert!((own.amplitude() - p.norm()).abs() < 1e-9 * p.norm());
        }
    }

    #[test]
    fn places_scatter_about_their_positions_the_same_way_for_all_drives() {
        let (positions, hidden) = (grid(30), exact());
        let microphone = Microphone { position: 2e-4, ..silent() };
        let places = microphone.places(&hidden, &positions);
        for axis in 0..3 {
            let square: f64 =
                places.iter().zip(&positions).map(|(place, at)| (place[axis] - at[axis]).powi(2)).sum();
            let rms = (square / positions.len() as f64).sqrt();
            assert!((rms / 2e-4 - 1.0).abs() < 0.15, "axis {axis}: {rms} m");
        }
        let aperture = Aperture::new(&point());
        let read = |number: u64| microphone.read(&aperture, &hidden, &positions, (number, &drive(1)));
        assert_eq!(read(0), read(1));
    }

    #[test]
    fn a_wall_adds_its_echo() {
        let microphone = Microphone { wall: Some(0.3), ..silent() };
        let (scene, at) = (point(), [[0.0, 0.0, 0.1]]);
        let read = |scene: &Scene| silent().read(&Aperture::new(scene), &exact(), &at, (0, &drive(1)))[0];
        let (echoing, free) = (read(&microphone.room(&scene).unwrap()), read(&scene));
        let echo = Signal { re: echoing.re - free.re, im: echoing.im - free.im };
        // From the image at 0.6 m, half a metre away.
        let expected = WALL * free.amplitude() * 0.1 / 0.5;
        assert!((echo.amplitude() / expected - 1.0).abs() < 1e-9, "{echo:?} is not {expected} Pa");
        assert_eq!(silent().room(&scene), Ok(scene));
    }

    #[test]
    fn a_wall_is_refused_where_the_scene_has_no_place_for_it() {
        let microphone = Microphone { wall: Some(0.3), ..silent() };
        let parallel = Scene { reflectors: vec![Reflector::default()], ..point() };
        let refused = microphone.room(&parallel).unwrap_err();
        assert!(refused.starts_with("wall=0.3: the scene has a reflector parallel to it"), "{refused}");
        let board = Board { at: [0.0, 0.0, 0.4].into(), ..Board::default() };
        let refused = microphone.room(&Scene { boards: vec![board], ..point() }).unwrap_err();
        assert!(refused.starts_with("wall=0.3: board 1 lies behind it"), "{refused}");
    }

    #[test]
    fn lists_are_read_and_nonsense_is_refused() {
        let list = "snr=30, width=0.005,position=0.0002,wall=0.3,complex";
        let expected = Microphone { snr: 30.0, width: 0.005, position: 2e-4, wall: Some(0.3), complex: true };
        assert_eq!(Microphone::parse(list), Ok(expected));
        assert_eq!(Microphone::parse("snr=inf"), Ok(silent()));
        for (list, words) in [
            ("", ": a microphone has snr, width, position, wall, complex"),
            ("width=5", "width=5: width= takes the diameter of the disk in m, from 0 to 0.02"),
            ("snr", "snr: snr= takes inf or the signal-to-noise ratio in dB, from -20 to 200"),
            ("snr=nan", "snr=nan: snr= takes inf or"),
            ("complex,position=-1", "position=-1: position= takes the RMS error of positions per axis in m"),
            ("wall=0", "wall=0: wall= takes the height of the wall in m, from 0.01 to 100"),
            ("complex=1", "complex=1: complex takes no value"),
            ("gain=2", "gain=2: a microphone has snr, width"),
        ] {
            let refused = Microphone::parse(list).unwrap_err();
            assert!(refused.starts_with(words), "{list}: {refused}");
        }
    }
}
