//! `sonoglyph solve`: the drive of a scene and its quality, as a table, JSON or CSV.

use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use comfy_table::{CellAlignment, Table};
use glam::DVec3;
use strum::VariantArray;

use crate::acoustics::Aperture;
use crate::cli::arguments::{self, DriveArgs};
use crate::cli::names;
use crate::cli::scene::{COLUMN, Source, read_scene};
use crate::drive::Drive;
use crate::echo;
use crate::field::harmonic::NoHarmonic;
use crate::field::{Evaluator, NoSideLobe, SideLobe, Stages};
use crate::rounding::{
    millimetres, milliseconds, pascals, pascals_at_most, percent, percent_at_least, percent_at_most,
};
use crate::scene::{
    Amplitudes, Focus, Listener, Method, Pressures, Scene, Turns, UNCERTAINTY, check, motion,
};
use crate::solver::levels;
use crate::solver::{self, Limits, Problem, Solution, SolveError, room};
use crate::studio::felt;
use crate::studio::findings::{Findings, Played};
use crate::studio::levitation::{self, Held};
use crate::studio::nonlinear::Nonlinear;
use crate::studio::output::{self, Files, note, say, warn};
use crate::studio::response::Moving;
use crate::studio::spread;
use crate::studio::stimulus;

/// Replaces the figures that compare pressures if the foci are silent, in these rows.
const SILENT: &str = "no sound reaches the foci";
const UNIFORMITY: &str = "uniformity (std/mean)";
const COMPARED: [&str; 7] =
    [UNIFORMITY, "relative to single", "residual", "evenness", "strength", "contrast", "error"];

#[derive(Debug, Args)]
pub struct SolveArgs {
    /// Scene file
    pub scene: PathBuf,
    /// Solver method, instead of the scene's
    #[arg(long, value_parser = methods(), conflicts_with = "drive")]
    pub method: Option<Methods>,
    #[command(flatten)]
    pub drive: DriveArgs,
    /// Print JSON; an array of objects for `--method all`
    #[arg(long)]
    pub json: bool,
    /// Write the drive: element, x, y (m), phase (rad), amplitude
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Quality on a board with L phase levels per period, rounded and refined; --csv writes the refined drive
    #[arg(long, value_name = "L", value_parser = clap::value_parser!(u32).range(2..=65536))]
    pub levels: Option<u32>,
    /// Solve every frame of the scene's motion, each starting from the previous one
    ///
    /// --csv then writes a row per frame: frame, time (s), and phase_0, phase_1, ... (rad), `nan` for elements that are
    /// off. --json prints one object whose `frames` hold time, foci, pressures (Pa, peak) and phases.
    #[arg(long, conflicts_with_all = ["levels", "drive"])]
    pub motion: bool,
    /// Play the drawing in many ways, and list what is felt most: kind, level over threshold by channel, and keys of the scene
    #[arg(long, conflicts_with_all = ["method", "drive", "levels", "motion", "csv"])]
    pub felt: bool,
    /// Duration of the further search (s), instead of the scene's
    #[arg(long, value_name = "S", conflicts_with_all = ["motion", "drive"], allow_negative_numbers = true, value_parser = arguments::parse_search)]
    pub search: Option<f64>,
    /// Exposure at a listener's position (m), instead of the scene's
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = arguments::parse_listener)]
    pub listener: Option<Listener>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Methods {
    One(Method),
    All,
}

pub fn methods() -> impl TypedValueParser<Value = Methods> {
    let all = PossibleValue::new("all").help("Every method, side by side");
    PossibleValuesParser::new(names::of_methods().chain([all]))
        .map(|name| name.parse().map_or(Methods::All, Methods::One))
}

pub fn run(args: &SolveArgs) -> anyhow::Result<()> {
    let one = match args.method {
        Some(Methods::One(method)) => Some(method),
        Some(Methods::All) | None => None,
    };
    let mut files = Files::new();
    let source = Source { method: one, drive: args.drive.drive.as_deref() };
    let mut scene = read_scene(&args.scene, source, &mut files)?;
    if let Some(listener) = &args.listener {
        check::listener(listener, &scene.front())
            .map_err(|error| anyhow::anyhow!("--listener {}", error.message))?;
        scene.listener = args.listener.clone();
    }
    scene.solver.search = args.search.unwrap_or(scene.solver.search);
    if let Some(path) = &args.csv {
        if args.method == Some(Methods::All) {
            anyhow::bail!("--csv writes one drive: name one method");
        }
        files.writes(path)?;
    }
    let in_file = |error: SolveError| anyhow::anyhow!("{}: {error}", args.scene.display());
    if args.method == Some(Methods::All) {
        if args.levels.is_some() {
            anyhow::bail!("--levels takes one drive: name one method");
        }
        return compare(&scene, args.json, &in_file);
    }
    if args.felt {
        return rank(&scene, args);
    }
    if args.levels.is_some() {
        match scene.solver.frames {
            Turns::Auto => scene.solver.frames = Turns::Count(1),
            Turns::Count(1) => {}
            Turns::Count(count) => {
                anyhow::bail!("--levels takes one drive, and this scene has {count} (`frames` in [solver])");
            }
        }
    }
    let solution = solver::solve(&scene).map_err(in_file)?;
    if scene.drive.is_named() && motion::moves(&scene) {
        note("these figures are of the targets at rest, and of the mean of all frames");
    }
    if args.levels.is_some() && !solution.others.is_empty() {
        anyhow::bail!("--levels takes one drive, and `{}` has several", scene.drive.name);
    }
    let aperture = Aperture::new(&scene);
    let mut stages = Stages::new(Evaluator::Cpu);
    let findings = Findings::of_scene(&scene, &mut stages, solution).map_err(in_file)?;
    findings.warnings.iter().for_each(|warning| warn(warning));
    let played = args.levels.map(|levels| {
        let problem = Problem::of_scene(&scene, &aperture, findings.solution.foci.clone());
        Played::new(&problem, &findings.solution, levels)
    });
    if let Some(path) = &args.csv {
        let drives = match &played {
            Some(played) => vec![played.refined.0.clone()],
            None => findings.solution.drives(),
        };
        output::write(path, Drive::write_in_turn(&drives, &aperture).as_bytes())?;
    }
    if args.json {
        let mut value = findings.json(&aperture);
        if let Some(played) = &played {
            value["played"] = played.json();
        }
        say!("{}", serde_json::to_string_pretty(&value)?)?;
    } else {
        print(&findings, &scene)?;
        print_ranges(&findings, &scene)?;
        for Held { target, hold } in &findings.traps {
            say!("{:<COLUMN$}{}", format!("trap, target {}", target + 1), levitation::verdict(hold))?;
        }
        for (index, body) in findings.bodies.iter().enumerate() {
            let name = format!("body {}, {}", index + 1, <&str>::from(body.kind));
            say!("{name:<COLUMN$}{}", body.words())?;
        }
        if let Some(neighbour) = &findings.neighbour {
            say!("{:<COLUMN$}{}", "between beads", levitation::between(neighbour))?;
        }
        if let Some(played) = &played {
            print_played(played, scene.solver.pressures, findings.solution.quality.is_silent())?;
        }
    }
    Ok(())
}

/// Prints the ways of playing a drawing, the one that is felt most first.
fn rank(scene: &Scene, args: &SolveArgs) -> anyhow::Result<()> {
    let name = args.scene.display();
    if scene.drive.is_named() || !felt::is_for_a_hand(scene) {
        anyhow::bail!(
            "{name}: --felt takes a drawing for a hand, without a liquid, traps or a drive of its own"
        );
    }
    let ways = stimulus::ranked(scene).map_err(|error| anyhow::anyhow!("{name}: {error}"))?;
    if args.json {
        let ways: Vec<_> = ways.iter().map(stimulus::Stimulus::json).collect();
        return say!("{}", serde_json::to_string_pretty(&ways)?);
    }
    let mut table = Table::new();
    table.set_header([
        "felt / dB",
        "pressure",
        "flutter",
        "vibration",
        "drawing felt",
        "kept",
        "kind",
        "keys of the scene",
    ]);
    for way in &ways {
        let felt = &way.felt;
        let mut row: Vec<_> = [felt.level, felt.pressure, felt.flutter, felt.vibration].map(level).to_vec();
        row.extend([felt.share, way.kept].map(|part| part.map_or("-".to_owned(), percent)));
        row.extend([<&str>::from(way.kind).to_owned(), way.keys()]);
        table.add_row(row);
    }
    for column in table.column_iter_mut().take(6) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    let [absolute, differences] = UNCERTAINTY;
    say!("{table}")?;
    say!("levels over threshold are worth ± {absolute} dB, differences ± {differences} dB")
}

/// A level (dB over threshold).
fn level(level: f64) -> String {
    if level > felt::FLOOR { format!("{level:.1}") } else { "-".to_owned() }
}

/// Prints the quality on a board with few phase levels.
fn print_played(played: &Played, pressures: Pressures, is_silent: bool) -> anyhow::Result<()> {
    say!(
        "\nOn {} phase levels (rounding leaves {} of the mean on average):",
        played.levels,
        percent(levels::expected_part(played.levels))
    )?;
    if is_silent {
        return say!("{SILENT}");
    }
    let of_target = |part: f64| match pressures {
        Pressures::Relative => pascals(part),
        Pressures::Pascal => format!("{} of its target", percent(part)),
    };
    for (name, reached) in [("rounded", played.rounded), ("refined", played.refined.1)] {
        say!(
            "{name:<COLUMN$}mean {} ({}), weakest {} ({}), std/mean {}",
            pascals(reached.mean_pressure),
            percent(reached.mean_pressure / played.ideal.mean_pressure),
            of_target(reached.weakest),
            percent(reached.weakest / played.ideal.weakest),
            percent(reached.spread)
        )?;
    }
    Ok(())
}

fn compare(
    scene: &Scene,
    as_json: bool,
    in_file: &dyn Fn(SolveError) -> anyhow::Error,
) -> anyhow::Result<()> {
    let mut solutions = Vec::new();
    for &method in Method::VARIANTS {
        let mut scene = scene.clone();
        // The scene's iteration count applies to its own method.
        scene.solver.iterations = if scene.solver.method == method { scene.solver.iterations } else { 0 };
        scene.solve_by(method);
        match solver::solve(&scene) {
            Ok(solution) => solutions.push(solution),
            // `focus` solves single foci only.
            Err(SolveError::SeveralFoci(_)) => {}
            Err(error) => return Err(in_file(error)),
        }
    }
    let aperture = Aperture::new(scene);
    let Some(first) = solutions.first() else { return Ok(()) };
    // Limits and stages of the map depend on foci and array alone: all methods share them.
    let _room = room::of_limits(scene, first.foci.len()).map_err(in_file)?;
    let problem = Problem::new(&aperture, first.foci.clone());
    let (limits, mut stages) = (Limits::new(&problem), Stages::new(Evaluator::Cpu));
    let findings: Vec<_> = solutions
        .into_iter()
        .map(|solution| Findings::new(scene, &problem, limits, &mut stages, solution))
        .collect();
    report_warnings(&findings);
    if as_json {
        let values: Vec<_> = findings.iter().map(|one| one.json(&aperture)).collect();
        say!("{}", serde_json::to_string_pretty(&values)?)
    } else {
        say!("{}", comparison(&findings))
    }
}

/// Prints every warning once, with the names of its methods unless it concerns all.
fn report_warnings(findings: &[Findings]) {
    let mut said = Vec::new();
    for warning in findings.iter().flat_map(|one| &one.warnings) {
        if said.contains(&warning) {
            continue;
        }
        said.push(warning);
        let concerned: Vec<_> = findings
            .iter()
            .filter(|other| other.warnings.contains(warning))
            .map(|other| other.solution.method_name())
            .collect();
        if concerned.len() == findings.len() {
            warn(warning);
        } else {
            warn(&format!("{}: {warning}", concerned.join(", ")));
        }
    }
}

fn comparison(findings: &[Findings]) -> Table {
    let mut table = Table::new();
    let mut header = vec![
        "method",
        "mean",
        "weakest",
        "std/mean",
        "efficiency",
        "of the bound",
        "side lobe",
        "iterations",
        "ms",
    ];
    header.extend(findings.iter().any(|one| one.heard.is_some()).then_some("listener"));
    table.set_header(header);
    for Findings { solution, limits, side_lobe, heard, .. } in findings {
        let quality = &solution.quality;
        let mut row = vec![
            solution.method_name().to_owned(),
            pascals(quality.mean_pressure),
            pascals(quality.min_pressure),
            if quality.is_silent() { "-".to_owned() } else { percent(quality.spread) },
            percent(quality.efficiency),
            percent_at_least(solution.certified(limits.bound), 2),
            side_lobe.as_ref().map_or("-".to_owned(), |lobe| percent(lobe.part)),
            solution.iterations.to_string(),
            format!("{:.2}", solution.seconds * 1e3),
        ];
        row.extend(heard.map(|heard| format!("{:.1} dB", heard.spl())));
        table.add_row(row);
    }
    align_numbers(&mut table);
    table
}

fn align_numbers(table: &mut Table) {
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
}

/// The method, or the file of the drive.
fn source_row(scene: &Scene, solution: &Solution) -> (&'static str, String) {
    match solution.method {
        Some(method) => {
            let (iterations, time) = (solution.iterations, milliseconds(solution.seconds, 2));
            ("method", format!("{}, {iterations} iterations, {time}", method.into_str()))
        }
        None => {
            let turns = match solution.others.len() {
                0 => String::new(),
                others => format!("{} drives whose mean counts, ", others + 1),
            };
            ("drive", format!("{}, {turns}nothing is solved", echo::value(&scene.drive.name)))
        }
    }
}

/// Number and amplitudes of the driven elements.
fn drive_row(scene: &Scene, solution: &Solution) -> String {
    let driven = solution.drive.amplitudes.iter().filter(|&&amplitude| amplitude > 0.0).count();
    let part = percent(solution.turned_down);
    if solution.method.is_none() {
        let amplitudes = solution.drive.amplitudes.iter().copied().filter(|&amplitude| amplitude > 0.0);
        let [least, most] =
            [amplitudes.clone().fold(1.0, f64::min), amplitudes.fold(0.0, f64::max)].map(percent);
        let how = if least == most { format!("at {most}") } else { format!("at {least} to {most}") };
        let how = if driven > 0 { format!(", {how} of full drive") } else { String::new() };
        return format!("{driven} of {}{how}", solution.drive.phases.len());
    }
    let how = match (scene.solver.amplitudes, scene.solver.pressures) {
        (Amplitudes::Uniform, Pressures::Relative) => String::new(),
        (Amplitudes::Uniform, Pressures::Pascal) => format!(", each at {part} of full drive"),
        (Amplitudes::Free, _) => format!(", with free amplitudes, the largest {part} of full drive"),
    };
    format!("{driven} of {}{how}", solution.drive.phases.len())
}

fn coordinates(point: DVec3) -> [String; 3] {
    point.to_array().map(|coordinate| millimetres(coordinate, 2))
}

fn print(findings: &Findings, scene: &Scene) -> anyhow::Result<()> {
    let Findings { solution, limits, .. } = findings;
    let quality = &solution.quality;
    if solution.foci.iter().any(|focus| focus.is_separate()) {
        say!("{}", foci_table(scene, solution))?;
    }
    let no_more = match scene.solver.pressures {
        Pressures::Relative => {
            format!(
                "{}: no drive brings every focus to more than this times its target",
                pascals_at_most(limits.bound)
            )
        }
        Pressures::Pascal => {
            format!("{}: no drive brings every focus to more of its target", percent_at_most(limits.bound, 2))
        }
    };
    let at_full = if solution.turned_down < 1.0 { ", at full drive" } else { "" };
    let mut rows = vec![
        source_row(scene, solution),
        ("elements driven", drive_row(scene, solution)),
        ("mean pressure", pascals(quality.mean_pressure)),
        ("weakest focus", pascals(quality.min_pressure)),
        (UNIFORMITY, percent(quality.spread)),
        ("efficiency", percent(quality.efficiency)),
        ("relative to single", format!("{:.4}", quality.relative_to_single)),
        ("upper bound", no_more),
        (
            "fraction of the bound",
            format!(
                "at least {}, guaranteed{at_full}",
                percent_at_least(solution.certified(limits.bound), 2)
            ),
        ),
        ("peak side lobe", side_lobe_row(&findings.side_lobe)),
        ("residual", format!("{:.2e}", quality.residual)),
        (
            "rank, condition",
            format!("{} of {} foci, {:.2e}", limits.rank, solution.foci.len(), limits.condition),
        ),
    ];
    if let Some(figures) = &solution.figures {
        let figures = [
            (
                "evenness",
                format!("{}, weakest over mean; {:.1} dB", percent(figures.evenness), figures.ripple_db),
            ),
            ("strength", format!("{} of the strongest drive's mean", percent(figures.strength))),
        ];
        rows.splice(5..5, figures);
    }
    if let Some(areas) = solution.figures.as_ref().and_then(|figures| figures.areas) {
        let what = if scene.aims_at_depression() { "the depression" } else { "|p|²" };
        let contrast = format!("{:.1}, mean of {what} inside over mean around", areas.contrast);
        let error = format!("{} squared deviation of {what} from the drawing", percent(areas.error));
        rows.splice(5..5, [("contrast", contrast), ("error", error)]);
    }
    let of = |is_one: &dyn Fn(&Focus) -> bool| solution.foci.iter().filter(|focus| is_one(focus)).count();
    let areas = of(&Focus::is_of_area);
    let strokes = of(&|focus| !focus.is_separate()) - areas;
    for (name, samples) in [("areas", areas), ("continuous strokes", strokes)] {
        if samples > 0 {
            rows.insert(1, (name, format!("{samples} samples")));
        }
    }
    if let Some(heard) = &findings.heard {
        let [x, y, z] = coordinates(heard.position);
        rows.push((
            "listener",
            format!("{:.1} dB re 20 µPa ({} RMS) at ({x}, {y}, {z}) mm", heard.spl(), pascals(heard.rms())),
        ));
    }
    rows.extend(findings.moving.iter().flat_map(Moving::rows));
    rows.extend(felt::rows(findings.felt.as_ref()));
    rows.extend(nonlinear_rows(&findings.nonlinear));
    if let Some(demodulated) = &findings.demodulated {
        let words = demodulated.words();
        rows.push(("heard at 1 m", format!("{words}; far field on the beam's axis (Berktay), ± 6 dB")));
    }
    for (name, value) in rows {
        let is_void = quality.is_silent() && COMPARED.contains(&name);
        let value = if is_void { format!("-, {SILENT}") } else { value };
        say!("{name:<COLUMN$}{value}")?;
    }
    Ok(())
}

/// Where linear theory ends.
fn nonlinear_rows(found: &Result<Nonlinear, NoHarmonic>) -> Vec<(&'static str, String)> {
    let found = match found {
        Ok(found) => found,
        Err(NoHarmonic::Silent) => return Vec::new(),
        Err(why) => return vec![("second harmonic", format!("-, {why}"))],
    };
    let [x, y, z] = coordinates(found.position);
    let linear = match found.linear_drive {
        part if part < 1.0 => format!("a tenth at {} of full drive", percent_at_most(part, 0)),
        _ => "at most a tenth at full drive".to_owned(),
    };
    let mut rows = vec![
        (
            "second harmonic",
            format!("{} of the pressure at ({x}, {y}, {z}) mm; {linear}", percent(found.harmonic)),
        ),
        ("streaming", format!("at most {:.2} m/s along the beam", found.streaming)),
    ];
    if let Some(audible) = found.audible {
        rows.push((
            "audible",
            format!(
                "{:.0} dB(A) at the listener, mostly at {:.0} Hz ({:.0} dB re 20 µPa), from the modulated beam, ± 6 dB",
                audible.weighted_level(),
                audible.frequency,
                audible.level()
            ),
        ));
    }
    rows
}

/// Prints 5, 50 and 95 % of the figures of elements that differ.
fn print_ranges(findings: &Findings, scene: &Scene) -> anyhow::Result<()> {
    let Some(ranges) = &findings.ranges else { return Ok(()) };
    say!("\nOf {} (5, 50, 95 %):", spread::title(scene.array.spread))?;
    let more = [("calibration would win", spread::won(ranges)), ("faults", spread::faults(scene))];
    for (name, value) in spread::rows(ranges, pascals).into_iter().chain(more) {
        say!("{name:<COLUMN$}{value}")?;
    }
    Ok(())
}

fn side_lobe_row(found: &Result<SideLobe, NoSideLobe>) -> String {
    match found {
        Ok(lobe) => {
            let [x, y, z] = coordinates(lobe.position);
            // A drive of a file may leave its targets silent.
            let times = match lobe.part {
                part if part < 10.0 => format!("{} of", percent(part)),
                part => format!("{part:.0} times"),
            };
            format!(
                "{times} the mean, the loudest outside the main lobes: {} at ({x}, {y}, {z}) mm",
                pascals(lobe.pressure)
            )
        }
        Err(why) => format!("-, {why}"),
    }
}

fn foci_table(scene: &Scene, solution: &Solution) -> Table {
    let mut foci = Table::new();
    let target = match scene.solver.pressures {
        Pressures::Relative => "target",
        Pressures::Pascal => "target / Pa",
    };
    foci.set_header(["focus", "x / mm", "y / mm", "z / mm", target, "pressure (peak)", "phase / rad"]);
    let separate = solution.foci.iter().zip(&solution.pressures).filter(|(focus, _)| focus.is_separate());
    for (index, (focus, pressure)) in separate.enumerate() {
        // A direction is a place at infinity, with its pressure at 1 m.
        let far = |part: f64| format!("∞ × {part:.3}");
        let ([x, y, z], distance) = match focus.is_direction() {
            true => (focus.position.to_array().map(far), " at 1 m"),
            false => (coordinates(focus.position), ""),
        };
        foci.add_row([
            (index + 1).to_string(),
            x,
            y,
            z,
            format!("{}", focus.target),
            format!("{}{distance}", pascals(pressure.norm())),
            format!("{:.3}", pressure.arg()),
        ]);
    }
    align_numbers(&mut foci);
    foci
}
