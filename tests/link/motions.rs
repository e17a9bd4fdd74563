//! Motions, modulation and several boards on one line: played by the board itself, or streamed at the line's rate.

use std::time::{Duration, Instant};

use sonoglyph::device::board::{Board, Playing, Setup};
use sonoglyph::device::levels::Levels;
use sonoglyph::device::link::{Content, Event};
use sonoglyph::device::profile::Profile;
use sonoglyph::scene::{Envelope, Modulation};

use crate::{PATIENCE, Pair, eventually, is_silent, link_to, numbered, pair, pair_with, wait_for};

#[test]
fn the_native_device_plays_a_motion_by_itself() {
    let pair = pair(Profile::Native);
    let frames: Vec<_> = (0..10).map(|n| numbered(Profile::Native, 25 * n)).collect();
    pair.link.show(Content::Motion { frames: frames.clone(), rate: 50.0 });
    // Element 0 goes through all delays without further frames.
    let phase = || pair.board.report().playing.unwrap().drive().phases[0];
    let sent = || pair.link.health().frames;
    eventually("the upload", || sent() >= 10 && !pair.is_silent());
    let (before, mut phases) = (sent(), Vec::new());
    eventually("ten phases", || {
        let _ = &before;
        phase() != 0.0
    });
    let until = Instant::now() + PATIENCE;
    while phases.len() < 10 && Instant::now() < until {
        let now = (phase() / 0.1).round() as i32;
        if !phases.contains(&now) {
            phases.push(now);
        }
    }
    assert!(phases.len() >= 10 && sent() == before, "{phases:?}, {} frames", sent() - before);
    let until = Instant::now() + Duration::from_millis(150);
    while Instant::now() < until {
        assert!(!pair.is_silent(), "a slot without a frame is played");
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn motions_beyond_a_boards_store_are_streamed() {
    for (profile, count) in [(Profile::Native, 200), (Profile::SonicSurface, 20)] {
        let pair = pair(profile);
        let frames: Vec<_> = (0..count).map(|n| numbered(profile, n)).collect();
        pair.link.show(Content::Motion { frames: frames.clone(), rate: 40.0 });
        let mut seen = Vec::new();
        while seen.len() < 8 {
            let levels = pair.shown.recv_timeout(PATIENCE).unwrap().levels;
            assert!(frames.contains(&levels) || levels == Levels::off(profile), "{}: torn", profile.name());
            if levels != Levels::off(profile) && !seen.contains(&levels) {
                seen.push(levels);
            }
        }
    }
}

#[test]
fn a_motion_beyond_the_lines_rate_is_slowed_down_and_reported() {
    let cases = [
        (Profile::Native, 2_000_000, 64, 50.0, 40_000.0 / 13.0),
        (Profile::Native, 2_000_000, 64, 100.0, 40_000.0 / 7.0),
        (Profile::Native, 460_800, 128, 20.0, 40_000.0 / 31.0),
        (Profile::Native, 115_200, 64, 5.0, 320.0),
        (Profile::SonicSurface, 230_400, 64, 50.0, 230_400.0 / 2580.0),
    ];
    for (profile, baud, count, cycles, played) in cases {
        let pair = pair_with(Setup::new(profile), Some(baud));
        let frames: Vec<_> = (0..count).map(|n| numbered(profile, n)).collect();
        let asked = cycles * f64::from(count);
        pair.link.show(Content::Motion { frames, rate: asked });
        eventually("sound", || !pair.is_silent());
        eventually("a frame in place", || pair.link.health().in_place);
        let rates = pair.link.health().rates.unwrap();
        assert_eq!(rates.asked, asked);
        assert!((rates.played / played - 1.0).abs() < 1e-3, "{cycles} x {count} at {baud}: {rates}");
        if (played / asked - 1.0).abs() > 1e-3 {
            wait_for(
                &pair.link,
                |event| matches!(event, Event::Notice(text) if text.contains("frames/s asked")),
            );
        }
    }
}

/// The rising edges of the first element of all devices, at one moment.
fn rises(board: &Board) -> Vec<u8> {
    let Some(Playing::Pulses { pulses, .. }) = board.report().playing else { return Vec::new() };
    pulses.chunks(256).map(|pulses| pulses[0].rise).collect()
}

#[test]
fn several_native_boards_on_a_line_change_frames_in_the_same_period() {
    let profile = Profile::Natives(3);
    let pair = pair(profile);
    let in_step = |seen: &[u8]| seen.len() == 3 && seen.iter().all(|&rise| rise == seen[0]);
    // Live, with one packet per part.
    for n in 1..20 {
        pair.link.show(Content::Still(numbered(profile, 10 * n)));
        eventually("a frame in place", || pair.link.health().in_place);
        let wanted = pair.board.report().playing.unwrap().drive();
        assert_eq!(wanted.amplitudes.len(), 768);
        // Each board's amplitudes ramp up from its own ENABLE.
        eventually("all alike", || in_step(&rises(&pair.board)));
    }
    let before = pair.link.health().frames;
    // From the boards' stores.
    let frames: Vec<_> = (0..32).map(|n| numbered(profile, 8 * n)).collect();
    // Two periods per frame: a board one period late shows another frame half of the time.
    pair.link.show(Content::Motion { frames, rate: 20_000.0 });
    let mut seen = Vec::new();
    eventually("a motion of all", || {
        let now = rises(&pair.board);
        // During the upload each board still plays its first frame.
        if pair.link.health().frames >= before + 96 {
            assert!(in_step(&now), "{now:?}");
            seen.push(now[0]);
        }
        seen.sort_unstable();
        seen.dedup();
        seen.len() > 10
    });
    // Boards stop at different frames of two, which leaves neither slot free.
    for n in 0..8 {
        let frames = [10 * n + 20, 10 * n + 25].map(|n| numbered(profile, n)).to_vec();
        pair.link.show(Content::Motion { frames, rate: 20_000.0 });
        let mut seen = Vec::new();
        eventually("a motion of two frames", || {
            let now = rises(&pair.board);
            if pair.link.health().in_place && in_step(&now) && !seen.contains(&now[0]) {
                seen.push(now[0]);
            }
            seen.len() > 1
        });
    }
    pair.link.stop();
    pair.wait_until_silent();
}

#[test]
fn a_new_link_clears_the_state_of_an_earlier_one() {
    let first = pair(Profile::Native);
    first.link.modulate(Modulation { shape: Envelope::Square, frequency: 20.0, ..Modulation::default() });
    first.link.show(Content::Still(numbered(Profile::Native, 3)));
    eventually("a dark half", || first.link.health().in_place && first.is_silent());
    let Pair { link, board, .. } = first;
    drop(link);
    let link = link_to(&board, Profile::Native, None);
    wait_for(&link, |event| matches!(event, Event::Ready(_)));
    link.show(Content::Still(numbered(Profile::Native, 4)));
    eventually("sound", || link.health().in_place && !is_silent(&board));
    let until = Instant::now() + Duration::from_millis(150);
    while Instant::now() < until {
        assert!(!is_silent(&board), "the envelope of the first link");
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn a_motion_as_long_as_the_store_replaces_another_and_makes_room_for_a_still() {
    let pair = pair(Profile::Native);
    let frames = |from: u16| (from..from + 64).map(|n| numbered(Profile::Native, n)).collect::<Vec<_>>();
    for from in [0, 64] {
        pair.link.show(Content::Motion { frames: frames(from), rate: 320.0 });
        // Slots change by themselves once all frames are uploaded.
        eventually("64 frames", || pair.link.health().frames >= 64 * (1 + u64::from(from) / 64));
        eventually("a motion", || {
            let Some(Playing::Pulses { pulses, .. }) = pair.board.report().playing else { return false };
            let before = pulses[0].rise;
            std::thread::sleep(Duration::from_millis(20));
            let Some(Playing::Pulses { pulses, .. }) = pair.board.report().playing else { return false };
            pulses[0].rise != before
        });
    }
    // All slots are in play until the motion has stopped, and new frames arrive sooner.
    for number in 200..=300 {
        pair.link.show(Content::Still(numbered(Profile::Native, number)));
    }
    pair.shown_until(&numbered(Profile::Native, 300));
    eventually("a frame in place", || pair.link.health().in_place);
}

#[test]
fn stock_boards_are_modulated_by_swaps() {
    let pair = pair(Profile::SonicSurface);
    let levels = numbered(Profile::SonicSurface, 5);
    pair.link.modulate(Modulation { shape: Envelope::Square, frequency: 100.0, ..Modulation::default() });
    pair.link.show(Content::Still(levels.clone()));
    let dark = Levels::off(Profile::SonicSurface);
    pair.shown_until(&levels);
    // Light and dark alternate, and no other frame appears.
    for n in 0..100 {
        let wanted = if n % 2 == 0 { &dark } else { &levels };
        assert_eq!(pair.shown.recv_timeout(PATIENCE).unwrap().levels, *wanted, "half period {n}");
    }
    assert!(pair.link.health().swaps.is_some());
    // A new frame is inserted, and the pauses stay dark.
    let next = numbered(Profile::SonicSurface, 6);
    pair.link.show(Content::Still(next.clone()));
    let seen = pair.shown_until(&next);
    assert!(seen.iter().all(|seen| [&levels, &dark, &next].contains(&seen)) && seen[seen.len() - 2] == dark);
}

#[test]
fn stock_boards_are_modulated_while_they_move() {
    // At 1 Mbaud a SonicSurface takes a frame in a dark half of 5 ms; at its default rate each frame costs pulses; the
    // other board has one buffer.
    for (profile, baud, lost) in [
        (Profile::SonicSurface, 1_000_000, false),
        (Profile::SonicSurface, 230_400, true),
        (Profile::Acoustophoretic512, 2_000_000, false),
    ] {
        let pair = pair_with(Setup { baud: Some(baud), ..Setup::new(profile) }, Some(baud));
        let frames: Vec<_> = (0..3).map(|n| numbered(profile, n)).collect();
        pair.link.modulate(Modulation { shape: Envelope::Square, frequency: 100.0, ..Modulation::default() });
        pair.link.show(Content::Motion { frames: frames.clone(), rate: 25.0 });
        let notice =
            wait_for(&pair.link, |event| matches!(event, Event::Notice(text) if text.contains("100 times")));
        let costs = matches!(&notice, Event::Notice(text) if text.contains("1 of 4 pulses") && text.contains("11.2 ms"));
        assert_eq!(costs, lost, "{notice:?}");
        // A frame has several pulses, except on a busy machine.
        let dark = Levels::off(profile);
        let repeated = |seen: &[Levels]| {
            let pulses: Vec<_> = seen.iter().filter(|levels| **levels != dark).collect();
            pulses.windows(2).any(|two| *two[0] == frames[1] && *two[1] == frames[1])
        };
        let (mut seen, until) = (Vec::new(), Instant::now() + PATIENCE);
        while !repeated(&seen) {
            assert!(Instant::now() < until, "{}: no frame has two pulses", profile.name());
            seen.extend(pair.shown_until(&frames[1]));
            seen.extend(pair.shown_until(&frames[0]));
        }
        // There is always darkness in between.
        let first = seen.iter().position(|levels| *levels != dark).unwrap();
        for pulse in seen[first..].chunks(2) {
            assert!(
                frames.contains(&pulse[0]) && pulse.get(1).is_none_or(|second| *second == dark),
                "{}",
                profile.name()
            );
        }
        let rates = pair.link.health().rates.unwrap();
        assert!((rates.asked, rates.played) == (25.0, 25.0), "{rates:?}");
    }
}
