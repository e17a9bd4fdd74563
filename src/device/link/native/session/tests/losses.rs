//! What becomes of a wish when something goes wrong.

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
