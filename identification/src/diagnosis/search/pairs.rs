//! Two effects at once, where neither alone is worth a name: one may hide the other.

use dynamics::EffectKind;
use rayon::prelude::*;

use crate::diagnosis::model_fit::twist;
use crate::diagnosis::search::acceptance::{EVIDENCE, LEFT, explains_enough, worthwhile};
use crate::diagnosis::search::found::Found;
use crate::diagnosis::search::hypotheses::coupled::{self, Effort};
use crate::diagnosis::search::judged::Judged;
use crate::diagnosis::search::{MOST_EFFECTS, Search};

/// Number of the best effects beside which a second one is tried.
const HIDING: usize = 3;

impl Search<'_> {
    /// Adds two effects at once where neither alone is worth it and much is left: one may hide the other.
    pub(crate) fn add_pair(&self, found: &mut Found, current: &Judged, tried: &[Judged]) -> bool {
        if current.train_over_floor() < LEFT || found.steps.len() + 2 > MOST_EFFECTS {
            return false;
        }
        let is_coupled = current.structure.is_coupled();
        let firsts: Vec<&Judged> = tried
            .iter()
            .filter(|judged| {
                judged.structure.is_coupled() == is_coupled
                    && judged.evidence > current.evidence + EVIDENCE
                    && !self.is_the_detents(judged)
            })
            .take(HIDING)
            .collect();
        let pair = firsts.iter().find_map(|first| self.pair_with(found, current, first));
        let may_be_coupled = !is_coupled && !self.detents_are_equal;
        let pair =
            pair.or_else(|| if may_be_coupled { self.coupled_pair(found, current, &firsts, tried) } else { None });
        let Some((first, second, rivals)) = pair else { return false };
        found.partial.clear();
        self.add(found, first, tried.to_vec(), false);
        self.add(found, second, rivals, false);
        true
    }

    /// A first effect that explains enough, though not surely, with a second one, each worth a name beside the other; also the second one's
    /// rivals.
    fn pair_with(&self, found: &Found, current: &Judged, first: &Judged) -> Option<(Judged, Judged, Vec<Judged>)> {
        if !explains_enough(current, first) || self.disqualified(first).is_some() || self.is_nothing(first) {
            return None;
        }
        let mut seconds = self.ranked(first, self.try_values(first));
        let place = seconds.iter().position(|second| {
            self.is_worth_a_name(first, second, found)
                && self
                    .without(second, first.newest(), found)
                    .is_some_and(|without| worthwhile(&without, second, &found.base, self.heldout))
        })?;
        let second = seconds.remove(place);
        Some((first.clone(), second, seconds))
    }

    /// The best of the first effects together with a coupling, and the others.
    fn coupled_pair(
        &self,
        found: &Found,
        current: &Judged,
        firsts: &[&Judged],
        tried: &[Judged],
    ) -> Option<(Judged, Judged, Vec<Judged>)> {
        let mut couplings = self.couplings(current);
        // A contact, which takes a simulation to find, shows without the first effect too.
        couplings.retain(|kind| {
            let shows = |judged: &Judged| judged.newest() == kind.name && judged.evidence > current.evidence + EVIDENCE;
            twist::is_shaft(kind) || tried.iter().any(shows)
        });
        let pairs: Vec<(&Judged, &'static EffectKind)> =
            firsts.iter().flat_map(|first| couplings.iter().map(|kind| (*first, *kind))).collect();
        let fitted = pairs.par_iter().filter_map(|(first, kind)| {
            let judged = coupled::fitted(kind, &first.structure, [self.train, self.heldout], Effort::Short)?;
            Some(((*first).clone(), judged))
        });
        let mut both: Vec<(Judged, Judged)> = fitted.collect();
        both.retain(|(_, judged)| self.is_worth_a_name(current, judged, found));
        both.sort_by(|a, b| b.1.evidence.total_cmp(&a.1.evidence));
        let mut both = both.into_iter();
        let (first, second) = both.next()?;
        Some((first, second, both.map(|(_, judged)| judged).collect()))
    }
}
