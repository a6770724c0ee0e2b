//! Where parts come from: shipped knobs, model files, drawn tables.

use std::path::Path;

use anyhow::Context as _;
use dynamics::{Effect, Model, Source, TorqueTable, effects, knobs};

/// The model that is called `given`: a shipped knob's number, a model file, or a table whose name ends in `.csv`.
///
/// # Errors
/// One sentence on what is wrong with it.
pub fn load(given: &str) -> anyhow::Result<Source> {
    if let Ok(number) = given.parse::<u32>() {
        return Ok(Source::new(format!("knob {number}"), knobs::paper_knob(number)?));
    }
    let path = Path::new(given);
    let model =
        if path.extension().is_some_and(|extension| extension == "csv") { drawn(path)? } else { Model::load(path)? };
    Ok(Source::new(given, model))
}

/// A drawn table as a model of nothing else.
fn drawn(path: &Path) -> anyhow::Result<Model> {
    let text = foreign_files::open(path)
        .with_context(|| format!("the table {} cannot be read; check the path", path.display()))?;
    let table = TorqueTable::kept_from_csv(text).with_context(|| path.display().to_string())?;
    let effect = Effect::new(&effects::torque_table::KIND, &[1.0]).with_table(table);
    Ok(Model {
        name: path.display().to_string(),
        description: String::new(),
        effects: vec![effect],
        ..Model::default()
    })
}
