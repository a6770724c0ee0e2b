//! From single breakaways to the torque that a resting knob bears.

use std::f64::consts::FRAC_PI_2;

use dynamics::{Direction, Model, Motion};
use identification::checks::Breakaway;
use identification::statistics::{MEDIAN_MAGNITUDE, median, student_95};
use serde::Serialize;

/// The torque at which the knob breaks away in one direction.
#[derive(Clone, Debug, Serialize)]
pub struct Threshold {
    /// Median magnitude, mNm; without the model's detents, if there is a model.
    pub torque_mnm: f64,
    /// Its 95 % interval from the scatter; `None` for a single breakaway.
    pub ci95_mnm: Option<[f64; 2]>,
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
