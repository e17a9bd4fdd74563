//! Counts of received messages and their outcomes.

use std::fmt;
use std::sync::atomic::{AtomicU64, Ordering};

/// Counted by all threads of a server.
#[derive(Debug, Default)]
pub struct Counts {
    pub packets: Count,
    pub changes: Count,
    pub refused: Count,
    pub malformed: Count,
    pub strangers: Count,
    pub answers: Count,
    pub unanswered: Count,
    pub connections: Count,
}

#[derive(Debug, Default)]
pub struct Count(AtomicU64);

impl Count {
    pub fn add(&self) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }

    pub fn get(&self) -> u64 {
        self.0.load(Ordering::Relaxed)
    }
}

/// Counts at a moment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Received packets and messages.
    pub packets: u64,
    /// Messages that changed the scene or its playback.
    pub changes: u64,
    /// Refused messages.
    pub refused: u64,
    /// Malformed messages.
    pub malformed: u64,
    /// Messages without the token.
    pub strangers: u64,
    pub answers: u64,
    /// Messages left unanswered by rate limits.
    pub unanswered: u64,
    /// Accepted WebSocket connections.
    pub connections: u64,
}

impl Counts {
    pub fn tally(&self) -> Tally {
        let Self { packets, changes, refused, malformed, strangers, answers, unanswered, connections } = self;
        Tally {
            packets: packets.get(),
            changes: changes.get(),
            refused: refused.get(),
            malformed: malformed.get(),
            strangers: strangers.get(),
            answers: answers.get(),
            unanswered: unanswered.get(),
            connections: connections.get(),
        }
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} packets, {} changes, {} refused, {} malformed, {} from strangers",
            self.packets, self.changes, self.refused, self.malformed, self.strangers
        )
    }
}
