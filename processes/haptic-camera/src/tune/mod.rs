//! `tune`: turns the parameters of the model that a running replay renders.

mod changes;
mod exchange;
mod settings;

use anyhow::Context as _;
use dynamics::{Model, knobs};

use crate::command_line::TuneOptions;
use crate::outcome::{Outcome, remark, say};
use exchange::LoopModels;

/// Sends the running replay another model, or tells the present one.
///
/// # Errors
/// No running replay; a setting that the model does not have or must not have; a model that the rig cannot render.
pub fn run(options: &TuneOptions) -> anyhow::Result<Outcome> {
    let link = LoopModels::open()?;
    let present = link.present()?;
    let mut wanted = match &options.model {
        Some(name) => chosen(name)?,
        None => present.clone(),
    };
    settings::apply(&options.settings, &mut wanted)?;
    if options.model.is_none() && options.settings.is_empty() {
        say(&present.name);
        present.parameters().for_each(|(parameter, value)| say(changes::told(parameter, value)));
        return Ok(Outcome::Done);
    }
    for sentence in link.send(&wanted)? {
        remark(sentence);
    }
    changes::lines(&present, &wanted).iter().for_each(say);
    Ok(Outcome::Done)
}

/// The model that the operator named.
fn chosen(name: &str) -> anyhow::Result<Model> {
    knobs::named(name).context("nothing was changed")
}
