//! A knob composed of parts of others.
//!
//! ```
//! use dynamics::{Composition, Role, Source, knobs};
//!
//! let (heavy, subtle) = (Source::new("knob 2", knobs::paper_knob(2)?), Source::new("knob 3", knobs::paper_knob(3)?));
//! let mut composition = Composition::default();
//! composition.take(Role::Inertia, &heavy)?;
//! composition.take(Role::Detents, &subtle)?;
//! composition.set("detent_amplitude", 1.5)?;
//! let model = composition.model("stronger", "");
//! assert_eq!((model.parameter("inertia"), model.parameter("detent_amplitude")), (Some(0.28), Some(1.5)));
//! assert_eq!(model.effects[1].origin(), Some("knob 3; detent_amplitude set to 1.5"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod error;
mod nearest;
mod notes;
mod source;

use crate::{Axis, Effect, Model, ParameterKind, Role, effects};

pub use self::error::CompositionError;
pub use self::notes::{CompositionNote, composition_notes};
pub use self::source::{Parts, Source};

/// A model in the making.
///
/// Parts come first, then single values. Every effect is taken from one source; every value is changed once.
#[derive(Clone, Debug, Default)]
pub struct Composition {
    axis: Option<Axis>,
    taken: Vec<Taken>,
}

/// An effect with where it and its values come from.
#[derive(Clone, Debug)]
struct Taken {
    effect: Effect,
    /// Label of its source.
    label: String,
    /// Parameters whose value was changed, each with the origin of its new value.
    changed: Vec<(&'static str, String)>,
}

impl Taken {
    /// The note that goes into the model file.
    fn origin(&self) -> String {
        // A source may be composed itself.
        let source = match self.effect.origin() {
            Some(earlier) => format!("{} ({earlier})", self.label),
            None => self.label.clone(),
        };
        let changes = self.changed.iter().map(|(name, from)| format!("; {name} {from}"));
        changes.fold(source, |text, change| text + &change)
    }
}

impl Composition {
    /// Takes everything in `source` that belongs to a part.
    ///
    /// # Errors
    /// [`CompositionError::NoSuchPart`] when there is nothing, [`CompositionError::Repeated`] when it was taken already.
    pub fn take(&mut self, role: Role, source: &Source) -> Result<(), CompositionError> {
        let of_role: Vec<&Effect> = source.model.effects.iter().filter(|effect| effect.kind().role == role).collect();
        if of_role.is_empty() {
            return Err(CompositionError::no_such_part(role, source));
        }
        of_role.into_iter().try_for_each(|effect| self.add(effect, source))
    }

    /// Takes the effect called `name`, whatever it belongs to.
    ///
    /// # Errors
    /// [`CompositionError::UnknownEffect`], [`CompositionError::NoSuchEffect`] or [`CompositionError::Repeated`].
    pub fn take_effect(&mut self, name: &str, source: &Source) -> Result<(), CompositionError> {
        let kind = effects::by_name(name).ok_or_else(|| CompositionError::unknown_effect(name))?;
        match source.model.effect(kind.name) {
            Some(effect) => self.add(effect, source),
            None => Err(CompositionError::no_such_effect(kind.name, source)),
        }
    }

    fn add(&mut self, effect: &Effect, source: &Source) -> Result<(), CompositionError> {
        let name = effect.kind().name;
        if *self.axis.get_or_insert(source.model.axis) != source.model.axis {
            return Err(CompositionError::TwoAxes { label: source.label.clone() });
        }
        if let Some(before) = self.taken.iter().find(|taken| taken.effect.kind().name == name) {
            let (first, second) = (before.label.clone(), source.label.clone());
            return Err(CompositionError::Repeated { effect: name, first, second });
        }
        self.taken.push(Taken { effect: *effect, label: source.label.clone(), changed: Vec::new() });
        Ok(())
    }

    /// Gives the parameter called `name` another value.
    ///
    /// # Errors
    /// [`CompositionError`] for a name that the composed effects lack, a value out of range, and a second change.
    pub fn set(&mut self, name: &str, value: f64) -> Result<(), CompositionError> {
        self.change(name, value, format!("set to {value}"))
    }

    /// Gives the parameter called `name` the value that it has in `source`.
    ///
    /// # Errors
    /// As [`Composition::set`], and [`CompositionError::SourceLacksParameter`].
    pub fn take_parameter(&mut self, name: &str, source: &Source) -> Result<(), CompositionError> {
        self.position(name)?;
        let value = source.model.parameter(name).ok_or_else(|| CompositionError::source_lacks(name, source))?;
        self.change(name, value, format!("from {}", source.label))
    }

    fn change(&mut self, name: &str, value: f64, from: String) -> Result<(), CompositionError> {
        let (index, slot) = self.position(name)?;
        let taken = &mut self.taken[index];
        let kind = &taken.effect.kind().parameters[slot];
        if !kind.minimum.permits(value) {
            return Err(CompositionError::OutOfRange {
                parameter: kind.name,
                value,
                unit: kind.unit,
                requirement: kind.minimum.requirement(),
            });
        }
        if taken.changed.iter().any(|(changed, _)| *changed == kind.name) {
            return Err(CompositionError::ChangedTwice { parameter: kind.name });
        }
        taken.effect.values_mut()[slot] = value;
        taken.changed.push((kind.name, from));
        Ok(())
    }

    /// Index of the effect that has the parameter, and of the parameter in it.
    fn position(&self, name: &str) -> Result<(usize, usize), CompositionError> {
        let slot_in =
            |taken: &Taken| taken.effect.kind().parameters.iter().position(|parameter| parameter.name == name);
        let found = self.taken.iter().enumerate().find_map(|(index, taken)| Some((index, slot_in(taken)?)));
        found.ok_or_else(|| CompositionError::no_such_parameter(name, self.parameters().map(|(_, kind, _)| kind.name)))
    }

    fn parameters(&self) -> impl Iterator<Item = (&Taken, &'static ParameterKind, f64)> {
        self.taken.iter().flat_map(|taken| taken.effect.parameters().map(move |(kind, value)| (taken, kind, value)))
    }

    /// Label of the source, or what else was done, for the parameter called `name`.
    #[must_use]
    pub fn origin_of(&self, name: &str) -> Option<&str> {
        let (taken, kind, _) = self.parameters().find(|(_, kind, _)| kind.name == name)?;
        let change = taken.changed.iter().find(|(changed, _)| *changed == kind.name);
        Some(change.map_or(taken.label.as_str(), |(_, from)| from.as_str()))
    }

    /// The composed model, its effects in the order of [`effects::ALL`], each with a note on where it comes from.
    #[must_use]
    pub fn model(&self, name: &str, description: &str) -> Model {
        let of_kind = |name: &str| self.taken.iter().find(|taken| taken.effect.kind().name == name);
        let in_order = effects::ALL.iter().filter_map(|kind| of_kind(kind.name));
        Model {
            name: name.to_owned(),
            description: description.to_owned(),
            effects: in_order.map(|taken| taken.effect.with_origin(&taken.origin())).collect(),
            axis: self.axis.unwrap_or_default(),
        }
    }
}
