//! The motor's winding and the amplifier's current loop.

use super::RigParameters;

/// A winding under current control.
///
/// The voltage is held over a substep, over which the winding's equation L·di/dt = u − R·i − k·ω is
/// solved exactly. The PI controller's zero lies on the winding's pole, so that the current follows
/// a step as 1 − exp(−2π·bandwidth·t) until the voltage is at its limit.
#[derive(Debug)]
pub(super) struct Drive {
    resistance_ohm: f64,
    torque_constant_mnm_a: f64,
    supply_v: f64,
    peak_current_a: f64,
    /// What remains of a current after a substep with the terminals shorted.
    decay: f64,
    /// The mean of that decay over the substep.
    mean_decay: f64,
    gain_v_a: f64,
    integral_v: f64,
    current_a: f64,
}

impl Drive {
    pub(super) fn new(parameters: &RigParameters) -> Self {
        let substep_s = parameters.substep_s();
        let substep_in_time_constants =
            substep_s * parameters.terminal_resistance_ohm / parameters.terminal_inductance_h;
        let decay = (-substep_in_time_constants).exp();
        let loop_decay = (-std::f64::consts::TAU * parameters.current_bandwidth_hz * substep_s).exp();
        Self {
            resistance_ohm: parameters.terminal_resistance_ohm,
            torque_constant_mnm_a: parameters.torque_constant_mnm_a,
            supply_v: parameters.supply_v,
            peak_current_a: parameters.peak_current_a,
            decay,
            mean_decay: (1.0 - decay) / substep_in_time_constants,
            gain_v_a: parameters.terminal_resistance_ohm * (1.0 - loop_decay) / (1.0 - decay),
            integral_v: 0.0,
            current_a: 0.0,
        }
    }

    pub(super) fn current_a(&self) -> f64 {
        self.current_a
    }

    /// One substep towards the commanded torque, or with the amplifier off; gives the mean torque of
    /// the motor over it, mNm.
    pub(super) fn step(&mut self, command_mnm: Option<f64>, motor_velocity_rad_s: f64) -> f64 {
        let Some(command_mnm) = command_mnm else { return self.run_out() };
        let target_a = (command_mnm / self.torque_constant_mnm_a).clamp(-self.peak_current_a, self.peak_current_a);
        let error_a = target_a - self.current_a;
        let wanted_v = self.gain_v_a * error_a + self.integral_v;
        let voltage_v = wanted_v.clamp(-self.supply_v, self.supply_v);
        // At its limit the integral only moves back: otherwise it would wind up.
        if wanted_v == voltage_v || wanted_v * error_a < 0.0 {
            self.integral_v += self.gain_v_a * (1.0 - self.decay) * error_a;
        }
        let back_emf_v = 1e-3 * self.torque_constant_mnm_a * motor_velocity_rad_s;
        let final_a = (voltage_v - back_emf_v) / self.resistance_ohm;
        let mean_a = final_a + (self.current_a - final_a) * self.mean_decay;
        self.current_a = final_a + (self.current_a - final_a) * self.decay;
        self.torque_constant_mnm_a * mean_a
    }

    /// A substep with the bridge open: the current runs out into the supply and stays at zero.
    fn run_out(&mut self) -> f64 {
        self.integral_v = 0.0;
        let start_a = self.current_a;
        let final_a = -self.supply_v.copysign(start_a) / self.resistance_ohm;
        let end_a = final_a + (start_a - final_a) * self.decay;
        self.current_a = if end_a * start_a > 0.0 { end_a } else { 0.0 };
        self.torque_constant_mnm_a * (start_a + self.current_a) / 2.0
    }
}
