//! Reconsiders effects beside those that were added after them.

use dynamics::Effect;
use dynamics::effects::{self, cogging};

use crate::diagnosis::search::Search;
use crate::diagnosis::search::acceptance::{FALSE_DISCOVERIES, TIE, explains_enough_of_both, takes_its_part};
use crate::diagnosis::search::found::{Added, Found};
use crate::diagnosis::search::judged::Judged;
use crate::diagnosis::search::trials::detent_of;

/// The best start of a replacement must explain this share of what the effect to be replaced explains.
const RIVALS: f64 = 0.1;

impl Search<'_> {
    /// Replaces a return spring by an offset where that one fits or predicts no worse: a spring far from its centre is an offset.
    pub(crate) fn simplify(&self, found: &mut Found) {
        let (spring, offset) = (effects::return_spring::KIND.name, &effects::torque_offset::KIND);
        let Some(step) = found.step_of(spring) else { return };
        let Some(with_spring) = found.named().clone().with_newest(spring) else { return };
        let Some(without) = self.without(&with_spring, spring, found) else { return };
        if without.structure.position(offset.name).is_some() {
            return;
        }
        let simple = self.settled(without.structure.with(Effect::new(offset, &[]), offset.columns_of_a_line()));
        let is_as_good =
            with_spring.evidence - simple.evidence < TIE || simple.heldout_rms_mnm <= with_spring.heldout_rms_mnm;
        if is_as_good && self.is_worth_a_name(&without, &simple, found) {
            // The rivals of an earlier effect were tried beside fewer effects.
            let is_newest = step + 1 == found.steps.len();
            let Added { rivals, is_part, .. } = self.remove(found, step, without);
            let rivals = if is_newest { rivals } else { Vec::new() }.into_iter().chain([with_spring]);
            self.add(found, simple, rivals.collect(), is_part);
        }
    }

    /// Tries each effect again beside those that were added after it. Replaces the first one that explains less than another effect would, or
    /// removes it if it explains nothing. Returns whether there was one.
    ///
    /// The first effect is the best one beside a model that lacks all others; it need not be one of those that are missing.
    pub(crate) fn replace_one(&self, found: &mut Found) -> bool {
        let last = found.named().clone();
        // The newest one has just been compared with all others.
        for step in 0..found.steps.len().saturating_sub(1) {
            let added = found.steps[step].effect;
            let Some(without) = self.without(&last, added, found) else { continue };
            if without.evidence > last.evidence && without.heldout_rms_mnm <= last.heldout_rms_mnm {
                self.remove(found, step, without);
                return true;
            }
            // A replacement that explains much less than the effect itself need not be refined.
            let share = without.explained_by(&last);
            let search = Search { promising: RIVALS * share, ..*self };
            let tried = search.try_replacements(&without);
            let is_better = |rival: &Judged| rival.evidence > last.evidence + TIE;
            // Settling raises the effect's own evidence from `own` to the last model's, and a rival's by hardly more than twice as much.
            let own = tried.iter().find(|rival| rival.newest() == added).map_or(f64::NEG_INFINITY, |own| own.evidence);
            let promising = own - (last.evidence - own).max(TIE);
            if !tried.iter().any(|rival| is_better(rival) || rival.newest() != added && rival.evidence > promising) {
                continue;
            }
            let mut tried = self.ranked(&without, tried);
            // The effect itself may have another line beside those that were added after it.
            let best = tried.iter().position(|rival| self.is_worth_a_name(&without, rival, found));
            let Some(best) = best.filter(|best| is_better(&tried[*best])) else { continue };
            let chosen = tried.remove(best);
            self.remove(found, step, without);
            self.add(found, chosen, tried, false);
            return true;
        }
        false
    }

    /// Takes a line of the cogging for the detents where these were fitted to something that now has another name; whether it did.
    pub(crate) fn find_detents_again(&self, found: &mut Found) -> bool {
        let last = found.named();
        let positions = [cogging::KIND.name, effects::detent::KIND.name].map(|name| last.structure.position(name));
        let step = found.step_of(cogging::KIND.name);
        let ([Some(index), Some(_)], Some(step)) = (positions, step) else { return false };
        let lines = cogging::lines(last.structure.effects[index].values());
        let fitted = lines.map(|line| {
            let mut structure = last.structure.clone();
            structure.put_detent(detent_of(line));
            self.settled(structure.without(index))
        });
        let best = fitted.max_by(|one, other| one.evidence.total_cmp(&other.evidence));
        let Some(best) = best.filter(|best| best.evidence > last.evidence) else { return false };
        let detent = best.structure.position(effects::detent::KIND.name).map(|index| best.structure.effects[index]);
        self.remove(found, step, best);
        found.each_model(|judged| {
            let mut structure = judged.structure.clone();
            detent.into_iter().for_each(|detent| structure.put_detent(detent));
            self.settled(structure)
        });
        true
    }

    /// Takes out again what other effects have made superfluous.
    pub(crate) fn eliminate(&self, found: &mut Found) {
        let mut step = 0;
        while step < found.steps.len() && found.steps.len() > 1 {
            let last = found.named();
            let Some(without) = self.without(last, found.steps[step].effect, found) else { return };
            let is_discovery = takes_its_part(&without, last) && last.heldout_p_value(&without) < FALSE_DISCOVERIES;
            let is_needed =
                explains_enough_of_both(&without, last, &found.base, self.heldout) || found.in_part() && is_discovery;
            let predicts = without.is_finite() && without.heldout_rms_mnm < found.base.heldout_rms_mnm;
            if is_needed || !predicts {
                step += 1;
                continue;
            }
            self.remove(found, step, without);
            step = 0;
        }
    }

    /// A model without one of the effects that were added, the others fitted anew; equal detents are again where unequal ones were.
    pub(crate) fn without(&self, judged: &Judged, effect: &str, found: &Found) -> Option<Judged> {
        let mut structure = judged.structure.without(judged.structure.position(effect)?);
        if effect == effects::unequal_detents::KIND.name {
            let base = &found.base.structure;
            let index = base.position(effects::detent::KIND.name)?;
            structure = structure.with_at(index, base.effects[index], base.columns[index]);
        }
        Some(self.settled(structure))
    }

    /// Takes out the effect that was added in a step, with `without` as the last model, and makes the models before anew.
    fn remove(&self, found: &mut Found, step: usize, without: Judged) -> Added {
        let removed = found.steps.remove(step);
        for later in step..found.steps.len().saturating_sub(1) {
            if let Some(without) = self.without(&found.steps[later].judged, removed.effect, found) {
                found.steps[later].judged = without;
            }
        }
        match found.steps.last_mut() {
            Some(last) => last.judged = without,
            None => found.base = without,
        }
        removed
    }
}
