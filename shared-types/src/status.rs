//! What the control loop says about itself, ten times a second.

#[cfg(feature = "services")]
use iceoryx2::prelude::ZeroCopySend;

/// Upper edges of the lateness bins, ns; the last bin counts everything above the last edge.
///
/// Two per decade from 30 ns to 1 ms, which is what a glance needs, then one more at 10 ms.
pub const LATENESS_BIN_EDGES_NS: [u64; 11] =
    [30, 100, 300, 1_000, 3_000, 10_000, 30_000, 100_000, 300_000, 1_000_000, 10_000_000];

wire_message! {
    /// Health of the control loop.
    pub struct LoopStatus as "haptic_camera/msg/LoopStatus" {
        /// Identity of the run.
        pub run_id: u64,
        /// CLOCK_MONOTONIC when this was written, ns.
        pub monotonic_time_ns: u64,
        /// System clock when this was written, ns since 1970; for the log only.
        pub wall_clock_time_ns: u64,
        /// Ticks that the run will have; 0 when it has no planned end.
        pub planned_ticks: u64,
        /// Samples published so far.
        pub published_samples: u64,
        /// Ticks missed so far because the loop was not given the processor in time.
        pub missed_ticks: u64,
        /// Times at which one or more ticks were missed.
        pub overruns: u64,
        /// Samples that were taken but never published, because the ring to the publisher was full.
        pub dropped_samples: u64,
        /// Ticks so far in which the passivity guard of a rendering took energy back.
        pub guarded_ticks: u64,
        /// Longest lateness so far, ns.
        pub max_lateness_ns: u64,
        /// Ticks by lateness: up to 30 ns, 100 ns, 300 ns, 1 us ... 10 ms, and above.
        pub lateness_counts: [u64; 12],
        /// Sample rate, Hz.
        pub rate_hz: f64,
        /// Knob angle of the newest sample, rad.
        pub angle_rad: f64,
        /// Torque sensor's reading in the newest sample, mNm.
        pub torque_mnm: f64,
        /// State of the loop: 0 idle, 1 armed, 2 running, 3 stopping, 4 fault.
        pub state: u32,
        /// Cause of the fault, 0 for none.
        pub fault: u32,
        /// Bits: 1 SCHED_FIFO, 2 memory locked, 4 pinned to a core.
        pub realtime: u32,
        /// Core that the loop runs on.
        pub core: u32,
        /// 1 once the run has ended and every sample of it was published.
        pub finished: u32,
        /// Process id of the loop.
        pub process_id: u32,
        /// Flags of the newest sample.
        pub flags: u32,
        /// The rig's own code for the fault, 0 for none: a signed number as its bits.
        pub device_code: u32,
    }
}

/// Bits of [`LoopStatus::realtime`].
pub mod realtime {
    /// The loop runs under SCHED_FIFO.
    pub const FIFO: u32 = 1;
    /// The loop's memory is locked.
    pub const LOCKED: u32 = 2;
    /// The loop is pinned to one core.
    pub const PINNED: u32 = 4;
    /// All of them: real-time permission was granted in full.
    pub const FULL: u32 = FIFO | LOCKED | PINNED;
}

impl LoopStatus {
    /// Samples that the run has taken, published or not. Once it has ended this is the `seq` after the last one's.
    #[must_use]
    pub fn taken_samples(&self) -> u64 {
        self.published_samples + self.dropped_samples
    }

    /// Upper edge of the bin that holds the `share` quantile of the ticks' lateness, ns; `None` in the last bin, which has no edge, and
    /// without ticks.
    #[must_use]
    pub fn lateness_below_ns(&self, share: f64) -> Option<u64> {
        let ticks: u64 = self.lateness_counts.iter().sum();
        let wanted = (share * ticks as f64).ceil() as u64;
        let mut counted = 0;
        let bin = self.lateness_counts.iter().position(|count| {
            counted += count;
            ticks > 0 && counted >= wanted
        });
        LATENESS_BIN_EDGES_NS.get(bin?).copied()
    }

    /// The bin of [`LoopStatus::lateness_counts`] for a lateness in ns.
    #[must_use]
    pub fn lateness_bin(lateness_ns: u64) -> usize {
        LATENESS_BIN_EDGES_NS.partition_point(|&edge| edge < lateness_ns)
    }
}
