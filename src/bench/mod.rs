//! `sonoglyph bench`: time against error on this machine, relative to a baseline in the same run.

pub mod conditions;
pub mod drawings;
pub mod field;
pub mod foci;
pub mod shapes;
pub mod solve;
pub mod stability;
pub mod time;

use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::{Args, ValueEnum};
use comfy_table::{CellAlignment, Table};
use serde_json::Value;

use crate::echo;
use crate::picture::chart::Chart;
use crate::picture::export;
use crate::studio::output::{self, Files, note, say};

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

/// Results of a benchmark.
#[derive(Debug)]
pub struct Report {
    pub header: Vec<&'static str>,
    pub rows: Vec<Vec<String>>,
    /// Explanations of the columns, a paragraph each.
    pub notes: Vec<String>,
    pub records: Vec<Value>,
    /// Charts with their file names without extension.
    pub charts: Vec<(String, Chart)>,
}

/// A subject, its key in the JSON, the names of its charts, and its benchmark.
type Part = (Subject, &'static str, &'static [&'static str], fn() -> anyhow::Result<Report>);

const PARTS: [Part; 4] = [
    (Subject::Field, "field", &["field-error"], field::run),
    (Subject::Solve, "solve", &["solve-loss-8", "solve-loss-32"], solve::run),
    (Subject::Shapes, "shapes", &["shapes-side-lobe"], shapes::run),
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

impl Report {
    /// Prints the table without empty columns, and the notes.
    ///
    /// # Errors
    /// Standard output cannot be written.
    pub fn show(&self) -> anyhow::Result<()> {
        let mut table = Table::new();
        let is_shown = |column: &usize| self.rows.iter().any(|row| row[*column] != "-");
        let columns: Vec<_> = (0..self.header.len()).filter(is_shown).collect();
        table.set_header(columns.iter().map(|&column| self.header[column]));
        table.add_rows(self.rows.iter().map(|row| columns.iter().map(|&column| &row[column])));
        for (&index, column) in columns.iter().zip(table.column_iter_mut()) {
            if self.holds_numbers(index) {
                column.set_cell_alignment(CellAlignment::Right);
            }
        }
        say!("{table}")?;
        self.notes.iter().try_for_each(|line| say!("{line}"))
    }

    /// Whether a column is aligned to the right.
    pub fn holds_numbers(&self, column: usize) -> bool {
        let is_number =
            |cell: &String| cell == "exact" || cell.starts_with(|c: char| c.is_ascii_digit() || c == '-');
        self.rows.iter().filter_map(|row| row.get(column)).all(is_number)
    }
}
