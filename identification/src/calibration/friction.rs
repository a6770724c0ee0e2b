//! The motor's own inertia and friction, from a sweep without a knob.

use dynamics::Calibration;

use super::estimate::{CalibrateError, Calibrated, Estimate};
use crate::{FitOptions, Parameter, Samples, fit};

/// Fits the motor to what of the command does not reach the torque sensor, as a fit does a knob.
///
/// `commanded_mnm` is the torque commanded at each sample, held until the next. Takes zeros and cogging from `known`. Tells
/// `motor_inertia`, `motor_coulomb_mnm` and `motor_viscous`: the means of both directions.
///
/// # Errors
/// [`CalibrateError`] for a capture that cannot be fitted or does not tell them.
pub fn friction(
    samples: &Samples<'_>,
    commanded_mnm: &[f64],
    known: &Calibration,
) -> Result<Calibrated, CalibrateError> {
    samples.check()?;
    let cogging = known.motor_cogging.as_deref().unwrap_or_default();
    let mut taken_mnm = motors_share_mnm(samples, commanded_mnm, known)?;
    for (taken_mnm, angle_rad) in taken_mnm.iter_mut().zip(samples.angle_rad) {
        *taken_mnm -= cogging.iter().map(|harmonic| harmonic.at_mnm(*angle_rad)).sum::<f64>();
    }
    let motor = Samples { torque_mnm: &taken_mnm, acceleration_rad_s2: None, velocity_rad_s: None, ..*samples };
    let fitted = fit(&motor, &FitOptions { without_detents: true, ..FitOptions::default() })?;
    let estimated = |name: &'static str| -> Result<(f64, f64), CalibrateError> {
        let parameter = fitted.parameters.get(name);
        let known = parameter.and_then(|Parameter { value, ci95, .. }| value.zip(*ci95));
        known.map(|(value, [low, high])| (value, 0.5 * (high - low))).ok_or_else(|| CalibrateError::NoFriction {
            quantity: name,
            reason: parameter.and_then(|parameter| parameter.reason.clone()).unwrap_or_default(),
        })
    };
    let mean = |[first, second]: [(f64, f64); 2]| (0.5 * (first.0 + second.0), 0.5 * first.1.hypot(second.1));
    let (inertia, inertia_half) = estimated("inertia")?;
    let coulomb = [estimated("coulomb_negative")?, estimated("coulomb_positive")?];
    let (coulomb_mnm, coulomb_half) = mean(coulomb);
    let (viscous, viscous_half) = mean([estimated("viscous_negative")?, estimated("viscous_positive")?]);
    let mut notes = Vec::new();
    let apart_mnm = (coulomb[0].0 - coulomb[1].0).abs();
    if apart_mnm > 0.1 * coulomb_mnm {
        notes.push(format!(
            "the motor rubs by {apart_mnm:.2} mNm more in one direction than in the other; the mean is kept, the rest will be felt"
        ));
    }
    let estimate = |quantity, value: f64, half_width, unit| Estimate { quantity, value, half_width, unit };
    Ok(Calibrated {
        estimates: vec![
            estimate("motor_inertia", inertia, inertia_half, "mNm s²/rad"),
            estimate("motor_coulomb_mnm", coulomb_mnm, coulomb_half, "mNm"),
            estimate("motor_viscous", viscous.max(0.0), viscous_half, "mNm s/rad"),
        ],
        cogging: None,
        notes,
    })
}

/// What of the command does not reach the torque sensor, sample by sample, mNm: the motor takes it.
pub(super) fn motors_share_mnm(
    samples: &Samples<'_>,
    commanded_mnm: &[f64],
    known: &Calibration,
) -> Result<Vec<f64>, CalibrateError> {
    if commanded_mnm.len() != samples.torque_mnm.len() || commanded_mnm.iter().any(|command| !command.is_finite()) {
        return Err(CalibrateError::NoCommand);
    }
    // At a sample the mean of the command that ends and the one that begins acts.
    let share_mnm = |index: usize| {
        let acting_mnm = 0.5 * (commanded_mnm[index.saturating_sub(1)] + commanded_mnm[index]);
        acting_mnm - (samples.torque_mnm[index] - known.torque_zero_mnm)
    };
    Ok((0..commanded_mnm.len()).map(share_mnm).collect())
}
