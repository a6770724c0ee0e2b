//! A slow curve measured point by point, for a pressed control, whose torque has no sinusoids.

use dynamics::Motion;
use nalgebra::DMatrix;

use super::{Fitted, Map};
use crate::estimate::Fit;
use crate::regression::block_sums::{BlockSums, Estimate};
use crate::regression::characteristic::{Measured, NO_DETENTS, Places, measure};
use crate::samples::Samples;

/// Fits friction and the torque over the angle to a map; `None` where its rows determine no point.
///
/// A curve gives one friction for both directions, half the mean distance between its branches: a difference between the directions
/// cannot be told from a torque that is independent of the direction.
pub(super) fn fit(samples: &Samples<'_>, map: &Map) -> Option<Fit> {
    let frictions = map.frictions();
    let columns: Vec<Vec<f64>> = frictions.iter().map(|friction| map.friction_column(*friction)).collect();
    let both_ways = frictions.len() == 2;
    let both = || map.directions.iter().map(|direction| f64::from(*direction)).collect();
    let base: Vec<Vec<f64>> = both_ways.then(both).into_iter().collect();
    let places = Places::of(&map.motion.angle_rad.iter().copied().zip(map.torque_mnm.iter().copied()))?;
    let motion = |at: usize| Motion {
        angle_rad: map.motion.angle_rad[at],
        velocity_rad_s: f64::from(map.directions[at]),
        ..Motion::default()
    };
    let rows = map.torque_mnm.len();
    let measured = measure(&base, &vec![true; base.len()], &[], &map.torque_mnm, &places, both_ways, |spline| {
        spline.columns(rows, motion).collect()
    })?;
    let Measured { effects, curves, columns: all, solution, covariance, .. } = measured;
    let known = if both_ways { frictions.as_slice() } else { &[] };
    let mut sums = BlockSums::new(map.torque_mnm.clone());
    let of_friction = columns.into_iter().take(known.len());
    of_friction.chain(all.into_iter().skip(base.len())).for_each(|column| sums.push(column));
    // Both frictions are the one that was fitted.
    let fitted = |column: usize| column.saturating_sub(known.len().saturating_sub(base.len()));
    let width = sums.width();
    let spread =
        |matrix: &DMatrix<f64>| DMatrix::from_fn(width, width, |row, column| matrix[(fitted(row), fitted(column))]);
    let coefficients: Vec<f64> = (0..width).map(|column| solution.coefficients[fitted(column)]).collect();
    let (covariance, textbook) = (spread(&covariance), spread(&solution.textbook_covariance()));
    let estimate = Estimate { coefficients, covariance, textbook };
    let fitted = Fitted { sums, estimate, harmonics: Vec::new(), period_half_width_rad: 0.0, whole_turn: false };
    let mut fit = fitted.fit(samples, map, known, NO_DETENTS, map.notes());
    fit.effects.extend(effects);
    fit.characteristics = curves;
    Some(fit)
}
