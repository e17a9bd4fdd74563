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

use crate::device::link::native::connect::Connection;
use crate::device::link::shared::{LinkError, Settings, Shared};

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
