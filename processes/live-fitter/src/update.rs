//! From a live estimate to the message that is published.

use std::time::{Duration, Instant};

use identification::live::{LiveEstimate, LiveParameter};
use shared_types::{Estimate, FitUpdate, Verdict, rig};

use crate::streams::Newest;

/// Time between two updates: 25 a second.
const INTERVAL: Duration = Duration::from_millis(40);

/// When an update is due: at an even pace, and only when there is something new to tell.
pub struct Cadence {
    next: Instant,
    sent: Option<Newest>,
}

impl Cadence {
    /// The first update is due at once.
    pub fn new() -> Self {
        Self { next: Instant::now(), sent: None }
    }

    /// Whether an update is due, the newest sample being this.
    pub fn is_due(&mut self, newest: Option<Newest>) -> bool {
        let now = Instant::now();
        if newest == self.sent || now < self.next {
            return false;
        }
        self.sent = newest;
        self.next = now + INTERVAL;
        true
    }
}

/// The message for an estimate, with the CPU time that making it cost.
pub fn measured(run_id: u64, estimate: impl FnOnce() -> LiveEstimate) -> FitUpdate {
    let begun_ns = rig::thread_cpu_time_ns();
    let estimate = estimate();
    let parameter = |name: &str| estimate.parameter(name).map_or_else(absent, message);
    FitUpdate {
        run_id,
        samples: estimate.samples,
        update_ns: rig::thread_cpu_time_ns().saturating_sub(begun_ns),
        residual_rms_mnm: estimate.residual_rms_mnm.unwrap_or(f64::NAN),
        speed_rms_rad_s: estimate.speed_rms_rad_s.unwrap_or(f64::NAN),
        acceleration_rms_rad_s2: estimate.acceleration_rms_rad_s2.unwrap_or(f64::NAN),
        inertia: parameter("inertia"),
        coulomb_negative: parameter("coulomb_negative"),
        coulomb_positive: parameter("coulomb_positive"),
        viscous_negative: parameter("viscous_negative"),
        viscous_positive: parameter("viscous_positive"),
        detent_amplitude: parameter("detent_amplitude"),
        detent_period: parameter("detent_period"),
        detent_phase: parameter("detent_phase"),
        ..FitUpdate::default()
    }
}

fn message(parameter: &LiveParameter) -> Estimate {
    let [ci95_low, ci95_high] = parameter.ci95.unwrap_or([f64::NAN; 2]);
    Estimate {
        value: parameter.value.unwrap_or(f64::NAN),
        ci95_low,
        ci95_high,
        verdict: parameter.verdict.code(),
        convergence: parameter.convergence.code(),
    }
}

fn absent() -> Estimate {
    let nothing = f64::NAN;
    Estimate { value: nothing, ci95_low: nothing, ci95_high: nothing, verdict: Verdict::Absent.code(), convergence: 0 }
}
