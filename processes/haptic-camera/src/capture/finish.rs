//! After the run: what was captured, the fitted model, and where everything lies.

use std::path::Path;

use super::{RunEnd, fault_words};
use crate::fit;
use crate::load::LoadedCapture;
use crate::outcome::{Outcome, remark, say};

/// Tells how the run went, fits the archive and writes model and report beside it.
///
/// # Errors
/// When the archive cannot be read or the results not written.
pub(super) fn conclude(archive: &Path, end: &RunEnd) -> anyhow::Result<Outcome> {
    let Some((loaded, outcome)) = read_back(archive, end)? else { return Ok(Outcome::Failed) };
    match fit::fit_capture(&loaded) {
        Ok(fitted) => {
            let (model, report) = (archive.with_extension("toml"), archive.with_extension("html"));
            fit::write(&model, &fitted.model(&loaded.title()).to_toml())?;
            fit::write(&report, &loaded.report_page(&fitted))?;
            say(format!("model    {}", model.display()));
            say(format!("report   {}", report.display()));
            say(format!("view     haptic-camera view {}", archive.display()));
            say("");
            fit::show(&loaded, &fitted);
        }
        // The capture is kept and whole; that it tells no model is a finding, not a failure.
        Err(error) => remark(format!("no model: {error:#}")),
    }
    Ok(outcome)
}

/// Tells how the run went and reads its archive; `None` when there is none.
///
/// # Errors
/// When the archive cannot be read.
pub(super) fn read_back(archive: &Path, end: &RunEnd) -> anyhow::Result<Option<(LoadedCapture, Outcome)>> {
    tell_run(end);
    if !archive.exists() {
        remark(format!(
            "the recorder could not close {}; what it wrote lies beside it as parts, to be made whole by \
             `haptic-camera recover`",
            archive.display()
        ));
        return Ok(None);
    }
    let loaded = LoadedCapture::load(archive)?;
    let missing: u64 = loaded.capture.gaps.iter().map(|gap| gap.count).sum();
    say(format!("archive  {} ({} samples)", archive.display(), loaded.capture.len()));
    if missing > 0 {
        remark(format!("{missing} samples are missing in the archive; it says where"));
    }
    let outcome = if end.loop_died || fault_words(&end.status).is_some() {
        Outcome::Failed
    } else if missing > 0 || end.recorder_exit == Some(3) {
        Outcome::DataLost
    } else {
        Outcome::Done
    };
    Ok(Some((loaded, outcome)))
}

fn tell_run(end: &RunEnd) {
    let status = &end.status;
    if let Some(fault) = fault_words(status) {
        remark(format!("the run ended in a fault after {} samples: {fault}", status.published_samples));
    } else if end.interrupted {
        say(format!("stopped by the operator after {} samples", status.published_samples));
    }
    say(format!(
        "samples  {} taken, {} ticks missed in {} stalls, longest lateness {:.3} ms",
        status.published_samples,
        status.missed_ticks,
        status.overruns,
        ns_to_ms(status.max_lateness_ns)
    ));
    if status.dropped_samples > 0 {
        remark(format!("{} samples were lost before they could be published", status.dropped_samples));
    }
    for (kind, restarts) in end.restarts.iter().filter(|(_, restarts)| *restarts > 0) {
        say(format!("{} died and was restarted {restarts} times", kind.name()));
    }
}

#[allow(clippy::cast_precision_loss, reason = "for display")]
fn ns_to_ms(nanoseconds: u64) -> f64 {
    nanoseconds as f64 / 1e6
}
