//! Encoder, accelerometer, torque channel and contact: bandwidth, offset, noise and steps.

use dynamics::{Model, Motion};

use super::artefacts::Artefacts;
use super::noise::{Noise, quantised};
use super::switch::Switching;
use super::{ParameterError, RigParameters, Truth};
use crate::Measurement;

/// One reading of the rig's three sensors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Readings {
    /// Encoder angle, rad.
    pub angle_rad: f64,
    /// Accelerometer, gravity included, rad/s².
    pub acceleration_rad_s2: f64,
    /// Torque sensor: what knob and gripper take from the rig, mNm.
    pub torque_mnm: f64,
    /// Whether the control's switch is closed; `None` if none is watched.
    pub contact: Option<bool>,
}

impl From<Readings> for Measurement {
    fn from(readings: Readings) -> Self {
        let Readings { angle_rad, acceleration_rad_s2, torque_mnm, contact } = readings;
        Self { angle_rad, acceleration_rad_s2: Some(acceleration_rad_s2), torque_mnm, contact, ..Self::default() }
    }
}

/// The rig's three sensors.
///
/// Bandwidth belongs to the sensor: its filters advance at every substep. Noise and quantisation belong to a reading. Filters
/// treat the mean over a substep as held, which is exact for what they are given.
#[derive(Debug)]
pub(super) struct Sensors {
    parameters: RigParameters,
    half_substep_s: f64,
    noise: Noise,
    acceleration: FirstOrder,
    torque: SecondOrder,
    artefacts: Artefacts,
    switching: Option<Switching>,
}

impl Sensors {
    /// Sensors that have long been at rest, the torque channel with what `model` says of it.
    ///
    /// # Errors
    /// [`ParameterError`] for a delay that cannot be.
    pub(super) fn new(parameters: &RigParameters, model: &Model, seed: u64) -> Result<Self, ParameterError> {
        let substep_s = parameters.substep_s();
        let at_rest_rad_s2 = gravity_rad_s2(parameters, 0.0);
        Ok(Self {
            parameters: parameters.clone(),
            half_substep_s: substep_s / 2.0,
            noise: Noise::new(seed, parameters.noise_scale),
            acceleration: FirstOrder::new(parameters.acceleration_bandwidth_hz, substep_s, at_rest_rad_s2),
            torque: SecondOrder::new(parameters.torque_bandwidth_hz, substep_s),
            artefacts: Artefacts::new(parameters, model)?,
            switching: parameters.switch.map(Switching::new),
        })
    }

    /// Lets a substep pass that ended in `truth`.
    pub(super) fn step(&mut self, truth: &Truth) {
        let middle_rad = truth.knob_angle_rad - self.half_substep_s * truth.knob_velocity_rad_s;
        let gravity_rad_s2 = gravity_rad_s2(&self.parameters, middle_rad);
        self.acceleration.step(truth.knob_acceleration_rad_s2 + gravity_rad_s2);
        self.torque.step(truth.sensor_torque_mnm);
        self.artefacts.step(self.torque.value);
        if let Some(switching) = &mut self.switching {
            switching.step(truth.time_s, truth.knob_angle_rad);
        }
    }

    /// A reading `beyond_s` after the last substep.
    pub(super) fn read(&mut self, truth: &Truth, beyond_s: f64) -> Readings {
        let Self { parameters, noise, acceleration, torque, artefacts, switching, half_substep_s: _ } = self;
        let angle_rad = truth.motor_angle_rad + beyond_s * truth.motor_velocity_rad_s;
        let acceleration_rad_s2 = acceleration.value
            + beyond_s * acceleration.rate
            + parameters.acceleration_zero_rad_s2
            + noise.sample(parameters.acceleration_noise_rms_rad_s2);
        let motion = Motion {
            time_s: truth.time_s + beyond_s,
            angle_rad,
            velocity_rad_s: truth.motor_velocity_rad_s,
            acceleration_rad_s2: truth.knob_acceleration_rad_s2,
        };
        let torque_mnm = artefacts.read(beyond_s, torque.rate, &motion)
            + parameters.torque_zero_mnm
            + noise.sample(parameters.torque_noise_rms_mnm);
        Readings {
            angle_rad: quantised(angle_rad, parameters.angle_step_rad),
            acceleration_rad_s2: quantised(acceleration_rad_s2, parameters.acceleration_step_rad_s2),
            torque_mnm: quantised(torque_mnm, parameters.torque_step_mnm),
            contact: switching.as_ref().map(|switching| switching.is_closed(motion.time_s)),
        }
    }
}

fn gravity_rad_s2(parameters: &RigParameters, knob_angle_rad: f64) -> f64 {
    parameters.gravity_amplitude_rad_s2 * (knob_angle_rad + parameters.gravity_phase_rad).sin()
}

/// Delay of a first-order low-pass of the given bandwidth for slow signals, s.
pub(super) fn first_order_delay_s(bandwidth_hz: f64) -> f64 {
    1.0 / (std::f64::consts::TAU * bandwidth_hz)
}

/// Delay of a second-order Butterworth low-pass of the given bandwidth for slow signals, s.
pub(super) fn second_order_delay_s(bandwidth_hz: f64) -> f64 {
    std::f64::consts::SQRT_2 / (std::f64::consts::TAU * bandwidth_hz)
}

/// A first-order low-pass, exact for inputs that are constant over a substep.
#[derive(Debug)]
struct FirstOrder {
    decay: f64,
    angular_frequency: f64,
    value: f64,
    rate: f64,
}

impl FirstOrder {
    fn new(bandwidth_hz: f64, substep_s: f64, value: f64) -> Self {
        let angular_frequency = std::f64::consts::TAU * bandwidth_hz;
        Self { decay: (-angular_frequency * substep_s).exp(), angular_frequency, value, rate: 0.0 }
    }

    fn step(&mut self, input: f64) {
        self.value = input + (self.value - input) * self.decay;
        self.rate = self.angular_frequency * (input - self.value);
    }
}

/// A second-order Butterworth low-pass, exact for inputs that are constant over a substep.
///
/// With ω the corner and s = ω/√2 the distance to the input is a free oscillation
/// exp(−s·t)·(cos s·t, sin s·t): damping ratio and damped frequency of a Butterworth pair are equal.
#[derive(Debug)]
struct SecondOrder {
    value: f64,
    rate: f64,
    value_of_value: f64,
    value_of_rate: f64,
    rate_of_value: f64,
    rate_of_rate: f64,
}

impl SecondOrder {
    fn new(bandwidth_hz: f64, substep_s: f64) -> Self {
        let s = std::f64::consts::TAU * bandwidth_hz * std::f64::consts::FRAC_1_SQRT_2;
        let decay = (-s * substep_s).exp();
        let (sine, cosine) = (s * substep_s).sin_cos();
        Self {
            value: 0.0,
            rate: 0.0,
            value_of_value: decay * (cosine + sine),
            value_of_rate: decay * sine / s,
            rate_of_value: -decay * 2.0 * s * sine,
            rate_of_rate: decay * (cosine - sine),
        }
    }

    fn step(&mut self, input: f64) {
        let distance = self.value - input;
        let value = input + self.value_of_value * distance + self.value_of_rate * self.rate;
        self.rate = self.rate_of_value * distance + self.rate_of_rate * self.rate;
        self.value = value;
    }
}
