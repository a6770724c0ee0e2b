//! The model's curves in the x-y plots, with the ends of their 95 % intervals.

use std::f64::consts::TAU;

use crate::extent::Extent;
use crate::model_torque::KnobModel;

/// Points of a curve that has no detents to resolve.
const CURVE_POINTS: usize = 121;
/// Points per detent of a curve that has, and of the ring of detents.
pub const POINTS_PER_DETENT: f64 = 16.0;
const MAX_CURVE_POINTS: f64 = 2_000.0;

/// The model in a plot: curves as (x, torque).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ModelCurves {
    pub curves: Vec<Curve>,
    /// Lower and upper ends of its 95 % interval.
    pub borders: Vec<Curve>,
    /// Mean half width of the interval, mNm; `None` where nothing is identified.
    pub half_width_mnm: Option<f64>,
}

pub type Curve = Vec<[f64; 2]>;

/// Torque over angle, two curves: the knob turning slowly either way, without inertia.
pub fn torque_over_angle(model: &KnobModel, [low, high]: Extent) -> ModelCurves {
    let points = model.detent().map_or(CURVE_POINTS, |[_, period, _]| {
        let resolving = (POINTS_PER_DETENT * (high - low) / (TAU * period.abs())).min(MAX_CURVE_POINTS) as usize;
        resolving.max(CURVE_POINTS)
    });
    let mut drawn = ModelCurves::default();
    for slowly in [-f64::MIN_POSITIVE, f64::MIN_POSITIVE] {
        let torque_mnm = |angle: f64| model.torque_mnm(angle, slowly, 0.0);
        drawn.add(curve(low, high, points, torque_mnm), |angle| model.half_width_mnm(angle, slowly));
    }
    drawn
}

/// Torque over velocity: friction in either direction, and the least and the largest torque that the angle adds to it.
pub fn torque_over_velocity(model: &KnobModel, [low, high]: Extent) -> ModelCurves {
    let mut drawn = ModelCurves::default();
    for (from, to) in [(low, -f64::MIN_POSITIVE), (f64::MIN_POSITIVE, high)] {
        if from < to {
            let friction = |band: f64| curve(from, to, 2, |velocity| model.friction_mnm(velocity) + band);
            drawn.add(friction(0.0), |velocity| model.friction_half_width_mnm(velocity));
            let range = model.range_over_angle_mnm(if from < 0.0 { from } else { to });
            drawn.curves.extend(range.into_iter().flatten().map(friction));
        }
    }
    drawn
}

impl ModelCurves {
    /// Adds a curve with its interval, if its torque is identified.
    fn add(&mut self, curve: Curve, half_width_mnm: impl Fn(f64) -> f64) {
        if curve.iter().any(|point| !point[1].is_finite()) {
            return;
        }
        let half_widths: Vec<f64> = curve.iter().map(|point| half_width_mnm(point[0])).collect();
        for side in [-1.0, 1.0] {
            let border = curve.iter().zip(&half_widths).map(|([x, torque], half)| [*x, torque + side * half]);
            self.borders.push(border.collect());
        }
        let mean = half_widths.iter().sum::<f64>() / half_widths.len() as f64;
        // The wider direction speaks for both.
        self.half_width_mnm = Some(self.half_width_mnm.map_or(mean, |other| other.max(mean)));
        self.curves.push(curve);
    }
}

fn curve(low: f64, high: f64, points: usize, torque_mnm: impl Fn(f64) -> f64) -> Curve {
    let last = points.max(2) - 1;
    (0..=last)
        .map(|index| index as f64 / last as f64)
        // Both ends come out exactly, however close to zero: friction jumps there.
        .map(|share| low * (1.0 - share) + high * share)
        .map(|x| [x, torque_mnm(x)])
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coulomb_friction_is_a_step_over_velocity_and_two_lines_over_angle() {
        let coulomb = |name: &str| name.starts_with("coulomb_").then_some([2.5, 0.0]);
        let model = KnobModel::from_estimates(coulomb).unwrap();
        let over_velocity = torque_over_velocity(&model, [-3.0, 4.0]);
        assert_eq!(
            over_velocity.curves,
            [[[-3.0, -2.5], [-f64::MIN_POSITIVE, -2.5]], [[f64::MIN_POSITIVE, 2.5], [4.0, 2.5]]]
        );
        let over_angle = torque_over_angle(&model, [-1.0, 1.0]);
        assert!(over_angle.curves[0].iter().all(|point| point[1] == -2.5));
        assert!(over_angle.curves[1].iter().all(|point| point[1] == 2.5));
        assert_eq!(over_angle.half_width_mnm, Some(0.0));
    }
}
