//! The model that a replay renders, as the text next to the plots shows it.

use dynamics::{Model, ModelError, ParameterKind};
use shared_types::ModelChange;

use crate::numbers::three_figures;

/// The model that is felt, and the model before it.
#[derive(Clone, Debug)]
pub struct RenderedModel {
    model: Model,
    before: Option<Model>,
    from_s: f64,
}

impl RenderedModel {
    /// The model of `change`, which gives way to `before`. An error says what is wrong with the model's text.
    pub fn new(change: &ModelChange, before: Option<Self>, rate_hz: f64) -> Result<Self, ModelError> {
        let model = change.model()?;
        Ok(Self { model, before: before.map(|before| before.model), from_s: change.tick as f64 / rate_hz })
    }

    /// Its parameters as a table; changed values stand out, beside the value before.
    pub fn markdown(&self) -> String {
        let (name, from_s) = (&self.model.name, self.from_s);
        let row = |(parameter, value): (&ParameterKind, f64)| {
            let before = self.before.as_ref().and_then(|before| before.parameter(parameter.name));
            let values = match before.filter(|before| before.to_bits() != value.to_bits()) {
                Some(before) => format!("**{}** | {} |", three_figures(value), three_figures(before)),
                None => format!("{} | |", three_figures(value)),
            };
            let unit = match dynamics::printed_unit(parameter.unit) {
                "" => String::new(),
                unit => format!(", {unit}"),
            };
            format!("| {}{unit} | {values}\n", parameter.name.replace('_', " "))
        };
        let rows: String = self.model.parameters().map(row).collect();
        format!("| rendered: {name}, from {from_s:.1} s on | value | before |\n|---|---:|---:|\n{rows}\n")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn change(tick: u64, inertia: f64) -> ModelChange {
        let model_toml = format!("name = \"wheel\"\n[[effects]]\neffect = \"inertia\"\ninertia = {inertia}\n");
        ModelChange { run_id: 1, tick, monotonic_time_ns: 0, model_toml }
    }

    #[test]
    fn what_was_turned_stands_beside_what_it_was() {
        let first = RenderedModel::new(&change(0, 0.05), None, 1e4).unwrap();
        let turned = RenderedModel::new(&change(25_000, 0.07), Some(first), 1e4).unwrap();
        let text = turned.markdown();
        assert!(text.contains("rendered: wheel, from 2.5 s on"), "{text}");
        assert!(text.contains("**0.0700** | 0.0500"), "{text}");
    }
}
