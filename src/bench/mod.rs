//! `sonoglyph bench`: time against error, measured beside a baseline in the same run.

mod conditions;
mod dent;
mod field;
mod figures;
mod foci;
#[cfg(all(unix, feature = "serial"))]
mod link;
mod page;
mod shapes;
mod solve;
mod stability;
mod time;
#[cfg(feature = "window")]
mod window;

use std::path::{Path, PathBuf};

use anyhow::Context;
use comfy_table::{CellAlignment, Table};
use serde_json::{Map, Value};

use crate::echo;
use crate::picture::chart::Chart;
use crate::picture::export;
use crate::studio::output::{self, Files, note, say, warn};
use conditions::Conditions;

/// What is measured, and what is made of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Options {
    pub subject: Subject,
    /// Where every record goes as JSON.
    pub json: Option<PathBuf>,
    /// The folder of the charts, and of the page that holds them.
    pub plots: Option<PathBuf>,
    /// Fewer cases: fewer sizes, planes, arrays, tolerances and sets of foci.
    pub quick: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Subject {
    /// Maps of the field, and depressions and means beside them.
    Field,
    /// Solver methods.
    Solve,
    /// Solver methods on sets of foci that are hard to solve.
    Stability,
    /// Drives of drawings.
    Shapes,
    /// Frames of the window.
    Window,
    /// Links to virtual boards.
    Link,
    All,
}

/// Measures one subject; `true` asks for fewer cases.
type Measure = fn(bool) -> anyhow::Result<Report>;

/// What a benchmark found.
#[derive(Debug)]
pub struct Report {
    pub header: Vec<&'static str>,
    pub rows: Vec<Vec<String>>,
    /// How to read the rows, a sentence each.
    pub notes: Vec<String>,
    pub records: Vec<Value>,
    /// File names without extension, and the charts.
    pub charts: Vec<(String, Chart)>,
}

/// A part of the whole report.
#[derive(Debug)]
struct Section {
    /// Its key in the JSON.
    name: &'static str,
    title: &'static str,
    /// What was found, or why nothing was.
    found: Result<Report, String>,
}

/// Subject, key in the JSON, title, and who measures it.
fn subjects() -> [(Subject, &'static str, &'static str, Measure); 7] {
    [
        (Subject::Field, "field", "Maps of the field", field::run),
        (Subject::Field, "dent", "Depressions, radiation pressure and means over a cycle", dent::run),
        (Subject::Solve, "solve", "Solver methods", solve::run),
        (Subject::Stability, "stability", "Foci that are hard to solve", stability::run),
        (Subject::Shapes, "shapes", "Drives of drawings", shapes::run),
        (Subject::Window, "window", "Frames of the window", window()),
        (Subject::Link, "link", "Links to boards", link()),
    ]
}

#[cfg(feature = "window")]
fn window() -> Measure {
    window::run
}

#[cfg(not(feature = "window"))]
fn window() -> Measure {
    |_| anyhow::bail!("this program was built without its window")
}

#[cfg(all(unix, feature = "serial"))]
fn link() -> Measure {
    link::run
}

#[cfg(not(all(unix, feature = "serial")))]
fn link() -> Measure {
    |_| anyhow::bail!("links are measured on a Unix system, by a program built with serial links")
}

/// Measures what is asked for, prints it, and writes the JSON, the charts and the page.
///
/// # Errors
/// What cannot be written; what cannot be measured, unless everything is asked for: then the report says why it is missing.
pub fn run(options: &Options) -> anyhow::Result<()> {
    let mut files = Files::new();
    if let Some(path) = &options.json {
        files.writes(path)?;
    }
    if let Some(folder) = &options.plots {
        std::fs::create_dir_all(folder)
            .with_context(|| format!("{}: cannot make the folder", folder.display()))?;
        files.writes(&folder.join(page::NAME))?;
    }
    let conditions = Conditions::now();
    let mut sections = Vec::new();
    for (subject, name, title, measure) in subjects() {
        if ![Subject::All, subject].contains(&options.subject) {
            continue;
        }
        note(&format!("measuring: {}", title.to_lowercase()));
        let found = match measure(options.quick) {
            Ok(report) => {
                show(&report)?;
                Ok(report)
            }
            Err(error) if options.subject == Subject::All => {
                warn(&format!("{name} is missing from the report: {error:#}"));
                Err(format!("{error:#}"))
            }
            Err(error) => return Err(error),
        };
        sections.push(Section { name, title, found });
    }
    let value = json(&conditions, &sections);
    if let Some(path) = &options.json {
        output::write(path, serde_json::to_string_pretty(&value)?.as_bytes())?;
    }
    if let Some(folder) = &options.plots {
        write_page(folder, &conditions, &sections, &value, &mut files)?;
    }
    Ok(())
}

fn show(report: &Report) -> anyhow::Result<()> {
    let mut table = Table::new();
    table.set_header(&report.header);
    table.add_rows(&report.rows);
    for (index, column) in table.column_iter_mut().enumerate() {
        if report.holds_numbers(index) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    say!("{table}")?;
    for line in &report.notes {
        say!("{line}")?;
    }
    Ok(())
}

impl Report {
    /// Whether a column's cells are to stand at the right.
    fn holds_numbers(&self, column: usize) -> bool {
        let is_number =
            |cell: &String| cell == "exact" || cell.starts_with(|c: char| c.is_ascii_digit() || c == '-');
        self.rows.iter().filter_map(|row| row.get(column)).all(is_number)
    }
}

/// Conditions and figures, and the records of every section by its name; `missing` says why there are none.
fn json(conditions: &Conditions, sections: &[Section]) -> Value {
    let mut value = conditions.json();
    let mut missing = Map::new();
    for section in sections {
        match &section.found {
            Ok(report) => value[section.name] = report.records.clone().into(),
            Err(reason) => drop(missing.insert(section.name.to_owned(), reason.clone().into())),
        }
    }
    value["missing"] = missing.into();
    value["figures"] = figures::measured(&value).iter().map(figures::Measured::json).collect();
    value
}

fn write_page(
    folder: &Path,
    conditions: &Conditions,
    sections: &[Section],
    value: &Value,
    files: &mut Files,
) -> anyhow::Result<()> {
    for (name, chart) in
        sections.iter().filter_map(|section| section.found.as_ref().ok()).flat_map(|r| &r.charts)
    {
        let path = folder.join(name).with_extension("png");
        files.keeps(&path)?;
        output::write(&path, &export::png(&chart.draw()?)?)?;
        say!("{}", echo::path(&path))?;
    }
    let path = folder.join(page::NAME);
    output::write(&path, page::html(conditions, sections, &figures::measured(value))?.as_bytes())?;
    say!("{}", echo::path(&path))
}
