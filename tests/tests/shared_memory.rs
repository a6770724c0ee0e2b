//! Shared memory that is too small, or fills up in a run.
#![allow(clippy::unwrap_used, clippy::print_stderr, reason = "a test may stop at a failure; a skipped one says so")]

use std::process::{Command, Output};

use archive::Capture;
use shared_types::shared_memory::NEEDED_BYTES;
use tests::{Bench, printed};

/// Makes a capture of five seconds in a shared memory of its own, beside a shell command; `None` where that is not
/// permitted, which is said.
fn capture(bench: &Bench, bytes: u64, beside: &str) -> Option<Output> {
    let plain = bench.command(&["capture", "--duration-s", "5", "--no-viewer", "--out", "out"]).unwrap();
    let words = std::iter::once(plain.get_program()).chain(plain.get_args());
    let words: Vec<String> = words.map(|word| word.to_string_lossy().into_owned()).collect();
    let script = format!("mount -t tmpfs -o size={bytes} tmpfs /dev/shm || exit 77; {beside} exec {}", words.join(" "));
    let output = Command::new("unshare")
        .args(["--mount", "sh", "-c", &script])
        .current_dir(plain.get_current_dir().unwrap())
        .env(shared_types::rig::RUNTIME_DIR_VARIABLE, bench.path("rig"))
        .output()
        .unwrap();
    if output.status.code() == Some(77) || String::from_utf8_lossy(&output.stderr).contains("unshare failed") {
        eprintln!("SKIPPED: no permission to mount a shared memory");
        return None;
    }
    Some(output)
}

#[test]
fn a_shared_memory_that_is_too_small_is_refused_before_the_rig_is_touched_and_what_is_needed_is_reported() {
    for bytes in [0x1000, NEEDED_BYTES - 1_000_000] {
        let bench = Bench::new().unwrap();
        let Some(output) = capture(&bench, bytes, "") else { return };
        assert_eq!(output.status.code(), Some(1), "{}", printed(&output));
        let needed = format!("a run needs {} MB of shared memory", NEEDED_BYTES.div_ceil(1_000_000));
        assert!(printed(&output).contains(&needed), "{}", printed(&output));
        assert_eq!(bench.leftovers(), Vec::<String>::new());
    }
}

#[test]
fn a_shared_memory_that_fills_up_in_the_run_costs_nothing() {
    let bench = Bench::new().unwrap();
    let fill = "(sleep 2; head -c 1000000000 /dev/zero > /dev/shm/filled) 2> /dev/null &";
    let Some(output) = capture(&bench, NEEDED_BYTES + (1 << 20), fill) else { return };
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    let capture = Capture::load(&bench.only_archive("out").unwrap()).unwrap();
    assert!(capture.seq.iter().enumerate().all(|(index, &seq)| seq == index as u64), "no sample is missing");
    assert_eq!(capture.len() as u64 + capture.ticks_without_sample() + capture.tick[0], 50_000);
}
