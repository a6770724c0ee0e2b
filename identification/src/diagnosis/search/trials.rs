//! Every effect that may be missing, tried beside a structure, and what speaks against one.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};

use dynamics::effects::{self, cogging};
use dynamics::{Effect, EffectKind, ParameterKind, Part};
use rayon::prelude::*;

use crate::diagnosis::findings::Value;
use crate::diagnosis::model_fit::bound::on_bound;
use crate::diagnosis::model_fit::separable::{BEND, Separable};
use crate::diagnosis::model_fit::structure::Structure;
use crate::diagnosis::model_fit::{intervals, twist, unequal};
use crate::diagnosis::search::Search;
use crate::diagnosis::search::acceptance::{
    CLOSED, EVIDENCE, explains_enough, explains_most_of_the_gap, is_near_the_floor,
};
use crate::diagnosis::search::found::Found;
use crate::diagnosis::search::hypotheses::coupled::{self, Effort};
use crate::diagnosis::search::hypotheses::{candidates, separable};
use crate::diagnosis::search::judged::Judged;
use crate::diagnosis::workflow::Progress;
use crate::numerics::vector::square;

/// Detents with the amplitude (mNm), periods per turn and phase (rad) of a line of cogging.
pub(crate) fn detent_of([amplitude_mnm, per_turn, phase_rad]: [f64; 3]) -> Effect {
    Effect::new(&effects::detent::KIND, &[amplitude_mnm, 1.0 / per_turn, phase_rad])
}

fn is_coupling(kind: &EffectKind) -> bool {
    matches!(kind.part, Part::Coupling(_))
}

/// Whether an effect couples bodies that may lose touch, which those of a shaft do not.
fn has_a_gap(effect: &Effect) -> bool {
    is_coupling(effect.kind()) && !twist::is_shaft(effect.kind())
}

impl Search<'_> {
    /// The best fit with each effect of the catalogue added.
    pub(crate) fn try_all(&self, current: &Judged, found: &Found) -> Vec<Judged> {
        let mut tried = self.try_values(current);
        if !current.structure.is_coupled() && !self.detents_are_equal {
            self.try_couplings(current, found, &mut tried);
        }
        tried
    }

    /// The same without the couplings that take a simulation to find.
    pub(crate) fn try_replacements(&self, current: &Judged) -> Vec<Judged> {
        let mut tried = self.try_values(current);
        if !current.structure.is_coupled() {
            let shafts = self.couplings(current).into_iter().filter(|kind| twist::is_shaft(kind));
            tried.extend(shafts.filter_map(|kind| self.coupled(kind, current, Effort::Short)));
        }
        tried
    }

    /// The same without couplings.
    pub(crate) fn try_values(&self, current: &Judged) -> Vec<Judged> {
        let mut kinds = candidates(&current.structure, self.train);
        if current.structure.is_simulated() {
            let mut tried = coupled::with_one_more(&kinds, &current.structure, self.train, self.heldout);
            if !self.detents_are_equal {
                // A simulation does not fit detents one by one; behind a shaft they are.
                let on_shaft = Structure { shaft_is_simulated: false, ..current.structure.clone() };
                let unequal = self.behind_shaft(&on_shaft, |search, bare| Vec::from_iter(search.unequal_detents(bare)));
                tried.extend(unequal.into_iter().flatten());
            }
            return tried;
        }
        let of = kinds.len();
        kinds.retain(|kind| !is_coupling(kind));
        let behind = self.behind_shaft(&current.structure, |search, bare| search.try_separable(&kinds, of, bare));
        behind.unwrap_or_else(|| self.try_separable(&kinds, of, current))
    }

    /// What is tried behind a structure's shaft, on that shaft; `None` if there is none that merely twists.
    fn behind_shaft(
        &self,
        structure: &Structure,
        tried: impl Fn(&Search<'_>, &Judged) -> Vec<Judged>,
    ) -> Option<Vec<Judged>> {
        let (index, shaft) = twist::of(structure)?;
        let (bare, train) = twist::unwound(structure, self.train)?;
        let (_, heldout) = twist::unwound(structure, self.heldout)?;
        let bare = Judged::separable(&Separable::new(bare, &train), &heldout);
        let tried = tried(&Search { train: &train, heldout: &heldout, ..*self }, &bare).into_iter();
        let on_shaft = |judged: Judged| {
            // The effect that was tried is the last one, even if it replaced the detents.
            let last = judged.structure.effects.len() - 1;
            let structure = judged.structure.with_at(index.min(last), shaft, 0);
            judged.with_structure(structure, self.train, self.heldout)
        };
        Some(tried.map(on_shaft).collect())
    }

    /// The best fits with each of the `kinds` added, and the fit with unequal detents. Progress is reported out of `of` effects.
    fn try_separable(&self, kinds: &[&'static EffectKind], of: usize, current: &Judged) -> Vec<Judged> {
        let base = Separable::new(current.structure.clone(), self.train);
        let done = AtomicUsize::new(0);
        let one_more = || {
            let fits = kinds.par_iter().filter_map(|kind| {
                let judged = separable::fitted(kind, &base, self.heldout, self.promising);
                let done = done.fetch_add(1, Ordering::Relaxed) + 1;
                self.say(Progress::Tried { effect: kind.name, done, of });
                judged
            });
            fits.collect::<Vec<Judged>>()
        };
        if self.detents_are_equal {
            return one_more();
        }
        let (unequal, mut tried) = rayon::join(|| self.unequal_detents(current), one_more);
        tried.extend(unequal);
        tried
    }

    /// Tries couplings, which cost most, where nothing else explains what is left.
    fn try_couplings(&self, current: &Judged, found: &Found, tried: &mut Vec<Judged>) {
        // So close to the floor, its uncertainty exceeds what backlash leaves: couplings are tried whatever else may explain it.
        let is_faint = is_near_the_floor(current);
        let is_closed = |judged: &Judged| judged.most_over_floor() <= CLOSED;
        let qualifies = |judged: &Judged| self.disqualified(judged).is_none();
        let explains_all = |judged: &Judged| is_closed(judged) && qualifies(judged);
        let explains_most =
            |judged: &Judged| (is_closed(judged) || explains_most_of_the_gap(judged, &found.base)) && qualifies(judged);
        if !is_faint && (is_closed(current) || tried.iter().any(explains_all)) {
            return;
        }
        let is_mostly_explained = !is_faint && tried.iter().any(explains_most);
        let effort = if is_faint { Effort::Fine } else { Effort::Full };
        let of = candidates(&current.structure, self.train).len();
        let mut couplings = self.couplings(current);
        // A shaft is found without simulation.
        couplings.retain(|kind| twist::is_shaft(kind) || !is_mostly_explained && !found.has_failed(kind));
        for (index, kind) in couplings.iter().enumerate() {
            let mut judged = self.coupled(kind, current, effort);
            if !twist::is_shaft(kind)
                && judged.as_ref().is_some_and(|judged| self.is_worth_a_name(current, judged, found))
            {
                judged = judged.filter(|judged| !self.is_rather_a_shaft(judged, tried));
            }
            self.say(Progress::Tried { effect: kind.name, done: of - couplings.len() + index + 1, of });
            let is_enough = !is_faint && judged.as_ref().is_some_and(explains_most);
            tried.extend(judged);
            if is_enough {
                // The next coupling has more freedom and costs more.
                return;
            }
        }
        if is_faint || is_mostly_explained {
            return;
        }
        let best = tried.iter().max_by(|a, b| a.evidence.total_cmp(&b.evidence));
        if best.is_some_and(|best| best.structure.is_coupled() && explains_enough(current, best)) {
            // The coupling explains most, but not all: its fit may be in a neighbouring valley, or another coupling be right.
            tried.retain(|judged| !judged.structure.effects.last().is_some_and(has_a_gap));
            let backlash = self.couplings(current).into_iter().filter(|kind| !twist::is_shaft(kind));
            tried.extend(backlash.filter_map(|kind| self.coupled(kind, current, Effort::Thorough)));
        }
    }

    /// The couplings that could be added to a structure, that with the fewest values first.
    pub(crate) fn couplings(&self, current: &Judged) -> Vec<&'static EffectKind> {
        let mut couplings = candidates(&current.structure, self.train);
        couplings.retain(|kind| is_coupling(kind));
        couplings.sort_by_key(|kind| kind.parameters.len());
        couplings
    }

    /// Whether a shaft that was tried has more evidence than a gap, or hardly less if the gap may be zero.
    fn is_rather_a_shaft(&self, gap: &Judged, tried: &[Judged]) -> bool {
        let is_shaft =
            |judged: &&Judged| judged.structure.effects.last().is_some_and(|last| twist::is_shaft(last.kind()));
        let Some(shaft) = tried.iter().find(is_shaft) else { return false };
        let last = gap.structure.effects.len() - 1;
        let values = intervals::of(&gap.structure, self.train).pop().unwrap_or_default();
        let margin = if self.may_be_a_shaft(&gap.structure, last, &values) { EVIDENCE } else { 0.0 };
        shaft.evidence > gap.evidence - margin
    }

    /// Whether an effect of these values is a coupling whose gap is not surely wider than the least that is looked for.
    pub(crate) fn may_be_a_shaft(
        &self,
        structure: &Structure,
        index: usize,
        values: &BTreeMap<&'static str, Value>,
    ) -> bool {
        let effect = &structure.effects[index];
        let shows_gap = || {
            let search = effect.kind().hypothesis?.searched.first()?;
            let (least_rad, _) = search.range_in(&self.train.scene_of(structure))?;
            let [low, _] = values.get(effect.kind().parameters[search.parameter].name)?.ci95?;
            Some(low > least_rad)
        };
        has_a_gap(effect) && !shows_gap().unwrap_or(false)
    }

    fn coupled(&self, kind: &'static EffectKind, current: &Judged, effort: Effort) -> Option<Judged> {
        coupled::fitted(kind, &current.structure, [self.train, self.heldout], effort)
    }

    /// The reason why the last effect cannot be the missing one; `None` if it can be.
    pub(crate) fn disqualified(&self, judged: &Judged) -> Option<String> {
        if twist::is_overdamped(&judged.structure) {
            return Some("its damping exceeds the critical one, so that it does not resonate".to_owned());
        }
        on_bound(&judged.structure, self.train)
            .map(|parameter| format!("{parameter} stands on the bound of what this capture could show"))
    }

    /// Whether the last effect may be absent: the intervals of all parameters that scale its torque contain zero, or it may be no more than
    /// Coulomb friction.
    pub(crate) fn is_nothing(&self, judged: &Judged) -> bool {
        let structure = &judged.structure;
        let values = intervals::given_straight_ends(structure, self.train);
        let last = structure.effects.last().zip(values.last());
        let is_coulomb = last.is_some_and(|(effect, values)| self.may_be_coulomb_friction(structure, effect, values));
        is_coulomb || may_be_zero(structure, values)
    }

    /// Whether the interval of an effect's speed reaches one at which it is Coulomb friction.
    pub(crate) fn may_be_coulomb_friction(
        &self,
        structure: &Structure,
        effect: &Effect,
        values: &BTreeMap<&'static str, Value>,
    ) -> bool {
        let scene = self.train.scene_of(structure);
        effect.kind().searches().iter().any(|search| {
            let parameter = &effect.kind().parameters[search.parameter];
            let least = search.range_in(&scene).filter(|_| search.is_coulomb_at_least).map(|(least, _)| least);
            let low = values.get(parameter.name).and_then(|value| value.ci95).map(|[low, _]| low);
            least.zip(low).is_some_and(|(least, low)| low <= least)
        })
    }

    /// Whether the last effect is the first torque that repeats with the angle: the detents, which the model lacks.
    pub(crate) fn is_the_detents(&self, judged: &Judged) -> bool {
        judged.newest() == cogging::KIND.name && !judged.structure.has_detents()
    }

    /// The last effect as detents; `None` if it is something else.
    pub(crate) fn as_detent(&self, judged: &Judged) -> Option<Effect> {
        let effect = judged.structure.effects.last().filter(|_| self.is_the_detents(judged))?;
        // Other lines will be found again beside the detents.
        cogging::lines(effect.values()).next().map(detent_of)
    }

    /// Whether the last effect is cogging with every line a multiple of the detents' frequency: that is the detents' own shape.
    pub(crate) fn repeats_with_the_detents(&self, judged: &Judged) -> bool {
        let Some(effect) = judged.structure.effects.last() else { return false };
        let scene = self.train.scene_of(&judged.structure);
        effect.kind().name == cogging::KIND.name
            && cogging::lines(effect.values()).all(|[_, per_turn, _]| cogging::is_of_the_detents(per_turn, &scene))
    }

    /// Whether unequal detents explain most of the training capture's gap beside equal ones.
    pub(crate) fn detents_are_unequal(&self, base: &Judged) -> bool {
        base.train_over_floor() > CLOSED
            && self.unequal_detents(base).is_some_and(|unequal| base.explained_by(&unequal) > 0.5)
    }

    /// The fit with unequal detents in the place of equal ones; `None` where they explain nothing, or no more than a torque that
    /// bends slowly along the angle.
    fn unequal_detents(&self, current: &Judged) -> Option<Judged> {
        let evidence = |squares: f64, freedom: usize| {
            let weight = self.train.weight;
            let cost = 0.5 * freedom as f64 * weight.ln();
            -0.5 * weight * squares.max(f64::MIN_POSITIVE).ln() - cost
        };
        let squares = |judged: &Judged| square(&judged.train_residual);
        let freedom = current.structure.freedom();
        let (start, left) = unequal::structure(&current.structure, self.train)?;
        let gap = squares(current) - self.train.weight * current.train_floor_mnm.powi(2);
        let is_promising = squares(current) - left > self.promising * gap;
        if !is_promising || evidence(left, start.freedom()) < evidence(squares(current), freedom) {
            return None;
        }
        let unequal = self.settled(start);
        let bent = self.bent(current)?;
        (evidence(squares(&unequal), unequal.structure.freedom()) > evidence(squares(&bent), freedom + BEND))
            .then_some(unequal)
    }
}

/// Whether the last effect may be absent: the intervals of all parameters that scale its torque contain zero.
pub(crate) fn may_be_zero(structure: &Structure, mut values: Vec<BTreeMap<&'static str, Value>>) -> bool {
    let (Some(effect), Some(values)) = (structure.effects.last(), values.pop()) else { return true };
    let searched = effect.kind().searches();
    let is_strength = |index: usize, unit: &str| {
        (unit.starts_with("mNm") || unit == "1") && searched.iter().all(|search| search.parameter != index)
    };
    let holds_zero = |parameter: &ParameterKind| match values.get(parameter.name) {
        Some(Value { ci95: Some([low, high]), .. }) => *low <= 0.0 && 0.0 <= *high,
        Some(Value { value, .. }) => *value == 0.0,
        None => true,
    };
    let parameters = effect.kind().parameters;
    let linear: Vec<&ParameterKind> = parameters
        .iter()
        .enumerate()
        .filter(|(index, parameter)| effect.kind().regressors.is_some() && is_strength(*index, parameter.unit))
        .map(|(_, parameter)| parameter)
        .collect();
    // An end stop is absent if its stiffness is zero, whatever its damping.
    let stiffnesses: Vec<&ParameterKind> =
        linear.iter().copied().filter(|parameter| parameter.unit == "mNm/rad").collect();
    let linear = if stiffnesses.is_empty() { linear } else { stiffnesses };
    // An effect without such strengths (backlash, a shaft, a delay) is absent if its first parameter is zero.
    if linear.is_empty() { parameters.first().is_some_and(holds_zero) } else { linear.into_iter().all(holds_zero) }
}
