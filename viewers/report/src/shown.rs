//! The numbers on a fit's page that follow from the fit, under their names in the JSON.

use std::collections::BTreeMap;

use dynamics::Model;
use identification::diagnosis::{Diagnosis, ForwardFromCommand};
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
    /// The numbers of a fit, and of the model that a simulated rig turned.
    #[must_use]
    pub fn of(fit: &Fit, truth: Option<&Model>) -> Self {
        let value = |name: &str| fit.parameters.get(name).and_then(|parameter| parameter.value);
        let true_values = truth
            .into_iter()
            .flat_map(Model::parameters)
            .filter_map(|(kind, _)| Some((kind.name, true_value(truth, kind.name, value(kind.name))?)));
        let half_width = |parameter: &Parameter| Some((parameter.name, parameter.half_width()?));
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

/// A parameter of a model.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ModelValue {
    /// Its value.
    pub value: f64,
    /// Its unit.
    pub unit: &'static str,
}

/// Numbers on the page of a diagnosis that follow from it.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct DiagnosisNumbers {
    /// Parameters of the final model.
    pub model_parameters: BTreeMap<&'static str, ModelValue>,
    /// What is left of the held-out capture over the noise floor: by the first model, then with each effect more.
    pub heldout_over_noise_floor: Vec<f64>,
    /// Factor by which the added effects reduce each gap; none if nothing was added.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub smaller_by: BTreeMap<&'static str, f64>,
    /// Evidence of each effect less that of its closest rival, nats; `None` where every rival is ruled out.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub evidence_over_closest_rival: Vec<Option<f64>>,
}

impl DiagnosisNumbers {
    /// The numbers of a diagnosis.
    #[must_use]
    pub fn of(found: &Diagnosis) -> Self {
        let model_parameters =
            found.model.parameters().map(|(kind, value)| (kind.name, ModelValue { value, unit: kind.unit }));
        let after = found.steps.iter().map(|step| step.heldout_rms_after);
        let levels = [found.heldout_rms_before].into_iter().chain(after);
        let forward = found.forward_from_command.as_ref().and_then(ForwardFromCommand::before_and_after_rad);
        let gaps = [
            ("heldout_rms", Some([found.heldout_rms_before, found.heldout_rms_after])),
            ("heldout_relative_error_percent", Some(found.heldout_relative_error_percent)),
            ("train_rms", Some([found.train_rms_before, found.train_rms_after])),
            ("forward_angle_rms_rad", found.forward_angle_rms_rad),
            ("forward_from_command", forward),
        ];
        let smaller_by = gaps
            .into_iter()
            .filter(|_| !found.steps.is_empty())
            .filter_map(|(name, gap)| gap.map(|[before, after]| (name, before / after)));
        let over_closest = found.steps.iter().map(|step| {
            let closest = step.rivals.iter().find(|rival| rival.disqualified.is_none())?;
            Some(step.evidence - closest.evidence)
        });
        Self {
            model_parameters: model_parameters.collect(),
            heldout_over_noise_floor: levels.map(|rms_mnm| rms_mnm / found.noise_floor_rms).collect(),
            smaller_by: smaller_by.collect(),
            evidence_over_closest_rival: over_closest.collect(),
        }
    }
}
