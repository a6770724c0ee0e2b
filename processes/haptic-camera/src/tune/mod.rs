//! `tune`: turns the parameters of the model that a running replay renders.

mod exchange;

use anyhow::{Context as _, bail};
use clap::Args;
use dynamics::{Composition, CompositionError, Model, ParameterKind, Source, knobs};

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
pub fn run(options: &TuneOptions) -> anyhow::Result<Outcome> {
    let link = LoopModels::open()?;
    let mut present = link.present()?;
    if options.model.is_none() && options.settings.is_empty() {
        say(&present.model.name);
        present.model.parameters().for_each(|(parameter, value)| say(line(parameter, value)));
        return Ok(Outcome::Done);
    }
    for _ in 0..OVERTAKEN {
        let mut wanted = match &options.model {
            Some(name) => knobs::named(name).context("nothing was changed")?,
            None => present.model.clone(),
        };
        apply(&options.settings, &mut wanted)?;
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
        changes(&present.model, &wanted).iter().for_each(say);
        return Ok(Outcome::Done);
    }
    bail!(
        "other `tune` commands changed the model first {OVERTAKEN} times in a row; nothing was changed, try again later"
    )
}

/// Gives the parameters their values, all of them or, where one cannot be, none.
///
/// An effect whose values change no longer says where they come from.
fn apply(settings: &[(String, f64)], model: &mut Model) -> Result<(), CompositionError> {
    let present = Source::new(model.name.clone(), model.clone());
    let mut composition = Composition::default();
    for effect in &present.model.effects {
        composition.take_effect(effect.kind().name, &present)?;
    }
    for (name, value) in settings {
        composition.set(name, *value)?;
    }
    let changed = composition.model("", "");
    for effect in &mut model.effects {
        if let Some(wanted) = changed.effect(effect.kind().name)
            && wanted.values() != effect.values()
        {
            effect.values_mut().copy_from_slice(wanted.values());
            *effect = effect.without_origin();
        }
    }
    Ok(())
}

fn line(parameter: &ParameterKind, value: f64) -> String {
    format!("  {:<22} {value} {}", parameter.name, parameter.unit)
}

/// Every parameter whose value changes, old to new; a dash where a model does not have it.
fn changes(old: &Model, new: &Model) -> Vec<String> {
    let mut lines = Vec::new();
    if old.name != new.name {
        lines.push(format!("{} → {}", old.name, new.name));
    }
    let gone = old.parameters().filter(|(parameter, _)| new.parameter(parameter.name).is_none());
    for (parameter, _) in new.parameters().chain(gone) {
        let (before, after) = (old.parameter(parameter.name), new.parameter(parameter.name));
        if before != after {
            let value = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), |value| value.to_string());
            lines.push(format!("  {:<22} {} → {} {}", parameter.name, value(before), value(after), parameter.unit));
        }
    }
    if lines.is_empty() {
        lines.push("nothing changes: the model is as it was".to_owned());
    }
    lines
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may stop at a failure")]
mod tests {
    use dynamics::knobs;

    use super::changes;

    #[test]
    fn a_change_is_listed_from_old_to_new_and_what_stays_is_not() {
        let old = knobs::paper_knob(3).unwrap();
        let mut new = old.clone();
        assert_eq!(changes(&old, &new), ["nothing changes: the model is as it was"]);
        new.effects[0].values_mut()[0] = 0.05;
        assert_eq!(changes(&old, &new), ["  inertia                0.035 → 0.05 mNm s²/rad"]);
        let gone = new.effects.pop().unwrap();
        let listed = changes(&old, &new);
        assert!(
            listed[1..].iter().all(|line| line.contains("→ –")) && listed.len() == 1 + gone.values().len(),
            "{listed:?}"
        );
    }
}
