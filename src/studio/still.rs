//! Still pictures of a scene: a map, its drive, or a sheet of everything.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};

use crate::acoustics::response::responding_at;
use crate::drive::Drive;
use crate::echo;
use crate::field::{MOST_PIXELS, Quantity, Request, Stages, missed};
use crate::gauge::Gauge;
use crate::memory;
use crate::picture::{ColourMap, Picture, export, numbers, relief, sheet};
use crate::rounding::milliseconds;
use crate::scene::{Channel, Scene, file, motion};
use crate::solver::{self, Solution};
use crate::studio::convention::Convention;
use crate::studio::evaluator::{self, Backend};
use crate::studio::map;
use crate::studio::motion::{SOLVING, follow};
use crate::studio::opening::stem;
use crate::studio::output::{self, Files, say, warn};
use crate::studio::sheet::{pressure, words};
use crate::studio::{EXAMPLE, bodies, liquid, opening};

/// Default file name of a sheet.
const DEFAULT_SHEET: &str = "sonoglyph.png";
/// Pixels per side that a picture may have, and in all: half a gigabyte of field.
pub const LARGEST_SIDE: usize = 1_000_000;
/// Memory per pixel between field and PNG, at most.
const BYTES_PER_PIXEL: usize = 24;
const SMALLEST_SHEET: usize = 200;
const MAP_WIDTH: usize = 512;
const SHEET_WIDTH: usize = 1600;

/// The content of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Diagram {
    /// A quantity on the scene's plane.
    Map(Quantity),
    /// Phase and amplitude per element.
    Drive,
    /// Everything on one page with axes.
    Sheet,
}

/// Pixels. The default height suits the content.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    pub width: usize,
    pub height: Option<usize>,
}

/// The part of a motion in a still picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Moment {
    /// Counted from 0.
    Frame(usize),
    Mean,
}

/// The sheet of a scene, or of the example, in the current folder.
pub fn default_sheet(path: Option<&Path>) -> anyhow::Result<()> {
    let (output, mut files) = (PathBuf::from(DEFAULT_SHEET), Files::new());
    let scene = match path {
        Some(path) => opening::open(path)?,
        None => file::parse(EXAMPLE, Path::new("the example scene"))?,
    };
    path.map_or(Ok(()), |path| files.reads(path))?;
    files.reads_files_of(&scene)?;
    files.writes(&output)?;
    let solved = Solved::new(scene, path.unwrap_or(Path::new("hit.toml")))?;
    let mut stages = Stages::new(evaluator::for_maps(Backend::Auto, true)?);
    let look = Look {
        diagram: Diagram::Sheet,
        shaded: false,
        colours: ColourMap::Inferno,
        channel: Channel::All,
        size: None,
        numbers: false,
        backend: Backend::Auto,
        moment: None,
        begin: |_| Gauge::default(),
    };
    let rendered = render(&solved, &mut stages, &look)?;
    rendered.write(&output, None)?;
    say!("{}", rendered.line(&output))?;
    say!(
        "`sonoglyph render scene -o FILE.png` draws other scenes and quantities, and `sonoglyph --help` lists the rest."
    )
}

/// A scene with its drive.
#[derive(Debug)]
pub struct Solved {
    pub name: String,
    pub scene: Scene,
    pub solution: Solution,
}

impl Solved {
    /// Solves a scene and prints its warnings, with its file's name.
    ///
    /// # Errors
    /// A scene that cannot be solved.
    pub fn new(scene: Scene, path: &Path) -> anyhow::Result<Self> {
        let name = stem(path);
        let solution = solver::solve(&scene).with_context(|| path.display().to_string())?;
        for warning in &solution.warnings {
            warn(&format!("{name}: {warning}"));
        }
        Ok(Self { name, scene, solution })
    }
}

/// Options common to the pictures of all scenes.
#[derive(Clone, Debug)]
pub struct Look {
    pub diagram: Diagram,
    /// Whether a depression is drawn as a shaded relief.
    pub shaded: bool,
    pub colours: ColourMap,
    /// Frequencies of the skin's motion that count.
    pub channel: Channel,
    /// Overrides the default size.
    pub size: Option<Size>,
    /// Whether numbers are written in addition to the picture.
    pub numbers: bool,
    pub backend: Backend,
    pub moment: Option<Moment>,
    /// Begins to show the progress of a step of this name.
    pub begin: fn(&'static str) -> Gauge,
}

impl Look {
    /// The drives to display, alone or as a mean.
    ///
    /// # Errors
    /// A moment outside the motion.
    pub fn drives(&self, solved: &Solved) -> anyhow::Result<Vec<Drive>> {
        let Solved { scene, solution, .. } = solved;
        let presses = matches!(self.diagram, Diagram::Map(quantity) if quantity.declaration().is_slow);
        let moment = match self.moment {
            None if presses && motion::moves(scene) => Moment::Mean,
            None => return Ok(solution.drives()),
            Some(moment) => moment,
        };
        if matches!(self.diagram, Diagram::Sheet | Diagram::Drive) {
            bail!("--frame chooses among maps, and this is no quantity on a plane");
        }
        if moment != Moment::Mean
            && let Diagram::Map(quantity) = self.diagram
            && quantity.declaration().of_skin
        {
            bail!("{} is that of the whole cycle: leave out --frame", quantity.declaration().words);
        }
        let frames = follow(scene, &solved.name, &(self.begin)(SOLVING))?.frames;
        match moment {
            Moment::Mean
                if let Diagram::Map(quantity) = self.diagram
                    && !quantity.declaration().has_mean =>
            {
                bail!("{} has no mean over frames: give a frame's number", quantity.declaration().words)
            }
            Moment::Mean => Ok(frames.into_iter().map(|frame| frame.drive).collect()),
            Moment::Frame(number) if number >= frames.len() => {
                bail!("there is no frame {}: a cycle has {}", number + 1, frames.len())
            }
            Moment::Frame(number) => {
                let drives: Vec<_> = frames.into_iter().map(|frame| frame.drive).collect();
                Ok(vec![responding_at(scene, &drives, number)])
            }
        }
    }

    fn is_shaded(&self) -> bool {
        self.shaded && matches!(self.diagram, Diagram::Map(quantity) if quantity.declaration().is_surface())
    }

    /// Width and height of a scene's picture: as requested, or the quantity's default in the plane's shape.
    pub fn pixels(&self, scene: &Scene) -> anyhow::Result<(usize, usize)> {
        let is_page = matches!(self.diagram, Diagram::Sheet | Diagram::Drive) || self.is_shaded();
        let default = if is_page { SHEET_WIDTH } else { MAP_WIDTH };
        let Size { width, height } = self.size.unwrap_or(Size { width: default, height: None });
        let natural = match self.diagram {
            Diagram::Sheet => sheet::height(width),
            Diagram::Drive => sheet::drive_height(width),
            Diagram::Map(_) if self.is_shaded() => relief::height(width),
            Diagram::Map(_) => {
                let shape = scene.plane.size.y / scene.plane.size.x;
                ((width as f64 * shape).round() as usize).clamp(1, LARGEST_SIDE)
            }
        };
        let height = height.unwrap_or(natural);
        if width * height > MOST_PIXELS {
            let mebibytes = (width * height * 8) >> 20;
            bail!(
                "{width} x {height} pixels need {mebibytes} MiB for their field: the limit is {MOST_PIXELS} pixels"
            );
        }
        let bytes = width * height * BYTES_PER_PIXEL;
        if !memory::holds(bytes) {
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

/// A picture as drawn.
#[derive(Debug)]
pub struct Rendered {
    picture: Picture,
    /// Shape and values of the NPY file.
    numbers: Option<(Vec<u64>, Vec<f32>)>,
    /// Description of the picture.
    what: String,
    /// Evaluator, method and time, as text.
    pub how: String,
}

impl Rendered {
    /// The message after writing it.
    pub fn line(&self, output: &Path) -> String {
        format!(
            "{}: {} x {} pixels{}",
            echo::path(output),
            self.picture.width,
            self.picture.height,
            self.what
        )
    }

    /// Writes the picture, and its numbers if requested.
    ///
    /// # Errors
    /// Files that cannot be written.
    pub fn write(&self, output: &Path, data: Option<&Path>) -> anyhow::Result<()> {
        let png =
            export::png(&self.picture).with_context(|| format!("{}: cannot encode", output.display()))?;
        // Numbers first, so that an existing picture implies complete output.
        if let (Some(data), Some((shape, values))) = (data, &self.numbers) {
            output::write(data, &numbers::npy(shape, values)?)?;
        }
        output::write(output, &png)
    }
}

/// Draws a scene.
///
/// # Errors
/// Too many pixels or too few, a moment outside the motion, or a field that cannot be computed.
pub fn render(solved: &Solved, stages: &mut Stages, look: &Look) -> anyhow::Result<Rendered> {
    let Solved { name, scene, solution } = solved;
    let page = look.pixels(scene)?;
    let time = format!("{} took {}", solution.method_name(), milliseconds(solution.seconds, 1));
    let drives = look.drives(solved)?;
    let quantity = match look.diagram {
        Diagram::Drive => return drive(solved, look, page, time),
        Diagram::Sheet => Quantity::Rms,
        Diagram::Map(quantity) => quantity,
    };
    let (width, height) = match look.diagram {
        Diagram::Sheet => sheet::map_size(&scene.plane, page.0, page.1),
        Diagram::Map(_) if look.is_shaded() => liquid::points(&scene.plane),
        Diagram::Map(_) | Diagram::Drive => page,
    };
    let step = if drives.len() > 1 { "the mean of all frames" } else { "the map" };
    stages.show_progress((look.begin)(step));
    let channel = look.channel;
    let request = Request { channel, ..Request::new(scene, drives, quantity, (width, height)) };
    let drawn = map::draw(&request, look.colours, stages, look.backend == Backend::Gpu)?;
    if let Some(missed) = missed(drawn.map.error, quantity.declaration().tolerance(scene)) {
        warn(&format!("{name}: {missed}"));
    }
    let mut what = match &drawn.pressed {
        None => format!(", {}", map::summary(quantity, &drawn.map)),
        Some(pressed) => format!("\n  {}", liquid::describe(scene, pressed, (quantity, &drawn.map))),
    };
    if let Some(error) = bodies::remark(scene, &request.aperture, &request.drives) {
        what.push_str(&format!("\n  {error}"));
    }
    let picture = match look.diagram {
        Diagram::Sheet => {
            let words = words(scene, solution, name, Convention::Rms);
            let map = pressure(drawn.picture, &drawn.map, look.colours, Convention::Rms);
            sheet::sheet(scene, solution, &words, map, page)?
        }
        Diagram::Map(_) if quantity.declaration().of_liquid => {
            liquid::picture(name, scene, &drawn, look.is_shaded().then_some((width, page)))
        }
        Diagram::Map(_) | Diagram::Drive => {
            let mut picture = drawn.picture;
            let has_room = picture.width.min(picture.height) >= SMALLEST_SHEET;
            if let Some(remark) = map::remark(quantity, &drawn.map).filter(|_| has_room) {
                relief::label(&mut picture, &remark);
            }
            picture
        }
    };
    Ok(Rendered {
        picture,
        numbers: look.numbers.then(|| (vec![height as u64, width as u64], drawn.map.values)),
        what,
        how: format!("{time}; {}", drawn.how),
    })
}

/// Phase and amplitude per element.
fn drive(solved: &Solved, look: &Look, page: (usize, usize), how: String) -> anyhow::Result<Rendered> {
    let Solved { name, scene, solution } = solved;
    let values = solution.drive.phases.iter().chain(&solution.excitation).map(|&value| value as f32);
    let shape = match (&scene.array.file, scene.boards.len()) {
        (None, 0 | 1) => vec![2, u64::from(scene.array.rows), u64::from(scene.array.columns)],
        (_, boards) => vec![2, boards.max(1) as u64, scene.array.elements() as u64],
    };
    Ok(Rendered {
        picture: sheet::drive(scene, solution, &words(scene, solution, name, Convention::Rms), page)?,
        numbers: look.numbers.then(|| (shape, values.collect())),
        what: String::new(),
        how,
    })
}
