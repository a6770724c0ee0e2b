//! When a sweep may end because enough is known.

use identification::live::{Criterion, LiveEstimate, LiveParameter};

use super::Share;
use super::knowledge::of_fit;

/// The sweep goes on until it has held while the data grew by this factor: successive estimates rest on nearly the same
/// data, and an interval that is small by accident must be small by accident of new data too.
const HELD_GROWTH: f64 = 1.1;
/// Estimates that must hold in a row, besides.
const HELD_ESTIMATES: u32 = 10;

/// Ends a sweep once every parameter is known well enough, and says how far the sweep came.
#[derive(Clone, Debug)]
pub struct StopRule {
    pub asked: Share,
    /// Since when it has held without a break: time in the run, s, and estimates.
    held: Option<(f64, u32)>,
    newest_s: f64,
    /// Time in the run at which everything was known well enough, s; `None` as long as that has not come.
    pub ended_s: Option<f64>,
    /// What was known last; `None` without any estimate.
    pub last: Option<LiveEstimate>,
}

impl StopRule {
    pub fn new(asked: Share) -> Self {
        Self { asked, held: None, newest_s: f64::NEG_INFINITY, ended_s: None, last: None }
    }

    /// Takes what is known at a time in the run; true once the sweep may end. An estimate that comes twice counts once.
    pub fn take(&mut self, time_s: f64, estimate: LiveEstimate) -> bool {
        if time_s <= self.newest_s {
            return false;
        }
        self.newest_s = time_s;
        let enough = !estimate.parameters.is_empty() && estimate.parameters.iter().all(LiveParameter::is_settled);
        self.last = Some(estimate);
        self.held = match self.held {
            _ if !enough => None,
            None => Some((time_s, 1)),
            Some((since_s, estimates)) => Some((since_s, estimates + 1)),
        };
        let ends = self
            .held
            .is_some_and(|(since_s, estimates)| time_s >= HELD_GROWTH * since_s && estimates >= HELD_ESTIMATES);
        if ends && self.ended_s.is_none() {
            self.ended_s = Some(time_s);
        }
        ends
    }

    pub fn has_ended(&self) -> bool {
        self.ended_s.is_some()
    }

    /// What a fit of the archive knows, held against what was asked for; `None` if nothing ever was.
    pub fn verify(&self, fit: &identification::Fit, torque_step_mnm: f64) -> Option<Vec<LiveParameter>> {
        let criterion = Criterion { share: self.asked.get(), torque_step_mnm };
        Some(of_fit(self.last.as_ref()?, fit, &criterion))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]

    use identification::live::{Convergence, LiveEstimate, LiveParameter, Verdict};

    use super::StopRule;

    const CONVERGED: LiveParameter = LiveParameter {
        name: "inertia",
        unit: "mNm s²/rad",
        value: Some(0.035),
        ci95: Some([0.0348, 0.0352]),
        verdict: Verdict::Estimated,
        convergence: Convergence::Converged,
    };
    const OPEN: LiveParameter = LiveParameter { convergence: Convergence::Open, ..CONVERGED };

    fn knowledge(parameters: &[LiveParameter]) -> LiveEstimate {
        let mut estimate = LiveEstimate::default();
        estimate.parameters = parameters.to_vec();
        estimate
    }

    fn rule() -> StopRule {
        StopRule::new("1%".parse().unwrap())
    }

    /// The time at which a rule that hears the same again and again ends a sweep of ten seconds.
    fn ends_at(knowledge: &LiveEstimate) -> Option<f64> {
        let mut rule = rule();
        (1..=250).map(|index| f64::from(index) * 0.04).find(|&time_s| rule.take(time_s, knowledge.clone()))
    }

    #[test]
    fn it_must_hold_over_successive_estimates_and_a_tenth_more_data() {
        let (good, bad) = (knowledge(&[CONVERGED]), knowledge(&[OPEN]));
        let mut rule = rule();
        for index in 1..=100 {
            assert!(!rule.take(f64::from(index) * 0.04, bad.clone()));
        }
        assert!(!rule.take(4.04, good.clone()), "one good estimate is an accident");
        assert!(!rule.take(4.08, bad));
        let ended =
            (103..).map(|index| f64::from(index) * 0.04).find(|&time_s| rule.take(time_s, good.clone())).unwrap();
        assert!((ended - 4.12 * 1.1).abs() < 0.05, "{ended}");
    }

    #[test]
    fn the_same_estimate_heard_again_is_no_further_evidence() {
        let mut rule = rule();
        let good = knowledge(&[CONVERGED]);
        assert!((0..1000).all(|_| !rule.take(0.04, good.clone())));
    }

    #[test]
    fn what_is_open_is_waited_for_and_what_is_negligible_or_not_there_is_not() {
        assert_eq!(ends_at(&knowledge(&[CONVERGED, OPEN])), None);
        assert!(ends_at(&knowledge(&[CONVERGED, LiveParameter { verdict: Verdict::Absent, ..OPEN }])).is_some());
        assert!(
            ends_at(&knowledge(&[CONVERGED, LiveParameter { convergence: Convergence::Negligible, ..OPEN }])).is_some()
        );
        assert_eq!(ends_at(&knowledge(&[])), None);
    }
}
