//! `sonoglyph render --figure`: figures for papers, with their options.

use std::path::Path;
use std::sync::Arc;

use anyhow::bail;

use crate::cli::render::args::{RenderArgs, View};
use crate::field::{Quantity, Request, Scale, Stages, missed};
use crate::picture::figure::Paper;
use crate::picture::numbers::npy;
use crate::studio::convention::Convention;
use crate::studio::evaluator::Backend;
use crate::studio::figure::{self, MapOf, Panel, Subject, Wish};
use crate::studio::output::{self, say, warn};
use crate::studio::still::{Diagram, Look, Solved};
use crate::studio::{liquid, map};

/// The options, if --figure is given.
///
/// # Errors
/// Options that exclude each other, or a quantity without a figure.
pub fn wish(args: &RenderArgs) -> anyhow::Result<Option<(Quantity, Wish)>> {
    let figure = &args.figure;
    if !figure.figure {
        if figure.light {
            bail!("--light applies to figures and 3D views: add --figure or --view 3d");
        }
        return Ok(None);
    }
    let Diagram::Map(quantity) = args.quantity else {
        bail!("--figure draws a quantity on a plane: `drive` and `sheet` are pages with axes of their own");
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
        columns: None,
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

pub fn write(
    solved: &Solved,
    stages: &mut Stages,
    (look, quantity, wish): (&Look, Quantity, &Wish),
    output: &Path,
    data: Option<&Path>,
) -> anyhow::Result<()> {
    let Solved { name, scene, solution } = solved;
    let format = figure::format(output)?;
    let channel = look.channel;
    let request = Request { channel, ..Request::new(scene, look.drives(solved)?, quantity, (1, 1)) };
    let gpu_is_asked_for = look.backend == Backend::Gpu;
    let subject = match look.shaded {
        true => Subject::Shaded(request),
        false => Subject::Map { scene: Arc::new(scene.clone()), foci: solution.foci.clone(), request },
    };
    let panel = Panel { name: name.clone(), subject };
    let figure::Drawn { figure, maps } = figure::draw(&[panel], wish, stages, gpu_is_asked_for)?;
    let Some(MapOf { map, slope }) = maps.first() else { bail!("{name}: the figure has no map") };
    if let Some(missed) = missed(map.error, quantity.declaration().tolerance(scene.plane.tolerance)) {
        warn(&format!("{name}: {missed}"));
    }
    if let Some(beyond) = slope.and_then(liquid::beyond_linear_theory) {
        warn(&format!("{name}: {beyond}"));
    }
    let bytes = figure.write(format)?;
    if let Some(data) = data {
        let shape = [map.height as u64, map.width as u64];
        output::write(data, &npy(&shape, &map.values)?)?;
    }
    output::write(output, &bytes)?;
    let [width, height] = figure.size();
    let (kind, points) = if look.shaded { ("surface", "points") } else { ("map", "pixels") };
    say!(
        "{}: {width:.1} x {height:.1} mm, a {kind} of {} x {} {points}, {}",
        crate::echo::path(output),
        map.width,
        map.height,
        map::summary(quantity, map)
    )
}
