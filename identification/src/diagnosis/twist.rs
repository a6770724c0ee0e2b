//! The motion behind a shaft that twists, from the torque that twists it.
//!
//! The measured torque tells the twist of a shaft of known stiffness and damping at once, without simulating anything:
//! behind it everything is linear again, and the sum of squares has one wide valley over stiffness where a simulated
//! resonance has many narrow ones. The torque's noise above the resonance, which this makes louder, is turned down by
//! the shaft's own response.

use std::f64::consts::TAU;

use dynamics::Coupling;
use realfft::num_complex::Complex;

use super::bounded_least_squares;
use super::capture::Capture;
use super::structure::Structure;
use crate::numerics::fourier;
use crate::numerics::vector::dot;
use crate::preparation::motion::KnobMotion;
use crate::regression::least_squares::residual;

/// Sum of squares of what a structure leaves behind a shaft, and the coefficients with which it does, mNm².
pub(crate) fn squares(base: &Structure, shaft: &Coupling, capture: &Capture) -> (f64, Vec<f64>) {
    let behind = motion(shaft, capture);
    let target = capture.target(0.0);
    let response = turned_down(target.len(), base.inertia(), shaft, capture);
    let rows: Vec<Vec<f64>> = (0..base.effects.len())
        .flat_map(|index| base.rows(index, &behind, &capture.row_filter))
        .map(&response)
        .collect();
    let columns: Vec<&[f64]> = rows.iter().map(Vec::as_slice).collect();
    let target = response(target);
    let coefficients = bounded_least_squares::solve(&columns, &target, &base.nonnegative());
    let left = residual(&columns, &target, &coefficients);
    (dot(&left, &left), coefficients)
}

/// The motion of the body behind the shaft.
fn motion(shaft: &Coupling, capture: &Capture) -> KnobMotion {
    let mut motion = capture.motion.clone();
    let [torque, rate, curvature] = capture.torques();
    let sides = [
        (&mut motion.angle_rad, torque),
        (&mut motion.velocity_rad_s, rate),
        (&mut motion.acceleration_rad_s2, curvature),
    ];
    // Torque on a spring beside a damper: the twist follows it with this time constant.
    let kept = (-shaft.stiffness_mnm_rad / (shaft.damping * capture.rate_hz)).exp();
    for (values, torque) in sides {
        let mut twist = 0.0;
        for (value, torque_mnm) in values.iter_mut().zip(torque) {
            twist = kept * twist + (1.0 - kept) * torque_mnm / shaft.stiffness_mnm_rad;
            *value -= twist;
        }
    }
    motion
}

/// So many rows through the response of an inertia on the shaft: torque at the sensor over torque on the inertia.
#[allow(clippy::cast_precision_loss, reason = "a decimation")]
fn turned_down(
    rows: usize,
    inertia: f64,
    shaft: &Coupling,
    capture: &Capture,
) -> impl Fn(Vec<f64>) -> Vec<f64> + use<> {
    let rate_hz = capture.rate_hz / capture.row_filter.step as f64;
    let response = |cycles: f64| {
        let turning = TAU * cycles * rate_hz;
        let spring = Complex::new(shaft.stiffness_mnm_rad, turning * shaft.damping);
        spring / (spring - inertia * turning * turning)
    };
    fourier::through(rows, &response)
}
