//! Estimates beside effects that many machines have and the fit leaves out.

use nalgebra::{DMatrix, DVector};

use super::shift::Shift;
use super::trimmed::Trimmed;
use crate::numerics::statistics::rms;
use crate::numerics::vector::{self, dot, square};
use crate::regression::least_squares::{LeastSquares, residual};
use crate::regression::problem::{Column, Problem};

/// Speed within which friction near standstill differs from that beyond, as a share of the sliding knob's RMS speed.
const FRICTION_SPEED: f64 = 0.2;
/// Travel below which a weight looks like a constant torque with a slight bend, rad.
const FAR_RAD: f64 = 1.0;

/// Least share of an omitted column's square that the fit's columns must leave: a smaller remainder may be noise of the motion,
/// for example where a sinusoidal sweep makes angle and acceleration alike.
const INSEPARABLE: f64 = 1e-2;
/// Possible length of a delay that the capture cannot show, in samples: a torque held from one sample to the next is late by half a sample.
const UNSEEN_DELAY_SAMPLES: f64 = 0.5;
/// Share of the residual's sum of squares from which on omitted effects are reported.
const WORTH_A_NOTE: f64 = 0.25;

/// Omitted effects that are alike.
struct Group {
    /// Name of the group, as the subject of a sentence.
    name: String,
    columns: Vec<Omitted>,
}

/// A column of an omitted effect.
pub(super) struct Omitted {
    pub(super) column: Column,
    /// Whether only the part of the column beyond the model's own friction counts. With the whole column, the fitted levels of
    /// friction would apply to the start, to standstill or to one angle alone.
    pub(super) is_beyond_friction: bool,
}

/// Shifts of the estimates beside each group of effects, beside all of them, for a spring's rest angle, and for a delay that the capture cannot
/// show; and a note on the group that explains most of the residual, if that is much. `robust` is the covariance of the fit.
pub(super) fn shifts(trimmed: &Trimmed<'_>, robust: &DMatrix<f64>) -> (Vec<Shift>, Option<String>) {
    let groups = groups(trimmed);
    let beside = |group: &Group| group.columns.iter().filter_map(|omitted| Beside::of(omitted, trimmed)).collect();
    let beside: Vec<Vec<Beside>> = groups.iter().map(beside).collect();
    let separable: Vec<Vec<&Beside>> =
        beside.iter().map(|group| group.iter().filter(|beside| beside.is_separable).collect()).collect();
    let solution = &trimmed.solution;
    let each: Vec<Option<(Shift, f64)>> = separable.iter().map(|group| shift(group, solution, robust)).collect();
    let shares = groups.iter().zip(&each).filter_map(|(group, shift)| Some((&group.name, shift.as_ref()?.1)));
    let most = shares.max_by(|(_, one), (_, other)| one.total_cmp(other));
    let note = most.filter(|(_, share)| *share > WORTH_A_NOTE).map(|(name, share)| {
        format!(
            "{name} would explain {:.0} % of what the model leaves, and the intervals allow for that; diagnose the capture to name it",
            100.0 * share
        )
    });
    let all = shift(&separable.concat(), solution, robust);
    let mut shifts: Vec<Shift> = each.into_iter().chain([all]).flatten().map(|(shift, _)| shift).collect();
    if trimmed.curves.is_none() {
        shifts.extend(rest_angle(trimmed, robust).into_iter().flatten());
    }
    // The delay is the last group.
    let delay = beside.last().and_then(|group| group.first()).filter(|_| trimmed.delay.is_some());
    shifts.extend(delay.and_then(|delay| unseen_delay(delay, trimmed, robust)));
    (shifts, note)
}

/// The shift of the estimates by a delay that the capture cannot show, as where a damper makes torque and velocity alike: channels that are
/// read one after the other may be as late.
fn unseen_delay(delay: &Beside, trimmed: &Trimmed<'_>, robust: &DMatrix<f64>) -> Option<Shift> {
    let delay_s = UNSEEN_DELAY_SAMPLES / trimmed.problem.row_filter.rate_hz;
    let change = delay_s * &delay.change;
    (!delay.is_separable).then(|| Shift { change, covariance: robust.clone(), is_of_better_model: false })
}

/// The shifts of the estimates if a spring rests at either end of the travel. Where it rests is not known, and its constant torque looks like
/// friction that differs between the directions.
fn rest_angle(trimmed: &Trimmed<'_>, robust: &DMatrix<f64>) -> Option<[Shift; 2]> {
    let Trimmed { problem: Problem { motion, row_filter, .. }, columns, solution, .. } = trimmed;
    let (low_rad, high_rad) = vector::extent_where(&motion.angle_rad, &row_filter.mask)?;
    let (middle_rad, reach_rad) = (0.5 * (low_rad + high_rad), 0.5 * (high_rad - low_rad));
    let rows = row_filter.rows_of(2, |range, columns| {
        let [angle, constant] = columns else { return };
        angle.iter_mut().zip(&motion.angle_rad[range]).for_each(|(row, angle_rad)| *row = angle_rad - middle_rad);
        constant.fill(1.0);
    });
    let [angle, constant] = <[Vec<f64>; 2]>::try_from(rows).ok()?;
    let angle = Omitted { column: angle.into(), is_beyond_friction: false };
    let angle = Beside::of(&angle, trimmed).filter(|beside| beside.is_separable)?;
    let slope = LeastSquares::solve(&[&*angle.rest], &solution.residual);
    let of_constant = &solution.inverse * vector::products_with(columns, &constant);
    let variance = slope.robust_of_points(&[&*angle.rest], 1)[(0, 0)];
    Some([-reach_rad, reach_rad].map(|rest_rad| {
        let per_slope = &angle.change + rest_rad * &of_constant;
        Shift {
            covariance: robust + variance * &per_slope * per_slope.transpose(),
            change: slope.coefficients[0] * per_slope,
            is_of_better_model: true,
        }
    }))
}

fn groups(trimmed: &Trimmed<'_>) -> Vec<Group> {
    let mut groups = Vec::new();
    // A torque measured over the angle already contains these effects.
    if trimmed.curves.is_none() {
        groups.extend(of_motion(trimmed));
        groups.extend(friction_of_the_load(trimmed));
    }
    groups.extend(trimmed.delay.iter().map(|delay| Group {
        name: format!(
            "a torque that comes {:.2} ms {} the motion",
            1e3 * delay.delay_s.abs(),
            if delay.delay_s > 0.0 { "after" } else { "before" }
        ),
        columns: vec![Omitted { column: delay.column.clone(), is_beyond_friction: false }],
    }));
    groups
}

/// Those that follow from the motion.
fn of_motion(trimmed: &Trimmed<'_>) -> [Group; 5] {
    let Problem { motion, row_filter, .. } = &trimmed.problem;
    let friction_speed_rad_s = FRICTION_SPEED * rms(&row_filter.sliding_speeds_rad_s(motion));
    let (low_rad, high_rad) = vector::extent_where(&motion.angle_rad, &row_filter.mask).unwrap_or((0.0, 0.0));
    let is_short_travel = high_rad - low_rad < FAR_RAD;
    let middle_rad = 0.5 * (low_rad + high_rad);
    let rows = row_filter.rows_of(9, |range, columns| {
        let [sine, cosine, angle, eccentric_sine, eccentric_cosine, drift, friction_drift, slow, drag] = columns else {
            return;
        };
        vector::sines(&motion.angle_rad[range.clone()], 1.0, sine, cosine);
        for (place, at) in range.enumerate() {
            let velocity_rad_s = motion.velocity_rad_s[at];
            let sign = motion.at(at).velocity_sign();
            angle[place] = motion.angle_rad[at] - middle_rad;
            (eccentric_sine[place], eccentric_cosine[place]) = (sign * sine[place], sign * cosine[place]);
            drift[place] = motion.time_s[at] - motion.time_s[0];
            friction_drift[place] = sign * drift[place];
            slow[place] = sign / (1.0 + velocity_rad_s.abs() / friction_speed_rad_s);
            drag[place] = velocity_rad_s * velocity_rad_s.abs();
        }
    });
    let rows: Vec<Column> = rows.into_iter().map(Column::from).collect();
    let drag = rows.last().cloned();
    let mut rows = rows.into_iter().chain(drag);
    let mut group = |name: &str, are_beyond_friction: &[bool]| Group {
        name: name.to_owned(),
        columns: are_beyond_friction
            .iter()
            .zip(rows.by_ref())
            .map(|(is_beyond_friction, column)| Omitted { column, is_beyond_friction: *is_beyond_friction })
            .collect(),
    };
    [
        group("a torque over the angle, as of a weight or a spring,", &[is_short_travel; 3]),
        group("friction that differs over the angle", &[true; 2]),
        group("torque or friction that drifts", &[false, true]),
        group("friction that is not linear in the speed", &[true; 2]),
        // Beside a drag alone, viscous friction is that of a slow motion.
        group("a drag", &[false]),
    ]
}

/// Friction that grows with the load, the fitted torque without its friction: the model's Coulomb friction is then that without load.
fn friction_of_the_load(trimmed: &Trimmed<'_>) -> Option<Group> {
    let Trimmed { problem, columns, target, solution, .. } = trimmed;
    let friction = problem.friction()?;
    let fitted = target.iter().zip(&solution.residual).map(|(torque, left)| torque - left);
    let column = fitted.enumerate().map(|(row, fitted_mnm)| {
        let of_friction = friction.clone().map(|place| solution.coefficients[place] * columns[place][row]);
        let load_mnm = fitted_mnm - of_friction.sum::<f64>();
        problem.motion.at(row * problem.row_filter.step).velocity_sign() * load_mnm.abs()
    });
    let columns = vec![Omitted { column: column.collect(), is_beyond_friction: false }];
    Some(Group { name: "friction that grows with the load".to_owned(), columns })
}

/// An omitted column beside those of the fit.
pub(super) struct Beside {
    /// Residual of the omitted column after regression on the fit's columns.
    pub(super) rest: Vec<f64>,
    /// Change of the fit's coefficients per unit of the omitted column's coefficient.
    pub(super) change: DVector<f64>,
    /// Whether `rest` is more than noise, relative to the part of the column that the friction columns do not explain.
    pub(super) is_separable: bool,
}

impl Beside {
    /// `None` without a friction effect, and where its fitted columns are dependent.
    pub(super) fn of(omitted: &Omitted, Trimmed { problem, columns, solution, .. }: &Trimmed<'_>) -> Option<Self> {
        let Omitted { column, is_beyond_friction } = omitted;
        let is_fitted = |index: &usize| solution.inverse[(*index, *index)] != 0.0;
        let friction: Vec<usize> = problem.friction()?.filter(is_fitted).collect();
        let product = |row: usize, other: usize| dot(&columns[friction[row]], &columns[friction[other]]);
        let gram = DMatrix::from_fn(friction.len(), friction.len(), product).cholesky()?;
        let with_columns = vector::products_with(columns, column);
        let with_friction = with_columns.select_rows(&friction);
        let of_friction = gram.solve(&with_friction);
        let parts = &solution.inverse * &with_columns;
        let rest = residual(columns, column, parts.as_slice());
        let beyond_friction = square(column) - of_friction.dot(&with_friction);
        let is_separable = square(&rest) > INSEPARABLE * beyond_friction;
        let mut change = -parts;
        if *is_beyond_friction {
            friction.iter().zip(of_friction.iter()).for_each(|(place, part)| change[*place] += part);
        }
        Some(Self { rest, change, is_separable })
    }
}

/// The shift of the estimates if the effects of a group are fitted too (Frisch and Waugh 1933), and the share of the residual's sum of
/// squares that they explain; `None` for no effects.
fn shift(group: &[&Beside], solution: &LeastSquares, robust: &DMatrix<f64>) -> Option<(Shift, f64)> {
    let rests: Vec<&[f64]> = group.iter().map(|beside| &*beside.rest).collect();
    let changes: Vec<DVector<f64>> = group.iter().map(|beside| beside.change.clone()).collect();
    let changes = (!changes.is_empty()).then(|| DMatrix::from_columns(&changes))?;
    let fitted = LeastSquares::solve(&rests, &solution.residual);
    let covariance = robust + &changes * fitted.robust_of_points(&rests, rests.len()) * changes.transpose();
    let share = 1.0 - fitted.squares() / solution.squares().max(f64::MIN_POSITIVE);
    let change = changes * DVector::from_vec(fitted.coefficients);
    Some((Shift { change, covariance, is_of_better_model: true }, share))
}
