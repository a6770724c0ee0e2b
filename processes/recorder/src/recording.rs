//! A recording that outlives full and vanished disks and its own restarts.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::Context as _;
use archive::parts::{create_fallback_dir, fallback_dir};
use archive::whole_file::{folder_of, put_in_place};
use archive::{SequenceLedger, claim};
use shared_types::{FitUpdate, LoopStatus, ModelChange, ProcessHealth, RunDescription, Sample};

use crate::part::{Flushed, Part};
use crate::parts;
use crate::rescue::Rescue;

/// Interval between chunks. If all processes are killed, the samples since the last chunk are lost, at most half a second of them as
/// promised: on a machine whose processors and disk are both taken a chunk was seen to reach the operating system 0.3 s late.
const FLUSH_INTERVAL: Duration = Duration::from_millis(150);

/// One message for the archive.
#[derive(Debug)]
pub(crate) enum Entry {
    Sample(Sample),
    Status(Box<LoopStatus>),
    Fit(Box<FitUpdate>),
    Health(ProcessHealth),
    Model(Box<ModelChange>),
}

/// How often a place is looked for while there is none.
const RETRY_INTERVAL: Duration = Duration::from_secs(2);
/// Most messages kept in memory while no disk has them: 100 s at 10 kHz, 150 MB.
const MOST_KEPT: usize = 1_000_000;

/// Writes the parts of one archive.
pub(crate) struct Recording {
    out: PathBuf,
    run: RunDescription,
    /// `None` while no place takes one.
    part: Option<Part>,
    /// Every sample that this process received, over all its parts.
    received: SequenceLedger,
    /// Entries that are not yet on the disk. They are written again when the part fails, whether in a write or in a sync.
    unsaved: VecDeque<Entry>,
    /// How many of these the sync under way covers.
    at_disk: usize,
    /// Time of the last flush, or of the last search for a place.
    flushed: Instant,
    /// Copies of parts that were removed while they were written.
    rescues: Vec<Rescue>,
}

impl Recording {
    /// Begins a new part beside those that earlier starts may have left.
    pub(crate) fn begin(out: &Path, run: RunDescription) -> anyhow::Result<Self> {
        // If it cannot be made, the part below cannot either, and says so.
        let _ = std::fs::create_dir_all(folder_of(out));
        let part = create_part(out, folder_of(out), &run).or_else(|error| {
            let elsewhere = || create_part(out, &create_fallback_dir(run.run_id)?, &run);
            let part = elsewhere().context("no folder is left for the archive")?;
            tracing::error!("{error:#}; recording to {} instead", part.path.display());
            anyhow::Ok(part)
        })?;
        Ok(Self {
            out: out.to_owned(),
            run,
            part: Some(part),
            received: SequenceLedger::default(),
            unsaved: VecDeque::new(),
            at_disk: 0,
            flushed: Instant::now(),
            rescues: Vec::new(),
        })
    }

    /// The run that is recorded.
    pub(crate) fn run_id(&self) -> u64 {
        self.run.run_id
    }

    /// The `seq` that continues what is recorded.
    pub(crate) fn next_seq(&self) -> u64 {
        self.received.next()
    }

    /// Samples that never arrived since this process first received one.
    pub(crate) fn lost_samples(&self) -> u64 {
        // What was published before is in an earlier part, or shows as missing in the end.
        self.received.missing() - self.received.first().unwrap_or(0)
    }

    /// Writes one message, in another place if this one fails. A sample that came before is not written again.
    ///
    /// While no place takes it, it is kept in memory as long as there is room.
    pub(crate) fn write(&mut self, entry: Entry) {
        if let Entry::Sample(sample) = &entry
            && !self.received.admit(sample.seq)
        {
            return;
        }
        let written = self.part.as_mut().map_or(Ok(()), |part| write_entry(part, &entry));
        self.unsaved.push_back(entry);
        if let Err(error) = written {
            self.fall_back(&error);
        }
        if self.unsaved.len() > MOST_KEPT {
            // Lost if the part fails, or while there is none: the gap is reported at the end.
            self.unsaved.pop_front();
            self.at_disk = self.at_disk.saturating_sub(1);
        }
    }

    /// Closes the chunk if it is time, or looks for a place if there is none.
    pub(crate) fn flush_if_due(&mut self) {
        let interval = if self.part.is_some() { FLUSH_INTERVAL } else { RETRY_INTERVAL };
        if self.flushed.elapsed() >= interval {
            self.flush();
        }
    }

    fn flush(&mut self) {
        self.flushed = Instant::now();
        match self.part.as_mut().map(Part::flush) {
            Some(Ok(flushed)) => self.forget(flushed),
            Some(Err(error)) => self.fall_back(&error),
            None => {
                if let Ok(part) = self.go_on() {
                    tracing::error!("there is space again; recording continues in {}", part.display());
                }
            }
        }
    }

    /// Drops the entries that are on the disk.
    fn forget(&mut self, flushed: Flushed) {
        if flushed.taken {
            self.unsaved.drain(..self.at_disk);
            self.at_disk = 0;
        }
        if flushed.asked {
            self.at_disk = self.unsaved.len();
        }
    }

    /// Goes on in a new part elsewhere, with everything that the failed one did not take.
    fn fall_back(&mut self, error: &anyhow::Error) {
        if let Some(file) = self.part.take().and_then(Part::give_up) {
            self.rescues.extend(Rescue::begin(file, &self.out, self.run_id()));
        }
        self.flushed = Instant::now();
        match self.go_on() {
            Ok(part) => tracing::error!("{error:#}; recording continues in {}", part.display()),
            Err(nowhere) => tracing::error!(
                "{error:#}, and no other folder is left ({nowhere:#}): free some space; samples are kept in memory \
                 for 100 s at 10 kHz"
            ),
        }
    }

    /// Begins a part in a place that takes everything that waits; gives its file.
    fn go_on(&mut self) -> anyhow::Result<PathBuf> {
        let elsewhere = create_fallback_dir(self.run_id()).context("there is no temporary directory");
        let part = elsewhere
            .and_then(|elsewhere| self.begin_part_in(&elsewhere))
            .or_else(|error| self.begin_part_in(folder_of(&self.out)).map_err(|_| error))?;
        let path = part.path.clone();
        self.part = Some(part);
        // No sync of the new part covers any of these entries yet.
        self.at_disk = 0;
        Ok(path)
    }

    /// Writes what the disk may not have into one more part, when the last one failed at its end.
    fn end_elsewhere(&mut self, error: &anyhow::Error) {
        tracing::error!("{error:#}; data that may not be on the disk is written again");
        let ended = self.go_on().and_then(|_| self.part.take().map_or(Ok(()), |part| part.finish().map(drop)));
        if let Err(error) = ended {
            tracing::error!("{error:#}; the archive has only what was written before");
        }
    }

    fn begin_part_in(&self, directory: &Path) -> anyhow::Result<Part> {
        let path = parts::next_free(&self.out, directory)?;
        let begin = || {
            let mut part = Part::create(&path, &self.run)?;
            self.unsaved.iter().try_for_each(|entry| write_entry(&mut part, entry))?;
            part.flush()?;
            Ok(part)
        };
        begin().inspect_err(|_| {
            // Everything in it is still in memory; if it cannot be removed, merging keeps each sample once.
            let _ = std::fs::remove_file(&path);
        })
    }

    fn parts(&self) -> Vec<PathBuf> {
        let elsewhere = fallback_dir(self.run_id());
        let places = [folder_of(&self.out), &elsewhere];
        places.into_iter().flat_map(|place| parts::of_run(&self.out, place, self.run_id())).collect()
    }

    /// Ends the last part and makes one archive of all; gives the number of samples that are missing.
    pub(crate) fn finish(self, published_samples: u64) -> anyhow::Result<u64> {
        let (out, elsewhere) = (self.out.clone(), fallback_dir(self.run_id()));
        let missing = self.end(published_samples);
        claim::release(&out);
        // It stays as long as something lies in it.
        let _ = std::fs::remove_dir(elsewhere);
        missing
    }

    fn end(mut self, published_samples: u64) -> anyhow::Result<u64> {
        self.flush();
        self.rescues.drain(..).for_each(Rescue::finish);
        let alone = self.parts().len() == 1 && self.out.symlink_metadata().is_err();
        if let Some(mut part) = self.part.take() {
            if alone {
                part.writer.published(published_samples);
            }
            match part.finish() {
                Ok((path, summary)) if alone && path.parent() == Some(folder_of(&self.out)) => {
                    if put_in_place(&path, &self.out).is_ok() {
                        return Ok(tell(&self.out, &summary.ledger));
                    }
                }
                Ok(_) => {}
                // What was flushed is sound without an end, and is merged like any other part.
                Err(error) => self.end_elsewhere(&error),
            }
        } else {
            tracing::error!("{} messages could not be written and are lost", self.unsaved.len());
        }
        let mut sources = self.parts();
        let Self { out, run, received, .. } = self;
        let elsewhere = fallback_dir(run.run_id).join(out.file_name().unwrap_or(out.as_os_str()));
        for ended in [&elsewhere, &out] {
            // An earlier start had ended this run's archive already; this one adds to it.
            if archive::run_id(ended).is_ok_and(|found| found == Some(run.run_id)) {
                sources.insert(0, ended.clone());
            }
        }
        let merged = archive::merge(&sources, &out, Some(published_samples)).map(|merged| (&out, merged));
        let merged = merged.map_err(anyhow::Error::from).or_else(|error| {
            create_fallback_dir(run.run_id)?;
            let merged = archive::merge(&sources, &elsewhere, Some(published_samples))?;
            tracing::error!("{error}; the archive is {} instead", elsewhere.display());
            anyhow::Ok((&elsewhere, merged))
        });
        match merged {
            Ok((place, merged)) => {
                sources.retain(|source| source != place);
                parts::remove(&sources);
                Ok(tell(place, &merged.ledger))
            }
            Err(error) => {
                let paths: Vec<String> = sources.iter().map(|path| path.display().to_string()).collect();
                tracing::error!(
                    "{error:#}; the parts are kept: {}. Free some space, then run `haptic-camera recover {} --out \
                     FIXED.mcap`",
                    paths.join(", "),
                    out.display()
                );
                // Only a merge can tell how many samples the parts hold, and some may have found no place: all count as missing.
                Ok(published_samples.max(received.admitted()).max(1))
            }
        }
    }
}

/// Says what the archive holds; gives the number of samples that are missing.
fn tell(out: &Path, ledger: &SequenceLedger) -> u64 {
    if ledger.missing() == 0 {
        tracing::info!("{}: {} samples, none missing", out.display(), ledger.admitted());
    } else {
        let shown: Vec<String> = ledger.gaps().iter().take(5).map(ToString::to_string).collect();
        let more = if ledger.gaps().len() > shown.len() { ", ..." } else { "" };
        tracing::error!(
            "{}: {} samples, {} missing: {}{more}",
            out.display(),
            ledger.admitted(),
            ledger.missing(),
            shown.join(", ")
        );
    }
    ledger.missing()
}

fn create_part(out: &Path, directory: &Path, run: &RunDescription) -> anyhow::Result<Part> {
    Part::create(&parts::next_free(out, directory)?, run)
}

fn write_entry(part: &mut Part, entry: &Entry) -> anyhow::Result<()> {
    let written = match entry {
        Entry::Sample(sample) => part.writer.sample(sample).map(drop),
        Entry::Status(status) => part.writer.status(status),
        Entry::Fit(update) => part.writer.fit(update),
        Entry::Health(health) => part.writer.health(health),
        Entry::Model(change) => part.writer.model(change),
    };
    written.with_context(|| part.path.display().to_string())
}
