//! Models as TOML files.

mod effect_entry;
mod error;

use std::fmt::Write as _;
use std::path::Path;

use crate::{Axis, Model};

pub use self::error::ModelError;

const AXIS: &str = "axis";

impl Model {
    /// Reads a model from TOML; `origin` names the text in error messages.
    ///
    /// # Errors
    /// [`ModelError`], for text that is not a model, unknown effects or parameters, and values out of range.
    pub fn from_toml(text: &str, origin: &str) -> Result<Self, ModelError> {
        let malformed = |reason: String| ModelError::Malformed { origin: origin.to_owned(), reason };
        let mut table: toml::Table =
            text.parse().map_err(|error: toml::de::Error| malformed(error.to_string().trim().replace('\n', " ")))?;
        let axis = match table.remove(AXIS) {
            None => Axis::default(),
            Some(value) => {
                value.try_into().map_err(|_| malformed(format!("'{AXIS}' must be \"rotary\" or \"linear\"")))?
            }
        };
        let table = axis.table_within(table).map_err(|key| {
            malformed(format!("'{key}' is no name on a linear axis; it would be '{}'", axis.words(&key)))
        })?;
        let text_field = |key: &str| match table.get(key) {
            None => Ok(String::new()),
            Some(toml::Value::String(text)) => Ok(text.clone()),
            Some(_) => Err(malformed(format!("'{key}' must be text"))),
        };
        if let Some(key) = table.keys().find(|key| !["name", "description", "effects"].contains(&key.as_str())) {
            return Err(malformed(format!(
                "'{key}' is not part of a model; it has name, description, axis and [[effects]]"
            )));
        }
        let entries = match table.get("effects") {
            Some(toml::Value::Array(entries)) if !entries.is_empty() => entries,
            _ => return Err(malformed("it has no [[effects]]".to_owned())),
        };
        let mut model =
            Self { name: text_field("name")?, description: text_field("description")?, axis, effects: Vec::new() };
        for entry in entries {
            let entry = entry.as_table().ok_or_else(|| malformed("'effects' must be [[effects]] tables".to_owned()))?;
            let effect = effect_entry::parse(entry, axis, origin)?;
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
        let text = foreign_files::read_text(path)
            .map_err(|reason| ModelError::Unreadable { path: path.to_owned(), reason })?;
        Self::from_toml(&text, &path.display().to_string())
    }

    /// The model as TOML with a comment on every parameter.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let mut text = format!("name = {}\n", toml::Value::from(self.name.as_str()));
        if !self.description.is_empty() {
            let _ = writeln!(text, "description = {}", toml::Value::from(self.description.as_str()));
        }
        if !self.axis.is_rotary() {
            let _ = writeln!(text, "{AXIS} = \"linear\"  # travel in mm, force in N");
        }
        for effect in &self.effects {
            effect_entry::write(effect, self.axis, &mut text);
        }
        text
    }
}
