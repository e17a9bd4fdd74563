//! A single request and its reply, outside a session.

use web_time::{Duration, Instant};

use crate::device::link::shared::LinkError;
use crate::device::native::packet::{Kind, Outcome, Packet, REPLY, Reply, Splitter};
use crate::device::port::{Port, PortError};

/// Attempts to send a required packet.
const ATTEMPTS: u32 = 4;
/// Time limit of an answer: an adapter may delay it by 16 ms, a busy computer by more.
const ANSWER: Duration = Duration::from_millis(100);

/// The host's end of a line to native devices.
#[derive(Debug)]
pub struct Asker {
    splitter: Splitter,
    seq: u8,
    /// Whether any bytes arrived, even if no valid answer.
    pub heard: bool,
}

impl Asker {
    pub fn new() -> Self {
        Self { splitter: Splitter::default(), seq: 0, heard: false }
    }

    /// The answer to one packet, if there is one in time.
    ///
    /// # Errors
    /// A vanished or stuck port.
    pub async fn ask(&mut self, port: &mut Port, packet: &Packet) -> Result<Option<Reply>, PortError> {
        const LOOK: Duration = Duration::from_millis(5);
        self.seq = self.seq.wrapping_add(1);
        port.write(&packet.clone().numbered(self.seq).to_line()).await?;
        let until = Instant::now() + port.backlog() + ANSWER;
        while Instant::now() < until {
            // Any answer to this packet type counts: that of an earlier attempt may arrive late.
            let is_it = |reply: &Reply| (reply.code, reply.address) == (packet.code + REPLY, packet.address);
            if let Some(reply) = self.replies(port, LOOK).await?.into_iter().find(is_it) {
                return Ok(Some(reply));
            }
        }
        Ok(None)
    }

    /// Sends a required packet and returns its answer.
    ///
    /// # Errors
    /// A vanished port, a device that refuses or does not answer.
    pub async fn order(&mut self, port: &mut Port, packet: &Packet) -> Result<Reply, LinkError> {
        for _ in 0..ATTEMPTS {
            match self.ask(port, packet).await? {
                Some(reply) if reply.outcome == Outcome::Ok => return Ok(reply),
                Some(_) => {
                    return Err(LinkError::Refused(
                        Kind::from_repr(packet.code).map_or("a packet", Into::into),
                    ));
                }
                None => {}
            }
        }
        Err(LinkError::Silent(port.name().to_owned()))
    }

    /// The answers available now or within `timeout`.
    ///
    /// # Errors
    /// A vanished port.
    pub async fn replies(&mut self, port: &mut Port, timeout: Duration) -> Result<Vec<Reply>, PortError> {
        let bytes = port.read(timeout).await?;
        self.heard |= !bytes.is_empty();
        let parts = bytes.into_iter().filter_map(|byte| self.splitter.push(byte));
        Ok(parts.filter_map(|part| Reply::of_line(&part).ok()).collect())
    }

    /// Silences and resets a device in any state. Returns its answer to RESET.
    ///
    /// # Errors
    /// The errors of [`Self::order`], or a device that does not become silent.
    pub async fn reset(&mut self, port: &mut Port, address: u8) -> Result<Reply, LinkError> {
        /// Time for a muted device to become silent: its ramp takes 6.4 ms, and RESET is refused until it has ended.
        const FADED: Duration = Duration::from_millis(300);
        self.order(port, &Packet::mute().to(address)).await?;
        let until = Instant::now() + FADED;
        loop {
            match self.ask(port, &Packet::reset().to(address)).await? {
                Some(reply) if reply.outcome == Outcome::Ok => return Ok(reply),
                Some(reply) if reply.outcome != Outcome::State => break,
                Some(_) | None if Instant::now() > until => break,
                Some(_) | None => {}
            }
        }
        Err(LinkError::Refused(Kind::Reset.into_str()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::port::virtual_board;
    use crate::device::profile::Profile;
    use crate::device::task::finish;

    fn port() -> Port {
        finish(Port::open(&virtual_board(Profile::Native), Profile::Native.baud())).unwrap()
    }

    #[test]
    fn an_answer_is_awaited_for_as_long_as_the_line_is_busy() {
        let mut port = port();
        // 120 ms of delimiters, which the board ignores.
        finish(port.write(&vec![0; 24_000])).unwrap();
        let reply = finish(Asker::new().order(&mut port, &Packet::status()));
        assert!(reply.is_ok(), "{reply:?}");
    }

    #[test]
    fn a_device_that_sounds_is_reset_once_it_is_silent() {
        let (mut port, mut asker) = (port(), Asker::new());
        let mut order = |packet: &Packet| finish(asker.order(&mut port, packet)).unwrap();
        // At full amplitude at once, and silent only after the longest ramp.
        order(&Packet::phases(1, 255, &[0; 256], true));
        order(&Packet::silencer(0xFFFF, 0xFFFF));
        order(&Packet::enable(10_000));
        let sounding = order(&Packet::silencer(0xFFFF, 0x0100));
        assert!(sounding.flags.outputs_on);
        let reset = finish(asker.reset(&mut port, 0)).unwrap();
        assert!(!reset.flags.enabled && !reset.flags.outputs_on);
    }
}
