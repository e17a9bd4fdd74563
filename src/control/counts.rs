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
    /// Packets and messages that came.
    pub packets: u64,
    /// That changed the scene or what becomes of it.
    pub changes: u64,
    /// That asked for what cannot be.
    pub refused: u64,
    /// That are nothing of the protocol.
    pub malformed: u64,
    /// From who has not given the token.
    pub strangers: u64,
    pub answers: u64,
    /// That no answer was given to, since too many came.
    pub unanswered: u64,
    /// WebSocket connections that were let in.
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
