//! A capture as it would be behind a shaft that twists, from the torque that twists it.
//!
//! The measured torque tells the twist of a shaft of known stiffness and damping at once, without simulating anything:
//! behind it everything is linear again, and the sum of squares has one wide valley over stiffness where a simulated
//! resonance has many narrow ones. The torque's noise above the resonance, which this makes louder, is turned down by
//! the shaft's own response.

use std::f64::consts::TAU;

use dynamics::Coupling;
use realfft::num_complex::Complex;

use super::capture::Capture;
use crate::numerics::fourier::Response;
use crate::preparation::motion::KnobMotion;

/// The capture of a knob of this inertia as it would be with the motion of the shaft's other end.
pub(crate) fn behind(shaft: &Coupling, inertia: f64, capture: &Capture) -> Capture {
    let mut behind = capture.with_motion(motion(shaft, capture));
    behind.row_filter.response = Some(turned_down(inertia, shaft, capture));
    behind
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

/// The response of an inertia on the shaft: torque at the sensor over torque on the inertia.
#[allow(clippy::cast_precision_loss, reason = "a decimation")]
fn turned_down(inertia: f64, shaft: &Coupling, capture: &Capture) -> Response {
    let row_filter = &capture.row_filter;
    let rate_hz = capture.rate_hz / row_filter.step as f64;
    Response::new(row_filter.mask.len().div_ceil(row_filter.step), &|cycles| {
        let turning = TAU * cycles * rate_hz;
        let spring = Complex::new(shaft.stiffness_mnm_rad, turning * shaft.damping);
        spring / (spring - inertia * turning * turning)
    })
}
