//! Finding the native device, and agreeing on a bit rate.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use crate::device::health::Found;
use crate::device::link::native::{ANSWER, SILENT, Session};
use crate::device::link::{Event, LinkError, Settings, Shared, Sounding};
use crate::device::native::model;
use crate::device::native::packet::{Body, Info, Kind, Outcome, Packet, REPLY, Reply, Splitter};
use crate::device::port::Port;
use crate::device::profile::Profile;

/// Of the protocol that this program speaks.
const VERSION: u8 = 2;

impl<'a> Session<'a> {
    pub fn connect(settings: &Settings, shared: &'a Shared) -> Result<Self, LinkError> {
        let port = Port::open(&settings.port, Profile::Native.baud())?;
        let name = port.name().to_owned();
        // A delimiter first, to end what the line may have left there.
        let silence = [vec![0], Packet::mute().to_line()].concat();
        let now = Instant::now();
        let mut session = Self {
            board: Sounding { port, silence, shared },
            shared,
            name,
            info: Info {
                protocol: 0,
                phase_bits: 0,
                slots: 1,
                version: 0,
                carrier_millihertz: 0,
                channels: 1,
                largest_baud: 0,
            },
            splitter: Splitter::default(),
            seq: 0,
            tasks: VecDeque::new(),
            on_the_way: VecDeque::new(),
            written_at: now,
            heard_at: now,
            patience: ANSWER,
            ready_at: now,
            generation: u64::MAX,
            modulation: None,
            live: false,
            frame: None,
            live_slot: 0,
            placed: false,
            enabled: false,
            ended: None,
        };
        session.info = session.introduce()?;
        session.change_baud(settings.baud())?;
        let found = Found {
            baud: settings.baud(),
            carrier: Some(f64::from(session.info.carrier_millihertz) / 1e3),
            slots: usize::from(session.motion_slots()),
            phase_bits: Some(session.info.phase_bits),
        };
        session.ready_at = Instant::now();
        shared.tell(Event::Ready(found));
        Ok(session)
    }

    /// Asks what is there until it answers; a device that was left at another bit rate comes back to the usual one after 0.8 s.
    fn introduce(&mut self) -> Result<Info, LinkError> {
        let until = Instant::now() + SILENT;
        let mut heard = false;
        while Instant::now() < until && !self.shared.wanted().closing {
            self.board.port.write(&[0])?;
            let reply = self.ask(&Packet::info(), &mut heard)?;
            if let Some(Reply { body: Body::Info(info), .. }) = reply {
                return self.expected(info);
            }
        }
        Err(if heard {
            LinkError::OtherBoard(self.name.clone())
        } else {
            LinkError::NoAnswer(self.name.clone())
        })
    }

    fn expected(&self, info: Info) -> Result<Info, LinkError> {
        if info.protocol != VERSION {
            return Err(LinkError::OtherVersion { theirs: info.protocol, ours: VERSION });
        }
        let (board, expected) = (usize::from(info.channels), Profile::Native.elements());
        if board != expected {
            return Err(LinkError::OtherCount { board, expected });
        }
        Ok(info)
    }

    /// The answer to one packet, if there is one in time.
    fn ask(&mut self, packet: &Packet, heard: &mut bool) -> Result<Option<Reply>, LinkError> {
        self.seq = self.seq.wrapping_add(1);
        self.board.port.write(&packet.clone().numbered(self.seq).to_line())?;
        let until = Instant::now() + self.board.port.backlog() + ANSWER;
        while Instant::now() < until {
            let bytes = self.board.port.read(Duration::from_millis(5))?;
            *heard |= !bytes.is_empty();
            for part in bytes.into_iter().filter_map(|byte| self.splitter.push(byte)) {
                // Any answer of its kind will do: that of an earlier attempt may come late.
                let reply = Reply::of_line(&part).ok();
                if let Some(reply) = reply.filter(|reply| reply.code == packet.code + REPLY) {
                    self.heard_at = Instant::now();
                    return Ok(Some(reply));
                }
            }
        }
        Ok(None)
    }

    fn change_baud(&mut self, baud: u32) -> Result<(), LinkError> {
        if baud == self.board.port.baud() {
            return Ok(());
        }
        let largest = 100_000 * u32::from(self.info.largest_baud);
        if baud > largest {
            return Err(LinkError::TooFast { asked: baud, largest });
        }
        let carrier = f64::from(self.info.carrier_millihertz) / 1e3;
        let clock = f64::from(model::clocks(self.info.phase_bits)) * carrier;
        let increment = (f64::from(baud) / clock * 65_536.0).round() as u16;
        let mut heard = false;
        let agreed = self.ask(&Packet::baud(increment), &mut heard)?;
        if agreed.is_none_or(|reply| reply.outcome != Outcome::Ok) {
            return Err(LinkError::Refused(Kind::Baud.name()));
        }
        self.board.port.set_baud(baud)?;
        for _ in 0..3 {
            if self.ask(&Packet::status(), &mut heard)?.is_some() {
                return Ok(());
            }
        }
        Err(LinkError::Silent(self.name.clone()))
    }
}
