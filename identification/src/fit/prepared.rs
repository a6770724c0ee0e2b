//! The prepared data of one band, and the problems fitted to them.

use dynamics::{Calibration, Effect, Part, effects};

use super::report::Report;
use super::trimmed::{trim, untrimmed};
use crate::detents::{self, Solved};
use crate::estimate::{Fit, Preparation};
use crate::karnopp::Stick;
use crate::numerics::statistics::quantile;
use crate::numerics::vector;
use crate::options::{FitOptions, PreparationMethod};
use crate::preparation::Prepared;
use crate::preparation::band::Band;
use crate::preparation::encoder_step::encoder_step;
use crate::preparation::motion::KnobMotion;
use crate::preparation::row_filter::RowFilter;
use crate::preparation::uniform::Uniform;
use crate::regression::characteristic::{CurveProjection, Measured, Places, measure};
use crate::regression::problem::Problem;
use crate::samples::{FitError, Samples};

/// Step of an encoder that is coarse for a servo, rad: 17 bits in a turn.
const COARSE_STEP_RAD: f64 = 5e-5;
/// Ratio from which two steps count as different.
const DIFFERENT_STEPS: f64 = 1.1;

impl<'a> Prepared<'a> {
    pub(super) fn new(
        uniform: &'a Uniform,
        exact: Option<KnobMotion>,
        mut band: Band,
        options: &FitOptions,
    ) -> Result<Self, FitError> {
        let calibration = options.calibration.as_ref();
        let motion =
            exact.unwrap_or_else(|| KnobMotion::measured(uniform, &mut band, calibration, options.acceleration));
        let row_filter = RowFilter::new(uniform, &motion, &band);
        row_filter.checked()?;
        let torque_mnm = motion.alike(&uniform.torque_mnm, uniform.rate_hz);
        Ok(Self { band, motion, torque_mnm, row_filter })
    }

    /// The problem without detents.
    fn base(&self, options: &FitOptions) -> Problem<'_> {
        let base = [Effect::new(&effects::inertia::KIND, &[]), Effect::new(&effects::friction::KIND, &[])];
        let further = options.further_effects.iter().copied();
        let further = further.filter(|effect| !matches!(effect.kind().part, Part::Stick(_)));
        let effects: Vec<Effect> = base.into_iter().chain(further).collect();
        Problem::new(&self.row_filter, &self.motion, &self.band, &self.torque_mnm, &effects)
    }

    pub(super) fn solve(&self, samples: &Samples<'_>, options: &FitOptions) -> Solved<'_> {
        let mut base = self.base(options);
        let solution = base.refine(20, |_, value| 0.1 * value.abs());
        let known_step = options.calibration.as_ref().map(|known| known.angle_step_rad).filter(|step| *step > 0.0);
        let step = known_step.unwrap_or_else(|| vector::smallest_step(samples.angle_rad));
        let found = if options.without_detents {
            Err("detents were not asked for".to_owned())
        } else {
            detents::search(&base, &solution, &self.band, step)
        };
        found.unwrap_or_else(|reason| Solved {
            problem: base,
            solution,
            no_detents: Some(reason),
            aliases_rad: Vec::new(),
            harmonics: Vec::new(),
            is_unsettled: false,
        })
    }

    /// The torque over the angle, measured beside the base effects of the fit; `None` if it cannot be measured.
    pub(super) fn measure(&self, options: &FitOptions) -> Option<Measured> {
        let Self { motion, torque_mnm, row_filter, .. } = self;
        let base = self.base(options);
        // Both directions share one Coulomb friction: half the difference of two would be a torque that is independent of the direction.
        let ([negative, positive], both) = base.both_ways()?;
        let mut columns = base.columns.clone();
        columns[negative] = both;
        columns.remove(positive);
        let mut nonnegative = base.nonnegative.clone();
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

    /// A wider band if the detents found need it, else `None`.
    pub(super) fn band_for(&self, solved: &Solved<'_>) -> Option<Band> {
        if solved.no_detents.is_some() {
            return None;
        }
        let wavenumber = 1.0 / solved.problem.effects.last()?.values()[1];
        let mut speeds = self.row_filter.sliding_speeds_rad_s(&self.motion);
        self.band.widened(wavenumber, quantile(&mut speeds, 0.95), self.row_filter.rate_hz)
    }

    pub(super) fn report(
        &self,
        solved: Solved<'_>,
        curves: Option<CurveProjection>,
        uniform: &Uniform,
        samples: &Samples<'_>,
        options: &FitOptions,
    ) -> Fit {
        let calibration = options.calibration.as_ref();
        let Self { band, motion, torque_mnm, row_filter } = self;
        let Solved { problem, solution, no_detents, aliases_rad, harmonics, is_unsettled } = solved;
        let mut trimmed = if options.preparation == PreparationMethod::CentralDifferences {
            untrimmed(problem)
        } else {
            trim(problem, &solution)
        };
        if let Some(curves) = curves {
            trimmed.project_curves_out(curves);
        }
        // Rows that were projected off measured curves cannot be added to those of other samples.
        let can_be_wider = options.preparation == PreparationMethod::Automatic && trimmed.curves.is_none();
        let near = can_be_wider.then(|| row_filter.next_to_turning_points(uniform, motion)).flatten();
        let near = near.map(|near| trimmed.with_rows_of(&near, band, torque_mnm));
        let mut fit = Report::new(&trimmed, torque_mnm, band, calibration, near.as_ref()).fit(no_detents);
        Stick::of(uniform, motion, &fit.effects).report(&mut fit.parameters, &mut fit.effects);
        if is_unsettled {
            fit.notes.push(
                "the search for the detents' period ended while it still moved: its interval is too narrow; sweep over more detents, or more \
                 slowly"
                    .to_owned(),
            );
        }
        if uniform.lost > 0 {
            fit.notes.push(format!("samples missing from the capture: {}; the fit leaves the gaps out", uniform.lost));
        }
        fit.notes.extend(uniform.notes.iter().cloned());
        fit.notes.extend(encoder_note(samples, calibration));
        Fit {
            samples: samples.t_s.len(),
            detent_harmonics: harmonics,
            detent_aliases_rad: aliases_rad,
            preparation: self.told(uniform, options.preparation),
            ..fit
        }
    }

    /// The choices that were made.
    fn told(&self, uniform: &Uniform, method: PreparationMethod) -> Preparation {
        let Self { band, motion, row_filter, .. } = self;
        Preparation {
            method: method.name(),
            rate_hz: uniform.rate_hz,
            lost_samples: uniform.lost,
            exact_motion: motion.exact,
            accelerometer: motion.accelerometer,
            angle_cutoff_hz: motion.cutoff_hz,
            band_hz: band.edge_hz,
            stick_threshold_rad_s: row_filter.threshold_rad_s,
            sliding_percent: 100.0 * (row_filter.sliding() as f64 / motion.len() as f64),
            angle_noise_rad: (motion.angle_density * 0.5 * uniform.rate_hz).sqrt(),
            torque_noise_mnm: band.torque_noise_mnm,
        }
    }
}

/// A note on an encoder whose steps differ from those in the rig's calibration, or are coarse and missing there: a servo that
/// does not know its encoder's steps makes noise.
fn encoder_note(samples: &Samples<'_>, calibration: Option<&Calibration>) -> Option<String> {
    let known_rad = calibration?.angle_step_rad;
    let seen_rad = encoder_step(samples.angle_rad)?;
    if known_rad > 0.0 {
        let ratio = seen_rad / known_rad;
        let differs = !(1.0 / DIFFERENT_STEPS..DIFFERENT_STEPS).contains(&ratio);
        return differs.then(|| {
            format!(
                "the encoder's step is {seen_rad:.2e} rad, but {known_rad:.2e} rad in the rig's calibration: correct `angle_step_rad`, or \
                 the scale of the angle"
            )
        });
    }
    (seen_rad > COARSE_STEP_RAD).then(|| {
        format!(
            "the encoder's step is {seen_rad:.2e} rad, of which the rig's calibration says nothing; with \
             `angle_step_rad = {seen_rad:.2e}` in it the servo makes less noise"
        )
    })
}
