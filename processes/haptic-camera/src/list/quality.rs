//! How good a capture's fit is: from the JSON beside it, or from a fit made for the purpose.

use std::io::BufReader;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::fit::fit_capture;
use crate::load;

/// Samples up to which a capture is fitted for a list: a minute and a half at 10 kHz, a second's work or so.
const MOST_SAMPLES: u64 = 1_000_000;

/// What a fit's JSON says of its quality.
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
        let fitted = load::load(path).and_then(|loaded| fit_capture(&loaded));
        fitted.map_or_else(
            |_| Self::default(),
            |fit| Self {
                relative_error_percent: Some(fit.relative_error_percent),
                mean_ci95_mnm: Some(fit.mean_ci95_mnm),
            },
        )
    }
}
