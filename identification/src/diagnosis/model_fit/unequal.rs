//! Detents with a place and a height each, fitted in the place of equal ones.
//!
//! From one angle at which the detents' torque vanishes to the next it is half a sine. A detent is two of them, equally wide
//! and high, either from one rest to the next or from one wall to the next; or each half sine has its own width and height. The heights are linear, the places
//! follow by Gauss–Newton from those of equal detents, beside all other columns.

use dynamics::effects;

use crate::diagnosis::capture::Capture;
use crate::diagnosis::findings::{UnequalDetent, Value};
use crate::diagnosis::model_fit::lobes::{Lobes, Unit};
use crate::diagnosis::model_fit::separable::Separable;
use crate::diagnosis::model_fit::structure::Structure;
use crate::numerics::statistics::{deviation_of_sum, interval, mean, student_95};
use crate::regression::characteristic::holds;
use crate::regression::least_squares::LeastSquares;
use crate::regression::refiner::{self, longest_improving};

/// Gauss–Newton steps.
const STEPS: usize = 12;
/// Gauss–Newton steps of what is searched beside the detents.
const ROUNDS: usize = 10;
/// Share of the sum of squares below which a step's gain is the last.
const SETTLED: f64 = 1e-4;
/// Ridge that holds a unit that the capture hardly shows at the mean height and at its place, as a share of the mean
/// unit's square.
const HELD: f64 = 1e-3;

/// Columns of the units' heights, and of their places at the present heights; every sample is multiplied by 1 + `more`.
fn columns_of(lobes: &Lobes, capture: &Capture, more: impl Fn(usize) -> f64 + Sync) -> Vec<Vec<f64>> {
    // A sample contributes to five of the many columns: only these are visited.
    capture.row_filter.rows_of(2 * lobes.units(), |range, columns| {
        columns.iter_mut().for_each(|column| column.fill(0.0));
        for (row, index) in range.enumerate() {
            let factor = 1.0 + more(index);
            for (column, derivative) in lobes.derivatives(capture.motion.angle_rad[index]) {
                columns[column][row] += factor * derivative;
            }
        }
    })
}

/// The structure with unequal detents in the place of its equal ones, fitted to the capture, and the sum of squares that it leaves; `None` if it
/// has none.
///
/// Peak and trough of a detent are equally high. Detents extend from rest to rest or from wall to wall, whichever leaves less.
pub(crate) fn structure(base: &Structure, capture: &Capture) -> Option<(Structure, f64)> {
    let index = base.position(effects::detent::KIND.name)?;
    let scene = capture.scene_of(base);
    let fitted = [Unit::BetweenRests, Unit::BetweenWalls].into_iter().filter_map(|unit| {
        let equal = Lobes::equal(unit, &base.effects[index], scene.lowest_rad, scene.highest_rad)?;
        fitted(equal, base, index, capture)
    });
    fitted.min_by(|one, other| one.1.total_cmp(&other.1))
}

/// The fit of a structure without coupling from where it stands, unequal detents included.
pub(crate) fn settled(structure: Structure, capture: &Capture) -> Separable<'_> {
    let structure = fitted_anew(&structure, capture, |lobes| lobes).unwrap_or(structure);
    Separable::new(structure, capture).refined(ROUNDS)
}

/// The structure fitted with a height and a place for each lobe, so that peaks and troughs differ; `None` without such detents.
pub(crate) fn asymmetric(structure: &Structure, capture: &Capture) -> Option<Structure> {
    fitted_anew(structure, capture, Lobes::each_by_itself)
}

fn fitted_anew(structure: &Structure, capture: &Capture, start: impl Fn(Lobes) -> Lobes) -> Option<Structure> {
    let index = structure.position(effects::unequal_detents::KIND.name)?;
    let (fitted, _) = fitted(start(Lobes::of(&structure.effects[index])?), structure, index, capture)?;
    // It keeps its place among the effects.
    let (effect, columns) = (*fitted.effects.last()?, *fitted.columns.last()?);
    Some(fitted.without(fitted.effects.len() - 1).with_at(index, effect, columns))
}

/// The structure with `lobes` in place of the detents at an index, fitted from their present places, and the sum of squares left.
fn fitted(mut lobes: Lobes, structure: &Structure, index: usize, capture: &Capture) -> Option<(Structure, f64)> {
    let range = structure.ranges()[index].clone();
    let whole = Separable::new(structure.clone(), capture);
    // Friction that grows with the load also grows with the detents' torque.
    let load_factor = whole.structure.load_factor(&capture.motion);
    let more = |at: usize| load_factor.as_ref().map_or(0.0, |factor| factor[at]);
    let (mut all, target) = whole.linearised(load_factor.as_deref());
    all.drain(range.clone());
    let rest_columns: Vec<&[f64]> = all.iter().map(AsRef::as_ref).collect();
    let mut nonnegative = whole.structure.nonnegative();
    nonnegative.drain(range);
    nonnegative.resize(rest_columns.len() + 2 * lobes.units(), false);
    let mut columns = columns_of(&lobes, capture, more);
    let solve = |lobes: &Lobes, columns: &[Vec<f64>]| solved(lobes, columns, &rest_columns, &target, &nonnegative);
    let heights_alone = |lobes: &Lobes, columns: &[Vec<f64>]| solve(lobes, &columns[..lobes.units()]);
    let mut squares = heights_alone(&lobes, &columns).squares();
    refiner::refine(STEPS, SETTLED, squares, |left| {
        let step = solve(&lobes, &columns).coefficients;
        let (heights_mnm, shifts_rad) = step[rest_columns.len()..].split_at(lobes.units());
        let better = longest_improving(0.4, |share| {
            let moved = lobes.moved(heights_mnm, shifts_rad, share)?;
            let columns = columns_of(&moved, capture, more);
            let now = heights_alone(&moved, &columns).squares();
            (now < left).then_some((now, moved, columns))
        });
        let (now, moved, moved_columns) = better?;
        (squares, lobes, columns) = (now, moved, moved_columns);
        Ok(now)
    });
    let heights = heights_alone(&lobes, &columns).coefficients;
    let lobes = lobes.with_heights(&heights[rest_columns.len()..]);
    Some((whole.structure.without(index).with(lobes.effect()?, 1), squares))
}

/// The detents of a fitted structure that the capture shows whole, one by one with their intervals.
pub(crate) fn detents(effect: &str, structure: &Structure, capture: &Capture) -> Vec<UnequalDetent> {
    let index = structure
        .position(effects::unequal_detents::KIND.name)
        .filter(|_| effect == effects::unequal_detents::KIND.name);
    let Some((index, lobes)) = index.and_then(|index| Some((index, Lobes::of(&structure.effects[index])?))) else {
        return Vec::new();
    };
    let rest = Separable::new(structure.without(index), capture);
    let of_lobes = columns_of(&lobes, capture, |_| 0.0);
    let columns: Vec<&[f64]> = of_lobes.iter().map(Vec::as_slice).chain(rest.columns()).collect();
    // The structure is at its optimum, so its residual is that of these columns too.
    let left = Separable::new(structure.clone(), capture).residual;
    let solved = LeastSquares::solve(&columns, &left);
    let covariance = solved.robust(&columns);
    let critical = student_95(covariance.degrees_of_freedom);
    let (count, units) = (lobes.lobes(), lobes.units());
    let place = |zero: usize, sign: f64| lobes.decided_by(zero).map(|(unit, by)| (units + unit, sign * by));
    let value = |value: f64, unit, parts: &[(usize, f64)]| {
        let mut derivatives = vec![0.0; columns.len()];
        parts.iter().for_each(|(column, by)| derivatives[*column] += *by);
        let half = critical * deviation_of_sum(&covariance.matrix, &derivatives);
        let known = parts.iter().all(|(column, _)| !solved.collinear[*column]) && half.is_finite();
        Value { value, unit, ci95: known.then(|| interval(value, half)) }
    };
    let scene = capture.scene_of(structure);
    let each = (0..count).step_by(2).filter_map(|lobe| {
        let (before, next) = ((lobe + count - 1) % count, (lobe + 2) % count);
        let rest_rad = lobes.zeros_rad[lobe];
        let pitch_rad = lobes.next_zero_rad(lobe + 1) - rest_rad;
        let turns = ((scene.lowest_rad - rest_rad + pitch_rad) / lobes.period_rad).ceil().max(0.0);
        let seen_rad = rest_rad + turns * lobes.period_rad;
        (seen_rad - 0.5 * pitch_rad >= scene.lowest_rad && seen_rad + pitch_rad <= scene.highest_rad).then(|| {
            UnequalDetent {
                rest: value(rest_rad, "rad", &place(lobe, 1.0)),
                pitch: value(pitch_rad, "rad", &[place(lobe, -1.0), place(next, 1.0)].concat()),
                peak: value(lobes.heights_mnm[lobe], "mNm", &[(lobes.unit_of(lobe), 1.0)]),
                trough: value(lobes.heights_mnm[before], "mNm", &[(lobes.unit_of(before), 1.0)]),
            }
        })
    });
    each.collect()
}

/// Solves for the rest's columns and those of the lobes; where the capture does not show a unit, its zeros are held at their
/// place and its height at the mean.
fn solved(lobes: &Lobes, columns: &[Vec<f64>], rest: &[&[f64]], target: &[f64], nonnegative: &[bool]) -> LeastSquares {
    let count = lobes.units();
    let mean_mnm = mean(&lobes.heights_mnm);
    let of_kind = columns.chunks(count).zip([mean_mnm, 0.0]).enumerate();
    let holds = of_kind.flat_map(|(kind, (columns, held_at))| {
        let mut holds = holds(rest.len() + kind * count, columns, |_| HELD);
        holds.iter_mut().for_each(|hold| hold.product = hold.square * held_at);
        holds
    });
    let all: Vec<&[f64]> = rest.iter().copied().chain(columns.iter().map(Vec::as_slice)).collect();
    LeastSquares::held(&all, target, &nonnegative[..all.len()], &holds.collect::<Vec<_>>())
}
