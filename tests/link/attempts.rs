//! Attempts to open a port.

use std::fs;
use std::time::{Duration, Instant};

use sonoglyph::device::link::{Event, Link, Settings};
use sonoglyph::device::profile::Profile;

use crate::PATIENCE;

#[test]
fn a_missing_port_is_tried_again_after_a_pause() {
    const PAUSE: Duration = Duration::from_millis(250);
    let folder = tempfile::tempdir().unwrap();
    let port = folder.path().join("port");
    let appears = port.clone();
    // The next attempt then has another reason to fail, of which the link tells.
    let notify = move || drop(fs::write(&appears, ""));
    let begun = Instant::now();
    let settings = Settings { port, profile: Profile::Native, baud: None };
    let link = Link::open(settings, Box::new(notify)).unwrap();
    assert!(matches!(link.event_within(PATIENCE), Some(Event::Lost(_))));
    let next = link.event_within(PAUSE / 4);
    assert!(next.is_none() || begun.elapsed() >= PAUSE, "{next:?}");
}
