//! `sonoglyph bench`: time against error, measured beside a baseline in the same run.

mod average;
mod field;
#[cfg(all(unix, feature = "serial"))]
mod link;
mod solve;
mod stability;

use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::Context;
use cpu_time::ProcessTime;
use serde_json::json;

use crate::cli::output::say;
use crate::cli::{BenchArgs, Subject, output};
use crate::picture::chart::Chart;
use crate::picture::export;
use crate::simd::Isa;

/// What one measurement takes: as many runs as fit, at least one and at most [`MOST_RUNS`].
const BUDGET: Duration = Duration::from_millis(150);
const MOST_RUNS: usize = 15;

pub fn run(args: &BenchArgs) -> anyhow::Result<()> {
    if let Some(path) = &args.json {
        output::check_writable(path)?;
    }
    if let Some(folder) = &args.plots {
        std::fs::create_dir_all(folder)
            .with_context(|| format!("{}: cannot make the folder", folder.display()))?;
    }
    let mut value = json!({ "machine": machine(), "version": env!("CARGO_PKG_VERSION") });
    let mut show = |name: &str, report: Report| {
        say!("{}", report.table)?;
        for line in &report.notes {
            say!("{line}")?;
        }
        value[name] = report.records.into();
        match &args.plots {
            Some(folder) => write_charts(folder, &report.charts),
            None => Ok(()),
        }
    };
    let is_wanted = |subject| [Subject::All, subject].contains(&args.subject);
    if is_wanted(Subject::Field) {
        show("field", field::run(args.quick)?)?;
        show("average", average::run(args.quick)?)?;
    }
    if is_wanted(Subject::Solve) {
        show("solve", solve::run(args.quick)?)?;
    }
    if is_wanted(Subject::Stability) {
        show("stability", stability::run(args.quick)?)?;
    }
    #[cfg(all(unix, feature = "serial"))]
    if args.subject == Subject::Link {
        show("link", link::run(args.quick)?)?;
    }
    #[cfg(not(all(unix, feature = "serial")))]
    if args.subject == Subject::Link {
        anyhow::bail!("links are measured on a Unix system, by a program built with serial links");
    }
    if let Some(path) = &args.json {
        output::write(path, serde_json::to_string_pretty(&value)?.as_bytes())?;
    }
    Ok(())
}

/// What a benchmark found.
struct Report {
    table: comfy_table::Table,
    notes: Vec<String>,
    records: Vec<serde_json::Value>,
    /// File names without extension, and the charts.
    charts: Vec<(String, Chart)>,
}

fn write_charts(folder: &Path, charts: &[(String, Chart)]) -> anyhow::Result<()> {
    for (name, chart) in charts {
        let path = folder.join(name).with_extension("png");
        output::write(&path, &export::png(&chart.draw()?)?)?;
        say!("{}", path.display())?;
    }
    Ok(())
}

fn machine() -> serde_json::Value {
    json!({
        "threads": rayon::current_num_threads(),
        "instructions": Isa::best().name(),
        "architecture": std::env::consts::ARCH,
        "system": std::env::consts::OS,
    })
}

/// Time of a piece of work: medians over its runs, s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Spent {
    /// Of all threads of the process.
    cpu: f64,
    wall: f64,
}

impl Spent {
    /// Runs `work` with the number of the run, as often as the budget allows.
    fn on<E>(mut work: impl FnMut(usize) -> Result<(), E>) -> Result<Self, E> {
        let (mut cpu, mut wall) = (Vec::new(), Vec::new());
        let start = Instant::now();
        while cpu.is_empty() || (start.elapsed() < BUDGET && cpu.len() < MOST_RUNS) {
            let (cpu_start, wall_start) = (ProcessTime::now(), Instant::now());
            work(cpu.len())?;
            wall.push(wall_start.elapsed().as_secs_f64());
            cpu.push(cpu_start.elapsed().as_secs_f64());
        }
        Ok(Self { cpu: median(cpu), wall: median(wall) })
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
