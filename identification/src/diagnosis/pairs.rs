//! Two effects at once, where neither alone is worth a name: one may hide the other.

use dynamics::{Coordinate, EffectKind, Part, effects};
use rayon::prelude::*;

use super::acceptance::{EVIDENCE, takes_its_part, worthwhile};
use super::hypotheses::{self, Effort};
use super::judged::Judged;
use super::search::{Found, MOST_EFFECTS, Search};
use super::separable::Separable;
use super::verdict::LEFT;

/// Effects, the best ones, with which couplings are tried.
const HIDING: usize = 3;
/// Effects, the best that take their part of the gap, of which two are tried together.
const PAIRED: usize = 4;

impl Search<'_> {
    /// Adds two effects at once where neither alone is worth it and much is left: one may hide the other.
    pub(crate) fn add_pair(&self, found: &mut Found, current: &Judged, tried: &[Judged]) -> bool {
        if current.train_over_floor() < LEFT
            || current.structure.is_coupled()
            || self.detents_are_equal
            || found.rivals.len() + 2 > MOST_EFFECTS
        {
            return false;
        }
        let firsts: Vec<&Judged> = tried
            .iter()
            .filter(|judged| !judged.structure.is_coupled() && judged.evidence > current.evidence + EVIDENCE)
            .take(HIDING)
            .collect();
        let is_worth = |before: &Judged, judged: &Judged| worthwhile(before, judged, &found.chain[0], self.heldout);
        let is_right = |judged: &Judged| {
            self.disqualified(judged).is_none() && is_worth(current, judged) && !self.is_nothing(judged)
        };
        let separable = self
            .separable_pairs(current, tried)
            .into_iter()
            .filter(|(first, alone, judged)| is_worth(first, judged) && is_worth(alone, judged) && is_right(judged));
        let mut both: Vec<(Judged, Judged)> = separable.map(|(first, _, judged)| (first, judged)).collect();
        if both.is_empty() {
            both = self.coupled_pairs(&firsts, current);
            both.retain(|(_, judged)| is_right(judged));
        }
        both.sort_by(|a, b| b.1.evidence.total_cmp(&a.1.evidence));
        let mut both = both.into_iter();
        let Some((first, second)) = both.next() else { return false };
        found.partial.clear();
        for (judged, rivals) in [(first, tried.to_vec()), (second, both.map(|(_, judged)| judged).collect())] {
            self.add(found, judged, rivals);
        }
        true
    }

    /// Each of the best two effects together with each further one that takes its part: the first, the second alone, and both. What depends on the load
    /// is left out, since it costs as much as all others.
    fn separable_pairs(&self, current: &Judged, tried: &[Judged]) -> Vec<(Judged, Judged, Judged)> {
        let is_quick = |judged: &&Judged| {
            let newest = judged.structure.effects.last();
            !judged.structure.is_coupled()
                && newest.is_some_and(|effect| !effect.kind().depends_on.contains(&Coordinate::Load))
        };
        let parts = tried.iter().filter(is_quick).filter(|judged| takes_its_part(current, judged));
        let parts: Vec<&Judged> = parts.take(PAIRED).collect();
        let later = |place: usize| parts[place + 1..].iter().map(move |second| (place, *second));
        let pairs: Vec<(&Judged, &Judged)> =
            (0..parts.len().min(2)).flat_map(later).map(|(place, second)| (parts[place], second)).collect();
        let fitted = pairs.par_iter().filter_map(|(first, alone)| {
            let kind = effects::ALL.into_iter().find(|kind| kind.name == alone.newest())?;
            let judged =
                hypotheses::separable(kind, &Separable::new(first.structure.clone(), self.train), self.heldout)?;
            Some(((*first).clone(), (*alone).clone(), judged))
        });
        fitted.collect()
    }

    /// Each of the first effects together with each coupling.
    fn coupled_pairs(&self, firsts: &[&Judged], current: &Judged) -> Vec<(Judged, Judged)> {
        let couplings: Vec<&'static EffectKind> = self
            .candidates(&current.structure)
            .into_iter()
            .filter(|kind| matches!(kind.part, Part::Coupling(_)))
            .collect();
        let pairs: Vec<(&Judged, &'static EffectKind)> =
            firsts.iter().flat_map(|first| couplings.iter().map(|kind| (*first, *kind))).collect();
        let fitted = pairs.par_iter().filter_map(|(first, kind)| {
            let judged = hypotheses::coupled(kind, &first.structure, [self.train, self.heldout], Effort::Short)?;
            Some(((*first).clone(), judged))
        });
        fitted.collect()
    }
}
