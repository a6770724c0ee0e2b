//! Detents of which each has its own place and height, fitted in the place of equal ones.
//!
//! From one angle at which the detents' torque vanishes to the next it is half a sine of its own width and height. The
//! heights are linear, the zeros follow by Gauss–Newton from those of equal detents, beside all other columns.

use std::f64::consts::{PI, TAU};

use dynamics::{Coordinate, Curve, Effect, TableUse, TorqueTable, effects};

use super::bounded_least_squares;
use super::capture::Capture;
use super::findings::{UnequalDetent, Value};
use super::separable::Separable;
use super::structure::Structure;
use crate::numerics::vector::dot;
use crate::regression::backtracking::longest_improving;
use crate::regression::least_squares::{LeastSquares, residual};
use crate::uncertainty::statistics::{deviation_of_sum, mean, student_95};

/// Gauss–Newton steps; each moves a zero by at most this share of the distance between two.
const STEPS: usize = 12;
const LARGEST_STEP: f64 = 0.3;
/// Share of the sum of squares below which a step's gain is the last.
const SETTLED: f64 = 1e-4;
/// What holds a lobe that the capture hardly shows at the others' mean height and at its place, as a share of the mean
/// lobe's square.
const HELD: f64 = 1e-3;
/// Distance of the detents in a turn from a whole number up to which they repeat after a turn.
const WHOLE: f64 = 0.15;
/// Most lobes: two to a detent, of which hardly a knob has more than forty; a motor's cogging has more.
const MOST_LOBES: usize = 80;

/// Detents as lobes: half a sine from each zero to the next, of alternating sign.
#[derive(Clone)]
struct Lobes {
    /// Zeros in rising order, within one period, rad.
    zeros_rad: Vec<f64>,
    /// Height of the lobe that begins at each zero, mNm; every other one is a trough.
    heights_mnm: Vec<f64>,
    /// Angle after which they repeat, rad.
    period_rad: f64,
}

impl Lobes {
    /// Equal ones in the place of a detent, over the angles of a capture.
    #[allow(
        clippy::cast_precision_loss,
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "numbers of lobes"
    )]
    fn equal(detent: &Effect, lowest_rad: f64, highest_rad: f64) -> Option<Self> {
        let [amplitude_mnm, period, phase] = *detent.values() else { return None };
        let in_turn = (1.0 / period).round();
        let repeats = (1.0 / period - in_turn).abs() < WHOLE;
        let detents = if repeats { in_turn } else { ((highest_rad - lowest_rad) / (TAU * period)).ceil() + 1.0 };
        let count = 2 * detents as usize;
        if !(4..=MOST_LOBES).contains(&count) {
            return None;
        }
        let period_rad = if repeats { TAU } else { detents * TAU * period };
        let middle_rad = 0.5 * (lowest_rad + highest_rad);
        // A zero with rising torque half a period below the middle of the travel.
        let turns = ((middle_rad / period + phase) / TAU).round();
        let first_rad = period * (TAU * turns - phase) - (0.5 * detents).floor() * period_rad / detents;
        Some(Self {
            zeros_rad: (0..count).map(|lobe| first_rad + lobe as f64 * period_rad / count as f64).collect(),
            heights_mnm: vec![amplitude_mnm; count],
            period_rad,
        })
    }

    /// Those of an effect.
    fn of(effect: &Effect) -> Option<Self> {
        let (scale, table) = (effect.values()[0], effect.table()?);
        let every_other =
            |values: &[f64], first: usize| values.iter().skip(first).step_by(2).copied().collect::<Vec<_>>();
        let signs = [scale, -scale].into_iter().cycle();
        let heights = every_other(table.points_mnm(), 1).into_iter().zip(signs);
        Some(Self {
            zeros_rad: every_other(table.points(), 0),
            heights_mnm: heights.map(|(height, sign)| sign * height).collect(),
            period_rad: table.period_rad()?,
        })
    }

    fn count(&self) -> usize {
        self.zeros_rad.len()
    }

    /// Which lobe an angle lies in, and how far from its first to its second zero, with their distance, rad.
    fn place(&self, angle_rad: f64) -> (usize, f64, f64) {
        let first_rad = self.zeros_rad[0];
        let within_rad = first_rad + (angle_rad - first_rad).rem_euclid(self.period_rad);
        let lobe = self.zeros_rad.partition_point(|zero| *zero <= within_rad).max(1) - 1;
        let width_rad = self.next_zero_rad(lobe) - self.zeros_rad[lobe];
        (lobe, (within_rad - self.zeros_rad[lobe]) / width_rad, width_rad)
    }

    fn next_zero_rad(&self, lobe: usize) -> f64 {
        self.zeros_rad.get(lobe + 1).copied().unwrap_or(self.zeros_rad[0] + self.period_rad)
    }

    /// Columns of the heights, and of the zeros at the present heights.
    fn columns(&self, capture: &Capture) -> Vec<Vec<f64>> {
        let count = self.count();
        capture.row_filter.rows_of(2 * count, |range, columns| {
            columns.iter_mut().for_each(|column| column.fill(0.0));
            for (row, index) in range.enumerate() {
                let (lobe, share, width_rad) = self.place(capture.motion.angle_rad[index]);
                let sign = if lobe.is_multiple_of(2) { 1.0 } else { -1.0 };
                let (sine, cosine) = (PI * share).sin_cos();
                columns[lobe][row] = sign * sine;
                // sin(π·(θ − z)/w), w the distance to the next zero: its derivatives by both zeros.
                let slope = -sign * self.heights_mnm[lobe] * PI * cosine / width_rad;
                columns[count + lobe][row] += slope * (1.0 - share);
                columns[count + (lobe + 1) % count][row] += slope * share;
            }
        })
    }

    /// Moved by a step of Gauss and Newton: new heights, and shifts of the zeros, rad.
    fn moved(&self, heights_mnm: &[f64], shifts_rad: &[f64], share: f64) -> Option<Self> {
        let most_rad = LARGEST_STEP * self.period_rad / to_f64(self.count());
        let mut moved = self.clone();
        for (lobe, height) in heights_mnm.iter().enumerate() {
            moved.heights_mnm[lobe] += share * (height - moved.heights_mnm[lobe]);
            moved.zeros_rad[lobe] += share * shifts_rad[lobe].clamp(-most_rad, most_rad);
        }
        // Zeros that overtake each other are no detents.
        (0..self.count()).all(|lobe| moved.next_zero_rad(lobe) > moved.zeros_rad[lobe]).then_some(moved)
    }

    /// The effect: zeros, and extremes half way between them.
    fn effect(&self) -> Option<Effect> {
        let (mut points, mut torque_mnm) = (Vec::new(), Vec::new());
        for lobe in 0..self.count() {
            let zero_rad = self.zeros_rad[lobe];
            let sign = if lobe.is_multiple_of(2) { 1.0 } else { -1.0 };
            points.extend([zero_rad, 0.5 * (zero_rad + self.next_zero_rad(lobe))]);
            torque_mnm.extend([0.0, sign * self.heights_mnm[lobe]]);
        }
        let of = TableUse { curve: Curve::Sine, over: Coordinate::Angle, holds: false };
        let table = TorqueTable::kept_for(of, &points, &torque_mnm, Some(self.period_rad)).ok()?;
        Some(Effect::new(&effects::unequal_detents::KIND, &[1.0]).with_table(table))
    }
}

/// The structure with unequal detents in the place of its equal ones, fitted to the capture; `None` if it has none.
pub(crate) fn structure(base: &Structure, capture: &Capture) -> Option<Structure> {
    let index = base.position(effects::detent::KIND.name)?;
    let scene = capture.scene_of(base);
    let equal = Lobes::equal(&base.effects[index], scene.lowest_rad, scene.highest_rad)?;
    fitted(equal, base.without(index), capture)
}

/// A structure with unequal detents that are fitted anew beside its other effects; `None` if it has none.
pub(crate) fn refined(structure: &Structure, capture: &Capture) -> Option<Structure> {
    let index = structure.position(effects::unequal_detents::KIND.name)?;
    let fitted = fitted(Lobes::of(&structure.effects[index])?, structure.without(index), capture)?;
    // It keeps its place among the effects.
    let (effect, columns) = (*fitted.effects.last()?, *fitted.columns.last()?);
    let mut refined = fitted.without(fitted.effects.len() - 1);
    refined.effects.insert(index, effect);
    refined.columns.insert(index, columns);
    Some(refined)
}

/// The structure with lobes more, fitted from where they are.
fn fitted(mut lobes: Lobes, structure: Structure, capture: &Capture) -> Option<Structure> {
    let rest = Separable::new(structure, capture);
    let rest_columns = rest.columns();
    let target = capture.target(rest.structure.delay_s());
    let mut nonnegative = rest.structure.nonnegative();
    nonnegative.resize(rest_columns.len() + 2 * lobes.count(), false);
    let mut columns = lobes.columns(capture);
    let mut left = squares(&lobes, &columns, &rest_columns, &target, &nonnegative);
    for _ in 0..STEPS {
        let step = solved(&lobes, &columns, &rest_columns, &target, &nonnegative);
        let (heights_mnm, shifts_rad) = step[rest_columns.len()..].split_at(lobes.count());
        let better = longest_improving(0.4, |share| {
            let moved = lobes.moved(heights_mnm, shifts_rad, share)?;
            let columns = moved.columns(capture);
            let now = squares(&moved, &columns, &rest_columns, &target, &nonnegative);
            (now < left).then_some((now, moved, columns))
        });
        let Some((now, moved, moved_columns)) = better else { break };
        let settled = left - now < SETTLED * left;
        (left, lobes, columns) = (now, moved, moved_columns);
        if settled {
            break;
        }
    }
    let heights = solved(&lobes, &columns[..lobes.count()], &rest_columns, &target, &nonnegative);
    lobes.heights_mnm.copy_from_slice(&heights[rest_columns.len()..]);
    Some(rest.structure.with(lobes.effect()?, 1))
}

/// The detents of a fitted structure one by one, with their intervals: those that the capture shows whole.
pub(crate) fn detents(effect: &str, structure: &Structure, capture: &Capture) -> Vec<UnequalDetent> {
    let index = structure
        .position(effects::unequal_detents::KIND.name)
        .filter(|_| effect == effects::unequal_detents::KIND.name);
    let Some((index, lobes)) = index.and_then(|index| Some((index, Lobes::of(&structure.effects[index])?))) else {
        return Vec::new();
    };
    let rest = Separable::new(structure.without(index), capture);
    let of_lobes = lobes.columns(capture);
    let columns: Vec<&[f64]> = of_lobes.iter().map(Vec::as_slice).chain(rest.columns()).collect();
    // What is left is the same whichever columns say it: the structure is at its best.
    let left = Separable::new(structure.clone(), capture).residual;
    let solved = LeastSquares::solve(&columns, &left, &vec![false; columns.len()]);
    let covariance = solved.robust(&columns);
    let critical = student_95(covariance.degrees_of_freedom);
    let count = lobes.count();
    let value = |value: f64, unit, parts: &[(usize, f64)]| {
        let mut derivatives = vec![0.0; columns.len()];
        parts.iter().for_each(|(column, by)| derivatives[*column] = *by);
        let half = critical * deviation_of_sum(&covariance.matrix, &derivatives);
        let known = parts.iter().all(|(column, _)| !solved.collinear[*column]) && half.is_finite();
        Value { value, unit, ci95: known.then_some([value - half, value + half]) }
    };
    let scene = capture.scene_of(structure);
    let each = (0..count).step_by(2).filter_map(|lobe| {
        let (before, next) = ((lobe + count - 1) % count, (lobe + 2) % count);
        let rest_rad = lobes.zeros_rad[lobe];
        let pitch_rad =
            lobes.zeros_rad.get(lobe + 2).copied().unwrap_or(lobes.zeros_rad[0] + lobes.period_rad) - rest_rad;
        let turns = ((scene.lowest_rad - rest_rad + pitch_rad) / lobes.period_rad).ceil().max(0.0);
        let seen_rad = rest_rad + turns * lobes.period_rad;
        (seen_rad - 0.5 * pitch_rad >= scene.lowest_rad && seen_rad + pitch_rad <= scene.highest_rad).then(|| {
            UnequalDetent {
                rest: value(rest_rad, "rad", &[(count + lobe, 1.0)]),
                pitch: value(pitch_rad, "rad", &[(count + lobe, -1.0), (count + next, 1.0)]),
                peak: value(lobes.heights_mnm[lobe], "mNm", &[(lobe, 1.0)]),
                trough: value(lobes.heights_mnm[before], "mNm", &[(before, 1.0)]),
            }
        })
    });
    each.collect()
}

/// Coefficients of the rest's columns and of the lobes', zeros held at their place and heights at their mean where the
/// capture does not show them.
fn solved(lobes: &Lobes, columns: &[Vec<f64>], rest: &[&[f64]], target: &[f64], nonnegative: &[bool]) -> Vec<f64> {
    let count = lobes.count();
    let mean_square =
        |columns: &[Vec<f64>]| columns.iter().map(|column| dot(column, column)).sum::<f64>() / to_f64(count);
    let mean_mnm = mean(&lobes.heights_mnm);
    let held: Vec<f64> = columns
        .chunks(count)
        .flat_map(|of_kind| std::iter::repeat_n((HELD * mean_square(of_kind)).sqrt(), of_kind.len()))
        .collect();
    let with_rows = |column: &[f64], place: Option<usize>| {
        let mut column = column.to_vec();
        column.extend((0..columns.len()).map(|row| if place == Some(row) { held[row] } else { 0.0 }));
        column
    };
    let all: Vec<Vec<f64>> = rest
        .iter()
        .map(|column| with_rows(column, None))
        .chain(columns.iter().enumerate().map(|(place, column)| with_rows(column, Some(place))))
        .collect();
    let mut wanted = target.to_vec();
    wanted.extend((0..columns.len()).map(|row| if row < count { held[row] * mean_mnm } else { 0.0 }));
    let slices: Vec<&[f64]> = all.iter().map(Vec::as_slice).collect();
    bounded_least_squares::solve(&slices, &wanted, &nonnegative[..slices.len()])
}

/// Sum of squares that lobes leave, whatever their heights.
fn squares(lobes: &Lobes, columns: &[Vec<f64>], rest: &[&[f64]], target: &[f64], nonnegative: &[bool]) -> f64 {
    let heights = &columns[..lobes.count()];
    let coefficients = solved(lobes, heights, rest, target, nonnegative);
    let slices: Vec<&[f64]> = rest.iter().copied().chain(heights.iter().map(Vec::as_slice)).collect();
    let left = residual(&slices, target, &coefficients);
    dot(&left, &left)
}

#[allow(clippy::cast_precision_loss, reason = "a number of lobes")]
fn to_f64(count: usize) -> f64 {
    count as f64
}
