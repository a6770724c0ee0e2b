//! A calibration is checked where it is read, for whoever reads it.
#![allow(clippy::unwrap_used, reason = "tests")]

use dynamics::Calibration;

const SOUND: &str = "gripper_inertia = 0.0077\nmotor_inertia = 0.055\ntorque_sensor_stiffness_mnm_rad = 100000\n\
    torque_zero_mnm = 0.1\ntorque_delay_s = 1e-4\nacceleration_zero_rad_s2 = 0.5\nacceleration_delay_s = 2e-4\n\
    gravity_amplitude_rad_s2 = 120\ngravity_phase_rad = 1\nangle_step_rad = 1e-6\ntorque_step_mnm = 0.01\n\
    acceleration_step_rad_s2 = 0.1\nmotor_coulomb_mnm = 3\nmotor_viscous = 0.01\ncommand_delay_s = 1e-4\n";

#[test]
fn no_value_that_is_not_finite_or_far_beyond_a_rig_is_taken() {
    Calibration::from_toml(SOUND).unwrap();
    let keys: Vec<&str> = SOUND.lines().filter_map(|line| line.split(" = ").next()).collect();
    for key in keys {
        for value in ["nan", "inf", "-inf", "1.7e308", "-1.7e308"] {
            // A stiffness may stand for a rigid sensor.
            if key.contains("stiffness") && value == "1.7e308" {
                continue;
            }
            let text: String = SOUND
                .lines()
                .map(|line| if line.starts_with(key) { format!("{key} = {value}\n") } else { format!("{line}\n") })
                .collect();
            let refused = Calibration::from_toml(&text).unwrap_err().to_string();
            assert!(refused.contains(key) && refused.contains("but it must be"), "{key} = {value}: {refused}");
        }
    }
}

#[test]
fn cogging_is_bounded_in_number_and_size() {
    let harmonic = |torque: &str| format!("[[motor_cogging]]\nper_turn = 7\ntorque_mnm = {torque}\nphase_rad = 0.5\n");
    Calibration::from_toml(&format!("{SOUND}{}", harmonic("1").repeat(64))).unwrap();
    for text in [harmonic("1").repeat(65), harmonic("nan"), harmonic("1e300")] {
        let refused = Calibration::from_toml(&format!("{SOUND}{text}")).unwrap_err().to_string();
        assert!(refused.contains("motor_cogging"), "{refused}");
    }
}

#[test]
fn a_calibration_file_is_named_in_what_is_wrong_with_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rig.toml");
    std::fs::write(&path, SOUND.replace("motor_inertia = 0.055", "motor_inertia = 0")).unwrap();
    let refused = Calibration::load(&path).unwrap_err().to_string();
    assert!(refused.contains("rig.toml") && refused.contains("motor_inertia of 0"), "{refused}");
    let refused = Calibration::load(folder.path()).unwrap_err().to_string();
    assert!(refused.contains("it is a folder, not a file"), "{refused}");
}
