//! How a rig kept up with the ticks of a run: what it left unanswered, and how its clock went.

use std::collections::BTreeMap;

use shared_types::{LoopState, RunDescription, Sample};

use crate::schema::{FieldLayout, Layout};

/// How a rig kept up with the ticks of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RigAccount {
    /// Samples without new data from the rig, by its own code for the reason; 0 if it gave none.
    pub stale_samples: BTreeMap<i32, u64>,
    /// The rig's clock; `None` where the ticks kept to the machine's.
    pub clock: Option<RigClock>,
    /// Mean time that an exchange with the rig took, s …
    pub mean_exchange_s: f64,
    /// … and the longest, s.
    pub longest_exchange_s: f64,
}

/// The clock of a rig that the ticks followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigClock {
    /// By how much it was faster than CLOCK_MONOTONIC, parts per million.
    pub drift_ppm: f64,
    /// Mean time from when a tick was due to when the sensors were read, s.
    pub phase_s: f64,
    /// Standard deviation of the same, s.
    pub phase_deviation_s: f64,
}

impl RigAccount {
    /// A sentence for each reason, one for the clock and one for an exchange that took too long, with the meanings of the run's
    /// device codes. The reason with the code `reported` is left out: it ended the run and has been reported as its cause.
    #[must_use]
    pub fn in_words(&self, run: &RunDescription, reported: i32) -> Vec<String> {
        // The remedy, after the semicolon, is given where a code ends a run.
        let meaning = |code: &i32| {
            let known = run.device_codes.iter().find(|(known, _)| known == code);
            known.map_or("the rig gives no reason", |(_, meaning)| meaning.split(';').next().unwrap_or(meaning))
        };
        let stale = self.stale_samples.iter().filter(|(code, _)| **code == 0 || **code != reported);
        let stale = stale.map(|(code, ticks)| format!("{ticks} ticks without new data: {}", meaning(code)));
        let clock = self.clock.map(|RigClock { drift_ppm, phase_s, phase_deviation_s }| {
            format!(
                "the ticks followed the rig's clock: {drift_ppm:+.1} ppm, read {:+.1} µs after the tick, ± {:.1} µs",
                1e6 * phase_s,
                1e6 * phase_deviation_s
            )
        });
        let slow = (self.longest_exchange_s * run.rate_hz > MANY_TICKS).then(|| {
            format!(
                "the longest exchange with the rig took {:.1} ms, more than ten ticks: its driver or library waited, unless the machine stalled",
                1e3 * self.longest_exchange_s
            )
        });
        stale.chain(clock).chain(slow).collect()
    }
}

/// Ticks beyond which an exchange with the rig took too long.
const MANY_TICKS: f64 = 10.0;

/// Layout of the sample fields that the account is computed from; `None` for a field that the samples do not have.
#[derive(Debug)]
pub(crate) struct AccountFields {
    tick: Option<FieldLayout>,
    monotonic_time_ns: Option<FieldLayout>,
    measured_after_s: Option<FieldLayout>,
    state: Option<FieldLayout>,
    flags: Option<FieldLayout>,
    device_code: Option<FieldLayout>,
    sensor_read_ns: Option<FieldLayout>,
}

impl AccountFields {
    pub(crate) fn find(layout: &Layout) -> Self {
        let field = |name| layout.field(name).cloned();
        Self {
            tick: field("tick"),
            monotonic_time_ns: field("monotonic_time_ns"),
            measured_after_s: field("measured_after_s"),
            state: field("state"),
            flags: field("flags"),
            device_code: field("device_code"),
            sensor_read_ns: field("sensor_read_ns"),
        }
    }
}

/// Difference between a run's length and that at its nominal rate above which the ticks must have followed the rig's clock, ns. It is
/// larger than any rounding error.
const FOLLOWED_NS: f64 = 100.0;

/// What was read so far, in memory that does not grow.
#[derive(Debug, Default)]
pub(crate) struct Account {
    stale_samples: BTreeMap<i32, u64>,
    /// Tick and due time of the first sample, ns.
    first: Option<(u64, u64)>,
    last_tick: f64,
    /// Samples that are not stale.
    fresh: f64,
    mean_tick: f64,
    mean_due_ns: f64,
    mean_after_s: f64,
    /// Sums of squares and products about the means (B. P. Welford, Technometrics 4, 1962).
    tick_by_tick: f64,
    tick_by_due_ns: f64,
    after_by_after_s2: f64,
    mean_exchange_ns: f64,
    longest_exchange_ns: f64,
}

impl Account {
    /// Takes in the body of a sample.
    pub(crate) fn take(&mut self, fields: &AccountFields, body: &[u8]) {
        let whole = |field: &Option<FieldLayout>| field.as_ref().and_then(|field| field.as_u64(body));
        if whole(&fields.state) == Some(u64::from(LoopState::Fault.code())) {
            return;
        }
        if whole(&fields.flags).is_some_and(|flags| flags & u64::from(Sample::STALE) != 0) {
            let code = whole(&fields.device_code).map_or(0, |bits| (bits as u32).cast_signed());
            *self.stale_samples.entry(code).or_default() += 1;
            return;
        }
        let (Some(tick), Some(due_ns)) = (whole(&fields.tick), whole(&fields.monotonic_time_ns)) else { return };
        let (first_tick, first_due_ns) = *self.first.get_or_insert((tick, due_ns));
        let tick = tick.saturating_sub(first_tick) as f64;
        let due_ns = due_ns.saturating_sub(first_due_ns) as f64;
        let after_s = fields.measured_after_s.as_ref().and_then(|field| field.as_f64(body)).unwrap_or(0.0);
        let (tick_off, after_off_s) = (tick - self.mean_tick, after_s - self.mean_after_s);
        let exchange_ns = whole(&fields.sensor_read_ns).unwrap_or(0) as f64;
        self.last_tick = tick;
        self.fresh += 1.0;
        self.mean_exchange_ns += (exchange_ns - self.mean_exchange_ns) / self.fresh;
        self.longest_exchange_ns = self.longest_exchange_ns.max(exchange_ns);
        self.mean_tick += tick_off / self.fresh;
        self.mean_due_ns += (due_ns - self.mean_due_ns) / self.fresh;
        self.mean_after_s += after_off_s / self.fresh;
        self.tick_by_tick += tick_off * (tick - self.mean_tick);
        self.tick_by_due_ns += tick_off * (due_ns - self.mean_due_ns);
        self.after_by_after_s2 += after_off_s * (after_s - self.mean_after_s);
    }

    /// The account of a run at a rate.
    pub(crate) fn into_rig_account(self, rate_hz: f64) -> RigAccount {
        // The regression's slope: a clock that is faster has shorter periods.
        let period_ns = self.tick_by_due_ns / self.tick_by_tick;
        let planned_ns = 1e9 / rate_hz;
        let follows = ((period_ns - planned_ns) * self.last_tick).abs() > FOLLOWED_NS;
        let clock = follows.then(|| RigClock {
            drift_ppm: 1e6 * (planned_ns / period_ns - 1.0),
            phase_s: self.mean_after_s,
            phase_deviation_s: (self.after_by_after_s2 / self.fresh).sqrt(),
        });
        RigAccount {
            stale_samples: self.stale_samples,
            clock,
            mean_exchange_s: 1e-9 * self.mean_exchange_ns,
            longest_exchange_s: 1e-9 * self.longest_exchange_ns,
        }
    }
}
