//! A shaft that is turned at an end without inertia.

use super::State;
use crate::{Coupling, Motion};

/// The twist x of the shaft: the torque is all taken by it, τ = K·x + D·ẋ.
#[derive(Clone, Debug)]
pub(super) struct Twist {
    stiffness_mnm_rad: f64,
    damping: f64,
    twist_rad: f64,
    rate_rad_s: f64,
    acceleration_rad_s2: f64,
}

impl Twist {
    pub(super) fn of(coupling: &Coupling) -> Self {
        let Coupling { stiffness_mnm_rad, damping, .. } = *coupling;
        Self { stiffness_mnm_rad, damping, twist_rad: 0.0, rate_rad_s: 0.0, acceleration_rad_s2: 0.0 }
    }

    /// Twisted as in a given state.
    pub(super) fn wound(self, state: &State) -> Self {
        Self {
            twist_rad: state.angle_rad - state.inner_angle_rad,
            rate_rad_s: state.velocity_rad_s - state.inner_velocity_rad_s,
            ..self
        }
    }

    /// The shaft's turned end, given the motion of its other one.
    pub(super) fn ahead_of(&self, inner: &Motion) -> Motion {
        Motion {
            time_s: inner.time_s,
            angle_rad: inner.angle_rad + self.twist_rad,
            velocity_rad_s: inner.velocity_rad_s + self.rate_rad_s,
            acceleration_rad_s2: inner.acceleration_rad_s2 + self.acceleration_rad_s2,
        }
    }

    /// Moves on by a step in which the torque goes in a straight line: exact.
    pub(super) fn advance(&mut self, step_s: f64, torque_now_mnm: f64, torque_then_mnm: f64) {
        let Self { stiffness_mnm_rad: stiffness, damping, .. } = *self;
        let steady_rad_s = (torque_then_mnm - torque_now_mnm) / step_s / stiffness;
        // Under a ramp of torque, the lag of the twist behind it settles to a constant with the time constant D/K.
        let lag_s = damping / stiffness;
        let settled = |torque_mnm: f64| torque_mnm / stiffness - steady_rad_s * lag_s;
        let decay = if lag_s > 0.0 { (-step_s / lag_s).exp() } else { 0.0 };
        let excess_rad = (self.twist_rad - settled(torque_now_mnm)) * decay;
        let per_lag = |value: f64| if lag_s > 0.0 { value / lag_s } else { 0.0 };
        self.twist_rad = settled(torque_then_mnm) + excess_rad;
        self.rate_rad_s = steady_rad_s - per_lag(excess_rad);
        self.acceleration_rad_s2 = per_lag(per_lag(excess_rad));
    }
}
