//! The serial line: clock deviations, rate changes, and damaged bytes.

use sonoglyph::device::native::packet::{Body, Outcome, Packet};

use crate::dice::Dice;
use crate::gateware::twins::{Twins, WINDOW};

#[test]
fn a_host_with_a_clock_4_percent_off_is_understood() {
    for error in [-0.04, -0.02, 0.02, 0.04] {
        let Some(mut twins) = Twins::start(7) else { return };
        twins.simulated.baud(2e6 * (1.0 + error));
        let mut dice = Dice::seeded(4);
        for _ in 0..8 {
            twins.order(Packet::frame(1 + dice.below(60) as u8, &dice.pairs(), false));
        }
        let Body::Status(status) = twins.ask(Packet::status()).body else { panic!() };
        assert_eq!((status.spoiled, status.good), (0, 9), "{error}");
    }
}

#[test]
fn frames_without_pause_are_all_taken_at_8_megabaud() {
    for error in [-0.02, 0.0, 0.02] {
        let Some(mut twins) = Twins::start(7) else { return };
        let Body::Info(info) = twins.ask(Packet::info()).body else { panic!() };
        assert_eq!(info.largest_baud, 80);
        twins.order(Packet::baud(12_800));
        twins.simulated.baud(8e6 * (1.0 + error));
        let mut dice = Dice::seeded(8);
        // Far more than wait in the device: it is done with each before the next has arrived.
        (0..60)
            .for_each(|number| twins.send(Packet::phases(1 + number, 255, &dice.bytes(), number % 5 == 0)));
        twins.settle();
        let Body::Status(status) = twins.ask(Packet::status()).body else { panic!() };
        assert_eq!((status.spoiled, status.good), (0, 63), "{error}");
    }
}

#[test]
fn a_host_at_another_rate_does_no_harm() {
    let Some(mut twins) = Twins::start(7) else { return };
    twins.simulated.baud(1.4e6);
    let mut dice = Dice::seeded(5);
    for _ in 0..10 {
        twins.simulated.send(&Packet::frame(1, &dice.pairs(), true).to_line());
    }
    // No packet passes the gate (the twins compare that), and answers cannot be read at this rate.
    for period in twins.simulated.run(2000) {
        assert_eq!((period.gate, period.outputs_on), (None, false));
    }
}

#[test]
fn the_rate_changes_after_the_answer() {
    let Some(mut twins) = Twins::start(7) else { return };
    // From 640 kbaud to 10.24 Mbaud, the fastest rate of the device.
    for increment in [1024, 4800, 6400, 16_384] {
        twins.order(Packet::baud(increment));
        twins.simulated.baud(twins.twin.model.baud());
        twins.run(3);
        twins.order(Packet::frame(1, &[[3, 4]; 256], false));
    }
    // A full window of short packets at once: none is lost, although they arrive faster than periods.
    for _ in 0..20 {
        (0..WINDOW).for_each(|_| twins.send(Packet::status()));
        twins.settle();
    }
    assert_eq!(twins.twin.answers.len(), 8 + 20 * WINDOW);
    assert_eq!(twins.ask(Packet::baud(63)).outcome, Outcome::Argument);
    assert_eq!(twins.ask(Packet::baud(16_385)).outcome, Outcome::Argument);
}

#[test]
fn the_rate_falls_back_after_a_time_without_valid_packets() {
    let Some(mut twins) = Twins::start(5) else { return };
    twins.order(Packet::baud(6400));
    twins.simulated.baud(twins.twin.model.baud());
    twins.order(Packet::status());
    // Invalid bytes do not delay the fallback.
    for _ in 0..32 {
        assert_eq!(twins.twin.model.baud(), 4e6);
        twins.simulated.send(&[1, 2, 3, 0]);
        twins.run(1024);
    }
    assert_eq!(twins.twin.model.baud(), 2e6);
    twins.simulated.baud(2e6);
    twins.order(Packet::info());
}

/// Damages a line, but keeps its last delimiter.
fn damaged(dice: &mut Dice, line: &[u8]) -> Vec<u8> {
    let mut bytes = line.to_vec();
    let at = dice.below(line.len() as u64 - 1) as usize;
    match dice.below(4) {
        0 => drop(bytes.remove(at)),
        1 => bytes[at] ^= 1 << dice.below(8),
        2 => bytes.insert(at, dice.byte()),
        _ => {
            let end = (at + 1 + dice.below(40) as usize).min(line.len() - 1);
            bytes[at..end].iter_mut().for_each(|byte| *byte = dice.byte());
        }
    }
    bytes
}

#[test]
fn a_damaged_frame_is_never_played_and_the_next_one_is() {
    let Some(mut twins) = Twins::start(7) else { return };
    let mut dice = Dice::seeded(6);
    twins.order(Packet::silencer(0xFFFF, 0xFFFF));
    twins.order(Packet::enable(1000));
    for round in 0..40 {
        let slot = 1 + round % 2;
        twins.order(Packet::frame(slot, &dice.pairs(), true));
        // The model does not receive this frame and keeps the previous one.
        let broken = twins.twin.numbered(Packet::frame(3 - slot, &dice.pairs(), true));
        let bytes = damaged(&mut dice, &broken.to_line());
        if bytes == broken.to_line() {
            continue;
        }
        let before = twins.twin.spoiled;
        twins.simulated.send(&bytes);
        twins.run(130);
        assert!(twins.twin.spoiled > before, "a damaged frame is not reported");
    }
    // Also line noise: the host sends at far too low a rate for a moment.
    twins.simulated.baud(150e3);
    twins.simulated.send(&[0x55, 0x00]);
    twins.run(20);
    twins.simulated.baud(2e6);
    twins.simulated.send(&[0]);
    twins.run(20);
    let Body::Status(status) = twins.ask(Packet::status()).body else { panic!() };
    assert!(status.framing_errors > 0 && status.spoiled == twins.twin.spoiled, "{status:?}");
}
