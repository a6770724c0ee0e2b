//! A capture's columns.

use dynamics::Calibration;
use identification::{FitOptions, Samples};

/// A capture's columns and what its rig says of itself.
#[derive(Clone, Default)]
pub struct Capture {
    pub t_s: Vec<f64>,
    pub angle_rad: Vec<f64>,
    pub velocity_rad_s: Option<Vec<f64>>,
    pub acceleration_rad_s2: Option<Vec<f64>>,
    pub torque_mnm: Vec<f64>,
    /// The rig's true calibration; `None` of a capture by formula.
    pub calibration: Option<Calibration>,
}

impl Capture {
    /// The columns as a fit takes them.
    pub fn samples(&self) -> Samples<'_> {
        Samples {
            t_s: &self.t_s,
            angle_rad: &self.angle_rad,
            velocity_rad_s: self.velocity_rad_s.as_deref(),
            acceleration_rad_s2: self.acceleration_rad_s2.as_deref(),
            torque_mnm: &self.torque_mnm,
        }
    }

    /// A fit that knows the rig.
    pub fn options(&self) -> FitOptions {
        FitOptions { calibration: self.calibration.clone(), ..FitOptions::default() }
    }

    /// The same, begun `by_s` later.
    pub fn later(&self, by_s: f64) -> Self {
        Self { t_s: self.t_s.iter().map(|time| time + by_s).collect(), ..self.clone() }
    }

    /// The same with `factor` times the torque.
    pub fn louder(&self, factor: f64) -> Self {
        Self { torque_mnm: scaled(&self.torque_mnm, factor), ..self.clone() }
    }

    /// The same with the opposite sign of angle and torque.
    pub fn turned(&self) -> Self {
        Self {
            t_s: self.t_s.clone(),
            angle_rad: scaled(&self.angle_rad, -1.0),
            velocity_rad_s: self.velocity_rad_s.as_ref().map(|column| scaled(column, -1.0)),
            acceleration_rad_s2: self.acceleration_rad_s2.as_ref().map(|column| scaled(column, -1.0)),
            torque_mnm: scaled(&self.torque_mnm, -1.0),
            calibration: self.calibration.clone(),
        }
    }

    /// What the rig of a capture says of itself.
    #[allow(clippy::expect_used, reason = "a capture by formula has no rig, and none asks")]
    pub fn rig(&self) -> &Calibration {
        self.calibration.as_ref().expect("a capture from the rig")
    }
}

fn scaled(column: &[f64], factor: f64) -> Vec<f64> {
    column.iter().map(|value| factor * value).collect()
}
