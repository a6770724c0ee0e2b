//! Whether one more effect is worth its name.

use crate::diagnosis::capture::Capture;
use crate::diagnosis::search::judged::Judged;

/// Evidence that an effect must bring beyond the cost of its freedom, nats: odds of e¹⁰.
pub(crate) const EVIDENCE: f64 = 10.0;
/// Mean gain over the stretches, in standard errors, that an effect must exceed.
const STEADY: f64 = 3.0;
/// Share of the mean square above the floor that an effect must take away to be worth a name …
pub(crate) const WORTHWHILE: f64 = 0.28;
/// … and the least amount, in mean squares of the floor: a smaller one could be an error of the floor's own estimate.
const SMALLEST: f64 = 0.06;
/// Probability of chance up to which held-out stretches speak for an effect whose residual is more than noise.
const CHANCE: f64 = 0.05;
/// RMS in floors up to which a residual may be taken for noise.
pub(crate) const MOSTLY_NOISE: f64 = 3.0;
/// RMS in floors up to which a gap is closed.
pub(crate) const CLOSED: f64 = 1.12;
/// RMS in floors above which a residual is clearly louder than noise.
pub(crate) const OPEN: f64 = 1.6;
/// RMS in floors above which something is left, if the residual depends on a coordinate.
pub(crate) const LEFT: f64 = 1.3;
/// Evidence by which rivals must differ not to be a tie, nats: odds of 20 to 1.
pub(crate) const TIE: f64 = 3.0;
/// Share of the gap's amplitude up to which nothing more is looked for.
pub(crate) const UNEXPLAINED: f64 = 0.06;
/// Share up to which nothing more is looked for however quiet the sensors are: filters and numerical derivatives leave as much of a large gap.
const NUMERICAL: f64 = 0.006;
/// Share of the gap's amplitude that a complete explanation may leave, since no model describes a contact exactly; up to this
/// share, no coupling is tried.
pub(crate) const MOSTLY_EXPLAINED: f64 = 0.15;
/// An effect that takes away more than this share of the mean square above the floor leaves nothing for another effect.
const NEARLY_ALL: f64 = 0.9;
/// How far the floor may lie below its estimate, as a share of it.
pub(crate) const LOWER_FLOOR: f64 = 0.8;

/// Whether one more effect explains enough, and with enough certainty, to be added; `first` is the model without further effects.
pub(crate) fn worthwhile(before: &Judged, after: &Judged, first: &Judged, heldout: &Capture) -> bool {
    // The likelihood takes all of the residual for noise; where much of it is not, the held-out stretches must speak for the effect.
    let predicts = after.heldout_over_floor() < MOSTLY_NOISE || after.heldout_p_value(before) < CHANCE;
    predicts && explains_enough_of_both(before, after, first, heldout)
}

/// Whether an effect explains enough of both captures together. One that was added stays by this alone, since those added after it may take
/// much of what it predicts.
pub(crate) fn explains_enough_of_both(before: &Judged, after: &Judged, first: &Judged, heldout: &Capture) -> bool {
    let floor = after.heldout_floor_mnm;
    let [_, closed] = gap_and_closed(before, after);
    let is_steady = after.steadily_better_than(before) > STEADY;
    // An end stop may act in a few stretches only; then the held-out capture, which was never fitted, must speak for it, and the other stretches
    // not against it.
    let unseen = heldout.weight * (before.heldout_rms_mnm / after.heldout_rms_mnm).ln() * after.kept_share(before);
    // A few stretches prove nothing if a simulated body can stick, since anything may decide whether it breaks away at one moment. Nor do
    // they if much of the residual is not noise.
    let may_be_seldom =
        !(before.structure.is_coupled() && before.structure.sticks()) && after.heldout_over_floor() < MOSTLY_NOISE;
    let takes_enough = explains_enough(before, after) && closed > SMALLEST * floor * floor;
    // Near the floor, the floor's uncertainty exceeds the gap, but the gain of a first effect in stretch after stretch does not depend on the floor.
    // A later effect could imitate what the first one leaves, and an effect that is fitted to each capture predicts nothing.
    let is_first = before.structure.effects.iter().all(|effect| first.structure.position(effect.kind().name).is_some());
    let speaks_for_itself = is_first
        && is_near_the_floor(before)
        && !after.newest_is_per_capture()
        && brings_evidence(before, after)
        && closed > 0.0
        && predicts_better(before, after);
    (takes_enough && (is_steady || may_be_seldom && unseen > EVIDENCE) || speaks_for_itself && is_steady)
        && (closed > UNEXPLAINED * UNEXPLAINED * first.excess_above_lower_floor(after)
            || before.most_over_floor() > MOSTLY_NOISE
                && explains_nearly_all(before, after)
                && closed > NUMERICAL * NUMERICAL * first.excess_above_lower_floor(after))
}

/// Whether a model's residual may be noise alone, given how well the floor is known.
pub(crate) fn is_near_the_floor(judged: &Judged) -> bool {
    judged.most_over_floor() < OPEN
}

/// Mean square above the floor that a model leaves, and how much of it one more effect takes away, mNm².
pub(crate) fn gap_and_closed(before: &Judged, after: &Judged) -> [f64; 2] {
    let gap = before.excess_above_lower_floor(after);
    [gap, gap - after.excess()]
}

/// Whether one more effect explains as much as an effect worth a name must, though perhaps by chance.
pub(crate) fn explains_enough(before: &Judged, after: &Judged) -> bool {
    closes(WORTHWHILE, before, after) && predicts_better(before, after)
}

fn predicts_better(before: &Judged, after: &Judged) -> bool {
    after.heldout_rms_mnm < before.heldout_rms_mnm
}

fn brings_evidence(before: &Judged, after: &Judged) -> bool {
    after.evidence - before.evidence > EVIDENCE
}

/// Whether one more effect brings evidence and takes away more than a share of the mean square above the floor; below the floor there is none.
fn closes(share: f64, before: &Judged, after: &Judged) -> bool {
    let [gap, closed] = gap_and_closed(before, after);
    brings_evidence(before, after) && gap > 0.0 && closed > share * gap
}

/// Whether one more effect leaves next to nothing for any other, even if it stands on a bound and is not added.
pub(crate) fn explains_nearly_all(before: &Judged, after: &Judged) -> bool {
    closes(NEARLY_ALL, before, after)
}

/// [`explains_nearly_all`] in stretch after stretch of the held-out capture: the effect is then real, even if its values' intervals hold zero.
pub(crate) fn explains_surely(before: &Judged, after: &Judged) -> bool {
    explains_nearly_all(before, after) && after.heldout_p_value(before) < FALSE_DISCOVERIES
}

/// Whether so little of the first model's gap is left that no further effect could be worth a name, even if the floor
/// were lower than estimated. Beside a very large gap, such as a weight's, a small share is still far above the noise.
pub(crate) fn explains_the_gap(judged: &Judged, first: &Judged) -> bool {
    leaves_at_most(NUMERICAL, judged, first)
        || leaves_at_most(UNEXPLAINED, judged, first) && judged.most_over_floor() < MOSTLY_NOISE
}

/// Whether so little of the first model's gap is left that a coupling, which costs most, need not be tried in the same place.
pub(crate) fn explains_most_of_the_gap(judged: &Judged, first: &Judged) -> bool {
    leaves_at_most(MOSTLY_EXPLAINED, judged, first)
}

fn leaves_at_most(share: f64, judged: &Judged, first: &Judged) -> bool {
    let gap = first.excess_above_lower_floor(judged);
    let lower = judged.floors_mnm().map(|floor| LOWER_FLOOR * floor);
    gap > 0.0 && judged.excess_above(lower) < share * share * gap
}

/// Share of the mean square above the floor that an effect must take away to be added where much remains without a name: a
/// real machine has more effects than a catalogue, and a single one seldom makes up most of the gap.
const DISCOVERED: f64 = 0.04;
/// Share of false discoveries that is accepted among the effects added so: far below one in twenty, since neighbouring
/// stretches of a real machine's residual are not independent, and four times in a row something may be added.
pub(crate) const FALSE_DISCOVERIES: f64 = 1e-3;

/// Whether one more effect takes away its part of both captures' gaps.
pub(crate) fn takes_its_part(before: &Judged, after: &Judged) -> bool {
    let [train, heldout] = before.floors_mnm();
    let takes = |before: f64, after: f64, floor: f64| {
        before * before - after * after > DISCOVERED * (before * before - floor * floor)
    };
    brings_evidence(before, after)
        && takes(before.train_rms_mnm, after.train_rms_mnm, train)
        && takes(before.heldout_rms_mnm, after.heldout_rms_mnm, heldout)
}
