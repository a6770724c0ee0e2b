//! What is known of each parameter, from the live fitter's messages and from a fit of the whole capture.

use identification::Fit;
use identification::live::{Convergence, Criterion, LiveEstimate, LiveParameter, Verdict};
use shared_types::{Estimate, FitUpdate};

/// The estimate that a message of the live fitter is of.
pub fn estimate_of(update: &FitUpdate) -> LiveEstimate {
    let finite = |value: f64| value.is_finite().then_some(value);
    let kinds = || dynamics::effects::ALL.iter().flat_map(|effect| effect.parameters);
    let parameter = |(name, estimate): (&'static str, Estimate)| LiveParameter {
        name,
        unit: kinds().find(|kind| kind.name == name).map_or("", |kind| kind.unit),
        value: finite(estimate.value),
        ci95: finite(estimate.half_width()).map(|_| [estimate.ci95_low, estimate.ci95_high]),
        verdict: match shared_types::Verdict::from_code(estimate.verdict) {
            Some(shared_types::Verdict::Absent) => Verdict::Absent,
            Some(shared_types::Verdict::Estimated) => Verdict::Estimated,
            Some(shared_types::Verdict::NotYet) | None => Verdict::NotYet,
        },
        convergence: match shared_types::Convergence::from_code(estimate.convergence) {
            Some(shared_types::Convergence::Converged) => Convergence::Converged,
            Some(shared_types::Convergence::Negligible) => Convergence::Negligible,
            Some(shared_types::Convergence::Open) | None => Convergence::Open,
        },
    };
    let mut estimate = LiveEstimate::default();
    estimate.parameters = update.estimates().map(parameter).to_vec();
    estimate.speed_rms_rad_s = finite(update.speed_rms_rad_s);
    estimate.acceleration_rms_rad_s2 = finite(update.acceleration_rms_rad_s2);
    estimate
}

/// What a fit of the whole capture knows of the parameters of a live estimate, by the same motion.
pub fn of_fit(live: &LiveEstimate, fit: &Fit, criterion: &Criterion) -> Vec<LiveParameter> {
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
    live.parameters.iter().map(of).collect()
}

/// The parameters that are not known well enough, the least known first.
pub fn open(parameters: &[LiveParameter]) -> Vec<&LiveParameter> {
    let mut open: Vec<&LiveParameter> = parameters.iter().filter(|known| !known.is_settled()).collect();
    let width = |known: &LiveParameter| known.share().unwrap_or(f64::INFINITY);
    open.sort_by(|one, other| width(other).total_cmp(&width(one)));
    open
}

/// A parameter with its interval's share of the value.
pub fn share_words(known: &LiveParameter) -> String {
    match known.share() {
        Some(share) => format!("{} ± {:.2} %", known.name, 100.0 * share),
        None => format!("{} not estimated yet", known.name),
    }
}

#[cfg(test)]
mod tests {
    use shared_types::{Convergence, Estimate, FitUpdate, Verdict};

    use super::estimate_of;

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
