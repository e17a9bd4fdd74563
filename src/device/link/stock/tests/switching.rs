//! Modulation from here: pulses and pauses, still, in motion, and while the user drags.

use super::*;
use crate::device::link::stock::pulses::{Act, Pulses};
use crate::device::link::stock::rhythm::Rhythm;

#[test]
fn pulses_and_pauses_are_equal_and_go_on() {
    for (profile, baud, frequency, lost) in SWITCHED {
        let (shared, events) = shared();
        let mut line = Line::new(profile, baud, &shared);
        line.modulate(Envelope::Square, frequency);
        line.show(still(profile, 7));
        line.run(300 * MILLI);
        assert!(line.health().in_place);
        let from = line.now;
        line.run(Duration::from_secs(3));
        let what = format!("{} at {baud} baud, {frequency} Hz", profile.name());
        let half = Duration::from_secs_f64(0.5 / frequency);
        let halves = line.halves_since(from);
        assert!(halves.len().abs_diff((6.0 * frequency) as usize) <= 3, "{what}: {} halves", halves.len());
        for (_, lasted) in halves {
            assert!(lasted.abs_diff(half) < 30 * MICRO, "{what}: {lasted:?}");
        }
        let known = [Levels::off(profile), frame(profile, 7)];
        assert!(line.since(from).iter().all(|(levels, _)| known.contains(levels)), "{what}: torn");
        let said = notices(&events);
        assert!(said.len() == 1 && said[0].contains(&format!("{frequency} times a second")), "{said:?}");
        let swaps = line.health().swaps.unwrap();
        assert!(swaps.median.abs_diff(half) < 30 * MICRO && swaps.largest < half + 30 * MICRO, "{swaps:?}");
        // Repetitions, where they cost no pulse.
        let frames = line.health().frames;
        let is_repeated = lost == 0 && stock::swap(profile).is_some();
        let expected = if is_repeated { 11..=14 } else { 1..=1 };
        assert!(expected.contains(&frames), "{what}: {frames} frames");
    }
}

#[test]
fn pulses_keep_their_bytes_on_a_busy_computer() {
    for (baud, frequency) in [(230_400, 200.0), (230_400, 63.7), (1_000_000, 100.0)] {
        let (shared, _events) = shared();
        let mut line = Line::new(Profile::SonicSurface, baud, &shared);
        line.late = 20 * MILLI;
        line.modulate(Envelope::Square, frequency);
        line.show(still(line.profile, 7));
        line.run(400 * MILLI);
        let from = line.now;
        line.run(Duration::from_secs(3));
        let half = Duration::from_secs_f64(0.5 / frequency);
        let halves = line.halves_since(from);
        assert!(halves.len().abs_diff((6.0 * frequency) as usize) <= 3, "{} halves", halves.len());
        let byte = line.pace.time_of(1);
        assert!(halves.iter().all(|(_, lasted)| lasted.abs_diff(half) <= byte), "{halves:?}");
    }
}

#[test]
fn a_stop_discards_what_has_not_left() {
    for profile in [Profile::SonicSurface, Profile::SonicSurface2, Profile::UltrainoSimpleFpga] {
        let (shared, _events) = shared();
        let mut line = Line::new(profile, profile.baud(), &shared);
        line.modulate(Envelope::Square, 200.0);
        line.show(still(profile, 7));
        line.run(700 * MILLI);
        assert!(line.pace.backlog(line.now) > 20 * MILLI, "{:?}", line.pace.backlog(line.now));
        line.stop();
        line.run(30 * MILLI);
        assert_eq!(line.playing(), Levels::off(profile), "{}", profile.name());
    }
}

#[test]
fn two_frames_in_turn_are_loaded_once_and_swapped() {
    for (rate, late) in [(200.0, 0), (1000.0, 0), (1000.0, 20), (3000.0, 20)] {
        let profile = Profile::SonicSurface;
        let (shared, _events) = shared();
        let mut line = Line::new(profile, profile.baud(), &shared);
        line.late = late * MILLI;
        line.show(motion(profile, 2, rate));
        line.run(400 * MILLI);
        line.said.clear();
        let from = line.now;
        line.run(Duration::from_secs(2));
        let turns = line.since(from);
        assert!(turns.len().abs_diff((2.0 * rate) as usize) <= 2, "{} turns at {rate}", turns.len());
        let byte = line.pace.time_of(1);
        let even =
            |(_, lasted): &(Levels, Duration)| lasted.abs_diff(Duration::from_secs_f64(1.0 / rate)) <= byte;
        assert!(turns[1..turns.len() - 1].iter().all(even), "{rate}");
        assert!(
            turns.windows(2).all(|two| two[0].0 != two[1].0) && line.health().rates.unwrap().played == rate
        );
        let is_list = |bytes: &&Vec<u8>| bytes.contains(&254);
        assert_eq!(line.said.iter().filter(is_list).count(), 0);
    }
}

#[test]
fn slow_turns_of_two_frames_are_loaded_again() {
    let profile = Profile::SonicSurface;
    let (shared, _events) = shared();
    let mut line = Line::new(profile, profile.baud(), &shared);
    line.show(motion(profile, 2, 20.0));
    line.run(Duration::from_secs(1));
    // Both buffers are damaged.
    line.carry(&[[254].as_slice(), &[9; 256], &[253, 254], &[9; 256], &[253]].concat());
    line.run(Duration::from_secs(1));
    let from = line.now;
    line.run(Duration::from_secs(1));
    let known = [frame(profile, 0), frame(profile, 1)];
    assert!(line.since(from).iter().all(|(levels, _)| known.contains(levels)));
}

#[test]
fn a_motion_under_modulation_plays_as_many_frames_as_it_says() {
    for (profile, baud, frequency, lost) in SWITCHED {
        let (shared, _events) = shared();
        let mut line = Line::new(profile, baud, &shared);
        line.modulate(Envelope::Square, frequency);
        line.show(motion(profile, 64, 32.0));
        line.run(300 * MILLI);
        let (from, what) = (line.now, format!("{} at {baud} baud, {frequency} Hz", profile.name()));
        line.run(Duration::from_secs(4));
        let rates = line.health().rates.unwrap();
        let dark = Levels::off(profile);
        let number = |levels: &Levels| (0..64).find(|&number| frame(profile, number) == *levels);
        let mut heard: Vec<(usize, usize)> = Vec::new();
        for (levels, _) in line.since(from).iter().filter(|(levels, _)| *levels != dark) {
            let number = number(levels).unwrap_or_else(|| panic!("{what}: torn"));
            match heard.last_mut() {
                Some((last, pulses)) if *last == number => *pulses += 1,
                _ => heard.push((number, 1)),
            }
        }
        let streams = line.since(from).windows(2).any(|two| two[0].0 != dark && two[1].0 != dark);
        let played = heard.len() as f64 / 4.0;
        assert!(streams || (played / rates.played - 1.0).abs() < 0.05, "{what}: {played}, not {rates}");
        if streams {
            // A frame begins when its time has come, or the pulse.
            for (at, levels) in line.shown.iter().filter(|(at, levels)| *at > from && *levels != dark) {
                let asked = (*at - line.wanted.since).as_secs_f64() * 32.0;
                let late = (asked - number(levels).unwrap() as f64).rem_euclid(64.0);
                assert!(late < 1.0 + 0.025 * 32.0, "{what}: {late}");
            }
        }
        for two in heard.windows(2) {
            let step = (two[1].0 + 64 - two[0].0) % 64;
            assert!((1..=4).contains(&step), "{what}: {two:?}");
        }
        let whole = &heard[1..heard.len() - 1];
        assert!(whole.iter().all(|(_, pulses)| *pulses >= lost as usize), "{what}: {whole:?}");
        // In time: a frame is loaded before its pulse begins.
        let played = ((line.now - line.wanted.since).as_secs_f64() * 32.0) as usize % 64;
        let behind = (played + 64 - heard.last().unwrap().0) % 64;
        assert!(behind <= 1 + (32.0 / rates.played) as usize, "{what}: {behind} behind");
    }
}

#[test]
fn a_drag_under_modulation_is_heard() {
    for (profile, baud, frequency, lost) in SWITCHED {
        let (shared, events) = shared();
        let mut line = Line::new(profile, baud, &shared);
        line.modulate(Envelope::Square, frequency);
        line.show(still(profile, 0));
        line.run(300 * MILLI);
        let from = line.now;
        for number in 1..=120 {
            line.show(still(profile, number));
            line.run(16 * MILLI);
        }
        let what = format!("{} at {baud} baud, {frequency} Hz", profile.name());
        let sound = line.sound_since(from);
        assert!(sound > 0.22, "{what}: {sound}");
        let pauses = line.halves_since(from).into_iter().filter(|(sounds, _)| !sounds);
        let pauses: Vec<_> = pauses.map(|(_, lasted)| lasted).collect();
        let usual = Duration::from_secs_f64(1.6 / frequency).max(16 * MILLI);
        // Every two seconds the pause is refreshed, where that skips pulses.
        let allowed = usual + Duration::from_secs_f64(1.5 * f64::from(lost) / frequency);
        let long = pauses.iter().filter(|&&pause| pause > usual).count();
        assert!(long <= 1 && pauses.iter().all(|&pause| pause < allowed), "{what}: silent for {pauses:?}");
        line.run(100 * MILLI);
        let last = line.since(line.now - 90 * MILLI);
        assert!(last.iter().any(|(levels, _)| *levels == frame(profile, 120)), "{what}: not the last");
        assert!(line.health().in_place && notices(&events).len() == 1);
        let latency = line.health().latency.unwrap();
        let load = line.pace.time_of(stock::load(&frame(profile, 1)).len());
        assert!((load..2 * allowed).contains(&latency.median), "{what}: {latency:?}");
    }
}

#[test]
fn an_idle_line_is_given_the_frame_of_now() {
    let profile = Profile::SonicSurface;
    let (shared, _events) = shared();
    let wanted = shared.wanted();
    let content = Arc::new(motion(profile, 16, 40.0));
    let rhythm = Rhythm::new(0.5, 6 * MILLI, MILLI);
    let mut now = wanted.since;
    let mut pulses = Pulses::new(rhythm, true, &content, &wanted, now);
    loop {
        match pulses.next(now, now) {
            Act::Watch(due) => now = due,
            act => pulses.done(act, now, now + 6 * MILLI),
        }
        if pulses.next(now, now) == Act::Show {
            pulses.done(Act::Show, now, now);
            break;
        }
    }
    // Whatever was on is followed by half a period of silence.
    assert_eq!(now - wanted.since, 6 * MILLI + rhythm.half - MILLI);
    let free_at = now;
    now += 260 * MILLI;
    let frame = content.at(now - wanted.since).0;
    assert_eq!(pulses.next(now, free_at), Act::Stream((wanted.generation, frame)));
}

#[test]
fn slow_modulation_streams_a_motion_and_ends_in_time() {
    let profile = Profile::SonicSurface;
    let (shared, _events) = shared();
    let mut line = Line::new(profile, 230_400, &shared);
    line.modulate(Envelope::Square, 2.0);
    line.show(motion(profile, 16, 40.0));
    line.run(400 * MILLI);
    let from = line.now;
    line.run(Duration::from_secs(4));
    for (sounds, lasted) in line.halves_since(from) {
        assert!(lasted.abs_diff(250 * MILLI) < 100 * MICRO, "{sounds}: {lasted:?}");
    }
    let loud = line.since(from).iter().filter(|(levels, _)| *levels != Levels::off(profile)).count();
    assert!((60..=84).contains(&loud), "{loud} frames of 80 while it sounds");
    assert!(line.since(from).iter().all(|(_, time)| *time < 275 * MILLI));
    // Without waiting for the end of a pulse.
    line.stop();
    let from = line.now;
    line.run(60 * MILLI);
    assert!(
        line.playing() == Levels::off(profile) && line.sound_since(from) < 0.6,
        "{}",
        line.sound_since(from)
    );
}

#[test]
fn the_first_pulse_has_the_frame_of_its_time() {
    let profile = Profile::SonicSurface;
    let (shared, _events) = shared();
    let mut line = Line::new(profile, 230_400, &shared);
    line.modulate(Envelope::Square, 2.0);
    line.show(motion(profile, 64, 40.0));
    while line.shown.len() < 2 {
        line.turn(line.now + MILLI);
    }
    let (at, levels) = &line.shown[1];
    let number = ((*at - line.wanted.since).as_secs_f64() * 40.0) as usize;
    assert!(number > 9 && *levels == frame(profile, number), "frame {number} is due at first");
}

#[test]
fn a_stop_in_sound_shows_no_frame_of_before() {
    let profile = Profile::SonicSurface;
    let known: Vec<_> = (0..64).map(|number| frame(profile, number)).chain([Levels::off(profile)]).collect();
    // Silence is hidden while the first frame of a pulse sounds, and an older frame later.
    for sound in [Duration::ZERO, 60 * MILLI] {
        let (shared, _events) = shared();
        let mut line = Line::new(profile, 230_400, &shared);
        line.modulate(Envelope::Square, 2.0);
        line.show(motion(profile, 64, 40.0));
        while line.shown.len() < 2 {
            line.turn(line.now + MILLI);
        }
        line.run(sound);
        line.stop();
        line.run(60 * MILLI);
        let place = |levels: &Levels| known.iter().position(|known| known == levels).unwrap();
        let shown: Vec<_> = line.shown[1..].iter().map(|(_, levels)| place(levels)).collect();
        assert!(shown.ends_with(&[64]) && shown.is_sorted(), "after {sound:?}: {shown:?}");
    }
}

#[test]
fn another_frequency_begins_its_own_pulses_and_figures() {
    let profile = Profile::SonicSurface;
    let (shared, events) = shared();
    let mut line = Line::new(profile, 1_000_000, &shared);
    line.show(still(profile, 5));
    for (frequency, half) in [(100.0, 5 * MILLI), (50.0, 10 * MILLI)] {
        line.modulate(Envelope::Sine, frequency);
        line.run(Duration::from_secs(1));
        let swaps = line.health().swaps.unwrap();
        assert!(
            swaps.median.abs_diff(half) < 30 * MICRO && swaps.jitter < 30 * MICRO,
            "{frequency}: {swaps:?}"
        );
        assert_eq!(notices(&events).len(), 1);
    }
    // Streamed frames leave nothing to repeat in every pulse.
    line.modulate(Envelope::Square, 2.0);
    line.show(motion(profile, 8, 40.0));
    line.run(Duration::from_secs(1));
    line.show(still(profile, 6));
    line.run(Duration::from_secs(1));
    line.said.clear();
    line.run(Duration::from_secs(4));
    let lists = line.said.iter().filter(|bytes| bytes.contains(&254)).count();
    assert!((12..=18).contains(&lists), "{lists} lists in 8 pulses");
}

#[test]
fn a_board_with_one_buffer_is_not_switched_faster_than_its_line() {
    let profile = Profile::Acoustophoretic512;
    let fastest = 250_000.0 / (20.0 * profile.frame_bytes() as f64);
    for (frequency, is_switched) in [(fastest, true), (fastest + 0.5, false)] {
        let (shared, events) = shared();
        let mut line = Line::new(profile, 250_000, &shared);
        line.modulate(Envelope::Square, frequency);
        line.show(still(profile, 5));
        line.run(300 * MILLI);
        let from = line.now;
        line.run(Duration::from_secs(1));
        assert_eq!(line.sound_since(from) < 0.6, is_switched, "{frequency}");
        let said = notices(&events).join(" ");
        let refused = format!("but {fastest:.0} times at most");
        assert_eq!(said.contains(&refused), !is_switched, "{said}");
    }
}

#[test]
fn a_wish_is_in_place_when_its_own_frame_sounds() {
    for (profile, baud, frequency, _) in SWITCHED {
        let (shared, _events) = shared();
        let mut line = Line::new(profile, baud, &shared);
        line.modulate(Envelope::Square, frequency);
        for number in 1..10 {
            line.show(still(profile, number));
            let from = line.now;
            while !line.health().in_place {
                line.turn(line.now + MILLI);
                assert!(line.now - from < Duration::from_secs(5));
            }
            line.pass(line.now + line.pace.backlog(line.now));
            let what = format!("{} at {baud} baud, {frequency} Hz", profile.name());
            assert!(line.playing() == frame(profile, number), "{what}: frame {number} is not heard");
            let pause = line.chance.u32(1..20) * MILLI;
            line.run(pause);
        }
    }
}

#[test]
fn a_frame_loaded_too_late_for_a_pulse_waits_for_the_next() {
    let (shared, _events) = shared();
    let wanted = shared.wanted();
    let content = Arc::new(still(Profile::SonicSurface, 3));
    let rhythm = Rhythm::new(10.0, 9 * MILLI, MILLI);
    // The swap takes a millisecond after the frame.
    for (early, later) in [(MILLI, 0), (MILLI - MICRO, 1), (Duration::ZERO, 1)] {
        let now = wanted.since;
        let mut pulses = Pulses::new(rhythm, true, &content, &wanted, now);
        pulses.done(Act::Darken, now, now);
        let due = now + rhythm.half;
        pulses.done(Act::Load((wanted.generation, 0)), now, due - early);
        let shown = due + 2 * rhythm.half * later - rhythm.show;
        assert_eq!(pulses.next(now, due - early), Act::Watch(shown), "{early:?} before the pulse");
    }
}

#[test]
fn both_buffers_are_filled_again_seldom_and_while_there_is_time() {
    let (shared, _events) = shared();
    let wanted = shared.wanted();
    let content = Arc::new(still(Profile::SonicSurface, 3));
    let rhythm = Rhythm::new(10.0, 9 * MILLI, MILLI);
    for (rest, fits) in [(10 * MILLI, true), (10 * MILLI - MICRO, false)] {
        let (mut now, mut acts) = (wanted.since, Vec::new());
        let mut pulses = Pulses::new(rhythm, true, &content, &wanted, now);
        while acts.iter().filter(|act| **act == Act::Show).count() < 3 {
            match pulses.next(now, now) {
                Act::Watch(due) => now = due,
                act => {
                    pulses.done(act, now, now + MILLI);
                    acts.push(act);
                }
            }
        }
        let load = Act::Load((wanted.generation, 0));
        let swapped = [Act::Show, Act::ShowDark, Act::Show, Act::ShowDark, Act::Show];
        assert!(acts[..2] == [Act::Darken, load] && acts[2..] == swapped, "{acts:?}");
        // The third pulse: both buffers were filled more than 250 ms ago.
        let dark_at = now + rhythm.show + rhythm.half;
        let next = if fits { Act::LoadDark } else { Act::Watch(dark_at - rhythm.show) };
        assert_eq!(pulses.next(dark_at - rest, dark_at - rest), next, "{rest:?} before the pause");
    }
}

#[test]
fn a_late_pause_leaves_out_the_pulse_that_would_be_cut_short() {
    // A frame takes 2.6 ms of a half period of 3.3 ms.
    let (profile, frequency) = (Profile::Acoustophoretic512, 150.0);
    let (shared, _events) = shared();
    let mut line = Line::new(profile, 2_000_000, &shared);
    line.modulate(Envelope::Square, frequency);
    line.show(motion(profile, 8, 2.0 * frequency));
    line.run(20 * MILLI);
    let (from, half) = (line.now, Duration::from_secs_f64(0.5 / frequency));
    let dark = Levels::off(profile);
    for late in 0..20 {
        for sounds in [false, true] {
            while (line.shown.last().unwrap().1 != dark) != sounds {
                line.turn(line.now + 300 * MICRO);
            }
        }
        // A busy computer, while it sounds.
        line.pass(line.now + half * late / 10);
    }
    line.run(10 * MILLI);
    let sounds: Vec<_> = line.halves_since(from).into_iter().filter(|(sounds, _)| *sounds).collect();
    assert!(sounds.len() >= 20 && sounds.iter().all(|(_, time)| *time + 30 * MICRO > half), "{sounds:?}");
}

#[test]
fn the_longest_frame_of_a_motion_sets_its_rhythm() {
    let profile = Profile::UltrainoSimpleFpga;
    let mut frames: Vec<_> = (0..3).map(|number| frame(profile, number)).collect();
    // A frame with amplitudes has twice the bytes.
    frames[1].channels[0] = profile.level(0.5, 0.0);
    let longest = stock::frame(&frames[1]).len();
    assert!(longest > 500 && stock::frame(&frames[0]).len() < 300);
    let (shared, _events) = shared();
    let mut line = Line::new(profile, 230_400, &shared);
    line.modulate(Envelope::Square, 2.0);
    line.show(Content::Motion { frames, rate: 1000.0 });
    line.run(10 * MILLI);
    let rates = line.health().rates.unwrap();
    assert!((rates.played - 23_040.0 / longest as f64).abs() < 1e-3, "{rates}");
}
