//! What the simulated rig says of itself.

use dynamics::{Calibration, Model};

use super::RigParameters;
use super::cogging::Cogging;
use super::noise::Noise;
use super::sensors::{first_order_delay_s, second_order_delay_s};
use crate::{DeclaredCalls, Limits, RigDescription, TorqueSource};

/// Keeps the calibration's errors apart from the sensors' noise.
const CALIBRATION_STREAM: u64 = 0xca11_b4a7_1015_0000;

/// Slowest sample rate that it is run at, Hz; it has none of its own.
const SLOWEST_HZ: f64 = 500.0;

pub(super) fn describe(parameters: &RigParameters, knob: &Model, seed: u64) -> RigDescription {
    RigDescription {
        name: "simulated rig".to_owned(),
        limits: Limits {
            motor_torque_mnm: parameters.motor_torque_limit_mnm(),
            sensor_torque_mnm: parameters.sensor_torque_limit_mnm,
            speed_rad_s: parameters.speed_limit_rad_s,
            angle_rad: parameters.angle_limit_rad,
            following_error_rad: parameters.following_error_limit_rad,
            rate_hz: parameters.rate_limit_hz,
        },
        slowest_rate_hz: SLOWEST_HZ,
        calibration: Calibration { axis: knob.axis, ..calibration(parameters, seed) },
        torque: TorqueSource::Sensor,
        has_contact: parameters.switch.is_some(),
        torque_late_ticks: 0.0,
        angle_delay_s: 0.0,
        stale_limit: 0,
        watchdog_s: Some(parameters.watchdog_s),
        device: None,
        calls: DeclaredCalls::default(),
        codes: Vec::new(),
        notes: vec![
            ("seed".to_owned(), seed.to_string()),
            ("mounted knob".to_owned(), knob.name.clone()),
            ("noise scale".to_owned(), parameters.noise_scale.to_string()),
            ("plant substep".to_owned(), format!("{} ns", parameters.substep_ns)),
            ("motor cogging".to_owned(), cogging_in_words(&parameters.motor_cogging)),
        ],
    }
}

fn cogging_in_words(harmonics: &[Cogging]) -> String {
    if harmonics.is_empty() {
        return "none".to_owned();
    }
    let words = harmonics.iter().map(|Cogging { per_turn, torque_mnm, phase_rad }| {
        format!("{torque_mnm} mNm {per_turn} times a turn, phase {phase_rad} rad")
    });
    words.collect::<Vec<_>>().join("; ")
}

fn calibration(parameters: &RigParameters, seed: u64) -> Calibration {
    let mut error = Noise::new(seed ^ CALIBRATION_STREAM, parameters.calibration_error);
    let mut measured = |truth: f64| truth + error.sample(truth.abs());
    Calibration {
        axis: dynamics::Axis::Rotary,
        gripper_inertia: measured(parameters.gripper_inertia),
        motor_inertia: measured(parameters.motor_inertia()),
        torque_sensor_stiffness_mnm_rad: measured(parameters.torque_sensor_stiffness_mnm_rad),
        torque_zero_mnm: measured(parameters.torque_zero_mnm),
        torque_delay_s: measured(second_order_delay_s(parameters.torque_bandwidth_hz)),
        acceleration_zero_rad_s2: measured(parameters.acceleration_zero_rad_s2),
        acceleration_delay_s: measured(first_order_delay_s(parameters.acceleration_bandwidth_hz)),
        gravity_amplitude_rad_s2: measured(parameters.gravity_amplitude_rad_s2),
        gravity_phase_rad: measured(parameters.gravity_phase_rad),
        angle_step_rad: parameters.angle_step_rad,
        torque_step_mnm: parameters.torque_step_mnm,
        acceleration_step_rad_s2: parameters.acceleration_step_rad_s2,
        motor_coulomb_mnm: Some(measured(parameters.motor_coulomb_mnm)),
        motor_viscous: Some(measured(parameters.motor_viscous)),
        command_delay_s: Some(measured(first_order_delay_s(parameters.current_bandwidth_hz))),
        // No rig comes with it: `calibrate cogging` tells.
        motor_cogging: None,
    }
}
