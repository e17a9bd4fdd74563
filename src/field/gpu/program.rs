//! The WGSL programs: which files make one, the constants that Rust writes into them, and the structs they share.

use bytemuck::{Pod, Zeroable};

use crate::acoustics::element::NEAREST;
use crate::field::colouring::{FLOOR, Quantity, Scale};
use crate::field::sources::{COSINE, MOST_NODES, SINE};

/// Invocations in a workgroup.
pub const WORKGROUP: u32 = 64;
/// Samples that one invocation of the field computes.
pub const SAMPLES_PER_INVOCATION: u32 = 8;
/// Elements that fit a uniform buffer of 16 KiB, which every adapter has.
pub const UNIFORM_ELEMENTS: usize = 1024;

/// The same struct as in `shaders/params.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Params {
    pub directivity: [[f32; 4]; 6],
    pub decay: [[f32; 4]; 4],
    pub decay_scale: [f32; 2],
    pub turns_per_metre: f32,
    pub first_element: u32,
    pub last_element: u32,
    pub columns: u32,
    pub first: u32,
    pub count: u32,
    pub written: u32,
    pub nodes: u32,
    pub radius: f32,
    pub piston_scale: f32,
}

/// The same struct as in `shaders/peak.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct PeakParams {
    pub count: u32,
    pub invocations: u32,
}

/// The same struct as in `shaders/picture_params.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct PictureParams {
    pub count: u32,
    pub invocations: u32,
    pub turn: [f32; 2],
    pub full: f32,
    pub padding: u32,
}

/// The same struct as in `shaders/interpolation.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct ResampleParams {
    pub pixels: u32,
    pub lines: u32,
    pub start: u32,
    pub span: u32,
    pub tap_stride: u32,
    pub line_stride: u32,
    pub pixel_stride: u32,
    pub pixel_line_stride: u32,
}

/// The same struct as in `shaders/squares.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct SquaresParams {
    pub count: u32,
    pub invocations: u32,
    pub of_pressure: f32,
    pub of_gradient: f32,
    pub share: f32,
    pub padding: u32,
}

/// The same struct as in `shaders/compliance.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct ComplianceParams {
    pub count: u32,
    pub invocations: u32,
    pub columns: u32,
    pub weight: f32,
    pub tension: f32,
    pub padding: u32,
    pub wavenumber: [f32; 2],
}

/// The same struct as in `shaders/join.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct JoinParams {
    pub count: u32,
    pub invocations: u32,
    pub of_shape: f32,
    pub of_radiation: f32,
}

/// The field's program comes in eight forms.
///
/// What a run decides once is a constant: of a condition on uniforms alone, lavapipe makes a program of its own in every run, and
/// keeps it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct FieldProgram {
    pub exact_piston: bool,
    /// More than [`UNIFORM_ELEMENTS`].
    pub many_elements: bool,
    /// More than the first eight of the directivity or four of the decay.
    pub many_terms: bool,
}

impl FieldProgram {
    /// All of them.
    pub fn all() -> [Self; 8] {
        std::array::from_fn(|form| Self {
            exact_piston: form & 1 != 0,
            many_elements: form & 2 != 0,
            many_terms: form & 4 != 0,
        })
    }

    pub fn source(self) -> String {
        let element = if self.exact_piston {
            include_str!("../../../shaders/exact_piston.wgsl")
        } else {
            include_str!("../../../shaders/piston.wgsl")
        };
        let elements = if self.many_elements {
            include_str!("../../../shaders/elements_storage.wgsl")
        } else {
            include_str!("../../../shaders/elements_uniform.wgsl")
        };
        let terms = format!("const MANY_TERMS: bool = {};", self.many_terms);
        let params = include_str!("../../../shaders/params.wgsl");
        let phase = include_str!("../../../shaders/phase.wgsl");
        [&constants(), &terms, params, phase, elements, element, include_str!("../../../shaders/field.wgsl")]
            .join("\n")
    }
}

/// The number that is shown of a value and scaled by the largest: a program for each quantity, since software drivers run
/// both sides of a branch. `None` for what is no amount.
fn shown(quantity: Quantity) -> Option<&'static str> {
    match quantity {
        Quantity::Rms => Some(include_str!("../../../shaders/magnitude.wgsl")),
        Quantity::Phase | Quantity::Instantaneous => None,
        Quantity::MeanRms => Some(include_str!("../../../shaders/mean_rms.wgsl")),
        Quantity::Dent => Some(include_str!("../../../shaders/dent.wgsl")),
        Quantity::Radiation => Some(include_str!("../../../shaders/radiation.wgsl")),
    }
}

/// The largest number that is shown; of what is no amount the largest magnitude.
pub fn peak_source(quantity: Quantity) -> String {
    let shown = shown(quantity).unwrap_or(include_str!("../../../shaders/magnitude.wgsl"));
    [&constants(), shown, include_str!("../../../shaders/peak.wgsl")].join("\n")
}

pub fn picture_source(quantity: Quantity, scale: Scale) -> String {
    let params = include_str!("../../../shaders/picture_params.wgsl");
    let law = match scale {
        Scale::Linear => include_str!("../../../shaders/scaled.wgsl"),
        Scale::Logarithmic => include_str!("../../../shaders/logarithmic.wgsl"),
    };
    let colour_index = match shown(quantity) {
        Some(shown) => [shown, law].join("\n"),
        None if quantity == Quantity::Instantaneous => {
            include_str!("../../../shaders/instantaneous.wgsl").to_owned()
        }
        None => include_str!("../../../shaders/argument.wgsl").to_owned(),
    };
    [&constants(), params, &colour_index, include_str!("../../../shaders/picture.wgsl")].join("\n")
}

/// Squares of the pressure at the cells, from it and its slopes.
pub fn squares_source() -> String {
    [&constants(), include_str!("../../../shaders/squares.wgsl")].join("\n")
}

/// What every mode of a liquid's surface gives way.
pub fn compliance_source() -> String {
    [&constants(), include_str!("../../../shaders/compliance.wgsl")].join("\n")
}

/// A dent or a square beside the radiation pressure.
pub fn join_source() -> String {
    [&constants(), include_str!("../../../shaders/join.wgsl")].join("\n")
}

pub fn interpolation_source() -> String {
    [&constants(), include_str!("../../../shaders/interpolation.wgsl")].join("\n")
}

/// What Rust and WGSL must agree on is written once, here.
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
         const FLOOR: f32 = {FLOOR:?};\n\
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

    #[test]
    fn every_program_is_valid_and_has_the_workgroup_that_rust_divides_by() {
        let mut sources: Vec<_> =
            FieldProgram::all().iter().map(|program| (format!("{program:?}"), program.source())).collect();
        sources.extend(Quantity::ALL.map(|quantity| (format!("peak {quantity:?}"), peak_source(quantity))));
        sources.extend(pictures().map(|source| ("picture".to_owned(), source)));
        sources.push(("interpolation".to_owned(), interpolation_source()));
        sources.push(("squares".to_owned(), squares_source()));
        sources.push(("compliance".to_owned(), compliance_source()));
        sources.push(("join".to_owned(), join_source()));
        for (name, source) in sources {
            let module = module(&name, &source);
            assert_eq!(module.entry_points.len(), 1, "{name}");
            assert_eq!(module.entry_points[0].workgroup_size, [WORKGROUP, 1, 1], "{name}");
        }
    }

    fn pictures() -> impl Iterator<Item = String> {
        let scales = [Scale::Linear, Scale::Logarithmic];
        Quantity::ALL
            .into_iter()
            .flat_map(move |quantity| scales.map(|scale| picture_source(quantity, scale)))
    }

    #[test]
    fn every_shader_file_is_part_of_a_program() {
        let programs: String = FieldProgram::all()
            .iter()
            .map(|program| program.source())
            .chain([interpolation_source(), squares_source(), compliance_source(), join_source()])
            .chain(Quantity::ALL.map(peak_source))
            .chain(pictures())
            .collect();
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/shaders");
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
        let field = module("field", &FieldProgram::all()[0].source());
        assert_same_layout!(
            &field,
            Params {
                directivity,
                decay,
                decay_scale,
                turns_per_metre,
                first_element,
                last_element,
                columns,
                first,
                count,
                written,
                nodes,
                radius,
                piston_scale
            }
        );
        assert_same_layout!(&module("peak", &peak_source(Quantity::Rms)), PeakParams { count, invocations });
        assert_same_layout!(
            &module("squares", &squares_source()),
            SquaresParams { count, invocations, of_pressure, of_gradient, share, padding }
        );
        assert_same_layout!(
            &module("compliance", &compliance_source()),
            ComplianceParams { count, invocations, columns, weight, tension, padding, wavenumber }
        );
        assert_same_layout!(
            &module("join", &join_source()),
            JoinParams { count, invocations, of_shape, of_radiation }
        );
        let picture = module("picture", &picture_source(Quantity::Rms, Scale::Linear));
        assert_same_layout!(&picture, PictureParams { count, invocations, turn, full, padding });
        let interpolation = module("interpolation", &interpolation_source());
        assert_same_layout!(
            &interpolation,
            ResampleParams {
                pixels,
                lines,
                start,
                span,
                tap_stride,
                line_stride,
                pixel_stride,
                pixel_line_stride
            }
        );
    }
}
