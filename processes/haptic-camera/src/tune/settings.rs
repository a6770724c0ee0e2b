//! Parameters of a model that are to have another value.

use dynamics::{Composition, CompositionError, Model, Source};

/// Gives the parameters their values, all of them or, where one cannot be, none.
///
/// An effect whose values change no longer says where they come from.
///
/// # Errors
/// [`CompositionError`], for a name that the model's effects lack, a value out of range, and a parameter set twice.
pub(super) fn apply(settings: &[(String, f64)], model: &mut Model) -> Result<(), CompositionError> {
    let present = Source::new(model.name.clone(), model.clone());
    let mut composition = Composition::default();
    for effect in &present.model.effects {
        composition.take_effect(effect.kind().name, &present)?;
    }
    for (name, value) in settings {
        composition.set(name, *value)?;
    }
    let changed = composition.model("", "");
    for effect in &mut model.effects {
        if let Some(wanted) = changed.effect(effect.kind().name)
            && wanted.values() != effect.values()
        {
            effect.values_mut().copy_from_slice(wanted.values());
            *effect = effect.without_origin();
        }
    }
    Ok(())
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may stop at a failure")]
mod tests {
    use dynamics::knobs;

    use super::apply;
    use crate::compose::name_and_number;

    fn set(settings: &[&str]) -> Result<dynamics::Model, String> {
        let mut model = knobs::paper_knob(3).unwrap();
        let settings: Vec<_> = settings.iter().map(|text| name_and_number(text)).collect::<Result<_, _>>()?;
        apply(&settings, &mut model).map_err(|error| error.to_string())?;
        Ok(model)
    }

    #[test]
    fn parameters_are_set_and_everything_else_stays() {
        let (before, after) = (set(&[]).unwrap(), set(&["detent_amplitude=8", "viscous_positive=-0.5"]).unwrap());
        assert_eq!(before, knobs::paper_knob(3).unwrap());
        for ((parameter, old), (_, new)) in before.parameters().zip(after.parameters()) {
            let expected = match parameter.name {
                "detent_amplitude" => 8.0,
                "viscous_positive" => -0.5,
                _ => old,
            };
            assert_eq!(new, expected, "{}", parameter.name);
        }
    }

    #[test]
    fn what_cannot_be_set_is_refused_with_what_would_do() {
        for (setting, expected) in [
            ("detent_amplitud=8", "detent_amplitude"),
            ("detent_amplitude", "detent_amplitude=1.5"),
            ("inertia=heavy", "not a number"),
            ("coulomb_positive=-1", "zero or more"),
            ("detent_period=0", "more than zero"),
            ("spring_stiffness=1", "return-spring"),
        ] {
            let error = set(&[setting]).unwrap_err();
            assert!(error.contains(expected), "{setting}: {error}");
        }
    }
}
