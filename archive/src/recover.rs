//! A whole archive from a broken one.
//!
//! Kept is what a checksum vouches for: chunks and attachments, wherever in the file they lie, so
//! that damage in the middle costs the damaged chunk only. Of a chunk that the end of the file
//! cuts off, complete samples are kept as long as their `seq` continues the stream; they are
//! counted apart, since no checksum covers them. Nothing is invented: a sample is kept with the
//! bytes it had, or it is missing and the gap is named.

use std::collections::BTreeMap;
use std::io::{Read, Seek, Write};
use std::path::Path;

use crate::combine::{Combiner, advance};
use crate::description::RECOVERY_METADATA;
use crate::error::ArchiveError;
use crate::sequence::Gap;
use crate::source::Source;
use crate::whole_file;

/// What was kept and what was lost.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecoverySummary {
    /// Samples kept, each counted once.
    pub samples_kept: u64,
    /// Of these, samples from a chunk cut off by the end of the file, which no checksum covers.
    pub unchecked_samples: u64,
    /// Messages kept on all channels, samples included.
    pub messages_kept: u64,
    /// The first sample that is there.
    pub first_seq: Option<u64>,
    /// The last sample that is there.
    pub last_seq: Option<u64>,
    /// Samples known to be missing: before the last one that is there.
    pub missing_samples: u64,
    /// Where they are missing.
    pub gaps: Vec<Gap>,
    /// Size of the broken file, bytes.
    pub bytes_total: u64,
    /// Bytes of it that could not be understood.
    pub bytes_dropped: u64,
    /// Chunks whose checksum failed.
    pub damaged_chunks: u64,
    /// Chunks that the end of the file cut off: none or one.
    pub unfinished_chunks: u64,
    /// True when the recording had been finished, so that nothing is missing at its end.
    pub finished: bool,
    /// True when something of the recording is missing, or may be.
    pub lossy: bool,
}

impl std::fmt::Display for RecoverySummary {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "kept {} samples", self.samples_kept)?;
        if let (Some(first), Some(last)) = (self.first_seq, self.last_seq) {
            write!(f, " ({first} to {last})")?;
        }
        write!(f, " and {} other messages", self.messages_kept - self.samples_kept)?;
        if self.unchecked_samples > 0 {
            write!(f, "; {} of the samples come from a chunk that was cut off", self.unchecked_samples)?;
        }
        if self.damaged_chunks > 0 {
            write!(f, "; {} damaged chunks left out", self.damaged_chunks)?;
        }
        write!(f, "; {} of {} bytes dropped", self.bytes_dropped, self.bytes_total)?;
        if self.missing_samples > 0 {
            let shown: Vec<String> = self.gaps.iter().take(10).map(Gap::to_string).collect();
            let more = if self.gaps.len() > shown.len() { ", ..." } else { "" };
            write!(f, "; {} samples are missing: {}{more}", self.missing_samples, shown.join(", "))?;
        }
        if !self.finished {
            write!(f, "; the recording was not finished, what came after is not in the file")?;
        }
        Ok(())
    }
}

/// Writes to `output` what of the archive `broken` is sound.
///
/// The original is only read. `output` appears when it is whole.
///
/// # Errors
/// [`ArchiveError::Missing`], [`ArchiveError::Empty`], [`ArchiveError::SameFile`],
/// [`ArchiveError::NothingToRecover`], or the operating system's refusal.
pub fn recover(broken: &Path, output: &Path) -> Result<RecoverySummary, ArchiveError> {
    let file = std::fs::File::open(broken).map_err(|error| ArchiveError::file(broken, error))?;
    let metadata = file.metadata().map_err(|error| ArchiveError::file(broken, error))?;
    if metadata.is_file() && metadata.len() == 0 {
        return Err(ArchiveError::Empty { path: broken.to_owned() });
    }
    if is_same_file(broken, output) {
        return Err(ArchiveError::SameFile { path: broken.to_owned() });
    }
    whole_file::write_whole(output, |mut place| recover_stream(file, &mut place, broken))
}

/// [`recover`] without files: from any reader to any writer. `name` stands in errors.
///
/// # Errors
/// [`ArchiveError::NothingToRecover`], or what reading and writing report.
pub fn recover_stream<R: Read, W: Write + Seek>(
    broken: R,
    output: W,
    name: &Path,
) -> Result<RecoverySummary, ArchiveError> {
    let mut combiner = Combiner::new(output, false)?;
    let mut source = Source::new(broken);
    while let Some(sample) = advance(&mut source, &mut combiner, name)? {
        combiner.message(&sample, source.body(&sample))?;
    }
    let account = source.account();
    if account.chunks == 0 {
        return Err(ArchiveError::NothingToRecover { path: name.to_owned() });
    }
    let ledger = combiner.ledger.clone();
    let lossy = !account.finished || account.dropped_content + source.orphans + ledger.missing() > 0;
    let summary = RecoverySummary {
        samples_kept: ledger.admitted(),
        unchecked_samples: combiner.unchecked_samples,
        messages_kept: combiner.messages,
        first_seq: ledger.first(),
        last_seq: ledger.last(),
        missing_samples: ledger.missing(),
        gaps: ledger.gaps().to_vec(),
        bytes_total: account.bytes,
        bytes_dropped: account.dropped,
        damaged_chunks: account.damaged_chunks,
        unfinished_chunks: account.unfinished_chunks,
        finished: account.finished,
        lossy,
    };
    let notes = BTreeMap::from([
        ("summary".to_owned(), summary.to_string()),
        ("bytes_dropped".to_owned(), summary.bytes_dropped.to_string()),
        ("samples_kept".to_owned(), summary.samples_kept.to_string()),
    ]);
    combiner.metadata(&mcap::records::Metadata { name: RECOVERY_METADATA.to_owned(), metadata: notes })?;
    combiner.finish()?;
    Ok(summary)
}

fn is_same_file(one: &Path, other: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    match (std::fs::metadata(one), std::fs::metadata(other)) {
        (Ok(one), Ok(other)) => one.dev() == other.dev() && one.ino() == other.ino(),
        _ => false,
    }
}
