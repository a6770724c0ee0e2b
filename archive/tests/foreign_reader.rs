//! A capture means the same to the ROS 2 tools' own decoder as it does to us.

#![allow(clippy::unwrap_used, clippy::print_stderr, reason = "tests; a skipped one says so")]

mod common;

use std::path::Path;
use std::process::Command;

use common::{recording, sample};

/// A Python that has mcap and mcap-ros2-support; `$HAPTIC_CAMERA_PYTHON`, or `python3`.
fn python() -> Option<String> {
    let python = std::env::var("HAPTIC_CAMERA_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let has_packages = Command::new(&python).args(["-c", "import mcap.reader, mcap_ros2.decoder"]).output();
    has_packages.is_ok_and(|output| output.status.success()).then_some(python)
}

#[test]
fn python_s_ros_2_decoder_reads_the_same_bits() {
    let Some(python) = python() else {
        eprintln!("SKIPPED: no Python with mcap and mcap-ros2-support; set HAPTIC_CAMERA_PYTHON to one");
        return;
    };
    let directory = tempfile::tempdir().unwrap();
    let (capture, columns) = (directory.path().join("capture.mcap"), directory.path().join("columns.bin"));
    std::fs::write(&capture, recording(0..3000, 500)).unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scripts/check-archive.py");
    let output = Command::new(python).arg(script).arg(&capture).arg(&columns).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let printed = String::from_utf8(output.stdout).unwrap();
    for line in ["count 3000", "first_seq 0", "last_seq 2999", "missing 0", "in_order yes", "other_messages 15"] {
        assert!(printed.lines().any(|printed| printed == line), "{line} is not in\n{printed}");
    }
    let expected: Vec<u8> = (0..3000)
        .map(sample)
        .flat_map(|sample| {
            [
                sample.angle_rad,
                sample.velocity_rad_s,
                sample.acceleration_rad_s2,
                sample.torque_mnm,
                sample.commanded_angle_rad,
                sample.commanded_torque_mnm,
            ]
        })
        .flat_map(f64::to_le_bytes)
        .collect();
    assert!(std::fs::read(&columns).unwrap() == expected, "the columns differ");
}
