//! The emergency stop through the whole device: presses of any length at any time within a period.

use sonoglyph::device::native::packet::{Packet, Reply, Splitter};

use crate::gateware::simulated::Simulated;

const CLOCKS: u32 = 1024;
/// From less than a clock, over one clock, to 10 ms.
const PRESSES: [u32; 8] = [0, 1, 2, 31, 1000, 4096, 40_960, 409_600];

struct Stopped {
    simulated: Simulated,
    splitter: Splitter,
}

impl Stopped {
    /// Sends a packet and waits for its answer.
    fn ask(&mut self, packet: &Packet) -> Reply {
        self.simulated.send(&packet.to_line());
        for _ in 0..100 {
            for byte in self.simulated.run(1).into_iter().flat_map(|period| period.received) {
                if let Some(line) = self.splitter.push(byte) {
                    return Reply::of_line(&line).unwrap();
                }
            }
        }
        panic!("no answer to {packet:?}");
    }

    /// Runs periods: whether the outputs were enabled throughout, and whether at any time.
    fn run(&mut self, periods: u32) -> (bool, bool) {
        let periods = self.simulated.run(periods);
        (periods.iter().all(|period| period.outputs_on), periods.iter().any(|period| period.outputs_ever_on))
    }
}

#[test]
fn a_press_of_any_length_at_any_time_switches_off_until_enable() {
    let Some(simulated) = Simulated::start(7) else { return };
    let mut device = Stopped { simulated, splitter: Splitter::default() };
    device.ask(&Packet::silencer(0xFFFF, 0xFFFF));
    device.ask(&Packet::phases(1, 255, &[64; 256], true));
    for tick in (0..CLOCKS).step_by(64) {
        for clocks in PRESSES {
            let reply = device.ask(&Packet::enable(1000));
            assert!(!reply.flags.stopped && !reply.flags.tripped && reply.flags.enabled, "{reply:?}");
            device.run(3);
            assert_eq!(device.run(2), (true, true), "before the press");
            // The simulation also checks that the outputs are off two clocks later and for the rest of the period.
            device.simulated.press_for(tick, clocks);
            assert!(!device.run(1).0, "{clocks} clocks at tick {tick}");
            assert_eq!(device.run(1 + clocks / CLOCKS + 2), (false, false), "{clocks} clocks at tick {tick}");
            let reply = device.ask(&Packet::status());
            assert!(reply.flags.stopped && reply.flags.tripped, "{reply:?}");
            assert!(
                !reply.flags.enabled && !reply.flags.outputs_on && !reply.flags.emergency_stop,
                "{reply:?}"
            );
            assert_eq!(device.run(3), (false, false), "{clocks} clocks at tick {tick}");
        }
    }
}
