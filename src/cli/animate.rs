//! `sonoglyph render --motion`: a scene in, an animation of its round out.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, bail};
use indicatif::{ProgressBar, ProgressStyle};

use crate::acoustics::Aperture;
use crate::cli::render::{Look, stem};
use crate::cli::{Backend, Quantity, RenderArgs, evaluator, motion, note, output, read_scene, warn};
use crate::drive::Drive;
use crate::field::{self, Colouring, Evaluator, FieldError, Stages, Wanted};
use crate::picture::animation::{Animation, Format, Pace};
use crate::picture::{ColourMap, sheet};
use crate::scene::Scene;
use crate::solver::frames::Sequence;

/// What is written.
#[derive(Clone, Debug, PartialEq)]
enum Target {
    File(PathBuf, Format),
    /// A PNG per frame.
    Folder(PathBuf),
}

impl Target {
    fn of(output: &Path) -> anyhow::Result<Self> {
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
    fn check(&self, (width, height): (usize, usize)) -> anyhow::Result<()> {
        let Self::File(path, format) = self else { return Ok(()) };
        let most = format.largest_side();
        if width.max(height) > most {
            bail!("{}: {width} x {height} pixels: this format has room for {most} a side", path.display());
        }
        output::check_writable(path)
    }

    fn make_folder(&self) -> anyhow::Result<()> {
        let Self::Folder(path) = self else { return Ok(()) };
        std::fs::create_dir_all(path).with_context(|| format!("{}: cannot make the folder", path.display()))
    }
}

pub fn run(args: &RenderArgs) -> anyhow::Result<()> {
    let target = Target::of(&args.output)?;
    let [path] = &args.scenes[..] else {
        bail!("--motion animates one scene, and {} are given", args.scenes.len());
    };
    if args.data.is_some() {
        bail!("--data takes the numbers of a still map; leave out --motion");
    }
    let quantity = match args.quantity {
        Quantity::Rms => field::Quantity::Rms,
        Quantity::Phase => field::Quantity::Phase,
        Quantity::Drive | Quantity::Sheet => bail!("--motion animates maps: --quantity rms or phase"),
    };
    let mut scene = read_scene(path, args.method)?;
    scene.plane.tolerance = args.tolerance.unwrap_or(scene.plane.tolerance);
    let look = Look::new(args);
    let size = look.pixels(&scene)?;
    target.check(size)?;
    let sequence = motion::follow(&scene, &path.display().to_string())?;
    target.make_folder()?;
    let mut film = Film {
        aperture: Aperture::new(&scene),
        scene: &scene,
        stages: Stages::new(evaluator::for_maps(args.backend.backend)?),
        gpu_is_asked_for: args.backend.backend == Backend::Gpu,
        quantity,
        size,
        error: 0.0,
    };
    let start = Instant::now();
    let colours = if quantity == field::Quantity::Phase { ColourMap::Cyclic } else { args.colours.map() };
    let shot = film.shoot(&sequence, &target, &stem(path), colours)?;
    let tolerance = scene.plane.tolerance;
    if tolerance > 0.0 && film.error > tolerance {
        warn(&format!("a map's error is {:.1e} of its peak, more than the {tolerance:e} wanted", film.error));
    }
    println!("{}", shot.line(&args.output, size, &scene));
    if args.verbose {
        let (solving, drawing) = (sequence.seconds, start.elapsed().as_secs_f64());
        let each = drawing / sequence.frames.len() as f64;
        println!("  {:.1} ms for all drives, {:.1} ms per frame for its map", solving * 1e3, each * 1e3);
    }
    Ok(())
}

/// What was written.
struct Shot {
    frames: usize,
    pace: Pace,
    /// The largest RMS pressure (Pa) of all frames, where colours tell it.
    peak_rms: Option<f64>,
}

impl Shot {
    fn line(&self, output: &Path, (width, height): (usize, usize), scene: &Scene) -> String {
        let frames = if self.frames == 1 { "frame" } else { "frames" };
        let mut line = format!("{}: {} {frames} of {width} x {height} pixels", output.display(), self.frames);
        if let Some(peak) = self.peak_rms {
            line += &format!(", RMS pressure up to {}", sheet::pascals(peak));
        }
        if self.frames == 1 {
            return line;
        }
        let round = 1.0 / scene.motion.rate;
        line += &format!("; a round takes {round:.3} s, ");
        line + &match self.pace.slowed {
            slowed if slowed > 1.001 => {
                format!("shown slowed down {slowed:.1} x: viewers show no frame for less than 20 ms")
            }
            slowed if slowed < 0.999 => {
                format!("shown {:.1} x as fast: no frame lasts longer than 60 s", 1.0 / slowed)
            }
            _ => "and so it does here".to_owned(),
        }
    }
}

/// Makes the map of one frame after the other.
struct Film<'a> {
    scene: &'a Scene,
    aperture: Aperture,
    stages: Stages,
    gpu_is_asked_for: bool,
    quantity: field::Quantity,
    size: (usize, usize),
    /// The largest error of a map so far, relative to its peak.
    error: f64,
}

impl Film<'_> {
    /// Two passes, so that no more than one map is ever in memory: the first finds the range of the colours, which all frames
    /// share, the second writes.
    fn shoot(
        &mut self,
        sequence: &Sequence,
        target: &Target,
        name: &str,
        colours: ColourMap,
    ) -> anyhow::Result<Shot> {
        let frames = &sequence.frames;
        let has_range = self.quantity == field::Quantity::Rms;
        let bar = progress(frames.len() * if has_range { 2 } else { 1 });
        let mut full = 0.0;
        if has_range {
            for frame in frames {
                full = self.peak(&frame.drive)?.max(full);
                bar.inc(1);
            }
        }
        let pace = Pace::new(self.scene.motion.frames_per_second());
        let table = colours.table();
        let (count, size) = (frames.len(), self.size);
        match target {
            Target::File(path, format) => output::write_by(path, |file| {
                let mut animation = Animation::new(file, *format, size, &table, count as u32, pace)?;
                for frame in frames {
                    animation.add(&self.places(&frame.drive, full)?)?;
                    bar.inc(1);
                }
                Ok(animation.finish()?)
            })?,
            Target::Folder(folder) => {
                let digits = count.to_string().len();
                for (index, frame) in frames.iter().enumerate() {
                    let places = self.places(&frame.drive, full)?;
                    let path = folder.join(format!("{name}-{:0digits$}.png", index + 1));
                    output::write_by(&path, |file| {
                        let mut picture = Animation::new(file, Format::Png, size, &table, 1, pace)?;
                        picture.add(&places)?;
                        Ok(picture.finish()?)
                    })?;
                    bar.inc(1);
                }
            }
        }
        bar.finish_and_clear();
        let peak_rms = has_range.then(|| f64::from(full) / std::f64::consts::SQRT_2);
        Ok(Shot { frames: count, pace, peak_rms })
    }

    /// The largest |P| of a frame, Pa.
    fn peak(&mut self, drive: &Drive) -> Result<f32, FieldError> {
        let map = self.on_stages(drive, |stages, wanted| stages.map(wanted).cloned())?;
        self.error = map.error.max(self.error);
        Ok(map.peak)
    }

    /// The place of every pixel in a table of colours, of which `full` (Pa, peak) gets the last.
    fn places(&mut self, drive: &Drive, full: f32) -> Result<Vec<u8>, FieldError> {
        // In shades of grey, a colour is its place.
        let table = ColourMap::Grey.table();
        let colouring = Colouring { quantity: self.quantity, table, full: Some(full) };
        self.on_stages(drive, |stages, wanted| {
            Ok(stages.colours(wanted, &colouring)?.iter().map(|[place, ..]| *place).collect())
        })
    }

    /// Does something with the stages; a GPU that fails is replaced by the CPU, once and with a word, if it was not asked for by
    /// name.
    fn on_stages<T>(
        &mut self,
        drive: &Drive,
        work: impl Fn(&mut Stages, &Wanted<'_>) -> Result<T, FieldError>,
    ) -> Result<T, FieldError> {
        let (width, height) = self.size;
        let wanted = Wanted { aperture: &self.aperture, plane: &self.scene.plane, drive, width, height };
        match work(&mut self.stages, &wanted) {
            Err(FieldError::Gpu(error)) if !self.gpu_is_asked_for => {
                note(&format!("{error}; the CPU computes the field"));
                self.stages = Stages::new(Evaluator::Cpu);
                work(&mut self.stages, &wanted)
            }
            done => done,
        }
    }
}

fn progress(steps: usize) -> ProgressBar {
    let style = ProgressStyle::with_template("{bar:30} {percent} %, {eta} left");
    ProgressBar::new(steps as u64).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}
