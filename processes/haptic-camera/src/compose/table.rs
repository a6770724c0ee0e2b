//! The composed model's parameters with where each comes from.

use comfy_table::Table;
use dynamics::{Composition, Effect, Model};

use crate::terminal::table;

/// Parameters of one effect beyond which zeros are left out: harmonics that are not there.
const MANY: usize = 8;

/// Effect by effect, every parameter with its value and where that comes from.
pub fn parts(composition: &Composition, model: &Model) -> Table {
    let mut table = table(["effect", "parameter", "value", "unit", "from"], [2]);
    for effect in &model.effects {
        let mut name = effect.kind().name;
        for (parameter, value) in shown(effect) {
            let from = composition.origin_of(parameter.name).unwrap_or_default();
            table.add_row([name, parameter.name, &value.to_string(), parameter.unit, from]);
            name = "";
        }
        if let Some(drawn) = effect.table() {
            let points = format!("{} over {} rad", drawn.points().len(), drawn.period_rad().unwrap_or_default());
            table.add_row(["", "points", &points, "", ""]);
        }
    }
    table
}

fn shown(effect: &Effect) -> impl Iterator<Item = (&'static dynamics::ParameterKind, f64)> + '_ {
    let many = effect.values().len() > MANY;
    effect.parameters().filter(move |(_, value)| !many || *value != 0.0)
}
