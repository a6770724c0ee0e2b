//! A servo driving the simulated rig through an excitation, and how well it followed.

use dynamics::{Excitation, Model};
use hal::Apparatus;
use hal::simulated_rig::{RigParameters, SimulatedRig};

use super::servo::{Gains, Servo};

/// One run.
pub(crate) struct Conditions {
    /// Sample rate, Hz.
    pub(crate) rate_hz: f64,
    /// Ticks by which the torque comes late.
    pub(crate) delay_ticks: usize,
    /// Duration, s.
    pub(crate) duration_s: f64,
    /// The rig.
    pub(crate) parameters: RigParameters,
}

impl Default for Conditions {
    fn default() -> Self {
        Self { rate_hz: 10_000.0, delay_ticks: 0, duration_s: 10.0, parameters: RigParameters::default() }
    }
}

/// How well the servo followed.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Following {
    /// Largest following error, rad.
    pub(crate) peak_rad: f64,
    /// RMS of the following error, rad.
    pub(crate) rms_rad: f64,
    /// Share of ticks at the motor's limit.
    pub(crate) clipped: f64,
    /// RMS of the command's change from tick to tick, mNm: a ringing shaft shows here first.
    pub(crate) command_change_mnm: f64,
    /// Largest speed, rad/s.
    pub(crate) speed_rad_s: f64,
    /// Largest torque on the sensor, mNm.
    pub(crate) sensor_mnm: f64,
    /// Whether a limit of the rig was passed.
    pub(crate) limit_passed: bool,
}

/// Drives `knob` through `excitation`.
///
/// # Errors
/// What the rig says.
pub(crate) fn drive(
    knob: &Model,
    excitation: &Excitation,
    gains: Gains,
    conditions: &Conditions,
) -> Result<Following, Box<dyn std::error::Error>> {
    let Conditions { rate_hz, delay_ticks, duration_s, parameters } = conditions;
    let mut rig = SimulatedRig::new(parameters.clone(), knob.clone(), 1)?;
    let limits = rig.description().limits;
    let mut servo = Servo::new(&rig.description().calibration, *rate_hz, gains);
    rig.enable()?;
    let ticks = (duration_s * rate_hz) as u64;
    let mut late_mnm = std::collections::VecDeque::from(vec![0.0; *delay_ticks]);
    let mut following = Following::default();
    let (mut squares, mut change_squares, mut previous_mnm) = (0.0, 0.0, 0.0);
    for tick in 0..ticks {
        let time_s = tick as f64 / rate_hz;
        let measured = rig.read((time_s * 1e9).round() as u64)?;
        let wanted = excitation.at(time_s);
        let torque_mnm = servo.step(&wanted, &measured);
        late_mnm.push_back(torque_mnm);
        rig.write_torque(late_mnm.pop_front().unwrap_or(torque_mnm))?;

        let error_rad = wanted.value - measured.angle_rad;
        let truth = rig.truth();
        following.peak_rad = following.peak_rad.max(error_rad.abs());
        following.speed_rad_s = following.speed_rad_s.max(truth.motor_velocity_rad_s.abs());
        following.sensor_mnm = following.sensor_mnm.max(truth.sensor_torque_mnm.abs());
        following.clipped += f64::from(torque_mnm.abs() > limits.motor_torque_mnm) / ticks as f64;
        following.limit_passed |= truth.motor_angle_rad.abs() > limits.angle_rad;
        squares += error_rad * error_rad;
        change_squares += (torque_mnm - previous_mnm) * (torque_mnm - previous_mnm);
        previous_mnm = torque_mnm;
    }
    following.rms_rad = (squares / ticks as f64).sqrt();
    following.command_change_mnm = (change_squares / ticks as f64).sqrt();
    following.limit_passed |= following.peak_rad > limits.following_error_rad
        || following.speed_rad_s > limits.speed_rad_s
        || following.sensor_mnm > limits.sensor_torque_mnm;
    Ok(following)
}
