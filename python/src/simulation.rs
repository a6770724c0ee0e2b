//! Models along a capture's motion or torque.

use analysis::Drive;
use pyo3::prelude::*;

use crate::capture::Capture;
use crate::convert::{CaptureOrPath, ModelOrName};
use crate::error::{Error, raised};
use crate::interruptible::interruptible;

/// Simulate a model along a capture's motion, or under its torque.
///
/// Parameters
/// ----------
/// model : Model, str, os.PathLike or int
///     The model, its file, or 1 to 5 for a shipped knob.
/// motion : Capture, str or os.PathLike
///     The capture that is followed, with what is known of its rig.
/// drive : {"motion", "torque"}
///     What is taken from the capture: its motion, giving the torque, or its torque, giving the motion.
///
/// Returns
/// -------
/// Capture
///     The simulated columns, of the same length and rate.
///
/// Raises
/// ------
/// Error
///     If the samples are no capture of a motion, or the torque moves the model beyond all numbers.
#[pyfunction]
#[pyo3(signature = (model, motion, *, drive="motion"))]
pub(crate) fn simulate(py: Python<'_>, model: ModelOrName, motion: CaptureOrPath, drive: &str) -> PyResult<Capture> {
    let drive = match drive {
        "motion" => Drive::Motion,
        "torque" => Drive::Torque,
        other => return Err(Error::new_err(format!("there is no drive '{other}'; give \"motion\" or \"torque\""))),
    };
    let (model, like) = (model.model()?, motion.loaded(py)?);
    let simulated = interruptible(py, move || analysis::simulate(&model, &like, drive))?.map_err(raised)?;
    Ok(Capture::of(simulated.capture))
}
