//! The position servo: PID with a notch at the shaft's resonance, and the load's torque fed forward.
//!
//! Measured on the simulated rig with the paper's knobs, 10 s of `linear-chirp` at 10 kHz, one tick
//! of delay: plain PD with these gains or higher rings at the resonance of rotor and gripper over the
//! torque sensor (about 1 kHz) until the sensor's limit ends the run; the notch takes that away. The
//! knob's torque is unknown but measured, so most of it is fed forward, which halves the following
//! error with knobs that stick.

use biquad::{Biquad as _, Coefficients, DirectForm2Transposed};
use dynamics::{Calibration, Setpoint};
use hal::Measurement;

use super::lowpass::ButterworthLowPass;

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
    /// Share of the measured load torque that is fed forward.
    pub load_share: f64,
    /// Edge of the load torque's low-pass, Hz.
    pub load_edge_hz: f64,
    /// Damping ratio of the notch's zeros: its depth.
    pub notch_depth: f64,
    /// Damping ratio of the notch's poles: its width.
    pub notch_width: f64,
}

impl Default for ServoGains {
    /// Gains that hold each of the paper's knobs, and up to 2 mNm·s²/rad, at 5 to 20 kHz with a tick of delay.
    fn default() -> Self {
        Self {
            proportional_mnm_rad: 4_000.0,
            derivative_mnm_s_rad: 30.0,
            integral_mnm_rad_s: 40_000.0,
            integral_limit_mnm: 200.0,
            load_share: 0.6,
            load_edge_hz: 90.0,
            notch_depth: 0.1,
            notch_width: 1.0,
        }
    }
}

/// The servo with its state.
#[derive(Clone, Copy, Debug)]
pub(super) struct Servo {
    gains: ServoGains,
    rig_inertia: f64,
    gripper_inertia: f64,
    torque_zero_mnm: f64,
    notch: DirectForm2Transposed<f64>,
    load: ButterworthLowPass<1>,
    integral_mnm: f64,
}

impl Servo {
    /// A servo at rest; `None` when the rate is too low for its filters.
    pub(super) fn new(gains: ServoGains, calibration: &Calibration, rate_hz: f64) -> Option<Self> {
        // Whatever the knob, the shaft resonates at √(k/J) of the motor's side or above.
        let resonance_hz =
            (calibration.torque_sensor_stiffness_mnm_rad / calibration.motor_inertia).sqrt() / std::f64::consts::TAU;
        Some(Self {
            gains,
            rig_inertia: calibration.motor_inertia + calibration.gripper_inertia,
            gripper_inertia: calibration.gripper_inertia,
            torque_zero_mnm: calibration.torque_zero_mnm,
            notch: DirectForm2Transposed::new(notch(resonance_hz, gains.notch_depth, gains.notch_width, rate_hz)?),
            load: ButterworthLowPass::new(gains.load_edge_hz, rate_hz)?,
            integral_mnm: 0.0,
        })
    }

    /// Torque that follows `setpoint`, mNm, after a step of `step_s`.
    pub(super) fn torque_mnm(
        &mut self,
        setpoint: &Setpoint,
        measurement: &Measurement,
        velocity_rad_s: f64,
        step_s: f64,
    ) -> f64 {
        let gains = &self.gains;
        let behind_rad = setpoint.value - measurement.angle_rad;
        self.integral_mnm = (self.integral_mnm + gains.integral_mnm_rad_s * behind_rad * step_s)
            .clamp(-gains.integral_limit_mnm, gains.integral_limit_mnm);
        let feedback_mnm = gains.proportional_mnm_rad * behind_rad
            + gains.derivative_mnm_s_rad * (setpoint.rate - velocity_rad_s)
            + self.integral_mnm;
        let load_mnm = measurement.torque_mnm - self.torque_zero_mnm - self.gripper_inertia * setpoint.acceleration;
        self.rig_inertia * setpoint.acceleration
            + self.notch.run(feedback_mnm)
            + gains.load_share * self.load.run(load_mnm)
    }
}

/// A notch (s² + 2·depth·ω·s + ω²)/(s² + 2·width·ω·s + ω²) by the bilinear transform, its frequency kept.
///
/// `None` when the frequency is not below half the rate: then there is nothing to keep out.
fn notch(frequency_hz: f64, depth: f64, width: f64, rate_hz: f64) -> Option<Coefficients<f64>> {
    if !(frequency_hz > 0.0 && frequency_hz < 0.5 * rate_hz) {
        return None;
    }
    let k = (std::f64::consts::PI * frequency_hz / rate_hz).tan();
    let polynomial =
        |damping: f64| [1.0 + 2.0 * damping * k + k * k, 2.0 * (k * k - 1.0), 1.0 - 2.0 * damping * k + k * k];
    let (zeros, poles) = (polynomial(depth), polynomial(width));
    Some(Coefficients {
        b0: zeros[0] / poles[0],
        b1: zeros[1] / poles[0],
        b2: zeros[2] / poles[0],
        a1: poles[1] / poles[0],
        a2: poles[2] / poles[0],
    })
}
