//! Every effect of the catalogue that could be added to a structure, from its starts to its best fit.

mod coarse;
pub(crate) mod coupled;
pub(crate) mod separable;

use dynamics::effects::{self, cogging};
use dynamics::{Coordinate, Effect, EffectKind, Part, Role, Scene};

use crate::diagnosis::capture::Capture;
use crate::diagnosis::model_fit::structure::Structure;

/// The effects that could be added to a structure and that a capture could show.
pub(crate) fn candidates(structure: &Structure, capture: &Capture) -> Vec<&'static EffectKind> {
    let scene = &capture.scene;
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

/// Whether an effect is a torque over the angle, which a measured curve already includes.
fn is_curve(kind: &EffectKind) -> bool {
    matches!(kind.role, Role::Detents | Role::Other)
        && matches!(kind.part, Part::Torque(_) | Part::Reading(_))
        && !kind.depends_on.contains(&Coordinate::Time)
}

/// An effect at all combinations of its searched parameters' starts, the law occurring once; `None` if the capture cannot show one of
/// them.
fn starts(kind: &'static EffectKind, scene: &Scene) -> Option<Vec<Effect>> {
    let mut starts = vec![Effect::new(kind, &[])];
    let of_a_line = kind.parameters_of_a_line();
    for search in kind.searches().iter().filter(|search| search.parameter < of_a_line) {
        let values = search.values(scene);
        let at = |mut start: Effect, value: f64| {
            start.values_mut()[search.parameter] = value;
            start
        };
        starts = starts.into_iter().flat_map(|start| values.iter().map(move |value| at(start, *value))).collect();
    }
    if kind.name == cogging::KIND.name {
        starts.retain(|start| !cogging::is_of_the_detents(start.values()[1], scene));
    }
    (!starts.is_empty()).then_some(starts)
}
