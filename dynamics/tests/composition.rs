//! Composed knobs against the sums of their parts, with the paper's numbers written down here a second time.
#![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]

use dynamics::simulate::ForwardSimulation;
use dynamics::{
    Composition, CompositionError, CompositionNote, Effect, Model, Motion, Role, Source, composition_notes, effects,
    knobs,
};

/// Table 5 of Swindells and MacLean 2007: M, C₋ and C₊, B₋, B₊ of knobs 1 to 5.
const TABLE_5: [(f64, f64, f64, f64); 5] = [
    (0.091, 46.0, 2.7, -4.5),
    (0.28, 8.4, -0.095, 0.54),
    (0.035, 2.3, -0.15, -0.24),
    (0.049, 0.61, 0.55, 0.28),
    (0.0019, 19.0, 4.7, 4.1),
];
/// A, P, S of knobs 3 to 5.
const DETENTS: [(f64, f64, f64); 3] = [(1.1, 0.034, 0.16), (-11.0, 0.076, -0.2), (-130.0, 0.1, -1.0)];

fn inertia(knob: usize) -> f64 {
    TABLE_5[knob - 1].0
}

fn friction_mnm(knob: usize, velocity_rad_s: f64) -> f64 {
    let (_, coulomb, negative, positive) = TABLE_5[knob - 1];
    if velocity_rad_s < 0.0 { -coulomb + negative * velocity_rad_s } else { coulomb + positive * velocity_rad_s }
}

fn detents_mnm(knob: usize, angle_rad: f64) -> f64 {
    let (amplitude, period, phase) = DETENTS[knob - 3];
    let u = angle_rad / period + phase;
    // What knob 5's file says of its harmonics, which it writes with two decimals.
    let harmonics = if knob == 5 { 0.2 * (2.0 * u).sin() + 0.15 * (3.0 * u).sin() } else { 0.0 };
    amplitude * (u.sin() + harmonics)
}

fn shipped(knob: usize) -> Source {
    Source::new(format!("knob {knob}"), knobs::paper_knob(u32::try_from(knob).unwrap()).unwrap())
}

fn composed(inertia: usize, friction: usize, detents: Option<usize>) -> Model {
    let mut composition = Composition::default();
    composition.take(Role::Inertia, &shipped(inertia)).unwrap();
    composition.take(Role::Friction, &shipped(friction)).unwrap();
    if let Some(detents) = detents {
        composition.take(Role::Detents, &shipped(detents)).unwrap();
    }
    composition.model("mix", "")
}

fn every_mix() -> impl Iterator<Item = (usize, usize, Option<usize>)> {
    let detents = [None, Some(3), Some(4), Some(5)];
    (1..=5).flat_map(move |m| (1..=5).flat_map(move |f| detents.into_iter().map(move |d| (m, f, d))))
}

#[test]
fn every_mix_of_shipped_knobs_takes_the_sum_of_its_parts() {
    for (m, f, d) in every_mix() {
        let model = composed(m, f, d);
        let motions: Vec<Motion> = (0..500)
            .map(|index| {
                let time_s = f64::from(index) * 1e-3;
                let (sine, cosine) = (12.0 * time_s + 0.1).sin_cos();
                Motion { time_s, angle_rad: sine, velocity_rad_s: 12.0 * cosine, acceleration_rad_s2: -144.0 * sine }
            })
            .collect();
        for (motion, found) in motions.iter().zip(model.readings_mnm(&motions)) {
            let expected = inertia(m) * motion.acceleration_rad_s2
                + friction_mnm(f, motion.velocity_rad_s)
                + d.map_or(0.0, |d| detents_mnm(d, motion.angle_rad));
            assert!((found - expected).abs() < 0.03, "{m}, {f}, {d:?}: {found} for {expected} mNm");
        }
    }
}

#[test]
fn every_mix_of_shipped_knobs_moves_as_the_sum_of_its_parts_under_a_torque() {
    // Strong enough to slide on from the start over every stick and detent.
    let torque_mnm = |time_s: f64| 450.0 + 2000.0 * time_s;
    let (step_s, steps) = (1e-5, 800);
    for (m, f, d) in every_mix() {
        let model = composed(m, f, d);
        let mut simulation = ForwardSimulation::at_rest(&model, 0.0, 0.3).unwrap();
        let (mut angle, mut velocity) = (0.3, 0.0);
        let acceleration = |time_s: f64, angle: f64, velocity: f64| {
            (torque_mnm(time_s) - friction_mnm(f, velocity) - d.map_or(0.0, |d| detents_mnm(d, angle))) / inertia(m)
        };
        for index in 0..steps {
            let now_s = f64::from(index) * step_s;
            simulation.advance(step_s, torque_mnm(now_s), torque_mnm(now_s + step_s)).unwrap();
            // Runge's midpoint rule in a hundred steps.
            let fine_s = step_s / 100.0;
            for fine in 0..100 {
                let time_s = now_s + f64::from(fine) * fine_s;
                let half = 0.5 * fine_s;
                let (mid_angle, mid_velocity) =
                    (angle + half * velocity, velocity + half * acceleration(time_s, angle, velocity));
                angle += fine_s * mid_velocity;
                velocity += fine_s * acceleration(time_s + half, mid_angle, mid_velocity);
            }
        }
        let found = simulation.motion(0.0);
        let turned = angle - 0.3;
        assert!((found.angle_rad - angle).abs() < 2e-4 * turned, "{m}, {f}, {d:?}: {} for {angle}", found.angle_rad);
    }
}

#[test]
fn a_part_brings_everything_that_belongs_to_it_and_says_where_it_is_from() {
    let names = |model: &Model| model.effects.iter().map(|effect| effect.kind().name).collect::<Vec<_>>();
    let model = composed(2, 1, Some(5));
    assert_eq!(names(&model), ["inertia", "friction", "karnopp-stick", "detent", "detent-harmonics"]);
    let origins: Vec<_> = model.effects.iter().map(|effect| effect.origin().unwrap()).collect();
    assert_eq!(origins, ["knob 2", "knob 1", "knob 1", "knob 5", "knob 5"]);
}

#[test]
fn the_documentation_says_of_every_effect_what_it_belongs_to() {
    let rows: Vec<&str> = include_str!("../../docs/replay.md").lines().filter(|line| line.starts_with("| ")).collect();
    for kind in effects::ALL {
        let begins = match kind.role {
            Role::Inertia => "| inertia",
            Role::Friction => "| friction",
            Role::Detents => "| detents",
            Role::Other => "| every other effect",
        };
        let mentioned = format!("`{}`", kind.name);
        let rows: Vec<_> = rows.iter().filter(|row| row.contains(&mentioned)).collect();
        assert!(rows.len() == 1 && rows[0].starts_with(begins), "{} belongs to {}", kind.name, kind.role);
    }
}

#[test]
fn single_effects_and_single_values_come_from_anywhere() {
    let mut composition = Composition::default();
    composition.take(Role::Inertia, &shipped(5)).unwrap();
    composition.take(Role::Detents, &shipped(3)).unwrap();
    composition.take_effect("backlash", &shipped(5)).unwrap();
    composition.take_parameter("detent_period", &shipped(4)).unwrap();
    composition.set("detent_amplitude", 2.5).unwrap();
    let model = composition.model("mix", "");
    let detent = model.effect("detent").unwrap();
    assert_eq!(detent.values(), [2.5, 0.076, 0.16]);
    assert_eq!(detent.origin().unwrap(), "knob 3; detent_period from knob 4; detent_amplitude set to 2.5");
    assert_eq!(composition.origin_of("detent_phase"), Some("knob 3"));
    assert_eq!(model.coupling().unwrap().half_gap_rad, 0.013);

    // Composed once more, it still says where everything began, also out of its file.
    let read = Source::new("mix.toml", Model::from_toml(&model.to_toml(), "mix.toml").unwrap());
    let mut again = Composition::default();
    again.take(Role::Detents, &read).unwrap();
    let origin = again.model("again", "").effects[0].origin().unwrap();
    assert_eq!(origin, "mix.toml (knob 3; detent_period from knob 4; detent_amplitude set to 2.5)");
}

#[test]
fn what_does_not_fit_gets_one_sentence_that_says_what_would() {
    let mut mix = Composition::default();
    mix.take(Role::Inertia, &shipped(2)).unwrap();
    mix.take(Role::Detents, &shipped(3)).unwrap();
    mix.set("inertia", 0.3).unwrap();
    let refusal = |result: Result<(), CompositionError>| result.unwrap_err().to_string();
    for (message, expected) in [
        (
            refusal(mix.clone().take(Role::Detents, &shipped(1))),
            "knob 1 has no detents; it has inertia, friction, karnopp-stick. Of the shipped knobs 3, 4 and 5 have",
        ),
        (refusal(mix.clone().take(Role::Detents, &shipped(4))), "detent would come from knob 3 and again from knob 4"),
        (refusal(mix.clone().take_effect("end_stop", &shipped(4))), "no effect 'end_stop'; the nearest is end-stop"),
        (refusal(mix.clone().take_effect("end-stop", &shipped(4))), "knob 4 has no end-stop; it has inertia, friction"),
        (
            refusal(mix.clone().set("detent_amplitud", 1.0)),
            "'detent_amplitud' in the composed model; the nearest is detent_amplitude",
        ),
        (
            refusal(mix.clone().set("coulomb_positive", 1.0)),
            "coulomb_positive belongs to friction, which is not among the parts",
        ),
        (refusal(mix.clone().set("detent_period", 0.0)), "detent_period would be 0 rad, but it must be more than zero"),
        (
            refusal(mix.clone().set("detent_phase", f64::NAN)),
            "detent_phase would be NaN rad, but it must be a finite number",
        ),
        (refusal(mix.clone().set("inertia", 0.2)), "inertia is given two values"),
        (
            refusal(mix.clone().take_parameter("detent_period", &shipped(1))),
            "knob 1 has no detent_period; it has inertia, coulomb",
        ),
    ] {
        assert!(message.contains(expected), "{message}");
    }
}

/// An effect by name and values.
type Named<'test> = (&'test str, &'test [f64]);

fn model_of(effects: &[Named]) -> Model {
    let effect = |(name, values): &Named| Effect::new(effects::by_name(name).unwrap(), values);
    Model { effects: effects.iter().map(effect).collect(), ..Model::default() }
}

#[test]
fn parts_that_do_not_add_up_as_expected_are_reported() {
    let inertia: Named = ("inertia", &[0.1]);
    let friction: Named = ("friction", &[5.0, 6.0, 0.1, 0.1]);
    let cases: [(&[Named], &[&str]); 10] = [
        (&[inertia, friction, ("karnopp-stick", &[7.0, 7.0, 0.01])], &[]),
        (
            &[inertia, friction, ("karnopp-stick", &[4.0, 7.0, 0.01])],
            &["static_negative of 4 mNm is below the 5 mNm with which the knob begins to slide"],
        ),
        (
            &[inertia, ("friction", &[5.0, 6.0, 0.1, -0.5])],
            &["viscous_positive negative, friction pushes instead of braking beyond 12.00 rad/s"],
        ),
        (&[inertia, friction, ("detent", &[4.0, 0.1, 0.0])], &["the detents reach 4.000 mNm, less than the 5.000 mNm"]),
        (&[inertia, friction, ("detent", &[8.0, 0.1, 0.0])], &[]),
        (
            &[inertia, ("detent", &[8.0, 0.1, 0.0]), ("detent-harmonics", &[0.11, 1.0])],
            &["harmonic_period is 0.11 rad and detent_period 0.1 rad"],
        ),
        (&[inertia, ("friction-drift", &[0.5, 0.7])], &["friction-drift acts on friction, and the model has none"]),
        (&[inertia, ("stribeck", &[1.0, 0.5, 2.0]), ("friction-drift", &[0.5, 0.7])], &[]),
        (
            &[inertia, friction, ("karnopp-stick", &[4.0, 7.0, 0.01]), ("presliding-hysteresis", &[0.03, 0.02])],
            &["karnopp-stick does nothing beside presliding-hysteresis"],
        ),
        (&[friction], &["cannot be simulated on its own: forward simulation needs an inertia above zero"]),
    ];
    for (effects, expected) in cases {
        let notes: Vec<String> = composition_notes(&model_of(effects)).iter().map(CompositionNote::to_string).collect();
        assert_eq!(notes.len(), expected.len(), "{notes:?}");
        for (note, expected) in notes.iter().zip(expected) {
            assert!(note.contains(expected), "{note}");
        }
    }
}

#[test]
fn the_knob_without_its_gripper_keeps_the_inner_body_behind_a_shaft() {
    // 0.05 mNm·s²/rad behind the shaft, a gripper of 0.004 in front of it.
    let with = model_of(&[("inertia", &[0.054]), ("shaft-compliance", &[500.0, 0.1, 0.004 / 0.054])]);
    let knob = with.without_cap_inertia(0.004);
    assert!((knob.inertia() - 0.05).abs() < 1e-12);
    assert!((knob.coupling().unwrap().inner_share - 1.0).abs() < 1e-9);
    assert_eq!(with.without_cap_inertia(0.0), with);
}
