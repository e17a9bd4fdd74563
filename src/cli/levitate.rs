//! `sonoglyph levitate`: a bead that is released in the sound of a scene, or carried along its motion.

use std::path::PathBuf;

use anyhow::bail;
use clap::Args;
use glam::DVec3;

use crate::cli::{arguments, progress, read_scene};
use crate::studio::flight::{self, Course};
use crate::studio::levitation;
use crate::studio::motion::SOLVING;
use crate::studio::output::{self, Files, say, warn};

/// What a flight is called while it goes on.
const FLYING: &str = "the flight of the bead";
/// s of a flight where nothing moves, and rounds where something does.
const SECONDS: f64 = 1.0;
const ROUNDS: f64 = 2.0;

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
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = arguments::seconds(600.0))]
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
        output::write(path, flight::table(&flight).as_bytes())?;
    }
    if args.json {
        return say!("{:#}", flight::answer(&flight, from, fastest));
    }
    say!("{}", flight::words(&scene, &flight, from))?;
    if let Some(fastest) = fastest {
        let round = course.round().recip();
        say!("{:<14}  {}", "motion", flight::limit(fastest, round))?;
    }
    Ok(())
}
