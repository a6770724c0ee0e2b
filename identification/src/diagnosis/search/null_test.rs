//! The gain from mere freedom: an effect's own columns, but at the wrong time.

use crate::diagnosis::capture::Capture;
use crate::diagnosis::model_fit::nonlinear::Nonlinear;
use crate::diagnosis::model_fit::structure::Structure;
use crate::diagnosis::search::judged::Judged;
use crate::numerics::statistics::median;
use crate::numerics::vector::square;
use crate::regression::least_squares::{LeastSquares, residual};

/// Shifts of the columns, as shares of the capture.
const SHIFTS: [f64; 5] = [0.19, 0.31, 0.43, 0.61, 0.77];

/// RMS left of the held-out capture when the residual is given as many columns as the effect has parameters, mNm: the
/// derivatives of the effect's torque by its parameters, turned round in time. Median over several turns.
pub(crate) fn rms_mnm(effect: &str, before: &Judged, after: &Structure, train: &Capture, heldout: &Capture) -> f64 {
    let Some(effect) = after.position(effect) else { return before.heldout_rms_mnm };
    let columns = |capture: &Capture| Nonlinear::new(after.clone(), capture).tangents_of(effect);
    rms_of_columns([&columns(train), &columns(heldout)], before, heldout)
}

/// The same with the columns of both captures given.
pub(crate) fn rms_of_columns(
    [train_columns, heldout_columns]: [&[Vec<f64>]; 2],
    before: &Judged,
    heldout: &Capture,
) -> f64 {
    let mut left: Vec<f64> = SHIFTS
        .iter()
        .map(|shift| {
            let is_bounded = vec![false; train_columns.len()];
            let turned = turned(train_columns, *shift);
            let solved = LeastSquares::held(&turned, &before.train_residual, &is_bounded, &[]);
            let turned = self::turned(heldout_columns, *shift);
            let residual = residual(&turned, &before.heldout_residual, &solved.coefficients);
            (square(&residual) / heldout.weight).sqrt()
        })
        .collect();
    median(&mut left)
}

fn turned(columns: &[Vec<f64>], share: f64) -> Vec<Vec<f64>> {
    let turn = |column: &Vec<f64>| {
        let mut column = column.clone();
        let by = (share * column.len() as f64) as usize;
        column.rotate_left(by);
        column
    };
    columns.iter().map(turn).collect()
}
