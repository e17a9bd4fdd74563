//! The desk wakes those who wait for a change, and the loop solves only what is wanted.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::time::Duration;

use sonoglyph::control::desk::Desk;
use sonoglyph::control::edit::Edit;
use sonoglyph::control::live::Live;

use crate::waiting::{PATIENCE, eventually};
use crate::{TWO, scene};

#[test]
fn every_change_and_the_end_wake_one_who_waits_without_limit() {
    // Many times, since a waiting thread may be late for a change, which it then need not wait for.
    for _ in 0..30 {
        let desk = Arc::new(Desk::new(Arc::new(scene(TWO)), Box::new(|| {})));
        let (sender, waits) = sync_channel(1);
        let its = Arc::clone(&desk);
        let wait = move || {
            while !its.is_closing() {
                let generation = its.generation();
                sender.send(generation).unwrap();
                its.wait(generation, Duration::MAX);
            }
        };
        std::thread::Builder::new().name("waiting".to_owned()).spawn(wait).unwrap();
        assert_eq!(waits.recv_timeout(PATIENCE), Ok(1));
        desk.change(&[Edit::Stop]).unwrap();
        assert_eq!(waits.recv_timeout(PATIENCE), Ok(2), "woken by a change");
        let (wish, generation) = desk.wish();
        desk.put(generation, wish).unwrap();
        assert_eq!(waits.recv_timeout(PATIENCE), Ok(3), "woken by the user's change");
        desk.close();
        assert_eq!(waits.recv_timeout(PATIENCE), Err(RecvTimeoutError::Disconnected), "woken by the end");
    }
}

#[test]
fn the_author_of_a_change_tells_of_it_and_of_no_refused_one() {
    let told = Arc::new(AtomicUsize::new(0));
    let its = Arc::clone(&told);
    let notify = move || {
        its.fetch_add(1, Ordering::Relaxed);
    };
    let desk = Desk::new(Arc::new(scene(TWO)), Box::new(notify));
    for (change, expected) in [(Edit::Send(true), 1), (Edit::Remove(9), 1), (Edit::Clear, 2)] {
        let is_refused = desk.change(std::slice::from_ref(&change)).is_err();
        assert_eq!(is_refused, change == Edit::Remove(9));
        assert_eq!((told.load(Ordering::Relaxed), desk.generation()), (expected, expected as u64 + 1));
    }
}

#[test]
fn without_a_board_no_frames_of_a_motion_are_solved() {
    let text = "format = 1\n[[target]]\nat = [0, 0, 0.1]\n[motion]\npath = \"circle\"\nframes = 4\n";
    let desk = Arc::new(Desk::new(Arc::new(scene(text)), Box::new(|| {})));
    let mut live = Live::new(Arc::clone(&desk), None);
    for sends in [false, true] {
        desk.change(&[Edit::Motion(true), Edit::Send(sends)]).unwrap();
        eventually("a drive", || {
            live.turn();
            desk.report().solution.is_some()
        });
        assert!(!desk.report().is_solving, "sends: {sends}");
    }
}
