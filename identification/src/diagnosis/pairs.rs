//! An effect and a coupling at once, where neither alone is worth a name: one may hide the other.

use dynamics::{EffectKind, Part};
use rayon::prelude::*;

use super::acceptance::{EVIDENCE, worthwhile};
use super::hypotheses::{self, Effort};
use super::judged::Judged;
use super::search::{Found, MOST_EFFECTS, Search};
use super::verdict::LEFT;

/// Effects, the best ones, with which couplings are tried.
const HIDING: usize = 3;

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
        let mut both = self.coupled_pairs(&firsts, current);
        both.retain(|(_, judged)| {
            self.disqualified(judged).is_none()
                && worthwhile(current, judged, &found.chain[0], self.heldout)
                && !self.is_nothing(judged)
        });
        both.sort_by(|a, b| b.1.evidence.total_cmp(&a.1.evidence));
        let mut both = both.into_iter();
        let Some((first, second)) = both.next() else { return false };
        found.partial.clear();
        for (judged, rivals) in [(first, tried.to_vec()), (second, both.map(|(_, judged)| judged).collect())] {
            self.add(found, judged, rivals);
        }
        true
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
