//! Torque measured point by point: splines over a coordinate, linear in the torques of their points, that join a fit beside the
//! effects that have a name.

use dynamics::{Effect, EffectKind, Motion, Part, TableUse, TorqueTable, effects};
use nalgebra::DMatrix;

use super::gram::{COLLINEAR, Correction};
use super::least_squares::LeastSquares;
use crate::numerics::statistics::{NORMAL_95, half_width, interval, mean, range};
use crate::numerics::vector::{self, dot, square};

/// Numbers of points that are tried.
const POINTS: [u16; 5] = [8, 16, 32, 64, 128];
/// Rows that a point must have on the average.
const ROWS_PER_POINT: usize = 4;
/// Cells of the travel in which the bending of the torque is looked at.
const CELLS: usize = 200;
/// Ridge that holds a point near zero if the samples hardly show it, as a share of the mean point's square.
const HELD: f64 = 1e-6;
/// The ridge for the points of a friction, which is larger: a torque that was seen in one direction only counts as no friction.
const FRICTION_HELD: f64 = 1e-3;
/// Share of a column's square that is rounding.
const ROUNDING: f64 = 1e-18;
/// A point is given an interval if its column has this share of the mean point's square.
const SHOWN: f64 = 1e-3;

/// A torque measured over a coordinate.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct MeasuredCurve {
    /// Name of the effect that it is.
    pub effect: &'static str,
    /// Points of the spline.
    pub points: Vec<CharacteristicPoint>,
}

impl MeasuredCurve {
    /// Half width of the 95 % interval at a value of the coordinate, on a line between its points; `None` outside them, or where the
    /// capture hardly shows it.
    pub(crate) fn half_width(&self, at: f64) -> Option<f64> {
        let next = self.points.partition_point(|point| point.at < at);
        let right = self.points.get(next)?;
        let left = if right.at > at { self.points.get(next.checked_sub(1)?)? } else { right };
        let [before, after] = [left, right].map(|point| point.ci95.map(|ci95| half_width(point.torque_mnm, ci95)));
        let (before, after) = before.zip(after)?;
        let share = if right.at > left.at { (at - left.at) / (right.at - left.at) } else { 0.0 };
        Some(before + share * (after - before))
    }
}

/// A point of a measured characteristic.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct CharacteristicPoint {
    /// Where, rad or rad/s.
    pub at: f64,
    /// Torque there, mNm.
    pub torque_mnm: f64,
    /// Its 95 % interval; none where the capture hardly shows it.
    pub ci95: Option<[f64; 2]>,
}

/// A spline through points over one coordinate, before their torques are known.
pub(crate) struct Spline {
    pub(crate) kind: &'static EffectKind,
    pub(crate) of: TableUse,
    pub(crate) points: Vec<f64>,
    pub(crate) period_rad: Option<f64>,
}

impl Spline {
    /// Through `count` points from one value of the coordinate to another; `None` for an effect without a table.
    pub(crate) fn new(
        kind: &'static EffectKind,
        [from, to]: [f64; 2],
        count: u16,
        period_rad: Option<f64>,
    ) -> Option<Self> {
        let intervals = f64::from(if period_rad.is_some() { count } else { count - 1 });
        let points = (0..count).map(|point| from + (to - from) * f64::from(point) / intervals).collect();
        Self::through(kind, points, period_rad)
    }

    /// Through points at these values of the coordinate; `None` for an effect without a table.
    pub(crate) fn through(kind: &'static EffectKind, points: Vec<f64>, period_rad: Option<f64>) -> Option<Self> {
        let (Part::TorqueTable(of) | Part::FrictionTable(of)) = kind.part else { return None };
        Some(Self { kind, of, points, period_rad })
    }

    /// The effect with these torques at the points.
    pub(crate) fn effect(&self, torque_mnm: &[f64]) -> Option<Effect> {
        let table = TorqueTable::kept_for(self.of, &self.points, torque_mnm, self.period_rad).ok()?;
        Some(Effect::new(self.kind, &[1.0]).with_table(table))
    }

    /// Columns of the torque of every point alone, 1 mNm high, over samples that move like this.
    pub(crate) fn columns<'a>(
        &'a self,
        samples: usize,
        motion: impl Fn(usize) -> Motion + 'a,
    ) -> impl Iterator<Item = Vec<f64>> + 'a {
        let resists = matches!(self.kind.part, Part::FrictionTable(_));
        let mut unit = vec![0.0; self.points.len()];
        (0..self.points.len()).map(move |point| {
            unit.fill(0.0);
            unit[point] = 1.0;
            let table = TorqueTable::through(self.of, &self.points, &unit, self.period_rad).ok();
            let torque_mnm = |index: usize| {
                let motion = motion(index);
                let sign = if resists { motion.velocity_sign() } else { 1.0 };
                sign * table.as_ref().map_or(0.0, |table| self.of.torque_mnm(table, &motion))
            };
            (0..samples).map(torque_mnm).collect()
        })
    }
}

/// Corrections that hold the points of a spline near zero, each by a share of the mean point's square, so that a torque that the `base`
/// columns (of named effects) can also explain goes to these. The columns of the points follow the `base` columns.
pub(crate) fn holds(base: usize, points: &[Vec<f64>], share: impl Fn(usize) -> f64) -> Vec<Correction> {
    let squares: Vec<f64> = points.iter().map(|row| square(row)).collect();
    let mean = mean(&squares);
    let hold = |point| Correction { column: base + point, square: share(point) * mean, product: 0.0 };
    (0..points.len()).map(hold).collect()
}

/// Where the points of a spline are to lie: closer where the torque bends more.
pub(crate) struct Places {
    lowest_rad: f64,
    cell_rad: f64,
    /// Share of all bending up to the end of each cell.
    up_to: Vec<f64>,
}

impl Places {
    /// The density of a spline's points for samples of angle and torque: half of it is constant, half proportional to the root of the second
    /// derivative (C. de Boor, A Practical Guide to Splines, 1978, chapter XII). `None` where the angle does not change.
    pub(crate) fn of(samples: &(impl Iterator<Item = (f64, f64)> + Clone)) -> Option<Self> {
        let [lowest_rad, highest_rad] = range(samples.clone().map(|(angle_rad, _)| angle_rad));
        let cell_rad = (highest_rad - lowest_rad) / CELLS as f64;
        if !(cell_rad > 0.0 && cell_rad.is_finite()) {
            return None;
        }
        let mut sums = [[0.0, 0.0]; CELLS];
        for (angle_rad, torque_mnm) in samples.clone() {
            let [sum, count] = &mut sums[(((angle_rad - lowest_rad) / cell_rad) as usize).min(CELLS - 1)];
            (*sum, *count) = (*sum + torque_mnm, *count + 1.0);
        }
        let mut last = 0.0;
        let means = sums.map(|[sum, count]| {
            last = if count > 0.0 { sum / count } else { last };
            last
        });
        let mut bending = [0.0; CELLS];
        for at in 1..CELLS - 1 {
            bending[at] = (means[at - 1] - 2.0 * means[at] + means[at + 1]).abs().sqrt();
        }
        let even = (bending.iter().sum::<f64>() / CELLS as f64).max(f64::MIN_POSITIVE);
        let total = 2.0 * even * CELLS as f64;
        let mut up_to = 0.0;
        let grown = bending.iter().map(|bending| {
            up_to += (bending + even) / total;
            up_to
        });
        Some(Self { lowest_rad, cell_rad, up_to: grown.collect() })
    }

    /// Angles of `count` points, in rising order.
    fn points(&self, count: u16) -> Vec<f64> {
        let place = |point: u16| {
            let share = f64::from(point) / f64::from(count - 1);
            let cell = self.up_to.partition_point(|up_to| *up_to < share).min(CELLS - 1);
            let before = if cell == 0 { 0.0 } else { self.up_to[cell - 1] };
            let within = ((share - before) / (self.up_to[cell] - before)).clamp(0.0, 1.0);
            self.lowest_rad + self.cell_rad * (cell as f64 + within)
        };
        (0..count).map(place).collect()
    }
}

/// Torque over the angle, fitted together with a base.
pub(crate) struct Measured {
    /// The splines as effects.
    pub(crate) effects: Vec<Effect>,
    /// Their points with intervals.
    pub(crate) curves: Vec<MeasuredCurve>,
    /// All columns, those of the base first.
    pub(crate) columns: Vec<Vec<f64>>,
    /// The solution over them.
    pub(crate) solution: LeastSquares,
    /// Covariance of its coefficients.
    pub(crate) covariance: DMatrix<f64>,
}

/// The projection of columns on those of measured curves. The remainders of the other columns give the same coefficients and
/// covariance as a fit of all columns together (R. Frisch and F. V. Waugh, Econometrica 1, 1933, 387–401).
pub(crate) struct CurveProjection {
    pub(crate) points: Vec<Vec<f64>>,
    products: DMatrix<f64>,
}

impl CurveProjection {
    /// Projects on the points of measured curves; `both` is the column of a Coulomb friction equal
    /// in both directions, which is removed from the points of a measured friction.
    pub(crate) fn new(measured: &Measured, both: &[f64]) -> Self {
        let count: usize = measured.curves.iter().map(|curve| curve.points.len()).sum();
        let of_torque = measured.curves.first().map_or(0, |curve| curve.points.len());
        let square = square(both).max(f64::MIN_POSITIVE);
        let columns = measured.columns[measured.columns.len() - count..].iter().enumerate();
        let points: Vec<Vec<f64>> = columns
            .map(|(place, column)| {
                let mut column = column.clone();
                let share = if place < of_torque { 0.0 } else { dot(&column, both) / square };
                column.iter_mut().zip(both).for_each(|(value, both)| *value -= share * both);
                column
            })
            .collect();
        Self { products: vector::gram(&points), points }
    }

    /// The part of a column that the points cannot explain; zeros where only rounding is left.
    pub(crate) fn remainder(&self, column: &[f64]) -> Vec<f64> {
        let free = vec![false; self.points.len()];
        let left = LeastSquares::of_products(&self.points, &self.products, column, &free, &[], COLLINEAR).residual;
        if square(&left) > ROUNDING * square(column) { left } else { vec![0.0; column.len()] }
    }
}

/// Measures the torque over the angle beside the columns of a base: the mean of both directions and, with `both_ways`, the
/// variation of half their difference. The number of points minimises Schwarz's criterion (G. Schwarz, Ann. Statist. 6, 1978,
/// 461–464); `None` if there are too few rows for any number of points.
///
/// `rows` makes the columns of a spline's points; `noise` are the corrections for the noise in the base's columns.
pub(crate) fn measure(
    base: &[impl AsRef<[f64]>],
    nonnegative: &[bool],
    noise: &[Correction],
    target: &[f64],
    places: &Places,
    both_ways: bool,
    rows: impl Fn(&Spline) -> Vec<Vec<f64>>,
) -> Option<Measured> {
    let kinds = [&effects::angle_characteristic::KIND, &effects::friction_characteristic::KIND];
    let branches = if both_ways { &[1, 2][..] } else { &[1] };
    let tried = branches.iter().flat_map(|branches| POINTS.map(|count| (&kinds[..*branches], count)));
    let enough = |kinds: &[_], count: u16| usize::from(count) * kinds.len() * ROWS_PER_POINT <= target.len();
    let fitted = tried.filter(|(kinds, count)| enough(kinds, *count)).filter_map(|(kinds, count)| {
        let splines: Vec<Spline> =
            kinds.iter().map(|kind| Spline::through(kind, places.points(count), None)).collect::<Option<_>>()?;
        let points: Vec<Vec<f64>> = splines.iter().flat_map(&rows).collect();
        let share = |point: usize| if point < usize::from(count) { HELD } else { FRICTION_HELD };
        let corrections = [noise, &holds(base.len(), &points, share)].concat();
        let columns: Vec<Vec<f64>> = base.iter().map(|column| column.as_ref().to_vec()).chain(points).collect();
        let bounds: Vec<bool> =
            nonnegative.iter().copied().chain(std::iter::repeat(false)).take(columns.len()).collect();
        let solution = LeastSquares::corrected(&columns, target, &bounds, &corrections);
        let left = solution.squares();
        let criterion = {
            let (rows, fitted) = (target.len() as f64, solution.fitted() as f64);
            rows * (left / rows).max(f64::MIN_POSITIVE).ln() + fitted * rows.ln()
        };
        Some((criterion, splines, columns, solution))
    });
    let (_, splines, columns, solution) = fitted.min_by(|one, other| one.0.total_cmp(&other.0))?;
    let covariance = solution.robust_of_points(&columns, base.len());
    let mut first = base.len();
    let (mut effects, mut curves) = (Vec::new(), Vec::new());
    for spline in &splines {
        let range = first..first + spline.points.len();
        first = range.end;
        let torques_mnm = &solution.coefficients[range.clone()];
        let squares: Vec<f64> = range.clone().map(|at| dot(&columns[at], &columns[at])).collect();
        let shown = SHOWN * mean(&squares);
        let point = |(place, at): (usize, &f64)| {
            let (column, torque_mnm) = (range.start + place, torques_mnm[place]);
            let half = NORMAL_95 * covariance[(column, column)].max(0.0).sqrt();
            let known = squares[place] > shown && half.is_finite();
            CharacteristicPoint { at: *at, torque_mnm, ci95: known.then(|| interval(torque_mnm, half)) }
        };
        let points = spline.points.iter().enumerate().map(point).collect();
        curves.push(MeasuredCurve { effect: spline.kind.name, points });
        effects.push(spline.effect(torques_mnm)?);
    }
    Some(Measured { effects, curves, columns, solution, covariance })
}

/// Why a fit that measures the torque over the angle tells of no detents.
pub(crate) const NO_DETENTS: &str = "the torque over the angle was measured point by point instead";
