//! The real-time thread in a whole capture, watched by the kernel.
#![allow(clippy::unwrap_used, clippy::print_stderr, reason = "a test may stop at a failure, and says when it skips")]

use std::time::Duration;

use tests::{Bench, printed};

#[test]
fn it_makes_no_system_call_but_its_sleep_whatever_becomes_of_the_consumers() {
    let bench = Bench::new().unwrap();
    let mut command = bench.command(&["capture", "--duration-s", "4", "--out", "out"]).unwrap();
    let child = command.env("HAPTIC_CAMERA_WATCH_CALLS", "1").spawn().unwrap();
    bench.wait_for_process("recorder").unwrap();
    std::thread::sleep(Duration::from_millis(1_500));
    for consumer in ["live-fitter", "rerun-viewer", "recorder"] {
        bench.kill(consumer).unwrap();
    }
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    let errors = String::from_utf8_lossy(&output.stderr);
    if errors.contains("cannot be watched") {
        eprintln!("skipped: {errors}");
        return;
    }
    assert!(errors.contains("the real-time thread made no system call but its sleep"), "{errors}");
}
