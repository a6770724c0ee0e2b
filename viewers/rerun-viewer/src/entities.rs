//! Paths of what is shown; a series is named as the field it shows.

use dynamics::effects::{detent, friction, inertia};
use dynamics::{EffectKind, ParameterKind};

/// Signals of the sample stream and, last, the model's torque, each `signals/<field>`.
pub const SIGNALS: [&str; 6] =
    ["angle_rad", "velocity_rad_s", "acceleration_rad_s2", "torque_mnm", "contact", MODEL_TORQUE];

/// The torque that the fitted model gives for the measured motion.
pub const MODEL_TORQUE: &str = "model_torque_mnm";

/// Longest lateness per bin as log10 of ns.
pub const LATENESS: &str = "timing/log10_max_lateness_ns";
/// The tick's length as log10 of ns: the lateness that costs a tick.
pub const TICK_PERIOD: &str = "timing/log10_tick_period_ns";
pub const LATENESS_HISTOGRAM: &str = "lateness_histogram";
/// The text next to the plots: run and loop.
pub const SUMMARY: &str = "summary";
pub const PARAMETERS_TEXT: &str = "parameters";
pub const PROCESSES_TEXT: &str = "processes";
pub const KNOB: &str = "knob";

/// Quantities of a process's health, each `health/<quantity>/<process>`.
pub const HEALTH: [&str; 4] = ["cpu_share_percent", "resident_mib", "lost_samples", "latency_ms"];

/// The effects of Equation 1 in its order; their parameters are each `fit/<parameter>`.
pub const EQUATION_ONE: [&EffectKind; 3] = [&inertia::KIND, &friction::KIND, &detent::KIND];

/// The parameters of [`EQUATION_ONE`].
pub fn parameters() -> impl Iterator<Item = &'static ParameterKind> {
    EQUATION_ONE.into_iter().flat_map(|kind| kind.parameters)
}

/// rerun's name for a run: the same one for a viewer that was started again, so that its rows join what is shown.
pub fn recording(run_id: u64) -> String {
    format!("run-{run_id}")
}

pub fn signal(field: &str) -> String {
    format!("signals/{field}")
}

pub fn parameter(name: &str) -> String {
    format!("fit/{name}")
}

pub fn health(quantity: &str, process: &str) -> String {
    format!("health/{quantity}/{process}")
}

/// The entity under which a torque plot is drawn.
pub fn plot(abscissa: crate::scatter::Abscissa) -> String {
    format!("plots/torque_mnm_over_{}", abscissa.name())
}
