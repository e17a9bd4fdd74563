//! Arguments of the commands for boards.

use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::Args;

use crate::cli::arguments::seconds;
#[cfg(unix)]
use crate::device::board::faults::Faults;
use crate::device::calibration::Calibration;
use crate::device::profile::Profile;

#[derive(Debug, Args)]
pub struct BoardArgs {
    /// Kind of board; `sonoglyph ports` lists them
    #[arg(long, value_parser = parse_profile, default_value = "native")]
    pub profile: Profile,
    /// Bits per second of the board, instead of its default
    #[arg(long, value_parser = clap::value_parser!(u32).range(1200..=12_000_000))]
    pub baud: Option<u32>,
    /// Run the gateware itself, simulated by Verilator, instead of the model
    #[arg(long)]
    pub rtl: bool,
    /// Folder of the gateware for --rtl [default: `gateware` beside the program or in the current folder]
    #[arg(long, value_name = "FOLDER", requires = "rtl")]
    pub gateware: Option<PathBuf>,
    /// Phase bits of the native device
    #[arg(long, default_value_t = 7, value_parser = clap::value_parser!(u8).range(5..=8))]
    pub phase_bits: u8,
    /// Injected faults: drop, flip, insert, burst (each =probability per byte), garbage, stall=S, unplug=S, press=S
    #[arg(long, value_name = "LIST", value_parser = parse_faults)]
    pub faults: Option<Faults>,
    /// Running time (s)
    #[arg(long, value_name = "S", value_parser = seconds(1e9))]
    pub seconds: Option<f64>,
    /// Write the last played field as PNG
    #[arg(short, long, value_name = "FIELD.png")]
    pub output: Option<PathBuf>,
    /// Scene with array and plane of the field
    #[arg(long)]
    pub scene: Option<PathBuf>,
}

/// The board of this name.
pub fn parse_profile(name: &str) -> Result<Profile, String> {
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
pub fn calibration(path: Option<&Path>, profile: Profile) -> anyhow::Result<Calibration> {
    let Some(path) = path else { return Ok(Calibration::default()) };
    Calibration::read(path, profile.elements()).with_context(|| path.display().to_string())
}
