//! One file of the list.

use std::io::BufReader;
use std::path::Path;
use std::time::UNIX_EPOCH;

use archive::{ArchiveError, Overview};
use foreign_files::TableError;
use operator::one_line;
use serde::{Deserialize, Serialize};
use shared_types::RunDescription;

use crate::fit::fit_capture;
use crate::load;

/// Samples up to which a capture is fitted for a list: a minute and a half at 10 kHz, a second's work or so.
const MOST_SAMPLES: u64 = 1_000_000;

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Health {
    #[default]
    Whole,
    SamplesLost,
    Fault,
    /// The file ends in the middle.
    Truncated,
    /// The file contradicts itself.
    Damaged,
    /// It is no capture.
    Foreign,
    /// The system does not let it be read.
    Unreadable,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(super) struct Entry {
    pub(super) file: String,
    pub(super) health: Health,
    /// What is wrong with a file that cannot be read.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) problem: Option<String>,
    /// When the run began; of a table and of a file that cannot be read, when it was written.
    pub(super) captured_at: Option<String>,
    /// The knob, or the model of a replay.
    pub(super) knob: Option<String>,
    /// Whether a hand felt a rendered model.
    pub(super) replay: bool,
    /// Length, s.
    pub(super) duration_s: Option<f64>,
    /// Sample rate, Hz.
    pub(super) rate_hz: Option<f64>,
    pub(super) samples: Option<u64>,
    /// Runs of samples that are not.
    pub(super) gaps: Option<u64>,
    pub(super) lost_samples: Option<u64>,
    /// Ticks that the loop missed; none from a table.
    pub(super) missed_ticks: Option<u64>,
    /// Ticks without new data from the rig.
    pub(super) stale_ticks: Option<u64>,
    /// By how much the rig's clock was faster than the machine's, where the ticks followed it, ppm.
    pub(super) clock_drift_ppm: Option<f64>,
    /// Whether it was made of a broken archive.
    pub(super) recovered: bool,
    #[serde(flatten)]
    pub(super) quality: Quality,
    /// When, ns since 1970: what the list is sorted by.
    #[serde(skip)]
    pub(super) captured_at_ns: u128,
}

impl Entry {
    /// Looks at a file, whatever it is.
    pub(super) fn of(path: &Path) -> Self {
        match Overview::read(path) {
            Ok(overview) => Self::of_capture(path, &overview),
            Err(error) => Self::of_other(path, &error),
        }
    }

    fn of_capture(path: &Path, overview: &Overview) -> Self {
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
            gaps: Some(overview.gaps),
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

/// How good a capture's fit is: what the JSON beside it says, or a fit that is made for the purpose.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Quality {
    /// RMS of what the model leaves, as a share of the torque, %.
    pub(super) relative_error_percent: Option<f64>,
    /// Mean half width of the 95 % interval of the model's torque, mNm or N.
    #[serde(alias = "mean_ci95_n")]
    pub(super) mean_ci95_mnm: Option<f64>,
}

impl Quality {
    /// Of a capture that can be read; nothing where it tells no model, or is too long to be fitted in passing.
    pub(super) fn of(path: &Path, samples: u64) -> Self {
        let beside = foreign_files::open(&path.with_extension("json")).ok();
        let written = beside.and_then(|json| serde_json::from_reader::<_, Self>(BufReader::new(json)).ok());
        if let Some(written) = written.filter(|written| written.relative_error_percent.is_some()) {
            return written;
        }
        if samples > MOST_SAMPLES {
            return Self::default();
        }
        let fitted = load::load(path).and_then(|loaded| fit_capture(&loaded)).ok();
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
