//! A knob that sticks stands still.

use dynamics::Model;
use dynamics::knobs::{Fixture, paper_knob};
use hal::Apparatus as _;
use hal::simulated_rig::{Grip, Hand, Intention, RigParameters, SimulatedRig};
use rt_loop::admission::Admission;
use rt_loop::control::rendering::RenderGains;
use rt_loop::stability::gains_for;

use crate::held_knob::HeldKnob;

/// Step of the simulated encoder, rad.
const STEP_RAD: f64 = 9.8e-6;

/// Knob 5, whose inner body of 0.00095 mNm·s²/rad hangs behind a gap, as near as the simulated rig comes to it.
fn nearest_to_knob_5(rate_hz: f64) -> Model {
    let nothing = Fixture::None.model().unwrap();
    let rig = SimulatedRig::new(RigParameters::default(), nothing, 1).unwrap();
    let known = rig.description();
    let bounds = gains_for(&known.calibration, &known.limits, rate_hz, 0.0).unwrap().bounds;
    let admission = Admission::new(bounds, &known.calibration);
    admission.nearest(&paper_knob(5).unwrap()).unwrap().model
}

fn held_by(number: u32, torque_mnm: f64) -> HeldKnob {
    let hand = Hand { grip: Grip::default(), intention: Intention::Torque(torque_mnm), begins_s: 0.1 };
    let model = paper_knob(number).unwrap();
    HeldKnob::new(&model, RenderGains::at_rate(10_000.0), Some(hand), 10_000.0, u64::from(number))
}

#[test]
fn under_a_torque_inside_the_stick_band_the_knob_does_not_creep_for_ten_seconds() {
    for (number, torque_mnm) in [(1, 120.0), (2, -13.0), (3, 8.0), (4, -14.0)] {
        let mut knob = held_by(number, torque_mnm);
        let (mut least_rad, mut most_rad) = (f64::INFINITY, f64::NEG_INFINITY);
        while knob.time_s() < 10.5 {
            let rendered = knob.step();
            if knob.time_s() > 0.5 {
                assert!(rendered.stuck, "knob {number} slides at {:.3} s", knob.time_s());
                let angle_rad = knob.rig.truth().knob_angle_rad;
                (least_rad, most_rad) = (least_rad.min(angle_rad), most_rad.max(angle_rad));
            }
        }
        assert!(most_rad - least_rad < STEP_RAD, "knob {number} moved by {:.1e} rad", most_rad - least_rad);
    }
}

#[test]
fn behind_a_gap_too_a_torque_inside_the_stick_band_turns_nothing_for_ten_seconds() {
    for torque_mnm in [0.0, 60.0, -30.0] {
        let hand = Hand { grip: Grip::default(), intention: Intention::Torque(torque_mnm), begins_s: 0.1 };
        let gains = RenderGains::at_rate(10_000.0);
        let mut knob = HeldKnob::new(&nearest_to_knob_5(10_000.0), gains, Some(hand), 10_000.0, 5);
        let (mut least_rad, mut most_rad, mut inner_rad) = (f64::INFINITY, f64::NEG_INFINITY, f64::NAN);
        while knob.time_s() < 10.5 {
            let rendered = knob.step();
            if knob.time_s() > 1.0 {
                assert!(rendered.stuck, "{torque_mnm} mNm: it slides at {:.3} s", knob.time_s());
                assert!(inner_rad.is_nan() || inner_rad == rendered.inner_angle_rad, "what sticks stands still");
                inner_rad = rendered.inner_angle_rad;
                let angle_rad = knob.rig.truth().knob_angle_rad;
                (least_rad, most_rad) = (least_rad.min(angle_rad), most_rad.max(angle_rad));
            }
        }
        assert!(most_rad - least_rad < STEP_RAD, "{torque_mnm} mNm moved it by {:.1e} rad", most_rad - least_rad);
    }
}

#[test]
fn a_hand_pushes_the_cap_through_its_gap_to_the_contact() {
    let model = nearest_to_knob_5(10_000.0);
    let coupling = model.coupling().unwrap();
    for torque_mnm in [60.0, -30.0] {
        let hand = Hand { grip: Grip::default(), intention: Intention::Torque(torque_mnm), begins_s: 0.1 };
        let mut knob = HeldKnob::new(&model, RenderGains::at_rate(10_000.0), Some(hand), 10_000.0, 5);
        while knob.time_s() < 2.0 {
            knob.step();
        }
        let pressed_rad = coupling.half_gap_rad + torque_mnm.abs() / coupling.stiffness_mnm_rad;
        let angle_rad = knob.rig.truth().knob_angle_rad;
        // At rest the motor's own friction, 3 mNm either way, is borne by contact and virtual coupling.
        let gains = RenderGains::at_rate(10_000.0);
        let tolerance_rad = 3.0 / coupling.stiffness_mnm_rad + 3.0 / gains.stiffness_mnm_rad + 2.0 * STEP_RAD;
        assert!((angle_rad.abs() - pressed_rad).abs() < tolerance_rad, "{torque_mnm} mNm: {angle_rad} rad");
    }
}

#[test]
fn a_torque_beyond_the_stick_band_turns_it() {
    let mut knob = held_by(3, 16.0);
    while knob.time_s() < 2.0 {
        knob.step();
    }
    assert!(knob.rig.truth().knob_angle_rad > 0.1, "{}", knob.rig.truth().knob_angle_rad);
}
