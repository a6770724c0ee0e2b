//! `compose`: one knob's inertia, another's friction, a third one's detents, and any number changed.

mod arguments;
mod destination;
mod table;

use std::path::PathBuf;

use clap::Args;
use dynamics::{Composition, CompositionError, Model, ModelError, Parts, Role, Source, composition_notes};

pub use self::arguments::{Assignment, Extra};
use crate::outcome::{Outcome, UsageError, remark, say};
use crate::outputs::write;

/// Options of `compose`.
#[derive(Debug, Args)]
#[command(group(clap::ArgGroup::new("parts").args(["inertia", "friction", "detents", "extra"]).required(true).multiple(true)))]
pub struct ComposeOptions {
    /// Take the inertia of this knob: 1 to 5 for the paper's, or a model file
    #[arg(long, value_name = "1…5|FILE.toml")]
    pub inertia: Option<String>,
    /// Take the friction of this knob, with static friction and everything that modulates friction
    #[arg(long, value_name = "1…5|FILE.toml")]
    pub friction: Option<String>,
    /// Take the detents of this knob, or of a table with the header angle_rad,torque_mnm over one period
    #[arg(long, value_name = "1…5|FILE.toml|FILE.csv")]
    pub detents: Option<String>,
    /// Add an effect of another knob, as in 5:backlash or springy.toml:return-spring; may be repeated
    #[arg(long, value_name = "KNOB:EFFECT")]
    pub extra: Vec<Extra>,
    /// Set a parameter, as in detent_amplitude=1.5; may be repeated
    #[arg(long, value_name = "NAME=NUMBER")]
    pub set: Vec<Assignment<f64>>,
    /// Take a parameter's value from another knob, as in detent_amplitude=4; may be repeated
    #[arg(long, value_name = "NAME=KNOB")]
    pub from: Vec<Assignment<String>>,
    /// The model's name [default: that of its file]
    #[arg(long)]
    pub name: Option<String>,
    /// Write the model here; an earlier composed model is replaced
    #[arg(long, value_name = "MODEL.toml")]
    pub out: PathBuf,
    /// Overwrite any existing file
    #[arg(long)]
    pub overwrite: bool,
}

/// Composes a model and writes it.
///
/// # Errors
/// One sentence on what is wrong with a source or the output. Parts and values that do not fit are a [`UsageError`].
pub fn run(options: &ComposeOptions) -> anyhow::Result<Outcome> {
    let sources = Sources::load(options)?;
    let replaced = destination::replaced(options)?;
    let composition = composed(&sources, options).map_err(|error| UsageError(error.into()))?;
    let model = composition.model(&name(options), &sources.parts.description());
    write(&options.out, replaced, &model.to_toml())?;
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
