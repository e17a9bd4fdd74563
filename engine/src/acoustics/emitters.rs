//! Waves of elements and of their images at a point, with their slopes, in f64.
//!
//! With d the vector from an element to the point, h its height along the element's normal n and Q = d·d/2, the wave
//! is a function P(Q, h), whose derivatives are closed forms; ∂ᵢP = P_Q dᵢ + P_h nᵢ.

use std::f64::consts::PI;

use glam::DVec3;
use num_complex::Complex64;

use crate::acoustics::element::{NEAREST, Radiator};
use crate::acoustics::{aperture::Aperture, element::Element};
use crate::simd::{Instructions, Isa, Kernel, lanes, total};
use crate::special::bessel;
use crate::special::series::{COSINE, LANES, ROUNDER, SINE, horner, inverse_factorials};

type Lanes = [f64; LANES];

/// An array with an expression per axis, written out, since closures over arrays are not vectorised.
macro_rules! axes {
    ($axis:ident => $value:expr) => {
        [axes!($axis = 0, $value), axes!($axis = 1, $value), axes!($axis = 2, $value)]
    };
    ($axis:ident = $number:literal, $value:expr) => {{
        const $axis: usize = $number;
        $value
    }};
}

/// All sources, in the scene's coordinates.
#[derive(Clone, Debug)]
pub(super) struct Emitters {
    element: Element,
    /// m, padded to whole blocks with the last of them.
    places: [Vec<f64>; 3],
    /// Unit vectors.
    normals: [Vec<f64>; 3],
    /// Unit vectors of the elements' x axes, in the same form.
    asides: [Vec<f64>; 3],
    /// j times strength, gain and drive; zero beyond the last.
    played: [Vec<f64>; 2],
}

impl Emitters {
    /// The driven elements of an aperture and of its images, with a drive for each driven element.
    pub fn new(aperture: &Aperture, excitation: &[Complex64]) -> Self {
        let mut emitters = Self::none(aperture.element);
        for face in &aperture.faces {
            for column in face.among(&aperture.driven) {
                let u = excitation[column] * (aperture.element.strength * face.gain);
                if u != Complex64::ZERO {
                    let n = aperture.driven[column] - face.first;
                    let axes = [face.layout.normal(n), face.layout.aside(n)]
                        .map(|direction| face.pose.world_direction(direction));
                    emitters.push(face.pose.world(face.layout.positions[n]), axes, Complex64::I * u);
                }
            }
        }
        emitters.pad();
        emitters
    }

    /// Pressure (Pa) and its slopes along the scene's axes (Pa/m) at a point; `None` for exact pistons, which have no closed
    /// form.
    pub fn sum(&self, point: DVec3) -> Option<[Complex64; 4]> {
        Some(Isa::best().run(Sum(self.heard(point, self.pattern()?))))
    }

    /// Without any source.
    pub(super) fn none(element: Element) -> Self {
        Self {
            element,
            places: Default::default(),
            normals: Default::default(),
            asides: Default::default(),
            played: Default::default(),
        }
    }

    /// Adds a source with a normal and an x axis.
    pub(super) fn push(&mut self, place: DVec3, [normal, aside]: [DVec3; 2], played: Complex64) {
        self.places.iter_mut().zip(place.to_array()).for_each(|(all, value)| all.push(value));
        self.normals.iter_mut().zip(normal.to_array()).for_each(|(all, value)| all.push(value));
        self.asides.iter_mut().zip(aside.to_array()).for_each(|(all, value)| all.push(value));
        self.played.iter_mut().zip([played.re, played.im]).for_each(|(all, value)| all.push(value));
    }

    pub(super) fn pad(&mut self) {
        let room = self.places[0].len().next_multiple_of(LANES);
        for values in self.places.iter_mut().chain(&mut self.normals).chain(&mut self.asides) {
            values.resize(room, values.last().copied().unwrap_or(0.0));
        }
        self.played.iter_mut().for_each(|values| values.resize(room, 0.0));
    }

    /// Place of a source, its normal and its x axis.
    pub(super) fn source(&self, n: usize) -> (DVec3, [DVec3; 2]) {
        let at = |values: &[Vec<f64>; 3]| DVec3::from_array([0, 1, 2].map(|axis| values[axis][n]));
        (at(&self.places), [at(&self.normals), at(&self.asides)])
    }

    /// The waves of all sources at a point, each for itself; `false` for exact pistons, which have no closed form.
    pub(super) fn waves(&self, point: DVec3, waves: &mut Waves) -> bool {
        let Some(pattern) = self.pattern() else { return false };
        waves.0.iter_mut().flatten().for_each(|values| values.resize(self.places[0].len(), 0.0));
        Isa::best().run(Each { heard: self.heard(point, pattern), waves });
        true
    }

    fn pattern(&self) -> Option<Pattern> {
        match self.element.radiator() {
            Radiator::Monopole => Some(Pattern::Even),
            Radiator::Piston(radius) => {
                Some(Pattern::Piston { ka2: (self.element.wavenumber * radius).powi(2) })
            }
            Radiator::Rectangle(_) | Radiator::Cosine(_) | Radiator::Measured => Some(Pattern::Own),
            Radiator::Disk(_) => None,
        }
    }

    fn heard(&self, point: DVec3, pattern: Pattern) -> Heard<'_> {
        Heard { emitters: self, point, pattern }
    }
}

/// The directivity of elements.
#[derive(Clone, Copy)]
enum Pattern {
    Even,
    /// 2 J1(x)/x with x² = (ka)² sin²θ.
    Piston {
        ka2: f64,
    },
    /// [`Element::pattern`], element by element.
    Own,
}

/// The sources heard at a point.
#[derive(Clone, Copy)]
struct Heard<'a> {
    emitters: &'a Emitters,
    point: DVec3,
    pattern: Pattern,
}

/// The waves of a block of sources at a point, real and imaginary parts: the pressure and its slopes along the scene's axes.
type Block = [[Lanes; 4]; 2];

impl Heard<'_> {
    fn blocks(&self) -> usize {
        self.emitters.places[0].len() / LANES
    }

    #[inline(always)]
    fn block<I: Instructions>(&self, block: usize) -> Block {
        let Self { emitters, point, pattern } = *self;
        let Element { wavenumber, attenuation, .. } = emitters.element;
        let places = axes!(A => block_of(&emitters.places[A], block));
        let n = axes!(A => *block_of(&emitters.normals[A], block));
        let played = [*block_of(&emitters.played[0], block), *block_of(&emitters.played[1], block)];
        let d = axes!(A => lanes::<LANES>(|i| point[A] - places[A][i]));
        let h = dot(&d, &n);
        let heard = lanes::<LANES>(|i| if h[i] >= -NEAREST { 1.0 } else { 0.0 });
        let up = lanes::<LANES>(|i| (NEAREST - h[i]).max(0.0));
        let d = axes!(A => lanes::<LANES>(|i| d[A][i] + up[i] * n[A][i]));
        let h = lanes::<LANES>(|i| h[i] + up[i]);
        let q = dot(&d, &d);
        let r = lanes::<LANES>(|i| q[i].sqrt());
        let inverse = lanes::<LANES>(|i| 1.0 / q[i]);
        let decayed = match attenuation {
            0.0 => [1.0; LANES],
            _ => decay::<I>(&lanes(|i| attenuation * r[i])),
        };
        // e^{-jkr}/r times the drive.
        let half_turns = lanes::<LANES>(|i| -r[i] * (wavenumber / PI));
        let rounded = lanes::<LANES>(|i| half_turns[i] + ROUNDER);
        let f = lanes::<LANES>(|i| half_turns[i] - (rounded[i] - ROUNDER));
        let f2 = lanes::<LANES>(|i| f[i] * f[i]);
        let size = lanes::<LANES>(|i| heard[i] * decayed[i] * r[i] * inverse[i]);
        let size = lanes::<LANES>(|i| f64::from_bits(size[i].to_bits() ^ (rounded[i].to_bits() << 63)));
        let (c, s) = (horner::<I, 7>(&COSINE, &f2), horner::<I, 7>(&SINE, &f2));
        let s = lanes::<LANES>(|i| f[i] * s[i]);
        let part = lanes::<LANES>(|i| size[i] * s[i]);
        let turn = [lanes::<LANES>(|i| size[i] - part[i] * s[i]), lanes::<LANES>(|i| part[i] * c[i])];
        let wave = times(&turn, &played);
        // The derivative of e^{-γr}/r by Q over its value, γ = α + jk: 1/r d/dr.
        let g1 =
            [lanes(|i| -(attenuation * r[i] + 1.0) * inverse[i]), lanes(|i| -wavenumber * r[i] * inverse[i])];
        let sloped = times(&wave, &g1);
        let pattern = match pattern {
            Pattern::Even => Wave::EVEN,
            Pattern::Piston { ka2 } => Wave::piston::<I>(ka2, &h, &inverse),
            Pattern::Own => return self.own(block, (&d, &n), &wave, &sloped),
        };
        [0, 1].map(|part: usize| {
            let wave = pattern.product(&wave[part], &sloped[part]);
            let [x, y, z] = axes!(A => lanes::<LANES>(|l| wave.q[l] * d[A][l] + wave.h[l] * n[A][l]));
            [wave.value, x, y, z]
        })
    }

    /// Elements of any directivity D(d/r), given their ways and normals, the waves of points and these' derivatives by Q:
    /// ∇(SD) = S' D d + S/r (g - (g·d) d/r²), g the derivatives of D.
    #[inline(never)]
    fn own(
        &self,
        block: usize,
        (ways, normals): (&[Lanes; 3], &[Lanes; 3]),
        wave: &[Lanes; 2],
        sloped: &[Lanes; 2],
    ) -> Block {
        let mut all = [[[0.0; LANES]; 4]; 2];
        for lane in 0..LANES {
            let at = |values: &[Lanes; 3]| DVec3::from_array(values.map(|values| values[lane]));
            let (way, normal) = (at(ways), at(normals));
            let aside =
                DVec3::from_array([0, 1, 2].map(|axis| self.emitters.asides[axis][block * LANES + lane]));
            let axes = [aside, normal.cross(aside), normal];
            let r = way.length();
            let towards = DVec3::from_array(axes.map(|axis| axis.dot(way) / r));
            let pattern = self.emitters.element.pattern(towards);
            let [wave, sloped] = [wave, sloped].map(|it| Complex64::new(it[0][lane], it[1][lane]));
            let across: Complex64 = (0..3).map(|axis| pattern.slopes[axis] * towards[axis]).sum();
            let along = sloped * pattern.value - wave * across / (r * r);
            let mut values = [wave * pattern.value, along * way.x, along * way.y, along * way.z];
            for (slope, axis) in pattern.slopes.iter().zip(axes) {
                for (value, part) in values[1..].iter_mut().zip(axis.to_array()) {
                    *value += wave * slope * (part / r);
                }
            }
            for (part, value) in values.into_iter().enumerate() {
                (all[0][part][lane], all[1][part][lane]) = (value.re, value.im);
            }
        }
        all
    }
}

/// Waves of single sources at a point: the pressure (Pa) and its slopes along the scene's axes (Pa/m), of each the
/// real and the imaginary parts.
#[derive(Clone, Debug, Default)]
pub(super) struct Waves(pub(super) [[Vec<f64>; 2]; 4]);

struct Sum<'a>(Heard<'a>);

impl Kernel for Sum<'_> {
    type Output = [Complex64; 4];

    #[inline(always)]
    fn run<I: Instructions>(self) -> [Complex64; 4] {
        let mut sums = [[[0.0; LANES]; 4]; 2];
        for block in 0..self.0.blocks() {
            for (sums, wave) in sums.iter_mut().zip(&self.0.block::<I>(block)) {
                for (sum, own) in sums.iter_mut().zip(wave) {
                    *sum = lanes(|l| sum[l] + own[l]);
                }
            }
        }
        std::array::from_fn(|part| Complex64::new(total(&sums[0][part]), total(&sums[1][part])))
    }
}

struct Each<'a> {
    heard: Heard<'a>,
    waves: &'a mut Waves,
}

impl Kernel for Each<'_> {
    type Output = ();

    #[inline(always)]
    fn run<I: Instructions>(self) {
        for block in 0..self.heard.blocks() {
            let place = block * LANES..(block + 1) * LANES;
            for (part, wave) in self.heard.block::<I>(block).iter().enumerate() {
                for (to, values) in self.waves.0.iter_mut().zip(wave) {
                    to[part][place.clone()].copy_from_slice(values);
                }
            }
        }
    }
}

/// e^{-x} for x ≥ 0: a power of two, and a series of what is left of the exponent.
#[inline(always)]
fn decay<I: Instructions>(x: &Lanes) -> Lanes {
    /// Of the largest exponent left, ln 2/2: 4e-18 off.
    const TERMS: [f64; 14] = inverse_factorials();
    let x = lanes::<LANES>(|i| (-x[i]).max(-700.0));
    let rounded = lanes::<LANES>(|i| x[i] * std::f64::consts::LOG2_E + ROUNDER);
    let rest = lanes::<LANES>(|i| x[i] - (rounded[i] - ROUNDER) * std::f64::consts::LN_2);
    let series = horner::<I, 14>(&TERMS, &rest);
    // The integer is in the lowest bits of the rounded number.
    let power = lanes::<LANES>(|i| f64::from_bits((rounded[i].to_bits() << 52).wrapping_add(1023 << 52)));
    lanes(|i| series[i] * power[i])
}

#[inline(always)]
fn dot(a: &[Lanes; 3], b: &[Lanes; 3]) -> Lanes {
    lanes(|i| a[0][i] * b[0][i] + a[1][i] * b[1][i] + a[2][i] * b[2][i])
}

/// Product of complex numbers.
#[inline(always)]
fn times(a: &[Lanes; 2], b: &[Lanes; 2]) -> [Lanes; 2] {
    [lanes(|i| a[0][i] * b[0][i] - a[1][i] * b[1][i]), lanes(|i| a[0][i] * b[1][i] + a[1][i] * b[0][i])]
}

/// A real function of Q and h with its derivatives by both: the real or the imaginary part of a wave, or its
/// directivity D(w) with w = (ka)² (1 - h²/2Q).
struct Wave {
    value: Lanes,
    q: Lanes,
    h: Lanes,
}

impl Wave {
    const EVEN: Self = Self { value: [1.0; LANES], q: [0.0; LANES], h: [0.0; LANES] };

    #[inline(always)]
    fn piston<I: Instructions>(ka2: f64, h: &Lanes, i: &Lanes) -> Self {
        let sin2 = lanes::<LANES>(|l| (1.0 - h[l] * h[l] * i[l]).max(0.0));
        let w = lanes::<LANES>(|l| ka2 * sin2[l]);
        let [value, slope] = bessel::directivity::<I>(ka2, &w);
        let w_h = lanes::<LANES>(|l| -2.0 * ka2 * h[l] * i[l]);
        Self { value, q: lanes(|l| -slope[l] * w_h[l] * h[l] * i[l]), h: lanes(|l| slope[l] * w_h[l]) }
    }

    /// The product with an isotropic part of a wave, given with its derivative by Q.
    #[inline(always)]
    fn product(&self, value: &Lanes, slope: &Lanes) -> Self {
        Self {
            value: lanes(|l| self.value[l] * value[l]),
            q: lanes(|l| self.q[l] * value[l] + self.value[l] * slope[l]),
            h: lanes(|l| self.h[l] * value[l]),
        }
    }
}

/// Eight values of many.
#[inline(always)]
fn block_of(values: &[f64], block: usize) -> &Lanes {
    &values.as_chunks().0[block]
}
