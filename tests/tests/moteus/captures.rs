//! What a capture of the server's plant tells, against the numbers that it is made of.

use archive::Capture;
use serde_json::Value;
use tests::{Bench, printed};

use super::{Server, rig, with_sensor};

/// Its numbers, as its source has them.
const TRUTH: [(&str, f64); 7] = [
    ("inertia", 0.06),
    ("coulomb_negative", 3.0),
    ("coulomb_positive", 3.0),
    ("viscous_negative", 0.25),
    ("viscous_positive", 0.25),
    ("detent_amplitude", 4.0),
    ("detent_period", 1.0 / 24.0),
];
/// Most that half an interval may be of its value: a wide one would hold anything. A machine with other work to do answers late, and
/// what came late is left out.
const WIDEST_SHARE: f64 = 0.25;
/// Half widths of the 95 % interval within which the truth must lie: one in twenty misses it by right, one in fifteen thousand by
/// twice as much.
const HALF_WIDTHS: f64 = 2.0;

/// Captures the plant at 1 kHz; gives the capture and its fit's parameters.
fn captured(bench: &Bench, file: &str) -> (Capture, Value) {
    let output =
        bench.run(&["capture", "--rig", file, "--rate-hz", "1000", "--duration-s", "8", "--no-viewer", "--out", "out"]);
    let output = output.unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    assert!(!String::from_utf8_lossy(&output.stdout).contains("true"), "nobody knows what a real knob is");
    let archive = bench.only_archive("out").unwrap();
    let output = bench.run(&["fit", &archive.to_string_lossy(), "--json", "-"]).unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    let fit: Value = serde_json::from_slice(&output.stdout).unwrap();
    (Capture::load(&archive).unwrap(), fit["parameters"].clone())
}

pub fn is_the_plants(parameters: &Value) {
    for (name, truth) in TRUTH {
        let told = &parameters[name];
        let [value, low, high] =
            [&told["value"], &told["ci95"][0], &told["ci95"][1]].map(|number| number.as_f64().unwrap());
        let half_width = (high - low) / 2.0;
        eprintln!("{name}: {value:.5} ± {half_width:.5}, truth {truth:.5}");
        assert!(half_width < WIDEST_SHARE * truth, "{name} {value} ± {half_width}");
        assert!(
            (value - truth).abs() <= HALF_WIDTHS * half_width,
            "{name} is {value} ± {half_width}, but the plant has {truth}"
        );
    }
}

#[test]
fn a_plant_behind_a_controller_without_a_torque_sensor_is_captured_as_it_is() {
    let bench = Bench::new().unwrap();
    let _server = Server::start(&bench, &[]);
    let (capture, parameters) = captured(&bench, &rig(&bench, |text| text));
    is_the_plants(&parameters);
    assert_eq!(capture.acceleration_rad_s2, None, "absent, not zero");
    let run = capture.description.unwrap();
    assert_eq!(run.simulated_knob_toml, None);
    let note =
        |wanted: &str| run.notes.iter().find(|(name, _)| name == wanted).map(|(_, value)| value.clone()).unwrap();
    assert_eq!(note("watchdog"), "1 s, read back");
    assert!(note("torque").contains("the motor's"));
    assert!(note("round trip").contains("µs"), "{:?}", run.notes);
    assert!(note("when the watchdog runs out").contains("let go; servo.timeout_mode was 12"), "{:?}", run.notes);
    assert!(run.device_codes.iter().any(|(code, meaning)| *code == 33 && meaning.contains("motor driver fault")));
}

#[test]
fn a_torque_sensor_may_be_on_an_analogue_pin_and_the_port_a_uart() {
    let bench = Bench::new().unwrap();
    let _server = Server::start(&bench, &["--uart"]);
    let (capture, parameters) = captured(&bench, &rig(&bench, |text| with_sensor(&text)));
    is_the_plants(&parameters);
    let notes = capture.description.unwrap().notes;
    assert!(notes.contains(&("link".to_owned(), "UART".to_owned())), "{notes:?}");
    assert!(!notes.iter().any(|(name, _)| name == "torque"), "{notes:?}");
}
