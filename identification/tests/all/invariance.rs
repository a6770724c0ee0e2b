//! The same knob gives the same answer whatever the order of the rows, the zero of the angle and the units.
//!
//! Tolerances are shares of the parameters' own 95 % intervals: the detent period is improved until a further step
//! would be worth less than a hundredth of them.

use std::f64::consts::{PI, TAU};

use crate::common::{Capture, SLIDING, Uniform, ideal, knob, sweep};
use dynamics::{Effect, effects};
use identification::{Fit, FitOptions, fit};

const SEEDS: u64 = 30;
/// Largest difference between two answers that are the same, in half widths of the 95 % interval.
const SAME: f64 = 0.02;

/// A random knob's capture; every other one has the encoder alone, with noise.
fn capture(seed: u64) -> Capture {
    let mut random = Uniform(0x2545_f491_4f6c_dd1d ^ (seed + 1));
    let mut between = |low: f64, high: f64| low * (high / low).powf(random.next());
    let values = [
        between(0.05, 0.4),
        between(1.0, 10.0),
        between(1.0, 10.0),
        between(0.2, 2.0),
        between(0.2, 2.0),
        between(2.0, 10.0),
        between(0.02, 0.2),
        between(1.0, 7.0) - 4.0,
    ];
    let mut capture = ideal(&knob(&values), sweep("linear-chirp"), 1.0, &mut random);
    if seed % 2 == 1 {
        (capture.velocity_rad_s, capture.acceleration_rad_s2) = (None, None);
        capture.angle_rad.iter_mut().for_each(|angle| *angle += 2e-5 * (random.next() - 0.5));
    }
    capture
}

fn fitted(capture: &Capture) -> Fit {
    fit(&capture.samples(), &FitOptions::default()).unwrap()
}

/// Value and half width of the interval.
fn told(fit: &Fit, name: &str) -> (f64, f64) {
    let parameter = fit.parameters.get(name).unwrap();
    let [low, high] = parameter.ci95.unwrap();
    (parameter.value.unwrap(), 0.5 * (high - low))
}

fn assert_same(seed: u64, name: &str, found: f64, expected: f64, half: f64) {
    assert!((found - expected).abs() < SAME * half, "seed {seed}: {name} is {found}, expected {expected} ± {half}");
}

#[test]
fn rows_in_any_order_give_the_same_answer_to_the_last_digit() {
    for seed in 0..SEEDS {
        let capture = capture(seed);
        let mut random = Uniform(seed + 77);
        let mut order: Vec<usize> = (0..capture.t_s.len()).collect();
        for last in (1..order.len()).rev() {
            order.swap(last, (random.next() * (last + 1) as f64) as usize);
        }
        let shuffle = |column: &Vec<f64>| order.iter().map(|index| column[*index]).collect::<Vec<f64>>();
        let shuffled = Capture {
            t_s: shuffle(&capture.t_s),
            angle_rad: shuffle(&capture.angle_rad),
            velocity_rad_s: capture.velocity_rad_s.as_ref().map(shuffle),
            acceleration_rad_s2: capture.acceleration_rad_s2.as_ref().map(shuffle),
            torque_mnm: shuffle(&capture.torque_mnm),
            calibration: None,
        };
        let (in_order, in_any) = (fitted(&capture), fitted(&shuffled));
        assert_eq!(in_order.parameters, in_any.parameters, "seed {seed}");
        assert!(in_any.notes.iter().any(|note| note.contains("order of time")));
    }
}

#[test]
fn a_shifted_angle_moves_the_phase_of_the_detents_and_nothing_else() {
    for seed in 0..SEEDS {
        let capture = capture(seed);
        let shift_rad = 20.0 * (Uniform(seed + 5).next() - 0.5);
        let mut shifted = capture.clone();
        shifted.angle_rad.iter_mut().for_each(|angle| *angle += shift_rad);
        let (before, after) = (fitted(&capture), fitted(&shifted));
        for name in &SLIDING[..7] {
            let ((expected, half), (found, _)) = (told(&before, name), told(&after, name));
            assert_same(seed, name, found, expected, half);
        }
        // S is the phase at angle zero: with the angle's zero elsewhere, the period's own error turns it besides.
        let ((period, _), (phase, _)) = (told(&before, SLIDING[6]), told(&before, SLIDING[7]));
        let (found, half) = told(&after, SLIDING[7]);
        let difference = found - (phase - shift_rad / period);
        assert_same(seed, SLIDING[7], (difference + PI).rem_euclid(TAU) - PI, 0.0, half);
    }
}

#[test]
fn a_scaled_angle_scales_the_period_and_divides_inertia_and_viscous_friction() {
    for seed in 0..SEEDS {
        let capture = capture(seed);
        let factor = 10_f64.powf(2.0 * Uniform(seed + 9).next() - 1.0);
        let mut scaled = capture.clone();
        let columns =
            [Some(&mut scaled.angle_rad), scaled.velocity_rad_s.as_mut(), scaled.acceleration_rad_s2.as_mut()];
        columns.into_iter().flatten().flatten().for_each(|value| *value *= factor);
        let (before, after) = (fitted(&capture), fitted(&scaled));
        let by = [1.0 / factor, 1.0, 1.0, 1.0 / factor, 1.0 / factor, 1.0, factor, 1.0];
        for (name, by) in SLIDING.iter().zip(by) {
            let ((expected, half), (found, _)) = (told(&before, name), told(&after, name));
            assert_same(seed, name, found, by * expected, by * half);
        }
    }
}

#[test]
fn a_scaled_torque_scales_what_is_a_torque() {
    for seed in 0..SEEDS {
        let capture = capture(seed);
        let factor = 10_f64.powf(2.0 * Uniform(seed + 13).next() - 1.0);
        let (before, after) = (fitted(&capture), fitted(&capture.louder(factor)));
        for (index, name) in SLIDING.iter().enumerate() {
            let by = if index < 6 { factor } else { 1.0 };
            let ((expected, half), (found, _)) = (told(&before, name), told(&after, name));
            assert_same(seed, name, found, by * expected, by * half);
        }
    }
}

/// The fit takes no start for its own parameters. All that could act as one is the value that a further effect's
/// searched parameter comes with.
#[test]
fn a_further_effect_that_starts_anywhere_ends_at_the_same_answer() {
    for seed in 0..SEEDS {
        let mut random = Uniform(seed + 21);
        let mut model = knob(&[0.1, 3.0, 4.0, 0.5, 0.6, 2.0, 0.05, 0.3]);
        let speed_rad_s = 2.0 + 2.0 * random.next();
        model.effects.push(Effect::new(&effects::stribeck::KIND, &[6.0, speed_rad_s, 1.0]));
        let capture = ideal(&model, sweep("linear-chirp"), 0.5, &mut random);
        let fits: Vec<Fit> = [0.4, 0.7, 1.0, 1.5, 2.5]
            .iter()
            .map(|factor| {
                let further_effects = vec![Effect::new(&effects::stribeck::KIND, &[0.0, factor * speed_rad_s, 1.0])];
                fit(&capture.samples(), &FitOptions { further_effects, ..FitOptions::default() }).unwrap()
            })
            .collect();
        for other in &fits[1..] {
            for name in SLIDING.iter().chain(&["stribeck_torque", "stribeck_speed", "stribeck_exponent"]) {
                let ((expected, half), (found, _)) = (told(&fits[0], name), told(other, name));
                assert_same(seed, name, found, expected, half);
            }
        }
    }
}

#[test]
fn a_capture_that_begins_later_gives_the_same_answer() {
    for seed in 0..SEEDS {
        let capture = capture(seed);
        let before = fitted(&capture);
        for by_s in [5.0, 1e6] {
            let after = fitted(&capture.later(by_s));
            for name in SLIDING {
                let ((expected, half), (found, _)) = (told(&before, name), told(&after, name));
                assert_same(seed, name, found, expected, half);
            }
        }
    }
}

#[test]
fn both_axes_turned_round_swap_the_directions() {
    for seed in 0..SEEDS {
        let capture = capture(seed);
        let (before, after) = (fitted(&capture), fitted(&capture.turned()));
        // A·sin(−θ/P + S) is −A·sin(θ/P − S): the phase alone changes its sign.
        let swapped = [0, 2, 1, 4, 3, 5, 6];
        for (name, other) in SLIDING.iter().zip(swapped) {
            let ((expected, half), (found, _)) = (told(&before, SLIDING[other]), told(&after, name));
            assert_same(seed, name, found, expected, half);
        }
    }
}
