//! `capture`: a knob turned through a sweep, recorded and fitted.

mod budget;
mod evidence;
mod finish;
mod next;
mod until_named;

use archive::Claim;

use crate::command_line::CaptureOptions;
use crate::large_job;
use crate::outcome::Outcome;
use crate::supervision::{Shown, SupervisedRun, claim_archive, listen_for_interrupt};
pub(crate) use budget::Budget;
pub(crate) use finish::share_words;

/// Runs a capture from start to end, or capture after capture until the knob's effects have names.
///
/// # Errors
/// Whatever keeps a run from being started, recorded or ended.
pub fn run(options: &CaptureOptions) -> anyhow::Result<Outcome> {
    let interrupted = listen_for_interrupt()?;
    if options.diagnose {
        return until_named::run(options, &interrupted);
    }
    let claim = claim_archive(&options.run.out, &options.knob, "")?;
    let run = supervised(options, &claim);
    if !options.run.offline {
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "an absurd length is refused later"
        )]
        large_job::tell((options.duration_s * options.run.rate_hz) as u64);
    }
    match run.take(&interrupted)? {
        Some(end) => finish::conclude(&run.archive, &end, options.duration_s),
        None => Ok(Outcome::Failed),
    }
}

/// What the run of a capture needs.
fn supervised<'a>(options: &'a CaptureOptions, claim: &Claim) -> SupervisedRun<'a> {
    let mut task = vec![
        format!("--knob={}", options.knob),
        format!("--sweep={}", options.sweep),
        format!("--duration-s={}", options.duration_s),
    ];
    if options.torque {
        task.push("--torque".to_owned());
    }
    if let Some(amplitude) = options.amplitude {
        task.push(format!("--amplitude={amplitude}"));
    }
    SupervisedRun {
        in_words: in_words(options),
        task,
        options: &options.run,
        archive: claim.archive().to_owned(),
        duration_s: Some(options.duration_s),
        until: options.until_ci,
        shown: Shown::Fit,
    }
}

/// What is captured, and how.
fn in_words(options: &CaptureOptions) -> String {
    let amplitude = options.amplitude.map_or_else(String::new, |amplitude| {
        format!(" of {amplitude:.3} {}", if options.torque { "mNm" } else { "rad" })
    });
    let CaptureOptions { knob, sweep, duration_s, run, .. } = options;
    let until = options.until_ci.map_or_else(|| "for ".to_owned(), |share| format!("until ± {share}, at most "));
    format!("capturing knob {knob} with {sweep}{amplitude} at {} Hz {until}{duration_s} s", run.rate_hz)
}
