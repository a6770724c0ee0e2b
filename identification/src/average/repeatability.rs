//! How each parameter repeats from capture to capture.

use super::observation::Observation;
use super::reference::PHASE;
use crate::estimate::{Fit, Parameter};

/// A value with the half width of its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Estimated {
    /// Value.
    pub value: f64,
    /// Half width of its 95 % interval.
    pub half_width: f64,
}

/// How one parameter repeats from capture to capture.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Repeatability {
    /// The values, capture by capture; `None` where a capture did not identify it.
    pub values: Vec<Option<f64>>,
    /// The same with intervals as they were compared: phases at [`Repeatability::at_angle_rad`], on one turn.
    pub compared: Vec<Option<Estimated>>,
    /// The mean as it compares with them.
    pub mean: Estimated,
    /// Angle at which phases were compared, rad; `None` of other parameters.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_angle_rad: Option<f64>,
    /// Largest minus smallest value as compared.
    pub difference: f64,
    /// 95 % interval of that difference from the two captures' own intervals: ± this.
    pub difference_ci95: f64,
    /// The difference over its interval; above 1 the captures differ by more than their intervals allow.
    pub ratio: f64,
    /// Unit of values and differences.
    pub unit: &'static str,
}

impl Repeatability {
    /// Of a parameter that at least two captures told.
    pub(super) fn of(
        parameter: &Parameter,
        fits: &[Fit],
        observations: &[Observation],
        mean: &Observation,
        common_angle_rad: f64,
    ) -> Option<Self> {
        let estimated =
            |one: &Observation| one.estimate(parameter.name).map(|(value, half_width)| Estimated { value, half_width });
        let compared: Vec<Option<Estimated>> = observations.iter().map(estimated).collect();
        let known = || compared.iter().flatten();
        if known().count() < 2 {
            return None;
        }
        let least = known().min_by(|a, b| a.value.total_cmp(&b.value))?;
        let most = known().max_by(|a, b| a.value.total_cmp(&b.value))?;
        let difference = most.value - least.value;
        let difference_ci95 = least.half_width.hypot(most.half_width);
        Some(Self {
            values: fits.iter().map(|fit| fit.parameters.get(parameter.name).and_then(|own| own.value)).collect(),
            mean: estimated(mean)?,
            at_angle_rad: (parameter.name == PHASE).then_some(common_angle_rad),
            difference,
            difference_ci95,
            ratio: if difference_ci95 > 0.0 { difference / difference_ci95 } else { 0.0 },
            unit: parameter.unit,
            compared,
        })
    }
}
