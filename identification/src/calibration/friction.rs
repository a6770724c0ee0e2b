//! The gripper's inertia, and the motor's own inertia and friction, from sweeps without a knob.

use dynamics::Calibration;

use super::estimate::{CalibrateError, Calibrated, Estimate, check_command};
use crate::{Fit, FitOptions, Samples, fit};

/// Friction above which something other than the gripper must have turned, mNm.
const FRICTION_MNM: f64 = 0.5;

/// Fits the inertia beyond the torque sensor to a sweep of the gripper alone.
///
/// Takes everything but the gripper's inertia from `known`. Returns `gripper_inertia`.
///
/// # Errors
/// [`CalibrateError`] for a capture that does not accelerate the gripper enough.
pub fn gripper(samples: &Samples<'_>, known: &Calibration) -> Result<Calibrated, CalibrateError> {
    let calibration = Calibration { gripper_inertia: 0.0, ..known.clone() };
    let axis = known.axis;
    let options = FitOptions { axis, calibration: Some(calibration), without_detents: true, ..FitOptions::default() };
    let fitted = fit(samples, &options)?;
    let inertia = Estimate::new("gripper_inertia", identified(&fitted, "gripper", "inertia")?, "mNm s²/rad");
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
    Ok(Calibrated { estimates: vec![inertia], notes, ..Calibrated::default() })
}

/// Fits the motor's inertia and friction, as those of a knob, to the part of the command that does not reach the torque sensor.
///
/// `commanded_mnm` is the torque commanded at each sample, held until the next. Takes zeros and cogging from `known`. Returns
/// `motor_inertia`, `motor_coulomb_mnm` and `motor_viscous`: the means of both directions.
///
/// # Errors
/// [`CalibrateError`] for a capture that cannot be fitted or from which they cannot be estimated.
pub fn friction(
    samples: &Samples<'_>,
    commanded_mnm: &[f64],
    known: &Calibration,
) -> Result<Calibrated, CalibrateError> {
    samples.check()?;
    let mut taken_mnm = motors_share_mnm(samples, commanded_mnm, known)?;
    for (taken_mnm, angle_rad) in taken_mnm.iter_mut().zip(samples.angle_rad) {
        *taken_mnm -= known.motor_cogging_mnm(*angle_rad);
    }
    let motor = Samples { torque_mnm: &taken_mnm, acceleration_rad_s2: None, velocity_rad_s: None, ..*samples };
    let fitted = fit(&motor, &FitOptions { axis: known.axis, without_detents: true, ..FitOptions::default() })?;
    let estimated = |quantity: &'static str| identified(&fitted, "motor", quantity);
    let mean = |[first, second]: [(f64, f64); 2]| (0.5 * (first.0 + second.0), 0.5 * first.1.hypot(second.1));
    let inertia = estimated("inertia")?;
    let coulomb = [estimated("coulomb_negative")?, estimated("coulomb_positive")?];
    let coulomb_mnm = mean(coulomb);
    let (viscous, viscous_half) = mean([estimated("viscous_negative")?, estimated("viscous_positive")?]);
    let mut notes = Vec::new();
    let apart_mnm = (coulomb[0].0 - coulomb[1].0).abs();
    if apart_mnm > 0.1 * coulomb_mnm.0 {
        notes.push(format!(
            "the motor rubs by {apart_mnm:.2} mNm more in one direction than in the other; the mean is kept, the rest will be felt"
        ));
    }
    Ok(Calibrated {
        estimates: vec![
            Estimate::new("motor_inertia", inertia, "mNm s²/rad"),
            Estimate::new("motor_coulomb_mnm", coulomb_mnm, "mNm"),
            Estimate::new("motor_viscous", (viscous.max(0.0), viscous_half), "mNm s/rad"),
        ],
        notes,
        ..Calibrated::default()
    })
}

/// The commanded torque that does not reach the torque sensor, but turns the motor itself, sample by sample, mNm.
pub(super) fn motors_share_mnm(
    samples: &Samples<'_>,
    commanded_mnm: &[f64],
    known: &Calibration,
) -> Result<Vec<f64>, CalibrateError> {
    check_command(samples, commanded_mnm)?;
    let share_mnm =
        |sample: usize| acting_mnm(commanded_mnm, sample) - (samples.torque_mnm[sample] - known.torque_zero_mnm);
    Ok((0..commanded_mnm.len()).map(share_mnm).collect())
}

/// The commanded torque that acts at a sample, where one command, which is held for a period, gives way to the next: their mean, mNm.
pub(crate) fn acting_mnm(commanded_mnm: &[f64], sample: usize) -> f64 {
    0.5 * (commanded_mnm[sample.saturating_sub(1)] + commanded_mnm[sample])
}

/// A fitted value with the half width of its 95 % interval.
fn identified(fitted: &Fit, part: &'static str, quantity: &'static str) -> Result<(f64, f64), CalibrateError> {
    let parameter = fitted.parameters.get(quantity);
    let estimated = parameter.and_then(|parameter| parameter.value.zip(parameter.half_width()));
    estimated.ok_or_else(|| {
        let reason = parameter.and_then(|parameter| parameter.reason.clone()).unwrap_or_default();
        CalibrateError::NotIdentified { part, quantity, reason }
    })
}
