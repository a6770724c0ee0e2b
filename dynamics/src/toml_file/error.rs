//! Why a model could not be read from a file.

use std::path::PathBuf;

use crate::TorqueTableError;

/// Why a model could not be read from a file.
#[derive(Debug, thiserror::Error)]
pub enum ModelError {
    /// The file cannot be read.
    #[error("the model file {} cannot be read ({reason}); check the path", path.display())]
    Unreadable {
        /// Path as given.
        path: PathBuf,
        /// The system's word for it.
        reason: std::io::Error,
    },
    /// The file of a drawn table cannot be read.
    #[error("the table {} cannot be read ({reason}); check the path", path.display())]
    UnreadableTable {
        /// Path as given.
        path: PathBuf,
        /// The system's word for it.
        reason: std::io::Error,
    },
    /// The text is not TOML, or not of a model's form.
    #[error("{origin} is not a model file: {reason}")]
    Malformed {
        /// File or source of the text.
        origin: String,
        /// What the parser says, with the line.
        reason: String,
    },
    /// An effect that this version does not know.
    #[error("{origin} names the effect '{name}', which is unknown; known effects are {known}")]
    UnknownEffect {
        /// File or source of the text.
        origin: String,
        /// The name found.
        name: String,
        /// The names that would do.
        known: String,
    },
    /// A parameter that the effect does not have, or lacks.
    #[error("{origin}: the effect '{effect}' {problem}; its parameters are {known}")]
    WrongParameters {
        /// File or source of the text.
        origin: String,
        /// The effect.
        effect: &'static str,
        /// What is wrong.
        problem: String,
        /// The names that would do.
        known: String,
    },
    /// A value outside its range.
    #[error("{origin}: {parameter} is {value}{}, but it must be {requirement}", crate::spaced_unit(unit))]
    OutOfRange {
        /// File or source of the text.
        origin: String,
        /// The parameter.
        parameter: &'static str,
        /// The value found.
        value: f64,
        /// The parameter's unit.
        unit: &'static str,
        /// What it must be.
        requirement: &'static str,
    },
    /// The same effect twice.
    #[error("{origin} lists the effect '{effect}' twice; keep one of them")]
    Repeated {
        /// File or source of the text.
        origin: String,
        /// The effect.
        effect: &'static str,
    },
    /// A drawn table that is no periodic torque.
    #[error("{origin}: {reason}")]
    Table {
        /// File or source of the text.
        origin: String,
        /// What is wrong with the table.
        reason: TorqueTableError,
    },
    /// A number of a knob that is not among the shipped ones.
    #[error("there is no shipped knob {number}; choose 1 to 5 or give a model file")]
    UnknownKnob {
        /// The number asked for.
        number: u32,
    },
}
