//! What is left of a broken archive is kept, and nothing else.

#![allow(clippy::unwrap_used, reason = "tests")]

mod common;

use std::io::Cursor;
use std::path::Path;

use archive::recover::recover_stream;
use archive::{ArchiveError, Capture, Gap, Place, RecoverySummary, Unchecked, recover};
use common::{RATE_HZ, assert_nothing_invented, chunks_of, recording, sample, samples_in};

fn recovered(broken: &[u8]) -> Result<(RecoverySummary, Vec<u8>), ArchiveError> {
    recovered_with(broken, Unchecked::LeaveOut)
}

fn recovered_with(broken: &[u8], unchecked: Unchecked) -> Result<(RecoverySummary, Vec<u8>), ArchiveError> {
    let mut whole = Cursor::new(Vec::new());
    let summary = recover_stream(broken, &mut whole, Path::new("broken.mcap"), unchecked)?;
    Ok((summary, whole.into_inner()))
}

fn gaps(summary: &RecoverySummary) -> Vec<Gap> {
    summary.gaps().collect()
}

/// The bounds of what was kept, as they must be for samples `first` to `last`.
fn place(seq: u64) -> Option<Place> {
    Some(Place { seq, tick: Some(sample(seq).tick) })
}

/// Every bit with `HAPTIC_CAMERA_ALL_BITS` set, which takes minutes; else one in 47, over all bits of a byte.
fn some_of(bits: usize) -> impl Iterator<Item = usize> {
    (0..bits).step_by(if std::env::var_os("HAPTIC_CAMERA_ALL_BITS").is_some() { 1 } else { 47 })
}

#[test]
fn a_whole_archive_recovers_whole() {
    let file = recording(0..1000, 100);
    let (summary, whole) = recovered(&file).unwrap();
    assert_eq!((summary.samples_kept, summary.messages_kept), (1000, 1000 + 9 * 3));
    assert_eq!((summary.bytes_dropped, summary.unchecked_samples), (0, 0));
    assert!(summary.finished && !summary.lossy && summary.losses.is_empty());
    assert_eq!(samples_in(&whole), samples_in(&file));
}

#[test]
fn every_truncation_of_the_last_two_chunks_keeps_every_complete_chunk() {
    let file = recording(0..100, 20);
    let chunks = chunks_of(&file);
    let original = samples_in(&file);
    let from = chunks[chunks.len() - 2].start;
    for length in from..file.len() {
        // The first chunk holds the channels only.
        let complete = chunks.iter().skip(1).filter(|chunk| chunk.end <= length).count() * 20;
        let (summary, whole) = recovered(&file[..length]).unwrap();
        let kept = samples_in(&whole);
        assert_eq!(kept.len(), complete, "cut at {length}");
        assert_eq!(kept[..], original[..kept.len()], "cut at {length}");
        assert_eq!(summary.samples_kept, kept.len() as u64);
        assert_eq!((summary.first, summary.last), (place(0), place(complete as u64 - 1)));
        assert!(summary.lossy || kept.len() == original.len(), "cut at {length}: a loss was not reported");
        assert_eq!(summary.bytes_total, length as u64);
        let planned_ticks = common::description().planned_ticks;
        assert_eq!(summary.ticks_left, Some(planned_ticks - 1 - sample(complete as u64 - 1).tick));

        if length >= chunks[chunks.len() - 1].end {
            continue;
        }
        let (with_unchecked, whole) = recovered_with(&file[..length], Unchecked::Keep).unwrap();
        let kept = samples_in(&whole);
        assert_eq!(kept[..], original[..kept.len()], "cut at {length}");
        assert_eq!(with_unchecked.unchecked_samples, (kept.len() - complete) as u64, "cut at {length}");
        assert_eq!(with_unchecked.unchecked_samples, summary.unchecked_samples, "what was left out is counted");
    }
}

#[test]
fn whatever_bit_is_flipped_only_the_chunk_that_holds_it_is_lost() {
    let file = recording(0..60, 20);
    let original = samples_in(&file);
    for bit in some_of(file.len() * 8) {
        let mut flipped = file.clone();
        flipped[bit / 8] ^= 1 << (bit % 8);
        let (summary, whole) = recovered(&flipped).unwrap();
        let kept = samples_in(&whole);
        assert_nothing_invented(&kept);
        assert!(kept.len() >= 40, "bit {bit}: {} samples kept", kept.len());
        assert!(summary.lossy || kept.len() == original.len(), "bit {bit}: a loss was not reported");
    }
}

#[test]
fn a_flip_in_a_truncated_archive_invents_nothing_either() {
    let file = recording(0..60, 20);
    let chunks = chunks_of(&file);
    for cut in [chunks[2].end, chunks[3].start + chunks[3].len() / 2] {
        for bit in some_of(cut * 8) {
            let mut flipped = file[..cut].to_vec();
            flipped[bit / 8] ^= 1 << (bit % 8);
            match recovered(&flipped) {
                Ok((summary, whole)) => {
                    assert_nothing_invented(&samples_in(&whole));
                    assert!(summary.lossy);
                }
                Err(error) => assert!(matches!(error, ArchiveError::NothingToRecover { .. }), "{error}"),
            }
        }
    }
}

#[test]
fn hundreds_of_flips_and_holes_at_once_invent_nothing() {
    let file = recording(0..2000, 100);
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut random = |below: usize| {
        // xorshift64 (G. Marsaglia 2003).
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        usize::try_from(state % below as u64).unwrap()
    };
    let mut kept_in_all = 0;
    for trial in 0..200 {
        let mut broken = file.clone();
        for _ in 0..1 + random(200) {
            let bit = random(broken.len() * 8);
            broken[bit / 8] ^= 1 << (bit % 8);
        }
        if trial % 3 == 0 {
            let start = random(broken.len());
            let end = (start + random(4096)).min(broken.len());
            broken[start..end].fill(0);
        }
        if trial % 4 == 0 {
            broken.truncate(random(file.len()));
        }
        if let Ok((summary, whole)) = recovered(&broken) {
            let samples = samples_in(&whole);
            assert_nothing_invented(&samples);
            assert_eq!(summary.samples_kept, samples.len() as u64);
            assert!(summary.lossy || samples.len() == 2000, "trial {trial}: a loss was not reported");
            let lost: u64 = gaps(&summary).iter().map(|gap| gap.count).sum();
            let end = samples.last().map_or(0, |(seq, _)| seq + 1);
            assert_eq!(samples.len() as u64 + lost, end, "trial {trial}: kept and lost are all there were");
            kept_in_all += samples.len();
        }
    }
    assert!(kept_in_all > 0, "nothing was ever recovered");
}

#[test]
fn a_hole_in_the_middle_is_a_gap_with_its_bounds() {
    let mut file = recording(0..500, 100);
    let hole = chunks_of(&file)[3].clone();
    file[hole.start + 80..hole.end - 10].fill(0);
    let (summary, whole) = recovered(&file).unwrap();
    assert_eq!(gaps(&summary), [Gap { first_missing_seq: 200, last_missing_seq: 299, count: 100 }]);
    assert_eq!((summary.losses[0].after, summary.losses[0].before), (place(199), place(300)));
    assert_eq!(summary.rate_hz, Some(RATE_HZ));
    assert_eq!((summary.samples_kept, summary.damaged_chunks), (400, 1));
    assert_eq!(summary.bytes_dropped, hole.len() as u64);
    assert!(summary.lossy && summary.finished);
    assert_nothing_invented(&samples_in(&whole));
    assert!(
        summary.to_string().contains("100 samples are missing: samples 200 to 299 (100) between 0.0199 s and 0.0300 s")
    );
    assert!(summary.to_string().starts_with("kept 400 samples (0 to 499: 0.0000 s to 0.0499 s)"), "{summary}");
}

#[test]
fn bytes_inserted_in_the_middle_cost_no_sample() {
    let mut file = recording(0..500, 100);
    let place = chunks_of(&file)[3].start;
    file.splice(place..place, (0..1234_u32).map(|byte| u8::try_from(byte % 251).unwrap()));
    let (summary, whole) = recovered(&file).unwrap();
    assert_eq!((summary.samples_kept, summary.bytes_dropped), (500, 1234));
    assert_eq!(samples_in(&whole).len(), 500);
}

#[test]
fn an_archive_whose_first_chunk_is_lost_still_knows_its_channels() {
    let mut file = recording(0..300, 100);
    let first = chunks_of(&file)[0].clone();
    file[first.start + 60] ^= 0x10;
    let (summary, whole) = recovered(&file).unwrap();
    assert_eq!(summary.samples_kept, 300);
    assert_nothing_invented(&samples_in(&whole));
}

#[test]
fn a_recovered_archive_loads_and_recovers_again_to_the_same_samples() {
    let directory = tempfile::tempdir().unwrap();
    let place = |name: &str| directory.path().join(name);
    let file = recording(0..500, 100);
    let broken = &file[..chunks_of(&file)[4].end + 10];
    std::fs::write(place("broken.mcap"), broken).unwrap();
    let summary = recover(&place("broken.mcap"), &place("whole.mcap"), Unchecked::LeaveOut).unwrap();
    assert_eq!(std::fs::read(place("broken.mcap")).unwrap(), broken, "the original is left alone");
    let capture = Capture::load(&place("whole.mcap")).unwrap();
    assert_eq!(capture.len() as u64, summary.samples_kept);
    assert_eq!(capture.description, Some(common::description()));
    assert_eq!(capture.metadata[archive::RECOVERY_METADATA]["samples_kept"], summary.samples_kept.to_string());
    assert_eq!(capture.metadata[archive::CAPTURE_METADATA]["unit.angle_rad"], "rad");
    let again = recover(&place("whole.mcap"), &place("again.mcap"), Unchecked::LeaveOut).unwrap();
    assert_eq!((again.samples_kept, again.bytes_dropped, again.lossy), (summary.samples_kept, 0, false));
    assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 3, "nothing temporary stays");
}

#[test]
fn what_cannot_be_recovered_is_refused_without_leaving_a_file() {
    let directory = tempfile::tempdir().unwrap();
    let place = |name: &str| directory.path().join(name);
    let out = place("out.mcap");
    let recover = |broken: &Path, out: &Path| recover(broken, out, Unchecked::LeaveOut);
    assert!(matches!(recover(&place("none.mcap"), &out), Err(ArchiveError::Missing { .. })));
    for (name, content) in [("text.mcap", b"t_s,angle_rad\n".to_vec()), ("zeros.mcap", vec![0; 5_000_000])] {
        std::fs::write(place(name), content).unwrap();
        assert!(matches!(recover(&place(name), &out), Err(ArchiveError::NothingToRecover { .. })), "{name}");
    }
    std::fs::write(place("empty.mcap"), "").unwrap();
    assert!(matches!(recover(&place("empty.mcap"), &out), Err(ArchiveError::Empty { .. })));
    std::fs::write(place("same.mcap"), recording(0..9, 9)).unwrap();
    assert!(matches!(recover(&place("same.mcap"), &place("same.mcap")), Err(ArchiveError::SameFile { .. })));
    assert!(!out.exists());
}

#[test]
fn a_gap_at_the_end_that_the_recorder_noted_is_reported_again() {
    let mut writer = archive::CaptureWriter::new(Cursor::new(Vec::new()), &common::description()).unwrap();
    for seq in (0..100).chain(150..200) {
        assert!(writer.sample(&sample(seq)).unwrap());
    }
    writer.published(230);
    let file = writer.finish().unwrap().1.into_inner();
    let (summary, whole) = recovered(&file).unwrap();
    let expected = [
        Gap { first_missing_seq: 100, last_missing_seq: 149, count: 50 },
        Gap { first_missing_seq: 200, last_missing_seq: 229, count: 30 },
    ];
    assert_eq!(gaps(&summary), expected);
    assert_eq!((summary.losses[1].after, summary.losses[1].before), (place(199), None));
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("whole.mcap");
    std::fs::write(&path, whole).unwrap();
    assert_eq!(Capture::load(&path).unwrap().gaps, expected);
}

/// Found by `scripts/fuzz`: the mcap crate's reader goes on behind the end of such a chunk.
#[test]
fn a_record_longer_than_its_uncompressed_chunk_is_reported_and_harms_nothing() {
    let record = |opcode: u8, body: &[u8]| [&[opcode], &(body.len() as u64).to_le_bytes()[..], body].concat();
    // A schema whose length reaches over the chunk's end into what follows.
    let records = [&[3_u8][..], &200_u64.to_le_bytes(), &[0; 40]].concat();
    let digest = crc32(&records);
    let length = (records.len() as u64).to_le_bytes();
    let chunk = [&[0; 16][..], &length, &digest.to_le_bytes(), &[0; 4], &length, &records].concat();
    let file =
        [mcap::MAGIC, &record(1, &[0; 8]), &record(6, &chunk), &record(15, &[0; 4]), &record(2, &[0; 20]), mcap::MAGIC]
            .concat();
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("foreign.mcap");
    std::fs::write(&path, &file).unwrap();
    let error = Capture::load(&path).unwrap_err();
    assert!(error.to_string().contains("haptic-camera recover"), "{error}");
    if let Ok((summary, whole)) = recovered(&file) {
        assert_eq!(summary.samples_kept, 0);
        assert_eq!(samples_in(&whole), []);
    }
}

/// CRC-32 as MCAP uses it (ISO 3309), bit by bit.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| if crc & 1 == 1 { (crc >> 1) ^ 0xedb8_8320 } else { crc >> 1 })
    })
}
