//! The paper sorts its rows by position before the fit; least squares does not care.

use crate::common::{Uniform, ideal, knob, sweep};
use identification::{FitOptions, Point, PreparationMethod, fit};
use nalgebra::{DMatrix, DVector};

/// Least squares of the rows in the order given: M, C₋, C₊, B₋, B₊, and A·cos S, A·sin S at the period known.
fn solve(points: &[Point], period_rad: f64) -> Vec<f64> {
    let rows = points.iter().flat_map(|point| {
        let (backward, forward) = (f64::from(point.velocity_rad_s < 0.0), f64::from(point.velocity_rad_s > 0.0));
        let (sine, cosine) = (point.angle_rad / period_rad).sin_cos();
        let velocity = point.velocity_rad_s;
        [point.acceleration_rad_s2, -backward, forward, backward * velocity, forward * velocity, sine, cosine]
    });
    let matrix = DMatrix::from_row_iterator(points.len(), 7, rows);
    let torque = DVector::from_iterator(points.len(), points.iter().map(|point| point.torque_mnm));
    matrix.svd(true, true).solve(&torque, 1e-14).unwrap().iter().copied().collect()
}

#[test]
fn rows_sorted_by_position_give_the_same_model_as_rows_in_time() {
    let truth = [0.1, 3.0, 4.0, 0.5, 0.6, 2.0, 0.05, 0.3];
    let capture = ideal(&knob(&truth), sweep("linear-chirp"), 0.5, &mut Uniform(21));
    let options = FitOptions { preparation: PreparationMethod::Paper, ..FitOptions::default() };
    let fit = fit(&capture.samples(), &options).unwrap();
    let value = |name: &str| fit.parameters.get(name).unwrap().value.unwrap();
    let (amplitude, phase) = (value("detent_amplitude"), value("detent_phase"));
    let ours = [
        value("inertia"),
        value("coulomb_negative"),
        value("coulomb_positive"),
        value("viscous_negative"),
        value("viscous_positive"),
        amplitude * phase.cos(),
        amplitude * phase.sin(),
    ];
    let in_time = solve(&fit.points, value("detent_period"));
    let mut sorted = fit.points.clone();
    sorted.sort_by(|a, b| a.angle_rad.total_cmp(&b.angle_rad));
    assert!(sorted != fit.points, "the sort moves rows");
    let by_position = solve(&sorted, value("detent_period"));
    for ((time, position), ours) in in_time.iter().zip(&by_position).zip(ours) {
        assert!((time - position).abs() < 1e-9 * time.abs(), "{time} in time, {position} by position");
        assert!((ours - position).abs() < 1e-5 * position.abs(), "{ours} fitted, {position} by position");
    }
}
