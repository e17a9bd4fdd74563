//! The fate of a wish after losses and refusals.

use super::*;
use crate::device::native::packet::Status;

#[test]
fn the_emergency_stop_ends_a_wish() {
    for held in [true, false] {
        let (shared, events) = shared();
        let mut line = Line::playing(Profile::Native, &shared);
        line.devices.press(true);
        line.devices.press(held);
        line.run(100 * MILLI).unwrap();
        let notice = notices(&events);
        assert!(notice.contains(if held { "stop is pressed" } else { "stop was pressed" }), "{notice}");
        assert_eq!(notice.lines().count(), 1);
        assert!(line.health().stopped && !line.health().in_place);
        line.devices.press(false);
        line.packets();
        line.run(300 * MILLI).unwrap();
        assert!(line.packets().is_empty() && line.is_silent(), "silent until the next wish");
        line.show(still(Profile::Native, 2));
        line.run(100 * MILLI).unwrap();
        assert!(line.plays(&frame(Profile::Native, 2)) && !line.health().stopped && line.health().in_place);
        assert_eq!(notices(&events), "");
    }
}

#[test]
fn a_pause_trips_the_watchdog_and_the_sound_comes_back() {
    let (shared, events) = shared();
    let mut line = Line::playing(Profile::Native, &shared);
    line.pass(line.now + 140 * MILLI);
    line.run(100 * MILLI).unwrap();
    assert_eq!(notices(&events), "");
    line.pass(line.now + 300 * MILLI);
    assert!(line.is_silent());
    line.packets();
    line.run(100 * MILLI).unwrap();
    assert!(notices(&events).contains("watchdog"));
    assert_eq!(line.kinds(), ["ENABLE"]);
    assert!(line.plays(&frame(Profile::Native, 1)) && line.health().in_place);
}

#[test]
fn a_device_that_fell_silent_alone_is_switched_on_again() {
    let profile = Profile::Natives(2);
    let (shared, events) = shared();
    let mut line = Line::playing(profile, &shared);
    // Its watchdog trips after 64 periods.
    reply_of(&mut line.devices, &Packet::enable(1).to(1), line.now);
    line.run(100 * MILLI).unwrap();
    assert!(notices(&events).contains("watchdog"));
    let packets = line.packets();
    let [enable] = &packets[..] else { panic!("{packets:?}") };
    assert_eq!((enable.code, enable.address), (Kind::Enable.code(), 1));
    assert!(line.plays(&frame(profile, 1)) && line.health().in_place);
}

#[test]
fn a_frame_that_is_refused_during_an_emergency_stop_is_not_sent_again() {
    let (shared, _events) = shared();
    let mut line = Line::playing(Profile::Native, &shared);
    line.show(still(Profile::Native, 2));
    line.turn(line.now).unwrap();
    let Sent { seq, code, .. } = line.session.on_the_way.back().unwrap().clone();
    line.devices.press(true);
    let status = reply_of(&mut line.devices, &Packet::status(), line.now);
    let refused = Reply { code: code + REPLY, seq, outcome: Outcome::Crc, ..status };
    line.session.hear(&[refused], &line.wanted, line.now).unwrap();
    line.run(200 * MILLI).unwrap();
    assert_eq!(line.kinds(), ["PHASES"]);
    assert!(line.health().stopped && line.is_silent());
}

#[test]
fn lost_devices_are_lost_in_time_and_for_a_reason() {
    let of = |faults: Faults| {
        let (shared, _events) = shared();
        let mut line = Line::playing(Profile::Native, &shared);
        line.damage = Damage::new(faults, 2);
        line.show(still(Profile::Native, 2));
        let from = line.now;
        let error = line.run(Duration::from_secs(5)).unwrap_err();
        (error, line.now - from)
    };
    let (error, time) = of(Faults { drop: 1.0, ..Faults::default() });
    assert!(matches!(&error, LinkError::Silent(name) if name == "board"), "{error}");
    assert!((1450 * MILLI..1600 * MILLI).contains(&time), "{time:?}");
    // Each is answered, as spoiled.
    let (shared, _events) = shared();
    let mut line = Line::new(Profile::Native, &shared);
    line.damage = Damage::new(Faults { flip: 1.0, ..Faults::default() }, 3);
    let error = line.run(Duration::from_secs(5)).unwrap_err();
    assert!(matches!(error, LinkError::Refused("MUTE") | LinkError::Silent(_)), "{error}");
    // Switched off and on: its counter of periods begins anew.
    let mut line = Line::playing(Profile::Native, &shared);
    line.devices = Native::new(&Model::new(7), 1, line.now);
    assert!(matches!(line.run(200 * MILLI), Err(LinkError::Restarted)));
    let mut line = Line::new(Profile::Native, &shared);
    line.run(Duration::from_secs(1)).unwrap();
    line.devices = Native::new(&Model::new(7), 1, line.now);
    assert!(matches!(line.run(200 * MILLI), Err(LinkError::Restarted)), "also while it is silent");
}

#[test]
fn a_packet_that_is_always_refused_is_sent_twelve_times() {
    let reasons = [Outcome::Busy, Outcome::Crc, Outcome::Length, Outcome::Unknown, Outcome::Argument];
    for (profile, frame) in
        [(Profile::Native, None), (Profile::Natives(2), Some(still(Profile::Natives(2), 1)))]
    {
        let (shared, _events) = shared();
        let mut line = Line::new(profile, &shared);
        if let Some(frame) = frame {
            line.show(frame);
        }
        line.session.follow(&line.wanted);
        for attempt in 1..=12 {
            // Of the frames to two devices, one at a time is refused.
            let message = line.session.next(&line.wanted, line.now).unwrap();
            let (code, address, seq) = (message.code + REPLY, message.address, message.seq);
            line.session.sent(message, &line.wanted, line.now, line.now);
            let outcome = if address > 0 { Outcome::Busy } else { reasons[attempt % reasons.len()] };
            let body = Body::Status(Status { periods: 1000, ..Status::default() });
            let reply = Reply { code, address, seq, outcome, flags: Default::default(), body };
            let heard = line.session.hear(&[reply], &line.wanted, line.now);
            assert_eq!(heard.is_err(), attempt == 12, "{profile:?}, {attempt}: {heard:?}");
            assert_eq!(line.health().refused, attempt as u64);
        }
    }
}

#[test]
fn a_hurried_drag_over_several_devices_meets_no_slot_in_play() {
    let profile = Profile::Natives(2);
    let (shared, _events) = shared();
    let mut line = Line::new(profile, &shared);
    for hurry in 1..9 {
        for number in 0..hurry {
            line.show(still(profile, 16 * hurry + number));
            line.turn(line.now).unwrap();
        }
        line.run(40 * MILLI).unwrap();
        assert!(line.plays(&frame(profile, 17 * hurry - 1)) && line.health().refused == 0, "{hurry}");
    }
}

#[test]
fn an_upload_over_a_lossy_line_is_whole() {
    let profile = Profile::Natives(2);
    for seed in 0..30 {
        let (shared, _events) = shared();
        let mut line = Line::new(profile, &shared);
        line.damage = Damage::new(Faults { drop: 2e-4, insert: 2e-4, ..Faults::default() }, seed);
        line.show(motion(profile, 64, 320.0));
        let ran = line.run(Duration::from_secs(1));
        assert!(ran.is_ok() && line.health().in_place, "{seed}: {ran:?}");
        let play = line.packets().into_iter().rfind(|packet| is_of(packet, Kind::Play)).unwrap();
        let [first, last, ..] = play.arguments;
        assert_eq!(last - first, 63);
        for slot in 0..64 {
            let wanted = bytes(&frame(profile, usize::from(slot)));
            assert!((0..2).all(|n| line.has(Stored::Slot(slot), n, &wanted[..512])), "{seed}: slot {slot}");
        }
    }
}

#[test]
fn a_slow_board_is_waited_for() {
    let (shared, _events) = shared();
    let mut line = Line::new(Profile::Native, &shared);
    line.delay = 250 * MILLI;
    line.show(still(Profile::Native, 1));
    line.run(Duration::from_secs(3)).unwrap();
    assert!(line.health().in_place);
    let before = line.health().refused;
    for number in 2..5 {
        line.show(still(Profile::Native, number));
        line.run(Duration::from_secs(1)).unwrap();
    }
    assert!(line.health().in_place && line.health().refused == before, "{before}");
}

/// Any wishes over a line of any quality end in the last wish.
#[test]
fn the_last_of_any_wishes_is_played_over_any_line() {
    for seed in 0..200 {
        let mut dice = Rng::with_seed(seed);
        let profile = if dice.bool() { Profile::Native } else { Profile::Natives(2) };
        let (shared, _events) = shared();
        let mut line = Line::new(profile, &shared);
        let loss = [0.0, 1e-4, 2e-4][dice.usize(..3)];
        let faults = Faults { drop: loss, flip: loss, insert: loss / 2.0, ..Faults::default() };
        line.damage = Damage::new(faults, seed);
        for _ in 0..dice.usize(2..9) {
            match dice.u8(..6) {
                0 => line.stop(),
                1 => line.show(motion(profile, [1, 2, 9, 64, 100][dice.usize(..5)], 100.0)),
                2 => line.show(motion(profile, dice.usize(1..130), 2000.0)),
                3 => line.want(|wanted| wanted.modulation.frequency = 200.0),
                _ => line.show(still(profile, dice.usize(..256))),
            }
            let ran = line.run(MILLI * dice.u32(..60));
            assert!(ran.is_ok(), "{seed} {loss} {profile:?}: {ran:?}");
        }
        line.stop();
        let ran = line.run(400 * MILLI);
        assert!(ran.is_ok(), "{seed} {loss} {profile:?}: {ran:?}");
        assert!(line.is_silent(), "{seed}");
        let last = dice.usize(..256);
        line.show(still(profile, last));
        let ran = line.run(400 * MILLI);
        assert!(ran.is_ok(), "{seed} {loss} {profile:?}: {ran:?}");
        assert!(line.plays(&frame(profile, last)) && line.health().in_place, "{seed}: {:?}", line.health());
        assert!(loss > 0.0 || line.health().refused == 0, "{seed}: {:?}", line.health());
    }
}

#[test]
fn late_answers_to_lost_packets_double_the_patience() {
    let (shared, _events) = shared();
    let mut line = Line::new(Profile::Native, &shared);
    line.session.follow(&line.wanted);
    let mut late = Vec::new();
    for _ in 0..WINDOW {
        let message = line.session.next(&line.wanted, line.now).unwrap();
        let (code, address, seq) = (message.code + REPLY, message.address, message.seq);
        let body = Body::Status(Status::default());
        late.push(Reply { code, address, seq, outcome: Outcome::Ok, flags: Default::default(), body });
        line.session.sent(message, &line.wanted, line.now, line.now);
        line.now += ANSWER + MILLI;
        line.session.hear(&[], &line.wanted, line.now).unwrap();
    }
    let stranger = Reply { seq: 99, ..late[0] };
    // The first one clears what is known of the others.
    let answers = [(stranger, 1), (late[0], 2), (late[1], 2), (late[WINDOW - 1], 2)];
    for (reply, times) in answers {
        line.session.hear(&[reply], &line.wanted, line.now).unwrap();
        assert_eq!(line.session.patience, times * ANSWER, "{reply:?}");
    }
}

#[test]
fn an_answer_to_an_older_frame_does_not_end_a_stop() {
    let profile = Profile::Natives(2);
    let (shared, _events) = shared();
    let mut line = Line::playing(profile, &shared);
    line.show(still(profile, 2));
    line.turn(line.now).unwrap();
    line.stop();
    for _ in 0..100 {
        line.run(MILLI).unwrap();
        assert!(!line.health().in_place);
    }
    assert_eq!(line.kinds(), ["PHASES", "MUTE", "MUTE"]);
    assert!(line.is_silent());
}

/// Slots and addresses of the frames put on since the last call.
fn put_on(packets: &[Packet]) -> Vec<(u8, u8)> {
    let frames = packets.iter().filter(|packet| packet.commits());
    frames.map(|packet| (packet.arguments[0], packet.address)).collect()
}

#[test]
fn a_frame_whose_answer_was_lost_begins_again_in_another_slot() {
    let lose_answers = |line: &mut Line<'_>| {
        line.pass(line.now + 3 * MILLI);
        line.back.clear();
        line.run(200 * MILLI).unwrap();
        assert!(line.health().in_place);
        line.packets()
    };
    // Device 1 has its part, and waits for the leader's.
    let profile = Profile::Natives(2);
    let (frames, _events) = shared();
    let mut line = Line::playing(profile, &frames);
    line.show(still(profile, 2));
    line.turn(line.now).unwrap();
    let [(slot, 1), again, (other, 1), last] = put_on(&lose_answers(&mut line))[..] else {
        panic!("other frames")
    };
    assert_eq!((again, last), ((slot, 1), (other, 0)));
    assert!(slot != other && line.plays(&frame(profile, 2)));
    // The first frame of a stored motion plays, so that no other may be in its slot.
    let (motions, _events) = shared();
    let mut line = Line::playing(Profile::Native, &motions);
    line.show(motion(Profile::Native, 9, 50.0));
    while !line.said.iter().any(|(_, packet)| packet.commits()) {
        line.turn(line.now + MILLI).unwrap();
    }
    let packets = lose_answers(&mut line);
    assert_eq!(put_on(&packets), [(0, 0), (0, 0), (1, 0)]);
    assert_eq!(packets.last().unwrap().arguments[..2], [0, 8]);
    for slot in 0..9 {
        let wanted = bytes(&frame(Profile::Native, usize::from(slot)));
        assert!(line.has(Stored::Slot(slot), 0, &wanted), "slot {slot}");
    }
}

#[test]
fn a_refused_frame_of_an_older_wish_leaves_the_newer_one_alone() {
    let profile = Profile::Natives(2);
    let (shared, _events) = shared();
    let mut line = Line::playing(profile, &shared);
    line.show(still(profile, 2));
    line.turn(line.now).unwrap();
    let Sent { address, seq, code, .. } = line.session.on_the_way.back().unwrap().clone();
    line.show(still(profile, 3));
    line.turn(line.now).unwrap();
    let status = reply_of(&mut line.devices, &Packet::status().to(address), line.now);
    let busy = Reply { code: code + REPLY, seq, outcome: Outcome::Busy, ..status };
    line.session.hear(&[busy], &line.wanted, line.now).unwrap();
    line.run(100 * MILLI).unwrap();
    let addresses: Vec<_> = put_on(&line.packets()).into_iter().map(|(_, address)| address).collect();
    assert_eq!(addresses, [1, 1, 0]);
    assert!(line.plays(&frame(profile, 3)) && line.health().in_place);
}

#[test]
fn of_an_older_wish_only_lost_settings_are_sent_again() {
    let (shared, _events) = shared();
    let mut line = Line::playing(Profile::Native, &shared);
    let modulation =
        Modulation { shape: Envelope::Sine, frequency: 200.0, depth: 1.0, ..Modulation::default() };
    line.want(|wanted| wanted.modulation = modulation.clone());
    line.turn(line.now).unwrap();
    line.out.clear();
    line.show(still(Profile::Native, 2));
    line.run(200 * MILLI).unwrap();
    let table = Table::new(&modulation, 40_000.0).unwrap();
    assert!(line.has(Stored::Envelope, 0, &table.values));
    line.packets();
    line.stop();
    line.turn(line.now).unwrap();
    line.out.clear();
    line.show(still(Profile::Native, 3));
    line.run(200 * MILLI).unwrap();
    assert_eq!(line.kinds(), ["MUTE", "PHASES"]);
    assert!(line.shown.last() == Some(&frame(Profile::Native, 3)) && line.health().in_place);
}

/// Several devices would otherwise drop a frame that waits for its period.
#[test]
fn a_frame_follows_the_stop_of_a_motion_even_if_that_is_lost() {
    let (shared, _events) = shared();
    let mut line = Line::playing(Profile::Native, &shared);
    line.show(motion(Profile::Native, 9, 50.0));
    line.run(200 * MILLI).unwrap();
    line.packets();
    line.show(still(Profile::Native, 7));
    line.turn(line.now).unwrap();
    line.out.clear();
    line.run(200 * MILLI).unwrap();
    let mut kinds = line.kinds();
    assert_eq!(kinds.pop(), Some("PHASES"));
    assert_eq!(kinds.iter().filter(|kind| **kind == "STOP").count(), 2);
    assert!(!kinds.contains(&"PHASES") && line.plays(&frame(Profile::Native, 7)));
}
