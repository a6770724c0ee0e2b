//! After the run: what was captured, the fitted model, and where everything lies.

use std::path::Path;

use crate::fit;
use crate::load::LoadedCapture;
use crate::outcome::{Outcome, remark, say};
use crate::supervision::RunEnd;

/// Gaps that are told one by one.
const TOLD_GAPS: usize = 5;

/// Tells how the run went, fits the archive and writes model and report beside it.
///
/// # Errors
/// When the archive cannot be read or the results not written.
pub(super) fn conclude(archive: &Path, end: &RunEnd) -> anyhow::Result<Outcome> {
    let Some((loaded, outcome)) = read_back(archive, end)? else { return Ok(end.outcome_without_archive()) };
    let archive = loaded.capture.source.as_path();
    match fit::fit_capture(&loaded) {
        Ok(fitted) => {
            let (model, report) = (archive.with_extension("toml"), archive.with_extension("html"));
            fit::write(&model, &fitted.model(&loaded.title()).to_toml())?;
            fit::write(&report, &loaded.report_page(&fitted).0)?;
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
    end.tell();
    let Some(archive) = end.left_archive(archive) else { return Ok(None) };
    let loaded = LoadedCapture::load(&archive)?;
    let missing: u64 = loaded.capture.gaps.iter().map(|gap| gap.count).sum();
    say(format!("archive  {} ({} samples)", archive.display(), loaded.capture.len()));
    if missing > 0 {
        let told: Vec<String> = loaded.capture.gaps.iter().take(TOLD_GAPS).map(ToString::to_string).collect();
        let more = if loaded.capture.gaps.len() > told.len() { ", ...; the archive says where" } else { "" };
        remark(format!("{missing} samples are missing in the archive: {}{more}", told.join(", ")));
    }
    let outcome = end.outcome(missing);
    Ok(Some((loaded, outcome)))
}
