//! Arguments of `sonoglyph measure`.

use std::path::PathBuf;

use clap::Args;

use crate::cli::arguments::{above_zero, between, parse_place, seconds};
use crate::cli::boards::arguments::parse_profile;
use crate::device::profile::Profile;

/// Pa m and m of a scan's lengths, at most.
const LONGEST: f64 = 10.0;

#[derive(Debug, Args)]
#[command(group(clap::ArgGroup::new("task").required(true).args(["plan", "scan"])))]
pub struct MeasureArgs {
    /// Scene with array and air
    pub scene: PathBuf,
    /// Plan a scan: drive.csv, positions.csv, path.gcode, scan.csv to fill in, and expected.csv in the folder of -o
    #[arg(long, requires = "output")]
    pub plan: bool,
    /// Readings: CSV with x, y, z (m) and re and im (Pa, peak), amplitude (Pa, peak), amplitude and phase (rad), rms (Pa) or
    /// level (dB re 20 uPa); optionally drive, from 0
    #[arg(long, value_name = "SCAN.csv")]
    pub scan: Option<PathBuf>,
    /// Drives of the scan: CSV as of `solve --csv`, several by a column drive or frame
    ///
    /// Without it, a scan takes drive.csv in its own folder, or else the scene's drive; a plan makes random ones.
    #[arg(long, value_name = "DRIVE.csv")]
    pub drive: Option<PathBuf>,
    /// Folder of the plan, or calibration to write: columns element, offset (degrees), gain, off
    #[arg(short, long, value_name = "PATH")]
    pub output: Option<PathBuf>,
    /// Signal-to-noise of the readings (dB): root mean square of the readings over that of their noise
    ///
    /// For a plan, what it will be [default: 30]; for a scan, to tell noise from errors of the model, if no place was read
    /// more than once.
    #[arg(long, value_name = "DB", value_parser = between([0.0, 140.0], "dB"))]
    pub snr: Option<f64>,
    #[command(flatten)]
    pub plan_args: PlanArgs,
    #[command(flatten)]
    pub fit: FitArgs,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Plan")]
pub struct PlanArgs {
    /// Heights of the planes (m), 30 mm or more apart to tell speed of sound and height [default: one, 0.6 widths of the array]
    #[arg(long, value_name = "Z,Z", value_delimiter = ',', value_parser = above_zero(LONGEST, "m"), requires = "plan", conflicts_with = "at")]
    pub heights: Vec<f64>,
    /// Sides of the planes (m) [default: those of the array]
    #[arg(long, value_name = "W,H", value_delimiter = ',', num_args = 1..=2, value_parser = above_zero(LONGEST, "m"), requires = "plan", conflicts_with = "at")]
    pub size: Vec<f64>,
    /// Distance between neighbouring places (m) [default: half a wavelength]
    #[arg(long, value_name = "M", value_parser = above_zero(LONGEST, "m"), requires = "plan", conflicts_with = "at")]
    pub step: Option<f64>,
    /// Number of random drives, each played for a whole scan [default: 1, or as many as one place needs]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=10_000), requires = "plan", conflicts_with = "drive")]
    pub drives: Option<u16>,
    /// Seed of the random drives
    #[arg(long, default_value_t = 1, requires = "plan")]
    pub seed: u64,
    /// Microphone that does not move (m): many drives in place of many positions
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_place, allow_hyphen_values = true, requires = "plan")]
    pub at: Option<glam::DVec3>,
    /// Elements one at a time, for a phase detector beside a microphone that does not move
    #[arg(long, requires = "at", conflicts_with_all = ["drive", "drives"])]
    pub single: bool,
    /// Readings with phases: a lock-in amplifier or a phase detector
    #[arg(long, requires = "plan")]
    pub phases: bool,
    /// Rest of the plotter at every place (s)
    #[arg(long, value_name = "S", default_value_t = 0.8, value_parser = seconds(3600.0), requires = "plan")]
    pub dwell: f64,
    /// Serial port of the board that plays the drives while the scan runs
    #[arg(long, value_name = "PORT", requires_all = ["plan", "profile"])]
    pub port: Option<PathBuf>,
    /// Kind of board; `sonoglyph ports` lists them
    #[arg(long, value_parser = parse_profile)]
    pub profile: Option<Profile>,
    /// Bits per second, instead of the board's default
    #[arg(long, value_parser = clap::value_parser!(u32).range(1200..=12_000_000), requires = "port")]
    pub baud: Option<u32>,
    /// Playing time of each drive (s) [default: until Ctrl-C; of several, the time of a scan]
    #[arg(long, value_name = "S", value_parser = seconds(1e6), requires = "port")]
    pub seconds: Option<f64>,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Fit")]
pub struct FitArgs {
    /// Print gains, phases, bench and residual as JSON
    #[arg(long, requires = "scan")]
    pub json: bool,
    /// Gains in the calibration, too: louder elements are weakened. By default, phases alone, which win pressure
    #[arg(long, requires = "output", conflicts_with = "plan")]
    pub gains: bool,
    /// Fitted parameters of the bench, instead of those of which the readings speak: x, y, z, tilt_x, tilt_y, sound_speed,
    /// radius, microphone_width, or none
    #[arg(long, value_name = "LIST", value_delimiter = ',', requires = "scan")]
    pub free: Option<Vec<String>>,
    /// Diameter of the microphone's membrane (m), if it is known
    #[arg(long, value_name = "M", value_parser = between([0.0, 0.02], "m"), requires = "scan")]
    pub width: Option<f64>,
    /// Measured, model and difference side by side: PNG, SVG or PDF, by the ending
    #[arg(long, value_name = "FILE", requires = "scan")]
    pub figure: Option<PathBuf>,
    /// All that was found, with the figure: HTML or PDF, by the ending
    #[arg(long, value_name = "FILE", requires = "scan")]
    pub report: Option<PathBuf>,
}
