//! Triangle, sawtooth and ramp.

use std::f64::consts::{FRAC_2_PI, PI, TAU};

use crate::{effect, torque_mnm};

fn angles() -> impl Iterator<Item = f64> {
    (0..4000).map(|step| f64::from(step) * 0.000_937 - 1.9)
}

#[test]
fn a_triangle_is_the_arc_sine_of_a_sine() {
    for (amplitude, period, phase) in [(5.0, 0.1, 0.4), (-3.0, 0.02, -7.0), (0.5, 1.0, 100.0)] {
        let triangle = effect("detent-triangle", &[amplitude, period, phase]);
        for angle in angles() {
            let expected = amplitude * FRAC_2_PI * (angle / period + phase).sin().asin();
            assert!((torque_mnm(&triangle, angle) - expected).abs() < 1e-6, "at {angle} rad");
        }
    }
}

#[test]
fn a_sawtooth_is_straight_between_its_corners() {
    let (amplitude, period, phase) = (4.0, 0.05, 0.3);
    for share in [0.05, 0.3, 0.5, 0.8, 0.97] {
        let sawtooth = effect("detent-sawtooth", &[amplitude, period, phase, share]);
        // Corners in turns from the middle of the rise: the end of the rise, and the start of the next.
        let corners = [(-0.5 * share, -1.0), (0.5 * share, 1.0), (1.0 - 0.5 * share, -1.0)];
        for pair in corners.windows(2) {
            for step in 0..=50 {
                let along = f64::from(step) / 50.0;
                let turns = pair[0].0 + along * (pair[1].0 - pair[0].0);
                let expected = amplitude * (pair[0].1 + along * (pair[1].1 - pair[0].1));
                for period_of_it in [-20.0, 0.0, 3.0] {
                    let angle = period * ((turns + period_of_it) * TAU - phase);
                    let found = torque_mnm(&sawtooth, angle);
                    assert!((found - expected).abs() < 1e-9, "share {share}: {found} for {expected} at {turns}");
                }
            }
        }
    }
}

#[test]
fn a_sawtooth_that_rises_over_half_of_its_period_is_a_triangle() {
    let sawtooth = effect("detent-sawtooth", &[4.0, 0.05, 0.3, 0.5]);
    let triangle = effect("detent-triangle", &[4.0, 0.05, 0.3]);
    for angle in angles() {
        assert!((torque_mnm(&sawtooth, angle) - torque_mnm(&triangle, angle)).abs() < 1e-9);
    }
}

#[test]
fn detents_of_every_waveform_have_their_zeros_and_extremes_where_the_sine_has_them() {
    let (period, phase) = (0.05, 0.3);
    let waves = [
        effect("detent", &[2.0, period, phase]),
        effect("detent-triangle", &[2.0, period, phase]),
        effect("detent-sawtooth", &[2.0, period, phase, 0.5]),
    ];
    for wave in waves {
        for (at, expected) in [(0.0, 0.0), (0.5 * PI, 2.0), (PI, 0.0), (1.5 * PI, -2.0)] {
            assert!((torque_mnm(&wave, period * (at - phase)) - expected).abs() < 1e-12);
        }
    }
}

#[test]
fn a_ramp_rises_between_two_angles_and_stays() {
    let ramp = effect("torque-ramp", &[-6.0, 0.5, 0.2]);
    for (angle, expected) in [(-9.0, 0.0), (0.5, 0.0), (0.55, -1.5), (0.6, -3.0), (0.7, -6.0), (50.0, -6.0)] {
        assert!((torque_mnm(&ramp, angle) - expected).abs() < 1e-12, "at {angle} rad");
    }
}
