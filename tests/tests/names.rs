//! Rigs that share a folder of captures.
#![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]

use archive::Capture;
use tests::{Bench, printed};

#[test]
fn captures_of_two_rigs_begun_at_once_into_one_folder_are_each_their_own() {
    let bench = Bench::new().unwrap();
    let begin = |rig: &str| {
        let seed = format!("--seed={}", rig.len());
        // A core for each loop, at a rate that leaves it time.
        let core = if rig == "rig" { "--core=0" } else { "--core=1" };
        let line = [
            "capture",
            "--knob",
            "3",
            "--rate-hz",
            "2000",
            "--duration-s",
            "3",
            "--no-viewer",
            core,
            &seed,
            "--out",
            "out",
        ];
        let mut command = bench.command(&line).unwrap();
        command.env(shared_types::rig::RUNTIME_DIR_VARIABLE, bench.path(rig)).spawn().unwrap()
    };
    // A second that has just begun: both take their names in it.
    while shared_types::rig::wall_clock_time_ns() % 1_000_000_000 > 200_000_000 {
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    let begun = [("rig", begin("rig")), ("other-rig", begin("other-rig"))];
    for (rig, capture) in begun {
        let output = capture.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        let archive = said.lines().find_map(|line| line.strip_prefix("archive  ")).unwrap();
        let capture = Capture::load(&bench.path(archive.split(" (").next().unwrap())).unwrap();
        assert_eq!(capture.gaps, []);
        let notes = capture.description.unwrap().notes;
        let seed = ("seed".to_owned(), rig.len().to_string());
        assert!(notes.contains(&seed), "{rig} tells of another rig's capture: {notes:?}");
    }
}
