//! A bounded queue that drops its oldest: whoever fills it never waits.

use std::collections::VecDeque;
use std::sync::mpsc::RecvTimeoutError;
use std::time::Duration;

use parking_lot::{Condvar, Mutex};

/// A queue of at most `capacity` items between two threads.
#[derive(Debug)]
pub struct Outbox<T> {
    state: Mutex<State<T>>,
    filled: Condvar,
    capacity: usize,
}

#[derive(Debug)]
struct State<T> {
    queue: VecDeque<T>,
    dropped: u64,
    closed: bool,
}

impl<T> Outbox<T> {
    /// An empty queue for `capacity` items, at least one.
    pub fn new(capacity: usize) -> Self {
        Self {
            state: Mutex::new(State { queue: VecDeque::with_capacity(capacity), dropped: 0, closed: false }),
            filled: Condvar::new(),
            capacity: capacity.max(1),
        }
    }

    /// Adds an item; when the queue is full the oldest goes and is counted.
    pub fn push(&self, item: T) {
        let mut state = self.state.lock();
        if state.queue.len() >= self.capacity {
            state.queue.pop_front();
            state.dropped += 1;
        }
        state.queue.push_back(item);
        self.filled.notify_one();
    }

    /// Whether the next item would cost the oldest.
    pub fn is_full(&self) -> bool {
        self.state.lock().queue.len() >= self.capacity
    }

    /// Takes the oldest item, waiting for one up to `limit`; the error says whether one may still come.
    pub fn take(&self, limit: Duration) -> Result<T, RecvTimeoutError> {
        let mut state = self.state.lock();
        self.filled.wait_while_for(&mut state, |state| state.queue.is_empty() && !state.closed, limit);
        let none = if state.closed { RecvTimeoutError::Disconnected } else { RecvTimeoutError::Timeout };
        state.queue.pop_front().ok_or(none)
    }

    /// Counts an item that was taken but could not be used.
    pub fn count_dropped(&self) {
        self.state.lock().dropped += 1;
    }

    /// Items that never reached their reader.
    pub fn dropped(&self) -> u64 {
        self.state.lock().dropped
    }

    /// Says that nothing more will come; what waits can still be taken.
    pub fn close(&self) {
        self.state.lock().closed = true;
        self.filled.notify_all();
    }

    /// Whether nothing more will come, or be taken.
    pub fn is_closed(&self) -> bool {
        self.state.lock().closed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stalled_screen_costs_the_oldest_frames_and_they_are_counted() {
        let outbox = Outbox::new(3);
        (0..3).for_each(|frame| outbox.push(frame));
        assert!(outbox.is_full() && outbox.dropped() == 0, "a sender that can wait learns it before anything is lost");
        (3..10).for_each(|frame| outbox.push(frame));
        assert_eq!(outbox.dropped(), 7);
        assert_eq!(outbox.take(Duration::ZERO), Ok(7));
        assert!(!outbox.is_full());
    }

    #[test]
    fn frames_that_wait_are_still_shown_after_closing() {
        let outbox = Outbox::new(3);
        assert_eq!(outbox.take(Duration::ZERO), Err(RecvTimeoutError::Timeout));
        outbox.push('b');
        outbox.close();
        assert_eq!(outbox.take(Duration::ZERO), Ok('b'));
        assert_eq!(outbox.take(Duration::ZERO), Err(RecvTimeoutError::Disconnected));
    }
}
