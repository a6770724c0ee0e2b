//! One model of several captures of the same knob.
//!
//! The mean is that of whole parameter vectors: each capture is weighted by the inverse of its covariance
//! ([`Fit::covariance`]), so that a capture that determines a sum of two parameters better than either of them contributes
//! that sum. Where captures differ by more than their covariances say, the excess is a scatter between captures, estimated
//! parameter by parameter after DerSimonian and Laird (Controlled Clinical Trials 7, 1986, 177–188). The scatter always
//! widens the combined interval. It enters the weights only if the captures disagree ([`Agreement`]), so that captures
//! that differ count nearly alike. If they agree, a scatter estimated from two captures is mostly chance and
//! would take weight off the better one.

mod curves;
mod generalised;
mod observation;
mod scalar;

use std::collections::BTreeMap;

use dynamics::{Effect, Model, effects};
use nalgebra::DMatrix;

use crate::estimate::{Covariance, Fit, Parameter, Parameters, Point, residual_of};
use crate::numerics::statistics::{self, NORMAL_95, deviation_of_sum};
use observation::{Observation, PERIOD, PHASE};

pub use scalar::Estimated;
pub(crate) use scalar::combined;

/// If captures differ by this multiple of what their intervals allow, they show different knobs or one of them went wrong.
const GROSS: f64 = 5.0;
/// Probability of the disagreement below which it is worth a note, and captures count alike.
const UNLIKELY: f64 = 1e-3;
/// Points of each capture at which the combined torque's interval is taken.
const POINTS: usize = 400;
/// Step of a parameter for the torque's derivative, in standard deviations.
const STEP: f64 = 1e-3;

/// Whether captures differ by more than their covariances allow.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Agreement {
    /// Σ rᵀV⁻¹r of the captures' parameter vectors about their mean.
    pub chi_squared: f64,
    /// Degrees of freedom: the mean of χ² if the captures agree.
    pub degrees_of_freedom: usize,
    /// Probability of a χ² at least as large if the captures agree, allowing for covariances that are themselves estimates.
    pub probability: f64,
    /// √(χ²/degrees of freedom): how many times larger the differences are than the covariances say.
    pub birge_ratio: f64,
}

impl Agreement {
    /// Whether chance may explain the differences.
    #[must_use]
    pub fn agrees(&self) -> bool {
        self.probability >= UNLIKELY
    }
}

/// A model of several captures; serialises to what `fit --json` gives, with `captures`, `agreement` and `repeatability`.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Average {
    /// The combined fit. Residual and relative error are those of all captures together, and the mean interval is that
    /// of the combined model's torque.
    #[serde(flatten)]
    pub fit: Fit,
    /// Number of captures.
    pub captures: usize,
    /// Whether the captures agree; `None` for one alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub agreement: Option<Agreement>,
    /// Repeatability of each parameter that at least two captures estimate.
    pub repeatability: BTreeMap<&'static str, Repeatability>,
}

/// Repeatability of one parameter from capture to capture.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Repeatability {
    /// The values, capture by capture; `None` where a capture did not identify it.
    pub values: Vec<Option<f64>>,
    /// The values as compared, with half widths of their intervals: phases at [`Repeatability::at_angle_rad`], on one turn.
    pub compared: Vec<Option<Estimated>>,
    /// The combined value, for a phase likewise at [`Repeatability::at_angle_rad`].
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
    /// The repeatability of a parameter; `None` if fewer than two captures estimated it.
    fn of(
        parameter: &Parameter,
        fits: &[Fit],
        observations: &[Observation],
        mean: &Observation,
        common_angle_rad: f64,
    ) -> Option<Self> {
        let compared: Vec<Option<Estimated>> = observations.iter().map(|one| one.estimate(parameter.name)).collect();
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
            mean: mean.estimate(parameter.name)?,
            at_angle_rad: (parameter.name == PHASE).then_some(common_angle_rad),
            difference,
            difference_ci95,
            ratio: if difference_ci95 > 0.0 { difference / difference_ci95 } else { 0.0 },
            unit: parameter.unit,
            compared,
        })
    }
}

impl Average {
    /// The combined model.
    #[must_use]
    pub fn model(&self, name: &str) -> Model {
        let model = self.fit.model(name);
        Model { description: format!("mean of {} captures, {}", self.captures, model.description), ..model }
    }
}

/// Combines fits of captures of the same knob; `None` for none. Rates and sweeps may differ.
#[must_use]
pub fn average(fits: &[Fit]) -> Option<Average> {
    // The list of parameters is that of the fit with the most effects.
    let most = fits.iter().max_by_key(|fit| fit.effects().len())?;
    let common_angle_rad =
        statistics::mean(fits.iter().map(|fit| statistics::mean(fit.points.iter().map(|point| point.angle_rad))));
    let mut observations: Vec<Observation> = fits.iter().map(Observation::of).collect();
    observation::to_angle(&mut observations, common_angle_rad);
    let (mut mean, agreement) = generalised::mean(&observations);
    let repeatability: BTreeMap<_, _> = most
        .parameters
        .0
        .iter()
        .filter_map(|parameter| {
            let record = Repeatability::of(parameter, fits, &observations, &mean, common_angle_rad)?;
            Some((parameter.name, record))
        })
        .collect();
    mean.back_to_zero(common_angle_rad);

    let mut fit = most.clone();
    let curves = curves::mean(fits);
    // Another capture may show an effect that this one does not, such as detents or stick; a measured curve has them in it.
    let are_curves = !curves.is_empty();
    for effect in fits.iter().flat_map(Fit::effects) {
        if !are_curves && fit.effects.iter().all(|known| known.kind().name != effect.kind().name) {
            fit.effects.push(*effect);
        }
    }
    fit.parameters = Parameters(most.parameters.0.iter().map(|parameter| with_mean(parameter, &mean)).collect());
    fit.notes = notes(fits, agreement, &repeatability);
    fit.effects = fit.effects.iter().map(|effect| with_values(effect, &fit.parameters)).collect();
    fit.characteristics.clear();
    for (curve, effect) in curves {
        fit.effects.retain(|other| other.kind().name != curve.effect);
        fit.effects.push(effect);
        fit.characteristics.push(curve);
    }
    if let Some(effect) = curves::beyond_detents(fits).filter(|_| !are_curves) {
        fit.effects.retain(|other| other.kind().name != effect.kind().name);
        fit.effects.push(effect);
    }
    sums(&mut fit, fits);
    fit.covariance = covariance(&mean);
    let own = statistics::mean(fits.iter().map(|one| one.mean_ci95_mnm));
    let textbook = statistics::mean(fits.iter().map(|one| one.mean_ci95_textbook_mnm));
    fit.mean_ci95_mnm = mean_half_width_mnm(&fit, fits);
    fit.mean_ci95_textbook_mnm = if own > 0.0 { textbook * fit.mean_ci95_mnm / own } else { textbook };
    Some(Average { fit, captures: fits.len(), agreement, repeatability })
}

fn with_mean(parameter: &Parameter, mean: &Observation) -> Parameter {
    let Some(Estimated { value, half_width }) = mean.estimate(parameter.name) else { return parameter.clone() };
    // An interval that ends at zero, the bound of its parameter, still does so.
    let floor = if parameter.ci95.is_some_and(|[low, _]| low == 0.0) { 0.0 } else { f64::NEG_INFINITY };
    let ci95 = Some([(value - half_width).max(floor), value + half_width]);
    Parameter { value: Some(value), ci95, ci95_textbook: None, reason: None, ..parameter.clone() }
}

/// Covariance of the mean, restricted to the parameters whose covariance comes from a fit.
fn covariance(mean: &Observation) -> Covariance {
    let joint: Vec<usize> = (0..mean.names.len()).filter(|at| mean.joint[*at]).collect();
    let row = |a: &usize| joint.iter().map(|b| mean.covariance[(*a, *b)]).collect();
    Covariance {
        order: joint.iter().map(|at| mean.names[*at]).collect(),
        rows: joint.iter().map(row).collect(),
        critical: NORMAL_95,
        degrees_of_freedom: mean.degrees_of_freedom,
    }
}

fn notes(
    fits: &[Fit],
    agreement: Option<Agreement>,
    repeatability: &BTreeMap<&'static str, Repeatability>,
) -> Vec<String> {
    let mut notes = Vec::new();
    for (index, fit) in fits.iter().enumerate() {
        notes.extend(fit.notes.iter().map(|note| format!("capture {}: {note}", index + 1)));
    }
    if let Some(agreement) = agreement.filter(|agreement| !agreement.agrees()) {
        notes.push(format!(
            "taken together the captures differ {:.1} times as much as their intervals say; the mean's intervals allow for it",
            agreement.birge_ratio
        ));
    }
    let gross: Vec<&str> =
        repeatability.iter().filter(|(_, record)| record.ratio > GROSS).map(|(name, _)| *name).collect();
    if !gross.is_empty() {
        notes.push(format!(
            "the captures disagree by more than {GROSS} times their intervals in {}: are they of the same knob?",
            gross.join(", ")
        ));
    }
    let shows = |fit: &&Fit| fit.parameters.get(PERIOD).is_some_and(|period| period.value.is_some());
    let with = fits.iter().filter(shows).count();
    if with > 0 && with < fits.len() {
        notes.push(format!("{with} of {} captures show detents; the others take no part in theirs", fits.len()));
    }
    notes
}

/// Residual and relative error of the combined model over all captures, and their counts.
fn sums(combined: &mut Fit, fits: &[Fit]) {
    let points: Vec<Point> = fits.iter().flat_map(|fit| compared(fit, combined)).collect();
    (combined.residual_rms_mnm, combined.relative_error_percent) = residual_of(&points);
    combined.samples = fits.iter().map(|fit| fit.samples).sum();
    combined.rows = fits.iter().map(|fit| fit.rows).sum();
}

/// The points of a capture, compared with the combined model: to the residual of the capture's own fit comes the torque by which the two
/// models differ. It is not filtered as the fit's rows are; where the models are alike, this changes little.
fn compared<'a>(own: &'a Fit, combined: &Fit) -> impl Iterator<Item = Point> + 'a {
    let inertia = |fit: &Fit| fit.parameters.get("inertia").and_then(|known| known.value);
    let excess = inertia(own).zip(inertia(combined)).map_or(0.0, |(own, combined)| own - combined);
    // The effects' inertias have the grippers in them, which may differ from capture to capture.
    let without_inertia = |fit: &Fit| {
        let others = fit.effects.iter().filter(|effect| effect.kind().name != effects::inertia::KIND.name);
        Model { effects: others.copied().collect(), ..Model::default() }
    };
    let (mut one, other) = (without_inertia(own), without_inertia(combined));
    one.effects.push(Effect::new(&effects::inertia::KIND, &[excess]));
    own.points.iter().map(move |point| {
        let motion = point.motion();
        let residual_mnm = point.residual_mnm + one.torque_mnm(&motion) - other.torque_mnm(&motion);
        Point::of(motion, point.torque_mnm, residual_mnm, point.torque_model_ci95_mnm)
    })
}

/// The effect with its values replaced by the combined ones where these exist.
fn with_values(effect: &Effect, parameters: &Parameters) -> Effect {
    let mut effect = *effect;
    let kind = effect.kind();
    for (slot, parameter) in effect.values_mut().iter_mut().zip(kind.parameters) {
        // The effect's inertia includes the gripper; the parameter's does not.
        if kind.name == effects::inertia::KIND.name {
            continue;
        }
        if let Some(value) = parameters.get(parameter.name).and_then(|estimated| estimated.value) {
            *slot = value;
        }
    }
    effect
}

/// Mean half width of the 95 % interval of the torque of `combined`, over the motion of all captures, mNm.
fn mean_half_width_mnm(combined: &Fit, fits: &[Fit]) -> f64 {
    let base = Model { effects: combined.effects().to_vec(), ..Model::default() };
    let known = &combined.covariance;
    let count = known.order.len();
    let covariance = DMatrix::from_fn(count, count, |row, column| known.rows[row][column]);
    let shifted: Vec<Option<(Model, f64)>> =
        known.order.iter().enumerate().map(|(at, name)| shifted(&base, name, known.rows[at][at].sqrt())).collect();
    let half_width = |point: &Point| {
        let motion = point.motion();
        let torque_mnm = base.torque_mnm(&motion);
        let gradient: Vec<f64> = shifted
            .iter()
            .map(|one| one.as_ref().map_or(0.0, |(model, step)| (model.torque_mnm(&motion) - torque_mnm) / step))
            .collect();
        let of_parameters = known.critical * deviation_of_sum(&covariance, &gradient);
        combined
            .characteristics
            .iter()
            .filter_map(|curve| curve.half_width(point.angle_rad))
            .fold(of_parameters, f64::hypot)
    };
    statistics::mean(fits.iter().flat_map(|fit| {
        let every = fit.points.len().div_ceil(POINTS).max(1);
        fit.points.iter().step_by(every).map(half_width)
    }))
}

/// The model with one parameter moved by a small step, and the step; `None` if the model lacks the parameter or its deviation is zero.
fn shifted(base: &Model, name: &str, deviation: f64) -> Option<(Model, f64)> {
    let mut model = base.clone();
    let (effect, slot) = model.effects.iter().enumerate().find_map(|(index, effect)| {
        effect.kind().parameters.iter().position(|parameter| parameter.name == name).map(|slot| (index, slot))
    })?;
    let value = model.effects[effect].values_mut().get_mut(slot)?;
    let before = *value;
    *value += STEP * deviation;
    let step = *value - before;
    (step > 0.0).then_some((model, step))
}
