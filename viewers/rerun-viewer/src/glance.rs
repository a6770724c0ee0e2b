//! What is to be read from two metres: the large figures above the plots.
//!
//! The page asks for them twice a second, beside rerun's stream: so they are there at once, whatever the
//! browser still has to draw, and a stream that has stopped is noticed.

use std::sync::Arc;

use dynamics::ParameterKind;
use parking_lot::Mutex;
use serde_json::{Value, json};
use shared_types::{Estimate, LoopState, rig};

use crate::entities;
use crate::knob_track::Motion;
use crate::numbers::value_and_interval;
use crate::processes::{self, Row};
use crate::run::Run;
use crate::summary;

/// The large figures of a run as JSON; keys carry their units.
pub fn of(run: &Run) -> Value {
    // A finished capture has no control loop.
    let of_loop = run.status.as_ref();
    let has_fault = of_loop.is_some_and(|status| LoopState::from_code(status.state) == Some(LoopState::Fault));
    let state = match run.status {
        Some(_) => summary::state(run),
        None => if run.finished() { "finished" } else { "waiting for a run" }.to_owned(),
    };
    let processes = processes::rows(run, rig::monotonic_time_ns()).into_iter();
    let process =
        |row: Row| json!({ "name": row.name, "condition": row.in_words(), "alarm": row.alarm || row.lost > 0 });
    let axis = run.axis.unwrap_or_default();
    let parameter = |(kind, estimate): (&ParameterKind, Estimate)| {
        // A phase is an angle whatever moves.
        let unit = if kind.name.ends_with("_phase") { kind.unit.into() } else { axis.words(kind.unit) };
        let value = format!("{} {unit}", value_and_interval(&estimate));
        json!({ "name": kind.name.replace('_', " "), "value": value, "enough": estimate.is_settled() })
    };
    let newest =
        run.newest.map_or([f64::NAN; 3], |newest| [newest.angle_rad, newest.velocity_rad_s, newest.torque_mnm]);
    // As many decimals as are worth showing. What is not a number has no form in JSON and becomes null.
    let decimals = if axis.is_rotary() { [2, 1, 1] } else { [2, 1, 3] };
    let readings = ["angle, rad", "velocity, rad/s", "torque, mNm"].into_iter().zip(newest).zip(decimals);
    let reading = |((name, value), decimals)| json!({ "name": axis.words(name), "value": value, "decimals": decimals });
    json!({
        "recording": run.id.map(entities::recording),
        "knob": run.description.as_ref().map(|run| summary::knob_title(&run.knob)).unwrap_or_default(),
        "state": state,
        // Whether the state calls for the operator.
        "alarm": has_fault || run.source_gone,
        "finished": run.finished(),
        "time_s": run.time_s(),
        "planned_s": run.planned_s(),
        "readings": readings.map(reading).collect::<Value>(),
        "sticking": run.motion.map(|motion| motion == Motion::Sticking),
        // Those that the model has: value and half of the 95 % interval with the unit, and whether that is enough.
        "parameters": run.parameters().map(parameter).collect::<Value>(),
        "missed_ticks": of_loop.map(|status| status.missed_ticks),
        "max_lateness_us": of_loop.map(|status| status.max_lateness_ns as f64 / 1e3),
        // The control loop, then the consumers, each with how it fares and whether that calls for the operator.
        "processes": processes.map(process).collect::<Value>(),
    })
}

/// The newest figures, from the thread that gathers them to the one that serves them.
pub type SharedGlance = Arc<Mutex<Value>>;
