//! Disks that fill up, go away or cannot be written to during a run.
#![allow(clippy::unwrap_used, reason = "tests")]

mod common;

use std::path::Path;

use archive::Capture;
use common::{Rig, files_in, sample};
use tests::small_disk::SmallDisk;

#[test]
fn a_place_that_cannot_be_written_to_sends_the_recording_to_the_temporary_directory() {
    let mut rig = Rig::new();
    let mut recorder = rig.start_recorder_to(Path::new("/proc/no/such/place/run.mcap"), 0);
    let part = rig.fallback().join("run.mcap.part-000");
    rig.wait_for("the part elsewhere", |_| part.exists());
    rig.publish_blocks(300);
    assert_eq!(rig.finish(&mut recorder), 0);
    assert_eq!(files_in(&rig.fallback()), ["run.mcap"], "the archive is where there is room");
    rig.assert_complete(&rig.fallback().join("run.mcap"));
}

#[test]
fn a_folder_that_is_removed_during_the_run_costs_no_sample() {
    let mut rig = Rig::new();
    let folder = rig.directory.path().join("captures");
    let mut recorder = rig.start_recorder_to(&folder.join("run.mcap"), 0);
    rig.wait_for("the first part", |path| path.join("captures/run.mcap.part-000").exists());
    rig.publish_blocks(1200);
    std::fs::remove_dir_all(&folder).unwrap();
    rig.publish_blocks(1200);
    assert_eq!(rig.finish(&mut recorder), 0);
    assert_eq!(files_in(&rig.fallback()), ["run.mcap"], "what was removed was saved from the open file");
    rig.assert_complete(&rig.fallback().join("run.mcap"));
}

#[test]
fn a_disk_that_becomes_read_only_costs_no_sample() {
    let mut rig = Rig::new();
    let Some(disk) = SmallDisk::mount(&rig.directory.path().join("disk"), 65_536) else { return };
    let out = disk.path().join("run.mcap");
    let mut recorder = rig.start_recorder_to(&out, 0);
    rig.wait_for("the first part", |path| path.join("disk/run.mcap.part-000").exists());
    rig.publish_blocks(1000);
    // The system permits it only while no file is open for writing, so between two lives of the recorder.
    recorder.kill();
    recorder.0.wait().unwrap();
    disk.remount("ro");
    let mut recorder = rig.start_recorder_to(&out, 1);
    rig.publish_blocks(1000);
    assert_eq!(rig.finish(&mut recorder), 0);
    assert_eq!(files_in(disk.path()), ["run.mcap.part-000"], "what cannot be removed stays");
    rig.assert_complete(&rig.fallback().join("run.mcap"));
}

#[test]
fn two_full_disks_cost_no_sample_when_room_is_made_in_time() {
    let mut rig = Rig::new();
    let Some(disk) = SmallDisk::mount(&rig.directory.path().join("disk"), 512) else { return };
    let Some(other) = SmallDisk::mount(&rig.elsewhere(), 512) else { return };
    let mut recorder = rig.start_recorder_to(&disk.path().join("run.mcap"), 0);
    rig.publish_blocks(4000);
    other.remount("size=64m");
    assert_eq!(rig.finish(&mut recorder), 0);
    rig.assert_complete(&rig.fallback().join("run.mcap"));
}

#[test]
fn two_full_disks_leave_what_fitted_readable_and_the_loss_is_reported() {
    let mut rig = Rig::new();
    let Some(disk) = SmallDisk::mount(&rig.directory.path().join("disk"), 512) else { return };
    let Some(_other) = SmallDisk::mount(&rig.elsewhere(), 512) else { return };
    let out = disk.path().join("run.mcap");
    let mut recorder = rig.start_recorder_to(&out, 0);
    rig.publish_blocks(4000);
    assert_eq!(rig.finish(&mut recorder), 3);
    let mut parts = Vec::new();
    for folder in [disk.path(), &rig.fallback()] {
        parts.extend(files_in(folder).into_iter().map(|name| folder.join(name)));
    }
    let merged = rig.directory.path().join("merged.mcap");
    let summary = archive::merge(&parts, &merged, Some(rig.published)).unwrap();
    assert!(summary.ledger.admitted() > 1000, "{parts:?} hold {} samples", summary.ledger.admitted());
    assert_eq!(summary.ledger.admitted() + summary.ledger.missing(), rig.published);
    let capture = Capture::load(&merged).unwrap();
    for (seq, torque) in capture.seq.iter().zip(&capture.torque_mnm) {
        assert_eq!(torque.to_bits(), sample(*seq).torque_mnm.to_bits());
    }
}

#[test]
fn a_disk_that_fills_up_costs_no_sample() {
    let mut rig = Rig::new();
    let Some(disk) = SmallDisk::mount(&rig.directory.path().join("disk"), 1024) else { return };
    let out = disk.path().join("run.mcap");
    let mut recorder = rig.start_recorder_to(&out, 0);
    rig.publish_blocks(3000);
    assert_eq!(rig.finish(&mut recorder), 0);
    assert_eq!(files_in(disk.path()), [""; 0], "the parts were merged elsewhere");
    assert_eq!(files_in(&rig.fallback()), ["run.mcap"]);
    rig.assert_complete(&rig.fallback().join("run.mcap"));
}
