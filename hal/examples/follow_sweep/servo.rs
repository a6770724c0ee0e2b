//! A position servo for the rig: PID, a notch at the shaft's resonance, and the load's torque fed forward.

use dynamics::{Calibration, Setpoint};
use hal::simulated_rig::Readings;

/// Gains of the servo.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gains {
    /// Torque per angle, mNm/rad.
    pub(crate) proportional: f64,
    /// Torque per speed, mNm·s/rad.
    pub(crate) derivative: f64,
    /// Torque per angle and time, mNm/(rad·s).
    pub(crate) integral: f64,
    /// Damping ratio of the notch's poles, its width; zero for no notch.
    pub(crate) notch_width: f64,
    /// Share of the measured load torque that is fed forward.
    pub(crate) load_share: f64,
    /// Bandwidth of the load torque, Hz.
    pub(crate) load_bandwidth_hz: f64,
}

impl Gains {
    /// Gains that hold for every knob of the paper at 5 to 20 kHz, even with a tick of delay.
    pub(crate) const RECOMMENDED: Self = Self {
        proportional: 4000.0,
        derivative: 30.0,
        integral: 4e4,
        notch_width: 1.0,
        load_share: 0.6,
        load_bandwidth_hz: 90.0,
    };
}

/// Most torque that the integral may give, mNm.
const INTEGRAL_LIMIT_MNM: f64 = 200.0;
/// Damping ratio of the notch's zeros, its depth.
const NOTCH_DEPTH: f64 = 0.1;

/// The servo's state.
#[derive(Debug)]
pub(crate) struct Servo {
    gains: Gains,
    period_s: f64,
    inertia: f64,
    gripper_inertia: f64,
    torque_zero_mnm: f64,
    notch: Biquad,
    load: Biquad,
    integral_mnm: f64,
    previous_rad: f64,
}

impl Servo {
    /// A servo at rest at angle zero.
    ///
    /// The shaft of any knob resonates at √(k/Jm) or above: the notch is put there.
    pub(crate) fn new(calibration: &Calibration, rate_hz: f64, gains: Gains) -> Self {
        let notch_hz =
            (calibration.torque_sensor_stiffness_mnm_rad / calibration.motor_inertia).sqrt() / std::f64::consts::TAU;
        Self {
            gains,
            period_s: 1.0 / rate_hz,
            inertia: calibration.motor_inertia + calibration.gripper_inertia,
            gripper_inertia: calibration.gripper_inertia,
            torque_zero_mnm: calibration.torque_zero_mnm,
            notch: if gains.notch_width > 0.0 {
                Biquad::notch(notch_hz, NOTCH_DEPTH, gains.notch_width, rate_hz)
            } else {
                Biquad::default()
            },
            load: Biquad::low_pass(gains.load_bandwidth_hz, rate_hz),
            integral_mnm: 0.0,
            previous_rad: 0.0,
        }
    }

    /// The torque for this tick, mNm.
    pub(crate) fn step(&mut self, wanted: &Setpoint, measured: &Readings) -> f64 {
        let Gains { proportional, derivative, integral, load_share, .. } = self.gains;
        // The difference of two encoder readings is half a tick old, less than any filter would make it.
        let velocity_rad_s = (measured.angle_rad - self.previous_rad) / self.period_s;
        self.previous_rad = measured.angle_rad;
        let error_rad = wanted.value - measured.angle_rad;
        self.integral_mnm =
            (self.integral_mnm + integral * error_rad * self.period_s).clamp(-INTEGRAL_LIMIT_MNM, INTEGRAL_LIMIT_MNM);
        let feedback_mnm = proportional * error_rad + derivative * (wanted.rate - velocity_rad_s) + self.integral_mnm;
        let load_mnm = measured.torque_mnm - self.torque_zero_mnm - self.gripper_inertia * wanted.acceleration;
        self.inertia * wanted.acceleration + self.notch.step(feedback_mnm) + load_share * self.load.step(load_mnm)
    }
}

/// A second-order filter, direct form I, from a bilinear transform with its frequency kept.
#[derive(Clone, Copy, Debug)]
struct Biquad {
    feed: [f64; 3],
    back: [f64; 2],
    inputs: [f64; 2],
    outputs: [f64; 2],
}

impl Default for Biquad {
    /// Passes everything.
    fn default() -> Self {
        Self::new([1.0, 0.0, 0.0], [1.0, 0.0, 0.0])
    }
}

impl Biquad {
    fn new(feed: [f64; 3], back: [f64; 3]) -> Self {
        let scale = 1.0 / back[0];
        Self {
            feed: feed.map(|value| value * scale),
            back: [back[1] * scale, back[2] * scale],
            inputs: [0.0; 2],
            outputs: [0.0; 2],
        }
    }

    fn low_pass(frequency_hz: f64, rate_hz: f64) -> Self {
        let k = (std::f64::consts::PI * frequency_hz / rate_hz).tan();
        let k2 = k * k;
        Self::new([k2, 2.0 * k2, k2], Self::poles(k, std::f64::consts::FRAC_1_SQRT_2))
    }

    fn notch(frequency_hz: f64, depth: f64, width: f64, rate_hz: f64) -> Self {
        let k = (std::f64::consts::PI * frequency_hz / rate_hz).tan();
        Self::new(Self::poles(k, depth), Self::poles(k, width))
    }

    fn poles(k: f64, damping: f64) -> [f64; 3] {
        [1.0 + 2.0 * damping * k + k * k, 2.0 * (k * k - 1.0), 1.0 - 2.0 * damping * k + k * k]
    }

    fn step(&mut self, input: f64) -> f64 {
        let output = self.feed[0] * input + self.feed[1] * self.inputs[0] + self.feed[2] * self.inputs[1]
            - self.back[0] * self.outputs[0]
            - self.back[1] * self.outputs[1];
        self.inputs = [input, self.inputs[0]];
        self.outputs = [output, self.outputs[0]];
        output
    }
}
