//! From one model to another while the hand turns.

use dynamics::knobs::paper_knob;
use dynamics::{Drive, Excitation};
use hal::Apparatus as _;
use hal::simulated_rig::{Grip, Hand, Intention};
use rt_loop::control::rendering::{RenderGains, RenderedModel};

use crate::held_knob::HeldKnob;

/// Largest step of the command from tick to tick within a span of time, and its largest value, mNm.
fn steps_mnm(knob: &mut HeldKnob, until_s: f64) -> [f64; 2] {
    let mut largest = [0.0_f64; 2];
    while knob.time_s() < until_s {
        let before_mnm = knob.torque_mnm;
        knob.step();
        largest[0] = largest[0].max((knob.torque_mnm - before_mnm).abs());
        largest[1] = largest[1].max(knob.torque_mnm.abs());
    }
    largest
}

#[test]
fn models_that_change_under_motion_make_no_step_in_torque() {
    let motion = Excitation::named("linear-chirp", Drive::Position).unwrap().with_amplitude(0.5).unwrap();
    let hand = Hand { grip: Grip::default(), intention: Intention::Motion(motion), begins_s: 0.1 };
    let models = [3, 4, 2, 3].map(|number| paper_knob(number).unwrap());
    let rate_hz = 10_000.0;
    let mut knob = HeldKnob::new(&models[0], RenderGains::at_rate(rate_hz), Some(hand), rate_hz, 1);
    let calibration = knob.rig.description().calibration.clone();
    // Between swaps: what reversals, detents and the encoder's steps make of the command by themselves.
    let mut peak_mnm = 0.0_f64;
    let (mut ordinary_mnm, mut swapping_mnm) = (0.0_f64, 0.0_f64);
    for (index, model) in models.iter().enumerate().skip(1) {
        let begins_s = 1.3 * f64::from(u32::try_from(index).unwrap());
        let [step_mnm, largest_mnm] = steps_mnm(&mut knob, begins_s);
        (ordinary_mnm, peak_mnm) = (ordinary_mnm.max(step_mnm), peak_mnm.max(largest_mnm));
        knob.renderer.take(Box::new(RenderedModel::new(model, &calibration).unwrap())).unwrap();
        let [step_mnm, largest_mnm] = steps_mnm(&mut knob, begins_s + 0.01);
        (swapping_mnm, peak_mnm) = (swapping_mnm.max(step_mnm), peak_mnm.max(largest_mnm));
        let [_, largest_mnm] = steps_mnm(&mut knob, begins_s + 0.4);
        peak_mnm = peak_mnm.max(largest_mnm);
        assert!(knob.renderer.retired().is_some(), "the model before is given back");
    }
    // The command carries the encoder's steps times the coupling's damping; a swap adds nothing to that.
    let encoder_mnm = 2.0 * RenderGains::at_rate(rate_hz).damping * 9.8e-6 * rate_hz;
    assert!(
        swapping_mnm < encoder_mnm + 0.02 * peak_mnm,
        "{swapping_mnm:.2} mNm at a swap, {ordinary_mnm:.2} otherwise, peak {peak_mnm:.1}"
    );
}
