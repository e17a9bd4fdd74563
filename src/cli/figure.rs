//! `sonoglyph render --figure`: figures for papers, with their options.

use std::path::Path;

use anyhow::bail;
use clap::Args;

use crate::cli::arguments::{between, numbers};
use crate::cli::{RenderArgs, View};
use crate::field::{Quantity, Request, Scale, Stages, missed};
use crate::picture::figure::Paper;
use crate::picture::numbers::npy;
use crate::studio::convention::Convention;
use crate::studio::evaluator::Backend;
use crate::studio::figure::{self, DENSITIES, WIDTHS, Wish};
use crate::studio::output::{self, say, warn};
use crate::studio::still::{Diagram, Look, Solved};
use crate::studio::{liquid, map};

#[derive(Debug, Args)]
#[command(next_help_heading = "Figures")]
pub struct FigureArgs {
    /// Draw a figure for a paper, with axes and a colour bar: .png, .svg or .pdf
    #[arg(long, conflicts_with_all = ["size", "motion", "waves"])]
    pub figure: bool,
    /// Width of the figure in mm [default: 85, one column]
    #[arg(long, value_name = "W", requires = "figure", value_parser = between(WIDTHS, "mm"))]
    width_mm: Option<f64>,
    /// Dots per inch of the map, and of a PNG [default: 300]
    #[arg(long, value_name = "D", requires = "figure", value_parser = between(DENSITIES, "dots per inch"))]
    dpi: Option<f64>,
    /// Logarithmic colours, in dB relative to the largest value
    #[arg(long, requires = "figure")]
    db: bool,
    /// Values of the first and the last colour: Pa, m, W/m², m/s or × undisturbed; with --db in dB
    #[arg(long, value_name = "A,B", requires = "figure", allow_hyphen_values = true, value_parser = parse_range)]
    range: Option<[f64; 2]>,
    /// Contour lines at these levels, in dB relative to the largest value: -6, or -3,-6,-12
    #[arg(long, value_name = "L", requires = "figure", allow_hyphen_values = true, value_delimiter = ',', value_parser = parse_level)]
    contours: Vec<f64>,
    /// Draw targets: strokes as lines, foci as rings
    #[arg(long, requires = "figure")]
    targets: bool,
    /// Draw the -6 dB widths of separate foci along both axes
    #[arg(long, requires = "figure")]
    widths: bool,
    /// Draw a scale bar on the map
    #[arg(long, requires = "figure")]
    scale_bar: bool,
    /// Title above the map
    #[arg(long, value_name = "T", requires = "figure")]
    title: Option<String>,
    /// Colours for a light background: silence is white; also for --view 3d
    #[arg(long)]
    pub light: bool,
    /// State pressures as peak amplitudes instead of RMS
    #[arg(long, requires = "figure")]
    peak: bool,
}

fn parse_range(text: &str) -> Result<[f64; 2], String> {
    numbers(text)
        .filter(|&[low, high]: &[f64; 2]| low < high && low.is_finite() && high.is_finite())
        .ok_or_else(|| "give two numbers, the smaller first: A,B".to_owned())
}

fn parse_level(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(level) if (-200.0..0.0).contains(&level) => Ok(level),
        _ => Err("give a number of dB below 0, such as -6".to_owned()),
    }
}

impl FigureArgs {
    /// The options, if --figure is given.
    ///
    /// # Errors
    /// Options that exclude each other, or a quantity without a figure.
    pub(in crate::cli) fn wish(args: &RenderArgs) -> anyhow::Result<Option<(Quantity, Wish)>> {
        let figure = &args.figure;
        if !figure.figure {
            if figure.light {
                bail!("--light applies to figures and 3D views: add --figure or --view 3d");
            }
            return Ok(None);
        }
        let Diagram::Map(quantity) = args.quantity else {
            bail!(
                "--figure draws a quantity on a plane: `drive` and `sheet` are pages with axes of their own"
            );
        };
        let is_shaded = args.view == View::Shaded;
        if is_shaded && !quantity.declaration().is_surface() {
            bail!("--view shaded draws a liquid's surface: add --quantity depression");
        }
        let of_maps = [
            (figure.db, "--db"),
            (figure.range.is_some(), "--range"),
            (!figure.contours.is_empty(), "--contours"),
            (figure.targets, "--targets"),
            (figure.widths, "--widths"),
            (figure.light, "--light"),
        ];
        if let Some((_, option)) = of_maps.iter().find(|(is_given, _)| is_shaded && *is_given) {
            bail!("{option} applies to flat maps: leave out --view shaded");
        }
        let column = Paper::default();
        let wish = Wish {
            paper: Paper {
                width: figure.width_mm.unwrap_or(column.width),
                dpi: figure.dpi.unwrap_or(column.dpi),
            },
            title: figure.title.clone(),
            is_shaded,
            colours: args.colours,
            is_light: figure.light,
            scale: if figure.db { Scale::Logarithmic } else { Scale::Linear },
            range: figure.range,
            contours: figure.contours.clone(),
            convention: if figure.peak { Convention::Peak } else { Convention::Rms },
            has_colour_bar: true,
            has_scale_bar: figure.scale_bar,
            has_targets: figure.targets,
            has_widths: figure.widths,
            ..Wish::default()
        };
        Ok(Some((quantity, wish)))
    }
}

pub(in crate::cli) fn write(
    solved: &Solved,
    stages: &mut Stages,
    (look, quantity, wish): (&Look, Quantity, &Wish),
    output: &Path,
    data: Option<&Path>,
) -> anyhow::Result<()> {
    let Solved { name, scene, solution } = solved;
    let format = figure::format(output)?;
    let request = Request::new(scene, look.drives(solved)?, quantity, (1, 1));
    let gpu_is_asked_for = look.backend == Backend::Gpu;
    let drawn = figure::draw((scene, &solution.foci), &request, wish, stages, gpu_is_asked_for)?;
    if let Some(missed) = missed(drawn.map.error, scene.plane.tolerance) {
        warn(&format!("{name}: {missed}"));
    }
    if let Some(beyond) = drawn.slope.and_then(liquid::beyond_linear_theory) {
        warn(&format!("{name}: {beyond}"));
    }
    let bytes = drawn.figure.write(format)?;
    if let Some(data) = data {
        let shape = [drawn.map.height as u64, drawn.map.width as u64];
        output::write(data, &npy(&shape, &drawn.map.values)?)?;
    }
    output::write(output, &bytes)?;
    let [width, height] = drawn.figure.size();
    let (kind, points) = if wish.is_shaded { ("surface", "points") } else { ("map", "pixels") };
    say!(
        "{}: {width:.1} x {height:.1} mm, a {kind} of {} x {} {points}, {}",
        crate::echo::path(output),
        drawn.map.width,
        drawn.map.height,
        map::summary(quantity, &drawn.map)
    )
}
