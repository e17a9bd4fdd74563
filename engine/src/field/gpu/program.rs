//! The WGSL programs: their source files, constants written by Rust, and shared structs.
//!
//! `shaders/` holds WGSL only. The files of a program are concatenated behind the shared constants, so that each
//! polynomial, workgroup size and limit is defined once.
//!
//! | file | used in |
//! |---|---|
//! | `params`, `phase`, `field` | every field program |
//! | `piston`, `cosine`, `rectangle`, `exact_piston`, `curved` or `curved_cosine` | one of them: the wave of one element |
//! | `elements_uniform` or `elements_storage` | one of them: up to 1024 elements, or more |
//! | `whole` or `slices` | one of them: the sum over the elements in one invocation, or in several |
//! | `emission` | with `phase`, and `whole` or `slices`: the sound that surfaces scatter |
//! | `interpolation` | interpolation along one axis, a block of pixels per invocation: with `across` to values that are interpolated again, with `form` to final values |
//! | `direct` | with `form`: values where the sound is known at the pixels |
//! | `form` | the value of a sound, and the maximum; the formula of the quantity is prepended |
//! | `sound` | all three: the parts of the sound |
//! | `gather` | the sound at the probes and the peak, in one small buffer |
//! | `picture` | from values to colours, in a texture |
//! | `volume` | 3D pictures by ray marching, in a texture |
//!
//! No branch and no outermost loop of a program depends on uniforms alone: lavapipe specialises on uniform-only
//! branches at every dispatch and leaks the variants, so decisions fixed for a run are constants of the
//! [`Program`].

use bytemuck::{Pod, Zeroable};
use strum::VariantArray;

use crate::acoustics::element::NEAREST;
use crate::field::colouring::{SMALLEST, Scale};
use crate::field::gpu::tuning::{Tuning, WORKGROUP};
use crate::field::quantity::{Norm, PRESSURE, Part, Quantity};
use crate::field::sources::{COSINE, MOST_NODES, SINE};
use crate::field::volume::bricks::BRICK;
use crate::field::volume::{march, scenery};

/// Number of element vectors in a uniform buffer of 16 KiB, available on all adapters.
pub const UNIFORM_ELEMENTS: usize = 1024;

/// The same struct as in `shaders/params.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Params {
    pub directivity: [[f32; 4]; 6],
    pub second: [[f32; 4]; 6],
    pub decay: [[f32; 4]; 4],
    pub decay_scale: [f32; 2],
    pub turns_per_metre: f32,
    pub first_element: u32,
    pub last_element: u32,
    pub columns: u32,
    pub first: u32,
    pub count: u32,
    pub nodes: u32,
    pub radius: f32,
    pub piston_scale: f32,
    pub gain: f32,
}

/// The same struct as in `shaders/emission.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct EmissionParams {
    pub first_source: u32,
    pub last_source: u32,
    pub first: u32,
    pub count: u32,
    pub leak: f32,
    pub least: f32,
}

/// The same struct as in `shaders/interpolation.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct InterpolationParams {
    pub pixels: u32,
    pub lines: u32,
    pub span: u32,
    pub slopes: u32,
    pub tap_stride: u32,
    pub line_stride: u32,
    pub part_stride: u32,
    pub first_pixel: u32,
    pub pixel_stride: u32,
    pub pixel_line_stride: u32,
}

/// The same struct as in `shaders/form.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct FormParams {
    pub of_pressure: f32,
    pub of_gradient: f32,
    pub of_velocity: f32,
    pub factor: f32,
    pub turn: [f32; 2],
}

/// The same struct as in `shaders/direct.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct DirectParams {
    pub columns: u32,
    pub count: u32,
    pub first_pixel: u32,
}

/// The same struct as in `shaders/gather.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct GatherParams {
    pub probes: u32,
    pub all: u32,
    pub parts: u32,
    pub sloped: u32,
    pub taps: u32,
    pub tap_stride: u32,
    pub part_stride: u32,
}

/// The same struct as in `shaders/picture.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct PictureParams {
    pub width: u32,
    pub zero: f32,
    pub spread: f32,
    pub full: f32,
}

const PHASE: &str = include_str!("../../../../shaders/phase.wgsl");
const SOUND: &str = include_str!("../../../../shaders/sound.wgsl");
const FORM: &str = include_str!("../../../../shaders/form.wgsl");
const INTERPOLATION: &str = include_str!("../../../../shaders/interpolation.wgsl");

/// A program. Decisions fixed for a run are constants: lavapipe specialises on uniform-only branches at every
/// dispatch and leaks the variants.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Program {
    /// Sums over the elements.
    Field(FieldProgram),
    /// Sums over the sources of surfaces.
    Emission,
    /// Interpolation from samples to intermediate values, which are interpolated again.
    Across,
    /// Interpolation from these to values.
    Form(Quantity),
    /// Values from the sound at the pixels.
    FormDirect(Quantity),
    Gather,
    /// Colours from values.
    Picture(Scale),
    /// Space, ray by ray; with smooth edges or quickly.
    Volume(Seen, bool),
}

/// The representation of the field in a box, apart from slices.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Seen {
    Nothing,
    Surface,
    Projection,
}

/// The element model of a field program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, VariantArray)]
pub enum Waves {
    /// The far field of elements on a flat board.
    Piston,
    /// The same with a complex directivity in cosθ.
    Cosine,
    /// The same of rectangles.
    Rectangle,
    /// The whole field of elements on a flat board.
    ExactPiston,
    /// The far field of elements on a curved board: two vectors each.
    Curved,
    /// The same with a complex directivity in cosθ.
    CurvedCosine,
}

impl Waves {
    /// Vectors that describe an element.
    pub fn vectors(self) -> usize {
        match self {
            Self::Piston | Self::Cosine | Self::Rectangle | Self::ExactPiston => 1,
            Self::Curved | Self::CurvedCosine => 2,
        }
    }

    /// Whether all elements lie in z = 0 and radiate along z.
    fn are_flat(self) -> bool {
        self.vectors() == 1
    }
}

/// The field's program has four variants for each of the waves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct FieldProgram {
    pub waves: Waves,
    /// More than [`UNIFORM_ELEMENTS`] vectors.
    pub many_elements: bool,
    /// More than the first eight of the directivity or four of the decay.
    pub many_terms: bool,
}

impl FieldProgram {
    #[cfg(test)]
    pub fn all() -> impl Iterator<Item = Self> {
        let of_form =
            |form: u32, waves| Self { waves, many_elements: form & 1 != 0, many_terms: form & 2 != 0 };
        (0..4).flat_map(move |form| Waves::VARIANTS.iter().map(move |&waves| of_form(form, waves)))
    }

    fn source(self, tuning: &Tuning) -> String {
        let element = match self.waves {
            Waves::Piston => include_str!("../../../../shaders/piston.wgsl"),
            Waves::Cosine => include_str!("../../../../shaders/cosine.wgsl"),
            Waves::Rectangle => include_str!("../../../../shaders/rectangle.wgsl"),
            Waves::ExactPiston => include_str!("../../../../shaders/exact_piston.wgsl"),
            Waves::Curved => include_str!("../../../../shaders/curved.wgsl"),
            Waves::CurvedCosine => include_str!("../../../../shaders/curved_cosine.wgsl"),
        };
        let elements = if self.many_elements {
            include_str!("../../../../shaders/elements_storage.wgsl")
        } else {
            include_str!("../../../../shaders/elements_uniform.wgsl")
        };
        let forms = format!(
            "const MANY_TERMS: bool = {};\nconst IS_FLAT: bool = {};\nconst VECTORS: u32 = {}u;",
            self.many_terms,
            self.waves.are_flat(),
            self.waves.vectors()
        );
        let params = include_str!("../../../../shaders/params.wgsl");
        let field = include_str!("../../../../shaders/field.wgsl");
        [&forms, params, PHASE, elements, element, &shared_sum(tuning), field].join("\n")
    }
}

/// How invocations share samples, and the elements of each.
fn shared_sum(tuning: &Tuning) -> String {
    let sum = match tuning.slices {
        1 => include_str!("../../../../shaders/whole.wgsl"),
        _ => include_str!("../../../../shaders/slices.wgsl"),
    };
    format!(
        "const EIGHT_SAMPLES: bool = {};\nconst LANES: u32 = {}u;\nconst SLICES: u32 = {}u;\n{sum}",
        tuning.eight_samples,
        tuning.lanes(),
        tuning.slices
    )
}

impl Program {
    #[cfg(test)]
    pub fn all() -> Vec<Self> {
        let mut all = vec![Self::Emission, Self::Across, Self::Gather];
        all.extend(FieldProgram::all().map(Self::Field));
        all.extend(Quantity::ALL.map(Self::Form));
        all.extend(Quantity::ALL.map(Self::FormDirect));
        all.extend([Scale::Linear, Scale::Logarithmic].map(Self::Picture));
        for seen in [Seen::Nothing, Seen::Surface, Seen::Projection] {
            all.extend([false, true].map(|is_smooth| Self::Volume(seen, is_smooth)));
        }
        all
    }

    pub fn source(self, tuning: &Tuning) -> String {
        let source = match self {
            Self::Field(field) => field.source(tuning),
            Self::Emission => {
                let emission = include_str!("../../../../shaders/emission.wgsl");
                [PHASE, &shared_sum(tuning), emission].join("\n")
            }
            Self::Across => {
                let across = include_str!("../../../../shaders/across.wgsl");
                [&places(PRESSURE), SOUND, across, &blocks(tuning, PRESSURE), INTERPOLATION].join("\n")
            }
            Self::Form(quantity) => {
                let blocks = blocks(tuning, quantity.declaration().parts);
                [&declared(quantity), SOUND, FORM, &blocks, INTERPOLATION].join("\n")
            }
            Self::FormDirect(quantity) => {
                let direct = include_str!("../../../../shaders/direct.wgsl");
                [&declared(quantity), SOUND, FORM, direct].join("\n")
            }
            Self::Gather => include_str!("../../../../shaders/gather.wgsl").to_owned(),
            Self::Picture(scale) => {
                let law = format!("const LOGARITHMIC: bool = {};", scale == Scale::Logarithmic);
                [&law, include_str!("../../../../shaders/picture.wgsl")].join("\n")
            }
            Self::Volume(seen, is_smooth) => {
                [&space(seen, is_smooth), include_str!("../../../../shaders/volume.wgsl")].join("\n")
            }
        };
        [constants(), source].join("\n")
    }
}

/// Constants shared by `shaders/volume.wgsl` and its CPU twin.
fn space(seen: Seen, is_smooth: bool) -> String {
    let rays = if is_smooth { &march::SMOOTH[..] } else { &[[0.0; 2]][..] };
    let ray: Vec<_> = rays.iter().map(|[x, y]| format!("vec2f({x:?}, {y:?})")).collect();
    let count = |name: &str, value: u32| format!("const {name}: u32 = {value}u;\n");
    let number = |name: &str, value: f32| format!("const {name}: f32 = {value:?};\n");
    [
        count("TILE", scenery::TILE as u32),
        count("MOST_MET", scenery::MOST_MET as u32),
        count("LINE", scenery::LINE),
        count("DOT", scenery::DOT),
        count("DISC", scenery::DISC),
        count("PANEL", scenery::PANEL),
        count("MOST_STEPS", march::MOST_STEPS),
        count("MOST_BRICKS", march::MOST_BRICKS),
        count("HALVINGS", march::HALVINGS),
        count("RAYS", rays.len() as u32),
        number("BRICK", BRICK as f32),
        number("SURFACE_STRIDE", march::SURFACE_STRIDE),
        number("PROJECTION_STRIDE", march::PROJECTION_STRIDE),
        number("NUDGE", march::NUDGE),
        number("LEAST", march::LEAST),
        number("LEAST_SLOPE", march::LEAST_SLOPE),
        number("OPAQUE", march::OPAQUE),
        number("FAINT", march::FAINT),
        number("SOLID", march::SOLID),
        format!(
            "var<private> RAY: array<vec2f, {}> = array<vec2f, {}>({});\n",
            rays.len(),
            rays.len(),
            ray.join(", ")
        ),
        format!("const HAS_BODY: bool = {};\n", seen != Seen::Nothing),
        format!("const IS_SURFACE: bool = {};\n", seen == Seen::Surface),
    ]
    .concat()
}

fn blocks(tuning: &Tuning, parts: u8) -> String {
    let [_, lines] = tuning.block(parts);
    format!("const SIXTEEN_PIXELS: bool = {};\nconst FOUR_LINES: bool = {};", tuning.large_blocks, lines > 1)
}

/// Indices of the parts of the sound used by a program.
fn places(parts: u8) -> String {
    let place = |wanted: Part| match Part::of(parts).position(|part| part == wanted) {
        Some(place) => format!("{place}u"),
        None => "NOWHERE".to_owned(),
    };
    let [pressure, along_x, along_y, normal] =
        [Part::Pressure, Part::AlongX, Part::AlongY, Part::Normal].map(place);
    format!(
        "const NOWHERE: u32 = 0xffffffffu;\n\
         const PRESSURE: u32 = {pressure};\n\
         const ALONG_X: u32 = {along_x};\n\
         const ALONG_Y: u32 = {along_y};\n\
         const NORMAL: u32 = {normal};\n"
    )
}

/// A quantity's declaration in the names of `shaders/form.wgsl`.
fn declared(quantity: Quantity) -> String {
    let declaration = quantity.declaration();
    let extent = match declaration.norm {
        Norm::Value | Norm::Difference => "abs(value)",
        Norm::Pressure => "length(s.p)",
    };
    format!(
        "{}const IS_ROOT: bool = {};\n\
         fn formula(s: Sound) -> f32 {{ return {}; }}\n\
         fn extent(s: Sound, value: f32) -> f32 {{ return {extent}; }}\n",
        places(declaration.parts),
        declaration.is_root,
        declaration.wgsl
    )
}

/// Constants shared by Rust and WGSL, written once.
fn constants() -> String {
    let polynomial = |name: &'static str, coefficients: &[f32]| {
        coefficients
            .iter()
            .enumerate()
            .map(|(i, c)| format!("const {name}_{i}: f32 = {c:?};\n"))
            .collect::<String>()
    };
    format!(
        "const WORKGROUP: u32 = {WORKGROUP}u;\n\
         const UNIFORM_ELEMENTS: u32 = {UNIFORM_ELEMENTS}u;\n\
         const MOST_NODES: u32 = {MOST_NODES}u;\n\
         const NEAREST: f32 = {NEAREST:?};\n\
         const SMALLEST: f32 = {SMALLEST:?};\n\
         const PI: f32 = {:?};\n{}{}",
        std::f32::consts::PI,
        polynomial("SINE", &SINE),
        polynomial("COSINE", &COSINE)
    )
}

#[cfg(test)]
mod tests {
    use std::mem::{offset_of, size_of};

    use naga::valid::{Capabilities, ValidationFlags, Validator};
    use naga::{Module, TypeInner};

    use super::*;
    use crate::field::volume::scenery::{ShotParams, Thing};

    /// Parses and validates with no capability beyond the portable ones.
    fn module(name: &str, source: &str) -> Module {
        let module = naga::front::wgsl::parse_str(source)
            .unwrap_or_else(|e| panic!("{}", e.emit_to_string_with_path(source, name)));
        Validator::new(ValidationFlags::all(), Capabilities::empty())
            .validate(&module)
            .unwrap_or_else(|e| panic!("{}", e.emit_to_string_with_path(source, name)));
        module
    }

    /// Names and offsets of a WGSL struct's members, and its size.
    fn layout(module: &Module, name: &str) -> (Vec<(String, usize)>, usize) {
        let found = module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some(name));
        let (_, ty) = found.unwrap_or_else(|| panic!("no struct {name}"));
        let TypeInner::Struct { members, span } = &ty.inner else { panic!("{name} is no struct") };
        let members =
            members.iter().map(|m| (m.name.clone().unwrap_or_default(), m.offset as usize)).collect();
        (members, *span as usize)
    }

    macro_rules! assert_same_layout {
        ($module:expr, $name:ident { $($field:ident),* }) => {
            let expected = (vec![$((stringify!($field).to_owned(), offset_of!($name, $field))),*], size_of::<$name>());
            assert_eq!(layout($module, stringify!($name)), expected, stringify!($name));
        };
    }

    const TUNINGS: [Tuning; 3] = [Tuning::SOFTWARE, Tuning::INTEGRATED, Tuning::DISCRETE];

    #[test]
    fn every_program_is_valid_and_has_the_workgroup_that_rust_divides_by() {
        for tuning in TUNINGS {
            for program in Program::all() {
                let name = format!("{program:?}");
                let module = module(&name, &program.source(&tuning));
                assert_eq!(module.entry_points.len(), 1, "{name}");
                let is_field = matches!(program, Program::Field(_) | Program::Emission);
                let size = if is_field { [tuning.lanes(), tuning.slices] } else { [WORKGROUP, 1] };
                assert_eq!(module.entry_points[0].workgroup_size, [size[0], size[1], 1], "{name}");
            }
        }
    }

    #[test]
    fn every_shader_file_is_part_of_a_program() {
        let sources = TUNINGS
            .iter()
            .flat_map(|tuning| Program::all().into_iter().map(move |program| program.source(tuning)));
        let programs: String = sources.collect();
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../shaders");
        let mut files = 0;
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            assert!(
                programs.contains(&std::fs::read_to_string(&path).unwrap()),
                "{} is in no program",
                path.display()
            );
            files += 1;
        }
        assert!(files >= 8);
    }

    #[test]
    fn structs_are_laid_out_as_in_rust() {
        let module = |program: Program, tuning: &Tuning| module("", &program.source(tuning));
        let field = module(Program::Field(FieldProgram::all().next().unwrap()), &Tuning::SOFTWARE);
        assert_same_layout!(
            &field,
            Params {
                directivity,
                second,
                decay,
                decay_scale,
                turns_per_metre,
                first_element,
                last_element,
                columns,
                first,
                count,
                nodes,
                radius,
                piston_scale,
                gain
            }
        );
        assert_same_layout!(
            &module(Program::Emission, &Tuning::SOFTWARE),
            EmissionParams { first_source, last_source, first, count, leak, least }
        );
        assert_same_layout!(
            &module(Program::Form(Quantity::Rms), &Tuning::SOFTWARE),
            FormParams { of_pressure, of_gradient, of_velocity, factor, turn }
        );
        assert_same_layout!(
            &module(Program::FormDirect(Quantity::Rms), &Tuning::SOFTWARE),
            DirectParams { columns, count, first_pixel }
        );
        assert_same_layout!(
            &module(Program::Gather, &Tuning::SOFTWARE),
            GatherParams { probes, all, parts, sloped, taps, tap_stride, part_stride }
        );
        assert_same_layout!(
            &module(Program::Picture(Scale::Linear), &Tuning::SOFTWARE),
            PictureParams { width, zero, spread, full }
        );
        let space = module(Program::Volume(Seen::Surface, true), &Tuning::SOFTWARE);
        assert_same_layout!(&space, Thing { place, first, second, colour });
        assert_same_layout!(
            &space,
            ShotParams {
                eye,
                aside,
                right,
                spread,
                up,
                level,
                forward,
                per_peak,
                low,
                width,
                high,
                height,
                first,
                tiles,
                per_metre,
                more,
                counts,
                columns,
                bricks,
                rows,
                surface,
                top,
                bottom
            }
        );
        assert_same_layout!(
            &module(Program::Across, &Tuning::SOFTWARE),
            InterpolationParams {
                pixels,
                lines,
                span,
                slopes,
                tap_stride,
                line_stride,
                part_stride,
                first_pixel,
                pixel_stride,
                pixel_line_stride
            }
        );
    }
}
