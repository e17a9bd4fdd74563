//! `sonoglyph elements`: positions and normals of a scene's elements, as CSV.

use std::path::PathBuf;

use clap::Args;

use crate::cli::scene::{Source, read_scene, write_or_print};
use crate::studio::elements;
use crate::studio::output::Files;

#[derive(Debug, Args)]
pub struct ElementsArgs {
    /// Scene file
    scene: PathBuf,
    /// Output file [default: standard output]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

pub fn run(args: &ElementsArgs) -> anyhow::Result<()> {
    let mut files = Files::new();
    let scene = read_scene(&args.scene, Source::default(), &mut files)?;
    if let Some(path) = &args.output {
        files.writes(path)?;
    }
    write_or_print(args.output.as_deref(), &elements::of_scene(&scene))
}
