//! What belongs to another run, or to nobody's: it stays out of the archive, and stays as it is.
#![allow(clippy::unwrap_used, reason = "tests")]

mod common;

use std::process::Command;

use common::{RUN_ID, Rig, description, files_in, sample};
use shared_types::Sample;

#[test]
fn blocks_of_another_run_stay_out_of_the_archive() {
    let mut rig = Rig::new();
    let mut recorder = rig.start_recorder(0);
    rig.wait_for("the first part", |path| path.join("run.mcap.part-000").exists());
    rig.publish_blocks(100);
    let published = rig.published;
    rig.publish_block_of(RUN_ID + 1);
    rig.published = published;
    rig.publish_blocks(100);
    assert_eq!(rig.finish(&mut recorder), 0);
    rig.assert_complete(&rig.out());
}

#[test]
fn an_archive_of_another_run_is_never_overwritten() {
    let mut rig = Rig::new();
    let other = archive_of_run(1);
    std::fs::write(rig.out(), &other).unwrap();
    rig.publish_blocks(10);
    let mut recorder = rig.start_recorder(0);
    assert_eq!(rig.finish(&mut recorder), 0);
    assert_eq!(std::fs::read(rig.out()).unwrap(), other);
    assert_eq!(files_in(rig.directory.path()), ["run.mcap"]);
    rig.assert_complete(&rig.fallback().join("run.mcap"));
}

#[test]
fn what_the_recorder_did_not_make_is_never_part_of_its_run() {
    let mut rig = Rig::new();
    let place = rig.directory.path().to_owned();
    // Samples of nobody's run under the name of the next part, a pipe that nobody writes to, a folder, a link.
    let mut stranger = archive_with_samples(RUN_ID + 1);
    let name = stranger.windows(8).position(|bytes| bytes == b"run.json").unwrap();
    stranger[name] = b'X';
    std::fs::write(place.join("run.mcap.part-001"), &stranger).unwrap();
    assert!(Command::new("mkfifo").arg(place.join("run.mcap.part-002")).status().unwrap().success());
    std::fs::create_dir(place.join("run.mcap.part-003")).unwrap();
    std::fs::write(place.join("theirs"), archive_with_samples(RUN_ID)).unwrap();
    std::os::unix::fs::symlink("theirs", place.join("run.mcap.part-004")).unwrap();
    let mut recorder = rig.start_recorder(0);
    rig.wait_for("the first part", |path| path.join("run.mcap.part-000").exists());
    rig.publish_blocks(300);
    recorder.kill();
    let mut recorder = rig.start_recorder(1);
    rig.publish_blocks(300);
    assert_eq!(rig.finish(&mut recorder), 0);
    rig.assert_complete(&rig.out());
    let left: Vec<String> = (1..=4).map(|number| format!("run.mcap.part-00{number}")).collect();
    assert_eq!(files_in(&place), [&["run.mcap".to_owned()][..], &left].concat(), "what is not its own stays");
    assert_eq!(std::fs::read(place.join("run.mcap.part-001")).unwrap(), stranger);
}

/// An archive of a run with this identity and samples that the rig never published.
fn archive_with_samples(run_id: u64) -> Vec<u8> {
    let mut writer = archive::CaptureWriter::new(std::io::Cursor::new(Vec::new()), &description(run_id)).unwrap();
    for seq in 0..100_000 {
        writer.sample(&Sample { torque_mnm: 1e6, ..sample(seq) }).unwrap();
    }
    writer.finish().unwrap().1.into_inner()
}

/// An archive of a run with this identity, without samples.
fn archive_of_run(run_id: u64) -> Vec<u8> {
    let writer = archive::CaptureWriter::new(std::io::Cursor::new(Vec::new()), &description(run_id)).unwrap();
    writer.finish().unwrap().1.into_inner()
}
