//! `list`: what captures a folder holds, of which knob, how good their fits are and whether they are whole.

use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

use anyhow::Context as _;
use archive::{ArchiveError, Overview};
use clap::Args;
use dynamics::Axis;
use foreign_files::TableError;
use identification::PreparationMethod;
use loaded_capture::LoadedCapture;
use operator::one_line;
use serde::Deserialize;
use serde_json::{Value, json};
use shared_types::RunDescription;

use crate::command_line::outputs::write_json;
use crate::outcome::show;
use crate::terminal;

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
    let captures: Vec<Value> = entries.iter().map(Entry::json).collect();
    write_json(Axis::default(), &options.json, &json!({ "captures": captures }))
}

/// Samples up to which a capture is fitted for a list: a minute and a half at 10 kHz, which takes about a second to fit.
const MOST_SAMPLES: u64 = 1_000_000;

struct Entry {
    file: String,
    /// When the run began; for a table or a file that cannot be read, when the file was written; ns since 1970.
    captured_at_ns: u128,
    read: Result<Overview, ArchiveError>,
    quality: Quality,
}

impl Entry {
    fn of(path: &Path) -> Self {
        let read = Overview::read(path);
        let run = read.as_ref().ok().and_then(|told| told.description.as_ref());
        let begun_ns = run.map(|run| u128::from(run.clock.wall_clock_time_ns)).filter(|&time| time > 0);
        let captured_at_ns = begun_ns.unwrap_or_else(|| written_ns(path));
        let quality = read.as_ref().map_or_else(|_| Quality::default(), |told| Quality::of(path, told.samples));
        let file = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        Self { file, captured_at_ns, read, quality }
    }

    /// Whether the capture is whole, in a word. A truncated file ends in the middle, a damaged one contradicts itself, a foreign one
    /// is no capture, and an unreadable one is refused by the system.
    fn health(&self) -> &'static str {
        match &self.read {
            Ok(told) if told.fault => "fault",
            Ok(told) if told.lost_samples > 0 => "samples-lost",
            Ok(_) => "whole",
            Err(ArchiveError::Truncated { .. }) => "truncated",
            Err(ArchiveError::Missing { .. } | ArchiveError::File { .. }) => "unreadable",
            Err(
                ArchiveError::Empty { .. }
                | ArchiveError::NotACapture { .. }
                | ArchiveError::NoSamples { .. }
                | ArchiveError::Tester { .. }
                | ArchiveError::NoTime { .. }
                | ArchiveError::Table { error: TableError::Header { .. }, .. },
            ) => "foreign",
            Err(_) => "damaged",
        }
    }

    /// The entry as JSON, with nothing for what the file does not tell.
    fn json(&self) -> Value {
        let told = self.read.as_ref().ok();
        let run = told.and_then(|told| told.description.as_ref());
        let mut entry = json!({
            "file": self.file,
            "health": self.health(),
            "captured_at": date(self.captured_at_ns),
            // Of a replay the model.
            "knob": run.map(|run| &run.knob),
            "replay": run.is_some_and(RunDescription::is_rendered),
            "duration_s": told.map(|told| told.duration_s),
            "rate_hz": told.map(|told| told.rate_hz),
            "samples": told.map(|told| told.samples),
            "gaps": told.map(|told| told.gaps.len()),
            "lost_samples": told.map(|told| told.lost_samples),
            "missed_ticks": told.and_then(|told| told.missed_ticks),
            // Without new data from the rig.
            "stale_ticks": told.map(|told| told.rig.stale_samples.values().sum::<u64>()),
            // By how much the rig's clock was faster than the machine's, where the ticks followed it.
            "clock_drift_ppm": told.and_then(|told| Some(told.rig.clock.as_ref()?.drift_ppm)),
            "recovered": told.is_some_and(|told| told.recovered),
            "relative_error_percent": self.quality.relative_error_percent,
            "mean_ci95_mnm": self.quality.mean_ci95_mnm,
        });
        if let Err(error) = &self.read {
            entry["problem"] = one_line(&error.to_string()).into();
        }
        entry
    }
}

/// How good a capture's fit is, from the JSON file beside it or else from a fit made for the list.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
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
        let loaded = LoadedCapture::load(path).ok();
        let fitted = loaded.and_then(|loaded| analysis::fit(&loaded, PreparationMethod::default()).ok());
        Self {
            relative_error_percent: fitted.as_ref().map(|fit| fit.relative_error_percent),
            mean_ci95_mnm: fitted.map(|fit| fit.mean_ci95_mnm),
        }
    }
}

/// When a file was written, ns since 1970; 0 where the system does not say.
pub fn written_ns(path: &Path) -> u128 {
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
    let to_minutes = |date: String| Some(format!("{} {}", date.get(..10)?, date.get(11..16)?));
    let or_dash = |text: Option<String>| text.unwrap_or_else(|| "-".to_owned());
    let rows = entries.iter().map(|entry| {
        let told = entry.read.as_ref().ok();
        let knob = told.and_then(|told| Some(one_line(&told.description.as_ref()?.knob)));
        [
            shortened(&one_line(&entry.file), NAME_LETTERS),
            shortened(&or_dash(knob), KNOB_LETTERS),
            or_dash(date(entry.captured_at_ns).and_then(to_minutes)),
            or_dash(told.map(|told| format!("{:.1}", told.duration_s))),
            or_dash(entry.quality.relative_error_percent.map(|error| format!("{error:.1} %"))),
            or_dash(entry.quality.mean_ci95_mnm.map(|half_width| format!("{half_width:.3}"))),
            word(entry).to_owned(),
        ]
    });
    let mut table = terminal::table(["file", "knob", "captured", "s", "error", "95 %", "health"], 3..6, rows);
    table.column_iter_mut().for_each(|column| {
        column.set_padding((0, 1));
    });
    let mut lines = vec![table.to_string()];
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
    let is_late = entry.read.as_ref().is_ok_and(|told| told.missed_ticks.is_some_and(|ticks| ticks > 0));
    match entry.health() {
        "whole" if is_late => "late",
        "samples-lost" => "lost",
        health => health,
    }
}

fn remark(entry: &Entry) -> Option<String> {
    let told = match &entry.read {
        Ok(told) => told,
        // A file that is no capture needs no advice.
        Err(_) if entry.health() == "foreign" => return None,
        Err(error) => return Some(format!("- {}", one_line(&error.to_string()))),
    };
    let some = |count: u64| Some(count).filter(|&count| count > 0);
    let stale: u64 = told.rig.stale_samples.values().sum();
    let clock = told.rig.clock.as_ref();
    let words = [
        some(told.lost_samples).map(|lost| format!("{lost} samples lost in {} gaps", told.gaps.len())),
        told.missed_ticks.and_then(some).map(|ticks| format!("{ticks} ticks missed")),
        some(stale).map(|ticks| format!("{ticks} ticks without new data")),
        clock.map(|clock| format!("the rig's clock drifted by {:+.1} ppm", clock.drift_ppm)),
        told.fault.then(|| "the run ended in a fault".to_owned()),
        told.recovered.then(|| "recovered from a broken archive".to_owned()),
    ];
    let words: Vec<String> = words.into_iter().flatten().collect();
    (!words.is_empty()).then(|| format!("- {}: {}", one_line(&entry.file), words.join(", ")))
}
