//! Where parts come from: shipped knobs, model files, drawn tables.

use std::path::Path;

use super::{Composition, CompositionError};
use crate::{Effect, Model, ModelError, Role, TorqueTable, effects, knobs};

/// A model to take parts from.
#[derive(Clone, Debug, PartialEq)]
pub struct Source {
    /// What it is called where the composed model says what comes from it: `knob 3`, or a path.
    pub label: String,
    /// The model.
    pub model: Model,
}

impl Source {
    /// A model under a label.
    #[must_use]
    pub fn new(label: impl Into<String>, model: Model) -> Self {
        Self { label: label.into(), model }
    }

    /// The source that an operator names: a shipped knob's number, a model file, or a table of a drawn torque whose name ends in
    /// `.csv`.
    ///
    /// # Errors
    /// [`ModelError`], for a number that no shipped knob has and a file that is no model or no table.
    pub fn named(name: &str) -> Result<Self, ModelError> {
        let path = Path::new(name);
        if path.extension().is_some_and(|ending| ending == "csv") {
            let text = foreign_files::open(path)
                .map_err(|reason| ModelError::UnreadableTable { path: path.to_owned(), reason })?;
            let table = TorqueTable::kept_from_csv(text)
                .map_err(|reason| ModelError::Table { origin: name.to_owned(), reason })?;
            return Ok(Self::drawn(name, table));
        }
        let label = name.parse().map_or_else(|_| name.to_owned(), |number: u32| format!("knob {number}"));
        Ok(Self::new(label, knobs::named(name)?))
    }

    /// A drawn table, as a model of nothing else.
    #[must_use]
    pub fn drawn(label: &str, table: &'static TorqueTable) -> Self {
        let effect = Effect::new(&effects::torque_table::KIND, &[1.0]).with_table(table);
        Self::new(label, Model { name: label.to_owned(), effects: vec![effect], ..Model::default() })
    }
}

/// What a knob is composed of: parts of other knobs, and single effects by their names.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Parts {
    /// Where inertia, friction and detents come from.
    pub roles: Vec<(Role, Source)>,
    /// Further effects.
    pub effects: Vec<(String, Source)>,
}

impl Parts {
    /// In one line what the model is composed of.
    #[must_use]
    pub fn description(&self) -> String {
        let roles = self.roles.iter().map(|(role, source)| format!("{role} of {}", source.label));
        let effects = self.effects.iter().map(|(effect, source)| format!("{effect} of {}", source.label));
        roles.chain(effects).collect::<Vec<_>>().join(", ")
    }

    /// The parts together.
    ///
    /// # Errors
    /// [`CompositionError`], for a source without its part and for an effect that comes from two.
    pub fn composition(&self) -> Result<Composition, CompositionError> {
        let mut composition = Composition::default();
        for (role, source) in &self.roles {
            composition.take(*role, source)?;
        }
        for (effect, source) in &self.effects {
            composition.take_effect(effect, source)?;
        }
        Ok(composition)
    }
}
