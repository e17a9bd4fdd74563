//! The Verilated device as a program that goes period by period; `gateware/sim/main.cpp` says what it speaks.

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

/// Where the line of the second of two devices comes from.
#[derive(Clone, Copy)]
pub enum Second {
    /// Switched on so many clocks after the first, with a line of its own.
    OwnLine(u32),
    /// On the line of the first.
    SharedLine(u32),
}

/// What was seen in one period of a device.
pub struct Period {
    pub device: usize,
    /// The outputs were on all the time.
    pub outputs_on: bool,
    /// They were on at any time.
    pub outputs_ever_on: bool,
    /// It follows a leader.
    pub follows: bool,
    /// Its `sync` marks the period.
    pub marked: bool,
    /// The clock with which it began.
    pub start: u64,
    /// Type, sequence number and result of the packet that went through the gate.
    pub gate: Option<[u8; 3]>,
    /// What the host received.
    pub received: Vec<u8>,
    /// What stood at the register outputs.
    pub pulses: Vec<Pulse>,
}

impl Simulated {
    /// A device with so many phase bits that has just been switched on; nothing if no Verilator is here and none has to be.
    pub fn start(phase_bits: u8) -> Option<Self> {
        Self::with(phase_bits, &[])
    }

    /// Two devices on one clock, the second of which gets the `sync` of the first.
    pub fn start_two(phase_bits: u8, second: Second) -> Option<Self> {
        match second {
            Second::OwnLine(later) => Self::with(phase_bits, &["2", &later.to_string()]),
            Second::SharedLine(later) => Self::with(phase_bits, &["2", &later.to_string(), "shared"]),
        }
    }

    fn with(phase_bits: u8, arguments: &[&str]) -> Option<Self> {
        let verilator = Command::new("verilator").arg("--version").output();
        requirement::found("rtl", verilator.map_err(|error| format!("verilator: {error}")))?;
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let folder = root.join(format!("target/gateware/{phase_bits}"));
        let built = Command::new(root.join("gateware/sim/build"))
            .arg(phase_bits.to_string())
            .arg(&folder)
            .output()
            .unwrap();
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

    /// The bit rate of the host's own clock.
    pub fn baud(&mut self, baud: f64) {
        self.tell(b'b', &baud.to_le_bytes());
    }

    /// Appends to what the host sends.
    pub fn send(&mut self, bytes: &[u8]) {
        let mut arguments = u16::try_from(bytes.len()).unwrap().to_le_bytes().to_vec();
        arguments.extend(bytes);
        self.tell(b'u', &arguments);
    }

    pub fn press(&mut self, pressed: bool) {
        self.tell(b'e', &[u8::from(pressed)]);
    }

    /// Presses the emergency stop so many clocks from now, for so many clocks; 0 for less than one.
    pub fn press_for(&mut self, from: u32, clocks: u32) {
        self.tell(b'x', &[from.to_le_bytes(), clocks.to_le_bytes()].concat());
    }

    /// What is told next is about this device.
    pub fn about(&mut self, device: usize) {
        self.tell(b'd', &[u8::try_from(device).unwrap()]);
    }

    /// Goes on by so many periods of the first device: all periods that ended meanwhile.
    pub fn run(&mut self, periods: u32) -> Vec<Period> {
        self.tell(b'r', &periods.to_le_bytes());
        std::iter::from_fn(|| self.record()).collect()
    }

    fn bytes<const N: usize>(&mut self) -> [u8; N] {
        let mut bytes = [0; N];
        self.records.read_exact(&mut bytes).unwrap();
        bytes
    }

    /// Nothing at the end of a run.
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
