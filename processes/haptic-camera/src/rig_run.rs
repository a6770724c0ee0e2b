//! One run of the rig that a command makes by itself, live or offline.

use std::path::PathBuf;

use anyhow::Context as _;
use archive::claim;
use rt_loop::request::{Pace, RigRequest, RunRequest};

use crate::command_line::RigOptions;
use crate::outcome::Outcome;
use crate::supervision::{Interrupt, SupervisedRun};

/// A run through a sweep without a knob: `on_it` is `none` or `locked`.
pub fn request(on_it: &str, sweep: &str, duration_s: f64, pace: Pace, rig: RigRequest) -> RunRequest {
    let (knob, sweep) = (Some(on_it.to_owned()), sweep.to_owned());
    RunRequest { knob, sweep, duration_s, pace, rig, ..RunRequest::default() }
}

/// Makes the run in a folder of its own, named after its purpose; gives its archive, and whether data was lost.
pub fn archive(
    request: RunRequest,
    rig: &RigOptions,
    purpose: &str,
    interrupt: &Interrupt,
) -> anyhow::Result<(PathBuf, Outcome)> {
    let time = jiff::Zoned::now().strftime("%Y%m%d-%H%M%S");
    let folder = claim::folder(&rig.captures_in, &format!("{time}-{purpose}"))
        .with_context(|| format!("cannot create a folder in {}; choose another", rig.captures_in.display()))?;
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
    SupervisedRun::new(in_words, request, archive, rig.offline).complete(interrupt)
}
