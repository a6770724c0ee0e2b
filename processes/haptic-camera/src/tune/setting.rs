//! A parameter and the value it is to have.

use std::str::FromStr;

use dynamics::{Minimum, Model, effects};

/// `name=value`, as the operator gives it.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    name: String,
    value: f64,
}

/// Why a setting is none, or cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SettingError {
    /// Not of the form `name=value`.
    #[error("give a parameter's name and a number, as detent_amplitude=8")]
    NotASetting,
    /// No effect has a parameter of that name.
    #[error("the model has no parameter '{name}'; the nearest that it has is '{nearest}'")]
    Unknown {
        /// The name given.
        name: String,
        /// The most similar name of the model.
        nearest: &'static str,
    },
    /// Another effect's parameter, which the model lacks.
    #[error(
        "'{name}' belongs to the effect '{effect}', which the model does not have; add it to a model file and change \
         over with --model"
    )]
    OtherEffect {
        /// The name given.
        name: String,
        /// The effect that has it.
        effect: &'static str,
    },
    /// A value that means nothing.
    #[error("{name} cannot be {value} {unit}: it must be {requirement}")]
    OutOfRange {
        /// The parameter.
        name: &'static str,
        /// The value given.
        value: f64,
        /// The parameter's unit.
        unit: &'static str,
        /// What it must be.
        requirement: &'static str,
    },
}

impl FromStr for Setting {
    type Err = SettingError;

    fn from_str(text: &str) -> Result<Self, SettingError> {
        let (name, value) = text.split_once('=').ok_or(SettingError::NotASetting)?;
        let value = value.trim().parse().map_err(|_| SettingError::NotASetting)?;
        Ok(Self { name: name.trim().to_owned(), value })
    }
}

impl Setting {
    /// Makes the setting in `model`.
    ///
    /// # Errors
    /// [`SettingError`], for a parameter that the model does not have and a value outside its range.
    pub fn apply(&self, model: &mut Model) -> Result<(), SettingError> {
        let place = model.effects.iter_mut().find_map(|effect| {
            let parameters = effect.kind().parameters;
            let index = parameters.iter().position(|parameter| parameter.name == self.name)?;
            Some((&parameters[index], &mut effect.values_mut()[index]))
        });
        let Some((parameter, slot)) = place else { return Err(self.not_there(model)) };
        if !parameter.minimum.permits(self.value) {
            return Err(SettingError::OutOfRange {
                name: parameter.name,
                value: self.value,
                unit: parameter.unit,
                requirement: match parameter.minimum {
                    Minimum::None => "a finite number",
                    Minimum::Zero => "zero or more, and finite",
                    Minimum::AboveZero => "more than zero, and finite",
                },
            });
        }
        *slot = self.value;
        Ok(())
    }

    fn not_there(&self, model: &Model) -> SettingError {
        let name = self.name.clone();
        let owner = effects::ALL.iter().find(|kind| kind.parameters.iter().any(|parameter| parameter.name == name));
        if let Some(kind) = owner {
            return SettingError::OtherEffect { name, effect: kind.name };
        }
        let nearest = model.parameters().map(|(parameter, _)| parameter.name);
        let nearest = nearest.min_by_key(|known| edits(&name, known)).unwrap_or("inertia");
        SettingError::Unknown { name, nearest }
    }
}

/// Letters to insert, leave out or replace to make one word of the other (Levenshtein's distance).
fn edits(one: &str, other: &str) -> usize {
    let other: Vec<char> = other.chars().collect();
    let mut row: Vec<usize> = (0..=other.len()).collect();
    for (index, letter) in one.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = index + 1;
        for (place, wanted) in other.iter().enumerate() {
            let replaced = diagonal + usize::from(letter != *wanted);
            diagonal = row[place + 1];
            row[place + 1] = replaced.min(diagonal + 1).min(row[place] + 1);
        }
    }
    row[other.len()]
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may stop at a failure")]
mod tests {
    use dynamics::knobs;

    use super::{Setting, SettingError, edits};

    fn set(text: &str) -> Result<f64, SettingError> {
        let mut model = knobs::paper_knob(3).unwrap();
        let setting: Setting = text.parse()?;
        setting.apply(&mut model)?;
        Ok(model.parameter(&setting.name).unwrap())
    }

    #[test]
    fn a_parameter_that_the_model_has_is_set() {
        assert_eq!(set("detent_amplitude=8"), Ok(8.0));
        assert_eq!(set(" viscous_positive = -0.5 "), Ok(-0.5));
    }

    #[test]
    fn what_cannot_be_set_is_refused_with_what_would_do() {
        assert_eq!(set("detent_amplitude"), Err(SettingError::NotASetting));
        assert_eq!(set("inertia=heavy"), Err(SettingError::NotASetting));
        assert_eq!(
            set("detent_amplitud=8"),
            Err(SettingError::Unknown { name: "detent_amplitud".to_owned(), nearest: "detent_amplitude" })
        );
        let text = |setting| set(setting).unwrap_err().to_string();
        assert!(text("coulomb_positive=-1").contains("zero or more"), "{}", text("coulomb_positive=-1"));
        assert!(text("detent_period=0").contains("more than zero"));
        assert!(text("inertia=NaN").contains("inertia"));
        assert!(matches!(set("stribeck_velocity_positive=1"), Err(SettingError::OtherEffect { .. } | SettingError::Unknown { .. })));
    }

    #[test]
    fn words_are_as_far_apart_as_letters_must_be_changed() {
        for (one, other, expected) in [("", "abc", 3), ("abc", "abc", 0), ("kitten", "sitting", 3), ("ab", "ba", 2)] {
            assert_eq!(edits(one, other), expected, "{one} {other}");
        }
    }
}
