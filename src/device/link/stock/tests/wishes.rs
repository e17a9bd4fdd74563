//! The fate of wishes: repetitions, motions beyond the line, random wishes, damaged lines.

use super::*;
use crate::device::link::Link;
use crate::device::link::shared::Sounding;
use crate::device::link::stock::session::AHEAD;
use crate::device::link::stock::{run, watch};
use crate::device::port::{Port, virtual_board};
use crate::device::task::finish;

/// Random conversations of each kind.
const SEEDS: u64 = 40;

#[test]
fn a_watch_ends_when_it_is_due_and_earlier_only_for_a_newer_wish() {
    let (shared, _events) = shared();
    let wanted = shared.wanted();
    for _ in 0..20 {
        let due = Instant::now() + MILLI;
        finish(watch(due, &wanted, &shared));
        assert!(Instant::now() >= due);
    }
    shared.renew(&mut shared.wanted.lock(), Instant::now(), |_| {});
    let due = Instant::now() + Duration::from_secs(60);
    finish(watch(due, &wanted, &shared));
    assert!(Instant::now() < due);
}

#[test]
fn the_silence_at_the_start_is_counted() {
    let profile = Profile::SonicSurface;
    let (shared, events) = shared();
    let settings = Settings { port: virtual_board(profile), profile, baud: Some(10_000_000) };
    shared.wanted.lock().closing = true;
    finish(run(&settings, &shared, false)).unwrap();
    assert!(matches!(events.try_recv(), Ok(Event::Ready(_))));
    let health = shared.health();
    assert!(health.silenced && health.bytes == stock::silence(profile).len() as u64, "{health:?}");
}

#[test]
fn a_link_ends_after_the_line_has_carried_its_silence() {
    let (profile, baud) = (Profile::SonicSurface, 460_800);
    let (shared, _events) = shared();
    let port = finish(Port::open(&virtual_board(profile), baud)).unwrap();
    let silence = stock::silence(profile);
    let time = port.time_of(silence.len());
    assert!(time > 10 * MILLI);
    let begun = Instant::now();
    drop(Sounding::new(port, silence, Duration::ZERO, &shared));
    assert!(begun.elapsed() >= time && shared.health().silenced, "{:?}", begun.elapsed());
}

#[test]
fn a_frame_waits_for_the_line() {
    // The port takes bytes at once; the line carries 190 frames/s.
    let (profile, baud) = (Profile::SonicSurface, 500_000);
    let settings = Settings { port: virtual_board(profile), profile, baud: Some(baud) };
    let link = Link::open(settings, Box::new(|| {})).unwrap();
    let begun = Instant::now();
    link.show(motion(profile, 64, 1e5));
    let frames = loop {
        let frames = link.health().frames;
        if frames > 7 {
            break frames;
        }
        assert!(begun.elapsed() < Duration::from_secs(60), "{:?}", link.health());
        std::thread::sleep(MILLI);
    };
    let carried = Pace::new(f64::from(baud), begun).time_of(profile.frame_bytes()) * (frames as u32 - 1);
    assert!(begun.elapsed() + AHEAD >= carried, "{frames} frames in {:?}", begun.elapsed());
}

#[test]
fn unchanged_content_and_silence_are_repeated_and_the_line_rests_in_between() {
    for profile in [Profile::SonicSurface, Profile::SonicSurfaceTactile, Profile::UltrainoMega64] {
        let (shared, _events) = shared();
        let mut line = Line::new(profile, profile.baud(), &shared);
        let repeated = [stock::start(profile), &stock::frame(&frame(profile, 3))].concat();
        line.show(still(profile, 3));
        line.run(30 * MILLI);
        let health = line.health();
        assert_eq!((health.frames, health.bytes), (1, profile.frame_bytes() as u64));
        assert!(std::mem::take(&mut line.said) == [stock::frame(&frame(profile, 3))]);
        line.run(Duration::from_secs(2));
        assert!(std::mem::take(&mut line.said) == vec![repeated; 8], "{profile:?}");
        line.stop();
        line.run(100 * MILLI);
        assert!(std::mem::take(&mut line.said) == [stock::silence(profile)]);
        line.run(Duration::from_secs(2));
        let repeated = [stock::start(profile), &stock::frame(&Levels::off(profile))].concat();
        assert!(std::mem::take(&mut line.said) == vec![repeated; 8], "{profile:?}");
        // The board's own modulation is set when it changes.
        line.modulate(Envelope::Sine, 200.0);
        line.show(still(profile, 4));
        line.run(30 * MILLI);
        let first = line.said[0].clone();
        assert_eq!(first.len() == 1, profile == Profile::SonicSurfaceTactile);
    }
}

#[test]
fn a_wait_for_a_repetition_ends_with_it() {
    let profile = Profile::SonicSurface;
    let (shared, _events) = shared();
    let mut line = Line::new(profile, profile.baud(), &shared);
    for content in [None, Some(Arc::new(still(profile, 3)))] {
        line.want(|wanted| wanted.content = content);
        line.run(100 * MILLI);
        let Step::Wait(due) = line.session.next(&line.wanted, line.now, line.now) else { panic!("no wait") };
        assert!(matches!(line.session.next(&line.wanted, due, due), Step::Write(_)));
    }
}

#[test]
fn a_motion_faster_than_the_line_keeps_its_time() {
    let profile = Profile::SonicSurface;
    let (shared, events) = shared();
    let mut line = Line::new(profile, 230_400, &shared);
    line.late = 2 * MILLI;
    line.show(motion(profile, 512, 256.0));
    let from = line.now;
    line.run(Duration::from_secs(3));
    let shown = line.since(from);
    assert!((240..=270).contains(&shown.len()), "{} frames in 3 s", shown.len());
    for (at, levels) in line.shown.iter().skip(2) {
        let number = (0..512).find(|&number| frame(profile, number) == *levels).unwrap();
        let asked = (*at - line.wanted.since).as_secs_f64() * 256.0;
        let late = (asked - number as f64).rem_euclid(512.0) / 256.0;
        // On the line for 11.2 ms, behind at most LEAD of the frame before.
        assert!(late < 0.0112 + LEAD.as_secs_f64() + 0.004 + 0.001, "{late} s");
    }
    let is_started = |bytes: &&Vec<u8>| bytes.starts_with(stock::start(profile));
    let started = line.said.iter().filter(is_started).count();
    assert!((10..=12).contains(&started), "{started} of {} frames", line.said.len());
    let rates = line.health().rates.unwrap();
    assert!(rates.asked == 256.0 && (rates.played - 89.3).abs() < 0.1, "{rates}");
    let said = notices(&events);
    assert!(said.len() == 1 && said[0].ends_with("the line carries no more at 230400 baud"), "{said:?}");
    let latency = line.health().latency.unwrap();
    assert!(latency.median.abs_diff(Duration::from_secs_f64(2580.0 / 230_400.0)) < 3 * MICRO, "{latency:?}");
    line.stop();
    line.run(MILLI);
    assert!(line.health().rates.is_none());
}

/// A content and a modulation at random, or silence.
fn random_wish(line: &mut Line<'_>, chance: &mut Rng) {
    let (profile, number) = (line.profile, chance.usize(..900));
    match chance.u8(..5) {
        0 => line.stop(),
        1 => line.modulate(Envelope::Off, 0.0),
        2 => line.modulate(Envelope::Square, chance.choice([2.0, 35.0, 100.0, 200.0]).unwrap()),
        3 => {
            let frames = (0..chance.usize(2..9)).map(|n| frame(profile, (number + n) % 900)).collect();
            line.show(Content::Motion { frames, rate: chance.choice([10.0, 60.0, 500.0]).unwrap() });
        }
        _ => line.show(still(profile, number)),
    }
}

/// Whether what was shown since then is the wish, and all of it.
fn is_wish(line: &Line<'_>, from: Instant) -> Result<(), String> {
    let (dark, shown) = (Levels::off(line.profile), line.since(from));
    let Some(content) = &line.wanted.content else {
        return if shown.iter().all(|(levels, _)| *levels == dark) {
            Ok(())
        } else {
            Err("not silent".into())
        };
    };
    let is_switched =
        matches!(stock::modulated(line.profile, &line.wanted.modulation, line.baud), Modulated::FromHere(_));
    let is_of = |levels: &Levels| content.frames().contains(levels) || is_switched && *levels == dark;
    if let Some((levels, _)) = shown.iter().find(|(levels, _)| !is_of(levels)) {
        return Err(format!("another frame: {:?}", &levels.channels[..4]));
    }
    let sound = line.sound_since(from);
    let expected = if is_switched { 0.2..0.56 } else { 0.999..1.1 };
    if expected.contains(&sound) { Ok(()) } else { Err(format!("sound for {sound} of the time")) }
}

#[test]
fn a_list_that_was_not_shown_is_replaced_on_both_boards() {
    let profile = Profile::SonicSurface2;
    let (shared, _events) = shared();
    let mut line = Line::new(profile, 1_000_000, &shared);
    line.modulate(Envelope::Square, 100.0);
    line.show(still(profile, 5));
    // The list is loaded, and not yet shown.
    while line.said.iter().filter(|bytes| bytes.contains(&254)).count() < 2 {
        line.turn(line.now + MILLI);
    }
    line.pass(line.now + line.pace.backlog(line.now));
    line.modulate(Envelope::Off, 0.0);
    line.show(still(profile, 6));
    line.run(20 * MILLI);
    let known = [Levels::off(profile), frame(profile, 6)];
    assert!(line.shown.iter().all(|(_, levels)| known.contains(levels)) && line.playing() == known[1]);
}

#[test]
fn the_last_of_random_wishes_is_played() {
    for seed in 0..SEEDS {
        let mut chance = Rng::with_seed(seed);
        let (profile, baud, ..) = chance.choice(SWITCHED).unwrap();
        let (shared, _events) = shared();
        let mut line = Line::new(profile, baud, &shared);
        line.chance.seed(seed);
        line.late = chance.choice([Duration::ZERO, MILLI, 4 * MILLI]).unwrap();
        for _ in 0..chance.usize(1..12) {
            random_wish(&mut line, &mut chance);
            line.run(chance.u32(..120) * MILLI);
        }
        line.run(300 * MILLI);
        let from = line.now;
        line.run(Duration::from_secs(1));
        let found = is_wish(&line, from);
        assert!(found.is_ok(), "{seed}, {}: {found:?} of {:?}", profile.name(), line.wanted.modulation);
    }
}

#[test]
fn a_damaged_line_plays_the_wish_soon_after() {
    for seed in 0..SEEDS {
        let mut chance = Rng::with_seed(seed);
        let (profile, baud, frequency, lost) = chance.choice(SWITCHED).unwrap();
        let (shared, _events) = shared();
        let mut line = Line::new(profile, baud, &shared);
        line.damage = Damage::new(
            Faults { drop: 1e-2, flip: 1e-2, insert: 1e-2, burst: 1e-3, ..Faults::default() },
            seed,
        );
        if chance.bool() {
            line.modulate(Envelope::Square, frequency);
        }
        match chance.u8(..3) {
            0 => {
                line.show(still(profile, 5));
                line.run(50 * MILLI);
                line.stop();
            }
            // A repetition of one frame would skip pulses.
            1 if lost == 0 => line.show(still(profile, 9)),
            _ => line.show(motion(profile, 4, 20.0)),
        }
        line.run(Duration::from_secs(1));
        line.damage = Damage::new(Faults::default(), 1);
        line.run(if lost == 0 { 3 * REFRESH } else { 9 * REFRESH });
        let from = line.now;
        line.run(Duration::from_secs(1));
        let found = is_wish(&line, from);
        assert!(found.is_ok(), "{seed}, {}: {found:?} of {:?}", profile.name(), line.wanted.modulation);
    }
}
