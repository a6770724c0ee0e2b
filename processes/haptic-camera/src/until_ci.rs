//! How well a capture must know a knob before it may end: `capture --until-ci`.
//!
//! The live fit decides whether a parameter is known well enough ([`identification::live::Criterion`]). A parameter that the data
//! do not determine yet is waited for, since a later part of the sweep may excite it; one that the model does not have, such as
//! detents of a knob without them, is not.

use std::fmt;
use std::str::FromStr;

use identification::Fit;
use identification::live::{Convergence, Criterion, LiveEstimate, LiveParameter, Verdict};
use shared_types::{Estimate, FitUpdate};

/// The share of a parameter's value that half its interval may be wide: more than zero and less than one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Share(pub f64);

impl FromStr for Share {
    type Err = &'static str;

    /// The sign is asked for, since a bare 1 could mean all of the value.
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let percent = text.trim().strip_suffix('%').and_then(|number| number.trim().parse().ok());
        let share = percent.filter(|percent| (0.0..100.0).contains(percent) && *percent > 0.0);
        share.map(|percent: f64| Self(percent / 100.0)).ok_or(
            "give half the width of the 95 % interval as a share of the value, between 0% and 100%, as in 1% or 0.5%",
        )
    }
}

impl fmt::Display for Share {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        // As it was given: 7 %, where a hundred times its binary fraction is 7.000000000000001.
        write!(formatter, "{} %", (self.0 * 1e8).round() / 1e6)
    }
}

/// Factor by which the data must grow while the criterion holds before the sweep ends. Successive estimates rest on nearly the same
/// data; an interval that is small by chance is then unlikely to stay small with new data.
const HELD_GROWTH: f64 = 1.1;
/// Number of consecutive estimates that must also meet the criterion.
const HELD_ESTIMATES: u32 = 10;

/// Ends a sweep once every parameter is known well enough, and says how far the sweep came.
#[derive(Clone, Debug)]
pub struct StopRule {
    pub asked: Share,
    /// Since when the criterion has held without a break: time in the run, s, and number of estimates.
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
        let (since_s, estimates) = self.held.map_or((time_s, 1), |(since_s, estimates)| (since_s, estimates + 1));
        self.held = enough.then_some((since_s, estimates));
        let ends = enough && time_s >= HELD_GROWTH * since_s && estimates >= HELD_ESTIMATES;
        self.ended_s = self.ended_s.or(ends.then_some(time_s));
        ends
    }

    /// What a fit of the archive knows of the parameters of the last estimate, held against what was asked for; `None` if
    /// there never was an estimate.
    pub fn verify(&self, fit: &Fit, torque_step_mnm: f64) -> Option<Vec<LiveParameter>> {
        let criterion = Criterion { share: self.asked.0, torque_step_mnm };
        let live = self.last.as_ref()?;
        let of = |known: &LiveParameter| {
            let fitted = fit.parameters.get(known.name);
            let value = fitted.and_then(|parameter| parameter.value);
            let ci95 = fitted.and_then(|parameter| parameter.ci95);
            let is_in_model = fitted.is_some() && (value.is_some() || known.is_in_model());
            let verdict = if is_in_model { Verdict::Estimated } else { Verdict::Absent };
            let mut known = LiveParameter { value, ci95, verdict, convergence: Convergence::Open, ..*known };
            if let Some((value, half_width)) = value.zip(known.half_width()) {
                known.convergence = criterion.judge(known.name, value, half_width, live.motion());
            }
            known
        };
        Some(live.parameters.iter().map(of).collect())
    }
}

/// The estimate in a message of the live fitter.
pub fn estimate_of(update: &FitUpdate) -> LiveEstimate {
    let finite = |value: f64| value.is_finite().then_some(value);
    let kinds = || dynamics::effects::ALL.iter().flat_map(|effect| effect.parameters);
    let parameter = |(name, estimate): (&'static str, Estimate)| LiveParameter {
        name,
        unit: kinds().find(|kind| kind.name == name).map_or("", |kind| kind.unit),
        value: finite(estimate.value),
        ci95: finite(estimate.half_width()).map(|_| [estimate.ci95_low, estimate.ci95_high]),
        verdict: Verdict::from_code(estimate.verdict).unwrap_or(Verdict::NotYet),
        convergence: Convergence::from_code(estimate.convergence).unwrap_or(Convergence::Open),
    };
    let mut estimate = LiveEstimate::default();
    estimate.parameters = update.estimates().map(parameter).to_vec();
    estimate.speed_rms_rad_s = finite(update.speed_rms_rad_s);
    estimate.acceleration_rms_rad_s2 = finite(update.acceleration_rms_rad_s2);
    estimate
}

/// The parameters that are not known well enough, the least known first.
pub fn open(parameters: &[LiveParameter]) -> Vec<&LiveParameter> {
    let mut open: Vec<&LiveParameter> = parameters.iter().filter(|known| !known.is_settled()).collect();
    let width = |known: &LiveParameter| known.share().unwrap_or(f64::INFINITY);
    open.sort_by(|one, other| width(other).total_cmp(&width(one)));
    open
}

pub fn share_words(known: &LiveParameter) -> String {
    match known.share() {
        Some(share) => format!("{} ± {:.2} %", known.name, 100.0 * share),
        None => format!("{} not estimated yet", known.name),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]

    use super::*;

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

    /// The time at which a rule that hears the same again and again ends a sweep of ten seconds.
    fn ends_at(knowledge: &LiveEstimate) -> Option<f64> {
        let mut rule = StopRule::new(Share(0.01));
        (1..=250).map(|index| f64::from(index) * 0.04).find(|&time_s| rule.take(time_s, knowledge.clone()))
    }

    #[test]
    fn it_must_hold_over_successive_estimates_and_a_tenth_more_data() {
        let (good, bad) = (knowledge(&[CONVERGED]), knowledge(&[OPEN]));
        let mut rule = StopRule::new(Share(0.01));
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
        let mut rule = StopRule::new(Share(0.01));
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

    #[test]
    fn the_terminal_counts_as_known_what_the_page_does() {
        for verdict in [Verdict::NotYet, Verdict::Estimated] {
            for convergence in [Convergence::Open, Convergence::Converged, Convergence::Negligible] {
                let inertia =
                    Estimate { verdict: verdict.code(), convergence: convergence.code(), ..Estimate::default() };
                let known = estimate_of(&FitUpdate { inertia, ..FitUpdate::default() }).parameters[0];
                assert_eq!(known.is_settled(), inertia.is_settled(), "{verdict:?}, {convergence:?}");
            }
        }
    }
}
