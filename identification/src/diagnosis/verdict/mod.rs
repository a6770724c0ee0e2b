//! What was found: where the residual lies, whether it is explained, and what to capture next.

pub(crate) mod commanded;
pub(crate) mod experiment;
mod hum;
pub(crate) mod locate;
mod shown_in_part;

use std::collections::BTreeMap;

use dynamics::{Model, effects};

use self::locate::locate;
use crate::diagnosis::capture::{Capture, SLIDING, rows};
use crate::diagnosis::findings::{Diagnosis, Rival, Step, Value, Verdict};
use crate::diagnosis::model_fit::structure::Structure;
use crate::diagnosis::model_fit::{intervals, unequal};
use crate::diagnosis::search::acceptance::{
    LEFT, LOWER_FLOOR, MOSTLY_EXPLAINED, MOSTLY_NOISE, TIE, UNEXPLAINED, is_near_the_floor, takes_its_part, worthwhile,
};
use crate::diagnosis::search::found::{Added, Found};
use crate::diagnosis::search::judged::Judged;
use crate::diagnosis::search::{Search, null_test};
use crate::fit::report::one_sided_friction;
use crate::numerics::statistics::rank_correlation;
use crate::numerics::vector::square;

/// RMS in floors above which something is left even if the residual depends on no coordinate. If noise is stronger at low frequencies, the rests
/// in which it is measured are too short to show all of it. Of 34 captures with such noise and nothing hidden, four left 1.6 to 1.8 floors.
const CERTAINLY_LEFT: f64 = 2.0;
/// Correlation of the ranks of time and speed from which their effects cannot be separated.
const INSEPARABLE: f64 = 0.98;

/// Advice on a residual without a name, by the coordinate on which it depends, if any.
fn next_step(coordinate: Option<&str>) -> &'static str {
    match coordinate {
        Some("angle" | "angle-within-turn" | "detent-phase") => {
            "to learn what the rest is, turn the knob slowly through its whole travel, both ways (--sweep slow-turn), and look at \
             the map over the angle on the report page"
        }
        Some("velocity" | "speed-and-direction-of-acceleration" | "acceleration") => {
            "to learn what the rest is, capture more speeds, slow ones too (--sweep stepped-amplitude), and look at the map over \
             the velocity on the report page"
        }
        Some("time") => "to learn what the rest is, let the rig warm up and capture for longer",
        Some("frequency") => {
            "to learn what the rest is, look at the spectrum on the report page: what hums or rings has a line there"
        }
        _ => {
            "to learn what the rest is, capture another motion, slower and faster, and look at the maps of what is left on the \
             report page"
        }
    }
}

/// A note on a capture in which the speed only rises or only falls, as when the torque is a ramp: what depends on time
/// looks like what depends on speed.
fn note_on_time_and_speed(train: &Capture) -> Option<String> {
    let rows = train.row_motions();
    let sliding = rows.iter().filter(|(_, mask)| *mask > SLIDING).map(|(motion, _)| motion);
    let points: Vec<[f64; 2]> = sliding.map(|motion| [motion.time_s, motion.velocity_rad_s.abs()]).collect();
    let correlation = rank_correlation(&points);
    (correlation.abs() > INSEPARABLE).then(|| {
        "in the training capture time and speed are correlated: friction that changes with time cannot be distinguished from \
         friction that changes with speed; capture a motion whose speed rises and falls"
            .to_owned()
    })
}

/// The reason why the effects added may not be all: the residual exceeds the sensors' noise, or lies so far below it that the
/// noise is not known, or the first model left little more than noise. `None` without such a reason.
fn note_on_the_rest(first: &Judged, last: &Judged) -> Option<String> {
    let [(quieter, least), (louder, most)] = {
        let mut captures = [("training", last.train_over_floor()), ("held-out", last.heldout_over_floor())];
        captures.sort_by(|one, other| one.1.total_cmp(&other.1));
        captures
    };
    if most > LEFT {
        Some(format!(
            "the effects added may not be all: {most:.1} times the noise is left of the {louder} capture; hold out another motion"
        ))
    } else if least < LOWER_FLOOR {
        Some(format!(
            "whether the effects added are all is not known: of the {quieter} capture {least:.1} times the noise is left, which was \
             overestimated; let the knob rest for a second in a capture"
        ))
    } else if is_near_the_floor(first) {
        Some(format!(
            "whether these are all the effects, or similar ones, is not known: without them only {:.1} times the noise was left, and the noise is not \
             known that well; capture a faster or wider motion, in which they show more",
            first.most_over_floor()
        ))
    } else {
        None
    }
}

impl Search<'_> {
    /// The effects that were added but are disqualified, and why: each may stand for another effect.
    fn on_bounds(&self, found: &Found) -> Vec<(&'static str, String)> {
        found.steps.iter().filter_map(|added| Some((added.effect, self.disqualified(&added.judged)?))).collect()
    }

    /// A note on an effect of the speed that may be no more than Coulomb friction, as beside bristles, which take that of the model.
    fn note_on_coulomb_friction(
        &self,
        structure: &Structure,
        values: &[BTreeMap<&'static str, Value>],
    ) -> Option<String> {
        let mut effects = structure.effects.iter().zip(values);
        let (effect, _) = effects.find(|(effect, values)| self.may_be_coulomb_friction(structure, effect, values))?;
        Some(format!(
            "{}: its speed may be too low to show, and it is Coulomb friction then; capture a slower motion",
            effect.kind().name
        ))
    }

    /// Whether something is missing, and whether all of it has a name.
    pub(crate) fn verdict(&self, found: &Found) -> Verdict {
        let (first, last) = (&found.base, found.named());
        // If nothing was found, one unexplained capture is enough to say that something is left. If something was found, both
        // must be unexplained, since either may contain something that the other was too short to show.
        let each = [last.heldout_over_floor(), last.train_over_floor()];
        let left = if found.steps.is_empty() { each[0].max(each[1]) } else { each[0].min(each[1]) };
        let unexplained = (last.excess().max(0.0) / first.excess_above_lower_floor(last).max(f64::MIN_POSITIVE)).sqrt();
        let locations = locate(&last.train_residual, &last.structure, self.train);
        // In motion, noise may exceed that of the sensors, but it then depends on no coordinate.
        let shaped = locations.iter().any(|location| location.significant);
        let is_left = unexplained > MOSTLY_EXPLAINED
            && (left > LEFT && (shaped || left > CERTAINLY_LEFT) || last.heldout_over_floor() > MOSTLY_NOISE);
        if is_left || !self.on_bounds(found).is_empty() || found.in_part() && unexplained > UNEXPLAINED {
            Verdict::OutsideLibrary
        } else if found.steps.is_empty() {
            Verdict::None
        } else {
            Verdict::Effects
        }
    }

    pub(crate) fn report(&self, found: &Found, verdict: Verdict, heldout_is_own: bool) -> Diagnosis {
        let (first, last) = (&found.base, found.last());
        let values = self.values(&last.structure);
        let step = |(added, before): (&Added, &Judged)| self.step(added, before, last, &values);
        let steps: Vec<Step> = found.steps.iter().zip(found.models()).map(step).collect();
        let effects = self.strongest_first(&last.structure, &steps);
        let mut partial = found.partial.clone();
        partial.retain(|partial| !effects.contains(&partial.effect));
        let next_experiment =
            steps.iter().zip(&found.steps).find_map(|(step, Added { judged: chosen, rivals, .. })| {
                let tied = rivals.iter().find(|rival| !self.train.is_map && step.ties.contains(&rival.newest()))?;
                experiment::next(
                    [step.effect, tied.newest()],
                    [&chosen.structure, &tied.structure],
                    self.train,
                    self.options.reach_rad,
                )
            });
        let rest = note_on_the_rest(first, last).or_else(|| self.note_on_coulomb_friction(&last.structure, &values));
        let rest = rest.filter(|_| verdict == Verdict::Effects);
        let mut diagnosis = Diagnosis {
            verdict,
            complete: verdict != Verdict::OutsideLibrary && rest.is_none(),
            effects,
            summary: String::new(),
            train_rms_before: first.train_rms_mnm,
            train_rms_after: last.train_rms_mnm,
            heldout_rms_before: first.heldout_rms_mnm,
            heldout_rms_after: last.heldout_rms_mnm,
            noise_floor_rms: last.heldout_floor_mnm,
            forward_angle_rms_rad: self.forward_angle_rms_rad(&first.structure, &last.structure),
            forward_from_command: None,
            heldout_relative_error_percent: [first, last].map(|judged| self.relative_error_percent(judged)),
            steps,
            partial,
            characteristics: found.characteristics.iter().map(|(_, characteristic)| characteristic.clone()).collect(),
            locations: locate(&first.train_residual, &first.structure, self.train),
            where_after: locate(&last.train_residual, &last.structure, self.train),
            next_experiment,
            heldout_is_own,
            captures_are_exchanged: false,
            band_hz: self.train.band.edge_hz,
            notes: Vec::new(),
            model: self.knob(&last.structure),
            refined: self
                .options
                .model
                .as_ref()
                .map_or_else(Default::default, |_| self.values(&first.structure).into_iter().flatten().collect()),
            chain: found.models().map(|judged| judged.structure.model()).collect(),
            rows: rows::of(first, last, [self.train, self.heldout]),
        };
        self.add_hum_above_the_band(&mut diagnosis, last);
        diagnosis.summary = diagnosis.in_one_sentence();
        let known = self.options.calibration.as_ref();
        match commanded::forward(&diagnosis.chain, [self.train, self.heldout], self.options.commanded, known) {
            Ok(forward) => diagnosis.forward_from_command = Some(forward),
            Err(reason) => diagnosis.notes.push(format!("motion is not predicted from the command: {reason}")),
        }
        if heldout_is_own {
            diagnosis.notes.push(
                "no held-out capture was given: stretches of the training capture were held out, which is weaker \
                 evidence than another motion; give one with --heldout"
                    .to_owned(),
            );
        }
        diagnosis.notes.extend(note_on_time_and_speed(self.train));
        let levels = ["coulomb_negative", "coulomb_positive"].map(|name| last.structure.parameter(name));
        if let [Some(negative), Some(positive)] = levels
            && last.structure.position(effects::torque_offset::KIND.name).is_none()
        {
            diagnosis.notes.extend(one_sided_friction([negative, positive]));
        }
        diagnosis.notes.extend(self.on_bounds(found).into_iter().map(|(effect, reason)| {
            format!("{effect}: {reason}: it may be another effect; capture a wider and a faster motion")
        }));
        let (model, scene) = (last.structure.model(), &self.train.scene);
        let effects = model.effects.iter().zip(&values);
        let notes = effects.filter_map(|(effect, values)| shown_in_part::note(effect, &model, values, scene));
        diagnosis.notes.extend(notes);
        diagnosis.notes.extend(rest);
        if verdict == Verdict::OutsideLibrary {
            let strongest = diagnosis.where_after.iter().find(|location| location.significant);
            diagnosis.notes.push(next_step(strongest.map(|location| location.coordinate)).to_owned());
        }
        diagnosis
    }

    /// The knob of a structure: without the gripper, whose inertia the torque sensor bears too.
    fn knob(&self, structure: &Structure) -> Model {
        let gripper_inertia = self.options.calibration.as_ref().map_or(0.0, |known| known.gripper_inertia);
        structure.model().without_cap_inertia(gripper_inertia)
    }

    /// The knob's values with intervals, effect by effect.
    fn values(&self, structure: &Structure) -> Vec<BTreeMap<&'static str, Value>> {
        let mut values = intervals::of(structure, self.train);
        let effects = structure.effects.iter().zip(&mut values);
        effects.for_each(|(effect, values)| shown_in_part::leave_out_intervals(effect, values));
        // The gripper changes inertias and shares of them only.
        for (index, values) in values.iter_mut().enumerate() {
            let kinds = structure.effects[index].kind().parameters.iter().enumerate();
            for (parameter, kind) in kinds.filter(|(_, kind)| ["1", "mNm s²/rad"].contains(&kind.unit)) {
                let of_knob = |value: f64| {
                    let mut moved = structure.clone();
                    moved.effects[index].values_mut()[parameter] = value;
                    self.knob(&moved).effects[index].values()[parameter]
                };
                if let Some(value) = values.get_mut(kind.name) {
                    value.value = of_knob(value.value);
                    value.ci95 = value.ci95.map(|ends| ends.map(of_knob));
                }
            }
        }
        values
    }

    fn relative_error_percent(&self, judged: &Judged) -> f64 {
        let target = self.heldout.target(judged.structure.delay_s());
        100.0 * (square(&judged.heldout_residual) / square(&target)).sqrt()
    }

    fn step(
        &self,
        Added { effect, judged: after, rivals, false_discovery_rate, .. }: &Added,
        before: &Judged,
        last: &Judged,
        values: &[BTreeMap<&'static str, Value>],
    ) -> Step {
        let (effect, false_discovery_rate) = (*effect, *false_discovery_rate);
        let best = rivals.iter().map(|rival| rival.evidence).fold(after.evidence, f64::max);
        let total: f64 = rivals.iter().chain([after]).map(|rival| (rival.evidence - best).exp()).sum();
        let rival = |judged: &Judged| Rival {
            effect: judged.newest(),
            heldout_rms_after: judged.heldout_rms_mnm,
            evidence: judged.evidence - before.evidence,
            probability: (judged.evidence - best).exp() / total,
            disqualified: self.disqualified(judged),
        };
        let tied = |judged: &&Judged| {
            self.disqualified(judged).is_none()
                && (after.evidence - judged.evidence < TIE || after.steadily_better_than(judged) < 2.0)
                && (worthwhile(before, judged, before, self.heldout) || takes_its_part(before, judged))
                && last.structure.position(judged.newest()).is_none()
                && !self.is_nothing(judged)
        };
        let index = last.structure.position(effect);
        let mut ties: Vec<&str> = rivals.iter().filter(tied).map(Judged::newest).collect();
        let shaft = effects::shaft_compliance::KIND.name;
        let may_be_a_shaft = index.is_some_and(|index| self.may_be_a_shaft(&last.structure, index, &values[index]));
        if may_be_a_shaft && !ties.contains(&shaft) {
            ties.push(shaft);
        }
        let detents = unequal::detents(effect, &last.structure, self.train);
        let parameters = index.filter(|_| detents.is_empty());
        Step {
            effect,
            parameters: parameters.map(|index| values[index].clone()).unwrap_or_default(),
            detents,
            train_rms_before: before.train_rms_mnm,
            train_rms_after: after.train_rms_mnm,
            heldout_rms_before: before.heldout_rms_mnm,
            heldout_rms_after: after.heldout_rms_mnm,
            evidence: after.evidence - before.evidence,
            steadiness: after.steadily_better_than(before),
            false_discovery_rate,
            placebo_rms: null_test::rms_mnm(effect, before, &after.structure, self.train, self.heldout),
            ties,
            rivals: rivals.iter().map(rival).collect(),
        }
    }

    /// The effects that were added, in order of the torque that each contributes to the final model.
    fn strongest_first(&self, structure: &Structure, steps: &[Step]) -> Vec<&'static str> {
        let with = structure.model().readings_mnm(&self.train.motions);
        let mut sizes: Vec<(f64, &'static str)> = steps
            .iter()
            .filter_map(|step| {
                let index = structure.position(step.effect)?;
                let less = structure.without(index);
                let without = less.model().readings_mnm(&self.train.motions);
                let delayed = self.train.target(structure.delay_s()).into_iter().zip(self.train.target(less.delay_s()));
                let late: f64 = delayed.map(|(with, without)| (with - without).powi(2)).sum();
                let difference: Vec<f64> = with.iter().zip(&without).map(|(with, without)| with - without).collect();
                let rows = self.train.row_filter.rows(&difference);
                Some((square(&rows) + late, step.effect))
            })
            .collect();
        sizes.sort_by(|a, b| b.0.total_cmp(&a.0));
        sizes.into_iter().map(|(_, effect)| effect).collect()
    }
}
