//! Values, intervals and reasons from the settled problem.

use std::ops::Deref;

use dynamics::{Calibration, Effect, ParameterKind, Part, effects};
use nalgebra::{DMatrix, RowDVector};

use super::misfit::Misfit;
use super::trimmed::{Rows, Trimmed};
use crate::estimate::{Covariance, Fit, Parameter, Parameters, Point};
use crate::numerics::statistics::{NORMAL_95, deviation_of_sum, mean, plus_minus, rms, student_95};
use crate::numerics::vector::{self, dot};
use crate::preparation::band::Band;
use crate::regression::characteristic::MeasuredCurve;
use crate::regression::least_squares::RobustCovariance;
use crate::regression::problem::Problem;

/// A parameter is not estimated if the half width of its interval times the RMS of its column exceeds this share of the torque's RMS.
const HOPELESS: f64 = 0.5;
/// Share of the acceleration's power that may be noise before the inertia is not estimated.
const NOISY_ACCELERATION: f64 = 0.2;
/// Scatter of the speed, relative to it, up to which friction is known for one speed alone.
const ONE_SPEED: f64 = 1e-3;
/// Share of the speed's scatter that may be the encoder's noise: it would draw viscous friction towards zero.
const NOISY_SPEED: f64 = 0.05;
/// Difference of the Coulomb frictions of both directions, as a share of their sum, from which a constant torque is thought of.
const ONE_SIDED: f64 = 0.25;
/// A collinear column's share of another column from which both are not identifiable.
const ENTANGLED: f64 = 0.01;

/// The settled problem with the covariances and the misfit from which values, intervals and reasons follow.
pub(crate) struct Report<'a> {
    trimmed: &'a Trimmed<'a>,
    band: &'a Band,
    calibration: Option<&'a Calibration>,
    robust: RobustCovariance,
    textbook: DMatrix<f64>,
    misfit: Misfit,
}

/// Difference of a derivative from 1 or 0 that is rounding.
const SAME: f64 = 1e-4;

/// A parameter, with its derivatives by the coefficients if it is told and not held at zero.
type Told = (Parameter, Option<RowDVector<f64>>);

/// The reason why a coefficient that cannot be negative is not identifiable where more than chance holds it at zero: how far below zero the fit
/// would go without that bound does not limit where it would be without what the model lacks.
const DRIVEN: &str = "it would be negative: something that the model lacks drives the knob; diagnose the capture";

impl<'a> Report<'a> {
    /// `near` are the rows plus those next to standstill that the fit leaves out; `None` if it leaves out none.
    pub(crate) fn new(
        trimmed: &'a Trimmed<'a>,
        torque_mnm: &[f64],
        band: &'a Band,
        calibration: Option<&'a Calibration>,
        near: Option<&Rows>,
    ) -> Self {
        let mut robust = trimmed.solution.robust(&trimmed.columns);
        if let Some(curves) = &trimmed.curves {
            robust.enlarge(curves.points.len());
        }
        let misfit = Misfit::of(trimmed, torque_mnm, &robust.matrix, near);
        Self { trimmed, band, calibration, robust, textbook: trimmed.solution.textbook_covariance(), misfit }
    }

    /// The fit that follows from the settled problem; `no_detents` is the reason if there are no detents.
    pub(crate) fn fit(&self, no_detents: Option<String>) -> Fit {
        let Trimmed { columns, .. } = self.trimmed;
        let effects = self.trimmed.effects();
        let of_effect = |(index, effect)| self.parameters(index, effect);
        let mut told: Vec<Told> = effects.iter().enumerate().flat_map(of_effect).collect();
        if let Some(reason) = no_detents {
            let absent = |kind| (Parameter::not_identifiable(kind, reason.clone()), None);
            told.extend(effects::detent::KIND.parameters.iter().map(absent));
        }
        let covariance = self.covariance(&told);
        let parameters = Parameters(told.into_iter().map(|(parameter, _)| parameter).collect());
        let rows = self.sliding_rows();
        let points = self.points(&rows, &prediction_sd(columns, &self.robust.matrix), covariance.critical);
        let textbook_sd = prediction_sd(columns, &self.textbook);
        let notes = [negative_friction(&parameters), one_sided_friction_of(&parameters), self.misfit.note.clone()];
        Fit {
            mean_ci95_textbook_mnm: NORMAL_95 * mean(rows.iter().map(|row| textbook_sd[*row])),
            torque_delay_s: self.trimmed.delay_s,
            notes: notes.into_iter().flatten().collect(),
            parameters,
            covariance,
            effects,
            ..Fit::default()
        }
        .compared(points)
    }

    /// Covariance of the parameters that are told and not held at zero, from that of the coefficients.
    fn covariance(&self, told: &[Told]) -> Covariance {
        let derivatives = || told.iter().filter_map(|(_, derivatives)| derivatives.as_ref());
        let row = |left: &RowDVector<f64>| {
            let product = left * &self.robust.matrix;
            derivatives().map(|right| product.dot(right)).collect()
        };
        let degrees_of_freedom = self.robust.degrees_of_freedom;
        Covariance {
            order: told.iter().filter(|told| told.1.is_some()).map(|(parameter, _)| parameter.name).collect(),
            rows: derivatives().map(row).collect(),
            critical: student_95(degrees_of_freedom),
            degrees_of_freedom,
        }
    }

    fn parameters(&self, index: usize, effect: &Effect) -> Vec<Told> {
        let Self { robust, misfit, .. } = self;
        let Some(regressors) = effect.kind().regressors else { return Vec::new() };
        let jacobian = self.jacobian(index, effect);
        let [variances, textbook] =
            [&robust.matrix, &self.textbook].map(|covariance| &jacobian * covariance * jacobian.transpose());
        let gripper = match (effect.kind().part, self.calibration) {
            (Part::Inertia(_), Some(calibration)) => calibration.gripper_inertia,
            _ => 0.0,
        };
        let range = self.trimmed.problem.range(index);
        // Of other parameters, such as a phase, several coefficients decide.
        let is_coefficient = |position: usize| {
            let unit = |column: usize| f64::from(u8::from(column == range.start + position));
            regressors.searched.is_empty()
                && position < range.len()
                && range.clone().all(|column| (jacobian[(position, column)] - unit(column)).abs() < SAME)
        };
        let parameter = |(position, (kind, value)): (usize, (&'static ParameterKind, f64))| {
            let critical = student_95(robust.degrees_of_freedom_of(&jacobian.row(position).transpose()));
            let derivatives = jacobian.row(position).into_owned();
            let by_chance = critical * variances[(position, position)].max(0.0).sqrt();
            let half = misfit.half_width(&derivatives, by_chance, variances[(position, position)]);
            let [below, above] = misfit.without_bounds(&derivatives, critical).unwrap_or([0.0; 2]);
            let half_textbook = NORMAL_95 * textbook[(position, position)].max(0.0).sqrt();
            let linear = is_coefficient(position).then(|| range.start + position);
            let held = linear.is_some_and(|column| self.trimmed.solution.at_zero[column]);
            let reason = linear.and_then(|column| {
                self.at_one_speed(column, critical)
                    .or_else(|| self.beside_a_load(column, kind.name, critical))
                    .or_else(|| (held && (above < 0.0 || misfit.note.is_some())).then(|| DRIVEN.to_owned()))
                    .or_else(|| self.why_not_identifiable(column, kind.name, by_chance))
                    .or_else(|| self.beside_what_is_omitted(column, kind.name, half))
            });
            if let Some(reason) = reason {
                return (Parameter::not_identifiable(kind, reason), None);
            }
            let value = value - gripper;
            let low = if held { 0.0 } else { value - half.max(-below) };
            let half = if held { self.half_width_at_zero(range.start + position, critical) } else { half };
            let parameter = Parameter {
                ci95_textbook: (!held).then_some([value - half_textbook, value + half_textbook]),
                ..Parameter::estimated(kind, value, Some([low, value + half.max(above)]))
            };
            (parameter, (!held).then_some(derivatives))
        };
        effect.parameters().enumerate().map(parameter).collect()
    }

    /// Derivatives of an effect's values by all fitted coefficients, by differences of a thousandth of a standard error.
    fn jacobian(&self, index: usize, effect: &Effect) -> DMatrix<f64> {
        let covariance = &self.robust.matrix;
        let problem = &self.trimmed.problem;
        let count = self.trimmed.columns.len();
        let parameters = effect.values().len();
        let mut jacobian = DMatrix::zeros(parameters, count);
        let Some(regressors) = effect.kind().regressors else { return jacobian };
        let coefficients = &self.trimmed.solution.coefficients[problem.range(index)];
        let values_at = |shifted: &[f64]| {
            let mut changed = *effect;
            (regressors.values)(shifted, changed.values_mut());
            changed
        };
        let centre = values_at(coefficients);
        for (position, column) in problem.range(index).enumerate() {
            let step = 1e-3 * covariance[(column, column)].sqrt().max(1e-9 * coefficients[position].abs()).max(1e-15);
            let mut shifted = coefficients.to_vec();
            shifted[position] += step;
            let moved = values_at(&shifted);
            for parameter in 0..parameters {
                jacobian[(parameter, column)] = (moved.values()[parameter] - centre.values()[parameter]) / step;
            }
        }
        for (position, which) in problem.searched().iter().enumerate() {
            if which.effect == index {
                jacobian[(which.parameter, problem.columns.len() + position)] = 1.0;
            }
        }
        jacobian
    }

    /// Upper end of the interval of a coefficient that is held at zero, from its curvature alone.
    fn half_width_at_zero(&self, column: usize, critical: f64) -> f64 {
        let Trimmed { columns, solution, .. } = self.trimmed;
        critical * rms(&solution.residual) / dot(&columns[column], &columns[column]).sqrt()
    }

    /// The reason why a friction column cannot be separated from the other one of its direction, with their sum: the speed
    /// varies by little more than the encoder's noise. `None` if they can be separated.
    fn at_one_speed(&self, column: usize, critical: f64) -> Option<String> {
        let Trimmed { columns, solution, problem, .. } = self.trimmed;
        let friction = problem.friction().filter(|friction| friction.contains(&column))?;
        let coulomb = friction.start + (column - friction.start) % 2;
        let viscous = coulomb + 2;
        let product = |left: usize, right: usize| dot(&columns[left], &columns[right]);
        let (rows, speed_rad_s) = (product(coulomb, coulomb), product(coulomb, viscous) / product(coulomb, coulomb));
        let varies = product(viscous, viscous) - rows * speed_rad_s.powi(2);
        let noise = problem.noise.velocity_squares * rows / self.sliding_rows().len().max(1) as f64;
        let is_one_speed = varies <= (ONE_SPEED * speed_rad_s).powi(2) * rows || noise > NOISY_SPEED * varies;
        if rows == 0.0 || !is_one_speed {
            return None;
        }
        let together = solution.coefficients[coulomb] + solution.coefficients[viscous] * speed_rad_s;
        let mut derivatives = RowDVector::zeros(columns.len());
        (derivatives[coulomb], derivatives[viscous]) = (1.0, speed_rad_s);
        let deviation = deviation_of_sum(&self.robust.matrix, derivatives.as_slice());
        let half = self.misfit.half_width(&derivatives, critical * deviation, deviation.powi(2));
        let [name, with] = if column == coulomb { [coulomb, viscous] } else { [viscous, coulomb] }
            .map(|column| self.column_name(column).unwrap_or_default());
        Some(format!(
            "{name} and {with} cannot be separated: the knob turned at one speed, {speed_rad_s:.4} rad/s, where both together \
             make {} mNm; vary the speed",
            plus_minus(together, half)
        ))
    }

    /// The reason why a Coulomb friction cannot be separated from a constant torque, with the sum of both directions, which can:
    /// without the bound at zero one direction's friction would surely be negative and the other's positive. `None` otherwise.
    fn beside_a_load(&self, column: usize, name: &str, critical: f64) -> Option<String> {
        let Trimmed { columns, solution, problem, .. } = self.trimmed;
        let (levels, _) = problem.both_ways()?;
        if !levels.contains(&column) {
            return None;
        }
        let interval = |levels: &[usize]| {
            let mut derivatives = RowDVector::zeros(columns.len());
            levels.iter().for_each(|level| derivatives[*level] = 1.0);
            let at: f64 = levels.iter().map(|level| solution.coefficients[*level]).sum();
            self.misfit.without_bounds(&derivatives, critical).map(|[low, high]| [at + low, at + high])
        };
        let [negative, positive] = [interval(&levels[..1])?, interval(&levels[1..])?];
        let is_driven = |[_, high]: [f64; 2], [low, _]: [f64; 2]| high < 0.0 && low > 0.0;
        if !is_driven(negative, positive) && !is_driven(positive, negative) {
            return None;
        }
        let [low, high] = interval(&levels)?;
        Some(format!(
            "{name} cannot be separated from a constant torque: a weight, a spring or the sensor's zero drives the knob in one direction; \
             the frictions of both directions add up to {} mNm; take the zero, or diagnose the capture",
            plus_minus(0.5 * (low + high), 0.5 * (high - low))
        ))
    }

    fn why_not_identifiable(&self, column: usize, name: &str, half: f64) -> Option<String> {
        let Trimmed { columns, solution, problem, .. } = self.trimmed;
        if columns[column].iter().all(|value| *value == 0.0) {
            return Some(match name.rsplit_once('_') {
                Some((_, direction @ ("negative" | "positive"))) => {
                    format!("the knob never slid in the {direction} direction for long enough; sweep both ways")
                }
                _ => format!("the capture never excites {name}; sweep faster and wider"),
            });
        }
        if let Some(with) = self.entangled(column) {
            return Some(format!(
                "{name} and {with} cannot be separated: they are collinear along this sweep; vary the speed"
            ));
        }
        if name == effects::inertia::KIND.parameters[0].name {
            let noise = problem.motion.acceleration_noise_rad_s2(self.band.edge_hz);
            let seen = rms(&columns[column]);
            if noise * noise > NOISY_ACCELERATION * seen * seen {
                return Some(format!(
                    "the knob accelerated too little: {seen:.3} rad/s² RMS, of which {noise:.3} are sensor noise; sweep faster"
                ));
            }
            if half >= solution.coefficients[column].abs() {
                return Some(format!(
                    "the knob accelerated too little ({seen:.3e} rad/s² RMS): the 95 % interval of the inertia includes zero; \
                     sweep faster"
                ));
            }
        }
        let used: Vec<f64> = columns[column].iter().copied().filter(|value| value.abs() > 0.0).collect();
        let torque = rms(&problem.target);
        (!solution.at_zero[column] && half * rms(&used) > HOPELESS * torque).then(|| {
            format!(
                "the sweep excites it too little: in {} the interval amounts to {:.1} times the torque's RMS; sweep faster, \
                 wider or longer",
                plus_minus(solution.coefficients[column], half),
                half * rms(&used) / torque
            )
        })
    }

    /// Why a parameter cannot be identified once its interval allows for what the model lacks; `None` if it can.
    fn beside_what_is_omitted(&self, column: usize, name: &str, half: f64) -> Option<String> {
        self.why_not_identifiable(column, name, half).map(|_| {
            format!(
                "{name} depends on what the model lacks: beside that its 95 % interval is {}; diagnose the capture",
                plus_minus(self.trimmed.solution.coefficients[column], half)
            )
        })
    }

    /// Names of the other parameters whose columns are linearly dependent together with this one; `None` if there are none.
    fn entangled(&self, column: usize) -> Option<String> {
        let Trimmed { columns, solution, .. } = self.trimmed;
        let collinear = (0..columns.len()).filter(|index| solution.collinear[*index] && rms(&columns[*index]) > 0.0);
        for dependent in collinear {
            let products: Vec<f64> = columns.iter().map(|other| dot(other, &columns[dependent])).collect();
            let size = rms(&columns[dependent]);
            let parts: Vec<usize> = (0..columns.len())
                .filter(|index| {
                    let share: f64 = (0..columns.len()).map(|k| solution.inverse[(*index, k)] * products[k]).sum();
                    (share * rms(&columns[*index])).abs() > ENTANGLED * size
                })
                .collect();
            if column == dependent || parts.contains(&column) {
                let others = parts.iter().chain([&dependent]).filter(|other| **other != column);
                let names: Vec<&str> = others.filter_map(|other| self.column_name(*other)).collect();
                return Some(names.join(" and "));
            }
        }
        None
    }

    fn column_name(&self, column: usize) -> Option<&'static str> {
        let problem = &self.trimmed.problem;
        (0..problem.effects.len())
            .find(|effect| problem.range(*effect).contains(&column))
            .map(|effect| problem.effects[effect].kind().column_name(column - problem.range(effect).start))
    }

    /// Measured against model in these rows, with the model's standard deviation in every row.
    fn points(&self, rows: &[usize], deviation_mnm: &[f64], critical: f64) -> Vec<Point> {
        let Trimmed { solution, problem, .. } = self.trimmed;
        let point = |row: &usize| {
            let motion = problem.motion.at(row * problem.row_filter.step);
            Point::of(motion, problem.target[*row], solution.residual[*row], critical * deviation_mnm[*row])
        };
        rows.iter().map(point).collect()
    }

    /// Rows whose middle is not masked at all.
    fn sliding_rows(&self) -> Vec<usize> {
        let Problem { row_filter, target, .. } = &self.trimmed.problem;
        (0..target.len()).filter(|row| row_filter.mask[row * row_filter.step] >= 1.0).collect()
    }
}

/// A note on the possible causes of viscous friction that is surely below zero, since a knob does not drive itself; `None` if
/// there is none.
fn negative_friction(parameters: &Parameters) -> Option<String> {
    let is_negative = |known: &&Parameter| known.ci95.is_some_and(|[_, high]| high < 0.0);
    let viscous = parameters.0.iter().filter(|known| known.name.starts_with("viscous"));
    let names: Vec<&str> = viscous.filter(is_negative).map(|known| known.name).collect();
    (!names.is_empty()).then(|| {
        format!(
            "{}: negative over the whole 95 % interval; friction that falls as the knob turns faster (Stribeck's), a torque \
             that is late, or a spring or gravity that the model lacks looks like this; diagnose the capture, and calibrate \
             the delay between torque and motion",
            names.join(", ")
        )
    })
}

/// [`one_sided_friction`] of levels that differ beyond their intervals.
pub(crate) fn one_sided_friction_of(parameters: &Parameters) -> Option<String> {
    let known = |name: &str| parameters.get(name).and_then(|parameter| parameter.value.zip(parameter.ci95));
    let ((negative, [low, high]), (positive, [from, to])) = (known("coulomb_negative")?, known("coulomb_positive")?);
    if low > to || from > high { one_sided_friction([negative, positive]) } else { None }
}

/// A note on Coulomb friction that differs much between the directions, which may have another cause; `None` without one.
pub(crate) fn one_sided_friction([negative, positive]: [f64; 2]) -> Option<String> {
    ((positive - negative).abs() > ONE_SIDED * (positive + negative)).then(|| {
        format!(
            "the Coulomb friction differs by {:.4} mNm between the directions: a constant torque of half as much, such as a weight or \
             the sensor's zero, looks the same",
            (positive - negative).abs()
        )
    })
}

/// A note on a measured curve whose mean may be friction that differs between the directions; `None` where it is small.
pub(super) fn constant_torque(curves: &[MeasuredCurve], parameters: &Parameters) -> Option<String> {
    let curve = curves.iter().find(|curve| curve.effect == effects::angle_characteristic::KIND.name)?;
    let mean_mnm = mean(curve.points.iter().map(|point| point.torque_mnm));
    let friction_mnm = parameters.get("coulomb_positive")?.value?;
    (mean_mnm.abs() > ONE_SIDED * friction_mnm).then(|| {
        format!(
            "the measured torque over the angle is {mean_mnm:+.4} mNm on average: a constant torque such as a weight, or half of a difference \
             of the Coulomb friction between the directions, looks the same; the friction is the mean of both"
        )
    })
}

/// Standard deviation of the predicted torque, row by row.
pub(crate) fn prediction_sd<C: Deref<Target = [f64]>>(columns: &[C], covariance: &DMatrix<f64>) -> Vec<f64> {
    let variances = vector::quadratic_form(columns, covariance).into_iter();
    variances.map(|variance| variance.max(0.0).sqrt()).collect()
}
