//! `tune`: turns the parameters of the model that a running replay renders.

use std::fmt::Display;
use std::time::{Duration, Instant};

use anyhow::{Context as _, anyhow, bail};
use clap::Args;
use dynamics::{Composition, CompositionError, Model, ParameterKind, Source, knobs};
use shared_types::services::{self, ModelClient, RigNode};
use shared_types::{MODEL_MAX_BYTES, ModelAnswer, ModelRequest};

use crate::compose::name_and_number;
use crate::outcome::{remark, say};
use crate::supervision::{clear_shared_memory, unsent};

#[derive(Clone, Debug, Args)]
pub struct TuneOptions {
    /// Switch to this model: a model file, or 1 to 5 for the paper's knobs
    #[arg(long, value_name = "1…5|MODEL.toml")]
    pub model: Option<String>,
    /// Parameters to set, by their names in a model file; without these or a model, show the present model
    #[arg(value_name = "NAME=VALUE", value_parser = name_and_number)]
    pub settings: Vec<(String, f64)>,
}

/// How often other `tune` commands may overtake this one before it gives up; each time one of them has succeeded.
const OVERTAKEN: usize = 16;

/// Sends the running replay another model, or tells the present one.
pub fn run(options: &TuneOptions) -> anyhow::Result<()> {
    let link = LoopModels::open()?;
    let mut present = link.present()?;
    if options.model.is_none() && options.settings.is_empty() {
        say(&present.model.name);
        let axis = present.model.axis;
        present.model.parameters().for_each(|(parameter, value)| say(axis.words(&line(parameter, value))));
        return Ok(());
    }
    for _ in 0..OVERTAKEN {
        let mut wanted = match &options.model {
            Some(name) => knobs::named(name).context("nothing was changed")?,
            None => present.model.clone(),
        };
        let axis = wanted.axis;
        apply(&options.settings, &mut wanted).map_err(|error| anyhow!("{}", axis.words(&error.to_string())))?;
        let remarks = match link.send(&wanted, &present)? {
            Ok(remarks) => remarks,
            // It was taken, and the answer lost.
            Err(newest) if newest.model == wanted => Vec::new(),
            Err(newest) => {
                remark("another `tune` changed the model first; the change was applied to its model");
                present = newest;
                continue;
            }
        };
        remarks.iter().for_each(remark);
        changes(&present.model, &wanted).iter().for_each(say);
        return Ok(());
    }
    bail!(
        "other `tune` commands changed the model first {OVERTAKEN} times in a row; nothing was changed, try again later"
    )
}

/// Longest wait for one answer, after which the request is sent again. Checking a model takes a tenth of a second of a core that the
/// loop's publisher may have to share.
const ANSWER: Duration = Duration::from_secs(2);
/// Most times that a request is sent. If it was taken and its answer lost, the next answer returns the requested model itself.
const ATTEMPTS: u32 = 5;
/// Longest wait until the loop can take a model: it takes one in a quarter of a second.
const PATIENCE: Duration = Duration::from_secs(2);
const PAUSE: Duration = Duration::from_millis(10);

struct LoopModels {
    client: ModelClient,
    // Last, since ports go before the node they belong to.
    _node: RigNode,
}

/// The model that a replay renders, or is about to.
struct Present {
    model: Model,
    revision: u64,
}

fn read_present(revision: u64, model_toml: &str) -> anyhow::Result<Present> {
    Ok(Present { model: Model::from_toml(model_toml, "the rendered model")?, revision })
}

impl LoopModels {
    fn open() -> anyhow::Result<Self> {
        let node = services::attach("tune")?;
        Ok(Self { client: services::model_client(&node)?, _node: node })
    }

    fn present(&self) -> anyhow::Result<Present> {
        match self.ask(&ModelRequest::Present)? {
            Some(ModelAnswer::Rendered { revision, model_toml }) => read_present(revision, &model_toml),
            Some(ModelAnswer::Refused { reason }) => bail!(reason),
            Some(other) => bail!("the control loop did not report its model, but {other:?}"),
            None => {
                clear_shared_memory();
                bail!("no replay is running on this rig; start one with `haptic-camera replay MODEL`")
            }
        }
    }

    /// Sends a model that is to take the place of `present`. Gives sentences on where it feels different from the model; where
    /// another model was sent first, that one.
    fn send(&self, model: &Model, present: &Present) -> anyhow::Result<Result<Vec<String>, Present>> {
        let model_toml = model.to_toml();
        anyhow::ensure!(
            model_toml.len() <= MODEL_MAX_BYTES,
            "the model takes {} bytes, but at most {MODEL_MAX_BYTES} can be sent; shorten its description",
            model_toml.len()
        );
        let request = ModelRequest::Replace { revision: present.revision, model_toml };
        let deadline = Instant::now() + PATIENCE;
        loop {
            match self.ask(&request)? {
                Some(ModelAnswer::Taken { remarks }) => return Ok(Ok(remarks)),
                Some(ModelAnswer::Overtaken { revision, model_toml }) => {
                    return read_present(revision, &model_toml).map(Err);
                }
                Some(ModelAnswer::Refused { reason }) => bail!(reason),
                Some(ModelAnswer::Busy) if Instant::now() < deadline => std::thread::sleep(PAUSE),
                Some(ModelAnswer::Busy) => {
                    bail!("the replay has yet to start rendering an earlier model; try again in a moment")
                }
                Some(other) => bail!("the control loop gave an unexpected answer to the model: {other:?}"),
                None => bail!("the replay ended before it could take the model; run `haptic-camera replay` again"),
            }
        }
    }

    /// A request and its answer; `None` when nobody is there to answer.
    fn ask(&self, request: &ModelRequest) -> anyhow::Result<Option<ModelAnswer>> {
        let text = serde_json::to_vec(request).context("the model has no text form")?;
        let mut alone = 0;
        for _ in 0..ATTEMPTS {
            let place = self.client.loan_slice_uninit(text.len()).map_err(unsent)?;
            let pending = place.write_from_slice(&text).send().map_err(unsent)?;
            let deadline = Instant::now() + ANSWER;
            let mut is_connected = pending.number_of_server_connections() > 0;
            while is_connected && Instant::now() < deadline {
                // Asked before the answer is received: an answer comes before its sender lets go.
                is_connected = pending.is_connected();
                if let Ok(Some(answer)) = pending.receive() {
                    let answer = serde_json::from_slice(answer.payload())
                        .context("the control loop's answer cannot be read; use programs of the same build")?;
                    return Ok(Some(answer));
                }
                std::thread::sleep(Duration::from_millis(1));
            }
            // No control loop is there, or the one that was there dropped the request.
            alone += u32::from(!is_connected);
            if alone > 1 {
                return Ok(None);
            }
        }
        bail!("the control loop did not answer within {} s", (ATTEMPTS * ANSWER).as_secs())
    }
}

/// Sets all parameters to their values, or none if one of them cannot be set.
///
/// An effect whose values change no longer says where they come from.
fn apply(settings: &[(String, f64)], model: &mut Model) -> Result<(), CompositionError> {
    let present = Source::new(model.name.clone(), model.clone());
    let mut composition = Composition::default();
    for effect in &present.model.effects {
        composition.take_effect(effect.kind().name, &present)?;
    }
    for (name, value) in settings {
        composition.set(&model.axis.name_within(name).unwrap_or_else(|| name.clone()), *value)?;
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

fn line(parameter: &ParameterKind, value: impl Display) -> String {
    format!("  {:<22} {value}{}", parameter.name, dynamics::spaced_unit(parameter.unit))
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
            let line = line(parameter, format!("{} → {}", value(before), value(after)));
            lines.push(new.axis.words(&line).into_owned());
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

    use super::{apply, changes, line};

    #[test]
    fn a_number_without_a_unit_is_listed_without_one() {
        let scale = &dynamics::effects::torque_table::KIND.parameters[0];
        assert!(line(scale, 0.5).ends_with(" 0.5"));
    }

    #[test]
    fn a_parameter_of_a_pressed_control_is_set_by_the_name_in_its_file_and_listed_in_its_units() {
        let old = knobs::dome().unwrap();
        let mut new = old.clone();
        apply(&[("bottom_travel".to_owned(), 3.0)], &mut new).unwrap();
        let listed = changes(&old, &new).join("\n");
        assert!(listed.starts_with("  bottom_travel ") && listed.ends_with("→ 3 mm"), "{listed}");
    }
}
