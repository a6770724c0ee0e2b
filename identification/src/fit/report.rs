//! Values, intervals and reasons from the settled problem.

use dynamics::{Calibration, Effect, Part, effects};
use nalgebra::{DMatrix, RowDVector};

use super::misfit::Misfit;
use super::trimmed::{RefusedDelay, Rows, Trimmed};
use crate::estimate::{Covariance, Parameter, Parameters, Point};
use crate::numerics::vector::{self, dot};
use crate::preparation::motion::{Band, KnobMotion};
use crate::preparation::row_filter::RowFilter;
use crate::regression::least_squares::RobustCovariance;
use crate::regression::problem::Column;
use crate::uncertainty::statistics::{NORMAL_95, deviation_of_sum, plus_minus, rms, student_95};

/// A parameter whose interval spans this share of the torque's RMS, times its column, is not estimated.
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

/// The settled problem with all that its words need.
pub(crate) struct Report<'a> {
    pub(crate) trimmed: &'a Trimmed<'a>,
    pub(crate) motion: &'a KnobMotion,
    pub(crate) row_filter: &'a RowFilter,
    pub(crate) band: &'a Band,
    pub(crate) calibration: Option<&'a Calibration>,
    /// The rows, together with those next to standstill that the fit leaves out; `None` if it leaves out none.
    pub(crate) near: Option<Rows>,
}

/// Measured against model, row by row, and in sum.
pub(crate) struct Comparison {
    pub(crate) residual_rms_mnm: f64,
    pub(crate) relative_error_percent: f64,
    pub(crate) mean_ci95_mnm: f64,
    pub(crate) mean_ci95_textbook_mnm: f64,
    pub(crate) points: Vec<Point>,
}

impl Report<'_> {
    /// All parameters, their covariance, and the comparison on the rows; `no_detents` is the reason if there are none.
    pub(crate) fn parameters(&self, no_detents: Option<String>) -> (Parameters, Covariance, Comparison) {
        let Trimmed { columns, solution, .. } = self.trimmed;
        let textbook = solution.textbook_covariance();
        let instruments = self.trimmed.instruments.as_ref().unwrap_or(columns);
        let mut robust = solution.robust(instruments);
        if let Some(curves) = &self.trimmed.curves {
            robust.enlarge(curves.count());
        }
        let degrees_of_freedom = robust.degrees_of_freedom;
        let critical = student_95(degrees_of_freedom);
        let misfit = Misfit::of(self.trimmed, self.near.as_ref(), self.motion, &robust);
        let mut parameters = Vec::new();
        for (index, effect) in self.trimmed.effects().iter().enumerate() {
            self.effect_parameters(index, effect, &robust, &textbook, &misfit, &mut parameters);
        }
        if let Some(reason) = no_detents {
            for parameter in effects::detent::KIND.parameters {
                parameters.push(Parameter::not_identifiable(parameter.name, parameter.unit, reason.clone()));
            }
        }
        let covariance = Covariance { critical, degrees_of_freedom, ..self.covariance(&parameters, &robust.matrix) };
        (Parameters(parameters), covariance, self.compare([&robust.matrix, &textbook], critical))
    }

    /// Covariance of the parameters that are told and not held at zero, from that of the coefficients.
    fn covariance(&self, parameters: &[Parameter], coefficients: &DMatrix<f64>) -> Covariance {
        let mut order = Vec::new();
        let mut derivatives = Vec::new();
        for (index, effect) in self.trimmed.effects().iter().enumerate() {
            let jacobian = self.jacobian(index, effect, coefficients);
            for (position, (kind, _)) in effect.parameters().enumerate() {
                // The textbook's interval is left out where a parameter is held at zero.
                if parameters.iter().any(|estimated| estimated.name == kind.name && estimated.ci95_textbook.is_some()) {
                    order.push(kind.name);
                    derivatives.push(jacobian.row(position).into_owned());
                }
            }
        }
        let row = |left: &RowDVector<f64>| {
            let product = left * coefficients;
            derivatives.iter().map(|right| product.dot(right)).collect()
        };
        Covariance { rows: derivatives.iter().map(row).collect(), order, ..Covariance::default() }
    }

    /// What a reader should know besides.
    pub(crate) fn notes(&self, parameters: &Parameters) -> Vec<String> {
        let mut notes: Vec<String> = parameters.0.iter().filter_map(negative_friction).collect();
        notes.extend(one_sided_friction_of(parameters));
        if let Some(RefusedDelay { delay_s, is_worth_a_note: true, .. }) = self.trimmed.refused {
            notes.push(format!(
                "the torque seems to come {:.2} ms {} the motion, more than half a sample: calibrate the delay or diagnose the capture",
                1e3 * delay_s.abs(),
                if delay_s > 0.0 { "after" } else { "before" }
            ));
        }
        notes
    }

    fn effect_parameters(
        &self,
        index: usize,
        effect: &Effect,
        robust: &RobustCovariance,
        textbook: &DMatrix<f64>,
        misfit: &Misfit,
        parameters: &mut Vec<Parameter>,
    ) {
        let Some(regressors) = effect.kind().regressors else { return };
        let jacobian = self.jacobian(index, effect, &robust.matrix);
        let [variances, textbook] =
            [&robust.matrix, textbook].map(|covariance| &jacobian * covariance * jacobian.transpose());
        let gripper = match (effect.kind().part, self.calibration) {
            (Part::Inertia(_), Some(calibration)) => calibration.gripper_inertia,
            _ => 0.0,
        };
        let range = self.trimmed.problem.range(index);
        let searched_any = !regressors.searched.is_empty();
        for (position, (kind, value)) in effect.parameters().enumerate() {
            let critical = student_95(robust.degrees_of_freedom_of(&jacobian.row(position).transpose()));
            let derivatives = jacobian.row(position).into_owned();
            let by_chance = critical * variances[(position, position)].max(0.0).sqrt();
            let half = by_chance.hypot(misfit.of_sum(&derivatives));
            let [below, above] = misfit.without_bounds(&derivatives, critical).unwrap_or([0.0; 2]);
            let half_textbook = NORMAL_95 * textbook[(position, position)].max(0.0).sqrt();
            let linear = (!searched_any && position < range.len()).then(|| range.start + position);
            let reason = linear.and_then(|column| {
                self.at_one_speed(column, robust, critical, misfit)
                    .or_else(|| self.beside_a_load(column, kind.name, critical, misfit))
                    .or_else(|| self.why_not_identifiable(column, kind.name, half))
            });
            if let Some(reason) = reason {
                parameters.push(Parameter::not_identifiable(kind.name, kind.unit, reason));
                continue;
            }
            let value = value - gripper;
            let held = linear.is_some_and(|column| self.trimmed.solution.at_zero[column]);
            let low = if held { 0.0 } else { value - half.max(-below) };
            let half = if held { self.half_width_at_zero(range.start + position, critical) } else { half };
            parameters.push(Parameter {
                name: kind.name,
                value: Some(value),
                unit: kind.unit,
                ci95: Some([low, value + half.max(above)]),
                ci95_textbook: (!held).then_some([value - half_textbook, value + half_textbook]),
                reason: None,
            });
        }
    }

    /// Derivatives of an effect's values by all fitted coefficients, by differences of a thousandth of a standard error.
    fn jacobian(&self, index: usize, effect: &Effect, covariance: &DMatrix<f64>) -> DMatrix<f64> {
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

    /// Why a friction column cannot be told apart from the other one of its direction, and what is known of both together:
    /// the speed varies by little more than the encoder's noise.
    fn at_one_speed(&self, column: usize, robust: &RobustCovariance, critical: f64, misfit: &Misfit) -> Option<String> {
        let Trimmed { columns, solution, problem, .. } = self.trimmed;
        let friction = problem.effects.iter().position(|effect| effect.kind().name == effects::friction::KIND.name)?;
        let direction = column.checked_sub(problem.range(friction).start).filter(|place| *place < 4)? % 2;
        let coulomb = problem.range(friction).start + direction;
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
        let by_chance = critical * deviation_of_sum(&robust.matrix, derivatives.as_slice());
        let half = by_chance.hypot(misfit.of_sum(&derivatives));
        let [name, with] = if column == coulomb { [coulomb, viscous] } else { [viscous, coulomb] }
            .map(|column| self.column_name(column).unwrap_or_default());
        Some(format!(
            "{name} and {with} cannot be separated: the knob turned at one speed, {speed_rad_s:.4} rad/s, where both together \
             make {} mNm; vary the speed",
            plus_minus(together, half)
        ))
    }

    /// Why a Coulomb friction cannot be separated from a constant torque, and the sum of both directions, which can: without the bound at
    /// zero one direction's friction would surely be negative, and the other's positive.
    fn beside_a_load(&self, column: usize, name: &str, critical: f64, misfit: &Misfit) -> Option<String> {
        let Trimmed { columns, solution, problem, .. } = self.trimmed;
        let (levels, _) = problem.both_ways()?;
        if !levels.contains(&column) {
            return None;
        }
        let interval = |levels: &[usize]| {
            let mut derivatives = RowDVector::zeros(columns.len());
            levels.iter().for_each(|level| derivatives[*level] = 1.0);
            let at: f64 = levels.iter().map(|level| solution.coefficients[*level]).sum();
            misfit.without_bounds(&derivatives, critical).map(|[low, high]| [at + low, at + high])
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
        let direction = if name.ends_with("_negative") {
            "negative"
        } else if name.ends_with("_positive") {
            "positive"
        } else {
            ""
        };
        if columns[column].iter().all(|value| *value == 0.0) {
            return Some(if direction.is_empty() {
                format!("the capture never excites {name}; sweep faster and wider")
            } else {
                format!("the knob never slid in the {direction} direction for long enough; sweep both ways")
            });
        }
        if let Some(with) = self.entangled(column) {
            return Some(format!(
                "{name} and {with} cannot be separated: they are collinear along this sweep; vary the speed"
            ));
        }
        if name == effects::inertia::KIND.parameters[0].name {
            let noise = self.motion.acceleration_noise_rad_s2(self.band.edge_hz);
            let seen = rms(&columns[column]);
            if noise * noise > NOISY_ACCELERATION * seen * seen {
                return Some(format!(
                    "the knob accelerated too little: {seen:.3} rad/s² RMS, of which {noise:.3} are sensor noise; sweep faster"
                ));
            }
        }
        if name == effects::inertia::KIND.parameters[0].name && half >= solution.coefficients[column].abs() {
            return Some(format!(
                "the knob accelerated too little ({:.3e} rad/s² RMS): the 95 % interval of the inertia includes zero; \
                 sweep faster",
                rms(&columns[column])
            ));
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

    /// Names of the parameters that a column is a sum of, or that are a sum with it.
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
        (0..problem.effects.len()).find(|effect| problem.range(*effect).contains(&column)).map(|effect| {
            let position = column - problem.range(effect).start;
            problem.effects[effect].kind().parameters[position].name
        })
    }

    fn compare(&self, covariances: [&DMatrix<f64>; 2], critical: f64) -> Comparison {
        let Trimmed { columns, solution, problem, .. } = self.trimmed;
        let half_widths = covariances.map(|covariance| prediction_sd(columns, covariance));
        let rows = self.sliding_rows();
        let count: f64 = rows.iter().map(|_| 1.0).sum();
        let mean = |widths: &[f64]| rows.iter().map(|row| widths[*row]).sum::<f64>() / f64::max(count, 1.0);
        let points = rows
            .iter()
            .map(|row| {
                let sample = row * self.row_filter.step;
                Point {
                    t_s: self.motion.time_s[sample],
                    angle_rad: self.motion.angle_rad[sample],
                    velocity_rad_s: self.motion.velocity_rad_s[sample],
                    acceleration_rad_s2: self.motion.acceleration_rad_s2[sample],
                    torque_mnm: problem.target[*row],
                    torque_model_mnm: problem.target[*row] - solution.residual[*row],
                    torque_model_ci95_mnm: critical * half_widths[0][*row],
                    residual_mnm: solution.residual[*row],
                }
            })
            .collect();
        let of = |values: &[f64]| rms(&rows.iter().map(|row| values[*row]).collect::<Vec<_>>());
        Comparison {
            residual_rms_mnm: of(&solution.residual),
            relative_error_percent: 100.0 * of(&solution.residual) / of(&problem.target),
            mean_ci95_mnm: critical * mean(&half_widths[0]),
            mean_ci95_textbook_mnm: NORMAL_95 * mean(&half_widths[1]),
            points,
        }
    }

    /// Rows whose middle is not masked at all.
    fn sliding_rows(&self) -> Vec<usize> {
        (0..self.trimmed.problem.target.len())
            .filter(|row| self.row_filter.mask[row * self.row_filter.step] >= 1.0)
            .collect()
    }
}

/// What viscous friction may mean that is surely below zero: a knob does not drive itself.
fn negative_friction(Parameter { name, ci95, .. }: &Parameter) -> Option<String> {
    let [_, high] = ci95.filter(|_| name.starts_with("viscous"))?;
    (high < 0.0).then(|| {
        format!(
            "{name} is negative, its whole 95 % interval is: friction that falls as the knob turns faster (Stribeck's), a torque \
             that is late, or a spring or gravity that the model lacks looks like this; diagnose the capture, and calibrate \
             the delay between torque and motion"
        )
    })
}

/// [`one_sided_friction`] of levels that differ beyond their intervals.
fn one_sided_friction_of(parameters: &Parameters) -> Option<String> {
    let known = |name: &str| parameters.get(name).and_then(|parameter| parameter.value.zip(parameter.ci95));
    let ((negative, [low, high]), (positive, [from, to])) = (known("coulomb_negative")?, known("coulomb_positive")?);
    if low > to || from > high { one_sided_friction([negative, positive]) } else { None }
}

/// What Coulomb friction that differs much between the directions may mean besides.
pub(crate) fn one_sided_friction([negative, positive]: [f64; 2]) -> Option<String> {
    ((positive - negative).abs() > ONE_SIDED * (positive + negative)).then(|| {
        format!(
            "the Coulomb friction differs by {:.4} mNm between the directions: a constant torque of half as much, such as a weight or \
             the sensor's zero, looks the same",
            (positive - negative).abs()
        )
    })
}

/// Standard deviation of the predicted torque, row by row.
fn prediction_sd(columns: &[Column], covariance: &DMatrix<f64>) -> Vec<f64> {
    let rows = columns.first().map_or(0, |column| column.len());
    let mut deviation = vec![0.0; rows];
    vector::quadratic_form(columns, covariance, &mut deviation);
    deviation.iter_mut().for_each(|variance| *variance = variance.max(0.0).sqrt());
    deviation
}
