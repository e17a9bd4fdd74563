//! `sonoglyph ports`: lists serial ports and supported boards.

use comfy_table::Table;

use crate::device::declaration::Strength;
use crate::device::port;
use crate::device::profile::Profile;
use crate::device::task::finish;
use crate::studio::output::say;

pub fn run() -> anyhow::Result<()> {
    let ports = finish(port::available())?;
    if ports.is_empty() {
        say!(
            "There is no serial port. A board's appears when it is plugged in; `sonoglyph board` emulates a board."
        )?;
    }
    for port in ports {
        say!("{port}")?;
    }
    let mut table = Table::new();
    table.set_header(["--profile", "elements", "phases", "amplitudes", "at most"]);
    for profile in Profile::ALL {
        let amplitudes = match profile.strength() {
            Strength::Fixed => "on or off".to_owned(),
            Strength::Linear(full) | Strength::Duty(full) => full.to_string(),
        };
        table.add_row([
            profile.name().to_owned(),
            profile.elements().to_string(),
            profile.levels().to_string(),
            amplitudes,
            profile.bandwidth(profile.baud()),
        ]);
    }
    say!("{table}")?;
    let natives: Vec<_> = Profile::choices().skip(Profile::ALL.len()).map(Profile::name).collect();
    say!("{}: as many native boards on one line, synchronised", natives.join(", "))?;
    for profile in Profile::ALL {
        if let Some(remark) = profile.remark() {
            say!("{}: {remark}", profile.name())?;
        }
    }
    Ok(())
}
