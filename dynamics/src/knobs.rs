//! The five knobs of Swindells and MacLean 2007, with the values of their Tables 5 and 6, and what
//! a rig is tried with instead of a knob.

use std::path::Path;

use crate::{Axis, Model, ModelError};

const FILES: [&str; 5] = [
    include_str!("../knobs/knob-1.toml"),
    include_str!("../knobs/knob-2.toml"),
    include_str!("../knobs/knob-3.toml"),
    include_str!("../knobs/knob-4.toml"),
    include_str!("../knobs/knob-5.toml"),
];

/// What the shipped dome is called.
pub const DOME: &str = "dome";

/// The paper's knob with the given number, 1 to 5.
///
/// Table 5 gives C₋ as a signed torque; here it is a magnitude. Amplitudes keep the table's sign.
/// Of knob 5 the paper says that it has backlash and detents that are no sine, without numbers: those are chosen.
///
/// # Errors
/// [`ModelError::UnknownKnob`] for another number.
pub fn paper_knob(number: u32) -> Result<Model, ModelError> {
    let text = (1..=5).contains(&number).then(|| FILES[number as usize - 1]);
    let text = text.ok_or(ModelError::UnknownKnob { number })?;
    Model::from_toml(text, &format!("knob {number}"))
}

/// The model that a rig presses by default: a rubber dome under its plunger.
///
/// # Errors
/// None in a build whose shipped file is whole, which a test sees to.
pub fn dome() -> Result<Model, ModelError> {
    Model::from_toml(include_str!("../knobs/dome.toml"), "the shipped dome")
}

/// The model that an operator names: the number of a shipped knob, the shipped dome, or a model file.
///
/// # Errors
/// [`ModelError`], for a number that no shipped knob has and a file that is no model.
pub fn named(name: &str) -> Result<Model, ModelError> {
    match name.parse::<u32>() {
        Ok(number) => paper_knob(number),
        Err(_) if name == DOME => dome(),
        Err(_) => Model::load(Path::new(name)),
    }
}

/// Whether a name is that of a shipped model: the number of a knob, or the dome.
#[must_use]
pub fn is_shipped(name: &str) -> bool {
    name == DOME || name.parse::<u32>().is_ok()
}

/// What a rig is tried with instead of a knob.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fixture {
    /// Nothing: the gripper spins freely.
    None,
    /// The gripper held fast.
    Locked,
}

impl Fixture {
    /// The fixture called `none` or `locked`.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "none" => Some(Self::None),
            "locked" => Some(Self::Locked),
            _ => None,
        }
    }

    /// The fixture as a model of a rig with that axis.
    ///
    /// # Errors
    /// None in a build whose shipped files are whole, which a test sees to.
    pub fn model_on(self, axis: Axis) -> Result<Model, ModelError> {
        Ok(Model { axis, ..self.model()? })
    }

    /// The fixture as a model of a rig that turns.
    ///
    /// # Errors
    /// As [`model_on`](Self::model_on).
    pub fn model(self) -> Result<Model, ModelError> {
        match self {
            Self::None => Model::from_toml(include_str!("../knobs/none.toml"), "the fixture 'none'"),
            Self::Locked => Model::from_toml(include_str!("../knobs/locked.toml"), "the fixture 'locked'"),
        }
    }
}
