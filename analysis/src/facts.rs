//! What tables and pages say of a capture.

use identification::Fit;
use loaded_capture::LoadedCapture;
use report::{CaptureFacts, FigureNumbers, FitPage};

/// The report page of a fit of this capture, with the numbers in its captions.
#[must_use]
pub fn fit_page(loaded: &LoadedCapture, fit: &Fit) -> (String, FigureNumbers) {
    let (page, numbers) =
        report::fit_page_with_numbers(&FitPage { fit, capture: facts(loaded), truth: loaded.truth.as_ref() });
    (fit.axis.words(&page).into_owned(), numbers)
}

/// What a report page says of the capture besides the fit.
#[must_use]
pub fn facts(loaded: &LoadedCapture) -> CaptureFacts {
    let capture = &loaded.capture;
    let facts = CaptureFacts {
        title: loaded.title(),
        source: capture.file_name(),
        rate_hz: capture.rate_hz,
        duration_s: capture.duration_s(),
        samples: capture.len() as u64,
        software_version: env!("CARGO_PKG_VERSION").to_owned(),
        ..CaptureFacts::default()
    };
    let Some(run) = &capture.description else { return facts };
    // What was made of a table or simulated was never run.
    let was_run = run.clock.wall_clock_time_ns > 0;
    CaptureFacts {
        knob: run.knob.clone(),
        rig: run.apparatus.clone(),
        captured_at: if was_run { captured_at(run.clock.wall_clock_time_ns) } else { String::new() },
        missed_ticks: was_run.then(|| capture.missed_tick_count()),
        gaps: Some(capture.lost_samples()),
        real_time: was_run.then_some(run.realtime & shared_types::realtime::FULL == shared_types::realtime::FULL),
        ..facts
    }
}

/// Date and time of a capture in the reader's time zone.
fn captured_at(wall_clock_time_ns: u64) -> String {
    let second = i64::try_from(wall_clock_time_ns / 1_000_000_000).unwrap_or(0);
    jiff::Timestamp::from_second(second).map_or_else(
        |_| String::new(),
        |time| time.to_zoned(jiff::tz::TimeZone::system()).strftime("%Y-%m-%d %H:%M:%S %Z").to_string(),
    )
}
