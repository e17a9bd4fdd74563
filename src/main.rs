//! The program `sonoglyph`: runs the command line, then the window if requested, and sets the exit status.

use std::path::Path;
use std::process::ExitCode;

use sonoglyph::cli::{BadArguments, Next};
use sonoglyph::studio::evaluator::{self, Renderer};
use sonoglyph::studio::output::mention;

/// Called by the loader before Rust opens /dev/null for a closed standard output.
#[cfg(target_os = "linux")]
#[used]
#[expect(unsafe_code, reason = "the function does not need Rust's runtime")]
#[unsafe(link_section = ".init_array")]
static BEFORE_MAIN: extern "C" fn() = look_at_standard;

#[cfg(target_os = "linux")]
extern "C" fn look_at_standard() {
    sonoglyph::studio::output::look_at_standard();
}

fn main() -> ExitCode {
    #[cfg(unix)]
    sonoglyph::device::port::guard();
    #[cfg(all(feature = "window", target_os = "linux", target_env = "gnu"))]
    fault::end_when_sent();
    evaluator::quiet_drivers();
    match sonoglyph::cli::run().and_then(go_on) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) if error.is::<BadArguments>() => ExitCode::from(2),
        Err(error) if is_closed_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            mention(&format!("error: {error:#}"));
            ExitCode::from(2)
        }
    }
}

/// SIGSEGV from another process. Rust's handler, which reports overflows of the stack, waits for the fault to recur
/// and so ignores the first signal without one: a program that is sent one would go on, and its board sound.
#[cfg(all(feature = "window", target_os = "linux", target_env = "gnu"))]
#[expect(unsafe_code, reason = "a handler that calls only what a handler may, and the handler before it")]
mod fault {
    use std::mem::{transmute, zeroed};
    use std::ptr::{null, null_mut};
    use std::sync::OnceLock;

    use libc::{SIG_DFL, SIGSEGV, c_int, c_void, raise, sigaction, siginfo_t, signal};

    type Handler = extern "C" fn(c_int, *mut siginfo_t, *mut c_void);
    static BEFORE: OnceLock<sigaction> = OnceLock::new();

    pub fn end_when_sent() {
        unsafe {
            let mut action: sigaction = zeroed();
            if sigaction(SIGSEGV, null(), &mut action) == 0 && action.sa_sigaction > 1 {
                BEFORE.get_or_init(|| action);
                action.sa_sigaction = handle as Handler as usize;
                sigaction(SIGSEGV, &action, null_mut());
            }
        }
    }

    extern "C" fn handle(number: c_int, info: *mut siginfo_t, context: *mut c_void) {
        unsafe {
            // Positive codes are the system's own.
            match BEFORE.get() {
                Some(before) if (*info).si_code > 0 => {
                    transmute::<usize, Handler>(before.sa_sigaction)(number, info, context);
                }
                _ => {
                    signal(number, SIG_DFL);
                    raise(number);
                }
            }
        }
    }
}

/// Whether the reader of a pipe has closed it, as in `sonoglyph … | head`.
fn is_closed_pipe(error: &anyhow::Error) -> bool {
    /// A Windows error for a closed pipe that Rust does not map to `BrokenPipe`.
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

/// Without the feature `window`: writes the sheet, as without a display.
#[cfg(not(feature = "window"))]
fn open(scene: Option<&Path>, _: Renderer) -> anyhow::Result<()> {
    sonoglyph::studio::still::default_sheet(scene)
}

/// Returns freed memory to the system. By default glibc gives each thread a heap and raises the threshold for
/// separate mappings to the largest buffer freed so far, up to 32 MiB; smaller buffers then fragment all heaps.
#[cfg(feature = "window")]
fn return_freed_memory() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        use libc::{M_ARENA_MAX, M_MMAP_THRESHOLD, M_TRIM_THRESHOLD, mallopt};

        /// Bytes. The pixels of a typical map stay below, so that a drag maps no new pages in every frame.
        const LARGE: i32 = 2 << 20;
        #[expect(unsafe_code, reason = "mallopt sets allocator parameters under its own lock")]
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
        #[expect(unsafe_code, reason = "the system writes at most the two announced numbers")]
        unsafe {
            if GetConsoleProcessList(programs.as_mut_ptr(), 2) == 1 {
                FreeConsole();
            }
        }
    }
}
