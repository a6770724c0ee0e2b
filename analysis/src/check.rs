//! What captures show without a fit, beside a fitted model, as `check --json` writes it.

use std::f64::consts::FRAC_PI_2;

use dynamics::{Axis, Direction, Model, Motion};
use identification::checks::{Breakaway, DetentCount, FreeTravel, breakaways, count_detents, free_travel};
use identification::statistics::{MEDIAN_MAGNITUDE, median, student_95};
use loaded_capture::LoadedCapture;
use serde::{Serialize, Serializer};

use crate::AnalysisError;

/// What captures show, and how that agrees with a model.
#[derive(Debug, Serialize)]
pub struct Check {
    /// What each capture shows.
    pub captures: Vec<Shown>,
    /// Each quantity as the captures show it best, beside the model's value.
    pub agreement: Vec<CheckedQuantity>,
}

/// What a capture shows.
#[derive(Debug, Serialize)]
pub struct Shown {
    /// The capture.
    pub capture: String,
    /// Detents counted, if the capture turns far enough both ways.
    pub detents: Option<DetentCount>,
    /// Why they cannot be counted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub no_detents: Option<String>,
    /// Torque at which the knob broke away in the negative direction, a magnitude.
    pub static_negative: Option<Threshold>,
    /// The same in the positive direction.
    pub static_positive: Option<Threshold>,
    /// Stretches in which the knob turned freely until it met what is behind its lost motion.
    free_travel: Vec<FreeTravel>,
    /// Why breakaways tell no torque.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub no_static: Option<LostMotionError>,
}

/// The torque at which the knob breaks away in one direction.
#[derive(Clone, Debug, Serialize)]
pub struct Threshold {
    /// Median magnitude, mNm; without the model's detents, if there is a model.
    pub(crate) torque_mnm: f64,
    /// Its 95 % interval from the scatter; `None` for a single breakaway.
    pub(crate) ci95_mnm: Option<[f64; 2]>,
    /// Breakaways in that direction.
    pub times: usize,
}

/// Why breakaways do not tell the torque at which a knob breaks away.
#[derive(Clone, Copy, Debug, thiserror::Error)]
#[error(
    "static_negative and static_positive are not identifiable: the knob turned freely, {} and for up to {}, before it \
     met any torque, and the start of motion through such backlash looks like a breakaway; remove the backlash, or run \
     `diagnose`",
    if *times == 1 { "once".to_owned() } else { format!("{times} times") },
    match axis {
        Axis::Rotary => format!("{:.2}° ({longest:.3} rad)", longest.to_degrees()),
        Axis::Linear => format!("{longest:.3} mm"),
    }
)]
pub struct LostMotionError {
    /// How often it turned freely.
    times: usize,
    /// The longest way of these, rad or mm.
    longest: f64,
    axis: Axis,
}

/// Serialises as the sentence of the error.
impl Serialize for LostMotionError {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// A quantity by its check and by the model.
#[derive(Debug, Serialize)]
pub struct CheckedQuantity {
    /// Its name.
    pub quantity: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// As the captures show it.
    pub checked: f64,
    /// The 95 % interval of that.
    pub ci95: Option<[f64; 2]>,
    /// The model's value.
    pub model: Option<f64>,
    /// 100 · (checked / model − 1).
    pub difference_percent: Option<f64>,
}

impl Threshold {
    /// In the negative and the positive direction.
    pub(crate) fn of(loaded: &LoadedCapture, model: Option<&Model>) -> Result<[Option<Self>; 2], AnalysisError> {
        let seen = breakaways(&loaded.samples(), loaded.calibration.as_ref())?;
        Ok([Direction::Negative, Direction::Positive].map(|direction| {
            let torque_mnm = |breakaway: &Breakaway| {
                let rest = Motion { angle_rad: breakaway.angle_rad, ..Motion::default() };
                direction.sign() * (breakaway.torque_mnm - model.map_or(0.0, |model| model.free_torque_mnm(&rest)))
            };
            let seen = seen.iter().filter(|breakaway| breakaway.direction == direction);
            Self::from_torques(seen.map(torque_mnm).collect())
        }))
    }

    fn from_torques(mut torques: Vec<f64>) -> Option<Self> {
        if torques.is_empty() {
            return None;
        }
        let torque_mnm = median(&mut torques);
        let count = torques.len() as f64;
        let mut distances: Vec<f64> = torques.iter().map(|torque| (torque - torque_mnm).abs()).collect();
        let scatter = median(&mut distances) / MEDIAN_MAGNITUDE;
        // A median is √(π/2) times as uncertain as a mean.
        let half = student_95(count - 1.0) * FRAC_PI_2.sqrt() * scatter / count.sqrt();
        let ci95_mnm = (torques.len() > 1).then_some([torque_mnm - half, torque_mnm + half]);
        Some(Self { torque_mnm, ci95_mnm, times: torques.len() })
    }
}

impl Shown {
    /// Looks at a capture; with a model, breakaways count without its detents.
    ///
    /// # Errors
    /// [`AnalysisError::Motion`], for samples that are not a capture of a motion.
    pub fn of(loaded: &LoadedCapture, model: Option<&Model>) -> Result<Self, AnalysisError> {
        let samples = loaded.samples();
        let counted = count_detents(&samples);
        let [static_negative, static_positive] = Threshold::of(loaded, model)?;
        Ok(Self {
            capture: loaded.title(),
            no_detents: counted.as_ref().err().map(ToString::to_string),
            detents: counted.ok(),
            static_negative,
            static_positive,
            free_travel: free_travel(&samples, loaded.calibration.as_ref())?,
            no_static: None,
        })
    }
}

impl Check {
    /// Compares what captures of one knob show with a model.
    #[must_use]
    pub fn of(axis: Axis, mut captures: Vec<Shown>, model: Option<&Model>) -> Self {
        withhold_breakaways(axis, &mut captures);
        Self { agreement: agreement(axis, &captures, model), captures }
    }
}

/// Discards the breakaways in all captures of a knob if one capture shows lost motion. The start of the cap's motion through the gap looks
/// like a breakaway, and the inner body, which bears the torque, rests at an angle that the encoder does not measure.
fn withhold_breakaways(axis: Axis, captures: &mut [Shown]) {
    let ways: Vec<f64> = captures.iter().flat_map(|shown| &shown.free_travel).map(FreeTravel::travel_rad).collect();
    if ways.is_empty() {
        return;
    }
    let longest = ways.iter().copied().fold(0.0, f64::max);
    let reason = LostMotionError { times: ways.len(), longest, axis };
    for shown in captures {
        (shown.static_negative, shown.static_positive) = (None, None);
        shown.no_static = Some(reason);
    }
}

fn agreement(axis: Axis, captures: &[Shown], model: Option<&Model>) -> Vec<CheckedQuantity> {
    let mut agreement = Vec::new();
    let mut add = |quantity, unit, checked: f64, ci95, model: Option<f64>| {
        let difference_percent = model.map(|model| 100.0 * (checked / model - 1.0));
        agreement.push(CheckedQuantity { quantity, unit, checked, ci95, model, difference_percent });
    };
    let counted = captures.iter().filter_map(|shown| shown.detents.as_ref());
    if let Some(count) = counted.max_by(|a, b| a.turned_rad.total_cmp(&b.turned_rad)) {
        let period = model.and_then(|model| model.parameter("detent_period"));
        let per_turn_ci95 = [1.0 / count.period_ci95_rad[1], 1.0 / count.period_ci95_rad[0]];
        if axis.is_rotary() {
            add("detents per turn", "", count.per_turn, Some(per_turn_ci95), period.map(|period| 1.0 / period));
        }
        add("detent_period", "rad", count.period_rad, Some(count.period_ci95_rad), period);
    }
    let mut add_static = |quantity, of: fn(&Shown) -> &Option<Threshold>| {
        if let Some(threshold) = captures.iter().filter_map(|shown| of(shown).as_ref()).max_by_key(|seen| seen.times) {
            let fitted = model.and_then(|model| model.parameter(quantity));
            add(quantity, "mNm", threshold.torque_mnm, threshold.ci95_mnm, fitted);
        }
    };
    add_static("static_negative", |shown| &shown.static_negative);
    add_static("static_positive", |shown| &shown.static_positive);
    agreement
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]

    use super::Threshold;

    #[test]
    fn the_interval_of_two_breakaways_is_students_of_one_degree_of_freedom() {
        // Median 2, magnitudes of the differences 0.1: 12.706 · √(π/2) · 0.1/0.67449 / √2.
        let [low, high] = Threshold::from_torques(vec![1.9, 2.1]).unwrap().ci95_mnm.unwrap();
        assert!((0.5 * (high - low) - 1.669_5).abs() < 1e-3, "{low} to {high}");
    }
}
