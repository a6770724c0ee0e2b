//! Whether an effect more is worth its name.

use super::capture::Capture;
use super::judged::Judged;

/// Evidence that an effect must bring beyond the cost of its freedom, nats: odds of e¹⁰.
pub(crate) const EVIDENCE: f64 = 10.0;
/// Standard errors by which stretch after stretch must be explained better.
const STEADY: f64 = 3.0;
/// Share of the mean square above the floor that an effect must take away to be worth a name …
pub(crate) const WORTHWHILE: f64 = 0.28;
/// … and in mean squares of the floor: smaller ones could be what the floor's own estimate is wrong by.
const SMALLEST: f64 = 0.06;
/// Share of the gap's amplitude that may be left by a complete explanation.
pub(crate) const UNEXPLAINED: f64 = 0.15;
/// How far the floor may lie below its estimate, as a share of it.
const LOWER_FLOOR: f64 = 0.8;

/// Whether an effect more explains enough, surely enough.
pub(crate) fn worthwhile(before: &Judged, after: &Judged, first: &Judged, heldout: &Capture) -> bool {
    let floor = after.heldout_floor_mnm;
    let gap = before.excess_beside(after);
    // A coupling that the angle's noise drives raises the floor, and what it left is less than it seems.
    let closed = gap - after.excess_beside(before).min(after.excess());
    // An end stop may be felt in a few stretches only; then what was never fitted must speak for it.
    let unseen = heldout.weight * (before.heldout_rms_mnm / after.heldout_rms_mnm).ln();
    // Whether a simulated body breaks away at one moment may hang on anything: then one stretch proves nothing.
    let may_be_seldom = !(before.structure.is_coupled() && before.structure.sticks());
    after.evidence - before.evidence > EVIDENCE
        && (after.steadily_better_than(before) > STEADY || may_be_seldom && unseen > EVIDENCE)
        && after.heldout_rms_mnm < before.heldout_rms_mnm
        && closed > WORTHWHILE * gap
        && closed > SMALLEST * floor * floor
        && closed > UNEXPLAINED * UNEXPLAINED * first.excess_beside(after)
}

/// Whether so little of the first model's gap is left that no further effect could be worth a name, even if the floor
/// were lower than it is thought to be.
pub(crate) fn explains_the_gap(judged: &Judged, first: &Judged) -> bool {
    let gap = first.excess_beside(judged);
    let lower = judged.floors_mnm().map(|floor| LOWER_FLOOR * floor);
    gap > 0.0 && judged.excess_above(lower) < UNEXPLAINED * UNEXPLAINED * gap
}
