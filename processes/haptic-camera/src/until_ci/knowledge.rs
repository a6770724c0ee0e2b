//! What an estimate knows of each parameter, and whether that is enough.

use identification::live::{LiveEstimate, Verdict as LiveVerdict};
use identification::{Fit, Parameter};
use shared_types::{FitUpdate, Verdict};

/// A parameter as far as it is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Known {
    /// Standard name.
    pub name: &'static str,
    /// Value; `None` while nothing can be said of it.
    pub value: Option<f64>,
    /// Half the width of the 95 % interval; `None` while there is none.
    pub half_width: Option<f64>,
    /// Whether the model lacks the parameter.
    pub absent: bool,
}

impl Known {
    /// The half width as a share of the value; of a phase, of one radian. `None` while there is no interval.
    pub fn share(&self) -> Option<f64> {
        let scale = if is_phase(self.name) { 1.0 } else { self.value?.abs() };
        Some(self.half_width? / scale)
    }
}

/// What an estimate knows.
#[derive(Clone, Debug, PartialEq)]
pub struct Knowledge {
    /// The parameters of inertia, friction and detents.
    pub parameters: Vec<Known>,
    /// RMS of the velocity so far, rad/s; NaN where it is not known.
    pub speed_rms_rad_s: f64,
    /// RMS of the acceleration so far, rad/s².
    pub acceleration_rms_rad_s2: f64,
}

/// Whether a parameter is known well enough.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Standing {
    /// The interval's half width is this share of the value, which is enough.
    Enough(f64),
    /// Too small to be seen by the torque sensor.
    Negligible,
    /// The model does not have it.
    Absent,
    /// Not yet: the half width is this share of the value, or nothing can be said of it.
    Wanting(Option<f64>),
}

impl Standing {
    /// Whether a capture need not go on for this parameter.
    pub fn is_settled(self) -> bool {
        !matches!(self, Self::Wanting(_))
    }
}

/// What parameters are measured by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Yardstick {
    /// The share that half an interval may be wide, below one.
    pub share: f64,
    /// One step of the torque sensor, mNm.
    pub torque_step_mnm: f64,
}

impl Yardstick {
    /// Where a parameter stands after a motion.
    pub fn standing(&self, known: &Known, of: &Knowledge) -> Standing {
        if known.absent {
            return Standing::Absent;
        }
        let (Some(value), Some(half_width), Some(share)) = (known.value, known.half_width, known.share()) else {
            return Standing::Wanting(None);
        };
        if share <= self.share {
            return Standing::Enough(share);
        }
        let most_mnm = torque_per_unit(known.name, of).map(|torque| (value.abs() + half_width) * torque);
        match most_mnm {
            Some(most_mnm) if most_mnm <= self.torque_step_mnm => Standing::Negligible,
            _ => Standing::Wanting(share.is_finite().then_some(share)),
        }
    }
}

/// Torque that one unit of a parameter makes over the motion so far, mNm; `None` for period and phase, which make none.
fn torque_per_unit(name: &str, of: &Knowledge) -> Option<f64> {
    match name {
        "inertia" => Some(of.acceleration_rms_rad_s2),
        "viscous_negative" | "viscous_positive" => Some(of.speed_rms_rad_s),
        "coulomb_negative" | "coulomb_positive" | "detent_amplitude" => Some(1.0),
        _ => None,
    }
}

fn is_phase(name: &str) -> bool {
    name == "detent_phase"
}

impl From<&FitUpdate> for Knowledge {
    fn from(update: &FitUpdate) -> Self {
        let finite = |value: f64| value.is_finite().then_some(value);
        let known = |(name, estimate): (&'static str, shared_types::Estimate)| Known {
            name,
            value: finite(estimate.value),
            half_width: finite(0.5 * (estimate.ci95_high - estimate.ci95_low)),
            absent: estimate.verdict == Verdict::Absent.code(),
        };
        Self {
            parameters: update.estimates().map(known).to_vec(),
            speed_rms_rad_s: update.speed_rms_rad_s,
            acceleration_rms_rad_s2: update.acceleration_rms_rad_s2,
        }
    }
}

impl From<&LiveEstimate> for Knowledge {
    fn from(estimate: &LiveEstimate) -> Self {
        let parameters = estimate.parameters.iter().map(|parameter| Known {
            name: parameter.name,
            value: parameter.value,
            half_width: parameter.ci95.map(|[low, high]| 0.5 * (high - low)),
            absent: parameter.verdict == LiveVerdict::Absent,
        });
        Self {
            parameters: parameters.collect(),
            speed_rms_rad_s: estimate.speed_rms_rad_s.unwrap_or(f64::NAN),
            acceleration_rms_rad_s2: estimate.acceleration_rms_rad_s2.unwrap_or(f64::NAN),
        }
    }
}

impl Knowledge {
    /// What a fit of the whole capture knows of the same parameters, by the same motion.
    #[must_use]
    pub fn of_fit(&self, fit: &Fit) -> Self {
        let of = |known: &Known| {
            let fitted: Option<&Parameter> = fit.parameters.0.iter().find(|parameter| parameter.name == known.name);
            Known {
                name: known.name,
                value: fitted.and_then(|parameter| parameter.value),
                half_width: fitted.and_then(|parameter| parameter.ci95).map(|[low, high]| 0.5 * (high - low)),
                absent: fitted.is_none_or(|parameter| parameter.value.is_none() && known.absent),
            }
        };
        Self { parameters: self.parameters.iter().map(of).collect(), ..self.clone() }
    }
}
