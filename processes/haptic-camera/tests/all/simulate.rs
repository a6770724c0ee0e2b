//! `simulate` on tables whose motion is known by formula.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::Path;

const SAMPLE_S: f64 = 1e-3;
const SAMPLES: usize = 4_000;

const BASE: &str = "name = \"knob\"\n[[effects]]\neffect = \"inertia\"\ninertia = 0.05\n\
    [[effects]]\neffect = \"friction\"\ncoulomb_negative = 4.0\ncoulomb_positive = 4.0\n\
    viscous_negative = 0.2\nviscous_positive = 0.2\n";

/// Angle, velocity and acceleration of a sine that starts at rest at its lower end.
fn motion(time_s: f64) -> (f64, f64, f64) {
    let omega = TAU * 1.5;
    let (sine, cosine) = (omega * time_s).sin_cos();
    (-0.8 * cosine, 0.8 * omega * sine, 0.8 * omega * omega * cosine)
}

/// Simulates the model along a capture of [`motion`] and [`rigid_mnm`]; gives what is said on standard output.
fn simulated(folder: &Path, model: &str, more: &str) -> String {
    let mut like = "t_s,angle_rad,velocity_rad_s,acceleration_rad_s2,torque_mnm\n".to_owned();
    for index in 0..SAMPLES {
        let time_s = index as f64 * SAMPLE_S;
        let (angle_rad, velocity_rad_s, acceleration_rad_s2) = motion(time_s);
        let torque_mnm = rigid_mnm(time_s);
        writeln!(like, "{time_s},{angle_rad},{velocity_rad_s},{acceleration_rad_s2},{torque_mnm}").unwrap();
    }
    std::fs::write(folder.join("like.csv"), like).unwrap();
    std::fs::write(folder.join("model.toml"), model).unwrap();
    crate::program::done(folder, &format!("simulate model.toml --like like.csv {more}"))
}

/// The torque column that `simulate` writes for the model along [`motion`].
fn simulated_mnm(folder: &Path, model: &str) -> Vec<f64> {
    simulated(folder, model, "--out out.csv");
    let table = std::fs::read_to_string(folder.join("out.csv")).unwrap();
    let mut lines = table.lines();
    let column = lines.next().unwrap().split(',').position(|name| name == "torque_mnm").unwrap();
    lines.map(|line| line.split(',').nth(column).unwrap().parse().unwrap()).collect()
}

/// Largest difference, mNm, between the torque written and what is expected of the time `delay_s` before, some
/// milliseconds around every reversal left out: there the two may disagree on which sample is the first to turn back.
fn worst_mnm(written: &[f64], delay_s: f64, expected: impl Fn(f64) -> f64) -> f64 {
    assert_eq!(written.len(), SAMPLES);
    let each = written.iter().enumerate().skip(20).map(|(index, torque)| {
        let time_s = index as f64 * SAMPLE_S - delay_s;
        if motion(time_s).1.abs() < 0.3 { 0.0 } else { (torque - expected(time_s)).abs() }
    });
    each.fold(0.0, f64::max)
}

fn rigid_mnm(time_s: f64) -> f64 {
    let (_, velocity, acceleration) = motion(time_s);
    0.05 * acceleration + 4.0 * velocity.signum() + 0.2 * velocity
}

#[test]
fn the_torque_of_equation_1_is_as_before() {
    let folder = tempfile::tempdir().unwrap();
    let written = simulated_mnm(folder.path(), BASE);
    let worst = worst_mnm(&written, 0.0, rigid_mnm);
    assert!(worst < 0.02, "{worst}");
    // At a reversal friction goes through zero.
    assert!(written[0].abs() < 0.05 * 0.8 * (TAU * 1.5).powi(2) + 0.1, "{}", written[0]);
}

#[test]
fn what_the_sensor_misreads_is_in_the_simulated_torque() {
    let folder = tempfile::tempdir().unwrap();
    let model = format!(
        "{BASE}[[effects]]\neffect = \"torque-offset\"\ntorque_offset = 1.5\n\
         [[effects]]\neffect = \"mains-hum\"\nhum_torque = 0.7\nhum_frequency = 50.0\nhum_phase = 0.4\n\
         [[effects]]\neffect = \"sensor-delay\"\nsensor_delay = 0.0043\n"
    );
    let written = simulated_mnm(folder.path(), &model);
    let expected = |time_s: f64| rigid_mnm(time_s) + 1.5 + 0.7 * (TAU * 50.0 * time_s + 0.4).sin();
    let worst = worst_mnm(&written, 0.0043, expected);
    assert!(worst < 0.02, "{worst}");
}

#[test]
fn friction_with_bristles_builds_up_after_every_reversal() {
    let folder = tempfile::tempdir().unwrap();
    let model = format!(
        "{BASE}[[effects]]\neffect = \"presliding-hysteresis\"\nbristle_deflection = 0.1\nbristle_damping = 0.0\n"
    );
    let written = simulated_mnm(folder.path(), &model);
    // Deflection from the law dz/dθ = (1 − z·sign)/z₀, by the path since the last reversal; the first starts unbent.
    let expected = |time_s: f64| {
        let (angle, velocity, _) = motion(time_s);
        let (side, mut bent, half_turn) = (velocity.signum(), 0.0, (time_s * 3.0).floor());
        let settled = (-1.6_f64 / 0.1).exp();
        for turn in 0..=(half_turn as u32) {
            let slipping = if turn % 2 == 0 { 1.0 } else { -1.0 };
            let passed = if f64::from(turn) < half_turn { settled } else { (-(angle + 0.8 * side).abs() / 0.1).exp() };
            bent = slipping + (bent - slipping) * passed;
        }
        rigid_mnm(time_s) - 4.0 * side + 4.0 * bent
    };
    let worst = worst_mnm(&written, 0.0, expected);
    assert!(worst < 0.05, "{worst}");
}

#[test]
fn a_knob_behind_a_shaft_is_simulated_with_its_own_motion() {
    let folder = tempfile::tempdir().unwrap();
    // So soft that the shaft twists visibly, so damped that what its end starts with is soon forgotten.
    let model = "name = \"soft\"\n[[effects]]\neffect = \"inertia\"\ninertia = 0.05\n\
        [[effects]]\neffect = \"shaft-compliance\"\nshaft_stiffness = 60.0\nshaft_damping = 1.0\n";
    let written = simulated_mnm(folder.path(), model);
    // Steady state of M·θ̈ᵢ = K·x + D·ẋ, x = θ − θᵢ, for θ = −0.8·cos ωt, as complex amplitudes.
    let omega = TAU * 1.5;
    let inertial = -0.05 * omega * omega;
    let (real, imaginary) = (60.0, omega);
    // τ = s·m/(m + s)·θ with m = −M·ω² and s = K + iωD.
    let (bottom_real, bottom_imaginary) = (inertial + real, imaginary);
    let size = bottom_real * bottom_real + bottom_imaginary * bottom_imaginary;
    let ratio_real = inertial * (real * bottom_real + imaginary * bottom_imaginary) / size;
    let ratio_imaginary = inertial * (imaginary * bottom_real - real * bottom_imaginary) / size;
    let steady = |time_s: f64| {
        let (sine, cosine) = (omega * time_s).sin_cos();
        -0.8 * (ratio_real * cosine - ratio_imaginary * sine)
    };
    let late = |index: usize| index as f64 * SAMPLE_S;
    let worst = (2_000..SAMPLES - 50).map(|index| (written[index] - steady(late(index))).abs()).fold(0.0, f64::max);
    assert!(worst < 0.01, "{worst}");
}

#[test]
fn a_models_relative_error_on_a_capture_is_reported_without_writing_anything() {
    let folder = tempfile::tempdir().unwrap();
    let error_percent = |model: &str| -> f64 {
        let said = simulated(folder.path(), model, "");
        let number = said.split("relative error ").nth(1).and_then(|rest| rest.split(' ').next());
        number.and_then(|number| number.parse().ok()).unwrap_or_else(|| panic!("no relative error in {said}"))
    };
    // Friction goes through zero at rest and not from one sample to the next: hence not quite nothing.
    assert!(error_percent(BASE) < 3.0);
    let inertia_alone = "name = \"half\"\n[[effects]]\neffect = \"inertia\"\ninertia = 0.05\n";
    let torques = (0..SAMPLES).map(|index| index as f64 * SAMPLE_S);
    let (left, all) = torques.fold((0.0, 0.0), |(left, all), time_s| {
        let (torque, friction) = (rigid_mnm(time_s), rigid_mnm(time_s) - 0.05 * motion(time_s).2);
        (left + friction * friction, all + torque * torque)
    });
    let expected: f64 = 100.0 * f64::sqrt(left / all);
    let found = error_percent(inertia_alone);
    assert!((found - expected).abs() < 0.05, "{found} % for {expected} %");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
}

#[test]
fn a_capture_is_simulated_into_a_table_whatever_the_case_of_its_ending() {
    let folder = tempfile::tempdir().unwrap();
    simulated(folder.path(), BASE, "--out OUT.CSV");
    let table = std::fs::read_to_string(folder.path().join("OUT.CSV")).unwrap();
    assert!(table.starts_with("t_s,angle_rad,"), "{}", &table[..40]);
}
