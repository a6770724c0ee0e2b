//! `list`: what captures a folder holds, of which knob, how good their fits are and whether they are whole.

mod entry;
mod table;

use std::collections::BTreeMap;
use std::path::PathBuf;

use anyhow::Context as _;
use clap::Args;
use dynamics::Axis;

use crate::outcome::{Outcome, show};
use crate::outputs::write_json;
use entry::Entry;

#[derive(Debug, Args)]
pub struct ListOptions {
    /// The folder to list
    #[arg(default_value = "captures", value_name = "DIR")]
    pub folder: PathBuf,
    /// Write the list as JSON; `-` for standard output
    #[arg(long, value_name = "FILE", num_args = 0..=1, default_missing_value = "-")]
    pub json: Option<PathBuf>,
}

/// Endings of what lies beside a capture and was made of it: no captures, and no strangers.
const RESULTS: [&str; 7] = ["toml", "json", "html", "rrd", "parquet", "h", "incomplete"];

/// Lists the captures of a folder by time.
///
/// # Errors
/// When the folder cannot be read; a file in it that cannot is an entry.
pub fn run(options: &ListOptions) -> anyhow::Result<Outcome> {
    let folder = options.folder.as_path();
    let files = std::fs::read_dir(folder)
        .with_context(|| format!("the folder {} cannot be read; name the folder of the captures", folder.display()))?;
    let mut entries = Vec::new();
    for file in files {
        let path = file.with_context(|| format!("the folder {} cannot be read", folder.display()))?.path();
        let is_result = path.extension().is_some_and(|ending| RESULTS.iter().any(|known| ending == *known));
        if path.is_file() && !is_result {
            entries.push(Entry::of(&path));
        }
    }
    entries.sort_by(|one, other| one.order().cmp(&other.order()));
    if entries.is_empty() {
        show([format!("{} holds no captures; `haptic-camera capture --out {0}` makes one", folder.display())]);
    } else {
        show(table::lines(&entries));
    }
    write_json(Axis::default(), &options.json, &BTreeMap::from([("captures", &entries)]))?;
    Ok(Outcome::Done)
}
