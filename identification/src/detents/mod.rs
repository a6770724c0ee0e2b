//! Whether there are detents at all, and of which period.

pub(crate) mod angle_bins;

use dynamics::{Effect, effects};

use crate::estimate::Harmonic;
use crate::numerics::statistics::rms;
use crate::numerics::vector::{self, square};
use crate::preparation::band::Band;
use crate::regression::gram::held_out_evidence;
use crate::regression::least_squares::LeastSquares;
use crate::regression::problem::{Column, Problem, Searched};
use crate::regression::refiner::Ended;
use crate::sinusoids::scan::Scan;
use crate::sinusoids::{FEWEST_PERIODS, MARGIN, PREDICTS, threshold};

/// Peaks of the scan that are refined, at most, …
const CANDIDATES: usize = 3;
/// … if they explain at least this share of what the strongest explains.
const RIVAL: f64 = 0.5;
/// A detent must explain this share of the sum of squares that the rest of the model leaves …
const WORTHWHILE_SHARE: f64 = 0.25;
/// … or have this amplitude relative to the RMS of the torque: less is a ripple, felt by nobody.
const WORTHWHILE_AMPLITUDE: f64 = 0.1;
/// A detent must reduce the sum of squares by this many times the null test's reduction. The null test is the second best other
/// period in the residual beside the detent, since the best one may be a further true sinusoid …
const NULL_TEST: f64 = 2.0;
/// … and this many times where the travel holds few of its periods: then any bend in the torque looks like it.
const NULL_TEST_OF_FEW: f64 = 20.0;
/// Beside springs and gravity a detent must still reduce the sum of squares by this many times the null test's reduction there.
const BESIDE_BENDS: f64 = 10.0;
/// A spring of any stiffness up to the third power of its deflection, and gravity.
const BENDS: usize = 5;
/// Periods in the travel that are few.
const FEW_PERIODS: f64 = 3.0;
/// Multiple of the noise's variance that a harmonic in the residual must take off.
const HARMONIC_MARGIN: f64 = 14.0;
/// A harmonic explains at least this share of the residual's sum of squares.
const HARMONIC_SHARE: f64 = 0.01;
/// A harmonic is fitted if the scan shows at least what it must explain divided by this.
const HARMONIC_LOOK: f64 = 2.0;
/// Overtones are looked for up to this multiple of the detent.
const HIGHEST_OVERTONE: u32 = 12;
/// A period that explains less than this share, and whose first fit does not stand out, is refined no further.
const CLEARLY_NOT: f64 = 0.05;
/// A model that leaves less than this share of the torque has nothing left to explain.
const NOTHING_LEFT: f64 = 1e-9;
/// Aliases explain at least this share of what the best period explains.
const ALIAS: f64 = 0.9;

/// A problem solved, with detents or without.
pub(crate) struct Solved<'a> {
    pub(crate) problem: Problem<'a>,
    pub(crate) solution: LeastSquares,
    /// Why there are no detents.
    pub(crate) no_detents: Option<String>,
    /// Other periods that explain nearly as much.
    pub(crate) aliases_rad: Vec<f64>,
    pub(crate) harmonics: Vec<Harmonic>,
    /// Whether the detents' period was still moving when its search ended.
    pub(crate) is_unsettled: bool,
}

/// Searches all periods that the travel supports, refines the strongest and weighs the evidence; the error says why no detents
/// can be identified.
pub(crate) fn search<'a>(
    base: &Problem<'a>,
    base_solution: &LeastSquares,
    band: &Band,
    angle_step_rad: f64,
) -> Result<Solved<'a>, String> {
    let left = base_solution.squares();
    if left.sqrt() <= NOTHING_LEFT * square(&base.target).sqrt() {
        return Err("the knob has no detents: inertia and friction explain the whole torque".to_owned());
    }
    let Some(scan) = Scan::new(base, &base_solution.inverse, band, angle_step_rad) else {
        return Err(format!(
            "the travel is too small to identify detents: it must hold at least {FEWEST_PERIODS} periods; sweep wider"
        ));
    };
    let (longest, shortest) = scan.periods_rad();
    let powers = scan.powers(base, &base_solution.residual);
    let peaks = scan.peaks(&powers, 12);
    let resolution = scan.resolution();
    let limit = |which: Searched, value: f64| {
        let most = 0.1 * value.abs();
        if which.effect == base.effects.len() { most.min(0.25 * resolution * value * value) } else { most }
    };
    let best_power = peaks.first().map_or(0.0, |peak| peak.power);
    let best = peaks
        .iter()
        .take(CANDIDATES)
        .filter(|peak| peak.power > RIVAL * best_power)
        .map(|peak| {
            let mut problem = base.clone();
            problem.add(Effect::new(&effects::detent::KIND, &[0.0, 1.0 / peak.wavenumber, 0.0]));
            let solution = problem.refine(2, limit);
            (solution.squares(), problem, solution)
        })
        .min_by(|a, b| a.0.total_cmp(&b.0));
    let Some((close, mut problem, solution)) = best else {
        return Err(no_detents(longest, shortest));
    };
    let needed = threshold(scan.independent(), MARGIN);
    let rough = needed * scan.background(&powers, 1.0 / problem.effects[problem.effects.len() - 1].values()[1]);
    if 1.5 * (left - close) < rough && left - close < CLEARLY_NOT * left {
        return Err(no_detents(longest, shortest));
    }
    let (solution, ended) = problem.refine_from(solution, 12, limit);
    let detent = problem.effects.len() - 1;
    let period_rad = problem.effects[detent].values()[1];
    let range = problem.range(detent);
    let amplitude_mnm = solution.coefficients[range.start].hypot(solution.coefficients[range.start + 1]);
    let after = solution.squares();
    let share = 1.0 - after / left;
    let detents = &problem.columns[range.clone()];
    // The background is read with the detent taken out; otherwise the detent's side lobes would raise it.
    let rest = scan.powers(base, &solution.residual);
    let background = scan.background(&rest, 1.0 / period_rad);
    let clear = left - after > needed * background;
    let predicts = held_out_evidence(&problem.columns, range.start, &problem.target) > PREDICTS;
    let periods = 1.0 / (period_rad * resolution);
    let few = periods < FEW_PERIODS;
    let null_test = scan.null_test(&rest, 1.0 / period_rad, if few { 0.0 } else { FEW_PERIODS });
    if clear && !(predicts && left - after > if few { NULL_TEST_OF_FEW } else { NULL_TEST } * null_test) {
        return Err(format!(
            "no detents that can be distinguished from other variation of the torque: the best period (P {period_rad:.4} rad, \
             {periods:.1} of them in the travel) {}; sweep wider, so that the travel holds more of them",
            if predicts {
                format!("takes away only {:.1} times what other periods do", (left - after) / null_test)
            } else {
                "does not predict stretches that it was not fitted to".to_owned()
            }
        ));
    }
    if clear && is_bend(base, &scan, detents, 1.0 / period_rad) {
        return Err(format!(
            "no detents that can be distinguished from a spring or from gravity, which leave nothing of the torque's \
             variation with the angle that the best period (P {period_rad:.4} rad, {periods:.1} of them in the travel) would explain; diagnose \
             the capture, or sweep wider, so that the travel holds more periods"
        ));
    }
    let inside = period_rad < 1.2 * longest && period_rad > 0.0 && amplitude_mnm.is_finite();
    if !clear || !inside {
        return Err(no_detents(longest, shortest));
    }
    if share < WORTHWHILE_SHARE && amplitude_mnm < WORTHWHILE_AMPLITUDE * rms(&problem.target) {
        return Err(format!(
            "the knob has no detents worth the name: the strongest torque that repeats with the angle (amplitude \
             {amplitude_mnm:.3} mNm, P {period_rad:.6} rad) is a ripple that explains only {:.0} % of what inertia and \
             friction leave",
            100.0 * share
        ));
    }
    let aliases_rad = peaks
        .iter()
        .filter(|peak| {
            peak.power > ALIAS * best_power && (peak.wavenumber - 1.0 / period_rad).abs() > 0.75 * resolution
        })
        .map(|peak| 1.0 / peak.wavenumber)
        .collect();
    let evident = |order: u32, needed: f64| {
        scan.near(&rest, f64::from(order) / period_rad).is_none_or(|power| HARMONIC_LOOK * power > needed)
    };
    let harmonics = harmonics(&problem, &solution, [period_rad, shortest], background, evident);
    let is_unsettled = ended == Ended::OutOfSteps;
    Ok(Solved { problem, solution, no_detents: None, aliases_rad, harmonics, is_unsettled })
}

/// Whether a detent of `wavenumber` with the columns `detent` explains little once springs and gravity are fitted too.
fn is_bend(base: &Problem<'_>, scan: &Scan, detent: &[Column], wavenumber: f64) -> bool {
    let bends = bends(base);
    let residual = |columns: &[&[Column]]| LeastSquares::solve(&columns.concat(), &base.target).residual;
    let (without, with) = (residual(&[&base.columns, &bends]), residual(&[&base.columns, &bends, detent]));
    let left = square(&with);
    let explained = square(&without) - left;
    let null_test = || scan.null_test(&scan.powers(base, &with), wavenumber, 0.0);
    // The null test is at most `left`, so it need not be computed where the detent explains `BESIDE_BENDS` times `left`.
    explained < BESIDE_BENDS * left && explained < BESIDE_BENDS * null_test()
}

/// Rows of x, x² and x³, with x the position within the travel from −1 to 1, and of the angle's sine and cosine: torques that bend over
/// the travel and are no detents.
fn bends(problem: &Problem<'_>) -> Vec<Column> {
    let Problem { row_filter, motion, .. } = problem;
    let (lowest, highest) = vector::extent_where(&motion.angle_rad, &row_filter.mask).unwrap_or((0.0, 0.0));
    let (middle, half) = (0.5 * (lowest + highest), 0.5 * (highest - lowest));
    let rows = row_filter.rows_of(BENDS, |range, columns| {
        let angles = &motion.angle_rad[range];
        let (powers, turn) = columns.split_at_mut(BENDS - 2);
        for (power, column) in (1..).zip(powers) {
            column.iter_mut().zip(angles).for_each(|(slot, angle)| *slot = ((angle - middle) / half).powi(power));
        }
        if let [sine, cosine] = turn {
            vector::sines(angles, 1.0, sine, cosine);
        }
    });
    rows.into_iter().map(Column::from).collect()
}

fn no_detents(longest: f64, shortest: f64) -> String {
    format!(
        "no detents: no torque that repeats with the angle stands out for any period P between {shortest:.4} and \
         {longest:.4} rad, which is what the travel and the speed of the sweep can show"
    )
}

/// The overtones in the residual that stand out and predict stretches of the capture that they were not fitted to.
///
/// `evident` tells whether the scan shows enough at an order for a closer look, given what the order must explain, mNm².
fn harmonics(
    problem: &Problem<'_>,
    solution: &LeastSquares,
    [period_rad, shortest_rad]: [f64; 2],
    background: f64,
    evident: impl Fn(u32, f64) -> bool,
) -> Vec<Harmonic> {
    let mut total = solution.squares();
    let mut found: Vec<(Harmonic, Vec<Column>)> = Vec::new();
    let orders = (2..=HIGHEST_OVERTONE).take_while(|order| period_rad / f64::from(*order) >= shortest_rad);
    for order in orders {
        let needed = (HARMONIC_MARGIN * background).max(HARMONIC_SHARE * total);
        if !evident(order, needed) {
            continue;
        }
        let effect = Effect::new(&effects::detent::KIND, &[0.0, period_rad / f64::from(order), 0.0]);
        let own: Vec<Column> =
            problem.row_filter.effect_rows(&effect, problem.motion).into_iter().map(Column::from).collect();
        let rows: Vec<Column> = found.iter().flat_map(|(_, rows)| rows).chain(&own).cloned().collect();
        let (columns, with) = problem.solve_with(&rows);
        let [.., sine, cosine] = with.coefficients[..] else { continue };
        let left = with.squares();
        let gain = total - left;
        if gain < needed || held_out_evidence(&columns, columns.len() - own.len(), &problem.target) < PREDICTS {
            continue;
        }
        let harmonic = Harmonic {
            order: Some(order),
            per_turn: f64::from(order) / period_rad,
            amplitude_mnm: sine.hypot(cosine),
            phase_rad: cosine.atan2(sine),
            explains_percent: 100.0 * gain / total,
            ..Harmonic::default()
        };
        total = left;
        found.push((harmonic, own));
    }
    let mut harmonics: Vec<Harmonic> = found.into_iter().map(|(harmonic, _)| harmonic).collect();
    harmonics.sort_by(|a, b| b.amplitude_mnm.total_cmp(&a.amplitude_mnm));
    harmonics
}
