//! EMPS, a measured linear axis with published parameters (Janot, Gautier, Brunot 2019).
//!
//! `HAPTIC_CAMERA_DATA` names the folder that holds `measured/`; where there is none the test skips and says so.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
#![allow(clippy::print_stderr, reason = "a test that skips says so")]

use identification::{FitOptions, Samples, fit};

#[test]
fn the_measured_axis_has_the_published_inertia_and_no_detents() {
    let folder = std::env::var_os("HAPTIC_CAMERA_DATA").map_or_else(
        || std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data"),
        std::path::PathBuf::from,
    );
    let path = folder.join("measured/emps.csv");
    let Ok(text) = std::fs::read_to_string(&path) else {
        eprintln!("skipped: there is no {}; HAPTIC_CAMERA_DATA may name the folder", path.display());
        return;
    };
    let rows: Vec<Vec<f64>> =
        text.lines().skip(1).map(|line| line.split(',').map(|value| value.parse().unwrap()).collect()).collect();
    let column = |index: usize| rows.iter().map(|row| row[index]).collect::<Vec<f64>>();
    let (t_s, angle_rad, torque_mnm) = (column(0), column(1), column(2));
    let samples = Samples {
        t_s: &t_s,
        angle_rad: &angle_rad,
        velocity_rad_s: None,
        acceleration_rad_s2: None,
        torque_mnm: &torque_mnm,
    };
    let fit = fit(&samples, &FitOptions::default()).unwrap();
    let value = |name: &str| fit.parameters.get(name).unwrap().value;
    assert!((value("inertia").unwrap() / 95.154 - 1.0).abs() < 0.005);
    assert!((value("coulomb_positive").unwrap() / 20.144 - 1.0).abs() < 0.03);
    assert!((value("coulomb_negative").unwrap() / 20.6277 - 1.0).abs() < 0.03);
    assert!((value("viscous_positive").unwrap() / 166.7061 - 1.0).abs() < 0.03);
    assert!((value("viscous_negative").unwrap() / 240.4236 - 1.0).abs() < 0.03);
    assert!(fit.relative_error_percent <= 3.2);
    assert_eq!(value("detent_amplitude"), None);
    assert!(fit.parameters.get("detent_amplitude").unwrap().reason.is_some());
}
