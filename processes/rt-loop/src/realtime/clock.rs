//! Waiting for an absolute deadline: sleep to a little before it, then spin.

use nix::sys::time::TimeSpec;
use nix::time::{ClockId, ClockNanosleepFlags, clock_nanosleep};
use shared_types::rig::monotonic_time_ns;

/// How long before a deadline the loop stops sleeping, ns.
///
/// Sleep alone wakes about 6 µs late here; spinning over the last stretch brings the median to well
/// under 0.1 µs. Longer would cost processor time, and a loop that never sleeps is taken off its
/// core for some 50 ms at a time by the kernel's guard for ordinary tasks.
const SPIN_NS: u64 = 25_000;

/// Returns at `deadline_ns` (CLOCK_MONOTONIC) or as soon after it as the host permits, with the time then.
pub(super) fn wait_until(deadline_ns: u64) -> u64 {
    let now = monotonic_time_ns();
    if now + SPIN_NS < deadline_ns {
        let wake_ns = deadline_ns - SPIN_NS;
        #[allow(clippy::cast_possible_wrap, reason = "nanoseconds since boot fit in 63 bits for 292 years")]
        let wake = TimeSpec::new((wake_ns / 1_000_000_000) as i64, (wake_ns % 1_000_000_000) as i64);
        // An interrupted sleep only means a longer spin.
        let _ = clock_nanosleep(ClockId::CLOCK_MONOTONIC, ClockNanosleepFlags::TIMER_ABSTIME, &wake);
    }
    loop {
        let now = monotonic_time_ns();
        if now >= deadline_ns {
            return now;
        }
        std::hint::spin_loop();
    }
}
