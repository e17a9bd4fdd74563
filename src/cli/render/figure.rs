//! `sonoglyph render --figure`: figures for papers, with their options.

use std::path::Path;
use std::sync::Arc;

use anyhow::bail;

use crate::cli::render::args::{RenderArgs, View};
use crate::field::{Request, Scale, Stages, missed};
use crate::picture::figure::Paper;
use crate::picture::figure::elements::Elements;
use crate::picture::figure::page::Plot;
use crate::picture::numbers::npy;
use crate::picture::sheet::amplitude_title;
use crate::studio::convention::Convention;
use crate::studio::evaluator::Backend;
use crate::studio::figure::{self, MapOf, Panel, Subject, Wish};
use crate::studio::output::{self, say, warn};
use crate::studio::still::{Diagram, Look, Solved};
use crate::studio::{liquid, map, view_3d};

/// The options, if --figure is given.
///
/// # Errors
/// Options that exclude each other, or a quantity without a figure.
pub fn wish(args: &RenderArgs) -> anyhow::Result<Option<Wish>> {
    let figure = &args.figure;
    if !figure.figure {
        if figure.light {
            bail!("--light applies to figures and 3D views: add --figure or --view 3d");
        }
        return Ok(None);
    }
    let is_surface = matches!(args.quantity, Diagram::Map(quantity) if quantity.declaration().is_surface());
    let other = match (args.quantity, args.view) {
        (Diagram::Sheet, _) => bail!("--figure draws panels, and `sheet` is a page with axes of its own"),
        (_, View::Shaded) if !is_surface => {
            bail!("--view shaded draws a liquid's surface: add --quantity depression")
        }
        (Diagram::Map(_), View::Flat) if args.pattern.pattern => Some("leave out --pattern"),
        (Diagram::Map(_), View::Flat) => None,
        (Diagram::Map(_) | Diagram::Drive, View::Shaded) => Some("leave out --view shaded"),
        (Diagram::Map(_) | Diagram::Drive, View::Space) => Some("leave out --view 3d"),
        (Diagram::Drive, View::Flat) => Some("leave out --quantity drive"),
    };
    let of_maps = [
        (figure.db, "--db"),
        (figure.range.is_some(), "--range"),
        (!figure.contours.is_empty(), "--contours"),
        (figure.targets, "--targets"),
        (figure.widths, "--widths"),
        (figure.arrows, "--arrows"),
        (figure.light && args.view != View::Space, "--light"),
        (figure.scale_bar && args.view != View::Shaded, "--scale-bar"),
        (args.data.is_some() && args.view != View::Shaded, "--data"),
    ];
    if let (Some(instead), Some((_, option))) = (other, of_maps.iter().find(|(is_given, _)| *is_given)) {
        bail!("{option} applies to flat maps: {instead}");
    }
    let column = Paper::default();
    let wish = Wish {
        paper: Paper {
            width: figure.width_mm.unwrap_or(column.width),
            dpi: figure.dpi.unwrap_or(column.dpi),
        },
        title: figure.title.clone(),
        columns: figure.columns.map(usize::from),
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
        has_arrows: figure.arrows,
        ..Wish::default()
    };
    Ok(Some(wish))
}

/// Writes the figure of some scenes on one page.
///
/// # Errors
/// Figures that cannot be drawn, or files that cannot be written.
pub fn write(
    scenes: &[Solved],
    stages: &mut Stages,
    (args, look, wish): (&RenderArgs, &Look, &Wish),
    output: &Path,
) -> anyhow::Result<()> {
    let format = figure::format(output)?;
    let mut panels = Vec::new();
    for solved in scenes {
        panels.extend(self::panels(solved, (args, look), scenes.len() == 1)?);
    }
    let gpu_is_asked_for = look.backend == Backend::Gpu;
    let figure::Drawn { figure, maps } = figure::draw(&panels, wish, stages, gpu_is_asked_for)?;
    for (Solved { name, scene, .. }, MapOf { map, slope, quantity }) in scenes.iter().zip(&maps) {
        if let Some(missed) = missed(map.error, quantity.declaration().tolerance(scene)) {
            warn(&format!("{name}: {missed}"));
        }
        if let Some(beyond) = slope.and_then(liquid::beyond_linear_theory) {
            warn(&format!("{name}: {beyond}"));
        }
    }
    let bytes = figure.write(format)?;
    if let (Some(data), Some(MapOf { map, .. })) = (&args.data, maps.first()) {
        let shape = [map.height as u64, map.width as u64];
        output::write(data, &npy(&shape, &map.values)?)?;
    }
    output::write(output, &bytes)?;
    let [width, height] = figure.size();
    let page = format!("{}: {width:.1} x {height:.1} mm", crate::echo::path(output));
    let [MapOf { map, quantity, .. }] = &maps[..] else {
        return say!("{page}, {} panels", panels.len());
    };
    let (kind, points) = if look.shaded { ("surface", "points") } else { ("map", "pixels") };
    say!("{page}, a {kind} of {} x {} {points}, {}", map.width, map.height, map::summary(*quantity, map))
}

/// The panels of a scene.
fn panels(solved: &Solved, (args, look): (&RenderArgs, &Look), is_only: bool) -> anyhow::Result<Vec<Panel>> {
    let Solved { name, scene, solution } = solved;
    let panel = |subject| Panel { name: name.clone(), subject };
    let quantity = match args.quantity {
        Diagram::Map(quantity) => quantity,
        Diagram::Drive => {
            let drive = &solution.drive;
            let elements = |elements| Subject::Plot(Box::new(Plot::Elements(elements)));
            let phases = elements(Elements::phases(scene, &drive.phases, &drive.amplitudes));
            let own = elements(Elements::amplitudes(scene, &solution.excitation, &drive.amplitudes));
            let named = |(subject, title): (Subject, &str)| match is_only {
                true => Panel { name: title.to_owned(), subject },
                false => Panel { name: format!("{name}: {title}"), subject },
            };
            let panels = [(phases, "Phase per element"), (own, amplitude_title(solution))];
            return Ok(panels.map(named).to_vec());
        }
        Diagram::Sheet => bail!("--figure draws panels, and `sheet` is a page with axes of its own"),
    };
    if args.view == View::Space {
        let prospect = view_3d::prospect(solved, look, &args.space.wish(args))?;
        return Ok(vec![panel(Subject::Space(Box::new(prospect)))]);
    }
    let channel = look.channel;
    let request = Request { channel, ..Request::new(scene, look.drives(solved)?, quantity, (1, 1)) };
    Ok(vec![panel(match look.shaded {
        true => Subject::Shaded(request),
        false => Subject::Map { scene: Arc::new(scene.clone()), foci: solution.foci.clone(), request },
    })])
}
