//! Hostile files and calls, as `scripts/break` makes them from its data.
#![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]

use std::path::Path;
use std::process::Command;

use tests::{Bench, printed, program};

#[test]
#[allow(clippy::print_stderr, reason = "a test that skips says so")]
fn hostile_files_and_calls_cost_little_destroy_nothing_and_are_reported_in_a_line() {
    let _turn = Bench::new().unwrap();
    if !Command::new("python3").args(["-c", "import tomllib"]).output().is_ok_and(|output| output.status.success()) {
        eprintln!("skipped: scripts/break needs Python 3.11 or newer");
        return;
    }
    let programs = program("haptic-camera").unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scripts/break");
    let output = Command::new("python3")
        .arg(script)
        .arg("--everyday")
        .arg("--programs")
        .arg(programs.parent().unwrap())
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", printed(&output));
}
