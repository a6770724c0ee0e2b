//! How fast archives are written: ours beside what MCAP's own library does with the messages of MCAP's own benchmark.
//!
//! The peer is the fixed-payload case of MCAP's cross-language benchmarks (github.com/foxglove/mcap, `benchmarking/`):
//! a million messages of 100 bytes on one channel, byte i being (137·i + 43) mod 256, in chunks of the library's default
//! size with their CRC. Ours is [`CaptureWriter`] with as many samples of 112 bytes. Both go to a file in the folder that
//! is given; the time ends when the operating system has every byte. Prints one JSON object, messages per second.

#![allow(clippy::print_stdout, reason = "a measurement prints its figures")]

use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::Path;
use std::time::Instant;

use archive::CaptureWriter;
use mcap::records::MessageHeader;
use synthetic::sample;

#[path = "synthetic/sample.rs"]
mod synthetic;

const MESSAGES: u64 = 1_000_000;
const PAYLOAD_BYTES: u32 = 100;

fn peer(path: &Path, compression: Option<mcap::Compression>) -> Result<f64, Box<dyn std::error::Error>> {
    let payload: Vec<u8> = (0..PAYLOAD_BYTES).map(|index| ((index * 137 + 43) & 0xff) as u8).collect();
    let started = Instant::now();
    let mut writer = mcap::WriteOptions::new().compression(compression).create(BufWriter::new(File::create(path)?))?;
    let schema = writer.add_schema("Fixed", "jsonschema", b"{}")?;
    let channel_id = writer.add_channel(schema, "/fixed", "json", &std::collections::BTreeMap::new())?;
    for number in 0..MESSAGES {
        let time_ns = number * 1_000;
        let sequence = u32::try_from(number)?;
        let header = MessageHeader { channel_id, sequence, log_time: time_ns, publish_time: time_ns };
        writer.write_to_known_channel(&header, &payload)?;
    }
    writer.finish()?;
    writer.into_inner().flush()?;
    Ok(MESSAGES as f64 / started.elapsed().as_secs_f64())
}

fn ours(path: &Path) -> Result<f64, Box<dyn std::error::Error>> {
    let mut random = 88_172_645_463_325_252;
    let samples: Vec<_> = (0..MESSAGES).map(|seq| sample(seq, &mut random)).collect();
    let started = Instant::now();
    let mut writer = CaptureWriter::new(BufWriter::new(File::create(path)?), &archive::doc_example_description())?;
    for sample in &samples {
        writer.sample(sample)?;
    }
    let (_, mut file) = writer.finish()?;
    file.flush()?;
    Ok(MESSAGES as f64 / started.elapsed().as_secs_f64())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args().nth(1).ok_or("give the folder to write to")?;
    let path = Path::new(&folder).join("rate.mcap");
    let (plain, zstd) = (peer(&path, None)?, peer(&path, Some(mcap::Compression::Zstd))?);
    let ours = ours(&path)?;
    std::fs::remove_file(&path)?;
    println!("{{\"mcap_uncompressed\": {plain:.0}, \"mcap_zstd\": {zstd:.0}, \"archive\": {ours:.0}}}");
    Ok(())
}
