//! `tune`: turns the parameters of the model that a running replay renders.

mod changes;
mod exchange;
mod settings;

use anyhow::{Context as _, bail};
use clap::Args;
use dynamics::knobs;

use crate::compose::name_and_number;
use crate::outcome::{Outcome, remark, say};
use exchange::{LoopModels, Sent};

#[derive(Clone, Debug, Args)]
pub struct TuneOptions {
    /// Switch to this model: a model file, or 1 to 5 for the paper's knobs
    #[arg(long, value_name = "1…5|MODEL.toml")]
    pub model: Option<String>,
    /// Parameters to set, by their names in a model file; without these or a model, show the present model
    #[arg(value_name = "NAME=VALUE", value_parser = name_and_number)]
    pub settings: Vec<(String, f64)>,
}

/// Times that another may be faster before this one gives up: each time one of the others is done.
const OVERTAKEN: usize = 16;

/// Sends the running replay another model, or tells the present one.
///
/// # Errors
/// No running replay; a setting that the model does not have or must not have; a model that the rig cannot render.
pub fn run(options: &TuneOptions) -> anyhow::Result<Outcome> {
    let link = LoopModels::open()?;
    let mut present = link.present()?;
    if options.model.is_none() && options.settings.is_empty() {
        say(&present.model.name);
        present.model.parameters().for_each(|(parameter, value)| say(changes::line(parameter, value)));
        return Ok(Outcome::Done);
    }
    for _ in 0..OVERTAKEN {
        let mut wanted = match &options.model {
            Some(name) => knobs::named(name).context("nothing was changed")?,
            None => present.model.clone(),
        };
        settings::apply(&options.settings, &mut wanted)?;
        let remarks = match link.send(&wanted, &present)? {
            Sent::Taken(remarks) => remarks,
            // It was taken, and the answer lost.
            Sent::Overtaken(newest) if newest.model == wanted => Vec::new(),
            Sent::Overtaken(newest) => {
                remark("another `tune` changed the model first; the change was applied to its model");
                present = newest;
                continue;
            }
        };
        remarks.iter().for_each(remark);
        changes::lines(&present.model, &wanted).iter().for_each(say);
        return Ok(Outcome::Done);
    }
    bail!(
        "other `tune` commands changed the model first {OVERTAKEN} times in a row; nothing was changed, try again later"
    )
}
