//! After the run: what was captured, the fitted model, and where everything lies.

use std::path::Path;

use archive::claim::numbered;
use archive::{Overview, whole_file};
use identification::live::Convergence;
use identification::{Fit, PreparationMethod};
use loaded_capture::LoadedCapture;

use crate::command_line::outputs::{ResultFiles, kind, show_on, write};
use crate::outcome::{Outcome, remark, say};
use crate::supervision::RunEnd;
use crate::until_ci::{StopRule, open, share_words};
use crate::{fit, load};

const NAMES_TRIED: u32 = 1_000;

/// Tells how the run went, fits the archive and writes model and report beside it: where they cannot be written, the run
/// counts as a failure.
pub(super) fn conclude(archive: &Path, end: &RunEnd, planned_s: f64) -> anyhow::Result<Outcome> {
    if let Some(achieved) = &end.achieved {
        say(end_of_sweep(achieved, planned_s));
    }
    let Some((loaded, mut outcome)) = read_back(archive, end)? else { return Ok(end.outcome_without_archive()) };
    let archive = loaded.capture.source.display();
    match analysis::fit(&loaded, PreparationMethod::default()) {
        Ok(fitted) => {
            if let Err(error) = keep(&loaded, &fitted) {
                remark(format!("{error:#}; the archive is kept: run `haptic-camera fit {archive}` to write them"));
                outcome = Outcome::Failed;
            }
            say(format!("view     haptic-camera view {archive}"));
            say("");
            show_on(fitted.axis, fit::lines(loaded.truth.as_ref(), &fitted));
            if let Some(achieved) = &end.achieved {
                let step_mnm = loaded.calibration.as_ref().map_or(0.0, |known| known.torque_step_mnm);
                tell_precision(achieved, &fitted, step_mnm);
            }
        }
        // The capture is kept and whole; that it tells no model is a finding, not a failure.
        Err(error) => remark(format!("no model: {error:#}")),
    }
    Ok(outcome)
}

/// Writes model, report and figures beside the archive, under its name unless somebody has taken that meanwhile.
fn keep(loaded: &LoadedCapture, fitted: &Fit) -> anyhow::Result<()> {
    let archive = &loaded.capture.source;
    let stem = archive.file_stem().unwrap_or_default().to_string_lossy();
    let results = [("toml", kind::FITTED_MODEL), ("html", kind::PAGE), ("json", kind::JSON)];
    let named = |number, ending: &str| archive.with_file_name(format!("{}.{ending}", numbered(&stem, number)));
    let is_free =
        |number: &u32| results.iter().all(|(ending, kind)| whole_file::check(&named(*number, ending), *kind).is_ok());
    let number = (1..NAMES_TRIED).find(is_free).unwrap_or(1);
    let [model, report, json] = results.map(|(ending, _)| named(number, ending));
    write(&model, kind::FITTED_MODEL, &fitted.model(&loaded.title()).to_toml())?;
    say(format!("model    {}", model.display()));
    // The JSON is for `list`, and for whoever computes with the intervals.
    fit::write_results(&ResultFiles { json: Some(json), report: Some(report.clone()) }, loaded, fitted)?;
    say(format!("report   {}", report.display()));
    Ok(())
}

/// Whether a run that was to end once enough is known reached that, and how much of the planned sweep it saved.
fn end_of_sweep(achieved: &StopRule, planned_s: f64) -> String {
    let share = achieved.asked;
    let Some(ended_s) = achieved.ended_s else {
        let open: Vec<String> = achieved.last.iter().flat_map(|last| open(&last.parameters)).map(share_words).collect();
        let open = if open.is_empty() { "there was no steady estimate".to_owned() } else { open.join(", ") };
        return format!("not known within {share} by the end: {open}; give a longer --duration-s, or a larger share");
    };
    let saved_s = planned_s - ended_s;
    let percent = 100.0 * saved_s / planned_s;
    format!("known within {share} after {ended_s:.2} s of {planned_s} s planned: {saved_s:.2} s saved, {percent:.0} %")
}

/// Compares the fit of the archive with the share for which the sweep was to end.
fn tell_precision(achieved: &StopRule, fitted: &Fit, torque_step_mnm: f64) {
    let Some(known) = achieved.verify(fitted, torque_step_mnm) else { return };
    let share = achieved.asked;
    let open: Vec<String> = open(&known).into_iter().map(share_words).collect();
    let converged = known.iter().filter(|known| known.convergence == Convergence::Converged);
    let widest = converged.max_by(|one, other| one.share().unwrap_or(0.0).total_cmp(&other.share().unwrap_or(0.0)));
    if !open.is_empty() {
        remark(format!("not known within {share} in the fit of the archive: {}", open.join(", ")));
    } else if let Some(widest) = widest {
        say(format!("every parameter is known within {share}; the widest interval: {}", share_words(widest)));
    }
}

/// Tells how the run went and reads its archive; `None` when there is none.
pub(super) fn read_back(archive: &Path, end: &RunEnd) -> anyhow::Result<Option<(LoadedCapture, Outcome)>> {
    end.tell();
    let Some(archive) = end.left_archive(archive) else { return Ok(None) };
    let loaded = load::load(&archive)?;
    say(format!("archive  {} ({} samples)", archive.display(), loaded.capture.len()));
    let capture = &loaded.capture;
    let outcome = end.settle(&Overview {
        samples: capture.len() as u64 + capture.unmeasured_samples(),
        lost_samples: capture.lost_samples(),
        gaps: capture.gaps.clone(),
        rig: capture.rig.clone(),
        ..Overview::default()
    });
    Ok(Some((loaded, outcome)))
}
