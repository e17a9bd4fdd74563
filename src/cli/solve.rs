//! `sonoglyph solve`: the drive of a scene and its quality, as a table, JSON or CSV.

use comfy_table::{CellAlignment, Table};
use serde_json::{Value, json};

use crate::acoustics::Aperture;
use crate::cli::{SolveArgs, output, parse_method, read_scene, warn};
use crate::drive::{Drive, delay_level};
use crate::picture::sheet::pascals;
use crate::scene::{Method, Scene};
use crate::solver::levels::{self, Reached};
use crate::solver::{self, Problem, Solution, SolveError};

/// Which methods to run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Methods {
    One(Method),
    All,
}

pub fn parse_methods(name: &str) -> Result<Methods, String> {
    if name == "all" {
        return Ok(Methods::All);
    }
    parse_method(name).map(Methods::One).map_err(|error| format!("{error}, all"))
}

pub fn run(args: &SolveArgs) -> anyhow::Result<()> {
    let one = match args.method {
        Some(Methods::One(method)) => Some(method),
        Some(Methods::All) | None => None,
    };
    let scene = read_scene(&args.scene, one)?;
    if let Some(path) = &args.csv {
        if args.method == Some(Methods::All) {
            anyhow::bail!("--csv writes one drive: name one method");
        }
        output::check_writable(path)?;
    }
    if args.method == Some(Methods::All) {
        if args.levels.is_some() {
            anyhow::bail!("--levels looks at one drive: name one method");
        }
        return compare(&scene, args.json);
    }
    let in_file = |error: SolveError| anyhow::anyhow!("{}: {error}", args.scene.display());
    let solution = solver::solve(&scene).map_err(in_file)?;
    report_warnings(&solution);
    let aperture = Aperture::new(&scene);
    let played = args.levels.map(|levels| Played::new(&aperture, &solution, levels));
    if let Some(path) = &args.csv {
        let drive = played.as_ref().map_or(&solution.drive, |played| &played.refined.0);
        output::write(path, csv(&aperture, drive).as_bytes())?;
    }
    if args.json {
        let mut value = json(&solution);
        if let Some(played) = &played {
            value["played"] = played.json();
        }
        println!("{}", serde_json::to_string_pretty(&value)?);
    } else {
        print(&solution);
        if let Some(played) = &played {
            played.print();
        }
    }
    Ok(())
}

/// What a board with few phase levels makes of a drive.
struct Played {
    levels: u32,
    ideal: Reached,
    rounded: Reached,
    refined: (Drive, Reached),
}

impl Played {
    fn new(aperture: &Aperture, solution: &Solution, levels: u32) -> Self {
        let problem = Problem::new(aperture, solution.foci.clone());
        let reached = |drive: &Drive| Reached::new(&problem, drive);
        let refined = levels::refined(&problem, &solution.drive, levels);
        Self {
            levels,
            ideal: reached(&solution.drive),
            rounded: reached(&solution.drive.at_levels(levels)),
            refined: (refined.clone(), reached(&refined)),
        }
    }

    fn print(&self) {
        println!(
            "\nOn {} phase levels (rounding leaves {} of the mean on the average):",
            self.levels,
            percent(levels::expected_part(self.levels))
        );
        for (name, reached) in [("rounded", self.rounded), ("refined", self.refined.1)] {
            println!(
                "{name:<20}mean {} ({}), weakest {} ({}), spread {}",
                pascals(reached.mean_pressure),
                percent(reached.mean_pressure / self.ideal.mean_pressure),
                pascals(reached.weakest),
                percent(reached.weakest / self.ideal.weakest),
                percent(reached.spread)
            );
        }
    }

    fn json(&self) -> Value {
        let reached = |reached: Reached| {
            json!({
                "mean_pressure": reached.mean_pressure,
                "min_pressure": reached.weakest,
                "spread": reached.spread,
            })
        };
        let delays: Vec<_> =
            self.refined.0.phases.iter().map(|&phase| delay_level(phase, self.levels)).collect();
        json!({
            "levels": self.levels,
            "expected_part": levels::expected_part(self.levels),
            "rounded": reached(self.rounded),
            "refined": reached(self.refined.1),
            "delays": delays,
        })
    }
}

fn compare(scene: &Scene, as_json: bool) -> anyhow::Result<()> {
    let mut solutions = Vec::new();
    for method in Method::ALL {
        let mut scene = scene.clone();
        // An iteration count is meant for the scene's own method.
        scene.solver.iterations = if scene.solver.method == method { scene.solver.iterations } else { 0 };
        scene.solver.method = method;
        match solver::solve(&scene) {
            Ok(solution) => solutions.push(solution),
            // A comparison leaves out what cannot be compared.
            Err(SolveError::SeveralFoci(_)) => {}
            Err(error) => return Err(error.into()),
        }
    }
    if let Some(solution) = solutions.first() {
        report_warnings(solution);
    }
    if as_json {
        let values: Vec<_> = solutions.iter().map(json).collect();
        println!("{}", serde_json::to_string_pretty(&values)?);
    } else {
        println!("{}", comparison(&solutions));
    }
    Ok(())
}

fn report_warnings(solution: &Solution) {
    for warning in &solution.warnings {
        warn(warning);
    }
}

fn comparison(solutions: &[Solution]) -> Table {
    let mut table = Table::new();
    table.set_header(["method", "mean", "weakest", "spread", "efficiency", "certified", "iterations", "ms"]);
    for solution in solutions {
        let quality = &solution.quality;
        table.add_row([
            solution.method.name().to_owned(),
            pascals(quality.mean_pressure),
            pascals(quality.min_pressure),
            percent(quality.spread),
            percent(quality.efficiency),
            percent(quality.certified),
            solution.iterations.to_string(),
            format!("{:.2}", solution.seconds * 1e3),
        ]);
    }
    align_numbers(&mut table);
    table
}

fn align_numbers(table: &mut Table) {
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
}

fn percent(part: f64) -> String {
    format!("{:.2} %", 100.0 * part)
}

fn print(solution: &Solution) {
    let quality = &solution.quality;
    let mut foci = Table::new();
    foci.set_header(["focus", "x / mm", "y / mm", "z / mm", "target", "pressure (peak)", "phase / rad"]);
    for (index, (focus, pressure)) in solution.foci.iter().zip(&solution.pressures).enumerate() {
        let millimetres = focus.position * 1e3;
        foci.add_row([
            (index + 1).to_string(),
            format!("{:.2}", millimetres.x),
            format!("{:.2}", millimetres.y),
            format!("{:.2}", millimetres.z),
            format!("{}", focus.target),
            pascals(pressure.norm()),
            format!("{:.3}", pressure.arg()),
        ]);
    }
    align_numbers(&mut foci);
    println!("{foci}");
    let driven = solution.drive.amplitudes.iter().filter(|&&amplitude| amplitude > 0.0).count();
    let rows = [
        (
            "method",
            format!(
                "{}, {} iterations, {:.2} ms",
                solution.method.name(),
                solution.iterations,
                solution.seconds * 1e3
            ),
        ),
        ("elements driven", format!("{driven} of {}", solution.drive.phases.len())),
        ("mean pressure", pascals(quality.mean_pressure)),
        ("weakest focus", pascals(quality.min_pressure)),
        ("spread", percent(quality.spread)),
        ("efficiency", percent(quality.efficiency)),
        ("relative to single", format!("{:.4}", quality.relative_to_single)),
        (
            "bound",
            format!(
                "{}: no drive brings every focus to more than this times its target",
                pascals(quality.bound)
            ),
        ),
        ("certified", format!("at least {} of the best any drive can do", percent(quality.certified))),
        ("residual", format!("{:.2e}", quality.residual)),
        (
            "rank, condition",
            format!("{} of {} foci, {:.2e}", quality.rank, solution.foci.len(), quality.condition),
        ),
    ];
    for (name, value) in rows {
        println!("{name:<20}{value}");
    }
}

/// The object that design and other programs know.
fn json(solution: &Solution) -> Value {
    let quality = &solution.quality;
    let foci: Vec<_> = solution
        .foci
        .iter()
        .zip(&solution.pressures)
        .map(|(focus, pressure)| {
            json!({
                "position": focus.position.to_array(),
                "target": focus.target,
                "pressure": pressure.norm(),
                "phase": pressure.arg(),
            })
        })
        .collect();
    json!({
        "method": solution.method.name(),
        "elements": solution.drive.phases.len(),
        "foci": foci,
        "quality": {
            "mean_pressure": quality.mean_pressure,
            "min_pressure": quality.min_pressure,
            "spread": quality.spread,
            "efficiency": quality.efficiency,
            "relative_to_single": quality.relative_to_single,
            "bound": quality.bound,
            "certified": quality.certified,
            "residual": quality.residual,
            "rank": quality.rank,
            "condition": quality.condition,
        },
        "seconds": solution.seconds,
        "iterations": solution.iterations,
        "phases": solution.drive.phases,
        "amplitudes": solution.drive.amplitudes,
    })
}

fn csv(aperture: &Aperture, drive: &Drive) -> String {
    let mut text = String::from("element,x,y,phase,amplitude\n");
    for (element, position) in aperture.positions.iter().enumerate() {
        let (phase, amplitude) = (drive.phases[element], drive.amplitudes[element]);
        text.push_str(&format!("{element},{:?},{:?},{phase:?},{amplitude:?}\n", position.x, position.y));
    }
    text
}
