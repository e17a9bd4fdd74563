//! The gateware as a virtual board: a Verilated program, driven over its standard input and output.
//!
//! It is slower than the device; its line and its watchdog run in simulated time.

use std::collections::VecDeque;
use std::io::{self, BufReader, BufWriter, Read, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use web_time::Instant;

use crate::device::board::logic::{Heeded, Playing, Shown, committed};
use crate::device::native::model::{CHANNELS, Pulse};
use crate::device::native::packet::{Body, Flags, Outcome, Packet, REPLY, Reply, Splitter, Status};

/// Limit of packets waiting for their outcome at the gate.
const REMEMBERED: usize = 16;
/// The program's end marker of a run.
const END: u8 = 0xFF;
/// Flag of a record: the outputs were on during the whole period.
const ALWAYS_ON: u8 = 1;

#[derive(Debug)]
pub struct Rtl {
    program: Child,
    commands: BufWriter<ChildStdin>,
    records: BufReader<ChildStdout>,
    levels: u16,
    splitter: Splitter,
    coming: VecDeque<Packet>,
    pulses: Box<[Pulse; CHANNELS]>,
    outputs_on: bool,
    baud: u32,
    pressed: bool,
}

/// A period as reported by the program.
struct Record {
    applied: bool,
    code: u8,
    seq: u8,
    result: u8,
}

impl Rtl {
    /// # Errors
    /// The program does not start.
    pub fn start(program: &Path, phase_bits: u8) -> io::Result<Self> {
        let mut program = Command::new(program).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn()?;
        let pipes = program.stdin.take().zip(program.stdout.take());
        let (commands, records) = pipes.ok_or(io::ErrorKind::BrokenPipe)?;
        Ok(Self {
            program,
            commands: BufWriter::new(commands),
            records: BufReader::new(records),
            levels: 1 << phase_bits,
            splitter: Splitter::default(),
            coming: VecDeque::new(),
            pulses: Box::new([Pulse::default(); CHANNELS]),
            outputs_on: false,
            baud: 0,
            pressed: false,
        })
    }

    /// Runs periods during which these bytes begin to arrive, sent at `baud`.
    ///
    /// # Errors
    /// The program ended.
    pub fn run(&mut self, bytes: &[u8], baud: u32, periods: u32, heeded: &mut Heeded) -> io::Result<()> {
        if self.baud != baud {
            self.baud = baud;
            self.commands.write_all(b"b")?;
            self.commands.write_all(&f64::from(baud).to_le_bytes())?;
        }
        for part in bytes.chunks(usize::from(u16::MAX)) {
            self.commands.write_all(b"u")?;
            self.commands.write_all(&(part.len() as u16).to_le_bytes())?;
            self.commands.write_all(part)?;
        }
        self.remember(bytes, heeded);
        self.commands.write_all(b"r")?;
        self.commands.write_all(&periods.to_le_bytes())?;
        self.commands.flush()?;
        while let Some(record) = self.record(&mut heeded.answer)? {
            self.see(&record, heeded);
        }
        Ok(())
    }

    /// # Errors
    /// The program ended.
    pub fn press(&mut self, pressed: bool) -> io::Result<()> {
        if std::mem::replace(&mut self.pressed, pressed) != pressed {
            self.commands.write_all(&[b'e', u8::from(pressed)])?;
        }
        Ok(())
    }

    fn remember(&mut self, bytes: &[u8], heeded: &mut Heeded) {
        for part in bytes.iter().filter_map(|&byte| self.splitter.push(byte)) {
            match Packet::of_line(&part) {
                Ok(packet) => self.coming.push_back(packet),
                Err(_) => heeded.spoiled += 1,
            }
            if self.coming.len() > REMEMBERED {
                self.coming.pop_front();
            }
        }
    }

    /// `None` at the end of a run.
    fn record(&mut self, answer: &mut Vec<u8>) -> io::Result<Option<Record>> {
        let mut device = [0];
        self.records.read_exact(&mut device)?;
        if device == [END] {
            return Ok(None);
        }
        let mut head = [0; 15];
        self.records.read_exact(&mut head)?;
        let [flags, _, _, _, _, _, _, _, _, applied, code, seq, result, low, high] = head;
        let mut received = vec![0; usize::from(u16::from_le_bytes([low, high]))];
        self.records.read_exact(&mut received)?;
        answer.extend(received);
        let mut pulses = [0; 2 * CHANNELS];
        self.records.read_exact(&mut pulses)?;
        for (pulse, &[rise, width]) in self.pulses.iter_mut().zip(pulses.as_chunks::<2>().0) {
            *pulse = Pulse { rise, width };
        }
        self.outputs_on = flags & ALWAYS_ON != 0;
        Ok(Some(Record { applied: applied == 1, code, seq, result }))
    }

    fn see(&mut self, record: &Record, heeded: &mut Heeded) {
        let is_it = |packet: &Packet| packet.code == record.code && packet.seq == record.seq;
        let Some(place) = self.coming.iter().position(is_it).filter(|_| record.applied) else { return };
        let packet = self.coming.drain(..=place).next_back();
        let Some(outcome) = Outcome::from_repr(record.result) else { return };
        let reply = Reply {
            code: record.code.wrapping_add(REPLY),
            address: 0,
            seq: record.seq,
            outcome,
            flags: Flags::default(),
            body: Body::Status(Status::default()),
        };
        let levels = packet.and_then(|packet| committed(&packet, &reply));
        heeded.shown.extend(levels.map(|levels| Shown { at: Instant::now(), levels }));
    }

    pub fn playing(&self) -> Playing {
        Playing::Pulses { levels: self.levels, pulses: self.pulses.to_vec(), outputs_on: self.outputs_on }
    }
}

impl Drop for Rtl {
    fn drop(&mut self) {
        // It would end with its input, but waiting would require closing the pipe first.
        let _ = self.program.kill();
        let _ = self.program.wait();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A board whose program reports no period.
    fn rtl() -> Rtl {
        Rtl::start(Path::new("/bin/cat"), 7).unwrap()
    }

    #[test]
    fn the_latest_packets_are_remembered_and_other_bytes_are_spoiled() {
        let (mut rtl, mut heeded) = (rtl(), Heeded::default());
        rtl.remember(&[7, 7, 0], &mut heeded);
        assert_eq!((heeded.spoiled, rtl.coming.len()), (1, 0));
        let packets = (0..20).map(|seq| Packet::status().numbered(seq));
        packets.for_each(|packet| rtl.remember(&packet.to_line(), &mut heeded));
        assert!(rtl.coming.iter().map(|packet| packet.seq).eq(4..20));
        assert_eq!(heeded.spoiled, 1);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn the_program_ends_with_its_board() {
        let rtl = rtl();
        let process = Path::new("/proc").join(rtl.program.id().to_string());
        assert!(process.exists());
        drop(rtl);
        assert!(!process.exists(), "nor is it left unreaped");
    }
}
