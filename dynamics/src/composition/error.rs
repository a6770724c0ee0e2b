//! Why parts do not make a model.

use super::Source;
use super::nearest::nearest;
use crate::{Role, effects, knobs};

/// Parts or values that do not fit into a composed model.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CompositionError {
    /// Parts of what turns and of what is pressed or slid.
    #[error(
        "{label} does not move along the axis of the parts before it; take all from what turns, or all from what is pressed or slid"
    )]
    TwoAxes {
        /// The source.
        label: String,
    },
    /// A source without the part asked for.
    #[error("{label} has no {role}; it has {has}{}", shipped(shipped_knobs))]
    NoSuchPart {
        /// The source.
        label: String,
        /// The part.
        role: Role,
        /// The effects that it has.
        has: String,
        /// Numbers of the shipped knobs that have the part.
        shipped_knobs: Vec<u32>,
    },
    /// A source without the effect asked for.
    #[error("{label} has no {effect}; it has {has}")]
    NoSuchEffect {
        /// The source.
        label: String,
        /// The effect.
        effect: &'static str,
        /// The effects that it has.
        has: String,
    },
    /// An effect that this version does not know.
    #[error("there is no effect '{name}'; the nearest is {nearest}")]
    UnknownEffect {
        /// The name asked for.
        name: String,
        /// A known name.
        nearest: &'static str,
    },
    /// An effect from two sources.
    #[error("{effect} would come from {first} and again from {second}; take it from one of them")]
    Repeated {
        /// The effect.
        effect: &'static str,
        /// The source it was taken from.
        first: String,
        /// The other.
        second: String,
    },
    /// A parameter whose effect was not taken.
    #[error("{parameter} belongs to {effect}, which is not among the parts; take that from a model that has it")]
    EffectNotTaken {
        /// The parameter.
        parameter: &'static str,
        /// Its effect.
        effect: &'static str,
    },
    /// A parameter that no effect has.
    #[error("there is no parameter '{name}' in the composed model; the nearest is {nearest}")]
    UnknownParameter {
        /// The name asked for.
        name: String,
        /// A name that it has.
        nearest: &'static str,
    },
    /// A parameter that the source of its value lacks.
    #[error("{label} has no {parameter}; it has {has}")]
    SourceLacksParameter {
        /// The source.
        label: String,
        /// The parameter.
        parameter: String,
        /// The parameters that it has.
        has: String,
    },
    /// A value outside its range.
    #[error("{parameter} would be {value}{}, but it must be {requirement}", crate::spaced_unit(unit))]
    OutOfRange {
        /// The parameter.
        parameter: &'static str,
        /// The value asked for.
        value: f64,
        /// The parameter's unit.
        unit: &'static str,
        /// What it must be.
        requirement: &'static str,
    },
    /// A parameter that is given two values.
    #[error("{parameter} is given two values; keep one of them")]
    ChangedTwice {
        /// The parameter.
        parameter: &'static str,
    },
}

impl CompositionError {
    pub(super) fn no_such_part(role: Role, source: &Source) -> Self {
        let has_it = |number: &u32| {
            knobs::paper_knob(*number).is_ok_and(|knob| knob.effects.iter().any(|effect| effect.kind().role == role))
        };
        let shipped_knobs = (1..=5).filter(has_it).collect();
        Self::NoSuchPart { label: source.label.clone(), role, has: effects_of(source), shipped_knobs }
    }

    pub(super) fn no_such_effect(effect: &'static str, source: &Source) -> Self {
        Self::NoSuchEffect { label: source.label.clone(), effect, has: effects_of(source) }
    }

    pub(super) fn unknown_effect(name: &str) -> Self {
        let known = effects::ALL.iter().map(|kind| kind.name);
        Self::UnknownEffect { name: name.to_owned(), nearest: nearest(name, known).unwrap_or_default() }
    }

    /// `present` are the parameters of the composed model.
    pub(super) fn no_such_parameter(name: &str, present: impl Iterator<Item = &'static str>) -> Self {
        for kind in effects::ALL {
            if let Some(parameter) = kind.parameters.iter().find(|parameter| parameter.name == name) {
                return Self::EffectNotTaken { parameter: parameter.name, effect: kind.name };
            }
        }
        Self::UnknownParameter { name: name.to_owned(), nearest: nearest(name, present).unwrap_or("none") }
    }

    pub(super) fn source_lacks(name: &str, source: &Source) -> Self {
        let has = source.model.parameters().map(|(kind, _)| kind.name).collect::<Vec<_>>().join(", ");
        Self::SourceLacksParameter { label: source.label.clone(), parameter: name.to_owned(), has }
    }
}

fn effects_of(source: &Source) -> String {
    source.model.effects.iter().map(|effect| effect.kind().name).collect::<Vec<_>>().join(", ")
}

/// The end of a sentence: which shipped knobs would do.
fn shipped(numbers: &[u32]) -> String {
    match numbers {
        [] => String::new(),
        [one] => format!(". Of the shipped knobs {one} has"),
        [first @ .., last] => {
            let first = first.iter().map(u32::to_string).collect::<Vec<_>>().join(", ");
            format!(". Of the shipped knobs {first} and {last} have")
        }
    }
}
