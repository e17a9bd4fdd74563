//! The program `sonoglyph`.

use std::path::Path;
use std::process::ExitCode;

use sonoglyph::cli::{BadArguments, Next};
use sonoglyph::studio::evaluator::Renderer;
use sonoglyph::studio::output::mention;

/// The loader calls this before Rust puts /dev/null where the caller closed standard output.
#[cfg(target_os = "linux")]
#[used]
#[expect(unsafe_code, reason = "what is called there needs nothing of Rust's runtime")]
#[unsafe(link_section = ".init_array")]
static BEFORE_MAIN: extern "C" fn() = look_at_standard;

#[cfg(target_os = "linux")]
extern "C" fn look_at_standard() {
    sonoglyph::studio::output::look_at_standard();
}

fn main() -> ExitCode {
    quiet_drivers();
    match sonoglyph::cli::run().and_then(go_on) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) if error.is::<BadArguments>() => ExitCode::from(2),
        Err(error) if nobody_reads(&error) => ExitCode::SUCCESS,
        Err(error) => {
            mention(&format!("error: {error:#}"));
            ExitCode::from(2)
        }
    }
}

/// `sonoglyph … | head` wants no more than it took.
fn nobody_reads(error: &anyhow::Error) -> bool {
    let cause = error.root_cause().downcast_ref::<std::io::Error>();
    cause.is_some_and(|cause| cause.kind() == std::io::ErrorKind::BrokenPipe)
}

fn go_on(next: Next) -> anyhow::Result<()> {
    match next {
        Next::Exit => Ok(()),
        Next::Window(scene, renderer) => open(scene.as_deref(), renderer),
        Next::Bench(options) => sonoglyph::bench::run(&options),
    }
}

#[cfg(feature = "window")]
fn open(scene: Option<&Path>, renderer: Renderer) -> anyhow::Result<()> {
    sonoglyph::app::run(scene, renderer)
}

/// A program without its window writes the sheet that it writes where there is no display.
#[cfg(not(feature = "window"))]
fn open(scene: Option<&Path>, _: Renderer) -> anyhow::Result<()> {
    sonoglyph::studio::still::default_sheet(scene)
}

/// Without a desktop session, Mesa's device-selection layer complains on stderr about a Wayland that was not asked for.
#[expect(unsafe_code, reason = "no other thread runs yet")]
fn quiet_drivers() {
    if std::env::var_os("XDG_RUNTIME_DIR").is_none() {
        unsafe { std::env::set_var("NODEVICE_SELECT", "1") };
    }
}
