//! The guardian of an open port: a second process that silences the board when this one dies.
//!
//! A board without a watchdog plays its last frame for ever, and a killed or crashed program runs no more code. The
//! guardian is this program, started anew with the open port and a pipe that holds the bytes of silence. The pipe
//! ends with its owner, however that ends; then the guardian discards the port's queue, in which part of a frame may
//! be left, and writes the bytes, which silence the board in any state. A crashing process holds its pipe until the
//! system has written its memory to a file, which may take seconds; on Linux the guardian looks for this, too.
//!
//! An owner that closes its port ends the guardian first, so that the port is free at once. A process group of its
//! own and ignored signals keep it from ending with its owner.

use std::fs::{self, File};
use std::io::{self, PipeWriter, Write};
use std::os::fd::{AsFd, BorrowedFd, RawFd};
use std::os::unix::process::{CommandExt, parent_id};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::termios::{QueueSelector, tcdrain, tcflush, tcgetattr};
use signal_hook::consts::{SIGHUP, SIGINT, SIGQUIT, SIGTERM};

use crate::device::pace::BITS;

/// The argument of a guardian, followed by the milliseconds during which it may not yet write.
const ARGUMENT: &str = "--guard-the-port-at-standard-output";
/// Its name among the processes: not that of its owner, so that one is killed by name without the other.
const NAME: &str = "board-guardian";
/// Interval of looks at a crashing owner.
const LOOK: Duration = Duration::from_millis(40);
/// Limit of the wait for a port that takes no bytes.
const STALLED: Duration = Duration::from_secs(2);

/// Whether this program can be started as a guardian.
static IS_ABLE: AtomicBool = AtomicBool::new(false);

/// Lets open ports of this program have guardians, and does the work of one if this process was started as such.
/// Called first in `main`; ports of programs that do not call it have none.
pub fn guard() {
    let mut arguments = std::env::args_os().skip(1);
    if arguments.next().is_none_or(|first| first != ARGUMENT) {
        return IS_ABLE.store(true, Ordering::Relaxed);
    }
    let wait = arguments.next().and_then(|wait| wait.to_str()?.parse().ok()).map(Duration::from_millis);
    // There is nobody to tell of an error.
    let _ = keep_watch(wait.unwrap_or_default());
    std::process::exit(0);
}

/// A port's guardian. Dropping it ends it without silencing the board.
#[derive(Debug)]
pub(super) struct Guardian {
    process: Child,
    /// Its end is the sign for the guardian, so no other process may have it.
    _pipe: PipeWriter,
}

impl Guardian {
    /// A guardian that writes `last` to the port, but not before `wait` has passed; `None` if the program has no
    /// guardians.
    ///
    /// # Errors
    /// The process could not be started.
    pub(super) fn start(port: BorrowedFd<'_>, last: &[u8], wait: Duration) -> io::Result<Option<Self>> {
        if !IS_ABLE.load(Ordering::Relaxed) {
            return Ok(None);
        }
        let (reader, mut pipe) = io::pipe()?;
        // A pipe holds more than any board's silence.
        pipe.write_all(last)?;
        let process = Command::new(own_program()?)
            .arg0(NAME)
            .args([ARGUMENT, &wait.as_millis().to_string()])
            .stdin(reader)
            .stdout(port.try_clone_to_owned()?)
            .stderr(Stdio::null())
            .current_dir("/")
            .process_group(0)
            .spawn()?;
        Ok(Some(Self { process, _pipe: pipe }))
    }
}

impl Drop for Guardian {
    fn drop(&mut self) {
        // It may have been killed before. The wait takes a moment and leaves no trace of the process.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// This program, also after its file has been replaced.
fn own_program() -> io::Result<PathBuf> {
    if cfg!(target_os = "linux") { Ok("/proc/self/exe".into()) } else { std::env::current_exe() }
}

/// The guardian's work: waits for the end of its owner, and silences the board.
fn keep_watch(wait: Duration) -> io::Result<()> {
    let begun = Instant::now();
    for signal in [SIGHUP, SIGINT, SIGQUIT, SIGTERM] {
        signal_hook::flag::register(signal, Arc::default())?;
    }
    close_others();
    // Only Linux has this file.
    if let Ok(mut name) = File::options().write(true).open("/proc/self/comm") {
        name.write_all(NAME.as_bytes())?;
    }
    let last = wait_for_end()?;
    thread::sleep(wait.saturating_sub(begun.elapsed()));
    let port = io::stdout();
    tcflush(&port, QueueSelector::OFlush)?;
    write(port.as_fd(), &last)?;
    tcdrain(&port)?;
    // Some adapters discard what they hold when their port is closed.
    let baud = f64::from(tcgetattr(&port)?.output_speed().max(1));
    thread::sleep(Duration::from_secs_f64(last.len() as f64 * BITS / baud).min(STALLED));
    Ok(())
}

/// Closes what the owner's caller has left open in it, such as pipes whose end somebody awaits.
fn close_others() {
    let names = fs::read_dir("/dev/fd").into_iter().flatten().flatten();
    let others: Vec<RawFd> = names.filter_map(|entry| entry.file_name().to_str()?.parse().ok()).collect();
    for other in others.into_iter().filter(|&other| other > 2) {
        #[expect(unsafe_code, reason = "nothing in this process uses the descriptor")]
        unsafe {
            // The folder's own is closed already.
            if rustix::io::fcntl_getfd(BorrowedFd::borrow_raw(other)).is_ok() {
                rustix::io::close(other);
            }
        }
    }
}

/// The bytes of silence, once the owner has ended or crashed.
fn wait_for_end() -> io::Result<Vec<u8>> {
    let (input, look) = (io::stdin(), Timespec::try_from(LOOK).ok());
    let status = format!("/proc/{}/status", parent_id());
    let mut last = Vec::new();
    loop {
        let mut part = [0; 4096];
        let mut pipe = [PollFd::new(&input, PollFlags::IN)];
        match poll(&mut pipe, look.as_ref()) {
            Ok(0) if is_crashing(&status) => return Ok(last),
            Ok(0) | Err(rustix::io::Errno::INTR) => continue,
            Ok(_) => {}
            Err(error) => return Err(error.into()),
        }
        match rustix::io::read(&input, &mut part)? {
            0 => return Ok(last),
            count => last.extend(&part[..count]),
        }
    }
}

/// Whether the system is writing the memory of the process to a file, as Linux says.
fn is_crashing(status: &str) -> bool {
    fs::read_to_string(status).is_ok_and(|status| status.contains("\nCoreDumping:\t1"))
}

/// The port does not block, as its owner wanted.
fn write(port: BorrowedFd<'_>, mut bytes: &[u8]) -> io::Result<()> {
    let stalled = Timespec::try_from(STALLED).ok();
    while !bytes.is_empty() {
        match rustix::io::write(port, bytes) {
            Ok(count) => bytes = &bytes[count..],
            Err(rustix::io::Errno::AGAIN) => {
                if poll(&mut [PollFd::new(&port, PollFlags::OUT)], stalled.as_ref()) == Ok(0) {
                    return Err(io::ErrorKind::TimedOut.into());
                }
            }
            Err(rustix::io::Errno::INTR) => {}
            Err(error) => return Err(error.into()),
        }
    }
    Ok(())
}
