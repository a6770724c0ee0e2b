//! From single breakaways to the torque that a resting knob bears.

use dynamics::{Direction, Model, Motion};
use identification::checks::Breakaway;
use identification::statistics::student_95;
use serde::Serialize;

/// The torque at which the knob breaks away in one direction.
#[derive(Clone, Debug, Serialize)]
pub struct Threshold {
    /// Median magnitude, mNm; without the model's detents, if there is a model.
    pub torque_mnm: f64,
    /// Its 95 % interval from the scatter; `None` for a single breakaway.
    pub ci95_mnm: Option<[f64; 2]>,
    /// Number of breakaways.
    pub times: usize,
}

impl Threshold {
    /// In the negative and the positive direction.
    pub fn of(seen: &[Breakaway], model: Option<&Model>) -> [Option<Self>; 2] {
        [Direction::Negative, Direction::Positive].map(|direction| {
            let torques: Vec<f64> = seen
                .iter()
                .filter(|breakaway| breakaway.direction == direction)
                .map(|breakaway| {
                    let rest = Motion { angle_rad: breakaway.angle_rad, ..Motion::default() };
                    direction.sign() * (breakaway.torque_mnm - model.map_or(0.0, |model| model.free_torque_mnm(&rest)))
                })
                .collect();
            Self::from_torques(torques)
        })
    }

    #[allow(clippy::cast_precision_loss, reason = "a few breakaways")]
    fn from_torques(mut torques: Vec<f64>) -> Option<Self> {
        if torques.is_empty() {
            return None;
        }
        let torque_mnm = median(&mut torques);
        let count = torques.len() as f64;
        let mut distances: Vec<f64> = torques.iter().map(|torque| (torque - torque_mnm).abs()).collect();
        let scatter = median(&mut distances) / 0.6745;
        // A median is 1.253 times as uncertain as a mean.
        let half = student_95((count - 1.0).max(1.0)) * 1.253 * scatter / count.sqrt();
        let ci95_mnm = (torques.len() > 1).then_some([torque_mnm - half, torque_mnm + half]);
        Some(Self { torque_mnm, ci95_mnm, times: torques.len() })
    }
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    if values.len() % 2 == 1 { values[middle] } else { 0.5 * (values[middle - 1] + values[middle]) }
}

#[cfg(test)]
mod tests {
    use super::Threshold;

    #[test]
    fn the_interval_of_two_breakaways_takes_students_factor_at_one_degree_of_freedom() {
        let threshold = Threshold::from_torques(vec![9.0, 11.0]).expect("there are breakaways");
        let [low, high] = threshold.ci95_mnm.expect("two readings scatter");
        let standard_error = 1.253 / 0.6745 / 2.0_f64.sqrt();
        assert!((0.5 * (high - low) / standard_error - 12.706).abs() < 1e-2, "{low} to {high} mNm");
    }
}
