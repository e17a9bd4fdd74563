//! Films: a motion or waves, frame by frame, as one file or a folder of pictures.

mod target;

use std::cell::Cell;
use std::io;
use std::path::{Path, PathBuf};

use anyhow::Context;

use crate::echo;
use crate::field::{Colouring, HATCH, Quantity, Range, Request, Stages, hatch};
use crate::gauge::Gauge;
use crate::picture::Picture;
use crate::picture::animation::{Animation, Colours, Format, Pace};
use crate::picture::numbers::{self, Numbers};
use crate::picture::relief::{self, Relief};
use crate::scene::{Scene, motion};
use crate::studio::evaluator::or_by_cpu;
use crate::studio::liquid::{self, Moment};
use crate::studio::map;
#[cfg(feature = "window")]
use crate::studio::opening::stem;
use crate::studio::output;
use crate::studio::swell::{Schedule, Swell};
use crate::studio::video::Video;
use target::Encoding;
pub use target::{Kind, RATES, Target};

/// Writes a film. `tell` receives the completed fraction, and cancels with an error.
///
/// # Errors
/// An unsupported or unwritable file, too many pixels for it, or an error of `tell`.
#[cfg(feature = "window")]
pub fn write(
    film: &mut Film<'_>,
    path: &Path,
    tell: &dyn Fn(f64) -> anyhow::Result<()>,
) -> anyhow::Result<()> {
    let target = Target::of(path)?;
    target.check(film.size(), film.rate)?;
    target.make_folder()?;
    film.shoot(&target, &stem(path), tell).map(drop)
}

/// The file for the times of all frames, beside their data.
pub fn times_of(data: &Path) -> PathBuf {
    data.with_extension("times.npy")
}

/// The written film.
#[derive(Debug)]
pub struct Shot {
    frames: usize,
    pace: Pace,
    /// Whether the frame rate was requested.
    is_chosen: bool,
    /// Description of the colours.
    range: String,
    /// Description of the real-time content.
    what: String,
}

impl Shot {
    /// Number of frames, of waves or of a motion.
    pub fn frames(&self) -> usize {
        self.frames
    }

    pub fn line(&self, output: &Path, (width, height): (usize, usize)) -> String {
        let Self { frames, pace, is_chosen, range, what } = self;
        let because = |why: &'static str| if *is_chosen { "" } else { why };
        let name = if *frames == 1 { "frame" } else { "frames" };
        let line = format!("{}: {frames} {name} of {width} x {height} pixels{range}", echo::path(output));
        if *frames == 1 {
            return line;
        }
        let shown = match pace.slowed {
            slowed if slowed > 1.001 => {
                let why = because(": viewers show no frame for less than 20 ms");
                format!("shown slowed down {slowed:.1} x{why}")
            }
            slowed if slowed < 0.999 => {
                let why = because(": no frame lasts longer than 60 s");
                format!("shown {:.1} x as fast{why}", 1.0 / slowed)
            }
            _ => "and so it does here".to_owned(),
        };
        format!("{line}; {what}, {shown}")
    }
}

/// The content of every frame.
#[derive(Clone, Debug)]
pub enum Look {
    /// A map. By default the colours extend to the largest value of all frames.
    Flat(Box<Colouring>),
    /// The shaded surface of the liquid, on a page of this size. The request's pixels are the points of the surface.
    Shaded { name: String, page: (usize, usize) },
}

/// Data common to all frames.
#[derive(Debug, Default)]
struct Extent {
    /// The smallest and the largest value, including 0.
    range: [f32; 2],
    /// Whether values near elements exceed it.
    has_larger: bool,
    /// The values of the frame with the largest magnitude, for a palette.
    farthest: Option<Vec<f32>>,
}

impl Extent {
    fn deepest(&self) -> f32 {
        self.range[1].max(-self.range[0])
    }
}

/// Pictures of the skin in a period of its motion.
#[derive(Clone, Copy, Debug)]
struct Period {
    pictures: usize,
    seconds: f64,
}

impl Period {
    /// `None` of other quantities.
    fn new(request: &Request) -> Option<Self> {
        /// Pictures of a period, at least, if its sound has no frames.
        const FEWEST: usize = 32;
        let seconds = request.course.usual_span();
        let pictures = if seconds > 0.0 { request.drives.len().max(FEWEST) } else { 1 };
        let of_skin = request.quantity.declaration().of_skin;
        of_skin.then_some(Self { pictures, seconds: if seconds > 0.0 { seconds } else { 1.0 } })
    }
}

/// Draws one frame after the other.
#[derive(Debug)]
pub struct Film<'a> {
    scene: &'a Scene,
    /// Without the frame's drive or surface.
    request: Request,
    stages: Stages,
    pub gpu_is_asked_for: bool,
    look: Look,
    /// Displayed frames per second; `None`: real time, as far as viewers allow.
    pub rate: Option<f64>,
    /// The schedule of waves, if shown.
    pub schedule: Option<Schedule>,
    /// Pictures of the moving skin, if shown.
    skin: Option<Period>,
    /// The waves, once made.
    swell: Option<Swell>,
    /// Begins to show the progress of a step of this name.
    pub begin: fn(&'static str) -> Gauge,
    /// File for the values of all frames of waves, with the times beside it.
    pub data: Option<PathBuf>,
    /// The largest error of a map so far, relative to its peak, and the steepest slope of a surface.
    pub error: f64,
    pub slope: f64,
}

impl<'a> Film<'a> {
    /// `request` has the drives of all frames.
    pub fn new(scene: &'a Scene, request: Request, stages: Stages, look: Look) -> Self {
        // A level is that of the whole cycle: what moves is the skin.
        let is_level = request.quantity.declaration().is_level();
        let quantity = if is_level { Quantity::Skin } else { request.quantity };
        let request = Request { quantity, ..request };
        Self {
            scene,
            skin: Period::new(&request),
            request,
            stages,
            gpu_is_asked_for: false,
            look,
            rate: None,
            schedule: None,

            swell: None,
            begin: |_| Gauge::default(),
            data: None,
            error: 0.0,
            slope: 0.0,
        }
    }

    /// Pixels of a frame.
    pub fn size(&self) -> (usize, usize) {
        match self.look {
            Look::Flat(_) => self.request.size,
            Look::Shaded { page, .. } => page,
        }
    }

    /// Two passes, so that only one map is in memory at a time: the first finds the common range, the second writes.
    pub fn shoot(
        &mut self,
        target: &Target,
        name: &str,
        tell: &dyn Fn(f64) -> anyhow::Result<()>,
    ) -> anyhow::Result<Shot> {
        let size = self.size();
        let count = match (self.schedule, self.skin) {
            (Some(schedule), _) => schedule.pictures,
            (None, Some(period)) => period.pictures,
            (None, None) => self.request.drives.len(),
        };
        let (done, progress) = (Cell::new(0), (self.begin)("the maps of all frames"));
        let step = || {
            done.set(done.get() + 1);
            progress.tell(done.get(), 2 * count);
            tell(done.get() as f64 / (2 * count) as f64)
        };
        let extent = self.measured(count, &step)?;
        let frames_per_second = self.schedule.map_or(self.frames_per_second(), Schedule::rate);
        let pace = self
            .rate
            .map_or_else(|| Pace::new(frames_per_second), |rate| Pace::chosen(rate, frames_per_second));
        match target {
            Target::File(path, kind) => output::write_by(path, |file| match kind.encoding() {
                Encoding::Pictures(format) => {
                    let colours = self.colours(&extent)?;
                    let mut animation = Animation::new(file, format, size, &colours, count as u32, pace)?;
                    self.each(|film, index, request| {
                        animation.add(&film.picture(index, request, &extent)?)?;
                        step()
                    })?;
                    Ok(animation.finish()?)
                }
                Encoding::Video(codec) => {
                    let mut video = Video::new(codec, size, 1.0 / pace.per_frame)?;
                    self.each(|film, index, request| {
                        video.add(&film.picture(index, request, &extent)?)?;
                        step()
                    })?;
                    video.finish(file, &|| tell(1.0))
                }
            })?,
            Target::Folder(_) => {
                let colours = self.colours(&extent)?;
                let mut paths = target.pictures(name, count);
                self.each(|film, index, request| {
                    let frame = film.picture(index, request, &extent)?;
                    let path = paths.next().context("a picture has no name")?;
                    step()?;
                    output::write_by(&path, |file| {
                        let mut picture = Animation::new(file, Format::Png, size, &colours, 1, pace)?;
                        picture.add(&frame)?;
                        Ok(picture.finish()?)
                    })
                })?;
            }
        }
        let what = match self.schedule {
            None => format!("a cycle takes {:.3} s", count as f64 / frames_per_second),
            Some(_) => format!("it takes {:.3} s", count as f64 / frames_per_second),
        };
        let is_chosen = self.rate.is_some();
        Ok(Shot { frames: count, pace, is_chosen, range: self.in_words(&extent), what })
    }

    /// Frame rate of the motion; a scene at rest shows its single frame for a second.
    fn frames_per_second(&self) -> f64 {
        if let Some(Period { pictures, seconds }) = self.skin {
            return pictures as f64 / seconds;
        }
        motion::cycle(self.scene).map_or(1.0, |cycle| cycle.frames_per_second())
    }

    /// Measures all frames; writes their values if requested.
    fn measured(&mut self, count: usize, step: &dyn Fn() -> anyhow::Result<()>) -> anyhow::Result<Extent> {
        let mut extent = Extent::default();
        let mut measure =
            |film: &mut Self, request: &Request, take: &mut dyn FnMut(&[f32]) -> io::Result<()>| {
                film.measure(request, &mut extent, take)?;
                step()
            };
        if let Some(path) = self.data.clone() {
            let (width, height) = self.request.size;
            output::write_by(&path, |file| {
                let mut numbers = Numbers::new(file, &[count as u64, height as u64, width as u64])?;
                self.each(|film, _, request| measure(film, request, &mut |values| numbers.add(values)))?;
                Ok(numbers.finish()?)
            })?;
            let rate = self.schedule.map_or(self.frames_per_second(), Schedule::rate);
            let times: Vec<_> = (1..=count).map(|frame| (frame as f64 / rate) as f32).collect();
            output::write(&times_of(&path), &numbers::npy(&[count as u64], &times)?)?;
        } else {
            self.each(|film, _, request| measure(film, request, &mut |_| Ok(())))?;
        }
        Ok(extent)
    }

    fn in_words(&self, extent: &Extent) -> String {
        let [low, high] = extent.range;
        let quantity = self.request.quantity;
        let declaration = quantity.declaration();
        match (self.schedule.is_some() || self.skin.is_some(), declaration.range) {
            (true, _) => {
                let what = if declaration.of_light { declaration.words } else { "depth" };
                format!(", {what} {} to {}", quantity.with_unit(low.into()), quantity.with_unit(high.into()))
            }
            (false, Range::Cyclic) => String::new(),
            (false, Range::Amount | Range::Signed) => {
                let remark = if extent.has_larger { format!(", {}", map::LARGER) } else { String::new() };
                format!(", {}{remark}", map::extent(quantity, high.into()))
            }
        }
    }

    /// Calls back with the request of every frame.
    fn each(
        &mut self,
        mut take: impl FnMut(&mut Self, usize, &Request) -> anyhow::Result<()>,
    ) -> anyhow::Result<()> {
        let all = self.request.clone();
        if let Some(Period { pictures, seconds }) = self.skin {
            for index in 0..pictures {
                let time = index as f64 * seconds / pictures as f64;
                let depth = or_by_cpu(&mut self.stages, self.gpu_is_asked_for, |stages| {
                    Ok(stages.skin(&all)?.surface(time))
                })?;
                take(self, index, &Request { depth: Some(depth), ..all.clone() })?;
            }
            return Ok(());
        }
        let Some(schedule) = self.schedule else {
            for (index, drive) in all.drives.iter().enumerate() {
                take(self, index, &Request { drives: [drive.clone()].into(), ..all.clone() })?;
            }
            return Ok(());
        };
        let (scene, asked_for, begin) = (self.scene, self.gpu_is_asked_for, self.begin);
        let mut swell = match self.swell.take() {
            Some(swell) => swell,
            None => or_by_cpu(&mut self.stages, asked_for, |stages| {
                Swell::new(scene, schedule, &all, stages, &begin("the surfaces at rest of all frames"))
            })?,
        };
        let first = Request { drives: [all.drives[0].clone()].into(), part: 1.0, ..all };
        for index in 0..schedule.pictures {
            take(self, index, &Request { depth: Some(swell.next_surface()), ..first.clone() })?;
        }
        swell.restart();
        self.swell = Some(swell);
        Ok(())
    }

    /// Adds a frame to the common data; passes its values to `take`.
    fn measure(
        &mut self,
        request: &Request,
        extent: &mut Extent,
        take: &mut dyn FnMut(&[f32]) -> io::Result<()>,
    ) -> anyhow::Result<()> {
        let of_liquid = request.quantity.declaration().of_liquid;
        let (map, slope) = or_by_cpu(&mut self.stages, self.gpu_is_asked_for, |stages| {
            let map = stages.map(request)?.clone();
            let pressed = of_liquid.then(|| stages.pressed(request)).transpose()?;
            let depression = pressed.and_then(|pressed| pressed.depression);
            Ok((map, depression.map_or(0.0, |depression| depression.slope)))
        })?;
        take(&map.values)?;
        self.error = self.error.max(map.error);
        self.slope = self.slope.max(slope);
        let [low, high] = match request.depth {
            Some(_) => map.values.iter().fold([0.0; 2], |[low, high], &h| [h.min(low), h.max(high)]),
            None => [0.0, map.peak],
        };
        extent.has_larger |= map.has_larger();
        let before = extent.deepest();
        extent.range = [extent.range[0].min(low), extent.range[1].max(high)];
        let is_farthest = extent.farthest.is_none() || extent.deepest() > before;
        if matches!(self.look, Look::Shaded { .. }) && is_farthest {
            extent.farthest = Some(map.values);
        }
        Ok(())
    }

    /// The colours of the frames.
    fn colours(&self, extent: &Extent) -> anyhow::Result<Colours> {
        Ok(match &self.look {
            Look::Flat(colouring) => {
                let mut table = colouring.table;
                if !self.scene.bodies.is_empty() {
                    // The two places of a palette that are missed least.
                    [table[1], table[3]] = HATCH;
                }
                Colours::Map(Box::new(table))
            }
            Look::Shaded { name, page } => Colours::Like(self.shaded(
                0,
                extent.farthest.as_deref().unwrap_or_default(),
                extent,
                (name, *page),
            )?),
        })
    }

    fn picture(&mut self, index: usize, request: &Request, extent: &Extent) -> anyhow::Result<Picture> {
        let (width, height) = request.size;
        let [low, high] = extent.range;
        match self.look.clone() {
            Look::Flat(colouring) if request.depth.is_some() => {
                let scale = 255.0 / (high - low).max(f32::MIN_POSITIVE);
                let colour = |&h: &f32| colouring.table[usize::from(((h - low) * scale + 0.5) as u8)];
                let map = or_by_cpu(&mut self.stages, self.gpu_is_asked_for, |stages| {
                    let values = &stages.map(request)?.values;
                    let mut colours: Vec<_> = values.iter().map(colour).collect();
                    hatch(values, width, &mut colours);
                    Ok(colours)
                })?;
                Ok(Picture::from_field_order(width, height, map.as_flattened()))
            }
            Look::Flat(colouring) => {
                let colouring = Colouring { full: colouring.full.or(Some(high)), ..*colouring };
                or_by_cpu(&mut self.stages, self.gpu_is_asked_for, |stages| {
                    let colours = stages.colours(request, &colouring)?;
                    Ok(Picture::from_field_order(width, height, colours.as_flattened()))
                })
                .map_err(Into::into)
            }
            Look::Shaded { name, page } => {
                let depth = or_by_cpu(&mut self.stages, self.gpu_is_asked_for, |stages| {
                    Ok(stages.map(request)?.values.clone())
                })?;
                self.shaded(index, &depth, extent, (&name, page))
            }
        }
    }

    /// A frame's surface on a page.
    fn shaded(
        &self,
        index: usize,
        depth: &[f32],
        extent: &Extent,
        (name, page): (&str, (usize, usize)),
    ) -> anyhow::Result<Picture> {
        let size = self.request.plane.size;
        let exaggeration = relief::exaggeration(extent.deepest().into(), size);
        let relief = Relief { exaggeration, ..Relief::new(depth, self.request.size.0, size) };
        let moment = match self.schedule {
            Some(schedule) => Moment::Time((index + 1) as f64 / schedule.rate()),
            None => Moment::Frame(index, self.request.drives.len()),
        };
        Ok(liquid::frame(name, self.scene, (&relief, extent.range), (moment, self.slope), page))
    }
}
