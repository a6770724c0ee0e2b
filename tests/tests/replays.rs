//! Replays from start to end, with all processes: a model felt, turned while it runs, and recorded.
#![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]
#![allow(clippy::print_stdout, reason = "figures for who asks for them")]

use std::process::Output;
use std::time::{Duration, Instant};

use archive::Capture;
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use tests::{Bench, printed};

/// Sends `haptic-camera tune ARGUMENTS` to the replay, which must take it.
fn tuned(bench: &Bench, arguments: &[&str]) -> String {
    let output = bench.run(&[&["tune"], arguments].concat()).unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// What is not taken is refused in one sentence that says what would do.
fn refused(bench: &Bench, arguments: &[&str], expected: &str) {
    let output: Output = bench.run(&[&["tune"], arguments].concat()).unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", printed(&output));
    let said = String::from_utf8_lossy(&output.stderr).trim().to_owned();
    assert!(said.lines().count() == 1 && said.contains(expected), "'{expected}' is missing in: {said}");
}

#[test]
fn a_model_is_turned_while_it_is_felt_and_both_are_in_the_archive() {
    let bench = Bench::new().unwrap();
    refused(&bench, &["inertia=0.05"], "no replay is running");
    let arguments = ["replay", "3", "--hand", "multisine", "--grip", "6", "--no-viewer", "--out", "out"];
    let child = bench.start(&arguments).unwrap();
    bench.wait_for_process("recorder").unwrap();
    let deadline = Instant::now() + Duration::from_secs(10);
    // The replay is there as soon as its loop answers.
    while bench.run(&["tune"]).unwrap().status.code() != Some(0) {
        assert!(Instant::now() < deadline, "the replay never answers");
        std::thread::sleep(Duration::from_millis(50));
    }
    std::thread::sleep(Duration::from_secs(3));
    let said = tuned(&bench, &["detent_amplitude=3", "coulomb_positive=5"]);
    assert!(said.contains("1.1 → 3 mNm") && said.contains("2.3 → 5 mNm"), "{said}");
    let present = tuned(&bench, &[]);
    assert!(present.contains("detent_amplitude       3 mNm"), "{present}");
    refused(&bench, &["detent_amplitud=3"], "detent_amplitude");
    refused(&bench, &["inertia=-1"], "zero");
    refused(&bench, &["inertia=1000"], "at most");
    refused(&bench, &["--model", "nowhere.toml"], "nowhere.toml");
    std::thread::sleep(Duration::from_secs(1));
    kill(Pid::from_raw(i32::try_from(child.id()).unwrap()), Signal::SIGINT).unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    let text = String::from_utf8_lossy(&output.stdout);
    for expected in ["rendered Knob 3 from 0.00 s", "guard", "archive", "stopped by the operator"] {
        assert!(text.contains(expected), "'{expected}' is missing in\n{text}");
    }
    assert_eq!(bench.leftovers(), Vec::<String>::new());

    let capture = Capture::load(&bench.only_archive("out").unwrap()).unwrap();
    assert!(capture.seq.iter().enumerate().all(|(index, &seq)| seq == index as u64), "no sample is missing");
    let [first, second] = &capture.models[..] else { panic!("two models: {:?}", capture.models) };
    let run = capture.description.as_ref().unwrap();
    assert_eq!(first.tick, 0);
    assert_eq!(Some(&first.model_toml), run.rendered_model_toml.as_ref());
    assert!(second.tick > 20_000 && second.model_toml.contains("detent_amplitude = 3.0"), "{second:?}");
    assert!(capture.models.iter().all(|model| model.run_id == run.run_id));

    // What was recorded, fed through the control step again with both models, gives the same torques bit for bit …
    let archive = bench.only_archive("out").unwrap();
    let output = bench.run(&["recompute", archive.to_str().unwrap()]).unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(text.contains("of 2 models") && text.contains("every torque command, bit for bit"), "{text}");
    // … and does not once a model has another number.
    let mut tampered = capture.clone();
    tampered.models[1].model_toml = second.model_toml.replace("detent_amplitude = 3.0", "detent_amplitude = 3.001");
    tampered.write_mcap(&bench.path("tampered.mcap")).unwrap();
    let output = bench.run(&["recompute", "tampered.mcap"]).unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", printed(&output));
    assert!(String::from_utf8_lossy(&output.stdout).contains("differs  from tick"), "{}", printed(&output));

    // Around the change the commanded torque goes on as it does everywhere.
    let row = capture.tick.iter().position(|tick| *tick >= second.tick).unwrap();
    let commanded_mnm = capture.commanded_torque_mnm.as_ref().unwrap();
    let step_mnm = |rows: std::ops::Range<usize>| {
        commanded_mnm[rows].windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max)
    };
    let peak_mnm = commanded_mnm.iter().fold(0.0_f64, |peak, torque_mnm| peak.max(torque_mnm.abs()));
    let (elsewhere_mnm, at_change_mnm) = (step_mnm(10_000..row - 10), step_mnm(row - 10..row + 10));
    println!("steps: {elsewhere_mnm:.3} mNm elsewhere, {at_change_mnm:.3} mNm at the change; peak {peak_mnm:.1} mNm");
    assert!(at_change_mnm < elsewhere_mnm + 0.02 * peak_mnm, "{at_change_mnm}, {elsewhere_mnm}, {peak_mnm} mNm");
}

#[test]
fn of_several_tunes_at_once_none_is_lost() {
    let bench = Bench::new().unwrap();
    let child = bench.start(&["replay", "3", "--no-viewer", "--out", "out"]).unwrap();
    bench.wait_for_process("recorder").unwrap();
    let deadline = Instant::now() + Duration::from_secs(10);
    while bench.run(&["tune"]).unwrap().status.code() != Some(0) {
        assert!(Instant::now() < deadline, "the replay never answers");
        std::thread::sleep(Duration::from_millis(50));
    }
    let settings = ["detent_amplitude=3", "coulomb_positive=5", "coulomb_negative=4"];
    let tunes: Vec<_> = settings.iter().map(|setting| bench.start(&["tune", setting]).unwrap()).collect();
    let mut overtaken = 0;
    for tune in tunes {
        let output = tune.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
        overtaken += String::from_utf8_lossy(&output.stderr).matches("changed the model first").count();
    }
    println!("{overtaken} times changed the model first");
    let present = tuned(&bench, &[]);
    for setting in settings {
        let (name, value) = setting.split_once('=').unwrap();
        let line = present.lines().find(|line| line.contains(name)).unwrap();
        assert!(line.contains(&format!(" {value} mNm")), "{setting} is lost:\n{present}");
    }
    let said = tuned(&bench, &["--model", "1"]);
    assert!(said.contains("Knob 3 → Knob 1") && said.contains(" → –"), "what knob 1 does not have is gone: {said}");
    assert_eq!(tuned(&bench, &["--model", "1"]).trim(), "nothing changes: the model is as it was");
    kill(Pid::from_raw(i32::try_from(child.id()).unwrap()), Signal::SIGINT).unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
}

#[test]
fn a_capture_says_that_it_renders_nothing() {
    let bench = Bench::new().unwrap();
    let child = bench.start(&["capture", "--duration-s", "4", "--no-viewer", "--out", "out"]).unwrap();
    bench.wait_for_process("recorder").unwrap();
    refused(&bench, &["inertia=0.05"], "the run is a capture");
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    assert_eq!(Capture::load(&bench.only_archive("out").unwrap()).unwrap().models, []);
}

#[test]
fn a_model_beyond_the_rig_is_refused_once_with_what_would_do() {
    let bench = Bench::new().unwrap();
    let heavy = "name = \"Heavy\"\n[[effects]]\neffect = \"inertia\"\ninertia = 5000.0\n";
    std::fs::write(bench.path("heavy.toml"), heavy).unwrap();
    let output = bench.run(&["replay", "heavy.toml", "--no-viewer", "--out", "out"]).unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", printed(&output));
    let said = String::from_utf8_lossy(&output.stderr).trim().to_owned();
    assert!(said.lines().count() == 1 && said.contains("at most"), "{said}");
    assert_eq!(bench.leftovers(), Vec::<String>::new());
}
