//! What is to be read from two metres: the large figures above the plots.
//!
//! The page asks for them twice a second, beside rerun's stream: so they are there at once, whatever the
//! browser still has to draw, and a stream that has stopped is noticed.

use std::sync::{Arc, Mutex, PoisonError};

use dynamics::Axis;
use serde::Serialize;
use shared_types::LoopState;

use crate::entities::PARAMETERS;
use crate::knob_track::Motion;
use crate::process_conditions;
use crate::summary::{self, Facts, value_and_interval};

/// The large figures; keys carry their units.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Glance {
    /// rerun's name for the run that is shown; `None` before there is one.
    pub recording: Option<String>,
    /// Title of the knob.
    pub knob: String,
    /// State of the run in words.
    pub state: String,
    /// Whether the state calls for the operator.
    pub alarm: bool,
    /// Whether the run has ended and all of it is shown.
    pub finished: bool,
    /// Time in the run, s.
    pub time_s: f64,
    /// Length of the run, s; `None` where the operator ends it.
    pub planned_s: Option<f64>,
    /// Newest position, speed and load.
    pub readings: Vec<ReadingAtAGlance>,
    /// Whether the knob sticks.
    pub sticking: Option<bool>,
    /// The parameters that the model has.
    pub parameters: Vec<ParameterAtAGlance>,
    /// Ticks that the control loop has missed.
    pub missed_ticks: u64,
    /// Longest lateness of the control loop, µs.
    pub max_lateness_us: f64,
    /// The processes, the control loop first.
    pub processes: Vec<ProcessAtAGlance>,
}

/// One reading.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReadingAtAGlance {
    /// What it is, with its unit.
    pub name: String,
    /// Its value; `None` before there is one.
    pub value: Option<f64>,
    /// Decimals that are worth showing.
    pub decimals: u32,
}

/// One parameter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ParameterAtAGlance {
    /// Its standard name in words.
    pub name: String,
    /// Value and half of its 95 % interval with the unit.
    pub value: String,
    /// Whether it is known well enough.
    pub enough: bool,
}

/// One process.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ProcessAtAGlance {
    /// Its program's name.
    pub name: String,
    /// How it fares, in a few words.
    pub condition: String,
    /// Whether that calls for the operator.
    pub alarm: bool,
}

impl Glance {
    /// The figures of these facts, of a run that rerun knows as `recording`.
    pub fn of(facts: &Facts<'_>, axis: Axis, recording: Option<String>, finished: bool) -> Self {
        let reading = facts.newest.as_ref();
        let decimals = if axis.is_rotary() { [2, 1, 1] } else { [2, 1, 3] };
        let values = reading.map(|reading| [reading.angle_rad, reading.velocity_rad_s, reading.torque_mnm]);
        let names = ["angle, rad", "velocity, rad/s", "torque, mNm"].into_iter().enumerate();
        let readings = names.map(|(place, name)| ReadingAtAGlance {
            name: axis.words(name).into_owned(),
            value: values.map(|values| values[place]).filter(|value| value.is_finite()),
            decimals: decimals[place],
        });
        let fault = facts.status.is_some_and(|status| LoopState::from_code(status.state) == Some(LoopState::Fault));
        let mut glance = Self {
            recording,
            knob: facts.description.map(|run| summary::knob_title(&run.knob)).unwrap_or_default(),
            // A finished capture has no control loop that would say so.
            state: if finished { "finished" } else { "waiting for a run" }.to_owned(),
            alarm: fault || facts.source_gone,
            finished,
            time_s: facts.time_s.unwrap_or(0.0),
            planned_s: facts.description.and_then(summary::planned_s),
            readings: readings.collect(),
            sticking: facts.motion.map(|motion| motion == Motion::Sticking),
            parameters: parameters(facts, axis),
            processes: processes(facts),
            ..Self::default()
        };
        if let Some(status) = facts.status {
            glance.state = summary::state(facts.status, facts.source_gone);
            glance.missed_ticks = status.missed_ticks;
            #[allow(clippy::cast_precision_loss, reason = "shown with a few digits")]
            let max_lateness_us = status.max_lateness_ns as f64 / 1e3;
            glance.max_lateness_us = max_lateness_us;
        }
        glance
    }
}

fn parameters(facts: &Facts<'_>, axis: Axis) -> Vec<ParameterAtAGlance> {
    let Some(fit) = facts.fit else { return Vec::new() };
    let estimates = fit.estimates().into_iter().zip(PARAMETERS);
    estimates
        .filter(|((_, estimate), _)| estimate.is_in_model())
        .map(|((name, estimate), (_, unit))| ParameterAtAGlance {
            name: name.replace('_', " "),
            value: if name.ends_with("_phase") {
                format!("{} {unit}", value_and_interval(&estimate))
            } else {
                format!("{} {}", value_and_interval(&estimate), axis.words(unit))
            },
            enough: estimate.is_settled(),
        })
        .collect()
}

fn processes(facts: &Facts<'_>) -> Vec<ProcessAtAGlance> {
    let rows = process_conditions::rows(facts).into_iter();
    rows.map(|row| ProcessAtAGlance {
        name: row.name.to_owned(),
        condition: row.in_words(),
        alarm: row.alarm || row.lost > 0,
    })
    .collect()
}

/// The newest figures, from the thread that gathers them to the one that serves them.
#[derive(Clone, Debug, Default)]
pub struct SharedGlance(Arc<Mutex<Glance>>);

impl SharedGlance {
    /// Replaces the figures.
    pub fn set(&self, glance: Glance) {
        // A thread that panicked amid a plain assignment left nothing half done.
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = glance;
    }

    /// The newest figures.
    pub fn get(&self) -> Glance {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}
