//! One run of the rig that a command makes by itself, live or offline.

use std::path::{Path, PathBuf};

use anyhow::Context as _;
use archive::claim;
use rt_loop::request::{Pace, RigRequest, RunRequest};

use crate::outcome::Outcome;
use crate::supervision::{Interrupt, SupervisedRun, archive_stem};

/// A run through a sweep without a knob: `on_it` is `none` or `locked`.
pub fn request(on_it: &str, sweep: &str, duration_s: f64, pace: Pace, rig: RigRequest) -> RunRequest {
    let (knob, sweep) = (Some(on_it.to_owned()), sweep.to_owned());
    RunRequest { knob, sweep, duration_s, pace, rig, ..RunRequest::default() }
}

/// Makes the run in a folder of its own, named after its purpose; gives its archive, and whether data was lost.
pub fn archive(
    request: RunRequest,
    captures_in: &Path,
    offline: bool,
    purpose: &str,
    interrupt: &Interrupt,
) -> anyhow::Result<(PathBuf, Outcome)> {
    let folder = claim::folder(captures_in, &archive_stem(purpose, ""))
        .with_context(|| format!("cannot create a folder in {}; choose another", captures_in.display()))?;
    let turned = match request.knob_name() {
        "none" if request.torque => "driving whatever is on the rig",
        "none" => "turning the gripper alone",
        "locked" => "loading the locked gripper",
        _ => "turning the knob",
    };
    let done = match request.sweep.as_str() {
        "hold" if request.torque => "reading the rig without torque".to_owned(),
        sweep => format!("{turned} with {sweep}"),
    };
    let in_words = format!("{done} for {} s", request.duration_s);
    let archive = folder.join(format!("{}.mcap", request.knob_name()));
    SupervisedRun::new(in_words, request, archive, offline).complete(interrupt)
}
