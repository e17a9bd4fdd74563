//! The link to boards without acknowledgements: frames as fast as the line allows, and modulation by timed buffer
//! swaps.
//!
//! A frame at rest and silence are repeated four times a second. An envelope is played by swapping the two buffers,
//! one silent, at the right times (`pulses`), also during a motion or a drag: frames are loaded while the board is
//! silent (`rhythm` computes the skipped pulses).
//!
//! The line is the clock where a board has a byte that it ignores: up to 50 ms are written ahead, the time between two
//! swaps is filled with that byte, and a swap is on the line within half a byte of its time whatever the computer does.
//! A stop discards what has not left.
//!
//! [`session`] holds what is sent and when, without a line or a clock; [`run`] carries it over a port. Tests let a
//! session converse with the boards' twins in simulated time.

mod pulses;
mod rhythm;
mod session;
#[cfg(all(test, unix))]
mod tests;

use web_time::{Duration, Instant};

use crate::device::health::Found;
use crate::device::link::shared::{Event, LinkError, Settings};
use crate::device::link::shared::{Shared, Sounding, Wanted};
use crate::device::link::stock::session::{Session, Step};
use crate::device::port::{Port, PortError};
use crate::device::{stock, task};

pub async fn run(settings: &Settings, shared: &Shared) -> Result<(), LinkError> {
    let silence = stock::silence(settings.profile);
    let mut board =
        Sounding::new(Port::open(&settings.port, settings.baud()).await?, silence.clone(), shared);
    board.port.write(&silence).await?;
    shared.note_bytes(silence.len());
    task::sleep(board.port.backlog()).await;
    let mut session = Session::new(settings, shared, Instant::now());
    let carrier = settings.profile.carrier();
    let found = Found { baud: settings.baud(), carrier, slots: 0, phase_bits: None };
    shared.tell(Event::Ready(found));
    if let Some(remark) = settings.profile.remark() {
        shared.notice(&format!("{}: {remark}", settings.profile.name()));
    }
    loop {
        let wanted = shared.wanted();
        if wanted.closing {
            if stock::filler(settings.profile).is_some() {
                board.port.discard();
            }
            return Ok(());
        }
        session.shift(board.port.settle());
        let now = Instant::now();
        match session.next(&wanted, now, now + board.port.backlog()) {
            Step::Write(bytes) => {
                let gone = board.port.write(&bytes).await?;
                session.written(bytes.len(), &wanted, Instant::now(), gone);
            }
            Step::Wait(until) => {
                shared.wait(wanted.generation, until.saturating_duration_since(now)).await;
                look(&mut board.port).await?;
            }
            Step::Watch(due) => {
                look(&mut board.port).await?;
                watch(due, &wanted, shared).await;
            }
            Step::Discard => {
                if board.port.discard() {
                    session.discarded();
                }
            }
        }
    }
}

/// Checks the port. A board's bytes are at most an echo.
async fn look(port: &mut Port) -> Result<(), PortError> {
    port.read(Duration::ZERO).await.map(drop)
}

/// Waits exactly until then, or inexactly for a newer wish.
async fn watch(due: Instant, wanted: &Wanted, shared: &Shared) {
    let rest = due.saturating_duration_since(Instant::now());
    shared.wait(wanted.generation, rest.saturating_sub(task::WATCHFUL)).await;
    let now = shared.wanted();
    if now.generation == wanted.generation && !now.closing {
        task::watch(due);
    }
}
