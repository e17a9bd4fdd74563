//! Two devices on one clock, of which the second follows the first.

use sonoglyph::device::native::model::Model;
use sonoglyph::device::native::packet::{BROADCAST, Outcome, Packet, Reply};

use crate::dice::Dice;
use crate::gateware::simulated::{Second, Simulated};
use crate::gateware::twins::{Twin, WINDOW};

struct Pair {
    simulated: Simulated,
    twins: [Twin; 2],
    shared: bool,
    /// The beginning of the last period of each, in clocks.
    starts: [u64; 2],
    /// Slots played by each model, with the clock at the beginning of the period.
    slots: [Vec<(u64, u8)>; 2],
    /// The beginning of the leader's marked period, in clocks.
    mark: Option<u64>,
    /// Whether the last periods of both began within a clock; once `locked`, they must.
    together: bool,
    locked: bool,
}

impl Pair {
    fn start(phase_bits: u8, second: Second) -> Option<Self> {
        let twin = |address| Twin::new(Model::new(phase_bits).with_address(address));
        Some(Self {
            simulated: Simulated::start_two(phase_bits, second)?,
            twins: [twin(0), twin(1)],
            shared: matches!(second, Second::SharedLine(_)),
            starts: [0; 2],
            slots: [Vec::new(), Vec::new()],
            mark: None,
            together: false,
            locked: false,
        })
    }

    /// Runs periods of the leader, and compares every period of both.
    fn run(&mut self, periods: u32) {
        let mut seen = self.simulated.run(periods);
        // In order of their beginnings; on a tie the leader's first, since its marks are followed.
        seen.sort_by_key(|period| (period.start + u64::from(period.device == 1), period.device));
        for period in seen {
            let (device, start, marked) = (period.device, period.start, period.marked);
            let follows = period.follows;
            self.starts[device] = start;
            let twin = &mut self.twins[device];
            if device == 1 && self.mark.take_if(|mark| mark.abs_diff(start) <= 1).is_some() {
                twin.model.mark();
            }
            assert!(device == 1 || !period.follows, "the first one leads");
            twin.compare(period);
            if device == 0 {
                self.mark = marked.then_some(start);
            } else {
                self.together = follows && self.starts[0].abs_diff(start) <= 1;
                assert!(self.together || !self.locked, "periods begin at {:?}", self.starts);
            }
            self.slots[device].push((start, self.twins[device].model.slot()));
        }
    }

    /// Runs until the second follows and begins its periods within a clock of the first.
    fn lock(&mut self) {
        while !self.together {
            assert!(self.twins[0].periods < 100, "the second device does not follow");
            self.run(1);
        }
        self.locked = true;
        self.run(2);
    }

    fn send(&mut self, line: usize, packet: Packet) {
        let packet = self.twins[line].numbered(packet);
        self.simulated.about(if self.shared { 0 } else { line });
        self.simulated.send(&packet.to_line());
        for (device, twin) in self.twins.iter_mut().enumerate() {
            if self.shared || device == line {
                twin.is_sent(packet.clone());
            }
        }
    }

    fn unanswered(&self) -> usize {
        self.twins.iter().map(Twin::unanswered).sum()
    }

    fn settle(&mut self) {
        for _ in 0..10_000 {
            if self.unanswered() == 0 {
                return;
            }
            self.run(2);
        }
        panic!("{} packets are not answered", self.unanswered());
    }

    /// Sends a packet to the device with this address, and waits for its answer.
    fn order(&mut self, device: usize, packet: Packet) -> Reply {
        self.send(device, packet.to(device as u8));
        self.settle();
        let reply = *self.twins[device].answers.last().unwrap();
        assert_eq!((reply.outcome, usize::from(reply.address)), (Outcome::Ok, device), "{reply:?}");
        reply
    }
}

/// The clocks at which the devices began to play a slot.
fn change(pair: &Pair, slot: u8) -> [u64; 2] {
    pair.slots.each_ref().map(|slots| slots.iter().find(|&&(_, played)| played == slot).unwrap().0)
}

fn in_step(phase_bits: u8, second: Second) {
    let Some(mut pair) = Pair::start(phase_bits, second) else { return };
    pair.lock();
    let follows = pair.order(1, Packet::status()).flags.follows;
    assert!(follows && !pair.order(0, Packet::status()).flags.follows);
    for device in [0, 1] {
        pair.order(device, Packet::silencer(0xFFFF, 0xFFFF));
        pair.order(device, Packet::enable(1000));
    }
    let mut dice = Dice::seeded(u64::from(phase_bits));
    for slot in 1..12 {
        // To the follower first, where it waits, then to the leader, which takes it in the next period.
        pair.order(1, Packet::frame(slot, &dice.pairs(), true).in_step());
        pair.run(dice.below(20) as u32);
        assert!(pair.order(1, Packet::status()).flags.waiting);
        let packet = Packet::frame(slot, &dice.pairs(), slot % 2 == 0);
        if slot % 2 == 0 {
            pair.order(0, packet.in_step());
        } else {
            pair.order(0, packet);
            pair.order(0, Packet::play(slot, slot, 1, 0, false).in_step());
        }
        pair.run(3);
        let [leader, follower] = change(&pair, slot);
        assert!(leader.abs_diff(follower) <= 1, "slot {slot} at {leader} and {follower}");
    }
    assert!(pair.twins.iter().all(|twin| twin.sounding > 100));
}

#[test]
fn frames_in_step_change_in_the_same_period_with_5_phase_bits() {
    in_step(5, Second::OwnLine(777));
}

#[test]
fn frames_in_step_change_in_the_same_period_with_7_phase_bits() {
    in_step(7, Second::OwnLine(20_513));
    in_step(7, Second::SharedLine(1023));
}

#[test]
fn devices_on_a_line_heed_their_address_and_broadcasts() {
    let Some(mut pair) = Pair::start(7, Second::SharedLine(300)) else { return };
    pair.lock();
    pair.order(0, Packet::phases(1, 255, &[9; 256], true));
    pair.order(1, Packet::phases(2, 255, &[70; 256], true));
    pair.send(0, Packet::enable(1000).to(BROADCAST));
    pair.settle();
    pair.run(40);
    let answers = pair.twins.each_ref().map(|twin| twin.answers.len());
    assert_eq!(answers, [1, 1], "a broadcast is not answered");
    assert!(pair.twins.iter().all(|twin| twin.sounding > 10));
    // A flood of packets to one does not affect the other.
    for _ in 0..8 {
        pair.send(0, Packet::frame(3, &[[1, 2]; 256], false));
        pair.send(0, Packet::status().to(5));
    }
    pair.settle();
    // Both count a corrupted packet, and the first answers.
    let mut line = Packet::status().to_line();
    line[3] ^= 0x40;
    pair.simulated.about(0);
    pair.simulated.send(&line);
    pair.run(40);
    assert_eq!(pair.twins[0].spoiled, 1);
    assert_eq!(pair.twins[1].model.spoil(false), None);
    pair.order(0, Packet::status());
    pair.order(1, Packet::status());
}

/// Random requests to two devices: every period of both agrees with the models.
fn random_session(phase_bits: u8, second: Second, periods: u32) {
    let Some(mut pair) = Pair::start(phase_bits, second) else { return };
    let mut dice = Dice::seeded(100 + u64::from(phase_bits));
    pair.lock();
    while pair.twins[0].periods < periods {
        let device = dice.below(2) as usize;
        // A packet for both must find room in both.
        if pair.unanswered() < WINDOW {
            let packet = dice.packet_about(device as u8);
            pair.send(device, packet);
        }
        pair.run(1 + dice.below(30) as u32);
    }
    pair.settle();
    let sounding = pair.twins.each_ref().map(|twin| twin.sounding);
    assert!(sounding.iter().all(|&sounding| sounding > 100), "{sounding:?} of {periods} periods sound");
    let stepped = |twin: &Twin| twin.answers.iter().any(|reply| reply.flags.waiting);
    assert!(pair.twins.iter().all(stepped));
}

#[test]
fn both_devices_agree_with_the_models_with_5_phase_bits() {
    random_session(5, Second::OwnLine(31_337), 3000);
}

#[test]
fn both_devices_agree_with_the_models_with_7_phase_bits() {
    random_session(7, Second::SharedLine(4242), 4000);
}
