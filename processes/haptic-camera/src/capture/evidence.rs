//! The captures that a diagnosis rests on, and how further ones join them.

use dynamics::{Coordinate, effects};
use identification::diagnosis::Diagnosis;
use loaded_capture::LoadedCapture;

use super::CaptureOptions;
use crate::diagnose::with_progress;
use crate::outcome::say;

/// Diagnoses all captures so far, two at least; `before` is the diagnosis of all but the last.
///
/// The second capture is held out; the first and all later ones are fitted together, so that the experiments which tell rivals
/// apart also determine their parameters, and the sweep the others. An effect of the time since a capture began cannot be fitted
/// across captures: where one is named or tied, the first capture alone is fitted and the last one is held out.
pub(super) fn diagnosed(
    options: &CaptureOptions,
    mut fitted: Vec<&LoadedCapture>,
    before: Option<&Diagnosis>,
) -> anyhow::Result<Diagnosis> {
    let held_out = if before.is_some_and(depends_on_time) {
        let last = fitted.split_off(fitted.len() - 1);
        fitted.truncate(1);
        last
    } else {
        vec![fitted.remove(1)]
    };
    let (train, heldout) = (LoadedCapture::joined(&fitted), LoadedCapture::joined(&held_out));
    let found = with_progress(|progress| {
        Ok(analysis::diagnose_in_these_roles(options.reach, &train, &heldout, None, Some(progress))?)
    })?;
    ["", &found.summary].iter().for_each(say);
    Ok(found)
}

/// Whether a name or a rival is an effect of the time since a capture began.
fn depends_on_time(found: &Diagnosis) -> bool {
    let names = found.steps.iter().flat_map(|step| step.ties.iter().chain([&step.effect]));
    names.into_iter().filter_map(|name| effects::by_name(name)).any(|kind| kind.depends_on.contains(&Coordinate::Time))
}
