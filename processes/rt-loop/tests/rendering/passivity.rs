//! Inside the bounds nothing swings up and no energy comes out; outside, it can.

use hal::Apparatus as _;
use hal::simulated_rig::{Cogging, Grip, Hand, Intention, RigParameters, SimulatedRig};
use rt_loop::control::rendering::RenderGains;
use rt_loop::stability::{Bounds, Firmness, gains_for};

use crate::held_knob::{HeldKnob, held_by_contact, held_by_springs};
use crate::numbers::Numbers;
use crate::random_knob::{random_hand, random_knob, random_two_bodies};

/// How a knob behaved in a hand that moves about for a second and then keeps still.
#[derive(Debug)]
pub struct Behaviour {
    /// Minimum over time of the hand's work less the energy held by springs, mNm·rad; negative if energy came out.
    pub least_energy: f64,
    /// Energy of knob, springs and grip soon after the hand kept still, and at the end, mNm·rad.
    pub swings: [f64; 2],
    /// Ticks in which the guard took energy back.
    pub guarded: u32,
}

/// Time for which the hand moves, s, and the whole run's.
pub const MOVES_S: f64 = 1.0;
pub const LASTS_S: f64 = 2.5;

pub fn behaviour(model: &dynamics::Model, gains: RenderGains, hand: Hand, rate_hz: f64, seed: u64) -> Behaviour {
    behaviour_on(&[], model, gains, hand, rate_hz, seed)
}

/// A motor of 12 slots and 16 poles that cogs by 1.4 % of a rated torque of 100 mNm.
pub const SLOTTED: [Cogging; 3] = [
    Cogging { per_turn: 48, torque_mnm: 1.4, phase_rad: 0.4 },
    Cogging { per_turn: 12, torque_mnm: 0.6, phase_rad: -1.1 },
    Cogging { per_turn: 16, torque_mnm: 0.3, phase_rad: 2.0 },
];

/// The same on a motor that cogs, its cogging taken out.
pub fn behaviour_on(
    cogging: &[Cogging],
    model: &dynamics::Model,
    gains: RenderGains,
    hand: Hand,
    rate_hz: f64,
    seed: u64,
) -> Behaviour {
    let Intention::Recorded { angle_rad, .. } = &hand.intention else { unreachable!("random hands move as recorded") };
    let wanted_rad = angle_rad.last().unwrap() - angle_rad[0];
    let grip = hand.grip;
    let mut knob = HeldKnob::on_motor(cogging, model, gains, Some(hand), rate_hz, seed);
    let mut inner_rad = 0.0;
    let mut seen = Behaviour { least_energy: f64::INFINITY, swings: [0.0; 2], guarded: 0 };
    while knob.time_s() < LASTS_S {
        let time_s = knob.time_s();
        let rendered = knob.step();
        seen.guarded += u32::from(rendered.guarded);
        let truth = knob.rig.truth();
        let springs = if model.coupling().is_some() {
            held_by_springs(model, rendered.inner_angle_rad)
                + held_by_contact(model, rendered.angle_rad - rendered.inner_angle_rad)
        } else {
            held_by_springs(model, truth.knob_angle_rad)
        };
        seen.least_energy = seen.least_energy.min(knob.work_of_hand - springs);
        // Of two bodies the inner one may be much slower or faster than the cap: as much as that.
        let inner_rad_s = (rendered.inner_angle_rad - inner_rad) * rate_hz;
        inner_rad = rendered.inner_angle_rad;
        let inner_inertia = model.coupling().map_or(0.0, |coupling| coupling.inner_share.min(0.99) * model.inertia());
        let moving = 0.5 * (model.inertia() - inner_inertia + grip.inertia) * truth.knob_velocity_rad_s.powi(2)
            + 0.5 * inner_inertia * inner_rad_s.powi(2);
        let gripped = 0.5 * grip.stiffness_mnm_rad * (truth.knob_angle_rad - wanted_rad).powi(2);
        let now = moving + springs + gripped;
        if time_s < MOVES_S + 0.1 {
            seen.swings[0] = now;
        }
        seen.swings[1] = now;
    }
    seen
}

/// What the simulated rig renders at a rate, and under which gains; `None` where it holds nothing firmly enough.
pub fn firmness(rate_hz: f64) -> Option<Firmness> {
    let nothing = dynamics::knobs::Fixture::None.model().unwrap();
    let rig = SimulatedRig::new(RigParameters::default(), nothing, 1).unwrap();
    let description = rig.description();
    gains_for(&description.calibration, &description.limits, rate_hz, 0.0)
}

/// The bounds of the simulated rig.
pub fn bounds(rate_hz: f64) -> Bounds {
    firmness(rate_hz).unwrap().bounds
}

/// A knob inside the bounds in a hand of the class, drawn by `seed`.
pub fn inside(seed: u64, rate_hz: f64) -> (dynamics::Model, Hand) {
    let bounds = bounds(rate_hz);
    let mut numbers = Numbers(seed);
    loop {
        let model = random_knob(&mut numbers, bounds.largest_inertia(0.0));
        if bounds.check(&model).is_ok() {
            return (model, random_hand(&mut numbers, MOVES_S, LASTS_S));
        }
    }
}

/// The same with lost motion, or a shaft that twists.
pub fn inside_with_two_bodies(seed: u64, rate_hz: f64) -> (dynamics::Model, Hand) {
    let bounds = bounds(rate_hz);
    let mut numbers = Numbers(0x5eed_0000 + seed);
    loop {
        let model = random_two_bodies(&mut numbers, bounds.least_inertia, bounds.largest_inertia(0.0));
        if bounds.check(&model).is_ok() {
            return (model, random_hand(&mut numbers, MOVES_S, LASTS_S));
        }
    }
}

/// Most energy that may come out, mNm·rad: the guard's slack.
pub const SLACK: f64 = 1.0;

/// Whether the energy of knob, springs and grip grew while the hand kept still, by more than sensors and steps make.
pub fn grew(seen: &Behaviour) -> bool {
    seen.swings[1] > seen.swings[0] + 0.05
}

#[test]
fn inside_the_bounds_no_swing_grows_and_no_energy_comes_out() {
    for seed in 0..24 {
        let (model, hand) = inside(seed, 10_000.0);
        let seen = behaviour(&model, RenderGains::at_rate(10_000.0), hand, 10_000.0, seed);
        assert!(seen.least_energy > -SLACK && !grew(&seen), "seed {seed}: {seen:?}");
    }
}

#[test]
fn neither_does_it_on_a_motor_whose_cogging_is_taken_out() {
    for seed in 0..8 {
        let (model, hand) = inside(seed, 10_000.0);
        let gains = RenderGains::at_rate(10_000.0);
        let seen = behaviour_on(&SLOTTED, &model, gains, hand, 10_000.0, seed);
        assert!(seen.least_energy > -SLACK && !grew(&seen), "seed {seed}: {seen:?}");
    }
}

#[test]
fn inside_the_bounds_lost_motion_and_shafts_make_no_swing_grow_and_no_energy_come_out() {
    for seed in 0..16 {
        let (model, hand) = inside_with_two_bodies(seed, 10_000.0);
        let seen = behaviour(&model, RenderGains::at_rate(10_000.0), hand, 10_000.0, seed);
        assert!(seen.least_energy > -SLACK && !grew(&seen), "seed {seed}: {seen:?} of {model:?}");
    }
}

/// Knob 3 of the paper with one effect more.
fn knob_three_with(kind: &'static dynamics::EffectKind, values: &[f64]) -> dynamics::Model {
    let mut model = dynamics::knobs::paper_knob(3).unwrap();
    model.effects.push(dynamics::Effect::new(kind, values));
    model
}

#[test]
fn damping_that_cannot_be_rendered_is_refused_by_its_parameter_whichever_effect_has_it() {
    use dynamics::effects::{eddy_current_damping, end_stop, quadratic_drag};
    use rt_loop::stability::Bounded;

    let mut viscous = dynamics::knobs::paper_knob(3).unwrap();
    viscous.effects.iter_mut().filter(|effect| effect.kind().name == "friction").for_each(|friction| {
        friction.values_mut()[3] = 100.0;
    });
    let cases = [
        (viscous, "viscous_positive"),
        (knob_three_with(&quadratic_drag::KIND, &[100.0]), "drag_coefficient"),
        (knob_three_with(&eddy_current_damping::KIND, &[5000.0, 3.0]), "eddy_damping"),
        (knob_three_with(&end_stop::KIND, &[-6.2, 6.2, 1.0, 1.0, 5000.0]), "stop_damping"),
    ];
    for (model, parameter) in cases {
        let refused = bounds(10_000.0).check(&model).unwrap_err();
        let of_speed = matches!(refused.what, Bounded::Damping | Bounded::Torque);
        assert!(of_speed, "{refused}");
        assert!(refused.bound > 0.0 && refused.remedy.contains(parameter), "{refused}");
    }
}

#[test]
fn inside_the_bounds_drag_lets_no_swing_grow_and_no_energy_come_out() {
    use dynamics::effects::{eddy_current_damping, quadratic_drag};
    let bounds = bounds(10_000.0);
    for seed in 0..8 {
        let shares = [(&quadratic_drag::KIND, [1.0, 0.0]), (&eddy_current_damping::KIND, [1.0, 4.0])];
        let (kind, [_, speed]) = shares[usize::try_from(seed % 2).unwrap()];
        // The largest that is admitted.
        let model = (0..100).map(|step| knob_three_with(kind, &[2000.0 * 0.9_f64.powi(step), speed]));
        let model = model.into_iter().find(|model| bounds.check(model).is_ok()).unwrap();
        let hand = random_hand(&mut Numbers(900 + seed), MOVES_S, LASTS_S);
        let seen = behaviour(&model, RenderGains::at_rate(10_000.0), hand, 10_000.0, seed);
        assert!(seen.least_energy > -SLACK && !grew(&seen) && seen.guarded == 0, "seed {seed}: {seen:?}");
    }
}

/// A wheel in the grip of the class that suits it least, moved about and then kept still.
pub fn wheel(inertia: f64, stiffness_mnm_rad: f64, gains: RenderGains, grip: Grip) -> Behaviour {
    let model = wheel_model(inertia, stiffness_mnm_rad);
    let hand = Hand { grip, ..random_hand(&mut Numbers(7), MOVES_S, LASTS_S) };
    behaviour(&model, gains, hand, 10_000.0, 7)
}

/// Energy of a detent without friction, mNm·rad, just after it was pushed and let go, and two seconds later.
pub fn let_go(stiffness_mnm_rad: f64, gains: RenderGains) -> [f64; 2] {
    let model = wheel_model(0.035, stiffness_mnm_rad);
    let mut knob = HeldKnob::new(&model, gains, None, 10_000.0, 7);
    knob.rig.set_hand_torque(30.0);
    let mut energy = [0.0; 2];
    while knob.time_s() < 2.5 {
        if knob.time_s() > 0.02 {
            knob.rig.set_hand_torque(0.0);
        }
        knob.step();
        let truth = knob.rig.truth();
        let moving = 0.5 * model.inertia() * truth.knob_velocity_rad_s.powi(2);
        energy[1] = moving + held_by_springs(&model, truth.knob_angle_rad);
        if knob.time_s() < 0.5 {
            energy[0] = energy[1];
        }
    }
    energy
}

fn wheel_model(inertia: f64, stiffness_mnm_rad: f64) -> dynamics::Model {
    let mut model = dynamics::Model {
        name: "wheel".to_owned(),
        description: String::new(),
        effects: Vec::new(),
        ..dynamics::Model::default()
    };
    model.effects.push(dynamics::Effect::new(&dynamics::effects::inertia::KIND, &[inertia]));
    if stiffness_mnm_rad > 0.0 {
        let amplitude_mnm = 100.0;
        let detent = [amplitude_mnm, amplitude_mnm / stiffness_mnm_rad, 0.0];
        model.effects.push(dynamics::Effect::new(&dynamics::effects::detent::KIND, &detent));
    }
    model
}

/// Grips at the edge of the class: as little damping as it permits.
pub fn edge_of_the_class() -> Vec<Grip> {
    let mut grips = Vec::new();
    for stiffness_mnm_rad in [100.0, 400.0, 1_600.0, 6_400.0] {
        for inertia in [0.0, 0.005, 0.01, 0.02] {
            grips.push(Grip { inertia, damping: stiffness_mnm_rad / 1_000.0, stiffness_mnm_rad });
        }
    }
    grips
}

#[test]
fn outside_the_bounds_a_knob_can_be_made_to_swing() {
    let gains = RenderGains::at_rate(10_000.0);
    let bounds = bounds(10_000.0);
    let worst = |inertia: f64, stiffness: f64| {
        let seen = edge_of_the_class().into_iter().map(|grip| wheel(inertia, stiffness, gains, grip));
        seen.filter(grew).count()
    };
    assert_eq!(worst(bounds.largest_inertia(0.0), 0.0), 0, "at the largest inertia");
    let bound = bounds.largest_stiffness_mnm_rad(0.035, 0.0);
    let [before, after] = let_go(bound, gains);
    assert!(after < before, "a detent at the bound comes to rest: {before:.3} to {after:.3} mNm·rad");
    let [before, after] = let_go(8.0 * bound, gains);
    assert!(after > before, "one of eight times that stiffness swings up: {before:.3} to {after:.3} mNm·rad");
}
