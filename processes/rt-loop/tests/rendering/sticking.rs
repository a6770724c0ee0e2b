//! A knob that sticks stands still.

use dynamics::knobs::paper_knob;
use hal::simulated::{Grip, Hand, Intention};
use rt_loop::control::rendering::RenderGains;

use crate::held_knob::HeldKnob;

/// Step of the simulated encoder, rad.
const STEP_RAD: f64 = 9.8e-6;

fn held_by(number: u32, torque_mnm: f64) -> HeldKnob {
    let hand = Hand { grip: Grip::default(), intention: Intention::Torque(torque_mnm), begins_s: 0.1 };
    let model = paper_knob(number).unwrap();
    HeldKnob::new(&model, RenderGains::at_rate(10_000.0).unwrap(), Some(hand), 10_000.0, u64::from(number))
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
fn a_torque_beyond_the_stick_band_turns_it() {
    let mut knob = held_by(3, 16.0);
    while knob.time_s() < 2.0 {
        knob.step();
    }
    assert!(knob.rig.truth().knob_angle_rad > 0.1, "{}", knob.rig.truth().knob_angle_rad);
}
