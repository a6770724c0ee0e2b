//! Each calibration against what the simulated rig is made of, over seeds of its noise.

use crate::common::run;
use dynamics::knobs::{self, Fixture};
use dynamics::{Calibration, Drive, Model};
use identification::calibration::{CalibrateError, Calibrated, Estimate, combine, gravity, gripper, latency, zero};
use rand_distr::{Distribution as _, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng as _;

const SEEDS: u64 = 12;

/// A calibration that knows nothing of what the others are to find.
fn ignorant(truth: &Calibration) -> Calibration {
    Calibration {
        gripper_inertia: 0.0,
        torque_zero_mnm: 0.0,
        torque_delay_s: 0.0,
        acceleration_zero_rad_s2: 0.0,
        acceleration_delay_s: 0.0,
        gravity_amplitude_rad_s2: 0.0,
        gravity_phase_rad: 0.0,
        ..truth.clone()
    }
}

/// How often a quantity's interval held the truth, and how far off it was.
#[derive(Default)]
struct Tally {
    held: u64,
    told: u64,
    worst: f64,
    half_width: f64,
}

impl Tally {
    fn count(&mut self, estimate: &Estimate, truth: f64) {
        let error = (estimate.value - truth).abs();
        self.told += 1;
        self.held += u64::from(error <= estimate.half_width);
        self.worst = self.worst.max(error);
        self.half_width = estimate.half_width;
    }

    /// Holds the truth as often as 95 % intervals do, and is narrow enough to be of use.
    #[track_caller]
    fn assert_good(&self, quantity: &str, useful: f64) {
        let Self { held, told, worst, half_width } = self;
        println!("{quantity}: {held} of {told} hold, worst error {worst:.3e}, half width {half_width:.3e}");
        assert!(*told == SEEDS && *held + 2 >= *told, "{quantity}: {held} of {told} intervals hold the truth");
        assert!(*half_width < useful, "{quantity}: an interval of ±{half_width} is of no use");
    }
}

#[test]
fn gravity_is_found_from_a_slow_turn_even_of_a_knob_with_detents_and_stick() {
    for number in [0, 3, 4] {
        let knob = if number == 0 { Fixture::None.model().unwrap() } else { knobs::paper_knob(number).unwrap() };
        let (mut amplitude, mut phase, mut offset) = (Tally::default(), Tally::default(), Tally::default());
        for seed in 1..=SEEDS {
            let turn = run(&knob, "slow-turn", Drive::Position, None, 15.0, seed);
            let known = Calibration { acceleration_delay_s: turn.rig().acceleration_delay_s, ..ignorant(turn.rig()) };
            let found = gravity(&turn.samples(), &known).unwrap();
            amplitude.count(found.get("gravity_amplitude_rad_s2").unwrap(), turn.rig().gravity_amplitude_rad_s2);
            phase.count(found.get("gravity_phase_rad").unwrap(), turn.rig().gravity_phase_rad);
            offset.count(found.get("acceleration_zero_rad_s2").unwrap(), turn.rig().acceleration_zero_rad_s2);
        }
        println!("knob {number}");
        amplitude.assert_good("gravity_amplitude_rad_s2", 0.5);
        phase.assert_good("gravity_phase_rad", 1e-3);
        offset.assert_good("acceleration_zero_rad_s2", 0.5);
    }
}

#[test]
fn zeros_are_found_at_rest() {
    let (mut torque, mut acceleration) = (Tally::default(), Tally::default());
    for seed in 1..=SEEDS {
        let rest = run(&Fixture::None.model().unwrap(), "hold", Drive::Torque, None, 5.0, seed);
        let known = Calibration { torque_zero_mnm: 0.0, acceleration_zero_rad_s2: 0.0, ..rest.rig().clone() };
        let found = zero(&rest.samples(), &known).unwrap();
        torque.count(found.get("torque_zero_mnm").unwrap(), rest.rig().torque_zero_mnm);
        acceleration.count(found.get("acceleration_zero_rad_s2").unwrap(), rest.rig().acceleration_zero_rad_s2);
    }
    torque.assert_good("torque_zero_mnm", 0.01);
    acceleration.assert_good("acceleration_zero_rad_s2", 0.1);
}

#[test]
fn the_zero_of_a_coarse_sensor_is_within_its_interval_however_little_noise_there_is() {
    const ROWS: usize = 3000;
    let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
    let t_s: Vec<f64> = (0..ROWS).map(|row| row as f64 * 1e-3).collect();
    let still = vec![0.0; ROWS];
    let rest = run(&Fixture::None.model().unwrap(), "hold", Drive::Torque, None, 1.0, 1);
    let known = Calibration { torque_step_mnm: 0.5, ..rest.rig().clone() };
    for noise_mnm in [0.0, 0.02, 0.05, 0.1, 0.2] {
        for truth_mnm in [-0.24, -0.1, 0.03, 0.2, 0.249] {
            let seen = |_| {
                let unit: f64 = StandardNormal.sample(&mut random);
                ((truth_mnm + noise_mnm * unit) / known.torque_step_mnm).round() * known.torque_step_mnm
            };
            let torque: Vec<f64> = (0..ROWS).map(seen).collect();
            let samples = identification::Samples {
                t_s: &t_s,
                angle_rad: &still,
                velocity_rad_s: None,
                acceleration_rad_s2: None,
                torque_mnm: &torque,
            };
            let found = zero(&samples, &known).unwrap();
            let estimate = found.get("torque_zero_mnm").unwrap();
            let error = (estimate.value - truth_mnm).abs();
            assert!(error <= estimate.half_width, "noise {noise_mnm}, {truth_mnm}: {estimate:?}");
        }
    }
}

#[test]
fn both_channels_delays_are_found_to_a_fraction_of_a_sample() {
    let (mut torque, mut acceleration) = (Tally::default(), Tally::default());
    for seed in 1..=SEEDS {
        let fast = run(&Fixture::None.model().unwrap(), "fast-multisine", Drive::Position, Some(0.1), 10.0, seed);
        let known = Calibration {
            torque_delay_s: 0.0,
            acceleration_delay_s: 0.0,
            gripper_inertia: 0.0,
            torque_zero_mnm: 0.0,
            ..fast.rig().clone()
        };
        let found = latency(&fast.samples(), &known).unwrap();
        torque.count(found.get("torque_delay_s").unwrap(), fast.rig().torque_delay_s);
        acceleration.count(found.get("acceleration_delay_s").unwrap(), fast.rig().acceleration_delay_s);
    }
    torque.assert_good("torque_delay_s", 10e-6);
    acceleration.assert_good("acceleration_delay_s", 10e-6);
}

#[test]
fn friction_behind_the_torque_sensor_is_not_taken_for_a_delay() {
    let rough = Model::from_toml(
        "name = \"rough\"\n[[effects]]\neffect = \"inertia\"\ninertia = 0.08\n[[effects]]\neffect = \"friction\"\n\
         coulomb_negative = 4.0\ncoulomb_positive = 4.0\nviscous_negative = 0.3\nviscous_positive = 0.3\n",
        "rough",
    )
    .unwrap();
    for seed in 1..=SEEDS {
        let fast = run(&rough, "fast-multisine", Drive::Position, Some(0.1), 10.0, seed);
        let known = Calibration { torque_delay_s: 0.0, ..fast.rig().clone() };
        let found = latency(&fast.samples(), &known).unwrap();
        let error_s = found.get("torque_delay_s").unwrap().value - fast.rig().torque_delay_s;
        println!("{error_s:.2e} ± {:.2e} s: {:?}", found.get("torque_delay_s").unwrap().half_width, found.notes);
        assert!(error_s.abs() < 20e-6, "{error_s}");
        assert!(found.notes.iter().any(|note| note.contains("friction behind the torque sensor")), "{:?}", found.notes);
    }
}

#[test]
fn the_grippers_inertia_is_found_from_a_sweep_without_a_knob() {
    let mut inertia = Tally::default();
    for seed in 1..=SEEDS {
        let sweep = run(&Fixture::None.model().unwrap(), "fast-multisine", Drive::Position, Some(0.1), 10.0, seed);
        let known = Calibration { gripper_inertia: 0.0, ..sweep.rig().clone() };
        let found = gripper(&sweep.samples(), &known).unwrap();
        assert_eq!(found.notes, Vec::<String>::new());
        inertia.count(found.get("gripper_inertia").unwrap(), sweep.rig().gripper_inertia);
    }
    inertia.assert_good("gripper_inertia", 2e-4);
}

#[test]
fn a_rig_of_which_nothing_is_known_is_calibrated_step_by_step() {
    let none = Fixture::None.model().unwrap();
    let rest = run(&none, "hold", Drive::Torque, None, 5.0, 21);
    let fast = run(&none, "fast-multisine", Drive::Position, Some(0.1), 10.0, 22);
    let turn = run(&none, "slow-turn", Drive::Position, None, 15.0, 23);
    let truth = rest.rig();
    let mut known = ignorant(truth);
    // Gravity and delay lean on each other a little: twice around is enough.
    for _ in 0..2 {
        known = gravity(&turn.samples(), &known).unwrap().applied_to(&known);
        known = latency(&fast.samples(), &known).unwrap().applied_to(&known);
    }
    known = zero(&rest.samples(), &known).unwrap().applied_to(&known);
    known = gripper(&fast.samples(), &known).unwrap().applied_to(&known);
    let pairs = [
        ("gravity", known.gravity_amplitude_rad_s2, truth.gravity_amplitude_rad_s2, 0.2),
        ("gravity's phase", known.gravity_phase_rad, truth.gravity_phase_rad, 1e-3),
        ("acceleration's zero", known.acceleration_zero_rad_s2, truth.acceleration_zero_rad_s2, 0.3),
        ("acceleration's delay", known.acceleration_delay_s, truth.acceleration_delay_s, 5e-6),
        ("torque's zero", known.torque_zero_mnm, truth.torque_zero_mnm, 0.01),
        ("torque's delay", known.torque_delay_s, truth.torque_delay_s, 10e-6),
        ("gripper", known.gripper_inertia, truth.gripper_inertia, 2e-4),
    ];
    for (name, found, true_value, tolerance) in pairs {
        assert!((found - true_value).abs() < tolerance, "{name} is {found}, in truth {true_value}");
    }
}

#[test]
fn captures_made_for_something_else_are_refused_in_one_sentence() {
    let none = Fixture::None.model().unwrap();
    let rest = run(&none, "hold", Drive::Torque, None, 1.0, 1);
    let sweep = run(&none, "linear-chirp", Drive::Position, None, 3.0, 1);
    let stuck = run(&knobs::paper_knob(1).unwrap(), "linear-chirp", Drive::Position, None, 3.0, 1);
    let known = ignorant(rest.rig());
    assert!(matches!(gravity(&sweep.samples(), &known), Err(CalibrateError::LessThanATurn { .. })));
    assert!(matches!(zero(&sweep.samples(), &known), Err(CalibrateError::NotAtRest { .. })));
    assert!(gripper(&rest.samples(), &known).is_err());
    let deaf = identification::Samples { acceleration_rad_s2: None, ..sweep.samples() };
    assert!(gravity(&deaf, &known).is_err());
    // Friction is no inertia: its torque does not follow the acceleration.
    let refused = latency(&stuck.samples(), stuck.rig()).unwrap();
    assert!(refused.get("torque_delay_s").is_none() && refused.notes.len() == 1, "{refused:?}");
    for message in [
        gravity(&sweep.samples(), &known).unwrap_err().to_string(),
        zero(&sweep.samples(), &known).unwrap_err().to_string(),
    ] {
        assert!(message.contains("capture with") && !message.contains('\n'), "{message}");
    }
}

#[test]
fn several_captures_narrow_the_interval_unless_they_disagree() {
    let told = |value, half_width| Calibrated {
        estimates: vec![Estimate { quantity: "gravity_phase_rad", value, half_width, unit: "rad" }],
        ..Calibrated::default()
    };
    let alike = combine(&[told(3.12, 0.1), told(-3.12, 0.1)]).unwrap();
    let one = alike.get("gravity_phase_rad").unwrap();
    assert!((one.value.abs() - std::f64::consts::PI).abs() < 1e-9, "across the cut of the circle: {}", one.value);
    assert!((one.half_width - 0.1 / 2_f64.sqrt()).abs() < 1e-9);
    let apart = combine(&[told(0.0, 0.01), told(1.0, 0.01)]).unwrap();
    let one = apart.get("gravity_phase_rad").unwrap();
    assert!((one.value - 0.5).abs() < 1e-9 && one.half_width > 0.5);
    assert_eq!(combine(&[]), None);
}
