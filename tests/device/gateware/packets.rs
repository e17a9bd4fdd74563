//! Random packets.

use sonoglyph::device::native::packet::{BROADCAST, Kind, Packet, Table};
use strum::VariantArray;

use crate::dice::Dice;

impl Dice {
    pub fn bytes<const N: usize>(&mut self) -> [u8; N] {
        std::array::from_fn(|_| self.byte())
    }

    pub fn pairs(&mut self) -> [[u8; 2]; 256] {
        std::array::from_fn(|_| self.bytes())
    }

    /// A packet for the device at this address, for all devices, or for another one.
    pub fn packet_about(&mut self, address: u8) -> Packet {
        let packet = self.packet();
        match self.below(16) {
            0 => packet.to(BROADCAST),
            1 => packet.to(address ^ (1 + self.below(127) as u8)),
            _ => packet.to(address),
        }
    }

    /// A random packet, mostly one that a host would send, sometimes an invalid one.
    fn packet(&mut self) -> Packet {
        let slot = self.below(12) as u8;
        match self.below(36) {
            0..5 => Packet::frame(slot, &self.pairs(), self.below(2) == 0),
            5..8 => Packet::phases(slot, self.byte(), &self.bytes(), self.below(2) == 0),
            8..12 => {
                let (divider, loops, after) = (1 + self.below(9), self.below(4), self.below(2) == 0);
                let play =
                    Packet::play(slot, slot + self.below(5) as u8, divider as u16, loops as u16, after);
                match self.below(8) {
                    0 | 1 => play.in_step(),
                    2 => play.at_trigger(),
                    _ => play,
                }
            }
            12 => Packet::stop(),
            13 => Packet::envelope(&self.bytes()),
            14 => Packet::rate(self.below(1 << 22) as u32, self.below(2) == 0),
            15 => Packet::silencer(self.step(), self.step()),
            16 => Packet::widths(&self.bytes()),
            17 => Packet::calibration(&self.pairs()),
            18 => Packet::mute(),
            19..25 => Packet::enable(1 + self.below(20) as u16),
            25 => Packet::status(),
            26 => Packet::info(),
            27 => {
                let (code, arguments) = (0x40 + self.byte() / 4, self.bytes());
                Packet { code, address: 0, seq: 0, arguments, payload: Vec::new() }
            }
            28 => Packet { payload: vec![3; self.below(513) as usize], ..self.of_any_kind() },
            29 => Packet { arguments: self.bytes(), ..self.of_any_kind() },
            30 => Packet::enable(0),
            31 => Packet::reset(),
            32 => Packet::digest(Table::Slot(slot)),
            33 => {
                Packet::digest([Table::Envelope, Table::Widths, Table::Calibration][self.below(3) as usize])
            }
            34 => Packet::phases(slot, self.byte(), &self.bytes(), true).in_step(),
            _ => Packet::phases(self.byte(), self.byte(), &self.bytes(), true),
        }
    }

    /// Of any kind, with the right length and arguments 0. BAUD is left out, as it changes the host's rate, too.
    fn of_any_kind(&mut self) -> Packet {
        let kind = Kind::VARIANTS[self.below(16) as usize];
        let kind = if kind == Kind::Baud { Kind::Stop } else { kind };
        Packet::new(kind, [0; 4], vec![0; kind.payload()])
    }

    fn step(&mut self) -> u16 {
        match self.below(4) {
            0 => 0xFFFF,
            1 => self.below(0x40) as u16,
            _ => self.below(0x2000) as u16,
        }
    }
}
