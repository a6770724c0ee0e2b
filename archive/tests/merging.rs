//! Parts become one archive, each sample once.

#![allow(clippy::unwrap_used, reason = "tests")]

mod common;

use std::io::Cursor;
use std::path::PathBuf;

use archive::{ArchiveError, Capture, CaptureWriter, Gap, merge};
use common::{RUN_ID, assert_nothing_invented, chunks_of, recording, sample, samples_in};
use shared_types::ModelChange;
use tempfile::TempDir;

fn parts(directory: &TempDir, contents: &[Vec<u8>]) -> Vec<PathBuf> {
    contents
        .iter()
        .enumerate()
        .map(|(number, content)| {
            let path = directory.path().join(format!("run.mcap.part-{number:03}"));
            std::fs::write(&path, content).unwrap();
            path
        })
        .collect()
}

#[test]
fn overlapping_parts_give_each_sample_once_and_in_order() {
    let directory = tempfile::tempdir().unwrap();
    let parts = parts(&directory, &[recording(0..450, 100), recording(300..900, 100), recording(850..1000, 100)]);
    let out = directory.path().join("run.mcap");
    let merged = merge(&parts, &out, Some(1000)).unwrap();
    assert_eq!((merged.ledger.admitted(), merged.ledger.missing(), merged.bytes_dropped), (1000, 0, 0));
    let samples = samples_in(&std::fs::read(&out).unwrap());
    assert_eq!(samples.len(), 1000);
    assert_nothing_invented(&samples);
    let capture = Capture::load(&out).unwrap();
    assert_eq!(capture.gaps, []);
    assert!(!capture.metadata.contains_key(archive::GAPS_METADATA));
    assert_eq!(capture.description, Some(common::description()));
}

#[test]
fn reports_that_two_parts_received_come_once() {
    let directory = tempfile::tempdir().unwrap();
    // The reports of both parts at sample 400 are the same bytes.
    let parts = parts(&directory, &[recording(0..450, 100), recording(300..700, 100)]);
    let out = directory.path().join("run.mcap");
    let merged = merge(&parts, &out, None).unwrap();
    // Status, estimate and health each at samples 100 to 400 and 500 to 600.
    assert_eq!(merged.messages, 700 + 3 * 6);
}

#[test]
fn rendered_models_come_once_and_in_order_with_the_ticks_from_which_they_are_felt() {
    let directory = tempfile::tempdir().unwrap();
    let model = |tick: u64| ModelChange {
        run_id: RUN_ID,
        tick,
        monotonic_time_ns: sample(0).monotonic_time_ns + tick * 100_000,
        model_toml: format!("name = \"felt from {tick} on, θ\"\n"),
    };
    let part = |seqs: std::ops::Range<u64>, ticks: &[u64]| {
        let mut writer = CaptureWriter::new(Cursor::new(Vec::new()), &common::description()).unwrap();
        ticks.iter().for_each(|tick| writer.model(&model(*tick)).unwrap());
        seqs.for_each(|seq| assert!(writer.sample(&sample(seq)).unwrap()));
        writer.finish().unwrap().1.into_inner()
    };
    // A recorder that was started again received the first two once more.
    let parts = parts(&directory, &[part(0..450, &[0, 300]), part(300..900, &[0, 300, 700])]);
    let out = directory.path().join("run.mcap");
    merge(&parts, &out, Some(900)).unwrap();
    let capture = Capture::load(&out).unwrap();
    assert_eq!(capture.models, [0, 300, 700].map(model));
    let again = directory.path().join("again.mcap");
    capture.write_mcap(&again).unwrap();
    assert_eq!(Capture::load(&again).unwrap().models, capture.models);
    assert_eq!(Capture::load(&parts[0]).unwrap().models.len(), 2);
}

#[test]
fn parts_cut_off_anywhere_fill_each_other() {
    let directory = tempfile::tempdir().unwrap();
    let first = recording(0..500, 100);
    let second = recording(350..800, 100);
    let cut = chunks_of(&first)[5].start + 50;
    for length in [cut, cut + 1000, cut + 2500] {
        let parts = parts(&directory, &[first[..length].to_vec(), second.clone()]);
        let out = directory.path().join("run.mcap");
        let merged = merge(&parts, &out, Some(800)).unwrap();
        assert_eq!((merged.ledger.admitted(), merged.ledger.missing()), (800, 0));
        assert!(merged.bytes_dropped > 0);
        assert_nothing_invented(&samples_in(&std::fs::read(&out).unwrap()));
    }
}

#[test]
fn samples_that_no_part_has_under_a_checksum_are_counted() {
    let directory = tempfile::tempdir().unwrap();
    // Chunks so long that a cut leaves whole blocks of one; the first of the file has the channels only.
    let second = recording(400..6400, 3000);
    let chunk = chunks_of(&second)[2].clone();
    let cut = chunk.start + chunk.len() / 2;
    let parts = parts(&directory, &[recording(0..500, 100), second[..cut].to_vec()]);
    let merged = merge(&parts, &directory.path().join("run.mcap"), None).unwrap();
    assert!(merged.unchecked_samples > 0);
    assert_eq!(merged.ledger.admitted(), 3400 + merged.unchecked_samples);
}

#[test]
fn what_no_part_has_is_a_gap_at_the_start_between_and_at_the_end() {
    let directory = tempfile::tempdir().unwrap();
    let parts = parts(&directory, &[recording(5..100, 100), recording(150..200, 100)]);
    let out = directory.path().join("run.mcap");
    let merged = merge(&parts, &out, Some(210)).unwrap();
    let expected = [
        Gap { first_missing_seq: 0, last_missing_seq: 4, count: 5 },
        Gap { first_missing_seq: 100, last_missing_seq: 149, count: 50 },
        Gap { first_missing_seq: 200, last_missing_seq: 209, count: 10 },
    ];
    assert_eq!(merged.ledger.gaps(), expected);
    let capture = Capture::load(&out).unwrap();
    assert_eq!(capture.gaps, expected);
    assert_eq!(capture.metadata[archive::GAPS_METADATA]["missing_samples"], "65");
}

#[test]
fn a_later_part_fills_a_hole_inside_an_earlier_one() {
    let directory = tempfile::tempdir().unwrap();
    let with_hole = recording((0..100).chain(200..500), 100);
    let parts = parts(&directory, &[with_hole, recording(90..400, 100)]);
    let merged = merge(&parts, &directory.path().join("run.mcap"), Some(500)).unwrap();
    assert_eq!((merged.ledger.admitted(), merged.ledger.missing()), (500, 0));
}

#[test]
fn a_part_killed_at_birth_and_a_hundred_restarts_do_no_harm() {
    let directory = tempfile::tempdir().unwrap();
    let mut contents = vec![Vec::new(), recording(0..3, 100)[..40].to_vec(), recording([], 100)];
    contents.extend((0..100).map(|restart| recording(restart * 20..restart * 20 + 50, 100)));
    let parts = parts(&directory, &contents);
    let out = directory.path().join("run.mcap");
    let merged = merge(&parts, &out, Some(2030)).unwrap();
    assert_eq!((merged.ledger.admitted(), merged.ledger.missing()), (2030, 0));
    assert_nothing_invented(&samples_in(&std::fs::read(&out).unwrap()));
}

#[test]
fn parts_of_two_runs_are_not_mixed() {
    let directory = tempfile::tempdir().unwrap();
    let run = shared_types::RunDescription { run_id: 99, ..common::description() };
    let writer = archive::CaptureWriter::new(std::io::Cursor::new(Vec::new()), &run).unwrap();
    let other = writer.finish().unwrap().1.into_inner();
    let parts = parts(&directory, &[recording(0..10, 100), other]);
    let out = directory.path().join("run.mcap");
    assert!(matches!(merge(&parts, &out, None), Err(ArchiveError::OtherRun { found: 99, .. })));
    assert!(!out.exists());
    assert_eq!(archive::run_id(&parts[0]).unwrap(), Some(common::RUN_ID));
}
