//! Every effect of the catalogue that could be added to a structure, from its starts to its best fit.

mod coarse;
pub(crate) mod coupled;
pub(crate) mod separable;

use dynamics::effects::{self, cogging};
use dynamics::{Coordinate, Effect, EffectKind, Hypothesis, Part, Role, Scene};

use crate::diagnosis::capture::Capture;
use crate::diagnosis::model_fit::structure::Structure;

/// The effects that could be added to a structure, of which a capture could show each.
pub(crate) fn candidates(structure: &Structure, capture: &Capture) -> Vec<&'static EffectKind> {
    let scene = capture.scene();
    let is_coupled = structure.is_coupled();
    let is_measured = structure.position(effects::angle_characteristic::KIND.name).is_some();
    let shows_turns = |least_rad| scene.is_rotary && least_rad <= scene.travel_rad();
    let mut kinds = effects::ALL.to_vec();
    kinds.retain(|kind| {
        kind.hypothesis.is_some_and(|hypothesis| hypothesis.least_turn_rad.is_none_or(shows_turns))
            && structure.position(kind.name).is_none()
            && !(is_coupled && matches!(kind.part, Part::Coupling(_) | Part::Bristles(_)))
            && (!capture.is_map || is_of_angle(kind))
            && !(is_measured && is_curve(kind))
    });
    kinds
}

/// Whether an effect depends on the angle alone, and acts at once.
fn is_of_angle(kind: &EffectKind) -> bool {
    !matches!(kind.part, Part::Coupling(_) | Part::Bristles(_) | Part::ReadingDelay(_))
        && kind.depends_on.iter().all(|coordinate| *coordinate == Coordinate::Angle)
}

/// Whether an effect is a torque over the angle, which a measured curve has already.
fn is_curve(kind: &EffectKind) -> bool {
    matches!(kind.role, Role::Detents | Role::Other)
        && matches!(kind.part, Part::Torque(_) | Part::Reading(_))
        && !kind.depends_on.contains(&Coordinate::Time)
}

/// All combinations of the searched parameters' starts, the law occurring once; `None` if the capture cannot show one of
/// them.
fn grid(kind: &EffectKind, hypothesis: &Hypothesis, scene: &Scene) -> Option<Vec<Vec<f64>>> {
    let mut grid: Vec<Vec<f64>> = vec![Vec::new()];
    let of_a_line = kind.parameters_of_a_line();
    for search in hypothesis.searched.iter().filter(|search| search.parameter < of_a_line) {
        let values = search.values(scene);
        if values.is_empty() {
            return None;
        }
        grid = grid
            .into_iter()
            .flat_map(|point| values.iter().map(move |value| point.iter().copied().chain([*value]).collect()))
            .collect();
    }
    if kind.name == cogging::KIND.name {
        grid.retain(|point| !cogging::is_of_the_detents(point[0], scene));
    }
    Some(grid)
}

fn effect_at(kind: &'static EffectKind, hypothesis: &Hypothesis, point: &[f64]) -> Effect {
    let mut effect = Effect::new(kind, &[]);
    for (search, value) in hypothesis.searched.iter().zip(point) {
        effect.values_mut()[search.parameter] = *value;
    }
    effect
}
