//! When ticks are due, and what is made of those that the host let pass.

use shared_types::rig::monotonic_time_ns;

use super::clock::wait_until;

/// Time from the making of a schedule to its first tick, ns.
const LEAD_NS: u64 = 1_000_000;

/// Ticks at a fixed rate on CLOCK_MONOTONIC: tick n is due at origin + n / rate.
#[derive(Clone, Copy, Debug)]
pub struct Schedule {
    origin_ns: u64,
    period_ns: f64,
    next: u64,
}

/// One tick that is served.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tick {
    /// Its number.
    pub number: u64,
    /// Time at which it was due, ns.
    pub due_ns: u64,
    /// Time at which the wait for it ended, ns.
    pub begun_ns: u64,
    /// Ticks since the one that was served before: one, or more after a stall.
    pub elapsed: u64,
}

impl Schedule {
    /// A schedule whose tick 0 is due in a millisecond.
    #[must_use]
    pub fn starting_now(rate_hz: f64) -> Self {
        Self { origin_ns: monotonic_time_ns() + LEAD_NS, period_ns: 1e9 / rate_hz, next: 0 }
    }

    /// Waits for the next tick. After a stall the newest tick that is due is served; those before it are missed.
    pub fn wait(&mut self) -> Tick {
        let begun_ns = wait_until(self.due_ns(self.next));
        let number = self.newest_at(begun_ns).max(self.next);
        let elapsed = number - self.next + 1;
        self.next = number + 1;
        Tick { number, due_ns: self.due_ns(number), begun_ns, elapsed }
    }

    #[allow(
        clippy::cast_precision_loss,
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "ticks and their nanoseconds stay far below 2^53"
    )]
    fn due_ns(&self, tick: u64) -> u64 {
        self.origin_ns + (tick as f64 * self.period_ns) as u64
    }

    #[allow(
        clippy::cast_precision_loss,
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "ticks and their nanoseconds stay far below 2^53"
    )]
    fn newest_at(&self, now_ns: u64) -> u64 {
        (now_ns.saturating_sub(self.origin_ns) as f64 / self.period_ns) as u64
    }
}
