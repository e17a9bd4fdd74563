//! The model of the native device: its output and its safety. `tests/device/gateware` compares the Verilog with it.

use sonoglyph::device::native::line;
use sonoglyph::device::native::model::{Model, Pulse};
use sonoglyph::device::native::packet::{BROADCAST, Body, Info, Kind, Outcome, Packet, Reply, Status, Table};

/// Applies a packet that must succeed.
pub fn apply(model: &mut Model, packet: &Packet) -> Reply {
    let reply = model.apply(packet);
    assert_eq!(reply.outcome, Outcome::Ok, "{packet:?}");
    reply
}

pub fn run(model: &mut Model, periods: u32) {
    (0..periods).for_each(|_| {
        model.period();
    });
}

fn status(model: &mut Model) -> (Reply, Status) {
    let reply = apply(model, &Packet::status());
    let Body::Status(status) = reply.body else { panic!("{reply:?}") };
    (reply, status)
}

/// Without silencer, one frame at full amplitude in slot 1.
pub fn playing(phase_bits: u8, phases: &[u8; 256]) -> Model {
    let mut model = Model::new(phase_bits);
    apply(&mut model, &Packet::silencer(0xFFFF, 0xFFFF));
    apply(&mut model, &Packet::enable(1000));
    apply(&mut model, &Packet::phases(1, 255, phases, true));
    run(&mut model, 2);
    model
}

pub fn ramp() -> [u8; 256] {
    std::array::from_fn(|n| n as u8)
}

#[test]
fn power_up_is_silent_until_enabled_with_a_frame() {
    let mut model = Model::new(7);
    let silent =
        |model: &mut Model| (0..300).all(|_| model.period().iter().all(|pulse| *pulse == Pulse::default()));
    assert!(silent(&mut model) && !model.outputs_on());
    apply(&mut model, &Packet::phases(1, 255, &ramp(), true));
    assert!(silent(&mut model) && !model.outputs_on(), "a frame alone");
    let mut model = Model::new(7);
    apply(&mut model, &Packet::enable(100));
    assert!(silent(&mut model), "ENABLE alone");
    assert!(model.outputs_on());
}

#[test]
fn a_pulse_is_half_a_period_around_its_delay() {
    for phase_bits in 5..=8 {
        let levels = i32::from(Model::new(phase_bits).levels());
        let mut model = playing(phase_bits, &ramp());
        for (phase, pulse) in model.period().iter().enumerate() {
            assert_eq!(i32::from(pulse.width), levels / 2);
            // The centre of the pulse, in half levels, against the delay.
            let middle = 2 * i32::from(pulse.rise) + i32::from(pulse.width);
            let wanted = 2 * levels * i32::try_from(phase).unwrap() / 256;
            let off = (middle - wanted + levels).rem_euclid(2 * levels) - levels;
            assert!(off.abs() <= 1, "{phase_bits} bits: phase {phase} in {pulse:?}");
        }
    }
}

#[test]
fn pulses_of_any_width_are_centred_to_half_a_level() {
    for phase_bits in 5..=8 {
        let mut model = playing(phase_bits, &[0; 256]);
        let (level, mut slot) = (256 >> phase_bits, 1);
        for amplitude in 1..=255 {
            slot = 3 - slot;
            apply(&mut model, &Packet::phases(slot, amplitude, &ramp(), true));
            run(&mut model, 2);
            for (phase, pulse) in model.played().iter().enumerate().filter(|(_, pulse)| pulse.width > 0) {
                // In 1/512 period.
                let centre = level * (2 * i32::from(pulse.rise) + i32::from(pulse.width));
                let off = (centre - 2 * phase as i32 + 256).rem_euclid(512) - 256;
                assert!(off.abs() <= level, "{phase_bits} bits: phase {phase}, {amplitude}: {pulse:?}");
            }
        }
    }
}

#[test]
fn amplitude_is_the_sine_of_the_width_up_to_half_a_period() {
    let mut model = Model::new(8);
    apply(&mut model, &Packet::silencer(0xFFFF, 0xFFFF));
    apply(&mut model, &Packet::enable(1000));
    let pairs = std::array::from_fn(|n| [0, n as u8]);
    apply(&mut model, &Packet::frame(1, &pairs, true));
    run(&mut model, 3);
    for (amplitude, pulse) in model.played().iter().enumerate() {
        let made = (std::f64::consts::PI * f64::from(pulse.width) / 256.0).sin();
        assert!((made - amplitude as f64 / 255.0).abs() < 0.01, "{amplitude} as {pulse:?}");
    }
    apply(&mut model, &Packet::widths(&[255; 256]));
    run(&mut model, 2);
    let played = model.played();
    assert!(played[1..].iter().all(|pulse| pulse.width == 128), "the duty cycle is capped for any table");
    assert_eq!(played[0].width, 0, "and amplitude 0 is silent");
}

#[test]
fn widths_are_rounded_to_levels() {
    for phase_bits in 5..=8 {
        let mut model = playing(phase_bits, &[0; 256]);
        apply(&mut model, &Packet::widths(&ramp().map(|n| n / 2)));
        let pairs = std::array::from_fn(|n| [0, n as u8]);
        apply(&mut model, &Packet::frame(2, &pairs, true));
        run(&mut model, 2);
        for (n, pulse) in model.played().iter().enumerate() {
            let wanted = f64::from(model.levels()) * (n / 2) as f64 / 256.0;
            assert_eq!(f64::from(pulse.width), wanted.round(), "{phase_bits} bits: {n}");
        }
    }
}

#[test]
fn a_commit_takes_effect_as_a_whole_at_the_next_sweep() {
    let mut model = playing(8, &[0; 256]);
    let before = *model.period();
    apply(&mut model, &Packet::phases(2, 255, &[128; 256], true));
    assert_eq!(*model.period(), before, "swept before the packet");
    let after = *model.period();
    assert!(after.iter().all(|pulse| *pulse == after[0]) && after != before);
}

#[test]
fn frames_with_commit_commit() {
    let phases = |commit| Packet::phases(1, 255, &ramp(), commit);
    assert!(phases(true).commits() && !phases(false).commits());
    assert!(phases(false).in_step().commits());
    let pairs = [[1, 2]; 256];
    assert!(Packet::frame(1, &pairs, true).commits() && !Packet::frame(1, &pairs, false).commits());
    assert!(!Packet::play(3, 5, 2, 2, true).commits() && !Packet::stop().commits());
}

#[test]
fn a_sounding_device_is_not_reset() {
    let reset = Packet::reset();
    let mut model = Model::new(7);
    apply(&mut model, &Packet::enable(1000));
    assert_eq!(model.apply(&reset).outcome, Outcome::State, "enabled, without a frame");
    let mut model = playing(7, &ramp());
    apply(&mut model, &Packet::silencer(0x0300, 0x0100));
    apply(&mut model, &Packet::mute());
    run(&mut model, 2);
    assert!(model.outputs_on());
    assert_eq!(model.apply(&reset).outcome, Outcome::State, "on the way to silence");
    run(&mut model, 1000);
    assert!(!model.outputs_on());
    apply(&mut model, &reset);
}

#[test]
fn slots_in_play_cannot_be_written() {
    let mut model = playing(7, &ramp());
    let busy = |model: &mut Model, slot| model.apply(&Packet::phases(slot, 9, &[1; 256], false)).outcome;
    assert_eq!(busy(&mut model, 1), Outcome::Busy);
    apply(&mut model, &Packet::play(3, 6, 10, 0, false));
    assert_eq!(busy(&mut model, 5), Outcome::Busy, "waits");
    model.period();
    assert_eq!((busy(&mut model, 6), busy(&mut model, 1)), (Outcome::Busy, Outcome::Ok));
    apply(&mut model, &Packet::play(10, 11, 1, 0, true));
    assert_eq!(busy(&mut model, 11), Outcome::Busy);
    apply(&mut model, &Packet::stop());
    assert_eq!((busy(&mut model, 3), busy(&mut model, 4)), (Outcome::Busy, Outcome::Ok), "still plays 3");
}

#[test]
fn slots_are_played_for_their_periods_and_loops() {
    let mut model = playing(7, &ramp());
    apply(&mut model, &Packet::play(3, 5, 2, 2, false));
    let mut slots = Vec::new();
    for _ in 0..15 {
        model.period();
        slots.push(status(&mut model).1.slot);
        assert_eq!(slots.last(), Some(&model.slot()));
        if slots.len() == 4 {
            apply(&mut model, &Packet::play(8, 8, 1, 0, true));
        }
    }
    assert_eq!(
        slots,
        [3, 3, 4, 4, 5, 5, 8, 8, 8, 8, 8, 8, 8, 8, 8],
        "a waiting PLAY starts at the end of the loop"
    );
    let mut model = playing(7, &ramp());
    apply(&mut model, &Packet::play(3, 4, 1, 2, false));
    let mut slots = Vec::new();
    for _ in 0..6 {
        model.period();
        slots.push(status(&mut model).1.slot);
    }
    assert_eq!(slots, [3, 4, 3, 4, 4, 4]);
}

#[test]
fn a_silent_sender_mutes_by_a_ramp_and_latches() {
    let mut model = playing(7, &ramp());
    apply(&mut model, &Packet::silencer(0x0300, 0x0100));
    apply(&mut model, &Packet::enable(2));
    run(&mut model, 127);
    assert!(model.outputs_on() && model.period()[0].width == 64);
    run(&mut model, 10);
    let width = model.period()[0].width;
    assert!(model.outputs_on() && width > 30 && width < 64, "ramps: {width}");
    run(&mut model, 260);
    assert!(!model.outputs_on());
    assert!(status(&mut model).0.flags.tripped);
    apply(&mut model, &Packet::phases(2, 255, &ramp(), true));
    run(&mut model, 300);
    assert!(!model.outputs_on(), "only ENABLE switches on again");
    apply(&mut model, &Packet::enable(100));
    run(&mut model, 300);
    assert!(model.outputs_on() && !status(&mut model).0.flags.tripped);
}

#[test]
fn a_device_without_a_watchdog_sounds_on_if_that_is_confirmed() {
    let mut model = playing(7, &ramp());
    apply(&mut model, &Packet::new(Kind::Enable, [0, 0, 0x5A, 0], vec![]));
    run(&mut model, 1000);
    assert!(model.outputs_on() && status(&mut model).0.flags.enabled);
}

#[test]
fn the_emergency_stop_is_immediate_and_prevents_enable() {
    let mut model = playing(7, &ramp());
    model.press(true);
    model.press(false);
    let (reply, _) = status(&mut model);
    assert!(reply.flags.stopped && reply.flags.tripped && !reply.flags.enabled && !model.outputs_on());
    model.press(true);
    run(&mut model, 300);
    assert_eq!(model.apply(&Packet::enable(10)).outcome, Outcome::State);
    model.press(false);
    run(&mut model, 2);
    let (reply, _) = status(&mut model);
    assert!(reply.flags.stopped && !reply.flags.emergency_stop && !model.outputs_on());
    apply(&mut model, &Packet::enable(1000));
    run(&mut model, 2);
    assert!(model.outputs_on() && !status(&mut model).0.flags.stopped);
}

#[test]
fn reset_is_refused_until_the_last_period_of_sound_is_over() {
    for periods in 0..5 {
        let mut model = playing(7, &ramp());
        apply(&mut model, &Packet::mute());
        run(&mut model, periods);
        let mut next = model.clone();
        next.period();
        let sounds = model.outputs_on() || next.outputs_on();
        let refused = model.apply(&Packet::reset()).outcome == Outcome::State;
        assert_eq!(refused, sounds, "{periods} periods after MUTE");
    }
}

#[test]
fn reset_is_refused_during_sound_and_clears_all_but_the_line() {
    let mut model = playing(7, &ramp());
    apply(&mut model, &Packet::baud(4800));
    apply(&mut model, &Packet::silencer(1, 0x0100));
    apply(&mut model, &Packet::widths(&[9; 256]));
    assert_eq!(model.apply(&Packet::reset()).outcome, Outcome::State);
    // The stop silences at once, but the silencer ramps down at its own rate.
    model.press(true);
    run(&mut model, 250);
    assert_eq!((model.apply(&Packet::reset()).outcome, model.outputs_on()), (Outcome::State, false));
    run(&mut model, 10);
    let (rate, before) = (model.baud(), status(&mut model).1);
    let pressed = apply(&mut model, &Packet::reset());
    assert!(pressed.flags.stopped && pressed.flags.tripped);
    model.press(false);
    let after = apply(&mut model, &Packet::reset());
    assert!(!after.flags.stopped && !after.flags.tripped);
    let Body::Status(counts) = after.body else { panic!() };
    assert_eq!((counts.slot, counts.good, counts.periods), (0, before.good + 2, before.periods));
    assert_eq!(model.baud(), rate);
    // The tables are those of a device after power-up.
    let mut fresh = Model::new(7);
    for table in [Table::Slot(0), Table::Slot(1), Table::Envelope, Table::Widths, Table::Calibration] {
        assert_eq!(digest(&mut model, table), digest(&mut fresh, table), "{table:?}");
    }
    apply(&mut model, &Packet::enable(1000));
    apply(&mut fresh, &Packet::enable(1000));
    for device in [&mut model, &mut fresh] {
        apply(device, &Packet::frame(3, &[[200, 99]; 256], true));
    }
    (0..100).for_each(|_| assert_eq!(model.period(), fresh.period()));
}

fn digest(model: &mut Model, table: Table) -> u32 {
    let Body::Digest(digest) = apply(model, &Packet::digest(table)).body else { panic!("{table:?}") };
    digest.crc
}

#[test]
fn a_digest_is_the_crc_of_the_packets_payload() {
    let mut model = Model::new(7);
    let pairs: [[u8; 2]; 256] = std::array::from_fn(|n| [n as u8, 255 - n as u8]);
    let packets = [
        (Packet::frame(9, &pairs, false), Table::Slot(9)),
        (Packet::envelope(&ramp()), Table::Envelope),
        (Packet::widths(&ramp().map(|n| n / 2)), Table::Widths),
        (Packet::calibration(&pairs), Table::Calibration),
    ];
    // Values of the protocol's document.
    let power_up = [0xB2AA_7578, 0xFEA8_A821, 0xAF04_75A1, 0x1B6E_50DD];
    for ((packet, table), fresh) in packets.into_iter().zip(power_up) {
        assert_eq!(digest(&mut model, table), fresh, "{table:?}");
        apply(&mut model, &packet);
        assert_eq!(digest(&mut model, table), line::digest(&packet.payload), "{table:?}");
    }
    apply(&mut model, &Packet::phases(9, 7, &ramp(), false));
    let pairs: Vec<_> = ramp().into_iter().flat_map(|phase| [phase, 7]).collect();
    assert_eq!(digest(&mut model, Table::Slot(9)), line::digest(&pairs));
}

#[test]
fn a_device_heeds_its_address_and_broadcasts() {
    let mut model = Model::new(7).with_address(3);
    for other in [0, 2, 4, 8, 254] {
        assert_eq!(model.hear(&Packet::enable(10).to(other)), None);
    }
    // A reply is not a command.
    for code in [0x80, 0x83] {
        assert_eq!(model.hear(&Packet { code, ..Packet::status().to(3) }), None, "{code:#x}");
    }
    let reply = model.hear(&Packet::status().to(3)).unwrap();
    let Body::Status(counts) = reply.body else { panic!() };
    assert_eq!((reply.address, counts.good, reply.flags.enabled), (3, 1, false));
    assert_eq!(model.hear(&Packet::enable(10).to(BROADCAST)), None);
    assert!(model.hear(&Packet::status().to(3)).unwrap().flags.enabled);
    assert_eq!(model.spoil(false), None, "a corrupted packet's address is unknown");
    let Body::Status(counts) = model.hear(&Packet::status().to(3)).unwrap().body else { panic!() };
    assert_eq!((counts.good, counts.spoiled), (4, 1));
}

#[test]
fn packets_in_step_wait_for_the_leaders_mark() {
    let slot = |model: &mut Model| status(model).1.slot;
    let mut leader = playing(7, &ramp());
    assert!(!leader.marks());
    apply(&mut leader, &Packet::play(4, 4, 1, 0, false).in_step());
    leader.period();
    assert_eq!((leader.marks(), slot(&mut leader)), (true, 4));
    leader.period();
    assert!(!leader.marks());
    let mut follower = playing(7, &ramp());
    follower.follow(true);
    apply(&mut follower, &Packet::play(2, 3, 1, 1, false));
    apply(&mut follower, &Packet::phases(5, 9, &ramp(), true).in_step());
    run(&mut follower, 10);
    assert!(slot(&mut follower) == 1 && status(&mut follower).0.flags.waiting && !follower.marks());
    follower.mark();
    follower.period();
    assert_eq!((follower.marks(), slot(&mut follower)), (false, 5));
    // A mark without a waiting packet is forgotten; a device that becomes a leader no longer waits.
    follower.mark();
    follower.period();
    apply(&mut follower, &Packet::phases(6, 9, &ramp(), true).in_step());
    follower.period();
    assert_eq!(slot(&mut follower), 5);
    follower.follow(false);
    follower.period();
    assert_eq!((follower.marks(), slot(&mut follower)), (true, 6));
}

#[test]
fn modulation_follows_its_table_at_its_rate() {
    let mut model = playing(8, &[0; 256]);
    let table = std::array::from_fn(|n| if n < 128 { 255 } else { 0 });
    apply(&mut model, &Packet::envelope(&table));
    // 200 Hz at 40 kHz: 200 periods.
    apply(&mut model, &Packet::rate((1 << 24) / 200, true));
    model.period();
    let on = (0..2000).filter(|_| model.period()[0].width > 0).count();
    assert!((999..=1001).contains(&on), "{on}");
}

#[test]
fn a_rate_restarts_the_envelope_if_asked_to() {
    let mut model = playing(8, &[0; 256]);
    let table = std::array::from_fn(|n| if n < 128 { 255 } else { 0 });
    apply(&mut model, &Packet::envelope(&table));
    // A step of the table per period.
    for (restart, periods, width) in [(true, 150, 0), (false, 2, 0), (true, 2, 128)] {
        apply(&mut model, &Packet::rate(1 << 16, restart));
        run(&mut model, periods);
        assert_eq!(model.played()[0].width, width, "{restart}");
    }
}

#[test]
fn calibration_shifts_and_attenuates_its_channel() {
    let mut model = playing(8, &[10; 256]);
    let mut pairs = [[0, 255]; 256];
    pairs[7] = [64, 127];
    pairs[8] = [0, 0];
    apply(&mut model, &Packet::calibration(&pairs));
    run(&mut model, 2);
    let played = model.played();
    let middle = |pulse: Pulse| (u16::from(pulse.rise) * 2 + u16::from(pulse.width)) % 512;
    assert_eq!(middle(played[7]).abs_diff(middle(played[0])) / 2, 64);
    assert!((f64::from(played[7].width) - 256.0 / 6.0).abs() < 1.5, "half the amplitude: {:?}", played[7]);
    assert_eq!(played[8].width, 0);
}

#[test]
fn refusals_change_nothing() {
    let mut model = playing(7, &ramp());
    let before = *model.period();
    let refused = [
        (Packet { code: 0x77, address: 0, seq: 3, arguments: [0; 4], payload: vec![] }, Outcome::Unknown),
        (Packet { payload: vec![1; 255], ..Packet::envelope(&[0; 256]) }, Outcome::Length),
        (Packet::new(Kind::Enable, [0; 4], vec![]), Outcome::Argument),
        (Packet::silencer(0, 1), Outcome::Argument),
        (Packet::baud(63), Outcome::Argument),
        (Packet::baud(16_385), Outcome::Argument),
        (Packet::play(5, 4, 1, 0, false), Outcome::Argument),
        (Packet::play(5, 64, 1, 0, false), Outcome::Argument),
        (Packet::play(5, 6, 0, 0, false), Outcome::Argument),
        (Packet { payload: vec![0, 0, 4], ..Packet::play(5, 6, 1, 0, false) }, Outcome::Argument),
        (Packet::digest(Table::Slot(64)), Outcome::Argument),
        (Packet::new(Kind::Digest, [4, 0, 0, 0], vec![]), Outcome::Argument),
        (Packet::reset(), Outcome::State),
        (Packet::phases(64, 1, &ramp(), true), Outcome::Argument),
    ];
    for (packet, outcome) in refused {
        let reply = model.apply(&packet.clone().numbered(9));
        assert_eq!((reply.outcome, reply.seq, reply.code), (outcome, 9, packet.code + 0x80), "{packet:?}");
        assert_eq!(*model.period(), before);
    }
    let reply = model.spoil(true).unwrap();
    assert_eq!((reply.code, reply.outcome), (0x80, Outcome::Crc));
    let (_, status) = status(&mut model);
    assert_eq!((status.framing_errors, status.spoiled), (1, 1));
}

#[test]
fn the_bit_rate_is_kept_until_the_line_is_idle() {
    for phase_bits in 5..=8 {
        let mut model = Model::new(phase_bits);
        assert!((model.baud() - 2e6).abs() < 100.0);
        apply(&mut model, &Packet::baud(3000));
        let rate = model.baud();
        run(&mut model, 32_767);
        assert_eq!(model.baud(), rate);
        model.period();
        assert!((model.baud() - 2e6).abs() < 100.0);
    }
}

#[test]
fn info_describes_the_device() {
    let mut model = Model::new(6).with_carrier(39_950_000);
    let Body::Info(info) = apply(&mut model, &Packet::info()).body else { panic!() };
    let Info { phase_bits, slots, carrier_millihertz, channels, .. } = info;
    assert_eq!((phase_bits, slots, carrier_millihertz, channels), (6, 64, 39_950_000, 256));
}

#[test]
fn info_of_version_1_is_answered_in_its_form_and_counts_as_spoiled() {
    let mut model = Model::new(7);
    model.press(true);
    let line = model.introduce(9).unwrap().to_line();
    let body = cobs::decode_vec(line.strip_suffix(&[0]).unwrap()).unwrap();
    assert_eq!(body[..8], [0x81, 9, 4, 0b00_1010, 2, 7, 63, 3]);
    assert_eq!((body.len(), status(&mut model).1.spoiled), (16, 1));
    assert_eq!(Model::new(7).with_address(1).introduce(9), None);
}
