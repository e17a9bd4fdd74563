//! `sonoglyph levitate`: simulates a bead released in a scene's field, or carried along its motion.

use std::path::PathBuf;

use anyhow::bail;
use clap::Args;
use glam::DVec3;

use crate::cli::arguments::DriveArgs;
use crate::cli::scene::read_scene;
use crate::cli::{arguments, progress};
use crate::studio::flight::{self, Course};
use crate::studio::levitation;
use crate::studio::motion::{SOLVING, at_rest};
use crate::studio::output::{self, Files, say, warn};

/// Name of the step in progress reports.
const FLYING: &str = "the flight of the bead";
/// Default duration: s at rest, cycles of a motion.
const SECONDS: f64 = 1.0;
const CYCLES: f64 = 2.0;

#[derive(Debug, Args)]
pub struct LevitateArgs {
    /// Scene file
    scene: PathBuf,
    #[command(flatten)]
    drive: DriveArgs,
    /// Target number of the trap, counted from 1 [default: the first trap, or the first focus]
    #[arg(long, value_name = "N")]
    target: Option<usize>,
    /// Release position (m) [default: the equilibrium in the first frame]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = arguments::parse_place)]
    from: Option<DVec3>,
    /// Simulated time (s) [default: 1, or two cycles of a motion]
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = arguments::seconds(600.0))]
    seconds: Option<f64>,
    /// Also find the highest speed of the motion at which the bead stays
    #[arg(long)]
    fastest: bool,
    /// Output file: columns time (s), x, y, z (m), vx, vy, vz (m/s), and the trap's position
    #[arg(short, long, value_name = "FILE.csv")]
    output: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub fn run(args: &LevitateArgs) -> anyhow::Result<()> {
    let mut files = Files::new();
    let scene = read_scene(&args.scene, args.drive.source(), &mut files)?;
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
        bail!("{name}: --fastest: nothing moves ({})", at_rest(&scene));
    }
    levitation::warning(&scene).iter().for_each(|warning| warn(warning));
    let from = args.from.unwrap_or_else(|| course.start());
    let seconds = args.seconds.unwrap_or(if course.moves() { CYCLES * course.round() } else { SECONDS });
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
