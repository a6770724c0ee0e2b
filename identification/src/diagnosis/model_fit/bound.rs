//! Whether a fitted value stands on the bound of its search.

use dynamics::{Part, RangeEnd};

use crate::diagnosis::capture::Capture;
use crate::diagnosis::model_fit::residuals::residual;
use crate::diagnosis::model_fit::structure::Structure;
use crate::numerics::vector::square;

/// Distance from the bound at which a value on its bound is tried, as a share of the range or, for ratios, of the value.
const NEAR: f64 = 0.05;

/// Name of a parameter of the last effect that tends beyond the bound of its search: its value stands on the bound, and a
/// little inside the bound the fit is clearly worse. An end of the range beyond which the effect stays the same straight
/// line does not count as a bound. `None` if there is no such parameter.
pub(crate) fn on_bound(structure: &Structure, capture: &Capture) -> Option<&'static str> {
    let index = structure.effects.len().checked_sub(1)?;
    let effect = structure.effects[index];
    let scene = capture.scene_of(structure);
    let mut squares = None;
    let at_bound = effect.free_searches(structure.columns[index]).find(|search| {
        let Some((least, largest)) = search.range_in(&scene) else { return false };
        // A coupling's share is bounded by its definition, not by what the capture could show.
        if matches!(effect.kind().part, Part::Coupling(_)) && effect.kind().parameters[search.parameter].unit == "1" {
            return false;
        }
        let value = effect.values()[search.parameter];
        let width = if search.logarithmic { value } else { largest - least };
        let inward = if value <= least + 1e-3 * width && search.straight_end != Some(RangeEnd::Least) {
            NEAR * width
        } else if value >= largest - 1e-3 * width && search.straight_end != Some(RangeEnd::Largest) {
            -NEAR * width
        } else {
            return false;
        };
        let mut moved = structure.clone();
        moved.effects[index].values_mut()[search.parameter] = value + inward;
        let here = *squares.get_or_insert_with(|| square(&residual(structure, capture)));
        // Two log-likelihood units.
        0.5 * capture.weight * (square(&residual(&moved, capture)) / here).ln() > 2.0
    });
    at_bound.map(|search| effect.kind().parameters[search.parameter].name)
}
