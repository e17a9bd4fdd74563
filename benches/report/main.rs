//! The benchmark report for developers, and the README's table: `cargo bench --bench report -- --help`.

mod depression;
mod field;
mod figures;
#[cfg(unix)]
mod link;
mod page;
mod search;
mod solve;
mod window;

use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::{Parser, ValueEnum};
use jiff::Timestamp;
use serde_json::{Value, json};
use sonoglyph::bench::drawings::DRAWINGS;
use sonoglyph::bench::{Report, conditions, shapes, stability};
use sonoglyph::picture::export;
use sonoglyph::studio::evaluator;
use sonoglyph::studio::output::{note, print, warn, write};

/// Measures time against error, relative to baselines in the same run, and writes one page, report.html, with
/// report.json and the charts as PNG.
#[derive(Debug, Parser)]
#[command(bin_name = "cargo bench --bench report --", max_term_width = 100)]
struct Arguments {
    /// Measured subjects [default: all]
    #[arg(value_enum)]
    subjects: Vec<Subject>,
    /// Fewer sizes, planes, arrays, tolerances and sets of foci: three minutes instead of 35
    #[arg(long)]
    quick: bool,
    /// Output folder
    #[arg(short, long, value_name = "DIR", default_value = "target/report")]
    output: PathBuf,
    /// Measure nothing; write the medians of earlier runs into the README's table
    #[arg(long, value_name = "RUN.json", num_args = 1.., conflicts_with_all = ["subjects", "quick", "output"])]
    readme: Vec<PathBuf>,
    /// Passed by `cargo bench`
    #[arg(long, hide = true)]
    bench: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Subject {
    /// Maps by evaluator, error, pixels, elements and plane
    Field,
    /// Depressions, radiation pressure and means over a cycle, relative to a pressure map
    Depression,
    /// Solver methods on rings, helices and random sets, and by number of foci and elements
    Solve,
    /// Solver methods on ill-conditioned sets of foci
    Stability,
    /// Shapes as continuous strokes and as separate foci
    Shapes,
    /// Convergence of the search for shapes, call by call
    Search,
    /// Frames of the window
    Window,
    /// Links to virtual boards
    Link,
}

impl Subject {
    /// The key in the JSON.
    fn name(self) -> String {
        self.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
    }

    fn title(self) -> &'static str {
        match self {
            Self::Field => "Maps of the field",
            Self::Depression => "Depressions, radiation pressure and means over a cycle",
            Self::Solve => "Solver methods",
            Self::Stability => "Ill-conditioned sets of foci",
            Self::Shapes => "Shapes: continuous strokes and separate foci",
            Self::Search => "Convergence of the search for shapes",
            Self::Window => "Frames of the window",
            Self::Link => "Links to boards",
        }
    }

    fn measure(self, quick: bool) -> anyhow::Result<Report> {
        let drawings = if quick { &DRAWINGS[..QUICK_DRAWINGS] } else { &DRAWINGS };
        match self {
            Self::Field => field::run(quick),
            Self::Depression => depression::run(quick),
            Self::Solve => solve::run(quick),
            Self::Stability => stability::run(!quick),
            Self::Shapes => shapes::on(drawings),
            Self::Search => search::run(drawings),
            Self::Window => window::run(quick),
            #[cfg(unix)]
            Self::Link => link::run(quick),
            #[cfg(not(unix))]
            Self::Link => anyhow::bail!("measuring links needs a Unix system"),
        }
    }
}

const QUICK_DRAWINGS: usize = 5;

/// A part of the report, or the reason for its absence.
struct Section {
    subject: Subject,
    found: Result<Report, String>,
}

fn main() -> anyhow::Result<()> {
    evaluator::quiet_drivers();
    let args = Arguments::parse();
    if !args.readme.is_empty() {
        return write_readme(&args.readme);
    }
    std::fs::create_dir_all(&args.output)
        .with_context(|| format!("{}: cannot make the folder", args.output.display()))?;
    let mut run = conditions::json();
    run["load"] = json!(load());
    let now = Timestamp::now();
    run["date"] = json!(now.strftime("%Y-%m-%d").to_string());
    run["time"] = json!(now.strftime("%H:%M UTC").to_string());
    let subjects = if args.subjects.is_empty() { Subject::value_variants() } else { &args.subjects };
    let mut sections = Vec::new();
    for &subject in subjects {
        note(&format!("measuring: {}", subject.title().to_lowercase()));
        let found = subject.measure(args.quick).map_err(|error| format!("{error:#}"));
        match &found {
            Ok(report) => {
                report.show()?;
                run[subject.name()] = report.records.clone().into();
            }
            Err(error) => warn(&format!("{} is missing from the report: {error}", subject.name())),
        }
        sections.push(Section { subject, found });
    }
    write_report(&args.output, &run, &sections)
}

fn write_report(folder: &Path, run: &Value, sections: &[Section]) -> anyhow::Result<()> {
    let reports = sections.iter().filter_map(|section| section.found.as_ref().ok());
    for (name, chart) in reports.flat_map(|report| &report.charts) {
        write(&folder.join(name).with_extension("png"), &export::png(&chart.draw()?)?)?;
    }
    write(&folder.join("report.json"), serde_json::to_string_pretty(run)?.as_bytes())?;
    let page = folder.join("report.html");
    write(&page, page::html(run, sections)?.as_bytes())?;
    print(format_args!("{}\n", page.display()))
}

fn write_readme(paths: &[PathBuf]) -> anyhow::Result<()> {
    let read = |path: &PathBuf| -> anyhow::Result<Value> {
        let text = std::fs::read(path).with_context(|| path.display().to_string())?;
        serde_json::from_slice(&text).with_context(|| path.display().to_string())
    };
    let runs = paths.iter().map(read).collect::<anyhow::Result<Vec<_>>>()?;
    let path = Path::new(figures::README);
    let text = std::fs::read_to_string(path).with_context(|| path.display().to_string())?;
    write(path, figures::inserted(&text, &runs)?.as_bytes())
}

/// Mean number of runnable threads over the last minute, in Linux.
fn load() -> Option<f64> {
    std::fs::read_to_string("/proc/loadavg").ok()?.split(' ').next()?.parse().ok()
}
