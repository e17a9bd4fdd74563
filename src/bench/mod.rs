//! `sonoglyph bench`: time against error on this machine, relative to a baseline in the same run.

pub mod conditions;
pub mod drawings;
pub mod field;
pub mod foci;
mod report;
pub mod shapes;
pub mod solve;
pub mod stability;
pub mod time;

use crate::echo;
use crate::picture::chart::Chart;
use crate::picture::export;
use crate::studio::output::{self, Files, note, say};
use anyhow::Context;
use clap::{Args, ValueEnum};
use std::path::{Path, PathBuf};

pub use report::Report;

#[derive(Debug, Args)]
pub struct BenchArgs {
    /// Subject of the measurements
    #[arg(value_enum, default_value_t = Subject::All)]
    subject: Subject,
    /// Write every record as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write charts as PNG into a folder
    #[arg(long, value_name = "DIR")]
    plots: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Subject {
    /// Maps by evaluator and tolerance
    Field,
    /// Solver methods on random sets of foci
    Solve,
    /// Shapes as continuous strokes and as separate foci
    Shapes,
    /// Solver methods on ill-conditioned sets of foci
    Stability,
    All,
}

/// A subject, its key in the JSON, the names of its charts, and its benchmark.
type Part = (Subject, &'static str, &'static [&'static str], fn() -> anyhow::Result<Report>);

const PARTS: [Part; 4] = [
    (Subject::Field, "field", &["field-error"], field::run),
    (Subject::Solve, "solve", &["solve-loss-8", "solve-loss-32"], solve::run),
    (Subject::Shapes, "shapes", &["shapes-side-lobe", "shapes-strength"], shapes::run),
    (Subject::Stability, "stability", &[], || stability::run(false)),
];

/// Measures the requested subjects, prints the tables, and writes the JSON and the charts.
///
/// # Errors
/// A benchmark that fails, or files that cannot be written.
pub fn run(args: &BenchArgs) -> anyhow::Result<()> {
    let parts = PARTS.iter().filter(|part| [Subject::All, part.0].contains(&args.subject));
    let mut files = Files::new();
    if let Some(path) = &args.json {
        files.writes(path)?;
    }
    if let Some(folder) = &args.plots {
        std::fs::create_dir_all(folder)
            .with_context(|| format!("{}: cannot make the folder", folder.display()))?;
        let charts = parts.clone().flat_map(|part| part.2);
        charts.map(|name| folder.join(name).with_extension("png")).try_for_each(|path| files.keeps(&path))?;
    }
    let mut value = conditions::json();
    for (_, name, _, measure) in parts {
        note(&format!("measuring: {name}"));
        let report = measure()?;
        report.show()?;
        if let Some(folder) = &args.plots {
            let file = |name: &str| folder.join(name).with_extension("png");
            report.charts.iter().try_for_each(|(name, chart)| draw(&file(name), chart))?;
        }
        value[*name] = report.records.into();
    }
    match &args.json {
        Some(path) => output::write(path, serde_json::to_string_pretty(&value)?.as_bytes()),
        None => Ok(()),
    }
}

fn draw(path: &Path, chart: &Chart) -> anyhow::Result<()> {
    output::write(path, &export::png(&chart.draw()?)?)?;
    say!("{}", echo::path(path))
}
