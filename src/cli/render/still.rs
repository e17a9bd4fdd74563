//! `sonoglyph render`: still pictures and figures of scenes.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, anyhow, bail};
use indicatif::{ProgressBar, ProgressStyle};

use crate::cli::render::args::{RenderArgs, View, look};
use crate::cli::render::figure::{wish, write as write_figure};
use crate::cli::scene::read_scene;
use crate::echo;
use crate::field::{Evaluator, Stages};
use crate::rounding::milliseconds;
use crate::studio::opening::stem;
use crate::studio::output::{self, Files, say};
use crate::studio::still::{self, Diagram, Solved};
use crate::studio::{evaluator, figure};

pub fn run(args: &RenderArgs) -> anyhow::Result<()> {
    if args.volume.block.is_some() && args.view != View::Space {
        bail!("--box applies to volumes and 3D views: add --volume or --view 3d");
    }
    let is_page = args.figure.columns.is_some();
    let outputs = if is_page { vec![args.output.clone()] } else { outputs(&args.scenes, &args.output)? };
    if args.data.is_some() && args.scenes.len() > 1 {
        bail!("--data takes the numbers of one scene, and {} are given", args.scenes.len());
    }
    if args.fps.is_some() {
        bail!("--fps applies to animations: add --motion or --waves");
    }
    let (look, wish) = (look(args), wish(args)?);
    // All scenes are read and solved before the first is drawn, so that an error in the last costs no drawing.
    let (mut scenes, mut files) = (Vec::new(), Files::new());
    args.scenes.iter().try_for_each(|path| files.reads(path))?;
    outputs.iter().chain(&args.data).try_for_each(|path| files.keeps(path))?;
    for output in &outputs {
        match &wish {
            Some(_) => figure::format(output).map(drop)?,
            None => figure::refuse_ending(output, &["png"])
                .map_err(|error| anyhow!("{error}; with --figure as .png, .svg or .pdf"))?,
        }
    }
    for path in &args.scenes {
        let mut scene = read_scene(path, args.source(), &mut files)?;
        scene.plane.tolerance = args.tolerance.unwrap_or(scene.plane.tolerance);
        if wish.is_none() {
            look.pixels(&scene)?;
        }
        scenes.push(Solved::new(scene, path)?);
    }
    make_folder(args, &outputs)?;
    for path in outputs.iter().chain(&args.data) {
        output::check_writable(path)?;
    }
    // A drive needs no field, hence no evaluator to report.
    let mut stages = Stages::new(match args.quantity {
        Diagram::Drive => Evaluator::Cpu,
        Diagram::Map(_) | Diagram::Sheet => evaluator::for_maps(look.backend, args.verbose)?,
    });

    let bar = bar(scenes.len());
    if let Some(wish) = &wish {
        let pages = scenes.chunks(if is_page { scenes.len() } else { 1 });
        for (page, output) in pages.zip(&outputs) {
            let name = page.iter().map(|solved| solved.name.as_str()).collect::<Vec<_>>().join(", ");
            bar.set_message(echo::value(&name));
            bar.suspend(|| write_figure(page, &mut stages, (args, &look, wish), output).context(name))?;
            bar.inc(page.len() as u64);
        }
        bar.finish_and_clear();
        return Ok(());
    }
    for (solved, output) in scenes.iter().zip(&outputs) {
        bar.set_message(echo::value(&solved.name));
        let start = Instant::now();
        let rendered = still::render(solved, &mut stages, &look).with_context(|| solved.name.clone())?;
        rendered.write(output, args.data.as_deref())?;
        bar.suspend(|| {
            say!("{}", rendered.line(output))?;
            match args.verbose {
                true => {
                    let whole = milliseconds(start.elapsed().as_secs_f64(), 0);
                    say!("  {}; {whole} in all", rendered.how)
                }
                false => Ok(()),
            }
        })?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(())
}

/// One output per scene: the named file, or files in the named folder.
pub fn outputs(scenes: &[PathBuf], output: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let named_as_folder = output.as_os_str().to_string_lossy().ends_with(std::path::is_separator);
    if scenes.len() == 1 && !output.is_dir() && !named_as_folder {
        return Ok(vec![output.to_owned()]);
    }
    if output.is_file() {
        bail!("{}: {} scenes need a folder, and this is a file", output.display(), scenes.len());
    }
    let mut outputs = Vec::new();
    for scene in scenes {
        let path = output.join(format!("{}.png", stem(scene)));
        if outputs.contains(&path) {
            bail!("{}: two scenes would be written to this file", path.display());
        }
        outputs.push(path);
    }
    Ok(outputs)
}

/// Creates the output folder. The folder of a single named file must exist.
pub fn make_folder(args: &RenderArgs, outputs: &[PathBuf]) -> anyhow::Result<()> {
    if outputs.len() == 1 && outputs[0] == args.output {
        return Ok(());
    }
    std::fs::create_dir_all(&args.output)
        .with_context(|| format!("{}: cannot make the folder", args.output.display()))
}

fn bar(scenes: usize) -> ProgressBar {
    if scenes < 2 {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{bar:30} {pos}/{len} {msg}");
    ProgressBar::new(scenes as u64).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}
