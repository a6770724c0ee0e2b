//! Whether the control loop that feeds a consumer is still there.

use shared_types::{LoopStatus, rig};

/// Silence of the control loop, which reports ten times a second, after which its process is looked for, ns.
const SILENCE_NS: u64 = 500_000_000;

/// Watches the control loop of a run. Times are CLOCK_MONOTONIC.
#[derive(Clone, Copy, Debug, Default)]
pub struct SourceWatch {
    heard: Option<Heard>,
}

#[derive(Clone, Copy, Debug)]
struct Heard {
    process_id: u32,
    at_ns: u64,
}

impl SourceWatch {
    /// Takes note of the control loop's status.
    pub fn hear(&mut self, status: &LoopStatus, now_ns: u64) {
        self.heard = (status.finished == 0).then_some(Heard { process_id: status.process_id, at_ns: now_ns });
    }

    /// Whether the control loop died before its run had ended. One that is merely silent may come back.
    #[must_use]
    pub fn is_gone(&self, now_ns: u64) -> bool {
        self.is_gone_unless(now_ns, rig::process_exists)
    }

    fn is_gone_unless(&self, now_ns: u64, process_exists: impl Fn(u32) -> bool) -> bool {
        self.heard
            .is_some_and(|heard| now_ns.saturating_sub(heard.at_ns) > SILENCE_NS && !process_exists(heard.process_id))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND: u64 = 1_000_000_000;

    fn status(finished: u32) -> LoopStatus {
        LoopStatus { finished, process_id: 77, ..LoopStatus::default() }
    }

    #[test]
    fn a_silent_control_loop_is_gone_only_when_its_process_is() {
        let mut source = SourceWatch::default();
        assert!(!source.is_gone_unless(9 * SECOND, |_| false), "no loop was heard yet");
        source.hear(&status(0), SECOND);
        assert!(!source.is_gone_unless(SECOND + SILENCE_NS, |_| false));
        assert!(!source.is_gone_unless(3 * SECOND, |process| process == 77));
        assert!(source.is_gone_unless(SECOND + SILENCE_NS + 1, |_| false));
    }

    #[test]
    fn a_control_loop_that_has_ended_its_run_may_go() {
        let mut source = SourceWatch::default();
        source.hear(&status(1), SECOND);
        assert!(!source.is_gone_unless(9 * SECOND, |_| false));
    }
}
