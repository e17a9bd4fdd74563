//! The link to boards without acknowledgements: frames as fast as the line allows, and modulation by timed buffer
//! swaps.
//!
//! A frame at rest and silence are repeated four times a second. An envelope is played by swapping the two buffers,
//! one silent, at the right times (`pulses`), also during a motion or a drag: frames are loaded while the board is
//! silent (`rhythm` computes the skipped pulses).
//!
//! The line is the clock where a board has a byte that it ignores: up to 30 ms are written ahead, the time between two
//! swaps is filled with that byte, and a swap is on the line within half a byte of its time whatever the computer does.
//! A stop discards what has not left.
//!
//! [`session`] holds what is sent and when, without a line or a clock; [`run`] carries it over a port. Tests let a
//! session converse with the boards' twins in simulated time.

mod echo;
mod pulses;
mod rhythm;
mod session;
#[cfg(all(test, unix))]
mod tests;

use web_time::{Duration, Instant};

use crate::device::health::Found;
use crate::device::link::shared::{Event, LinkError, Settings};
use crate::device::link::shared::{Shared, Sounding, Wanted};
use crate::device::link::stock::echo::Echo;
use crate::device::link::stock::session::{Session, Step};
use crate::device::port::{Port, PortError};
use crate::device::{stock, task};

/// Plays on a board, which is expected to be held by its boot loader if it `was_deaf`.
pub async fn run(settings: &Settings, shared: &Shared, was_deaf: bool) -> Result<(), LinkError> {
    let silence = stock::silence(settings.profile);
    let quiet = stock::quiet(settings.profile, was_deaf);
    let port = Port::open(&settings.port, settings.baud()).await?;
    let mut board = Sounding::new(port, silence.clone(), quiet, shared);
    // A board that its boot loader leaves later sounds, so closing waits, too; but not for one that may not be there.
    let is_given_up = |_| was_deaf && shared.wanted().closing;
    let heard = listen(&mut board.port, Instant::now() + quiet, is_given_up).await?;
    if is_given_up(heard) {
        return Ok(());
    }
    let gone = board.port.write(&silence).await?;
    shared.note_bytes(silence.len());
    task::sleep(board.port.backlog()).await;
    let mut echo = Echo::of(settings.profile, Instant::now());
    if let Some(echo) = &mut echo {
        echo.wrote(&silence, gone);
        let heard = listen(&mut board.port, gone + echo::ANSWERS, |heard| echo.is_complete(heard)).await?;
        echo.greet(heard, silence.len(), settings)?;
    }
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
                echo.iter_mut().for_each(|echo| echo.wrote(&bytes, gone));
                session.written(bytes.len(), &wanted, Instant::now(), gone);
            }
            Step::Wait(until) => {
                shared.wait(wanted.generation, until.saturating_duration_since(now)).await;
                look(&mut board.port, &mut echo).await?;
            }
            Step::Watch(due) => {
                look(&mut board.port, &mut echo).await?;
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

/// Checks the port, and the board by its echo.
async fn look(port: &mut Port, echo: &mut Option<Echo>) -> Result<(), LinkError> {
    let heard = port.read(Duration::ZERO).await?.len();
    echo.as_mut().map_or(Ok(()), |echo| echo.heard(heard, Instant::now(), port.name()))
}

/// The number of bytes that arrive until then, or until there are enough.
async fn listen(
    port: &mut Port,
    until: Instant,
    is_over: impl Fn(usize) -> bool,
) -> Result<usize, PortError> {
    const PART: Duration = Duration::from_millis(20);
    let mut heard = 0;
    loop {
        let rest = until.saturating_duration_since(Instant::now());
        if rest.is_zero() || is_over(heard) {
            return Ok(heard);
        }
        heard += port.read(rest.min(PART)).await?.len();
    }
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
