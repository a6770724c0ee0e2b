//! One model of several captures of the same knob.
//!
//! Every parameter is weighted by the inverse square of its interval. Where captures differ by more
//! than their intervals allow, the excess is a scatter from capture to capture, estimated after
//! DerSimonian and Laird (Controlled Clinical Trials 7, 1986, 177–188) and added to every capture's
//! variance: the combined interval widens, and captures that differ count alike.
//!
//! Phase and period of detents go together: θ/P + S turns about the angle around which a capture
//! lies, and S, the phase at angle zero, follows P wherever that is elsewhere. The phase is therefore
//! combined at the mean angle of all captures, on the circle, and taken back to angle zero with the
//! combined period.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

use dynamics::{Effect, Model, effects};

use crate::estimate::{Fit, Parameter, Parameters};

/// Half width of a 95 % interval, in standard deviations.
const NORMAL_95: f64 = 1.959_964;
/// Captures that differ by this multiple of what their intervals allow are not of the same knob, or one went wrong.
const GROSS: f64 = 5.0;
/// Least share of a phase's variance at angle zero that stays at the capture's own angle.
const LEAST_SHARE: f64 = 0.05;

/// How one parameter repeats from capture to capture.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Repeatability {
    /// The values, capture by capture; `None` where a capture could not tell it.
    pub values: Vec<Option<f64>>,
    /// Largest minus smallest value (of phases: on the circle, at the captures' mean angle).
    pub difference: f64,
    /// 95 % interval of that difference from the two captures' own intervals: ± this.
    pub difference_ci95: f64,
    /// The difference over its interval; above 1 the captures differ by more than their intervals allow.
    pub ratio: f64,
    /// Unit of values and differences.
    pub unit: &'static str,
}

/// A model of several captures; serialises to what `fit --json` gives, with `captures` and `repeatability`.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Average {
    /// The combined fit. Residual, relative error and mean interval are those of all captures together;
    /// the mean interval shrinks (or widens) as the parameters' intervals do.
    #[serde(flatten)]
    pub fit: Fit,
    /// Number of captures.
    pub captures: usize,
    /// How each parameter repeats; those that fewer than two captures tell are left out.
    pub repeatability: BTreeMap<&'static str, Repeatability>,
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
    // The fit that knows most effects lends the list of parameters.
    let most = fits.iter().max_by_key(|fit| fit.effects().len())?;
    let reference = Reference::of(fits);
    let mut parameters = Vec::new();
    let mut repeatability = BTreeMap::new();
    let mut shrinking = Vec::new();
    for parameter in &most.parameters.0 {
        let told: Vec<Told> = fits.iter().filter_map(|fit| Told::of(fit, parameter.name, &reference)).collect();
        if told.is_empty() {
            parameters.push(parameter.clone());
            continue;
        }
        let pairs: Vec<(f64, f64)> = told.iter().map(|one| (one.value, one.half_width)).collect();
        let mean = combined(&pairs);
        if let Some(record) = repeats(fits, parameter, &told) {
            repeatability.insert(parameter.name, record);
        }
        shrinking.extend(
            told.iter().filter(|one| one.half_width > 0.0).map(|one| (mean.half_width / one.half_width).powi(2)),
        );
        parameters.push(Parameter {
            value: Some(mean.value),
            ci95: Some(bounded(parameter, mean.value, mean.half_width)),
            ci95_textbook: None,
            reason: None,
            ..parameter.clone()
        });
    }
    reference.back_to_angle_zero(&mut parameters);

    let mut fit = most.clone();
    sums(&mut fit, fits);
    let shrink = if shrinking.is_empty() { 1.0 } else { mean_of(shrinking.iter().copied()).sqrt() };
    fit.mean_ci95_mnm = shrink * mean_of(fits.iter().map(|one| one.mean_ci95_mnm));
    fit.mean_ci95_textbook_mnm = shrink * mean_of(fits.iter().map(|one| one.mean_ci95_textbook_mnm));
    fit.notes = notes(fits, &repeatability);
    fit.parameters = Parameters(parameters);
    fit.effects = fit.effects.iter().map(|effect| with_values(effect, &fit.parameters)).collect();
    Some(Average { fit, captures: fits.len(), repeatability })
}

/// A value with the half width of its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Combined {
    pub(crate) value: f64,
    pub(crate) half_width: f64,
}

/// The weighted mean of values with half widths, scatter between them included.
#[allow(clippy::cast_precision_loss, reason = "a number of captures")]
pub(crate) fn combined(told: &[(f64, f64)]) -> Combined {
    let smallest = told.iter().map(|one| one.1).filter(|half| *half > 0.0).fold(f64::INFINITY, f64::min);
    // A value without an interval counts like the best one; without any, all count alike.
    let floor = if smallest.is_finite() { smallest } else { 1.0 };
    let variances: Vec<f64> =
        told.iter().map(|one| ((if one.1 > 0.0 { one.1 } else { floor }) / NORMAL_95).powi(2)).collect();
    let mean = |between: f64| {
        let weights = variances.iter().map(|own| 1.0 / (own + between));
        let total: f64 = weights.clone().sum();
        (told.iter().zip(weights).map(|(one, weight)| weight * one.0).sum::<f64>() / total, total)
    };
    let (fixed, total) = mean(0.0);
    let excess: f64 = told.iter().zip(&variances).map(|(one, own)| (one.0 - fixed).powi(2) / own).sum();
    let squares: f64 = variances.iter().map(|own| own.powi(-2)).sum();
    let freedom = told.len() as f64 - 1.0;
    let scale = total - squares / total;
    let between = if scale > 0.0 { ((excess - freedom) / scale).max(0.0) } else { 0.0 };
    let (value, total) = mean(between);
    let known = smallest.is_finite() || between > 0.0;
    Combined { value, half_width: if known { NORMAL_95 / total.sqrt() } else { 0.0 } }
}

/// An angle in (−π, π].
pub(crate) fn wrapped(angle_rad: f64) -> f64 {
    angle_rad - TAU * ((angle_rad - PI) / TAU).ceil()
}

/// What one capture tells of one parameter.
struct Told {
    capture: usize,
    value: f64,
    half_width: f64,
}

impl Told {
    fn of(fit: &Fit, name: &str, reference: &Reference) -> Option<Self> {
        let capture = reference.index(fit)?;
        let parameter = fit.parameters.get(name)?;
        let value = parameter.value?;
        let half_width = half_width(parameter);
        if name == PHASE {
            let (value, half_width) = reference.phase(capture, fit, value, half_width);
            return Some(Self { capture, value, half_width });
        }
        Some(Self { capture, value, half_width })
    }
}

const PHASE: &str = "detent_phase";
const PERIOD: &str = "detent_period";

/// The angle at which phases are combined, and the phase around which the circle is cut open.
struct Reference<'a> {
    fits: &'a [Fit],
    angle_rad: f64,
    /// Mean angle of each capture.
    centres_rad: Vec<f64>,
    phase_rad: f64,
}

impl<'a> Reference<'a> {
    fn of(fits: &'a [Fit]) -> Self {
        let centres_rad: Vec<f64> =
            fits.iter().map(|fit| mean_of(fit.points.iter().map(|point| point.angle_rad))).collect();
        let mut reference = Self { fits, angle_rad: mean_of(centres_rad.iter().copied()), centres_rad, phase_rad: 0.0 };
        let (mut sine, mut cosine) = (0.0, 0.0);
        for (capture, fit) in fits.iter().enumerate() {
            let Some(parameter) = fit.parameters.get(PHASE) else { continue };
            let Some(value) = parameter.value else { continue };
            let (phase, half) = reference.phase(capture, fit, value, half_width(parameter));
            let weight = half.max(1e-9).powi(-2);
            sine += weight * phase.sin();
            cosine += weight * phase.cos();
        }
        reference.phase_rad = sine.atan2(cosine);
        reference
    }

    fn index(&self, fit: &Fit) -> Option<usize> {
        self.fits.iter().position(|known| std::ptr::eq(known, fit))
    }

    /// Phase of a capture's detents at the common angle, and the half width of its interval.
    fn phase(&self, capture: usize, fit: &Fit, at_zero_rad: f64, half_width_rad: f64) -> (f64, f64) {
        let period = fit.parameters.get(PERIOD);
        let Some(period_rad) = period.and_then(|period| period.value) else { return (at_zero_rad, half_width_rad) };
        // d(θ/P)/dP = −θ/P²
        let per_angle = period.map_or(0.0, half_width) / (period_rad * period_rad);
        let centre_rad = self.centres_rad[capture];
        let own = (half_width_rad.powi(2) - (per_angle * centre_rad).powi(2)).max(LEAST_SHARE * half_width_rad.powi(2));
        let half = (own + (per_angle * (self.angle_rad - centre_rad)).powi(2)).sqrt();
        let phase = at_zero_rad + self.angle_rad / period_rad;
        (self.phase_rad + wrapped(phase - self.phase_rad), half)
    }

    /// Takes the combined phase from the common angle back to angle zero.
    fn back_to_angle_zero(&self, parameters: &mut [Parameter]) {
        let period = parameters.iter().find(|parameter| parameter.name == PERIOD);
        let Some((period_rad, period_half)) = period.and_then(|period| Some((period.value?, half_width(period))))
        else {
            return;
        };
        let Some(phase) = parameters.iter_mut().find(|parameter| parameter.name == PHASE) else { return };
        let Some(at_common_rad) = phase.value else { return };
        let half = half_width(phase).hypot(period_half * self.angle_rad / (period_rad * period_rad));
        let value = wrapped(at_common_rad - self.angle_rad / period_rad);
        phase.value = Some(value);
        phase.ci95 = Some([value - half, value + half]);
    }
}

fn half_width(parameter: &Parameter) -> f64 {
    match (parameter.value, parameter.ci95) {
        (Some(value), Some([low, high])) => (high - value).max(value - low),
        _ => 0.0,
    }
}

/// An interval that stays above zero where the first capture's did.
fn bounded(parameter: &Parameter, value: f64, half_width: f64) -> [f64; 2] {
    let floor = parameter.ci95.is_some_and(|[low, _]| low == 0.0);
    let low = value - half_width;
    [if floor { low.max(0.0) } else { low }, value + half_width]
}

fn repeats(fits: &[Fit], parameter: &Parameter, told: &[Told]) -> Option<Repeatability> {
    if told.len() < 2 {
        return None;
    }
    let least = told.iter().min_by(|a, b| a.value.total_cmp(&b.value))?;
    let most = told.iter().max_by(|a, b| a.value.total_cmp(&b.value))?;
    let difference = most.value - least.value;
    let difference_ci95 = least.half_width.hypot(most.half_width);
    let mut values = vec![None; fits.len()];
    for one in told {
        values[one.capture] = fits[one.capture].parameters.get(parameter.name).and_then(|own| own.value);
    }
    let ratio = if difference_ci95 > 0.0 { difference / difference_ci95 } else { 0.0 };
    Some(Repeatability { values, difference, difference_ci95, ratio, unit: parameter.unit })
}

fn notes(fits: &[Fit], repeatability: &BTreeMap<&'static str, Repeatability>) -> Vec<String> {
    let mut notes = Vec::new();
    for (index, fit) in fits.iter().enumerate() {
        notes.extend(fit.notes.iter().map(|note| format!("capture {}: {note}", index + 1)));
    }
    let gross: Vec<&str> =
        repeatability.iter().filter(|(_, record)| record.ratio > GROSS).map(|(name, _)| *name).collect();
    if !gross.is_empty() {
        notes.push(format!(
            "the captures disagree by more than {GROSS} times their intervals in {}: are they of the same knob?",
            gross.join(", ")
        ));
    }
    let with =
        fits.iter().filter(|fit| fit.parameters.get(PERIOD).is_some_and(|period| period.value.is_some())).count();
    if with > 0 && with < fits.len() {
        notes.push(format!("{with} of {} captures show detents; the others take no part in theirs", fits.len()));
    }
    notes
}

/// Residual, relative error and counts of all captures together.
#[allow(clippy::cast_precision_loss, reason = "a number of rows")]
fn sums(combined: &mut Fit, fits: &[Fit]) {
    let (mut residual, mut torque, mut rows) = (0.0, 0.0, 0);
    for fit in fits {
        for point in &fit.points {
            residual += point.residual_mnm.powi(2);
            torque += point.torque_mnm.powi(2);
        }
        rows += fit.points.len();
    }
    combined.residual_rms_mnm = (residual / rows.max(1) as f64).sqrt();
    combined.relative_error_percent = if torque > 0.0 { 100.0 * (residual / torque).sqrt() } else { 0.0 };
    combined.samples = fits.iter().map(|fit| fit.samples).sum();
    combined.rows = fits.iter().map(|fit| fit.rows).sum();
}

/// The effect with the combined values where there are some.
fn with_values(effect: &Effect, parameters: &Parameters) -> Effect {
    let mut effect = *effect;
    let kind = effect.kind();
    for (slot, parameter) in effect.values_mut().iter_mut().zip(kind.parameters) {
        // The inertia as fitted has the gripper in it; the told one does not.
        if kind.name == effects::inertia::KIND.name {
            continue;
        }
        if let Some(value) = parameters.get(parameter.name).and_then(|told| told.value) {
            *slot = value;
        }
    }
    effect
}

fn mean_of(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    if count > 0.0 { sum / count } else { 0.0 }
}
