//! One archive from the parts that a recorder leaves when it is killed and restarted.
//!
//! A restarted recorder receives the last seconds again, so parts overlap. Samples are taken in the
//! order of `seq`, each from the first part that has it under a checksum, or from the first part that
//! has it without one if no part has it under a checksum. Parts may be cut off anywhere.

use std::fs::File;
use std::io::{Seek, Write};
use std::path::{Path, PathBuf};

use shared_types::RunDescription;

use crate::combine::{Combiner, advance};
use crate::description::attachment;
use crate::error::ArchiveError;
use crate::own_file;
use crate::sequence::SequenceLedger;
use crate::source::{Item, Source, SourceMessage};
use crate::whole_file::{self, Replace};

/// What a merged archive holds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MergeSummary {
    /// Samples that are there and samples that are missing.
    pub ledger: SequenceLedger,
    /// Messages on all channels, samples included.
    pub messages: u64,
    /// Samples that no part has under a checksum.
    pub unchecked_samples: u64,
    /// Bytes of all parts that could not be understood, such as the chunk that a kill cut off.
    pub bytes_dropped: u64,
}

/// The run that an archive or a part belongs to; `None` when it does not say.
///
/// # Errors
/// [`ArchiveError::Missing`] or [`ArchiveError::File`] when it cannot be read, or is no file of the user's own.
pub fn run_id(path: &Path) -> Result<Option<u64>, ArchiveError> {
    let mut source = open(path)?;
    while let Some(item) = source.next().map_err(|error| ArchiveError::file(path, error))? {
        match item {
            Item::Attachment { name, content, .. } if name == attachment::RUN => {
                return Ok(serde_json::from_slice::<RunDescription>(&content).ok().map(|run| run.run_id));
            }
            // The description stands before the first message.
            Item::Message(_) => return Ok(None),
            _ => {}
        }
    }
    Ok(None)
}

/// Merges `parts` into `output`, which appears when it is whole; the parts stay.
///
/// `published` is the number of samples that the run had, if known: what is missing at the end
/// becomes a gap like any other. Memory does not grow with the parts' length. An archive of the same run at `output` is replaced,
/// and nothing else.
///
/// # Errors
/// [`ArchiveError::NoParts`], [`ArchiveError::OtherRun`], or what reading and writing report.
pub fn merge(parts: &[PathBuf], output: &Path, published: Option<u64>) -> Result<MergeSummary, ArchiveError> {
    if parts.is_empty() {
        return Err(ArchiveError::NoParts { path: output.to_owned() });
    }
    let run = one_run(parts)?;
    let is_same_run = run.is_some() && run_id(output).is_ok_and(|found| found == run);
    let replace = if is_same_run { Replace::Anything } else { Replace::Nothing };
    whole_file::write_whole(output, replace, |mut place| merge_into(parts, &mut place, published))
}

/// The run of the parts; refuses parts of different runs. A part that does not say is welcome.
fn one_run(parts: &[PathBuf]) -> Result<Option<u64>, ArchiveError> {
    let mut expected = None;
    for path in parts {
        if let Some(found) = run_id(path)? {
            let expected = *expected.get_or_insert(found);
            if found != expected {
                return Err(ArchiveError::OtherRun { path: path.clone(), found, expected });
            }
        }
    }
    Ok(expected)
}

/// A part whose next sample is at hand.
struct Reading {
    path: PathBuf,
    source: Source<File>,
    sample: SourceMessage,
}

fn merge_into<W: Write + Seek>(
    parts: &[PathBuf],
    output: W,
    published: Option<u64>,
) -> Result<MergeSummary, ArchiveError> {
    let mut combiner = Combiner::new(output, parts.len() > 1)?;
    let (mut unchecked_samples, mut bytes_dropped) = (0, 0);
    // Only parts whose samples overlap are open at once: a recorder may be restarted often.
    let mut waiting = by_first_sample(parts)?;
    let mut reading: Vec<Reading> = Vec::new();
    loop {
        let next = reading.iter().filter_map(|part| part.sample.seq).min();
        if let Some((_, path)) = waiting.pop_if(|(first, _)| next.is_none_or(|next| *first <= next)) {
            let mut source = open(&path)?;
            match advance(&mut source, &mut combiner, &path)? {
                Some(sample) => reading.push(Reading { path, source, sample }),
                None => bytes_dropped += source.account().dropped,
            }
            continue;
        }
        let Some((index, part)) =
            reading.iter_mut().enumerate().min_by_key(|(_, part)| (part.sample.seq, !part.sample.checked))
        else {
            break;
        };
        let admitted = combiner.ledger.admitted();
        combiner.message(&part.sample, part.source.body(&part.sample))?;
        if !part.sample.checked {
            unchecked_samples += combiner.ledger.admitted() - admitted;
        }
        match advance(&mut part.source, &mut combiner, &part.path)? {
            Some(sample) => part.sample = sample,
            None => {
                bytes_dropped += part.source.account().dropped;
                reading.remove(index);
            }
        }
    }
    if let Some(published) = published {
        combiner.ledger.close(published);
    }
    combiner.finish()?;
    let Combiner { ledger, messages, .. } = combiner;
    Ok(MergeSummary { ledger, messages, unchecked_samples, bytes_dropped })
}

/// The parts with their first `seq`, in descending order, to be popped from the end. A part without samples counts as beginning at 0.
fn by_first_sample(parts: &[PathBuf]) -> Result<Vec<(u64, PathBuf)>, ArchiveError> {
    let mut order = Vec::new();
    for path in parts {
        let mut source = open(path)?;
        let mut first = 0;
        while let Some(item) = source.next().map_err(|error| ArchiveError::file(path, error))? {
            if let Item::Message(SourceMessage { seq: Some(seq), .. }) = item {
                first = seq;
                break;
            }
        }
        order.push((first, path.clone()));
    }
    // A stable sort, then reversed: of parts that begin alike the first given comes first.
    order.sort_by_key(|(first, _)| *first);
    order.reverse();
    Ok(order)
}

fn open(path: &Path) -> Result<Source<File>, ArchiveError> {
    own_file::open(path).map(Source::new).map_err(|error| ArchiveError::file(path, error))
}
