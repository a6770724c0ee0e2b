//! Model files and excitations against the paper's numbers and against finite differences.
#![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]

use dynamics::effects::detent::canonical;
use dynamics::excitation::NAMES;
use dynamics::knobs::Fixture;
use dynamics::{Drive, Excitation, Model, Motion, knobs};

#[test]
fn a_model_survives_its_own_file() {
    for number in 1..=5 {
        let knob = knobs::paper_knob(number).unwrap();
        assert_eq!(Model::from_toml(&knob.to_toml(), "written").unwrap(), knob);
    }
}

#[test]
fn the_fixtures_are_a_gripper_that_spins_freely_and_one_that_holds() {
    let none = Fixture::named("none").unwrap().model().unwrap();
    assert_eq!((none.inertia(), none.stick_limits(&Motion::default()).positive_mnm), (0.0, 0.0));
    let locked = Fixture::named("locked").unwrap().model().unwrap();
    assert!(locked.stick_limits(&Motion::default()).negative_mnm >= 1e6);
    assert_eq!(Fixture::named("3"), None);
}

#[test]
fn a_wrong_model_file_gets_one_sentence_that_names_what_is_wrong() {
    let cases = [
        ("[[effects]]\neffect = \"wobble\"\n", "names the effect 'wobble', which is unknown"),
        (
            "[[effects]]\neffect = \"inertia\"\ninertia = -0.1\n",
            "inertia is -0.1 mNm s²/rad, but it must be zero or more",
        ),
        ("[[effects]]\neffect = \"inertia\"\ninertia = nan\n", "must be zero or more, and finite"),
        ("[[effects]]\neffect = \"inertia\"\n", "lacks 'inertia'"),
        ("[[effects]]\neffect = \"shaft-compliance\"\nshaft_stiffness = 1.0\n", "lacks 'shaft_damping'"),
        ("[[effects]]\neffect = \"inertia\"\ninertia = 1\nmass = 2\n", "has no parameter 'mass'"),
        ("name = \"empty\"\n", "has no [[effects]]"),
        ("colour = 3\n", "'colour' is not part of a model"),
        ("not toml at all", "is not a model file"),
    ];
    for (text, expected) in cases {
        let message = Model::from_toml(text, "knob.toml").unwrap_err().to_string();
        assert!(message.contains(expected) && message.starts_with("knob.toml"), "{message}");
        assert!(!message.contains('\n'), "one line: {message}");
    }
}

#[test]
fn the_printed_sweep_is_equation_2_digit_for_digit() {
    let sweep = Excitation::named("paper", Drive::Position).unwrap();
    let (a, b, c, d) = (0.0_f64, 1.5, 1.0, 3.0);
    for n in 1..=30_000_u32 {
        let t = f64::from(n) / 5_000.0;
        let printed = c * (std::f64::consts::PI / (b - a) * ((b - a) * t / d + a).powi(2) - a * a).sin();
        assert!((sweep.at(t).value - printed).abs() < 1e-12);
    }
}

#[test]
fn every_excitation_starts_at_zero_and_its_derivatives_are_those_of_its_value() {
    for name in NAMES {
        let sweep = Excitation::named(name, Drive::Position).unwrap();
        assert!(sweep.at(0.0).value.abs() < 1e-12, "{name} starts with a jump");
        let step = 1e-5;
        let mut largest = 0.0_f64;
        for index in 1..2_000_u32 {
            let t = f64::from(index) * 0.009_973;
            let (before, here, after) = (sweep.at(t - step), sweep.at(t), sweep.at(t + step));
            let rate = (after.value - before.value) / (2.0 * step);
            let acceleration = (after.rate - before.rate) / (2.0 * step);
            assert!((rate - here.rate).abs() < 1e-4 * (1.0 + here.rate.abs()), "{name} at {t} s: rate");
            assert!(
                (acceleration - here.acceleration).abs() < 2e-3 * (1.0 + here.acceleration.abs()) || near_a_fold(t),
                "{name} at {t} s: acceleration {acceleration} against {}",
                here.acceleration
            );
            largest = largest.max(here.value.abs());
            assert!(
                here.value.abs() <= 1.05 * sweep.amplitude,
                "{name} exceeds its amplitude at {t} s: {}",
                here.value
            );
        }
        assert!(largest >= 0.9 * sweep.amplitude || name == "hold", "{name} reaches {largest}");
    }
}

#[test]
fn a_slow_turn_passes_every_angle_of_a_full_turn_at_one_speed() {
    let turn = Excitation::named("slow-turn", Drive::Position).unwrap();
    let steady: Vec<f64> = (0..15_000)
        .map(|index| turn.at(f64::from(index) * 1e-3))
        .filter(|here| here.acceleration == 0.0 && here.rate != 0.0)
        .map(|here| here.rate.abs())
        .collect();
    assert!(steady.len() > 13_900 && steady.iter().all(|rate| (rate - steady[0]).abs() < 1e-9));
    assert!((turn.at(7.5).value - 1.2 * std::f64::consts::TAU).abs() < 1e-9, "at the far end after one way");
    assert!(turn.at(15.0).value.abs() < 1e-9, "back after two");
}

#[test]
fn the_teeth_of_a_torque_ramp_alternate_and_grow_up_to_the_amplitude() {
    let ramp = Excitation::named("torque-ramp", Drive::Torque).unwrap();
    for level in 0..16_u32 {
        let peak = 20.0 * f64::from(level + 1) / 16.0;
        let start_s = 0.6 * f64::from(level);
        assert!((ramp.at(start_s + 0.15).value - peak).abs() < 1e-9);
        assert!((ramp.at(start_s + 0.45).value + peak).abs() < 1e-9);
    }
}

/// Where a sweep turns from rising to falling its acceleration has a corner or a step.
fn near_a_fold(time_s: f64) -> bool {
    let within = time_s.rem_euclid(1.0);
    !(2e-5..=1.0 - 2e-5).contains(&within)
}

#[test]
fn a_detent_is_the_same_torque_in_its_canonical_form() {
    for (amplitude, phase) in [(-11.0, -0.2), (1.1, 0.16), (-130.0, -1.0), (2.0, 7.0), (-2.0, 3.1)] {
        let (positive, wrapped) = canonical(amplitude, phase);
        assert!(positive >= 0.0 && wrapped > -std::f64::consts::PI && wrapped <= std::f64::consts::PI);
        for x in [0.0, 0.3, 1.7, -2.2] {
            let difference: f64 = amplitude * f64::sin(x + phase) - positive * f64::sin(x + wrapped);
            assert!(difference.abs() < 1e-12 * positive.max(1.0));
        }
    }
}

/// An effect with values that make every parameter matter.
fn sample_of(kind: &'static dynamics::EffectKind) -> dynamics::Effect {
    let values: Vec<f64> =
        (0..kind.parameters.len()).map(|index| 0.3 + 0.07 * f64::from(u8::try_from(index).unwrap())).collect();
    dynamics::Effect::new(kind, &values)
}

#[test]
fn an_effect_depends_on_what_it_declares_and_on_nothing_else() {
    use dynamics::{Coordinate, Direction, Part};
    let moved = |coordinate, start: &Motion, by: f64| {
        let mut motion = *start;
        match coordinate {
            Coordinate::Angle => motion.angle_rad += by,
            Coordinate::Velocity => motion.velocity_rad_s += by,
            Coordinate::Acceleration => motion.acceleration_rad_s2 += by,
            Coordinate::Time => motion.time_s += by,
            Coordinate::Load => {}
        }
        motion
    };
    let mut tested = 0;
    for kind in dynamics::effects::ALL {
        let effect = sample_of(kind);
        let at = |motion: &Motion| match kind.part {
            Part::Torque(law) | Part::Reading(law) | Part::CoulombFactor(law) | Part::FrictionFactor(law) => {
                Some(law(effect.values(), motion))
            }
            Part::Friction(law) => Some(law(effect.values(), motion, Direction::Positive)),
            _ => None,
        };
        let start = Motion { time_s: 0.2, angle_rad: 0.9, velocity_rad_s: 0.7, acceleration_rad_s2: 3.0 };
        let Some(before) = at(&start) else { continue };
        tested += 1;
        for coordinate in [Coordinate::Angle, Coordinate::Velocity, Coordinate::Acceleration, Coordinate::Time] {
            let differs = [-2.0, -0.61, -0.49, 0.13, 0.37, 1.3]
                .iter()
                .any(|by| at(&moved(coordinate, &start, *by)).unwrap().to_bits() != before.to_bits());
            assert_eq!(differs, kind.depends_on.contains(&coordinate), "{} and {coordinate:?}", kind.name);
        }
        let of_angle = matches!(kind.part, Part::Torque(_)) && kind.depends_on.contains(&Coordinate::Angle);
        assert_eq!(kind.steepest_mnm_rad.is_some(), of_angle, "the slope of {}", kind.name);
    }
    assert!(tested >= 17, "{tested} effects");
}

#[test]
fn every_effect_that_is_looked_for_is_hidden_in_the_plant_that_tries_the_diagnosis() {
    let looked_for = dynamics::effects::ALL.iter().filter(|kind| kind.hypothesis.is_some());
    // Equal detents become unequal ones by themselves.
    let unequal = dynamics::effects::unequal_detents::KIND.name;
    let mut looked_for: Vec<&str> = looked_for.map(|kind| kind.name).chain([unequal]).collect();
    let mut hidden: Vec<&str> = hidden_effects::effect::catalogue().iter().map(|kind| kind.name).collect();
    looked_for.sort_unstable();
    hidden.sort_unstable();
    assert_eq!(looked_for, hidden);
}
