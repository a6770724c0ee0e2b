//! What bends the torque over the travel and is no detent.

use crate::numerics::vector;
use crate::preparation::motion::KnobMotion;
use crate::preparation::row_filter::RowFilter;
use crate::regression::problem::Column;

/// A spring of any stiffness up to the third power of its deflection, and gravity.
const BENDS: usize = 5;

/// Rows of the place in the travel, its square and its cube, and of the angle's sine and cosine.
pub(crate) fn bends(row_filter: &RowFilter, motion: &KnobMotion) -> Vec<Column> {
    let (lowest, highest) = vector::extent_where(&motion.angle_rad, &row_filter.mask).unwrap_or((0.0, 0.0));
    let (middle, half) = (0.5 * (lowest + highest), 0.5 * (highest - lowest));
    let rows = row_filter.rows_of(BENDS, |range, columns| {
        let angles = &motion.angle_rad[range];
        let (powers, turn) = columns.split_at_mut(BENDS - 2);
        for (power, column) in (1..).zip(powers) {
            column.iter_mut().zip(angles).for_each(|(slot, angle)| *slot = ((angle - middle) / half).powi(power));
        }
        if let [sine, cosine] = turn {
            vector::sines(angles, 1.0, sine, cosine);
        }
    });
    rows.into_iter().map(Column::from).collect()
}
