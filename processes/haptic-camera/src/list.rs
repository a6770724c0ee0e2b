//! `list`: what captures a folder holds, of which knob, how good their fits are and whether they are whole.

use std::collections::BTreeMap;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

use anyhow::Context as _;
use archive::{ArchiveError, Overview};
use clap::Args;
use dynamics::Axis;
use foreign_files::TableError;
use identification::PreparationMethod;
use operator::one_line;
use serde::{Deserialize, Serialize};
use shared_types::RunDescription;

use crate::outcome::show;
use crate::outputs::write_json;
use crate::{load, terminal};

#[derive(Debug, Args)]
pub struct ListOptions {
    /// The folder to list
    #[arg(default_value = "captures", value_name = "DIR")]
    pub folder: PathBuf,
    /// Write the list as JSON; `-` for standard output
    #[arg(long, value_name = "FILE", num_args = 0..=1, default_missing_value = "-")]
    pub json: Option<PathBuf>,
}

/// Endings of the files that commands write beside a capture, which are not listed.
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

/// Samples up to which a capture is fitted for a list: a minute and a half at 10 kHz, which takes about a second to fit.
const MOST_SAMPLES: u64 = 1_000_000;

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
enum Health {
    #[default]
    Whole,
    SamplesLost,
    Fault,
    /// The file ends in the middle.
    Truncated,
    /// The file contradicts itself.
    Damaged,
    /// The file is not a capture.
    Foreign,
    /// The system refuses to read the file.
    Unreadable,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize)]
struct Entry {
    file: String,
    health: Health,
    /// What is wrong with a file that cannot be read.
    #[serde(skip_serializing_if = "Option::is_none")]
    problem: Option<String>,
    /// When the run began; for a table or a file that cannot be read, when the file was written.
    captured_at: Option<String>,
    /// The knob, or the model of a replay.
    knob: Option<String>,
    /// Whether a hand felt a rendered model.
    replay: bool,
    /// Length, s.
    duration_s: Option<f64>,
    /// Sample rate, Hz.
    rate_hz: Option<f64>,
    samples: Option<u64>,
    /// Runs of missing samples.
    gaps: Option<u64>,
    lost_samples: Option<u64>,
    /// Ticks that the loop missed; `None` for a table.
    missed_ticks: Option<u64>,
    /// Ticks without new data from the rig.
    stale_ticks: Option<u64>,
    /// By how much the rig's clock was faster than the machine's, where the ticks followed it, ppm.
    clock_drift_ppm: Option<f64>,
    /// Whether it was recovered from a broken archive.
    recovered: bool,
    #[serde(flatten)]
    quality: Quality,
    /// The time of `captured_at` in ns since 1970, by which the list is sorted.
    #[serde(skip)]
    captured_at_ns: u128,
}

impl Entry {
    /// The entry of a file, whether or not it is a capture.
    fn of(path: &Path) -> Self {
        let overview = match Overview::read(path) {
            Ok(overview) => overview,
            Err(error) => return Self::of_other(path, &error),
        };
        let description = overview.description.as_ref();
        let begun_ns = description.map(|run| u128::from(run.clock.wall_clock_time_ns));
        let captured_at_ns = begun_ns.filter(|&time| time > 0).unwrap_or_else(|| written_ns(path));
        let health = match () {
            () if overview.fault => Health::Fault,
            () if overview.lost_samples > 0 => Health::SamplesLost,
            () => Health::Whole,
        };
        Self {
            file: name(path),
            health,
            captured_at: date(captured_at_ns),
            replay: description.is_some_and(RunDescription::is_rendered),
            knob: description.map(|run| run.knob.clone()),
            duration_s: Some(overview.duration_s),
            rate_hz: Some(overview.rate_hz),
            samples: Some(overview.samples),
            gaps: Some(overview.gaps.len() as u64),
            lost_samples: Some(overview.lost_samples),
            missed_ticks: overview.missed_ticks,
            stale_ticks: Some(overview.rig.stale_samples.values().sum()),
            clock_drift_ppm: overview.rig.clock.as_ref().map(|clock| clock.drift_ppm),
            recovered: overview.recovered,
            quality: Quality::of(path, overview.samples),
            captured_at_ns,
            ..Self::default()
        }
    }

    fn of_other(path: &Path, error: &ArchiveError) -> Self {
        let health = match error {
            ArchiveError::Truncated { .. } => Health::Truncated,
            ArchiveError::Missing { .. } | ArchiveError::File { .. } => Health::Unreadable,
            ArchiveError::Empty { .. }
            | ArchiveError::NotACapture { .. }
            | ArchiveError::NoSamples { .. }
            | ArchiveError::Tester { .. }
            | ArchiveError::NoTime { .. }
            | ArchiveError::Table { error: TableError::Header { .. }, .. } => Health::Foreign,
            _ => Health::Damaged,
        };
        let captured_at_ns = written_ns(path);
        Self {
            file: name(path),
            health,
            problem: Some(one_line(&error.to_string())),
            captured_at: date(captured_at_ns),
            captured_at_ns,
            ..Self::default()
        }
    }
}

/// How good a capture's fit is, from the JSON file beside it or else from a fit made for the list.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Quality {
    /// RMS of the residual as a share of the torque, %.
    relative_error_percent: Option<f64>,
    /// Mean half width of the 95 % interval of the model's torque, mNm or N.
    #[serde(alias = "mean_ci95_n")]
    mean_ci95_mnm: Option<f64>,
}

impl Quality {
    /// The quality of a readable capture; empty if it cannot be fitted or is too long to be fitted for a list.
    fn of(path: &Path, samples: u64) -> Self {
        let beside = foreign_files::open(&path.with_extension("json")).ok();
        let written = beside.and_then(|json| serde_json::from_reader::<_, Self>(BufReader::new(json)).ok());
        if let Some(written) = written.filter(|written| written.relative_error_percent.is_some()) {
            return written;
        }
        if samples > MOST_SAMPLES {
            return Self::default();
        }
        let loaded = load::load(path).ok();
        let fitted = loaded.and_then(|loaded| analysis::fit(&loaded, PreparationMethod::default()).ok());
        Self {
            relative_error_percent: fitted.as_ref().map(|fit| fit.relative_error_percent),
            mean_ci95_mnm: fitted.map(|fit| fit.mean_ci95_mnm),
        }
    }
}

fn name(path: &Path) -> String {
    path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}

/// When a file was last written, ns since 1970.
fn written_ns(path: &Path) -> u128 {
    let time = std::fs::metadata(path).and_then(|file| file.modified()).ok();
    time.and_then(|time| time.duration_since(UNIX_EPOCH).ok()).map_or(0, |time| time.as_nanos())
}

/// Date and time in the reader's time zone.
fn date(since_1970_ns: u128) -> Option<String> {
    let time = jiff::Timestamp::from_nanosecond(i128::try_from(since_1970_ns).ok()?).ok()?;
    Some(time.to_zoned(jiff::tz::TimeZone::system()).strftime("%Y-%m-%dT%H:%M:%S%:z").to_string())
}

const NAME_LETTERS: usize = 27;
const KNOB_LETTERS: usize = 7;

/// The table, and a sentence on each file that is no whole capture.
fn lines(entries: &[Entry]) -> Vec<String> {
    let to_minutes = |date: &str| Some(format!("{} {}", date.get(..10)?, date.get(11..16)?));
    let or_dash = |text: Option<String>| text.unwrap_or_else(|| "-".to_owned());
    let rows = entries.iter().map(|entry| {
        [
            shortened(&one_line(&entry.file), NAME_LETTERS),
            shortened(&one_line(entry.knob.as_deref().unwrap_or("-")), KNOB_LETTERS),
            or_dash(entry.captured_at.as_deref().and_then(to_minutes)),
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
    // A file that is no capture needs no advice.
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
