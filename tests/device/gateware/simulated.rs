//! The Verilated device as a program that advances by periods, with the protocol of `gateware/sim/main.cpp`.

use std::io::{BufReader, Read, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use crate::requirement;
use sonoglyph::device::native::model::Pulse;

pub struct Simulated {
    program: Child,
    commands: Option<ChildStdin>,
    records: BufReader<ChildStdout>,
}

/// The line of the second of two devices.
#[derive(Clone, Copy)]
pub enum Second {
    /// A line of its own, switched on this number of clocks after the first.
    OwnLine(u32),
    /// The line of the first device.
    SharedLine(u32),
}

/// Observations of one period of a device.
pub struct Period {
    pub device: usize,
    /// The outputs were enabled throughout.
    pub outputs_on: bool,
    /// The outputs were enabled at any time.
    pub outputs_ever_on: bool,
    /// It follows a leader.
    pub follows: bool,
    /// Its `sync` output marks the period.
    pub marked: bool,
    /// Its `trigger` output is high.
    pub triggers: bool,
    /// The clock at its beginning.
    pub start: u64,
    /// Type, sequence number and result of the packet that passed the gate.
    pub gate: Option<[u8; 3]>,
    /// Bytes received by the host.
    pub received: Vec<u8>,
    /// The pulses at the register outputs.
    pub pulses: Vec<Pulse>,
}

impl Simulated {
    /// A device after power-up; `None` if Verilator is neither found nor required.
    pub fn start(phase_bits: u8) -> Option<Self> {
        Self::with(&phase_bits.to_string(), &[])
    }

    /// One with 7 phase bits and 256 slots.
    pub fn start_with_256_slots() -> Option<Self> {
        Self::with("7-8", &[])
    }

    /// Two devices on one clock; the second receives the `sync` of the first.
    pub fn start_two(phase_bits: u8, second: Second) -> Option<Self> {
        match second {
            Second::OwnLine(later) => Self::with(&phase_bits.to_string(), &["2", &later.to_string()]),
            Second::SharedLine(later) => {
                Self::with(&phase_bits.to_string(), &["2", &later.to_string(), "shared"])
            }
        }
    }

    /// `bits` are those of phases, and of slots if not 6.
    fn with(bits: &str, arguments: &[&str]) -> Option<Self> {
        let verilator = Command::new("verilator").arg("--version").output();
        requirement::found("rtl", verilator.map_err(|error| format!("verilator: {error}")))?;
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let folder = root.join(format!("target/gateware/{bits}"));
        let built = Command::new(root.join("gateware/sim/build")).arg(bits).arg(&folder).output().unwrap();
        assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
        let mut program = Command::new(folder.join("device"))
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let (commands, records) = (program.stdin.take(), BufReader::new(program.stdout.take().unwrap()));
        Some(Self { program, commands, records })
    }

    fn tell(&mut self, command: u8, arguments: &[u8]) {
        let mut whole = vec![command];
        whole.extend(arguments);
        self.commands.as_mut().unwrap().write_all(&whole).unwrap();
    }

    /// The bit rate of the host's clock.
    pub fn baud(&mut self, baud: f64) {
        self.tell(b'b', &baud.to_le_bytes());
    }

    /// Appends to the bytes that the host sends.
    pub fn send(&mut self, bytes: &[u8]) {
        let mut arguments = u16::try_from(bytes.len()).unwrap().to_le_bytes().to_vec();
        arguments.extend(bytes);
        self.tell(b'u', &arguments);
    }

    pub fn press(&mut self, pressed: bool) {
        self.tell(b'e', &[u8::from(pressed)]);
    }

    /// Presses the emergency stop after `from` clocks for this number of clocks; 0 is less than one.
    pub fn press_for(&mut self, from: u32, clocks: u32) {
        self.tell(b'x', &[from.to_le_bytes(), clocks.to_le_bytes()].concat());
    }

    /// The level of its trigger input.
    pub fn trigger(&mut self, level: bool) {
        self.tell(b't', &[u8::from(level)]);
    }

    /// Selects the device of later commands.
    pub fn about(&mut self, device: usize) {
        self.tell(b'd', &[u8::try_from(device).unwrap()]);
    }

    /// Advances by periods of the first device; gives all periods that ended.
    pub fn run(&mut self, periods: u32) -> Vec<Period> {
        self.tell(b'r', &periods.to_le_bytes());
        std::iter::from_fn(|| self.record()).collect()
    }

    fn bytes<const N: usize>(&mut self) -> [u8; N] {
        let mut bytes = [0; N];
        self.records.read_exact(&mut bytes).unwrap();
        bytes
    }

    /// `None` at the end of a run.
    fn record(&mut self) -> Option<Period> {
        let [device] = self.bytes();
        if device == 0xFF {
            return None;
        }
        let [flags] = self.bytes();
        let start = u64::from_le_bytes(self.bytes());
        let [applied, code, seq, result] = self.bytes();
        let mut received = vec![0; usize::from(u16::from_le_bytes(self.bytes()))];
        self.records.read_exact(&mut received).unwrap();
        let pulses: [u8; 512] = self.bytes();
        let set = |bit: u8| flags >> bit & 1 == 1;
        Some(Period {
            device: usize::from(device),
            outputs_on: set(0),
            outputs_ever_on: set(1),
            follows: set(2),
            marked: set(3),
            triggers: set(4),
            start,
            gate: (applied == 1).then_some([code, seq, result]),
            received,
            pulses: pulses.chunks_exact(2).map(|pair| Pulse { rise: pair[0], width: pair[1] }).collect(),
        })
    }
}

impl Drop for Simulated {
    fn drop(&mut self) {
        drop(self.commands.take());
        let ended = self.program.wait().unwrap();
        if !std::thread::panicking() {
            assert!(ended.success(), "the simulated device ended with {ended}");
        }
    }
}
