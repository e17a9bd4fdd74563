//! The quantities of a field. Each is declared once: its parts of the sound, its formula in Rust and in WGSL, unit,
//! range, and names.
//!
//! A formula maps the sound of one drive at one point to one real number. The numbers of several drives are
//! averaged; RMS values take the root of that mean, a liquid responds to it, and of a vector the length of the mean
//! is taken.
//!
//! Menus, arguments, legends, colour maps, contour lines and both evaluators use the declaration, so a new quantity
//! is one more declaration (`docs/adding-a-quantity.md`). Three have no formula: potential and force of a bead (`of_bead`)
//! need partial waves (`stages::force`), and the second harmonic (`of_volume`) the sound of all the air before the array
//! (`stages::harmonic`).

use std::ops::{Mul, Sub};

use num_complex::Complex;

use crate::field::harmonic::TOLERANCE;
pub use crate::field::sound::{ALONG, Constants, NORMAL, PRESSURE, Part, Sound, Sounds, narrow};
pub use crate::field::unit::Unit;
use crate::rounding;
use crate::scene::Scene;
use crate::simd::{Instructions, Isa, Kernel};

/// Error of maps with bodies that is left, relative to the peak: within an edge of a surface its triangles show, which
/// samples do not resolve, and which the sound of the body does not have.
pub(crate) const OF_BODIES: f64 = 1e-2;

/// The kind of range of values, which determines their colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Range {
    /// Zero to the largest value.
    Amount,
    /// Minus the largest magnitude to the largest.
    Signed,
    /// Once round a turn.
    Cyclic,
}

/// The norm behind the largest value and the error of a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Norm {
    /// The value is a norm of the sound, and its error the same norm of the sound's error.
    Value,
    /// |P| (Pa, peak).
    Pressure,
    /// The value itself: errors are differences of values, weighted by the pressure.
    Difference,
}

/// One quantity.
#[derive(Debug)]
pub struct Declaration {
    /// Name in files and arguments.
    pub name: &'static str,
    /// Former names, still accepted.
    pub aliases: &'static [&'static str],
    /// Title on buttons and legends.
    pub title: &'static str,
    /// Words within sentences.
    pub words: &'static str,
    /// A sentence of explanation.
    pub help: &'static str,
    pub unit: Unit,
    pub range: Range,
    pub norm: Norm,
    /// Bits of the [`Part`]s that the formula reads.
    #[doc(hidden)]
    pub parts: u8,
    /// The formula in Rust, for a run of points.
    pub(crate) formula: fn(Sounds<'_>, &Constants, &mut [f32]),
    /// The formula in f64, at one point.
    #[doc(hidden)]
    pub exact: fn(Sound<f64>, &Constants<f64>) -> f64,
    /// WGSL expression in `s` (a sound) and `c` (the constants).
    #[doc(hidden)]
    pub wgsl: &'static str,
    /// The vector whose length the formula is.
    #[doc(hidden)]
    pub flow: Option<Flow>,
    /// Quadratic in the sound: twice the bandwidth, and linear from there on, so that it may be formed at cells.
    pub is_square: bool,
    /// Several drives have a mean of it.
    pub has_mean: bool,
    /// The root is taken of the mean.
    pub is_root: bool,
    /// dB of a factor of ten.
    pub decibels: f64,
    /// Averaged over a motion and an envelope.
    pub is_slow: bool,
    /// Shown through the response of the liquid.
    pub of_liquid: bool,
    /// Shows the light refracted by the liquid's surface.
    pub of_light: bool,
    /// Potential or force of the scene's bead, by its partial waves instead of the formula.
    pub of_bead: bool,
    /// Depends on the moment, ωt.
    pub of_moment: bool,
    /// An integral over the air before the array, instead of a formula of the sound at a point.
    pub of_volume: bool,
    /// Shown through the motion of the skin on the plane.
    pub of_skin: bool,
}

/// The components of a vector.
#[derive(Clone, Copy, Debug)]
pub struct Flow {
    /// Added for a run of points.
    pub add: fn(Sounds<'_>, &Constants, &mut [[f32; 3]]),
    /// The formula in f64, at one point.
    pub exact: fn(Sound<f64>, &Constants<f64>) -> [f64; 3],
}

/// The mean flow of energy, ½ Re{P V*} (W/m²), along the plane's axes and its normal, of half of 1/(ρω).
#[inline(always)]
fn power<T: Copy + Mul<Output = T> + Sub<Output = T>>(s: &Sound<T>, half: T) -> [T; 3] {
    // In W/m² before it is squared, where f32 has as much room below as above.
    [s.x, s.y, s.n].map(|slope| half * (s.p.im * slope.re - s.p.re * slope.im))
}

/// Defaults of a declaration.
const USUAL: Declaration = Declaration {
    name: "",
    aliases: &[],
    title: "",
    words: "",
    help: "",
    unit: Unit::Pascal,
    range: Range::Amount,
    norm: Norm::Value,
    parts: PRESSURE,
    formula: |_, _, _| (),
    exact: |_, _| 0.0,
    wgsl: "",
    flow: None,
    is_square: false,
    has_mean: true,
    is_root: false,
    decibels: 20.0,
    is_slow: false,
    of_liquid: false,
    of_light: false,
    of_bead: false,
    of_moment: false,
    of_volume: false,
    of_skin: false,
};

macro_rules! quantities {
    ($($(#[$doc:meta])* $quantity:ident {
        parts: $parts:expr,
        formula: |$s:ident, $c:ident| $formula:expr,
        $($field:ident: $value:expr),* $(,)?
    })*) => {
        /// A quantity of a field.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Quantity {
            $($(#[$doc])* $quantity,)*
        }

        impl Quantity {
            pub const ALL: [Self; [$(stringify!($quantity)),*].len()] = [$(Self::$quantity),*];

            pub fn declaration(self) -> &'static Declaration {
                match self {
                    $(Self::$quantity => {
                        const DECLARATION: Declaration = Declaration {
                            parts: $parts,
                            formula: |sounds, constants, values| {
                                let at = |$s: Sound, $c: &Constants| -> f32 { $formula };
                                Isa::best().run(Along::<_, { $parts }> { sounds, constants, values, at });
                            },
                            exact: |$s: Sound<f64>, $c: &Constants<f64>| -> f64 { $formula },
                            $($field: $value,)*
                            ..USUAL
                        };
                        &DECLARATION
                    })*
                }
            }
        }
    };
}

quantities! {
    /// |P|/√2, Pa.
    Rms {
        parts: PRESSURE,
        formula: |s, _c| 0.5 * s.p.norm_sqr(),
        wgsl: "0.5 * dot(s.p, s.p)",
        name: "rms",
        title: "Pressure",
        words: "RMS pressure",
        help: "RMS pressure of the sound",
        is_square: true,
        is_root: true,
    }
    /// arg P, rad in (-π, π].
    Phase {
        parts: PRESSURE,
        // The angle of zero is 0, whatever the signs of its zeros.
        formula: |s, _c| s.p.im.atan2(if s.p == Complex::new(0.0, 0.0) { 1.0 } else { s.p.re }),
        wgsl: "atan2(s.p.y, select(s.p.x, 1.0, all(s.p == vec2f(0.0))))",
        name: "phase",
        title: "Phase",
        words: "phase",
        help: "Where in its period the sound is",
        unit: Unit::Radian,
        range: Range::Cyclic,
        norm: Norm::Pressure,
        has_mean: false,
    }
    /// Radiation pressure (Pa) on the plane as a rigid or a liquid surface, which reflects 99.9 % of the sound.
    ///
    /// On such a surface the incident pressure P doubles, and only the tangential velocity v remains. The mean of
    /// ⟨p²⟩/(2ρc²) - ρ⟨v²⟩/2 is then |P|²/(ρc²) - |∇P|²/(ρω²), ∇ taken along the surface. For a plane wave at the
    /// angle θ this is Langevin's 2⟨p²⟩cos²θ/(ρc²).
    Radiation {
        parts: PRESSURE | ALONG,
        formula: |s, c| c.of_pressure * s.p.norm_sqr() - c.of_gradient * (s.x.norm_sqr() + s.y.norm_sqr()),
        wgsl: "c.of_pressure * dot(s.p, s.p) - c.of_gradient * (dot(s.x, s.x) + dot(s.y, s.y))",
        name: "radiation",
        title: "Radiation",
        words: "radiation pressure",
        help: "The steady pressure of the sound on a surface that reflects it",
        range: Range::Signed,
        norm: Norm::Difference,
        is_square: true,
        decibels: 10.0,
        is_slow: true,
    }
    /// Surface depression (m, positive down) of the liquid at the plane under the radiation pressure.
    Depression {
        parts: PRESSURE | ALONG,
        formula: |s, c| c.of_pressure * s.p.norm_sqr() - c.of_gradient * (s.x.norm_sqr() + s.y.norm_sqr()),
        wgsl: "c.of_pressure * dot(s.p, s.p) - c.of_gradient * (dot(s.x, s.x) + dot(s.y, s.y))",
        name: "depression",
        aliases: &["dent"],
        title: "Depression",
        words: "surface depression",
        help: "How deep the sound presses the liquid whose surface the plane is",
        unit: Unit::Metre,
        norm: Norm::Difference,
        is_square: true,
        decibels: 10.0,
        is_slow: true,
        of_liquid: true,
    }
    /// Re{P e^{jωt}} at one moment, Pa.
    Instantaneous {
        parts: PRESSURE,
        formula: |s, c| s.p.re * c.turn.re - s.p.im * c.turn.im,
        wgsl: "s.p.x * c.turn.x - s.p.y * c.turn.y",
        name: "instantaneous",
        title: "Instantaneous",
        words: "instantaneous pressure",
        help: "The pressure at one moment: the waves as they run, slowed down",
        range: Range::Signed,
        norm: Norm::Pressure,
        has_mean: false,
        of_moment: true,
    }
    /// Magnitude of the mean flow of energy, W/m²: |½ Re{P V*}| with V = j∇P/(ρω), the vectors of several drives averaged.
    Intensity {
        parts: PRESSURE | ALONG | NORMAL,
        formula: |s, c| {
            let [x, y, n] = power(&s, 0.5 * c.of_velocity);
            (x * x + y * y + n * n).sqrt()
        },
        wgsl: "length(0.5 * c.of_velocity * (s.p.y * vec3f(s.x.x, s.y.x, s.n.x) - s.p.x * vec3f(s.x.y, s.y.y, s.n.y)))",
        flow: Some(Flow {
            add: |Sounds([p, x, y, n]), c, sums| {
                for (i, sum) in sums.iter_mut().enumerate() {
                    let sound = Sound { p: p[i], x: x[i], y: y[i], n: n[i] };
                    let power = power(&sound, 0.5 * c.of_velocity);
                    sum.iter_mut().zip(power).for_each(|(sum, power)| *sum += power);
                }
            },
            exact: |s, c| power(&s, 0.5 * c.of_velocity),
        }),
        name: "intensity",
        title: "Intensity",
        words: "acoustic intensity",
        help: "How much power the sound carries through a square metre, in whichever direction",
        unit: Unit::WattPerSquareMetre,
        norm: Norm::Difference,
        decibels: 10.0,
    }
    /// RMS particle velocity along the plane's normal, m/s: |∂P/∂n|/(√2 ρω).
    Velocity {
        parts: NORMAL,
        formula: |s, c| 0.5 * c.of_velocity * c.of_velocity * s.n.norm_sqr(),
        wgsl: "0.5 * c.of_velocity * c.of_velocity * dot(s.n, s.n)",
        name: "velocity",
        title: "Velocity",
        words: "RMS particle velocity",
        help: "RMS velocity of the air along the plane's normal",
        unit: Unit::MetrePerSecond,
        is_square: true,
        is_root: true,
    }
    /// Brightness of light on a screen, through the liquid at the plane or reflected by it; 1 is undisturbed.
    Caustic {
        parts: PRESSURE | ALONG,
        formula: |s, c| c.of_pressure * s.p.norm_sqr() - c.of_gradient * (s.x.norm_sqr() + s.y.norm_sqr()),
        wgsl: "c.of_pressure * dot(s.p, s.p) - c.of_gradient * (dot(s.x, s.x) + dot(s.y, s.y))",
        name: "caustic",
        title: "Caustic",
        words: "brightness",
        help: "How bright light is on a screen after the pressed surface of a liquid has bent it",
        unit: Unit::Undisturbed,
        norm: Norm::Difference,
        is_square: true,
        decibels: 10.0,
        is_slow: true,
        of_liquid: true,
        of_light: true,
    }
    /// Potential of the radiation force on the scene's bead, J: Gor'kov's, of any size.
    Gorkov {
        parts: PRESSURE,
        formula: |_s, _c| 0.0,
        wgsl: "0.0",
        name: "gorkov",
        title: "Potential",
        words: "Gor'kov potential",
        help: "Potential of the scene's bead: it is driven from high to low",
        unit: Unit::Joule,
        range: Range::Signed,
        decibels: 10.0,
        of_bead: true,
    }
    /// The radiation force on the scene's bead (N), its length: [`crate::force`].
    Force {
        parts: PRESSURE,
        formula: |_s, _c| 0.0,
        wgsl: "0.0",
        name: "force",
        title: "Bead force",
        words: "radiation force",
        help: "Force of the sound on the scene's bead, without its weight",
        unit: Unit::Newton,
        decibels: 10.0,
        of_bead: true,
    }
    /// RMS pressure (Pa) of the second harmonic, at twice the frequency: [`crate::field::harmonic`].
    Harmonic {
        parts: PRESSURE,
        formula: |_s, _c| 0.0,
        wgsl: "0.0",
        name: "harmonic",
        title: "Harmonic",
        words: "RMS pressure of the second harmonic",
        help: "RMS pressure at twice the frequency, which the loud sound makes on its way",
        of_volume: true,
    }
    /// RMS of the moving part of the skin's displacement (m) on the plane: [`crate::surface::skin`].
    Skin {
        parts: PRESSURE | ALONG,
        formula: |s, c| c.of_pressure * s.p.norm_sqr() - c.of_gradient * (s.x.norm_sqr() + s.y.norm_sqr()),
        wgsl: "c.of_pressure * dot(s.p, s.p) - c.of_gradient * (dot(s.x, s.x) + dot(s.y, s.y))",
        name: "skin",
        title: "Skin",
        words: "RMS displacement of the skin",
        help: "How far the sound moves the skin on the plane",
        unit: Unit::Metre,
        norm: Norm::Difference,
        is_square: true,
        is_slow: true,
        of_skin: true,
    }
    /// How far the skin's motion is above the threshold of feeling (dB), at every place by itself.
    Felt {
        parts: PRESSURE | ALONG,
        formula: |s, c| c.of_pressure * s.p.norm_sqr() - c.of_gradient * (s.x.norm_sqr() + s.y.norm_sqr()),
        wgsl: "c.of_pressure * dot(s.p, s.p) - c.of_gradient * (dot(s.x, s.x) + dot(s.y, s.y))",
        name: "felt",
        title: "Felt",
        words: "level over the threshold of feeling",
        help: "How strongly a hand on the plane feels the sound: above 0 dB it does, ± 15 dB",
        unit: Unit::Decibel,
        norm: Norm::Difference,
        is_square: true,
        is_slow: true,
        of_skin: true,
    }
    /// RMS particle velocity in all directions, m/s: |∇P|/(√2 ρω).
    Speed {
        parts: ALONG | NORMAL,
        formula: |s, c| {
            0.5 * c.of_velocity * c.of_velocity * (s.x.norm_sqr() + s.y.norm_sqr() + s.n.norm_sqr())
        },
        wgsl: "0.5 * c.of_velocity * c.of_velocity * (dot(s.x, s.x) + dot(s.y, s.y) + dot(s.n, s.n))",
        name: "speed",
        title: "Speed",
        words: "RMS particle velocity in all directions",
        help: "Modulus of the RMS velocity of the air, along and across the plane",
        unit: Unit::MetrePerSecond,
        is_square: true,
        is_root: true,
    }
}

/// The mean of a formula over drives at one point, in f64.
#[derive(Clone, Copy, Debug, Default)]
pub struct Mean {
    /// Sum of a vector; a scalar is the first component.
    sum: [f64; 3],
}

impl Mean {
    /// Adds the sound of one of `count` drives.
    pub fn add(
        &mut self,
        declaration: &Declaration,
        sound: Sound<f64>,
        constants: &Constants<f64>,
        count: usize,
    ) {
        let own = match declaration.flow {
            Some(flow) => (flow.exact)(sound, constants),
            None => [(declaration.exact)(sound, constants), 0.0, 0.0],
        };
        self.sum.iter_mut().zip(own).for_each(|(sum, own)| *sum += own / count as f64);
    }

    pub fn of(&self, declaration: &Declaration) -> f64 {
        let [x, y, n] = self.sum;
        if declaration.flow.is_some() { (x * x + y * y + n * n).sqrt() } else { x }
    }
}

impl Declaration {
    /// Whether it is a formula of the sound at a point.
    #[doc(hidden)]
    pub fn has_formula(&self) -> bool {
        !self.of_bead && !self.of_volume
    }

    /// The promised error of its maps on the plane of a scene, relative to their peak: an integral over the air has its own
    /// steps, and the triangles of bodies show.
    #[doc(hidden)]
    pub fn tolerance(&self, scene: &Scene) -> f64 {
        let of_plane = scene.plane.tolerance;
        match (self.of_volume, scene.bodies.is_empty()) {
            (true, _) => of_plane.max(TOLERANCE),
            (false, true) => of_plane,
            (false, false) => of_plane.max(OF_BODIES),
        }
    }

    /// Whether the scattered sound of elements that differ adds to it, point by point.
    pub(crate) fn has_scatter(&self) -> bool {
        self.is_square && !self.is_pressed()
    }

    /// Whether it is how a surface on the plane, a liquid's or the skin's, answers the radiation pressure.
    #[doc(hidden)]
    pub fn is_pressed(&self) -> bool {
        self.of_liquid || self.of_skin
    }

    /// Whether it is a level in dB.
    #[doc(hidden)]
    pub fn is_level(&self) -> bool {
        self.unit == Unit::Decibel
    }

    /// Whether it is a liquid's surface, which has a relief.
    pub fn is_surface(&self) -> bool {
        self.of_liquid && !self.of_light
    }
}

impl Quantity {
    /// The quantity with the formula and response of this one: itself, except for light and what is felt.
    pub(crate) fn pressed_by(self) -> Self {
        match (self.declaration().of_light, self.declaration().of_skin) {
            (true, _) => Self::Depression,
            (false, true) => Self::Skin,
            (false, false) => self,
        }
    }

    /// A value as people read it, with three figures and the unit that suits it.
    pub fn with_unit(self, value: f64) -> String {
        let (factor, unit) = self.declaration().unit.scaled(value.abs());
        format!("{} {unit}", figures(value * factor))
    }

    /// The same, rounded up to an upper bound.
    pub fn at_most(self, value: f64) -> String {
        let (factor, unit) = self.declaration().unit.scaled(value.abs());
        format!("{} {unit}", rounding::at_most(value * factor, decimals(value * factor)))
    }

    /// dB of a part of the largest value.
    pub fn decibels(self, part: f64) -> f64 {
        self.declaration().decibels * part.max(1e-12).log10()
    }

    /// Whether it has a logarithmic scale.
    pub fn is_amount(self) -> bool {
        self.declaration().range == Range::Amount
    }

    /// The value of a mean of the formula.
    pub fn value(self, mean: f32) -> f32 {
        if self.declaration().is_root { mean.clamp(0.0, f32::INFINITY).sqrt() } else { mean }
    }

    /// The same in f64.
    pub fn exact_value(self, mean: f64) -> f64 {
        if self.declaration().is_root { mean.clamp(0.0, f64::INFINITY).sqrt() } else { mean }
    }

    /// The value of a single sound.
    pub fn of(self, sound: Sound, constants: &Constants) -> f32 {
        let parts = [[sound.p], [sound.x], [sound.y], [sound.n]];
        let mut value = [0.0];
        (self.declaration().formula)(Sounds(parts.each_ref().map(|part| &part[..])), constants, &mut value);
        self.value(value[0])
    }
}

/// Three figures.
pub fn figures(value: f64) -> String {
    format!("{value:.*}", decimals(value))
}

/// Decimals of a value with three figures.
fn decimals(value: f64) -> usize {
    let size = value.abs();
    if size >= 99.95 || size == 0.0 {
        0
    } else if size >= 9.995 {
        1
    } else {
        2
    }
}

/// A formula at every point of a run.
struct Along<'a, F, const PARTS: u8> {
    sounds: Sounds<'a>,
    constants: &'a Constants,
    values: &'a mut [f32],
    at: F,
}

impl<F: Fn(Sound, &Constants) -> f32, const PARTS: u8> Kernel for Along<'_, F, PARTS> {
    type Output = ();

    #[inline(always)]
    fn run<I: Instructions>(self) {
        let Self { sounds: Sounds(parts), constants, values, at } = self;
        let count = values.len();
        // Of one length known to the compiler, which removes bounds checks.
        let [p, x, y, n] =
            std::array::from_fn(|i| if PARTS & 1 << i == 0 { parts[i] } else { &parts[i][..count] });
        for (i, value) in values.iter_mut().enumerate() {
            let mut sound = Sound::default();
            if PARTS & PRESSURE != 0 {
                sound.p = p[i];
            }
            if PARTS & ALONG != 0 {
                (sound.x, sound.y) = (x[i], y[i]);
            }
            if PARTS & NORMAL != 0 {
                sound.n = n[i];
            }
            *value = at(sound, constants);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use num_complex::{Complex32, Complex64};

    use super::*;
    use crate::acoustics::Air;
    use crate::scene::Medium;

    fn constants() -> (Air, Constants, f64) {
        let air = Air::new(&Medium::default(), 40e3);
        let wavenumber = TAU * 40e3 / air.sound_speed;
        (air, Constants::new(&air, wavenumber, 0.0).narrow(), wavenumber)
    }

    /// A plane wave of 100 Pa at an angle to the normal, in the plane's first direction.
    fn plane_wave(angle: f64) -> Sound {
        let (_, _, k) = constants();
        let p = Complex64::from_polar(100.0, 0.7);
        let slope = |along: f64| narrow(Complex64::new(0.0, -k * along) * p);
        Sound { p: narrow(p), x: slope(angle.sin()), y: Complex32::ZERO, n: slope(angle.cos()) }
    }

    #[test]
    fn only_a_depression_is_a_surface_and_decibels_are_of_amplitudes_or_of_squares() {
        for quantity in Quantity::ALL {
            assert_eq!(quantity.declaration().is_surface(), quantity == Quantity::Depression, "{quantity:?}");
        }
        assert!((Quantity::Rms.decibels(0.1) + 20.0).abs() < 1e-12);
        assert!((Quantity::Radiation.decibels(0.1) + 10.0).abs() < 1e-12);
        assert!((Quantity::Rms.decibels(0.0) + 240.0).abs() < 1e-9, "silence has a level");
    }

    #[test]
    fn a_plane_wave_has_the_intensity_velocity_and_radiation_pressure_of_the_textbook() {
        let (air, constants, _) = constants();
        let impedance = air.density * air.sound_speed;
        for angle in [0.0, 0.5, 1.2] {
            let sound = plane_wave(angle);
            let near = |quantity: Quantity, expected: f64| {
                let got = f64::from(quantity.of(sound, &constants));
                assert!(
                    (got / expected - 1.0).abs() < 1e-5,
                    "{quantity:?} at {angle}: {got}, not {expected}"
                );
            };
            near(Quantity::Rms, 100.0 / 2f64.sqrt());
            near(Quantity::Intensity, 100.0 * 100.0 / (2.0 * impedance));
            near(Quantity::Velocity, 100.0 / 2f64.sqrt() / impedance * angle.cos());
            near(Quantity::Speed, 100.0 / 2f64.sqrt() / impedance);
            near(Quantity::Radiation, 1e4 / (impedance * air.sound_speed) * angle.cos().powi(2));
            near(Quantity::Phase, 0.7);
            near(Quantity::Instantaneous, 100.0 * 0.7f64.cos());
        }
    }

    #[test]
    fn values_are_read_in_the_unit_that_suits_them() {
        for (quantity, value, words) in [
            (Quantity::Rms, 1234.0, "1.23 kPa"),
            (Quantity::Rms, 56.78, "56.8 Pa"),
            (Quantity::Rms, 99.95, "100 Pa"),
            (Quantity::Rms, 9.995, "10.0 Pa"),
            (Quantity::Depression, 2e-3, "2.00 mm"),
            (Quantity::Depression, 2e-5, "20.0 µm"),
            (Quantity::Phase, PI, "180 °"),
            (Quantity::Velocity, 0.5, "500 mm/s"),
            (Quantity::Intensity, 12.3, "12.3 W/m²"),
            (Quantity::Radiation, -3.0, "-3.00 Pa"),
            (Quantity::Gorkov, -2.34e-10, "-234 pJ"),
            (Quantity::Caustic, 2.5, "2.50 × undisturbed"),
        ] {
            assert_eq!(quantity.with_unit(value), words);
        }
    }
}
