//! Captures and models as the analysis wants them.

use std::path::{Path, PathBuf};

use anyhow::Context as _;
use archive::{Capture, attachment};
use dynamics::{Calibration, Model};
use identification::{Fit, Samples};
use report::{CaptureFacts, FigureNumbers, FitPage};

use crate::outcome::remark;

/// A capture with what is known of the rig that made it.
pub struct LoadedCapture {
    /// The capture.
    pub capture: Capture,
    /// The rig's calibration; `None` for a table.
    pub calibration: Option<Calibration>,
    /// The knob that the simulated rig turned; `None` for a real one or a table.
    pub truth: Option<Model>,
}

impl LoadedCapture {
    /// Reads a capture and its attachments; of a table, the calibration that an export put beside it.
    ///
    /// # Errors
    /// One sentence on what is wrong with the file.
    pub fn load(path: &Path) -> anyhow::Result<Self> {
        let capture = Capture::load(path)?.of_knob();
        let calibration = match capture.attached_text(attachment::CALIBRATION).filter(|text| !text.is_empty()) {
            Some(text) => Some(Calibration::from_toml(text).with_context(|| path.display().to_string())?),
            None if capture.description.is_none() => read_calibration_beside(path)?,
            None => None,
        };
        let truth = capture
            .attached_text(attachment::MODEL)
            .map(|text| Model::from_toml(text, &format!("the model in {}", path.display())))
            .transpose()?;
        let seen = |known: Calibration| if capture.is_rendered() { known.seen_from_the_hand() } else { known };
        let calibration = calibration.map(seen);
        Ok(Self { capture, calibration, truth })
    }

    /// The columns that a fit takes.
    pub fn samples(&self) -> Samples<'_> {
        Samples {
            t_s: &self.capture.t_s,
            angle_rad: &self.capture.angle_rad,
            velocity_rad_s: self.capture.velocity_rad_s.as_deref(),
            acceleration_rad_s2: self.capture.acceleration_rad_s2.as_deref(),
            torque_mnm: &self.capture.torque_mnm,
        }
    }

    /// Torque commanded from the motor, mNm; none for a table or a simulation without it.
    pub fn commanded_torque_mnm(&self) -> Option<&[f64]> {
        self.capture.commanded_torque_mnm.as_deref()
    }

    /// What to call it in tables and on pages.
    pub fn title(&self) -> String {
        let file = self.capture.source.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let title = match &self.capture.description {
            Some(description) => format!("Knob {} ({file})", description.knob),
            None => file,
        };
        // Either may hold anything of any length.
        operator::one_line(&title)
    }

    /// The report page of a fit of this capture, with the numbers in its captions.
    pub fn report_page(&self, fit: &Fit) -> (String, FigureNumbers) {
        report::fit_page_with_numbers(&FitPage { fit, capture: self.facts(), truth: self.truth.as_ref() })
    }

    /// What a report page says of the capture besides the fit.
    #[allow(clippy::cast_precision_loss, reason = "a number of samples")]
    pub fn facts(&self) -> CaptureFacts {
        let capture = &self.capture;
        let file = capture.source.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let facts = CaptureFacts {
            title: self.title(),
            source: file,
            rate_hz: capture.rate_hz,
            duration_s: capture.tick.last().map_or(0.0, |tick| (tick + 1) as f64 / capture.rate_hz),
            samples: capture.len() as u64,
            software_version: env!("CARGO_PKG_VERSION").to_owned(),
            ..CaptureFacts::default()
        };
        let Some(run) = &capture.description else { return facts };
        let first_tick = capture.tick.first().copied().unwrap_or(0);
        let lost: u64 = capture.gaps.iter().map(|gap| gap.count).sum();
        CaptureFacts {
            knob: run.knob.clone(),
            rig: run.apparatus.clone(),
            captured_at: captured_at(run.clock.wall_clock_time_ns),
            missed_ticks: Some((capture.ticks_without_sample() + first_tick).saturating_sub(lost)),
            gaps: Some(lost),
            real_time: Some(run.realtime & shared_types::realtime::FULL == shared_types::realtime::FULL),
            ..facts
        }
    }
}

/// Where the calibration of an exported table lies.
pub fn calibration_beside(table: &Path) -> PathBuf {
    table.with_extension("calibration.toml")
}

/// The calibration of an exported table; `None` for a table that came without one.
fn read_calibration_beside(table: &Path) -> anyhow::Result<Option<Calibration>> {
    let path = calibration_beside(table);
    if !path.try_exists().with_context(|| format!("{} cannot be read", path.display()))? {
        return Ok(None);
    }
    let known = Calibration::load(&path)?;
    remark(format!("the rig's calibration is that of {}", path.display()));
    Ok(Some(known))
}

/// Date and time of a capture in the reader's time zone.
fn captured_at(wall_clock_time_ns: u64) -> String {
    let second = i64::try_from(wall_clock_time_ns / 1_000_000_000).unwrap_or(0);
    jiff::Timestamp::from_second(second).map_or_else(
        |_| String::new(),
        |time| time.to_zoned(jiff::tz::TimeZone::system()).strftime("%Y-%m-%d %H:%M:%S %Z").to_string(),
    )
}
