//! Connects to native devices: search, reset to a known state, and choice of the bit rate.

use std::collections::VecDeque;

use web_time::Instant;

use crate::device::envelope::Table;
use crate::device::health::Found;
use crate::device::link::native::ask::Asker;
use crate::device::link::native::{ANSWER, Device, SILENT, Session};
use crate::device::link::{Event, LinkError, Settings, Shared, Sounding};
use crate::device::native::model;
use crate::device::native::packet::{BROADCAST, Body, Info, Packet, Reply};
use crate::device::port::Port;
use crate::device::profile::Profile;

/// Of the protocol that this program speaks.
const VERSION: u8 = 2;

impl<'a> Session<'a> {
    /// Finds the devices, silences them, and resets the state of earlier programs.
    pub async fn connect(settings: &Settings, shared: &'a Shared) -> Result<Self, LinkError> {
        let port = Port::open(&settings.port, Profile::Native.baud()).await?;
        let name = port.name().to_owned();
        // A delimiter first, to end an incomplete packet on the line.
        let silence = [vec![0], Packet::mute().to(BROADCAST).to_line()].concat();
        let mut board = Sounding::new(port, silence, shared);
        let mut asker = Asker::new();
        let closing = || shared.wanted().closing;
        let info = introduce(&mut board.port, &mut asker, 0, &closing).await?;
        let now = Instant::now();
        let mut session = Self {
            board,
            shared,
            profile: settings.profile,
            name,
            info,
            devices: vec![Device::default(); settings.profile.devices()],
            asker,
            in_step: settings.profile.devices() > 1,
            seq: 0,
            tasks: VecDeque::new(),
            on_the_way: VecDeque::new(),
            written_at: now,
            patience: ANSWER,
            ready_at: now,
            generation: u64::MAX,
            modulation: Table::steady(),
            storing: None,
            live: false,
            playing: false,
            frame: None,
            live_slot: 0,
            placed: false,
            enabling: false,
            ended: None,
        };
        for address in session.addresses() {
            introduce(&mut session.board.port, &mut session.asker, address, &closing).await?;
            session.reset(address).await?;
        }
        session.change_baud(settings.baud()).await?;
        let found = Found {
            baud: settings.baud(),
            carrier: Some(session.carrier()),
            slots: usize::from(session.info.slots),
            phase_bits: Some(session.info.phase_bits),
        };
        session.ready_at = Instant::now();
        shared.tell(Event::Ready(found));
        Ok(session)
    }

    /// Device `address` in the state of power-up.
    async fn reset(&mut self, address: u8) -> Result<(), LinkError> {
        let reply = self.asker.reset(&mut self.board.port, address).await?;
        if let (Body::Status(status), Some(device)) = (reply.body, self.devices.get_mut(usize::from(address)))
        {
            *device = Device { slot: status.slot, periods: status.periods, enabled: false };
        }
        if address > 0 && !reply.flags.follows {
            self.in_step = false;
            self.shared.notice(&format!(
                "board {address} receives no sync, so its phase drifts: wire `sync` of board 0 to its `sync_in`"
            ));
        }
        Ok(())
    }

    async fn change_baud(&mut self, baud: u32) -> Result<(), LinkError> {
        if baud == self.board.port.baud() {
            return Ok(());
        }
        let packet = agreeable(&self.info, baud)?;
        // On a shared line all change at once; a loss shows as silence afterwards.
        match self.devices.len() {
            1 => drop(self.asker.order(&mut self.board.port, &packet).await?),
            _ => drop(self.board.port.write(&packet.to(BROADCAST).to_line()).await?),
        }
        self.board.port.set_baud(baud).await?;
        for address in self.addresses() {
            self.asker.order(&mut self.board.port, &Packet::status().to(address)).await?;
        }
        Ok(())
    }
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

/// The packet that changes a device's bit rate.
///
/// # Errors
/// More than the device supports.
pub fn agreeable(info: &Info, baud: u32) -> Result<Packet, LinkError> {
    let largest = 100_000 * u32::from(info.largest_baud);
    if baud > largest {
        return Err(LinkError::TooFast { asked: baud, largest });
    }
    let clock = f64::from(model::clocks(info.phase_bits)) * f64::from(info.carrier_millihertz) / 1e3;
    Ok(Packet::baud((f64::from(baud) / clock * 65_536.0).round() as u16))
}
