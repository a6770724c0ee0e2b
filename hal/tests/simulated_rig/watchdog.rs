//! The amplifier's switch and watchdog, and readings that come late.

use dynamics::knobs;
use hal::simulated_rig::{RigParameters, SimulatedRig};
use hal::{Apparatus, ApparatusError};

use super::{flywheel, ideal_sensors};

const MILLISECOND_NS: u64 = 1_000_000;

fn rig() -> SimulatedRig {
    let parameters = RigParameters { watchdog_s: 0.025, catch_up_limit_s: 0.030, ..ideal_sensors() };
    SimulatedRig::new(parameters, flywheel(0.01), 1).unwrap()
}

#[test]
fn a_loop_that_stops_writing_loses_the_torque_after_the_watchdogs_time() {
    let mut rig = rig();
    rig.enable().unwrap();
    rig.read(0).unwrap();
    rig.write_torque(50.0).unwrap();
    rig.read(24 * MILLISECOND_NS).unwrap();
    assert!(rig.truth().current_a > 3.0);
    assert_eq!(rig.read(27 * MILLISECOND_NS), Err(ApparatusError::Watchdog));
    assert_eq!(rig.truth().current_a, 0.0);
    assert_eq!(rig.write_torque(50.0), Err(ApparatusError::Watchdog));
    rig.disable();
    assert_eq!(rig.read(28 * MILLISECOND_NS), Err(ApparatusError::Watchdog), "until it is enabled again");
    rig.enable().unwrap();
    rig.read(29 * MILLISECOND_NS).unwrap();
    rig.write_torque(50.0).unwrap();
    rig.read(30 * MILLISECOND_NS).unwrap();
    assert!(rig.truth().current_a > 3.0);
    assert_eq!(rig.watchdog_trips(), 1);
}

#[test]
fn a_stall_shorter_than_the_watchdog_is_made_up_for_in_full() {
    let mut rig = rig();
    rig.enable().unwrap();
    rig.read(0).unwrap();
    rig.write_torque(50.0).unwrap();
    rig.read(8 * MILLISECOND_NS).unwrap();
    assert!((rig.truth().time_s - 0.008).abs() < 1e-12);
    assert!(rig.truth().motor_velocity_rad_s > 10.0);
}

#[test]
fn a_long_stall_costs_a_bounded_catch_up_and_is_reported() {
    let mut rig = rig();
    rig.enable().unwrap();
    rig.read(5).unwrap();
    rig.write_torque(50.0).unwrap();
    assert_eq!(rig.read(5 + 3000 * MILLISECOND_NS), Err(ApparatusError::Watchdog));
    assert!((rig.truth().time_s - 0.030).abs() < 1e-12, "30 ms of plant time");
    assert_eq!(rig.skipped_time_ns(), 2970 * MILLISECOND_NS);
    rig.enable().unwrap();
    rig.read(5 + 3001 * MILLISECOND_NS).unwrap();
    assert!((rig.truth().time_s - 0.031).abs() < 1e-12, "and then time goes on as before");
}

#[test]
fn a_rig_that_waited_long_before_it_was_enabled_does_not_trip() {
    let mut rig = rig();
    rig.read(0).unwrap();
    rig.enable().unwrap();
    rig.read(60_000 * MILLISECOND_NS).unwrap();
    rig.write_torque(10.0).unwrap();
    rig.read(60_001 * MILLISECOND_NS).unwrap();
    assert_eq!(rig.watchdog_trips(), 0);
}

#[test]
fn a_disabled_rig_is_torque_free_whatever_is_written() {
    let mut rig = rig();
    rig.read(0).unwrap();
    rig.write_torque(300.0).unwrap();
    rig.read(30 * MILLISECOND_NS).unwrap();
    assert_eq!(rig.truth().motor_angle_rad, 0.0);
}

#[test]
fn a_torque_that_is_not_a_number_is_refused_and_becomes_zero() {
    let mut rig = rig();
    rig.enable().unwrap();
    rig.read(0).unwrap();
    assert_eq!(rig.write_torque(f64::NAN), Err(ApparatusError::Amplifier));
    rig.read(MILLISECOND_NS).unwrap();
    assert_eq!(rig.truth().current_a, 0.0);
}

#[test]
fn time_that_stands_still_or_falls_moves_nothing() {
    let mut rig = rig();
    rig.enable().unwrap();
    rig.read(MILLISECOND_NS).unwrap();
    rig.write_torque(50.0).unwrap();
    rig.read(2 * MILLISECOND_NS).unwrap();
    let truth = rig.truth();
    rig.read(2 * MILLISECOND_NS).unwrap();
    rig.read(MILLISECOND_NS / 2).unwrap();
    assert_eq!(rig.truth(), truth);
}

#[test]
fn numbers_that_are_no_rig_are_refused_with_their_name() {
    let parameters = RigParameters { gripper_inertia: -0.004, ..RigParameters::default() };
    let error = SimulatedRig::new(parameters, knobs::paper_knob(1).unwrap(), 1).unwrap_err();
    assert_eq!(
        error.to_string(),
        "the simulated rig's gripper_inertia is -0.004, but it must be more than zero, and finite"
    );
}
