//! Boards on the command line: `ports`, `check`, `send`, `serve` and `board`, and what a program without serial links says instead.

#[cfg(all(unix, feature = "serial"))]
mod board;
#[cfg(feature = "serial")]
mod check;
#[cfg(feature = "serial")]
mod ports;
#[cfg(feature = "serial")]
mod send;
pub mod serve;

#[cfg(feature = "serial")]
use std::path::Path;
use std::path::PathBuf;

#[cfg(feature = "serial")]
use anyhow::Context;
use clap::Args;

use crate::cli::arguments::seconds;
#[cfg(all(unix, feature = "serial"))]
pub use crate::cli::boards::board::run as board;
#[cfg(feature = "serial")]
pub use crate::cli::boards::{check::run as check, ports::run as ports, send::run as send};
#[cfg(not(feature = "serial"))]
pub use crate::cli::boards::{without_ports as check, without_ports as send};
#[cfg(all(unix, feature = "serial"))]
use crate::device::board::faults::Faults;
#[cfg(feature = "serial")]
use crate::device::calibration::Calibration;
use crate::device::profile::Profile;
use crate::scene::Method;

#[derive(Debug, Args)]
pub struct SendArgs {
    /// Scene file
    scene: PathBuf,
    /// Serial port that the board is at; `sonoglyph ports` lists them
    #[arg(long)]
    port: PathBuf,
    /// Kind of board; `sonoglyph ports` lists them
    #[arg(long, value_parser = parse_profile)]
    profile: Profile,
    /// Bits per second, instead of the board's default
    #[arg(long, value_parser = clap::value_parser!(u32).range(1200..=12_000_000))]
    baud: Option<u32>,
    /// Solver method, instead of the scene's
    #[arg(long, value_enum)]
    method: Option<Method>,
    /// Go on until Ctrl-C
    #[arg(long = "loop")]
    repeat: bool,
    /// Go on for so long
    #[arg(long, value_name = "S", value_parser = seconds(1e9))]
    seconds: Option<f64>,
    /// CSV with the columns element, offset (degrees), gain (0 to 1), off (0 or 1), a row for every element
    #[arg(long, value_name = "FILE.csv")]
    calibration: Option<PathBuf>,
    /// Play one of the scene's boards alone, counted from 1: of boards that have a port each
    #[arg(long, value_name = "NUMBER")]
    board: Option<usize>,
}

#[derive(Debug, Args)]
pub struct CheckArgs {
    /// Serial port that the board is at; `sonoglyph ports` lists them
    #[arg(long)]
    port: PathBuf,
    /// Kind of board; `sonoglyph ports` lists them
    #[arg(long, value_parser = parse_profile, default_value = "native")]
    profile: Profile,
    /// Bits per second to play at, instead of the fastest without loss
    #[arg(long, value_parser = clap::value_parser!(u32).range(1200..=12_000_000))]
    baud: Option<u32>,
    /// Ask, element by element, what is heard or seen; answers come from standard input
    #[arg(long)]
    listen: bool,
    /// Calibration to begin with, if there is one, and to write silent elements into
    #[arg(long, value_name = "FILE.csv")]
    calibration: Option<PathBuf>,
    /// Write the report, too
    #[arg(short, long, value_name = "REPORT.txt")]
    output: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub struct BoardArgs {
    /// Kind of board; `sonoglyph ports` lists them
    #[arg(long, value_parser = parse_profile, default_value = "native")]
    profile: Profile,
    /// Bits per second that the board listens at, instead of its default
    #[arg(long, value_parser = clap::value_parser!(u32).range(1200..=12_000_000))]
    baud: Option<u32>,
    /// Run the gateware itself in a simulation by Verilator, instead of the model
    #[arg(long)]
    rtl: bool,
    /// Folder of the gateware that --rtl runs; else `gateware` beside the program, then in the current folder
    #[arg(long, value_name = "FOLDER", requires = "rtl")]
    gateware: Option<PathBuf>,
    /// Phase bits of the native device
    #[arg(long, default_value_t = 7, value_parser = clap::value_parser!(u8).range(5..=8))]
    phase_bits: u8,
    /// What goes wrong: drop, flip, insert, burst (each =probability per byte), garbage, stall=S, unplug=S, press=S
    #[arg(long, value_name = "LIST", value_parser = parse_faults)]
    faults: Option<Faults>,
    /// End after so long
    #[arg(long, value_name = "S", value_parser = seconds(1e9))]
    seconds: Option<f64>,
    /// Write the field that was played last as PNG
    #[arg(short, long, value_name = "FIELD.png")]
    output: Option<PathBuf>,
    /// Scene whose array and plane the field is shown for
    #[arg(long)]
    scene: Option<PathBuf>,
}

fn parse_profile(name: &str) -> Result<Profile, String> {
    let names = || Profile::choices().map(Profile::name).collect::<Vec<_>>().join(", ");
    Profile::of_name(name).ok_or_else(|| format!("the boards are {}", names()))
}

#[cfg(all(unix, feature = "serial"))]
fn parse_faults(text: &str) -> Result<Faults, String> {
    Faults::parse(text)
}

/// Faults where no board could have them.
#[cfg(not(all(unix, feature = "serial")))]
type Faults = String;

#[cfg(not(all(unix, feature = "serial")))]
fn parse_faults(text: &str) -> Result<Faults, String> {
    Ok(text.to_owned())
}

/// What is known of a board's elements.
#[cfg(feature = "serial")]
fn calibration(path: Option<&Path>, profile: Profile) -> anyhow::Result<Calibration> {
    let Some(path) = path else { return Ok(Calibration::default()) };
    Calibration::read(path, profile.elements()).with_context(|| path.display().to_string())
}

#[cfg(not(feature = "serial"))]
pub fn ports() -> anyhow::Result<()> {
    anyhow::bail!("this program was built without serial links; `cargo build --features serial` has them")
}

/// What is done with a port where there are none.
#[cfg(not(feature = "serial"))]
pub fn without_ports<T>(_: &T) -> anyhow::Result<()> {
    ports()
}

#[cfg(not(all(unix, feature = "serial")))]
pub fn board(_: &BoardArgs) -> anyhow::Result<()> {
    anyhow::bail!(
        "virtual boards need a Unix system and a program built with serial links (feature `serial`)"
    )
}
