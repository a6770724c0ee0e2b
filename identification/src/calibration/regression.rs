//! A linear relation between signals of a capture, solved in a band, with robust intervals.

use super::estimate::CalibrateError;
use crate::numerics::statistics::{MEDIAN_MAGNITUDE, deviation_of_sum, mean, median, rms, student_95};
use crate::preparation::filter::low_pass;
use crate::preparation::row_filter::row_step;
use crate::regression::least_squares::{LeastSquares, RobustCovariance};

/// Rows further from the relation than this many standard deviations are left out: a knob that breaks
/// loose shakes the rig.
const OUTLIER: f64 = 5.0;
/// Most rounds of leaving out outliers.
const ROUNDS: usize = 5;
/// Largest share of a channel's standard deviation that the relation may leave unexplained.
pub(super) const UNEXPLAINED: f64 = 0.5;
/// Time at each end in which the filter settles, in periods of the band's edge.
const SETTLING: f64 = 2.0;

/// The band in which a relation is solved.
#[derive(Clone, Copy, Debug)]
pub(super) struct Band {
    pub(super) edge_hz: f64,
    pub(super) rate_hz: f64,
}

/// A solved relation target = Σ coefficient · column.
pub(super) struct Solved {
    pub(super) coefficients: Vec<f64>,
    covariance: RobustCovariance,
    /// Standard deviation of the target: a constant is explained by any relation.
    pub(super) target_deviation: f64,
    /// RMS of the residual, as a share of `target_deviation`.
    pub(super) unexplained: f64,
}

impl Solved {
    /// Half width of the 95 % interval of a quantity whose derivatives by the coefficients are given.
    pub(super) fn half_width(&self, derivatives: &[f64]) -> f64 {
        student_95(self.covariance.degrees_of_freedom) * deviation_of_sum(&self.covariance.matrix, derivatives)
    }

    /// The error for a channel most of which is not what is `expected`; `None` if the relation explains enough of it.
    pub(super) fn unexplained(
        &self,
        channel: &'static str,
        expected: &'static str,
        remedy: &'static str,
    ) -> Option<CalibrateError> {
        let percent = 100.0 * self.unexplained;
        (self.unexplained > UNEXPLAINED).then_some(CalibrateError::Unexplained { channel, percent, expected, remedy })
    }
}

impl Band {
    /// The signal below the band's edge, without phase shift.
    pub(super) fn smooth(&self, signal: &[f64]) -> Vec<f64> {
        low_pass(4, self.edge_hz, self.rate_hz, signal)
    }

    /// Solves for columns and a target that are already limited to the band.
    pub(super) fn solve(&self, columns: &[Vec<f64>], target: &[f64]) -> Solved {
        let step = row_step(self.edge_hz, self.rate_hz);
        let settling = ((SETTLING * self.rate_hz / self.edge_hz) as usize).min(target.len() / 4);
        let rows = |signal: &[f64]| -> Vec<f64> {
            signal[settling..signal.len() - settling].iter().step_by(step).copied().collect()
        };
        let mut columns: Vec<Vec<f64>> = columns.iter().map(|column| rows(column)).collect();
        let mut target = rows(target);
        let mut solution = LeastSquares::solve(&columns, &target);
        let mut kept: Vec<usize> = (0..target.len()).collect();
        for _ in 0..ROUNDS {
            let distance = |row: &usize| solution.residual[*row].abs();
            let limit = OUTLIER * median(&mut kept.iter().map(distance).collect::<Vec<_>>()) / MEDIAN_MAGNITUDE;
            let (outliers, near): (Vec<usize>, Vec<usize>) = kept.iter().partition(|row| distance(row) > limit);
            if outliers.is_empty() || near.len() < target.len() / 2 {
                break;
            }
            kept = near;
            // A row of zeros has no weight, and the other rows keep their distances in time.
            for row in outliers {
                target[row] = 0.0;
                columns.iter_mut().for_each(|column| column[row] = 0.0);
            }
            solution = LeastSquares::solve(&columns, &target);
        }
        let of_kept = |signal: &[f64]| kept.iter().map(|row| signal[*row]).collect::<Vec<_>>();
        let mut varying = of_kept(&target);
        let mean = mean(&varying);
        varying.iter_mut().for_each(|value| *value -= mean);
        let target_deviation = rms(&varying).max(f64::MIN_POSITIVE);
        Solved {
            covariance: solution.robust(&columns),
            target_deviation,
            unexplained: rms(&of_kept(&solution.residual)) / target_deviation,
            coefficients: solution.coefficients,
        }
    }
}
