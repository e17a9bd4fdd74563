//! `sonoglyph render`: scenes in, pictures out.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, bail};
use indicatif::{ProgressBar, ProgressStyle};

use crate::cli::map::{self, Sound};
use crate::cli::output::say;
use crate::cli::{
    Backend, Colours, DEFAULT_SHEET, EXAMPLE, Quantity, RenderArgs, View, evaluator, liquid, motion, output,
    read_scene, warn,
};
use crate::drive::Drive;
use crate::field::stages::MOST_PIXELS;
use crate::field::{self, Evaluator, Stages};
use crate::picture::{Picture, export, relief, sheet};
use crate::scene::{MotionPath, Scene, file};
use crate::solver::{self, Solution};

/// Pixels per side that a picture may have, and in all: half a gigabyte of field.
const LARGEST_SIDE: usize = 1_000_000;
/// What a pixel takes on its way from the field to a PNG, at most.
const BYTES_PER_PIXEL: usize = 24;
const SMALLEST_SHEET: usize = 200;
const MAP_WIDTH: usize = 512;
const SHEET_WIDTH: usize = 1600;

/// `W` or `WxH`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    width: usize,
    height: Option<usize>,
}

pub fn parse_size(text: &str) -> Result<Size, String> {
    let side = |text: &str| match text.parse::<usize>() {
        Ok(side) if (1..=LARGEST_SIDE).contains(&side) => Ok(side),
        _ => Err(format!("`{text}` is no number of pixels from 1 to {LARGEST_SIDE}")),
    };
    match text.split_once(['x', 'X']) {
        Some((width, height)) => Ok(Size { width: side(width)?, height: Some(side(height)?) }),
        None => Ok(Size { width: side(text)?, height: None }),
    }
}

/// Which part of a motion a still picture shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Moment {
    /// Counted from 0.
    Frame(usize),
    Mean,
}

/// Whether the system would give so many bytes. A refusal is a message now; in the middle of the work it would be the end.
fn there_is_room(bytes: usize) -> bool {
    let mut room = Vec::<u8>::new();
    let is_given = room.try_reserve_exact(bytes).is_ok();
    // Otherwise a compiler may leave out what nobody uses.
    std::hint::black_box(&mut room);
    is_given
}

pub fn parse_moment(text: &str) -> Result<Moment, String> {
    match text.parse::<usize>() {
        _ if text == "mean" => Ok(Moment::Mean),
        Ok(number) if number > 0 => Ok(Moment::Frame(number - 1)),
        _ => Err("give a frame's number, counted from 1, or `mean`".to_owned()),
    }
}

pub fn parse_tolerance(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        _ if text == "exact" => Ok(0.0),
        Ok(tolerance) if tolerance > 0.0 && tolerance < 1.0 => Ok(tolerance),
        _ => Err("give a number between 0 and 1, or `exact`".to_owned()),
    }
}

/// The sheet of a scene, or of the example, in the current folder.
pub fn default_sheet(path: Option<&Path>) -> anyhow::Result<()> {
    let output = PathBuf::from(DEFAULT_SHEET);
    let scene = match path {
        Some(path) => file::read(path)?,
        None => file::parse(EXAMPLE, Path::new("the example scene"))?,
    };
    let solved = Solved::new(scene, path.unwrap_or(Path::new("hit.toml")))?;
    output::check_writable(&output)?;
    let mut stages = Stages::new(evaluator::for_maps(Backend::Auto)?);
    let look = Look {
        quantity: Quantity::Sheet,
        view: View::Flat,
        colours: Colours::Inferno,
        size: None,
        numbers: false,
        backend: Backend::Auto,
        moment: None,
    };
    let rendered = render(&solved, &mut stages, &look)?;
    rendered.write(&output, None)?;
    say!("{}", rendered.line(&output))?;
    say!(
        "`sonoglyph render SCENE -o FILE.png` draws other scenes and quantities, and `sonoglyph --help` lists the rest."
    )
}

pub(in crate::cli) fn run(args: &RenderArgs) -> anyhow::Result<()> {
    let outputs = outputs(&args.scenes, &args.output)?;
    if args.data.is_some() && args.scenes.len() > 1 {
        bail!("--data takes the numbers of one scene, and {} are given", args.scenes.len());
    }
    let look = Look::new(args);
    // Every scene is read and solved before the first is drawn: a slip in the last one costs no work.
    let mut scenes = Vec::new();
    for path in &args.scenes {
        let mut scene = read_scene(path, args.method)?;
        scene.plane.tolerance = args.tolerance.unwrap_or(scene.plane.tolerance);
        look.pixels(&scene)?;
        scenes.push(Solved::new(scene, path)?);
    }
    make_folder(args, &outputs)?;
    for path in outputs.iter().chain(&args.data) {
        output::check_writable(path)?;
    }
    // A drive has no field to compute, and so no word is needed on who would.
    let mut stages = Stages::new(match args.quantity {
        Quantity::Drive => Evaluator::Cpu,
        _ => evaluator::for_maps(look.backend)?,
    });

    let bar = progress(scenes.len());
    for (solved, output) in scenes.iter().zip(&outputs) {
        bar.set_message(solved.name.clone());
        let start = Instant::now();
        let rendered = render(solved, &mut stages, &look).with_context(|| solved.name.clone())?;
        rendered.write(output, args.data.as_deref())?;
        bar.suspend(|| {
            say!("{}", rendered.line(output))?;
            match args.verbose {
                true => say!("  {}; {:.0} ms in all", rendered.how, start.elapsed().as_secs_f64() * 1e3),
                false => Ok(()),
            }
        })?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(())
}

/// One output per scene: the file itself, or files in a folder.
fn outputs(scenes: &[PathBuf], output: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let named_as_folder = output.as_os_str().to_string_lossy().ends_with(std::path::is_separator);
    if scenes.len() == 1 && !output.is_dir() && !named_as_folder {
        return Ok(vec![output.to_owned()]);
    }
    if output.is_file() {
        bail!("{}: {} scenes need a folder, and this is a file", output.display(), scenes.len());
    }
    let mut outputs = Vec::new();
    for scene in scenes {
        let path = output.join(stem(scene)).with_extension("png");
        if outputs.contains(&path) {
            bail!("{}: two scenes would be written to this file", path.display());
        }
        outputs.push(path);
    }
    Ok(outputs)
}

/// The name of a file without folder and extension.
pub fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// Makes the folder that outputs go to, unless a single file was named: its folder must be there.
fn make_folder(args: &RenderArgs, outputs: &[PathBuf]) -> anyhow::Result<()> {
    if outputs.len() == 1 && outputs[0] == args.output {
        return Ok(());
    }
    std::fs::create_dir_all(&args.output)
        .with_context(|| format!("{}: cannot make the folder", args.output.display()))
}

fn progress(scenes: usize) -> ProgressBar {
    if scenes < 2 {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{bar:30} {pos}/{len} {msg}");
    ProgressBar::new(scenes as u64).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

/// A scene with its drive.
struct Solved {
    name: String,
    scene: Scene,
    solution: Solution,
}

impl Solved {
    fn new(scene: Scene, path: &Path) -> anyhow::Result<Self> {
        let name = stem(path);
        let solution = solver::solve(&scene).with_context(|| path.display().to_string())?;
        for warning in &solution.warnings {
            warn(&format!("{name}: {warning}"));
        }
        Ok(Self { name, scene, solution })
    }
}

/// What the pictures of all scenes have in common.
pub struct Look {
    quantity: Quantity,
    view: View,
    colours: Colours,
    size: Option<Size>,
    /// The numbers are wanted, not only their picture.
    numbers: bool,
    backend: Backend,
    moment: Option<Moment>,
}

impl Look {
    /// The drives whose field or mean is shown.
    fn drives(&self, solved: &Solved) -> anyhow::Result<Vec<Drive>> {
        let Solved { scene, solution, .. } = solved;
        let presses = matches!(self.quantity, Quantity::Radiation | Quantity::Dent);
        let moment = match self.moment {
            None if presses && scene.motion.path != MotionPath::None => Moment::Mean,
            None => return Ok(vec![solution.drive.clone()]),
            Some(moment) => moment,
        };
        if matches!(self.quantity, Quantity::Sheet | Quantity::Drive) {
            bail!("--frame chooses among maps: --quantity rms, phase, radiation or dent");
        }
        let mut frames = motion::follow(scene, &solved.name)?.frames;
        match moment {
            Moment::Mean if self.quantity == Quantity::Phase => {
                bail!("a mean over frames has no phase: give a frame's number")
            }
            Moment::Mean => Ok(frames.into_iter().map(|frame| frame.drive).collect()),
            Moment::Frame(number) if number >= frames.len() => {
                bail!("there is no frame {}: a round has {}", number + 1, frames.len())
            }
            Moment::Frame(number) => Ok(vec![frames.swap_remove(number).drive]),
        }
    }

    fn is_shaded(&self) -> bool {
        self.quantity == Quantity::Dent && self.view == View::Shaded
    }

    pub(in crate::cli) fn new(args: &RenderArgs) -> Self {
        Self {
            quantity: args.quantity,
            view: args.view,
            colours: args.colours,
            size: args.size,
            numbers: args.data.is_some(),
            backend: args.backend.backend,
            moment: args.frame,
        }
    }

    /// Width and height of a scene's picture: what was asked for, or the quantity's own default in the plane's shape.
    pub fn pixels(&self, scene: &Scene) -> anyhow::Result<(usize, usize)> {
        let is_page = matches!(self.quantity, Quantity::Sheet | Quantity::Drive) || self.is_shaded();
        let default = if is_page { SHEET_WIDTH } else { MAP_WIDTH };
        let Size { width, height } = self.size.unwrap_or(Size { width: default, height: None });
        let natural = match self.quantity {
            Quantity::Sheet => sheet::height(width),
            Quantity::Drive => sheet::drive_height(width),
            Quantity::Dent if self.is_shaded() => relief::height(width),
            Quantity::Rms | Quantity::Phase | Quantity::Radiation | Quantity::Dent => {
                let shape = scene.plane.size.y / scene.plane.size.x;
                ((width as f64 * shape).round() as usize).clamp(1, LARGEST_SIDE)
            }
        };
        let height = height.unwrap_or(natural);
        if width * height > MOST_PIXELS {
            let mebibytes = (width * height * 8) >> 20;
            bail!(
                "{width} x {height} pixels need {mebibytes} MiB for their field; {MOST_PIXELS} pixels are the most"
            );
        }
        let bytes = width * height * BYTES_PER_PIXEL;
        if !there_is_room(bytes) {
            bail!("{width} x {height} pixels need about {} MiB of memory, more than there is", bytes >> 20);
        }
        if is_page && width.min(height) < SMALLEST_SHEET {
            bail!(
                "a page of {width} x {height} pixels has no room for its words: {SMALLEST_SHEET} a side are the least"
            );
        }
        Ok((width, height))
    }
}

struct Rendered {
    picture: Picture,
    /// Shape and values of the NPY file.
    numbers: Option<(Vec<u64>, Vec<f32>)>,
    /// What the picture shows, in words.
    what: String,
    how: String,
}

impl Rendered {
    fn line(&self, output: &Path) -> String {
        format!("{}: {} x {} pixels{}", output.display(), self.picture.width, self.picture.height, self.what)
    }

    fn write(&self, output: &Path, data: Option<&Path>) -> anyhow::Result<()> {
        let png =
            export::png(&self.picture).with_context(|| format!("{}: cannot encode", output.display()))?;
        // The numbers first: a picture that is there is complete.
        if let (Some(data), Some((shape, values))) = (data, &self.numbers) {
            output::write(data, &export::npy(shape, values)?)?;
        }
        output::write(output, &png)
    }
}

fn render(solved: &Solved, stages: &mut Stages, look: &Look) -> anyhow::Result<Rendered> {
    let Solved { name, scene, solution } = solved;
    let page = look.pixels(scene)?;
    let time = format!("{} took {:.1} ms", solution.method.name(), solution.seconds * 1e3);
    let drives = look.drives(solved)?;
    let quantity = match look.quantity {
        Quantity::Drive => return drive(solved, look, page, time),
        Quantity::Rms if look.moment == Some(Moment::Mean) => field::Quantity::MeanRms,
        Quantity::Sheet | Quantity::Rms => field::Quantity::Rms,
        Quantity::Phase => field::Quantity::Phase,
        Quantity::Radiation => field::Quantity::Radiation,
        Quantity::Dent => field::Quantity::Dent,
    };
    let (width, height) = match look.quantity {
        Quantity::Sheet => sheet::map_size(&scene.plane, page.0, page.1),
        Quantity::Dent if look.is_shaded() => liquid::points(&scene.plane),
        _ => page,
    };
    let numbers = look.numbers || look.is_shaded();
    let map_look = map::Look { width, height, quantity, colours: look.colours.map(), numbers };
    let sound = Sound { scene, drives: &drives };
    let map = map::draw_anyhow(sound, stages, &map_look, look.backend == Backend::Gpu)?;
    let tolerance = scene.plane.tolerance;
    if tolerance > 0.0 && map.error > tolerance {
        warn(&format!(
            "{name}: the map's error is {:.1e} of its peak, more than the {tolerance:e} wanted",
            map.error
        ));
    }
    let what = match &map.pressed {
        None => format!(", RMS pressure up to {}", sheet::pascals(map.largest)),
        Some(pressed) => format!("\n  {}", liquid::describe(scene, pressed, map.largest)),
    };
    let picture = match look.quantity {
        Quantity::Sheet => {
            sheet::sheet(scene, solution, name, &map.picture, (look.colours.map(), map.largest), page)?
        }
        Quantity::Dent => liquid::picture(name, scene, &map, look.is_shaded().then_some((width, page)))?,
        _ => map.picture,
    };
    Ok(Rendered {
        picture,
        numbers: map.numbers.map(|values| (vec![height as u64, width as u64], values)),
        what,
        how: format!("{time}; {}", map.how),
    })
}

/// Phase and amplitude per element.
fn drive(solved: &Solved, look: &Look, page: (usize, usize), how: String) -> anyhow::Result<Rendered> {
    let Solved { name, scene, solution } = solved;
    let values = solution.drive.phases.iter().chain(&solution.excitation).map(|&value| value as f32);
    let shape = vec![2, u64::from(scene.array.rows), u64::from(scene.array.columns)];
    Ok(Rendered {
        picture: sheet::drive(scene, solution, name, page)?,
        numbers: look.numbers.then(|| (shape, values.collect())),
        what: String::new(),
        how,
    })
}
