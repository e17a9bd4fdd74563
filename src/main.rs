//! The program `sonoglyph`: starts the command line, the window or the measurements.

use std::path::Path;
use std::process::ExitCode;

use sonoglyph::cli::{BadArguments, Next};
use sonoglyph::studio::evaluator::Renderer;
use sonoglyph::studio::output::mention;

/// Called by the loader before Rust opens /dev/null for a closed standard output.
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

/// Whether the reader of a pipe has closed it, as in `sonoglyph … | head`.
fn nobody_reads(error: &anyhow::Error) -> bool {
    /// The second Windows error for this, unknown to Rust.
    const PIPE_NOT_CONNECTED: i32 = 233;
    let cause = error.root_cause().downcast_ref::<std::io::Error>();
    cause.is_some_and(|cause| {
        cause.kind() == std::io::ErrorKind::BrokenPipe
            || (cfg!(windows) && cause.raw_os_error() == Some(PIPE_NOT_CONNECTED))
    })
}

fn go_on(next: Next) -> anyhow::Result<()> {
    match next {
        Next::Exit => Ok(()),
        Next::Window(scene, renderer) => open(scene.as_deref(), renderer),
    }
}

#[cfg(feature = "window")]
fn open(scene: Option<&Path>, renderer: Renderer) -> anyhow::Result<()> {
    return_freed_memory();
    close_own_console();
    sonoglyph::app::run(scene, renderer)
}

/// Without the window feature, writes the sheet as without a display.
#[cfg(not(feature = "window"))]
fn open(scene: Option<&Path>, _: Renderer) -> anyhow::Result<()> {
    sonoglyph::studio::still::default_sheet(scene)
}

/// Silences Mesa's device-selection layer, which complains on stderr about a missing Wayland without a desktop
/// session.
#[expect(unsafe_code, reason = "no other thread runs yet")]
fn quiet_drivers() {
    if std::env::var_os("XDG_RUNTIME_DIR").is_none() {
        unsafe { std::env::set_var("NODEVICE_SELECT", "1") };
    }
}

/// Returns freed memory to the system. By default glibc gives each thread a heap and raises the threshold for
/// separate mappings to the largest buffer freed so far, up to 32 MiB; smaller buffers then fragment all heaps.
#[cfg(feature = "window")]
fn return_freed_memory() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        use libc::{M_ARENA_MAX, M_MMAP_THRESHOLD, M_TRIM_THRESHOLD, mallopt};

        /// Bytes: the pixels of a usual map stay below and cost no new pages in every frame of a drag.
        const LARGE: i32 = 2 << 20;
        #[expect(unsafe_code, reason = "numbers of the allocator, which it sets under a lock of its own")]
        unsafe {
            mallopt(M_ARENA_MAX, 1);
            mallopt(M_MMAP_THRESHOLD, LARGE);
            mallopt(M_TRIM_THRESHOLD, 2 * LARGE);
        }
    }
}

/// Closes the console that Windows opens for a program started from the desktop, unless other programs use it.
#[cfg(feature = "window")]
fn close_own_console() {
    #[cfg(windows)]
    {
        use windows_sys::Win32::System::Console::{FreeConsole, GetConsoleProcessList};

        let mut programs = [0; 2];
        #[expect(unsafe_code, reason = "the system fills no more than the two numbers that it is told of")]
        unsafe {
            if GetConsoleProcessList(programs.as_mut_ptr(), 2) == 1 {
                FreeConsole();
            }
        }
    }
}
