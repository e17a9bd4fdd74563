//! Commands for boards: `ports`, `check`, `send`, `serve` and `board`.

#[cfg(unix)]
mod board;
mod check;
mod ports;
mod send;
pub mod serve;

use std::path::Path;
use std::path::PathBuf;

use anyhow::Context;
use clap::Args;

use crate::cli::arguments::seconds;
#[cfg(unix)]
pub use crate::cli::boards::board::run as board;
pub use crate::cli::boards::{check::run as check, ports::run as ports, send::run as send};
use crate::cli::names;
#[cfg(unix)]
use crate::device::board::faults::Faults;
use crate::device::calibration::Calibration;
use crate::device::profile::Profile;
use crate::scene::Method;

#[derive(Debug, Args)]
pub struct SendArgs {
    /// Scene file
    scene: PathBuf,
    /// Serial port of the board; `sonoglyph ports` lists them
    #[arg(long)]
    port: PathBuf,
    /// Kind of board; `sonoglyph ports` lists them
    #[arg(long, value_parser = parse_profile)]
    profile: Profile,
    /// Bits per second, instead of the board's default
    #[arg(long, value_parser = clap::value_parser!(u32).range(1200..=12_000_000))]
    baud: Option<u32>,
    /// Solver method, instead of the scene's
    #[arg(long, value_parser = names::method())]
    method: Option<Method>,
    /// Play until Ctrl-C
    #[arg(long = "loop")]
    repeat: bool,
    /// Playing time (s)
    #[arg(long, value_name = "S", value_parser = seconds(1e9))]
    seconds: Option<f64>,
    /// CSV with the columns element, offset (degrees), gain (0 to 1), off (0 or 1), and a row per element
    #[arg(long, value_name = "FILE.csv")]
    calibration: Option<PathBuf>,
    /// Play a single board of the scene, counted from 1, for boards with their own ports
    #[arg(long, value_name = "NUMBER")]
    board: Option<usize>,
}

#[derive(Debug, Args)]
pub struct CheckArgs {
    /// Serial port of the board; `sonoglyph ports` lists them
    #[arg(long)]
    port: PathBuf,
    /// Kind of board; `sonoglyph ports` lists them
    #[arg(long, value_parser = parse_profile, default_value = "native")]
    profile: Profile,
    /// Bits per second, instead of the fastest rate without loss
    #[arg(long, value_parser = clap::value_parser!(u32).range(1200..=12_000_000))]
    baud: Option<u32>,
    /// Ask after each element whether it is audible; answers are read from standard input
    #[arg(long)]
    listen: bool,
    /// Calibration: read if it exists, and written with the silent elements
    #[arg(long, value_name = "FILE.csv")]
    calibration: Option<PathBuf>,
    /// Also write the report
    #[arg(short, long, value_name = "REPORT.txt")]
    output: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub struct BoardArgs {
    /// Kind of board; `sonoglyph ports` lists them
    #[arg(long, value_parser = parse_profile, default_value = "native")]
    profile: Profile,
    /// Bits per second of the board, instead of its default
    #[arg(long, value_parser = clap::value_parser!(u32).range(1200..=12_000_000))]
    baud: Option<u32>,
    /// Run the gateware itself, simulated by Verilator, instead of the model
    #[arg(long)]
    rtl: bool,
    /// Folder of the gateware for --rtl [default: `gateware` beside the program or in the current folder]
    #[arg(long, value_name = "FOLDER", requires = "rtl")]
    gateware: Option<PathBuf>,
    /// Phase bits of the native device
    #[arg(long, default_value_t = 7, value_parser = clap::value_parser!(u8).range(5..=8))]
    phase_bits: u8,
    /// Injected faults: drop, flip, insert, burst (each =probability per byte), garbage, stall=S, unplug=S, press=S
    #[arg(long, value_name = "LIST", value_parser = parse_faults)]
    faults: Option<Faults>,
    /// Running time (s)
    #[arg(long, value_name = "S", value_parser = seconds(1e9))]
    seconds: Option<f64>,
    /// Write the last played field as PNG
    #[arg(short, long, value_name = "FIELD.png")]
    output: Option<PathBuf>,
    /// Scene with array and plane of the field
    #[arg(long)]
    scene: Option<PathBuf>,
}

fn parse_profile(name: &str) -> Result<Profile, String> {
    let names = || Profile::choices().map(Profile::name).collect::<Vec<_>>().join(", ");
    Profile::of_name(name).ok_or_else(|| format!("the boards are {}", names()))
}

#[cfg(unix)]
fn parse_faults(text: &str) -> Result<Faults, String> {
    Faults::parse(text)
}

/// Unused without virtual boards.
#[cfg(not(unix))]
type Faults = String;

#[cfg(not(unix))]
fn parse_faults(text: &str) -> Result<Faults, String> {
    Ok(text.to_owned())
}

/// The calibration of a board, by default without corrections.
fn calibration(path: Option<&Path>, profile: Profile) -> anyhow::Result<Calibration> {
    let Some(path) = path else { return Ok(Calibration::default()) };
    Calibration::read(path, profile.elements()).with_context(|| path.display().to_string())
}

#[cfg(not(unix))]
pub fn board(_: &BoardArgs) -> anyhow::Result<()> {
    anyhow::bail!("virtual boards need a Unix system")
}
