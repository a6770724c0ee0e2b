//! Parameter by parameter: intended and rendered.

use dynamics::{Effect, Model, Motion, Part, effects};
use identification::Fit;
use loaded_capture::LoadedCapture;
use serde::Serialize;

use analysis::{along_motion, torque_at_knob};

use super::{LARGEST_DIFFERENCE_PERCENT, LARGEST_STATIC_DIFFERENCE_PERCENT};
use crate::check::Threshold;
use crate::parameter_table::true_value;

/// One parameter of a rendered knob.
#[derive(Clone, Debug, Serialize)]
pub struct Verified {
    /// Its name.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Its value in the model.
    pub intended: f64,
    /// Its value in the rendered knob; `None` where the captures do not determine it.
    pub rendered: Option<f64>,
    /// The 95 % interval of the rendered value.
    pub ci95: Option<[f64; 2]>,
    /// 100 · (rendered / intended − 1); for a phase, its error as a share of a period.
    pub difference_percent: Option<f64>,
    /// Whether the interval holds the intended value or the difference is small enough; `None` where there is no value.
    pub passed: Option<bool>,
    /// Why there is no value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

impl Verified {
    pub(super) fn new(
        name: &'static str,
        unit: &'static str,
        intended: f64,
        rendered: f64,
        ci95: Option<[f64; 2]>,
    ) -> Self {
        let difference_percent = if unit == "rad" && name.ends_with("phase") {
            let turn = std::f64::consts::TAU;
            100.0 * ((rendered - intended + 0.5 * turn).rem_euclid(turn) / turn - 0.5)
        } else {
            100.0 * (rendered / intended - 1.0)
        };
        let is_static = name.starts_with("static_");
        let limit = if is_static { LARGEST_STATIC_DIFFERENCE_PERCENT } else { LARGEST_DIFFERENCE_PERCENT };
        let held = ci95.is_some_and(|[low, high]| (low..=high).contains(&intended));
        Self {
            name,
            unit,
            intended,
            rendered: Some(rendered),
            ci95,
            difference_percent: Some(difference_percent),
            passed: Some(held || difference_percent.abs() <= limit),
            reason: None,
        }
    }

    pub(super) fn not_identifiable(name: &'static str, unit: &'static str, intended: f64, reason: String) -> Self {
        Self {
            name,
            unit,
            intended,
            rendered: None,
            ci95: None,
            difference_percent: None,
            passed: None,
            reason: Some(reason),
        }
    }
}

/// The effects of a model that a fit takes beside inertia, friction and detents.
pub(super) fn further_effects(model: &Model) -> Vec<Effect> {
    let base = [effects::inertia::KIND.name, effects::friction::KIND.name, effects::detent::KIND.name];
    let fits = |effect: &&Effect| effect.kind().regressors.is_some() && !base.contains(&effect.kind().name);
    model.effects.iter().filter(fits).copied().collect()
}

/// Every parameter of the model beside what the fit of the rendered knob and its breakaways tell.
pub(super) fn parameters(model: &Model, fit: &Fit, thresholds: &[Option<Threshold>; 2]) -> Vec<Verified> {
    let mut verified = Vec::new();
    for effect in &model.effects {
        for (parameter, value) in effect.parameters() {
            let (name, unit) = (parameter.name, parameter.unit);
            let intended = true_value(model, name).unwrap_or(value);
            if let Part::Stick(_) = effect.kind().part {
                let threshold = match name {
                    "static_negative" => thresholds[0].as_ref(),
                    "static_positive" => thresholds[1].as_ref(),
                    // The speed at which a knob comes to rest shows in no torque.
                    _ => continue,
                };
                // A knob bears at rest at least the friction with which it slides off.
                let limits = model.stick_limits(&Motion::default());
                let borne = if name == "static_negative" { limits.negative_mnm } else { limits.positive_mnm };
                verified.push(match threshold {
                    Some(seen) => Verified::new(name, unit, borne, seen.torque_mnm, seen.ci95_mnm),
                    None => Verified::not_identifiable(
                        name,
                        unit,
                        borne,
                        "the knob did not break away in the creep".to_owned(),
                    ),
                });
                continue;
            }
            verified.push(match fit.parameters.get(name) {
                Some(found) => match found.value {
                    Some(value) => Verified::new(name, unit, intended, value, found.ci95),
                    None => Verified::not_identifiable(name, unit, intended, found.reason.clone().unwrap_or_default()),
                },
                None => {
                    Verified::not_identifiable(name, unit, intended, "a fit does not estimate this effect".to_owned())
                }
            });
        }
    }
    verified
}

/// RMS of rendered minus intended torque over the fit's rows, and of the intended torque, mNm.
///
/// A row is a mean over samples, some of them left out where the knob may stick: rendered minus fitted torque is the fit's
/// residual there, to which comes what the fitted model differs from the intended one for the row's motion.
#[allow(clippy::cast_precision_loss, reason = "a number of rows")]
pub(super) fn torque_error_mnm(model: &Model, fit: &Fit) -> [f64; 2] {
    let mut fitted = fit.model(&model.name);
    // Parameters that are not separately identifiable make up the torque together: their fitted values are used as they are.
    for effect in fitted.effects.iter_mut().filter(|effect| !matches!(effect.kind().part, Part::Inertia(_))) {
        let left = fit.effects().iter().find(|left| left.kind().name == effect.kind().name);
        *effect = left.copied().unwrap_or(*effect);
    }
    let mut sums = [0.0; 2];
    for point in &fit.points {
        let motion = point.motion();
        let intended_mnm = model.torque_mnm(&motion);
        sums[0] += (point.residual_mnm + fitted.torque_mnm(&motion) - intended_mnm).powi(2);
        sums[1] += intended_mnm * intended_mnm;
    }
    sums.map(|sum| (sum / fit.points.len().max(1) as f64).sqrt())
}

/// Length of the means in which torques of a knob of two bodies are compared, s: the band of a diagnosis, 200 Hz.
const MEAN_S: f64 = 0.0025;

/// RMS of captured minus simulated torque over means of the capture, and of the captured torque, mNm: the model as it is, its inner
/// body simulated behind the measured motion of the cap.
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::cast_precision_loss,
    reason = "a few samples"
)]
pub(super) fn along_motion_mnm(model: &Model, capture: &LoadedCapture) -> anyhow::Result<[f64; 2]> {
    let gripper_inertia = capture.calibration.as_ref().map_or(0.0, |known| known.gripper_inertia);
    let motions = identification::knob_motion(&capture.samples(), capture.calibration.as_ref())?;
    let simulated_mnm = along_motion(model, gripper_inertia, &motions).torque_mnm;
    let captured_mnm = torque_at_knob(capture);
    let length = ((MEAN_S * capture.capture.rate_hz) as usize).max(1);
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let mut sums = [0.0; 2];
    for (captured, simulated) in captured_mnm.chunks_exact(length).zip(simulated_mnm.chunks_exact(length)) {
        sums[0] += (mean(captured) - mean(simulated)).powi(2);
        sums[1] += mean(captured).powi(2);
    }
    let count = (captured_mnm.len() / length).max(1) as f64;
    Ok(sums.map(|sum| (sum / count).sqrt()))
}
