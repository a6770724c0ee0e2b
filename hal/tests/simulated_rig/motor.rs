//! Winding and amplifier against closed forms and the catalogue.

use std::f64::consts::TAU;

use hal::simulated_rig::RigParameters;

use super::{Run, assert_close, clamped, flywheel, frictionless_motor, ideal_sensors};

#[test]
fn current_follows_a_step_as_the_loop_bandwidth_says() {
    let parameters = frictionless_motor();
    let rate = TAU * parameters.current_bandwidth_hz;
    let mut run = Run::new(parameters, clamped(), 100_000);
    run.tick(82.0); // 5 A
    for step in 1..50 {
        run.tick(82.0);
        let time_s = f64::from(step) * 1e-5;
        let expected_a = 5.0 * (1.0 - (-rate * time_s).exp());
        assert_close(run.rig.truth().current_a, expected_a, 0.02, "the current in A");
    }
}

#[test]
fn a_free_motor_gains_the_momentum_that_its_torque_gives() {
    // With a back-EMF that rises at e V/s the PI loop falls behind by e / (R·2π·bandwidth): to the
    // shaft that looks like additional inertia.
    let parameters = frictionless_motor();
    let loop_rate = TAU * parameters.current_bandwidth_hz;
    let constant = parameters.torque_constant_mnm_a;
    let apparent_inertia = 1e-3 * constant * constant / (parameters.terminal_resistance_ohm * loop_rate);
    let (motor, load) = (parameters.motor_inertia(), parameters.gripper_inertia + 0.01);
    let mut run = Run::new(parameters, flywheel(0.01), 10_000);
    let torque_mnm = 50.0;
    run.ticks(201, torque_mnm);
    let truth = run.rig.truth();
    let momentum = motor * truth.motor_velocity_rad_s + load * truth.knob_velocity_rad_s;
    let expected = torque_mnm * (truth.time_s - 1.0 / loop_rate) * (motor + load) / (motor + load + apparent_inertia);
    assert_close(momentum / expected, 1.0, 1e-3, "the momentum over the one expected");
}

#[test]
fn the_free_motor_reaches_the_catalogues_no_load_speed_and_current() {
    // Catalogue: 6920 rpm and 0.241 A at 12 V; the coupling and gripper change only how long it takes.
    let parameters = ideal_sensors();
    let limit_mnm = parameters.motor_torque_limit_mnm();
    let mut run = Run::new(parameters, flywheel(0.0), 10_000);
    run.ticks(20_000, limit_mnm);
    let truth = run.rig.truth();
    let speed_rpm = truth.motor_velocity_rad_s * 60.0 / TAU;
    assert_close(speed_rpm, 6920.0, 0.01 * 6920.0, "the no-load speed in rpm");
    assert_close(truth.current_a, 0.241, 0.02 * 0.241, "the no-load current in A");
}

#[test]
fn torque_beyond_the_amplifiers_current_is_not_given() {
    let parameters = RigParameters::default();
    let limit_a = parameters.peak_current_a;
    let mut run = Run::new(parameters, clamped(), 10_000);
    // The shaft winds up and rings a little: its back-EMF moves the current by some hundredths.
    run.ticks(500, 1e4);
    assert_close(run.rig.truth().current_a, limit_a, 0.05, "the current in A");
    run.ticks(500, -1e4);
    assert_close(run.rig.truth().current_a, -limit_a, 0.05, "the current in A");
}
