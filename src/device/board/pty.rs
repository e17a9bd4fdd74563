//! A pseudo-terminal with the board at one end and a serial port at the other.

use std::fs;
use std::io;
use std::os::fd::OwnedFd;
use std::path::{Path, PathBuf};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{Mode, OFlags, fcntl_setfl, open};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, ioctl_tiocnxcl, tcgetattr, tcsetattr};
use web_time::Duration;

/// The board's end. A link in the temporary folder leads to the other end, and stays the same when the board is
/// unplugged and comes back.
#[derive(Debug)]
pub struct Pty {
    master: OwnedFd,
    /// Keeps the other end open between programs that open and close it.
    slave: OwnedFd,
    link: PathBuf,
    /// Events of programs that open the other end.
    #[cfg(target_os = "linux")]
    openings: Option<OwnedFd>,
}

impl Pty {
    /// # Errors
    /// No pseudo-terminal available.
    pub fn open(link: &Path, baud: u32) -> io::Result<Self> {
        let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC)?;
        grantpt(&master)?;
        unlockpt(&master)?;
        let name = ptsname(&master, Vec::new())?;
        let slave = open(&name, OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC, Mode::empty())?;
        let mut settings = tcgetattr(&slave)?;
        settings.make_raw();
        settings.set_speed(baud)?;
        tcsetattr(&slave, OptionalActions::Now, &settings)?;
        fcntl_setfl(&master, OFlags::RDWR | OFlags::NONBLOCK)?;
        let target = name.to_string_lossy();
        match fs::remove_file(link) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
            _ => std::os::unix::fs::symlink(&*target, link)?,
        }
        Ok(Self {
            master,
            slave,
            link: link.to_owned(),
            #[cfg(target_os = "linux")]
            openings: watch_openings(&target),
        })
    }

    /// Whether a program has opened the other end since the last call. Only Linux tells.
    pub fn was_opened(&self) -> bool {
        #[cfg(target_os = "linux")]
        return self.openings.as_ref().is_some_and(|openings| {
            rustix::io::read(openings, &mut [0; 4096]).is_ok_and(|events| events > 0)
        });
        #[cfg(not(target_os = "linux"))]
        false
    }

    /// The bit rate that the other end has set.
    pub fn baud(&self) -> u32 {
        tcgetattr(&self.master).map_or(0, |settings| settings.output_speed())
    }

    /// Lifts the exclusive claim on the port, as a real port does when its owner is killed. The lock on it still
    /// protects a port in use.
    pub fn lift_claim(&self) {
        // A vanished terminal has no claim.
        let _ = ioctl_tiocnxcl(&self.slave);
    }

    /// Waits until there is something to read, for `timeout` at most.
    pub fn wait(&self, timeout: Duration) {
        let timeout = Timespec::try_from(timeout).ok();
        // An early end of the wait by a signal is harmless.
        let _ = poll(&mut [PollFd::new(&self.master, PollFlags::IN)], timeout.as_ref());
    }

    /// Up to `bytes.len()` bytes, without waiting.
    pub fn read(&self, bytes: &mut [u8]) -> usize {
        rustix::io::read(&self.master, bytes).unwrap_or(0)
    }

    /// Excess bytes are lost, as on a line without a receiver.
    pub fn write(&self, bytes: &[u8]) {
        let _ = rustix::io::write(&self.master, bytes);
    }
}

#[cfg(target_os = "linux")]
fn watch_openings(port: &str) -> Option<OwnedFd> {
    use rustix::fs::inotify::{CreateFlags, WatchFlags, add_watch, init};
    let openings = init(CreateFlags::NONBLOCK | CreateFlags::CLOEXEC).ok()?;
    add_watch(&openings, port, WatchFlags::OPEN).ok()?;
    Some(openings)
}

impl Drop for Pty {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.link);
    }
}

#[cfg(test)]
mod tests {
    use std::io::{Read, Write};

    use super::*;

    #[test]
    fn all_bytes_pass_as_they_are_in_both_directions() {
        let link = std::env::temp_dir().join(format!("pty-of-a-test-{}", std::process::id()));
        let pty = Pty::open(&link, 230_400).unwrap();
        let port = open(&link, OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC, Mode::empty()).unwrap();
        let mut port = fs::File::from(port);
        let bytes: Vec<u8> = (0..=255).collect();
        port.write_all(&bytes).unwrap();
        let (mut read, mut part) = (Vec::<u8>::new(), [0; 256]);
        while read.len() < bytes.len() {
            pty.wait(Duration::from_secs(10));
            let count = pty.read(&mut part);
            assert!(count > 0, "{} bytes came", read.len());
            read.extend(&part[..count]);
        }
        assert_eq!(read, bytes);
        pty.write(&bytes);
        port.read_exact(&mut part).unwrap();
        assert_eq!(part[..], bytes);
        drop(pty);
        assert!(!link.exists());
    }
}
