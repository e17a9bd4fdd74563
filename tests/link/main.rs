//! The link with virtual boards over pseudo-terminals: whole frames only, and recovery from every fault.

#![cfg(unix)]
#![expect(clippy::unwrap_used, reason = "a test's helper may panic")]

mod attempts;
#[cfg(target_os = "linux")]
mod boot;
mod commands;
mod motions;
#[path = "../requirement/mod.rs"]
mod requirement;
#[path = "../running/mod.rs"]
mod running;
#[path = "../waiting/mod.rs"]
mod waiting;

use std::process::Command;
use std::sync::mpsc::{Receiver, sync_channel};
use std::time::{Duration, Instant};

use sonoglyph::device::board::faults::Faults;
use sonoglyph::device::board::{Board, Setup, Shown};
use sonoglyph::device::declaration::Level;
use sonoglyph::device::health::State;
use sonoglyph::device::levels::Levels;
use sonoglyph::device::link::{Content, Event, Link, Settings};
use sonoglyph::device::port::{Port, PortError};
use sonoglyph::device::profile::Profile;
use sonoglyph::device::stock;
use sonoglyph::device::task::finish;
use waiting::{PATIENCE, eventually};

/// A frame with its number in every element: a torn one would hold two numbers.
fn numbered(profile: Profile, number: u16) -> Levels {
    let delay = number % profile.levels();
    let other = number / profile.levels() % profile.levels();
    let level = |n| Level { delay: if n % 2 == 0 { delay } else { other }, amplitude: full(profile) };
    Levels { profile, channels: (0..profile.elements()).map(|n| Some(level(n))).collect() }
}

fn full(profile: Profile) -> u16 {
    profile.level(1.0, 0.0).unwrap().amplitude
}

/// A board, a ready link to it, and the board's output.
struct Pair {
    link: Link,
    board: Board,
    shown: Receiver<Shown>,
}

fn board(setup: Setup) -> (Board, Receiver<Shown>) {
    let (sender, shown) = sync_channel(100_000);
    let watch = move |frame: &Shown| drop(sender.try_send(frame.clone()));
    (Board::start(setup, Box::new(watch)).unwrap(), shown)
}

fn link_to(board: &Board, profile: Profile, baud: Option<u32>) -> Link {
    let settings = Settings { port: board.path().to_owned(), profile, baud };
    Link::open(settings, Box::new(|| {})).unwrap()
}

fn pair_with(setup: Setup, baud: Option<u32>) -> Pair {
    let profile = setup.profile;
    let (board, shown) = board(setup);
    let link = link_to(&board, profile, baud);
    wait_for(&link, |event| matches!(event, Event::Ready(_)));
    Pair { link, board, shown }
}

fn pair(profile: Profile) -> Pair {
    pair_with(Setup::new(profile), None)
}

fn wait_for(link: &Link, wanted: impl Fn(&Event) -> bool) -> Event {
    let until = Instant::now() + PATIENCE;
    while let Some(event) = link.event_within(until.saturating_duration_since(Instant::now())) {
        if wanted(&event) {
            return event;
        }
    }
    panic!("timed out waiting for an event; {:?}", link.health());
}

impl Pair {
    /// All frames shown up to `last`.
    fn shown_until(&self, last: &Levels) -> Vec<Levels> {
        let until = Instant::now() + PATIENCE;
        let mut all = Vec::new();
        while let Ok(shown) = self.shown.recv_timeout(until.saturating_duration_since(Instant::now())) {
            all.push(shown.levels);
            if all.last() == Some(last) {
                return all;
            }
        }
        panic!("the last frame was not shown; {:?}, {:?}", self.link.health(), self.board.report());
    }

    fn is_silent(&self) -> bool {
        is_silent(&self.board)
    }

    fn wait_until_silent(&self) {
        eventually("silence", || self.is_silent());
    }
}

fn is_silent(board: &Board) -> bool {
    board.report().playing.unwrap().drive().amplitudes.iter().all(|&amplitude| amplitude == 0.0)
}

/// Sends frames with this pause; checks that no other frame is shown, and that the last one is.
fn drag(pair: &Pair, profile: Profile, frames: u16, pause: Duration) -> Vec<Levels> {
    let sent: Vec<_> = (0..frames).map(|n| numbered(profile, n * 7 + 1)).collect();
    for levels in &sent {
        pair.link.show(Content::Still(levels.clone()));
        std::thread::sleep(pause);
    }
    let seen = pair.shown_until(sent.last().unwrap());
    for levels in &seen {
        assert!(sent.contains(levels) || *levels == Levels::off(profile), "{}: torn", profile.name());
    }
    seen
}

#[test]
fn frames_arrive_whole_at_every_board_and_silence_at_the_end() {
    std::thread::scope(|scope| {
        for profile in Profile::ALL {
            scope.spawn(move || {
                let pair = pair(profile);
                let seen = drag(&pair, profile, 12, Duration::from_millis(30));
                assert!(seen.len() >= 3, "{}: {} frames", profile.name(), seen.len());
                eventually("sound", || !pair.is_silent());
                let Pair { link, board, .. } = pair;
                drop(link);
                eventually("silence", || is_silent(&board));
                assert_eq!(board.report().spoiled, 0, "{}", profile.name());
            });
        }
    });
}

#[test]
fn a_stock_board_is_ready_after_its_first_silent_frame() {
    // Later frames then do not wait. At this rate it takes half a second.
    let (profile, baud) = (Profile::SonicSurface, 9600);
    let (board, _shown) = board(Setup { baud: Some(baud), ..Setup::new(profile) });
    let begun = Instant::now();
    let link = link_to(&board, profile, Some(baud));
    wait_for(&link, |event| matches!(event, Event::Ready(_)));
    let bits = 10.0 * stock::silence(profile).len() as f64;
    assert!(begun.elapsed().as_secs_f64() >= bits / f64::from(baud), "{:?}", begun.elapsed());
}

#[test]
fn frames_from_before_the_connection_do_not_count_as_latency() {
    for profile in [Profile::Native, Profile::SonicSurface] {
        let (board, shown) = board(Setup::new(profile));
        board.unplug(true);
        let link = link_to(&board, profile, None);
        wait_for(&link, |event| matches!(event, Event::Lost(_)));
        let early = numbered(profile, 1);
        link.show(Content::Still(early.clone()));
        board.unplug(false);
        let pair = Pair { link, board, shown };
        pair.shown_until(&early);
        eventually("a frame in place", || pair.link.health().in_place);
        assert_eq!(pair.link.health().latency, None, "{}", profile.name());
        pair.link.show(Content::Still(numbered(profile, 2)));
        eventually("a latency", || pair.link.health().latency.is_some());
    }
}

#[test]
fn the_newest_frame_wins() {
    let pair = pair(Profile::SonicSurface);
    let seen = drag(&pair, Profile::SonicSurface, 300, Duration::ZERO);
    assert!(seen.len() < 30, "{} frames were sent instead of the newest", seen.len());
}

#[test]
fn the_native_device_plays_no_corrupted_frame() {
    let bad = |faults: Faults| {
        let setup = Setup { faults, ..Setup::new(Profile::Native) };
        let pair = pair_with(setup, None);
        // Until enough frames were corrupted, on a machine of any speed.
        let until = Instant::now() + PATIENCE;
        while pair.board.report().spoiled < 5 || pair.link.health().refused == 0 {
            assert!(Instant::now() < until, "{:?}, {:?}", pair.link.health(), pair.board.report());
            drag(&pair, Profile::Native, 20, Duration::from_millis(4));
        }
    };
    std::thread::scope(|scope| {
        scope.spawn(|| bad(Faults { drop: 5e-4, ..Faults::default() }));
        scope.spawn(|| bad(Faults { flip: 5e-4, ..Faults::default() }));
        scope.spawn(|| bad(Faults { insert: 5e-4, ..Faults::default() }));
        scope.spawn(|| bad(Faults { burst: 2e-4, ..Faults::default() }));
    });
}

/// What a board has sent before anything was said to it.
fn greeting(board: &Board) -> Vec<u8> {
    let mut port = finish(Port::open(board.path(), Profile::SonicSurface.baud())).unwrap();
    finish(port.read(Duration::from_secs(2))).unwrap()
}

#[test]
fn garbage_is_sent_whenever_a_board_is_plugged_in() {
    let garbage = Faults { garbage: true, ..Faults::default() };
    let (board, _shown) = board(Setup { faults: garbage, ..Setup::new(Profile::SonicSurface) });
    assert!(!greeting(&board).is_empty());
    board.unplug(true);
    eventually("no port", || !board.path().exists());
    board.unplug(false);
    eventually("the port", || board.path().exists());
    assert!(!greeting(&board).is_empty());
}

#[test]
fn a_board_takes_bytes_no_faster_than_its_line_carries_them() {
    const BYTES: usize = 200;
    let (board, _shown) = board(Setup { baud: Some(9600), ..Setup::new(Profile::SonicSurface) });
    let mut port = finish(Port::open(board.path(), 9600)).unwrap();
    let begun = Instant::now();
    finish(port.write(&[0; BYTES])).unwrap();
    eventually("all bytes", || board.report().bytes == BYTES as u64);
    let carried = BYTES as f64 * 10.0 / 9600.0;
    assert!(begun.elapsed().as_secs_f64() > 0.9 * carried, "{:?} of {carried} s", begun.elapsed());
}

#[test]
fn garbage_at_the_start_does_no_harm() {
    let garbage = Faults { garbage: true, ..Faults::default() };
    for profile in [Profile::Native, Profile::SonicSurface] {
        let pair = pair_with(Setup { faults: garbage, ..Setup::new(profile) }, None);
        drag(&pair, profile, 3, Duration::from_millis(30));
    }
}

#[test]
fn a_replugged_board_plays_only_the_newest_frame() {
    std::thread::scope(|scope| {
        for profile in [Profile::Native, Profile::SonicSurface, Profile::UltrainoMega64] {
            scope.spawn(move || {
                let pair = pair(profile);
                drag(&pair, profile, 5, Duration::from_millis(30));
                eventually("a frame in place", || pair.link.health().in_place);
                pair.board.unplug(true);
                let lost = wait_for(&pair.link, |event| matches!(event, Event::Lost(_)));
                let Event::Lost(why) = &lost else { panic!() };
                assert!(why.contains("lost") || why.contains("no port"), "{why}");
                assert!(matches!(pair.link.health().state, State::Lost(_)));
                assert!(
                    !pair.link.health().in_place,
                    "{}: a lost board has no frame in place",
                    profile.name()
                );
                while pair.shown.try_recv().is_ok() {}
                // Frames continue while the board is lost.
                for n in 100..105 {
                    pair.link.show(Content::Still(numbered(profile, n)));
                }
                assert!(!pair.link.health().in_place, "{}: a request is not in place yet", profile.name());
                pair.board.unplug(false);
                wait_for(&pair.link, |event| matches!(event, Event::Ready(_)));
                let newest = numbered(profile, 104);
                let seen = pair.shown_until(&newest);
                let old = seen.iter().find(|levels| **levels != newest && **levels != Levels::off(profile));
                assert_eq!(old, None, "{}: stale", profile.name());
                eventually("sound", || !pair.is_silent());
                eventually("a frame in place again", || pair.link.health().in_place);
                let events = pair.board.report().events;
                let of_line: Vec<_> = events.iter().filter(|event| event.contains("plugged")).collect();
                assert_eq!(of_line, ["unplugged", "plugged in"], "{}", profile.name());
            });
        }
    });
}

/// The line stays free for the next frame. A stock board, which does not answer, hears it four times a second.
#[test]
fn a_still_frame_is_sent_once_or_seldom() {
    std::thread::scope(|scope| {
        for (profile, most) in [(Profile::Native, 1), (Profile::SonicSurface, 4)] {
            scope.spawn(move || {
                let pair = pair(profile);
                pair.link.show(Content::Still(numbered(profile, 3)));
                eventually("a frame in place", || pair.link.health().in_place);
                std::thread::sleep(Duration::from_millis(100));
                let before = pair.board.report().bytes;
                std::thread::sleep(Duration::from_millis(300));
                let more = pair.board.report().bytes - before;
                let frame = profile.elements() as u64;
                assert!(more < most * frame, "{}: {more} bytes after the frame", profile.name());
            });
        }
    });
}

#[test]
fn a_stall_is_reported_and_recovered_from() {
    std::thread::scope(|scope| {
        for profile in [Profile::Native, Profile::SonicSurface] {
            scope.spawn(move || {
                let pair = pair(profile);
                drag(&pair, profile, 3, Duration::from_millis(20));
                pair.board.stall(true);
                let until = Instant::now() + PATIENCE;
                let mut n = 0;
                // Frames fill the line until the port accepts no more.
                while !matches!(pair.link.health().state, State::Lost(_)) {
                    assert!(Instant::now() < until);
                    pair.link.show(Content::Still(numbered(profile, n)));
                    n += 1;
                    std::thread::sleep(Duration::from_millis(10));
                }
                pair.board.stall(false);
                wait_for(&pair.link, |event| matches!(event, Event::Ready(_)));
                let newest = numbered(profile, 999);
                pair.link.show(Content::Still(newest.clone()));
                pair.shown_until(&newest);
            });
        }
    });
}

#[test]
fn a_wrong_bit_rate_or_board_is_reported_and_stays_silent() {
    let (deaf, shown) = board(Setup { baud: Some(57_600), ..Setup::new(Profile::Native) });
    let link = link_to(&deaf, Profile::Native, None);
    link.show(Content::Still(numbered(Profile::Native, 1)));
    let Event::Lost(why) = wait_for(&link, |event| matches!(event, Event::Lost(_))) else { panic!() };
    assert!(why.contains("does not answer"), "{why}");
    assert!(shown.try_recv().is_err() && deaf.report().wrong_baud > 0);

    // An Arduino sends back most bytes.
    let setup = Setup { baud: Some(2_000_000), boot_loader: None, ..Setup::new(Profile::UltrainoMega64) };
    let (mega, _shown) = board(setup);
    let link = link_to(&mega, Profile::Native, None);
    let Event::Lost(why) = wait_for(&link, |event| matches!(event, Event::Lost(_))) else { panic!() };
    assert!(why.contains("no native board"), "{why}");
}

#[test]
fn ports_that_cannot_be_opened_give_a_reason() {
    let lost = |path: &std::path::Path| {
        let settings = Settings { port: path.to_owned(), profile: Profile::SonicSurface, baud: None };
        let link = Link::open(settings, Box::new(|| {})).unwrap();
        let Event::Lost(why) = wait_for(&link, |event| matches!(event, Event::Lost(_))) else { panic!() };
        why
    };
    assert!(lost("/dev/there-is-no-such-port".as_ref()).contains("there is no port"));
    assert!(lost(file!().as_ref()).contains("is not a serial port"));
    assert!(lost("/dev/null".as_ref()).contains("is not a serial port"));
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    assert!(lost(&pipe).contains("is not a serial port"));
    let pair = pair(Profile::SonicSurface);
    assert!(lost(pair.board.path()).contains("in use"));
}

#[test]
fn a_port_has_any_bit_rate_and_is_exclusive() {
    let bytes = stock::silence(Profile::SonicSurface);
    for baud in [1200, 115_200, 250_000, 333_333, 3_000_000, 12_000_000] {
        let (board, _shown) = board(Setup { baud: Some(baud), ..Setup::new(Profile::SonicSurface) });
        let mut port = finish(Port::open(board.path(), 57_600)).unwrap();
        assert!(matches!(finish(Port::open(board.path(), baud)), Err(PortError::Busy(_))));
        finish(port.set_baud(baud)).unwrap();
        finish(port.write(&bytes[..10])).unwrap();
        eventually("bytes", || board.report().bytes == 10);
        drop(port);
        let mut port = finish(Port::open(board.path(), baud)).unwrap();
        finish(port.write(&bytes[..10])).unwrap();
        eventually("more bytes", || board.report().bytes == 20);
        assert_eq!(board.report().wrong_baud, 0, "{baud} baud");
    }
}

#[test]
fn a_port_distinguishes_blocked_from_lost_lines() {
    let (board, _shown) = board(Setup::new(Profile::Native));
    let mut port = finish(Port::open(board.path(), Profile::Native.baud())).unwrap();
    assert!(
        finish(port.read(Duration::ZERO)).unwrap().is_empty()
            && finish(port.read(Duration::from_millis(1))).is_ok()
    );
    board.stall(true);
    // More than the line's buffer: the write must not wait for the rest.
    let (sender, written) = sync_channel(1);
    let write = move || drop(sender.send((finish(port.write(&[0; 1 << 20])), port)));
    std::thread::Builder::new().name("writer".to_owned()).spawn(write).unwrap();
    let (written, mut port) = written.recv_timeout(PATIENCE).unwrap();
    assert!(matches!(written, Err(PortError::Stalled(_))));
    board.unplug(true);
    eventually("the loss", || matches!(finish(port.read(Duration::ZERO)), Err(PortError::Lost { .. })));
    assert!(matches!(finish(port.write(&[0])), Err(PortError::Lost { .. })));
    assert!(matches!(finish(Port::open(board.path(), 1200)), Err(PortError::Missing(_))));
}

#[test]
fn the_bit_rate_changes_within_the_device_range() {
    let pair = pair_with(Setup::new(Profile::Native), Some(3_000_000));
    drag(&pair, Profile::Native, 20, Duration::from_millis(2));
    assert_eq!(pair.board.report().wrong_baud, 0);
    drop(pair.link);
    // The device falls back to the default rate, where a new link finds it.
    let link = link_to(&pair.board, Profile::Native, None);
    wait_for(&link, |event| matches!(event, Event::Ready(_)));
    drop(link);
    let link = link_to(&pair.board, Profile::Native, Some(9_000_000));
    let Event::Lost(why) = wait_for(&link, |event| matches!(event, Event::Lost(_))) else { panic!() };
    assert!(why.contains("9000000") && why.contains("8000000"), "{why}");
}

#[test]
fn the_device_reports_its_actual_carrier() {
    let setup = Setup { carrier_millihertz: 39_950_400, phase_bits: 6, ..Setup::new(Profile::Native) };
    let (board, _shown) = board(setup);
    let link = link_to(&board, Profile::Native, None);
    let Event::Ready(found) = wait_for(&link, |event| matches!(event, Event::Ready(_))) else { panic!() };
    assert_eq!((found.carrier, found.phase_bits, found.slots), (39_950.4, Some(6), 64));
}

#[test]
fn the_emergency_stop_holds_until_the_next_frame() {
    let pair = pair(Profile::Native);
    let levels = numbered(Profile::Native, 3);
    pair.link.show(Content::Still(levels.clone()));
    eventually("sound", || !pair.is_silent());
    pair.board.press(true);
    let notice =
        wait_for(&pair.link, |event| matches!(event, Event::Notice(text) if text.contains("emergency")));
    assert!(matches!(notice, Event::Notice(_)));
    pair.wait_until_silent();
    pair.board.press(false);
    std::thread::sleep(Duration::from_millis(200));
    assert!(pair.is_silent(), "silent until the next frame");
    pair.link.show(Content::Still(levels));
    eventually("sound", || !pair.is_silent());
}

#[test]
fn stop_silences_and_keeps_the_link() {
    for profile in [Profile::Native, Profile::SonicSurface, Profile::Acoustophoretic512] {
        let pair = pair(profile);
        drag(&pair, profile, 3, Duration::from_millis(30));
        eventually("sound", || !pair.is_silent());
        pair.link.stop();
        pair.wait_until_silent();
        let next = numbered(profile, 50);
        pair.link.show(Content::Still(next.clone()));
        pair.shown_until(&next);
        eventually("sound", || !pair.is_silent());
    }
}

#[test]
fn a_sender_that_panics_leaves_silence() {
    for profile in [Profile::Native, Profile::SonicSurface] {
        let (board, shown) = board(Setup::new(profile));
        let settings = Settings { port: board.path().to_owned(), profile, baud: None };
        let levels = numbered(profile, 9);
        let send = move || {
            let link = Link::open(settings, Box::new(|| {})).unwrap();
            link.show(Content::Still(levels.clone()));
            while shown.recv_timeout(PATIENCE).unwrap().levels != levels {}
            panic!("on purpose");
        };
        let sender = std::thread::Builder::new().name("sender".to_owned()).spawn(send).unwrap();
        assert_eq!(sender.join().unwrap_err().downcast_ref(), Some(&"on purpose"));
        eventually("silence", || is_silent(&board));
    }
}

#[test]
fn a_pause_that_trips_the_watchdog_is_noticed_and_the_sound_comes_back() {
    let pair = pair(Profile::Native);
    let levels = numbered(Profile::Native, 7);
    pair.link.show(Content::Still(levels.clone()));
    pair.shown_until(&levels);
    eventually("a frame in place", || pair.link.health().in_place);
    pair.board.stall(true);
    std::thread::sleep(Duration::from_millis(400));
    pair.board.stall(false);
    let event = wait_for(&pair.link, |event| matches!(event, Event::Notice(_) | Event::Lost(_)));
    assert!(matches!(&event, Event::Notice(text) if text.contains("watchdog")), "{event:?}");
    eventually("sound", || !pair.is_silent());
    assert_eq!(pair.link.health().state, State::Ready);
}
