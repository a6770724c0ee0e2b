//! `compose`: one knob's inertia, another's friction, a third one's detents, and any number changed.

mod arguments;
mod destination;
mod table;

use dynamics::{Composition, CompositionError, Model, ModelError, Parts, Role, Source, composition_notes};

pub use self::arguments::{Assignment, Extra};

use crate::command_line::ComposeOptions;
use crate::outcome::{Outcome, remark, say, tell_error};
use crate::outputs::replace;

/// Composes a model and writes it.
///
/// # Errors
/// One sentence on what is wrong with a source or the output. Parts and values that do not fit are wrong usage, reported
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
    let model = composition.model(&name(options), &sources.parts.description());
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
    parts: Parts,
    values: Vec<(String, Source)>,
}

impl Sources {
    fn load(options: &ComposeOptions) -> Result<Self, ModelError> {
        let ComposeOptions { inertia, friction, detents, extra, from, .. } = options;
        let roles = [(Role::Inertia, inertia), (Role::Friction, friction), (Role::Detents, detents)];
        let role =
            |(role, given): (Role, &Option<String>)| Some(Source::named(given.as_ref()?).map(|from| (role, from)));
        let effect = |extra: &Extra| Ok((extra.effect.clone(), Source::named(&extra.source)?));
        let value = |from: &Assignment<String>| Ok((from.name.clone(), Source::named(&from.value)?));
        Ok(Self {
            parts: Parts {
                roles: roles.into_iter().filter_map(role).collect::<Result<_, _>>()?,
                effects: extra.iter().map(effect).collect::<Result<_, ModelError>>()?,
            },
            values: from.iter().map(value).collect::<Result<_, ModelError>>()?,
        })
    }
}

fn composed(sources: &Sources, options: &ComposeOptions) -> Result<Composition, CompositionError> {
    let mut composition = sources.parts.composition()?;
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
