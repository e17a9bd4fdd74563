//! The effect of sound on a liquid, as text and as a picture.

use glam::DVec2;

use crate::echo;
use crate::field::{Depression, Map, Pressed, Quantity};
use crate::picture::Picture;
use crate::picture::relief::{self, Relief, Words};
use crate::rounding::{at_most, digits, milliseconds, percent_at_least};
use crate::scene::{self, Envelope, Law, Liquid, Modulation, Plane, Scene};
use crate::studio::map::{DrawnMap, SILENT, extent, summary};
use crate::studio::output::warn;
use crate::surface::{Light, STEEPEST, largest_drive};

/// Columns of the shaded surface.
const COLUMNS: usize = 1200;

/// Width and height of the map of a shaded surface.
pub fn points(plane: &Plane) -> (usize, usize) {
    let rows = (COLUMNS as f64 * plane.size.y / plane.size.x).round();
    (COLUMNS, rows.clamp(2.0, 10.0 * COLUMNS as f64) as usize)
}

/// The figures of a map of radiation pressure or its effects.
pub fn describe(scene: &Scene, pressed: &Pressed, (quantity, map): (Quantity, &Map)) -> String {
    let mut words = match pressed.depression {
        None | Some(_) if map.peak == 0.0 => summary(quantity, map),
        None => format!("{}, {} on {}", summary(quantity, map), newtons(pressed.force), area(pressed.size)),
        Some(depression) => {
            let surface = format!("{}: {}", liquid(scene), figures(pressed, depression));
            match pressed.light {
                Some(light) => format!("{}\n  {surface}", caustic(scene, light, map.peak.into())),
                None => surface,
            }
        }
    };
    let part = scene.envelope().mean_square();
    if part < 1.0 {
        words.push_str(&format!("; {}", envelope(scene)));
    }
    words
}

/// A depression as a map, or shaded on a page from points with `columns` columns.
pub fn picture(
    name: &str,
    scene: &Scene,
    map: &DrawnMap,
    shaded: Option<(usize, (usize, usize))>,
) -> Picture {
    let pressed = map.pressed.and_then(|pressed| Some((pressed, pressed.depression?)));
    let beyond = pressed.and_then(|(_, depression)| beyond_linear_theory(depression.slope));
    if let Some(beyond) = &beyond {
        warn(&format!("{name}: {beyond}"));
    }
    let (Some((columns, page)), Some((pressed, depression))) = (shaded, pressed) else {
        let mut picture = map.picture.clone();
        if let Some((_, depression)) = pressed.filter(|_| beyond.is_some()) {
            let holds =
                format!("beyond linear theory, valid up to {} of this drive", holds_to(depression.slope));
            relief::label(&mut picture, &holds);
        }
        return picture;
    };
    let relief = Relief::new(&map.map.values, columns, scene.plane.size);
    let size = scene.plane.size * 1e3;
    let mut lines = vec![
        format!("{name}: {}", liquid(scene)),
        figures(&pressed, depression),
        format!(
            "{:.0} x {:.0} mm seen from the front, depths drawn {} times as deep",
            size.x, size.y, relief.exaggeration
        ),
    ];
    if scene.envelope().mean_square() < 1.0 {
        lines[2] = format!("{}; {}", lines[2], envelope(scene));
    }
    relief.page(Words { lines: &lines, warning: beyond.as_deref() }, page)
}

/// When a frame of a film is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Moment {
    /// A frame and the number of frames of a cycle, from 0.
    Frame(usize, usize),
    /// s, since the sound began.
    Time(f64),
}

/// A frame of a film with this common range of depths (m), shaded on a page; `slope` is the steepest of all.
pub fn frame(
    name: &str,
    scene: &Scene,
    (relief, [low, high]): (&Relief<'_>, [f32; 2]),
    (moment, slope): (Moment, f64),
    page: (usize, usize),
) -> Picture {
    let when = match moment {
        Moment::Frame(index, count) => format!("Frame {} of {count}", index + 1),
        Moment::Time(seconds) => format!("{} after the sound begins", milliseconds(seconds, 1)),
    };
    let depth = |depth: f32| Quantity::Depression.with_unit(depth.into());
    let all = match moment {
        Moment::Frame(..) => format!("deepest {} in all frames", depth(high)),
        Moment::Time(_) => format!("depth {} to {} in all frames", depth(low), depth(high)),
    };
    let size = relief.size * 1e3;
    let lines = [
        format!("{name}: {}", liquid(scene)),
        format!("{when}; {all}"),
        format!(
            "{:.0} x {:.0} mm seen from the front, depths drawn {} times as deep",
            size.x, size.y, relief.exaggeration
        ),
    ];
    let warning = beyond_linear_theory(slope);
    relief.page(Words { lines: &lines, warning: warning.as_deref() }, page)
}

/// Description of a caustic: its light path, largest brightness, and the light beside the screen.
fn caustic(scene: &Scene, light: Light, brightest: f64) -> String {
    let crosses = if light.crosses { "rays cross before it" } else { "no rays cross before it" };
    format!(
        "{}: {}, {crosses}, {}",
        screen(&scene.liquid),
        extent(Quantity::Caustic, brightest),
        landed(light)
    )
}

/// Description of light path and screen.
pub fn screen(liquid: &Liquid) -> String {
    let distance = metres(liquid.screen);
    match liquid.light {
        scene::Light::Through => {
            format!(
                "light transmitted by the liquid (n = {}) on a screen {distance} off",
                liquid.refractive_index()
            )
        }
        scene::Light::Reflected => format!("light reflected by the surface on a screen {distance} off"),
    }
}

/// Description of the light on a screen of the plane's size.
pub fn landed(light: Light) -> String {
    format!("{:.2} % of the light of its area", 100.0 * light.landed)
}

fn liquid(scene: &Scene) -> String {
    let height = scene.plane.centre.z * 1e3;
    let liquid = &scene.liquid;
    let given = liquid.density.is_some() || liquid.surface_tension.is_some();
    let name = if given {
        format!("liquid of {:.0} kg/m³ and {:.1} mN/m", liquid.density(), liquid.surface_tension() * 1e3)
    } else {
        liquid.named().into_str().replace('-', " ")
    };
    format!("{name} {height:.0} mm from the array")
}

fn figures(pressed: &Pressed, depression: Depression) -> String {
    if pressed.force == 0.0 && depression.deepest == 0.0 {
        return SILENT.to_owned();
    }
    format!(
        "deepest {}, {} displaced by {} on {}, steepest slope {}",
        metres(depression.deepest),
        volume(depression.volume),
        newtons(pressed.force),
        area(pressed.size),
        digits(depression.slope)
    )
}

fn envelope(scene: &Scene) -> String {
    let modulation = scene.envelope();
    let Modulation { frequency, tones, file, .. } = modulation;
    let what = match modulation.shape {
        Envelope::Off => "no modulation".to_owned(),
        Envelope::Sine | Envelope::Square => {
            format!("{} modulation at {frequency} Hz", modulation.shape.into_str())
        }
        Envelope::Tones => {
            let all: Vec<_> = tones.iter().map(|tone| tone.frequency.to_string()).collect();
            format!("modulation by tones at {} Hz", all.join(", "))
        }
        Envelope::File => format!("modulation by “{}”", echo::value(file)),
    };
    let law = match modulation.law {
        Law::Amplitude => "",
        Law::Power => " of the power",
    };
    format!("{what}{law} leaves {:.1} % of the steady pressure", modulation.mean_square() * 100.0)
}

/// The warning about a surface too steep for linear theory.
pub fn beyond_linear_theory(slope: f64) -> Option<String> {
    (slope > STEEPEST).then(|| {
        format!(
            "slope {} is beyond linear theory (at most {STEEPEST}): valid up to {} of this amplitude; beyond that, \
             qualitative only",
            at_most(slope, 2),
            holds_to(slope)
        )
    })
}

/// The fraction of the drive up to which a surface of this slope follows linear theory.
fn holds_to(slope: f64) -> String {
    percent_at_least(largest_drive(slope), 0)
}

/// Width and height (m) of the plane that figures are of.
pub fn area(size: DVec2) -> String {
    let millimetres = |length: f64| digits(length * 1e3).parse::<f64>().unwrap_or(length * 1e3);
    format!("{} x {} mm", millimetres(size.x), millimetres(size.y))
}

pub fn metres(length: f64) -> String {
    if length >= 1e-3 {
        format!("{} mm", digits(length * 1e3))
    } else {
        format!("{} µm", digits(length * 1e6))
    }
}

pub fn volume(volume: f64) -> String {
    format!("{} mm³", digits(volume * 1e9))
}

fn newtons(force: f64) -> String {
    if force.abs() >= 1e-3 {
        format!("{} mN", digits(force * 1e3))
    } else {
        format!("{} µN", digits(force * 1e6))
    }
}
