//! Elements and their images with their drives, and the pressure at a point with its derivatives, in f64.
//!
//! With d the vector from an element to the point, h its height along the element's normal n and Q = d·d/2, the wave
//! is a function P(Q, h), whose derivatives are closed forms; ∂ᵢP = P_Q dᵢ + P_h nᵢ, and so on with ∂ᵢdⱼ = δᵢⱼ.

use std::f64::consts::PI;

use glam::DVec3;
use num_complex::Complex64;

use crate::acoustics::derivatives::{COUNT, Derivatives, PAIRS, SECOND, TRIPLES};
use crate::acoustics::element::{NEAREST, Radiator};
use crate::acoustics::row::{COSINE, LANES, ROUNDER, SINE, horner};
use crate::acoustics::{aperture::Aperture, bessel, disk, element::Element};
use crate::simd::{Instructions, Isa, Kernel, lanes, total};

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

/// The same for each pair of axes, in the order of `PAIRS`.
macro_rules! pairs {
    ($i:ident, $j:ident => $value:expr) => {
        [
            pairs!($i = 0, $j = 0, $value),
            pairs!($i = 0, $j = 1, $value),
            pairs!($i = 0, $j = 2, $value),
            pairs!($i = 1, $j = 1, $value),
            pairs!($i = 1, $j = 2, $value),
            pairs!($i = 2, $j = 2, $value),
        ]
    };
    ($i:ident = $first:literal, $j:ident = $second:literal, $value:expr) => {{
        const $i: usize = $first;
        const $j: usize = $second;
        $value
    }};
}

/// A statement for each of the third derivatives, in the order of `TRIPLES`.
macro_rules! triples {
    ($at:ident, $i:ident, $j:ident, $k:ident => $body:expr) => {
        triples!($at = 0, $i, $j, $k, $body);
        triples!($at = 1, $i, $j, $k, $body);
        triples!($at = 2, $i, $j, $k, $body);
        triples!($at = 3, $i, $j, $k, $body);
        triples!($at = 4, $i, $j, $k, $body);
        triples!($at = 5, $i, $j, $k, $body);
        triples!($at = 6, $i, $j, $k, $body);
        triples!($at = 7, $i, $j, $k, $body);
        triples!($at = 8, $i, $j, $k, $body);
        triples!($at = 9, $i, $j, $k, $body);
    };
    ($at:ident = $number:literal, $i:ident, $j:ident, $k:ident, $body:expr) => {{
        const $at: usize = $number;
        const $i: usize = TRIPLES[$number][0];
        const $j: usize = TRIPLES[$number][1];
        const $k: usize = TRIPLES[$number][2];
        $body
    }};
}

/// All sources, in the scene's coordinates.
#[derive(Clone, Debug)]
pub struct Emitters {
    element: Element,
    /// m, padded to whole blocks with the last of them.
    places: [Vec<f64>; 3],
    /// Unit vectors.
    normals: [Vec<f64>; 3],
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
                    let normal = face.pose.world_direction(face.layout.normal(n));
                    emitters.push(face.pose.world(face.layout.positions[n]), normal, Complex64::I * u);
                }
            }
        }
        emitters.pad();
        emitters
    }

    /// The derivatives at a point of every driven element alone at full drive, for weighted sums.
    pub fn columns(aperture: &Aperture, point: DVec3) -> Vec<Derivatives> {
        let mut columns = vec![Derivatives::default(); aperture.driven.len()];
        for face in &aperture.faces {
            for column in face.among(&aperture.driven) {
                let n = aperture.driven[column] - face.first;
                let normal = face.pose.world_direction(face.layout.normal(n));
                let mut alone = Self::none(aperture.element);
                let played = Complex64::I * (aperture.element.strength * face.gain);
                alone.push(face.pose.world(face.layout.positions[n]), normal, played);
                alone.pad();
                columns[column] += alone.derivatives(point);
            }
        }
        columns
    }

    /// Without any source.
    pub(super) fn none(element: Element) -> Self {
        Self { element, places: Default::default(), normals: Default::default(), played: Default::default() }
    }

    pub(super) fn push(&mut self, place: DVec3, normal: DVec3, played: Complex64) {
        self.places.iter_mut().zip(place.to_array()).for_each(|(all, value)| all.push(value));
        self.normals.iter_mut().zip(normal.to_array()).for_each(|(all, value)| all.push(value));
        self.played.iter_mut().zip([played.re, played.im]).for_each(|(all, value)| all.push(value));
    }

    pub(super) fn pad(&mut self) {
        let room = self.places[0].len().next_multiple_of(LANES);
        for values in self.places.iter_mut().chain(&mut self.normals) {
            values.resize(room, values.last().copied().unwrap_or(0.0));
        }
        self.played.iter_mut().for_each(|values| values.resize(room, 0.0));
    }

    /// The pressure and its derivatives at a point, m.
    pub fn derivatives(&self, point: DVec3) -> Derivatives {
        self.up_to::<3>(point)
    }

    /// The same without those of the third order, in less time.
    pub fn to_second_order(&self, point: DVec3) -> Derivatives {
        self.up_to::<2>(point)
    }

    fn up_to<const ORDER: usize>(&self, point: DVec3) -> Derivatives {
        let sum = |pattern| Isa::best().run(Sum::<ORDER>(self.heard(point, pattern)));
        match self.element.radiator() {
            Radiator::Monopole => sum(Pattern::Even),
            Radiator::Piston(radius) => sum(self.piston(radius)),
            Radiator::Disk(radius) => self.disks::<ORDER>(radius, point),
        }
    }

    /// Place and normal of a source.
    pub(super) fn source(&self, n: usize) -> (DVec3, DVec3) {
        let at = |values: &[Vec<f64>; 3]| DVec3::from_array([0, 1, 2].map(|axis| values[axis][n]));
        (at(&self.places), at(&self.normals))
    }

    /// The waves of all sources at a point, each for itself; `false` for exact pistons, which have no closed form.
    pub(super) fn waves(&self, point: DVec3, waves: &mut Waves) -> bool {
        let pattern = match self.element.radiator() {
            Radiator::Monopole => Pattern::Even,
            Radiator::Piston(radius) => self.piston(radius),
            Radiator::Disk(_) => return false,
        };
        waves.0.iter_mut().flatten().for_each(|values| values.resize(self.places[0].len(), 0.0));
        Isa::best().run(Each { heard: self.heard(point, pattern), waves });
        true
    }

    fn piston(&self, radius: f64) -> Pattern {
        Pattern::Piston { ka2: (self.element.wavenumber * radius).powi(2) }
    }

    fn heard(&self, point: DVec3, pattern: Pattern) -> Heard<'_> {
        Heard { emitters: self, point, pattern, attenuation: self.element.attenuation }
    }

    /// Derivatives of exact pistons: each a sum of points on its disk, and absorption that counts from its centre.
    fn disks<const ORDER: usize>(&self, radius: f64, point: DVec3) -> Derivatives {
        let Element { wavenumber, attenuation, .. } = self.element;
        let mut sum = Derivatives::default();
        for n in 0..self.places[0].len() {
            let played = Complex64::new(self.played[0][n], self.played[1][n]);
            let (centre, normal) = self.source(n);
            let way = point - centre;
            let height = normal.dot(way);
            if played == Complex64::ZERO || height < -NEAREST {
                continue;
            }
            let mut nodes = Self::none(self.element);
            let across = (way.length_squared() - height * height).max(0.0).sqrt();
            let (x, y) = normal.any_orthonormal_pair();
            // In the disk's own coordinates: its plane's normal and the point's way may be any.
            for node in disk::nodes(wavenumber * radius, across / radius, height / radius) {
                let place = centre + (x * node.at[0] + y * node.at[1]) * radius;
                nodes.push(place, normal, played * node.weight);
            }
            nodes.pad();
            let heard = Heard { attenuation: 0.0, ..nodes.heard(point, Pattern::Even) };
            let wave = Isa::best().run(Sum::<ORDER>(heard));
            sum += if attenuation == 0.0 { wave } else { wave.times(&decay(way, attenuation)) };
        }
        sum
    }
}

/// e^{-αr} with its derivatives.
fn decay(way: DVec3, attenuation: f64) -> Derivatives {
    let r = way.length().max(NEAREST);
    let (a, i) = (attenuation, 1.0 / r);
    let value = (-a * r).exp();
    // By Q, which is 1/r times the derivative by r.
    let first = -a * i * value;
    let second = (a * a + a * i) * i * i * value;
    let third = -(a * a * a + 3.0 * a * a * i + 3.0 * a * i * i) * i * i * i * value;
    let d = way.to_array();
    let delta = |i: usize, j: usize| f64::from(u8::from(i == j));
    let mut all = Derivatives::default();
    all.0[0] = value.into();
    (0..3).for_each(|i| all.0[1 + i] = (first * d[i]).into());
    for (&[i, j], to) in PAIRS.iter().zip(&mut all.0[4..]) {
        *to = (second * d[i] * d[j] + first * delta(i, j)).into();
    }
    for (&[i, j, k], to) in TRIPLES.iter().zip(&mut all.0[10..]) {
        let traces = delta(i, j) * d[k] + delta(i, k) * d[j] + delta(j, k) * d[i];
        *to = (third * d[i] * d[j] * d[k] + second * traces).into();
    }
    all
}

/// The directivity of elements.
#[derive(Clone, Copy)]
enum Pattern {
    Even,
    /// 2 J1(x)/x with x² = (ka)² sin²θ.
    Piston {
        ka2: f64,
    },
}

/// The sources heard at a point.
#[derive(Clone, Copy)]
struct Heard<'a> {
    emitters: &'a Emitters,
    point: DVec3,
    pattern: Pattern,
    attenuation: f64,
}

/// The waves of a block of sources at a point, real and imaginary parts, with the ways and the normals.
struct Block {
    waves: [Wave; 2],
    ways: [Lanes; 3],
    normals: [Lanes; 3],
}

impl Heard<'_> {
    fn blocks(&self) -> usize {
        self.emitters.places[0].len() / LANES
    }

    #[inline(always)]
    fn block<I: Instructions>(&self, block: usize) -> Block {
        let Self { emitters, point, pattern, attenuation } = *self;
        let wavenumber = emitters.element.wavenumber;
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
            _ => lanes(|i| (-attenuation * r[i]).exp()),
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
        // Derivatives of e^{-γr}/r by Q over its value, γ = α + jk: (1/r d/dr)ⁿ.
        let x = lanes::<LANES>(|i| attenuation * r[i]);
        let y = lanes::<LANES>(|i| wavenumber * r[i]);
        let i2 = lanes::<LANES>(|i| inverse[i] * inverse[i]);
        let i3 = lanes::<LANES>(|i| i2[i] * inverse[i]);
        let (x2, y2) = (lanes::<LANES>(|i| x[i] * x[i]), lanes::<LANES>(|i| y[i] * y[i]));
        let g1 = [lanes(|i| -(x[i] + 1.0) * inverse[i]), lanes(|i| -y[i] * inverse[i])];
        let g2 = [
            lanes(|i| (x2[i] - y2[i] + 3.0 * x[i] + 3.0) * i2[i]),
            lanes(|i| (2.0 * x[i] + 3.0) * y[i] * i2[i]),
        ];
        let g3 = [
            lanes(|i| -(x[i] * (x2[i] - 3.0 * y2[i] + 15.0) + 6.0 * (x2[i] - y2[i]) + 15.0) * i3[i]),
            lanes(|i| -y[i] * (3.0 * x2[i] - y2[i] + 12.0 * x[i] + 15.0) * i3[i]),
        ];
        let g = [wave, times(&wave, &g1), times(&wave, &g2), times(&wave, &g3)];
        let pattern = match pattern {
            Pattern::Even => Directivity::EVEN,
            Pattern::Piston { ka2 } => Directivity::piston::<I>(ka2, &h, &inverse),
        };
        let re = pattern.product([&g[0][0], &g[1][0], &g[2][0], &g[3][0]]);
        let im = pattern.product([&g[0][1], &g[1][1], &g[2][1], &g[3][1]]);
        Block { waves: [re, im], ways: d, normals: n }
    }
}

struct Sum<'a, const ORDER: usize>(Heard<'a>);

impl<const ORDER: usize> Kernel for Sum<'_, ORDER> {
    type Output = Derivatives;

    #[inline(always)]
    fn run<I: Instructions>(self) -> Derivatives {
        let mut sums = [[[0.0; LANES]; COUNT]; 2];
        for block in 0..self.0.blocks() {
            let Block { waves: [re, im], ways, normals } = self.0.block::<I>(block);
            let vectors = Vectors::new(&ways, &normals);
            add::<ORDER>(&mut sums[0], &re, &vectors);
            add::<ORDER>(&mut sums[1], &im, &vectors);
        }
        Derivatives(std::array::from_fn(|at| Complex64::new(total(&sums[0][at]), total(&sums[1][at]))))
    }
}

/// Waves of single sources at a point: the pressure (Pa) and its slopes along the scene's axes (Pa/m), of each the
/// real and the imaginary parts.
#[derive(Clone, Debug, Default)]
pub(super) struct Waves(pub(super) [[Vec<f64>; 2]; 4]);

struct Each<'a> {
    heard: Heard<'a>,
    waves: &'a mut Waves,
}

impl Kernel for Each<'_> {
    type Output = ();

    #[inline(always)]
    fn run<I: Instructions>(self) {
        for block in 0..self.heard.blocks() {
            let Block { waves, ways: d, normals: n } = self.heard.block::<I>(block);
            let place = block * LANES..(block + 1) * LANES;
            for (part, wave) in waves.iter().enumerate() {
                let [x, y, z] = axes!(I => lanes::<LANES>(|l| wave.q[l] * d[I][l] + wave.h[l] * n[I][l]));
                for (to, values) in self.waves.0.iter_mut().zip([wave.value, x, y, z]) {
                    to[part][place.clone()].copy_from_slice(&values);
                }
            }
        }
    }
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

/// A function of Q and h with its derivatives by both: D(w) with w = (ka)² (1 - h²/2Q).
struct Directivity {
    value: Lanes,
    q: Lanes,
    qq: Lanes,
    qqq: Lanes,
    h: Lanes,
    hh: Lanes,
    hhh: Lanes,
    qh: Lanes,
    qqh: Lanes,
    qhh: Lanes,
}

/// The real or the imaginary part of a wave, as a function of Q and h, with its derivatives.
type Wave = Directivity;

impl Directivity {
    const NONE: Lanes = [0.0; LANES];
    const EVEN: Self = Self {
        value: [1.0; LANES],
        q: Self::NONE,
        qq: Self::NONE,
        qqq: Self::NONE,
        h: Self::NONE,
        hh: Self::NONE,
        hhh: Self::NONE,
        qh: Self::NONE,
        qqh: Self::NONE,
        qhh: Self::NONE,
    };

    #[inline(always)]
    fn piston<I: Instructions>(ka2: f64, h: &Lanes, i: &Lanes) -> Self {
        let i2 = lanes::<LANES>(|l| i[l] * i[l]);
        let h2 = lanes::<LANES>(|l| h[l] * h[l]);
        let sin2 = lanes::<LANES>(|l| (1.0 - h2[l] * i[l]).max(0.0));
        let w = lanes::<LANES>(|l| ka2 * sin2[l]);
        let [d0, d1, d2, d3] = bessel::directivity::<I>(ka2, &w);
        let w_h = lanes::<LANES>(|l| -2.0 * ka2 * h[l] * i[l]);
        let w_hh = lanes::<LANES>(|l| -2.0 * ka2 * i[l]);
        let w_q = lanes::<LANES>(|l| 2.0 * ka2 * h2[l] * i2[l]);
        let w_qh = lanes::<LANES>(|l| 4.0 * ka2 * h[l] * i2[l]);
        let w_qhh = lanes::<LANES>(|l| 4.0 * ka2 * i2[l]);
        let w_qq = lanes::<LANES>(|l| -4.0 * w_q[l] * i[l]);
        let w_qqh = lanes::<LANES>(|l| -4.0 * w_qh[l] * i[l]);
        let w_qqq = lanes::<LANES>(|l| -6.0 * w_qq[l] * i[l]);
        Self {
            value: d0,
            q: lanes(|l| d1[l] * w_q[l]),
            qq: lanes(|l| d2[l] * w_q[l] * w_q[l] + d1[l] * w_qq[l]),
            qqq: lanes(|l| w_q[l] * (d3[l] * w_q[l] * w_q[l] + 3.0 * d2[l] * w_qq[l]) + d1[l] * w_qqq[l]),
            h: lanes(|l| d1[l] * w_h[l]),
            hh: lanes(|l| d2[l] * w_h[l] * w_h[l] + d1[l] * w_hh[l]),
            hhh: lanes(|l| w_h[l] * (d3[l] * w_h[l] * w_h[l] + 3.0 * d2[l] * w_hh[l])),
            qh: lanes(|l| d2[l] * w_q[l] * w_h[l] + d1[l] * w_qh[l]),
            qqh: lanes(|l| {
                d3[l] * w_q[l] * w_q[l] * w_h[l]
                    + d2[l] * (2.0 * w_q[l] * w_qh[l] + w_qq[l] * w_h[l])
                    + d1[l] * w_qqh[l]
            }),
            qhh: lanes(|l| {
                d3[l] * w_q[l] * w_h[l] * w_h[l]
                    + d2[l] * (2.0 * w_qh[l] * w_h[l] + w_q[l] * w_hh[l])
                    + d1[l] * w_qhh[l]
            }),
        }
    }

    /// The product with an isotropic part of a wave, given its derivatives by Q.
    #[inline(always)]
    fn product(&self, [g0, g1, g2, g3]: [&Lanes; 4]) -> Wave {
        let (d, own) = (&self.value, self);
        Wave {
            value: lanes(|l| d[l] * g0[l]),
            q: lanes(|l| own.q[l] * g0[l] + d[l] * g1[l]),
            qq: lanes(|l| own.qq[l] * g0[l] + 2.0 * own.q[l] * g1[l] + d[l] * g2[l]),
            qqq: lanes(|l| own.qqq[l] * g0[l] + 3.0 * (own.qq[l] * g1[l] + own.q[l] * g2[l]) + d[l] * g3[l]),
            h: lanes(|l| own.h[l] * g0[l]),
            hh: lanes(|l| own.hh[l] * g0[l]),
            hhh: lanes(|l| own.hhh[l] * g0[l]),
            qh: lanes(|l| own.qh[l] * g0[l] + own.h[l] * g1[l]),
            qqh: lanes(|l| own.qqh[l] * g0[l] + 2.0 * own.qh[l] * g1[l] + own.h[l] * g2[l]),
            qhh: lanes(|l| own.qhh[l] * g0[l] + own.hh[l] * g1[l]),
        }
    }
}

/// The ways d and the normals n of elements, and the symmetric products of two of them.
struct Vectors<'a> {
    d: &'a [Lanes; 3],
    n: &'a [Lanes; 3],
    dd: [Lanes; 6],
    dn: [Lanes; 6],
    nn: [Lanes; 6],
}

impl<'a> Vectors<'a> {
    #[inline(always)]
    fn new(d: &'a [Lanes; 3], n: &'a [Lanes; 3]) -> Self {
        Self {
            d,
            n,
            dd: pairs!(I, J => lanes::<LANES>(|l| d[I][l] * d[J][l])),
            dn: pairs!(I, J => lanes::<LANES>(|l| d[I][l] * n[J][l] + d[J][l] * n[I][l])),
            nn: pairs!(I, J => lanes::<LANES>(|l| n[I][l] * n[J][l])),
        }
    }
}

const fn delta(i: usize, j: usize) -> f64 {
    if i == j { 1.0 } else { 0.0 }
}

/// Adds a part of the wave's derivatives along the scene's axes.
#[inline(always)]
fn add<const ORDER: usize>(sums: &mut [Lanes; COUNT], p: &Wave, vectors: &Vectors<'_>) {
    let Vectors { d, n, dd, dn, nn } = vectors;
    sums[0] = lanes(|l| sums[0][l] + p.value[l]);
    axes!(I => sums[1 + I] = lanes(|l| sums[1 + I][l] + p.q[l] * d[I][l] + p.h[l] * n[I][l]));
    pairs!(I, J => {
        const AT: usize = SECOND[I][J] - 4;
        sums[4 + AT] = lanes(|l| {
            sums[4 + AT][l]
                + (p.qq[l] * dd[AT][l] + p.qh[l] * dn[AT][l])
                + (p.hh[l] * nn[AT][l] + delta(I, J) * p.q[l])
        });
    });
    if ORDER < 3 {
        return;
    }
    triples!(AT, I, J, K => {
        const IJ: usize = SECOND[I][J] - 4;
        let wave = lanes::<LANES>(|l| {
            (p.qqq[l] * dd[IJ][l] + p.qqh[l] * dn[IJ][l] + p.qhh[l] * nn[IJ][l]) * d[K][l]
                + (p.qqh[l] * dd[IJ][l] + p.qhh[l] * dn[IJ][l] + p.hhh[l] * nn[IJ][l]) * n[K][l]
        });
        let along = lanes::<LANES>(|l| delta(J, K) * d[I][l] + delta(I, K) * d[J][l] + delta(I, J) * d[K][l]);
        let across = lanes::<LANES>(|l| delta(J, K) * n[I][l] + delta(I, K) * n[J][l] + delta(I, J) * n[K][l]);
        sums[10 + AT] =
            lanes(|l| sums[10 + AT][l] + wave[l] + (p.qq[l] * along[l] + p.qh[l] * across[l]));
    });
}

/// Eight values of many.
#[inline(always)]
fn block_of(values: &[f64], block: usize) -> &Lanes {
    &values.as_chunks().0[block]
}

#[cfg(test)]
mod tests {
    use glam::dvec3;

    use super::*;

    #[test]
    fn decay_has_the_derivatives_of_its_value() {
        const STEP: f64 = 1e-5;
        // Dense enough for every term to count: α = 4.2/r.
        let (way, attenuation) = (dvec3(0.03, -0.05, 0.04), 60.0);
        let all = decay(way, attenuation);
        assert!((all.0[0].re - (-attenuation * way.length()).exp()).abs() < 1e-15);
        let of_axes = |axes: &mut [usize]| -> usize {
            axes.sort_unstable();
            match *axes {
                [i] => 1 + i,
                [i, j] => SECOND[i][j],
                _ => 10 + TRIPLES.iter().position(|triple| triple[..] == *axes).unwrap(),
            }
        };
        for axis in 0..3 {
            let step = DVec3::AXES[axis] * STEP;
            let [low, high] = [-step, step].map(|by| decay(way + by, attenuation));
            let check = |at: usize, axes: &mut [usize]| {
                let slope = (high.0[at].re - low.0[at].re) / (2.0 * STEP);
                let largest = attenuation.powi(axes.len() as i32) * all.0[0].re;
                let own = all.0[of_axes(axes)].re;
                assert!((own - slope).abs() < 1e-5 * largest, "{axes:?}: {own}, not {slope}");
            };
            check(0, &mut [axis]);
            (0..3).for_each(|i| check(1 + i, &mut [i, axis]));
            PAIRS.iter().enumerate().for_each(|(pair, &[i, j])| check(4 + pair, &mut [i, j, axis]));
        }
    }
}
