//! `sonoglyph render`: scenes in, pictures out.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, bail};
use indicatif::{ProgressBar, ProgressStyle};
use num_complex::Complex32;

use crate::acoustics::Aperture;
use crate::cli::{
    Backend, DEFAULT_SHEET, EXAMPLE, Quantity, RenderArgs, evaluator, note, output, read_scene, warn,
};
use crate::drive::Drive;
use crate::field::gpu::Colouring;
use crate::field::{Evaluator, Samples, Sources, cpu};
use crate::picture::colour::{self, ColourMap};
use crate::picture::{Picture, export, sheet};
use crate::scene::{Scene, file};
use crate::solver;

/// Pixels per side that a picture may have, and in all: half a gigabyte of field.
const LARGEST_SIDE: usize = 16_384;
const MOST_PIXELS: usize = 1 << 26;
const SMALLEST_SHEET: usize = 200;
const MAP_WIDTH: usize = 512;
const SHEET_WIDTH: usize = 1600;
/// What direct summation in f32 keeps, relative to the peak; tests hold the evaluators to it.
const DIRECT_ERROR: f64 = 2e-5;

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

pub fn parse_tolerance(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        _ if text == "exact" => Ok(0.0),
        Ok(tolerance) if tolerance > 0.0 && tolerance < 1.0 => Ok(tolerance),
        _ => Err("give a number between 0 and 1, or `exact`".to_owned()),
    }
}

/// The sheet of a scene, or of the example, in the current folder.
pub fn default_sheet(scene: Option<&Path>) -> anyhow::Result<()> {
    let (scene, name) = match scene {
        Some(path) => (file::read(path)?, stem(path)?),
        None => (file::parse(EXAMPLE, Path::new("the example scene"))?, "hit".to_owned()),
    };
    let output = PathBuf::from(DEFAULT_SHEET);
    output::check_writable(&output)?;
    let evaluator = evaluator::for_maps(Backend::Auto)?;
    let look = Look { quantity: Quantity::Sheet, map: ColourMap::Inferno, size: None, with_numbers: false };
    let rendered = render(&scene, &name, &evaluator, &look).with_context(|| name.clone())?;
    write_rendered(&rendered, &output, None)?;
    println!("{}", rendered.line(&output));
    println!(
        "`sonoglyph render SCENE -o FILE.png` draws other scenes and quantities; `sonoglyph --help` lists the rest."
    );
    Ok(())
}

pub fn run(args: &RenderArgs) -> anyhow::Result<()> {
    let outputs = outputs(&args.scenes, &args.output)?;
    if args.data.is_some() && args.scenes.len() > 1 {
        bail!("--data takes the numbers of one scene, and {} are given", args.scenes.len());
    }
    // Every scene is read before the first is drawn: a slip in the last one costs no work.
    let mut scenes = Vec::new();
    for path in &args.scenes {
        let mut scene = read_scene(path, args.method)?;
        scene.plane.tolerance = args.tolerance.unwrap_or(scene.plane.tolerance);
        scenes.push((stem(path)?, scene, path));
    }
    for path in outputs.iter().chain(&args.data) {
        output::check_writable(path)?;
    }
    let finest =
        scenes.iter().map(|(_, scene, _)| scene.plane.tolerance).filter(|&t| t > 0.0).fold(1.0, f64::min);
    let evaluator = evaluator_for(args.backend.backend, finest)?;
    let look = Look {
        quantity: args.quantity,
        map: args.colours.map(),
        size: args.size,
        with_numbers: args.data.is_some(),
    };

    let bar = progress(scenes.len());
    for ((name, scene, path), output) in scenes.iter().zip(&outputs) {
        bar.set_message(name.clone());
        let start = Instant::now();
        let rendered = render(scene, name, &evaluator, &look).with_context(|| path.display().to_string())?;
        write_rendered(&rendered, output, args.data.as_deref())?;
        bar.suspend(|| {
            println!("{}", rendered.line(output));
            if args.verbose {
                println!("  {}; {:.0} ms in all", rendered.how, start.elapsed().as_secs_f64() * 1e3);
            }
        });
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(())
}

fn evaluator_for(backend: Backend, tolerance: f64) -> anyhow::Result<Evaluator> {
    let too_fine = tolerance < DIRECT_ERROR;
    if too_fine && backend == Backend::Auto {
        note(&format!(
            "a tolerance of {tolerance:e} is finer than f32 keeps; the f64 reference computes the field"
        ));
        return Ok(Evaluator::Reference);
    }
    if too_fine && matches!(backend, Backend::Gpu | Backend::Cpu) {
        warn(&format!("a tolerance of {tolerance:e} may not be reached: f32 keeps {DIRECT_ERROR:e}"));
    }
    Ok(evaluator::for_maps(backend)?)
}

/// One output per scene: the file itself, or files in a folder, which is made if it is not there.
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
        let path = output.join(stem(scene)?).with_extension("png");
        if outputs.contains(&path) {
            bail!("{}: two scenes would be written to this file", path.display());
        }
        outputs.push(path);
    }
    std::fs::create_dir_all(output)
        .with_context(|| format!("{}: cannot make the folder", output.display()))?;
    Ok(outputs)
}

fn stem(path: &Path) -> anyhow::Result<String> {
    let stem = path.file_stem().with_context(|| format!("{}: this is no file", path.display()))?;
    Ok(stem.to_string_lossy().into_owned())
}

fn progress(scenes: usize) -> ProgressBar {
    if scenes < 2 {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{bar:30} {pos}/{len} {msg}")
        .unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new(scenes as u64).with_style(style)
}

struct Look {
    quantity: Quantity,
    map: ColourMap,
    size: Option<Size>,
    /// The numbers are wanted, not only their picture.
    with_numbers: bool,
}

struct Rendered {
    picture: Picture,
    /// Shape and values of the NPY file.
    numbers: Option<(Vec<u64>, Vec<f32>)>,
    /// The largest RMS pressure (Pa) of the map, if there is one.
    peak_rms: Option<f64>,
    how: String,
}

impl Rendered {
    fn line(&self, output: &Path) -> String {
        let peak = self
            .peak_rms
            .map_or(String::new(), |peak| format!(", RMS pressure up to {}", sheet::pascals(peak)));
        format!("{}: {} x {} pixels{peak}", output.display(), self.picture.width, self.picture.height)
    }
}

fn write_rendered(rendered: &Rendered, output: &Path, data: Option<&Path>) -> anyhow::Result<()> {
    let png =
        export::png(&rendered.picture).with_context(|| format!("{}: cannot encode", output.display()))?;
    // The numbers first: a picture that is there is complete.
    if let (Some(data), Some((shape, values))) = (data, &rendered.numbers) {
        output::write(data, &export::npy(shape, values)?)?;
    }
    output::write(output, &png)
}

fn render(scene: &Scene, name: &str, evaluator: &Evaluator, look: &Look) -> anyhow::Result<Rendered> {
    let (width, height) = size(scene, look)?;
    let solution = solver::solve(scene)?;
    for warning in &solution.warnings {
        warn(&format!("{name}: {warning}"));
    }
    let solved = format!("{} took {:.1} ms", solution.method.name(), solution.seconds * 1e3);
    Ok(match look.quantity {
        Quantity::Drive => {
            let numbers =
                || solution.drive.phases.iter().chain(&solution.excitation).map(|&v| v as f32).collect();
            let shape = vec![2, u64::from(scene.array.rows), u64::from(scene.array.columns)];
            Rendered {
                picture: sheet::drive(scene, &solution, name, (width, height))?,
                numbers: look.with_numbers.then(|| (shape, numbers())),
                peak_rms: None,
                how: solved,
            }
        }
        Quantity::Sheet => {
            let (columns, rows) = sheet::map_size(&scene.plane, width, height);
            let map = map(scene, &solution.drive, evaluator, (columns, rows), look)?;
            let peak_rms = f64::from(map.peak) / std::f64::consts::SQRT_2;
            Rendered {
                picture: sheet::sheet(scene, &solution, name, &map.picture, peak_rms, (width, height))?,
                numbers: map.numbers(columns, rows, colour::Quantity::Rms),
                peak_rms: Some(peak_rms),
                how: format!("{solved}; {}", map.how),
            }
        }
        Quantity::Rms | Quantity::Phase => {
            let map = map(scene, &solution.drive, evaluator, (width, height), look)?;
            Rendered {
                numbers: map.numbers(width, height, shown(look.quantity)),
                peak_rms: Some(f64::from(map.peak) / std::f64::consts::SQRT_2),
                how: format!("{solved}; {}", map.how),
                picture: map.picture,
            }
        }
    })
}

/// Pixels of the picture: what was asked for, or the quantity's own default in the plane's shape.
fn size(scene: &Scene, look: &Look) -> anyhow::Result<(usize, usize)> {
    let default = if matches!(look.quantity, Quantity::Sheet) { SHEET_WIDTH } else { MAP_WIDTH };
    let default = if matches!(look.quantity, Quantity::Drive) { SHEET_WIDTH } else { default };
    let Size { width, height } = look.size.unwrap_or(Size { width: default, height: None });
    let natural = match look.quantity {
        Quantity::Sheet => sheet::height(width),
        Quantity::Drive => sheet::drive_height(width),
        Quantity::Rms | Quantity::Phase => {
            let shape = scene.plane.size.y / scene.plane.size.x;
            ((width as f64 * shape).round() as usize).clamp(1, LARGEST_SIDE)
        }
    };
    let height = height.unwrap_or(natural);
    if width * height > MOST_PIXELS {
        bail!(
            "a picture of {width} x {height} needs {} MiB for its field alone; {MOST_PIXELS} pixels are the most",
            width * height * 8 >> 20
        );
    }
    if matches!(look.quantity, Quantity::Sheet | Quantity::Drive) && width.min(height) < SMALLEST_SHEET {
        bail!(
            "a sheet of {width} x {height} pixels has no room for its axes; {SMALLEST_SHEET} a side are the least"
        );
    }
    Ok((width, height))
}

fn shown(quantity: Quantity) -> colour::Quantity {
    if quantity == Quantity::Phase { colour::Quantity::Phase } else { colour::Quantity::Rms }
}

struct Map {
    picture: Picture,
    /// The largest |p|, Pa.
    peak: f32,
    /// Read back from the GPU only if wanted.
    field: Option<Vec<Complex32>>,
    how: String,
}

impl Map {
    fn numbers(
        &self,
        width: usize,
        height: usize,
        quantity: colour::Quantity,
    ) -> Option<(Vec<u64>, Vec<f32>)> {
        let field = self.field.as_ref()?;
        Some((vec![height as u64, width as u64], field.iter().map(|&p| quantity.of(p)).collect()))
    }
}

fn map(
    scene: &Scene,
    drive: &Drive,
    evaluator: &Evaluator,
    (width, height): (usize, usize),
    look: &Look,
) -> anyhow::Result<Map> {
    let start = Instant::now();
    let aperture = Aperture::new(scene);
    let samples = Samples::on_plane(&scene.plane, width, height).context("the plane's axes span no plane")?;
    let quantity = shown(look.quantity);
    let table = if quantity == colour::Quantity::Phase { ColourMap::Cyclic } else { look.map }.table();
    let milliseconds = |start: Instant| start.elapsed().as_secs_f64() * 1e3;
    if let (Evaluator::Gpu(gpu), Some(sources)) = (evaluator, Sources::new(&aperture, drive, &samples)) {
        let field = gpu.pressure(&sources, &samples)?;
        let colouring = Colouring { table: &table, phase: quantity == colour::Quantity::Phase, full: None };
        let picture = Picture::from_field_order(width, height, &field.colours(&colouring)?);
        let peak = field.peak()?;
        let how = format!("{} took {:.1} ms for the field and its colours", gpu.info(), milliseconds(start));
        return Ok(Map { picture, peak, field: look.with_numbers.then(|| field.read()).transpose()?, how });
    }
    let field = evaluator.pressure(&aperture, drive, &samples)?;
    let who = match evaluator {
        Evaluator::Cpu if Sources::new(&aperture, drive, &samples).is_some() => {
            format!("the CPU evaluator ({})", cpu::Isa::best().name())
        }
        Evaluator::Reference => "the f64 reference".to_owned(),
        Evaluator::Cpu | Evaluator::Gpu(_) => {
            "the f64 reference, since f32 has no room for such elements,".to_owned()
        }
    };
    let how = format!("{who} took {:.1} ms for the field", milliseconds(start));
    let peak = colour::peak(&field);
    let colours = colour::colours(&field, quantity, &table, peak);
    Ok(Map { picture: Picture::from_field_order(width, height, &colours), peak, field: Some(field), how })
}
