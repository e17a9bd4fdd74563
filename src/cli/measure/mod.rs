//! `sonoglyph measure`: plans a scan of a microphone, and identifies an array from its readings.

pub mod args;
mod fit;
mod plan;

use crate::cli::measure::args::MeasureArgs;

pub fn run(args: &MeasureArgs) -> anyhow::Result<()> {
    match &args.scan {
        Some(scan) => fit::run(args, scan),
        None => plan::run(args),
    }
}
