//! A whole archive from a broken one.
//!
//! Kept is what a checksum vouches for: chunks and attachments, wherever in the file they lie, so
//! that damage in the middle costs the damaged chunk only. Of a chunk that the end of the file
//! cuts off, samples can still be read as long as their `seq` continues the stream, but no checksum
//! covers them: they are counted and named, and kept only where that is asked for
//! ([`Unchecked::Keep`]). Nothing is invented: a sample is kept with the bytes it had, or it is
//! missing and the gap is named.

use std::collections::BTreeMap;
use std::io::{Read, Seek, Write};
use std::path::Path;

use crate::combine::{Combiner, advance};
use crate::description::RECOVERY_METADATA;
use crate::error::ArchiveError;
use crate::losses::{Loss, Losses, Place};
use crate::sequence::Gap;
use crate::source::Source;
use crate::whole_file::{self, Replace};

/// What becomes of samples from a chunk that the end of the file cuts off, which no checksum covers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Unchecked {
    /// They are counted and left out: whether their bytes are those that were recorded, nobody can tell.
    #[default]
    LeaveOut,
    /// They are kept; right where the file was only cut off, and not damaged too.
    Keep,
}

/// What was kept and what was lost.
#[derive(Clone, Debug, PartialEq)]
pub struct RecoverySummary {
    /// Samples kept, each counted once.
    pub samples_kept: u64,
    /// Samples that could be read from a chunk cut off by the end of the file, which no checksum covers.
    pub unchecked_samples: u64,
    /// Whether those were kept.
    pub unchecked: Unchecked,
    /// Messages kept on all channels, samples included.
    pub messages_kept: u64,
    /// The first sample that is there.
    pub first: Option<Place>,
    /// The last sample that is there.
    pub last: Option<Place>,
    /// Samples known to be missing: before the last one that is there, or noted by the recorder.
    pub missing_samples: u64,
    /// Where they are missing, with the samples on either side.
    pub losses: Vec<Loss>,
    /// Ticks that an unfinished recording was still to have after the last sample that is there: no more than that is lost at its
    /// end. `None` where the file does not say.
    pub ticks_left: Option<u64>,
    /// Sample rate, Hz; `None` where the file does not say.
    pub rate_hz: Option<f64>,
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

impl RecoverySummary {
    /// Where samples are missing.
    pub fn gaps(&self) -> impl Iterator<Item = Gap> + '_ {
        self.losses.iter().map(|loss| loss.gap)
    }
}

/// Most losses to list in a message; the archive's record `gaps` lists them all.
const LISTED_LOSSES: usize = 10;

impl std::fmt::Display for RecoverySummary {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let place = |place: &Place| place.in_words(self.rate_hz);
        write!(f, "kept {} samples", self.samples_kept)?;
        if let (Some(first), Some(last)) = (&self.first, &self.last) {
            write!(f, " ({} to {}: {} to {})", first.seq, last.seq, place(first), place(last))?;
        }
        write!(f, " and {} other messages", self.messages_kept - self.samples_kept)?;
        match (self.unchecked_samples, self.unchecked) {
            (0, _) => {}
            (count, Unchecked::Keep) => write!(f, "; {count} of the samples come from a truncated chunk")?,
            (count, Unchecked::LeaveOut) => {
                write!(f, "; a truncated chunk has {count} more samples, but no checksum covers them")?;
            }
        }
        if self.damaged_chunks > 0 {
            write!(f, "; {} damaged chunks left out", self.damaged_chunks)?;
        }
        write!(f, "; {} of {} bytes dropped", self.bytes_dropped, self.bytes_total)?;
        if self.missing_samples > 0 {
            let listed: Vec<String> =
                self.losses.iter().take(LISTED_LOSSES).map(|loss| loss.in_words(self.rate_hz)).collect();
            let more = if self.losses.len() > listed.len() { ", ..." } else { "" };
            write!(f, "; {} samples are missing: {}{more}", self.missing_samples, listed.join(", "))?;
        }
        if !self.finished {
            write!(f, "; the recording was not finished, later samples are lost")?;
            if let Some(ticks) = self.ticks_left {
                write!(f, " (at most {ticks} ticks, if the run went on to its planned end)")?;
            }
        }
        Ok(())
    }
}

/// Writes the sound content of the archive `broken` to `output`.
///
/// The original is only read. `output` appears when it is whole, and replaces nothing.
///
/// # Errors
/// [`ArchiveError::Missing`], [`ArchiveError::Empty`], [`ArchiveError::SameFile`],
/// [`ArchiveError::NothingToRecover`], [`ArchiveError::Occupied`], or the operating system's refusal.
pub fn recover(broken: &Path, output: &Path, unchecked: Unchecked) -> Result<RecoverySummary, ArchiveError> {
    let file = foreign_files::open(broken).map_err(|error| ArchiveError::file(broken, error))?;
    let metadata = file.metadata().map_err(|error| ArchiveError::file(broken, error))?;
    if metadata.len() == 0 {
        return Err(ArchiveError::Empty { path: broken.to_owned() });
    }
    if is_same_file(broken, output) {
        return Err(ArchiveError::SameFile { path: broken.to_owned() });
    }
    whole_file::write_whole(output, Replace::Nothing, |mut place| recover_stream(file, &mut place, broken, unchecked))
}

/// [`recover`] without files: from any reader to any writer. `name` stands in errors.
///
/// # Errors
/// [`ArchiveError::NothingToRecover`], or what reading and writing report.
pub fn recover_stream<R: Read, W: Write + Seek>(
    broken: R,
    output: W,
    name: &Path,
    unchecked: Unchecked,
) -> Result<RecoverySummary, ArchiveError> {
    let mut combiner = Combiner::new(output, false)?;
    let mut source = Source::new(broken);
    let mut losses = Losses::default();
    let mut unchecked_samples = 0;
    while let Some(sample) = advance(&mut source, &mut combiner, name)? {
        unchecked_samples += u64::from(!sample.checked);
        if !sample.checked && unchecked == Unchecked::LeaveOut {
            continue;
        }
        combiner.message(&sample, source.body(&sample))?;
        losses.note(&combiner.ledger, sample.tick);
    }
    let account = source.account();
    if account.chunks == 0 {
        return Err(ArchiveError::NothingToRecover { path: name.to_owned() });
    }
    combiner.take_over_noted_gap();
    losses.note(&combiner.ledger, None);
    let ledger = combiner.ledger.clone();
    let (first, last, losses) = losses.into_parts();
    let run = combiner.run.as_ref();
    let next_tick = last.map_or(Some(0), |last| last.tick.map(|tick| tick.saturating_add(1)));
    let planned_ticks = run.map(|run| run.planned_ticks).filter(|&ticks| ticks > 0);
    let summary = RecoverySummary {
        samples_kept: ledger.admitted(),
        unchecked_samples,
        unchecked,
        messages_kept: combiner.messages,
        first,
        last,
        missing_samples: ledger.missing(),
        losses,
        ticks_left: planned_ticks.zip(next_tick).map(|(planned, next)| planned.saturating_sub(next)),
        rate_hz: run.map(|run| run.rate_hz).filter(|rate| rate.is_finite() && *rate > 0.0),
        bytes_total: account.bytes,
        bytes_dropped: account.dropped,
        damaged_chunks: account.damaged_chunks,
        unfinished_chunks: account.unfinished_chunks,
        finished: account.finished,
        lossy: !account.finished || account.dropped_content + source.orphans + ledger.missing() > 0,
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
