//! Cycles at the rate of the run before there is a control loop, and the thread that makes them.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use shared_types::rig::monotonic_time_ns;

use super::bus::{Bus, Cycle, DriveCommand, Unanswered};
use super::drive::SWITCH_ON;

/// Where in the devices' period frames are to pass: after they have taken their inputs, well before they take outputs.
const PHASE: f64 = 0.3;
/// Share of the phase error that each tick corrects.
const PHASE_GAIN: f64 = 0.1;
/// Time that such a cycle waits for its frame, ns: nothing hurries.
const PATIENCE_NS: u64 = 10_000_000;

/// Cycles at a rate, in the phase of the devices' clocks.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pace {
    period_ns: u64,
    next_ns: u64,
}

impl Pace {
    pub(super) fn new(rate_hz: f64) -> Self {
        Self { period_ns: (1e9 / rate_hz) as u64, next_ns: 0 }
    }

    /// By how much the next tick is to come later, ns, where the frame passed so long after the devices' SYNC0.
    pub(super) fn shift_ns(&self, after_sync_ns: u64) -> i64 {
        let period_ns = self.period_ns as f64;
        let off = (after_sync_ns as f64 / period_ns - PHASE).rem_euclid(1.0);
        let late = if off > 0.5 { off - 1.0 } else { off };
        (-PHASE_GAIN * late * period_ns) as i64
    }

    /// Waits for the next cycle, and makes it.
    pub(super) fn cycle(&mut self, bus: &mut Bus, command: DriveCommand) -> Result<Cycle, Unanswered> {
        let now_ns = monotonic_time_ns();
        self.next_ns = if self.next_ns + 10 * self.period_ns < now_ns { now_ns } else { self.next_ns + self.period_ns };
        std::thread::sleep(Duration::from_nanos(self.next_ns.saturating_sub(now_ns)));
        let cycle = bus.cycle(command, monotonic_time_ns() + PATIENCE_NS);
        if let Ok(Cycle { after_sync_ns: Some(after_ns), .. }) = cycle {
            self.next_ns = self.next_ns.saturating_add_signed(self.shift_ns(after_ns));
        }
        cycle
    }
}

/// A thread that keeps the bus alive with the drive switched on, until the control loop takes it over.
pub(super) struct Keeper {
    stop: Arc<AtomicBool>,
    thread: JoinHandle<Box<Bus>>,
}

impl Keeper {
    pub(super) fn start(bus: Bus, rate_hz: f64) -> Self {
        let stop = Arc::new(AtomicBool::new(false));
        let stops = Arc::clone(&stop);
        let mut bus = Box::new(bus);
        let thread = std::thread::spawn(move || {
            let mut pace = Pace::new(rate_hz);
            while !stops.load(Ordering::Acquire) {
                // A frame that is lost shows again when the loop has the bus.
                let _ = pace.cycle(&mut bus, DriveCommand { controlword: SWITCH_ON, target_torque: 0 });
            }
            bus
        });
        Self { stop, thread }
    }

    /// Ends the thread, within a cycle, and gives the bus.
    pub(super) fn hand_over(self) -> Option<Box<Bus>> {
        self.stop.store(true, Ordering::Release);
        self.thread.join().ok()
    }
}
