//! The position servo.

use dynamics::{Calibration, Setpoint};

/// Gains of the position servo.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ServoGains {
    /// Torque per angle behind, mNm/rad.
    pub proportional_mnm_rad: f64,
    /// Torque per speed behind, mNm·s/rad.
    pub derivative_mnm_s_rad: f64,
    /// Torque per angle behind and second, mNm/(rad·s).
    pub integral_mnm_rad_s: f64,
    /// Most torque that the integral may hold, mNm.
    pub integral_limit_mnm: f64,
    /// Inertia whose torque is fed forward, mNm·s²/rad: the rig's own, since the knob's is unknown.
    pub feedforward_inertia: f64,
}

impl ServoGains {
    /// Gains that hold any knob from a free gripper to 0.5 mNm·s²/rad on a rig with this calibration.
    ///
    /// The loop crosses over at kd/(2π·J): about 350 Hz with a bare gripper, safely below the
    /// resonance of rotor and gripper over the torque sensor, and 16 Hz with the heaviest knob.
    #[must_use]
    pub fn for_rig(calibration: &Calibration) -> Self {
        Self {
            proportional_mnm_rad: 6_000.0,
            derivative_mnm_s_rad: 50.0,
            integral_mnm_rad_s: 60_000.0,
            integral_limit_mnm: 150.0,
            feedforward_inertia: calibration.motor_inertia + calibration.gripper_inertia,
        }
    }

    /// Torque that follows `setpoint`, mNm, updating the integral over a step of `step_s`.
    pub(super) fn torque_mnm(
        &self,
        setpoint: &Setpoint,
        angle_rad: f64,
        velocity_rad_s: f64,
        step_s: f64,
        integral_mnm: &mut f64,
    ) -> f64 {
        let behind_rad = setpoint.value - angle_rad;
        let integral = *integral_mnm + self.integral_mnm_rad_s * behind_rad * step_s;
        *integral_mnm = integral.clamp(-self.integral_limit_mnm, self.integral_limit_mnm);
        self.proportional_mnm_rad * behind_rad
            + self.derivative_mnm_s_rad * (setpoint.rate - velocity_rad_s)
            + *integral_mnm
            + self.feedforward_inertia * setpoint.acceleration
    }
}
