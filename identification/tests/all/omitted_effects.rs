//! Machines that have more than inertia and friction: the intervals of a fit that leaves it out allow for it. The torque follows from the
//! motion by inverse dynamics.

use std::f64::consts::TAU;

use crate::common::{Capture, Uniform};
use identification::diagnosis::{DiagnoseOptions, Diagnosis, diagnose, diagnose_either_way};
use identification::{Fit, FitOptions, fit};

const RATE_HZ: f64 = 500.0;
const DURATION_S: f64 = 12.0;
const INERTIA: f64 = 0.35;
const COULOMB_MNM: f64 = 5.6;
const VISCOUS: f64 = 0.3;
const CAPTURES: u64 = 20;

/// Torque besides inertia and friction, mNm, of time, angle, velocity and acceleration.
type Besides = fn([f64; 4]) -> f64;

/// A multisine drawn at random, with lines between two frequencies.
fn captured(seed: u64, [low_hz, high_hz]: [f64; 2], torque_late_s: f64, besides: Besides) -> Capture {
    let mut random = Uniform(seed * 0x9e37_79b9_7f4a_7c15);
    let lines: Vec<[f64; 3]> = (0..6)
        .map(|line| {
            let hz = low_hz * (high_hz / low_hz).powf((f64::from(line) + random.next()) / 6.0);
            [TAU * hz, 0.5 / (1.0 + hz), TAU * random.next()]
        })
        .collect();
    let motion_at = |t_s: f64| {
        lines.iter().fold([0.0; 3], |[angle, velocity, acceleration], [turning, size, phase]| {
            let (sine, cosine) = (turning * t_s + phase).sin_cos();
            [angle + size * sine, velocity + size * turning * cosine, acceleration - size * turning * turning * sine]
        })
    };
    let torque_at = |t_s: f64| {
        let [angle, velocity, acceleration] = motion_at(t_s);
        INERTIA * acceleration
            + COULOMB_MNM * velocity.signum()
            + VISCOUS * velocity
            + besides([t_s, angle, velocity, acceleration])
    };
    let t_s: Vec<f64> = (0..(DURATION_S * RATE_HZ) as usize).map(|sample| sample as f64 / RATE_HZ).collect();
    let step_rad = TAU / f64::from(1 << 18);
    Capture {
        angle_rad: t_s.iter().map(|t_s| (motion_at(*t_s)[0] / step_rad).round() * step_rad).collect(),
        torque_mnm: t_s.iter().map(|t_s| torque_at(t_s - torque_late_s) + 0.1 * random.normal()).collect(),
        t_s,
        ..Capture::default()
    }
}

const SWEEP_HZ: [f64; 2] = [0.3, 4.0];

fn weight([_, angle, ..]: [f64; 4]) -> f64 {
    4.0 * (angle + 0.4).sin()
}

fn spring([_, angle, ..]: [f64; 4]) -> f64 {
    3.0 * angle
}

fn spring_that_rests_elsewhere([_, angle, ..]: [f64; 4]) -> f64 {
    3.0 * (angle - 0.4)
}

fn drifting_friction([t_s, _, velocity, _]: [f64; 4]) -> f64 {
    0.25 * COULOMB_MNM * (1.0 - t_s / DURATION_S) * velocity.signum()
}

fn slight_drift([t_s, _, velocity, _]: [f64; 4]) -> f64 {
    0.12 * COULOMB_MNM * (1.0 - t_s / DURATION_S) * velocity.signum()
}

fn rising_friction([_, _, velocity, _]: [f64; 4]) -> f64 {
    -0.5 * COULOMB_MNM * velocity.signum() * (-velocity.abs() / 0.8).exp()
}

fn eccentric_friction([_, angle, velocity, _]: [f64; 4]) -> f64 {
    0.4 * COULOMB_MNM * velocity.signum() * (angle + 0.7).cos()
}

fn friction_of_the_load([_, _, velocity, acceleration]: [f64; 4]) -> f64 {
    0.15 * (INERTIA * acceleration).abs() * velocity.signum()
}

fn nothing(_: [f64; 4]) -> f64 {
    0.0
}

fn fitted(capture: &Capture) -> Fit {
    fit(&capture.samples(), &FitOptions::default()).unwrap()
}

/// Whether an interval no wider than a multiple of the truth holds it.
fn holds(fit: &Fit, name: &str, truth: f64, widest: f64) -> bool {
    let interval = fit.parameters.get(name).unwrap().ci95;
    interval.is_some_and(|[low, high]| (low..=high).contains(&truth) && high - low < widest * truth)
}

#[test]
fn intervals_hold_the_inertia_whatever_the_model_lacks() {
    let cases: [(&str, f64, Besides, &str); 8] = [
        ("nothing", 0.0, nothing, ""),
        ("weight", 0.0, weight, "a weight or a spring"),
        ("spring", 0.0, spring, "a weight or a spring"),
        ("drifting friction", 0.0, drifting_friction, "friction that drifts"),
        ("rising friction", 0.0, rising_friction, "not linear in the speed"),
        ("eccentric friction", 0.0, eccentric_friction, "friction that differs over the angle"),
        ("friction of the load", 0.0, friction_of_the_load, "grows with the load"),
        ("late torque", 3.0 / RATE_HZ, nothing, "ms after the motion"),
    ];
    for (name, late_s, besides, words) in cases {
        let fits: Vec<Fit> = (1..=CAPTURES).map(|seed| fitted(&captured(seed, SWEEP_HZ, late_s, besides))).collect();
        let held = fits.iter().filter(|fit| holds(fit, "inertia", INERTIA, 0.8)).count();
        let remarked =
            |words: &str| fits.iter().filter(|fit| fit.notes.iter().any(|note| note.contains(words))).count();
        println!("{name}: {held} hold, {} remarked", remarked(words));
        // Of 20 intervals of 95 %, fewer than 16 hold the truth with a probability of 0.003.
        assert!(held >= 16, "{name}: {held} of {CAPTURES} hold the inertia");
        if words.is_empty() {
            assert_eq!(remarked("would explain"), 0, "{name}");
        } else {
            assert!(remarked(words) >= 16, "{name}: {:?}", fits[0].notes);
        }
    }
}

#[test]
fn a_weight_and_the_load_keep_the_friction_in_its_interval() {
    let cases: [(&str, Besides); 2] = [("weight", weight), ("load", friction_of_the_load)];
    for (name, besides) in cases {
        let fits = (1..=CAPTURES).map(|seed| fitted(&captured(seed, SWEEP_HZ, 0.0, besides)));
        let held = fits.filter(|fit| {
            holds(fit, "coulomb_negative", COULOMB_MNM, 4.0) && holds(fit, "coulomb_positive", COULOMB_MNM, 4.0)
        });
        let held = held.count();
        assert!(held >= 15, "{name}: {held} of {CAPTURES} hold both");
    }
}

#[test]
fn a_spring_keeps_the_friction_in_its_interval_wherever_it_rests() {
    for besides in [spring, spring_that_rests_elsewhere] {
        let fits: Vec<Fit> = (1..=CAPTURES).map(|seed| fitted(&captured(seed, SWEEP_HZ, 0.0, besides))).collect();
        let intervals: Vec<[f64; 2]> = fits
            .iter()
            .flat_map(|fit| ["coulomb_negative", "coulomb_positive"].map(|name| fit.parameters.get(name).unwrap().ci95))
            .flatten()
            .collect();
        let held = intervals.iter().filter(|[low, high]| (*low..=*high).contains(&COULOMB_MNM)).count();
        println!("{held} of {}", intervals.len());
        // What the motion leaves open may also be said not to be identifiable.
        assert!(intervals.len() >= 20 && held * 10 >= intervals.len() * 9, "{held} of {}", intervals.len());
    }
}

fn diagnosed(train: &Capture, heldout: &Capture) -> Diagnosis {
    diagnose_either_way(&train.samples(), Some(&heldout.samples()), &DiagnoseOptions::default()).unwrap()
}

#[test]
fn where_the_training_capture_tells_too_little_the_captures_are_exchanged() {
    // One sinusoid of 2 Hz: what a weight does there, inertia does too.
    let mut exchanged = 0;
    for seed in 1..=4 {
        let [train, heldout] =
            [(seed, [2.0, 2.0]), (seed + 100, SWEEP_HZ)].map(|(seed, band_hz)| captured(seed, band_hz, 0.0, weight));
        let found = diagnosed(&train, &heldout);
        assert_eq!(found.effects, ["mass-imbalance"], "seed {seed}: {}", found.summary);
        if !found.captures_are_exchanged {
            continue;
        }
        exchanged += 1;
        assert!(found.summary.contains("exchanged"), "{}", found.summary);
        assert_eq!(found.in_their_roles("given", Some("held out")), ("held out", Some("given")));
        let direct = diagnose(&heldout.samples(), Some(&train.samples()), &DiagnoseOptions::default()).unwrap();
        assert_eq!((found.heldout_rms_after, found.model), (direct.heldout_rms_after, direct.model));
    }
    assert!(exchanged >= 2, "{exchanged} of 4 exchanged");
}

#[test]
fn a_drift_of_which_only_the_beginning_shows_is_named() {
    for seed in 1..=4 {
        let [train, heldout] = [seed, seed + 100].map(|seed| captured(seed, SWEEP_HZ, 0.0, slight_drift));
        let found = diagnosed(&train, &heldout);
        assert_eq!(found.effects, ["friction-drift"], "seed {seed}: {}", found.summary);
        assert!(found.notes.iter().any(|note| note.contains("a straight line")), "{:?}", found.notes);
    }
}

#[test]
fn values_that_the_training_capture_leaves_open_are_no_further_effect() {
    for seed in 1..=4 {
        let [train, heldout] =
            [(seed, [4.0, 8.0]), (seed + 100, SWEEP_HZ)].map(|(seed, band_hz)| captured(seed, band_hz, 0.0, weight));
        let found = diagnosed(&train, &heldout);
        assert_eq!(found.effects, ["mass-imbalance"], "seed {seed}: {}", found.summary);
    }
}
