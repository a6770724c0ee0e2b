//! From samples to a fitted model.

mod late_torque;
mod misfit;
mod omitted;
mod prepared;
pub(crate) mod report;
mod shift;
mod trimmed;

use self::report::constant_torque;
use crate::estimate::Fit;
use crate::options::{AccelerationUse, FitOptions, PreparationMethod};
use crate::preparation::Prepared;
use crate::preparation::band::Band;
use crate::preparation::fixed_preparation::{central_differences, paper};
use crate::preparation::motion::KnobMotion;
use crate::preparation::saturation::Saturation;
use crate::preparation::uniform::Uniform;
use crate::quasi_static;
use crate::regression::characteristic::{CurveProjection, NO_DETENTS};
use crate::samples::{FitError, Samples};

/// Fits inertia, friction and detents (equation 1 of Swindells and MacLean 2007) to a capture.
///
/// Sorts the samples by time. Needs no starting point and makes every choice of preparation from the data: see [`Fit::preparation`].
///
/// ```
/// use dynamics::{Drive, Excitation, Motion, knobs};
/// use identification::{FitOptions, Samples, fit};
///
/// let knob = knobs::paper_knob(3)?;
/// let sweep = Excitation::named("linear-chirp", Drive::Position)?;
/// let t_s: Vec<f64> = (0..30_000).map(|n| f64::from(n) / 5000.0).collect();
/// let motions: Vec<_> = t_s.iter().map(|t| sweep.at(*t)).collect();
/// let column = |of: fn(&dynamics::Setpoint) -> f64| motions.iter().map(of).collect::<Vec<f64>>();
/// let (angle, velocity, acceleration) = (column(|m| m.value), column(|m| m.rate), column(|m| m.acceleration));
/// let torque: Vec<f64> = (0..t_s.len())
///     .map(|n| {
///         knob.torque_mnm(&Motion {
///             time_s: t_s[n],
///             angle_rad: angle[n],
///             velocity_rad_s: velocity[n],
///             acceleration_rad_s2: acceleration[n],
///         })
///     })
///     .collect();
/// let samples = Samples {
///     t_s: &t_s,
///     angle_rad: &angle,
///     velocity_rad_s: Some(&velocity),
///     acceleration_rad_s2: Some(&acceleration),
///     torque_mnm: &torque,
/// };
/// let fit = fit(&samples, &FitOptions::default())?;
/// assert!((fit.parameters.get("detent_period").unwrap().value.unwrap() - 0.034).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`FitError`] if nothing can be estimated. If only some parameters cannot, [`Fit::parameters`] holds the reasons.
pub fn fit(samples: &Samples<'_>, options: &FitOptions) -> Result<Fit, FitError> {
    let sorted = samples.sorted();
    let in_time = sorted.as_ref().map_or(*samples, |sorted| sorted.samples());
    let mut fit = fit_in_time(&in_time, options)?;
    if sorted.is_some() {
        fit.notes.push("the samples were not in the order of time; the fit took them in that order".to_owned());
    }
    // This note comes first, since opposite signs explain any other note.
    let opposite = opposite_signs(&in_time, options, &fit);
    fit.notes.splice(0..0, opposite);
    fit.axis = options.axis;
    Ok(fit)
}

/// Relative error of a fit, %, from which the signs of torque and angle are in doubt.
const IN_DOUBT_PERCENT: f64 = 20.0;
/// The inverted torque is taken for the right one if its fit has less than this share of the relative error.
const BETTER: f64 = 0.75;

/// A note on torque and angle of opposite signs, to which no inertia and no friction can be fitted.
pub(crate) fn opposite_signs(samples: &Samples<'_>, options: &FitOptions, fit: &Fit) -> Option<String> {
    if fit.relative_error_percent < IN_DOUBT_PERCENT {
        return None;
    }
    // The sensor's zero stays where it is.
    let zero_mnm = options.calibration.as_ref().map_or(0.0, |calibration| calibration.torque_zero_mnm);
    let inverted: Vec<f64> = samples.torque_mnm.iter().map(|torque_mnm| 2.0 * zero_mnm - torque_mnm).collect();
    let inverted = fit_in_time(&Samples { torque_mnm: &inverted, ..*samples }, options).ok()?;
    let [as_given, inverted] = [fit, &inverted].map(|fit| fit.relative_error_percent);
    (inverted < BETTER * as_given).then(|| {
        format!(
            "torque and angle have opposite signs: with the torque inverted {inverted:.1} % of it are left instead of {as_given:.1} %; \
             invert the sign of one of them, on a rig of its own [channels.torque] sign, and capture again"
        )
    })
}

/// [`fit`] of samples in the order of time, without its notes on the whole capture, one of which takes a second fit.
pub(crate) fn fit_in_time(samples: &Samples<'_>, options: &FitOptions) -> Result<Fit, FitError> {
    samples.check()?;
    if options.is_quasi_static {
        return quasi_static::fit(samples, options).ok_or(FitError::NoMap);
    }
    match fit_moving(samples, options) {
        Err(hardly @ FitError::HardlyMoving { .. }) if options.preparation == PreparationMethod::Automatic => {
            let (saturated, total) = (Saturation::of(samples.torque_mnm).samples(), samples.t_s.len());
            if 2 * saturated > total {
                return Err(FitError::Saturated { samples: saturated, total });
            }
            quasi_static::fit(samples, options).ok_or(hardly)
        }
        result => result,
    }
}

/// Fits a capture in which the knob moves fast enough for its speed to be estimated.
fn fit_moving(samples: &Samples<'_>, options: &FitOptions) -> Result<Fit, FitError> {
    let calibration = options.calibration.as_ref();
    let mut uniform = Uniform::of(samples, options.axis, calibration);
    let fixed = match options.preparation {
        PreparationMethod::Automatic => None,
        PreparationMethod::Paper => Some(paper(&uniform)),
        PreparationMethod::CentralDifferences => Some(central_differences(&uniform)),
    };
    if let Some(prepared) = fixed {
        prepared.row_filter.checked()?;
        let solved = prepared.solve(samples, options);
        return Ok(prepared.report(solved, None, &uniform, samples, options));
    }
    let as_given = options.acceleration == AccelerationUse::Best;
    let exact = if as_given { KnobMotion::exact(&mut uniform, calibration) } else { None };
    let band = Band::of(&uniform, exact.is_some(), calibration);
    let first = Prepared::new(&uniform, exact, band, options)?;
    if let Some(measured) = options.characteristic.then(|| first.measure(options)).flatten() {
        let mut further_effects = options.further_effects.clone();
        further_effects.extend(&measured.effects);
        let options = FitOptions { further_effects, without_detents: true, ..options.clone() };
        let mut solved = first.solve(samples, &options);
        solved.no_detents = Some(NO_DETENTS.to_owned());
        let curves = solved.problem.both_ways().map(|(_, both)| CurveProjection::new(&measured, &both));
        let fit = first.report(solved, curves, &uniform, samples, &options);
        let notes = fit.notes.iter().cloned().chain(constant_torque(&measured.curves, &fit.parameters)).collect();
        return Ok(Fit { characteristics: measured.curves, notes, ..fit });
    }
    let solved = first.solve(samples, options);
    let Some(wider) = first.band_for(&solved) else {
        return Ok(first.report(solved, None, &uniform, samples, options));
    };
    drop(solved);
    // An exact motion is the same in any band.
    let exact = Some(first.motion).filter(|motion| motion.exact);
    let second = Prepared::new(&uniform, exact, wider, options)?;
    let solved = second.solve(samples, options);
    Ok(second.report(solved, None, &uniform, samples, options))
}
