//! Why a capture gives no result.

use std::path::PathBuf;

use dynamics::simulate::SimulationError;
use dynamics::{Axis, Model};
use identification::FitError;
use identification::diagnosis::DiagnosisError;
use loaded_capture::{LoadError, LoadedCapture};
use sheet::{SheetError, SpecificationError};

/// Why a capture gives no result.
#[derive(Debug, thiserror::Error)]
pub enum AnalysisError {
    /// A capture that cannot be fitted.
    #[error("{} cannot be fitted: {reason}", capture.display())]
    Fit {
        /// The capture.
        capture: PathBuf,
        /// What is wrong with it.
        reason: FitError,
    },
    /// A rendered knob that cannot be fitted.
    #[error("the rendered knob cannot be fitted: {0}")]
    Rendered(FitError),
    /// A diagnosis that could not reach a meaningful verdict.
    #[error(transparent)]
    Diagnosis(#[from] DiagnosisError),
    /// A model to start from that cannot be fitted.
    #[error(
        "{model} has a {effect}, which is drawn and cannot be fitted; take it out, its shape will show in what is left"
    )]
    Drawn {
        /// What the model is called.
        model: String,
        /// The effect.
        effect: &'static str,
    },
    /// A capture whose motion cannot be determined.
    #[error(transparent)]
    Motion(#[from] FitError),
    /// A model that cannot be moved by the torque.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// A model of what moves along another axis than what was captured.
    #[error(
        "the model '{model}' is of a control with a {is} axis, and {} is of one with a {has} axis; choose another of either",
        capture.display()
    )]
    OtherAxis {
        /// The model's name.
        model: String,
        /// Its axis.
        is: Axis,
        /// The capture.
        capture: PathBuf,
        /// Its axis.
        has: Axis,
    },
    /// Captures of a turned and of a pressed control together.
    #[error("some captures are rotary and some linear; give one kind")]
    TwoAxes,
    /// A capture that cannot be read.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// A file or a folder that cannot be read.
    #[error("{} cannot be read: {error}", path.display())]
    Unreadable {
        /// The file or folder.
        path: PathBuf,
        /// The system's error.
        error: std::io::Error,
    },
    /// A folder without captures.
    #[error("{} holds no captures, which end in .{endings}; give another folder, or their files", folder.display())]
    NoCaptures {
        /// The folder.
        folder: PathBuf,
        /// The endings that captures have.
        endings: String,
    },
    /// Curves that make no sheet.
    #[error(transparent)]
    Sheet(#[from] SheetError),
    /// An invalid specification.
    #[error("{} is no specification: {error}", path.display())]
    Specification {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        error: SpecificationError,
    },
}

/// The axis that several captures must have in common; without captures, the rotary one.
///
/// # Errors
/// [`AnalysisError::TwoAxes`].
pub fn common_axis(axes: impl IntoIterator<Item = Axis>) -> Result<Axis, AnalysisError> {
    let mut axes = axes.into_iter();
    let first = axes.next().unwrap_or_default();
    if axes.all(|axis| axis == first) { Ok(first) } else { Err(AnalysisError::TwoAxes) }
}

/// Refuses a model of what moves along another axis than what was captured.
pub(crate) fn same_axis(model: &Model, loaded: &LoadedCapture) -> Result<(), AnalysisError> {
    let capture = &loaded.capture;
    if model.axis == capture.axis {
        return Ok(());
    }
    Err(AnalysisError::OtherAxis {
        model: model.name.clone(),
        is: model.axis,
        capture: capture.source.clone(),
        has: capture.axis,
    })
}
