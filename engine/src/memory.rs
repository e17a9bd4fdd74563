//! Checks and reserves memory for pictures and large tables before the work begins.
//!
//! Linux overcommits memory and kills a process that uses too much of it: a successful allocation proves nothing.

use std::sync::{Condvar, Mutex, PoisonError};

/// Whether this process may use `bytes` more and the machine has them. Unknown limits count as sufficient.
pub fn holds(bytes: usize) -> bool {
    let figures = std::fs::read_to_string("/proc/meminfo").ok();
    let left = figures.as_deref().and_then(left);
    may_be_reserved(bytes) && left.is_none_or(|left| bytes as u64 <= left)
}

/// Bytes granted without checks.
const LARGE: usize = 32 << 20;

/// Total reservation of all threads.
static RESERVED: Mutex<usize> = Mutex::new(0);
static RELEASED: Condvar = Condvar::new();

/// Reserved memory for the tables of one computation; released on drop.
#[derive(Debug)]
#[must_use]
pub struct Room(usize);

/// Reserves memory in addition to other threads' reservations, waiting for their release if necessary. `None` if it
/// would not fit even then. A thread with a reservation must not request more.
pub fn reserve(bytes: usize) -> Option<Room> {
    if bytes < LARGE {
        return Some(Room(0));
    }
    let mut reserved = RESERVED.lock().unwrap_or_else(PoisonError::into_inner);
    while !holds(bytes.saturating_add(*reserved)) {
        if *reserved == 0 {
            return None;
        }
        reserved = RELEASED.wait(reserved).unwrap_or_else(PoisonError::into_inner);
    }
    *reserved += bytes;
    Some(Room(bytes))
}

impl Drop for Room {
    fn drop(&mut self) {
        *RESERVED.lock().unwrap_or_else(PoisonError::into_inner) -= self.0;
        RELEASED.notify_all();
    }
}

/// Whether the limits of this process (`ulimit`) allow `bytes` more.
fn may_be_reserved(bytes: usize) -> bool {
    let mut room = Vec::<u8>::new();
    let is_reserved = room.try_reserve_exact(bytes).is_ok();
    // Otherwise the compiler may remove the unused allocation.
    std::hint::black_box(&mut room);
    is_reserved
}

/// Bytes that programs can still use, swap included, from the text of /proc/meminfo.
fn left(figures: &str) -> Option<u64> {
    let bytes = |name: &str| {
        let figure = figures.lines().find_map(|line| line.strip_prefix(name))?;
        let kibibytes: u64 = figure.trim().strip_suffix(" kB")?.parse().ok()?;
        kibibytes.checked_mul(1024)
    };
    bytes("MemAvailable:")?.checked_add(bytes("SwapFree:").unwrap_or(0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn available_memory_and_free_swap_are_left() {
        let figures = "MemTotal:  900 kB\nMemFree:  100 kB\nMemAvailable:    300 kB\nSwapTotal: 70 kB\n";
        assert_eq!(left(figures), Some(300 << 10));
        assert_eq!(left(&format!("{figures}SwapFree:       50 kB\n")), Some(350 << 10));
        for unknown in
            ["", "MemFree: 100 kB\n", "MemAvailable: much\n", "MemAvailable: 99999999999999999999 kB\n"]
        {
            assert_eq!(left(unknown), None, "{unknown}");
        }
    }

    #[test]
    fn room_that_is_never_there_is_refused_and_other_room_is_given_back() {
        assert!(reserve(usize::MAX / 4).is_none());
        let room = reserve(LARGE).unwrap();
        // More than is free beside that reservation: the thread waits for its release, then is refused.
        let waiting = std::thread::Builder::new().spawn(|| reserve(usize::MAX / 4).is_none()).unwrap();
        drop(room);
        assert!(waiting.join().unwrap());
        assert_eq!(*RESERVED.lock().unwrap(), 0);
    }
}
