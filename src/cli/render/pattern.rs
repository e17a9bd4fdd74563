//! `sonoglyph render --pattern`: the beam pattern as a table of levels or a figure, with its lobes in words.

use std::path::Path;

use anyhow::Context;

use crate::cli::render::args::{RenderArgs, look};
use crate::cli::render::{figure::wish, still};
use crate::cli::scene::read_scene;
use crate::field::{Evaluator, Stages};
use crate::studio::figure::{self, Panel, Subject, Wish};
use crate::studio::output::{self, Files, say};
use crate::studio::pattern::Pattern;
use crate::studio::still::{Look, Solved};

pub fn run(args: &RenderArgs) -> anyhow::Result<()> {
    let outputs = still::outputs(&args.scenes, &args.output)?;
    let wish = wish(args)?.unwrap_or_default();
    // Charts below each other fill a column.
    let wish = Wish { columns: wish.columns.or(Some(1)), ..wish };
    let (mut scenes, mut files) = (Vec::new(), Files::new());
    args.scenes.iter().try_for_each(|path| files.reads(path))?;
    outputs.iter().try_for_each(|path| files.keeps(path))?;
    for output in outputs.iter().filter(|path| !is_table(path)) {
        figure::format(output).with_context(|| "a beam pattern is a figure, or a table: .csv")?;
    }
    for path in &args.scenes {
        scenes.push(Solved::new(read_scene(path, args.source(), &mut files)?, path)?);
    }
    still::make_folder(args, &outputs)?;
    outputs.iter().try_for_each(|path| output::check_writable(path))?;
    let look = look(args);
    for (solved, output) in scenes.iter().zip(&outputs) {
        write(solved, (args, &look, &wish), output).with_context(|| solved.name.clone())?;
    }
    Ok(())
}

fn is_table(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("csv"))
}

fn write(
    solved: &Solved,
    (args, look, wish): (&RenderArgs, &Look, &Wish),
    output: &Path,
) -> anyhow::Result<()> {
    let azimuths: Vec<_> = args.pattern.cut.iter().map(|degrees| degrees.to_radians()).collect();
    let pattern = Pattern::new(&solved.scene, &look.drives(solved)?, &solved.solution.foci, &azimuths);
    let bytes = match is_table(output) {
        true => pattern.csv().into_bytes(),
        false => {
            let panels = pattern
                .panels()
                .map(|(name, plot)| Panel { name: name.to_owned(), subject: Subject::Plot(Box::new(plot)) });
            let drawn = figure::draw(&panels, wish, &mut Stages::new(Evaluator::Cpu), false)?;
            drawn.figure.write(figure::format(output)?)?
        }
    };
    output::write(output, &bytes)?;
    if args.pattern.json {
        return say!("{:#}", pattern.json());
    }
    say!("{}: beam pattern", crate::echo::path(output))?;
    for cut in &pattern.cuts {
        say!("\n{}", cut.name())?;
        for (name, value) in cut.rows() {
            say!("  {name:<28}{value}")?;
        }
    }
    Ok(())
}
