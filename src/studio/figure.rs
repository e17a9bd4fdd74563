//! Figures for papers: a quantity on a plane with axes, in chosen colours, range and convention.

use std::path::Path;

use anyhow::{Context, bail};
use glam::{DVec2, DVec3};

use crate::echo;
use crate::field::{
    Colouring, FLOOR, FieldError, MOST_PIXELS, Map, Quantity, Range, Request, Scale, Stages, contour,
};
use crate::memory;
use crate::picture::figure::surface::{self, Measure, Surface};
use crate::picture::figure::{Bar, Content, Figure, Format, Paper, round_step};
use crate::picture::relief::Relief;
use crate::picture::{ColourMap, Picture, sheet, veil};
use crate::rounding::millimetres;
use crate::scene::{Focus, Sampling, Scene, Target, outline};
use crate::studio::convention::Convention;
use crate::studio::evaluator::or_by_cpu;
use crate::studio::{liquid, map, width};

/// mm, and dots per inch, that a figure may have.
pub const WIDTHS: [f64; 2] = [30.0, 1000.0];
pub const DENSITIES: [f64; 2] = [36.0, 2400.0];
/// Memory per pixel between field and file, at most.
const BYTES_PER_PIXEL: usize = 32;
/// Largest distance of a focus that counts as on a plane, m.
const ON_PLANE: f64 = 1e-3;
/// Limit of foci with drawn widths: each takes some milliseconds.
const MOST_WIDTHS: usize = 24;
/// mm on the paper that the bar of a depth has at least.
const LEAST_DEPTH: f64 = 2.5;

/// The options of a figure.
#[derive(Clone, Debug, PartialEq)]
pub struct Wish {
    pub paper: Paper,
    pub title: Option<String>,
    /// A liquid's surface as light falls on it: colours, range, contours and targets are those of maps.
    pub is_shaded: bool,
    pub colours: ColourMap,
    /// Colours for a light ground.
    pub is_light: bool,
    pub scale: Scale,
    /// Values of the first and the last colour: SI units in the convention, or dB on a logarithmic scale.
    pub range: Option<[f64; 2]>,
    /// The value of 0 dB and of the default last colour; the map's largest value if `None`.
    pub full: Option<f64>,
    /// Without a range, the value of the first colour on a linear scale, as in [`crate::field::Colouring::low`].
    pub low: Option<f64>,
    /// Without a range, the part of the largest value with the first colour on a logarithmic scale.
    pub floor: f64,
    /// The brightness of a phase follows its amplitude.
    pub fades: bool,
    /// dB from the map's largest value; of a level in dB, its values.
    pub contours: Vec<f64>,
    pub convention: Convention,
    /// Whether there is a colour bar; beside a shaded surface, a bar of a round depth.
    pub has_colour_bar: bool,
    pub has_scale_bar: bool,
    pub has_targets: bool,
    /// The -6 dB widths of separate foci, along the axes.
    pub has_widths: bool,
}

impl Default for Wish {
    fn default() -> Self {
        Self {
            paper: Paper::default(),
            title: None,
            is_shaded: false,
            colours: ColourMap::default(),
            is_light: false,
            scale: Scale::Linear,
            range: None,
            full: None,
            low: None,
            floor: FLOOR.into(),
            fades: false,
            contours: Vec::new(),
            convention: Convention::default(),
            has_colour_bar: true,
            has_scale_bar: false,
            has_targets: false,
            has_widths: false,
        }
    }
}

/// The format of a figure, by its file name extension.
///
/// # Errors
/// An unknown or missing extension.
pub fn format(path: &Path) -> anyhow::Result<Format> {
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    ending.parse().ok().with_context(|| {
        format!("{}: figures are written as .png, .svg and .pdf, by the ending", echo::path(path))
    })
}

/// Refuses a file name with an unsupported extension.
///
/// # Errors
/// An unsupported extension.
pub fn refuse_ending(path: &Path, endings: &[&str]) -> anyhow::Result<()> {
    let Some(ending) = path.extension().map(|ending| ending.to_string_lossy().to_lowercase()) else {
        return Ok(());
    };
    if endings.contains(&ending.as_str()) {
        return Ok(());
    }
    bail!("{}: this is written as .{}", echo::path(path), endings.join(" or ."))
}

/// A figure, and the map in it.
#[derive(Debug)]
pub struct Drawn {
    pub figure: Figure,
    pub map: Map,
    /// The steepest slope of a liquid's surface.
    pub slope: Option<f64>,
}

/// Draws the request, of the size of the figure's map; `foci` are those of its drives.
///
/// # Errors
/// Choices invalid for the quantity, too many pixels, or a field that cannot be computed.
pub fn draw(
    (scene, foci): (&Scene, &[Focus]),
    request: &Request,
    wish: &Wish,
    stages: &mut Stages,
    gpu_is_asked_for: bool,
) -> anyhow::Result<Drawn> {
    let quantity = request.quantity;
    check(quantity, wish)?;
    if wish.is_shaded {
        return shaded(request, wish, stages, gpu_is_asked_for);
    }
    let mut content = content((scene, foci), request, wish)?;
    check_size(content.page_pixels(wish.paper))?;
    let [width, height] = content.map_pixels(wish.paper);
    let request = Request { size: (width, height), ..request.clone() };
    let (map, slope) = or_by_cpu(stages, gpu_is_asked_for, |stages| mapped(&request, stages))?;
    let law = Law::new(quantity, wish, f64::from(map.peak));
    let table = table(quantity, wish);
    let has_phases = quantity.declaration().range == Range::Cyclic;
    let colour = |&value: &f32| {
        // Silence has no phase.
        let value = if has_phases && map.peak == 0.0 { 0.0 } else { value };
        table[law.place(f64::from(value))]
    };
    let colours: Vec<u8> = map.values.iter().flat_map(colour).collect();
    let mut picture = Picture::from_field_order(width, height, &colours);
    if wish.fades && has_phases {
        let request = Request { quantity: Quantity::Rms, ..request };
        let colouring = Colouring::new(Quantity::Rms, veil(wish.is_light));
        let veil = or_by_cpu(stages, gpu_is_asked_for, |stages| {
            stages.colours(&request, &colouring).map(<[_]>::to_vec)
        })?;
        picture.veil(&Picture::from_field_order(width, height, veil.as_flattened()));
    }
    if let Some(bar) = &mut content.bar {
        *bar = law.bar(table);
    }
    content.remark = map::remark(quantity, &map).filter(|_| wish.full.is_none() && wish.range.is_none());
    if map.peak > 0.0 {
        for level in &wish.contours {
            let level = map::contour(quantity, *level, map.peak.into());
            content.contours.extend(contour::lines(&map.values, width, level as f32, |&value| value));
        }
    }
    Ok(Drawn { figure: content.figure(wish.paper, picture), map, slope })
}

fn check_size([width, height]: [usize; 2]) -> anyhow::Result<()> {
    let bytes = width.saturating_mul(height).saturating_mul(BYTES_PER_PIXEL);
    if bytes / BYTES_PER_PIXEL > MOST_PIXELS || !memory::holds(bytes) {
        bail!("{width} x {height} pixels are too many: choose fewer dots per inch or a smaller width");
    }
    Ok(())
}

/// The map, and for a liquid the steepest slope.
fn mapped(request: &Request, stages: &mut Stages) -> Result<(Map, Option<f64>), FieldError> {
    let map = stages.map(request)?.clone();
    let of_liquid = request.quantity.declaration().of_liquid;
    let pressed = of_liquid.then(|| stages.pressed(request)).transpose()?;
    Ok((map, pressed.and_then(|pressed| pressed.depression).map(|depression| depression.slope)))
}

/// The surface at an angle, with bars for lengths to the right and for depths.
fn shaded(
    request: &Request,
    wish: &Wish,
    stages: &mut Stages,
    gpu_is_asked_for: bool,
) -> anyhow::Result<Drawn> {
    let (plane, paper) = (&request.plane, wish.paper);
    let place = surface::place(paper, plane.size);
    check_size([place.width, place.height])?;
    let request = Request { size: liquid::points(plane), ..request.clone() };
    let (map, slope) = or_by_cpu(stages, gpu_is_asked_for, |stages| mapped(&request, stages))?;
    let relief = Relief::new(&map.values, map.width, plane.size);
    let picture = relief.draw(&place);
    // On the paper, of a metre.
    let to_the_right = place.scale(plane.size) * 25.4 / paper.dpi;
    let down = relief.sinks(to_the_right);
    let measure = |metres: f64, mm: f64, words: &str| {
        let (factor, unit) = request.quantity.declaration().unit.scaled(metres);
        Measure {
            length: metres * mm,
            text: format!("{} {unit}{words}", (metres * factor * 1e6).round() / 1e6),
        }
    };
    let drawn = format!(" deep, drawn {} ×", relief.exaggeration);
    let content = Surface {
        title: title(wish),
        scale: wish.has_scale_bar.then(|| measure(round_step(plane.size.x / 8.0), to_the_right, "")),
        depth: wish.has_colour_bar.then(|| measure(round_step(LEAST_DEPTH / down), down, &drawn)),
    };
    let figure = content.figure(paper, picture);
    Ok(Drawn { figure, map, slope })
}

/// One that is not blank.
fn title(wish: &Wish) -> Option<String> {
    wish.title.clone().filter(|title| !title.trim().is_empty())
}

fn check(quantity: Quantity, wish: &Wish) -> anyhow::Result<()> {
    let declaration = quantity.declaration();
    let words = declaration.words;
    if wish.is_shaded && !declaration.is_surface() {
        bail!("a surface is shaded: show the depression, not {words}");
    }
    if wish.scale == Scale::Logarithmic && declaration.range != Range::Amount {
        bail!("--db is a scale of amounts, and {words} has a sign or a direction");
    }
    if wish.scale == Scale::Logarithmic && declaration.is_level() {
        bail!("--db: {words} is in dB already");
    }
    if let Some(level) = wish.contours.iter().find(|level| **level >= 0.0 && !declaration.is_level()) {
        bail!("--contours {level}: give dB below 0, relative to the largest value, such as -6");
    }
    if !wish.contours.is_empty() && !declaration.has_mean {
        bail!("--contours are of amounts, and {words} has none");
    }
    if wish.range.is_some() && declaration.range == Range::Cyclic {
        bail!("--range: a {words} has one range, a whole turn");
    }
    Ok(())
}

fn table(quantity: Quantity, wish: &Wish) -> [[u8; 4]; 256] {
    let colours = map::colours(quantity, wish.colours);
    colours.on(wish.is_light)
}

/// The content that does not depend on the map's values.
fn content((scene, foci): (&Scene, &[Focus]), request: &Request, wish: &Wish) -> anyhow::Result<Content> {
    let plane = &request.plane;
    let place = |point| sheet::on_plane(plane, point).map(|DVec2 { x, y }| [x, y]);
    let is_continuous = |target: &Target| target.sampling == Sampling::Continuous || target.is_area();
    let (mut outlines, mut rings) = (Vec::new(), Vec::new());
    if wish.has_targets {
        for target in scene.targets.iter().filter(|target| target.is_in(0) && is_continuous(target)) {
            for stroke in outline::strokes(target)? {
                outlines.push(stroke.into_iter().filter_map(place).collect());
            }
        }
        let separate = foci.iter().filter(|focus| focus.is_separate());
        rings = separate.filter_map(|focus| place(focus.position)).collect();
    }
    let bar = || Law::new(request.quantity, wish, 1.0).bar(table(request.quantity, wish));
    Ok(Content {
        title: title(wish),
        axes: sheet::axes(plane),
        bar: wish.has_colour_bar.then(bar),
        has_scale_bar: wish.has_scale_bar,
        remark: None,
        contours: Vec::new(),
        outlines,
        foci: rings,
        lengths: if wish.has_widths { lengths(foci, request) } else { Vec::new() },
        is_light: wish.is_light,
    })
}

/// The -6 dB widths of separate foci on the plane, mm on the axes.
fn lengths(foci: &[Focus], request: &Request) -> Vec<([[f64; 2]; 2], String)> {
    let Request { plane, aperture, drives, .. } = request;
    let Some((x, y)) = plane.axes() else { return Vec::new() };
    let place = |point| sheet::on_plane(plane, point).map(|DVec2 { x, y }| [x, y]);
    let height = |point: DVec3| (point - plane.centre).dot(x.cross(y)).abs();
    let shown = foci.iter().filter(|focus| focus.is_separate() && height(focus.position) < ON_PLANE);
    let spans =
        shown.take(MOST_WIDTHS).flat_map(|focus| width::spans(aperture, drives, focus.position, [x, y]));
    spans
        .filter_map(|[from, to]| {
            let text = format!("{} mm", millimetres(from.distance(to), 1));
            Some(([place(from)?, place(to)?], text))
        })
        .collect()
}

/// The mapping of values to colours, and its labels on the colour bar.
struct Law {
    quantity: Quantity,
    convention: Convention,
    /// From a value to the number on the bar: dB, or a factor.
    scale: Scale,
    factor: f64,
    unit: &'static str,
    /// The value of 0 dB.
    full: f64,
    /// Numbers on the bar.
    ends: [f64; 2],
}

impl Law {
    fn new(quantity: Quantity, wish: &Wish, peak: f64) -> Self {
        let declaration = quantity.declaration();
        // RMS pressures are stated in either convention; all others have one.
        let stated = if quantity == Quantity::Rms {
            wish.convention.of_peak() / Convention::Rms.of_peak()
        } else {
            1.0
        };
        let full = wish.full.unwrap_or(if peak > 0.0 { peak } else { 1.0 });
        let largest = wish
            .range
            .filter(|_| wish.scale == Scale::Linear)
            .map_or(full * stated, |[low, high]| low.abs().max(high.abs()));
        let (factor, unit) = declaration.unit.scaled(largest);
        let low = wish.low.map(|low| low * stated).filter(|low| *low < largest);
        let ends = match (declaration.range, wish.scale) {
            (Range::Cyclic, _) => [-180.0, 180.0],
            (Range::Amount, Scale::Logarithmic) => wish.range.unwrap_or([quantity.decibels(wish.floor), 0.0]),
            (Range::Amount, Scale::Linear) => {
                wish.range.unwrap_or([low.unwrap_or(0.0), largest]).map(|end| end * factor)
            }
            (Range::Signed, _) => {
                wish.range.unwrap_or([low.unwrap_or(-largest), largest]).map(|end| end * factor)
            }
        };
        let scale = if declaration.range == Range::Amount { wish.scale } else { Scale::Linear };
        Self { quantity, convention: wish.convention, scale, factor: factor * stated, unit, full, ends }
    }

    /// The index of a value in a table of colours.
    fn place(&self, value: f64) -> usize {
        let number = match self.scale {
            Scale::Linear => value * self.factor,
            Scale::Logarithmic => self.quantity.decibels(value / self.full),
        };
        let part = (number - self.ends[0]) / (self.ends[1] - self.ends[0]);
        match self.quantity.declaration().range {
            // Every colour covers an equal part of the circle.
            Range::Cyclic => (part.rem_euclid(1.0) * 256.0) as usize % 256,
            Range::Amount | Range::Signed => (part.clamp(0.0, 1.0) * 255.0).round() as usize,
        }
    }

    fn bar(&self, table: [[u8; 4]; 256]) -> Bar {
        let declaration = self.quantity.declaration();
        let words = match (self.quantity, self.convention) {
            (Quantity::Rms, Convention::Rms) => "RMS pressure".to_owned(),
            (Quantity::Rms, Convention::Peak) => "Peak pressure".to_owned(),
            _ => capital(declaration.words),
        };
        let label = match self.scale {
            Scale::Linear => format!("{words} / {}", self.unit),
            Scale::Logarithmic => {
                let stated = self.factor / declaration.unit.scaled(self.full).0;
                format!("{words} / dB re {}", self.quantity.with_unit(self.full * stated))
            }
        };
        let is_turn = declaration.range == Range::Cyclic;
        let quarter = |quarter: i32| {
            let degrees = 90 * quarter;
            let sign = if degrees < 0 { "−" } else { "" };
            (f64::from(degrees), format!("{sign}{}", degrees.abs()))
        };
        let numbers = is_turn.then(|| (-2..=2).map(quarter).collect());
        Bar { table, ends: self.ends, label, numbers }
    }
}

pub fn capital(words: &str) -> String {
    let mut letters = words.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pressure_is_stated_in_the_convention_that_is_chosen() {
        let of = |convention, scale| {
            let wish = Wish { convention, scale, ..Wish::default() };
            let law = Law::new(Quantity::Rms, &wish, 100.0);
            (law.bar(ColourMap::Grey.table()).label, law.ends, law.place(50.0))
        };
        let (label, ends, place) = of(Convention::Rms, Scale::Linear);
        assert_eq!((label.as_str(), ends, place), ("RMS pressure / Pa", [0.0, 100.0], 128));
        let (label, ends, place) = of(Convention::Peak, Scale::Linear);
        assert_eq!((label.as_str(), place), ("Peak pressure / Pa", 128));
        assert!((ends[1] - 141.42).abs() < 0.01);
        let (label, ends, place) = of(Convention::Peak, Scale::Logarithmic);
        assert_eq!((label.as_str(), ends[1]), ("Peak pressure / dB re 141 Pa", 0.0));
        // Half the pressure is 6.02 dB below.
        assert_eq!(place, ((60.0f64 - 6.0206) / 60.0 * 255.0).round() as usize);
    }

    #[test]
    fn a_range_has_the_first_and_the_last_colour_at_its_ends() {
        let wish = Wish { range: Some([20.0, 60.0]), ..Wish::default() };
        let law = Law::new(Quantity::Rms, &wish, 100.0);
        assert_eq!([10.0, 20.0, 40.0, 60.0, 99.0].map(|value| law.place(value)), [0, 0, 128, 255, 255]);
        let wish = Wish { low: Some(20.0), full: Some(60.0), ..Wish::default() };
        let law = Law::new(Quantity::Rms, &wish, 100.0);
        assert_eq!([10.0, 20.0, 40.0, 60.0, 99.0].map(|value| law.place(value)), [0, 0, 128, 255, 255]);
        let wish = Wish { floor: 1e-2, scale: Scale::Logarithmic, ..Wish::default() };
        let law = Law::new(Quantity::Rms, &wish, 100.0);
        assert_eq!([0.1, 1.0, 10.0, 100.0].map(|value| law.place(value)), [0, 0, 128, 255]);
    }
}
