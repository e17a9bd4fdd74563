//! The skin on the plane under the sound of all frames: its motion as spectral lines at the cells.
//!
//! All is linear after the square. The radiation pressure at the cells, of every frame, has a Fourier series over the cycle;
//! with the lines of the envelope it makes lines of the pressure (`acoustics::course`), and each of them moves the skin by one
//! convolution (`surface::skin`). Lines that neither move the skin nor are felt, in their channel, are left out.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::ops::Range;

use glam::DVec2;
use num_complex::{Complex32, Complex64};
use rayon::prelude::*;
use sonoglyph_fourier::transform;

use crate::acoustics::course::{Combination, Course};
use crate::field::cells::{Cells, smooth};
use crate::field::stages::job::FormedKey;
use crate::field::stages::kept::Kept;
use crate::field::stages::request::FieldError;
use crate::scene::{Channel, Skin, SpectralLine};
use crate::surface::skin::{Touch, yielding};

/// Highest frequency of a line, Hz: far beyond what is felt, and what a focus of 15 m/s excites.
const BAND: f64 = 2000.0;
/// Part of the power, and of what is felt, of all lines that may be left out: of maps, and of courses of time, whose lines add up
/// in phase.
const LEAST: [f64; 2] = [1e-5, 1e-7];
/// Wavenumber (1/m) whose response ranks the lines: that of a focus.
const OF_FOCUS: f64 = 300.0;
/// Values of all frames at the cells.
const MOST_VALUES: usize = 1 << 26;
/// Frequencies whose factors are kept.
const MOST_FACTORS: usize = 128;
/// Cells transformed over time together.
const TOGETHER: usize = 512;
/// Power of a level that is as good as none: -100 dB.
pub(super) const FLOOR: f64 = 1e-10;

/// The motion of the skin: spectral lines at the cells of a lattice.
#[derive(Clone, Debug, Default)]
pub struct SkinMotion {
    cells: Option<Cells>,
    /// Columns and rows of all cells, with the same centre.
    all: [usize; 2],
    lines: Vec<Line>,
}

/// One line: coefficients of e^{2πj frequency t}, m, of every cell.
#[derive(Clone, Debug)]
struct Line {
    /// Hz
    frequency: f64,
    values: Vec<Complex32>,
}

impl SkinMotion {
    /// The lines at places (m along the plane's axes, from its centre), the mean first; m, peak.
    pub fn at(&self, places: &[DVec2]) -> Vec<Vec<SpectralLine>> {
        let Some(cells) = &self.cells else { return vec![Vec::new(); places.len()] };
        let along = [0, 1].map(|axis| cells.resampling(axis, places.iter().map(|place| place[axis])));
        let at = |place: usize| {
            let ((column, across), (row, up)) = (along[0].of(place, 1), along[1].of(place, 1));
            let value = |line: &Line| {
                let of_row = |(tap, part): (usize, &f32)| {
                    let row = &line.values[(row + tap) * cells.counts[0] + column..][..across.len()];
                    row.iter().zip(across).map(|(value, part)| value * *part).sum::<Complex32>() * *part
                };
                up.iter().enumerate().map(of_row).sum::<Complex32>()
            };
            let line = |line: &Line| {
                let value = value(line);
                match line.frequency {
                    0.0 => SpectralLine { frequency: 0.0, amplitude: value.re.into(), phase: 0.0 },
                    frequency => SpectralLine {
                        frequency,
                        amplitude: 2.0 * f64::from(value.norm()),
                        phase: value.arg().into(),
                    },
                }
            };
            self.lines.iter().map(line).collect()
        };
        (0..places.len()).map(at).collect()
    }

    /// The lattice, and the sum over all moving lines of a weight (by frequency, Hz) times the squared amplitude (m, peak) at every cell of it.
    pub fn powers(&self, weight: impl Fn(f64) -> f64) -> Option<(&Cells, Vec<f64>)> {
        let cells = self.cells.as_ref()?;
        let mut sums = vec![0.0; cells.count()];
        for line in self.lines.iter().filter(|line| line.frequency > 0.0) {
            let weight = 4.0 * weight(line.frequency);
            if weight > 0.0 {
                let cells = sums.iter_mut().zip(&line.values);
                cells.for_each(|(sum, value)| *sum += weight * f64::from(value.norm_sqr()));
            }
        }
        Some((cells, sums))
    }
}

/// What lines must contribute to: frequencies of a channel, by displacement or by what is felt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Purpose {
    Displacement(Channel),
    Feeling(Channel),
    /// Every channel by itself, and the mean.
    All,
}

impl Purpose {
    /// The weight of the squared amplitude (m, peak) of a line (Hz) in the value of a map.
    pub(super) fn weight(self, skin: &Skin, frequency: f64) -> f64 {
        match self {
            Self::Displacement(channel) if channel.contains(frequency) => 0.5,
            Self::Feeling(channel) if channel.contains(frequency) => skin.threshold_at(frequency).powi(-2),
            Self::Displacement(_) | Self::Feeling(_) | Self::All => 0.0,
        }
    }

    /// All values that a line may count for.
    fn parts(self) -> Vec<Self> {
        match self {
            Self::Displacement(_) | Self::Feeling(_) => vec![self],
            Self::All => vec![
                Self::Displacement(Channel::All),
                Self::Feeling(Channel::Pressure),
                Self::Feeling(Channel::Flutter),
                Self::Feeling(Channel::Vibration),
            ],
        }
    }
}

/// The inputs of a motion.
#[derive(Clone, Debug, PartialEq)]
struct MotionKey {
    formed: FormedKey,
    skin: Skin,
    course: Course,
    purpose: Purpose,
}

/// The lattice of a convolution: pressures at all cells, displacements at those in the middle.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Lattice {
    cells: [usize; 2],
    middle: [usize; 2],
    step: f64,
}

impl Lattice {
    /// The displacement is wanted on a plane of a size (m), and as far beyond as an interpolation reaches.
    fn new(cells: &Cells, size: DVec2) -> Self {
        let middle = [0, 1].map(|axis| {
            let half = (size[axis] / 2.0 + cells.reach()) / cells.step + 2.0;
            // The centres of both coincide.
            let count = 2 * half.ceil() as usize + cells.counts[axis] % 2;
            count.min(cells.counts[axis])
        });
        Self { cells: cells.counts, middle, step: cells.step }
    }

    fn first(self) -> [usize; 2] {
        [0, 1].map(|axis| (self.cells[axis] - self.middle[axis]) / 2)
    }
}

/// The latest motion of the skin.
#[derive(Debug, Default)]
pub(super) struct OfSkin {
    /// Radiation pressure (Pa) of every frame at the cells.
    pub(super) pressures: Kept<FormedKey, Vec<Vec<f32>>>,
    touch: Kept<Lattice, Option<Touch>>,
    factors: Kept<(Lattice, Skin), BTreeMap<u64, Vec<Complex64>>>,
    motion: Kept<MotionKey, SkinMotion>,
}

impl OfSkin {
    pub(super) fn forget(&mut self) {
        *self = Self::default();
    }

    /// Bytes of the values of all frames and lines.
    pub(super) fn bytes(&self) -> usize {
        let of_frames: usize =
            self.pressures.value.iter().map(|frame| frame.capacity() * size_of::<f32>()).sum();
        let of_line = |line: &Line| line.values.capacity() * size_of::<Complex32>();
        of_frames + self.motion.value.lines.iter().map(of_line).sum::<usize>()
    }

    /// # Errors
    /// More values than memory has room for.
    pub(super) fn check(frames: usize, cells: &Cells) -> Result<(), FieldError> {
        match frames.saturating_mul(cells.count()) > MOST_VALUES {
            true => Err(FieldError::TooManyFrames(frames)),
            false => Ok(()),
        }
    }

    /// The motion under the kept pressures, and the number of lines that were made for it.
    pub(super) fn motion(
        &mut self,
        cells: &Cells,
        size: DVec2,
        (skin, course): (&Skin, &Course),
        purpose: Purpose,
    ) -> (&SkinMotion, u64) {
        let Some(formed) = self.pressures.key.clone() else { return (&self.motion.value, 0) };
        let key = MotionKey { formed, skin: skin.clone(), course: course.clone(), purpose };
        if self.motion.is_of(&key) {
            return (&self.motion.value, 0);
        }
        let Self { pressures, touch, factors, motion, .. } = self;
        motion.key = None;
        let lattice = Lattice::new(cells, size);
        let counts = [0, 1].map(|axis| smooth(lattice.cells[axis] + lattice.middle[axis]));
        let touch = touch.update(&lattice, |touch| *touch = Some(Touch::new(counts, lattice.step)));
        let Some(touch) = touch else { return (&motion.value, 0) };
        let harmonics = Harmonics::new(&pressures.value);
        let lines = lines_that_count(course.lines(BAND), &harmonics, skin, purpose);
        let matter = Skin { threshold: Skin::default().threshold, curve: Default::default(), ..skin.clone() };
        factors.update(&(lattice, matter), BTreeMap::clear);
        let kept = &mut factors.value;
        let mut made = Vec::with_capacity(lines.len());
        for some in lines.chunks(MOST_FACTORS) {
            let of = |line: &Combination| line.frequency.to_bits();
            let mut lacking: Vec<_> = some.iter().filter(|line| !kept.contains_key(&of(line))).collect();
            if kept.len() + lacking.len() > MOST_FACTORS {
                kept.clear();
                lacking = some.iter().collect();
            }
            let frequencies: Vec<_> = lacking.iter().map(|line| line.frequency).collect();
            kept.extend(lacking.into_iter().map(of).zip(touch.factors(skin, &frequencies)));
            made.par_extend(some.par_iter().map(|line| {
                let pressure = harmonics.combined(&line.weights);
                let found = touch.displacement(
                    &kept[&of(line)],
                    (&pressure, lattice.cells),
                    (lattice.first(), lattice.middle),
                );
                let narrow = |value: Complex64| Complex32::new(value.re as f32, value.im as f32);
                Line { frequency: line.frequency, values: found.into_iter().map(narrow).collect() }
            }));
        }
        let (count, lines) = (made.len() as u64, made);
        motion.value = SkinMotion { cells: Some(cells.within(lattice.middle)), all: cells.counts, lines };
        motion.key = Some(key);
        (&motion.value, count)
    }
}

impl SkinMotion {
    /// The skin at a time (s), m, positive into it, as the `depth` of a request.
    pub fn surface(&self, time: f64) -> Vec<f64> {
        let mut sums = vec![0.0; self.cells.as_ref().map_or(0, Cells::count)];
        for line in &self.lines {
            let turn = Complex64::from_polar(1.0, TAU * (line.frequency * time).fract());
            let [re, im] =
                [turn.re, turn.im].map(|part| if line.frequency > 0.0 { 2.0 * part } else { part });
            let cells = sums.iter_mut().zip(&line.values);
            cells.for_each(|(sum, value)| *sum += re * f64::from(value.re) - im * f64::from(value.im));
        }
        self.widened(&sums)
    }

    /// Values of the lattice as those of all cells, 0 beyond it.
    pub(super) fn widened(&self, values: &[f64]) -> Vec<f64> {
        let mut wide = vec![0.0; self.all[0] * self.all[1]];
        let Some(cells) = &self.cells else { return wide };
        let [first_column, first_row] = [0, 1].map(|axis| (self.all[axis] - cells.counts[axis]) / 2);
        for (row, values) in values.chunks_exact(cells.counts[0]).enumerate() {
            wide[(first_row + row) * self.all[0] + first_column..][..values.len()].copy_from_slice(values);
        }
        wide
    }
}

/// The lines that count for a purpose; the mean only where all is wanted.
fn lines_that_count(
    all: Vec<Combination>,
    harmonics: &Harmonics,
    skin: &Skin,
    purpose: Purpose,
) -> Vec<Combination> {
    let power = |line: &Combination| {
        let of_pressure: f64 =
            line.weights.iter().map(|(k, weight)| weight.norm_sqr() * harmonics.power(*k)).sum();
        let omega = TAU * line.frequency;
        of_pressure * yielding(skin, Complex64::from(OF_FOCUS), omega).norm_sqr()
    };
    let powers: Vec<_> = all.iter().map(power).collect();
    let mut counts = vec![false; all.len()];
    for part in purpose.parts() {
        let weighted = |(index, line): (usize, &Combination)| match line.frequency {
            0.0 => (index, 0.0),
            frequency => (index, powers[index] * part.weight(skin, frequency)),
        };
        let mut ranked: Vec<_> = all.iter().enumerate().map(weighted).collect();
        ranked.sort_unstable_by(|a, b| b.1.total_cmp(&a.1));
        let mut left: f64 = ranked.iter().map(|(_, power)| power).sum();
        let least = LEAST[usize::from(purpose == Purpose::All)] * left;
        for (index, power) in ranked {
            if left <= least || power <= 0.0 {
                break;
            }
            counts[index] = true;
            left -= power;
        }
    }
    if purpose == Purpose::All && all.first().is_some_and(|line| line.frequency == 0.0) {
        counts[0] = true;
    }
    all.into_iter().zip(counts).filter(|(_, counts)| *counts).map(|(line, _)| line).collect()
}

/// The Fourier series over the frames at every cell: harmonics 0 to half the frames.
struct Harmonics {
    frames: usize,
    values: Vec<Vec<Complex32>>,
}

impl Harmonics {
    fn new(frames: &[Vec<f32>]) -> Self {
        let (count, cells) = (frames.len(), frames.first().map_or(0, Vec::len));
        let kept = count / 2 + 1;
        let over_time = transform(count);
        // Two cells are the real and the imaginary part of one sequence.
        let of_cells = |first: usize| {
            let cells = first..cells.min(first + TOGETHER);
            let pairs = cells.len().div_ceil(2);
            let mut buffer = vec![Complex64::ZERO; pairs * count];
            for (frame, values) in frames.iter().enumerate() {
                for (pair, two) in values[cells.clone()].chunks(2).enumerate() {
                    let second = two.get(1).copied().unwrap_or(0.0);
                    buffer[pair * count + frame] = Complex64::new(two[0].into(), second.into());
                }
            }
            over_time.process(&mut buffer);
            let scale = 0.5 / count as f64;
            let mut harmonics = vec![Complex32::ZERO; kept * cells.len()];
            for (pair, line) in buffer.chunks_exact(count).enumerate() {
                for k in 0..kept {
                    let (a, b) = (line[k], line[(count - k) % count].conj());
                    let two = [(a + b) * scale, (a - b) * scale * -Complex64::I];
                    for (cell, value) in (2 * pair..cells.len()).zip(two) {
                        harmonics[k * cells.len() + cell] = Complex32::new(value.re as f32, value.im as f32);
                    }
                }
            }
            (cells, harmonics)
        };
        let starts: Vec<_> = (0..cells).step_by(TOGETHER).collect();
        let runs: Vec<(Range<usize>, Vec<Complex32>)> = starts.into_par_iter().map(of_cells).collect();
        let of_harmonic = |k: usize| {
            runs.iter()
                .flat_map(|(cells, values)| values[k * cells.len()..][..cells.len()].iter().copied())
                .collect()
        };
        Self { frames: count, values: (0..kept).into_par_iter().map(of_harmonic).collect() }
    }

    /// The kept harmonic that is this one or its conjugate.
    fn kept(&self, k: usize) -> (&[Complex32], bool) {
        let mirrored = self.frames - k;
        if k < self.values.len() { (&self.values[k], false) } else { (&self.values[mirrored], true) }
    }

    /// Sum of the squares over all cells.
    fn power(&self, k: usize) -> f64 {
        self.kept(k).0.iter().map(|value| f64::from(value.norm_sqr())).sum()
    }

    /// The sum of harmonics times weights, at every cell.
    fn combined(&self, weights: &[(usize, Complex64)]) -> Vec<Complex64> {
        let mut sum = vec![Complex64::ZERO; self.values[0].len()];
        for (k, weight) in weights {
            let (values, is_mirrored) = self.kept(*k);
            for (sum, value) in sum.iter_mut().zip(values) {
                let value = Complex64::new(value.re.into(), value.im.into());
                *sum += weight * if is_mirrored { value.conj() } else { value };
            }
        }
        sum
    }
}
