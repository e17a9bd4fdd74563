//! Serial ports: enumeration and open ports. `system` has the computer's ports, `page` those of a browser page; a
//! virtual board in memory is a port, too.
//!
//! Operations are `async` for the page's sake: on a computer they block.

mod error;
#[cfg(unix)]
mod guardian;
#[cfg(not(target_arch = "wasm32"))]
mod system;
#[cfg(not(target_arch = "wasm32"))]
use crate::device::port::system as here;

#[cfg(target_arch = "wasm32")]
mod page;
#[cfg(target_arch = "wasm32")]
use crate::device::port::page as here;

use std::io;
use std::path::{Path, PathBuf};

use web_time::{Duration, Instant};

use crate::device::board::memory::VirtualBoard;
use crate::device::pace::Pace;
use crate::device::profile::Profile;
use crate::device::task;

pub use crate::device::port::error::{LISTED, Listed, PortError};
#[cfg(unix)]
#[doc(hidden)]
pub use crate::device::port::guardian::guard;
#[cfg(target_arch = "wasm32")]
pub use crate::device::port::page::{available, choose, is_there};
#[cfg(not(target_arch = "wasm32"))]
pub use crate::device::port::system::available;

/// Ports of this name and a profile's are virtual boards in this program.
const VIRTUAL: &str = "virtual:";

/// The port of a virtual board in this program, which lives as long as the open port.
pub fn virtual_board(profile: Profile) -> PathBuf {
    format!("{VIRTUAL}{}", profile.name()).into()
}

fn as_virtual_board(path: &Path) -> Option<Profile> {
    Profile::of_name(path.to_str()?.strip_prefix(VIRTUAL)?)
}

/// An open port, with its pacing.
#[derive(Debug)]
pub struct Port {
    line: Line,
    name: String,
    baud: u32,
    pace: Pace,
}

#[derive(Debug)]
enum Line {
    Wire(here::Wire),
    Virtual(Box<VirtualBoard>),
}

impl Port {
    /// 8 data bits, no parity, one stop bit.
    ///
    /// # Errors
    /// A port that is missing, not permitted, not serial, in use, or unable to use this bit rate.
    pub async fn open(path: &Path, baud: u32) -> Result<Self, PortError> {
        let line = match as_virtual_board(path) {
            Some(profile) => {
                let mut board = Box::new(VirtualBoard::new(profile, baud));
                board.reset();
                Line::Virtual(board)
            }
            None => Line::Wire(here::Wire::open(path, baud).await?),
        };
        let pace = Pace::new(f64::from(baud), Instant::now());
        Ok(Self { line, name: path.display().to_string(), baud, pace })
    }

    pub fn name(&self) -> &str {
        &self.name
    }

    pub fn baud(&self) -> u32 {
        self.baud
    }

    /// Changes the bit rate when all has been sent.
    ///
    /// # Errors
    /// A bit rate that this port cannot have.
    pub async fn set_baud(&mut self, baud: u32) -> Result<(), PortError> {
        task::sleep(self.backlog()).await;
        match &mut self.line {
            Line::Wire(wire) => wire.set_baud(baud).await?,
            Line::Virtual(board) => board.set_baud(baud),
        }
        self.baud = baud;
        self.pace = Pace::new(f64::from(baud), Instant::now());
        Ok(())
    }

    /// Writes bytes, and returns the time at which the last of them leaves.
    ///
    /// # Errors
    /// A vanished port, or one blocked for [`WRITE_TIMEOUT`].
    pub async fn write(&mut self, bytes: &[u8]) -> Result<Instant, PortError> {
        match &mut self.line {
            Line::Wire(wire) => wire.write(bytes).await?,
            Line::Virtual(board) => board.write(bytes),
        }
        Ok(self.pace.sent(bytes.len(), Instant::now()))
    }

    /// The arrived bytes, after waiting at most `timeout`; empty if none.
    ///
    /// # Errors
    /// A vanished port.
    pub async fn read(&mut self, timeout: Duration) -> Result<Vec<u8>, PortError> {
        match &mut self.line {
            Line::Wire(wire) => wire.read(timeout).await,
            Line::Virtual(board) => Ok(answer_within(board, timeout).await),
        }
    }

    /// Writes the last bytes without waiting; returns whether the port accepted them.
    pub fn leave(&mut self, last: &[u8]) -> bool {
        let taken = match &mut self.line {
            Line::Wire(wire) => wire.leave(last),
            Line::Virtual(board) => {
                board.write(last);
                true
            }
        };
        if taken {
            self.pace.sent(last.len(), Instant::now());
        }
        taken
    }

    /// Deposits bytes to be sent if the program ends without running any more code: killed, crashed, or as a page that
    /// is left. They are not sent before `wait` has passed.
    ///
    /// # Errors
    /// Nothing takes the deposit.
    pub fn leave_behind(&mut self, last: &[u8], wait: Duration) -> io::Result<()> {
        match &mut self.line {
            Line::Wire(wire) => wire.leave_behind(last, wait),
            Line::Virtual(_) => Ok(()),
        }
    }

    /// Discards what was written and has not left; returns whether that is possible here.
    pub fn discard(&mut self) -> bool {
        let discarded = match &mut self.line {
            Line::Wire(wire) => wire.discard(),
            Line::Virtual(board) => {
                board.discard();
                true
            }
        };
        if discarded {
            self.pace.discarded(Instant::now());
        }
        discarded
    }

    /// Corrects the count of what is on the line by the system's; returns the seconds by which the line is later than
    /// was thought.
    pub fn settle(&mut self) -> f64 {
        let held = match &self.line {
            Line::Wire(wire) => wire.held(),
            Line::Virtual(_) => 0,
        };
        self.pace.settle(held, Instant::now())
    }

    /// Remaining time for which the line is busy.
    pub fn backlog(&self) -> Duration {
        self.pace.backlog(Instant::now())
    }

    /// Time for `bytes` on the line.
    pub fn time_of(&self, bytes: usize) -> Duration {
        self.pace.time_of(bytes)
    }
}

async fn answer_within(board: &mut VirtualBoard, timeout: Duration) -> Vec<u8> {
    let until = Instant::now() + timeout;
    loop {
        let answer = board.read();
        let rest = until.saturating_duration_since(Instant::now());
        if !answer.is_empty() || rest.is_zero() {
            return answer;
        }
        task::sleep(board.next_in().min(rest)).await;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::board::Playing;
    use crate::device::levels::Levels;
    use crate::device::native::packet::{Body, Packet, Reply, Splitter};
    use crate::device::stock;
    use crate::device::task::finish;

    const PATIENCE: Duration = Duration::from_secs(5);

    #[test]
    fn every_profile_has_a_virtual_board_of_its_own_name() {
        for profile in Profile::choices() {
            assert_eq!(as_virtual_board(&virtual_board(profile)), Some(profile));
        }
        assert!(
            ["virtual:abacus", "native", "/dev/ttyUSB0"]
                .iter()
                .all(|path| as_virtual_board(path.as_ref()).is_none())
        );
    }

    #[test]
    fn a_virtual_board_shows_what_its_line_has_carried() {
        let profile = Profile::SonicSurface;
        let levels = Levels::one(profile, 3);
        let mut port = finish(Port::open(&virtual_board(profile), 10_000)).unwrap();
        let gone = finish(port.write(&stock::frame(&levels))).unwrap();
        let Line::Virtual(board) = &mut port.line else { panic!("not virtual") };
        assert!(board.frames().is_empty(), "258 bytes take 0.26 s");
        finish(task::sleep(gone.saturating_duration_since(Instant::now()) + Duration::from_millis(1)));
        let shown = board.frames();
        assert_eq!(shown.len(), 1);
        assert_eq!(shown[0].levels, levels);
        assert!(matches!(board.playing(), Playing::Levels(playing) if playing == levels));
    }

    #[test]
    fn a_native_virtual_board_answers_at_its_own_bit_rate_only() {
        let ask = |baud: u32, timeout: Duration| {
            let mut port = finish(Port::open(&virtual_board(Profile::Native), baud)).unwrap();
            finish(port.write(&Packet::info().numbered(7).to_line())).unwrap();
            let (mut splitter, mut replies) = (Splitter::default(), Vec::new());
            let until = Instant::now() + timeout;
            while replies.is_empty() && Instant::now() < until {
                let bytes = finish(port.read(Duration::from_millis(5))).unwrap();
                let parts = bytes.into_iter().filter_map(|byte| splitter.push(byte));
                replies.extend(parts.filter_map(|part| Reply::of_line(&part).ok()));
            }
            replies
        };
        let own = ask(Profile::Native.baud(), PATIENCE);
        assert!(matches!(own[..], [Reply { seq: 7, body: Body::Info(info), .. }] if info.channels == 256));
        let wrong = ask(Profile::Native.baud() / 2, Duration::from_millis(200));
        assert!(wrong.iter().all(|reply| !matches!(reply.body, Body::Info(_))), "{wrong:?}");
    }

    #[test]
    fn last_bytes_are_left_to_the_line() {
        let profile = Profile::SonicSurface;
        let levels = Levels::one(profile, 3);
        let mut port = finish(Port::open(&virtual_board(profile), 10_000)).unwrap();
        assert!(port.leave(&stock::frame(&levels)));
        let backlog = port.backlog();
        assert!(!backlog.is_zero());
        finish(task::sleep(backlog + Duration::from_millis(1)));
        let Line::Virtual(board) = &mut port.line else { panic!("not virtual") };
        assert_eq!(board.frames().len(), 1);
    }

    #[test]
    fn a_read_of_a_virtual_board_waits_for_its_answer() {
        let mut port = finish(Port::open(&virtual_board(Profile::Native), Profile::Native.baud())).unwrap();
        finish(port.write(&Packet::info().to_line())).unwrap();
        assert!(!finish(port.read(PATIENCE)).unwrap().is_empty());
    }
}
