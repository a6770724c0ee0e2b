//! Records that nobody of ours wrote, in a chunk whose checksum holds: what the checksums keep from the other target.
#![no_main]

use libfuzzer_sys::fuzz_target;
use mcap::records::op;

fuzz_target!(|records: &[u8]| fuzz::bounded(records.len(), || {
    let mut file = mcap::MAGIC.to_vec();
    record(&mut file, op::HEADER, &[0; 8]);
    let mut chunk = vec![0; 16];
    chunk.extend((records.len() as u64).to_le_bytes());
    chunk.extend(crc32fast::hash(records).to_le_bytes());
    chunk.extend([0; 4]);
    chunk.extend((records.len() as u64).to_le_bytes());
    chunk.extend(records);
    record(&mut file, op::CHUNK, &chunk);
    record(&mut file, op::METADATA, &metadata("capture", &[("rate_hz", "10000")]));
    record(&mut file, op::DATA_END, &[0; 4]);
    record(&mut file, op::FOOTER, &[0; 20]);
    file.extend(mcap::MAGIC);
    fuzz::read_and_recover(&file);
}));

fn record(file: &mut Vec<u8>, opcode: u8, body: &[u8]) {
    file.push(opcode);
    file.extend((body.len() as u64).to_le_bytes());
    file.extend(body);
}

fn metadata(name: &str, entries: &[(&str, &str)]) -> Vec<u8> {
    let text = |text: &str| [&(text.len() as u32).to_le_bytes(), text.as_bytes()].concat();
    let map: Vec<u8> = entries.iter().flat_map(|(key, value)| [text(key), text(value)].concat()).collect();
    [text(name), (map.len() as u32).to_le_bytes().to_vec(), map].concat()
}
