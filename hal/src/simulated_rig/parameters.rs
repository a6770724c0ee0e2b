//! What the simulated rig is made of.

use serde::{Deserialize, Serialize};

use super::Switch;
use super::cogging::{self, Cogging};

/// Every number of the simulated rig; units mNm, rad, s unless the name says otherwise.
///
/// The default is the rig of Swindells and MacLean 2007: their section 2 and Table 1, and the
/// catalogue of its motor. A rig file's `[settings]` may have any of them by its name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RigParameters {
    /// Resistance between the motor's terminals, ohm.
    pub terminal_resistance_ohm: f64,
    /// Inductance between the motor's terminals, H.
    pub terminal_inductance_h: f64,
    /// Torque per current, mNm/A; in V·s/rad a thousandth of it is the back-EMF constant.
    pub torque_constant_mnm_a: f64,
    /// Moment of inertia of the rotor, mNm·s²/rad.
    pub rotor_inertia: f64,
    /// Moment of inertia of coupling and encoder disc on the motor's side, mNm·s²/rad.
    pub coupling_inertia: f64,
    /// Coulomb friction of brushes and bearings, also what they hold at rest, mNm.
    pub motor_coulomb_mnm: f64,
    /// Viscous friction of the motor, mNm·s/rad.
    pub motor_viscous: f64,
    /// Cogging of the motor, by harmonics of its angle.
    pub motor_cogging: Vec<Cogging>,

    /// Voltage that the amplifier can put on the winding, either way, V.
    pub supply_v: f64,
    /// Largest current that the amplifier drives, A.
    pub peak_current_a: f64,
    /// Bandwidth of the amplifier's current loop, Hz.
    pub current_bandwidth_hz: f64,
    /// Time without a command after which the amplifier removes the torque, s.
    pub watchdog_s: f64,

    /// Stiffness of the torque sensor, mNm/rad.
    pub torque_sensor_stiffness_mnm_rad: f64,
    /// Damping of the torque sensor, mNm·s/rad.
    pub torque_sensor_damping: f64,
    /// Moment of inertia of the gripper, mNm·s²/rad.
    pub gripper_inertia: f64,

    /// Step of the encoder, rad; zero for none, here and in the other steps.
    pub angle_step_rad: f64,
    /// Bandwidth of the accelerometer, first order, Hz.
    pub acceleration_bandwidth_hz: f64,
    /// White noise of one acceleration reading, RMS, rad/s².
    pub acceleration_noise_rms_rad_s2: f64,
    /// Step of the acceleration channel, rad/s².
    pub acceleration_step_rad_s2: f64,
    /// Accelerometer's reading at rest, gravity apart, rad/s².
    pub acceleration_zero_rad_s2: f64,
    /// Gravity in the acceleration signal is amplitude · sin(angle + phase); its amplitude, rad/s².
    pub gravity_amplitude_rad_s2: f64,
    /// Phase of gravity in the acceleration signal, rad.
    pub gravity_phase_rad: f64,
    /// Largest bandwidth of the torque channel's anti-aliasing filter, second-order Butterworth, Hz.
    pub torque_bandwidth_hz: f64,
    /// White noise of one torque reading, RMS, mNm.
    pub torque_noise_rms_mnm: f64,
    /// Step of the torque channel, mNm.
    pub torque_step_mnm: f64,
    /// Torque sensor's reading with nothing attached, mNm.
    pub torque_zero_mnm: f64,
    /// The switch in the control, if the rig watches one.
    pub switch: Option<Switch>,
    /// Factor on all sensor noise; zero for a rig without noise.
    pub noise_scale: f64,
    /// Relative error, RMS, of each calibrated value as the rig's description states it.
    pub calibration_error: f64,

    /// Largest torque that the sensor may carry, mNm.
    pub sensor_torque_limit_mnm: f64,
    /// Largest speed, rad/s.
    pub speed_limit_rad_s: f64,
    /// Largest angle away from the start, rad.
    pub angle_limit_rad: f64,
    /// Largest distance from the commanded angle, rad.
    pub following_error_limit_rad: f64,
    /// Fastest sample rate, Hz.
    pub rate_limit_hz: f64,

    /// Step in which the plant is integrated, ns.
    pub substep_ns: u64,
    /// Longest stretch that one reading makes up for, s; what goes beyond is left out of the plant's time.
    pub catch_up_limit_s: f64,
}

impl Default for RigParameters {
    /// - Motor: maxon RE 40, Ø40 mm, graphite brushes, 150 W, 12 V winding, order number 148866
    ///   (maxon catalogue): 0.117 Ω, 0.0245 mH, 16.4 mNm/A, 139 g·cm². Its friction is the no-load
    ///   current of 0.241 A at 6920 rpm, 3.95 mNm in all; how this divides into a constant part and
    ///   one that grows with speed is an assumption. Its rotor is a winding without iron, which no magnet pulls: it has no
    ///   cogging. A slotted brushless motor in its place would have 1 to 2 % of its rated torque, some mNm.
    /// - Amplifier: a PWM amplifier like the paper's Copley 2122 on ±12 V, with the bandwidth of 3 kHz of
    ///   that maker's later 4122 (its data sheet). Its peak current, 22 A, is what breaks knob 5 loose
    ///   even where its detents add to its stick, 200 + 136 mNm, as the paper says its rig does: with
    ///   20 A, 60 of 80 sweeps of 0.5 to 1.45 rad got stuck there, with 22 A none (example `follow_sweep`).
    /// - Watchdog: 100 ms. Stalls of up to 77 ms were seen on a virtual host that was busy compiling on
    ///   all cores; such a stall is to cost ticks and not the run. A rig on hardware of its own, which
    ///   does not stall, would have a shorter one.
    /// - Steps: Table 1. Gravity: 9.81 m/s² over a radius of 20 mm.
    /// - Noise, bandwidths, zero offsets, stiffness, damping and gripper: assumed, of the size that
    ///   the paper's sensors (ADXL 202, Sensotec QWFK-8M) and its ABS encasements have.
    fn default() -> Self {
        Self {
            terminal_resistance_ohm: 0.117,
            terminal_inductance_h: 24.5e-6,
            torque_constant_mnm_a: 16.4,
            rotor_inertia: 0.0139,
            coupling_inertia: 0.002,
            motor_coulomb_mnm: 3.0,
            motor_viscous: 1.31e-3,
            motor_cogging: Vec::new(),

            supply_v: 12.0,
            peak_current_a: 22.0,
            current_bandwidth_hz: 3000.0,
            watchdog_s: 0.100,

            torque_sensor_stiffness_mnm_rad: 5e5,
            torque_sensor_damping: 2.0,
            gripper_inertia: 0.004,

            angle_step_rad: 9.8e-6,
            acceleration_bandwidth_hz: 500.0,
            acceleration_noise_rms_rad_s2: 1.5,
            acceleration_step_rad_s2: 2.8,
            acceleration_zero_rad_s2: 6.3,
            gravity_amplitude_rad_s2: 490.5,
            gravity_phase_rad: 0.7,
            torque_bandwidth_hz: 2000.0,
            torque_noise_rms_mnm: 0.25,
            torque_step_mnm: 0.18,
            torque_zero_mnm: 0.6,
            switch: None,
            noise_scale: 1.0,
            calibration_error: 0.0,

            sensor_torque_limit_mnm: 1000.0,
            speed_limit_rad_s: 60.0,
            angle_limit_rad: 60.0,
            following_error_limit_rad: 0.5,
            rate_limit_hz: 20_000.0,

            substep_ns: 10_000,
            catch_up_limit_s: 0.120,
        }
    }
}

/// A rig that cannot be built from the numbers given.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("the simulated rig's {parameter} is {value}, but it must be {requirement}")]
pub struct ParameterError {
    /// The parameter's field.
    pub parameter: &'static str,
    /// The value found.
    pub value: f64,
    /// What it must be.
    pub requirement: &'static str,
}

/// Longest substep, ns: ten to a period of the stiffest rig that is still sensible, 10 kHz.
const MAX_SUBSTEP_NS: u64 = 20_000;

/// Largest bandwidth of the torque channel's anti-aliasing filter as a share of the sample rate.
const BANDWIDTH_PER_RATE: f64 = 0.4;

impl RigParameters {
    /// The rig with its anti-aliasing filter set for a sample rate.
    ///
    /// The motor's torque is held between samples, and its steps make rotor and gripper ring on the torque sensor, at 1.06 kHz
    /// by default. Sampled at 1 kHz without such a filter, the ringing is indistinguishable from a torque of 60 Hz.
    #[must_use]
    pub fn at_rate(self, rate_hz: f64) -> Self {
        Self { torque_bandwidth_hz: self.torque_bandwidth_hz.min(BANDWIDTH_PER_RATE * rate_hz), ..self }
    }

    /// Moment of inertia on the motor's side of the torque sensor, mNm·s²/rad.
    #[must_use]
    pub fn motor_inertia(&self) -> f64 {
        self.rotor_inertia + self.coupling_inertia
    }

    /// Largest torque of the motor: torque constant times peak current, mNm.
    #[must_use]
    pub fn motor_torque_limit_mnm(&self) -> f64 {
        self.torque_constant_mnm_a * self.peak_current_a
    }

    /// The substep, s.
    #[must_use]
    pub(super) fn substep_s(&self) -> f64 {
        self.substep_ns as f64 * 1e-9
    }

    /// Checks that the numbers describe a rig.
    ///
    /// # Errors
    /// [`ParameterError`] for the first number that does not.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let above_zero = [
            ("terminal_resistance_ohm", self.terminal_resistance_ohm),
            ("terminal_inductance_h", self.terminal_inductance_h),
            ("torque_constant_mnm_a", self.torque_constant_mnm_a),
            ("rotor_inertia", self.rotor_inertia),
            ("supply_v", self.supply_v),
            ("peak_current_a", self.peak_current_a),
            ("current_bandwidth_hz", self.current_bandwidth_hz),
            ("watchdog_s", self.watchdog_s),
            ("torque_sensor_stiffness_mnm_rad", self.torque_sensor_stiffness_mnm_rad),
            ("gripper_inertia", self.gripper_inertia),
            ("acceleration_bandwidth_hz", self.acceleration_bandwidth_hz),
            ("torque_bandwidth_hz", self.torque_bandwidth_hz),
            ("sensor_torque_limit_mnm", self.sensor_torque_limit_mnm),
            ("speed_limit_rad_s", self.speed_limit_rad_s),
            ("angle_limit_rad", self.angle_limit_rad),
            ("following_error_limit_rad", self.following_error_limit_rad),
            ("rate_limit_hz", self.rate_limit_hz),
            ("catch_up_limit_s", self.catch_up_limit_s),
        ];
        let zero_or_more = [
            ("coupling_inertia", self.coupling_inertia),
            ("motor_coulomb_mnm", self.motor_coulomb_mnm),
            ("motor_viscous", self.motor_viscous),
            ("torque_sensor_damping", self.torque_sensor_damping),
            ("angle_step_rad", self.angle_step_rad),
            ("acceleration_noise_rms_rad_s2", self.acceleration_noise_rms_rad_s2),
            ("acceleration_step_rad_s2", self.acceleration_step_rad_s2),
            ("gravity_amplitude_rad_s2", self.gravity_amplitude_rad_s2),
            ("torque_noise_rms_mnm", self.torque_noise_rms_mnm),
            ("torque_step_mnm", self.torque_step_mnm),
            ("noise_scale", self.noise_scale),
            ("calibration_error", self.calibration_error),
        ];
        let finite = [
            ("acceleration_zero_rad_s2", self.acceleration_zero_rad_s2),
            ("gravity_phase_rad", self.gravity_phase_rad),
            ("torque_zero_mnm", self.torque_zero_mnm),
        ];
        let check = |(parameter, value): (&'static str, f64), permitted: bool, requirement| {
            if value.is_finite() && permitted { Ok(()) } else { Err(ParameterError { parameter, value, requirement }) }
        };
        for entry in above_zero {
            check(entry, entry.1 > 0.0, "more than zero, and finite")?;
        }
        for entry in zero_or_more {
            check(entry, entry.1 >= 0.0, "zero or more, and finite")?;
        }
        for entry in finite {
            check(entry, true, "finite")?;
        }
        cogging::validate(&self.motor_cogging)?;
        self.switch.as_ref().map_or(Ok(()), Switch::validate)?;
        let substep = ("substep_ns", self.substep_s() * 1e9);
        check(substep, (1..=MAX_SUBSTEP_NS).contains(&self.substep_ns), "from 1 to 20000")
    }
}
