//! Pulses: every period of random sessions, and the safety functions.

use sonoglyph::device::native::model::Pulse;
use sonoglyph::device::native::packet::{Body, Outcome, Packet, Table};
use strum::VariantArray;

use crate::dice::Dice;
use crate::gateware::twins::{Twins, WINDOW};

/// Thousands of periods of random requests, with occasional presses of the emergency stop.
fn random_session(phase_bits: u8, periods: u32) {
    let Some(mut twins) = Twins::start(phase_bits) else { return };
    let mut dice = Dice::seeded(u64::from(phase_bits));
    // 5 Mbaud: at half this rate, half of the periods would pass without a new packet.
    let increment = if phase_bits == 8 { 4096 } else { 8192 };
    twins.order(Packet::baud(increment));
    twins.simulated.baud(twins.twin.model.baud());
    let mut pressed = false;
    while twins.twin.periods < periods {
        if twins.twin.unanswered() < WINDOW {
            twins.send(dice.packet_about(0));
        }
        match dice.below(300) {
            0 => twins.introduce(),
            1 => begin_anew(&mut twins),
            _ => {}
        }
        if dice.below(20) == 0 {
            twins.trigger();
        }
        if dice.below(if pressed { 4 } else { 60 }) == 0 {
            pressed = !pressed;
            twins.press(pressed);
        }
        twins.run(1 + dice.below(30) as u32);
    }
    twins.settle();
    // The session must have exercised the device.
    assert!(
        4 * twins.twin.sounding > twins.twin.periods,
        "{} of {} periods sound",
        twins.twin.sounding,
        twins.twin.periods
    );
    for &outcome in Outcome::VARIANTS {
        let count = twins.twin.answers.iter().filter(|reply| reply.outcome == outcome).count();
        assert_eq!(count > 0, outcome != Outcome::Crc, "{count} times {outcome:?}");
    }
    assert!(
        twins.twin.answers.iter().any(|reply| reply.flags.tripped)
            && twins.twin.answers.iter().any(|reply| reply.flags.playing)
            && !twins.twin.triggers.is_empty()
    );
}

/// Sends RESET once all is silent, and compares the remaining state by its digests.
fn begin_anew(twins: &mut Twins) {
    twins.settle();
    twins.order(Packet::mute());
    twins.run(260);
    twins.order(Packet::reset());
    for table in [Table::Slot(1), Table::Slot(63), Table::Envelope, Table::Widths, Table::Calibration] {
        twins.order(Packet::digest(table));
    }
}

#[test]
fn all_256_outputs_agree_with_the_model_with_5_phase_bits() {
    random_session(5, 5000);
}

#[test]
fn all_256_outputs_agree_with_the_model_with_6_phase_bits() {
    random_session(6, 5000);
}

#[test]
fn all_256_outputs_agree_with_the_model_with_7_phase_bits() {
    random_session(7, 8000);
}

#[test]
fn all_256_outputs_agree_with_the_model_with_8_phase_bits() {
    random_session(8, 5000);
}

/// All elements at full amplitude, in slot 1.
fn loud() -> Packet {
    Packet::phases(1, 255, &std::array::from_fn(|n| n as u8), true)
}

#[test]
fn outputs_are_silent_before_enable_and_a_frame() {
    let Some(mut twins) = Twins::start(7) else { return };
    for period in twins.simulated.run(300) {
        twins.twin.model.period();
        assert!(!period.outputs_on && period.received.is_empty());
        assert!(period.pulses.iter().all(|&pulse| pulse == Pulse::default()));
    }
    twins.order(loud());
    twins.run(50);
    assert_eq!(twins.twin.sounding, 0);
    twins.order(Packet::enable(100));
    twins.run(60);
    assert!(twins.twin.sounding > 50);
    assert!(twins.twin.model.played().iter().all(|pulse| pulse.width == 64));
}

#[test]
fn the_watchdog_ramps_down_and_stays_until_enable() {
    let Some(mut twins) = Twins::start(7) else { return };
    twins.order(Packet::silencer(0x0300, 0x0001));
    twins.order(loud());
    twins.order(Packet::silencer(0x0300, 0xFFFF));
    twins.order(Packet::enable(2));
    twins.order(Packet::silencer(0x0300, 0x0001));
    twins.run(100);
    assert!(twins.twin.model.outputs_on() && twins.twin.sounding > 100);
    // It trips 128 periods after the last packet; amplitudes fall by at least 0x100 per period, whatever the silencer.
    let before = twins.twin.sounding;
    twins.run(300);
    assert!(!twins.twin.model.outputs_on());
    assert!((250..290).contains(&(twins.twin.sounding - before)), "{}", twins.twin.sounding - before);
    let silent = twins.twin.sounding;
    twins.order(Packet::frame(2, &[[7, 255]; 256], true));
    twins.order(Packet::status());
    assert!(twins.twin.answers.last().unwrap().flags.tripped);
    twins.run(100);
    assert_eq!(twins.twin.sounding, silent);
    twins.order(Packet::enable(50));
    assert!(!twins.twin.answers.last().unwrap().flags.tripped);
    twins.order(Packet::silencer(0x0300, 0x0600));
    twins.run(100);
    assert!(twins.twin.sounding > silent + 90);
}

#[test]
fn the_emergency_stop_is_immediate_and_lasts_until_enable() {
    let Some(mut twins) = Twins::start(6) else { return };
    twins.order(loud());
    twins.order(Packet::enable(1000));
    twins.run(100);
    assert!(twins.twin.model.outputs_on());
    twins.press(true);
    twins.run(1);
    assert!(!twins.twin.model.outputs_on());
    assert_eq!(twins.ask(Packet::enable(1000)).outcome, Outcome::State);
    let silent = twins.twin.sounding;
    twins.run(300);
    twins.press(false);
    twins.run(300);
    assert_eq!(twins.twin.sounding, silent);
    twins.order(Packet::enable(1000));
    twins.run(100);
    assert!(twins.twin.sounding > silent + 90);
}

#[test]
fn a_sequence_changes_slots_exactly_at_its_periods() {
    let Some(mut twins) = Twins::start(7) else { return };
    twins.order(Packet::silencer(0xFFFF, 0xFFFF));
    twins.order(Packet::enable(1000));
    for slot in 1..=5 {
        twins.order(Packet::phases(slot, 255, &[slot * 32; 256], false));
    }
    twins.order(Packet::play(1, 5, 3, 0, false));
    let rises: Vec<_> = (0..60)
        .map(|_| {
            twins.run(1);
            twins.twin.model.played()[17].rise
        })
        .collect();
    // A pulse of half a period around slot · 32 / 256 of 128 levels.
    let expected: Vec<_> =
        (0..60).map(|period| 16 * (period / 3 % 5) as u8).map(|middle| (middle + 112) % 128).collect();
    let start = (0..15).find(|&start| (0..45).all(|i| rises[start + i] == expected[i]));
    assert!(start.is_some(), "{rises:?}");
}

#[test]
fn a_trigger_starts_a_motion_and_each_cycle_triggers() {
    let Some(mut twins) = Twins::start(7) else { return };
    twins.order(Packet::silencer(0xFFFF, 0xFFFF));
    twins.order(Packet::enable(1000));
    for slot in 1..=5 {
        twins.order(Packet::phases(slot, 255, &[slot * 32; 256], false));
    }
    let reply = twins.ask(Packet::play(1, 5, 3, 0, false).at_trigger());
    assert!(reply.flags.waiting && !reply.flags.playing, "{reply:?}");
    twins.run(200);
    assert!(twins.twin.model.slot() == 0 && twins.twin.triggers.is_empty());
    let edge = twins.twin.periods;
    twins.trigger();
    twins.run(60);
    // The slots change at the boundary after the edge, and are played a period later.
    let cycles: Vec<_> = (0..4).map(|cycle| edge + 1 + 15 * cycle).collect();
    assert_eq!(twins.twin.triggers, cycles);
    // A steady frame has no cycle but that of its modulation.
    twins.order(Packet::phases(6, 255, &[0; 256], true));
    twins.run(3);
    twins.twin.triggers.clear();
    twins.run(300);
    assert!(twins.twin.triggers.is_empty());
    twins.order(Packet::rate(1 << 17, true));
    twins.run(600);
    assert!(twins.twin.triggers.windows(2).all(|pair| pair[1] - pair[0] == 128));
    assert_eq!(twins.twin.triggers.len(), 5, "{:?}", twins.twin.triggers);
}

#[test]
fn all_of_256_slots_are_stored_and_played() {
    let Some(mut twins) = Twins::start_with_256_slots() else { return };
    let Body::Info(info) = twins.ask(Packet::info()).body else { panic!() };
    assert_eq!(info.slots, 256);
    let mut dice = Dice::seeded(9);
    twins.order(Packet::silencer(0xFFFF, 0xFFFF));
    twins.order(Packet::enable(1000));
    for slot in (1..=255).rev() {
        twins.order(Packet::frame(slot, &dice.pairs(), false));
    }
    twins.order(Packet::digest(Table::Slot(255)));
    twins.order(Packet::play(0, 255, 1, 1, false));
    twins.run(300);
    assert_eq!(twins.twin.model.slot(), 255);
    begin_anew(&mut twins);
    twins.order(Packet::digest(Table::Slot(255)));
}

#[test]
fn modulation_repeats_at_its_frequency() {
    let Some(mut twins) = Twins::start(7) else { return };
    let sine: [u8; 256] = std::array::from_fn(|i| {
        (127.5 - 127.5 * (std::f64::consts::TAU * i as f64 / 256.0).cos()).round() as u8
    });
    twins.order(Packet::silencer(0xFFFF, 0xFFFF));
    twins.order(Packet::envelope(&sine));
    twins.order(loud());
    twins.order(Packet::enable(1000));
    // 200 Hz at 40 kHz: 200 periods each.
    twins.order(Packet::rate((200.0_f64 / 40_000.0 * f64::from(1 << 24)).round() as u32, true));
    let widths: Vec<_> = (0..1000)
        .map(|_| {
            twins.run(1);
            twins.twin.model.played()[0].width
        })
        .collect();
    let middles: Vec<_> = (1..1000).filter(|&i| widths[i - 1] < 30 && widths[i] >= 30).collect();
    assert!((4..=5).contains(&middles.len()), "{middles:?}");
    assert!(middles.windows(2).all(|pair| (199..=201).contains(&(pair[1] - pair[0]))), "{middles:?}");
    assert_eq!((widths.iter().min(), widths.iter().max()), (Some(&0), Some(&64)));
}
