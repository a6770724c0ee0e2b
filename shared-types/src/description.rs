//! What a consumer must know about a run besides its samples.

use dynamics::{Axis, Calibration, Excitation, Model, ModelError};
use serde::{Deserialize, Serialize};

use crate::ModelChange;

/// A pair of clock readings taken at the same moment.
///
/// Sample times are CLOCK_MONOTONIC, which no one can step; the pair dates them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
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
///
/// What it says in TOML is read where it is asked for, so that a part which this program does not understand hides no other.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RunDescription {
    /// Identity of the run, drawn at its start.
    pub run_id: u64,
    /// Version of the program that made the run.
    pub software_version: String,
    /// The rig's name.
    pub apparatus: String,
    /// Whether the rig turns, or presses and slides.
    #[serde(default)]
    pub axis: Axis,
    /// Whether the rig watches a contact.
    #[serde(default)]
    pub contact: bool,
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
    /// By how many ticks a commanded torque acts later than in the tick that commands it, counted from the time of the angle read in
    /// that tick; `None` where nobody says.
    #[serde(default)]
    pub torque_late_ticks: Option<f64>,
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
    /// Meanings of the rig's own fault codes.
    #[serde(default)]
    pub device_codes: Vec<(i32, String)>,
    /// Further facts about the run, such as the seed of the simulated rig.
    pub notes: Vec<(String, String)>,
}

/// A part of a run's description that cannot be read.
#[derive(Debug, thiserror::Error)]
#[error("the run's {part} cannot be read ({reason}); read it with the version that made it, {version}")]
pub struct DescriptionError {
    part: &'static str,
    reason: String,
    version: String,
}

impl RunDescription {
    /// Whether the rig rendered a model, and a hand turned the gripper.
    #[must_use]
    pub fn is_rendered(&self) -> bool {
        self.rendered_model_toml.is_some()
    }

    /// Whether the rig has no torque sensor, and the torque is that of its motor: drivers note it so.
    #[must_use]
    pub fn has_motors_torque(&self) -> bool {
        self.notes.iter().any(|(name, _)| name == "torque")
    }

    /// What the rig was commanded to follow.
    ///
    /// # Errors
    /// [`DescriptionError`] for a text that is no excitation.
    pub fn excitation(&self) -> Result<Excitation, DescriptionError> {
        self.part("excitation", toml::from_str(&self.excitation_toml))
    }

    /// What was known of the rig; `None` where nothing was.
    ///
    /// # Errors
    /// [`DescriptionError`] for a text that is no calibration.
    pub fn calibration(&self) -> Result<Option<Calibration>, DescriptionError> {
        let text = Some(&self.calibration_toml).filter(|text| !text.is_empty());
        self.part("calibration", text.map(|text| Calibration::from_toml(text)).transpose())
    }

    /// The calibration for an analysis of the knob: for a rendering, the calibration as seen from the hand.
    ///
    /// # Errors
    /// As [`calibration`](Self::calibration).
    pub fn calibration_at_knob(&self) -> Result<Option<Calibration>, DescriptionError> {
        let seen = |known: Calibration| if self.is_rendered() { known.seen_from_the_hand() } else { known };
        Ok(self.calibration()?.map(seen))
    }

    /// The model with which a rendering begins, at its first tick; `None` where the rig turned a knob.
    #[must_use]
    pub fn first_model(&self) -> Option<ModelChange> {
        let monotonic_time_ns = self.clock.monotonic_time_ns;
        let model_toml = self.rendered_model_toml.clone()?;
        Some(ModelChange { run_id: self.run_id, tick: 0, monotonic_time_ns, model_toml })
    }

    /// A part that was read, or could not be.
    ///
    /// # Errors
    /// [`DescriptionError`], where `read` is an error.
    pub fn part<Part>(
        &self,
        part: &'static str,
        read: Result<Part, impl std::fmt::Display>,
    ) -> Result<Part, DescriptionError> {
        let version = &self.software_version;
        read.map_err(|error| DescriptionError { part, reason: error.to_string(), version: version.clone() })
    }
}

impl ModelChange {
    /// The model.
    ///
    /// # Errors
    /// [`ModelError`] for a text that is no model.
    pub fn model(&self) -> Result<Model, ModelError> {
        Model::from_toml(&self.model_toml, "the rendered model")
    }
}
