//! The captures that a diagnosis rests on, and how further ones join them.

use identification::Samples;

use crate::load::LoadedCapture;

/// Rest put between two captures that are made into one, s: longer than any gap that is filled in.
const PAUSE_S: f64 = 1.0;

/// Columns of captures one after the other.
///
/// Between two captures lies a gap, as if samples had been lost: what spans it is left out of every comparison.
pub(super) struct Joined {
    t_s: Vec<f64>,
    angle_rad: Vec<f64>,
    velocity_rad_s: Option<Vec<f64>>,
    acceleration_rad_s2: Option<Vec<f64>>,
    torque_mnm: Vec<f64>,
    /// Torque commanded from the motor, mNm; none unless every capture has it.
    pub(super) commanded_torque_mnm: Option<Vec<f64>>,
}

impl Joined {
    /// Puts captures one after the other. A column that one of them lacks is left out.
    pub(super) fn of(captures: &[&LoadedCapture]) -> Self {
        let mut t_s: Vec<f64> = Vec::new();
        for one in captures {
            let first = one.capture.t_s.first().copied().unwrap_or(0.0);
            let start = t_s.last().map_or(first, |last| last + PAUSE_S);
            t_s.extend(one.capture.t_s.iter().map(|time| time - first + start));
        }
        let all = |column: fn(&LoadedCapture) -> Option<&[f64]>| -> Option<Vec<f64>> {
            let columns: Option<Vec<&[f64]>> = captures.iter().map(|one| column(one)).collect();
            Some(columns?.concat())
        };
        Self {
            t_s,
            angle_rad: all(|one| Some(&one.capture.angle_rad)).unwrap_or_default(),
            velocity_rad_s: all(|one| one.capture.velocity_rad_s.as_deref()),
            acceleration_rad_s2: all(|one| one.capture.acceleration_rad_s2.as_deref()),
            torque_mnm: all(|one| Some(&one.capture.torque_mnm)).unwrap_or_default(),
            commanded_torque_mnm: all(|one| one.capture.commanded_torque_mnm.as_deref()),
        }
    }

    /// The columns that a diagnosis takes.
    pub(super) fn samples(&self) -> Samples<'_> {
        Samples {
            t_s: &self.t_s,
            angle_rad: &self.angle_rad,
            velocity_rad_s: self.velocity_rad_s.as_deref(),
            acceleration_rad_s2: self.acceleration_rad_s2.as_deref(),
            torque_mnm: &self.torque_mnm,
        }
    }
}
