//! `sonoglyph render`: pictures, animations, volumes and 3D views of scenes.

mod animate;
pub mod args;
mod figure;
mod pattern;
mod space;
mod still;
mod volume;

use crate::cli::render::args::{RenderArgs, View};

/// Runs the command.
///
/// # Errors
/// Bad input, or output that cannot be written.
pub fn run(args: &RenderArgs) -> anyhow::Result<()> {
    space::refuse(args)?;
    if args.pattern.pattern {
        return pattern::run(args);
    }
    match (args.motion || args.waves, args.volume.volume, args.view) {
        (true, _, _) => animate::run(args),
        (false, Some(counts), _) => volume::run(args, counts),
        (false, None, View::Space) if !args.figure.figure => space::run(args),
        (false, None, View::Flat | View::Shaded | View::Space) => still::run(args),
    }
}
