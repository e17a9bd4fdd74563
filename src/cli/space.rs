//! `sonoglyph render --view 3d`: 3D pictures of scenes, with their options.

use anyhow::{Context, anyhow, bail};
use clap::Args;

use crate::cli::arguments::{between, numbers};
use crate::cli::{RenderArgs, View, read_scene, render};
use crate::echo;
use crate::field::Quantity;
use crate::field::volume::camera::Standard;
use crate::field::volume::scenery::Body;
use crate::picture::export;
use crate::studio::output::{self, Files, say};
use crate::studio::space::{Look, surface_part};
use crate::studio::still::{Diagram, Solved};
use crate::studio::view_3d::{self, Wish};
use crate::studio::{evaluator, figure};

/// dB relative to the peak, of an isosurface.
const LEVELS: [f64; 2] = [-60.0, -0.1];

#[derive(Debug, Args)]
#[command(next_help_heading = "Space")]
pub struct SpaceArgs {
    /// View direction: iso, top, front, side, or azimuth and elevation in degrees
    #[arg(long, value_name = "VIEW|A,E", allow_hyphen_values = true, value_parser = parse_camera)]
    camera: Option<[f64; 2]>,
    /// Isosurface of the RMS pressure, in dB relative to the peak [default: -6]
    #[arg(long, value_name = "DB", allow_hyphen_values = true, value_parser = between(LEVELS, "dB"), conflicts_with = "projection")]
    iso: Option<f64>,
    /// Maximum-intensity projection of the RMS pressure, instead of an isosurface
    #[arg(long)]
    projection: bool,
    /// Slices through the field, at positions in m: z=0.1 or x=0,y=0.01
    #[arg(long, value_name = "AXIS=M", value_delimiter = ',', value_parser = parse_slice)]
    slice: Vec<(usize, f64)>,
    /// Parallel projection instead of perspective
    #[arg(long)]
    parallel: bool,
}

fn parse_camera(text: &str) -> Result<[f64; 2], String> {
    if let Ok(standard) = text.parse::<Standard>() {
        return Ok(standard.direction());
    }
    numbers(text)
        .filter(|&[azimuth, elevation]: &[f64; 2]| azimuth.abs() <= 360.0 && elevation.abs() <= 90.0)
        .map(|direction| direction.map(f64::to_radians))
        .ok_or_else(|| {
            "give iso, top, front, side, or an azimuth from -360 to 360 and an elevation from -90 to 90 degrees: A,E"
                .to_owned()
        })
}

fn parse_slice(text: &str) -> Result<(usize, f64), String> {
    let parts = text.split_once('=');
    let axis = parts.and_then(|(name, _)| ["x", "y", "z"].iter().position(|axis| *axis == name.trim()));
    match (axis, parts.map(|(_, place)| place.trim().parse::<f64>())) {
        (Some(axis), Some(Ok(place))) if place.abs() <= 100.0 => Ok((axis, place)),
        _ => Err("give an axis and a place in metres, such as z=0.1".to_owned()),
    }
}

impl SpaceArgs {
    /// The first given option, which only 3D pictures have.
    pub(in crate::cli) fn given(&self) -> Option<&'static str> {
        let all = [
            (self.camera.is_some(), "--camera"),
            (self.iso.is_some(), "--iso"),
            (self.projection, "--projection"),
            (!self.slice.is_empty(), "--slice"),
            (self.parallel, "--parallel"),
        ];
        all.into_iter().find(|(is_given, _)| *is_given).map(|(_, name)| name)
    }

    fn wish(&self, args: &RenderArgs) -> Wish {
        let mut look = Look { colours: args.colours, is_light: args.figure.light, ..Look::default() };
        if self.projection {
            look.body = Body::Projection;
        }
        if let Some(level) = self.iso {
            look.body = Body::Surface(surface_part(level));
        }
        for &(axis, place) in &self.slice {
            look.slices[axis] = Some(place);
        }
        let own = Wish::default();
        Wish {
            look,
            direction: self.camera.unwrap_or(own.direction),
            is_perspective: !self.parallel,
            block: args.volume.block,
            size: args.size,
        }
    }
}

pub(in crate::cli) fn run(args: &RenderArgs) -> anyhow::Result<()> {
    if args.quantity != Diagram::Map(Quantity::Rms) {
        bail!("--view 3d shows the RMS pressure: leave out --quantity");
    }
    if args.figure.figure || args.data.is_some() || args.fps.is_some() {
        bail!("--view 3d is a picture: leave out --figure, --data and --fps; --volume writes the numbers");
    }
    let outputs = render::outputs(&args.scenes, &args.output)?;
    let wish = args.space.wish(args);
    wish.pixels()?;
    let (mut scenes, mut files) = (Vec::new(), Files::new());
    args.scenes.iter().try_for_each(|path| files.reads(path))?;
    for output in &outputs {
        files.keeps(output)?;
        figure::refuse_ending(output, &["png"])
            .map_err(|error| anyhow!("{error}; --volume writes .vti and .npy"))?;
    }
    for path in &args.scenes {
        scenes.push(Solved::new(read_scene(path, args.method, &mut files)?, path)?);
    }
    render::make_folder(args, &outputs)?;
    outputs.iter().try_for_each(|path| output::check_writable(path))?;
    let evaluator = evaluator::for_maps(args.backend.backend, args.verbose)?;
    for (solved, path) in scenes.iter().zip(&outputs) {
        let drawn = view_3d::draw(solved, &render::look(args), &wish, &evaluator)
            .with_context(|| solved.name.clone())?;
        let png =
            export::png(&drawn.picture).with_context(|| format!("{}: cannot encode", path.display()))?;
        output::write(path, &png)?;
        let (width, height) = (drawn.picture.width, drawn.picture.height);
        say!("{}: {width} x {height} pixels, {}", echo::path(path), drawn.what)?;
        if args.verbose {
            say!("  {}", drawn.how)?;
        }
    }
    Ok(())
}

/// Refuses options of 3D pictures for other pictures, and animations of 3D pictures.
pub(in crate::cli) fn refuse(args: &RenderArgs) -> anyhow::Result<()> {
    if args.view == View::Space && (args.motion || args.waves) {
        bail!("--view 3d is a still picture: leave out --motion and --waves");
    }
    match args.space.given() {
        Some(name) if args.view != View::Space => bail!("{name} applies to 3D views: add --view 3d"),
        Some(_) | None => Ok(()),
    }
}
