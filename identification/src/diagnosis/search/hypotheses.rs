//! Every effect of the catalogue that could be added to a structure, from its starts to its best fit.

use dynamics::effects::{self, cogging, end_stop};
use dynamics::{Effect, EffectKind, Hypothesis, Motion, Part, Scene};
use rayon::prelude::*;

use crate::diagnosis::capture::Capture;
use crate::diagnosis::model_fit::nonlinear::Nonlinear;
use crate::diagnosis::model_fit::separable::Separable;
use crate::diagnosis::model_fit::sticking;
use crate::diagnosis::model_fit::structure::Structure;
use crate::diagnosis::model_fit::twist;
use crate::diagnosis::search::acceptance::WORTHWHILE;
use crate::diagnosis::search::judged::Judged;
use crate::numerics::vector::{dot, subtract};
use crate::regression::least_squares::LeastSquares;

/// Starts of a separable hypothesis that are refined.
const REFINED: usize = 2;
/// Gauss–Newton steps for each.
const ROUNDS: usize = 6;
/// Share of the band in which starts of a coupling are compared: there stiffness shows and ringing does not.
const SLOW: f64 = 0.25;
/// Starts of a coupling that are refined: as many of the best on slow motion and of the best on the whole band.
const STARTED: usize = 3;
/// Starts of a coupling that are refined in a thorough search.
const STARTED_THOROUGHLY: usize = 20;
/// Share of the squares of slow motion that a coupling must not leave to be looked at in the whole band.
const HOPELESS: f64 = 0.95;
/// A gap this close to the floor is closed, in floors.
pub(crate) const CLOSED: f64 = 1.12;
/// A fit that leaves more than this is clearly louder than noise, and may lack a stick limit, in floors.
pub(crate) const OPEN: f64 = 1.6;
/// Share by which values and sums of squares may differ of fits that are the same.
const ALIKE: f64 = 0.01;
/// A fit that leaves so many times the squares of the best one after a few steps is given up.
const LOSING: f64 = 2.0;
/// Effects that are tried in full beside a coupling.
const PROMISING: usize = 3;

/// The effects that could be added to a structure.
pub(crate) fn candidates(structure: &Structure) -> Vec<&'static EffectKind> {
    let coupled = structure.is_coupled();
    effects::ALL
        .into_iter()
        .filter(|kind| {
            kind.hypothesis.is_some()
                && structure.position(kind.name).is_none()
                && !(coupled && matches!(kind.part, Part::Coupling(_) | Part::Bristles(_)))
        })
        .collect()
}

/// The best fit of a structure without coupling and an effect of `kind` more; `None` if this capture could not show it.
///
/// It is refined if its start takes off at least the `promising` share of what is left above the floor.
pub(crate) fn separable<'a>(
    kind: &'static EffectKind,
    base: &Separable<'a>,
    heldout: &Capture,
    promising: f64,
) -> Option<Judged> {
    let train = base.capture;
    let hypothesis = kind.hypothesis?;
    let grid = grid(kind, &hypothesis, &train.scene_of(&base.structure))?;
    let width = hypothesis.nested.last().copied().unwrap_or(kind.columns_of_a_line());
    let coarse = (grid.len() > 1 && pointwise(kind)).then(|| Coarse::of(base));
    let starts = grid.par_iter().map(|point| {
        let effect = effect_at(kind, &hypothesis, point);
        let gain = match (&coarse, kind.part) {
            (Some(coarse), _) => coarse.gain(&effect),
            (None, Part::ReadingDelay(delay)) => base.squares() - base.squares_if_late(delay(effect.values())),
            _ => base.squares() - base.with(effect, width).squares(),
        };
        (gain, effect)
    });
    let mut starts: Vec<(f64, Effect)> = starts.collect();
    starts.sort_by(|a, b| b.0.total_cmp(&a.0));
    starts.truncate(REFINED);
    // One start only, or one that acts on what was before, says little of what it leads to.
    if coarse.is_some() && starts.first().is_some_and(|(gain, _)| *gain < promising * base.squares_above_floor()) {
        let (_, start) = starts.swap_remove(0);
        return Some(Judged::separable(&base.with(start, kind.columns_of_a_line()), heldout));
    }
    let refined = starts.into_iter().map(|(_, effect)| {
        let mut fit = base.with(effect, width);
        fit.refine_newest(ROUNDS);
        fit
    });
    let mut best: Separable<'a> = refined.min_by(|a, b| a.squares().total_cmp(&b.squares()))?;
    if kind.name == end_stop::KIND.name {
        best = one_sided(best, base);
    }
    let effect = *best.structure.effects.last()?;
    let smaller = hypothesis.nested.iter().filter(|columns| **columns < width).map(|columns| {
        let mut fit = base.with(effect, *columns);
        fit.refine_newest(2);
        Judged::separable(&fit, heldout)
    });
    let mut fitted: Vec<Judged> = smaller.chain([Judged::separable(&best, heldout)]).collect();
    let mut lines = best;
    while let Some(more) = with_a_line_more(&lines) {
        let judged = Judged::separable(&more, heldout);
        if fitted.iter().any(|fewer| fewer.evidence > judged.evidence) {
            break;
        }
        fitted.push(judged);
        lines = more;
    }
    fitted.into_iter().max_by(|a, b| a.evidence.total_cmp(&b.evidence))
}

/// The fit of stops without the one that explains less than its place and its stiffness cost: it could imitate what is still missing.
fn one_sided<'a>(both: Separable<'a>, base: &Separable<'a>) -> Separable<'a> {
    let index = base.structure.effects.len();
    let (stops, columns) = (both.structure.effects[index], both.structure.columns[index]);
    let sides = end_stop::one_sided(&stops, base.capture.scene()).map(|stop| {
        let mut fit = base.with(stop, columns);
        fit.refine_newest(ROUNDS);
        fit
    });
    let weight = base.capture.weight;
    let is_as_good = |fit: &Separable<'_>| 0.5 * weight * (fit.squares() / both.squares()).ln() < weight.ln();
    let best = sides.into_iter().min_by(|one, other| one.squares().total_cmp(&other.squares()));
    best.filter(is_as_good).unwrap_or(both)
}

/// The fit with the last effect's law once more, where what is left shows it best; `None` if it cannot occur again.
fn with_a_line_more<'a>(fit: &Separable<'a>) -> Option<Separable<'a>> {
    let index = fit.structure.effects.len().checked_sub(1)?;
    let (effect, columns) = (fit.structure.effects[index], fit.structure.columns[index]);
    let (kind, used) = (effect.kind(), effect.kind().parameters_in(columns));
    // The first line is the detents where there are none; others are found beside these.
    let may_have_more = used < kind.parameters.len() && fit.structure.has_detents();
    let hypothesis = kind.hypothesis.filter(|hypothesis| hypothesis.lines > 1 && may_have_more)?;
    let coarse = Coarse::of(fit);
    let probes = grid(kind, &hypothesis, &fit.capture.scene_of(&fit.structure))?;
    let probes = probes.iter().map(|point| effect_at(kind, &hypothesis, point));
    let (_, probe) = probes.map(|probe| (coarse.gain(&probe), probe)).max_by(|a, b| a.0.total_cmp(&b.0))?;
    let mut more = effect;
    let each = kind.parameters_of_a_line();
    more.values_mut()[used..used + each].copy_from_slice(&probe.values()[..each]);
    let mut fit =
        Separable::new(fit.structure.without(index).with(more, columns + kind.columns_of_a_line()), fit.capture);
    fit.refine_newest(ROUNDS);
    let per_turn = fit.structure.effects[index].values()[used + 1];
    (!cogging::is_of_the_detents(per_turn, &fit.capture.scene_of(&fit.structure))).then_some(fit)
}

/// How far the fit of a coupling goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Effort {
    /// Values only.
    Short,
    /// What the inner body bears at rest is looked for too, if much is left.
    Full,
    /// The same from starts that lie close together, for what is hardly louder than noise.
    Fine,
    /// The same from more of the starts.
    Thorough,
}

/// The best fit of a structure and a coupling of `kind` to the first capture, judged by both.
pub(crate) fn coupled<'a>(
    kind: &'static EffectKind,
    base: &Structure,
    [train, heldout]: [&'a Capture; 2],
    effort: Effort,
) -> Option<Judged> {
    let hypothesis = kind.hypothesis?;
    let scene = Scene { is_faint: effort == Effort::Fine, ..train.scene_of(base) };
    let grid = grid(kind, &hypothesis, &scene)?;
    let effects: Vec<Effect> = grid.iter().map(|point| effect_at(kind, &hypothesis, point)).collect();
    // The skew that the structure needed without the coupling tells nothing.
    let unskewed = Structure { skew_s: 0.0, shaft_is_simulated: false, ..base.clone() };
    if twist::is_shaft(kind) {
        let behind = twist::fitted(&effects, &hypothesis, &unskewed, train)?;
        // Of a higher resonance the band has the first rise only: next to noise, a sensor's own resonance makes as much.
        if scene.is_faint && !twist::resonates_in_band(&behind, train) {
            return None;
        }
        let simulated = Structure { shaft_is_simulated: true, ..behind.clone() };
        let refined = |structure| {
            let mut fit = Nonlinear::new(structure, train);
            fit.refine();
            Judged::nonlinear(&fit, train, heldout)
        };
        let behind = refined(behind);
        if behind.most_over_floor() < CLOSED {
            return Some(behind);
        }
        return [behind, refined(simulated)].into_iter().max_by(|a, b| a.evidence.total_cmp(&b.evidence));
    }
    let structures: Vec<Structure> = effects.iter().map(|effect| unskewed.with(*effect, 0)).collect();
    let fits = Nonlinear::all(&structures, train).into_iter();
    let mut starts: Vec<(f64, f64, Nonlinear<'_>)> =
        fits.map(|fit| (fit.slow_squares(SLOW), fit.squares(), fit)).collect();
    // The best starts on slow motion, and the best on the whole band among the others.
    starts.sort_by(|a, b| a.0.total_cmp(&b.0));
    let first = starts.len().min(STARTED);
    starts[first..].sort_by(|a, b| a.1.total_cmp(&b.1));
    starts.truncate(if effort == Effort::Thorough { STARTED_THOROUGHLY } else { 2 * STARTED });
    let present = Nonlinear::new(unskewed, train);
    let is_coarse = present.leaves_much();
    let present = present.slow_squares(SLOW);
    let refined = starts.par_iter().filter_map(|(_, _, start)| {
        let mut fit = start.clone();
        fit.refine_slow(is_coarse);
        let left = fit.slow_squares(SLOW);
        (left < HOPELESS * present).then_some((left, fit))
    });
    let mut slow: Vec<(f64, Nonlinear<'_>)> = refined.collect();
    slow.sort_by(|a, b| a.0.total_cmp(&b.0));
    // What other starts led to as well need not be refined twice.
    slow.dedup_by(|later, sooner| later.0 < (1.0 + ALIKE) * sooner.0 && later.1.is_like(&sooner.1, ALIKE));
    let mut slow = slow.into_iter().map(|(_, fit)| fit);
    // Most starts show soon that they lead nowhere.
    let begun = |fit: Option<Nonlinear<'a>>| {
        fit.map(|mut fit| {
            fit.refine_shortly();
            fit
        })
    };
    // Several valleys may be as deep where the first capture hardly shows the contact: both captures choose, among those that do not end on
    // a bound.
    let mut best: Option<((bool, f64), Judged, Nonlinear<'_>)> = None;
    let mut least = f64::INFINITY;
    let mut next = begun(slow.next());
    while let Some(mut fit) = next {
        let after = slow.next();
        if fit.squares() > LOSING * least {
            next = begun(after);
            continue;
        }
        ((), next) = rayon::join(|| fit.refine(), || begun(after));
        least = least.min(fit.squares());
        let judged = Judged::nonlinear(&fit, train, heldout);
        let is_closed = judged.train_over_floor() < CLOSED;
        let rank = (Nonlinear::on_bound(&fit.structure, train).is_none(), judged.evidence);
        if judged.is_finite() && best.as_ref().is_none_or(|(best, ..)| rank > *best) {
            best = Some((rank, judged, fit));
        }
        if is_closed {
            break;
        }
    }
    let (_, judged, fit) = best?;
    if effort == Effort::Short || judged.train_over_floor() < OPEN {
        return Some(judged);
    }
    let stuck = sticking::fitted(&fit, train).map(|stuck| Judged::nonlinear(&stuck, train, heldout));
    stuck.into_iter().chain([judged]).max_by(|a, b| a.evidence.total_cmp(&b.evidence))
}

/// Fits of a structure with a coupling and one of the `kinds` more: those that promise most beside the present values'
/// own derivatives.
pub(crate) fn with_coupling(
    kinds: &[&'static EffectKind],
    base: &Structure,
    train: &Capture,
    heldout: &Capture,
) -> Vec<Judged> {
    let present = Nonlinear::new(base.clone(), train);
    let tangents = present.tangents(1.0);
    let coarse = Coarse::new(train, base, &tangents.iter().map(Vec::as_slice).collect::<Vec<_>>(), &present.residual);
    let scene = train.scene_of(base);
    let mut promising: Vec<(f64, Structure)> = Vec::new();
    for kind in kinds {
        let Some(hypothesis) = kind.hypothesis else { continue };
        let width = hypothesis.nested.get(2).copied().unwrap_or(kind.columns_of_a_line());
        if kind.regressors.is_none() {
            // Friction of the load, or a delay: what it would do shows in the simulation alone.
            let structure = base.with(Effect::new(kind, &[]), width);
            let columns = Nonlinear::new(structure.clone(), train).tangents_of(base.effects.len());
            let nonnegative = [matches!(kind.part, Part::LoadFriction(_))];
            promising.push((coarse.gain_of(columns, &nonnegative).0, structure));
            continue;
        }
        let starts = grid(kind, &hypothesis, &scene).unwrap_or_default();
        let best = starts
            .par_iter()
            .map(|point| {
                let mut effect = effect_at(kind, &hypothesis, point);
                (coarse.gain_into(&mut effect), effect)
            })
            .max_by(|a, b| a.0.total_cmp(&b.0));
        promising.extend(best.map(|(gain, effect)| (gain, base.with(effect, width))));
    }
    promising.sort_by(|a, b| b.0.total_cmp(&a.0));
    promising.truncate(PROMISING);
    let fits = promising.into_par_iter().map(|(_, structure)| {
        let mut fit = Nonlinear::new(structure, train);
        fit.refine();
        let judged = Judged::nonlinear(&fit, train, heldout);
        // Where a body breaks away, a torque more changes everything: then the coupling is looked for anew beside it.
        let gains = base.sticks() && fit.squares() < (1.0 - WORTHWHILE) * present.squares();
        let anew = if gains { coupled_anew(&judged.structure, [train, heldout]) } else { None };
        anew.into_iter().chain([judged]).max_by(|a, b| a.evidence.total_cmp(&b.evidence))
    });
    fits.flatten().collect()
}

/// The best fit of a coupled structure that was found from the starts of its coupling, the last effect staying last.
fn coupled_anew(structure: &Structure, captures: [&Capture; 2]) -> Option<Judged> {
    let of_coupling = |effect: &Effect| matches!(effect.kind().part, Part::Coupling(_) | Part::Stick(_));
    let kind = structure.effects.iter().find(|effect| matches!(effect.kind().part, Part::Coupling(_)))?.kind();
    let newest = structure.effects.last()?.kind();
    let indices = (0..structure.effects.len()).rev().filter(|index| of_coupling(&structure.effects[*index]));
    let bare = indices.fold(structure.clone(), |bare, index| bare.without(index));
    coupled(kind, &bare, captures, Effort::Full)?.with_newest(newest.name)
}

/// All combinations of the searched parameters' starts, the law occurring once; `None` if the capture cannot show one of
/// them.
fn grid(kind: &EffectKind, hypothesis: &Hypothesis, scene: &Scene) -> Option<Vec<Vec<f64>>> {
    let mut grid: Vec<Vec<f64>> = vec![Vec::new()];
    let of_a_line = kind.parameters_of_a_line();
    for search in hypothesis.searched.iter().filter(|search| search.parameter < of_a_line) {
        let values = search.values(scene);
        if values.is_empty() {
            return None;
        }
        grid = grid
            .into_iter()
            .flat_map(|point| values.iter().map(move |value| point.iter().copied().chain([*value]).collect()))
            .collect();
    }
    if kind.name == cogging::KIND.name {
        grid.retain(|point| !cogging::is_of_the_detents(point[0], scene));
    }
    Some(grid)
}

fn effect_at(kind: &'static EffectKind, hypothesis: &Hypothesis, point: &[f64]) -> Effect {
    let mut effect = Effect::new(kind, &[]);
    for (search, value) in hypothesis.searched.iter().zip(point) {
        effect.values_mut()[search.parameter] = *value;
    }
    effect
}

/// Whether the effect's columns at one moment depend on that moment alone.
fn pointwise(kind: &EffectKind) -> bool {
    matches!(
        kind.part,
        Part::Torque(_) | Part::Reading(_) | Part::Friction(_) | Part::CoulombFactor(_) | Part::FrictionFactor(_)
    )
}

/// What a further effect would explain, judged at the rows' middles without filtering: enough to choose starts.
struct Coarse {
    motions: Vec<(Motion, f64)>,
    /// Friction at the rows, for what modulates it, mNm.
    friction: [Vec<f64>; 2],
    /// Orthonormal columns of the present structure.
    basis: Vec<Vec<f64>>,
    residual: Vec<f64>,
}

impl Coarse {
    fn of(current: &Separable<'_>) -> Self {
        Self::new(current.capture, &current.structure, &current.columns(), &current.residual)
    }

    /// `columns` are the directions in which the present structure can move.
    fn new(capture: &Capture, structure: &Structure, columns: &[&[f64]], residual: &[f64]) -> Self {
        let thin = |coulomb_only| {
            let rows = (0..capture.motion.len()).step_by(capture.row_filter.step);
            rows.map(structure.friction_mnm(&capture.motion, coulomb_only)).collect()
        };
        let mut basis: Vec<Vec<f64>> = Vec::new();
        for column in columns {
            let mut left = column.to_vec();
            let before = dot(&left, &left);
            for known in &basis {
                let share = dot(known, &left);
                subtract(&mut left, share, known);
            }
            let after = dot(&left, &left);
            if after > 1e-8 * before {
                left.iter_mut().for_each(|value| *value /= after.sqrt());
                basis.push(left);
            }
        }
        Self { motions: capture.row_motions(), friction: [thin(false), thin(true)], basis, residual: residual.to_vec() }
    }

    /// By how much the effect's columns would lower the sum of squares, mNm².
    fn gain(&self, effect: &Effect) -> f64 {
        self.gain_into(&mut effect.clone())
    }

    /// The same; writes the coefficients into the effect's values.
    fn gain_into(&self, effect: &mut Effect) -> f64 {
        let Some(regressors) = effect.kind().regressors else { return 0.0 };
        let factor = match effect.kind().part {
            Part::FrictionFactor(_) => Some(&self.friction[0]),
            Part::CoulombFactor(_) => Some(&self.friction[1]),
            _ => None,
        };
        // A further line of the law does not occur yet.
        let mut columns = vec![vec![0.0; self.motions.len()]; effect.kind().columns_of_a_line()];
        let mut row = [0.0; dynamics::MAX_PARAMETERS];
        for (index, (motion, mask)) in self.motions.iter().enumerate().filter(|(_, (_, mask))| *mask != 0.0) {
            (regressors.fill)(effect, motion, &mut row[..regressors.columns]);
            let weight = mask * factor.map_or(1.0, |friction| friction[index]);
            columns.iter_mut().zip(row).for_each(|(column, value)| column[index] = weight * value);
        }
        let nonnegative: Vec<bool> = (0..columns.len()).map(|c| regressors.nonnegative.contains(&c)).collect();
        let (gain, coefficients) = self.gain_of(columns, &nonnegative);
        let mut all = vec![0.0; regressors.columns];
        all[..coefficients.len()].copy_from_slice(&coefficients);
        (regressors.values)(&all, effect.values_mut());
        gain
    }

    /// By how much columns would lower the sum of squares, mNm², and their coefficients.
    fn gain_of(&self, mut columns: Vec<Vec<f64>>, nonnegative: &[bool]) -> (f64, Vec<f64>) {
        for column in &mut columns {
            for known in &self.basis {
                let share = dot(known, column);
                subtract(column, share, known);
            }
        }
        let solved = LeastSquares::held(&columns, &self.residual, nonnegative, &[]);
        (dot(&self.residual, &self.residual) - dot(&solved.residual, &solved.residual), solved.coefficients)
    }
}
