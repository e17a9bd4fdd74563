//! The link to native devices: numbered packets, at most four of them unacknowledged, and retransmission of lost
//! ones.
//!
//! A newly found board is muted and reset, so that no state of an earlier program remains. A corrupted, refused or
//! unanswered packet is sent again if it is still wanted.
//!
//! [`session`] holds the protocol, without a line or a clock; a [`Connection`] carries it over its port.

mod ask;
mod connect;
mod motion;
mod session;
pub mod survey;

use web_time::{Duration, Instant};

use crate::device::link::native::ask::Asker;
use crate::device::link::native::session::Session;
use crate::device::link::{LEAD, LinkError, Settings, Shared, Sounding, Wanted};

/// Packets without an answer at a time.
const WINDOW: usize = 4;
/// Time limit of an answer, unless a board turns out to be slower.
const ANSWER: Duration = Duration::from_millis(100);
/// Time without any answer after which the board is lost.
const SILENT: Duration = Duration::from_millis(1500);

pub async fn run(settings: &Settings, shared: &Shared) -> Result<(), LinkError> {
    let mut connection = Connection::open(settings, shared).await?;
    loop {
        let wanted = shared.wanted();
        if wanted.closing {
            return Ok(());
        }
        connection.session.follow(&wanted);
        connection.send_what_fits(&wanted).await?;
        connection.listen(&wanted).await?;
    }
}

/// A session and its line.
struct Connection<'a> {
    board: Sounding<'a>,
    asker: Asker,
    shared: &'a Shared,
    session: Session<'a>,
}

impl Connection<'_> {
    async fn send_what_fits(&mut self, wanted: &Wanted) -> Result<(), LinkError> {
        while self.board.port.backlog() < LEAD
            && let Some(message) = self.session.next(wanted, Instant::now())
        {
            let gone = self.board.port.write(&message.line).await?;
            self.session.sent(message, wanted, Instant::now(), gone);
        }
        Ok(())
    }

    /// Waits for answers or new work.
    async fn listen(&mut self, wanted: &Wanted) -> Result<(), LinkError> {
        if let Some(rest) = self.session.rest(wanted, Instant::now()) {
            self.shared.wait(wanted.generation, rest).await;
            return Ok(());
        }
        let replies = self.asker.replies(&mut self.board.port, Duration::from_millis(1)).await?;
        self.session.hear(&replies, wanted, Instant::now())
    }
}
