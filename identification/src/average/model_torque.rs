//! How far the combined model's torque is uncertain.

use dynamics::Model;
use nalgebra::DMatrix;

use crate::estimate::{Fit, Point};
use crate::uncertainty::statistics::{deviation_of_sum, mean};

/// Points of each capture at which the torque's interval is taken.
const POINTS: usize = 400;
/// Step of a parameter for the torque's derivative, in standard deviations.
const STEP: f64 = 1e-3;

/// Mean half width of the 95 % interval of the torque of `combined`, over the motion of all captures, mNm.
pub(super) fn mean_half_width_mnm(combined: &Fit, fits: &[Fit]) -> f64 {
    let base = Model { effects: combined.effects().to_vec(), ..Model::default() };
    let known = &combined.covariance;
    let count = known.order.len();
    let covariance = DMatrix::from_fn(count, count, |row, column| known.rows[row][column]);
    let shifted: Vec<Option<(Model, f64)>> =
        known.order.iter().enumerate().map(|(at, name)| shifted(&base, name, known.rows[at][at].sqrt())).collect();
    let half_width = |point: &Point| {
        let motion = point.motion();
        let torque_mnm = base.torque_mnm(&motion);
        let gradient: Vec<f64> = shifted
            .iter()
            .map(|one| one.as_ref().map_or(0.0, |(model, step)| (model.torque_mnm(&motion) - torque_mnm) / step))
            .collect();
        known.critical * deviation_of_sum(&covariance, &gradient)
    };
    mean(fits.iter().flat_map(|fit| {
        let every = fit.points.len().div_ceil(POINTS).max(1);
        fit.points.iter().step_by(every).map(half_width)
    }))
}

/// The model with one parameter a step further, and the step; `None` if it has no such parameter or that is exact.
fn shifted(base: &Model, name: &str, deviation: f64) -> Option<(Model, f64)> {
    let mut model = base.clone();
    let (effect, slot) = model.effects.iter().enumerate().find_map(|(index, effect)| {
        effect.kind().parameters.iter().position(|parameter| parameter.name == name).map(|slot| (index, slot))
    })?;
    let value = model.effects[effect].values_mut().get_mut(slot)?;
    let before = *value;
    *value += STEP * deviation;
    let step = *value - before;
    (step > 0.0).then_some((model, step))
}
