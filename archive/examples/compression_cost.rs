//! What recording costs: processor time and bytes per hour, by compression.
//!
//! Writes ten minutes of a 10 kHz run (a slow sweep, detents, sensor noise and quantised sensors as
//! a rig has them) through [`CaptureWriter`], a chunk every 400 ms, to memory.

#![allow(clippy::print_stdout, reason = "a measurement prints its figures")]

use std::io::{Cursor, Seek, SeekFrom, Write};

use archive::CaptureWriter;
use nix::sys::resource::{UsageWho, getrusage};
use synthetic::{RATE_HZ, sample};

#[path = "synthetic/sample.rs"]
mod synthetic;

const SAMPLES: u64 = 6_000_000;
const SAMPLES_PER_CHUNK: u64 = 4_000;

/// Counts bytes and forgets them.
#[derive(Default)]
struct Counter {
    bytes: u64,
    position: Cursor<[u8; 0]>,
}

impl Write for Counter {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.bytes += bytes.len() as u64;
        self.position.set_position(self.bytes);
        Ok(bytes.len())
    }
    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

impl Seek for Counter {
    fn seek(&mut self, to: SeekFrom) -> std::io::Result<u64> {
        self.position.seek(to)
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let cpu_s = || {
        getrusage(UsageWho::RUSAGE_SELF)
            .map(|usage| {
                let time = [usage.user_time(), usage.system_time()];
                time.iter().map(|time| time.tv_sec() as f64 + time.tv_usec() as f64 * 1e-6).sum::<f64>()
            })
            .unwrap_or(f64::NAN)
    };
    let mut random = 88_172_645_463_325_252;
    let start = cpu_s();
    for seq in 0..SAMPLES {
        std::hint::black_box(sample(seq, &mut random));
    }
    let making_s = cpu_s() - start;
    let hours = SAMPLES as f64 / RATE_HZ / 3600.0;
    println!("compression         threads   % of a core    GB/hour   bytes/sample");
    for (name, compression, level, threads) in [
        ("none", None, 0, 0),
        ("lz4", Some(mcap::Compression::Lz4), 0, 0),
        // Levels below zero give up compression for speed; the library passes them on as they are.
        ("zstd level -5", Some(mcap::Compression::Zstd), -5, 0),
        ("zstd level -3", Some(mcap::Compression::Zstd), -3, 0),
        ("zstd level -1", Some(mcap::Compression::Zstd), -1, 0),
        ("zstd level 1", Some(mcap::Compression::Zstd), 1, 0),
        ("zstd level 1", Some(mcap::Compression::Zstd), 1, 1),
        ("zstd level 3", Some(mcap::Compression::Zstd), 3, 1),
    ] {
        let options = mcap::WriteOptions::new()
            .profile("ros2")
            .compression(compression)
            .compression_level(i32::cast_unsigned(level))
            .compression_threads(threads)
            .disable_seeking(true);
        let mut random = 88_172_645_463_325_252;
        let start = cpu_s();
        let mut writer = CaptureWriter::with_options(Counter::default(), &archive::doc_example_description(), options)?;
        for seq in 0..SAMPLES {
            writer.sample(&sample(seq, &mut random))?;
            if seq % SAMPLES_PER_CHUNK == 0 {
                writer.flush()?;
            }
        }
        let (_, counter) = writer.finish()?;
        let share = (cpu_s() - start - making_s) / (SAMPLES as f64 / RATE_HZ) * 100.0;
        let bytes = counter.bytes as f64;
        println!(
            "{name:<19} {threads:>7} {share:>13.2} {:>10.2} {:>14.1}",
            bytes / hours / 1e9,
            bytes / SAMPLES as f64
        );
    }
    Ok(())
}
