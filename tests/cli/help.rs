//! What the help shows.

use crate::folder_with;
use crate::process::succeed;

#[test]
fn help_names_every_quantity_and_who_draws_the_window() {
    let folder = folder_with(&[]);
    let render = succeed(folder.path(), &["render", "--help"]);
    for quantity in
        ["rms", "phase", "radiation", "depression", "instantaneous", "intensity", "velocity", "caustic"]
    {
        assert!(render.contains(&format!("- {quantity}:")), "{quantity}: {render}");
    }
    let all = succeed(folder.path(), &["--help"]);
    assert!(["--renderer", "wgpu", "glow"].iter().all(|word| all.contains(word)), "{all}");
}

#[test]
fn help_shows_every_command_with_an_example() {
    let folder = folder_with(&[]);
    let help = succeed(folder.path(), &["--help"]);
    for command in [
        "render", "solve", "probe", "batch", "devices", "bench", "ports", "send", "serve", "board",
        "elements",
    ] {
        assert!(help.contains(command), "{help}");
        let own = succeed(folder.path(), &[command, "--help"]);
        assert!(
            ["devices", "ports"].contains(&command) || own.contains(&format!("sonoglyph {command} ")),
            "{own}"
        );
    }
}
