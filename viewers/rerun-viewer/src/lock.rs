//! The lock on what two threads share.

use std::sync::{Mutex, MutexGuard, PoisonError};

/// What is guarded, though a thread may have panicked with it: each leaves it whole between any two of its steps.
pub fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
