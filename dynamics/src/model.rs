//! A model: a named list of effects, kept as TOML.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use crate::{Direction, Effect, Motion, ParameterKind, Part, StickLimits, effects};

/// A knob as numbers: the list of its effects.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// What the knob is called.
    pub name: String,
    /// What it is like, or where the numbers come from; may be empty.
    pub description: String,
    /// The effects that act together.
    pub effects: Vec<Effect>,
}

/// Why a model could not be had from a file.
#[derive(Debug, thiserror::Error)]
pub enum ModelError {
    /// The file cannot be read.
    #[error("the model file {} cannot be read ({reason}); check the path", path.display())]
    Unreadable {
        /// Path as given.
        path: PathBuf,
        /// The system's word for it.
        reason: std::io::Error,
    },
    /// The text is not TOML, or not of a model's form.
    #[error("{origin} is not a model file: {reason}")]
    Malformed {
        /// File or source of the text.
        origin: String,
        /// What the parser says, with the line.
        reason: String,
    },
    /// An effect that this version does not know.
    #[error("{origin} names the effect '{name}', which is unknown; known effects are {known}")]
    UnknownEffect {
        /// File or source of the text.
        origin: String,
        /// The name found.
        name: String,
        /// The names that would do.
        known: String,
    },
    /// A parameter that the effect does not have, or lacks.
    #[error("{origin}: the effect '{effect}' {problem}; its parameters are {known}")]
    WrongParameters {
        /// File or source of the text.
        origin: String,
        /// The effect.
        effect: &'static str,
        /// What is wrong.
        problem: String,
        /// The names that would do.
        known: String,
    },
    /// A value outside its range.
    #[error("{origin}: {parameter} is {value} {unit}, but it must be {requirement}")]
    OutOfRange {
        /// File or source of the text.
        origin: String,
        /// The parameter.
        parameter: &'static str,
        /// The value found.
        value: f64,
        /// The parameter's unit.
        unit: &'static str,
        /// What it must be.
        requirement: &'static str,
    },
    /// The same effect twice.
    #[error("{origin} lists the effect '{effect}' twice; keep one of them")]
    Repeated {
        /// File or source of the text.
        origin: String,
        /// The effect.
        effect: &'static str,
    },
    /// A number of a knob that is not among the shipped ones.
    #[error("there is no shipped knob {number}; choose 1 to 5 or give a model file")]
    UnknownKnob {
        /// The number asked for.
        number: u32,
    },
}

impl Model {
    /// Reads a model from TOML; `origin` names the text in error messages.
    ///
    /// # Errors
    /// [`ModelError`], for text that is not a model, unknown effects or parameters, and values out of range.
    pub fn from_toml(text: &str, origin: &str) -> Result<Self, ModelError> {
        let malformed = |reason: String| ModelError::Malformed { origin: origin.to_owned(), reason };
        let table: toml::Table =
            text.parse().map_err(|error: toml::de::Error| malformed(error.to_string().trim().replace('\n', " ")))?;
        let text_field = |key: &str| match table.get(key) {
            None => Ok(String::new()),
            Some(toml::Value::String(text)) => Ok(text.clone()),
            Some(_) => Err(malformed(format!("'{key}' must be text"))),
        };
        if let Some(key) = table.keys().find(|key| !["name", "description", "effects"].contains(&key.as_str())) {
            return Err(malformed(format!("'{key}' is not part of a model; it has name, description and [[effects]]")));
        }
        let entries = match table.get("effects") {
            Some(toml::Value::Array(entries)) if !entries.is_empty() => entries,
            _ => return Err(malformed("it has no [[effects]]".to_owned())),
        };
        let mut model =
            Self { name: text_field("name")?, description: text_field("description")?, effects: Vec::new() };
        for entry in entries {
            let entry = entry.as_table().ok_or_else(|| malformed("'effects' must be [[effects]] tables".to_owned()))?;
            let effect = parse_effect(entry, origin)?;
            if model.effect(effect.kind().name).is_some() {
                return Err(ModelError::Repeated { origin: origin.to_owned(), effect: effect.kind().name });
            }
            model.effects.push(effect);
        }
        Ok(model)
    }

    /// Reads a model file.
    ///
    /// # Errors
    /// [`ModelError`], as [`Model::from_toml`] and for a file that cannot be read.
    pub fn load(path: &Path) -> Result<Self, ModelError> {
        let text =
            std::fs::read_to_string(path).map_err(|reason| ModelError::Unreadable { path: path.to_owned(), reason })?;
        Self::from_toml(&text, &path.display().to_string())
    }

    /// The model as TOML with a comment on every parameter.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let mut text = format!("name = {}\n", toml::Value::from(self.name.as_str()));
        if !self.description.is_empty() {
            let _ = writeln!(text, "description = {}", toml::Value::from(self.description.as_str()));
        }
        for effect in &self.effects {
            let _ =
                writeln!(text, "\n# {}\n[[effects]]\neffect = \"{}\"", effect.kind().description, effect.kind().name);
            for (parameter, value) in effect.parameters() {
                let value = toml::Value::from(value);
                let _ = writeln!(
                    text,
                    "{} = {value}  # {}, {}: {}",
                    parameter.name, parameter.symbol, parameter.unit, parameter.description
                );
            }
        }
        text
    }

    /// The effect called `name`, if the model has it.
    #[must_use]
    pub fn effect(&self, name: &str) -> Option<&Effect> {
        self.effects.iter().find(|effect| effect.kind().name == name)
    }

    /// The value of the parameter called `name`, if the model has it.
    #[must_use]
    pub fn parameter(&self, name: &str) -> Option<f64> {
        self.parameters().find(|(parameter, _)| parameter.name == name).map(|(_, value)| value)
    }

    /// Every parameter with its value, effect by effect.
    pub fn parameters(&self) -> impl Iterator<Item = (&'static ParameterKind, f64)> + '_ {
        self.effects.iter().flat_map(Effect::parameters)
    }

    /// Torque that the knob takes while it moves as given, mNm.
    ///
    /// At zero velocity friction is left out: there it is whatever holds the knob, up to [`Model::stick_limits`].
    /// Effects with a memory, an inner body or bristles, are taken as if there were none; [`Model::readings_mnm`] has
    /// them.
    #[must_use]
    pub fn torque_mnm(&self, motion: &Motion) -> f64 {
        let friction = if motion.velocity_rad_s == 0.0 {
            0.0
        } else {
            self.friction_mnm(motion, Direction::of(motion.velocity_rad_s))
        };
        self.inertia() * motion.acceleration_rad_s2 + self.free_torque_mnm(motion) + friction
    }

    /// Moment of inertia, mNm·s²/rad.
    #[must_use]
    pub fn inertia(&self) -> f64 {
        self.effects
            .iter()
            .map(|effect| if let Part::Inertia(inertia) = effect.kind().part { inertia(effect.values()) } else { 0.0 })
            .sum()
    }

    /// Torque that depends on neither acceleration nor the direction of sliding (detents), mNm.
    #[must_use]
    pub fn free_torque_mnm(&self, motion: &Motion) -> f64 {
        self.effects
            .iter()
            .map(
                |effect| {
                    if let Part::Torque(torque) = effect.kind().part { torque(effect.values(), motion) } else { 0.0 }
                },
            )
            .sum()
    }

    /// Torque of friction while sliding in `direction`, mNm.
    #[must_use]
    pub fn friction_mnm(&self, motion: &Motion, direction: Direction) -> f64 {
        let sliding_at = |motion: &Motion| -> f64 {
            let each = self.effects.iter().map(|effect| match effect.kind().part {
                Part::Friction(torque) => torque(effect.values(), motion, direction),
                _ => 0.0,
            });
            each.sum()
        };
        let (mut factor, mut coulomb_factor) = (0.0, 0.0);
        for effect in &self.effects {
            match effect.kind().part {
                Part::FrictionFactor(change) => factor += change(effect.values(), motion),
                Part::CoulombFactor(change) => coulomb_factor += change(effect.values(), motion),
                _ => {}
            }
        }
        let friction_mnm = (1.0 + factor) * sliding_at(motion);
        if coulomb_factor == 0.0 {
            return friction_mnm;
        }
        friction_mnm + coulomb_factor * sliding_at(&Motion { velocity_rad_s: 0.0, ..*motion })
    }

    /// What a knob at rest bears: Karnopp's limits, but at least the friction with which it begins to slide.
    ///
    /// If it bore less, it would break away into a friction that stops it at once.
    #[must_use]
    pub fn stick_limits(&self, motion: &Motion) -> StickLimits {
        let still = Motion { velocity_rad_s: 0.0, ..*motion };
        self.stick_limits_above([Direction::Negative, Direction::Positive].map(|to| self.friction_mnm(&still, to)))
    }

    /// The same where the friction of a knob that begins to slide negatively and positively is known, mNm.
    pub(crate) fn stick_limits_above(&self, sliding_mnm: [f64; 2]) -> StickLimits {
        let karnopp = self.effects.iter().find_map(|effect| match effect.kind().part {
            Part::Stick(limits) => Some(limits(effect.values())),
            _ => None,
        });
        let karnopp = karnopp.unwrap_or_default();
        StickLimits {
            negative_mnm: karnopp.negative_mnm.max(-sliding_mnm[0]),
            positive_mnm: karnopp.positive_mnm.max(sliding_mnm[1]),
            velocity_rad_s: karnopp.velocity_rad_s,
        }
    }
}

fn parse_effect(entry: &toml::Table, origin: &str) -> Result<Effect, ModelError> {
    let name = entry.get("effect").and_then(toml::Value::as_str).ok_or_else(|| ModelError::Malformed {
        origin: origin.to_owned(),
        reason: "an [[effects]] table lacks its effect = \"name\"".to_owned(),
    })?;
    let kind = effects::by_name(name).ok_or_else(|| ModelError::UnknownEffect {
        origin: origin.to_owned(),
        name: name.to_owned(),
        known: names(effects::ALL.iter().map(|kind| kind.name)),
    })?;
    let wrong = |problem: String| ModelError::WrongParameters {
        origin: origin.to_owned(),
        effect: kind.name,
        problem,
        known: names(kind.parameters.iter().map(|parameter| parameter.name)),
    };
    for key in entry.keys().filter(|key| *key != "effect") {
        if !kind.parameters.iter().any(|parameter| parameter.name == key) {
            return Err(wrong(format!("has no parameter '{key}'")));
        }
    }
    let mut effect = Effect::new(kind, &[]);
    for (slot, parameter) in effect.values_mut().iter_mut().zip(kind.parameters) {
        let value = match entry.get(parameter.name) {
            Some(toml::Value::Float(value)) => *value,
            #[allow(clippy::cast_precision_loss, reason = "a whole number in a model file is small")]
            Some(toml::Value::Integer(value)) => *value as f64,
            Some(_) => return Err(wrong(format!("needs a number for '{}'", parameter.name))),
            None => return Err(wrong(format!("lacks '{}'", parameter.name))),
        };
        if !parameter.minimum.permits(value) {
            return Err(ModelError::OutOfRange {
                origin: origin.to_owned(),
                parameter: parameter.name,
                value,
                unit: parameter.unit,
                requirement: match parameter.minimum {
                    crate::Minimum::None => "a finite number",
                    crate::Minimum::Zero => "zero or more, and finite",
                    crate::Minimum::AboveZero => "more than zero, and finite",
                },
            });
        }
        *slot = value;
    }
    Ok(effect)
}

fn names<'a>(names: impl Iterator<Item = &'a str>) -> String {
    names.collect::<Vec<_>>().join(", ")
}
