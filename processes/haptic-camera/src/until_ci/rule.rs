//! When a sweep may end because enough is known.

use identification::live::Criterion;

use super::{Knowledge, Known, Share};

/// The sweep goes on until it has held while the data grew by this factor: successive estimates rest on nearly the same
/// data, and an interval that is small by accident must be small by accident of new data too.
const HELD_GROWTH: f64 = 1.1;
/// Estimates that must hold in a row, besides.
const HELD_ESTIMATES: u32 = 10;

/// Ends a sweep once every parameter is known well enough, and says how far the sweep came.
#[derive(Clone, Debug)]
pub struct StopRule {
    /// What was asked for.
    pub asked: Share,
    /// Since when it has held without a break: time in the run, s, and estimates.
    held: Option<(f64, u32)>,
    newest_s: f64,
    /// Time in the run at which everything was known well enough, s; `None` as long as that has not come.
    pub ended_s: Option<f64>,
    /// What was known last; `None` without any estimate.
    last: Option<Knowledge>,
}

impl StopRule {
    /// A rule that has seen nothing.
    pub fn new(asked: Share) -> Self {
        Self { asked, held: None, newest_s: f64::NEG_INFINITY, ended_s: None, last: None }
    }

    /// Takes what is known at a time in the run; true once the sweep may end. An estimate that comes twice counts once.
    pub fn take(&mut self, time_s: f64, knowledge: Knowledge) -> bool {
        if time_s <= self.newest_s {
            return false;
        }
        self.newest_s = time_s;
        let enough = knowledge.is_enough();
        self.last = Some(knowledge);
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

    /// Whether it has ended the sweep.
    pub fn has_ended(&self) -> bool {
        self.ended_s.is_some()
    }

    /// Parameters that were not known well enough at the last estimate.
    pub fn open(&self) -> Vec<Known> {
        self.last.as_ref().map_or_else(Vec::new, Knowledge::open)
    }

    /// What a fit of the archive knows, held against what was asked for; `None` if nothing ever was.
    pub fn verify(&self, fit: &identification::Fit, torque_step_mnm: f64) -> Option<Knowledge> {
        let criterion = Criterion { share: self.asked.get(), torque_step_mnm };
        Some(self.last.as_ref()?.of_fit(fit, &criterion))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]

    use identification::live::{Convergence, MotionRms};

    use super::super::{Knowledge, Known};
    use super::StopRule;

    const CONVERGED: Known = Known {
        name: "inertia",
        value: Some(0.035),
        half_width: Some(0.0002),
        is_in_model: true,
        convergence: Convergence::Converged,
    };
    const OPEN: Known = Known { convergence: Convergence::Open, ..CONVERGED };

    fn knowledge(parameters: &[Known]) -> Knowledge {
        let motion = MotionRms { velocity_rad_s: 5.0, acceleration_rad_s2: 100.0 };
        Knowledge { parameters: parameters.to_vec(), motion }
    }

    fn rule() -> StopRule {
        StopRule::new("1%".parse().unwrap())
    }

    /// The time at which a rule that hears the same again and again ends a sweep of ten seconds.
    fn ends_at(knowledge: &Knowledge) -> Option<f64> {
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
        assert!(ends_at(&knowledge(&[CONVERGED, Known { is_in_model: false, ..OPEN }])).is_some());
        assert!(ends_at(&knowledge(&[CONVERGED, Known { convergence: Convergence::Negligible, ..OPEN }])).is_some());
        assert_eq!(ends_at(&knowledge(&[])), None);
    }
}
