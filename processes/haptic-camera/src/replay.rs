//! `replay`: the rig feels like a model, for as long as the operator wants.

use std::path::Path;

use dynamics::Axis;
use rt_loop::request::{HandRequest, LONGEST_DURATION_S, RunRequest};

use crate::command_line::ReplayOptions;
use crate::outcome::{Outcome, say};
use crate::supervision::{Archived, ModelStart, RunEnd, Shown, SupervisedRun, claim_archive, listen_for_interrupt};
use crate::verify;

/// Most models that are listed at the end.
const LISTED_MODELS: usize = 12;

/// Renders a model from start to end and keeps what the hand did.
///
/// # Errors
/// Whatever keeps a run from being started, recorded or ended.
pub fn run(options: &ReplayOptions) -> anyhow::Result<Outcome> {
    let interrupted = listen_for_interrupt()?;
    if options.verify {
        return verify::run(options, &interrupted);
    }
    let request = options.request();
    let claim = claim_archive(&options.run.out, request.knob_name(), "replay-")?;
    let axis = rt_loop::rigs::file(&request.rig)?.axis;
    let run = SupervisedRun {
        in_words: in_words(options, axis, &request),
        request,
        offline: options.run.offline,
        viewer: options.run.viewer(),
        archive: claim.archive().to_owned(),
        until: None,
        shown: Shown::Rendering,
    };
    match run.take(&interrupted)? {
        Some(end) => conclude(&run.archive, &end),
        None => Ok(Outcome::Failed),
    }
}

/// What is rendered, and for whom.
fn in_words(options: &ReplayOptions, axis: Axis, request: &RunRequest) -> String {
    let HandRequest { hand, hand_torque, .. } = &options.hand;
    let model = request.knob_name();
    let model = if model.parse::<u32>().is_ok() { format!("knob {model}") } else { model.to_owned() };
    let hand = match (hand_torque, hand.as_str()) {
        (Some(torque_mnm), _) => axis.words(&format!("a hand that applies {torque_mnm} mNm")).into_owned(),
        (None, "none") => "nobody's hand on it".to_owned(),
        (None, motion) => format!("a hand that follows {motion}"),
    };
    let length = if request.is_open_ended() {
        format!("until Ctrl-C, {} h at most", LONGEST_DURATION_S / 3600.0)
    } else {
        format!("for {} s", request.duration_s)
    };
    format!("rendering {model} with {hand} at {} Hz {length}", request.pace.rate_hz)
}

/// Tells what was rendered, how it went and where the archive lies.
fn conclude(archive: &Path, end: &RunEnd) -> anyhow::Result<Outcome> {
    end.tell();
    end.models.iter().enumerate().take(LISTED_MODELS).for_each(|(index, ModelStart { tick, name })| {
        #[allow(clippy::cast_precision_loss, reason = "ticks stay far below 2^53")]
        let from_s = *tick as f64 / end.status.rate_hz.max(1.0);
        say(format!("{} {name} from {from_s:.2} s on", if index == 0 { "rendered" } else { "        " }));
    });
    if end.models.len() > LISTED_MODELS {
        say(format!("         and {} more models; the archive lists them all", end.models.len() - LISTED_MODELS));
    }
    say(format!("guard    dissipated energy in {} ticks", end.status.guarded_ticks));
    let Some(archive) = end.left_archive(archive) else { return Ok(end.outcome_without_archive()) };
    let archived = Archived::read(&archive)?;
    say(format!("archive  {} ({} samples)", archive.display(), archived.samples));
    Ok(end.settle(&archived))
}
