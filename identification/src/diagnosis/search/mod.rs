//! Effect after effect is tried, added and, if others make it superfluous, taken out again.

pub(crate) mod acceptance;
pub(crate) mod both_captures;
pub(crate) mod characteristic;
pub(crate) mod forward;
pub(crate) mod found;
pub(crate) mod hypotheses;
pub(crate) mod judged;
pub(crate) mod null_test;
pub(crate) mod pairs;
pub(crate) mod revision;
pub(crate) mod trials;

use dynamics::{Effect, Part, effects};
use rayon::prelude::*;

use self::acceptance::{
    EVIDENCE, FALSE_DISCOVERIES, LEFT, TIE, explains_most_of_the_gap, explains_nearly_all, explains_surely,
    explains_the_gap, gap_and_closed, takes_its_part, worthwhile,
};
use self::found::{Added, Found};
use self::judged::Judged;
use crate::diagnosis::capture::Capture;
use crate::diagnosis::error::DiagnosisError;
use crate::diagnosis::findings::Partial;
use crate::diagnosis::model_fit::nonlinear::Nonlinear;
use crate::diagnosis::model_fit::structure::Structure;
use crate::diagnosis::model_fit::{twist, unequal};
use crate::diagnosis::workflow::{DiagnoseOptions, Progress};
use crate::fit::fit_in_time;
use crate::numerics::statistics::false_discovery_rate;
use crate::numerics::vector::{dot, square};
use crate::{FitError, Samples};

pub(crate) const MOST_EFFECTS: usize = 4;
/// Effects beside which all others are fitted anew before one is chosen.
const PROMISING: usize = 4;

/// Other first effects from which the search begins anew.
const OTHER_STARTS: usize = 2;

/// Share of the held-out torque's mean square that the model, scaled by a factor, must explain for the factor to show a wrong unit.
const WELL_PREDICTED: f64 = 0.5;

/// Largest skew between torque and motion that is no delay, in samples: channels may be read one after the other.
const USUAL_SKEW_SAMPLES: f64 = 0.2;

#[derive(Clone, Copy)]
pub(crate) struct Search<'a> {
    pub(crate) train: &'a Capture,
    pub(crate) heldout: &'a Capture,
    pub(crate) options: &'a DiagnoseOptions<'a>,
    /// Neither unequal detents nor couplings, which cost most, are tried.
    pub(crate) detents_are_equal: bool,
    /// Share of what is left above the floor that an effect's best start must take off to be refined.
    pub(crate) promising: f64,
}

impl<'a> Search<'a> {
    pub(crate) fn new([train, heldout]: [&'a Capture; 2], options: &'a DiagnoseOptions<'a>) -> Self {
        Self { train, heldout, options, detents_are_equal: false, promising: 0.0 }
    }

    /// Inertia, friction and detents, or the model given, fitted to the training capture.
    pub(crate) fn base(&self, samples: &Samples<'_>) -> Result<Judged, DiagnosisError> {
        let effects: Vec<Effect> = match &self.options.model {
            Some(model) => model.effects.clone(),
            None => {
                match fit_in_time(samples, &self.options.of_fit()) {
                    // A map's fit has a table of the sinusoids beside the detents: they are left for the search to find.
                    Ok(fit) if self.train.is_map && self.options.axis.is_rotary() => {
                        fit.effects().iter().filter(|effect| effect.table().is_none()).copied().collect()
                    }
                    Ok(fit) => fit.effects().to_vec(),
                    // Too slow or too coarse to look for detents; in a narrow band the rest can still be told.
                    Err(FitError::HardlyMoving { .. }) => {
                        [&effects::inertia::KIND, &effects::friction::KIND].map(|kind| Effect::new(kind, &[])).to_vec()
                    }
                    Err(reason) => return Err(DiagnosisError::Capture { which: "training", reason }),
                }
            }
        };
        // Stick can be fitted to an inner body only: the cap's own rests are masked.
        let coupled = effects.iter().any(|effect| matches!(effect.kind().part, Part::Coupling(_)));
        let fitted: Vec<Effect> =
            effects.into_iter().filter(|effect| coupled || !matches!(effect.kind().part, Part::Stick(_))).collect();
        let base = self.settled(Structure::new(&fitted));
        if twist::of(&base.structure).is_none() {
            return Ok(base);
        }
        let simulated = self.settled(Structure { shaft_is_simulated: true, ..base.structure.clone() });
        Ok(if simulated.evidence > base.evidence { simulated } else { base })
    }

    /// The structure fitted from its present values.
    pub(crate) fn settled(&self, structure: Structure) -> Judged {
        if !structure.is_coupled() {
            return Judged::separable(&unequal::settled(structure, self.train), self.heldout);
        }
        let fit = Nonlinear::new(twist::settled(structure, self.train), self.train).refined();
        Judged::nonlinear(&fit, self.train, self.heldout)
    }

    pub(crate) fn check(&self, base: &Judged) -> Result<(), DiagnosisError> {
        for (which, capture, residual, floor_mnm) in [
            ("training", self.train, &base.train_residual, base.train_floor_mnm),
            ("held-out", self.heldout, &base.heldout_residual, base.heldout_floor_mnm),
        ] {
            let target = capture.target(base.structure.delay_s());
            let target_square = square(&target);
            // Impacts fill the upper end of the spectrum, from which the sensor's noise is taken, but not the quiet stretches.
            let over_floor = (target_square / capture.weight).sqrt() / capture.floor_mnm(0.0).min(floor_mnm);
            if over_floor < 2.0 {
                return Err(DiagnosisError::TooQuiet { which, over_floor });
            }
            let predicted: Vec<f64> = target.iter().zip(residual).map(|(target, left)| target - left).collect();
            let predicted_square = square(&predicted);
            let factor = dot(&target, &predicted) / predicted_square.max(f64::MIN_POSITIVE);
            // A model that lacks gravity may well predict the opposite; only a good prediction shows a wrong unit.
            let predicts = predicted_square * factor.powi(2) > WELL_PREDICTED * target_square;
            if which == "held-out" && predicts && !(0.1..10.0).contains(&factor) {
                return Err(DiagnosisError::DifferentUnits { factor });
            }
        }
        Ok(())
    }

    /// Returns a better explanation if there is one: found from another first effect, without unequal detents, or with peaks and
    /// troughs that differ; otherwise `found`.
    pub(crate) fn reconsidered(&self, mut found: Found) -> Found {
        if let Some(other) = self.begun_again(&found) {
            found = other;
        }
        let Some(step) = found.step_of(effects::unequal_detents::KIND.name) else { return found };
        // With two values for each detent they imitate a few other effects together.
        let mut equal = found.before(step);
        Search { detents_are_equal: true, ..*self }.extend_and_revise(&mut equal);
        if equal.named().evidence > found.named().evidence {
            return equal;
        }
        let is_open = found.named().most_over_floor() > LEFT;
        let asymmetric = |judged: &Judged| {
            unequal::asymmetric(&judged.structure, self.train)
                .map_or_else(|| judged.clone(), |other| self.settled(other))
        };
        if is_open && asymmetric(found.named()).evidence > found.named().evidence {
            found.each_model(asymmetric);
        }
        found
    }

    /// If the skew is larger than usual, searches on without it. Returns the result if it has a delay as an effect, else `found`.
    pub(crate) fn with_delay_for_skew(&self, found: Found) -> Found {
        let last = &found.named().structure;
        if last.skew_s.abs() < USUAL_SKEW_SAMPLES / self.train.rate_hz || last.is_coupled() {
            return found;
        }
        let without_skew = |judged: &Judged| self.settled(judged.structure.without_skew());
        let mut other = found.clone();
        other.each_model(without_skew);
        self.extend_and_revise(&mut other);
        // A delay costs as much freedom as any value; a skew costs none.
        let has_delay = other.step_of(effects::sensor_delay::KIND.name).is_some();
        if has_delay && other.named().evidence > found.named().evidence - EVIDENCE { other } else { found }
    }

    /// The result of a search from another first effect, where the best first effect led to a model that leaves much: it may have
    /// imitated two others. `None` if no such result is better.
    fn begun_again(&self, found: &Found) -> Option<Found> {
        let (base, last) = (&found.base, found.named());
        let is_open = last.most_over_floor() > LEFT;
        if !is_open || found.steps.len() < 2 || found.in_part() || explains_most_of_the_gap(last, base) {
            return None;
        }
        let Added { judged, rivals, .. } = &found.steps[0];
        let search = Search { detents_are_equal: true, ..*self };
        let bare = found.before(0);
        let is_first = |judged: &&Judged| {
            judged.structure.effects.len() == base.structure.effects.len() + 1
                && !judged.structure.is_coupled()
                && self.is_worth_a_name(base, judged, &bare)
        };
        let firsts: Vec<&Judged> = rivals.iter().filter(is_first).take(OTHER_STARTS).collect();
        let others = firsts.into_iter().map(|first| {
            let mut other = bare.clone();
            let rivals = rivals.iter().chain([judged]).cloned().collect();
            search.add_or_take_for_detents(&mut other, first.clone(), rivals, false);
            search.extend_and_revise(&mut other);
            other
        });
        let best = others.max_by(|one, other| one.named().evidence.total_cmp(&other.named().evidence))?;
        (best.named().evidence > last.evidence + TIE).then_some(best)
    }

    /// Adds effect after effect as long as one is worth it, and revises what was added.
    pub(crate) fn extend_and_revise(&self, found: &mut Found) {
        for _ in 0..MOST_EFFECTS {
            self.extend(found);
            if !self.replace_one(found) && !self.find_detents_again(found) {
                break;
            }
        }
    }

    fn extend(&self, found: &mut Found) {
        while found.steps.len() < MOST_EFFECTS {
            let current = found.named().clone();
            if explains_the_gap(&current, &found.base) {
                // Nothing more could be worth a name.
                break;
            }
            let mut tried = self.ranked(&current, self.try_all(&current, found));
            let worthy = tried.iter().position(|rival| self.is_worth_a_name(&current, rival, found));
            if worthy.is_none() {
                found.partial = self.partial(&current, &tried);
                if !found.in_part() && self.add_pair(found, &current, &tried) {
                    continue;
                }
            }
            let on_bound = || if found.steps.is_empty() { self.explanation_on_bound(&current, &tried) } else { None };
            let best = worthy.or_else(|| self.discovery(&current, &tried)).or_else(on_bound);
            let Some(best) = best else { break };
            let chosen = tried.remove(best);
            if self.add_or_take_for_detents(found, chosen, tried, worthy.is_none()) {
                self.simplify(found);
            }
        }
    }

    /// Adds an effect and returns true. If the effect is the first torque that repeats with the angle, which the base lacked, puts it into every
    /// model as the detents and returns false.
    fn add_or_take_for_detents(&self, found: &mut Found, chosen: Judged, rivals: Vec<Judged>, is_part: bool) -> bool {
        let Some(detent) = self.as_detent(&chosen) else {
            self.add(found, chosen, rivals, is_part);
            return true;
        };
        let place = found.base.structure.effects.len();
        found.each_model(|judged| self.settled(judged.structure.with_at(place, detent, 2)));
        false
    }

    /// The models tried beside `current`, the one with the most evidence first.
    pub(crate) fn ranked(&self, current: &Judged, mut tried: Vec<Judged>) -> Vec<Judged> {
        tried.retain(Judged::is_finite);
        tried.retain(|judged| !self.repeats_with_the_detents(judged));
        tried.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
        if !current.structure.is_simulated() {
            // One more effect changes the best values of all others.
            let is_new = |judged: &Judged| judged.structure.is_coupled() == current.structure.is_coupled();
            let promising = tried.iter_mut().filter(|judged| is_new(judged)).take(PROMISING);
            promising.par_bridge().for_each(|judged| *judged = self.settled(judged.structure.clone()));
            tried.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
        }
        tried
    }

    /// Whether the last effect explains enough of what a model without it leaves, and differs from zero.
    pub(crate) fn is_worth_a_name(&self, before: &Judged, after: &Judged, found: &Found) -> bool {
        if self.disqualified(after).is_some() || !worthwhile(before, after, &found.base, self.heldout) {
            return false;
        }
        let both = after.fitted_to_both(self.train, self.heldout);
        (!self.is_nothing(after) || explains_surely(before, after) || self.shows_in_both(before, after, &both))
            && self.is_better_than_other_values(before, &both)
            && !self.moves_worse(before, after)
    }

    /// Whether an effect that the training capture leaves open predicts the other one better than chance, and differs from zero in both
    /// together; `both` is `after` fitted to both.
    fn shows_in_both(&self, before: &Judged, after: &Judged, both: &Judged) -> bool {
        if after.structure.is_coupled() || after.heldout_p_value(before) > FALSE_DISCOVERIES {
            return false;
        }
        let values = both.intervals_from_both(self.train, self.heldout);
        !trials::may_be_zero(&both.structure, values)
    }

    /// Whether one more effect, `after` fitted to both captures, explains them better than the earlier effects would with other values, which
    /// the training capture may leave open. True for coupled bodies, which are not fitted to both captures.
    fn is_better_than_other_values(&self, before: &Judged, after: &Judged) -> bool {
        if after.structure.is_coupled() {
            return true;
        }
        after.evidence > before.fitted_to_both(self.train, self.heldout).evidence + EVIDENCE
    }

    /// The effect that predicts the held-out capture best among those that each explain a part of a gap too large for any of them
    /// alone, and predict it better than the current model, than a null test and, stretch after stretch, than chance.
    fn discovery(&self, current: &Judged, tried: &[Judged]) -> Option<usize> {
        let explains_it_alone = |judged: &Judged| explains_nearly_all(current, judged);
        if current.heldout_over_floor().min(current.train_over_floor()) < LEFT || tried.iter().any(explains_it_alone) {
            return None;
        }
        let p_values: Vec<f64> = tried.iter().map(|judged| judged.heldout_p_value(current)).collect();
        let is_discovery = |index: &usize| {
            let judged = &tried[*index];
            false_discovery_rate(p_values[*index], &p_values) <= FALSE_DISCOVERIES
                && takes_its_part(current, judged)
                && self.disqualified(judged).is_none()
                && judged.heldout_rms_mnm
                    < null_test::rms_mnm(judged.newest(), current, &judged.structure, self.train, self.heldout)
                && !self.is_nothing(judged)
                && self.is_better_than_other_values(current, &judged.fitted_to_both(self.train, self.heldout))
        };
        (0..tried.len())
            .filter(is_discovery)
            .min_by(|one, other| tried[*one].heldout_rms_mnm.total_cmp(&tried[*other].heldout_rms_mnm))
    }

    /// The effect with the most evidence that explains nearly all of the gap, though one of its values stands on a bound.
    fn explanation_on_bound(&self, current: &Judged, tried: &[Judged]) -> Option<usize> {
        tried.iter().position(|judged| explains_surely(current, judged) && self.disqualified(judged).is_some())
    }

    /// Adds an effect, which may explain a part of the gap only.
    pub(crate) fn add(&self, found: &mut Found, chosen: Judged, rivals: Vec<Judged>, is_part: bool) {
        let effect = chosen.newest();
        self.say(Progress::Added { effect, heldout_over_floor: chosen.heldout_over_floor() });
        let added = Added::new(chosen, rivals, found.named(), is_part);
        found.steps.push(added);
    }

    pub(crate) fn say(&self, progress: Progress) {
        if let Some(progress_to) = self.options.progress {
            progress_to(progress);
        }
    }

    /// What explains some of the rest without being worth a name.
    fn partial(&self, current: &Judged, tried: &[Judged]) -> Vec<Partial> {
        let brings_evidence = |judged: &&Judged| judged.evidence - current.evidence > EVIDENCE;
        let each = tried.iter().filter(brings_evidence).filter_map(|judged| {
            let [gap, closed] = gap_and_closed(current, judged);
            let explains_percent = (100.0 * closed / gap).min(100.0);
            (gap > 0.0 && explains_percent > 5.0).then(|| Partial {
                effect: judged.newest(),
                explains_percent,
                disqualified: self.disqualified(judged),
            })
        });
        each.collect()
    }
}
