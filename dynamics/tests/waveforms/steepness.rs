//! The steepest slope that an effect states against finite differences of its torque.

use dynamics::{Effect, Model, TorqueTable, effects, knobs};

use crate::{drawing, effect, torque_mnm};

/// Steepest secant over `steps` even steps from one angle to another, mNm/rad: never more than the steepest slope.
fn steepest_secant(torque_mnm: impl Fn(f64) -> f64, from_rad: f64, to_rad: f64, steps: usize) -> f64 {
    let step_rad = (to_rad - from_rad) / steps as f64;
    let torques: Vec<f64> = (0..=steps).map(|step| torque_mnm(from_rad + step_rad * step as f64)).collect();
    torques.windows(2).map(|pair| (pair[1] - pair[0]).abs() / step_rad).fold(0.0, f64::max)
}

fn model(effects: Vec<Effect>) -> Model {
    Model { effects, ..Model::default() }
}

#[test]
fn the_stated_steepest_slope_is_reached_and_not_exceeded() {
    let cases: [(&str, &[f64]); 11] = [
        ("detent", &[-5.0, 0.1, 0.4]),
        ("detent-harmonics", &[0.1, 2.0, 0.3, 0.0, 1.5, 0.0, -0.7]),
        ("detent-triangle", &[-5.0, 0.1, 0.4]),
        ("detent-sawtooth", &[5.0, 0.1, 0.4, 0.9]),
        ("detent-sawtooth", &[5.0, 0.1, 0.4, 0.2]),
        ("cogging", &[3.0, 7.0, 0.4]),
        ("mass-imbalance", &[-3.0, 0.5]),
        ("return-spring", &[6.0, 0.2]),
        ("end-stop", &[-0.5, 1.0, 300.0, 400.0, 0.8]),
        ("torque-ramp", &[-6.0, 0.5, 0.2]),
        ("inertia", &[0.1]),
    ];
    for (name, values) in cases {
        let effect = effect(name, values);
        let stated = model(vec![effect]).steepest_stiffness_mnm_rad();
        let found = steepest_secant(|angle| torque_mnm(&effect, angle), -3.5, 3.5, 700_000);
        assert!(found <= stated * (1.0 + 1e-6) && found >= 0.9998 * stated, "{name}: {found} for {stated}");
    }
}

#[test]
fn the_steepest_slope_of_a_drawn_table_is_that_of_its_curve() {
    for seed in 1..=100 {
        let (angle_rad, points_mnm, period_rad) = drawing(seed);
        let table = TorqueTable::kept(&angle_rad, &points_mnm, Some(period_rad)).unwrap();
        let ends = angle_rad.iter().copied().chain([angle_rad[0] + period_rad]).collect::<Vec<_>>();
        let found = ends
            .windows(2)
            .map(|pair| steepest_secant(|angle| table.torque_mnm(angle), pair[0], pair[1] - 1e-12, 2000))
            .fold(0.0, f64::max);
        let effect = Effect::new(&effects::torque_table::KIND, &[-2.0]).with_table(table);
        let stated = 0.5 * model(vec![effect]).steepest_stiffness_mnm_rad();
        assert!(found <= stated * (1.0 + 1e-6) && found >= 0.999 * stated, "drawing {seed}: {found} for {stated}");
    }
}

#[test]
fn detents_and_their_harmonics_are_one_waveform() {
    let knob = knobs::paper_knob(5).unwrap();
    let found = steepest_secant(
        |angle_rad| knob.free_torque_mnm(&dynamics::Motion { angle_rad, ..dynamics::Motion::default() }),
        0.0,
        0.7,
        200_000,
    );
    let stated = knob.steepest_stiffness_mnm_rad();
    assert!(found <= stated && found >= 0.9999 * stated, "{found} for {stated}");
    // Of another period they add up.
    let mut apart = knob.clone();
    apart.effects.iter_mut().find(|effect| effect.kind().name == "detent").unwrap().values_mut()[1] = 0.09;
    let alone = |index: usize| model(vec![apart.effects[index]]).steepest_stiffness_mnm_rad();
    let sum: f64 = (0..apart.effects.len()).map(alone).sum();
    assert!((apart.steepest_stiffness_mnm_rad() - sum).abs() < 1e-9 * sum && sum > stated);
}
