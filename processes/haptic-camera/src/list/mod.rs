//! `list`: what captures a folder holds, of which knob, how good their fits are and whether they are whole.

mod entry;

use std::collections::BTreeMap;
use std::path::PathBuf;

use anyhow::Context as _;
use clap::Args;
use dynamics::Axis;
use operator::one_line;

use crate::outcome::show;
use crate::outputs::write_json;
use crate::terminal;
use entry::{Entry, Health};

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

/// Lists the captures of a folder by time; a file that cannot be read is an entry.
pub fn run(options: &ListOptions) -> anyhow::Result<()> {
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
    entries.sort_by(|a, b| (a.captured_at_ns, &a.file).cmp(&(b.captured_at_ns, &b.file)));
    if entries.is_empty() {
        show([format!("{} holds no captures; `haptic-camera capture --out {0}` makes one", folder.display())]);
    } else {
        show(lines(&entries));
    }
    write_json(Axis::default(), &options.json, &BTreeMap::from([("captures", &entries)]))
}

const NAME_LETTERS: usize = 27;
const KNOB_LETTERS: usize = 7;

/// The table, and a sentence on each file that is no whole capture.
fn lines(entries: &[Entry]) -> Vec<String> {
    let or_dash = |text: Option<String>| text.unwrap_or_else(|| "-".to_owned());
    let rows = entries.iter().map(|entry| {
        [
            shortened(&one_line(&entry.file), NAME_LETTERS),
            shortened(&one_line(entry.knob.as_deref().unwrap_or("-")), KNOB_LETTERS),
            or_dash(entry.captured_at.as_deref().and_then(minutes)),
            or_dash(entry.duration_s.map(|duration_s| format!("{duration_s:.1}"))),
            or_dash(entry.quality.relative_error_percent.map(|error| format!("{error:.1} %"))),
            or_dash(entry.quality.mean_ci95_mnm.map(|half_width| format!("{half_width:.3}"))),
            word(entry).to_owned(),
        ]
    });
    let mut table = terminal::table(["file", "knob", "captured", "s", "error", "95 %", "health"], 3..6, rows);
    table.column_iter_mut().for_each(|column| {
        column.set_padding((0, 1));
    });
    let mut lines = terminal::lines(&table);
    lines.push("s: length; error: residual, share of torque; 95 %: mean half width, mNm or N".to_owned());
    lines.extend(entries.iter().filter_map(remark));
    lines
}

fn minutes(date: &str) -> Option<String> {
    Some(format!("{} {}", date.get(..10)?, date.get(11..16)?))
}

/// A name that fits; its end tells more than its middle.
fn shortened(name: &str, most: usize) -> String {
    let letters: Vec<char> = name.chars().collect();
    if letters.len() <= most {
        return name.to_owned();
    }
    let end = most / 2;
    let (first, last) = (&letters[..most - end - 1], &letters[letters.len() - end..]);
    first.iter().chain(&['…']).chain(last).collect()
}

fn word(entry: &Entry) -> &'static str {
    match entry.health {
        Health::Whole if entry.missed_ticks.is_some_and(|ticks| ticks > 0) => "late",
        Health::Whole => "whole",
        Health::SamplesLost => "lost",
        Health::Fault => "fault",
        Health::Truncated => "truncated",
        Health::Damaged => "damaged",
        Health::Foreign => "foreign",
        Health::Unreadable => "unreadable",
    }
}

fn remark(entry: &Entry) -> Option<String> {
    // What is no capture needs no advice.
    if entry.health == Health::Foreign {
        return None;
    }
    if let Some(problem) = &entry.problem {
        return Some(format!("- {problem}"));
    }
    let some = |count: Option<u64>| count.filter(|&count| count > 0);
    let words = [
        some(entry.lost_samples).zip(entry.gaps).map(|(lost, gaps)| format!("{lost} samples lost in {gaps} gaps")),
        some(entry.missed_ticks).map(|ticks| format!("{ticks} ticks missed")),
        some(entry.stale_ticks).map(|ticks| format!("{ticks} ticks without new data")),
        entry.clock_drift_ppm.map(|drift_ppm| format!("the rig's clock drifted by {drift_ppm:+.1} ppm")),
        (entry.health == Health::Fault).then(|| "the run ended in a fault".to_owned()),
        entry.recovered.then(|| "recovered from a broken archive".to_owned()),
    ];
    let words: Vec<String> = words.into_iter().flatten().collect();
    (!words.is_empty()).then(|| format!("- {}: {}", one_line(&entry.file), words.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::shortened;

    #[test]
    fn a_long_name_keeps_its_beginning_and_its_end() {
        assert_eq!(shortened("20261121-101500-knob-3.mcap", 27), "20261121-101500-knob-3.mcap");
        let long = shortened("20261121-101500-a-knob-with-a-long-name.mcap", 27);
        assert!(long.starts_with("20261121-1") && long.ends_with("name.mcap"), "{long}");
        assert!(long.chars().count() <= 27);
    }
}
