//! What each consumer says about itself, twice a second.

#[cfg(feature = "services")]
use iceoryx2::prelude::ZeroCopySend;

use crate::wire_code;

wire_message! {
    /// Health of one consumer of the sample stream.
    pub struct ProcessHealth as "haptic_camera/msg/ProcessHealth" {
        /// CLOCK_MONOTONIC when this was written, ns.
        pub monotonic_time_ns: u64,
        /// Samples received so far, those from history included.
        pub received_samples: u64,
        /// Samples that were published and never arrived.
        pub lost_samples: u64,
        /// Age of the newest sample when it was taken from the queue, ns.
        pub latency_ns: u64,
        /// CPU time of the process so far, ns.
        pub cpu_time_ns: u64,
        /// Resident memory, bytes.
        pub resident_bytes: u64,
        /// Which process: 1 recorder, 2 live-fitter, 3 viewer.
        pub process: u32,
        /// Process id.
        pub process_id: u32,
        /// Times this process was restarted during the run.
        pub restarts: u32,
        /// Always 0.
        pub reserved: u32,
    }
}

wire_code! {
    /// A consumer of the sample stream.
    pub enum ProcessKind {
        /// Writes the archive.
        Recorder = 1,
        /// Fits the model while the run goes on.
        LiveFitter = 2,
        /// Shows the streams.
        Viewer = 3,
    }
}

impl ProcessKind {
    /// The process's name, as its program is called.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Recorder => "recorder",
            Self::LiveFitter => "live-fitter",
            Self::Viewer => "rerun-viewer",
        }
    }
}

impl ProcessHealth {
    /// Health of the calling process: CPU time and memory read from the kernel, counts from the caller.
    #[must_use]
    pub fn of_this_process(kind: ProcessKind, restarts: u32) -> Self {
        let usage = nix::sys::resource::getrusage(nix::sys::resource::UsageWho::RUSAGE_SELF).ok();
        let cpu_time_ns = usage.map_or(0, |usage| {
            let micros =
                |time: nix::sys::time::TimeVal| u64::try_from(time.tv_sec() * 1_000_000 + time.tv_usec()).unwrap_or(0);
            (micros(usage.user_time()) + micros(usage.system_time())) * 1_000
        });
        Self {
            monotonic_time_ns: crate::rig::monotonic_time_ns(),
            cpu_time_ns,
            resident_bytes: resident_bytes().unwrap_or(0),
            process: kind.code(),
            process_id: std::process::id(),
            restarts,
            ..Self::default()
        }
    }
}

/// Resident memory of the calling process, bytes; `None` where `/proc` does not tell.
fn resident_bytes() -> Option<u64> {
    let statm = std::fs::read_to_string("/proc/self/statm").ok()?;
    let pages: u64 = statm.split_whitespace().nth(1)?.parse().ok()?;
    let page_bytes = nix::unistd::sysconf(nix::unistd::SysconfVar::PAGE_SIZE).ok()??;
    Some(pages * u64::try_from(page_bytes).ok()?)
}
