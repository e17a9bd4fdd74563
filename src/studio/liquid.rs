//! What sound does to a liquid, in words and as a picture.

use crate::field::Pressed;
use crate::picture::relief::{self, Relief, Words};
use crate::picture::sheet::pascals;
use crate::picture::{Picture, PictureError};
use crate::scene::{Envelope, Plane, Scene};
use crate::studio::map::DrawnMap;
use crate::studio::output::warn;
use crate::surface::Dent;
use crate::surface::dent::{STEEPEST, largest_drive};

/// Columns of the surface that is shaded.
const COLUMNS: usize = 1200;

/// Width and height of the map from which a shaded surface is drawn.
pub fn points(plane: &Plane) -> (usize, usize) {
    let rows = (COLUMNS as f64 * plane.size.y / plane.size.x).round();
    (COLUMNS, rows.clamp(2.0, 10.0 * COLUMNS as f64) as usize)
}

/// The figures of a pressed surface whose largest radiation pressure (Pa) or depth (m) is `largest`.
pub fn describe(scene: &Scene, pressed: &Pressed, largest: f64) -> String {
    let mut words = match &pressed.dent {
        None => {
            format!("radiation pressure up to {}, {} on the plane", pascals(largest), newtons(pressed.force))
        }
        Some(dent) => format!("{}: {}", liquid(scene), figures(dent)),
    };
    let part = scene.modulation.mean_square();
    if part < 1.0 {
        words.push_str(&format!("; {}", envelope(scene)));
    }
    words
}

/// A dent as a map, or shaded on a page from points with so many `columns`.
///
/// # Errors
/// The page is too small for its words.
pub fn picture(
    name: &str,
    scene: &Scene,
    map: &DrawnMap,
    shaded: Option<(usize, (usize, usize))>,
) -> Result<Picture, PictureError> {
    let dent = map.pressed.as_ref().and_then(|pressed| pressed.dent.as_ref());
    let beyond = dent.and_then(|dent| beyond_linear_theory(dent.slope));
    if let Some(beyond) = &beyond {
        warn(&format!("{name}: {beyond}"));
    }
    let (Some((columns, page)), Some(dent)) = (shaded, dent) else {
        let mut picture = map.picture.clone();
        if let Some(dent) = dent.filter(|_| beyond.is_some()) {
            let holds = format!(
                "beyond linear theory, true up to {:.0} % of this drive",
                100.0 * largest_drive(dent.slope)
            );
            relief::label(&mut picture, &holds)?;
        }
        return Ok(picture);
    };
    let relief = Relief { depth: &map.map.values, columns, size: scene.plane.size };
    let size = scene.plane.size * 1e3;
    let mut lines = vec![
        format!("{name}: {}", liquid(scene)),
        figures(dent),
        format!(
            "{:.0} x {:.0} mm seen from the front, depths drawn {} times as deep",
            size.x,
            size.y,
            relief.exaggeration()
        ),
    ];
    if scene.modulation.mean_square() < 1.0 {
        lines[2] = format!("{}; {}", lines[2], envelope(scene));
    }
    relief.page(Words { lines: &lines, warning: beyond.as_deref() }, page)
}

fn liquid(scene: &Scene) -> String {
    let height = scene.plane.centre.z * 1e3;
    let liquid = &scene.liquid;
    let given = liquid.density.is_some() || liquid.surface_tension.is_some();
    let name = if given {
        format!("liquid of {:.0} kg/m³ and {:.1} mN/m", liquid.density(), liquid.surface_tension() * 1e3)
    } else {
        liquid.name.name().replace('-', " ")
    };
    format!("{name} {height:.0} mm from the array")
}

fn figures(dent: &Dent) -> String {
    format!(
        "deepest {}, {:.1} mm³ displaced by {}, steepest slope {:.3}",
        metres(dent.deepest),
        dent.volume * 1e9,
        newtons(dent.force),
        dent.slope
    )
}

fn envelope(scene: &Scene) -> String {
    let modulation = &scene.modulation;
    let shape = match modulation.shape {
        Envelope::Off => "steady sound",
        Envelope::Sine => "sine",
        Envelope::Square => "square",
    };
    format!(
        "the {shape} envelope of {} Hz leaves {:.1} % of the steady pressure",
        modulation.frequency,
        modulation.mean_square() * 100.0
    )
}

/// A sentence where a surface is too steep for what it was computed with.
pub fn beyond_linear_theory(slope: f64) -> Option<String> {
    (slope > STEEPEST).then(|| {
        format!(
            "slope {slope:.2} is beyond linear theory, which holds to {STEEPEST}: true up to {:.0} % of this drive's \
             amplitude, above it a sketch",
            100.0 * largest_drive(slope)
        )
    })
}

fn metres(length: f64) -> String {
    if length >= 1e-3 { format!("{:.2} mm", length * 1e3) } else { format!("{:.1} µm", length * 1e6) }
}

fn newtons(force: f64) -> String {
    if force.abs() >= 1e-3 { format!("{:.2} mN", force * 1e3) } else { format!("{:.1} µN", force * 1e6) }
}
