//! `sonoglyph levitate`: a bead that is released in the sound of a scene, or carried along its motion.

use std::fmt::Write;
use std::path::PathBuf;

use anyhow::bail;
use clap::Args;
use glam::DVec3;
use serde_json::{Value, json};

use crate::cli::{arguments, progress, read_scene};
use crate::force::Flight;
use crate::scene::Scene;
use crate::studio::flight::Course;
use crate::studio::levitation;
use crate::studio::motion::SOLVING;
use crate::studio::output::{self, Files, say, warn};

/// What a flight is called while it goes on.
const FLYING: &str = "the flight of the bead";
/// s of a flight where nothing moves, and rounds where something does.
const SECONDS: f64 = 1.0;
const ROUNDS: f64 = 2.0;
/// Moments of a table, at most.
const MOST_MOMENTS: usize = 2_000_000;

#[derive(Debug, Args)]
pub struct LevitateArgs {
    /// Scene file
    scene: PathBuf,
    /// Number of the trap, from 1 on; by default the first, or the first focus
    #[arg(long, value_name = "N")]
    target: Option<usize>,
    /// Where the bead is released (m); by default where the first frame holds it
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = arguments::parse_place)]
    from: Option<DVec3>,
    /// s that it is followed; by default 1, or two rounds of a motion
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = arguments::parse_flight)]
    seconds: Option<f64>,
    /// Also find how fast the motion may be so that the bead is not lost
    #[arg(long)]
    fastest: bool,
    /// Where the flight goes: columns time (s), x, y, z (m), vx, vy, vz (m/s), and where the bead is wanted
    #[arg(short, long, value_name = "FILE.csv")]
    output: Option<PathBuf>,
    /// The answer as JSON
    #[arg(long)]
    json: bool,
}

pub fn run(args: &LevitateArgs) -> anyhow::Result<()> {
    let mut files = Files::new();
    let scene = read_scene(&args.scene, None, &mut files)?;
    if let Some(path) = &args.output {
        files.writes(path)?;
    }
    let name = args.scene.display().to_string();
    let target = match args.target {
        Some(number) if number == 0 || number > scene.targets.len() => {
            bail!("{name}: --target {number}: the scene has {} targets", scene.targets.len())
        }
        number => number.map(|number| number - 1),
    };
    let course = Course::new(&scene, &name, target, &progress::begin(SOLVING))?;
    if args.fastest && !course.moves() {
        bail!("{name}: --fastest: nothing moves (`path` in [motion] is \"none\")");
    }
    levitation::warning(&scene).iter().for_each(|warning| warn(warning));
    let from = args.from.unwrap_or_else(|| course.start());
    let seconds = args.seconds.unwrap_or(if course.moves() { ROUNDS * course.round() } else { SECONDS });
    let flight = course.fly(from, seconds, 1.0, &progress::begin(FLYING));
    let fastest = args.fastest.then(|| course.fastest());
    if let Some(path) = &args.output {
        output::write(path, table(&flight).as_bytes())?;
    }
    if args.json {
        return say!("{:#}", answer(&flight, from, fastest));
    }
    say!("{}", words(&scene, &flight, from))?;
    if let Some(fastest) = fastest {
        let round = course.round().recip();
        say!("{:<14}  {}", "motion", limit(fastest, round))?;
    }
    Ok(())
}

fn words(scene: &Scene, flight: &Flight, from: DVec3) -> String {
    let mm = |place: DVec3| {
        let [x, y, z] = place.to_array().map(|length| format!("{:.2}", length * 1e3));
        format!("({x}, {y}, {z}) mm")
    };
    let bead = &scene.bead;
    let mut text = format!("{:<14}  {}, radius {:.3} mm\n", "bead", bead.material.title(), bead.radius * 1e3);
    let _ = writeln!(text, "{:<14}  {}, at rest", "released", mm(from));
    let Some(last) = flight.moments.last() else { return text };
    let end = if flight.is_lost {
        format!("lost after {:.4} s at {}", last.time, mm(last.at))
    } else {
        format!(
            "stays: after {:.4} s at {}, never more than {:.2} mm from its place",
            last.time,
            mm(last.at),
            flight.farthest * 1e3
        )
    };
    let _ = write!(text, "{:<14}  {end}", "flight");
    text
}

fn limit(fastest: Option<[f64; 2]>, round: f64) -> String {
    match fastest {
        None => "the bead is lost at any speed that was tried".to_owned(),
        Some([stays, lost]) if lost.is_infinite() => {
            format!("the bead stays at {stays:.0} times the speed: {:.1} rounds per second", stays * round)
        }
        Some([stays, lost]) => format!(
            "the bead stays up to {stays:.3} times the speed ({:.3} rounds per second), and is lost at {lost:.3}",
            stays * round
        ),
    }
}

fn answer(flight: &Flight, from: DVec3, fastest: Option<Option<[f64; 2]>>) -> Value {
    let last = flight.moments.last();
    let mut value = json!({
        "released": from.to_array(),
        "stays": !flight.is_lost,
        "seconds": last.map(|last| last.time),
        "at": last.map(|last| last.at.to_array()),
        "farthest": flight.farthest,
    });
    if let Some(fastest) = fastest {
        let finite = |value: f64| value.is_finite().then_some(value);
        value["fastest"] = json!({
            "stays": fastest.map(|[stays, _]| stays),
            "lost": fastest.and_then(|[_, lost]| finite(lost)),
        });
    }
    value
}

/// Every moment, or as many of them as fit.
fn table(flight: &Flight) -> String {
    let mut text = "time,x,y,z,vx,vy,vz,wanted_x,wanted_y,wanted_z\n".to_owned();
    let apart = flight.moments.len().div_ceil(MOST_MOMENTS).max(1);
    for moment in flight.moments.iter().step_by(apart) {
        let _ = write!(text, "{}", moment.time);
        for value in [moment.at, moment.velocity, moment.wanted].iter().flat_map(|vector| vector.to_array()) {
            let _ = write!(text, ",{value}");
        }
        text.push('\n');
    }
    text
}
