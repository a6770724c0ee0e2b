//! What a fit's page tells that follows from the fit, under the names that the JSON has for it.

use std::collections::BTreeMap;

use dynamics::Model;
use identification::{Fit, Parameter};
use serde::Serialize;

use crate::parameter_table::true_value;
use crate::verdict::{detent_spacing_deg, noise_in_band_mnm};

/// The numbers in captions, by figure and name.
pub type FigureNumbers = BTreeMap<&'static str, BTreeMap<&'static str, f64>>;

/// Numbers on the page of a fit that follow from the fit and the simulated knob.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FitNumbers {
    /// Parameters of the simulated knob as a fit writes them; empty on real hardware.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub true_values: BTreeMap<&'static str, f64>,
    /// Half widths of the parameters' 95 % intervals.
    pub ci95_half_widths: BTreeMap<&'static str, f64>,
    /// Noise of the torque within the fit's band, mNm; `None` if it is not known.
    pub torque_noise_in_band_mnm: Option<f64>,
    /// Residual over that noise; about 1 if the model explains the capture.
    pub residual_over_noise: Option<f64>,
    /// Angle from one detent to the next, degrees; `None` without detents.
    pub detent_spacing_deg: Option<f64>,
}

impl FitNumbers {
    /// Of a fit, and of the model that a simulated rig turned.
    #[must_use]
    pub fn of(fit: &Fit, truth: Option<&Model>) -> Self {
        let value = |name: &str| fit.parameters.get(name).and_then(|told| told.value);
        let true_values = truth.into_iter().flat_map(Model::parameters).filter_map(|(kind, _)| {
            Some((kind.name, true_value(truth, kind.name, value(kind.name))?))
        });
        let half_width = |told: &Parameter| told.ci95.map(|[low, high]| (told.name, 0.5 * (high - low)));
        let torque_noise_in_band_mnm = noise_in_band_mnm(fit);
        Self {
            true_values: true_values.collect(),
            ci95_half_widths: fit.parameters.0.iter().filter_map(half_width).collect(),
            torque_noise_in_band_mnm,
            residual_over_noise: torque_noise_in_band_mnm.map(|noise_mnm| fit.residual_rms_mnm / noise_mnm),
            detent_spacing_deg: value("detent_period").map(detent_spacing_deg),
        }
    }
}
