//! What an estimate knows of each parameter, and whether that is enough.

use identification::Fit;
use identification::live::{
    Convergence, Criterion, LiveEstimate, MotionRms, Verdict as LiveVerdict, relative_half_width,
};
use shared_types::FitUpdate;

/// A parameter as far as it is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Known {
    /// Standard name.
    pub name: &'static str,
    /// Value; `None` while nothing can be said of it.
    pub value: Option<f64>,
    /// Half the width of the 95 % interval; `None` while there is none.
    pub half_width: Option<f64>,
    /// Whether the model has the parameter.
    pub is_in_model: bool,
    /// Whether it is known as well as was asked for.
    pub convergence: Convergence,
}

impl Known {
    /// The half width as a share of the value; of a phase, of one radian. `None` while there is no interval.
    pub fn share(&self) -> Option<f64> {
        Some(relative_half_width(self.name, self.value?, self.half_width?)).filter(|share| share.is_finite())
    }

    /// Whether a capture need not go on for this parameter.
    pub fn is_settled(&self) -> bool {
        !self.is_in_model || self.convergence != Convergence::Open
    }
}

/// What an estimate knows.
#[derive(Clone, Debug, PartialEq)]
pub struct Knowledge {
    /// The parameters of inertia, friction and detents.
    pub parameters: Vec<Known>,
    /// RMS of the motion so far; NaN where it is not known.
    pub motion: MotionRms,
}

impl Knowledge {
    /// Whether every parameter is known well enough.
    pub fn is_enough(&self) -> bool {
        !self.parameters.is_empty() && self.parameters.iter().all(Known::is_settled)
    }

    /// The parameters that are not known well enough, the least known first.
    pub fn open(&self) -> Vec<Known> {
        let mut open: Vec<Known> = self.parameters.iter().filter(|known| !known.is_settled()).copied().collect();
        let width = |known: &Known| known.share().unwrap_or(f64::INFINITY);
        open.sort_by(|one, other| width(other).total_cmp(&width(one)));
        open
    }

    /// What a fit of the whole capture knows of the same parameters, by the same motion.
    #[must_use]
    pub fn of_fit(&self, fit: &Fit, criterion: &Criterion) -> Self {
        let of = |known: &Known| {
            let fitted = fit.parameters.0.iter().find(|parameter| parameter.name == known.name);
            let value = fitted.and_then(|parameter| parameter.value);
            let half_width = fitted.and_then(|parameter| parameter.ci95).map(|[low, high]| 0.5 * (high - low));
            let convergence = value.zip(half_width).map_or(Convergence::Open, |(value, half_width)| {
                criterion.judge(known.name, value, half_width, self.motion)
            });
            let is_in_model = fitted.is_some() && (value.is_some() || known.is_in_model);
            Known { value, half_width, is_in_model, convergence, ..*known }
        };
        Self { parameters: self.parameters.iter().map(of).collect(), ..*self }
    }
}

impl From<&FitUpdate> for Knowledge {
    fn from(update: &FitUpdate) -> Self {
        let finite = |value: f64| value.is_finite().then_some(value);
        let known = |(name, estimate): (&'static str, shared_types::Estimate)| Known {
            name,
            value: finite(estimate.value),
            half_width: finite(estimate.half_width()),
            is_in_model: estimate.is_in_model(),
            convergence: match shared_types::Convergence::from_code(estimate.convergence) {
                Some(shared_types::Convergence::Converged) => Convergence::Converged,
                Some(shared_types::Convergence::Negligible) => Convergence::Negligible,
                Some(shared_types::Convergence::Open) | None => Convergence::Open,
            },
        };
        Self {
            parameters: update.estimates().map(known).to_vec(),
            motion: MotionRms {
                velocity_rad_s: update.speed_rms_rad_s,
                acceleration_rad_s2: update.acceleration_rms_rad_s2,
            },
        }
    }
}

impl From<&LiveEstimate> for Knowledge {
    fn from(estimate: &LiveEstimate) -> Self {
        let parameters = estimate.parameters.iter().map(|parameter| Known {
            name: parameter.name,
            value: parameter.value,
            half_width: parameter.half_width(),
            is_in_model: parameter.verdict != LiveVerdict::Absent,
            convergence: parameter.convergence,
        });
        Self { parameters: parameters.collect(), motion: estimate.motion() }
    }
}

#[cfg(test)]
mod tests {
    use shared_types::{Convergence, Estimate, FitUpdate, Verdict};

    use super::Knowledge;

    #[test]
    fn the_terminal_counts_as_known_what_the_page_does() {
        for verdict in [Verdict::NotYet, Verdict::Estimated] {
            for convergence in [Convergence::Open, Convergence::Converged, Convergence::Negligible] {
                let inertia =
                    Estimate { verdict: verdict.code(), convergence: convergence.code(), ..Estimate::default() };
                let known = Knowledge::from(&FitUpdate { inertia, ..FitUpdate::default() }).parameters[0];
                assert_eq!(known.is_settled(), inertia.is_settled(), "{verdict:?}, {convergence:?}");
            }
        }
    }
}
