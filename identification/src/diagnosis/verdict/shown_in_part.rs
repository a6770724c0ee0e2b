//! Effects of which the training capture shows only a beginning or a part: their size there is known, but neither how far they
//! go nor where they turn.

use std::collections::BTreeMap;

use dynamics::effects::{angle_dependent_inertia, friction_drift};
use dynamics::{Effect, Model, Scene};

use crate::diagnosis::findings::Value;

/// Leaves out the intervals of such an effect.
pub(super) fn leave_out_intervals(effect: &Effect, values: &mut BTreeMap<&'static str, Value>) {
    let has_straight_end = effect.kind().searches().iter().any(|search| search.straight_end.is_some());
    let strength = values.get(effect.kind().parameters[0].name).and_then(|value| value.ci95);
    if has_straight_end && strength.is_none_or(|[low, high]| low <= 0.0 && 0.0 <= high) {
        values.values_mut().for_each(|value| value.ci95 = None);
    }
}

/// A note on such an effect of a model, whose intervals are left out.
pub(super) fn note(
    effect: &Effect,
    model: &Model,
    values: &BTreeMap<&'static str, Value>,
    scene: &Scene,
) -> Option<String> {
    let kind = effect.kind();
    if values.get(kind.parameters[0].name)?.ci95.is_some() {
        return None;
    }
    let shown = match effect.values() {
        [excess, time_s] if kind.name == friction_drift::KIND.name => format!(
            "its beginning, a straight line of {:+.2} % of the friction a second; capture for longer to see where it settles",
            -100.0 * excess / ((1.0 + excess) * time_s)
        ),
        _ if kind.name == angle_dependent_inertia::KIND.name => {
            let middle_rad = 0.5 * (scene.lowest_rad + scene.highest_rad);
            let inertias =
                [scene.lowest_rad, middle_rad, scene.highest_rad].map(|angle_rad| model.inertia_at(angle_rad));
            let [least, largest] = [f64::min, f64::max].map(|of| inertias.into_iter().fold(inertias[0], of));
            format!(
                "a part of its period, over which the inertia varies by {:.0} %; turn the knob farther to see where it turns back",
                100.0 * (largest / least - 1.0)
            )
        }
        _ => return None,
    };
    Some(format!("{}: the training capture shows only {shown}", kind.name))
}
