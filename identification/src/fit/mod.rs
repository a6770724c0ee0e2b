//! From samples to a fitted model.
//!
//! Takes [`Samples`] and [`FitOptions`]; prepares, looks for detents, settles the torque's delay ([`trim`]), and gives values
//! with intervals or reasons ([`report`]).

mod report;
mod trim;

use dynamics::{Effect, Part, effects};

use crate::detents::{self, Found};
use crate::estimate::{Fit, Preparation};
use crate::karnopp::Stick;
use crate::options::{AccelerationUse, FitOptions, PreparationMethod};
use crate::preparation::{Band, KnobMotion, Prepared, Saturation, Sorted, Uniform, prepare};
use crate::regression::Problem;
use crate::samples::{FitError, Samples};
use crate::statistics::quantile;
use crate::{quasi_static, vector};

use report::Report;
use trim::{trim, untrimmed};

/// Fits inertia, friction and detents (equation 1 of Swindells and MacLean 2007) to a capture.
///
/// The rows may come in any order; they are taken in that of their time. No starting point is needed, and every choice of preparation is made from the data; [`Fit::preparation`] tells them.
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
/// [`FitError`] where nothing is identifiable; where some parameters are not, [`Fit::parameters`] holds the reason.
pub fn fit(samples: &Samples<'_>, options: &FitOptions) -> Result<Fit, FitError> {
    if let Some(sorted) = Sorted::of(samples) {
        let mut fit = fit_in_time(&sorted.samples(), options)?;
        fit.notes.push("the samples were not in the order of time; the fit took them in that order".to_owned());
        return Ok(fit);
    }
    fit_in_time(samples, options)
}

/// [`fit`] of samples in the order of time.
fn fit_in_time(samples: &Samples<'_>, options: &FitOptions) -> Result<Fit, FitError> {
    samples.check()?;
    match fit_moving(samples, options) {
        Err(hardly @ FitError::HardlyMoving { .. }) if options.preparation == PreparationMethod::Automatic => {
            let (saturated, total) = (Saturation::of(samples.torque_mnm).samples(), samples.t_s.len());
            if 2 * saturated > total {
                return Err(FitError::Saturated { samples: saturated, total });
            }
            quasi_static::fit(samples, !options.without_detents).ok_or(hardly)
        }
        result => result,
    }
}

/// Fits a capture in which the knob moves fast enough for its speed to be measured.
fn fit_moving(samples: &Samples<'_>, options: &FitOptions) -> Result<Fit, FitError> {
    let calibration = options.calibration.as_ref();
    let mut uniform = Uniform::of(samples, calibration);
    let given = options.preparation == PreparationMethod::Automatic && options.acceleration == AccelerationUse::Best;
    let exact = if given { KnobMotion::exact(&mut uniform, calibration) } else { None };
    let first = prepare(&uniform, exact, options)?;
    let solved = first.solve(samples, options);
    let Some(wider) = first.band_for(&solved).filter(|_| options.preparation == PreparationMethod::Automatic) else {
        return Ok(first.report(solved, &uniform, samples, options));
    };
    drop(solved);
    // An exact motion is the same in any band.
    let exact = Some(first.motion).filter(|motion| motion.exact);
    let second = Prepared::in_band(&uniform, exact, wider, options)?;
    let solved = second.solve(samples, options);
    Ok(second.report(solved, &uniform, samples, options))
}

/// The problem with detents, not yet trimmed, or without them and why.
struct Solved<'a> {
    found: Found<'a>,
    no_detents: Option<String>,
}

impl Prepared<'_> {
    fn solve(&self, samples: &Samples<'_>, options: &FitOptions) -> Solved<'_> {
        let Self { band, motion, torque_mnm, row_mask } = self;
        let mut base = Problem::new(row_mask, motion, band, torque_mnm, &base_effects(&options.further_effects));
        let solution = base.refine(20, |_, value| 0.1 * value.abs());
        let known_step = options.calibration.as_ref().map(|known| known.angle_step_rad);
        let step = known_step.unwrap_or_else(|| vector::smallest_step(samples.angle_rad));
        let found = if options.without_detents {
            Err("detents were not asked for".to_owned())
        } else {
            detents::search(&base, &solution, row_mask, motion, band, step)
        };
        match found {
            Ok(found) => Solved { found, no_detents: None },
            Err(reason) => Solved {
                found: Found { problem: base, solution, aliases_rad: Vec::new(), harmonics: Vec::new() },
                no_detents: Some(reason),
            },
        }
    }

    /// A wider band, if the detents found need it.
    fn band_for(&self, solved: &Solved<'_>) -> Option<Band> {
        if solved.no_detents.is_some() {
            return None;
        }
        let wavenumber = 1.0 / solved.found.problem.effects.last()?.values()[1];
        let at_rows = self.motion.velocity_rad_s.iter().step_by(self.row_mask.step);
        let mut speeds: Vec<f64> = at_rows.map(|velocity| velocity.abs()).collect();
        self.band.widened(wavenumber, quantile(&mut speeds, 0.95), self.row_mask.rate_hz)
    }

    fn report(&self, solved: Solved<'_>, uniform: &Uniform, samples: &Samples<'_>, options: &FitOptions) -> Fit {
        let calibration = options.calibration.as_ref();
        let Self { band, motion, row_mask, .. } = self;
        let Solved { found: Found { problem, solution, aliases_rad, harmonics }, no_detents } = solved;
        let mut trimmed = if options.preparation == PreparationMethod::CentralDifferences {
            untrimmed(problem)
        } else {
            trim(problem, &solution)
        };
        if options.acceleration == AccelerationUse::ColumnInstrumented && motion.accelerometer {
            let encoder = KnobMotion::measured(uniform, band, calibration, AccelerationUse::Encoder);
            trimmed.instrument(&encoder.acceleration_rad_s2);
        }
        let report = Report { trimmed: &trimmed, prepared: self, calibration };
        let (mut parameters, covariance, comparison) = report.parameters(no_detents);
        let mut effects = trimmed.effects();
        Stick::of(uniform, motion, &effects).report(&mut parameters, &mut effects);
        let lost = (uniform.lost > 0)
            .then(|| format!("{} samples are missing from the capture; the fit leaves the gaps out", uniform.lost));
        let notes = trimmed.note().into_iter().chain(lost).chain(uniform.faults.iter().cloned()).collect();
        Fit {
            parameters,
            covariance,
            residual_rms_mnm: comparison.residual_rms_mnm,
            relative_error_percent: comparison.relative_error_percent,
            mean_ci95_mnm: comparison.mean_ci95_mnm,
            mean_ci95_textbook_mnm: comparison.mean_ci95_textbook_mnm,
            samples: samples.t_s.len(),
            rows: comparison.points.len(),
            torque_delay_s: trimmed.delay_s,
            detent_harmonics: harmonics,
            detent_aliases_rad: aliases_rad,
            preparation: Preparation {
                method: options.preparation.name(),
                rate_hz: uniform.rate_hz,
                lost_samples: uniform.lost,
                exact_motion: motion.exact,
                accelerometer: motion.accelerometer,
                angle_cutoff_hz: motion.cutoff_hz,
                band_hz: band.edge_hz,
                stick_threshold_rad_s: row_mask.threshold_rad_s,
                sliding_percent: 100.0 * row_mask.sliding() as f64 / motion.len() as f64,
                angle_noise_rad: (motion.angle_density * 0.5 * uniform.rate_hz).sqrt(),
                torque_noise_mnm: band.torque_noise_mnm,
            },
            notes,
            points: comparison.points,
            effects,
        }
    }
}

fn base_effects(further: &[Effect]) -> Vec<Effect> {
    let base = [Effect::new(&effects::inertia::KIND, &[]), Effect::new(&effects::friction::KIND, &[])];
    base.into_iter()
        .chain(further.iter().copied().filter(|effect| !matches!(effect.kind().part, Part::Stick(_))))
        .collect()
}
