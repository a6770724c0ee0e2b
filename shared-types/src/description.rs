//! What a consumer must know about a run besides its samples.

use serde::{Deserialize, Serialize};

/// A pair of clock readings taken at the same moment.
///
/// Sample times are CLOCK_MONOTONIC, which no one can step; the pair dates them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ClockMapping {
    /// CLOCK_MONOTONIC, ns.
    pub monotonic_time_ns: u64,
    /// System clock, ns since 1970.
    pub wall_clock_time_ns: u64,
}

impl ClockMapping {
    /// The system-clock time that belongs to a monotonic one, ns since 1970.
    #[must_use]
    pub fn wall_clock(&self, monotonic_time_ns: u64) -> u64 {
        self.wall_clock_time_ns.wrapping_add(monotonic_time_ns.wrapping_sub(self.monotonic_time_ns))
    }
}

/// Describes one run; published once as JSON with history, kept in the archive's metadata.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunDescription {
    /// Identity of the run, drawn at its start.
    pub run_id: u64,
    /// Version of the program that made the run.
    pub software_version: String,
    /// The rig's name.
    pub apparatus: String,
    /// The name of the knob on the rig, as the operator gave it.
    pub knob: String,
    /// Sample rate, Hz.
    pub rate_hz: f64,
    /// Ticks the run will have.
    pub planned_ticks: u64,
    /// Dates the samples' monotonic times.
    pub clock: ClockMapping,
    /// Bits of [`realtime`](crate::realtime): the real-time permissions the loop was given.
    pub realtime: u32,
    /// The excitation, as TOML.
    pub excitation_toml: String,
    /// The rig's calibration, as TOML.
    pub calibration_toml: String,
    /// The model that the simulated rig turns, as TOML; `None` on real hardware.
    pub simulated_knob_toml: Option<String>,
    /// The model that was rendered, as TOML; `None` where the rig turned a knob. Then a hand turned the gripper, and the
    /// torque sensor read what the rig put into it.
    #[serde(default)]
    pub rendered_model_toml: Option<String>,
    /// Rate, gains and limits of the control step, as TOML; with calibration, models and samples all that the torques of a
    /// rendering follow from. `None` of a run by an earlier program.
    #[serde(default)]
    pub control_toml: Option<String>,
    /// Further facts about the run, such as the seed of the simulated rig.
    pub notes: Vec<(String, String)>,
}
