//! The system clock is stepped an hour ahead and two hours back during a capture, as the programs see it (libfaketime).
#![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]

use std::path::Path;
use std::time::Duration;

use archive::Capture;
use tests::{Bench, printed};

const SECONDS: u64 = 9;
const HOUR_NS: i64 = 3_600_000_000_000;

#[test]
fn a_system_clock_that_is_stepped_moves_nothing_in_the_archive() {
    let library = format!("/usr/lib/{}-linux-gnu/faketime/libfaketime.so.1", std::env::consts::ARCH);
    assert!(Path::new(&library).exists(), "libfaketime is missing: scripts/set-up tests installs it");
    let bench = Bench::new().unwrap();
    let shift = bench.path("shift");
    std::fs::write(&shift, "+0").unwrap();
    let duration = SECONDS.to_string();
    let child = bench
        .command(&["capture", "--duration-s", &duration, "--no-viewer", "--out", "out"])
        .unwrap()
        .env("LD_PRELOAD", &library)
        .env("FAKETIME_TIMESTAMP_FILE", &shift)
        .env("FAKETIME_CACHE_DURATION", "1")
        .env("FAKETIME_DONT_FAKE_MONOTONIC", "1")
        .spawn()
        .unwrap();
    bench.wait_for_process("recorder").unwrap();
    for seconds in ["+3600", "-3600"] {
        std::thread::sleep(Duration::from_secs(SECONDS / 3));
        std::fs::write(&shift, seconds).unwrap();
    }
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    let archive = bench.only_archive("out").unwrap();
    let capture = Capture::load(&archive).unwrap();
    assert_eq!(capture.gaps, []);
    assert_eq!(capture.len() as u64 + capture.ticks_without_sample() + capture.tick[0], SECONDS * 10_000);

    let bytes = std::fs::read(&archive).unwrap();
    let (mut ahead, mut behind, mut newest) = (0, 0, 0);
    for message in mcap::MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        if message.channel.topic == "/sample" {
            assert!(message.log_time > newest, "time falls from {newest} to {}", message.log_time);
            newest = message.log_time;
        }
        if message.channel.topic == "/status" {
            // What the system's clock said, is among its fields.
            let shifted = |by_ns: i64| {
                message.data.windows(8).any(|bytes| {
                    let field = u64::from_le_bytes(bytes.try_into().unwrap());
                    field.cast_signed().wrapping_sub(message.log_time.cast_signed()).wrapping_sub(by_ns).unsigned_abs()
                        < 60_000_000_000
                })
            };
            ahead += u32::from(shifted(HOUR_NS));
            behind += u32::from(shifted(-HOUR_NS));
        }
    }
    assert!(ahead > 0 && behind > 0, "the clock was stepped: {ahead} reports ahead, {behind} behind");
    let span_s = (capture.tick[capture.len() - 1] - capture.tick[0]) as f64 / 10_000.0;
    assert!((span_s - SECONDS as f64).abs() < 0.1, "{span_s} s");
}
