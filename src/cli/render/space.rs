//! `sonoglyph render --view 3d`: 3D pictures of scenes, with their options.

use anyhow::{Context, anyhow, bail};

use crate::cli::render::args::{RenderArgs, SpaceArgs, View, look};
use crate::cli::render::still;
use crate::cli::scene::read_scene;
use crate::echo;
use crate::field::Quantity;
use crate::field::volume::scenery::Body;
use crate::picture::export;
use crate::studio::output::{self, Files, say};
use crate::studio::space::{Look, surface_part};
use crate::studio::still::{Diagram, Solved};
use crate::studio::view_3d::{self, Wish};
use crate::studio::{evaluator, figure};

impl SpaceArgs {
    /// The first given option, which only 3D pictures have.
    pub fn given(&self) -> Option<&'static str> {
        let all = [
            (self.camera.is_some(), "--camera"),
            (self.iso.is_some(), "--iso"),
            (self.projection, "--projection"),
            (!self.slice.is_empty(), "--slice"),
            (self.parallel, "--parallel"),
        ];
        all.into_iter().find(|(is_given, _)| *is_given).map(|(_, name)| name)
    }

    /// The view of these arguments.
    pub fn wish(&self, args: &RenderArgs) -> Wish {
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

pub fn run(args: &RenderArgs) -> anyhow::Result<()> {
    if args.data.is_some() {
        bail!("--view 3d is a picture: leave out --data; --volume writes the numbers");
    }
    let outputs = still::outputs(&args.scenes, &args.output)?;
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
        scenes.push(Solved::new(read_scene(path, args.source(), &mut files)?, path)?);
    }
    still::make_folder(args, &outputs)?;
    outputs.iter().try_for_each(|path| output::check_writable(path))?;
    let evaluator = evaluator::for_maps(args.backend.backend, args.verbose)?;
    for (solved, path) in scenes.iter().zip(&outputs) {
        let drawn =
            view_3d::draw(solved, &look(args), &wish, &evaluator).with_context(|| solved.name.clone())?;
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

/// Refuses options of 3D pictures for other pictures, and other options for 3D pictures.
pub fn refuse(args: &RenderArgs) -> anyhow::Result<()> {
    if args.view == View::Space && (args.motion || args.waves) {
        bail!("--view 3d is a still picture: leave out --motion and --waves");
    }
    let is_space = args.view == View::Space && args.volume.volume.is_none();
    if is_space && args.quantity != Diagram::Map(Quantity::Rms) {
        bail!("--view 3d shows the RMS pressure: leave out --quantity");
    }
    if is_space && args.fps.is_some() {
        bail!("--view 3d is a picture: leave out --fps");
    }
    match args.space.given() {
        Some(name) if args.view != View::Space => bail!("{name} applies to 3D views: add --view 3d"),
        Some(_) | None => Ok(()),
    }
}
