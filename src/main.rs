//! The program `sonoglyph`.

use std::process::ExitCode;

fn main() -> ExitCode {
    quiet_drivers();
    match sonoglyph::cli::run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::from(2)
        }
    }
}

/// Without a desktop session, Mesa's device-selection layer complains on stderr about a Wayland that nobody asked for.
#[expect(unsafe_code, reason = "no other thread runs yet")]
fn quiet_drivers() {
    if std::env::var_os("XDG_RUNTIME_DIR").is_none() {
        unsafe { std::env::set_var("NODEVICE_SELECT", "1") };
    }
}
