//! `capture`: a knob turned through a sweep, recorded and fitted.

mod budget;
mod evidence;
mod finish;
mod next;
mod until_certain;
mod until_named;

use archive::Claim;
use rt_loop::request::RunRequest;

use crate::command_line::CaptureOptions;
use crate::outcome::Outcome;
use crate::supervision::{Shown, SupervisedRun, claim_archive, listen_for_interrupt};
pub(crate) use budget::Budget;
pub(crate) use finish::share_words;

/// Runs a capture from start to end, or capture after capture until the knob's effects have names or
/// the verdict on it is certain.
///
/// # Errors
/// Whatever keeps a run from being started, recorded or ended.
pub fn run(options: &CaptureOptions) -> anyhow::Result<Outcome> {
    let interrupted = listen_for_interrupt()?;
    if options.diagnose {
        return until_named::run(options, &interrupted);
    }
    if let Some(spec) = &options.spec {
        return until_certain::run(options, spec, &interrupted);
    }
    let claim = claim_archive(&options.run.out, options.request.knob_name(), "")?;
    let run = supervised(options, &claim);
    match run.take(&interrupted)? {
        Some(end) => finish::conclude(&run.archive, &end, options.request.duration_s),
        None => Ok(Outcome::Failed),
    }
}

/// What the run of a capture needs.
fn supervised(options: &CaptureOptions, claim: &Claim) -> SupervisedRun {
    SupervisedRun {
        in_words: in_words(options),
        request: options.request.clone(),
        offline: options.run.offline,
        viewer: options.run.viewer(),
        archive: claim.archive().to_owned(),
        until: options.until_ci,
        shown: Shown::Fit,
    }
}

/// What is captured, and how.
fn in_words(options: &CaptureOptions) -> String {
    let knob = options.request.knob_name();
    let RunRequest { sweep, torque, amplitude, duration_s, pace, .. } = &options.request;
    let amplitude = amplitude
        .map_or_else(String::new, |amplitude| format!(" of {amplitude:.3} {}", if *torque { "mNm" } else { "rad" }));
    let axis = rt_loop::rigs::file(&options.request.rig).map(|file| file.axis).unwrap_or_default();
    let amplitude = axis.words(&amplitude);
    let until = options.until_ci.map_or_else(|| "for ".to_owned(), |share| format!("until ± {share}, at most "));
    format!("capturing knob {knob} with {sweep}{amplitude} at {} Hz {until}{duration_s} s", pace.rate_hz)
}
