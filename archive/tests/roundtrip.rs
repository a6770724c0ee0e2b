//! What goes into an archive comes out of it.

#![allow(clippy::unwrap_used, reason = "tests")]

mod common;

use archive::{ArchiveError, Capture, Gap, attachment};
use common::{RATE_HZ, description, recording, sample, samples_in};
use shared_types::LoopStatus;
use tempfile::tempdir;

#[test]
fn a_recording_reads_back_to_the_last_bit() {
    let directory = tempdir().unwrap();
    let path = directory.path().join("capture.mcap");
    std::fs::write(&path, recording(0..2500, 400)).unwrap();
    let capture = Capture::load(&path).unwrap();
    assert_eq!(capture.len(), 2500);
    assert_eq!(capture.rate_hz, RATE_HZ);
    for row in 0..2500 {
        let expected = sample(row as u64);
        assert_eq!(capture.seq[row], expected.seq);
        assert_eq!(capture.tick[row], expected.tick);
        assert_eq!(capture.t_s[row].to_bits(), (expected.tick as f64 / RATE_HZ).to_bits());
        assert_eq!(capture.angle_rad[row].to_bits(), expected.angle_rad.to_bits());
        assert_eq!(capture.torque_mnm[row].to_bits(), expected.torque_mnm.to_bits());
        let column = |column: &Option<Vec<f64>>| column.as_ref().unwrap()[row].to_bits();
        assert_eq!(column(&capture.velocity_rad_s), expected.velocity_rad_s.to_bits());
        assert_eq!(column(&capture.acceleration_rad_s2), expected.acceleration_rad_s2.to_bits());
        assert_eq!(column(&capture.commanded_angle_rad), expected.commanded_angle_rad.to_bits());
        assert_eq!(column(&capture.commanded_torque_mnm), expected.commanded_torque_mnm.to_bits());
        assert_eq!(capture.state.as_ref().unwrap()[row], 2);
        assert_eq!(capture.missed_ticks.as_ref().unwrap()[row], expected.missed_ticks);
        assert_eq!(capture.flags.as_ref().unwrap()[row], expected.flags);
    }
    assert_eq!(capture.gaps, []);
    assert_eq!(capture.ticks_without_sample(), 2);
    assert_eq!(capture.description, Some(description()));
    assert_eq!(capture.attached_text(attachment::MODEL), description().simulated_knob_toml.as_deref());
    assert_eq!(capture.attached_text(attachment::CALIBRATION), Some("torque_offset_mnm = 0.25\n"));
    assert_eq!(capture.attached_text(attachment::EXCITATION), Some("kind = \"paper\"\n"));
    let facts = &capture.metadata[archive::CAPTURE_METADATA];
    assert_eq!(facts["unit.torque_mnm"], "mNm");
    assert_eq!(facts["unit.acceleration_rad_s2"], "rad/s^2");
    assert_eq!(facts["run_id"], "0123456789abcdef");
    assert_eq!(facts["note.seed"], "42");
}

#[test]
fn every_column_of_an_archive_stands_in_the_documentation() {
    let directory = tempdir().unwrap();
    let path = directory.path().join("capture.mcap");
    std::fs::write(&path, recording(0..10, 400)).unwrap();
    let capture = Capture::load(&path).unwrap();
    let documentation = include_str!("../../docs/files.md");
    for (name, values) in archive::columns::of(&capture) {
        assert_eq!(values.len(), 10, "{name}");
        assert!(documentation.contains(name), "{name} is not in docs/files.md");
    }
}

#[test]
fn messages_are_dated_by_the_run_s_clock_and_not_by_the_system_s() {
    let file = recording(0..10, 100);
    let first = mcap::MessageStream::new(&file).unwrap().next().unwrap().unwrap();
    assert_eq!(first.log_time, 1_700_000_000_000_000_000);
    let last = mcap::MessageStream::new(&file).unwrap().last().unwrap().unwrap();
    assert_eq!(last.log_time, 1_700_000_000_000_000_000 + 9 * 100_000);
    assert_eq!(last.publish_time, last.log_time);
}

#[test]
fn a_system_clock_stepped_an_hour_either_way_moves_no_message() {
    const HOUR_NS: u64 = 3_600_000_000_000;
    let run = common::description();
    let mut writer = archive::CaptureWriter::new(std::io::Cursor::new(Vec::new()), &run).unwrap();
    let clock = run.clock;
    for seq in 0..300 {
        let sample = sample(seq);
        assert!(writer.sample(&sample).unwrap());
        // What the system clock says when the loop reports: an hour ahead, right, and an hour behind.
        let stepped = clock.wall_clock(sample.monotonic_time_ns) + HOUR_NS - (seq / 100) * HOUR_NS;
        let monotonic_time_ns = sample.monotonic_time_ns;
        let status = LoopStatus { monotonic_time_ns, wall_clock_time_ns: stepped, ..LoopStatus::default() };
        writer.status(&status).unwrap();
    }
    let file = writer.finish().unwrap().1.into_inner();
    let times: Vec<u64> = mcap::MessageStream::new(&file).unwrap().map(|message| message.unwrap().log_time).collect();
    assert_eq!(times.len(), 600);
    assert!(times.is_sorted(), "log times never fall");
    let expected = (0..300).flat_map(|seq| [clock.wall_clock(sample(seq).monotonic_time_ns); 2]);
    assert!(times.iter().copied().eq(expected), "log time is the run's clock, whatever the system's says");
}

#[test]
fn the_header_names_the_field_s_profile_and_this_program() {
    let file = recording(0..3, 100);
    let mut records = mcap::read::LinearReader::new(&file).unwrap();
    let Some(Ok(mcap::records::Record::Header(header))) = records.next() else { panic!("no header") };
    assert_eq!(header.profile, "ros2");
    assert_eq!(header.library, concat!("haptic-camera ", env!("CARGO_PKG_VERSION")));
}

#[test]
fn a_sample_that_comes_twice_is_written_once_and_one_that_never_comes_is_a_gap() {
    let file = recording([0, 1, 2, 1, 2, 3, 7, 8], 100);
    let seqs: Vec<u64> = samples_in(&file).into_iter().map(|(seq, _)| seq).collect();
    assert_eq!(seqs, [0, 1, 2, 3, 7, 8]);
    let directory = tempdir().unwrap();
    let path = directory.path().join("capture.mcap");
    std::fs::write(&path, file).unwrap();
    assert_eq!(Capture::load(&path).unwrap().gaps, [Gap { first_missing_seq: 4, last_missing_seq: 6, count: 3 }]);
}

#[test]
fn a_capture_made_in_memory_reads_back_from_mcap_and_from_csv() {
    let directory = tempdir().unwrap();
    let angle: Vec<f64> = (0..500).map(|row| sample(row).angle_rad).collect();
    let torque: Vec<f64> = (0..500).map(|row| sample(row).torque_mnm).collect();
    let made = Capture {
        velocity_rad_s: Some((0..500).map(|row| sample(row).velocity_rad_s).collect()),
        contact: Some((0..500).map(|row| f64::from(u8::from(row > 300))).collect()),
        ..Capture::from_columns(7_000.0, angle, torque)
    };
    for name in ["made.mcap", "made.csv"] {
        let path = directory.path().join(name);
        if name.ends_with("csv") { made.write_csv(&path) } else { made.write_mcap(&path) }.unwrap();
        let read = Capture::load(&path).unwrap();
        assert_eq!(read.rate_hz, 7_000.0, "{name}");
        assert_eq!(read.t_s, made.t_s, "{name}");
        assert_eq!(read.tick, made.tick, "{name}");
        assert_eq!(read.angle_rad, made.angle_rad, "{name}");
        assert_eq!(read.torque_mnm, made.torque_mnm, "{name}");
        assert_eq!(read.velocity_rad_s, made.velocity_rad_s, "{name}");
        assert_eq!(read.contact, made.contact, "{name}");
        assert_eq!(read.acceleration_rad_s2, None, "{name}");
        assert_eq!(read.commanded_angle_rad, None, "{name}");
    }
}

#[test]
fn a_recorded_capture_can_be_written_again_with_another_torque() {
    let directory = tempdir().unwrap();
    let (one, other) = (directory.path().join("one.mcap"), directory.path().join("other.mcap"));
    std::fs::write(&one, recording(0..1500, 400)).unwrap();
    let like = Capture::load(&one).unwrap();
    let simulated = Capture { torque_mnm: vec![0.5; like.len()], ..like.clone() };
    simulated.write_mcap(&other).unwrap();
    let read = Capture::load(&other).unwrap();
    assert_eq!(read.torque_mnm, simulated.torque_mnm);
    assert_eq!((read.tick, read.t_s, read.angle_rad), (like.tick, like.t_s, like.angle_rad));
    assert_eq!((read.state, read.description), (like.state, like.description));
    assert_eq!((read.missed_ticks, read.flags), (like.missed_ticks, like.flags));
    assert_eq!(read.attachments[attachment::EXCITATION], like.attachments[attachment::EXCITATION]);
}

#[test]
fn a_table_of_uneven_times_cannot_become_an_archive_of_ticks() {
    let directory = tempdir().unwrap();
    let path = directory.path().join("uneven.csv");
    std::fs::write(&path, "t_s,angle_rad,torque_mnm\n0,1,1\n1,1,1\n2,1,1\n2.001,1,1\n").unwrap();
    let uneven = Capture::load(&path).unwrap();
    let refused = uneven.write_mcap(&directory.path().join("uneven.mcap"));
    assert!(matches!(refused, Err(ArchiveError::SharedTick { row: 4, .. })), "{refused:?}");
    assert!(!directory.path().join("uneven.mcap").exists());
    assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 1, "nothing half-made stays");
}

/// An archive as another version of the program might have written it.
fn archive_of_another_version(schema: &str, message: impl Fn(u64) -> Vec<u8>) -> Vec<u8> {
    let mut file = std::io::Cursor::new(Vec::new());
    let mut writer = mcap::Writer::new(&mut file).unwrap();
    let schema = writer.add_schema("haptic_camera/msg/Sample", "ros2msg", schema.as_bytes()).unwrap();
    let channel_id = writer.add_channel(schema, "/sample", "cdr", &std::collections::BTreeMap::new()).unwrap();
    let metadata = [("rate_hz".to_owned(), "2000".to_owned())].into();
    writer.write_metadata(&mcap::records::Metadata { name: "capture".to_owned(), metadata }).unwrap();
    for seq in 0..5 {
        let header = mcap::records::MessageHeader { channel_id, sequence: 0, log_time: seq, publish_time: seq };
        let body = [vec![0, 1, 0, 0], message(seq)].concat();
        writer.write_to_known_channel(&header, &body).unwrap();
    }
    writer.finish().unwrap();
    drop(writer);
    file.into_inner()
}

#[test]
fn an_archive_of_another_version_opens_by_the_names_in_its_own_schema() {
    let directory = tempdir().unwrap();
    let path = directory.path().join("older.mcap");
    let schema =
        "uint8 colour\nfloat32 torque_mnm  # other type, other place\nfloat64 angle_rad\nuint32 tick\nuint64 seq\n";
    let file = archive_of_another_version(schema, |seq| {
        let mut body = vec![9, 0, 0, 0];
        body.extend((seq as f32 * 0.5).to_le_bytes());
        body.extend((seq as f64 * 0.25).to_le_bytes());
        body.extend(u32::try_from(seq * 2).unwrap().to_le_bytes());
        body.extend([0; 4]);
        body.extend(seq.to_le_bytes());
        body
    });
    std::fs::write(&path, file).unwrap();
    let capture = Capture::load(&path).unwrap();
    assert_eq!(capture.torque_mnm, [0.0, 0.5, 1.0, 1.5, 2.0]);
    assert_eq!(capture.angle_rad, [0.0, 0.25, 0.5, 0.75, 1.0]);
    assert_eq!(capture.t_s, [0.0, 0.001, 0.002, 0.003, 0.004]);
    assert_eq!((capture.velocity_rad_s, capture.state), (None, None));
    assert_eq!((capture.missed_ticks, capture.flags), (None, None));
    let overview = archive::Overview::read(&path).unwrap();
    assert_eq!((overview.samples, overview.rate_hz, overview.duration_s), (5, capture.rate_hz, capture.t_s[4]));
}

#[test]
fn a_table_that_begins_late_is_as_long_as_from_its_first_row_to_its_last() {
    let directory = tempdir().unwrap();
    let [table, saved] = ["late.csv", "late.mcap"].map(|name| directory.path().join(name));
    let rows: String = (0..=1000).map(|row| format!("{},{row},0\n", 300.0 + 0.01 * f64::from(row))).collect();
    std::fs::write(&table, format!("t_s,angle_rad,torque_mnm\n{rows}")).unwrap();
    let capture = Capture::load(&table).unwrap();
    capture.write_mcap(&saved).unwrap();
    assert_eq!(capture.duration_s(), 10.0);
    assert_eq!([table, saved].map(|path| archive::Overview::read(&path).unwrap().duration_s), [10.0; 2]);
}

#[test]
fn an_archive_whose_samples_lack_the_torque_is_refused_by_name() {
    let directory = tempdir().unwrap();
    let path = directory.path().join("other.mcap");
    let schema = "uint64 seq\nuint64 tick\nfloat64 angle_rad\n";
    std::fs::write(&path, archive_of_another_version(schema, |seq| [seq.to_le_bytes(); 3].concat())).unwrap();
    let refused = Capture::load(&path).unwrap_err().to_string();
    assert!(refused.ends_with("without the field `torque_mnm`; it has: seq, tick, angle_rad"), "{refused}");
}

#[test]
fn a_sample_shorter_than_its_schema_is_refused() {
    let directory = tempdir().unwrap();
    let path = directory.path().join("short.mcap");
    let schema = "uint64 seq\nuint64 tick\nfloat64 angle_rad\nfloat64 torque_mnm\n";
    std::fs::write(&path, archive_of_another_version(schema, |seq| seq.to_le_bytes().to_vec())).unwrap();
    let refused = Capture::load(&path).unwrap_err();
    assert!(matches!(refused, ArchiveError::Damaged { .. }), "{refused}");
}

/// A disk that takes so many bytes and then is full.
struct SmallDisk {
    bytes: std::io::Cursor<Vec<u8>>,
    room: usize,
}

impl std::io::Write for SmallDisk {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let fits = bytes.len().min(self.room);
        if fits == 0 && !bytes.is_empty() {
            return Err(std::io::Error::from(std::io::ErrorKind::StorageFull));
        }
        self.room -= fits;
        self.bytes.write(&bytes[..fits])
    }
    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

impl std::io::Seek for SmallDisk {
    fn seek(&mut self, to: std::io::SeekFrom) -> std::io::Result<u64> {
        self.bytes.seek(to)
    }
}

#[test]
fn a_full_disk_is_reported_by_the_write_that_meets_it_and_by_every_later_one() {
    let disk = SmallDisk { bytes: std::io::Cursor::new(Vec::new()), room: 20_000 };
    let mut writer = archive::CaptureWriter::new(disk, &description()).unwrap();
    let mut failed = false;
    for seq in 0..2_000 {
        let written = writer.sample(&sample(seq)).and_then(|_| if seq % 100 == 99 { writer.flush() } else { Ok(()) });
        assert!(!(failed && written.is_ok() && seq % 100 == 99), "a dead writer came back to life");
        failed |= written.is_err();
    }
    assert!(failed);
    assert!(matches!(writer.finish(), Err(ArchiveError::Write { .. })));
}

#[test]
fn the_last_sample_of_a_run_whose_sensor_failed_shows_the_fault_and_is_no_measurement() {
    let with_acceleration = |seq| shared_types::Sample { acceleration_rad_s2: 1.0, ..sample(seq) };
    let fault = shared_types::LoopState::Fault.code();
    for failed in [
        shared_types::Sample { angle_rad: f64::NAN, torque_mnm: f64::NAN, state: fault, ..with_acceleration(10) },
        shared_types::Sample { acceleration_rad_s2: f64::NAN, state: fault, ..sample(10) },
    ] {
        let directory = tempdir().unwrap();
        let path = directory.path().join("capture.mcap");
        let mut file = std::io::Cursor::new(Vec::new());
        let mut writer = archive::CaptureWriter::new(&mut file, &description()).unwrap();
        for seq in 0..10 {
            writer.sample(&with_acceleration(seq)).unwrap();
        }
        writer.sample(&failed).unwrap();
        writer.finish().unwrap();
        std::fs::write(&path, file.into_inner()).unwrap();
        let capture = Capture::load(&path).unwrap();
        assert_eq!(capture.len(), 10);
        assert!(capture.gaps.is_empty());
    }
}

#[test]
fn samples_are_dated_by_when_they_were_read_and_those_that_repeat_an_earlier_one_are_left_out() {
    let directory = tempdir().unwrap();
    let path = directory.path().join("capture.mcap");
    let mut file = std::io::Cursor::new(Vec::new());
    let mut writer = archive::CaptureWriter::new(&mut file, &description()).unwrap();
    for seq in 0..10 {
        let flags = if seq == 4 || seq == 5 { shared_types::Sample::STALE } else { 0 };
        writer.sample(&shared_types::Sample { flags, measured_after_s: 2e-5, ..sample(seq) }).unwrap();
    }
    writer.finish().unwrap();
    std::fs::write(&path, file.into_inner()).unwrap();
    let capture = Capture::load(&path).unwrap();
    assert_eq!(capture.seq, [0, 1, 2, 3, 6, 7, 8, 9]);
    assert_eq!((capture.unmeasured_samples(), capture.gaps.len()), (2, 0));
    for (t_s, tick) in capture.t_s.iter().zip(&capture.tick) {
        assert_eq!(*t_s, *tick as f64 / capture.rate_hz + 2e-5);
    }
}

#[test]
fn a_copy_keeps_what_was_not_measured_what_was_lost_and_the_fault() {
    use shared_types::{LoopState, Sample};
    let directory = tempdir().unwrap();
    let [path, copy] = ["capture.mcap", "copy.mcap"].map(|name| directory.path().join(name));
    let run = shared_types::RunDescription { rendered_model_toml: Some(String::new()), ..description() };
    let mut file = std::io::Cursor::new(Vec::new());
    let mut writer = archive::CaptureWriter::new(&mut file, &run).unwrap();
    for seq in [0, 1, 2, 3, 4, 5, 8, 9] {
        let (flags, device_code) = if seq == 4 { (Sample::STALE, 7) } else { (0, 0) };
        writer.sample(&Sample { flags, device_code, ..sample(seq) }).unwrap();
    }
    let state = LoopState::Fault.code();
    let failed = Sample { torque_mnm: f64::NAN, state, fault: 5, device_code: 9, flags: 0, ..sample(10) };
    writer.sample(&failed).unwrap();
    writer.published(13);
    writer.finish().unwrap();
    std::fs::write(&path, file.into_inner()).unwrap();
    let capture = Capture::load(&path).unwrap();
    assert_eq!((capture.seq.len(), capture.unmeasured_samples(), capture.lost_samples()), (7, 2, 4));
    // As every program loads it, and as it is saved.
    capture.clone().of_knob().of_knob().write_mcap(&copy).unwrap();
    let again = Capture::load(&copy).unwrap();
    assert_eq!((&again.seq, &again.gaps), (&capture.seq, &capture.gaps));
    assert_eq!(again.commanded_torque_mnm, capture.commanded_torque_mnm);
    assert_eq!(again.lost_samples(), 4);
    assert_eq!(again.rig.stale_samples, [(7, 1)].into());
    let [before, after] = [&capture, &again].map(|one| one.unmeasured.iter().map(|s| (s.seq, s.fault, s.device_code)));
    assert!(before.clone().eq([(4, 0, 7), (10, 5, 9)]) && after.eq(before));
    assert!(archive::Overview::read(&copy).unwrap().fault);
}

#[test]
fn a_replay_whose_description_was_lost_is_known_by_its_models() {
    let capture = Capture::from_columns(1e3, vec![0.0; 3], vec![1.0; 3]);
    assert_eq!(capture.clone().of_knob().torque_mnm, [1.0; 3]);
    let run = shared_types::RunDescription { rendered_model_toml: Some(String::new()), ..description() };
    let replay = Capture { models: run.first_model().into_iter().collect(), ..capture };
    assert_eq!(replay.of_knob().torque_mnm, [-1.0; 3]);
}

#[test]
fn what_a_rig_left_unanswered_is_counted_by_its_reason_and_its_clocks_drift_reported() {
    let directory = tempdir().unwrap();
    let path = directory.path().join("capture.mcap");
    let mut file = std::io::Cursor::new(Vec::new());
    let mut writer = archive::CaptureWriter::new(&mut file, &description()).unwrap();
    for seq in 0..3_000 {
        let ordinary = shared_types::Sample { flags: 0, measured_after_s: -3e-5, ..sample(seq) };
        // A clock that is 100 ppm fast.
        let monotonic_time_ns = 5_000_000_000 + (ordinary.tick as f64 * 1e5 / (1.0 + 1e-4)) as u64;
        let (flags, device_code) = match seq {
            100..120 => (shared_types::Sample::STALE, (-7_i32).cast_unsigned()),
            200 => (shared_types::Sample::STALE, 0),
            _ => (0, 0),
        };
        writer.sample(&shared_types::Sample { monotonic_time_ns, flags, device_code, ..ordinary }).unwrap();
    }
    writer.finish().unwrap();
    std::fs::write(&path, file.into_inner()).unwrap();
    let account = Capture::load(&path).unwrap().rig;
    assert_eq!(account, archive::Overview::read(&path).unwrap().rig);
    assert_eq!(account.stale_samples, [(-7, 20), (0, 1)].into());
    let clock = account.clock.unwrap();
    assert!((clock.drift_ppm - 100.0).abs() < 0.1, "{clock:?}");
    assert!((clock.phase_s + 3e-5).abs() < 1e-12 && clock.phase_deviation_s < 1e-12, "{clock:?}");
    let run =
        shared_types::RunDescription { device_codes: vec![(-7, "a frame was lost; look".to_owned())], ..description() };
    let lines = account.in_words(&run, 0);
    assert_eq!(lines[0], "20 ticks without new data: a frame was lost");
    assert_eq!(lines.len(), 3, "{lines:?}");
    assert_eq!(account.in_words(&run, -7).len(), 2, "what ended the run is reported with its end");
}
