//! A capture in the order of time, whatever the order of its rows.

use crate::numerics::vector;
use crate::samples::{Rows, Samples};

/// The samples in the order of time; `None` if they are in order, or not fit to be sorted.
///
/// Nothing is dropped: two samples of one time stay, for the check to find.
pub(crate) fn sorted(samples: &Samples<'_>) -> Option<Rows> {
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
    Some(Rows::of(samples, &order))
}
