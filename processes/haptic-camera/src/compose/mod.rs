//! `compose`: one knob's inertia, another's friction, a third one's detents, and any number changed.

mod arguments;
mod destination;
mod source;
mod table;

use dynamics::{Composition, CompositionError, Model, Role, Source, composition_notes};

pub use self::arguments::{Assignment, Extra};

use crate::command_line::ComposeOptions;
use crate::outcome::{Outcome, remark, say, tell_error};
use crate::outputs::replace;

/// Composes a model and writes it.
///
/// # Errors
/// One sentence on what is wrong with a source or the output. Parts and values that do not fit are wrong usage, told
/// here.
pub fn run(options: &ComposeOptions) -> anyhow::Result<Outcome> {
    let sources = Sources::load(options)?;
    let replaced = destination::replaced(options)?;
    let composition = match composed(&sources, options) {
        Ok(composition) => composition,
        Err(error) => {
            tell_error(&error.into());
            return Ok(Outcome::WrongUsage);
        }
    };
    let model = composition.model(&name(options), &sources.description());
    replace(&options.out, replaced, &model.to_toml())?;
    say(model.axis.words(&table::parts(&composition, &model).to_string()));
    say(format!(
        "{}: {}; {}",
        options.out.display(),
        effects(&model),
        model.axis.words(&format!("its torque changes by up to {:.4} mNm/rad", model.steepest_stiffness_mnm_rad()))
    ));
    for note in composition_notes(&model) {
        remark(format!("note: {}", model.axis.words(&note.to_string())));
    }
    Ok(Outcome::Done)
}

/// The models that parts and values come from.
struct Sources {
    parts: Vec<(Role, Source)>,
    extras: Vec<(String, Source)>,
    values: Vec<(String, Source)>,
}

impl Sources {
    fn load(options: &ComposeOptions) -> anyhow::Result<Self> {
        let ComposeOptions { inertia, friction, detents, extra, from, .. } = options;
        let parts = [(Role::Inertia, inertia), (Role::Friction, friction), (Role::Detents, detents)];
        let part =
            |(role, given): (Role, &Option<String>)| Some(source::load(given.as_ref()?).map(|from| (role, from)));
        Ok(Self {
            parts: parts.into_iter().filter_map(part).collect::<anyhow::Result<_>>()?,
            extras: extra
                .iter()
                .map(|extra| Ok((extra.effect.clone(), source::load(&extra.source)?)))
                .collect::<anyhow::Result<_>>()?,
            values: from
                .iter()
                .map(|from| Ok((from.name.clone(), source::load(&from.value)?)))
                .collect::<anyhow::Result<_>>()?,
        })
    }

    /// In one line what the model was composed of.
    fn description(&self) -> String {
        let parts = self.parts.iter().map(|(role, source)| format!("{role} of {}", source.label));
        let extras = self.extras.iter().map(|(effect, source)| format!("{effect} of {}", source.label));
        parts.chain(extras).collect::<Vec<_>>().join(", ")
    }
}

fn composed(sources: &Sources, options: &ComposeOptions) -> Result<Composition, CompositionError> {
    let mut composition = Composition::default();
    for (role, source) in &sources.parts {
        composition.take(*role, source)?;
    }
    for (effect, source) in &sources.extras {
        composition.take_effect(effect, source)?;
    }
    for (name, source) in &sources.values {
        composition.take_parameter(name, source)?;
    }
    for Assignment { name, value } in &options.set {
        composition.set(name, *value)?;
    }
    Ok(composition)
}

/// The name asked for, otherwise that of the file.
fn name(options: &ComposeOptions) -> String {
    let of_file = || options.out.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    options.name.clone().unwrap_or_else(of_file)
}

fn effects(model: &Model) -> String {
    match model.effects.len() {
        1 => "1 effect".to_owned(),
        count => format!("{count} effects"),
    }
}
