//! Locks of values shared between tasks.

use std::sync::{Mutex, MutexGuard, PoisonError};

/// Locked values stay consistent when a thread panics.
pub fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
