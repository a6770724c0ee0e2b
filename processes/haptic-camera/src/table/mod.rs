//! `table`: one row a capture of whole folders, fitted on all cores.
//!
//! Each core holds one capture at a time. Rows go into a journal beside the table as they are made, so that a killed command
//! continues where it was when it is run again. The journal becomes the table, sorted by file.

mod journal;

use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::sync::mpsc::sync_channel;

use analysis::{Row, ends_in, load_specification};
use anyhow::{Context as _, ensure};
use clap::Args;
use rayon::ThreadPoolBuilder;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::list::written_ns;
use crate::outcome::{remark, say};
use crate::terminal;
use journal::Journal;

#[derive(Debug, Args)]
pub struct TableOptions {
    /// Folders of captures, searched recursively
    #[arg(required = true, value_name = "DIR")]
    pub folders: Vec<PathBuf>,
    /// Write the table here
    #[arg(long, value_name = "FILE.parquet")]
    pub out: PathBuf,
    /// Limits, as for `judge`: adds the figures of the sheet and the verdict to every row
    #[arg(long, value_name = "SPEC.toml")]
    pub spec: Option<PathBuf>,
    /// Captures to fit at once [default: one per core]
    #[arg(long, value_name = "N")]
    pub jobs: Option<NonZero<usize>>,
}

/// Endings of the files that are taken for captures.
const ENDINGS: [&str; 3] = ["mcap", "csv", "mf4"];

pub fn run(options: &TableOptions) -> anyhow::Result<()> {
    let mut files = Vec::new();
    options.folders.iter().try_for_each(|folder| add(folder, &mut files))?;
    analysis::leave_exports_out(&mut files, |file| &file.path);
    files.sort();
    files.dedup();
    ensure!(!files.is_empty(), "no .{} file in the folders; give folders of captures", ENDINGS.join(", ."));
    let specification = options.spec.as_deref().map(load_specification).transpose()?;
    let mut journal = Journal::open(&options.out, specification.as_ref())?;
    let left: Vec<&CaptureFile> = files.iter().filter(|file| !journal.lines.contains_key(*file)).collect();
    let made = files.len() - left.len();
    if made > 0 {
        remark(format!("{made} of {} captures are in {} already", files.len(), journal.place.display()));
    }
    let jobs = options.jobs.or_else(|| std::thread::available_parallelism().ok()).map_or(1, NonZero::get);
    let pool = ThreadPoolBuilder::new().num_threads(jobs).build()?;
    let bar = terminal::bar(Some(files.len() as u64), "{bar:24} {pos}/{len} captures, {per_sec}, {eta} left");
    bar.set_position(made as u64);
    // A thread waits while the journal is slower than it, and ends once the journal takes no more.
    let (sender, receiver) = sync_channel(jobs);
    let added = pool.in_place_scope(|scope| {
        scope.spawn(|_| {
            let rows = left.par_iter().map(|file| (*file, Row::of(&file.path, specification.as_ref())));
            drop(rows.try_for_each_with(sender, |sender, row| sender.send(row)));
        });
        receiver.into_iter().try_for_each(|(file, row)| {
            journal.add(file, &row)?;
            bar.inc(1);
            anyhow::Ok(())
        })
    });
    bar.finish_and_clear();
    added?;
    let wrong = journal.into_table(&files)?;
    say(format!("{}: {} captures, {wrong} of them with an error", options.out.display(), files.len()));
    Ok(())
}

/// A capture's file as it was listed; one that has changed since counts as another file.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
struct CaptureFile {
    path: PathBuf,
    bytes: u64,
    written_ns: u64,
}

/// Adds all captures in a folder and in the folders in it.
fn add(folder: &Path, files: &mut Vec<CaptureFile>) -> anyhow::Result<()> {
    let unreadable = || format!("the folder {} cannot be read; give folders of captures", folder.display());
    for entry in std::fs::read_dir(folder).with_context(unreadable)? {
        let entry = entry.with_context(unreadable)?;
        let path = entry.path();
        // A link may lead back to a folder that contains it, so links to folders are not followed.
        if entry.file_type().with_context(unreadable)?.is_dir() {
            add(&path, files)?;
        } else if ENDINGS.iter().any(|ending| ends_in(&path, ending)) {
            let (bytes, written_ns) = (path.metadata().map_or(0, |file| file.len()), written_ns(&path) as u64);
            files.push(CaptureFile { path, bytes, written_ns });
        }
    }
    Ok(())
}
