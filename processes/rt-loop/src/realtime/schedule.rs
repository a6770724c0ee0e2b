//! When ticks are due, and what is made of those that the host let pass.

use shared_types::rig::monotonic_time_ns;

use super::clock::wait_until;

/// Time from the making of a schedule to its first tick, ns.
const LEAD_NS: u64 = 1_000_000;

/// Longest time before a tick at which the wait stops sleeping, ns.
///
/// Sleep alone wakes about 6 µs late at the median, and much later where the core was lent to something that cannot be
/// interrupted at once. The shorter the sleep, the fewer stalls of the host fall on it: spinning for three quarters of the period
/// instead of a half takes p99.9 from a half to a quarter of cyclictest's at 10 kHz (`docs/realtime.md`).
const LONGEST_SPIN_NS: f64 = 150_000.0;
/// Share of a period that is spun at most. The kernel takes a loop that leaves ordinary tasks less than a twentieth of its core
/// off that core for some 50 ms at a time, and the loop's own work adds to the spinning.
const SPIN_SHARE: f64 = 0.75;

/// Most of a period by which a rig may shift the ticks at a time.
const LARGEST_SHIFT: f64 = 0.1;

/// Ticks at a fixed rate on CLOCK_MONOTONIC: tick n is due at origin + n / rate. A rig with a phase of its own shifts the origin.
#[derive(Clone, Copy, Debug)]
pub struct Schedule {
    origin_ns: u64,
    period_ns: f64,
    spin_ns: u64,
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
        let period_ns = 1e9 / rate_hz;
        let spin_ns = LONGEST_SPIN_NS.min(SPIN_SHARE * period_ns) as u64;
        Self { origin_ns: monotonic_time_ns() + LEAD_NS, period_ns, spin_ns, next: 0 }
    }

    /// The same, spinning so long before each tick, ns.
    #[must_use]
    pub fn spinning(self, spin_ns: u64) -> Self {
        Self { spin_ns, ..self }
    }

    /// Waits for the next tick. After a stall the newest tick that is due is served; those before it are missed.
    pub fn wait(&mut self) -> Tick {
        let begun_ns = wait_until(self.due_ns(self.next), self.spin_ns);
        let number = self.newest_at(begun_ns).max(self.next);
        let elapsed = number - self.next + 1;
        self.next = number + 1;
        Tick { number, due_ns: self.due_ns(number), begun_ns, elapsed }
    }

    /// Shifts the ticks from the next one on by `later_ns`, at most a tenth of a period either way.
    pub fn shift(&mut self, later_ns: i64) {
        let most_ns = (LARGEST_SHIFT * self.period_ns) as i64;
        self.origin_ns = self.origin_ns.saturating_add_signed(later_ns.clamp(-most_ns, most_ns));
    }

    fn due_ns(&self, tick: u64) -> u64 {
        self.origin_ns + (tick as f64 * self.period_ns) as u64
    }

    fn newest_at(&self, now_ns: u64) -> u64 {
        (now_ns.saturating_sub(self.origin_ns) as f64 / self.period_ns) as u64
    }
}
