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

/// What was seen in one period.
pub struct Period {
    /// The outputs were on all the time.
    pub outputs_on: bool,
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
        let mut program =
            Command::new(folder.join("device")).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
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

    /// Goes on by so many periods.
    pub fn run(&mut self, periods: u32) -> Vec<Period> {
        self.tell(b'r', &periods.to_le_bytes());
        (0..periods).map(|_| self.record()).collect()
    }

    fn record(&mut self) -> Period {
        let mut head = [0; 7];
        self.records.read_exact(&mut head).unwrap();
        let [on, applied, code, seq, result, low, high] = head;
        let mut received = vec![0; usize::from(u16::from_le_bytes([low, high]))];
        self.records.read_exact(&mut received).unwrap();
        let mut pulses = [0; 512];
        self.records.read_exact(&mut pulses).unwrap();
        Period {
            outputs_on: on == 1,
            gate: (applied == 1).then_some([code, seq, result]),
            received,
            pulses: pulses.chunks_exact(2).map(|pair| Pulse { rise: pair[0], width: pair[1] }).collect(),
        }
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
