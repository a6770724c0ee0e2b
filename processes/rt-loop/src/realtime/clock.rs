//! Waiting for an absolute deadline: sleep to a little before it, then spin.

use nix::sys::time::TimeSpec;
use nix::time::{ClockId, ClockNanosleepFlags, clock_nanosleep};
use shared_types::rig::monotonic_time_ns;

/// Returns at `deadline_ns` (CLOCK_MONOTONIC) or as soon after it as the host permits, with the time then; stops sleeping
/// `spin_ns` before.
pub(super) fn wait_until(deadline_ns: u64, spin_ns: u64) -> u64 {
    let now = monotonic_time_ns();
    if now + spin_ns < deadline_ns {
        let wake_ns = deadline_ns - spin_ns;
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
