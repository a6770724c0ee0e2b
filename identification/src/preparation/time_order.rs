//! A capture in the order of time, whatever the order of its rows.

use crate::samples::Samples;
use crate::vector;

/// Columns sorted by time.
pub(crate) struct Sorted {
    t_s: Vec<f64>,
    angle_rad: Vec<f64>,
    velocity_rad_s: Option<Vec<f64>>,
    acceleration_rad_s2: Option<Vec<f64>>,
    torque_mnm: Vec<f64>,
}

impl Sorted {
    /// The samples in the order of time; `None` if they are in order, or not fit to be sorted.
    ///
    /// Nothing is dropped: two samples of one time stay, for the check to find.
    pub(crate) fn of(samples: &Samples<'_>) -> Option<Self> {
        let Samples { t_s, angle_rad, velocity_rad_s, acceleration_rad_s2, torque_mnm } = *samples;
        let columns = [Some(angle_rad), velocity_rad_s, acceleration_rad_s2, Some(torque_mnm)];
        if vector::rises(t_s)
            || columns.iter().flatten().any(|column| column.len() != t_s.len())
            || t_s.iter().any(|time| !time.is_finite())
        {
            return None;
        }
        let mut order: Vec<usize> = (0..t_s.len()).collect();
        order.sort_by(|a, b| t_s[*a].total_cmp(&t_s[*b]));
        let sorted = |column: &[f64]| order.iter().map(|index| column[*index]).collect::<Vec<f64>>();
        Some(Self {
            t_s: sorted(t_s),
            angle_rad: sorted(angle_rad),
            velocity_rad_s: velocity_rad_s.map(sorted),
            acceleration_rad_s2: acceleration_rad_s2.map(sorted),
            torque_mnm: sorted(torque_mnm),
        })
    }

    pub(crate) fn samples(&self) -> Samples<'_> {
        Samples {
            t_s: &self.t_s,
            angle_rad: &self.angle_rad,
            velocity_rad_s: self.velocity_rad_s.as_deref(),
            acceleration_rad_s2: self.acceleration_rad_s2.as_deref(),
            torque_mnm: &self.torque_mnm,
        }
    }
}
