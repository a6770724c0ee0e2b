//! One `[[effects]]` table of a model file.

use std::fmt::Write as _;

use super::ModelError;
use crate::{Axis, Effect, EffectKind, Minimum, Part, TableUse, TorqueTable, effects};

const NAME: &str = "effect";
const ORIGIN: &str = "origin";
const TORQUES: &str = "torque_mnm";
const PERIOD: &str = "period_rad";

/// Appends the effect of a model of that axis, with a comment on every parameter.
pub(super) fn write(effect: &Effect, axis: Axis, text: &mut String) {
    let kind = effect.kind();
    let _ = writeln!(text, "\n# {}\n[[effects]]\n{NAME} = \"{}\"", axis.words(kind.description), kind.name);
    if let Some(origin) = effect.origin() {
        let _ = writeln!(text, "{ORIGIN} = {}  # the knob that it was taken from", toml::Value::from(origin));
    }
    for (parameter, value) in effect.parameters() {
        let value = toml::Value::from(value);
        let line = format!(
            "{} = {value}  # {}, {}: {}",
            parameter.name, parameter.symbol, parameter.unit, parameter.description
        );
        let _ = writeln!(text, "{}", axis.words(&line));
    }
    if let (Some(of), Some(table)) = (table_use(effect.kind()), effect.table()) {
        if let Some(period) = table.period_rad() {
            let period = toml::Value::from(period);
            let line = format!("{PERIOD} = {period}  # rad: angle after which the table repeats");
            let _ = writeln!(text, "{}", axis.words(&line));
        }
        for (name, values, meaning) in [
            (of.coordinate_name(), table.points(), "the table's points, rising"),
            (TORQUES, table.points_mnm(), "mNm: torque at each of them"),
        ] {
            let _ = writeln!(
                text,
                "# {}\n{} = {}",
                axis.words(meaning),
                axis.words(name),
                toml::Value::from(values.to_vec())
            );
        }
    }
}

/// Reads the effect.
pub(super) fn parse(entry: &toml::Table, axis: Axis, origin: &str) -> Result<Effect, ModelError> {
    let name = entry.get(NAME).and_then(toml::Value::as_str).ok_or_else(|| ModelError::Malformed {
        origin: origin.to_owned(),
        reason: "an [[effects]] table lacks its effect = \"name\"".to_owned(),
    })?;
    let kind = effects::by_name(name).ok_or_else(|| ModelError::UnknownEffect {
        origin: origin.to_owned(),
        name: name.to_owned(),
        known: names(effects::ALL.iter().map(|kind| kind.name)),
    })?;
    let drawn = table_use(kind);
    let reader = Entry { kind, drawn, entry, axis, origin };
    reader.check_keys()?;
    let mut effect = Effect::new(kind, &[]);
    for (index, (slot, parameter)) in effect.values_mut().iter_mut().zip(kind.parameters).enumerate() {
        let value = match entry.get(parameter.name) {
            // A table is as drawn unless the file says otherwise.
            None if drawn.is_some() => 1.0,
            None if index >= kind.parameters_of_a_line() || parameter.minimum == Minimum::ZeroOrAbsent => 0.0,
            None => return Err(reader.wrong(&format!("lacks '{}'", parameter.name))),
            Some(value) => number(value).ok_or_else(|| reader.wrong(&not_a_number(parameter.name)))?,
        };
        if !parameter.minimum.permits(value) {
            return Err(ModelError::OutOfRange {
                origin: origin.to_owned(),
                parameter: parameter.name,
                value,
                unit: parameter.unit,
                requirement: parameter.minimum.requirement(),
            });
        }
        *slot = value;
    }
    if let Some(of) = drawn {
        effect = effect.with_table(reader.table(of)?);
    }
    match entry.get(ORIGIN) {
        None => Ok(effect),
        Some(toml::Value::String(text)) => Ok(effect.with_origin(text)),
        Some(_) => Err(reader.wrong(&format!("needs text for '{ORIGIN}'"))),
    }
}

fn table_use(kind: &EffectKind) -> Option<TableUse> {
    match kind.part {
        Part::TorqueTable(of) | Part::FrictionTable(of) => Some(of),
        _ => None,
    }
}

struct Entry<'file> {
    kind: &'static EffectKind,
    /// What it makes of a table, if one belongs to it.
    drawn: Option<TableUse>,
    entry: &'file toml::Table,
    axis: Axis,
    origin: &'file str,
}

impl Entry<'_> {
    fn check_keys(&self) -> Result<(), ModelError> {
        let known = |key: &str| {
            [NAME, ORIGIN].contains(&key)
                || self.table_keys().any(|table_key| table_key == key)
                || self.kind.parameters.iter().any(|parameter| parameter.name == key)
        };
        match self.entry.keys().find(|key| !known(key)) {
            Some(key) => Err(self.wrong(&format!("has no parameter '{key}'"))),
            None => Ok(()),
        }
    }

    fn table_keys(&self) -> impl Iterator<Item = &'static str> {
        self.drawn.into_iter().flat_map(|of| [of.coordinate_name(), TORQUES, PERIOD])
    }

    fn table(&self, of: TableUse) -> Result<&'static TorqueTable, ModelError> {
        let period_rad = match self.entry.get(PERIOD) {
            None => None,
            Some(value) => Some(number(value).ok_or_else(|| self.wrong(&not_a_number(PERIOD)))?),
        };
        TorqueTable::kept_for(of, &self.column(of.coordinate_name())?, &self.column(TORQUES)?, period_rad)
            .map_err(|reason| ModelError::Table { origin: self.origin.to_owned(), reason })
    }

    fn column(&self, key: &str) -> Result<Vec<f64>, ModelError> {
        let values = self.entry.get(key).ok_or_else(|| self.wrong(&format!("lacks '{key}'")))?;
        let numbers = values.as_array().and_then(|values| values.iter().map(number).collect());
        numbers.ok_or_else(|| self.wrong(&format!("needs a list of numbers for '{key}'")))
    }

    fn wrong(&self, problem: &str) -> ModelError {
        let known = names(self.kind.parameters.iter().map(|parameter| parameter.name).chain(self.table_keys()));
        ModelError::WrongParameters {
            origin: self.origin.to_owned(),
            effect: self.kind.name,
            problem: self.axis.words(problem).into_owned(),
            known: self.axis.words(&known).into_owned(),
        }
    }
}

fn number(value: &toml::Value) -> Option<f64> {
    match value {
        toml::Value::Float(value) => Some(*value),
        toml::Value::Integer(value) => Some(*value as f64),
        _ => None,
    }
}

fn not_a_number(key: &str) -> String {
    format!("needs a number for '{key}'")
}

fn names<'a>(names: impl Iterator<Item = &'a str>) -> String {
    names.collect::<Vec<_>>().join(", ")
}
