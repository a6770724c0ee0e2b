//! The comparison row by row, for plots.

use crate::diagnosis::capture::{Capture, SLIDING};
use crate::diagnosis::findings::Row;
use crate::diagnosis::search::judged::Judged;

/// Rows of training and held-out capture in which the knob surely slides.
pub(crate) fn of(first: &Judged, last: &Judged, captures: [&Capture; 2]) -> [Vec<Row>; 2] {
    let residuals = [(&first.train_residual, &last.train_residual), (&first.heldout_residual, &last.heldout_residual)];
    let mut all = captures.into_iter().zip(residuals).map(|(capture, (before, after))| {
        let torque = capture.target(last.structure.delay_s());
        let motions = capture.row_motions();
        let sliding = motions.iter().enumerate().filter(|(_, (_, mask))| *mask > SLIDING);
        sliding
            .map(|(index, (motion, _))| Row {
                t_s: capture.start_s + motion.time_s,
                angle_rad: motion.angle_rad,
                velocity_rad_s: motion.velocity_rad_s,
                torque_mnm: torque[index],
                residual_before_mnm: before[index],
                residual_after_mnm: after[index],
            })
            .collect()
    });
    [all.next().unwrap_or_default(), all.next().unwrap_or_default()]
}
