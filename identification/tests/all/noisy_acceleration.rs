//! A noisy accelerometer beside a good encoder, and the paper's own preparation.

use crate::common::{Capture, Uniform, ideal, knob, sweep};
use dynamics::Motion;
use identification::{FitOptions, PreparationMethod, fit};

const KNOB: [f64; 8] = [0.3, 3.0, 4.0, 0.5, 0.6, 0.0, 0.05, 0.3];
/// RMS of the noise on the acceleration column, rad/s².
const NOISE_RAD_S2: f64 = 400.0;

/// A capture whose acceleration column is noisy and whose encoder has steps of 9.8 µrad.
fn capture(seed: u64) -> Capture {
    let mut random = Uniform(seed);
    let mut capture = ideal(&knob(&KNOB), sweep("linear-chirp"), 0.3, &mut random);
    capture.velocity_rad_s = None;
    capture.angle_rad.iter_mut().for_each(|angle| *angle = (*angle / 9.8e-6).round() * 9.8e-6);
    let half_width = NOISE_RAD_S2 * 3_f64.sqrt();
    for value in capture.acceleration_rad_s2.as_mut().unwrap() {
        *value += half_width * (2.0 * random.next() - 1.0);
    }
    capture
}

#[test]
fn a_noisy_accelerometer_does_not_draw_the_inertia_where_the_encoder_is_quieter() {
    const SEEDS: u64 = 20;
    let options = FitOptions { without_detents: true, ..FitOptions::default() };
    let error = |seed: u64| {
        let fit = fit(&capture(0x9e37_79b9 * seed).samples(), &options).unwrap();
        fit.parameters.get("inertia").unwrap().value.unwrap() / KNOB[0] - 1.0
    };
    let mean_error = (1..=SEEDS).map(error).sum::<f64>() / 20.0;
    assert!(mean_error.abs() < 1e-3, "the inertia is off by {mean_error}");
}

#[test]
fn the_papers_preparation_comes_near_the_parameters() {
    let mut values = KNOB;
    (values[5], values[6]) = (5.0, 0.08);
    let motion = |time_s: f64| -> Motion { sweep("linear-chirp")(time_s) };
    let capture = ideal(&knob(&values), motion, 0.3, &mut Uniform(11));
    let options = FitOptions { preparation: PreparationMethod::Paper, ..FitOptions::default() };
    let fit = fit(&capture.samples(), &options).unwrap();
    for (name, index, tolerance) in [
        ("inertia", 0, 0.01),
        ("coulomb_positive", 2, 0.05),
        ("detent_amplitude", 5, 0.05),
        ("detent_period", 6, 0.001),
    ] {
        let value = fit.parameters.get(name).unwrap().value.unwrap();
        assert!((value / values[index] - 1.0).abs() < tolerance, "{name} is {value}");
    }
}
