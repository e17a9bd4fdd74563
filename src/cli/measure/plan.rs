//! `sonoglyph measure --plan`: the drives and places of a scan.

use crate::cli::measure::MeasureArgs;

pub fn run(_: &MeasureArgs) -> anyhow::Result<()> {
    anyhow::bail!("not yet")
}
