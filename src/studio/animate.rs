//! Maps of a motion or of waves, frame by frame, as one file or a folder of pictures.

use std::cell::Cell;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};

use crate::acoustics::Aperture;
use crate::drive::Drive;
use crate::field::{self, Average, Colouring, Evaluator, FieldError, Mean, Stages, Wanted};
use crate::picture::animation::{Animation, Format, Pace};
use crate::picture::{ColourMap, sheet};
use crate::scene::Scene;
use crate::solver::frames::Sequence;
use crate::studio::map;
use crate::studio::output::{self, note};
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
    /// A folder if there is one or the path ends like one, else a file of the format that its name says.
    ///
    /// # Errors
    /// A name that says no format.
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
    ///
    /// # Errors
    /// More pixels than the format has room for, or a file that cannot be written.
    pub fn check(&self, (width, height): (usize, usize)) -> anyhow::Result<()> {
        let Self::File(path, format) = self else { return Ok(()) };
        let most = format.largest_side();
        if width.max(height) > most {
            bail!("{}: {width} x {height} pixels: this format has room for {most} a side", path.display());
        }
        output::check_writable(path)
    }

    /// # Errors
    /// A folder that cannot be made.
    pub fn make_folder(&self) -> anyhow::Result<()> {
        let Self::Folder(path) = self else { return Ok(()) };
        std::fs::create_dir_all(path).with_context(|| format!("{}: cannot make the folder", path.display()))
    }
}

/// Writes the round of a moving scene as maps of its plane, in these colours. `tell` hears which part is done, and ends it with an
/// error.
///
/// # Errors
/// A file that is neither GIF nor PNG or cannot be written, too many pixels for it, or what `tell` says.
pub fn write(
    scene: &Scene,
    sequence: &Sequence,
    colouring: Colouring,
    size: (usize, usize),
    path: &Path,
    tell: &dyn Fn(f64) -> anyhow::Result<()>,
) -> anyhow::Result<()> {
    let target = Target::of(path)?;
    target.check(size)?;
    target.make_folder()?;
    let mut film = Film::new(scene, sequence, Stages::new(Evaluator::Cpu), colouring, size);
    film.shoot(sequence, &target, &stem(path), tell).map(drop)
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
    /// What is said of it when it has been written.
    pub fn line(&self, output: &Path, (width, height): (usize, usize)) -> String {
        let Self { frames, pace, range, what } = self;
        let name = if *frames == 1 { "frame" } else { "frames" };
        let line = format!("{}: {frames} {name} of {width} x {height} pixels{range}", output.display());
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

/// What one frame shows.
enum Moment<'a> {
    Drive(&'a Drive),
    /// The depth of every cell of a liquid's surface, m.
    Surface(Vec<f64>),
}

/// Makes the map of one frame after the other.
#[derive(Debug)]
pub struct Film<'a> {
    scene: &'a Scene,
    aperture: Aperture,
    /// Of the first frame.
    first: Drive,
    stages: Stages,
    pub gpu_is_asked_for: bool,
    /// But for the range, which all frames share.
    colouring: Colouring,
    /// What the quantity is the average of, if it is one.
    mean: Option<Mean>,
    size: (usize, usize),
    /// Of waves, if they are shown.
    pub schedule: Option<Schedule>,
    /// The largest error of a map so far, relative to its peak, and the steepest slope of a surface.
    pub error: f64,
    pub slope: f64,
}

impl<'a> Film<'a> {
    /// Of a sequence of at least one frame.
    pub fn new(
        scene: &'a Scene,
        sequence: &Sequence,
        stages: Stages,
        colouring: Colouring,
        size: (usize, usize),
    ) -> Self {
        Self {
            aperture: Aperture::new(scene),
            first: sequence.frames[0].drive.clone(),
            scene,
            stages,
            gpu_is_asked_for: false,
            mean: map::mean(scene, colouring.quantity),
            colouring,
            size,
            schedule: None,
            error: 0.0,
            slope: 0.0,
        }
    }

    /// Writes all frames; `tell` hears which part is done, and ends it with an error.
    ///
    /// Two passes, so that no more than one map is ever in memory: the first finds the range of the colours, which all frames
    /// share, the second writes.
    ///
    /// # Errors
    /// A field that cannot be computed, a file that cannot be written, or what `tell` says.
    pub fn shoot(
        &mut self,
        sequence: &Sequence,
        target: &Target,
        name: &str,
        tell: &dyn Fn(f64) -> anyhow::Result<()>,
    ) -> anyhow::Result<Shot> {
        let table = &self.colouring.table.clone();
        let has_range = self.colouring.quantity != field::Quantity::Phase;
        let count = self.schedule.map_or(sequence.frames.len(), |schedule| schedule.pictures);
        let steps = (count * if has_range { 2 } else { 1 }) as f64;
        let done = Cell::new(0.0);
        let step = || {
            done.set(done.get() + 1.0);
            tell(done.get() / steps)
        };
        let mut range = [0.0f32; 2];
        if has_range {
            self.each(sequence, |film, _, moment| {
                let [low, high] = film.extent(&moment)?;
                range = [range[0].min(low), range[1].max(high)];
                step()
            })?;
        }
        let frames_per_second = self.schedule.map_or(self.scene.motion.frames_per_second(), Schedule::rate);
        let pace = Pace::new(frames_per_second);
        let size = self.size;
        match target {
            Target::File(path, format) => output::write_by(path, |file| {
                let mut animation = Animation::new(file, *format, size, table, count as u32, pace)?;
                self.each(sequence, |film, _, moment| {
                    animation.add(&film.places(&moment, range)?)?;
                    step()
                })?;
                Ok(animation.finish()?)
            })?,
            Target::Folder(folder) => {
                let digits = count.to_string().len();
                self.each(sequence, |film, index, moment| {
                    let places = film.places(&moment, range)?;
                    let path = folder.join(format!("{name}-{:0digits$}.png", index + 1));
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
            None => format!("a round takes {:.3} s", 1.0 / self.scene.motion.rate),
            Some(_) => format!("it takes {:.3} s", count as f64 / frames_per_second),
        };
        Ok(Shot { frames: count, pace, range: self.in_words(range), what })
    }

    fn in_words(&self, [low, high]: [f32; 2]) -> String {
        let micrometres = |depth: f32| f64::from(depth) * 1e6;
        match self.colouring.quantity {
            field::Quantity::Phase | field::Quantity::Instantaneous => String::new(),
            field::Quantity::Rms | field::Quantity::MeanRms => {
                format!(", RMS pressure up to {}", sheet::pascals(f64::from(high) / std::f64::consts::SQRT_2))
            }
            field::Quantity::Radiation => {
                format!(", radiation pressure up to {}", sheet::pascals(f64::from(high)))
            }
            field::Quantity::Dent if self.schedule.is_some() => {
                format!(", depth {:.1} to {:.1} µm", micrometres(low), micrometres(high))
            }
            field::Quantity::Dent => format!(", up to {:.1} µm deep", micrometres(high)),
        }
    }

    /// Hands out what every frame shows.
    fn each(
        &mut self,
        sequence: &Sequence,
        mut take: impl FnMut(&mut Self, usize, Moment<'_>) -> anyhow::Result<()>,
    ) -> anyhow::Result<()> {
        let Some(schedule) = self.schedule else {
            for (index, frame) in sequence.frames.iter().enumerate() {
                take(self, index, Moment::Drive(&frame.drive))?;
            }
            return Ok(());
        };
        let drives: Vec<_> = sequence.frames.iter().map(|frame| frame.drive.clone()).collect();
        let scene = self.scene;
        let mut swell =
            self.on_average(&drives, |stages, wanted| Swell::new(scene, schedule, wanted, stages))?;
        for index in 0..schedule.pictures {
            take(self, index, Moment::Surface(swell.next()))?;
        }
        Ok(())
    }

    /// The smallest and the largest of what a frame shows: 0 and |P| (Pa, peak) of a field, or its numbers.
    fn extent(&mut self, moment: &Moment<'_>) -> Result<[f32; 2], FieldError> {
        match moment {
            Moment::Surface(depth) => {
                let numbers = self.shape(depth)?;
                let first = self.first.clone();
                let slope = self.on_average(std::slice::from_ref(&first), |stages, wanted| {
                    let tank = stages.average(wanted)?.tank.as_ref();
                    Ok(tank.map_or(0.0, |tank| tank.dent_of(depth.clone(), 0.0).slope))
                })?;
                self.slope = self.slope.max(slope);
                Ok(numbers.iter().fold([0.0; 2], |[low, high], &h| [h.min(low), h.max(high)]))
            }
            Moment::Drive(drive) => {
                let (largest, error, slope) = match self.mean {
                    None => self.on_field(drive, |stages, wanted| {
                        stages.map(wanted).map(|map| (map.peak, map.error, 0.0))
                    })?,
                    Some(_) => self.on_average(std::slice::from_ref(drive), |stages, wanted| {
                        let map = stages.average(wanted)?;
                        Ok((map.largest, map.error, map.dent.as_ref().map_or(0.0, |dent| dent.slope)))
                    })?,
                };
                self.error = error.max(self.error);
                self.slope = slope.max(self.slope);
                Ok([0.0, largest])
            }
        }
    }

    /// The place of every pixel in a table of colours that covers a range.
    fn places(&mut self, moment: &Moment<'_>, [low, high]: [f32; 2]) -> Result<Vec<u8>, FieldError> {
        // In shades of grey, a colour is its place.
        let table = ColourMap::Grey.table();
        let colouring = Colouring { table, full: Some(high), ..self.colouring.clone() };
        let places = |colours: &[[u8; 4]]| colours.iter().map(|[place, ..]| *place).collect();
        match moment {
            Moment::Surface(depth) => {
                let scale = 255.0 / (high - low).max(f32::MIN_POSITIVE);
                Ok(self.shape(depth)?.iter().map(|h| ((h - low) * scale + 0.5) as u8).collect())
            }
            Moment::Drive(drive) if self.mean.is_none() => {
                self.on_field(drive, |stages, wanted| stages.colours(wanted, &colouring).map(places))
            }
            Moment::Drive(drive) => self.on_average(std::slice::from_ref(drive), |stages, wanted| {
                stages.average_colours(wanted, &colouring).map(places)
            }),
        }
    }

    /// The pixels of a liquid's surface, m.
    fn shape(&mut self, depth: &[f64]) -> Result<Vec<f32>, FieldError> {
        let first = self.first.clone();
        self.on_average(std::slice::from_ref(&first), |stages, wanted| stages.read_shape(wanted, depth))
    }

    fn on_field<T>(
        &mut self,
        drive: &Drive,
        work: impl Fn(&mut Stages, &Wanted<'_>) -> Result<T, FieldError>,
    ) -> Result<T, FieldError> {
        let (width, height) = self.size;
        let wanted = Wanted { aperture: &self.aperture, plane: &self.scene.plane, drive, width, height };
        or_by_cpu(&mut self.stages, self.gpu_is_asked_for, |stages| work(stages, &wanted))
    }

    fn on_average<T>(
        &mut self,
        drives: &[Drive],
        work: impl Fn(&mut Stages, &Average<'_>) -> Result<T, FieldError>,
    ) -> Result<T, FieldError> {
        let wanted = Average {
            aperture: &self.aperture,
            plane: &self.scene.plane,
            drives,
            mean: self.mean.clone().unwrap_or(Mean::Square),
            part: if self.schedule.is_some() { 1.0 } else { self.scene.modulation.mean_square() },
            width: self.size.0,
            height: self.size.1,
        };
        or_by_cpu(&mut self.stages, self.gpu_is_asked_for, |stages| work(stages, &wanted))
    }
}

/// Does something with the stages; a GPU that fails is replaced by the CPU, once and with a word, if it was not asked for by name.
fn or_by_cpu<T>(
    stages: &mut Stages,
    gpu_is_asked_for: bool,
    work: impl Fn(&mut Stages) -> Result<T, FieldError>,
) -> Result<T, FieldError> {
    match work(stages) {
        Err(FieldError::Gpu(error)) if !gpu_is_asked_for => {
            note(&format!("{error}; the CPU computes the field"));
            *stages = Stages::new(Evaluator::Cpu);
            work(stages)
        }
        done => done,
    }
}
