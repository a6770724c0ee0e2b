//! Models of what is pressed: named and read in mm and N.
#![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]

use dynamics::{Axis, Drive, Excitation, Model, Motion, knobs};

#[test]
fn a_model_of_what_is_pressed_is_written_in_its_own_units_and_reads_back() {
    let dome = knobs::dome().unwrap();
    let text = dome.to_toml();
    assert!(text.contains("axis = \"linear\"") && text.contains("snap_flat_travel") && text.contains("N/mm"), "{text}");
    assert!(!text.contains("mNm") && !text.contains("rad"), "{text}");
    assert_eq!(Model::from_toml(&text, "the dome").unwrap(), dome);
}

#[test]
fn names_of_the_other_axis_are_refused() {
    let text = knobs::dome().unwrap().to_toml().replace("snap_flat_travel", "snap_flat_angle");
    let error = Model::from_toml(&text, "the dome").unwrap_err().to_string();
    assert!(error.contains("snap_flat_angle") && error.contains("snap_flat_travel"), "{error}");
}

#[test]
fn the_dome_collapses_and_bottoms_out() {
    let dome = knobs::dome().unwrap();
    let force_n = |travel_mm| dome.free_torque_mnm(&Motion { angle_rad: travel_mm, ..Motion::default() });
    assert!(force_n(0.0).abs() < 1e-12);
    assert!(force_n(1.0) > 0.45 && force_n(3.2) < 0.3 && force_n(3.8) > 1.0);
}

#[test]
fn what_is_pressed_is_never_pulled() {
    for name in dynamics::excitation::NAMES {
        let press = Excitation::named(name, Drive::Position).unwrap().on(Axis::Linear);
        let least = (0..20_000).map(|tick| press.at(f64::from(tick) * 1e-3).value).fold(f64::INFINITY, f64::min);
        assert!(least >= 0.0, "{name}: {least}");
    }
}

#[test]
fn what_is_pressed_fast_goes_as_far_as_a_fingertip_and_a_tone_keeps_its_frequency() {
    let press = |name| Excitation::named(name, Drive::Position).unwrap().on(Axis::Linear);
    assert!((press("fast-multisine").amplitude - 1.0).abs() < 1e-12 && (press("paper").amplitude - 3.4).abs() < 1e-12);
    let tone = press("tone");
    let [now, later, between] = [2.004, 2.004 + 1.0 / 30.0, 2.004 + 0.5 / 30.0].map(|time_s| tone.at(time_s).value);
    assert!((now - later).abs() < 1e-9 && (now - between).abs() > 1e-3, "{now} {later} {between}");
}
