//! The best fit of one more effect where only a few searched parameters are nonlinear.

use dynamics::effects::{cogging, end_stop};
use dynamics::{Effect, EffectKind, Part};
use rayon::prelude::*;

use super::coarse::Coarse;
use super::starts;
use crate::diagnosis::capture::Capture;
use crate::diagnosis::model_fit::bound::on_bound;
use crate::diagnosis::model_fit::separable::Separable;
use crate::diagnosis::search::judged::Judged;

/// Starts of a separable hypothesis that are refined.
const REFINED: usize = 2;
/// Gauss–Newton steps for each.
const ROUNDS: usize = 6;

/// The best fit of a structure without coupling and one more effect of `kind`; `None` if this capture could not show it.
///
/// It is refined if its start takes off at least the `promising` share of what is left above the floor.
pub(crate) fn fitted<'a>(
    kind: &'static EffectKind,
    base: &Separable<'a>,
    heldout: &Capture,
    promising: f64,
) -> Option<Judged> {
    let train = base.capture;
    let hypothesis = kind.hypothesis?;
    let starts = starts(kind, &train.scene_of(&base.structure))?;
    let width = hypothesis.nested.last().copied().unwrap_or(kind.columns_of_a_line());
    let coarse = (starts.len() > 1 && pointwise(kind)).then(|| Coarse::of(base));
    let starts = starts.into_par_iter().map(|effect| {
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
    // The gain of a start says little about the refined fit if it is the only start, or if the effect has a memory.
    if coarse.is_some() && starts.first().is_some_and(|(gain, _)| *gain < promising * base.squares_above_floor()) {
        let (_, start) = starts.swap_remove(0);
        return Some(Judged::separable(&base.with(start, kind.columns_of_a_line()), heldout));
    }
    let refined = starts.into_iter().map(|(_, effect)| base.with(effect, width).newest_refined(ROUNDS));
    let mut best: Separable<'a> = refined.min_by(|a, b| a.squares().total_cmp(&b.squares()))?;
    if kind.name == end_stop::KIND.name {
        best = one_sided(best, base);
    }
    let effect = *best.structure.effects.last()?;
    let smaller = hypothesis.nested.iter().filter(|columns| **columns < width);
    let smaller = smaller.map(|columns| Judged::separable(&base.with(effect, *columns).newest_refined(2), heldout));
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
    // A damper without a spring is no stop.
    let is_possible =
        |judged: &Judged| judged.structure.effects.last().is_some_and(|stop| end_stop::absent_sides(stop) < 2);
    let possible = fitted.iter().any(is_possible);
    fitted.retain(|judged| is_possible(judged) == possible);
    fitted.into_iter().max_by(|a, b| a.evidence.total_cmp(&b.evidence))
}

/// The fit of stops without one that explains less than its place and stiffness cost, which could imitate a missing effect.
fn one_sided<'a>(both: Separable<'a>, base: &Separable<'a>) -> Separable<'a> {
    let index = base.structure.effects.len();
    let (stops, columns) = (both.structure.effects[index], both.structure.columns[index]);
    let sides =
        end_stop::one_sided(&stops, &base.capture.scene).map(|stop| base.with(stop, columns).newest_refined(ROUNDS));
    let weight = base.capture.weight;
    let is_as_good = |fit: &Separable<'_>| 0.5 * weight * (fit.squares() / both.squares()).ln() < weight.ln();
    let best = sides.into_iter().min_by(|one, other| one.squares().total_cmp(&other.squares()));
    best.filter(is_as_good).unwrap_or(both)
}

/// The fit with the last effect's law occurring once more, where the residual shows it best; `None` if it cannot occur again.
fn with_a_line_more<'a>(fit: &Separable<'a>) -> Option<Separable<'a>> {
    let index = fit.structure.effects.len().checked_sub(1)?;
    let (effect, columns) = (fit.structure.effects[index], fit.structure.columns[index]);
    let (kind, used) = (effect.kind(), effect.kind().parameters_in(columns));
    // The first line is the detents where there are none; others are found beside these.
    let may_have_more = used < kind.parameters.len() && fit.structure.has_detents();
    kind.hypothesis.filter(|hypothesis| hypothesis.lines > 1 && may_have_more)?;
    let coarse = Coarse::of(fit);
    let scene = fit.capture.scene_of(&fit.structure);
    // At the detents' own frequency two sinusoids of any size would cancel each other.
    let is_apart = |per_turn: f64| cogging::is_apart_from_the_detents(per_turn, &scene);
    let probes = starts(kind, &scene)?.into_iter().filter(|probe| is_apart(probe.values()[1]));
    let (_, probe) = probes.map(|probe| (coarse.gain(&probe), probe)).max_by(|a, b| a.0.total_cmp(&b.0))?;
    let mut more = effect;
    let each = kind.parameters_of_a_line();
    more.values_mut()[used..used + each].copy_from_slice(&probe.values()[..each]);
    let structure = fit.structure.without(index).with(more, columns + kind.columns_of_a_line());
    let fit = Separable::new(structure, fit.capture).newest_refined(ROUNDS);
    let values = fit.structure.effects[index].values();
    let per_turn = values[used + 1];
    let is_new = cogging::lines_are_resolved(values, &scene)
        && is_apart(per_turn)
        && !cogging::is_of_the_detents(per_turn, &scene);
    (is_new && on_bound(&fit.structure, fit.capture).is_none()).then_some(fit)
}

/// Whether the effect's columns at one moment depend on that moment alone.
fn pointwise(kind: &EffectKind) -> bool {
    matches!(
        kind.part,
        Part::Torque(_) | Part::Reading(_) | Part::Friction(_) | Part::CoulombFactor(_) | Part::FrictionFactor(_)
    )
}
