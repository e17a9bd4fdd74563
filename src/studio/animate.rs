//! Maps of a motion or of waves, frame by frame, as one file or a folder of pictures.

use std::cell::Cell;
use std::io;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};

use crate::echo;
#[cfg(feature = "window")]
use crate::field::Evaluator;
use crate::field::quantity::Range;
use crate::field::{Colouring, FieldError, Request, Stages};
use crate::gauge::Gauge;
use crate::picture::ColourMap;
use crate::picture::animation::{Animation, Format, Pace};
use crate::picture::export::{self, Numbers};
use crate::scene::{Scene, motion};
use crate::studio::evaluator::or_by_cpu;
use crate::studio::map;
use crate::studio::output;
#[cfg(feature = "window")]
use crate::studio::still::stem;
use crate::studio::swell::{Schedule, Swell};

/// What is written.
#[derive(Clone, Debug, PartialEq)]
pub enum Target {
    File(PathBuf, Format),
    /// A PNG per frame.
    Folder(PathBuf),
}

impl Target {
    pub fn of(output: &Path) -> anyhow::Result<Self> {
        let named_as_folder = output.as_os_str().to_string_lossy().ends_with(std::path::is_separator);
        if output.is_dir() || named_as_folder {
            return Ok(Self::Folder(output.to_owned()));
        }
        match Format::of(output) {
            Some(format) => Ok(Self::File(output.to_owned(), format)),
            None => bail!(
                "{}: an animation goes into FILE.gif, FILE.png or FILE.apng, or as a PNG per frame into FOLDER/",
                output.display()
            ),
        }
    }

    /// Fails early where writing would fail after the work.
    pub fn check(&self, (width, height): (usize, usize)) -> anyhow::Result<()> {
        let Self::File(path, format) = self else { return Ok(()) };
        let most = format.largest_side();
        if width.max(height) > most {
            bail!("{}: {width} x {height} pixels: this format has room for {most} a side", path.display());
        }
        output::check_writable(path)
    }

    /// The names of a folder's pictures; none for a file.
    pub fn pictures<'a>(&'a self, name: &'a str, count: usize) -> impl Iterator<Item = PathBuf> + 'a {
        let folder = match self {
            Self::File(..) => None,
            Self::Folder(folder) => Some(folder),
        };
        let digits = count.to_string().len();
        let picture =
            move |folder: &PathBuf, index| folder.join(format!("{name}-{:0digits$}.png", index + 1));
        folder.into_iter().flat_map(move |folder| (0..count).map(move |index| picture(folder, index)))
    }

    pub fn make_folder(&self) -> anyhow::Result<()> {
        let Self::Folder(path) = self else { return Ok(()) };
        std::fs::create_dir_all(path).with_context(|| format!("{}: cannot make the folder", path.display()))
    }
}

/// Writes what the drives of a request show, one after the other, in these colours. `tell` hears which part is done, and ends it
/// with an error.
///
/// # Errors
/// A file that is neither GIF nor PNG or cannot be written, too many pixels for it, or what `tell` says.
#[cfg(feature = "window")]
pub fn write(
    scene: &Scene,
    request: Request,
    colouring: Colouring,
    path: &Path,
    tell: &dyn Fn(f64) -> anyhow::Result<()>,
) -> anyhow::Result<()> {
    let target = Target::of(path)?;
    target.check(request.size)?;
    target.make_folder()?;
    let mut film = Film::new(scene, request, Stages::new(Evaluator::Cpu), colouring);
    film.shoot(&target, &stem(path), tell).map(drop)
}

/// Where the times of all frames go, beside their numbers.
pub fn times_of(data: &Path) -> PathBuf {
    data.with_extension("times.npy")
}

/// What was written.
#[derive(Debug)]
pub struct Shot {
    frames: usize,
    pace: Pace,
    /// What the colours tell, in words.
    range: String,
    /// What it is that is shown as fast as it is.
    what: String,
}

impl Shot {
    /// How many pictures follow each other, of waves as of a motion.
    pub fn frames(&self) -> usize {
        self.frames
    }

    pub fn line(&self, output: &Path, (width, height): (usize, usize)) -> String {
        let Self { frames, pace, range, what } = self;
        let name = if *frames == 1 { "frame" } else { "frames" };
        let line = format!("{}: {frames} {name} of {width} x {height} pixels{range}", echo::path(output));
        if *frames == 1 {
            return line;
        }
        let shown = match pace.slowed {
            slowed if slowed > 1.001 => {
                format!("shown slowed down {slowed:.1} x: viewers show no frame for less than 20 ms")
            }
            slowed if slowed < 0.999 => {
                format!("shown {:.1} x as fast: no frame lasts longer than 60 s", 1.0 / slowed)
            }
            _ => "and so it does here".to_owned(),
        };
        format!("{line}; {what}, {shown}")
    }
}

/// Makes the map of one frame after the other.
#[derive(Debug)]
pub struct Film<'a> {
    scene: &'a Scene,
    /// But for the frame's drive or surface.
    request: Request,
    stages: Stages,
    pub gpu_is_asked_for: bool,
    /// But for the range, which all frames share.
    colouring: Colouring,
    /// Of waves, if they are shown.
    pub schedule: Option<Schedule>,
    /// Begins to show the progress of a step of this name.
    pub begin: fn(&'static str) -> Gauge,
    /// The values of all frames of waves go there, and the times beside it.
    pub data: Option<PathBuf>,
    /// The largest error of a map so far, relative to its peak, and the steepest slope of a surface.
    pub error: f64,
    pub slope: f64,
}

impl<'a> Film<'a> {
    /// `request` has the drives of all frames.
    pub fn new(scene: &'a Scene, request: Request, stages: Stages, colouring: Colouring) -> Self {
        Self {
            scene,
            request,
            stages,
            gpu_is_asked_for: false,
            colouring,
            schedule: None,
            begin: |_| Gauge::default(),
            data: None,
            error: 0.0,
            slope: 0.0,
        }
    }

    /// Two passes, so that no more than one map is ever in memory: the first finds the range of the colours, which all frames
    /// share, the second writes.
    pub fn shoot(
        &mut self,
        target: &Target,
        name: &str,
        tell: &dyn Fn(f64) -> anyhow::Result<()>,
    ) -> anyhow::Result<Shot> {
        let table = &self.colouring.table.clone();
        let size = self.request.size;
        let count = self.schedule.map_or(self.request.drives.len(), |schedule| schedule.pictures);
        let (done, progress) = (Cell::new(0), (self.begin)("the maps of all frames"));
        let step = || {
            done.set(done.get() + 1);
            progress.tell(done.get(), 2 * count);
            tell(done.get() as f64 / (2 * count) as f64)
        };
        let range = self.measured(count, &step)?;
        let frames_per_second = self.schedule.map_or(self.frames_per_second(), Schedule::rate);
        let pace = Pace::new(frames_per_second);
        match target {
            Target::File(path, format) => output::write_by(path, |file| {
                let mut animation = Animation::new(file, *format, size, table, count as u32, pace)?;
                self.each(|film, _, request| {
                    animation.add(&film.places(request, range)?)?;
                    step()
                })?;
                Ok(animation.finish()?)
            })?,
            Target::Folder(_) => {
                let mut paths = target.pictures(name, count);
                self.each(|film, _, request| {
                    let places = film.places(request, range)?;
                    let path = paths.next().context("a picture has no name")?;
                    step()?;
                    output::write_by(&path, |file| {
                        let mut picture = Animation::new(file, Format::Png, size, table, 1, pace)?;
                        picture.add(&places)?;
                        Ok(picture.finish()?)
                    })
                })?;
            }
        }
        let what = match self.schedule {
            None => format!("a cycle takes {:.3} s", count as f64 / frames_per_second),
            Some(_) => format!("it takes {:.3} s", count as f64 / frames_per_second),
        };
        Ok(Shot { frames: count, pace, range: self.in_words(range), what })
    }

    /// Of the motion; a scene that stands still shows its one frame for a second.
    fn frames_per_second(&self) -> f64 {
        motion::cycle(self.scene).map_or(1.0, |cycle| cycle.frames_per_second())
    }

    /// The range of all frames; their values are written if they are wanted.
    fn measured(&mut self, count: usize, step: &dyn Fn() -> anyhow::Result<()>) -> anyhow::Result<[f32; 2]> {
        let mut range = [0.0f32; 2];
        let mut measure =
            |film: &mut Self, request: &Request, take: &mut dyn FnMut(&[f32]) -> io::Result<()>| {
                let [low, high] = film.extent(request, take)?;
                range = [range[0].min(low), range[1].max(high)];
                step()
            };
        let Some(path) = self.data.clone() else {
            self.each(|film, _, request| measure(film, request, &mut |_| Ok(())))?;
            return Ok(range);
        };
        let (width, height) = self.request.size;
        output::write_by(&path, |file| {
            let mut numbers = Numbers::new(file, &[count as u64, height as u64, width as u64])?;
            self.each(|film, _, request| measure(film, request, &mut |values| numbers.add(values)))?;
            Ok(numbers.finish()?)
        })?;
        let rate = self.schedule.map_or(self.frames_per_second(), Schedule::rate);
        let times: Vec<_> = (1..=count).map(|frame| (frame as f64 / rate) as f32).collect();
        output::write(&times_of(&path), &export::npy(&[count as u64], &times)?)?;
        Ok(range)
    }

    fn in_words(&self, [low, high]: [f32; 2]) -> String {
        let quantity = self.request.quantity;
        let declaration = quantity.declaration();
        match (self.schedule, declaration.range) {
            (Some(_), _) => {
                format!(", depth {} to {}", quantity.with_unit(low.into()), quantity.with_unit(high.into()))
            }
            (None, Range::Cyclic) => String::new(),
            (None, Range::Amount | Range::Signed) => {
                format!(", {}", map::extent(quantity, high.into()))
            }
        }
    }

    /// Hands out what every frame is requested by.
    fn each(
        &mut self,
        mut take: impl FnMut(&mut Self, usize, &Request) -> anyhow::Result<()>,
    ) -> anyhow::Result<()> {
        let all = self.request.clone();
        let Some(schedule) = self.schedule else {
            for (index, drive) in all.drives.iter().enumerate() {
                take(self, index, &Request { drives: [drive.clone()].into(), ..all.clone() })?;
            }
            return Ok(());
        };
        let (scene, asked_for, begin) = (self.scene, self.gpu_is_asked_for, self.begin);
        let mut swell = or_by_cpu(&mut self.stages, asked_for, |stages| {
            Swell::new(scene, schedule, &all, stages, &begin("the surfaces at rest of all frames"))
        })?;
        let first = Request { drives: [all.drives[0].clone()].into(), part: 1.0, ..all };
        for index in 0..schedule.pictures {
            take(self, index, &Request { depth: Some(swell.next_surface()), ..first.clone() })?;
        }
        Ok(())
    }

    /// The smallest and the largest value of a frame; its values go to `take`.
    fn extent(
        &mut self,
        request: &Request,
        take: &mut dyn FnMut(&[f32]) -> io::Result<()>,
    ) -> anyhow::Result<[f32; 2]> {
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
        Ok(match request.depth {
            Some(_) => map.values.iter().fold([0.0; 2], |[low, high], &h| [h.min(low), h.max(high)]),
            None => [0.0, map.peak],
        })
    }

    /// The place of every pixel in a table of colours that covers a range.
    fn places(&mut self, request: &Request, [low, high]: [f32; 2]) -> Result<Vec<u8>, FieldError> {
        // In shades of grey, a colour is its place.
        let table = ColourMap::Grey.table();
        let colouring = Colouring { table, full: Some(high), ..self.colouring.clone() };
        or_by_cpu(&mut self.stages, self.gpu_is_asked_for, |stages| {
            if request.depth.is_some() {
                let scale = 255.0 / (high - low).max(f32::MIN_POSITIVE);
                let place = |&h: &f32| ((h - low) * scale + 0.5) as u8;
                return Ok(stages.map(request)?.values.iter().map(place).collect());
            }
            Ok(stages.colours(request, &colouring)?.iter().map(|[place, ..]| *place).collect())
        })
    }
}
