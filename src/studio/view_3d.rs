//! A 3D picture of a scene with labels: `render --view 3d`.

use std::sync::Arc;
use web_time::Instant;

use anyhow::bail;
use glam::DVec2;

use crate::field::gpu::SpacePainting;
use crate::field::volume::camera::Standard;
use crate::field::volume::scenery::{Body, Shot};
use crate::field::volume::{Block, Camera, Scenery, Volume, march};
use crate::field::{Evaluator, Quantity, Request};
use crate::memory;
use crate::picture::Picture;
use crate::picture::figure::axes::steps;
use crate::picture::space::{Bar, Words};
use crate::rounding::milliseconds;
use crate::studio::evaluator::Backend;
use crate::studio::map;
use crate::studio::output::note;
use crate::studio::space::{self, Look, Prospect, block_of};
use crate::studio::still::{self, Diagram, Size, Solved};

/// Default size of a picture in pixels, and its limit.
pub const USUAL: usize = 900;
const MOST_PIXELS: usize = 1 << 25;
/// What the field in the box lacks where that would take too long.
const LACKING: &str = "; without what bodies scatter, except on them";
/// Reference height at which a point of the screen is a pixel.
const HEIGHT: f64 = 760.0;

/// The request for a 3D picture.
#[derive(Clone, Debug)]
pub struct Wish {
    pub look: Look,
    /// Azimuth and elevation, rad.
    pub direction: [f64; 2],
    pub is_perspective: bool,
    /// Instead of the scene's own box.
    pub block: Option<Block>,
    pub size: Option<Size>,
}

impl Default for Wish {
    fn default() -> Self {
        Self {
            look: Look::default(),
            direction: Standard::Iso.direction(),
            is_perspective: true,
            block: None,
            size: None,
        }
    }
}

impl Wish {
    /// # Errors
    /// More pixels than a picture may have.
    pub fn pixels(&self) -> anyhow::Result<(usize, usize)> {
        let Size { width, height } = self.size.unwrap_or(Size { width: USUAL, height: None });
        let height = height.unwrap_or((width * 4).div_ceil(5));
        let pixels = width.saturating_mul(height);
        if pixels > MOST_PIXELS || !memory::holds(pixels.saturating_mul(16)) {
            bail!(
                "{width} x {height} pixels in space: the limit is {MOST_PIXELS}, and they must fit into memory"
            );
        }
        Ok((width, height))
    }
}

/// A picture with a description of its method.
#[derive(Debug)]
pub struct Drawn {
    pub picture: Picture,
    /// Description of its content.
    pub what: String,
    pub how: String,
}

/// The view of a scene in space, of the aspect ratio of its picture.
///
/// # Errors
/// Too many pixels, or a moment outside the motion.
pub fn prospect(solved: &Solved, look: &still::Look, wish: &Wish) -> anyhow::Result<Prospect> {
    let Solved { scene, solution, .. } = solved;
    let (width, height) = wish.pixels()?;
    let drives = still::Look { diagram: Diagram::Map(Quantity::Rms), ..look.clone() }.drives(solved)?;
    let Request { aperture, drives, .. } = Request::new(scene, drives, Quantity::Rms, (1, 1));
    let block = wish.block.unwrap_or_else(|| block_of(scene, &aperture, &solution.foci));
    let whole = space::whole(&block, &aperture);
    let scale = (height as f64 / HEIGHT).clamp(0.5, 8.0);
    Ok(Prospect {
        scene: Arc::new(scene.clone()),
        drive: drives[0].clone(),
        heard: drives.to_vec(),
        foci: solution.foci.clone(),
        clip: block,
        camera: Camera::of(&whole, wish.direction, width as f64 / height as f64, wish.is_perspective),
        look: wish.look.clone(),
        points: DVec2::new(width as f64, height as f64) / scale,
        volume: None,
        skins: None,
        block,
        aperture,
    })
}

/// Draws a scene in space. A failing GPU is replaced by the CPU with a warning, unless requested by name.
///
/// # Errors
/// Too many pixels, a moment outside the motion, failure of a requested GPU, or labels that cannot be drawn.
pub fn draw(
    solved: &Solved,
    look: &still::Look,
    wish: &Wish,
    evaluator: &Evaluator,
) -> anyhow::Result<Drawn> {
    let (width, height) = wish.pixels()?;
    let is_gpu_asked_for = look.backend == Backend::Gpu;
    let prospect = prospect(solved, look, wish)?;
    let start = Instant::now();
    let volume = prospect.volume();
    let sampled = start.elapsed();
    let scenery = prospect.scenery(width);
    let shot = Shot::new(&scenery, &volume, &prospect.camera, (width, height));
    let start = Instant::now();
    let (rgba, who) = picture((&shot, &scenery), &volume, evaluator, is_gpu_asked_for)?;
    let how = format!(
        "{} points in {}, {width} x {height} pixels by {who} in {}",
        volume.values.len(),
        milliseconds(sampled.as_secs_f64(), 1),
        milliseconds(start.elapsed().as_secs_f64(), 1)
    );
    let mut picture = Picture { width, height, rgba };
    let look = &prospect.look;
    let what = describe(look.body, &volume);
    let scale = width as f64 / prospect.points.x;
    let labels = prospect.labels((width, height), scale).into_iter();
    let words = Words {
        lines: vec![solved.name.clone(), what.clone()],
        labels: labels.map(|label| (label.at, label.text)).collect(),
        bar: (volume.peak > 0.0).then(|| bar(look, volume.peak.into())),
        is_light: look.is_light,
        scale,
    };
    words.write(&mut picture);
    Ok(Drawn { picture, what, how })
}

/// The colours of a picture, and its renderer.
fn picture(
    of: (&Shot, &Scenery),
    volume: &Arc<Volume>,
    evaluator: &Evaluator,
    is_gpu_asked_for: bool,
) -> anyhow::Result<(Vec<u8>, String)> {
    if let Evaluator::Gpu(gpu) = evaluator {
        let mut painting = SpacePainting::default();
        match painting.paint(gpu, of, volume, true).and_then(|_| painting.read(gpu)) {
            Ok(rgba) => return Ok((rgba, gpu.info().name.clone())),
            Err(error) if is_gpu_asked_for => return Err(error.into()),
            Err(error) => note(&format!("{error}; the CPU draws")),
        }
    }
    Ok((march::picture(of.0, volume, &of.1.table, true), "the CPU".to_owned()))
}

/// Description of a picture's field.
pub fn describe(body: Body, volume: &Volume) -> String {
    let peak = f64::from(volume.peak);
    if peak <= 0.0 {
        return "no sound in the box".to_owned();
    }
    let words = |value: f64| format!("{} RMS", Quantity::Rms.with_unit(value));
    let mut remark = if volume.loudest > volume.peak { format!(", {}", map::LARGER) } else { String::new() };
    if volume.is_incident {
        remark.push_str(LACKING);
    }
    let text = match body {
        Body::Surface(part) => format!(
            "Surface at −{:.1} dB of the peak: {}; peak {}",
            -Quantity::Rms.decibels(part.into()),
            words(f64::from(part) * peak),
            words(peak)
        ),
        Body::Projection => format!("Largest RMS pressure along every line of sight; peak {}", words(peak)),
        Body::Hidden => format!("RMS pressure; peak {}", words(peak)),
    };
    format!("{text}{remark}")
}

/// The colours of slices and projections.
fn bar(look: &Look, peak: f64) -> Bar {
    let (factor, unit) = Quantity::Rms.declaration().unit.scaled(peak);
    let largest = peak * factor;
    let ticks = steps(0.0, largest, 5.0).into_iter().map(|(value, text)| (value / largest, text)).collect();
    let mark = match look.body {
        Body::Surface(part) => Some(part.into()),
        Body::Hidden | Body::Projection => None,
    };
    Bar { table: look.colours.on(look.is_light), ticks, mark, title: format!("{unit} RMS") }
}
