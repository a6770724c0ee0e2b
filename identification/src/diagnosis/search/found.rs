//! The state of a search: what it has found so far.

use dynamics::EffectKind;
use rayon::prelude::*;

use crate::diagnosis::capture::Capture;
use crate::diagnosis::findings::{Characteristic, Partial};
use crate::diagnosis::search::acceptance::takes_its_part;
use crate::diagnosis::search::judged::Judged;
use crate::numerics::statistics::false_discovery_rate;

/// The model without further effects, and what was added to it.
#[derive(Clone)]
pub(crate) struct Found {
    pub(crate) base: Judged,
    /// The effects that were added, one after the other.
    pub(crate) steps: Vec<Added>,
    /// Effects that explain part of the rest and were not added.
    pub(crate) partial: Vec<Partial>,
    /// Measured torques without a name that were added.
    pub(crate) characteristics: Vec<(Judged, Characteristic)>,
}

/// An effect that was added.
#[derive(Clone)]
pub(crate) struct Added {
    pub(crate) effect: &'static str,
    /// The model with it.
    pub(crate) judged: Judged,
    /// The other effects that were tried with it.
    pub(crate) rivals: Vec<Judged>,
    /// Share of false discoveries among all effects tried, from how well each predicts the held-out capture.
    pub(crate) false_discovery_rate: f64,
    /// Whether it was added as a part of the gap only: then something is left that has no name.
    pub(crate) is_part: bool,
}

impl Added {
    /// The newest effect of a model, chosen among rivals beside the model `before`; it is no rival of its own.
    pub(crate) fn new(judged: Judged, mut rivals: Vec<Judged>, before: &Judged, is_part: bool) -> Self {
        let effect = judged.newest();
        rivals.retain(|rival| rival.newest() != effect);
        let false_discovery_rate = rate(&judged, &rivals, before);
        Self { effect, judged, rivals, false_discovery_rate, is_part }
    }
}

/// Share of false discoveries among a chosen effect and its rivals, all tried beside the model `before`.
fn rate(chosen: &Judged, rivals: &[Judged], before: &Judged) -> f64 {
    let p_value = chosen.heldout_p_value(before);
    let all: Vec<f64> = rivals.iter().map(|rival| rival.heldout_p_value(before)).chain([p_value]).collect();
    false_discovery_rate(p_value, &all)
}

impl From<Judged> for Found {
    /// Nothing beside a base model.
    fn from(base: Judged) -> Self {
        Self { base, steps: Vec::new(), partial: Vec::new(), characteristics: Vec::new() }
    }
}

impl Found {
    /// The state before the effect of a step was added.
    pub(crate) fn before(&self, step: usize) -> Self {
        Self { steps: self.steps[..step].to_vec(), ..Self::from(self.base.clone()) }
    }

    /// The same models judged by another held-out capture.
    pub(crate) fn judged_by(&self, train: &Capture, heldout: &Capture) -> Self {
        let anew = |judged: &Judged| judged.judged_by(train, heldout);
        let mut found = self.clone();
        found.each_model(anew);
        found.steps.iter_mut().for_each(|added| added.rivals = added.rivals.par_iter().map(anew).collect());
        for step in 0..found.steps.len() {
            let Added { judged, rivals, .. } = &found.steps[step];
            found.steps[step].false_discovery_rate = rate(judged, rivals, found.model_before(step));
        }
        found
    }

    /// Makes the base and every later model anew.
    pub(crate) fn each_model(&mut self, anew: impl Fn(&Judged) -> Judged + Sync) {
        let models = std::iter::once(&mut self.base).chain(self.steps.iter_mut().map(|added| &mut added.judged));
        models.par_bridge().for_each(|judged| *judged = anew(judged));
    }

    /// The model without further effects, and then with each more.
    pub(crate) fn models(&self) -> impl Iterator<Item = &Judged> {
        std::iter::once(&self.base).chain(self.steps.iter().map(|added| &added.judged))
    }

    /// The model before the effect of a step was added.
    pub(crate) fn model_before(&self, step: usize) -> &Judged {
        step.checked_sub(1).map_or(&self.base, |before| &self.steps[before].judged)
    }

    /// The step in which an effect was added.
    pub(crate) fn step_of(&self, effect: &str) -> Option<usize> {
        self.steps.iter().position(|added| added.effect == effect)
    }

    /// Whether an effect was added that explains a part of the gap only.
    pub(crate) fn in_part(&self) -> bool {
        self.steps.iter().any(|added| added.is_part)
    }

    /// The model with all effects that have a name.
    pub(crate) fn named(&self) -> &Judged {
        self.model_before(self.steps.len())
    }

    /// The final model.
    pub(crate) fn last(&self) -> &Judged {
        self.characteristics.last().map_or(self.named(), |(judged, _)| judged)
    }

    /// Whether an effect brought nothing when it was tried in the last step: at the cost of a coupling, it need not be tried again.
    pub(crate) fn has_failed(&self, kind: &EffectKind) -> bool {
        let Some(before) = self.steps.len().checked_sub(1) else { return false };
        let failed = |rival: &&Judged| !takes_its_part(self.model_before(before), rival);
        self.steps[before].rivals.iter().filter(failed).any(|rival| rival.newest() == kind.name)
    }
}
