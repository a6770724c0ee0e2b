//! Sensors: noise, steps, offsets, gravity, delays.

use dynamics::{Effect, Model, effects, knobs};
use hal::Apparatus;
use hal::simulated_rig::{RigParameters, SimulatedRig};

use super::{Run, assert_close, clamped, flywheel, frictionless_motor};

/// Mean and standard deviation.
fn statistics(values: &[f64]) -> (f64, f64) {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / values.len() as f64;
    (mean, variance.sqrt())
}

#[track_caller]
fn assert_on_grid(values: &[f64], step: f64) {
    for value in values {
        assert_close((value / step).round() * step, *value, 1e-9, "the nearest step");
    }
}

#[test]
fn noise_and_steps_at_rest_are_those_of_the_paper_for_every_seed() {
    let parameters = RigParameters::default();
    for seed in 0..5 {
        let mut run = Run::seeded(parameters.clone(), knobs::paper_knob(1).unwrap(), 10_000, seed);
        let readings: Vec<_> = (0..40_000).map(|_| run.tick(0.0)).collect();
        let torque_mnm: Vec<f64> = readings.iter().map(|reading| reading.torque_mnm).collect();
        let acceleration_rad_s2: Vec<f64> = readings.iter().map(|reading| reading.acceleration_rad_s2).collect();
        assert_on_grid(&torque_mnm, 0.18);
        assert_on_grid(&acceleration_rad_s2, 2.8);

        // Rounding adds step²/12 to the noise's variance.
        let (mean, deviation) = statistics(&torque_mnm);
        assert_close(deviation, (0.25_f64.powi(2) + 0.18_f64.powi(2) / 12.0).sqrt(), 0.005, "torque noise");
        assert_close(mean, parameters.torque_zero_mnm, 0.006, "torque zero");
        let (mean, deviation) = statistics(&acceleration_rad_s2);
        assert_close(deviation, (1.5_f64.powi(2) + 2.8_f64.powi(2) / 12.0).sqrt(), 0.04, "acceleration noise");
        let gravity_rad_s2 = parameters.gravity_amplitude_rad_s2 * parameters.gravity_phase_rad.sin();
        assert_close(mean, parameters.acceleration_zero_rad_s2 + gravity_rad_s2, 0.06, "acceleration at rest");
    }
}

#[test]
fn the_encoder_reads_whole_steps_next_to_the_true_angle() {
    let mut run = Run::new(RigParameters::default(), knobs::paper_knob(3).unwrap(), 10_000);
    for _ in 0..2000 {
        let angle_rad = run.tick(30.0).angle_rad;
        assert_on_grid(&[angle_rad], 9.8e-6);
        assert_close(angle_rad, run.rig.truth().motor_angle_rad, 4.9e-6 + 1e-9, "the encoder");
    }
}

/// Turns the knob at about the given speed, without noise; gives (angle, acceleration reading, true acceleration).
fn turn(speed_rad_s: f64, angle_rad: f64) -> Vec<(f64, f64, f64)> {
    let parameters = RigParameters { noise_scale: 0.0, acceleration_step_rad_s2: 0.0, ..RigParameters::default() };
    let mut run = Run::new(parameters, flywheel(0.01), 10_000);
    let mut readings = Vec::new();
    while run.rig.truth().knob_angle_rad < angle_rad + 1.0 {
        let truth = run.rig.truth();
        let reading = run.tick(10.0 * (speed_rad_s - truth.motor_velocity_rad_s) + 3.0);
        if truth.knob_angle_rad > 1.0 {
            let truth = run.rig.truth();
            readings.push((truth.knob_angle_rad, reading.acceleration_rad_s2, truth.knob_acceleration_rad_s2));
        }
    }
    readings
}

/// Amplitude and phase of a sine of the angle through readings over whole turns: their first Fourier coefficient.
fn sine_of_angle(readings: &[(f64, f64, f64)], offset: f64) -> (f64, f64) {
    let (mut sine, mut cosine, mut weight) = (0.0, 0.0, 0.0);
    for pair in readings.windows(2) {
        let step_rad = pair[1].0 - pair[0].0;
        let value = pair[0].1 - pair[0].2 - offset;
        sine += step_rad * value * pair[0].0.sin();
        cosine += step_rad * value * pair[0].0.cos();
        weight += step_rad / 2.0;
    }
    ((sine / weight).hypot(cosine / weight), cosine.atan2(sine))
}

#[test]
fn gravity_is_a_sine_of_the_angle_over_a_turn_and_lags_by_the_stated_delay() {
    let parameters = RigParameters::default();
    let slow = turn(1.0, std::f64::consts::TAU);
    let (amplitude, phase) = sine_of_angle(&slow, parameters.acceleration_zero_rad_s2);
    assert_close(amplitude, parameters.gravity_amplitude_rad_s2, 1.0, "gravity's amplitude in rad/s²");
    assert_close(phase, parameters.gravity_phase_rad, 0.002, "gravity's phase in rad");

    let fast = turn(40.0, std::f64::consts::TAU * 4.0);
    let (_, phase) = sine_of_angle(&fast, parameters.acceleration_zero_rad_s2);
    let rig = Run::new(parameters.clone(), flywheel(0.01), 10_000).rig;
    let lag_s = (parameters.gravity_phase_rad - phase) / 40.0;
    println!("accelerometer lag {:.1} µs", lag_s * 1e6);
    assert_close(lag_s, rig.description().calibration.acceleration_delay_s, 4e-6, "the accelerometer's delay in s");
}

#[test]
fn the_torque_channel_lags_by_the_stated_delay() {
    let mut run = Run::new(frictionless_motor(), clamped(), 10_000);
    let slope_mnm_s = 1000.0;
    let mut lags_s = Vec::new();
    for _ in 0..2000 {
        let reading_mnm = run.tick(slope_mnm_s * run.time_s()).torque_mnm;
        // The truth is a mean over the substep before the reading; its middle is 5 µs back.
        let now_mnm = run.rig.truth().sensor_torque_mnm + 5e-6 * slope_mnm_s;
        lags_s.push((now_mnm - reading_mnm) / slope_mnm_s);
    }
    let (lag_s, _) = statistics(&lags_s[1000..]);
    println!("torque lag {:.2} µs", lag_s * 1e6);
    assert_close(lag_s, run.rig.description().calibration.torque_delay_s, 1e-6, "the torque channel's delay in s");
}

#[test]
fn torque_is_what_gripper_and_knob_take() {
    let knob: Model = flywheel(0.05);
    let parameters = frictionless_motor();
    let (motor, load) = (parameters.motor_inertia(), parameters.gripper_inertia + 0.05);
    let mut run = Run::new(parameters, knob, 10_000);
    let readings: Vec<f64> = (0..2000).map(|_| run.tick(60.0).torque_mnm).collect();
    let (mean, _) = statistics(&readings[1000..]);
    assert_close(mean, 60.0 * load / (motor + load), 0.4, "the measured torque in mNm");
}

#[test]
fn a_calibration_error_shows_in_the_description_and_not_in_the_rig() {
    let honest = RigParameters::default();
    let flawed = RigParameters { calibration_error: 0.01, ..honest.clone() };
    let mut true_run = Run::new(honest, flywheel(0.01), 10_000);
    let mut flawed_run = Run::new(flawed, flywheel(0.01), 10_000);
    let (exact, stated) =
        (true_run.rig.description().calibration.clone(), flawed_run.rig.description().calibration.clone());
    let error = stated.gripper_inertia / exact.gripper_inertia - 1.0;
    assert!(error != 0.0 && error.abs() < 0.05, "the gripper's stated inertia is off by {error}");
    for _ in 0..1000 {
        assert_eq!(true_run.tick(20.0), flawed_run.tick(20.0));
    }
}

/// A knob with one artefact of the torque channel, driven like any other; gives a torque reading every substep of 10 µs.
fn torque_readings(artefact: Option<Effect>) -> Vec<f64> {
    let mut knob = knobs::paper_knob(2).unwrap();
    knob.effects.extend(artefact);
    let parameters = RigParameters { noise_scale: 0.0, torque_step_mnm: 0.0, ..RigParameters::default() };
    let mut run = Run::new(parameters, knob, 100_000);
    (0..30_000).map(|tick| run.tick(60.0 * (f64::from(tick) * 5e-4).sin()).torque_mnm).collect()
}

#[test]
fn a_late_reading_is_the_one_of_that_time_ago() {
    let plain = torque_readings(None);
    // Whole substeps, and half of one: between substeps on a straight line.
    for (delay_s, earlier, later) in [(3e-4, 30, 30), (1.25e-4, 13, 12)] {
        let late = torque_readings(Some(Effect::new(&effects::sensor_delay::KIND, &[delay_s])));
        for tick in earlier..plain.len() {
            let expected_mnm = 0.5 * (plain[tick - earlier] + plain[tick - later]);
            assert_close(late[tick], expected_mnm, 1e-9, "the late reading in mNm");
        }
    }
}

#[test]
fn offset_and_hum_come_on_top_of_the_torque() {
    let plain = torque_readings(None);
    let offset = torque_readings(Some(Effect::new(&effects::torque_offset::KIND, &[-2.5])));
    let hum = torque_readings(Some(Effect::new(&effects::mains_hum::KIND, &[1.5, 50.0, 0.3])));
    for tick in 0..plain.len() {
        assert_close(offset[tick] - plain[tick], -2.5, 1e-9, "the offset in mNm");
        let phase = std::f64::consts::TAU * 50.0 * tick as f64 * 1e-5 + 0.3;
        assert_close(hum[tick] - plain[tick], 1.5 * phase.sin(), 1e-9, "the hum in mNm");
    }
}

#[test]
fn a_reading_before_its_torque_is_refused() {
    let mut knob = knobs::paper_knob(2).unwrap();
    knob.effects.push(Effect::new(&effects::sensor_delay::KIND, &[-1e-4]));
    let error = SimulatedRig::new(RigParameters::default(), knob, 1).unwrap_err().to_string();
    assert!(error.contains("sensor_delay is -0.0001"), "{error}");
}
