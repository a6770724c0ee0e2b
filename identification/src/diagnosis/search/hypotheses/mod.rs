//! Every effect of the catalogue that could be added to a structure, from its starts to its best fit.

mod coarse;
pub(crate) mod coupled;
pub(crate) mod separable;

use dynamics::effects::{self, cogging};
use dynamics::{Effect, EffectKind, Hypothesis, Part, Scene};

use crate::diagnosis::model_fit::structure::Structure;

/// The effects that could be added to a structure.
pub(crate) fn candidates(structure: &Structure) -> Vec<&'static EffectKind> {
    let coupled = structure.is_coupled();
    effects::ALL
        .into_iter()
        .filter(|kind| {
            kind.hypothesis.is_some()
                && structure.position(kind.name).is_none()
                && !(coupled && matches!(kind.part, Part::Coupling(_) | Part::Bristles(_)))
        })
        .collect()
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
