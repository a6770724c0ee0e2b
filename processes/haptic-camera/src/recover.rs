//! `recover`: a whole archive of a broken one, or of the parts that a killed recorder left.

use std::path::{Path, PathBuf};

use anyhow::Context as _;
use archive::Unchecked;
use archive::parts::{self, fallback_dirs};
use archive::whole_file::folder_of;
use clap::Args;

use crate::outcome::{Outcome, remark, say};

#[derive(Debug, Args)]
pub struct RecoverOptions {
    /// The truncated or damaged archive, or one that a killed recorder left in parts; it is not changed
    #[arg(value_name = "BROKEN.mcap")]
    pub broken: PathBuf,
    /// Write the recovered archive here
    #[arg(long, value_name = "FIXED.mcap")]
    pub out: PathBuf,
    /// Also keep the samples of a truncated chunk, which no checksum covers; those of an archive in parts are always kept
    #[arg(long)]
    pub keep_unchecked: bool,
}

pub fn run(options: &RecoverOptions) -> anyhow::Result<Outcome> {
    let RecoverOptions { broken, out, keep_unchecked } = options;
    let unchecked = if *keep_unchecked { Unchecked::Keep } else { Unchecked::LeaveOut };
    let parts = if broken.exists() { Vec::new() } else { parts_of(broken) };
    if parts.len() > 1 {
        return merge(broken, &parts, out);
    }
    if let [part] = parts.as_slice() {
        remark(format!("{} was never closed; recovering its part {}", broken.display(), part.display()));
    }
    let summary = archive::recover(parts.first().unwrap_or(broken), out, unchecked)?;
    say(format!("{}: {summary}", out.display()));
    if summary.unchecked_samples > 0 && !keep_unchecked {
        say("--keep-unchecked keeps the samples that no checksum covers");
    }
    Ok(if summary.lossy { Outcome::DataLost } else { Outcome::Done })
}

/// Finds the parts of an archive that was never closed, beside it and in the fallback folders of the user's runs. Files that belong
/// to no run are left out, so that the list may be empty.
fn parts_of(archive: &Path) -> Vec<PathBuf> {
    let mut places = fallback_dirs();
    places.insert(0, folder_of(archive).to_owned());
    let found = places.iter().flat_map(|place| parts::find(archive, place));
    let (of_a_run, others): (Vec<_>, Vec<_>) = found.partition(|part| matches!(part.run_id, Ok(Some(_))));
    let refused: Vec<_> = others.iter().filter_map(|part| part.run_id.as_ref().err()).collect();
    if let [first, more @ ..] = refused.as_slice() {
        let and_more = |more: usize| format!(", and {more} more files of such names");
        remark(format!("skipped: {first}{}", if more.is_empty() { String::new() } else { and_more(more.len()) }));
    }
    of_a_run.into_iter().map(|part| part.path).collect()
}

/// Makes one archive of the parts of a recording that nobody ended.
fn merge(archive: &Path, parts: &[PathBuf], out: &Path) -> anyhow::Result<Outcome> {
    let merged = archive::merge(parts, out, None)
        .with_context(|| format!("{} was never closed, and its parts cannot be merged", archive.display()))?;
    let ledger = &merged.ledger;
    let bounds = ledger.first().zip(ledger.last()).map_or_else(String::new, |(a, b)| format!(" ({a} to {b})"));
    let gaps: Vec<String> = ledger.gaps().iter().take(10).map(ToString::to_string).collect();
    let missing = if gaps.is_empty() { "none missing between them".to_owned() } else { gaps.join(", ") + " missing" };
    let unchecked = match merged.unchecked_samples {
        0 => String::new(),
        count => format!("; no checksum covers {count} of the samples, which truncated chunks have"),
    };
    let (out, kept, parts, dropped) = (out.display(), ledger.admitted(), parts.len(), merged.bytes_dropped);
    say(format!(
        "{out}: kept {kept} samples{bounds} of {parts} parts, {missing}{unchecked}; {dropped} bytes dropped; the \
         recording was not finished, later samples are lost"
    ));
    Ok(Outcome::DataLost)
}
