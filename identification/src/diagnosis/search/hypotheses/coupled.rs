//! The best fit of a coupling, whose inner body is simulated, and of one more effect beside a coupling.

use dynamics::effects::shaft_compliance;
use dynamics::{Effect, EffectKind, Part, Scene};
use rayon::prelude::*;

use super::coarse::Coarse;
use super::starts;
use crate::diagnosis::capture::Capture;
use crate::diagnosis::model_fit::bound::on_bound;
use crate::diagnosis::model_fit::nonlinear::Nonlinear;
use crate::diagnosis::model_fit::structure::Structure;
use crate::diagnosis::model_fit::{sticking, twist};
use crate::diagnosis::search::acceptance::{CLOSED, OPEN, WORTHWHILE};
use crate::diagnosis::search::judged::Judged;

/// Share of the band in which starts of a coupling are compared: there stiffness shows and ringing does not.
const SLOW: f64 = 0.25;
/// Starts of a coupling that are refined: as many of the best on slow motion and of the best on the whole band.
const STARTED: usize = 3;
/// Starts of a coupling that are refined in a thorough search.
const STARTED_THOROUGHLY: usize = 20;
/// A coupling that leaves at least this share of the squares of slow motion is not examined in the whole band.
const HOPELESS: f64 = 0.95;
/// Share by which values and sums of squares of two fits may differ for the fits to count as the same.
const ALIKE: f64 = 0.01;
/// A fit that leaves so many times the squares of the best one after a few steps is given up.
const LOSING: f64 = 2.0;
/// Index of the smaller version of an effect that is tried beside a coupling: of the detents' harmonics, the first three.
const SMALLER: usize = 2;
/// Effects that are tried in full beside a coupling.
const PROMISING: usize = 3;

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
pub(crate) fn fitted<'a>(
    kind: &'static EffectKind,
    base: &Structure,
    [train, heldout]: [&'a Capture; 2],
    effort: Effort,
) -> Option<Judged> {
    let scene = Scene { is_faint: effort == Effort::Fine, ..train.scene_of(base) };
    let effects = starts(kind, &scene)?;
    // The skew fitted without the coupling says nothing about the structure with one.
    let unskewed = Structure { skew_s: 0.0, shaft_is_simulated: false, ..base.clone() };
    if twist::is_shaft(kind) {
        // Most have nothing in front that would have to be found.
        let mut alone = effects.clone();
        alone.iter_mut().for_each(|shaft| shaft.values_mut()[shaft_compliance::OUTER_SHARE] = 0.0);
        alone.dedup();
        let alone = shaft(&alone, &unskewed, [train, heldout])?;
        if is_closed(&alone) {
            return Some(alone);
        }
        // Near the floor, a shaft between two inertias would gain evidence just by keeping noise from the inner inertia.
        let present = Judged::nonlinear(&Nonlinear::new(base.clone(), train), train, heldout);
        if present.most_over_floor() < OPEN {
            return Some(alone);
        }
        // With the outer share at the end of its range, the inner inertia is so small that it could have any value.
        let is_all = |shaft: &Effect| shaft.values()[shaft_compliance::OUTER_SHARE] >= shaft_compliance::LARGEST_SHARE;
        let between = shaft(&effects, &unskewed, [train, heldout])
            .filter(|judged| !judged.structure.effects.last().is_some_and(is_all));
        let is_within = |judged: &Judged| on_bound(&judged.structure, train).is_none();
        let better = between.filter(|judged| judged.evidence > alone.evidence && is_within(judged));
        return Some(better.unwrap_or(alone));
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
    // Fits that several starts lead to need not be refined twice.
    slow.dedup_by(|later, sooner| later.0 < (1.0 + ALIKE) * sooner.0 && later.1.is_like(&sooner.1, ALIKE));
    let mut slow = slow.into_iter().map(|(_, fit)| fit);
    // Most starts show soon that they lead nowhere.
    let begun = |fit: Option<Nonlinear<'a>>| fit.map(Nonlinear::refined_shortly);
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
        (fit, next) = rayon::join(|| fit.refined(), || begun(after));
        least = least.min(fit.squares());
        let judged = Judged::nonlinear(&fit, train, heldout);
        let is_closed = judged.train_over_floor() < CLOSED;
        let rank = (on_bound(&fit.structure, train).is_none(), judged.evidence);
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

fn is_closed(judged: &Judged) -> bool {
    judged.most_over_floor() < CLOSED
}

/// The best fit of a structure and a shaft, from its starts.
fn shaft(starts: &[Effect], base: &Structure, [train, heldout]: [&Capture; 2]) -> Option<Judged> {
    let behind = twist::fitted(starts, base, train)?;
    let simulated = Structure { shaft_is_simulated: true, ..behind.clone() };
    let refined = |structure| Judged::nonlinear(&Nonlinear::new(structure, train).refined(), train, heldout);
    let has_outer = behind.effects.last().is_some_and(|shaft| !shaft.is_absent(shaft_compliance::OUTER_SHARE));
    // Between two inertias, a twist computed from a noisy torque favours a sharp resonance: there only simulations are compared.
    let behind = (!has_outer).then(|| refined(behind));
    if behind.as_ref().is_some_and(is_closed) {
        return behind;
    }
    // Next to noise a shaft's damping hardly shows in its twist: a simulation also begins with that of the starts.
    let mut damped = simulated.clone();
    if let (Some(shaft), Some(start)) = (damped.effects.last_mut(), starts.first()) {
        shaft.values_mut()[1] = start.values()[1];
    }
    let (simulated, damped) = rayon::join(|| refined(simulated), || refined(damped));
    behind.into_iter().chain([simulated, damped]).max_by(|a, b| a.evidence.total_cmp(&b.evidence))
}

/// Fits of a structure with a coupling and one of the `kinds` more: those that promise most beside the present values'
/// own derivatives.
pub(crate) fn with_one_more(
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
        let width = hypothesis.nested.get(SMALLER).copied().unwrap_or(kind.columns_of_a_line());
        if kind.regressors.is_none() {
            // For friction of the load or a delay, only the simulation gives the derivatives.
            let structure = base.with(Effect::new(kind, &[]), width);
            let columns = Nonlinear::new(structure.clone(), train).tangents_of(base.effects.len());
            let nonnegative = [matches!(kind.part, Part::LoadFriction(_))];
            promising.push((coarse.gain_of(columns, &nonnegative).0, structure));
            continue;
        }
        let starts = starts(kind, &scene).unwrap_or_default();
        let gains = starts.into_par_iter().map(|mut effect| (coarse.gain_into(&mut effect, width), effect));
        let best = gains.max_by(|a, b| a.0.total_cmp(&b.0));
        promising.extend(best.map(|(gain, effect)| (gain, base.with(effect, width))));
    }
    promising.sort_by(|a, b| b.0.total_cmp(&a.0));
    promising.truncate(PROMISING);
    let fits = promising.into_par_iter().map(|(_, structure)| {
        let fit = Nonlinear::new(structure, train).refined();
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
    let indices = (0..structure.effects.len()).filter(|index| of_coupling(&structure.effects[*index]));
    fitted(kind, &structure.without_all(&indices.collect::<Vec<_>>()), captures, Effort::Full)?.with_newest(newest.name)
}
