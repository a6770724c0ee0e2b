//! The values of a structure that a fit can move, and their steps.

use dynamics::{Minimum, Part};

use crate::diagnosis::capture::Capture;
use crate::diagnosis::model_fit::structure::{Searched, Structure};

/// A value that is fitted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FreeValue {
    pub(crate) searched: Searched,
    least: f64,
    largest: f64,
    /// Size of a typical change.
    scale: f64,
    logarithmic: bool,
}

impl FreeValue {
    /// The value after a step in units of its scale, within its range.
    pub(crate) fn moved(&self, now: f64, step: f64) -> f64 {
        let then = if self.logarithmic { now * step.clamp(-1.0, 1.0).exp() } else { now + step * self.scale };
        then.clamp(self.least, self.largest)
    }

    /// The step that takes the value to its lower bound; infinite where it has none.
    pub(crate) fn lowest_step(&self, now: f64) -> f64 {
        if self.logarithmic { f64::NEG_INFINITY } else { (self.least - now) / self.scale }
    }

    /// The value's interval from the half width of its step's; `None` where the step could be anything.
    pub(crate) fn interval(&self, now: f64, half: f64) -> Option<[f64; 2]> {
        if self.logarithmic {
            (half < 20.0).then(|| [now * (-half).exp(), now * half.exp()])
        } else {
            Some([now - half * self.scale, now + half * self.scale])
        }
    }

    /// Whether the value may stand at the end of its range where its effect is a straight line.
    pub(crate) fn has_straight_end(&self, structure: &Structure) -> bool {
        match self.searched {
            Searched::Parameter { effect, parameter, .. } => {
                let mut searches = structure.effects[effect].kind().searches().iter();
                searches.any(|search| search.parameter == parameter && search.straight_end.is_some())
            }
            Searched::Skew => false,
        }
    }
}

/// Everything in the structure that a fit can move.
pub(crate) fn free_values(structure: &Structure, capture: &Capture) -> Vec<FreeValue> {
    let scene = capture.scene_of(structure);
    let mut values = Vec::new();
    for (index, effect) in structure.effects.iter().enumerate() {
        let kind = effect.kind();
        if matches!(kind.part, Part::Stick(_)) {
            continue;
        }
        let searches = kind.searches();
        let used = kind.parameters_in(structure.columns[index]);
        for (parameter, parameter_kind) in kind.parameters.iter().enumerate().take(used) {
            let now = effect.values()[parameter];
            let value = |range: (f64, f64), scale, logarithmic| FreeValue {
                searched: Searched::Parameter { effect: index, parameter, range },
                least: range.0,
                largest: range.1,
                scale,
                logarithmic,
            };
            // Not free: a searched value without a range in this capture, one tied to another value, and an absent one.
            if let Some(search) = searches.iter().find(|search| search.parameter == parameter) {
                if let Some(range) =
                    search.range_in(&scene).filter(|_| search.same_as.is_none() && !effect.is_absent(parameter))
                {
                    values.push(value(range, 0.05 * (range.1 - range.0), search.logarithmic));
                }
                continue;
            }
            let positive = parameter_kind.minimum == Minimum::AboveZero;
            let least = if parameter_kind.minimum == Minimum::None { f64::NEG_INFINITY } else { 0.0 };
            let scale = if parameter_kind.unit == "rad" { 1.0 } else { now.abs().max(0.01 * scene.torque_rms_mnm) };
            values.push(value((least, f64::INFINITY), scale, positive && now > 0.0));
        }
    }
    if structure.has_free_skew(capture) {
        let largest = capture.largest_skew_s();
        values.push(FreeValue {
            searched: Searched::Skew,
            least: -largest,
            largest,
            scale: 0.2 * largest,
            logarithmic: false,
        });
    }
    values
}
