//! EMPS, a measured linear axis with published parameters (Janot, Gautier, Brunot 2019).
//!
//! `HAPTIC_CAMERA_DATA` names the folder that holds `measured/`; where there is none the tests skip and say so.

use crate::common::measured;
use identification::{Fit, FitOptions, PreparationMethod, Samples, fit};

/// The asymmetric model as published: inertia, and the friction of each direction.
const PUBLISHED: [(&str, f64); 5] = [
    ("inertia", 95.1540),
    ("coulomb_negative", 20.6277),
    ("coulomb_positive", 20.1440),
    ("viscous_negative", 240.4236),
    ("viscous_positive", 166.7061),
];

fn fitted(preparation: PreparationMethod) -> Option<Fit> {
    let columns = measured("emps.csv")?;
    let samples = Samples {
        t_s: &columns[0],
        angle_rad: &columns[1],
        velocity_rad_s: None,
        acceleration_rad_s2: None,
        torque_mnm: &columns[2],
    };
    Some(fit(&samples, &FitOptions { preparation, ..FitOptions::default() }).unwrap())
}

#[test]
fn the_measured_axis_has_the_published_parameters_and_no_detents() {
    let Some(fit) = fitted(PreparationMethod::Automatic) else { return };
    let value = |name: &str| fit.parameters.get(name).unwrap().value;
    for (name, published) in PUBLISHED {
        let tolerance = if name == "inertia" { 0.005 } else { 0.03 };
        assert!((value(name).unwrap() / published - 1.0).abs() < tolerance, "{name}");
    }
    assert!(fit.relative_error_percent <= 3.2);
    assert_eq!(value("detent_amplitude"), None);
    assert!(fit.parameters.get("detent_amplitude").unwrap().reason.is_some());
}

#[test]
fn prepared_as_its_authors_did_the_axis_is_within_two_standard_deviations_of_what_they_published() {
    let Some(fit) = fitted(PreparationMethod::CentralDifferences) else { return };
    for (name, published) in PUBLISHED {
        let parameter = fit.parameters.get(name).unwrap();
        let [low, high] = parameter.ci95_textbook.unwrap();
        // The authors' standard deviation is the one for independent residuals; this one must not be wide besides.
        let standard_deviation = 0.5 * (high - low) / 1.959_964;
        assert!(standard_deviation < 0.01 * published, "{name}: {standard_deviation}");
        assert!((parameter.value.unwrap() - published).abs() < 2.0 * standard_deviation, "{name}: {parameter:?}");
    }
    // Published: 3.112 %.
    assert!(fit.relative_error_percent <= 3.11, "{}", fit.relative_error_percent);
    assert!(fit.relative_error_percent > 3.0, "{}", fit.relative_error_percent);
    assert_eq!(fit.preparation.method, "central-differences");
}
