//! When each sample arrived, for measuring the latency from the tick to a consumer.

use std::fs::File;
use std::io::{BufWriter, Write as _};

use shared_types::rig::TIMINGS_VARIABLE;
use shared_types::{ProcessKind, Sample};

/// A file of pairs of CLOCK_MONOTONIC times in ns, as `u64` in little endian: when the tick was due, and when its sample
/// was taken from the queue.
#[derive(Debug)]
pub(crate) struct Arrivals {
    file: BufWriter<File>,
}

impl Arrivals {
    /// A file named after this process in the folder that [`TIMINGS_VARIABLE`] names; `None` if it names none or the file cannot
    /// be created.
    pub(crate) fn wanted(kind: ProcessKind) -> Option<Self> {
        let folder = std::path::PathBuf::from(std::env::var_os(TIMINGS_VARIABLE)?);
        let path = folder.join(format!("arrivals-{}-{}", kind.name(), std::process::id()));
        // A file that cannot be created spoils the measurement; it must not keep the consumer from its work.
        let file = File::create(path).ok()?;
        Some(Self { file: BufWriter::with_capacity(1 << 18, file) })
    }

    pub(crate) fn note(&mut self, block: &[Sample], now_ns: u64) {
        for sample in block {
            let mut pair = [0; 16];
            pair[..8].copy_from_slice(&sample.monotonic_time_ns.to_le_bytes());
            pair[8..].copy_from_slice(&now_ns.to_le_bytes());
            // As above: a failed measurement shows by its missing pairs.
            let _ = self.file.write_all(&pair);
        }
    }
}
