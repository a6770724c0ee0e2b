//! How firmly a model is held to the rotor at each rate.

use dynamics::knobs::Fixture;
use dynamics::{Effect, Model, effects};
use hal::Apparatus as _;
use hal::simulated_rig::{Grip, Hand, Intention, RigParameters, SimulatedRig};
use rt_loop::control::rendering::RenderGains;
use rt_loop::stability::{Firmness, gains_for};

use crate::held_knob::HeldKnob;
use crate::passivity::firmness;

/// Rates that are tried, Hz: those between them too.
fn rates_hz() -> impl Iterator<Item = f64> {
    std::iter::successors(Some(500.0), |rate_hz| Some(1.1 * rate_hz)).take_while(|rate_hz| *rate_hz <= 20_000.0)
}

#[test]
fn the_simulated_rig_renders_as_usual_where_the_delay_is_short_and_nothing_where_it_would_be_far_too_soft() {
    for rate_hz in rates_hz() {
        match firmness(rate_hz) {
            Some(Firmness { share, .. }) => {
                assert!(share == 1.0 || (1_900.0..5_000.0).contains(&rate_hz), "{share} at {rate_hz} Hz");
            }
            None => assert!((2_200.0..2_600.0).contains(&rate_hz), "nothing at {rate_hz} Hz"),
        }
    }
}

#[test]
fn a_rig_that_cannot_hold_even_the_softest_gains_renders_nothing() {
    let rig = SimulatedRig::new(RigParameters::default(), Fixture::None.model().unwrap(), 1).unwrap();
    let known = rig.description();
    assert!(gains_for(&known.calibration, &known.limits, 500.0, 0.1).is_none());
}

/// RMS of what the gripper does a second after it was kicked while the model sticks, on a motor without friction, rad/s.
fn swing_rad_s(inertia: f64, gains: RenderGains, rate_hz: f64) -> f64 {
    let stuck = Model {
        effects: vec![
            Effect::new(&effects::inertia::KIND, &[0.05]),
            Effect::new(&effects::friction::KIND, &[20.0, 20.0, 0.1, 0.1]),
            Effect::new(&effects::karnopp_stick::KIND, &[30.0, 30.0, 0.02]),
        ],
        ..Model::default()
    };
    let hand = Hand {
        grip: Grip { inertia, damping: 0.0, stiffness_mnm_rad: 0.0 },
        intention: Intention::Recorded { angle_rad: vec![0.0, 0.0], rate_hz: 1_000.0 },
        begins_s: 0.05,
    };
    let parameters = RigParameters { motor_coulomb_mnm: 0.0, ..RigParameters::default() };
    let mut knob = HeldKnob::on(parameters, &[], &stuck, gains, Some(hand), rate_hz, 7);
    let (mut squares, mut ticks) = (0.0, 0.0);
    while knob.time_s() < 1.3 {
        knob.rig.set_hand_torque(if (0.1..0.105).contains(&knob.time_s()) { 150.0 } else { 0.0 });
        knob.step();
        if knob.time_s() > 1.1 {
            squares += knob.rig.truth().knob_velocity_rad_s.powi(2);
            ticks += 1.0;
        }
    }
    f64::sqrt(squares / ticks)
}

#[test]
fn at_no_rate_does_a_heavy_hand_make_rotor_and_gripper_swing() {
    for rate_hz in rates_hz().filter(|rate_hz| (1_500.0..6_000.0).contains(rate_hz)) {
        let Some(Firmness { gains, .. }) = firmness(rate_hz) else { continue };
        for inertia in [0.0, 0.005, 0.01, 0.02] {
            let swing_rad_s = swing_rad_s(inertia, gains, rate_hz);
            assert!(swing_rad_s < 0.1, "{swing_rad_s} rad/s at {rate_hz} Hz with a hand of {inertia} mNm·s²/rad");
        }
    }
}
