//! Motion predicted from torque, effect by effect, against a knob simulated by other means.

use dynamics::simulate::{ForwardErrors, RigMotor, forward_windows, forward_windows_from_command};
use dynamics::{Model, Motion};

use crate::plant::{self, Knob, Link};

const SAMPLE_S: f64 = 1e-4;
const SAMPLES: usize = 15_000;
const WINDOW_S: f64 = 0.1;
/// The paper's encoder: what lies below it no capture shows.
const ENCODER_STEP_RAD: f64 = 9.8e-6;

/// Inertia and friction, with further effects.
fn model(effects: &[(&str, &[f64])]) -> Model {
    let base: [(&str, &[f64]); 2] = [("inertia", &[0.05]), ("friction", &[4.0, 4.0, 0.6, 0.6])];
    crate::model(&base.iter().chain(effects).copied().collect::<Vec<_>>())
}

/// Three sinusoids that start at zero: they turn the knob to and fro over a radian or two, and let it rest in between.
fn torque_mnm(time_s: f64) -> f64 {
    let sine = |amplitude: f64, hertz: f64| amplitude * (std::f64::consts::TAU * hertz * time_s).sin();
    sine(9.0, 1.3) + sine(6.0, 7.1) + sine(2.0, 31.0)
}

fn polygon() -> Vec<f64> {
    (0..SAMPLES).map(|index| torque_mnm(index as f64 * SAMPLE_S)).collect()
}

fn motions(course: &[(f64, f64)]) -> Vec<Motion> {
    let motion = |(index, (angle_rad, velocity_rad_s)): (usize, &(f64, f64))| Motion {
        time_s: index as f64 * SAMPLE_S,
        angle_rad: *angle_rad,
        velocity_rad_s: *velocity_rad_s,
        acceleration_rad_s2: 0.0,
    };
    course.iter().enumerate().map(motion).collect()
}

fn errors(model: &Model, motions: &[Motion], readings: &[f64]) -> ForwardErrors {
    forward_windows(model, motions, readings, WINDOW_S).unwrap()
}

type Case = (&'static str, &'static [f64], Knob);

fn cases() -> Vec<Case> {
    let knob = Knob::default;
    vec![
        ("detent", &[5.0, 0.1, 0.4], Knob { place: |x, _| 5.0 * (x / 0.1 + 0.4).sin(), ..knob() }),
        (
            "detent-harmonics",
            &[0.1, 2.0, 0.0, 0.0, 1.5],
            Knob { place: |x, _| 2.0 * (2.0 * x / 0.1).sin() + 1.5 * (3.0 * x / 0.1).cos(), ..knob() },
        ),
        (
            "detent-triangle",
            &[5.0, 0.1, 0.4],
            Knob { place: |x, _| 5.0 * std::f64::consts::FRAC_2_PI * (x / 0.1 + 0.4).sin().asin(), ..knob() },
        ),
        (
            "detent-sawtooth",
            &[5.0, 0.1, 0.4, 0.75],
            Knob {
                place: |x, _| {
                    // Turns since the start of the rise, which takes three quarters.
                    let turns = ((x / 0.1 + 0.4) / std::f64::consts::TAU + 0.375).rem_euclid(1.0);
                    if turns < 0.75 { 5.0 * (turns / 0.375 - 1.0) } else { 5.0 * (7.0 - 8.0 * turns) }
                },
                ..knob()
            },
        ),
        ("torque-ramp", &[6.0, -0.05, 0.1], Knob { place: |x, _| 60.0 * (x.clamp(-0.05, 0.05) + 0.05), ..knob() }),
        ("cogging", &[3.0, 7.0, 0.4], Knob { place: |x, _| 3.0 * (7.0 * x + 0.4).sin(), ..knob() }),
        ("mass-imbalance", &[3.0, 0.5], Knob { place: |x, _| 3.0 * (x + 0.5).sin(), ..knob() }),
        ("return-spring", &[6.0, 0.2], Knob { place: |x, _| 6.0 * (x - 0.2), ..knob() }),
        (
            "end-stop",
            &[-0.1, 0.2, 300.0, 400.0, 0.8],
            Knob {
                place: |x, v| {
                    if x > 0.2 {
                        (400.0 * (x - 0.2) + 0.8 * v).max(0.0)
                    } else if x < -0.1 {
                        (300.0 * (x + 0.1) + 0.8 * v).min(0.0)
                    } else {
                        0.0
                    }
                },
                ..knob()
            },
        ),
        ("quadratic-drag", &[0.1], Knob { place: |_, v| 0.1 * v * v.abs(), ..knob() }),
        (
            "stribeck",
            &[3.0, 0.8, 1.2],
            Knob { coulomb_factor: |_, v, _| 1.0 + 0.75 * (-(v.abs() / 0.8).powf(1.2)).exp(), ..knob() },
        ),
        (
            "friction-eccentricity",
            &[0.4, 0.3],
            Knob { coulomb_factor: |x, _, _| 1.0 + 0.4 * (x + 0.3).cos(), ..knob() },
        ),
        (
            "friction-drift",
            &[0.5, 0.7],
            Knob {
                coulomb_factor: |_, _, t| 1.0 + 0.5 * (-t / 0.7).exp(),
                viscous_factor: |t| 1.0 + 0.5 * (-t / 0.7).exp(),
                ..knob()
            },
        ),
        ("karnopp-stick", &[12.0, 12.0, 0.05], Knob { stick: Some((12.0, 0.05)), ..knob() }),
        ("presliding-hysteresis", &[0.03, 0.02], Knob { bristles: Some((0.03, 0.02)), ..knob() }),
        ("shaft-compliance", &[800.0, 0.3], Knob { link: Link::Shaft(800.0, 0.3), ..knob() }),
        ("shaft-compliance", &[800.0, 0.3, 0.4], Knob { link: Link::Cap(0.0, 0.02, 800.0, 0.3), ..knob() }),
        ("backlash", &[0.02, 0.6, 4000.0, 5.0], Knob { link: Link::Cap(0.02, 0.02, 4000.0, 5.0), ..knob() }),
    ]
}

#[test]
#[allow(clippy::print_stdout, reason = "the figures, for --nocapture")]
fn the_true_model_predicts_the_motion_and_one_without_the_effect_does_not() {
    let torque_mnm = polygon();
    for (name, values, knob) in cases() {
        let measured = motions(&plant::run(&knob, SAMPLE_S, &torque_mnm, 200));
        let with = errors(&model(&[(name, values)]), &measured, &torque_mnm);
        let without = errors(&model(&[]), &measured, &torque_mnm);
        assert_eq!(with.windows.len(), 15, "{name}");
        let (right, wrong) = (with.angle_rms_rad, without.angle_rms_rad);
        println!("{name}: {right:.2e} rad, without it {wrong:.2e} rad");
        assert!(right < ENCODER_STEP_RAD, "{name}: {right:.2e} rad");
        assert!(wrong > 1000.0 * right, "{name}: {right:.2e} rad, without it {wrong:.2e} rad");
        let (right, wrong) = (with.velocity_rms_rad_s, without.velocity_rms_rad_s);
        assert!(wrong > 1000.0 * right, "{name}: {right:.2e} rad/s, without it {wrong:.2e} rad/s");
    }
}

/// The motions as an encoder tells them: angles in its steps, velocities with a noise of up to `noise_rad_s`.
fn measured(motions: &[Motion], noise_rad_s: f64, seed: u64) -> Vec<Motion> {
    let mut state = seed;
    let mut noise = || {
        // Marsaglia's xorshift.
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        noise_rad_s * (2.0 * (state as f64 / u64::MAX as f64) - 1.0)
    };
    let each = |motion: &Motion| Motion {
        angle_rad: (motion.angle_rad / ENCODER_STEP_RAD).round() * ENCODER_STEP_RAD,
        velocity_rad_s: motion.velocity_rad_s + noise(),
        ..*motion
    };
    motions.iter().map(each).collect()
}

#[test]
#[allow(clippy::print_stdout, reason = "the figures, for --nocapture")]
fn an_effect_shows_through_the_steps_and_the_noise_of_an_encoder() {
    let torque_mnm = polygon();
    for (name, values, knob) in cases() {
        let exact = motions(&plant::run(&knob, SAMPLE_S, &torque_mnm, 50));
        for seed in [1, 0x9E37_79B9_7F4A_7C15, 0xDEAD_BEEF] {
            let measured = measured(&exact, 0.02, seed);
            let with = errors(&model(&[(name, values)]), &measured, &torque_mnm).angle_rms_rad;
            let without = errors(&model(&[]), &measured, &torque_mnm).angle_rms_rad;
            println!("{name}: {with:.2e} rad, without it {without:.2e} rad");
            assert!(without > 10.0 * with, "{name}: {with:.2e} rad, without it {without:.2e} rad");
        }
    }
}

#[test]
fn what_the_sensor_misreads_is_taken_off_before_the_motion_is_predicted() {
    let torque = polygon();
    let measured = motions(&plant::run(&Knob::default(), SAMPLE_S, &torque, 100));
    let (delay_s, offset_mnm) = (1.23e-3, 1.5);
    let hum = |time_s: f64| 2.0 * (std::f64::consts::TAU * 50.3 * time_s + 0.3).sin();
    let read =
        |reading: &dyn Fn(f64) -> f64| -> Vec<f64> { measured.iter().map(|motion| reading(motion.time_s)).collect() };
    let cases: [(&str, &[f64], Vec<f64>); 3] = [
        ("torque-offset", &[1.5], read(&|time_s| torque_mnm(time_s) + offset_mnm)),
        ("mains-hum", &[2.0, 50.3, 0.3], read(&|time_s| torque_mnm(time_s) + hum(time_s))),
        ("sensor-delay", &[delay_s], read(&|time_s| torque_mnm((time_s - delay_s).max(0.0)))),
    ];
    for (name, values, readings_mnm) in cases {
        let with = errors(&model(&[(name, values)]), &measured, &readings_mnm);
        let without = errors(&model(&[]), &measured, &readings_mnm);
        let (right, wrong) = (with.angle_rms_rad, without.angle_rms_rad);
        assert!(right < ENCODER_STEP_RAD && wrong > 1000.0 * right, "{name}: {right:.2e} and {wrong:.2e} rad");
    }
}

#[test]
fn a_gap_in_the_capture_starts_a_new_window() {
    let torque_mnm = polygon();
    let measured = motions(&plant::run(&Knob::default(), SAMPLE_S, &torque_mnm, 100));
    let kept = |index: &usize| !(4_300..4_700).contains(index);
    let (measured, torque_mnm): (Vec<_>, Vec<_>) =
        (0..SAMPLES).filter(kept).map(|index| (measured[index], torque_mnm[index])).unzip();
    let errors = errors(&model(&[]), &measured, &torque_mnm);
    assert!(errors.angle_rms_rad < ENCODER_STEP_RAD, "{:.2e} rad", errors.angle_rms_rad);
    let starts: Vec<f64> = errors.windows.iter().map(|window| window.start_s).collect();
    assert!((starts[4] - 0.4).abs() < 1e-9 && (starts[5] - 0.47).abs() < 1e-9, "{starts:?}");
    assert_eq!(errors.windows[4].samples, 299);
}

#[test]
fn a_capture_of_nothing_has_no_windows() {
    let none = errors(&model(&[]), &[], &[]);
    assert_eq!(none, ForwardErrors::default());
}

#[test]
#[allow(clippy::print_stdout, reason = "the figures, for --nocapture")]
fn the_motion_follows_from_the_command_once_the_motor_is_known() {
    let motor = RigMotor { inertia: 0.02, coulomb_mnm: 1.5, viscous: 0.2 };
    // Plant and motor turn as one: the plant is given the sum, the model only the knob's part.
    let knob = Knob { place: |x, _| 5.0 * (x / 0.1 + 0.4).sin(), ..Knob::default() };
    let alone = crate::model(&[("inertia", &[0.03]), ("friction", &[2.5, 2.5, 0.4, 0.4])]);
    let with_detent =
        crate::model(&[("inertia", &[0.03]), ("friction", &[2.5, 2.5, 0.4, 0.4]), ("detent", &[5.0, 0.1, 0.4])]);
    // Commands are held; the plant takes straight lines, so each command is given as the steps' two ends.
    let commands = polygon();
    let fine = 20;
    let held: Vec<f64> = commands.iter().flat_map(|command| std::iter::repeat_n(*command, fine)).collect();
    let course = plant::run(&knob, SAMPLE_S / fine as f64, &held, 10);
    let measured = motions(&course.into_iter().step_by(fine).collect::<Vec<_>>());
    let error = |model: &Model, motor: &RigMotor| {
        forward_windows_from_command(model, motor, &measured, &commands, WINDOW_S).unwrap().angle_rms_rad
    };
    let right = error(&with_detent, &motor);
    for (what, wrong) in [
        ("without the detents", error(&alone, &motor)),
        ("without the motor's friction", error(&with_detent, &RigMotor { coulomb_mnm: 0.0, viscous: 0.0, ..motor })),
        ("without the motor's inertia", error(&with_detent, &RigMotor { inertia: 0.0, ..motor })),
    ] {
        println!("{right:.2e} rad, {what} {wrong:.2e} rad");
        assert!(wrong > 20.0 * right, "{what}: {right:.2e} and {wrong:.2e} rad");
    }
}

#[test]
fn where_a_command_is_unknown_no_window_goes_on() {
    let mut commands = polygon();
    let measured = motions(&plant::run(&Knob::default(), SAMPLE_S, &commands, 50));
    commands[4_300] = f64::NAN;
    let motor = RigMotor::default();
    let errors = forward_windows_from_command(&model(&[]), &motor, &measured, &commands, WINDOW_S).unwrap();
    assert!(errors.angle_rms_rad.is_finite());
    assert_eq!(errors.windows[4].samples, 299);
    assert!((errors.windows[5].start_s - 0.4301).abs() < 1e-9);
}
