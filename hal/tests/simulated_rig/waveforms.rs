//! Detents of every waveform on the rig: a steady torque comes to rest where the waveform balances it.

use std::f64::consts::PI;

use dynamics::{Effect, Model, TorqueTable, effects};

use crate::{Run, assert_close, flywheel, frictionless_motor};

/// Viscous friction that lets the knob settle without swinging far, mNm·s/rad.
const DRAG: f64 = 10.0;

/// Angle at which the knob rests on a waveform under a steady torque, rad.
fn resting_rad(waveform: Effect, torque_mnm: f64) -> f64 {
    let drag = Effect::new(&effects::friction::KIND, &[0.0, 0.0, DRAG, DRAG]);
    let wheel = flywheel(0.035);
    let knob = Model { effects: [&wheel.effects[..], &[drag, waveform]].concat(), ..wheel };
    let mut run = Run::new(frictionless_motor(), knob, 10_000);
    run.ticks(10_000, torque_mnm);
    let truth = run.rig.truth();
    assert_close(truth.knob_velocity_rad_s, 0.0, 1e-6, "the velocity");
    truth.knob_angle_rad
}

#[test]
fn a_steady_torque_rests_where_the_waveform_balances_it() {
    let (amplitude, period) = (60.0, 0.1);
    for torque_mnm in [-30.0, -10.0, 20.0, 35.0] {
        let of_quarter = torque_mnm / amplitude;
        let triangle = Effect::new(&effects::detent_triangle::KIND, &[amplitude, period, 0.0]);
        assert_close(resting_rad(triangle, torque_mnm), of_quarter * 0.5 * PI * period, 1e-5, "on a triangle");

        let sawtooth = Effect::new(&effects::detent_sawtooth::KIND, &[amplitude, period, 0.0, 0.8]);
        assert_close(resting_rad(sawtooth, torque_mnm), of_quarter * 0.8 * PI * period, 1e-5, "on a sawtooth");
    }
    let ramp = Effect::new(&effects::torque_ramp::KIND, &[amplitude, 0.4, 0.2]);
    assert_close(resting_rad(ramp, 15.0), 0.45, 1e-5, "on a ramp");
}

#[test]
fn a_torque_that_was_drawn_rests_at_the_point_that_has_it() {
    let (angle_rad, torque_mnm) = ([-0.1, -0.04, 0.0, 0.02, 0.1, 0.15], [-60.0, -25.0, 0.0, 15.0, 50.0, 70.0]);
    let table = TorqueTable::kept(&angle_rad, &torque_mnm, Some(0.6)).unwrap();
    for point in 1..5 {
        let drawn = Effect::new(&effects::torque_table::KIND, &[0.5]).with_table(table);
        let resting = resting_rad(drawn, 0.5 * torque_mnm[point]);
        assert_close(resting, angle_rad[point], 1e-5, "the angle");
    }
}
