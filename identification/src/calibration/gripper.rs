//! The gripper's inertia, from a sweep without a knob.

use dynamics::Calibration;

use super::estimate::{CalibrateError, Calibrated, Estimate};
use crate::{FitOptions, Samples, fit};

/// Friction above which something else than the gripper turned, mNm.
const FRICTION_MNM: f64 = 0.5;

/// Fits the inertia beyond the torque sensor to a sweep of the gripper alone.
///
/// Takes everything but the gripper's inertia from `known`. Estimates `gripper_inertia`.
///
/// # Errors
/// [`CalibrateError`] for a capture that does not accelerate the gripper enough.
pub fn gripper(samples: &Samples<'_>, known: &Calibration) -> Result<Calibrated, CalibrateError> {
    let calibration = Calibration { gripper_inertia: 0.0, ..known.clone() };
    let options = FitOptions { calibration: Some(calibration), without_detents: true, ..FitOptions::default() };
    let fitted = fit(samples, &options)?;
    let inertia = fitted.parameters.get("inertia");
    let Some((value, [low, high])) = inertia.and_then(|inertia| inertia.value.zip(inertia.ci95)) else {
        let reason = inertia.and_then(|inertia| inertia.reason.clone()).unwrap_or_default();
        return Err(CalibrateError::NoInertia { reason });
    };
    let friction_mnm = ["coulomb_negative", "coulomb_positive"]
        .iter()
        .filter_map(|name| fitted.parameters.get(name)?.value)
        .fold(0.0, f64::max);
    let mut notes = Vec::new();
    if friction_mnm > FRICTION_MNM {
        notes.push(format!(
            "something rubs with {friction_mnm:.2} mNm: is the knob off the gripper? Its inertia would be counted as the gripper's"
        ));
    }
    Ok(Calibrated {
        cogging: None,
        estimates: vec![Estimate {
            quantity: "gripper_inertia",
            value,
            half_width: (high - value).max(value - low),
            unit: "mNm s²/rad",
        }],
        notes,
    })
}
