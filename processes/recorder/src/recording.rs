//! A recording that outlives full disks and its own restarts.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::{Context as _, bail};
use archive::SequenceLedger;
use archive::whole_file::put_in_place;
use shared_types::{FitUpdate, LoopStatus, ModelChange, ProcessHealth, RunDescription, Sample};

use crate::part::Part;
use crate::parts;

/// How often a chunk is closed: what a kill can cost before history makes up for it.
const FLUSH_INTERVAL: Duration = Duration::from_millis(400);

/// One message for the archive.
#[derive(Debug)]
pub(crate) enum Entry {
    Sample(Sample),
    Status(Box<LoopStatus>),
    Fit(Box<FitUpdate>),
    Health(ProcessHealth),
    Model(Box<ModelChange>),
}

/// Writes the parts of one archive.
pub(crate) struct Recording {
    out: PathBuf,
    run: RunDescription,
    /// Where parts can go: beside the archive, or where there is room.
    directories: [PathBuf; 2],
    fallen_back: bool,
    part: Part,
    /// Every sample that this process received, over all its parts.
    received: SequenceLedger,
    /// What the operating system has not yet taken: written again when the part fails.
    unflushed: Vec<Entry>,
    flushed: Instant,
}

impl Recording {
    /// Begins a new part beside those that earlier starts may have left.
    pub(crate) fn begin(out: &Path, run: RunDescription) -> anyhow::Result<Self> {
        if out.exists() && archive::run_id(out)? != Some(run.run_id) {
            bail!("{} exists and holds another run; give --out another name", out.display());
        }
        let directories = [parts::directory_of(out), std::env::temp_dir()];
        // If it cannot be made, the part below cannot either, and says so.
        let _ = std::fs::create_dir_all(&directories[0]);
        let (part, fallen_back) = match create_part(out, &directories[0], &run) {
            Ok(part) => (part, false),
            Err(error) => {
                let part = create_part(out, &directories[1], &run).context("no place for the archive is left")?;
                tracing::error!("{error:#}; recording to {} instead", part.path.display());
                (part, true)
            }
        };
        Ok(Self {
            out: out.to_owned(),
            run,
            directories,
            fallen_back,
            part,
            received: SequenceLedger::default(),
            unflushed: Vec::new(),
            flushed: Instant::now(),
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

    /// Writes one message, in another place if this one fails; a sample that came before, never again.
    pub(crate) fn write(&mut self, entry: Entry) -> anyhow::Result<()> {
        if let Entry::Sample(sample) = &entry
            && !self.received.admit(sample.seq)
        {
            return Ok(());
        }
        let written = write_entry(&mut self.part, &entry);
        self.unflushed.push(entry);
        written.or_else(|error| self.fall_back(&error))
    }

    /// Closes the chunk if it is time.
    pub(crate) fn flush_if_due(&mut self) -> anyhow::Result<()> {
        if self.flushed.elapsed() >= FLUSH_INTERVAL { self.flush() } else { Ok(()) }
    }

    fn flush(&mut self) -> anyhow::Result<()> {
        self.flushed = Instant::now();
        self.part.flush().or_else(|error| self.fall_back(&error))?;
        self.unflushed.clear();
        Ok(())
    }

    /// Goes on in a new part elsewhere, with everything that the failed one did not take.
    fn fall_back(&mut self, error: &anyhow::Error) -> anyhow::Result<()> {
        if self.fallen_back {
            bail!("{error:#}; what was recorded before is in {}", self.list_parts());
        }
        self.fallen_back = true;
        self.part = create_part(&self.out, &self.directories[1], &self.run)
            .with_context(|| format!("{error:#}, and no other place is left"))?;
        tracing::error!("{error:#}; recording goes on in {}", self.part.path.display());
        for entry in &self.unflushed {
            write_entry(&mut self.part, entry)?;
        }
        self.part.flush()?;
        self.unflushed.clear();
        Ok(())
    }

    fn parts(&self) -> Vec<PathBuf> {
        let [first, second] = &self.directories;
        let mut parts = parts::of_run(&self.out, first, self.run_id());
        // An archive in the temporary directory has nowhere else to go.
        if first.canonicalize().ok() != second.canonicalize().ok() {
            parts.extend(parts::of_run(&self.out, second, self.run_id()));
        }
        parts
    }

    fn list_parts(&self) -> String {
        let paths: Vec<String> = self.parts().iter().map(|path| path.display().to_string()).collect();
        paths.join(", ")
    }

    /// Ends the last part and makes one archive of all; the number of samples that are missing.
    pub(crate) fn finish(mut self, published_samples: u64) -> anyhow::Result<u64> {
        self.flush()?;
        let parts = self.parts();
        let alone = parts.len() == 1 && !self.out.exists();
        let Self { out, directories, mut part, .. } = self;
        if alone {
            part.writer.published(published_samples);
        }
        match part.finish() {
            Ok((path, summary)) if alone && path.parent() == Some(&directories[0]) => {
                put_in_place(&path, &out)?;
                return Ok(tell(&out, &summary.ledger));
            }
            Ok(_) => {}
            // What was flushed is sound without an end, and is merged like any other part.
            Err(error) => tracing::error!("{error:#}; the archive is made of what was written before"),
        }
        let mut sources = parts;
        if out.exists() {
            // An earlier start had ended this run's archive already; this one adds to it.
            sources.insert(0, out.clone());
        }
        let (out, merged) = match archive::merge(&sources, &out, Some(published_samples)) {
            Ok(merged) => (out, merged),
            Err(error) => {
                let elsewhere = directories[1].join(out.file_name().unwrap_or(out.as_os_str()));
                let merged = archive::merge(&sources, &elsewhere, Some(published_samples))
                    .with_context(|| format!("{error}; the parts stay where they are"))?;
                tracing::error!("{error}; the archive is {} instead", elsewhere.display());
                (elsewhere, merged)
            }
        };
        sources.retain(|source| *source != out);
        parts::remove(&sources);
        Ok(tell(&out, &merged.ledger))
    }
}

/// Says what the archive holds; the number of samples that are missing.
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
