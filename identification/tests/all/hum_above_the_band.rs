//! A mains hum that lies above the band in which models are compared.

use std::f64::consts::TAU;

use crate::common::{Capture, Uniform};
use identification::diagnosis::{DiagnoseOptions, Diagnosis, diagnose};

/// A knob with friction that is turned by hand, at 250 Hz with an encoder of 14 bits: the band ends at 25 Hz at most. The hum is on the torque
/// sensor.
fn turned(hum_mnm: f64, hum_hz: f64, slow_hz: f64, seed: u64) -> Capture {
    let mut random = Uniform(seed * 0x9e37_79b9_7f4a_7c15);
    let hum_phase_rad = TAU * random.next();
    let tones = [(slow_hz, 1.0), (2.3 * slow_hz, 0.3), (3.7 * slow_hz, 0.15)]
        .map(|(hertz, rad)| (TAU * hertz, rad, TAU * random.next()));
    let mut capture = Capture::default();
    for index in 0..3000 {
        let time_s = f64::from(index) / 250.0;
        let [mut angle, mut velocity, mut acceleration] = [0.0; 3];
        for (rad_s, rad, phase_rad) in tones {
            let (sine, cosine) = (rad_s * time_s + phase_rad).sin_cos();
            angle += rad * sine;
            velocity += rad * rad_s * cosine;
            acceleration -= rad * rad_s * rad_s * sine;
        }
        let hum = hum_mnm * (TAU * hum_hz * time_s + hum_phase_rad).sin();
        capture.t_s.push(time_s);
        capture.angle_rad.push((angle * 16384.0 / TAU).round() * TAU / 16384.0);
        capture
            .torque_mnm
            .push(0.2 * acceleration + 5.0 * velocity.signum() + 0.1 * velocity + hum + 0.1 * random.normal());
    }
    capture
}

fn diagnosed(hum_mnm: f64, hum_hz: f64, seed: u64) -> Diagnosis {
    let [train, heldout] =
        [0.5, 0.7].map(|slow_hz| turned(hum_mnm, hum_hz, slow_hz, seed + if slow_hz > 0.6 { 1000 } else { 0 }));
    diagnose(&train.samples(), Some(&heldout.samples()), &DiagnoseOptions::default()).unwrap()
}

#[test]
fn it_is_found_and_measured_at_its_own_frequency() {
    let (mut held, mut told) = (0, 0);
    for seed in 1..=12 {
        let hum_hz = [50.07, 59.95][usize::try_from(seed % 2).unwrap()];
        let found = diagnosed(1.0, hum_hz, seed);
        assert!(found.band_hz < 50.0);
        // Not where a coupling was found, whose inner body is not followed at such frequencies.
        let Some(step) = found.steps.iter().find(|step| step.effect == "mains-hum") else { continue };
        assert!(found.model.effect("mains-hum").is_some());
        for (name, truth) in [("hum_frequency", hum_hz), ("hum_torque", 1.0)] {
            let [low, high] = step.parameters[name].ci95.unwrap();
            told += 1;
            held += i32::from((low..=high).contains(&truth));
        }
    }
    assert!(told >= 20, "found in {} of 12", told / 2);
    assert!(held >= told - 3, "{held} of {told} intervals hold the truth");
}

#[test]
fn it_is_not_found_where_there_is_none_or_it_is_something_else() {
    let mut false_alarms = 0;
    for seed in 21..=32 {
        // Nothing, and a line of a motor, say.
        for (hum_mnm, hum_hz) in [(0.0, 50.0), (1.0, 44.0)] {
            let found = diagnosed(hum_mnm, hum_hz, seed);
            assert!(!found.effects.contains(&"mains-hum"), "seed {seed}, {hum_mnm} mNm");
            false_alarms += i32::from(!found.effects.is_empty());
        }
    }
    assert!(false_alarms <= 1, "{false_alarms} of 24");
}
