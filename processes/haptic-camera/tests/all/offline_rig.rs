//! Commands that turn the rig by themselves, on the simulated rig offline: no clock, no other process.

use std::path::Path;

use crate::program::{done, json, refused};

/// The only archive whose folder's name holds `purpose`.
fn archive(folder: &Path, purpose: &str) -> String {
    let runs = std::fs::read_dir(folder.join("captures")).unwrap().flatten().map(|entry| entry.path());
    let run = runs.into_iter().find(|path| path.to_string_lossy().contains(purpose)).unwrap();
    let files = std::fs::read_dir(run).unwrap().flatten().map(|entry| entry.path());
    files.into_iter().next().unwrap().display().to_string()
}

#[test]
fn a_rig_is_calibrated_step_by_step_and_the_next_run_carries_the_calibration() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    // What the simulated rig is made of; the file begins with other values.
    let truth = [
        ("torque_zero_mnm", 0.6, 0.01),
        ("acceleration_zero_rad_s2", 6.3, 0.2),
        ("gravity_amplitude_rad_s2", 490.5, 0.1),
        ("gravity_phase_rad", 0.7, 1e-3),
        ("torque_delay_s", 112.54e-6, 15e-6),
        ("acceleration_delay_s", 318.31e-6, 2e-6),
        ("command_delay_s", 53.05e-6, 15e-6),
        ("gripper_inertia", 0.004, 2e-5),
        ("motor_inertia", 0.0159, 3e-4),
        ("motor_coulomb_mnm", 3.0, 0.1),
        ("motor_viscous", 1.31e-3, 2e-3),
    ];
    let mut first: toml::Table = "torque_sensor_stiffness_mnm_rad = 5e5\nangle_step_rad = 9.8e-6\n\
         torque_step_mnm = 0.18\nacceleration_step_rad_s2 = 2.8\n"
        .parse()
        .unwrap();
    for (quantity, value, _) in truth {
        first.insert(quantity.to_owned(), toml::Value::Float(0.9 * value));
    }
    std::fs::write(folder.join("rig.toml"), first.to_string()).unwrap();
    for what in ["gravity", "latency", "gravity", "zero", "gripper", "friction"] {
        done(folder, &format!("calibrate {what} --offline --calibration rig.toml --out rig.toml"));
    }
    let text = std::fs::read_to_string(folder.join("rig.toml")).unwrap();
    let found: toml::Table = text.parse().unwrap();
    for (quantity, value, tolerance) in truth {
        let estimate = found[quantity].as_float().unwrap();
        assert!((estimate - value).abs() < tolerance, "{quantity} is {estimate}, in truth {value}");
        let comments = text.lines().filter(|line| line.starts_with(&format!("# {quantity}:"))).count();
        assert_eq!(comments, 1, "{quantity} says where it is from, once:\n{text}");
    }

    done(folder, "rig-test --offline --calibration rig.toml");
    let capture = archive::Capture::load(&folder.join(archive(folder, "rig-test-free-30"))).unwrap();
    let carried: toml::Table = capture.attached_text("calibration.toml").unwrap().parse().unwrap();
    assert_eq!(carried["torque_zero_mnm"], found["torque_zero_mnm"]);
}

#[test]
fn a_calibration_takes_captures_that_were_made_before() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    done(folder, "calibrate zero --offline --out first.toml");
    let capture = archive(folder, "calibrate-zeros");
    let said = done(folder, &format!("calibrate zero {capture} {capture} --out second.toml"));
    assert!(said.contains("torque_zero_mnm"), "{said}");
    let zero = |file: &str| {
        let table: toml::Table = std::fs::read_to_string(folder.join(file)).unwrap().parse().unwrap();
        table["torque_zero_mnm"].as_float().unwrap()
    };
    assert!((zero("first.toml") - zero("second.toml")).abs() < 1e-9);

    let message = refused(folder, &format!("calibrate gravity {capture} --out third.toml"));
    assert!(message.contains("slow-turn") || message.contains("did not move"), "{message}");
    assert!(!folder.join("third.toml").exists());
}

#[test]
fn the_rig_test_has_the_papers_table_3_beside_this_rigs_figures() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let said = done(folder, "rig-test --offline --json test.json");
    for expected in ["position", "velocity", "acceleration", "torque", "0.0032", "lag at 30 Hz"] {
        assert!(said.contains(expected), "'{expected}' is missing in\n{said}");
    }
    let test = json(&folder.join("test.json"));
    let differences = test["differences"].as_array().unwrap();
    assert_eq!(differences.len(), 4);
    assert!(differences[0]["sd"].as_f64().unwrap() < 0.0032, "the servo follows as closely as the paper's");
    for lag in test["lag_at_30_hz"].as_array().unwrap() {
        assert!(lag["phase_rad"].as_f64().unwrap().abs() < 0.5, "{lag}");
    }
}

#[test]
fn bad_input_gets_one_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("broken.toml"), "torque_zero_mnm = \"much\"\n").unwrap();
    std::fs::write(folder.join("table.csv"), "t_s,angle_rad,torque_mnm\n0,0,0\n1,0,0\n2,0,0\n").unwrap();
    let negative = "gripper_inertia = 0.004\nmotor_inertia = -1.0\ntorque_sensor_stiffness_mnm_rad = 5e5\n\
        torque_zero_mnm = 0.6\ntorque_delay_s = 0.0\nacceleration_zero_rad_s2 = 0.0\nacceleration_delay_s = 0.0\n\
        gravity_amplitude_rad_s2 = 0.0\ngravity_phase_rad = 0.0\nangle_step_rad = 0.0\ntorque_step_mnm = 0.0\n\
        acceleration_step_rad_s2 = 0.0\n";
    std::fs::write(folder.join("negative.toml"), negative).unwrap();
    let cases = [
        ("rig-test --offline --calibration negative.toml", "motor_inertia of -1"),
        ("calibrate zero --offline --calibration absent.toml --out rig.toml", "absent.toml"),
        ("calibrate zero --offline --calibration broken.toml --out rig.toml", "broken.toml"),
        ("calibrate zero table.csv --out rig.toml", "--calibration"),
        ("calibrate zero absent.mcap --out rig.toml", "absent.mcap"),
        ("rig-test --offline --sweep waltz", "waltz"),
        ("check table.csv", "3 samples"),
    ];
    for (arguments, expected) in cases {
        let message = refused(folder, arguments);
        assert!(message.contains(expected), "{arguments}: {message}");
    }
}
