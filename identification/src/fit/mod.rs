//! From samples to a fitted model.

mod misfit;
mod report;

use std::borrow::Cow;

use dynamics::{Calibration, Effect, Part, effects};

use self::report::Report;
use crate::detents::{self, Detents, Found};
use crate::estimate::{Fit, Harmonic, Preparation};
use crate::karnopp::Stick;
use crate::numerics::vector::{self, dot};
use crate::options::{AccelerationUse, FitOptions, PreparationMethod};
use crate::preparation::central_differences::central_differences;
use crate::preparation::encoder_step::encoder_step;
use crate::preparation::fixed_preparation::FixedPreparation;
use crate::preparation::motion::{Band, KnobMotion};
use crate::preparation::paper_preparation::paper_preparation;
use crate::preparation::row_filter::RowFilter;
use crate::preparation::saturation::Saturation;
use crate::preparation::time_order::sorted;
use crate::preparation::uniform::Uniform;
use crate::quasi_static;
use crate::regression::characteristic::{CurveProjection, Measured, NO_DETENTS, Places, measure};
use crate::regression::least_squares::{ColumnNoise, LeastSquares};
use crate::regression::problem::{Column, Problem};
use crate::samples::{FEWEST_SAMPLES, FitError, Samples};
use crate::uncertainty::statistics::quantile;

/// A delay between torque and motion is believed only up to this many samples; more is an effect of its own.
const LARGEST_DELAY_SAMPLES: f64 = 0.5;
/// Standard errors by which a delay must differ from zero to be allowed for.
const DELAY_SIGNIFICANCE: f64 = 4.5;

/// Step of an encoder that is coarse for a servo, rad: 17 bits in a turn.
const COARSE_STEP_RAD: f64 = 5e-5;

/// A delay too long for a trim is told if it explains this share of the residual's sum of squares.
const WORTH_A_NOTE: f64 = 0.25;

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
/// [`FitError`] where nothing can be estimated; what only some parameters lack is a reason in [`Fit::parameters`].
pub fn fit(samples: &Samples<'_>, options: &FitOptions) -> Result<Fit, FitError> {
    let mut fit = match sorted(samples) {
        Some(sorted) => {
            let mut fit = fit_in_time(&sorted.samples(), options)?;
            fit.notes.push("the samples were not in the order of time; the fit took them in that order".to_owned());
            fit
        }
        None => fit_in_time(samples, options)?,
    };
    fit.axis = options.axis;
    Ok(fit)
}

/// [`fit`] of samples in the order of time.
fn fit_in_time(samples: &Samples<'_>, options: &FitOptions) -> Result<Fit, FitError> {
    samples.check()?;
    if options.is_quasi_static {
        let nothing = FitError::HardlyMoving { threshold_rad_s: 0.0, samples: 0 };
        return quasi_static::fit(samples, options).ok_or(nothing);
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
    let mut uniform = Uniform::of(samples, calibration);
    let fixed = match options.preparation {
        PreparationMethod::Automatic => None,
        PreparationMethod::Paper => Some(paper_preparation(&uniform)),
        PreparationMethod::CentralDifferences => Some(central_differences(&uniform)),
    };
    if let Some(fixed) = fixed {
        let prepared = Prepared::fixed(fixed)?;
        let solved = prepared.solve(samples, options);
        return Ok(prepared.report(solved, &uniform, samples, options));
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
        solved.curves = solved.problem.both_ways().map(|(_, both)| CurveProjection::new(&measured, &both));
        let fit = first.report(solved, &uniform, samples, &options);
        return Ok(Fit { characteristics: measured.curves, ..fit });
    }
    let solved = first.solve(samples, options);
    let Some(wider) = first.band_for(&solved) else {
        return Ok(first.report(solved, &uniform, samples, options));
    };
    drop(solved);
    // An exact motion is the same in any band.
    let exact = Some(first.motion).filter(|motion| motion.exact);
    let second = Prepared::new(&uniform, exact, wider, options)?;
    let solved = second.solve(samples, options);
    Ok(second.report(solved, &uniform, samples, options))
}

/// Motion, mask and filter for one band.
struct Prepared<'a> {
    band: Band,
    motion: KnobMotion,
    torque_mnm: Cow<'a, [f64]>,
    row_filter: RowFilter,
}

/// The problem with detents, if there are any, not yet trimmed.
struct Solved<'a> {
    problem: Problem<'a>,
    solution: LeastSquares,
    aliases_rad: Vec<f64>,
    harmonics: Vec<Harmonic>,
    no_detents: Option<String>,
    /// Measured curves among the effects.
    curves: Option<CurveProjection>,
}

impl<'a> Prepared<'a> {
    fn new(
        uniform: &'a Uniform,
        exact: Option<KnobMotion>,
        band: Band,
        options: &FitOptions,
    ) -> Result<Self, FitError> {
        let calibration = options.calibration.as_ref();
        let motion = exact.unwrap_or_else(|| KnobMotion::measured(uniform, &band, calibration, options.acceleration));
        let row_filter = RowFilter::new(uniform, &motion, &band);
        let torque_mnm = motion.alike(&uniform.torque_mnm, uniform.rate_hz);
        Self { band, motion, torque_mnm, row_filter }.checked()
    }

    fn fixed(fixed: FixedPreparation) -> Result<Self, FitError> {
        let FixedPreparation { motion, torque_mnm, row_filter, band } = fixed;
        Self { band, motion, torque_mnm: torque_mnm.into(), row_filter }.checked()
    }

    fn checked(self) -> Result<Self, FitError> {
        let samples = self.row_filter.sliding();
        if samples < FEWEST_SAMPLES / 2 {
            return Err(FitError::HardlyMoving { threshold_rad_s: self.row_filter.threshold_rad_s, samples });
        }
        Ok(self)
    }

    fn solve(&self, samples: &Samples<'_>, options: &FitOptions) -> Solved<'_> {
        let Self { band, motion, torque_mnm, row_filter } = self;
        let mut base = Problem::new(row_filter, motion, band, torque_mnm, &base_effects(&options.further_effects));
        let solution = base.refine(20, |_, value| 0.1 * value.abs());
        let known_step = options.calibration.as_ref().map(|known| known.angle_step_rad).filter(|step| *step > 0.0);
        let step = known_step.unwrap_or_else(|| vector::smallest_step(samples.angle_rad));
        let found = if options.without_detents {
            Detents::None("detents were not asked for".to_owned())
        } else {
            detents::search(&base, &solution, row_filter, motion, band, step)
        };
        match found {
            Detents::Found(found) => {
                let Found { problem, solution, aliases_rad, harmonics } = *found;
                Solved { problem, solution, aliases_rad, harmonics, no_detents: None, curves: None }
            }
            Detents::None(reason) => Solved {
                problem: base,
                solution,
                aliases_rad: Vec::new(),
                harmonics: Vec::new(),
                no_detents: Some(reason),
                curves: None,
            },
        }
    }

    /// The torque over the angle, measured beside all that the fit has anyway.
    fn measure(&self, options: &FitOptions) -> Option<Measured> {
        let Self { band, motion, torque_mnm, row_filter } = self;
        let base = Problem::new(row_filter, motion, band, torque_mnm, &base_effects(&options.further_effects));
        // One Coulomb friction for both directions: half of what differs between them is a torque that does not change with them.
        let ([negative, positive], both) = base.both_ways()?;
        let mut columns = base.columns.clone();
        columns[negative] = both;
        columns.remove(positive);
        let mut nonnegative = base.nonnegative().to_vec();
        nonnegative.remove(positive);
        let mut noise = base.column_noise();
        noise.iter_mut().for_each(|noise| noise.column -= usize::from(noise.column > positive));
        let sliding = |index: &usize| row_filter.mask[*index] > 0.0;
        let places =
            Places::of(&(0..motion.len()).filter(sliding).map(|index| (motion.angle_rad[index], torque_mnm[index])))?;
        let [back, forth] = [negative, positive].map(|column| base.columns[column].iter().any(|value| *value != 0.0));
        measure(&columns, &nonnegative, &noise, &base.target, &places, back && forth, |spline| {
            spline.columns(motion.len(), |index| motion.at(index)).map(|column| row_filter.rows(&column)).collect()
        })
    }

    /// A wider band, if the detents found need it.
    fn band_for(&self, solved: &Solved<'_>) -> Option<Band> {
        if solved.no_detents.is_some() {
            return None;
        }
        let wavenumber = 1.0 / solved.problem.effects.last()?.values()[1];
        let at_rows = self.motion.velocity_rad_s.iter().step_by(self.row_filter.step);
        let mut speeds: Vec<f64> = at_rows.map(|velocity| velocity.abs()).collect();
        self.band.widened(wavenumber, quantile(&mut speeds, 0.95), self.row_filter.rate_hz)
    }

    fn report(&self, solved: Solved<'_>, uniform: &Uniform, samples: &Samples<'_>, options: &FitOptions) -> Fit {
        let calibration = options.calibration.as_ref();
        let Self { band, motion, torque_mnm, row_filter } = self;
        let Solved { problem, solution, aliases_rad, harmonics, no_detents, curves } = solved;
        let mut trimmed = if options.preparation == PreparationMethod::CentralDifferences {
            untrimmed(problem)
        } else {
            trim(problem, &solution)
        };
        if let Some(curves) = curves {
            trimmed.project_curves_out(curves);
        }
        let instrumented = options.acceleration == AccelerationUse::ColumnInstrumented && motion.accelerometer;
        if instrumented {
            let encoder = KnobMotion::measured(uniform, band, calibration, AccelerationUse::Encoder);
            trimmed.instrument(&encoder.acceleration_rad_s2);
        }
        let near = match options.preparation {
            PreparationMethod::Automatic => row_filter.next_to_standstill(uniform, motion),
            PreparationMethod::Paper | PreparationMethod::CentralDifferences => None,
        };
        // Rows beside measured curves are freed of what the curves do at their own samples.
        let near = near.filter(|_| trimmed.curves.is_none());
        let near = near.map(|near| trimmed.with_rows_of(&near, band, torque_mnm));
        let report = Report { trimmed: &trimmed, motion, row_filter, band, calibration, near };
        let (mut parameters, covariance, comparison) = report.parameters(no_detents);
        let mut effects = trimmed.effects();
        Stick::of(uniform, motion, &effects).report(&mut parameters, &mut effects);
        let mut notes = report.notes(&parameters);
        if uniform.lost > 0 {
            notes.push(format!("samples missing from the capture: {}; the fit leaves the gaps out", uniform.lost));
        }
        notes.extend(uniform.notes.iter().cloned());
        notes.extend(unknown_step(samples, calibration));
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
                ..preparation(uniform, motion, row_filter, band)
            },
            notes,
            points: comparison.points,
            characteristics: Vec::new(),
            axis: options.axis,
            effects,
        }
    }
}

/// A problem with everything settled: effects, searched parameters and the delay.
pub(crate) struct Trimmed<'a> {
    pub(crate) problem: Problem<'a>,
    /// All columns: the effects' linear ones, then those of searched parameters, then that of the delay if it is fitted.
    pub(crate) columns: Vec<Column>,
    /// What they were fitted to: the problem's target, without what measured curves do.
    pub(crate) target: Column,
    pub(crate) solution: LeastSquares,
    /// What the residual was made orthogonal to, if not the columns themselves.
    pub(crate) instruments: Option<Vec<Column>>,
    /// Measured curves of which the columns have been freed.
    pub(crate) curves: Option<CurveProjection>,
    /// Delay of the torque behind the motion that was allowed for, s.
    pub(crate) delay_s: f64,
    /// Delay that the data ask for although it is too long for a trim, s.
    pub(crate) refused_delay_s: Option<f64>,
}

/// Rows of torque and of every column.
pub(crate) struct Rows {
    pub(crate) columns: Vec<Column>,
    pub(crate) target: Column,
}

impl Trimmed<'_> {
    /// The rows, together with those of samples that only another row filter has.
    fn with_rows_of(&self, other: &RowFilter, band: &Band, torque_mnm: &[f64]) -> Rows {
        let coefficients = &self.solution.coefficients;
        let problem = Problem::new(other, self.problem.motion, band, torque_mnm, &self.problem.effects);
        let mut columns = problem.columns.clone();
        columns.extend(problem.searched().iter().map(|which| problem.tangent(*which, coefficients)));
        let mut target = problem.target.to_vec();
        if columns.len() < self.columns.len() {
            let delay = problem.delay_column(coefficients);
            target.iter_mut().zip(&*delay).for_each(|(torque, value)| *torque -= self.delay_s * value);
            columns.push(delay);
        }
        let sum = |one: &[f64], other: &[f64]| one.iter().zip(other).map(|(one, other)| one + other).collect();
        Rows {
            columns: self.columns.iter().zip(&columns).map(|(one, other)| sum(one, other)).collect(),
            target: sum(&self.problem.target, &target),
        }
    }

    /// Solves again with another sensor's acceleration as the instrument for the inertia.
    fn instrument(&mut self, acceleration_rad_s2: &[f64]) {
        let acceleration = self.problem.row_filter.rows(acceleration_rad_s2);
        let acceleration = self.curves.as_ref().map_or(acceleration.clone(), |curves| curves.remainder(&acceleration));
        let instruments = self.problem.instruments(&self.columns, &acceleration.into());
        self.solution = self.solution.clone().instrumented(&self.columns, &instruments, &self.target);
        self.instruments = Some(instruments);
    }

    /// Solves again with what the points of measured curves can do left out of the other columns: the curves stay as they are, and how little
    /// is known of them joins what is known of the rest.
    #[allow(clippy::cast_precision_loss, reason = "numbers of rows and points")]
    fn project_curves_out(&mut self, curves: CurveProjection) {
        let Self { problem, columns, target, .. } = self;
        let less = |column: &[f64], part: &[f64]| -> Vec<f64> {
            column.iter().zip(part).map(|(value, part)| value - part).collect()
        };
        let done = |column: &[f64]| less(column, &curves.remainder(column));
        let is_curve = |effect: &Effect| matches!(effect.kind().part, Part::TorqueTable(_) | Part::FrictionTable(_));
        let effects = (0..problem.effects.len()).filter(|effect| is_curve(&problem.effects[*effect]));
        let of_curves: Vec<usize> = effects.flat_map(|effect| problem.range(effect)).collect();
        // The mean of both directions is the curves', so that only half of the two Coulomb frictions' sum is told beside them.
        let coulomb = problem.both_ways().map(|(places, both)| {
            let half: Vec<f64> = done(&both).into_iter().map(|value| 0.5 * value).collect();
            (places, half)
        });
        let mut beyond = problem.target.to_vec();
        for (index, place) in columns.iter_mut().enumerate() {
            let column = place.clone();
            let part = match &coulomb {
                _ if of_curves.contains(&index) => {
                    beyond = less(&beyond, &column);
                    curves.remainder(&column)
                }
                Some((places, half)) if places.contains(&index) => half.clone(),
                _ => done(&column),
            };
            *place = less(&column, &part).into();
        }
        beyond = curves.remainder(&beyond);
        for index in of_curves {
            beyond.iter_mut().zip(&*columns[index]).for_each(|(sum, value)| *sum += value);
        }
        *target = beyond.into();
        let mut nonnegative = problem.nonnegative().to_vec();
        nonnegative.resize(columns.len(), false);
        let share = 1.0 - curves.count() as f64 / target.len() as f64;
        let noise = problem.column_noise().into_iter();
        let noise: Vec<ColumnNoise> = noise
            .map(|noise| ColumnNoise { square: share * noise.square, product: share * noise.product, ..noise })
            .collect();
        self.solution = LeastSquares::solve_within(columns, target, &nonnegative, &noise);
        self.curves = Some(curves);
    }

    /// The effects with all their values filled in.
    pub(crate) fn effects(&self) -> Vec<Effect> {
        let mut effects = self.problem.effects.clone();
        for (index, effect) in effects.iter_mut().enumerate() {
            if let Some(regressors) = effect.kind().regressors {
                (regressors.values)(&self.solution.coefficients[self.problem.range(index)], effect.values_mut());
            }
        }
        effects
    }
}

/// Fits a small delay of the torque channel, if the data show one, together with everything else.
fn trim<'a>(problem: Problem<'a>, solution: &LeastSquares) -> Trimmed<'a> {
    let tangents: Vec<Column> =
        problem.searched().iter().map(|which| problem.tangent(*which, &solution.coefficients)).collect();
    let mut with_delay = tangents.clone();
    with_delay.push(problem.delay_column(&solution.coefficients));
    let (columns, extended) = problem.solve_with(&with_delay);
    let delay_index = columns.len() - 1;
    let delay_s = extended.coefficients[delay_index];
    let significant = delay_s.abs() > DELAY_SIGNIFICANCE * extended.robust_deviation(&columns, delay_index)
        && extended.improves(solution);
    let left = |solution: &LeastSquares| dot(&solution.residual, &solution.residual);
    let worthwhile = left(&extended) < (1.0 - WORTH_A_NOTE) * left(solution);
    let small = delay_s.abs() <= LARGEST_DELAY_SAMPLES / problem.row_filter.rate_hz;
    if significant && small {
        // The delay shifts the searched parameters too: the column takes it out, then they settle again.
        let mut problem = problem;
        let delay_rows = columns[delay_index].clone();
        problem.target =
            problem.target.iter().zip(&*delay_rows).map(|(torque, value)| torque - delay_s * value).collect();
        let settled = problem.refine(4, |_, value| 0.01 * value.abs());
        let mut more: Vec<Column> =
            problem.searched().iter().map(|which| problem.tangent(*which, &settled.coefficients)).collect();
        more.push(delay_rows);
        let (columns, solution) = problem.solve_with(&more);
        let target = problem.target.clone();
        return Trimmed {
            problem,
            columns,
            target,
            solution,
            instruments: None,
            curves: None,
            delay_s,
            refused_delay_s: None,
        };
    }
    let (columns, solution) = problem.solve_with(&tangents);
    Trimmed {
        target: problem.target.clone(),
        problem,
        columns,
        solution,
        instruments: None,
        curves: None,
        delay_s: 0.0,
        refused_delay_s: (significant && worthwhile).then_some(delay_s),
    }
}

/// The problem as it is, without a delay.
fn untrimmed(problem: Problem<'_>) -> Trimmed<'_> {
    let solution = problem.solve();
    let tangents: Vec<Column> =
        problem.searched().iter().map(|which| problem.tangent(*which, &solution.coefficients)).collect();
    let (columns, solution) = problem.solve_with(&tangents);
    Trimmed {
        target: problem.target.clone(),
        problem,
        columns,
        solution,
        instruments: None,
        curves: None,
        delay_s: 0.0,
        refused_delay_s: None,
    }
}

fn base_effects(further: &[Effect]) -> Vec<Effect> {
    let base = [Effect::new(&effects::inertia::KIND, &[]), Effect::new(&effects::friction::KIND, &[])];
    base.into_iter()
        .chain(further.iter().copied().filter(|effect| !matches!(effect.kind().part, Part::Stick(_))))
        .collect()
}

/// A note on an encoder whose steps are coarse and unknown to the rig's calibration: a servo that does not know of them makes noise.
fn unknown_step(samples: &Samples<'_>, calibration: Option<&Calibration>) -> Option<String> {
    let step_rad = calibration
        .filter(|known| known.angle_step_rad == 0.0)
        .and_then(|_| encoder_step(samples.angle_rad))
        .filter(|step_rad| *step_rad > COARSE_STEP_RAD)?;
    Some(format!(
        "the encoder's step is {step_rad:.2e} rad, of which the rig's calibration says nothing; with `angle_step_rad = {step_rad:.2e}` \
         in it the servo makes less noise"
    ))
}

fn preparation(uniform: &Uniform, motion: &KnobMotion, row_filter: &RowFilter, band: &Band) -> Preparation {
    #[allow(clippy::cast_precision_loss, reason = "a number of samples")]
    let share = row_filter.sliding() as f64 / motion.len() as f64;
    Preparation {
        method: PreparationMethod::default().name(),
        rate_hz: uniform.rate_hz,
        lost_samples: uniform.lost,
        exact_motion: motion.exact,
        accelerometer: motion.accelerometer,
        angle_cutoff_hz: motion.cutoff_hz,
        band_hz: band.edge_hz,
        stick_threshold_rad_s: row_filter.threshold_rad_s,
        sliding_percent: 100.0 * share,
        angle_noise_rad: (motion.angle_density * 0.5 * uniform.rate_hz).sqrt(),
        torque_noise_mnm: band.torque_noise_mnm,
    }
}
