//! The recorder as a process: fed through shared memory, killed, restarted, stopped.
#![allow(clippy::unwrap_used, reason = "tests")]

mod common;

use std::process::Command;

use archive::Capture;
use common::{Process, Rig, files_in};
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;

fn send(signal: Signal, process: &Process) {
    kill(Pid::from_raw(i32::try_from(process.0.id()).unwrap()), signal).unwrap();
}

#[test]
fn a_run_is_recorded_whole() {
    let mut rig = Rig::new();
    let mut recorder = rig.start_recorder(0);
    rig.wait_for("the first part", |path| path.join("run.mcap.part-000").exists());
    rig.publish_blocks(1500);
    assert_eq!(rig.finish(&mut recorder), 0);
    assert_eq!(files_in(rig.directory.path()), ["run.mcap"]);
    rig.assert_complete(&rig.out());
}

#[test]
fn an_archive_in_the_temporary_directory_is_like_any_other() {
    let mut rig = Rig::new();
    let out = rig.elsewhere().join("run.mcap");
    let mut recorder = rig.start_recorder_to(&out, 0);
    rig.publish_blocks(300);
    assert_eq!(rig.finish(&mut recorder), 0);
    assert_eq!(files_in(&rig.elsewhere()), ["run.mcap"]);
    rig.assert_complete(&out);
}

#[test]
fn a_killed_recorder_resumes_without_a_gap() {
    let mut rig = Rig::new();
    let mut recorder = rig.start_recorder(0);
    for restart in 1..=3 {
        let part = format!("run.mcap.part-{:03}", restart - 1);
        rig.wait_for(&part, |path| path.join(&part).exists());
        rig.publish_blocks(900);
        recorder.kill();
        rig.publish_blocks(100);
        recorder = rig.start_recorder(restart);
    }
    rig.publish_blocks(300);
    assert_eq!(rig.finish(&mut recorder), 0);
    assert_eq!(files_in(rig.directory.path()), ["run.mcap"]);
    rig.assert_complete(&rig.out());
}

#[test]
fn a_recorder_that_comes_after_the_run_records_what_history_holds() {
    let mut rig = Rig::new();
    rig.publish_blocks(600);
    let mut recorder = rig.start_recorder(0);
    assert_eq!(rig.finish(&mut recorder), 0);
    rig.assert_complete(&rig.out());
}

#[test]
fn samples_that_never_come_are_reported_by_status_3_and_a_gap() {
    let mut rig = Rig::new();
    let mut recorder = rig.start_recorder(0);
    rig.wait_for("the first part", |path| path.join("run.mcap.part-000").exists());
    rig.publish_blocks(200);
    let first_missing_seq = rig.published;
    rig.published += 70;
    rig.publish_blocks(200);
    let next = rig.published;
    rig.published += 5;
    assert_eq!(rig.finish(&mut recorder), 3);
    let gaps = Capture::load(&rig.out()).unwrap().gaps;
    let bounds: Vec<(u64, u64)> = gaps.iter().map(|gap| (gap.first_missing_seq, gap.last_missing_seq)).collect();
    assert_eq!(bounds, [(first_missing_seq, first_missing_seq + 69), (next, next + 4)]);
}

#[test]
fn a_recorder_that_is_reported_to_stop_ends_its_archive_and_ignores_ctrl_c() {
    let mut rig = Rig::new();
    let mut recorder = rig.start_recorder(0);
    rig.wait_for("the first part", |path| path.join("run.mcap.part-000").exists());
    rig.publish_blocks(300);
    send(Signal::SIGINT, &recorder);
    rig.publish_blocks(300);
    assert!(recorder.0.try_wait().unwrap().is_none(), "an interrupt from the keyboard is the supervisor's to handle");
    send(Signal::SIGTERM, &recorder);
    assert_eq!(rig.wait(&mut recorder, || {}), 0);
    rig.assert_complete(&rig.out());
}

#[test]
fn a_recorder_whose_source_dies_ends_its_archive() {
    let mut rig = Rig::new();
    let mut source = Process::start(Command::new("sleep").arg("1000"));
    rig.process_id = source.0.id();
    let mut recorder = rig.start_recorder(0);
    rig.wait_for("the first part", |path| path.join("run.mcap.part-000").exists());
    rig.publish_blocks(400);
    rig.publish_status(false);
    source.kill();
    // Killed and not reaped: a dead process that still has an entry.
    assert_eq!(rig.wait(&mut recorder, || {}), 0);
    rig.assert_complete(&rig.out());
}

#[test]
fn a_recorder_started_again_after_its_archive_was_ended_loses_nothing_of_it() {
    let mut rig = Rig::new();
    let mut recorder = rig.start_recorder(0);
    rig.wait_for("the first part", |path| path.join("run.mcap.part-000").exists());
    // Longer than history reaches back.
    rig.publish_blocks(4500);
    assert_eq!(rig.finish(&mut recorder), 0);
    let mut again = rig.start_recorder(1);
    assert_eq!(rig.finish(&mut again), 0);
    assert_eq!(files_in(rig.directory.path()), ["run.mcap"]);
    rig.assert_complete(&rig.out());
}
