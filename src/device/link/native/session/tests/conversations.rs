//! The conversation for a wish, packet by packet.

use super::*;

#[test]
fn a_frame_is_followed_by_enable_and_a_newer_one_replaces_it() {
    let (shared, events) = shared();
    let mut line = Line::new(Profile::Native, &shared);
    line.run(20 * MILLI).unwrap();
    assert_eq!(line.kinds(), ["MUTE"], "silence is the wish of a link without content");
    line.show(still(Profile::Native, 1));
    line.run(300 * MILLI).unwrap();
    assert_eq!(line.kinds(), ["PHASES", "ENABLE"]);
    assert!(line.plays(&frame(Profile::Native, 1)));
    assert!(line.health().in_place && line.health().refused == 0);
    for number in 2..12 {
        line.show(still(Profile::Native, number));
        assert!(!line.health().in_place, "a newer wish");
        line.run(9 * MILLI).unwrap();
    }
    let packets = line.packets();
    assert!(packets.iter().all(|packet| packet.code == Kind::Phases.code() && packet.commits()));
    let slots: Vec<_> = packets.iter().map(|packet| packet.arguments[0]).collect();
    assert!(
        slots.windows(2).all(|pair| pair[0] != pair[1]) && slots.iter().all(|slot| (60..64).contains(slot))
    );
    assert_eq!((slots.len(), line.shown.len(), line.health().frames, line.health().refused), (10, 11, 11, 0));
    (20..70).for_each(|number| line.show(still(Profile::Native, number)));
    line.run(300 * MILLI).unwrap();
    assert_eq!(line.kinds(), ["PHASES"], "wishes that were replaced unsent");
    assert!(line.plays(&frame(Profile::Native, 69)) && line.health().in_place);
    assert_eq!(notices(&events), "");
    let figures = shared.figures.lock().unwrap();
    let latency = figures.latency.spread().unwrap();
    // 271 bytes at 2 Mbaud; the first wish is older than the link and does not count.
    assert_eq!(latency.median.as_micros(), 1355, "{latency:?}");
    assert!((MILLI..3 * MILLI).contains(&figures.round_trip.spread().unwrap().median));
}

#[test]
fn late_answers_are_noticed_and_cost_no_frames() {
    let frames = |delay: u32| {
        let (shared, events) = shared();
        let mut line = Line::playing(Profile::Native, &shared);
        line.delay = delay * MILLI;
        line.show(motion(Profile::Native, 1000, 660.0));
        line.run(Duration::from_secs(1)).unwrap();
        let begun = line.health().frames;
        line.run(Duration::from_secs(2)).unwrap();
        assert_eq!(line.health().refused, 0);
        let told = notices(&events).matches("latency timer").count();
        (line.health().frames - begun, told)
    };
    let (at_once, late) = (frames(1), frames(16));
    assert_eq!((at_once.1, late.1), (0, 1));
    assert!(20 * late.0 >= 19 * at_once.0, "{} frames in 2 s at 1 ms, {} at 16 ms", at_once.0, late.0);
}

#[test]
fn an_idle_line_is_kept_alive_and_no_more() {
    for profile in [Profile::Native, Profile::Natives(3), Profile::Natives(8)] {
        let (shared, events) = shared();
        let mut line = Line::playing(profile, &shared);
        line.run(Duration::from_secs(1)).unwrap();
        assert!(line.said.iter().all(|(_, packet)| is_of(packet, Kind::Status)));
        for address in 0..profile.devices() as u8 {
            let heard = line.said.iter().filter(|(_, packet)| packet.address == address);
            let times: Vec<_> = heard.map(|(at, _)| *at).collect();
            let pauses: Vec<_> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
            assert!(pauses.iter().all(|pause| (49 * MILLI..70 * MILLI).contains(pause)), "{pauses:?}");
            assert!(pauses.len() >= 13, "{pauses:?}");
        }
        assert_eq!(notices(&events), "");
        assert!(line.plays(&frame(profile, 1)), "no watchdog has tripped");
    }
}

#[test]
fn a_stored_motion_is_uploaded_behind_its_first_frame_and_played() {
    for profile in [Profile::Native, Profile::Natives(2)] {
        let (shared, events) = shared();
        let mut line = Line::new(profile, &shared);
        let devices = profile.devices();
        line.run(20 * MILLI).unwrap();
        line.packets();
        line.show(motion(profile, 64, 320.0));
        line.run(Duration::from_secs(1)).unwrap();
        let mut packets = line.packets();
        let kinds: Vec<_> = packets.iter().map(|packet| packet.code).collect();
        let order = [
            (Kind::Stop, 1),
            (Kind::Phases, 1),
            (Kind::Enable, 1),
            (Kind::Phases, 63),
            (Kind::Silencer, 1),
            (Kind::Play, 1),
        ];
        let order = order.into_iter().flat_map(|(kind, count)| vec![kind.code(); count * devices]);
        assert_eq!(kinds, order.collect::<Vec<_>>());
        let commits = packets.iter().filter(|packet| packet.commits()).count();
        assert_eq!(commits, devices, "only the standing frame is put on");
        let play = packets.pop().unwrap();
        assert_eq!((play.address, &play.arguments), (0, &[0, 63, 125, 0]), "the leader is told last");
        assert_eq!(play.payload, [0, 0, if devices > 1 { 2 } else { 0 }]);
        for slot in 0..64 {
            let wanted = bytes(&frame(profile, usize::from(slot)));
            assert!(
                (0..devices as u8).all(|n| line.has(Stored::Slot(slot), n, &wanted[..512])),
                "slot {slot}"
            );
        }
        let health = line.health();
        assert!(health.in_place && health.refused == 0 && health.frames == 64 * devices as u64);
        assert_eq!(health.rates.map(|rates| (rates.asked, rates.played)), Some((320.0, 320.0)));
        // From the store to a frame, which waits until no slot is played.
        line.show(still(profile, 7));
        line.run(300 * MILLI).unwrap();
        let packets = line.packets();
        let kinds: Vec<_> = packets.iter().map(|packet| packet.code).collect();
        let order = [Kind::Stop, Kind::Silencer, Kind::Phases].into_iter();
        assert_eq!(kinds, order.flat_map(|kind| vec![kind.code(); devices]).collect::<Vec<_>>());
        assert!(line.plays(&frame(profile, 7)) && line.health().refused == 0);
        assert_eq!(line.health().rates, None);
        line.show(still(profile, 8));
        line.run(100 * MILLI).unwrap();
        assert!(line.packets().iter().all(|packet| is_of(packet, Kind::Phases)), "nothing is left to stop");
        // A second motion is stored around the frame that plays.
        line.show(motion(profile, 10, 50.0));
        line.run(300 * MILLI).unwrap();
        let play = line.packets().pop().unwrap();
        let [first, last, ..] = play.arguments;
        assert_eq!((last - first, line.health().refused), (9, 0));
        assert!((first..=last).all(|slot| {
            let wanted = bytes(&frame(profile, usize::from(slot - first)));
            line.has(Stored::Slot(slot), 0, &wanted[..512])
        }));
        assert_eq!(notices(&events), "");
    }
}

#[test]
fn a_motion_beyond_the_store_is_streamed_frame_by_frame() {
    let (shared, events) = shared();
    let mut line = Line::new(Profile::Native, &shared);
    line.show(motion(Profile::Native, 200, 100.0));
    line.run(Duration::from_secs(1)).unwrap();
    let due: Vec<_> = (0..100).map(|number| frame(Profile::Native, number)).collect();
    // Of the first frames, all but the first wait for ENABLE.
    let seen: Vec<_> =
        line.shown.iter().filter_map(|levels| due.iter().position(|due| due == levels)).collect();
    assert!(seen.len() >= 97 && seen.windows(2).all(|pair| pair[0] < pair[1]), "{seen:?}");
    assert_eq!(seen.len(), line.shown.len());
    assert_eq!((line.health().refused, notices(&events)), (0, String::new()));
    line.show(motion(Profile::Native, 64, 10_000.0));
    line.run(500 * MILLI).unwrap();
    assert_eq!(notices(&events), "", "four periods of 25 us are exact");
    line.show(motion(Profile::Native, 200, 9000.0));
    line.run(500 * MILLI).unwrap();
    let notice = notices(&events);
    assert!(
        notice.contains("9000 frames/s asked") && notice.contains("of 200 frames, 44.6429 cycles/s"),
        "{notice}"
    );
}

#[test]
fn several_devices_change_frames_in_the_same_period() {
    let profile = Profile::Natives(3);
    let (shared, _events) = shared();
    let mut line = Line::new(profile, &shared);
    line.show(still(profile, 0));
    line.run(100 * MILLI).unwrap();
    for number in 1..10 {
        line.packets();
        line.show(still(profile, 20 * number));
        for _ in 0..30 {
            line.run(MILLI).unwrap();
            let pulses = line.pulses();
            assert!((256..768).all(|n| pulses[n] == pulses[n % 256]), "frame {number}");
        }
        let addresses: Vec<_> = line.packets().iter().map(|packet| packet.address).collect();
        assert_eq!(addresses, [2, 1, 0]);
        assert!(line.plays(&frame(profile, 20 * number)) && line.health().in_place);
    }
    assert_eq!(line.health().refused, 0);
    line.stop();
    line.run(100 * MILLI).unwrap();
    assert_eq!(line.kinds(), ["MUTE", "MUTE", "MUTE"]);
    assert!(line.is_silent());
}

#[test]
fn a_modulation_is_told_once_to_every_device() {
    let profile = Profile::Natives(2);
    let (shared, events) = shared();
    let mut line = Line::playing(profile, &shared);
    let modulation =
        Modulation { shape: Envelope::Sine, frequency: 200.0, depth: 1.0, ..Modulation::default() };
    line.want(|wanted| wanted.modulation = modulation.clone());
    line.run(100 * MILLI).unwrap();
    assert_eq!(line.kinds(), ["ENVELOPE", "ENVELOPE", "RATE", "RATE", "PHASES", "PHASES"]);
    let table = Table::new(&modulation, 40_000.0).unwrap();
    assert!((0..2).all(|address| line.has(Stored::Envelope, address, &table.values)));
    line.show(still(profile, 2));
    line.run(100 * MILLI).unwrap();
    assert_eq!(line.kinds(), ["PHASES", "PHASES"]);
    // Those of a superseded modulation are not sent any more.
    for frequency in [100.0, 150.0, 250.0] {
        line.want(|wanted| wanted.modulation.frequency = frequency);
        line.turn(line.now + MILLI).unwrap();
    }
    line.run(100 * MILLI).unwrap();
    let last = Table::new(&Modulation { frequency: 250.0, ..modulation }, 40_000.0).unwrap();
    let packets = line.packets();
    let rates: Vec<_> = packets.iter().filter(|packet| packet.code == Kind::Rate.code()).collect();
    assert!(
        rates.len() <= 4
            && rates.ends_with(&[&Packet::rate(last.step, true), &Packet::rate(last.step, true).to(1)].map(
                |packet| {
                    rates
                        .iter()
                        .copied()
                        .rfind(|rate| (rate.address, rate.arguments) == (packet.address, packet.arguments))
                        .unwrap()
                }
            ))
    );
    assert_eq!((line.health().refused, notices(&events)), (0, String::new()));
}

#[test]
fn a_changed_modulation_leaves_other_settings_to_be_sent() {
    let profile = Profile::Natives(4);
    let (shared, _events) = shared();
    let mut line = Line::new(profile, &shared);
    line.show(motion(profile, 9, 50.0));
    line.run(300 * MILLI).unwrap();
    line.packets();
    line.show(still(profile, 3));
    line.turn(line.now).unwrap();
    // The silencers of all devices return to their usual steps after STOP.
    while line.session.playing {
        line.turn(line.now + MILLI).unwrap();
    }
    assert!(line.session.tasks.iter().any(|task| is_of(&task.packet, Kind::Silencer)));
    line.want(|wanted| wanted.modulation = Modulation { shape: Envelope::Sine, ..Modulation::default() });
    line.run(100 * MILLI).unwrap();
    let mut told: Vec<_> = line
        .packets()
        .iter()
        .filter(|packet| is_of(packet, Kind::Silencer))
        .map(|packet| packet.address)
        .collect();
    told.sort_unstable();
    assert_eq!(told, [0, 1, 2, 3]);
}

#[test]
fn an_idle_session_rests_until_a_frame_or_a_question_is_due() {
    let (shared, _events) = shared();
    let mut line = Line::playing(Profile::Native, &shared);
    let answer_all = |line: &mut Line<'_>| {
        while !line.session.on_the_way.is_empty() {
            line.turn(line.now + MILLI).unwrap();
        }
    };
    answer_all(&mut line);
    let rest = KEEP_ALIVE - (line.now - line.session.written_at);
    assert_eq!(line.session.rest(&line.wanted, line.now), Some(rest));
    let content = motion(Profile::Native, 200, 100.0);
    line.show(content.clone());
    line.turn(line.now).unwrap();
    assert_eq!(line.session.rest(&line.wanted, line.now), None, "an answer is awaited");
    line.run(50 * MILLI).unwrap();
    answer_all(&mut line);
    let rest = content.next_in(line.now - line.wanted.since);
    assert_eq!(line.session.rest(&line.wanted, line.now), Some(rest));
}

#[test]
fn a_newer_wish_does_not_wait_for_the_rest_of_an_upload() {
    let (shared, _events) = shared();
    let mut line = Line::new(Profile::Native, &shared);
    line.show(motion(Profile::Native, 64, 320.0));
    line.run(20 * MILLI).unwrap();
    line.packets();
    line.show(still(Profile::Native, 9));
    line.run(15 * MILLI).unwrap();
    assert!(line.plays(&frame(Profile::Native, 9)) && line.health().in_place);
    let kinds = line.kinds();
    assert!(kinds.len() < 5, "{kinds:?}");
}

#[test]
fn each_wish_has_one_latency_and_every_byte_counts() {
    let (shared, _events) = shared();
    let mut line = Line::new(Profile::Native, &shared);
    line.run(20 * MILLI).unwrap();
    line.show(motion(Profile::Native, 200, 100.0));
    line.run(500 * MILLI).unwrap();
    let latency = shared.figures.lock().unwrap().latency.spread().unwrap();
    assert!(latency.largest < 3 * MILLI, "later frames of a motion have none: {latency:?}");
    let written: usize = line.said.iter().map(|(_, packet)| packet.to_line().len()).sum();
    // Delimiters before packets on an idle line come on top.
    let counted = line.health().bytes - written as u64;
    assert!((1..=line.said.len() as u64).contains(&counted), "{counted}");
}

#[test]
fn devices_without_sync_are_told_of_and_play_their_frames_at_once() {
    let profile = Profile::Natives(2);
    let (shared, events) = shared();
    let mut line = Line::of_devices(profile, &shared, |reply| reply.flags.follows = false);
    assert!(notices(&events).contains("board 1 receives no sync"));
    line.show(still(profile, 3));
    line.run(100 * MILLI).unwrap();
    let frames: Vec<_> = line.packets().into_iter().filter(|packet| is_of(packet, Kind::Phases)).collect();
    assert!(frames.iter().all(|packet| packet.arguments[2] == 1), "committed, not in step");
    assert!(line.plays(&frame(profile, 3)));
    let mut line = Line::new(profile, &shared);
    assert_eq!(notices(&events), "");
    line.show(still(profile, 3));
    line.run(100 * MILLI).unwrap();
    assert!(line.packets().iter().any(|packet| packet.arguments[2] == 3), "in step");
}

#[test]
fn a_modulation_that_no_table_holds_leaves_the_sound_steady() {
    let (shared, events) = shared();
    let mut line = Line::new(Profile::Native, &shared);
    line.want(|wanted| wanted.modulation.shape = Envelope::File);
    line.run(50 * MILLI).unwrap();
    assert_eq!(notices(&events), "", "nothing sounds yet");
    line.show(still(Profile::Native, 3));
    line.run(100 * MILLI).unwrap();
    assert_eq!(notices(&events), "the sound is steady: modulation.file is not loaded");
    assert!(line.plays(&frame(Profile::Native, 3)));
}

#[test]
fn settings_are_outdated_once_others_are_wanted() {
    let (shared, _events) = shared();
    let mut line = Line::new(Profile::Native, &shared);
    let (steady, other) = (Table::steady(), [7; 256]);
    let is_outdated = |line: &Line<'_>, packet: Packet| line.session.is_outdated(&packet);
    assert!(
        !is_outdated(&line, Packet::envelope(&steady.values)) && is_outdated(&line, Packet::envelope(&other))
    );
    assert!(!is_outdated(&line, Packet::rate(0, true)) && is_outdated(&line, Packet::rate(1 << 16, true)));
    let silencer = |phase_step| Packet::silencer(phase_step, SILENCER.1);
    assert!(!is_outdated(&line, silencer(SILENCER.0)) && is_outdated(&line, silencer(0x0400)));
    assert!(!is_outdated(&line, Packet::mute()) && !is_outdated(&line, Packet::widths(&other)));
    // Two frames half a turn apart, in four periods each.
    let frames = [0, 128].map(|number| frame(Profile::Native, number)).to_vec();
    line.show(Content::Motion { frames, rate: 10_000.0 });
    line.run(100 * MILLI).unwrap();
    assert!(is_outdated(&line, silencer(SILENCER.0)) && !is_outdated(&line, silencer(128 * 256 / 4)));
}

#[test]
fn the_first_frame_of_a_wish_is_answered_before_the_next_is_sent() {
    let (shared, _events) = shared();
    let mut line = Line::playing(Profile::Native, &shared);
    line.delay = 60 * MILLI;
    line.show(motion(Profile::Native, 200, 100.0));
    line.run(45 * MILLI).unwrap();
    assert_eq!(line.kinds(), ["PHASES"]);
    line.run(100 * MILLI).unwrap();
    assert!(line.kinds().len() > 1 && line.health().in_place);
}

#[test]
fn a_motion_is_stored_around_the_slots_that_devices_play() {
    let profile = Profile::Natives(2);
    let (shared, _events) = shared();
    let mut line = Line::new(profile, &shared);
    // Device 0 plays slot 0.
    reply_of(&mut line.devices, &Packet::phases(1, 0, &[0; 256], true).to(1), line.now);
    line.show(motion(profile, 2, 20_000.0));
    line.run(200 * MILLI).unwrap();
    let [first, last, ..] = line.packets().pop().unwrap().arguments;
    assert_eq!((first, last, line.health().refused), (1, 2, 0));
    assert!(line.health().in_place);
}
