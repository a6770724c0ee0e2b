//! What is wrong gets one clear line and the right exit status.
#![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]

use tests::{Bench, printed};

/// Runs `arguments` and checks exit status and that one line says all of `expected`.
fn refused(bench: &Bench, arguments: &[&str], status: i32, expected: &[&str]) {
    let output = bench.run(arguments).unwrap();
    assert_eq!(output.status.code(), Some(status), "{arguments:?}: {}", printed(&output));
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    for words in expected {
        assert!(text.contains(words), "{arguments:?}: '{words}' is missing in\n{text}");
    }
    assert_eq!(text.lines().filter(|line| line.starts_with("error:")).count(), 1, "reported once: {text}");
    if status == 1 {
        assert_eq!(text.lines().count(), 1, "one line: {text}");
    }
}

fn csv(bench: &Bench, name: &str, header: &str, rows: &[&str]) -> String {
    let path = bench.path(name);
    std::fs::write(&path, format!("{header}\n{}\n", rows.join("\n"))).unwrap();
    path.to_string_lossy().into_owned()
}

const HEADER: &str = "t_s,angle_rad,torque_mnm";

#[test]
fn a_capture_that_is_none_is_refused_with_its_reason() {
    let bench = Bench::new().unwrap();
    refused(&bench, &["fit", "nowhere.mcap"], 1, &["nowhere.mcap"]);
    let wrong = csv(&bench, "wrong.csv", "time,angle,torque", &["0,0,0", "1,1,1", "2,2,2"]);
    refused(&bench, &["fit", &wrong], 1, &["t_s", "time"]);
    let nan = csv(&bench, "nan.csv", HEADER, &["0,0,0", "1,NaN,1", "2,2,2"]);
    refused(&bench, &["fit", &nan], 1, &["angle_rad", "line 3"]);
    let unordered = csv(&bench, "unordered.csv", HEADER, &["0,0,0", "2,1,1", "1,2,2"]);
    refused(&bench, &["fit", &unordered], 1, &["row 3"]);
    let two = csv(&bench, "two.csv", HEADER, &["0,0,0", "1,1,1"]);
    refused(&bench, &["fit", &two], 1, &["two rows"]);
    std::fs::write(bench.path("empty.csv"), "").unwrap();
    refused(&bench, &["fit", "empty.csv"], 1, &["empty"]);
}

#[test]
fn a_truncated_archive_is_refused_with_the_command_that_recovers_it() {
    let bench = Bench::new().unwrap();
    let output = bench.run(&["capture", "--duration-s", "2", "--no-viewer", "--out", "out"]).unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    let archive = bench.only_archive("out").unwrap();
    let whole = std::fs::read(&archive).unwrap();
    std::fs::write(bench.path("broken.mcap"), &whole[..whole.len() * 2 / 3]).unwrap();
    refused(&bench, &["fit", "broken.mcap"], 1, &["haptic-camera recover"]);

    let output = bench.run(&["recover", "broken.mcap", "--out", "fixed.mcap"]).unwrap();
    assert_eq!(output.status.code(), Some(3), "{}", printed(&output));
    let recovered = archive::Capture::load(&bench.path("fixed.mcap")).unwrap();
    let original = archive::Capture::load(&archive).unwrap();
    assert!(recovered.len() > original.len() / 3);
    assert_eq!(recovered.torque_mnm, original.torque_mnm[..recovered.len()]);
    assert_eq!(std::fs::read(bench.path("broken.mcap")).unwrap(), &whole[..whole.len() * 2 / 3], "left as it was");
}

#[test]
fn a_model_file_that_means_nothing_is_refused() {
    let bench = Bench::new().unwrap();
    let model = |name: &str, text: &str| {
        std::fs::write(bench.path(name), text).unwrap();
        name.to_owned()
    };
    let unknown = model("unknown.toml", "[[effects]]\neffect = \"wobble\"\n");
    refused(&bench, &["capture", "--knob", &unknown, "--no-viewer"], 1, &["wobble", "known effects are"]);
    let negative = model("negative.toml", "[[effects]]\neffect = \"inertia\"\ninertia = -1.0\n");
    refused(&bench, &["capture", "--knob", &negative, "--no-viewer"], 1, &["inertia is -1"]);
    refused(&bench, &["capture", "--knob", "missing.toml", "--no-viewer"], 1, &["missing.toml"]);
    refused(&bench, &["capture", "--knob", "9", "--no-viewer"], 1, &["1 to 5"]);
}

#[test]
fn what_the_rig_cannot_do_is_refused_with_what_it_can() {
    let bench = Bench::new().unwrap();
    refused(&bench, &["capture", "--rate-hz", "50000", "--no-viewer"], 1, &["50000", "20000"]);
    refused(&bench, &["capture", "--rate-hz", "nan", "--no-viewer"], 1, &["NaN"]);
    refused(&bench, &["capture", "--duration-s", "-3", "--no-viewer"], 1, &["-3"]);
    refused(&bench, &["capture", "--sweep", "square", "--no-viewer"], 1, &["square", "linear-chirp"]);
    refused(&bench, &["capture", "--amplitude", "0", "--no-viewer"], 1, &["amplitude"]);
    refused(&bench, &["capture", "--apparatus", "canopen", "--no-viewer"], 1, &["canopen"]);
    refused(&bench, &["capture", "--core", "99", "--no-viewer"], 1, &["core 99"]);
}

#[test]
fn a_mistyped_command_is_wrong_usage() {
    let bench = Bench::new().unwrap();
    refused(&bench, &["captuer"], 2, &["captuer"]);
    refused(&bench, &["capture", "--rate-hz", "fast"], 2, &["fast"]);
    refused(&bench, &["fit"], 2, &["CAPTURE"]);
}

#[test]
fn a_second_capture_on_the_same_rig_is_refused_and_does_not_disturb_the_first() {
    let bench = Bench::new().unwrap();
    let first = bench.start(&["capture", "--duration-s", "6", "--no-viewer", "--out", "first"]).unwrap();
    bench.wait_for_process("recorder").unwrap();
    refused(&bench, &["capture", "--duration-s", "2", "--no-viewer", "--out", "second"], 1, &["in use by process"]);
    let output = first.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    let capture = archive::Capture::load(&bench.only_archive("first").unwrap()).unwrap();
    assert_eq!(capture.len() as u64 + capture.ticks_without_sample() + capture.tick[0], 60_000);
}
