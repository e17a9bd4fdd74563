//! Arguments of the commands for boards.

use std::path::PathBuf;

use anyhow::{Context, bail};
use clap::Args;

use crate::cli::arguments::seconds;
#[cfg(unix)]
use crate::device::board::faults::Faults;
use crate::device::board::microphone::Microphone;
use crate::device::calibration::Calibration;
use crate::device::profile::Profile;
use crate::scene::Scene;

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
    /// Seed of a hidden truth: elements, air and pose of the scan that differ from their model
    #[arg(long, value_name = "SEED")]
    pub hidden: Option<u64>,
    /// Nominal positions of a microphone: CSV with the columns x, y, z (m)
    #[arg(long, value_name = "FILE.csv", requires_all = ["hidden", "readings"])]
    pub positions: Option<PathBuf>,
    /// Write what the microphone reads of each steady drive as CSV (Pa, peak)
    #[arg(long, value_name = "FILE.csv", requires = "positions")]
    pub readings: Option<PathBuf>,
    /// Microphone: snr=DB (default 40, or inf), width=M, position=M (RMS error), wall=M (height of a wall), complex
    #[arg(long, value_name = "LIST", value_parser = Microphone::parse, requires = "positions")]
    pub microphone: Option<Microphone>,
    /// Write the hidden truth as CSV, for comparison
    #[arg(long, value_name = "FILE.csv", requires = "hidden")]
    pub truth: Option<PathBuf>,
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

/// The calibration of a scene's elements, by default without corrections: a file for all, a file for each board, or a
/// file for the only `board` (from 1) that is played.
pub fn calibration(paths: &[PathBuf], scene: &Scene, board: Option<usize>) -> anyhow::Result<Calibration> {
    let read =
        |path: &PathBuf, scene| Calibration::read(path, scene).with_context(|| path.display().to_string());
    let (boards, each) = (scene.boards.len().max(1), scene.array.elements());
    let one = Scene { boards: Vec::new(), ..scene.clone() };
    match (paths, board) {
        ([], _) => Ok(Calibration::default()),
        ([path], None) => read(path, scene),
        ([path], Some(number)) => {
            let own = Some(read(path, &one)?);
            let of_boards = (1..=boards).map(|other| own.clone().filter(|_| other == number));
            Ok(Calibration::of_boards(of_boards, each))
        }
        (paths, None) if paths.len() == boards => {
            let of_boards = paths.iter().map(|path| read(path, &one).map(Some));
            Ok(Calibration::of_boards(of_boards.collect::<anyhow::Result<Vec<_>>>()?, each))
        }
        (paths, _) => bail!(
            "--calibration is given {} times: give one file for all elements, or one for each board of the scene, which has \
             {boards}",
            paths.len()
        ),
    }
}
