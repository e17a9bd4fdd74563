//! Connects to native devices: search, reset to a known state, and choice of the bit rate.

use web_time::{Duration, Instant};

use crate::device::link::native::ask::Asker;
use crate::device::link::native::session::{SILENT, Session};
use crate::device::link::shared::{Event, LEAD, LinkError, Settings, Shared, Sounding, Wanted};
use crate::device::native::model;
use crate::device::native::packet::{BROADCAST, Body, Info, Packet, Reply};
use crate::device::port::Port;
use crate::device::profile::Profile;

/// Version of the protocol that this program speaks.
const VERSION: u8 = 2;

/// A session and its line.
pub struct Connection<'a> {
    board: Sounding<'a>,
    asker: Asker,
    shared: &'a Shared,
    pub session: Session<'a>,
}

impl<'a> Connection<'a> {
    /// Finds the devices, silences them, and resets the state of earlier programs.
    pub async fn open(settings: &Settings, shared: &'a Shared) -> Result<Self, LinkError> {
        let port = Port::open(&settings.port, Profile::Native.baud()).await?;
        // A delimiter first, to end an incomplete packet on the line.
        let silence = [vec![0], Packet::mute().to(BROADCAST).to_line()].concat();
        let mut board = Sounding::new(port, silence, Duration::ZERO, shared);
        let mut asker = Asker::new();
        let closing = || shared.wanted().closing;
        let info = introduce(&mut board.port, &mut asker, 0, &closing).await?;
        let mut resets = Vec::new();
        for address in 0..settings.profile.devices() as u8 {
            introduce(&mut board.port, &mut asker, address, &closing).await?;
            resets.push(asker.reset(&mut board.port, address).await?);
        }
        change_baud(&mut board.port, &mut asker, &info, resets.len() as u8, settings.baud()).await?;
        let session = Session::new(settings, info, &resets, shared, Instant::now());
        shared.tell(Event::Ready(session.found()));
        Ok(Self { board, asker, shared, session })
    }

    pub async fn send_what_fits(&mut self, wanted: &Wanted) -> Result<(), LinkError> {
        while self.board.port.backlog() < LEAD
            && let Some(message) = self.session.next(wanted, Instant::now())
        {
            let gone = self.board.port.write(&message.line).await?;
            self.session.sent(message, wanted, Instant::now(), gone);
        }
        Ok(())
    }

    /// Waits for answers or new work.
    pub async fn listen(&mut self, wanted: &Wanted) -> Result<(), LinkError> {
        if let Some(rest) = self.session.rest(wanted, Instant::now()) {
            self.shared.wait(wanted.generation, rest).await;
            return Ok(());
        }
        let replies = self.asker.replies(&mut self.board.port, Duration::from_millis(1)).await?;
        self.session.hear(&replies, wanted, Instant::now())
    }
}

async fn change_baud(
    port: &mut Port,
    asker: &mut Asker,
    info: &Info,
    devices: u8,
    baud: u32,
) -> Result<(), LinkError> {
    if baud == port.baud() {
        return Ok(());
    }
    let packet = agreeable(info, baud)?;
    // On a shared line all change at once; a loss shows as silence afterwards.
    match devices {
        1 => drop(asker.order(port, &packet).await?),
        _ => drop(port.write(&packet.to(BROADCAST).to_line()).await?),
    }
    port.set_baud(baud).await?;
    for address in 0..devices {
        asker.order(port, &Packet::status().to(address)).await?;
    }
    Ok(())
}

/// Repeats INFO until it is answered; a device left at another bit rate returns to the default after 0.8 s.
///
/// # Errors
/// No answer, or one of another board or of another version.
pub async fn introduce(
    port: &mut Port,
    asker: &mut Asker,
    address: u8,
    closing: &dyn Fn() -> bool,
) -> Result<Info, LinkError> {
    let until = Instant::now() + SILENT;
    while Instant::now() < until && !closing() {
        port.write(&[0]).await?;
        let reply = asker.ask(port, &Packet::info().to(address)).await?;
        if let Some(Reply { body: Body::Info(info), .. }) = reply {
            return expected(info);
        }
    }
    let name = port.name().to_owned();
    Err(match (asker.heard, address) {
        (true, 0) => LinkError::OtherBoard(name),
        (false, 0) => LinkError::NoAnswer(name),
        (_, address) => LinkError::NoDevice { name, address },
    })
}

fn expected(info: Info) -> Result<Info, LinkError> {
    if info.protocol != VERSION {
        return Err(LinkError::OtherVersion { theirs: info.protocol, ours: VERSION });
    }
    let (board, expected) = (usize::from(info.channels), Profile::Native.elements());
    if board != expected {
        return Err(LinkError::OtherCount { board, expected });
    }
    Ok(info)
}

/// The most that a device supports.
pub fn largest_baud(info: &Info) -> u32 {
    100_000 * u32::from(info.largest_baud)
}

/// The packet that changes a device's bit rate.
///
/// # Errors
/// More than the device supports.
pub fn agreeable(info: &Info, baud: u32) -> Result<Packet, LinkError> {
    let largest = largest_baud(info);
    if baud > largest {
        return Err(LinkError::TooFast { asked: baud, largest });
    }
    let clock = f64::from(model::clocks(info.phase_bits)) * f64::from(info.carrier_millihertz) / 1e3;
    Ok(Packet::baud((f64::from(baud) / clock * 65_536.0).round() as u16))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::native::model::Model;

    #[test]
    fn a_device_is_told_the_nearest_of_its_bit_rates() {
        for (phase_bits, carrier_millihertz) in [(7, 40_000_000), (8, 39_950_400)] {
            let mut device = Model::new(phase_bits).with_carrier(carrier_millihertz);
            let Body::Info(info) = device.apply(&Packet::info()).body else { panic!() };
            let step = device.carrier() * f64::from(model::clocks(phase_bits)) / 65_536.0;
            for baud in [115_200, 230_400, 333_333, 460_800, 921_600, 3_000_000, 8_000_000] {
                device.apply(&agreeable(&info, baud).unwrap());
                let off = (device.baud() - f64::from(baud)).abs();
                assert!(off <= step / 2.0, "{phase_bits} bits: {baud} baud is off by {off}");
            }
        }
    }
}
