//! Figures for papers: panels on a page, with maps in chosen colours, range and convention.
//!
//! All maps of a figure have one range of colours, and the last of each row the colour bar; all surfaces have one
//! exaggeration of their depths.

use std::path::Path;
use std::sync::Arc;

use anyhow::{Context, bail};
use glam::{DVec2, DVec3};

use crate::echo;
use crate::field::volume::scenery::Body;
use crate::field::{
    Colouring, FLOOR, FieldError, MOST_PIXELS, Map, Quantity, Range, Request, Scale, Stages, contour, hatch,
};
use crate::memory;
use crate::picture::figure::axes::round_step;
use crate::picture::figure::page::{self, Page, Plot};
use crate::picture::figure::space::{self, Space};
use crate::picture::figure::surface::{self, Measure, Surface};
use crate::picture::figure::{Bar, Content, Figure, Format, Length, Paper};
use crate::picture::relief::{self, Relief};
use crate::picture::{ColourMap, Picture, sheet, veil};
use crate::rounding::millimetres;
use crate::scene::{Focus, Sampling, Scene, Target, outline};
use crate::studio::convention::Convention;
use crate::studio::evaluator::or_by_cpu;
use crate::studio::scattered::Scattered;
use crate::studio::space::Prospect;
use crate::studio::{liquid, map, vectors, width};

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
    /// Columns of the page; `None`: as many as suit the panels.
    pub columns: Option<usize>,
    pub title: Option<String>,
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
    /// The moment of a motion or of waves, in words beside the quantity.
    pub moment: Option<String>,
    /// Whether there is a colour bar; beside a shaded surface, a bar of a round depth.
    pub has_colour_bar: bool,
    pub has_scale_bar: bool,
    pub has_targets: bool,
    /// The -6 dB widths of separate foci, along the axes.
    pub has_widths: bool,
    /// Arrows of the quantity's vector.
    pub has_arrows: bool,
}

impl Default for Wish {
    fn default() -> Self {
        Self {
            paper: Paper::default(),
            columns: None,
            title: None,
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
            moment: None,
            has_colour_bar: true,
            has_scale_bar: false,
            has_targets: false,
            has_widths: false,
            has_arrows: false,
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

/// A panel of a figure.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    /// Its title beside others, after its letter.
    pub name: String,
    pub subject: Subject,
}

/// The content of a panel.
#[derive(Clone, Debug, PartialEq)]
pub enum Subject {
    /// A quantity on a plane, with targets of the scene and the foci of its drives.
    Map {
        scene: Arc<Scene>,
        foci: Vec<Focus>,
        request: Request,
    },
    /// The first map minus the second.
    Difference(Box<[Request; 2]>),
    /// A liquid's surface as light falls on it.
    Shaded(Request),
    Space(Box<Prospect>),
    /// Readings, or their differences from a model.
    Scattered(Box<Scattered>),
    /// A plot that needs no field.
    Plot(Box<Plot>),
}

/// A figure, and the maps in it, a map per panel that has one.
#[derive(Debug)]
pub struct Drawn {
    pub figure: Figure,
    pub maps: Vec<MapOf>,
}

/// A map, and the steepest slope of a liquid's surface.
#[derive(Debug)]
pub struct MapOf {
    pub quantity: Quantity,
    pub map: Map,
    pub slope: Option<f64>,
}

/// Draws the panels on one page.
///
/// # Errors
/// Choices invalid for the quantity, too many pixels, or a field that cannot be computed.
pub fn draw(
    panels: &[Panel],
    wish: &Wish,
    stages: &mut Stages,
    gpu_is_asked_for: bool,
) -> anyhow::Result<Drawn> {
    let columns = wish.columns.unwrap_or_else(|| page::columns(panels.len())).max(1);
    let mut blank = Vec::new();
    for (index, Panel { name, subject }) in panels.iter().enumerate() {
        let title = (panels.len() > 1).then(|| format!("({}) {name}", letters(index)));
        // One bar beside the maps of a row.
        let end = panels.len().min(index - index % columns + columns);
        let mut rest = panels[index + 1..end].iter();
        let is_last = !rest.any(|panel| panel.subject.shares_range());
        blank.push(page::Panel { title, plot: subject.blank(wish, is_last)? });
    }
    let title = wish.title.clone().filter(|title| !title.trim().is_empty());
    let mut page = Page { paper: wish.paper, title, columns, panels: blank };
    check_size(page.pixels())?;
    let mut made = Vec::new();
    for (panel, size) in panels.iter().zip(page.plots()) {
        let size = size.unwrap_or_default();
        made.push(or_by_cpu(stages, gpu_is_asked_for, |stages| panel.subject.make(size, stages))?);
    }
    let of_all = |of: fn(&Made<'_>) -> f32| made.iter().map(of).fold(0.0, f32::max).into();
    let largest = Largest {
        value: of_all(|made| match made {
            Made::Map(_, MapOf { map, .. }) => map.peak,
            Made::Scattered(scattered, values, _) if !scattered.is_difference => largest(values),
            Made::Difference(..) | Made::Scattered(..) | Made::Shaded(..) | Made::Space(..) | Made::Plot => {
                0.0
            }
        }),
        depth: of_all(|made| match made {
            Made::Shaded(_, MapOf { map, .. }, _) => largest(&map.values),
            Made::Map(..) | Made::Difference(..) | Made::Scattered(..) | Made::Space(..) | Made::Plot => 0.0,
        }),
    };
    let mut pictures = Vec::new();
    for (panel, made) in page.panels.iter_mut().zip(&made) {
        let mut picture = made.picture(&mut panel.plot, largest, wish);
        if let (Some(picture), Made::Map(request, MapOf { map, .. })) = (&mut picture, made) {
            dim(picture, request, (map, wish), stages, gpu_is_asked_for)?;
        }
        pictures.push(picture);
    }
    let maps = made.into_iter().filter_map(|made| match made {
        Made::Map(_, map) | Made::Shaded(_, map, _) => Some(map),
        Made::Difference(..) | Made::Scattered(..) | Made::Space(..) | Made::Plot => None,
    });
    Ok(Drawn { maps: maps.collect(), figure: page.figure(pictures) })
}

/// The letters of a panel: a to z, then aa.
fn letters(index: usize) -> String {
    let letter = char::from(b'a' + (index % 26) as u8).to_string();
    if index < 26 { letter } else { letters(index / 26 - 1) + &letter }
}

/// The values of a panel.
enum Made<'a> {
    Map(&'a Request, MapOf),
    /// Values, and how many are in a row.
    Difference(&'a Request, Vec<f32>, usize),
    /// Values of pixels, and how many are in a row.
    Scattered(&'a Scattered, Vec<f32>, usize),
    /// For a picture of so many pixels.
    Shaded(&'a Request, MapOf, [usize; 2]),
    Space(&'a Prospect, [usize; 2]),
    Plot,
}

/// The largest value of all maps, and the largest depth of all surfaces.
#[derive(Clone, Copy)]
struct Largest {
    value: f64,
    depth: f64,
}

impl Made<'_> {
    /// The pixels of a plot. Completes the plot by what depends on values.
    fn picture(&self, plot: &mut Plot, largest: Largest, wish: &Wish) -> Option<Picture> {
        match (self, plot) {
            (Self::Map(request, MapOf { map, .. }), Plot::Map(content)) => {
                Some(coloured(content, (request.quantity, map, largest.value), wish))
            }
            (Self::Difference(request, values, width), Plot::Map(content)) => {
                Some(subtracted(content, request.quantity, (values, *width), wish))
            }
            (Self::Scattered(scattered, values, width), Plot::Map(content)) => {
                Some(scattered_picture(content, (scattered, values, *width), largest.value, wish))
            }
            (Self::Shaded(request, MapOf { map, .. }, size), Plot::Surface(surface)) => {
                Some(shaded(surface, (request, map, largest.depth), *size, wish))
            }
            (Self::Space(prospect, size), Plot::Space(space)) => Some(viewed(space, prospect, *size, wish)),
            (
                Self::Map(..)
                | Self::Difference(..)
                | Self::Scattered(..)
                | Self::Shaded(..)
                | Self::Space(..)
                | Self::Plot,
                Plot::Map(_)
                | Plot::Surface(_)
                | Plot::Space(_)
                | Plot::Elements(_)
                | Plot::Curve(_)
                | Plot::Polar(_)
                | Plot::Table(_),
            ) => None,
        }
    }
}

impl Subject {
    /// Whether it has the colours and the bar of the maps beside it.
    fn shares_range(&self) -> bool {
        match self {
            Self::Map { .. } => true,
            Self::Scattered(scattered) => !scattered.is_difference,
            Self::Difference(_) | Self::Shaded(_) | Self::Space(_) | Self::Plot(_) => false,
        }
    }

    /// The plot without what depends on values.
    fn blank(&self, wish: &Wish, has_bar: bool) -> anyhow::Result<Plot> {
        Ok(match self {
            Self::Map { scene, foci, request } => {
                check(request.quantity, wish)?;
                let wish = &Wish { has_colour_bar: wish.has_colour_bar && has_bar, ..wish.clone() };
                Plot::Map(content((scene, foci), request, wish)?)
            }
            Self::Difference(requests) => {
                let [request, _] = &**requests;
                let law = Law::of_difference(request.quantity, wish, 1.0);
                let bar = wish.has_colour_bar.then(|| law.bar(ColourMap::Diverging.on(wish.is_light)));
                let (axes, is_light) = (sheet::axes(&request.plane), wish.is_light);
                Plot::Map(Content { axes, bar, is_light, ..Content::default() })
            }
            Self::Shaded(request) => {
                let words = request.quantity.declaration().words;
                if !request.quantity.declaration().is_surface() {
                    bail!("a surface is shaded: show the depression, not {words}");
                }
                Plot::Surface(Surface { size: request.plane.size, ..Surface::default() })
            }
            Self::Space(prospect) => {
                let bar = wish.has_colour_bar.then(|| pressure_bar(wish.colours, wish.convention, 1.0));
                let shape = prospect.points.y / prospect.points.x;
                Plot::Space(Space { shape, bar, is_light: wish.is_light, ..Space::default() })
            }
            Self::Scattered(scattered) => {
                let has_bar = wish.has_colour_bar && (has_bar || scattered.is_difference);
                let bar = || law_of(scattered, wish, 1.0).bar(colours_of(scattered, wish));
                Plot::Map(Content {
                    axes: sheet::axes(&scattered.plane),
                    bar: has_bar.then(bar),
                    is_light: wish.is_light,
                    ..Content::default()
                })
            }
            Self::Plot(plot) => Plot::clone(plot),
        })
    }

    /// The values for a plot of so many pixels.
    fn make(&self, [width, height]: [usize; 2], stages: &mut Stages) -> Result<Made<'_>, FieldError> {
        let sized = |request: &Request| Request { size: (width, height), ..request.clone() };
        Ok(match self {
            Self::Map { request, .. } => Made::Map(request, mapped(&sized(request), stages)?),
            Self::Difference(requests) => {
                let [left, right] = &**requests;
                let left_values = stages.map(&sized(left))?.values.clone();
                let right = stages.map(&sized(right))?;
                let values = map::difference(left.quantity, &left_values, &right.values);
                Made::Difference(left, values, width)
            }
            Self::Shaded(request) => {
                let size = liquid::points(&request.plane);
                let map = mapped(&Request { size, ..request.clone() }, stages)?;
                Made::Shaded(request, map, [width, height])
            }
            Self::Space(prospect) => Made::Space(prospect, [width, height]),
            Self::Scattered(scattered) => Made::Scattered(scattered, scattered.pixels(width, height), width),
            Self::Plot(_) => Made::Plot,
        })
    }
}

fn check_size([width, height]: [usize; 2]) -> anyhow::Result<()> {
    let bytes = width.saturating_mul(height).saturating_mul(BYTES_PER_PIXEL);
    if bytes / BYTES_PER_PIXEL > MOST_PIXELS || !memory::holds(bytes) {
        bail!("{width} x {height} pixels are too many: choose fewer dots per inch or a smaller width");
    }
    Ok(())
}

/// The map, and for a liquid the steepest slope.
fn mapped(request: &Request, stages: &mut Stages) -> Result<MapOf, FieldError> {
    let map = stages.map(request)?.clone();
    let of_liquid = request.quantity.declaration().of_liquid;
    let pressed = of_liquid.then(|| stages.pressed(request)).transpose()?;
    let slope = pressed.and_then(|pressed| pressed.depression).map(|depression| depression.slope);
    Ok(MapOf { quantity: request.quantity, map, slope })
}

/// The picture of a map in colours up to `peak`, with its bar, contours and remark.
fn coloured(content: &mut Content, (quantity, map, peak): (Quantity, &Map, f64), wish: &Wish) -> Picture {
    let range = quantity.declaration().range;
    let law = Law::new((quantity, range), wish, peak);
    let table = table(quantity, wish);
    let colour = |&value: &f32| {
        // Silence has no phase.
        let value = if range == Range::Cyclic && map.peak == 0.0 { 0.0 } else { value };
        table[law.place(f64::from(value))]
    };
    let mut colours: Vec<_> = map.values.iter().map(colour).collect();
    hatch(&map.values, map.width, &mut colours);
    if let Some(bar) = &mut content.bar {
        *bar = law.bar(table);
    }
    let is_of_map = wish.full.is_none() && wish.range.is_none();
    content.remark = match is_of_map {
        true => map::remark(quantity, map),
        false => (map.within > 0).then(|| map::HATCHED.to_owned()),
    };
    if map.peak > 0.0 {
        for level in &wish.contours {
            let level = map::contour(quantity, *level, map.peak.into());
            content.contours.extend(contour::lines(&map.values, map.width, level as f32, |&value| value));
        }
    }
    Picture::from_field_order(map.width, map.height, colours.as_flattened())
}

/// Dims phases by their amplitude, if wanted.
fn dim(
    picture: &mut Picture,
    request: &Request,
    (map, wish): (&Map, &Wish),
    stages: &mut Stages,
    gpu_is_asked_for: bool,
) -> Result<(), FieldError> {
    if !wish.fades || request.quantity.declaration().range != Range::Cyclic {
        return Ok(());
    }
    let size = (map.width, map.height);
    let request = Request { quantity: Quantity::Rms, size, ..request.clone() };
    let colouring = Colouring::new(Quantity::Rms, veil(wish.is_light));
    let veil = or_by_cpu(stages, gpu_is_asked_for, |stages| {
        stages.colours(&request, &colouring).map(<[_]>::to_vec)
    })?;
    picture.veil(&Picture::from_field_order(size.0, size.1, veil.as_flattened()));
    Ok(())
}

/// The picture of a difference, with its bar.
fn subtracted(
    content: &mut Content,
    quantity: Quantity,
    (values, width): (&[f32], usize),
    wish: &Wish,
) -> Picture {
    let largest = values.iter().fold(0.0_f32, |most, value| most.max(value.abs()));
    let law = Law::of_difference(quantity, wish, largest.into());
    let table = ColourMap::Diverging.on(wish.is_light);
    let mut colours: Vec<_> = values.iter().map(|&value| table[law.place(value.into())]).collect();
    hatch(values, width, &mut colours);
    if let Some(bar) = &mut content.bar {
        *bar = law.bar(table);
    }
    Picture::from_field_order(width, values.len() / width.max(1), colours.as_flattened())
}

/// The largest modulus of some values.
fn largest(values: &[f32]) -> f32 {
    values.iter().filter(|value| !value.is_nan()).fold(0.0, |most, value| most.max(value.abs()))
}

fn law_of(scattered: &Scattered, wish: &Wish, peak: f64) -> Law {
    match scattered.is_difference {
        true => Law::of_difference(scattered.quantity, wish, peak),
        false => Law::new((scattered.quantity, scattered.quantity.declaration().range), wish, peak),
    }
}

fn colours_of(scattered: &Scattered, wish: &Wish) -> [[u8; 4]; 256] {
    match scattered.is_difference {
        true => ColourMap::Diverging.on(wish.is_light),
        false => table(scattered.quantity, wish),
    }
}

/// The picture of readings, with its bar. A difference has the range of the values, so that both are seen on one scale.
fn scattered_picture(
    content: &mut Content,
    (scattered, values, width): (&Scattered, &[f32], usize),
    peak: f64,
    wish: &Wish,
) -> Picture {
    /// Far from all readings.
    const UNREAD: [u8; 4] = [120, 120, 124, 255];
    let law = law_of(scattered, wish, peak);
    let table = colours_of(scattered, wish);
    let colour = |&value: &f32| if value.is_nan() { UNREAD } else { table[law.place(value.into())] };
    let colours: Vec<u8> = values.iter().flat_map(colour).collect();
    if let Some(bar) = &mut content.bar {
        *bar = law.bar(table);
    }
    Picture::from_field_order(width, values.len() / width.max(1), &colours)
}

/// The picture of a 3D view, with its labels and its bar.
fn viewed(space: &mut Space, prospect: &Prospect, [width, height]: [usize; 2], wish: &Wish) -> Picture {
    let (picture, volume) = prospect.draw((width, height));
    let scale = space::label_scale(wish.paper.dpi / 25.4);
    let labels = prospect.labels((width, height), scale).into_iter();
    space.labels = labels.map(|label| (label.at, label.text)).collect();
    let peak = f64::from(volume.peak);
    let pressure = |rms: f64| wish.convention.pressure(rms / Convention::Rms.of_peak());
    let part = match prospect.look.body {
        Body::Surface(part) => Some(f64::from(part)),
        Body::Projection | Body::Hidden => None,
    };
    if let Some(bar) = &mut space.bar {
        *bar = pressure_bar(wish.colours, wish.convention, peak);
        bar.table = prospect.look.colours.on(prospect.look.is_light);
        bar.mark = part.map(|part| part * bar.ends[1]);
    }
    if let Some(part) = part.filter(|_| peak > 0.0) {
        let level = -Quantity::Rms.decibels(part);
        space.remark = format!("Surface at −{level:.1} dB: {}", pressure(part * peak));
    }
    picture
}

/// The colour bar of an RMS pressure up to a value (Pa RMS), stated in a convention.
pub fn pressure_bar(colours: ColourMap, convention: Convention, peak: f64) -> Bar {
    let wish = Wish { colours, convention, ..Wish::default() };
    let law = Law::new((Quantity::Rms, Range::Amount), &wish, peak);
    law.bar(colours.table())
}

/// The picture of a surface at an angle, with bars for lengths to the right and for depths.
fn shaded(
    surface: &mut Surface,
    (request, map, deepest): (&Request, &Map, f64),
    size: [usize; 2],
    wish: &Wish,
) -> Picture {
    let (plane, place) = (&request.plane, surface::place(size));
    // Surfaces beside each other are drawn as many times as deep.
    let exaggeration = relief::exaggeration(deepest, plane.size);
    let relief = Relief { exaggeration, ..Relief::new(&map.values, map.width, plane.size) };
    // On the paper, of a metre.
    let to_the_right = place.scale(plane.size) * 25.4 / wish.paper.dpi;
    let down = relief.sinks(to_the_right);
    let measure = |metres: f64, mm: f64, words: &str| {
        let (factor, unit) = request.quantity.declaration().unit.scaled(metres);
        Measure {
            length: metres * mm,
            text: format!("{} {unit}{words}", (metres * factor * 1e6).round() / 1e6),
        }
    };
    let moment = wish.moment.as_ref().map_or_else(String::new, |moment| format!(", {moment}"));
    let drawn = format!(" deep, drawn {} ×{moment}", relief.exaggeration);
    surface.scale = wish.has_scale_bar.then(|| measure(round_step(plane.size.x / 8.0), to_the_right, ""));
    surface.depth = wish.has_colour_bar.then(|| measure(round_step(LEAST_DEPTH / down), down, &drawn));
    relief.draw(&place)
}

fn check(quantity: Quantity, wish: &Wish) -> anyhow::Result<()> {
    let declaration = quantity.declaration();
    let words = declaration.words;
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
    if wish.has_arrows && vectors::Vector::of(quantity).is_none() {
        bail!("--arrows: {words} has no direction; velocity, speed, intensity, gorkov and force have one");
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
    let is_continuous = |target: &Target| {
        target.sampling == Sampling::Continuous || target.is_area() || target.shape.is_direction()
    };
    let (mut outlines, mut rings) = (Vec::new(), Vec::new());
    if wish.has_targets {
        for target in scene.targets.iter().filter(|target| target.is_in(0) && is_continuous(target)) {
            for stroke in outline::strokes(target)? {
                outlines.push(stroke.into_iter().filter_map(place).collect());
            }
        }
        let separate = foci.iter().filter(|focus| focus.is_placed());
        rings = separate.filter_map(|focus| place(focus.position)).collect();
    }
    let range = request.quantity.declaration().range;
    let bar = || Law::new((request.quantity, range), wish, 1.0).bar(table(request.quantity, wish));
    Ok(Content {
        axes: sheet::axes(plane),
        bar: wish.has_colour_bar.then(bar),
        has_scale_bar: wish.has_scale_bar,
        remark: None,
        contours: Vec::new(),
        outlines,
        arrows: if wish.has_arrows { arrows(request) } else { Vec::new() },
        foci: rings,
        lengths: if wish.has_widths { lengths(foci, request) } else { Vec::new() },
        is_light: wish.is_light,
    })
}

/// The arrows of the quantity's vector, mm on the axes.
fn arrows(request: &Request) -> Vec<[[f64; 2]; 2]> {
    let Some((x, y)) = request.plane.axes() else { return Vec::new() };
    let place = |at: DVec2| sheet::on_plane(&request.plane, request.plane.centre + x * at.x + y * at.y);
    let on_axes = |at: DVec2| place(at).map(|DVec2 { x, y }| [x, y]);
    vectors::arrows(request)
        .into_iter()
        .filter_map(|[tail, tip]| Some([on_axes(tail)?, on_axes(tip)?]))
        .collect()
}

/// The -6 dB widths of separate foci on the plane, mm on the axes.
fn lengths(foci: &[Focus], request: &Request) -> Vec<Length> {
    let Request { plane, aperture, drives, .. } = request;
    let Some((x, y)) = plane.axes() else { return Vec::new() };
    let place = |point| sheet::on_plane(plane, point).map(|DVec2 { x, y }| [x, y]);
    let height = |point: DVec3| (point - plane.centre).dot(x.cross(y)).abs();
    let shown = foci.iter().filter(|focus| focus.is_placed() && height(focus.position) < ON_PLANE);
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
    /// Of values, or of their differences.
    range: Range,
    is_difference: bool,
    convention: Convention,
    /// The moment, after a comma, if there is one.
    moment: String,
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
    /// Of differences up to this one, about zero.
    fn of_difference(quantity: Quantity, wish: &Wish, largest: f64) -> Self {
        let wish = Wish { scale: Scale::Linear, range: None, full: None, low: None, ..wish.clone() };
        Self { is_difference: true, ..Self::new((quantity, Range::Signed), &wish, largest) }
    }

    fn new((quantity, range): (Quantity, Range), wish: &Wish, peak: f64) -> Self {
        let declaration = quantity.declaration();
        // RMS pressures and velocities are stated in either convention.
        let stated = wish.convention.factor(quantity);
        let full = wish.full.unwrap_or(if peak > 0.0 { peak } else { 1.0 });
        let largest = wish
            .range
            .filter(|_| wish.scale == Scale::Linear)
            .map_or(full * stated, |[low, high]| low.abs().max(high.abs()));
        let (factor, unit) = declaration.unit.scaled(largest);
        let low = wish.low.map(|low| low * stated).filter(|low| *low < largest);
        let ends = match (range, wish.scale) {
            (Range::Cyclic, _) => [-180.0, 180.0],
            (Range::Amount, Scale::Logarithmic) => wish.range.unwrap_or([quantity.decibels(wish.floor), 0.0]),
            (Range::Amount, Scale::Linear) => {
                wish.range.unwrap_or([low.unwrap_or(0.0), largest]).map(|end| end * factor)
            }
            (Range::Signed, _) => {
                wish.range.unwrap_or([low.unwrap_or(-largest), largest]).map(|end| end * factor)
            }
        };
        let scale = if range == Range::Amount { wish.scale } else { Scale::Linear };
        Self {
            quantity,
            range,
            is_difference: false,
            convention: wish.convention,
            moment: wish.moment.as_ref().map_or_else(String::new, |moment| format!(", {moment}")),
            scale,
            factor: factor * stated,
            unit,
            full,
            ends,
        }
    }

    /// The index of a value in a table of colours.
    fn place(&self, value: f64) -> usize {
        let number = match self.scale {
            Scale::Linear => value * self.factor,
            Scale::Logarithmic => self.quantity.decibels(value / self.full),
        };
        let part = (number - self.ends[0]) / (self.ends[1] - self.ends[0]);
        match self.range {
            // Every colour covers an equal part of the circle.
            Range::Cyclic => (part.rem_euclid(1.0) * 256.0) as usize % 256,
            Range::Amount | Range::Signed => (part.clamp(0.0, 1.0) * 255.0).round() as usize,
        }
    }

    fn bar(&self, table: [[u8; 4]; 256]) -> Bar {
        let declaration = self.quantity.declaration();
        let words = match declaration.words.strip_prefix(Convention::Rms.title()) {
            Some(rest) => format!("{}{rest}", self.convention.title()),
            None => capital(declaration.words),
        };
        let moment = &self.moment;
        let label = match self.scale {
            Scale::Linear if self.is_difference && declaration.is_root => {
                format!("Difference{moment} / {} {}", self.unit, self.convention.into_str())
            }
            Scale::Linear if self.is_difference => format!("Difference{moment} / {}", self.unit),
            Scale::Linear => format!("{words}{moment} / {}", self.unit),
            Scale::Logarithmic => {
                let stated = self.factor / declaration.unit.scaled(self.full).0;
                format!("{words}{moment} / dB re {}", self.quantity.with_unit(self.full * stated))
            }
        };
        let is_turn = self.range == Range::Cyclic;
        let quarter = |quarter: i32| {
            let degrees = 90 * quarter;
            let sign = if degrees < 0 { "−" } else { "" };
            (f64::from(degrees), format!("{sign}{}", degrees.abs()))
        };
        let numbers = is_turn.then(|| (-2..=2).map(quarter).collect());
        Bar { table, ends: self.ends, label, numbers, mark: None }
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
            let law = Law::new((Quantity::Rms, Range::Amount), &wish, 100.0);
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
        let law = Law::new((Quantity::Rms, Range::Amount), &wish, 100.0);
        assert_eq!([10.0, 20.0, 40.0, 60.0, 99.0].map(|value| law.place(value)), [0, 0, 128, 255, 255]);
        let wish = Wish { low: Some(20.0), full: Some(60.0), ..Wish::default() };
        let law = Law::new((Quantity::Rms, Range::Amount), &wish, 100.0);
        assert_eq!([10.0, 20.0, 40.0, 60.0, 99.0].map(|value| law.place(value)), [0, 0, 128, 255, 255]);
        let wish = Wish { floor: 1e-2, scale: Scale::Logarithmic, ..Wish::default() };
        let law = Law::new((Quantity::Rms, Range::Amount), &wish, 100.0);
        assert_eq!([0.1, 1.0, 10.0, 100.0].map(|value| law.place(value)), [0, 0, 128, 255]);
    }
}
