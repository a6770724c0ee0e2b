//! How each tick went, captured or not: for measuring the loop itself.

use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};

use rtrb::{Consumer, Producer, RingBuffer};

use super::schedule::Tick;

/// How one tick went.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TickRecord {
    /// CLOCK_MONOTONIC at which the tick was due, ns.
    pub due_ns: u64,
    /// CLOCK_MONOTONIC at which the loop began it, ns.
    pub begun_ns: u64,
    /// Ticks missed directly before it.
    pub missed_ticks: u32,
    /// Duration of reading the sensors, ns.
    pub sensor_read_ns: u32,
    /// Duration of the control step, ns.
    pub control_ns: u32,
    /// Duration of writing the torque and pushing the sample, ns.
    pub push_ns: u32,
    /// Code of the state in which it left the loop.
    pub state: u32,
}

impl TickRecord {
    /// A tick that did nothing so far.
    #[must_use]
    pub fn of(tick: Tick) -> Self {
        Self {
            due_ns: tick.due_ns,
            begun_ns: tick.begun_ns,
            missed_ticks: u32::try_from(tick.elapsed - 1).unwrap_or(u32::MAX),
            ..Self::default()
        }
    }

    /// The record as a file of records holds it: the fields in order, little endian, no padding.
    #[must_use]
    pub fn to_bytes(self) -> [u8; 36] {
        let Self { due_ns, begun_ns, missed_ticks, sensor_read_ns, control_ns, push_ns, state } = self;
        let mut bytes = [0; 36];
        bytes[..8].copy_from_slice(&due_ns.to_le_bytes());
        bytes[8..16].copy_from_slice(&begun_ns.to_le_bytes());
        let narrow = [missed_ticks, sensor_read_ns, control_ns, push_ns, state];
        for (place, value) in bytes[16..].chunks_exact_mut(4).zip(narrow) {
            place.copy_from_slice(&value.to_le_bytes());
        }
        bytes
    }
}

/// A ring for the loop's records, every page of it touched.
pub(super) fn ring(capacity: usize) -> (Producer<TickRecord>, Consumer<TickRecord>) {
    let (mut producer, mut consumer) = RingBuffer::new(capacity);
    while producer.push(TickRecord::default()).is_ok() {}
    while consumer.pop().is_ok() {}
    (producer, consumer)
}

/// Writes the loop's records to a file, outside the real-time thread.
#[derive(Debug)]
pub struct TickLog {
    records: Consumer<TickRecord>,
    file: BufWriter<File>,
    path: PathBuf,
    failed: bool,
}

impl TickLog {
    /// A file in `folder`, named for this process, for what comes out of `records`.
    ///
    /// # Errors
    /// The system's, when the file cannot be made.
    pub fn create(folder: &Path, records: Consumer<TickRecord>) -> std::io::Result<Self> {
        std::fs::create_dir_all(folder)?;
        let path = folder.join(format!("ticks-{}", std::process::id()));
        let file = BufWriter::with_capacity(1 << 20, File::create(&path)?);
        Ok(Self { records, file, path, failed: false })
    }

    /// Writes what has come; nothing more after a failure, which is reported once.
    pub fn write_waiting(&mut self) {
        while let Ok(record) = self.records.pop() {
            if !self.failed
                && let Err(error) = self.file.write_all(&record.to_bytes())
            {
                tracing::error!("the timings cannot be written to {} ({error})", self.path.display());
                self.failed = true;
            }
        }
    }

    /// Writes the rest and closes the file.
    ///
    /// # Errors
    /// The system's.
    pub fn finish(mut self) -> std::io::Result<()> {
        self.write_waiting();
        self.file.flush()
    }
}
