//! `compose`: one knob's inertia, another's friction, a third one's detents, and any number changed.

use std::path::PathBuf;

use anyhow::anyhow;
use archive::whole_file::Replace;
use clap::Args;
use comfy_table::Table;
use dynamics::{Composition, Model, ModelError, Parts, Role, Source, composition_notes};

use crate::command_line::outputs::{kind, write};
use crate::outcome::{UsageError, remark, say};
use crate::terminal::table;

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
    #[arg(long, value_name = "KNOB:EFFECT", value_parser = |text: &str| halves(text.rsplit_once(':'), EXTRA))]
    pub extra: Vec<(String, String)>,
    /// Set a parameter, as in detent_amplitude=1.5; may be repeated
    #[arg(long, value_name = "NAME=NUMBER", value_parser = name_and_number)]
    pub set: Vec<(String, f64)>,
    /// Take a parameter's value from another knob, as in detent_amplitude=4; may be repeated
    #[arg(long, value_name = "NAME=KNOB", value_parser = |text: &str| halves(text.split_once('='), FROM))]
    pub from: Vec<(String, String)>,
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

impl ComposeOptions {
    /// The models and tables that parts and values come from; none is lost unless `--overwrite` was given.
    pub fn sources(&self) -> impl Iterator<Item = &String> {
        let Self { inertia, friction, detents, extra, from, .. } = self;
        let parts = [inertia, friction, detents].into_iter().flatten();
        let sources = parts.chain(extra.iter().map(|(source, _)| source)).chain(from.iter().map(|(_, source)| source));
        sources.filter(|_| !self.overwrite)
    }

    /// What the model may replace: an earlier composed model, so that a number can be changed and felt again.
    pub fn replaced(&self) -> Replace {
        match Model::load(&self.out) {
            _ if self.overwrite => Replace::Anything,
            Ok(_) => kind::COMPOSED_MODEL,
            // An archive, too, holds the text of a model.
            Err(_) => Replace::Nothing,
        }
    }
}

const SETTING: &str = "it must be a parameter and a number, as in detent_amplitude=1.5";
const FROM: &str = "it must be a parameter and a shipped knob or model file, as in detent_amplitude=4";
const EXTRA: &str = "it must be a shipped knob or model file and an effect, as in 5:backlash";

pub fn name_and_number(text: &str) -> Result<(String, f64), String> {
    let (name, value) = halves(text.split_once('='), SETTING)?;
    let value = value.parse().map_err(|_| format!("'{value}' is not a number; {SETTING}"))?;
    Ok((name, value))
}

fn halves(halves: Option<(&str, &str)>, example: &'static str) -> Result<(String, String), &'static str> {
    let (one, other) = halves.map(|(one, other)| (one.trim(), other.trim())).unwrap_or_default();
    if one.is_empty() || other.is_empty() { Err(example) } else { Ok((one.to_owned(), other.to_owned())) }
}

/// Composes a model and writes it; parts and values that do not fit are a [`UsageError`].
pub fn run(options: &ComposeOptions) -> anyhow::Result<()> {
    let (parts, values) = sources(options)?;
    let mut composition = parts.composition().map_err(|error| UsageError(error.into()))?;
    let axis = composition.model("", "").axis;
    let within = |name: &String| axis.name_within(name).unwrap_or_else(|| name.clone());
    let taken = values.iter().try_for_each(|(name, source)| composition.take_parameter(&within(name), source));
    taken
        .and_then(|()| options.set.iter().try_for_each(|(name, value)| composition.set(&within(name), *value)))
        .map_err(|error| UsageError(anyhow!("{}", axis.words(&error.to_string()))))?;
    let of_file = || options.out.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let name = options.name.clone().unwrap_or_else(of_file);
    let model = composition.model(&name, &parts.description());
    write(&options.out, options.replaced(), &model.to_toml())?;
    say(model.axis.words(&parts_table(&composition, &model).to_string()));
    let (out, count, steepest) = (options.out.display(), model.effects.len(), model.steepest_stiffness_mnm_rad());
    let effects = if count == 1 { "effect" } else { "effects" };
    let steepest = format!("its torque changes by up to {steepest:.4} mNm/rad");
    say(format!("{out}: {count} {effects}; {}", model.axis.words(&steepest)));
    for note in composition_notes(&model) {
        remark(format!("note: {}", model.axis.words(&note.to_string())));
    }
    Ok(())
}

fn sources(options: &ComposeOptions) -> Result<(Parts, Vec<(String, Source)>), ModelError> {
    let ComposeOptions { inertia, friction, detents, extra, from, .. } = options;
    let roles = [(Role::Inertia, inertia), (Role::Friction, friction), (Role::Detents, detents)];
    let role = |(role, given): (Role, &Option<String>)| Some(Source::named(given.as_ref()?).map(|from| (role, from)));
    let effect = |(source, effect): &(String, String)| Ok((effect.clone(), Source::named(source)?));
    let value = |(name, source): &(String, String)| Ok((name.clone(), Source::named(source)?));
    let parts = Parts {
        roles: roles.into_iter().filter_map(role).collect::<Result<_, _>>()?,
        effects: extra.iter().map(effect).collect::<Result<_, ModelError>>()?,
    };
    Ok((parts, from.iter().map(value).collect::<Result<_, ModelError>>()?))
}

/// Number of parameters of one effect beyond which zeros are left out: they stand for harmonics that are absent.
const MANY: usize = 8;

fn parts_table(composition: &Composition, model: &Model) -> Table {
    let rows = model.effects.iter().flat_map(|effect| {
        let mut name = effect.kind().name;
        let many = effect.values().len() > MANY;
        let shown = effect.parameters().filter(move |(_, value)| !many || *value != 0.0);
        let parameters = shown.map(move |(parameter, value)| {
            let from = composition.origin_of(parameter.name).unwrap_or_default();
            let unit = dynamics::printed_unit(parameter.unit);
            [std::mem::take(&mut name), parameter.name, &value.to_string(), unit, from].map(str::to_owned)
        });
        let points = effect.table().map(|drawn| {
            let points = format!("{} over {} rad", drawn.points().len(), drawn.period_rad().unwrap_or_default());
            ["", "points", &points, "", ""].map(str::to_owned)
        });
        parameters.chain(points)
    });
    table(["effect", "parameter", "value", "unit", "from"], [2], rows)
}
