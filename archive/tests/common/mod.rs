//! Recordings that the tests write, and an independent way to read them.

#![allow(dead_code, unreachable_pub, clippy::unwrap_used, reason = "shared by several test programs")]

use std::io::Cursor;

use archive::CaptureWriter;
use shared_types::wire::WireMessage;
use shared_types::{ClockMapping, FitUpdate, LoopStatus, ProcessHealth, RunDescription, Sample};

pub const RATE_HZ: f64 = 10_000.0;
pub const RUN_ID: u64 = 0x0123_4567_89ab_cdef;

pub fn description() -> RunDescription {
    RunDescription {
        run_id: RUN_ID,
        software_version: "0.1.0".to_owned(),
        apparatus: "sim".to_owned(),
        knob: "3".to_owned(),
        rate_hz: RATE_HZ,
        planned_ticks: 100_000,
        clock: ClockMapping { monotonic_time_ns: 5_000_000_000, wall_clock_time_ns: 1_700_000_000_000_000_000 },
        realtime: 7,
        torque_late_ticks: None,
        excitation_toml: "kind = \"paper\"\n".to_owned(),
        calibration_toml: "torque_offset_mnm = 0.25\n".to_owned(),
        simulated_knob_toml: Some("[[effects]]\nname = \"inertia\"\n".to_owned()),
        notes: vec![("seed".to_owned(), "42".to_owned())],
        ..RunDescription::default()
    }
}

/// A sample whose every value depends on `seq` and uses all bits of its mantissa.
pub fn sample(seq: u64) -> Sample {
    let noise = |salt: u64| {
        let mut x = (seq + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ salt.wrapping_mul(0xd1b5_4a32_d192_ed03);
        x ^= x >> 29;
        x = x.wrapping_mul(0xbf58_476d_1ce4_e5b9);
        (x ^ (x >> 32)) as f64 / u64::MAX as f64 - 0.5
    };
    let tick = seq + seq / 1000;
    let time = tick as f64 / RATE_HZ;
    Sample {
        seq,
        tick,
        monotonic_time_ns: 5_000_000_000 + tick * 100_000,
        lateness_ns: 70 + seq % 50,
        angle_rad: (time * 3.0).sin() + noise(1) * 1e-5,
        velocity_rad_s: 3.0 * (time * 3.0).cos() + noise(2) * 1e-2,
        acceleration_rad_s2: noise(3) * 2.8,
        torque_mnm: 12.0 * (time * 25.0).sin() + noise(4) * 0.18,
        contact: f64::NAN,
        commanded_angle_rad: (time * 3.0).sin(),
        commanded_torque_mnm: noise(5) * 40.0,
        measured_after_s: 0.0,
        sensor_read_ns: 900,
        control_ns: 300,
        push_ns: 60,
        missed_ticks: u32::from(seq > 0 && seq.is_multiple_of(1000)),
        dropped_samples: 0,
        state: 2,
        fault: 0,
        flags: (seq % 16) as u32,
        device_code: 0,
        stale_ticks: 0,
    }
}

/// A recording in memory, a chunk of `chunk` samples at a time, with the other channels in between.
pub fn recording(seqs: impl IntoIterator<Item = u64>, chunk: usize) -> Vec<u8> {
    let mut writer = CaptureWriter::new(Cursor::new(Vec::new()), &description()).unwrap();
    for (count, seq) in seqs.into_iter().enumerate() {
        if count > 0 && count % chunk == 0 {
            let monotonic_time_ns = sample(seq).monotonic_time_ns;
            writer.status(&LoopStatus { run_id: RUN_ID, monotonic_time_ns, ..LoopStatus::default() }).unwrap();
            writer
                .fit(&FitUpdate { run_id: RUN_ID, monotonic_time_ns, latest_tick: seq, ..FitUpdate::default() })
                .unwrap();
            writer.health(&ProcessHealth { monotonic_time_ns, process: 1, ..ProcessHealth::default() }).unwrap();
            writer.flush().unwrap();
        }
        writer.sample(&sample(seq)).unwrap();
    }
    writer.finish().unwrap().1.into_inner()
}

/// `seq` and body of every sample in a whole file, read with the mcap crate's own reader.
pub fn samples_in(file: &[u8]) -> Vec<(u64, Vec<u8>)> {
    mcap::MessageStream::new(file)
        .unwrap()
        .map(Result::unwrap)
        .filter(|message| message.channel.topic == "/sample")
        .map(|message| (u64::from_le_bytes(message.data[4..12].try_into().unwrap()), message.data[4..].to_vec()))
        .collect()
}

/// Asserts that every sample is, bit for bit, the one that was recorded under its `seq`.
pub fn assert_nothing_invented(samples: &[(u64, Vec<u8>)]) {
    for (seq, body) in samples {
        assert!(body == sample(*seq).wire_bytes(), "sample {seq} differs from what was recorded");
    }
    assert!(samples.windows(2).all(|pair| pair[0].0 < pair[1].0), "samples are out of order");
}

/// Where each chunk begins and ends in a whole file.
pub fn chunks_of(file: &[u8]) -> Vec<std::ops::Range<usize>> {
    let summary = mcap::Summary::read(file).unwrap().unwrap();
    summary
        .chunk_indexes
        .iter()
        .map(|index| {
            let start = usize::try_from(index.chunk_start_offset).unwrap();
            start..start + usize::try_from(index.chunk_length).unwrap()
        })
        .collect()
}
