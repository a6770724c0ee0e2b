//! What a capture of the plant tells, against the numbers that it is made of.

use archive::Capture;
use serde_json::Value;
use tests::rotary_plant::is_the_plants;
use tests::{Bench, printed};

use super::{rig, without};

/// Captures the plant; gives the capture and its fit's parameters.
fn captured(bench: &Bench, file: &str) -> (Capture, Value) {
    let output = bench.run(&["capture", "--rig", file, "--duration-s", "5", "--no-viewer", "--out", "out"]).unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    let archive = std::fs::read_dir(bench.path("out")).unwrap().flatten().map(|entry| entry.path());
    let archive = archive.filter(|path| path.extension().is_some_and(|ending| ending == "mcap")).max().unwrap();
    let output = bench.run(&["fit", &archive.to_string_lossy(), "--json", "-"]).unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    let fit: Value = serde_json::from_slice(&output.stdout).unwrap();
    (Capture::load(&archive).unwrap(), fit["parameters"].clone())
}

#[test]
fn a_plant_behind_the_c_interface_is_captured_as_it_is() {
    let bench = Bench::new().unwrap();
    let (capture, parameters) = captured(&bench, &rig(&bench, "", |text| text));
    is_the_plants(&parameters, 0.0, "as it comes");
    let run = capture.description.unwrap();
    assert_eq!((run.apparatus.as_str(), run.knob.as_str()), ("rotary plant", "unnamed"));
    assert_eq!(run.simulated_knob_toml, None, "nobody knows what a real knob is");
    assert!(run.device_codes.iter().any(|(code, meaning)| *code == 12 && meaning.contains("interlock")));
    assert!(run.notes.contains(&("watchdog".to_owned(), "1 s, read back".to_owned())), "{:?}", run.notes);
}

#[test]
fn late_and_uneven_sampling_times_are_taken_as_they_are() {
    let bench = Bench::new().unwrap();
    let (capture, parameters) = captured(&bench, &rig(&bench, "late = 0.2", |text| text));
    is_the_plants(&parameters, 0.0, "0.2 of a period late");
    let after_s = capture.measured_after_s.unwrap();
    assert!(after_s.iter().all(|after_s| (after_s - 20e-6).abs() < 1e-6), "{:?}", &after_s[..5]);
    let (_, parameters) = captured(&bench, &rig(&bench, "jitter = 0.2", |text| text));
    is_the_plants(&parameters, 0.0, "up to 0.2 of a period late");
    let (capture, parameters) = captured(&bench, &rig(&bench, "drift_ppm = 50.0", |text| text));
    is_the_plants(&parameters, 0.0, "50 ppm of drift");
    let after_s = capture.measured_after_s.unwrap();
    let drift = (after_s[after_s.len() - 1] - after_s[0]) / (capture.t_s[capture.t_s.len() - 1] - capture.t_s[0]);
    assert!((drift - 50e-6).abs() < 1e-6, "{drift}");
}

#[test]
fn bursts_without_anything_new_are_flagged_and_left_out() {
    let bench = Bench::new().unwrap();
    let (capture, parameters) = captured(&bench, &rig(&bench, "stale_every = 200.0\nstale_for = 7.0", |text| text));
    is_the_plants(&parameters, 0.0, "7 stale ticks in 200");
    assert!(capture.unmeasured_samples() > 1_000, "{}", capture.unmeasured_samples());
    assert!(capture.t_s.windows(2).any(|pair| pair[1] - pair[0] > 7.5e-4), "the bursts are gaps");
}

#[test]
fn a_rig_may_lack_the_accelerometer_and_the_torque_sensor() {
    let bench = Bench::new().unwrap();
    let (capture, parameters) = captured(&bench, &rig(&bench, "", |text| without(&text, "[channels.acceleration]")));
    is_the_plants(&parameters, 0.0, "no accelerometer");
    assert_eq!(capture.acceleration_rad_s2, None, "absent, not zero");
    // The motor's constant is 16.4 mNm/A, but was calibrated 1 % too high. The current is half a period old.
    let from_current = |text: String| {
        let current = "source = \"current\"\nof_motor = true\nscale = 16.564\ndelay_s = 5e-5";
        without(&text, "[channels.acceleration]").replace("source = \"torque\"", current)
    };
    let (capture, parameters) = captured(&bench, &rig(&bench, "", from_current));
    is_the_plants(&parameters, 0.01, "torque from the motor's current");
    let notes = capture.description.unwrap().notes;
    assert!(notes.iter().any(|(name, note)| name == "torque" && note.contains("the motor's")), "{notes:?}");
}
